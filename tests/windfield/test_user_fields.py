"""Fields from a function and from a grid."""

# ruff: noqa: ARG005 - functions of (y, z) need not use both

from __future__ import annotations

import math
import pickle
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.interpolate import RegularGridInterpolator

from windfield import CallableField, DiscField, PowerLaw, StaticField, TowerShadow, WindFieldError


def jet(y: Any, z: Any) -> Any:
    return 10.0 + 0.01 * z - 1e-3 * y**2


class TestCallable:
    def test_sees_hub_centred_coordinates(self) -> None:
        field = CallableField(speed=jet, hub_height=90.0, direction=0.2)
        expected = 10.0 + 0.01 * 30.0 - 1e-3 * 400.0
        assert field.undisturbed_speed(20.0, 120.0) == pytest.approx(expected)
        np.testing.assert_allclose(
            field.velocity(-5.0, 20.0, 120.0),
            [expected * math.cos(0.2), expected * math.sin(0.2), 0.0],
        )

    @given(st.floats(-60, 60), st.floats(-60, 60))
    def test_same_as_the_static_field(self, y: float, z: float) -> None:
        tower = TowerShadow(radius=2.0, top=87.0)
        law = PowerLaw(exponent=0.2)
        static = StaticField(speed=12.0, hub_height=90.0, vertical=law, tower=tower)
        own = CallableField(
            speed=lambda y, z: 12.0 * ((z + 90.0) / 90.0) ** 0.2, hub_height=90.0, tower=tower
        )
        np.testing.assert_allclose(
            own.velocity(-5.0, y, 90.0 + z), static.velocity(-5.0, y, 90.0 + z), rtol=1e-13
        )

    @pytest.mark.parametrize(
        ("function", "vectorised"),
        [
            (jet, True),
            (lambda y, z: np.where(z > 0, 10.0, 9.0), True),
            (lambda y, z: 10 + 0 * y.astype(int), True),  # arrays only
            (lambda y, z: 10.0 if z > 0 else 9.0, False),
            (lambda y, z: 10.0 + math.sin(0.1 * y), False),
            (lambda y, z: 10.0, False),
            (lambda y, z: 10.0 + np.mean(z), False),  # mixes points when given arrays
            (lambda y, z: np.cumsum(np.atleast_1d(y))[-1] + 10.0, False),
            (lambda y, z: 10.0 + z - np.max(z), False),  # right shape, wrong values
        ],
    )
    def test_scalar_functions_are_found_out(
        self, function: Callable[..., Any], vectorised: bool
    ) -> None:
        field = CallableField(speed=function, hub_height=90.0)
        assert field.vectorised is vectorised
        y, z = np.array([[-3.0, 4.0, 0.5]]), np.array([[80.0], [95.0]])
        got = field.undisturbed_speed(y, z)
        assert got.shape == (2, 3)
        if not vectorised:
            for i, j in np.ndindex(2, 3):
                assert got[i, j] == function(float(y[0, j]), float(z[i, 0]) - 90.0)

    def test_may_change_its_arguments(self) -> None:
        def rude(y: Any, z: Any) -> Any:
            z += 10.0
            return 0.1 * z + 10.0

        height = np.array([80.0, 90.0])
        field = CallableField(speed=rude, hub_height=90.0)
        np.testing.assert_allclose(field.undisturbed_speed([0.0, 0.0], height), [10.0, 11.0])
        np.testing.assert_array_equal(height, [80.0, 90.0])

    @pytest.mark.parametrize(
        ("function", "message"),
        [
            (3.0, "speed: got float; must be a function"),
            (lambda y: 10.0, "speed: function failed .* TypeError"),
            (lambda y, z: None, "must return one number"),
            (lambda y, z: "fast", "must return one number"),
            (lambda y, z: 1 / 0, "ZeroDivisionError"),
            (lambda y, z: [10.0, 11.0], "must return one number"),
        ],
    )
    def test_bad_functions(self, function: Any, message: str) -> None:
        with pytest.raises(WindFieldError, match=message):
            CallableField(speed=function, hub_height=90.0)

    def test_bad_values_at_points(self) -> None:
        root = CallableField(speed=lambda y, z: np.sqrt(z + 5.0), hub_height=90.0)
        assert root.vectorised
        with pytest.raises(
            WindFieldError, match=r"returned nan at hub-centred \(y, z\) = \(1, -10\) m"
        ):
            root.velocity(0.0, [0.0, 1.0], [90.0, 80.0])
        poles = CallableField(speed=lambda y, z: math.inf if z > 20 else 9.0, hub_height=90.0)
        with pytest.raises(WindFieldError, match="returned inf"):
            poles.velocity(0.0, 0.0, 120.0)
        fails = CallableField(speed=lambda y, z: math.sqrt(z + 5.0), hub_height=90.0)
        with pytest.raises(WindFieldError, match=r"\(0, -10\) m with ValueError"):
            fails.velocity(0.0, 0.0, 80.0)
        short = CallableField(speed=lambda y, z: (10.0 + 0 * y)[:3], hub_height=90.0)
        with pytest.raises(WindFieldError, match=r"returned shape \(3,\) for 4 points"):
            short.velocity(0.0, np.zeros(4), 90.0)
        breaks = CallableField(speed=lambda y, z: 10.0 / (len(y) - 4) + 0 * y, hub_height=90.0)
        with pytest.raises(WindFieldError, match="failed on 4 points with ZeroDivisionError"):
            breaks.velocity(0.0, np.zeros(4), 90.0)
        text = CallableField(
            speed=lambda y, z: np.full(len(y), "a" if len(y) > 3 else 1), hub_height=90.0
        )
        with pytest.raises(WindFieldError, match="returned data of type"):
            text.velocity(0.0, np.zeros(4), 90.0)

    def test_value(self) -> None:
        field = CallableField(speed=jet, hub_height=90.0)
        assert field == CallableField(speed=jet, hub_height=90.0)
        assert field != CallableField(speed=jet, hub_height=91.0)
        assert hash(field) == hash(CallableField(speed=jet, hub_height=90.0))
        named = CallableField(speed=np.hypot, hub_height=90.0)
        assert pickle.loads(pickle.dumps(named)) == named  # noqa: S301  (our own object)


AXIS = np.array([-40.0, -10.0, 5.0, 40.0])
GRID = np.random.default_rng(6).uniform(8.0, 14.0, (4, 4))
RADII = np.array([0.0, 10.0, 25.0, 40.0])
TURN = np.deg2rad(np.arange(0.0, 360.0, 30.0))
RINGS = np.random.default_rng(7).uniform(8.0, 14.0, (4, 12))
RINGS[0] = 11.0


class TestGrid:
    def test_cartesian_against_scipy(self) -> None:
        field = DiscField(y=AXIS, z=AXIS, speed=GRID, hub_height=90.0, direction=-0.3)
        points = np.random.default_rng(8).uniform(-40.0, 40.0, (500, 2))
        expected = RegularGridInterpolator((AXIS, AXIS), GRID)(points)
        got = field.velocity(-5.0, points[:, 0], 90.0 + points[:, 1])
        np.testing.assert_allclose(got[:, 0], expected * math.cos(0.3), rtol=1e-12)
        np.testing.assert_allclose(got[:, 1], -expected * math.sin(0.3), rtol=1e-12)
        assert field.layout == "cartesian"

    def test_polar_against_scipy(self) -> None:
        field = DiscField(radius=RADII, azimuth=TURN, speed=RINGS, hub_height=90.0)
        rng = np.random.default_rng(9)
        r, psi = rng.uniform(0.0, 40.0, 500), rng.uniform(0.0, 2 * np.pi, 500)
        closed = RegularGridInterpolator(
            (RADII, np.append(TURN, 2 * np.pi)), np.hstack([RINGS, RINGS[:, :1]])
        )
        got = field.undisturbed_speed(-r * np.sin(psi), 90.0 + r * np.cos(psi))
        np.testing.assert_allclose(got, closed(np.stack([r, psi], axis=1)), rtol=1e-11)
        assert field.layout == "polar"

    def test_exact_at_the_nodes(self) -> None:
        cartesian = DiscField(y=AXIS, z=AXIS, speed=GRID, hub_height=90.0)
        got = cartesian.undisturbed_speed(AXIS[:, None], 90.0 + AXIS)
        np.testing.assert_allclose(got, GRID, rtol=1e-14)
        polar = DiscField(radius=RADII, azimuth=TURN, speed=RINGS, hub_height=90.0)
        y, z = -RADII[:, None] * np.sin(TURN), RADII[:, None] * np.cos(TURN)
        np.testing.assert_allclose(polar.undisturbed_speed(y, 90.0 + z), RINGS, rtol=1e-12)

    def test_azimuth_90_is_on_the_right(self) -> None:
        speed = np.full((2, 4), 10.0)
        speed[1, 1] = 12.0
        polar = DiscField(
            radius=[0.0, 40.0], azimuth=np.deg2rad([0, 90, 180, 270]), speed=speed, hub_height=90.0
        )
        np.testing.assert_allclose(
            polar.undisturbed_speed([-40.0, 40.0], [90.0, 90.0]), [12.0, 10.0], rtol=1e-12
        )

    def test_bilinear_profile_is_exact(self) -> None:
        field = DiscField(
            y=AXIS, z=AXIS, hub_height=90.0,
            speed=10.0 + 0.01 * AXIS[:, None] - 0.02 * AXIS + 1e-4 * AXIS[:, None] * AXIS,
        )  # fmt: skip
        y, z = np.random.default_rng(10).uniform(-40.0, 40.0, (2, 100))
        np.testing.assert_allclose(
            field.undisturbed_speed(y, 90.0 + z), 10 + 0.01 * y - 0.02 * z + 1e-4 * y * z
        )

    @given(st.floats(-np.pi, np.pi), st.floats(0.0, 40.0), st.integers(0, 11))
    def test_polar_shift_of_azimuth(self, psi: float, r: float, shift: int) -> None:
        one = DiscField(radius=RADII, azimuth=TURN, speed=RINGS, hub_height=90.0)
        rolled = np.roll(RINGS, shift, axis=1)
        two = DiscField(radius=RADII, azimuth=TURN, speed=rolled, hub_height=90.0)
        later = psi + math.radians(30.0 * shift)
        assert two.undisturbed_speed(-r * math.sin(later), 90 + r * math.cos(later)) == (
            pytest.approx(float(one.undisturbed_speed(-r * math.sin(psi), 90 + r * math.cos(psi))))
        )

    def test_azimuth_may_start_anywhere_and_repeat(self) -> None:
        plain = DiscField(radius=RADII, azimuth=TURN, speed=RINGS, hub_height=90.0)
        closed = DiscField(
            radius=RADII,
            azimuth=np.append(TURN, 2 * np.pi),
            speed=np.hstack([RINGS, RINGS[:, :1]]),
            hub_height=90.0,
        )
        assert plain == closed and hash(plain) == hash(closed)
        centred = DiscField(
            radius=RADII, azimuth=TURN - np.pi, speed=np.roll(RINGS, 6, axis=1), hub_height=90.0
        )
        y, z = np.random.default_rng(11).uniform(-25.0, 25.0, (2, 100))
        np.testing.assert_allclose(
            centred.undisturbed_speed(y, 90 + z), plain.undisturbed_speed(y, 90 + z), rtol=1e-12
        )

    def test_tower_comes_on_top(self) -> None:
        tower = TowerShadow(radius=2.0, top=88.0)
        flat = DiscField(y=AXIS, z=AXIS, speed=np.full((4, 4), 9.0), hub_height=90.0, tower=tower)
        static = StaticField(speed=9.0, hub_height=90.0, tower=tower)
        y = np.linspace(-40.0, 40.0, 31)
        np.testing.assert_allclose(
            flat.velocity(-5.0, y, 70.0), static.velocity(-5.0, y, 70.0), rtol=1e-14
        )

    def test_nothing_is_extrapolated(self) -> None:
        cartesian = DiscField(y=AXIS, z=AXIS, speed=GRID, hub_height=90.0)
        with pytest.raises(WindFieldError, match=r"y: got 40.5 m .* grid, -40 to 40 m"):
            cartesian.velocity(0.0, [0.0, 40.5], 90.0)
        with pytest.raises(WindFieldError, match=r"z: got -41 m"):
            cartesian.velocity(0.0, 0.0, 49.0)
        ring = DiscField(radius=RADII[1:], azimuth=TURN, speed=RINGS[1:], hub_height=90.0)
        with pytest.raises(WindFieldError, match=r"radius: got 5 m .* grid, 10 to 40 m"):
            ring.velocity(0.0, 5.0, 90.0)
        # rounding at the rim is no reason to fail
        edge = 40.0 * (1.0 + 1e-13)
        assert ring.undisturbed_speed(0.0, 90.0 + edge) == pytest.approx(RINGS[3, 0])

    def test_values(self) -> None:
        grid = GRID.copy()
        field = DiscField(y=AXIS, z=AXIS, speed=grid, hub_height=90.0)
        grid[...] = 0.0
        assert field.undisturbed_speed(-40.0, 50.0) == GRID[0, 0]
        with pytest.raises(ValueError, match="read-only"):
            field.speed[0, 0] = 1.0
        assert pickle.loads(pickle.dumps(field)) == field  # noqa: S301  (our own object)

    @pytest.mark.parametrize(
        ("arguments", "message"),
        [
            ({}, "got none; must be y and z or radius and azimuth"),
            ({"y": AXIS}, "got y; must be y and z"),
            ({"y": AXIS, "azimuth": TURN}, "got y, azimuth"),
            ({"y": AXIS, "z": AXIS, "radius": RADII}, "got y, z, radius"),
            ({"y": AXIS, "z": AXIS[:3]}, r"speed: got shape \(4, 4\); must be \(4, 3\)"),
            ({"y": AXIS, "z": AXIS[::-1]}, "z: got 5 after 40; must increase"),
            ({"y": [1.0], "z": AXIS}, r"y: got 1 value\(s\); must be at least 2"),
            ({"y": AXIS[:, None], "z": AXIS}, r"y: got shape \(4, 1\)"),
            ({"y": AXIS, "z": AXIS, "speed": GRID[0]}, r"speed: got shape \(4,\)"),
            ({"y": AXIS, "z": AXIS, "speed": GRID * np.nan}, "speed: got 16 NaN"),
            ({"y": AXIS, "z": AXIS, "speed": -GRID}, "speed: got -.*must be >= 0"),
            ({"y": AXIS, "z": AXIS, "hub_height": -1.0}, "hub_height: got -1.0"),
            ({"radius": RADII - 1.0, "azimuth": TURN, "speed": RINGS}, "radius: got -1"),
            ({"radius": RADII, "azimuth": 2.0 * TURN, "speed": RINGS}, "a span of 660 degrees"),
            ({"radius": RADII, "azimuth": 0.5 * TURN, "speed": RINGS}, "a gap of 195 degrees"),
            (
                {"radius": RADII, "azimuth": TURN, "speed": RINGS + TURN},
                "at radius 0; must be one value",
            ),
            (
                {
                    "radius": RADII,
                    "azimuth": np.linspace(0, 2 * np.pi, 12),
                    "speed": RINGS + np.arange(12) * [[0], [1], [1], [1]],
                },
                "one turn later; must agree",
            ),
        ],
    )
    def test_bad_input(self, arguments: dict[str, Any], message: str) -> None:
        with pytest.raises(WindFieldError, match=message):
            DiscField(**{"speed": GRID, "hub_height": 90.0, **arguments})
