"""Lightest tower of a given height under frozen loads.

    minimise  ln m(x)   subject to   c_i(x) <= 0,      x = (ln d, ln t),

with the rows c of `pitchopt.studies.tower.constraints`.  In these variables taper, steps of the
wall, slenderness and bounds of the wall are linear, the mass and the largest diameter are
logarithms of sums of exponentials and convex, damage and frequency are nearly linear: they are
monomials of a uniform tower.  Sequential convex programming: each subproblem

    minimise    g' p + p' H p / 2 + nu sum_i s_i
    subject to  c_i + a_i' p <= s_i,   s_i >= 0,   |p_k| <= Delta

is a quadratic program, with H the convex second derivative of ln m and of the largest
diameter's rows.  A model of second order in place of the exact exponentials saves an exponential
cone for each of their terms and loses nothing, as both are renewed at every step.  Violations
weigh nu in the merit ln m + nu sum max(c, 0), so that any start will do; the trust region Delta
follows the ratio of the merit's true and predicted fall.  Where violations stay however large nu
is, no design near keeps all limits.

Method: R. Fletcher, Practical Methods of Optimization, 2nd ed., section 14.4 (exact penalty and
trust region); solver Clarabel.

A multiplier lambda_i >= 0 is that of g_i <= 0 in  m + sum lambda_i g_i:  kilogrammes of the
lightest tower for each unit by which a limit is tightened.
"""

from __future__ import annotations

import time
from dataclasses import dataclass
from typing import Any

import numpy as np

from pitchopt.checks import FloatArray, finite_number, whole_number
from pitchopt.errors import ComputationError, InputError
from pitchopt.studies.tower.constraints import Rows, TowerConstraints, constraint_rows
from pitchopt.studies.tower.design import TowerDesign
from pitchopt.studies.tower.fatigue_loads import FatigueLoads
from pitchopt.studies.tower.frequencies import Frequencies, frequency_curvature, natural_frequencies
from pitchopt.studies.tower.limits import TowerLimits
from pitchopt.turbines import Turbine

__all__ = ["Sizing", "scaled_start", "size_tower"]

_RADIUS, _LARGEST_RADIUS, _LEAST_RADIUS = 0.2, 1.0, 1e-9
_PENALTY, _LARGEST_PENALTY = 3.0, 1e5
_LEAST_LOG = -20.0  # rows further within their limits are as good as absent
_LEAST_MULTIPLIER = 1e-6  # of ln m, whose row bends the Lagrangian
_RIDGE = 1e-6  # curvature where the mass has none


@dataclass(frozen=True, kw_only=True, eq=False)
class Sizing:
    """The lightest tower, or how far the search came.

    Attributes
    ----------
    design : TowerDesign
    mass : float
        [kg].
    status : str
        ``converged``, ``iteration limit`` or ``infeasible``.
    message : str
        In words; of an infeasible problem, which limit is missed most.
    iterations : int
        Subproblems solved.
    seconds : float
    constraints : TowerConstraints
        g, at most zero where kept [-].
    multipliers : TowerConstraints
        [kg]; where infeasible they belong to the penalty and mean nothing.
    frequencies : Frequencies
    error : float
        Largest of violation, stationarity of ln m and complementarity [-].
    limits : TowerLimits
    """

    design: TowerDesign
    mass: float
    status: str
    message: str
    iterations: int
    seconds: float
    constraints: TowerConstraints
    multipliers: TowerConstraints
    frequencies: Frequencies
    error: float
    limits: TowerLimits

    @property
    def converged(self) -> bool:
        """Whether the design is optimal."""
        return self.status == "converged"

    def relative_multipliers(self, reference_mass: float | None = None) -> TowerConstraints:
        """Multipliers over a reference mass [kg], or over the optimal mass."""
        mass = self.mass if reference_mass is None else reference_mass
        return self.multipliers.scaled(1.0 / finite_number("reference_mass", mass, above=0.0))

    def active(self, *, share: float = 1e-4) -> dict[str, list[int]]:
        """Places by group whose multiplier is above this share of the mass."""
        found = {
            name: np.flatnonzero(values > share * self.mass).tolist()
            for name, values in self.multipliers.items()
        }
        return {name: places for name, places in found.items() if places}


def scaled_start(reference: Turbine, hub_height: float, *, elements: int = 10) -> TowerDesign:
    """The reference's own tower stretched to a hub height, with evenly long elements.

    Diameters are those at the nodes; each wall keeps the mass of its element.
    """
    count = whole_number("elements", elements, at_least=1)
    tower = reference.tower
    if tower.thickness is None:
        raise InputError(f"turbine {reference.name!r}: the walls of its tower are not known")
    share = (tower.height - tower.base) / (tower.top - tower.base)
    middle = tower.diameter - tower.thickness
    node = np.linspace(0.0, 1.0, count + 1)
    diameter = np.interp(node, share, middle)
    fine = np.linspace(0.0, 1.0, 200 * count + 1)
    at = 0.5 * (fine[1:] + fine[:-1])
    area = np.interp(at, share, middle) * np.interp(at, share, tower.thickness)
    mean = area.reshape(count, -1).mean(axis=1)
    return TowerDesign(
        hub_height=hub_height,
        diameter=diameter,
        thickness=mean / (0.5 * (diameter[1:] + diameter[:-1])),
        reference=reference,
    )


def size_tower(
    hub_height: float,
    loads: FatigueLoads,
    limits: TowerLimits,
    reference: Turbine,
    start: TowerDesign | None = None,
    *,
    elements: int = 10,
    tolerance: float = 1e-6,
    iterations: int = 100,
) -> Sizing:
    """Lightest tower for frozen loads at a hub height.

    Parameters
    ----------
    hub_height : float
        [m].
    loads : FatigueLoads
    limits : TowerLimits
    reference : Turbine
        What stands on the tower, and its material.
    start : TowerDesign, optional
        Whose diameters and walls the search begins with, whatever its height; the reference's
        own tower, stretched, if absent.
    elements : int
        Number of elements where no start is given.
    tolerance : float
        On violation, stationarity and complementarity, all relative to limits and mass [-].
    iterations : int
        Largest number of subproblems.

    Raises
    ------
    InputError
        If an argument is out of range or the turbine's data do not suffice.
    ComputationError
        If a subproblem cannot be solved.
    """
    begun = time.perf_counter()
    tolerance = finite_number("tolerance", tolerance, above=0.0)
    most = whole_number("iterations", iterations, at_least=1)
    if start is None:
        first = scaled_start(reference, hub_height, elements=elements)
    else:
        first = TowerDesign(
            hub_height=hub_height,
            diameter=start.diameter,
            thickness=start.thickness,
            reference=reference,
        )
    search = _Search(loads, limits, tolerance)
    status, count, state, z, error = search.run(first, most)
    rows = state.rows
    values = rows.gather(rows.value, add=False)
    mass = state.design.mass
    multipliers = rows.gather(z * mass / rows.rate, add=True)
    return Sizing(
        design=state.design,
        mass=mass,
        status=status,
        message=_message(status, values, count, error),
        iterations=count,
        seconds=time.perf_counter() - begun,
        constraints=values,
        multipliers=multipliers,
        frequencies=state.frequencies,
        error=error,
        limits=limits,
    )


def _message(status: str, values: TowerConstraints, count: int, error: float) -> str:
    if status == "converged":
        return f"optimal after {count} steps, error {error:.1e}"
    name, place, value = values.largest
    worst = f"{name} {place} misses its limit by {100.0 * value:.3g} %"
    if status == "infeasible":
        return f"no design near keeps all limits: {worst}"
    return f"stopped after {count} steps with error {error:.1e}; {worst}"


@dataclass(frozen=True, eq=False)
class _State:
    """A design with all that is known of it."""

    design: TowerDesign
    frequencies: Frequencies
    rows: Rows
    x: FloatArray  # (2 E + 1,)
    log: FloatArray  # rows' c, bounded from below

    @property
    def violation(self) -> float:
        return float(np.maximum(self.log, 0.0).sum())

    def merit(self, penalty: float) -> float:
        return float(np.log(self.design.mass)) + penalty * self.violation


class _Search:
    """Sequential quadratic programming with an exact penalty in a trust region."""

    def __init__(self, loads: FatigueLoads, limits: TowerLimits, tolerance: float) -> None:
        self.loads = loads
        self.limits = limits
        self.tolerance = tolerance

    def state(self, design: TowerDesign) -> _State:
        frequencies = natural_frequencies(design)
        rows = constraint_rows(design, self.loads, self.limits, frequencies)
        x = np.log(np.concatenate([design.diameter, design.thickness]))
        return _State(design, frequencies, rows, x, np.maximum(rows.log, _LEAST_LOG))

    def moved(self, state: _State, step: FloatArray) -> _State | None:
        """State a step away; None if that is no tower."""
        values = np.exp(state.x + step)
        count = state.design.elements
        try:
            return self.state(
                TowerDesign(
                    hub_height=state.design.hub_height,
                    diameter=values[: count + 1],
                    thickness=values[count + 1 :],
                    reference=state.design.reference,
                )
            )
        except InputError:
            return None

    def run(self, first: TowerDesign, most: int) -> tuple[str, int, _State, FloatArray, float]:
        """Status, subproblems, last state, multipliers of c, error."""
        state = self.state(first)
        z = np.zeros(state.log.size)
        radius, penalty, error = _RADIUS, _PENALTY, np.inf
        for count in range(1, most + 1):
            gradient, hessian = _mass_model(state.design)
            hessian = _curvature(state, hessian, z)
            step, slack, z = _subproblem(gradient, hessian, state.rows, state.log, radius, penalty)
            error = self._error(gradient, state, z)
            if error <= self.tolerance:
                return "converged", count, state, z, error
            model = gradient @ step + 0.5 * step @ hessian @ step + penalty * slack.sum()
            fall = penalty * state.violation - model
            length = float(np.max(np.abs(step)))
            if fall <= 1e-3 * self.tolerance**1 and slack.sum() > self.tolerance:
                if penalty >= _LARGEST_PENALTY:
                    return "infeasible", count, state, z, error
                penalty *= 10.0
                radius = max(radius, _RADIUS)
                continue
            trial = self.moved(state, step)
            true = -np.inf if trial is None else state.merit(penalty) - trial.merit(penalty)
            if trial is not None and true < 0.75 * fall:
                # once more with the rows' curvature, as the step has met it
                log = trial.log - state.rows.jacobian @ step
                step, _, _ = _subproblem(gradient, hessian, state.rows, log, radius, penalty)
                other = self.moved(state, step)
                if other is not None and other.merit(penalty) < trial.merit(penalty):
                    trial, true = other, state.merit(penalty) - other.merit(penalty)
            if true >= 0.1 * fall - 1e-12:
                assert trial is not None  # its merit is finite
                state = trial
                if true >= 0.75 * fall and length >= 0.99 * radius:
                    radius = min(2.0 * radius, _LARGEST_RADIUS)
            else:
                radius = 0.3 * min(radius, length)
            if radius < _LEAST_RADIUS:
                break
        status = "infeasible" if state.violation > 1e3 * self.tolerance else "iteration limit"
        return (status if count < most else "iteration limit"), count, state, z, error

    def _error(self, gradient: FloatArray, state: _State, z: FloatArray) -> float:
        stationary = np.max(np.abs(gradient + state.rows.jacobian.T @ z))
        slack = np.max(z * np.abs(state.log))
        return float(max(stationary, slack, np.max(state.log)))


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


def _curvature(state: _State, hessian: FloatArray, z: FloatArray) -> FloatArray:
    """Second derivatives of the Lagrangian, made convex.

    To those of the mass come those of the frequencies and of the largest diameter,
    w (1 - w) (1, -1) (1, -1)' in an outer diameter's (ln d, ln t).
    """
    out = hessian.copy()
    rows = state.rows
    for r in np.flatnonzero(z > _LEAST_MULTIPLIER):
        name = rows.name(r)
        if name == "largest_diameter":
            columns = np.flatnonzero(rows.jacobian[r])
            weight = z[r] * rows.jacobian[r, columns].prod()
            out[np.ix_(columns, columns)] += weight * np.array([[1.0, -1.0], [-1.0, 1.0]])
        elif name == "frequency":
            plane, mode = divmod(int(r - np.flatnonzero(rows.group == rows.group[r])[0]), 2)
            out -= z[r] * frequency_curvature(state.design, state.frequencies, plane, mode)
    values, vectors = np.linalg.eigh(out)
    return np.asarray((vectors * np.maximum(values, _RIDGE)) @ vectors.T)


def _subproblem(
    gradient: FloatArray,
    hessian: FloatArray,
    rows: Rows,
    log: FloatArray,
    radius: float,
    penalty: float,
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Step (n,), slacks (K,) and multipliers (R,) of the quadratic program."""
    import clarabel
    from scipy import sparse

    n = gradient.size
    jacobian = rows.jacobian
    # rows that no step within the trust region can break are left out
    keep = np.flatnonzero(log + radius * np.abs(jacobian).sum(axis=1) > -1e-3)
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
    return x[:n], np.maximum(x[n:], 0.0), z
