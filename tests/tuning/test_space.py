"""Spaces: bounds, scales, turns of periodic parameters, gains with their offsets."""

from __future__ import annotations

import json

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from pitchopt.errors import InputError
from pitchopt.tuning import Parameter, Polar, Space

SPACE = Space(
    [
        Parameter(name="gain", low=-1.0, high=3.0),
        Parameter(name="rate", low=1e-3, high=10.0, scale="log"),
        Parameter(name="offset", low=-90.0, high=270.0, periodic=True),
        Parameter(name="turn", low=1.0, high=3.0, periodic=True),
    ],
    polar=[Polar(radius="gain", angle="offset")],
)
units = st.lists(st.floats(0.0, 1.0), min_size=4, max_size=4).map(np.array)
wide = st.lists(st.floats(-1e6, 1e6), min_size=4, max_size=4).map(np.array)


@given(units)
def test_unit_coordinates_and_back(u):
    x = SPACE.from_unit(u)
    assert np.all((x >= SPACE.lower) & (x <= SPACE.upper))
    again = SPACE.from_unit(SPACE.to_unit(x))
    assert again == pytest.approx(x, rel=1e-12, abs=1e-12)


def test_units_are_even_on_the_scale_of_a_parameter():
    assert SPACE.from_unit([0.5] * 4) == pytest.approx([1.0, 0.1, 90.0, 2.0])
    assert SPACE.to_unit([0.0, 1.0, 0.0, 2.5]) == pytest.approx([0.25, 0.75, 0.25, 0.75])


@given(wide)
def test_projection_is_inside_is_its_own_and_knows_one_end_of_a_period(x):
    inside = SPACE.project(x)
    assert np.all((inside >= SPACE.lower) & (inside <= SPACE.upper))
    assert np.all(inside[SPACE.periodic] < SPACE.upper[SPACE.periodic])
    assert np.array_equal(SPACE.project(inside), inside)


@pytest.mark.parametrize("x", [0.0, -1e-18, 360.0, -360.0, 720.0, 360.0 - 1e-15])
def test_ends_of_a_period_are_one_point(x):
    space = Space([Parameter(name="p", low=0.0, high=360.0, periodic=True)])
    assert space.point([x])[0] == pytest.approx(0.0, abs=1e-12)
    assert space.point(space.from_unit([x / 360.0]))[0] == pytest.approx(0.0, abs=1e-12)


def test_a_point_outside_is_named_and_rounding_is_forgiven():
    with pytest.raises(InputError, match=r"gain = 3\.1, expected between -1 and 3"):
        SPACE.point([3.1, 1.0, 0.0, 2.0])
    point = SPACE.point([3.0 + 1e-12, 1.0, 0.0, 2.0])
    assert point[0] == 3.0
    assert not point.flags.writeable
    for bad in ([1.0, 1.0], [np.nan, 1.0, 0.0, 2.0], "abcd", [[1.0, 1.0, 0.0, 2.0]]):
        with pytest.raises(InputError, match="x: "):
            SPACE.point(bad)


@given(units, st.integers(-3, 3))
def test_features_do_not_know_how_a_point_was_described(u, turns):
    features = SPACE.features(u)
    assert SPACE.features(u + turns * np.array([0, 0, 1, 1])) == pytest.approx(features, abs=1e-9)
    gain = SPACE.from_unit(u)[0]
    if abs(gain) <= 1.0:  # so that the opposite is in the space: half a period on
        opposite = u.copy()
        opposite[0] = SPACE.to_unit([-gain, 1.0, 0.0, 2.0])[0]
        opposite[2] += 0.5
        assert SPACE.features(opposite) == pytest.approx(features, abs=1e-9)


def test_at_gain_zero_all_offsets_are_one_point():
    u = np.array([0.25, 0.5, 0.1, 0.2])
    other = np.array([0.25, 0.5, 0.9, 0.2])
    assert SPACE.features(u) == pytest.approx(SPACE.features(other), abs=1e-15)


@given(units)
def test_jacobian_is_the_slope_of_the_features(u):
    step = 1e-6
    jacobian = SPACE.jacobian(u)
    for place, unit in enumerate(np.eye(4)):
        slope = (SPACE.features(u + step * unit) - SPACE.features(u - step * unit)) / (2 * step)
        assert jacobian[:, place] == pytest.approx(slope, abs=1e-7)


def test_features_of_one_parameter_share_a_group():
    # rate; cosine and sine of the turn; cosine and sine of the gain
    assert SPACE.groups.tolist() == [0, 1, 1, 2, 2]
    assert SPACE.features(np.zeros((5, 2, 4))).shape == (5, 2, 5)
    assert SPACE.jacobian(np.zeros((5, 2, 4))).shape == (5, 2, 5, 4)


def test_the_document_is_plain_and_tells_spaces_apart():
    document = SPACE.document()
    assert json.loads(json.dumps(document)) == document
    assert Space(SPACE.parameters).document() != document


@pytest.mark.parametrize(
    ("settings", "message"),
    [
        ({"low": 1.0, "high": 1.0}, "below the high one"),
        ({"low": 2.0, "high": 1.0}, "below the high one"),
        ({"low": np.nan, "high": 1.0}, "low bound of p"),
        ({"low": 0.0, "high": np.inf}, "high bound of p"),
        ({"low": 0.0, "high": 1.0, "scale": "log"}, "scale of p"),
        ({"low": 1.0, "high": 2.0, "scale": "log", "periodic": True}, "scale of p"),
        ({"low": 0.0, "high": 1.0, "scale": "cubic"}, "scale of p"),
    ],
)
def test_bad_parameters_are_named(settings, message):
    with pytest.raises(InputError, match=message):
        Parameter(name="p", **settings)


def test_bad_spaces_are_named():
    gain = Parameter(name="gain", low=0.0, high=1.0)
    angle = Parameter(name="angle", low=0.0, high=1.0, periodic=True)
    for parameters, polar, message in (
        ([], [], "got none"),
        ([gain, gain], [], "'gain' twice"),
        ([gain, angle], [Polar(radius="gian", angle="angle")], "'gian'"),
        ([gain, angle], [Polar(radius="gain", angle="gain")], "expected a periodic"),
        ([gain, angle], [Polar(radius="angle", angle="angle")], "expected a linear"),
        ([gain, angle], [Polar(radius="gain", angle="angle")] * 2, "in two pairs"),
    ):
        with pytest.raises(InputError, match=message):
            Space(parameters, polar)
