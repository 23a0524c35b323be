"""Tower shadow against potential-flow theory and the rule of AeroDyn."""

from __future__ import annotations

import copy
import math
import pickle

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray

from windfield import TowerShadow, WindFieldError

A = 2.0
TOWER = TowerShadow(radius=A, top=90.0)
NREL = TowerShadow(radius=[3.0, 1.935, 1.935], height=[0.0, 85.268, 87.6], top=87.6)


def wind(x: object, y: object, u: float = 10.0, v: float = 0.0) -> NDArray[np.float64]:
    """Total horizontal wind (..., 2) around TOWER, well below its top."""
    du, dv = TOWER.disturbance(x, y, 50.0, u, v)
    return np.stack([u + du, v + dv], axis=-1)


def test_matches_the_complex_velocity_of_the_circle_theorem() -> None:
    rng = np.random.default_rng(1)
    zeta = rng.uniform(A, 30.0, 200) * np.exp(1j * rng.uniform(0.0, 2 * np.pi, 200))
    free = 8.0 + 3.0j
    # W = conj(V) zeta + V a^2 / zeta, differentiated numerically along the real axis
    step = 1e-4

    def potential(at: NDArray[np.complex128]) -> NDArray[np.complex128]:
        return np.conj(free) * at + free * A**2 / at

    derivative = (potential(zeta + step) - potential(zeta - step)) / (2.0 * step)
    got = wind(zeta.real, zeta.imag, free.real, free.imag)
    np.testing.assert_allclose(got[:, 0], derivative.real, rtol=0.0, atol=1e-6)
    np.testing.assert_allclose(got[:, 1], -derivative.imag, rtol=0.0, atol=1e-6)


@pytest.mark.parametrize("direction", [0.0, 0.3, -2.0])
def test_no_flow_through_the_surface(direction: float) -> None:
    theta = np.linspace(0.0, 2.0 * np.pi, 73)
    u, v = 10.0 * math.cos(direction), 10.0 * math.sin(direction)
    got = wind(A * np.cos(theta), A * np.sin(theta), u, v)
    normal = np.stack([np.cos(theta), np.sin(theta)], axis=-1)
    np.testing.assert_allclose(np.sum(got * normal, axis=-1), 0.0, atol=1e-12)
    # and twice the free speed at the flanks
    assert np.linalg.norm(got, axis=-1).max() == pytest.approx(20.0, rel=2e-3)


def test_free_of_divergence_and_curl() -> None:
    rng = np.random.default_rng(2)
    r, theta = rng.uniform(1.2 * A, 20.0, 300), rng.uniform(0.0, 2.0 * np.pi, 300)
    x, y, h = r * np.cos(theta), r * np.sin(theta), 1e-4
    along_x = (wind(x + h, y, 9.0, 4.0) - wind(x - h, y, 9.0, 4.0)) / (2.0 * h)
    along_y = (wind(x, y + h, 9.0, 4.0) - wind(x, y - h, 9.0, 4.0)) / (2.0 * h)
    assert np.abs(along_x).max() > 1.0  # the gradients themselves are not small
    np.testing.assert_allclose(along_x[:, 0] + along_y[:, 1], 0.0, atol=1e-5)
    np.testing.assert_allclose(along_x[:, 1] - along_y[:, 0], 0.0, atol=1e-5)


def test_signs() -> None:
    du, dv = TOWER.disturbance([-5.0, 5.0, 0.0, -5.0, -5.0], [0.0, 0.0, 5.0, 3.0, -3.0], 50.0, 10.0)
    assert du[0] == pytest.approx(-10.0 * (A / 5.0) ** 2)  # slower in front
    assert du[1] == pytest.approx(du[0])  # and behind
    assert du[2] == pytest.approx(10.0 * (A / 5.0) ** 2)  # faster beside
    # upwind of the tower the flow parts: to the left on the left, to the right on the right
    assert dv[3] > 0.0 > dv[4] == pytest.approx(-dv[3])
    np.testing.assert_array_equal(dv[:3], 0.0)


def test_dipole_far_field() -> None:
    def strength(distance: float) -> float:
        theta = np.linspace(0.0, 2.0 * np.pi, 37)
        du, dv = TOWER.disturbance(distance * np.cos(theta), distance * np.sin(theta), 50.0, 10.0)
        size = np.hypot(du, dv)
        assert np.ptp(size) < 1e-12 * size[0]  # the same all round
        return float(size[0])

    assert strength(100.0) == pytest.approx(10.0 * A**2 / 100.0**2)
    assert strength(100.0) / strength(200.0) == pytest.approx(4.0)


def test_mirrored_in_the_wind_direction() -> None:
    rng = np.random.default_rng(3)
    x, y, z = rng.uniform(-9, 9, 50), rng.uniform(-9, 9, 50), rng.uniform(0, 95, 50)
    du, dv = TOWER.disturbance(x, y, z, 10.0)
    du_mirror, dv_mirror = TOWER.disturbance(x, -y, z, 10.0)
    np.testing.assert_array_equal(du_mirror, du)
    np.testing.assert_array_equal(dv_mirror, -dv)


@given(
    st.floats(-np.pi, np.pi), st.floats(-30, 30), st.floats(-30, 30), st.floats(0, 100),
    st.booleans(),
)  # fmt: skip
def test_turns_with_the_wind(turn: float, x: float, y: float, z: float, lateral: bool) -> None:
    tower = TowerShadow(radius=A, top=90.0, lateral=lateral)
    c, s = math.cos(turn), math.sin(turn)
    du, dv = tower.disturbance(x, y, z, 10.0, 0.0)
    turned = tower.disturbance(c * x - s * y, s * x + c * y, z, 10.0 * c, 10.0 * s)
    np.testing.assert_allclose(turned, [c * du - s * dv, s * du + c * dv], atol=1e-10)


def test_without_lateral_the_wind_keeps_its_direction() -> None:
    tower = TowerShadow(radius=A, top=90.0, lateral=False)
    x, y = np.meshgrid([-6.0, -3.0, 1.0], [-4.0, 0.5, 7.0])
    for u, v in [(10.0, 0.0), (6.0, -8.0)]:
        du, dv = tower.disturbance(x, y, 50.0, u, v)
        np.testing.assert_allclose(du * v - dv * u, 0.0, atol=1e-12)
        full_u, full_v = TOWER.disturbance(x, y, 50.0, u, v)
        np.testing.assert_allclose(du * u + dv * v, full_u * u + full_v * v, atol=1e-12)
    np.testing.assert_array_equal(tower.disturbance(x, y, 50.0, 0.0, 0.0), 0.0)  # calm


def test_corrected_formula_of_the_paper() -> None:
    r_t, d_t = 0.93, 5.5
    tower = TowerShadow.below_hub(radius=r_t, hub_height=80.0, lateral=False, smoothing=4.0)
    y = np.linspace(-40.0, 40.0, 81)
    du, dv = tower.disturbance(-d_t, y, 60.0, 13.0)
    np.testing.assert_allclose(
        du, -13.0 * r_t**2 * (d_t**2 - y**2) / (d_t**2 + y**2) ** 2, rtol=1e-13
    )
    np.testing.assert_array_equal(dv, 0.0)


def test_cut_below_hub() -> None:
    tower = TowerShadow.below_hub(radius=1.0, hub_height=80.0, smoothing=4.0)
    np.testing.assert_allclose(
        tower.weight([10.0, 78.0, 79.0, 80.0, 81.0, 82.0, 120.0]),
        [1.0, 1.0, 0.5 + 0.25 * math.sqrt(2), 0.5, 0.5 - 0.25 * math.sqrt(2), 0.0, 0.0],
        atol=1e-15,
    )
    assert TowerShadow.below_hub(radius=1.0, hub_height=80.0).smoothing == 2.0
    sharp = TowerShadow.below_hub(radius=1.0, hub_height=80.0, smoothing=0.0)
    np.testing.assert_array_equal(sharp.weight([79.9, 80.0, 80.0001]), [1.0, 1.0, 0.0])


def test_weight_is_smooth_and_falls() -> None:
    z = np.linspace(80.0, 100.0, 2001)
    weight = TowerShadow(radius=A, top=90.0, smoothing=5.0).weight(z)
    assert weight.max() == 1.0 and weight.min() == 0.0
    assert (np.diff(weight) <= 0.0).all()
    assert np.abs(np.diff(weight, 2)).max() < 1.1 * 0.5 * (math.pi / 5.0) ** 2 * 0.01**2


def aerodyn_factors(x: float, y: float, z: float, radius: float, top: float) -> tuple[float, float]:
    """AeroDyn's baseline potential flow for wind along x: shares of the wind at the tower."""
    if z > top:
        zbar = (z - top) / radius
        if zbar >= 1.0:
            return 0.0, 0.0
        radius *= math.cos(0.5 * math.pi * zbar)
    xbar, ybar = x / radius, y / radius
    square = xbar**2 + ybar**2
    return (ybar**2 - xbar**2) / square**2, -2.0 * xbar * ybar / square**2


@pytest.mark.parametrize("z", [30.0, 60.0, 85.268, 87.6, 88.0, 88.5, 89.5, 89.535, 95.0])
@pytest.mark.parametrize("y", [-12.0, -2.0, 0.0, 4.9])
def test_same_as_aerodyn_on_the_nrel_5mw(y: float, z: float) -> None:
    radius = 0.5 * (6.0 + (3.87 - 6.0) * min(z / 85.268, 1.0))
    expected = aerodyn_factors(-5.0, y, z, radius, 87.6)
    got = NREL.disturbance(-5.0, y, z, 12.0)
    np.testing.assert_allclose(got, 12.0 * np.array(expected), rtol=1e-11, atol=1e-15)


def test_nrel_5mw_magnitudes() -> None:
    assert NREL.smoothing == pytest.approx(1.935)
    np.testing.assert_allclose(NREL.radius_at([0.0, 42.634, 87.6, 99.0]), [3, 2.4675, 1.935, 1.935])
    du, _ = NREL.disturbance(-5.0, 0.0, 30.0, 1.0)
    assert du == pytest.approx(-(((3.0 - 1.065 * 30.0 / 85.268) / 5.0) ** 2))  # 28 % slower


def test_inside_the_tower() -> None:
    theta = np.linspace(0.0, 2.0 * np.pi, 25)
    outer = wind(A * (1 + 1e-9) * np.cos(theta), A * (1 + 1e-9) * np.sin(theta))
    inner = wind(A * (1 - 1e-9) * np.cos(theta), A * (1 - 1e-9) * np.sin(theta))
    np.testing.assert_allclose(inner, outer, atol=1e-6)
    np.testing.assert_array_equal(wind(0.0, 0.0), [10.0, 0.0])
    grid = np.linspace(-A, A, 41)
    du, dv = TOWER.disturbance(grid[:, None], grid, 50.0, 10.0)
    assert np.hypot(du, dv).max() <= 10.0 * (1 + 1e-12)


def test_strength_scales_the_disturbance() -> None:
    half = TowerShadow(radius=A, top=90.0, strength=0.5)
    np.testing.assert_allclose(
        half.disturbance(-4.0, 1.0, 50.0, 10.0),
        0.5 * np.array(TOWER.disturbance(-4.0, 1.0, 50.0, 10.0)),
    )
    off = TowerShadow(radius=A, top=90.0, strength=0.0)
    np.testing.assert_array_equal(off.disturbance(-4.0, 1.0, 50.0, 10.0), 0.0)


def test_apply_adds_to_a_velocity_of_any_shape() -> None:
    velocity = np.random.default_rng(4).normal(10.0, 1.0, (4, 1, 3))
    before = velocity.copy()
    y, z = np.linspace(-3.0, 3.0, 5), np.full(5, 50.0)
    got = TOWER.apply(velocity, -5.0, y, z)
    assert got.shape == (4, 5, 3)
    np.testing.assert_array_equal(velocity, before)
    du, dv = TOWER.disturbance(-5.0, y, z, velocity[..., 0], velocity[..., 1])
    np.testing.assert_array_equal(got[..., 0], velocity[..., 0] + du)
    np.testing.assert_array_equal(got[..., 1], velocity[..., 1] + dv)
    np.testing.assert_array_equal(got[..., 2], np.broadcast_to(velocity[..., 2], (4, 5)))
    with pytest.raises(WindFieldError, match=r"velocity: got shape \(4, 2\)"):
        TOWER.apply(np.zeros((4, 2)), 0.0, 0.0, 0.0)


def test_tables_are_copied_read_only_and_compared_by_value() -> None:
    radius = np.array([3.0, 2.0])
    tower = TowerShadow(radius=radius, height=[0.0, 80.0], top=80.0)
    radius[0] = 99.0
    assert tower.radius_at(0.0) == 3.0
    same = TowerShadow(radius=[3.0, 2.0], height=(0, 80), top=80, smoothing=2.0)
    assert tower == same and hash(tower) == hash(same)
    assert tower != TowerShadow(radius=[3.0, 2.1], height=[0.0, 80.0], top=80.0)
    assert tower != "tower"
    for twin in (pickle.loads(pickle.dumps(tower)), copy.deepcopy(tower)):  # noqa: S301  (our own object)
        assert twin == tower
        with pytest.raises(ValueError, match="read-only"):
            twin.radius[0] = 1.0
    with pytest.raises(ValueError, match="read-only"):
        tower.radius[0] = 1.0


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"radius": 0.0}, r"radius: got 0.0; must be a finite number > 0 \[m\]"),
        ({"radius": -1.0}, "radius: got -1.0"),
        ({"radius": math.nan}, "radius: got nan"),
        ({"radius": "wide"}, "radius: got 'wide'"),
        ({"radius": [2.0, 1.0]}, "radius: got"),
        ({"radius": [2.0, 1.0], "height": [0.0]}, "must be equal, with at least 2"),
        ({"radius": [2.0], "height": [0.0]}, "must be equal, with at least 2"),
        ({"radius": 2.0, "height": [0.0, 1.0]}, r"radius: got shape \(\)"),
        ({"radius": [2.0, 0.0], "height": [0.0, 80.0]}, "radius: got 0; must be > 0"),
        ({"radius": [2.0, math.inf], "height": [0.0, 80.0]}, "radius: got 1 NaN or infinite"),
        ({"radius": [2.0, 1.0], "height": [80.0, 0.0]}, "height: got 0 after 80"),
        ({"radius": [2.0, 1.0], "height": [-1.0, 80.0]}, "height: got -1; must be >= 0"),
        ({"radius": [[2.0], [1.0, 2.0]], "height": [0.0, 80.0]}, "ragged"),
        ({"top": 0.0}, "top: got 0.0"),
        ({"top": math.inf}, "top: got inf"),
        ({"smoothing": -0.1}, "smoothing: got -0.1"),
        ({"strength": -1.0}, "strength: got -1.0"),
    ],
)
def test_bad_input(change: dict[str, object], message: str) -> None:
    with pytest.raises(WindFieldError, match=message):
        TowerShadow(**{"radius": 2.0, "top": 90.0, **change})


def test_smoothing_below_hub_must_fit() -> None:
    with pytest.raises(WindFieldError, match="smoothing: got 20 m; must be below twice hub_height"):
        TowerShadow.below_hub(radius=1.0, hub_height=10.0, smoothing=20.0)
