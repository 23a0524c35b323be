"""Static field: composition, invariances, shapes and bad points; the paper's case."""

# ruff: noqa: ARG005 - functions of (y, z) need not use both

from __future__ import annotations

import math
import pickle
import subprocess
import sys

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from windfield import (
    CallableField,
    CubicShear,
    DiscField,
    LogLaw,
    PowerLaw,
    StaticField,
    TowerShadow,
    WindField,
    WindFieldError,
    sample_disc,
)

TOWER = TowerShadow(radius=[3.0, 1.935, 1.935], height=[0.0, 85.268, 87.6], top=87.6)
FULL = StaticField(
    speed=12.0,
    hub_height=90.0,
    vertical=PowerLaw(exponent=0.2),
    horizontal_shear=1e-3,
    direction=0.1,
    tower=TOWER,
)


def test_parts_add_up() -> None:
    x, y, z = -5.0, 7.0, 60.0
    speed = 12.0 * ((60.0 / 90.0) ** 0.2 + 1e-3 * 7.0)
    assert FULL.undisturbed_speed(y, z) == pytest.approx(speed, rel=1e-14)
    u, v = speed * math.cos(0.1), speed * math.sin(0.1)
    du, dv = TOWER.disturbance(x, y, z, u, v)
    np.testing.assert_allclose(FULL.velocity(x, y, z), [u + du, v + dv, 0.0], rtol=1e-14)


def test_uniform_wind() -> None:
    got = StaticField(speed=8.0, hub_height=90.0).velocity(0.0, [1.0, 2.0], [30.0, 150.0])
    np.testing.assert_array_equal(got, [[8.0, 0.0, 0.0]] * 2)


@pytest.mark.parametrize("law", [PowerLaw(exponent=0.2), LogLaw(roughness_length=0.05)])
def test_vertical_shear_is_about_the_hub(law: PowerLaw | LogLaw) -> None:
    field = StaticField(speed=9.0, hub_height=110.0, vertical=law)
    np.testing.assert_allclose(field.velocity(0.0, 0.0, 110.0), [9.0, 0.0, 0.0], rtol=1e-14)


def test_case_of_the_paper() -> None:
    # eta = (0, 15, 0.2, 5e-4, 1); its y axis points right looking downwind, ours left
    field = StaticField(
        speed=15.0,
        hub_height=80.0,
        vertical=CubicShear(exponent=0.2),
        horizontal_shear=-5e-4,
        tower=TowerShadow.below_hub(radius=0.93, hub_height=80.0, lateral=False, smoothing=4.0),
    )
    sample = sample_disc(field, 40.0, x=-5.5, rings=81, azimuths=360)
    # figure 2 is coloured from 13 to 16 m/s
    assert 12.5 < sample.speed.min() < 13.0
    assert 16.0 < sample.speed.max() < 16.5
    i, j = np.unravel_index(int(sample.speed.argmin()), sample.speed.shape)
    assert abs(sample.y[i, j]) < 1.0 and sample.z[i, j] < -39.0
    # faster on the right looking downwind, where the paper's y is positive
    right, left = field.velocity(-5.5, [-40.0, 40.0], 80.0)[:, 0]
    assert right - left == pytest.approx(2 * 15.0 * 5e-4 * 40.0, rel=1e-3)


def test_shear_to_the_left_is_positive() -> None:
    field = StaticField(speed=10.0, hub_height=90.0, horizontal_shear=1e-3)
    np.testing.assert_allclose(field.velocity(0.0, [50.0, -50.0], 90.0)[:, 0], [10.5, 9.5])


@given(st.floats(0.0, 40.0), st.floats(-60, 60), st.floats(1, 150))
def test_speed_scales_velocity(speed: float, y: float, z: float) -> None:
    scaled = StaticField(
        speed=speed, hub_height=90.0, vertical=PowerLaw(exponent=0.2), horizontal_shear=1e-3,
        direction=0.1, tower=TOWER,
    )  # fmt: skip
    np.testing.assert_allclose(
        scaled.velocity(-5.0, y, z), FULL.velocity(-5.0, y, z) * speed / 12.0, atol=1e-12
    )


@given(st.floats(-np.pi, np.pi), st.floats(-30, 30), st.floats(-30, 30), st.floats(1, 150))
def test_direction_turns_the_whole_field(turn: float, x: float, y: float, z: float) -> None:
    def field(direction: float) -> StaticField:
        return StaticField(
            speed=12.0, hub_height=90.0, vertical=PowerLaw(exponent=0.2), direction=direction,
            tower=TOWER,
        )  # fmt: skip

    c, s = math.cos(turn), math.sin(turn)
    u, v, w = field(0.0).velocity(x, y, z)
    turned = field(turn).velocity(c * x - s * y, s * x + c * y, z)
    np.testing.assert_allclose(turned, [c * u - s * v, s * u + c * v, w], atol=1e-9)


@given(st.floats(-60, 60), st.floats(1, 150), st.floats(-0.5, 0.5), st.floats(-1e-3, 1e-3))
def test_mirrored_wind(y: float, z: float, direction: float, shear: float) -> None:
    def field(sign: float) -> StaticField:
        return StaticField(
            speed=12.0, hub_height=90.0, direction=sign * direction, horizontal_shear=sign * shear,
            tower=TOWER,
        )  # fmt: skip

    u, v, w = field(1.0).velocity(-5.0, y, z)
    np.testing.assert_allclose(field(-1.0).velocity(-5.0, -y, z), [u, -v, w], atol=1e-12)


FIELDS: dict[str, WindField] = {
    "static": FULL,
    "callable": CallableField(speed=lambda y, z: 10.0 + 0.01 * z, hub_height=90.0, tower=TOWER),
    "scalar callable": CallableField(speed=lambda y, z: 10.0 if z > 0 else 9.0, hub_height=90.0),
    "grid": DiscField(
        y=[-70.0, 70.0], z=[-70.0, 70.0], speed=[[8.0, 10.0], [9.0, 12.0]], hub_height=90.0
    ),
    "polar grid": DiscField(
        radius=[0.0, 70.0], azimuth=np.deg2rad([0.0, 120.0, 240.0]),
        speed=[[8.0] * 3, [7.0, 8.0, 9.0]], hub_height=90.0, tower=TOWER,
    ),
}  # fmt: skip


@pytest.mark.parametrize("field", FIELDS.values(), ids=FIELDS.keys())
class TestEveryField:
    @pytest.mark.parametrize(
        ("shapes", "expected"),
        [
            (((), (), (), ()), ()),
            (((), (5,), (5,), ()), (5,)),
            (((1, 1), (4, 1), (3,), ()), (4, 3)),
            (((2, 1, 1), (3, 1), (4,), ()), (2, 3, 4)),
            (((), (3,), (3,), (6, 1)), (6, 3)),
            (((0,), (), (), ()), (0,)),
            (((), (0, 2), (2,), ()), (0, 2)),
        ],
    )
    def test_broadcasts(
        self, field: WindField, shapes: tuple[tuple[int, ...], ...], expected: tuple[int, ...]
    ) -> None:
        rng = np.random.default_rng(5)
        x, y = rng.uniform(-6, -4, shapes[0]), rng.uniform(-40, 40, shapes[1])
        z, t = rng.uniform(50, 130, shapes[2]), rng.uniform(0, 9, shapes[3])
        got = field.velocity(x, y, z, t)
        assert got.shape == (*expected, 3)
        assert got.dtype == np.float64
        full = np.broadcast_arrays(x, y, z)
        each = [field.velocity(*point) for point in zip(*(a.flat for a in full), strict=True)]
        if each:
            one_time = np.array(each).reshape(*full[0].shape, 3)
            np.testing.assert_allclose(got, np.broadcast_to(one_time, got.shape), rtol=1e-13)

    def test_is_a_wind_field_and_steady(self, field: WindField) -> None:
        assert isinstance(field, WindField)
        np.testing.assert_array_equal(field.velocity(-5, 3, 80, t=17.5), field.velocity(-5, 3, 80))

    def test_result_may_be_changed(self, field: WindField) -> None:
        first = field.velocity(-5.0, [0.0, 1.0], 80.0)
        expected = first.copy()
        first[...] = 0.0
        np.testing.assert_array_equal(field.velocity(-5.0, [0.0, 1.0], 80.0), expected)

    def test_integers_and_lists_will_do(self, field: WindField) -> None:
        np.testing.assert_array_equal(
            field.velocity(-5, [1, 2], 80), field.velocity(-5.0, np.array([1.0, 2.0]), 80.0)
        )

    @pytest.mark.parametrize(
        ("point", "message"),
        [
            ((0.0, 0.0, -2.5), r"z: got a height of -2.5 m, below ground; must be >= 0"),
            ((math.nan, 0.0, 90.0), "x: got 1 NaN or infinite of 1"),
            ((0.0, [0.0, math.inf], 90.0), "y: got 1 NaN or infinite of 2"),
            ((0.0, 0.0, "high"), "z: got data of type"),
            ((0.0, 0.0, None), "z: got data of type"),
            ((0.0, [1.0, 2.0], [90.0, 91.0, 92.0]), "must broadcast"),
        ],
    )
    def test_bad_points(self, field: WindField, point: tuple[object, ...], message: str) -> None:
        with pytest.raises(WindFieldError, match=message):
            field.velocity(*point)
        with pytest.raises(WindFieldError, match="t: got 1 NaN"):
            field.velocity(0.0, 0.0, 90.0, math.nan)


def test_rounding_at_the_ground_is_forgiven() -> None:
    got = FULL.velocity(20.0, 0.0, -1e-12)
    np.testing.assert_array_equal(got, FULL.velocity(20.0, 0.0, 0.0))
    assert np.isfinite(got).all()


def test_own_shear_law() -> None:
    class Jet:
        def factor(self, height: object, hub_height: float) -> object:
            return 2.0 - np.abs(np.asarray(height) / hub_height - 1.0)

    field = StaticField(speed=5.0, hub_height=100.0, vertical=Jet())
    np.testing.assert_allclose(field.velocity(0.0, 0.0, [50.0, 100.0])[:, 0], [7.5, 10.0])


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"speed": -1.0}, r"speed: got -1.0; must be a finite number >= 0 \[m/s\]"),
        ({"speed": math.nan}, "speed: got nan"),
        ({"speed": [8.0, 9.0]}, "speed: got"),
        ({"hub_height": 0.0}, r"hub_height: got 0.0; must be a finite number > 0 \[m\]"),
        ({"hub_height": math.inf}, "hub_height: got inf"),
        ({"vertical": 0.2}, "vertical: got 0.2; must be None, PowerLaw"),
        ({"vertical": PowerLaw}, "vertical: got"),
        ({"vertical": LogLaw(roughness_length=95.0)}, "roughness_length: got 95 m"),
        ({"horizontal_shear": math.inf}, "horizontal_shear: got inf"),
        ({"direction": math.nan}, r"direction: got nan; must be a finite number \[rad\]"),
        ({"tower": 2.0}, "tower: got float; must be a TowerShadow or None"),
    ],
)
def test_bad_input(change: dict[str, object], message: str) -> None:
    with pytest.raises(WindFieldError, match=message):
        StaticField(**{"speed": 10.0, "hub_height": 90.0, **change})


def test_fields_are_values() -> None:
    twin = pickle.loads(pickle.dumps(FULL))  # noqa: S301  (our own object)
    assert twin == FULL and hash(twin) == hash(FULL)
    assert StaticField(speed=10, hub_height=90) != FULL
    with pytest.raises(AttributeError):
        FULL.speed = 3.0


def test_stands_alone() -> None:
    code = "import sys, windfield; print(*sorted({m.split('.')[0] for m in sys.modules}))"
    out = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, check=True
    ).stdout.split()
    assert "windfield" in out
    assert not {"pitchopt", "ilc", "scipy", "matplotlib", "numba"} & set(out)
