"""Parts of the compiled loop: its functions, momentum balance, wind and elimination."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.optimize import brentq

from pitchopt.aero.induction import axial_induction, loss_factor
from pitchopt.errors import InputError
from pitchopt.sim import DynamicTurbine, TurbineRun
from pitchopt.sim.kernels_balance import ACCEPT, balance, loss, newton_step
from pitchopt.sim.kernels_math import angle, falling, sine_cosine
from pitchopt.sim.kernels_planes import element_planes, polar_rows
from pitchopt.sim.kernels_wind import table, wind_velocity
from pitchopt.sim.wind import Reach, wind_tables
from windfield import PowerLaw, StaticField, TurbulentField
from windfield.boxes import PolarBox, TurbulenceBox

OUTER, INNER, THETA = 0.6, 2.0, 0.05


def test_elementary_functions() -> None:
    x = np.linspace(-math.pi / 2, math.pi / 2, 2001)
    sine, cosine = np.array([sine_cosine(v) for v in x]).T
    np.testing.assert_allclose(sine, np.sin(x), rtol=0, atol=1e-15)
    np.testing.assert_allclose(cosine, np.cos(x), rtol=0, atol=1e-15)
    x = np.linspace(0.0, 24.0, 2001)
    fall = np.array([falling(v) for v in x])
    np.testing.assert_allclose(fall[x <= 12], np.exp(-x[x <= 12]), rtol=5e-14)
    np.testing.assert_allclose(fall, np.exp(-x), rtol=5e-10)
    assert falling(1e300) == falling(24.0)
    turn = np.linspace(-math.pi, math.pi, 2001)[1:]
    found = np.array([angle(3.0 * math.sin(v), 3.0 * math.cos(v)) for v in turn])
    np.testing.assert_allclose(found[:-1], turn[:-1], rtol=0, atol=5e-14)
    assert abs(found[-1]) == pytest.approx(math.pi)
    assert angle(0.0, 0.0) == 0.0


def test_loss_factor_and_its_derivative() -> None:
    for phi in np.linspace(0.04, 1.5, 60):
        s, c = math.sin(phi), math.cos(phi)
        factor, fall = loss(OUTER, INNER, s, c)
        # beyond an exponent of 24 the factor of the loop is 1
        assert factor == pytest.approx(float(loss_factor(s, OUTER, INNER)), rel=5e-11)
        h = 1e-5
        low, _ = loss(OUTER, INNER, math.sin(phi - h), math.cos(phi - h))
        high, _ = loss(OUTER, INNER, math.sin(phi + h), math.cos(phi + h))
        assert fall == pytest.approx((high - low) / (2 * h) / factor, rel=1e-5, abs=1e-8)
    assert loss(1e-13, 1e-13, 0.5, 0.5) == (1e-4, 0.0)


def polar() -> np.ndarray:
    """A straight lift curve, so that the root is smooth."""
    alpha = np.array([-math.pi, -0.5, 0.5, math.pi])
    lift = np.array([0.0, -2.4, 3.6, 0.0])
    return polar_rows(alpha, lift, 0.01 + 0.0 * alpha, 0.0 * alpha)


def solved(x: float, theta: float, solidity: float, start: float):
    counts = np.zeros(3, dtype=np.int64)
    out = balance(polar(), 0, 5, 0, OUTER, INNER, start, 10.0 * x, 10.0, theta, solidity, counts)
    return out, counts


@pytest.mark.parametrize(
    ("x", "solidity", "heavy"),
    [
        (0.15, 0.02, False),
        (0.6, 0.05, False),
        (0.12, 0.03, True),
        (0.2, 0.07, True),
        (0.3, 0.1, True),
    ],
)
def test_balance_against_a_bracketed_root(x: float, solidity: float, heavy: bool) -> None:
    def terms(phi: float) -> tuple[float, float, float]:
        s, c = math.sin(phi), math.cos(phi)
        lift = 0.6 + 6.0 * (phi - THETA)
        common = solidity * lift / (4.0 * float(loss_factor(s, OUTER, INNER)) * s)
        kappa, swirl = common * c / s, common * s / c
        a = float(axial_induction(kappa, loss_factor(s, OUTER, INNER)))
        return s / (1.0 - a) - x * c * (1.0 - swirl), a, swirl / (1.0 - swirl)

    exact = brentq(lambda phi: terms(phi)[0], 1e-3, 1.5, xtol=1e-15)
    _, a, tangential = terms(exact)
    assert (a > 0.4) is heavy  # Buhl's parabola
    # from far: brackets or several steps; then from near, where one step does
    far, counts = solved(x, THETA, solidity, -1.0)
    assert counts[2] == 1
    near, counts = solved(x, THETA, solidity, exact * (1.0 + 1e-4))
    assert list(counts[[0, 2]]) == [1, 0]
    for found, tolerance in ((far, 1e-9), (near, 1e-6)):
        assert found[0] == pytest.approx(exact, rel=tolerance)
        assert found[1] == pytest.approx(a, rel=tolerance, abs=tolerance)
        assert found[2] == pytest.approx(tangential, rel=tolerance, abs=tolerance)


@pytest.mark.parametrize(("x", "solidity"), [(0.15, 0.02), (0.2, 0.07)])
def test_derivatives_of_the_root(x: float, solidity: float) -> None:
    phi = solved(x, THETA, solidity, -1.0)[0][0]
    _, _, _, by_x, by_theta, _ = solved(x, THETA, solidity, phi)[0]
    h = 1e-5
    high, low = (solved(x + d, THETA, solidity, -1.0)[0][0] for d in (h, -h))
    assert by_x == pytest.approx((high - low) / (2 * h), rel=1e-6)
    high, low = (solved(x, THETA + d, solidity, -1.0)[0][0] for d in (h, -h))
    assert by_theta == pytest.approx((high - low) / (2 * h), rel=1e-6)


def test_accepted_step_is_of_second_order() -> None:
    """The error left by one accepted step is far below what it corrected."""
    x, solidity = 0.2, 0.07
    phi, a, *_ = solved(x, THETA, solidity, -1.0)[0]
    at = phi + ACCEPT * math.sin(phi)
    s, c = math.sin(at), math.cos(at)
    factor, fall = loss(OUTER, INNER, s, c)
    change, moved, _, _, _, good = newton_step(
        s, c, x, 0.6 + 6.0 * (at - THETA), 6.0, factor, fall, solidity
    )
    assert good
    assert abs(at + change - phi) < 0.02 * ACCEPT * math.sin(phi)
    assert abs(moved - a) < 1e-4


def test_table() -> None:
    values = np.array([1.0, 3.0, 2.0])
    for at in (-5.0, 0.0, 0.3, 1.0, 1.7, 2.0, 9.0):
        assert table(values, 0.0, 1.0, at) == pytest.approx(np.interp(at, [0, 1, 2], values))
    assert table(np.array([4.0]), 0.0, 1.0, 0.5) == 4.0
    assert table(values, 0.0, 1.0, math.nan) != table(values, 0.0, 1.0, 0.5)  # and no crash


def boxes():
    rng = np.random.default_rng(3)
    grid = {"spacing": 2.5, "mean_speed": 10.0, "label": "noise"}
    y, z = np.linspace(-70.0, 70.0, 6), np.linspace(20.0, 160.0, 7)
    spokes = rng.normal(size=(9, 5, 8, 3)).astype(np.float32)
    spokes[:, 0] = spokes[:, :1, :1].reshape(9, 1, 3)
    rings = np.linspace(0.0, 80.0, 5)
    noise = rng.normal(size=(9, 6, 7, 3)).astype(np.float32)
    return {
        "periodic": TurbulenceBox(velocity=noise, y=y, z=z, periodic=True, **grid),
        "once": TurbulenceBox(velocity=noise, y=y, z=z, periodic=False, offset=4.0, **grid),
        "polar": PolarBox(velocity=spokes, radius=rings, centre_height=90.0, periodic=True, **grid),
    }


@pytest.mark.parametrize("name", ["periodic", "once", "polar"])
def test_wind_of_a_box(name: str) -> None:
    mean = StaticField(speed=10.0, hub_height=90.0, vertical=PowerLaw(exponent=0.2), direction=0.1)
    field = TurbulentField(mean=mean, box=boxes()[name])
    tables = wind_tables(
        field, Reach(low=25.0, high=155.0, half_width=65.0, upwind=5.0, downwind=5.0)
    )
    rng = np.random.default_rng(1)
    longest = 0.15 if name == "once" else 30.0
    for _ in range(200):
        x, t = rng.uniform(-2.0, 2.0), rng.uniform(0.0, longest)
        radius, psi = 60.0 * math.sqrt(rng.uniform()), rng.uniform(0.0, 2 * math.pi)
        y, z = radius * math.sin(psi), 90.0 + radius * math.cos(psi)
        np.testing.assert_allclose(
            wind_velocity(tables, x, y, z, t), field.velocity(x, y, z, t), rtol=0, atol=2e-4
        )


def test_wind_far_outside_reads_nothing_outside_the_box() -> None:
    for box in boxes().values():
        field = TurbulentField(mean=StaticField(speed=10.0, hub_height=90.0), box=box)
        tables = wind_tables(
            field, Reach(low=25.0, high=155.0, half_width=65.0, upwind=5.0, downwind=5.0)
        )
        for bad in (1e300, -1e300, math.nan, math.inf):
            wind_velocity(tables, bad, bad, bad, 1.0)


@pytest.mark.parametrize("still", [(), (0,), (3,), (4, 7), (2, 5)])
def test_elimination_against_a_dense_solver(nrel, still: tuple[int, ...]) -> None:
    from pitchopt.sim.kernels_motion import solve

    run = TurbineRun(
        DynamicTurbine(turbine=nrel, step=0.025),
        StaticField(speed=10.0, hub_height=90.0),
        rotor_speed=1.0,
    )
    rng = np.random.default_rng(0)
    active = np.ones(10, dtype=np.int64)
    active[list(still)] = 0
    body = run.model.body._replace(active=active)
    full = np.diag(rng.uniform(5.0, 9.0, 10)) * 1e6
    for i in range(3):
        for j in [*range(i), *range(4, 10)]:
            full[i, j] = full[j, i] = 1e5 * rng.normal()
    full[2, 3] = full[3, 2] = 4e5
    for k in range(3):
        full[4 + 2 * k, 5 + 2 * k] = full[5 + 2 * k, 4 + 2 * k] = 1e6
    for i in still:
        full[i, :], full[:, i] = 0.0, 0.0
        full[i, i] = 1.0
    right, q, v = 1e6 * rng.normal(size=10), rng.normal(size=10), rng.normal(size=10)
    stiffness, damping = np.zeros((2, 10, 10))
    for matrix, tower, shaft, blade in (
        (stiffness, body.tower_stiffness, body.shaft_stiffness, body.stiffness),
        (damping, body.tower_damping, body.shaft_damping, body.damping),
    ):
        matrix[[0, 1], [0, 1]] = tower
        matrix[3, 3] = shaft
        for k in range(3):
            matrix[4 + 2 * k : 6 + 2 * k, 4 + 2 * k : 6 + 2 * k] = blade
    h = 0.05
    on = active == 1
    left = full + np.outer(on, on) * (0.25 * h * h * stiffness + 0.5 * h * damping)
    exact = np.linalg.solve(left, on * (right - stiffness @ q - damping @ v))
    run.work.motion.matrix[:], run.work.motion.right[:] = full, right
    found = np.empty(10)
    assert solve(body, run.work.motion, q, v, h, found)
    np.testing.assert_allclose(found, exact, rtol=1e-9, atol=1e-12 * abs(exact).max())
    run.work.motion.matrix[:] = full
    run.work.motion.matrix[1, 1] = -1e12
    if 1 not in still:
        assert not solve(body, run.work.motion, q, v, h, found)


def test_too_many_stations() -> None:
    row, block = np.ones(140), np.ones((140, 2, 2))
    names = ("span", "chord", "twist", "prebend", "sweep", "width", "lever", "outer", "inner")
    blocks = ("shape", "slope", "shortening", "weight")
    with pytest.raises(InputError, match="140 stations on each of 3 blades, expected at most 128"):
        element_planes(
            blades=3,
            hub_radius=1.0,
            **dict.fromkeys(names, row),
            **dict.fromkeys(blocks, block),
        )
