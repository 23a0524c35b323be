"""Turbulence on a mean wind, and hub speeds from a table."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from windfield import (
    PowerLaw,
    StaticField,
    TowerShadow,
    TransientField,
    TurbulenceBox,
    TurbulentField,
    WindField,
    WindFieldError,
    sample_disc,
)

TOWER = TowerShadow(radius=2.0, top=88.0)
MEAN = StaticField(
    speed=10.0,
    hub_height=90.0,
    vertical=PowerLaw(exponent=0.2),
    horizontal_shear=1e-3,
    tower=TOWER,
)
BOX = TurbulenceBox(
    velocity=np.random.default_rng(3).standard_normal((50, 6, 6, 3)),
    y=np.linspace(-80.0, 80.0, 6),
    z=np.linspace(0.0, 180.0, 6),
    spacing=3.0,
    mean_speed=10.0,
    periodic=True,
    label="made up",
)
FIELD = TurbulentField(mean=MEAN, box=BOX)
POINT = st.tuples(st.floats(-9, -3), st.floats(-60, 60), st.floats(20, 160), st.floats(0, 100))


@given(POINT)
def test_mean_and_fluctuation_then_the_tower(point: tuple[float, ...]) -> None:
    x, y, z, t = point
    wind = BOX.fluctuation(x, y, z, t)
    wind[0] += 10.0 * ((z / 90.0) ** 0.2 + 1e-3 * y)
    du, dv = TOWER.disturbance(x, y, z, wind[0], wind[1])
    np.testing.assert_allclose(
        FIELD.velocity(x, y, z, t), wind + np.array([du, dv, 0.0]), rtol=1e-12
    )
    assert z > 90.0 or float(np.hypot(du, dv)) > 0.0


@given(POINT, st.floats(-np.pi, np.pi))
def test_direction_turns_everything(point: tuple[float, ...], turn: float) -> None:
    x, y, z, t = point
    turned = TurbulentField(mean=replace(MEAN, horizontal_shear=0.0, direction=turn), box=BOX)
    straight = TurbulentField(mean=replace(MEAN, horizontal_shear=0.0), box=BOX)
    c, s = math.cos(turn), math.sin(turn)
    u, v, w = straight.velocity(x, y, z, t)
    got = turned.velocity(c * x - s * y, s * x + c * y, z, t)
    np.testing.assert_allclose(got, [c * u - s * v, s * u + c * v, w], atol=1e-9)


def test_without_turbulence_it_is_the_mean() -> None:
    calm = TurbulentField(mean=MEAN, box=replace(BOX, velocity=np.zeros((50, 6, 6, 3))))
    y, z = np.linspace(-50, 50, 7)[:, None], np.linspace(20, 160, 5)
    np.testing.assert_allclose(calm.velocity(-5.0, y, z, 3.0), MEAN.velocity(-5.0, y, z))


@pytest.mark.parametrize(
    "field",
    [FIELD, TransientField(mean=MEAN, time=[0.0, 9.0], speed=[3.0, 4.0])],
    ids=["turbulent", "transient"],
)
def test_protocol_and_broadcasting(field: TurbulentField | TransientField) -> None:
    assert isinstance(field, WindField)
    got = field.velocity(-5.0, [[1.0], [2.0]], [60.0, 70.0, 90.0], np.ones((4, 1, 1)))
    assert got.shape == (4, 2, 3, 3)
    one = field.velocity(-5.0, 2.0, 70.0, 1.0)
    np.testing.assert_allclose(got[2, 1, 1], one, rtol=1e-14)
    assert sample_disc(field, 60.0, x=-5.0, t=2.0).hub_height == 90.0
    with pytest.raises(WindFieldError, match="must broadcast"):
        field.velocity(0.0, 0.0, [50.0, 60.0], [0.0, 1.0, 2.0])
    with pytest.raises(WindFieldError, match="below ground"):
        field.velocity(0.0, 0.0, -1.0, 0.0)
    assert field == replace(field)


def test_points_outside_of_the_box() -> None:
    with pytest.raises(WindFieldError, match=r"y: got 81 m.*made up.*-80 to 80 m"):
        FIELD.velocity(0.0, 81.0, 90.0)


def test_box_and_mean_must_belong_together() -> None:
    with pytest.raises(WindFieldError, match=r"10 m/s carries .* mean wind of 12 m/s"):
        TurbulentField(mean=replace(MEAN, speed=12.0), box=BOX)
    with pytest.raises(WindFieldError, match="mean: got str"):
        TurbulentField(mean="wind", box=BOX)  # type: ignore[arg-type]
    with pytest.raises(WindFieldError, match="box: got ndarray"):
        TurbulentField(mean=MEAN, box=BOX.velocity)  # type: ignore[arg-type]


def test_a_step_of_the_whole_field() -> None:
    field = TransientField(mean=MEAN, time=[100.0, 100.1], speed=[12.0, 13.0])
    y, z = np.linspace(-50, 50, 7)[:, None], np.linspace(20, 160, 5)
    for t, speed in ((0.0, 12.0), (100.05, 12.5), (500.0, 13.0)):
        wanted = replace(MEAN, speed=speed).velocity(-5.0, y, z)
        np.testing.assert_allclose(field.velocity(-5.0, y, z, t), wanted, rtol=1e-12)
    np.testing.assert_allclose(field.hub_speed([99.0, 100.05]), [12.0, 12.5])


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"time": [0.0, 1.0, 2.0]}, r"time, speed: got shapes \(3,\) and \(2,\)"),
        ({"time": [], "speed": []}, "at least 1 entry"),
        ({"time": [1.0, 1.0]}, "time: got 1 after 1"),
        ({"speed": [1.0, -1.0]}, "speed: got -1"),
        ({"speed": [1.0, np.nan]}, "speed: got 1 NaN"),
        ({"mean": None}, "mean: got NoneType"),
    ],
)
def test_bad_tables(changes: dict[str, Any], message: str) -> None:
    settings: dict[str, Any] = {"mean": MEAN, "time": [0.0, 1.0], "speed": [3.0, 4.0]}
    with pytest.raises(WindFieldError, match=message):
        TransientField(**(settings | changes))
