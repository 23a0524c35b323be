"""Boxes of turbulence: interpolation, transport by the mean wind, bad input."""

from __future__ import annotations

import copy
import pickle
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.interpolate import RegularGridInterpolator

from windfield import PolarBox, TurbulenceBox, WindFieldError

Y = np.linspace(-30.0, 30.0, 5)
Z = np.linspace(20.0, 80.0, 4)
SPACING, SPEED = 2.0, 8.0
VALUES = np.random.default_rng(5).standard_normal((20, 5, 4, 3)).astype(np.float32)


def cartesian(**changes: Any) -> TurbulenceBox:
    settings: dict[str, Any] = {
        "velocity": VALUES, "y": Y, "z": Z, "spacing": SPACING, "mean_speed": SPEED,
        "periodic": True, "label": "made up",
    }  # fmt: skip
    return TurbulenceBox(**(settings | changes))


def polar(**changes: Any) -> PolarBox:
    velocity = np.random.default_rng(6).standard_normal((20, 4, 6, 3))
    velocity[:, 0] = velocity[:, 0, :1]
    settings: dict[str, Any] = {
        "velocity": velocity, "radius": [0.0, 10.0, 20.0, 30.0], "centre_height": 50.0,
        "spacing": SPACING, "mean_speed": SPEED, "periodic": True, "label": "made up",
    }  # fmt: skip
    return PolarBox(**(settings | changes))


BOXES = [cartesian(), polar()]


def test_velocity_is_single_precision_contiguous_and_read_only() -> None:
    box = cartesian(velocity=np.asfortranarray(VALUES.astype(np.float64)))
    assert box.velocity.dtype == np.float32 and box.velocity.flags.c_contiguous
    assert not box.velocity.flags.writeable
    np.testing.assert_array_equal(box.velocity, VALUES)


def test_grid_points_are_met_exactly() -> None:
    box = cartesian()
    x = -SPACING * np.arange(20.0)
    got = box.fluctuation(x[:, None, None], Y[:, None], Z, 0.0)
    np.testing.assert_allclose(got, VALUES, atol=1e-12)


def test_interpolation_is_scipys() -> None:
    # inside the first period, on a grid that repeats its first slice
    closed = np.concatenate([VALUES, VALUES[:1]])
    other = RegularGridInterpolator((np.arange(21.0), Y, Z), closed.astype(np.float64))
    rng = np.random.default_rng(1)
    x, y = rng.uniform(-15.0, 0.0, 200), rng.uniform(-30.0, 30.0, 200)
    z, t = rng.uniform(20.0, 80.0, 200), rng.uniform(0.0, 3.0, 200)
    got = cartesian().fluctuation(x, y, z, t)
    index = (SPEED * t - x) / SPACING
    np.testing.assert_allclose(got, other(np.column_stack([index, y, z])), atol=1e-12)


def test_polar_points_are_met_exactly() -> None:
    box = polar()
    radius, azimuth = box.radius[:, None], box.azimuth
    y, z = -radius * np.sin(azimuth), 50.0 + radius * np.cos(azimuth)
    got = box.fluctuation(-4.0 * SPACING, y, z, 0.0)
    np.testing.assert_allclose(got, box.velocity[4], atol=1e-12)
    # the second spoke of six stands on the right looking downwind, where y < 0
    assert y[1, 1] == pytest.approx(-10.0 * np.sqrt(0.75))


def test_polar_interpolation_is_linear_in_radius_and_azimuth() -> None:
    box = polar()
    a = 5.75 * np.pi / 3.0  # between the last spoke and the first one
    got = box.fluctuation(0.0, -24.0 * np.sin(a), 50.0 + 24.0 * np.cos(a), 0.0)
    wanted = 0.0
    for ring, p in ((2, 0.6), (3, 0.4)):
        for spoke, q in ((5, 0.25), (0, 0.75)):
            wanted = wanted + p * q * box.velocity[0, ring, spoke].astype(np.float64)
    np.testing.assert_allclose(got, wanted, atol=1e-12)


@pytest.mark.parametrize("box", BOXES, ids=["cartesian", "polar"])
@given(
    st.floats(-50, 50), st.floats(-20, 20), st.floats(30, 70), st.floats(0, 100), st.floats(0, 9)
)
def test_the_mean_wind_carries_the_box(
    box: TurbulenceBox | PolarBox, x: float, y: float, z: float, t: float, later: float
) -> None:
    here = box.fluctuation(x, y, z, t)
    np.testing.assert_allclose(box.fluctuation(x + SPEED * later, y, z, t + later), here, atol=1e-9)
    np.testing.assert_allclose(box.fluctuation(x, y, z, t + 3 * box.duration), here, atol=1e-9)


def test_offset_shifts_the_start() -> None:
    got = cartesian(offset=3.25).fluctuation(0.0, 5.0, 33.0, 1.0)
    np.testing.assert_allclose(got, cartesian().fluctuation(0.0, 5.0, 33.0, 1.0 + 3.25 * 0.25))


def test_just_below_zero_wraps() -> None:
    got = cartesian().fluctuation(1e-18, 0.0, 40.0, 0.0)
    np.testing.assert_allclose(got, cartesian().fluctuation(0.0, 0.0, 40.0, 0.0))


def test_broadcasting() -> None:
    got = cartesian().fluctuation(0.0, Y[:, None], Z, np.zeros((7, 1, 1)))
    assert got.shape == (7, 5, 4, 3)
    with pytest.raises(WindFieldError, match="must broadcast"):
        cartesian().fluctuation([0.0, 1.0], [0.0, 1.0, 2.0], 40.0)


@pytest.mark.parametrize("box", BOXES, ids=["cartesian", "polar"])
def test_outside_of_the_grid(box: TurbulenceBox | PolarBox) -> None:
    with pytest.raises(
        WindFieldError, match=r"got 31 m; .*made up.* is smaller than that, it spans"
    ):
        box.fluctuation(0.0, 31.0, 50.0)
    with pytest.raises(WindFieldError, match="it spans"):
        box.fluctuation(0.0, [0.0, 0.0], [50.0, 95.0])


def test_rounding_at_the_rim_is_forgiven() -> None:
    got = cartesian().fluctuation(0.0, 30.0 * (1 + 1e-12), 80.0 * (1 + 1e-12))
    np.testing.assert_allclose(got, VALUES[0, -1, -1], atol=1e-9)


def test_time_of_a_box_that_is_not_periodic() -> None:
    box = cartesian(periodic=False, offset=2.0)
    assert box.interval == 0.25
    assert box.duration == 17 * 0.25
    np.testing.assert_allclose(box.fluctuation(0.0, -30.0, 20.0, 4.25), VALUES[-1, 0, 0], atol=1e-6)
    np.testing.assert_allclose(box.fluctuation(4.0, -30.0, 20.0, 0.0), VALUES[0, 0, 0], atol=1e-6)
    with pytest.raises(
        WindFieldError, match=r"t = 4.3 s at x = 0 m; .* -0.5 to 4.25 s .* periodic"
    ):
        box.fluctuation(0.0, 0.0, 50.0, [1.0, 4.3])
    with pytest.raises(WindFieldError, match=r"at x = 4\.1 m"):
        box.fluctuation(4.1, 0.0, 50.0, 0.0)


def test_require_accepts_what_fits() -> None:
    cartesian().require(20.0, 80.0, 30.0, 5.0)
    cartesian().require(20.0, 80.0, 30.0, 50.0, repeat=True)
    polar().require(20.0, 80.0, 30.0, 5.0)
    box = cartesian(periodic=False, offset=2.0)
    box.require(20.0, 80.0, 30.0, 3.75, x_low=-4.0, x_high=4.0)
    # what it promises holds at the ends
    box.fluctuation([-4.0, 4.0], 0.0, 50.0, [3.75, 0.0])


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ((19.0, 80.0, 30.0, 5.0), "from 19 to 80 m; .* smaller than the rotor, it spans 20 to 80"),
        ((20.0, 81.0, 30.0, 5.0), "from 20 to 81 m"),
        ((20.0, 80.0, 31.0, 5.0), "31 m to either side; .* smaller than the rotor"),
        ((20.0, 80.0, 30.0, 5.1), "run of 5.1 s in a box .* repeats after 5 s"),
        ((20.0, 80.0, 30.0, -1.0), "duration: got -1"),
    ],
)
def test_require_refuses(arguments: tuple[float, ...], message: str) -> None:
    with pytest.raises(WindFieldError, match=message):
        cartesian().require(*arguments)


def test_require_of_polar_boxes() -> None:
    for low, high, half in ((19.0, 80.0, 30.0), (20.0, 81.0, 30.0), (20.0, 80.0, 31.0)):
        with pytest.raises(WindFieldError, match=r"reaches 31 m from the axis .* smaller"):
            polar().require(low, high, half, 1.0)


def test_require_of_a_box_that_is_not_periodic() -> None:
    box = cartesian(periodic=False, offset=2.0)
    with pytest.raises(WindFieldError, match=r"run of 3.8 s .* lasts 3.75 s at x = -4 m"):
        box.require(20.0, 80.0, 30.0, 3.8, x_low=-4.0)
    with pytest.raises(WindFieldError, match=r"offset: got 2 .* at least 2.5 .* x = 5 m"):
        box.require(20.0, 80.0, 30.0, 1.0, x_high=5.0)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"velocity": VALUES[..., :2]}, r"velocity: got shape \(20, 5, 4, 2\)"),
        ({"velocity": VALUES[0]}, "velocity: got shape"),
        ({"velocity": VALUES[:1]}, "velocity: got shape"),
        ({"velocity": VALUES[:, :4]}, r"velocity: got shape \(20, 4, 4, 3\); .* 5 and 4"),
        ({"velocity": VALUES.astype(complex)}, "velocity: got data of type complex"),
        ({"velocity": np.where(VALUES > 2.0, np.nan, VALUES)}, "velocity: got .* NaN"),
        ({"velocity": VALUES.astype(np.float64) * 1e39}, "velocity: got .* infinite"),
        ({"y": Y[::-1]}, "y: got .* must increase"),
        ({"y": [-30.0, -15.0, 0.0, 15.0, 31.0]}, "y: got steps of 15 to 16 m"),
        ({"z": Z - 21.0}, "z: got -1 m"),
        ({"spacing": 0.0}, "spacing: got 0"),
        ({"mean_speed": -1.0}, "mean_speed: got -1"),
        ({"offset": np.inf}, "offset: got inf"),
    ],
)
def test_bad_cartesian_boxes(changes: dict[str, Any], message: str) -> None:
    with pytest.raises(WindFieldError, match=message):
        cartesian(**changes)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"radius": [1.0, 2.0, 3.0, 4.0]}, "radius: got 1 m first"),
        ({"radius": [0.0, 2.0, 4.0]}, "velocity: got shape"),
        ({"centre_height": 0.0}, "centre_height: got 0"),
        ({"velocity": np.zeros((20, 4, 2, 3))}, "velocity: got 2 spokes"),
        ({"velocity": VALUES.swapaxes(1, 2)}, "different values at radius 0"),
    ],
)
def test_bad_polar_boxes(changes: dict[str, Any], message: str) -> None:
    with pytest.raises(WindFieldError, match=message):
        polar(**changes)


@pytest.mark.parametrize("box", BOXES, ids=["cartesian", "polar"])
def test_values_compare_and_pickle(box: TurbulenceBox | PolarBox) -> None:
    back = pickle.loads(pickle.dumps(box))  # noqa: S301 (own bytes)
    assert back == box and hash(back) == hash(box) and not back.velocity.flags.writeable
    assert copy.copy(box) == box
    assert cartesian(offset=1.0) != cartesian()
