"""The convex-hull relaxation: each station's curve replaced by the hull of its breakpoints.

    beta_n = sum_j theta_nj b_nj,  load_ln = sum_j theta_nj load_l(b_nj),  theta >= 0, sum_j = 1,

a second-order cone program whose value bounds the design problem, and whose pitch is a start
that no constant profile reaches.  It is solved by column generation: a few breakpoints per
station, the multipliers of that program, the exact bound of :mod:`pitchopt.design.certificate`
over *all* breakpoints, whose maximisers enter next.  Every round yields a valid bound; the
rounds end when it meets the value of the program.  With many rotor positions the multipliers of
every s-th of them (:mod:`pitchopt.design.coarse`) choose the first columns.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pitchopt.design.certificate import lagrangian_bound, projected
from pitchopt.design.coarse import interpolated, stride, widened
from pitchopt.design.cones import ConeProgram
from pitchopt.design.multipliers import Multipliers
from pitchopt.design.problem import DesignProblem, Objective

__all__ = ["HullSolution", "Relaxation", "relax", "solve_hull"]

FloatArray = NDArray[np.float64]
BoolArray = NDArray[np.bool_]

_LITTLE = 1e-3  # of the gap to the profile's value; what is not worth another round
_SPARSE = 40  # breakpoints in all for each one that columns are taken away from the best
_FIRST_COLUMNS = 7  # breakpoints per station in the first round, evenly spaced


@dataclass(frozen=True, kw_only=True, eq=False)
class Relaxation:
    """Bound, its multipliers, and the pitch that the relaxed weights imply."""

    upper_bound: float
    multipliers: Multipliers
    profile: FloatArray
    rounds: int
    closed: bool


@dataclass(frozen=True, kw_only=True, eq=False)
class HullSolution:
    """The relaxed optimum on given columns.

    Attributes
    ----------
    value : float
        As the solver has it [N m]; no bound.
    multipliers : Multipliers
        As the solver has them, not yet projected.
    profile : ndarray (N,)
        Pitch that the weights imply [rad].
    infeasible : bool
        True when the columns admit no profile inside the limits: the multipliers are then a ray
        along which the bound falls without end, and value and profile mean nothing.
    """

    value: float
    multipliers: Multipliers
    profile: FloatArray
    infeasible: bool


def relax(
    problem: DesignProblem,
    objective: Objective,
    *,
    profile: FloatArray | None = None,
    rounds: int = 12,
    tolerance: float = 1e-5,
) -> Relaxation | None:
    """Solve the hull relaxation and bound the design problem.

    Parameters
    ----------
    problem, objective
        As in :func:`pitchopt.design.scp.solve_local`; harmonics are left out (the bound of the
        wider problem).
    profile : array (N,), optional
        A good profile; the breakpoints around it are among the first columns.
    rounds : int
        At most this many rounds of column generation.
    tolerance : float
        Bound minus relaxed value, as a share of the largest mean torque, that ends it.  So does
        a thousandth of the gap between the bound and the profile's value.

    Returns
    -------
    Relaxation or None
        None when the cone solver failed in the first round; a failure later ends the rounds.
    """
    curves = problem.curves
    n, k = curves.beta.shape
    scale = problem.torque_scale
    active = np.zeros((n, k), dtype=bool)
    best = _from_coarse(problem, objective, profile, rounds, tolerance, active)
    spread = min(_FIRST_COLUMNS, k) if best is None else 2
    active[:, np.unique(np.linspace(0, k - 1, spread).astype(int))] = True
    rows, known = np.arange(n), None
    if profile is not None:
        j = curves.segment(profile)
        active[rows, j] = active[rows, j + 1] = True
        known = problem.value(profile, objective)
    for count in range(1, rounds + 1):
        station, column = np.nonzero(active)
        solved = solve_hull(
            problem,
            objective,
            station,
            curves.beta[station, column],
            curves.loads[:, station, column],
        )
        if solved is None or solved.infeasible:
            break
        value, mult, implied = solved.value, solved.multipliers, solved.profile
        mult = projected(problem, objective, mult)
        bound, values = lagrangian_bound(problem, objective, mult)
        if best is None or bound < best.upper_bound:
            best = Relaxation(
                upper_bound=bound, multipliers=mult, profile=implied, rounds=count, closed=False
            )
        # what the relaxation of all columns may still be below the bound
        left = best.upper_bound - value
        if left <= tolerance * scale:
            best = replace(best, closed=True)
            break
        if known is not None and left <= _LITTLE * (best.upper_bound - known):
            break
        top = values.max(axis=1)
        current = np.where(active, values, -np.inf).max(axis=1)
        if not _enlarge(active, values, top - current > 1e-9 * scale / n):
            break
    return best


def _from_coarse(
    problem: DesignProblem,
    objective: Objective,
    profile: FloatArray | None,
    rounds: int,
    tolerance: float,
    active: BoolArray,
) -> Relaxation | None:
    """The bound at multipliers from fewer rotor positions; its maximisers become active.

    Multipliers are smooth over azimuth, so that theirs are nearly the best ones here.
    """
    if problem.coarse is None:
        return None
    step = stride(problem.curves.positions)
    start = None if profile is None else profile[::step]
    coarse = relax(problem.coarse, objective, profile=start, rounds=rounds, tolerance=tolerance)
    if coarse is None:
        return None
    mult = projected(problem, objective, widened(coarse.multipliers, step))
    bound, values = lagrangian_bound(problem, objective, mult)
    _enlarge(active, values, np.ones(active.shape[0], dtype=bool))
    return Relaxation(
        upper_bound=bound,
        multipliers=mult,
        profile=interpolated(coarse.profile, step),
        rounds=0,
        closed=False,
    )


def _enlarge(active: BoolArray, values: FloatArray, wanting: BoolArray) -> bool:
    """Add breakpoints at and around each wanting station's best; True if any was new.

    Where breakpoints are many, some farther ones join the next ones: the best moves on by more
    than one breakpoint from round to round.
    """
    before = int(active.sum())
    rows = np.flatnonzero(wanting)
    best = values[rows].argmax(axis=1)
    last = values.shape[1] - 1
    reach = [1, *(far for far in (3, 10, 40) if _SPARSE * far < last)]
    for shift in (0, *reach, *(-far for far in reach)):
        active[rows, np.clip(best + shift, 0, last)] = True
    return int(active.sum()) > before


def solve_hull(
    problem: DesignProblem,
    objective: Objective,
    station: NDArray[np.intp],
    pitch: FloatArray,
    loads: FloatArray,
    means: FloatArray | None = None,
    *,
    tolerance: float | None = None,
) -> HullSolution | None:
    """The relaxation on given columns.

    Parameters
    ----------
    problem, objective
        The limits and the prices; the curves give sizes and pitch-rate terms only.
    station : int array (C,)
        Station of each column, in rising order, every station at least once.
    pitch : array (C,)
        Pitch of each column [rad].
    loads : array (5, C)
        The five loads there.
    means : array (4, 2), optional
        Lowest and highest mean of torque, tilt, yaw and thrust over the positions; infinite
        where a mean is free.
    tolerance : float, optional
        Relative accuracy; the multipliers of a rough solution bound the problem as well.

    Returns
    -------
    HullSolution or None
        None when the cone solver failed.
    """
    curves, scale = problem.curves, problem.torque_scale
    n_stations, m = curves.stations, curves.positions
    deviations = loads - loads.mean(axis=1, keepdims=True)  # RMS values see no constant
    theta = np.arange(station.size)
    position = station % m
    lam, rates = objective.lambdas, curves.rates
    half = 0.5 / curves.spacing
    has_rates = bool(np.any(rates))

    program = ConeProgram()
    torque = loads[0] / m
    if has_rates:
        folded = (np.roll(rates[0], 1) - np.roll(rates[0], -1)) * half / m
        torque = torque + folded[station] * pitch
    program.variables("theta", station.size, cost=-objective.torque * torque / scale)
    cones = [q for q in range(5) if lam[q] > 0 or (q == 4 and np.isfinite(objective.blade_cap))]
    spread = {}
    for q in cones:
        size = float(np.abs(loads[q]).max())
        std = float(deviations[q].std()) * np.sqrt(curves.blades)
        spread[q] = std if std > 1e-9 * size else size or 1.0
    for q in cones:
        program.variables(f"s{q}", 1, cost=lam[q] * spread[q] / scale)
        program.variables(f"mean{q}", 1)
    if objective.travel > 0:
        program.variables("u", n_stations, cost=objective.travel / scale)
    program.zero(np.ones(n_stations), (station, theta, 1.0))
    mean_block = None
    if curves.mean_pitch is not None:
        mean_block = program.zero(np.array([curves.mean_pitch]), (0, theta, pitch / n_stations))
    program.nonneg(np.zeros(station.size), (theta, theta, -1.0))
    index = np.arange(n_stations)
    beta = program.variables("beta", n_stations).start + index
    program.zero(np.zeros(n_stations), (station, theta, pitch), (index, beta, -1.0))
    following = beta[(index + 1) % n_stations]
    rate_blocks = [
        program.nonneg(
            np.full(n_stations, problem.step), (index, following, sign), (index, beta, -sign)
        )
        for sign in (1.0, -1.0)
    ]
    single: dict[str, slice] = {}
    if np.isfinite(objective.torque_min):
        single["min"] = program.nonneg(
            np.array([-objective.torque_min / scale]), (0, theta, -torque / scale)
        )
    if np.isfinite(objective.torque_max):
        single["max"] = program.nonneg(
            np.array([objective.torque_max / scale]), (0, theta, torque / scale)
        )
    if np.isfinite(objective.blade_cap):
        single["cap"] = program.nonneg(
            np.array([objective.blade_cap / spread[4]]), (0, program.at["s4"].start, 1.0)
        )
    travel_blocks: list[slice] = []
    if objective.travel > 0:
        travel_blocks = [
            program.nonneg(
                np.zeros(n_stations),
                (index, following, sign),
                (index, beta, -sign),
                (index, program.at["u"].start + index, -1.0),
            )
            for sign in (1.0, -1.0)
        ]
    boxes: list[tuple[int, float, slice, float]] = []
    for q in range(4) if means is not None else ():
        assert means is not None
        mean = loads[q] / m
        if has_rates:
            mean = mean + ((np.roll(rates[q], 1) - np.roll(rates[q], -1)) * half / m)[station] * (
                pitch
            )
        centre = float(mean.mean())
        for sign, limit in ((1.0, means[q, 1]), (-1.0, means[q, 0])):
            if np.isfinite(limit):
                unit = float(np.abs(mean - centre).max()) or 1.0
                room = np.array([sign * (limit - n_stations * centre) / unit])
                rows = program.nonneg(room, (0, theta, sign * (mean - centre) / unit))
                boxes.append((q, sign, rows, unit))
    blocks: dict[int, slice] = {}
    for q in cones:
        size, at = (n_stations, station) if q == 4 else (m, position)
        weight = 1.0 / (np.sqrt(size) * spread[q])
        entries: list[tuple[Any, Any, Any]] = [
            (0, program.at[f"s{q}"].start, -1.0),
            (1 + at, theta, -deviations[q] * weight),
            (1 + np.arange(size), program.at[f"mean{q}"].start, 1.0 / np.sqrt(size)),
        ]
        if has_rates:
            before, after = (station - 1) % n_stations, (station + 1) % n_stations
            for other, sign in ((before, 1.0), (after, -1.0)):
                where = other if q == 4 else other % m
                entries.append((1 + where, theta, -sign * rates[q][other] * half * pitch * weight))
        blocks[q] = program.second_order(np.zeros(1 + size), *entries)

    solution = program.solve(tolerance=tolerance)
    if not solution.solved and not solution.infeasible:
        solution = program.solve(reduced=True)
    if not solution.solved and not solution.infeasible:
        return None
    x, z = solution.x, solution.z * scale
    y_loads, y_blade = np.zeros((4, m)), np.zeros(n_stations)
    for q in cones:
        y = -z[blocks[q].start + 1 : blocks[q].stop] / (
            np.sqrt(n_stations if q == 4 else m) * spread[q]
        )
        if q == 4:
            y_blade = y
        else:
            y_loads[q] = y
    w = z[rate_blocks[0]] - z[rate_blocks[1]]
    if travel_blocks:
        w = w + z[travel_blocks[0]] - z[travel_blocks[1]]
    box = np.zeros(4)
    for q, sign, rows, unit in boxes:
        box[q] += sign * float(z[rows][0]) / unit
    mult = Multipliers(
        loads=y_loads,
        blade=y_blade,
        rate=w,
        torque_min=float(z[single["min"]][0]) / scale if "min" in single else 0.0,
        torque_max=float(z[single["max"]][0]) / scale if "max" in single else 0.0,
        cap=float(z[single["cap"]][0]) / spread[4] if "cap" in single else 0.0,
        mean=float(z[mean_block][0]) if mean_block is not None else 0.0,
        box=box,
    )
    implied = np.zeros(n_stations)
    np.add.at(implied, station, x[theta] * pitch)
    return HullSolution(
        value=-float(program.cost @ x) * scale,
        multipliers=mult,
        profile=implied,
        infeasible=solution.infeasible,
    )
