"""SPSA: its gradient, its gains, its bounds."""

from __future__ import annotations

import numpy as np
import pytest
from driving import drive
from hypothesis import given
from hypothesis import strategies as st

from pitchopt.errors import ComputationError, InputError
from pitchopt.tuning import Parameter, Space
from pitchopt.tuning.known_functions import hartmann
from pitchopt.tuning.spsa import Spsa

UNIT = Space([Parameter(name=f"u{i}", low=0.0, high=1.0) for i in range(3)])
SLOPE = np.array([0.3, -1.0, 0.5])


def linear(x):
    return float(SLOPE @ x)


def points_of(tuner, function, count=1000):
    return [candidate.x for candidate in drive(tuner, function, count)]


def test_a_linear_cost_moves_by_the_gains_times_its_gradient():
    # g = (SLOPE . delta) delta: computed here from the pairs that were asked for
    tuner = Spsa(UNIT, iterations=20, perturbation=0.01, step=0.02, calibration=1)
    points = points_of(tuner, linear)
    assert len(points) == 2 * 21 + 2
    pairs = np.array(points[1:-1]).reshape(21, 2, 3)
    centres = [*pairs.mean(axis=1), points[-1]]
    assert centres[0] == pytest.approx(points[0])
    for k, (above, below) in enumerate(pairs):
        width = 0.01 / (k + 1) ** 0.101
        delta = (above - below) / (2.0 * width)
        assert np.abs(delta) == pytest.approx(np.ones(3))
        move = 0.02 / (k + 1 + 2.0) ** 0.602 * (SLOPE @ delta) * delta
        assert centres[k + 1] == pytest.approx(centres[k] - move, abs=1e-12)


@pytest.mark.parametrize("factor", [1e-6, 1.0, 1e6])
def test_the_first_move_is_as_long_as_is_wanted_whatever_the_cost(factor):
    tuner = Spsa(UNIT, iterations=5, calibration=1, move=0.07)
    points = points_of(tuner, lambda x: factor * linear(x))
    moved = np.mean(points[3:5], axis=0) - points[0]
    assert np.abs(moved) == pytest.approx(np.full(3, 0.07))


def test_no_move_is_longer_than_the_limit():
    tuner = Spsa(UNIT, iterations=3, calibration=1, step=1e6, largest_move=0.11)
    points = points_of(tuner, linear)
    moved = np.mean(points[3:5], axis=0) - points[0]
    assert np.abs(moved) == pytest.approx(np.full(3, 0.11))


@given(
    seed=st.integers(0, 10**6),
    unit=st.lists(st.floats(0.0, 1.0), min_size=3, max_size=3),
    perturbation=st.floats(1e-3, 0.49),
    failing=st.floats(0.0, 1.0),
)
def test_all_points_lie_inside(seed, unit, perturbation, failing):
    space = Space(
        [
            Parameter(name="a", low=-2.0, high=3.0),
            Parameter(name="l", low=1e-3, high=10.0, scale="log"),
            Parameter(name="p", low=0.0, high=6.0, periodic=True),
        ]
    )
    noise = np.random.default_rng(seed)
    tuner = Spsa(
        space, start=space.from_unit(unit), iterations=10, perturbation=perturbation, seed=seed
    )
    points = points_of(tuner, lambda _: np.nan if noise.random() < failing else noise.normal())
    assert len(points) == 1 + 2 * (10 + 3) + 1
    assert np.all(np.array(points) >= space.lower)
    assert np.all(np.array(points) <= space.upper)
    assert tuner.finished


def test_it_stays_where_all_fails():
    tuner = Spsa(UNIT, iterations=4)
    points = points_of(tuner, lambda _: np.nan)
    assert points[-1] == pytest.approx(points[0])
    with pytest.raises(ComputationError):
        tuner.best()


def test_it_finds_a_minimum_through_noise():
    function = hartmann(3)
    noisy = function.noisy(0.3, seed=1)
    gaps = []
    for seed in range(8):
        tuner = Spsa(function.space, iterations=100, seed=seed)
        gaps.append(function(points_of(tuner, noisy)[-1]) - function.minimum)
    start = function(tuner.start) - function.minimum
    assert np.median(gaps) < 0.1 * start  # measured: 0.04


@pytest.mark.parametrize(
    ("settings", "message"),
    [
        ({"iterations": -1}, "iterations"),
        ({"perturbation": 0.5}, "perturbation"),
        ({"perturbation": 0.0}, "perturbation"),
        ({"step": 0.0}, "step"),
        ({"move": 2.0}, "move"),
        ({"largest_move": 0.0}, "largest_move"),
        ({"calibration": 0}, "calibration"),
        ({"start": [2.0, 0.0, 0.0]}, "u0 = 2"),
    ],
)
def test_bad_settings_are_named(settings, message):
    with pytest.raises(InputError, match=message):
        Spsa(UNIT, **settings)
