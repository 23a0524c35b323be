"""The step's quadratic program: optimality conditions, another solver, special cases."""

from __future__ import annotations

from typing import Any

import clarabel
import numpy as np
import pytest
import scipy.sparse as sp
from hypothesis import given, settings
from hypothesis import strategies as st

from ilc import ActuatorLimits, Layout
from ilc.adaptive import harmonic_basis
from ilc.program import Quadratic, StepProgram

CASES = [(3, 24), (3, 5), (2, 7), (4, 3), (1, 9), (3, 1), (2, 1), (1, 2)]


def problem(seed: int, layout: Layout, step: float = 0.01) -> Any:
    """A random quadratic, a profile in use and the limits of the next one."""
    random = np.random.default_rng(seed)
    positions, variables = layout.tracked, layout.variables
    limits = ActuatorLimits(lower=-0.1, upper=0.4, step=step)
    current = np.full(variables, 0.1)
    for passage in range(3):
        wish = current + 0.05 * random.normal(size=variables)
        current = limits.projected(layout, wish, current, passage)
    slopes = random.normal(size=(4, positions, layout.blades))
    price = 10 ** random.uniform(-1, 2, 4)
    quadratic = Quadratic(
        blocks=np.einsum("l,lpb,lpc->pbc", price, slopes, slopes),
        squares=slopes * np.sqrt(price / positions)[:, None, None],
        signs=np.array([1.0, -1.0, -1.0, -1.0]),
        slope=0.5 * random.normal(size=(positions, layout.blades)),
    )
    return quadratic, current, *limits.bounds(layout, current, 3)


def dense(layout: Layout, quadratic: Quadratic) -> tuple[np.ndarray, np.ndarray]:
    """H and g written out."""
    size, index = layout.variables, layout.index
    hessian, slope = np.zeros((size, size)), np.zeros(size)
    for block, row in zip(quadratic.blocks, index, strict=True):
        hessian[np.ix_(row, row)] += block
    for square, sign in zip(quadratic.squares, quadratic.signs, strict=True):
        flat = np.zeros(size)
        flat[index] = square
        hessian += sign * np.outer(flat, flat)
    slope[index] = quadratic.slope
    return hessian, slope


def rows(layout: Layout, step: float, current: Any, low: Any, high: Any) -> Any:
    """The limits as A x <= b."""
    one = np.eye(layout.variables)
    tie = one[layout.ahead] - one
    ahead = tie @ current
    return np.vstack([one, -one, tie, -tie]), np.concatenate(
        [high - current, current - low, step - ahead, step + ahead]
    )


def other_solver(hessian: Any, slope: Any, left: Any, right: Any) -> np.ndarray:
    options = clarabel.DefaultSettings()
    options.verbose = False
    options.tol_gap_abs = options.tol_gap_rel = options.tol_feas = 1e-11
    cones = [clarabel.NonnegativeConeT(right.size)]
    upper = sp.triu(sp.csc_matrix(hessian)).tocsc()
    solver = clarabel.DefaultSolver(upper, slope, sp.csc_matrix(left), right, cones, options)
    return np.array(solver.solve().x)


@pytest.mark.parametrize("separate", [False, True])
@pytest.mark.parametrize(("blades", "positions"), CASES)
@pytest.mark.parametrize("seed", [0, 1])
def test_same_value_as_another_solver(
    blades: int, positions: int, separate: bool, seed: int
) -> None:
    layout = Layout(blades=blades, positions=positions, separate=separate)
    quadratic, current, low, high = problem(seed, layout)
    found = StepProgram(layout, 0.01).solve(quadratic, current, low, high)
    hessian, slope = dense(layout, quadratic)
    left, right = rows(layout, 0.01, current, low, high)
    theirs = other_solver(hessian + 1e-10 * np.eye(slope.size), slope, left, right)

    def value(x: np.ndarray) -> float:
        return float(0.5 * x @ hessian @ x + slope @ x)

    assert np.max(left @ found - right) < 1e-9
    assert value(found) == pytest.approx(value(theirs), rel=1e-6, abs=1e-10)


@pytest.mark.parametrize("separate", [False, True])
def test_optimality_conditions(separate: bool) -> None:
    """The gradient is a combination of active limits with multipliers of the right sign."""
    layout = Layout(blades=3, positions=6, separate=separate)
    quadratic, current, low, high = problem(4, layout)
    found = StepProgram(layout, 0.01).solve(quadratic, current, low, high)
    hessian, slope = dense(layout, quadratic)
    left, right = rows(layout, 0.01, current, low, high)
    active = left @ found - right > -1e-4  # slack times multiplier is 1e-9: near is near enough
    assert 3 < active.sum() < layout.variables
    gradient = hessian @ found + slope
    from scipy.optimize import nnls

    _, misfit = nnls(left[active].T, -gradient, maxiter=1000)
    assert misfit < 1e-4 * np.linalg.norm(slope)


@given(seed=st.integers(0, 10_000), step=st.sampled_from([1e-4, 0.01, 1.0]), cut=st.booleans())
@settings(max_examples=40, deadline=None)
def test_limits_hold_and_nothing_is_lost(seed: int, step: float, cut: bool) -> None:
    layout = Layout(blades=3, positions=4)
    quadratic, current, low, high = problem(seed, layout, step)
    if cut:
        quadratic = quadratic._replace(slope=1e6 * quadratic.slope)
    found = StepProgram(layout, step).solve(quadratic, current, low, high)
    left, right = rows(layout, step, current, low, high)
    assert np.max(left @ found - right) < 1e-8
    hessian, slope = dense(layout, quadratic)
    assert 0.5 * found @ hessian @ found + slope @ found <= 1e-9  # not worse than no change


def test_free_program_is_a_linear_system() -> None:
    layout = Layout(blades=3, positions=4)
    quadratic, current, *_ = problem(2, layout)
    hessian, slope = dense(layout, quadratic)
    wanted = -np.linalg.solve(hessian, slope)
    wide = np.full(layout.variables, 3 * np.abs(wanted).max())
    found = StepProgram(layout, wide[0]).solve(quadratic, current, -wide, wide)
    np.testing.assert_allclose(found, wanted, rtol=1e-4, atol=1e-4 * wide[0])


def test_nothing_to_gain_changes_nothing() -> None:
    layout = Layout(blades=3, positions=4)
    quadratic, current, low, high = problem(2, layout)
    quadratic = quadratic._replace(slope=np.zeros_like(quadratic.slope))
    assert not StepProgram(layout, 0.01).solve(quadratic, current, low, high).any()


def test_no_room_changes_nothing() -> None:
    layout = Layout(blades=3, positions=4)
    quadratic, current, _, _ = problem(2, layout)
    assert not StepProgram(layout, 0.01).solve(quadratic, current, current, current).any()


@pytest.mark.parametrize("separate", [False, True])
@pytest.mark.parametrize("harmonics", [1, 3])
def test_basis(separate: bool, harmonics: int) -> None:
    """Changes lie in the basis, and no other change there is better."""
    layout = Layout(blades=3, positions=8, separate=separate)
    quadratic, _, low, high = problem(5, layout)
    basis = harmonic_basis(layout, harmonics)
    np.testing.assert_allclose(basis.T @ basis, np.eye(basis.shape[1]), atol=1e-12)
    current = np.full(layout.variables, 0.1)
    low, high = np.full_like(low, 0.06), np.full_like(high, 0.14)
    found = StepProgram(layout, 0.01, basis).solve(quadratic, current, low, high)
    np.testing.assert_allclose(basis @ (basis.T @ found), found, atol=1e-12)
    hessian, slope = dense(layout, quadratic)
    left, right = rows(layout, 0.01, current, low, high)
    theirs = other_solver(basis.T @ hessian @ basis, basis.T @ slope, left @ basis, right)
    best = 0.5 * theirs @ (basis.T @ hessian @ basis) @ theirs + basis.T @ slope @ theirs
    assert 0.5 * found @ hessian @ found + slope @ found == pytest.approx(best, rel=1e-6)
    assert np.max(left @ found - right) < 1e-9
