"""Sequential convex programming for the lightest tower.

    minimise  ln m(x)   subject to   c_i(x) <= 0,      x = (ln d, ln t),

with the rows c of `pitchopt.studies.tower.constraints`.  In these variables taper, steps of the
wall, slenderness and bounds of the wall are linear, the mass and the largest diameter are
logarithms of sums of exponentials and convex, damage and frequency are nearly linear: they are
monomials of a uniform tower.  Each subproblem

    minimise    g' p + p' H p / 2 + nu sum_i s_i
    subject to  c_i + a_i' p <= s_i,   s_i >= 0,   |p_k| <= Delta

is a convex quadratic program, with H the second derivative of the Lagrangian, negative
eigenvalues cut off.  A model of second order in place of the exact exponentials saves an
exponential cone for each of their terms and loses nothing, as both are renewed at every step;
with the curvature of all rows in H the steps converge quadratically.  A step that falls short is
tried again with the rows as it met them (second-order correction).

Violations weigh nu in the merit ln m + nu sum max(c, 0), so that any start will do; the trust
region Delta follows the ratio of the merit's true and predicted fall.  Where violations stay
however large nu is, no design near keeps all limits.

Method: R. Fletcher, Practical Methods of Optimization, 2nd ed., section 14.4 (exact penalty and
trust region); solver Clarabel.
"""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from typing import Any

import numpy as np

from pitchopt.checks import FloatArray
from pitchopt.errors import ComputationError, InputError
from pitchopt.studies.tower.constraints import (
    Rows,
    constraint_rows,
    fatigue_curvature,
    geometry_rows,
)
from pitchopt.studies.tower.design import TowerDesign
from pitchopt.studies.tower.fatigue_loads import FatigueLoads
from pitchopt.studies.tower.frequencies import (
    Frequencies,
    frequency_curvature,
    natural_frequencies,
)
from pitchopt.studies.tower.limits import TowerLimits

__all__ = ["Found", "lightest"]

_RADIUS, _LARGEST_RADIUS, _LEAST_RADIUS = 0.2, 1.0, 1e-9
_PENALTY, _LARGEST_PENALTY = 3.0, 3e4
_LEAST_LOG = -20.0  # rows further within their limits are as good as absent
_LEAST_MULTIPLIER = 1e-6  # of ln m, whose row bends the Lagrangian
_NOISE = 1e-9  # of a row, by rounding in the frequencies
_MISSED = 1e-4  # violation of a search that stalls far from what is allowed
_SHAPING = 8  # steps that bring a start into shape
_RIDGE = 1e-6  # curvature where the mass has none


@dataclass(frozen=True, kw_only=True, eq=False)
class Found:
    """Where a search ended.

    Attributes
    ----------
    status : str
        ``converged``, ``iteration limit`` or ``infeasible``.
    design, frequencies, rows
        The last design and what belongs to it.
    multipliers : ndarray (R,)
        Of the rows c in ln m + sum z_i c_i [-].
    steps : int
        Subproblems solved.
    error : float
        Largest of violation, stationarity and complementarity [-].
    """

    status: str
    design: TowerDesign
    frequencies: Frequencies
    rows: Rows
    multipliers: FloatArray
    steps: int
    error: float


@dataclass(frozen=True, eq=False)
class _State:
    """A design with all that is known of it."""

    design: TowerDesign
    frequencies: Frequencies
    rows: Rows
    x: FloatArray  # (2 E + 1,)
    log: FloatArray  # rows' c, bounded from below
    loads: FatigueLoads
    limits: TowerLimits

    @classmethod
    def of(cls, design: TowerDesign, loads: FatigueLoads, limits: TowerLimits) -> _State:
        frequencies = natural_frequencies(design)
        rows = constraint_rows(design, loads, limits, frequencies)
        x = np.log(np.concatenate([design.diameter, design.thickness]))
        log = np.where(rows.implied, _LEAST_LOG, np.maximum(rows.log, _LEAST_LOG))
        return cls(design, frequencies, rows, x, log, loads, limits)

    def moved(self, step: FloatArray) -> _State | None:
        """State a step away; None if that is no tower."""
        values = np.exp(self.x + step)
        nodes = self.design.diameter.size
        try:
            design = dataclasses.replace(
                self.design, diameter=values[:nodes], thickness=values[nodes:]
            )
            return _State.of(design, self.loads, self.limits)
        except InputError:
            return None

    @property
    def violation(self) -> float:
        return float(np.maximum(self.log, 0.0).sum())

    def merit(self, penalty: float) -> float:
        return float(np.log(self.design.mass)) + penalty * self.violation


def lightest(
    first: TowerDesign,
    loads: FatigueLoads,
    limits: TowerLimits,
    *,
    tolerance: float,
    most: int,
) -> Found:
    """Search from a design, which is brought into shape before.

    Parameters
    ----------
    first : TowerDesign
    loads : FatigueLoads
    limits : TowerLimits
    tolerance : float
        On the error at which the search ends [-].
    most : int
        Largest number of subproblems.

    Raises
    ------
    InputError
        If the design that is begun with buckles under its weights.
    ComputationError
        If a subproblem cannot be solved.
    """
    state = _State.of(_within_geometry(first, limits), loads, limits)
    z = np.zeros(state.log.size)
    radius, penalty, error, steps = _RADIUS, _PENALTY, np.inf, 0
    status = "iteration limit"
    while steps < most:
        steps += 1
        gradient, hessian = _mass_model(state.design)
        hessian = _curvature(state, loads, hessian, z)
        step, z = _subproblem(gradient, hessian, state.rows, state.log, radius, penalty)
        error = _error(gradient, state, z)
        if error <= tolerance:
            status = "converged"
            break
        left = float(np.maximum(state.log + state.rows.jacobian @ step, 0.0).sum())
        model = gradient @ step + 0.5 * step @ hessian @ step + penalty * left
        fall = penalty * state.violation - model
        noise = _NOISE * penalty * (1.0 + state.violation)
        length = float(np.max(np.abs(step)))
        if fall <= noise and left > tolerance:
            if penalty >= _LARGEST_PENALTY:
                status = "infeasible"
                break
            penalty *= 10.0
            radius = max(radius, _RADIUS)
            continue
        trial = state.moved(step)
        true = -np.inf if trial is None else state.merit(penalty) - trial.merit(penalty)
        if trial is not None and true < 0.75 * fall:
            log = trial.log - state.rows.jacobian @ step
            step, _ = _subproblem(gradient, hessian, state.rows, log, radius, penalty)
            other = state.moved(step)
            if other is not None and other.merit(penalty) < trial.merit(penalty):
                trial, true = other, state.merit(penalty) - other.merit(penalty)
        if trial is not None and true >= 0.1 * fall - noise:
            state = trial
            if true >= 0.75 * fall and length >= 0.99 * radius:
                radius = min(2.0 * radius, _LARGEST_RADIUS)
        else:
            radius = 0.3 * min(radius, length)
        if radius < _LEAST_RADIUS:
            status = "infeasible" if state.violation > _MISSED else status
            break
    return Found(
        status=status,
        design=state.design,
        frequencies=state.frequencies,
        rows=state.rows,
        multipliers=z,
        steps=steps,
        error=error,
    )


def _error(gradient: FloatArray, state: _State, z: FloatArray) -> float:
    stationary = np.max(np.abs(gradient + state.rows.jacobian.T @ z))
    slack = np.max(z * np.abs(state.log))
    return float(max(stationary, slack, np.max(state.log)))


def _within_geometry(design: TowerDesign, limits: TowerLimits) -> TowerDesign:
    """Near a design, one that keeps the limits of its shape, or nearly."""
    size = 2 * design.elements + 1
    for _ in range(_SHAPING):
        rows = geometry_rows(design, limits)
        log = np.where(rows.implied, _LEAST_LOG, rows.log)
        if log.max() <= 1e-6:
            break
        step, _ = _subproblem(np.zeros(size), np.eye(size), rows, log, 2.0, 1e3)
        values = np.exp(step)
        design = dataclasses.replace(
            design,
            diameter=design.diameter * values[: design.elements + 1],
            thickness=design.thickness * values[design.elements + 1 :],
        )
    return design


def _mass_model(design: TowerDesign) -> tuple[FloatArray, FloatArray]:
    """Gradient and Hessian of ln m by (ln d, ln t)."""
    count = design.elements
    e = np.arange(count)
    terms = np.zeros((2 * count, 2 * count + 1))
    terms[np.arange(2 * count), np.concatenate([e, e + 1])] = 1.0
    terms[np.arange(2 * count), count + 1 + np.concatenate([e, e])] = 1.0
    share = np.concatenate(
        [design.thickness * design.diameter[:-1], design.thickness * design.diameter[1:]]
    )
    share /= share.sum()
    gradient = share @ terms
    hessian = (terms * share[:, None]).T @ terms - np.outer(gradient, gradient)
    return gradient, hessian


def _curvature(
    state: _State, loads: FatigueLoads, hessian: FloatArray, z: FloatArray
) -> FloatArray:
    """Second derivatives of the Lagrangian made convex, those of the mass given.

    A row of the largest diameter has w (1 - w) (1, -1) (1, -1)' in its (ln d, ln t).
    """
    out = hessian.copy()
    rows = state.rows
    z = np.where(z > _LEAST_MULTIPLIER, z, 0.0)
    out += fatigue_curvature(state.design, loads, z[rows.of("fatigue")])
    for r in rows.of("largest_diameter")[z[rows.of("largest_diameter")] > 0.0]:
        columns = np.flatnonzero(rows.jacobian[r])
        weight = z[r] * rows.jacobian[r, columns].prod()
        out[np.ix_(columns, columns)] += weight * np.array([[1.0, -1.0], [-1.0, 1.0]])
    for k, weight in enumerate(z[rows.of("frequency")]):
        if weight > 0.0:
            plane, mode = divmod(k, 2)
            out -= weight * frequency_curvature(state.design, state.frequencies, plane, mode)
    values, vectors = np.linalg.eigh(out)
    return np.asarray((vectors * np.maximum(values, _RIDGE)) @ vectors.T)


def _subproblem(
    gradient: FloatArray,
    hessian: FloatArray,
    rows: Rows,
    log: FloatArray,
    radius: float,
    penalty: float,
) -> tuple[FloatArray, FloatArray]:
    """Step (n,) and multipliers (R,) of the quadratic program."""
    import clarabel
    from scipy import sparse

    n = gradient.size
    jacobian = rows.jacobian
    # rows that no step within the trust region can break are left out
    reach = radius * np.abs(jacobian).sum(axis=1)
    keep = np.flatnonzero(~rows.implied & (log + reach > -1e-3))
    count = keep.size
    unit = np.eye(n)
    matrix = sparse.csc_matrix(
        np.block(
            [
                [jacobian[keep], -np.eye(count)],
                [np.zeros((count, n)), -np.eye(count)],
                [unit, np.zeros((n, count))],
                [-unit, np.zeros((n, count))],
            ]
        )
    )
    rhs = np.concatenate([-log[keep], np.zeros(count), np.full(2 * n, radius)])
    quadratic = np.zeros((n + count, n + count))
    quadratic[:n, :n] = np.triu(hessian)
    settings: Any = clarabel.DefaultSettings()
    settings.verbose = False
    settings.presolve_enable = False
    settings.max_threads = 1
    settings.tol_gap_abs = settings.tol_gap_rel = settings.tol_feas = 1e-9
    result = clarabel.DefaultSolver(
        sparse.csc_matrix(quadratic),
        np.concatenate([gradient, np.full(count, penalty)]),
        matrix,
        rhs,
        [clarabel.NonnegativeConeT(rhs.size)],
        settings,
    ).solve()
    if str(result.status) not in ("Solved", "AlmostSolved"):
        raise ComputationError(f"sizing of the tower: subproblem ended with {result.status}")
    x, dual = np.asarray(result.x), np.asarray(result.z)
    z = np.zeros(log.size)
    z[keep] = np.maximum(dual[:count], 0.0)
    return x[:n], z
