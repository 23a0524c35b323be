"""Grid: even on each scale, no end of a period twice, rounds that close in on the best point."""

from __future__ import annotations

import numpy as np
import pytest
from driving import drive
from hypothesis import given
from hypothesis import strategies as st

from pitchopt.errors import InputError
from pitchopt.tuning import Parameter, Space
from pitchopt.tuning.grid import Grid

SPACE = Space(
    [
        Parameter(name="a", low=-1.0, high=1.0),
        Parameter(name="l", low=1e-2, high=1e2, scale="log"),
        Parameter(name="p", low=0.0, high=360.0, periodic=True),
    ]
)


def test_points_are_even_on_each_scale():
    asked = drive(Grid(SPACE, points=(3, 5, 4)), lambda _: 1.0, 1000)
    assert len(asked) == 60
    points = np.array([candidate.x for candidate in asked])
    assert np.unique(points[:, 0]) == pytest.approx([-1.0, 0.0, 1.0])
    assert np.unique(points[:, 1]) == pytest.approx([1e-2, 1e-1, 1.0, 1e1, 1e2])
    assert np.unique(points[:, 2]) == pytest.approx([0.0, 90.0, 180.0, 270.0])
    assert len(np.unique(points, axis=0)) == 60


def test_a_single_point_is_the_middle_and_stays_there():
    asked = drive(Grid(SPACE, points=(1, 3, 1), rounds=2), lambda x: abs(x[1] - 3.0), 1000)
    points = np.array([candidate.x for candidate in asked])
    assert np.all(points[:, [0, 2]] == [0.0, 180.0])
    assert len(asked) > 5


@pytest.mark.parametrize("points", [2, 3, 4, 5, 6])
def test_each_round_shrinks_the_spacing_by_two_over_one_more_than_the_points(points):
    # the distance to the minimum is at most a spacing in every round
    space = Space([Parameter(name="a", low=0.0, high=1.0)])
    minimum = 1.0 / np.e
    spacing = 1.0 / (points - 1)
    for rounds in range(5):
        tuner = Grid(space, points=points, rounds=rounds)
        drive(tuner, lambda x: abs(float(x[0]) - minimum), 1000)
        assert abs(tuner.best().x[0] - minimum) <= spacing
        spacing *= 2.0 / (points + 1)


def test_rounds_close_in_across_the_ends_of_a_period():
    space = Space([Parameter(name="p", low=0.0, high=360.0, periodic=True)])
    tuner = Grid(space, points=4, rounds=6)
    drive(tuner, lambda x: -float(np.cos(np.radians(x[0] + 7.0))), 1000)
    assert tuner.best().x[0] == pytest.approx(353.0, abs=0.4)


@given(
    points=st.tuples(st.integers(1, 4), st.integers(1, 4), st.integers(1, 4)),
    rounds=st.integers(0, 3),
    centre=st.tuples(st.floats(-1, 1), st.floats(-2, 2), st.floats(0, 360)),
)
def test_no_point_comes_twice_and_all_lie_inside(points, rounds, centre):
    tuner = Grid(SPACE, points=points, rounds=rounds)
    a, l, p = centre  # noqa: E741

    def function(x):
        return float((x[0] - a) ** 2 + (np.log10(x[1]) - l) ** 2 - np.cos(np.radians(x[2] - p)))

    asked = drive(tuner, function, 1000, parallel=2)
    units = SPACE.to_unit([candidate.x for candidate in asked])
    assert np.all((units >= 0.0) & (units <= 1.0))
    assert len(np.unique(np.round(units, 8), axis=0)) == len(asked)
    assert len(asked) <= np.prod(points) * (rounds + 1)
    assert tuner.finished


def test_a_failed_or_forbidden_point_is_not_closed_in_on():
    space = Space([Parameter(name="a", low=0.0, high=1.0)])
    tuner = Grid(space, points=5, rounds=4)
    drive(tuner, lambda x: np.nan if x[0] < 0.6 else float(x[0]), 1000)
    assert tuner.best().x[0] == pytest.approx(0.6, abs=0.02)


def test_it_starts_where_it_is_told():
    tuner = Grid(SPACE, points=2, start=[0.5, 1.0, 10.0])
    first, second, *_ = tuner.ask(3)
    assert first.origin == "start"
    assert np.array_equal(first.x, [0.5, 1.0, 10.0])
    assert second.origin == "grid 0.0"


@pytest.mark.parametrize(
    ("settings", "message"),
    [
        ({"points": 0}, "points"),
        ({"points": [3, 3]}, "2 numbers for 3 parameters"),
        ({"points": "6 x 6"}, "points"),
        ({"points": 100}, "1000000 in all"),
        ({"rounds": -1}, "rounds"),
        ({"start": [5.0, 1.0, 0.0]}, "a = 5"),
    ],
)
def test_bad_settings_are_named(settings, message):
    with pytest.raises(InputError, match=message):
        Grid(SPACE, **settings)


def test_start_on_the_grid_is_asked_for_once():
    space = Space([Parameter(name="a", low=0.0, high=2.0), Parameter(name="b", low=0.0, high=1.0)])
    tuner = Grid(space, points=3, start=[1.0, 0.5])
    points = [tuple(c.x) for c in tuner.ask(20)]
    assert points[0] == (1.0, 0.5)
    assert len(points) == len(set(points)) == 9
