"""Upper bounds on joint problems, from multipliers alone, and multipliers that make them tight.

Take any shares q_w (the weights p_w themselves, or numbers of 0 or more that sum to one for the
largest regret), for each wind multipliers y_w, nu_w, eta_w as in
:mod:`pitchopt.design.certificate` with q_w a_w and q_w lambda_w in place of a and lambda, any
cyclic w_sn of the rates and any v_sn of the changes between profiles.  Then

    UB = sum over (s, n) of max over beta of [ sum over winds w of s of bracket_wn(beta)
             + (w_sn - w_s,n-1 + v_sn - v_s-1,n) beta ]
         + sum_s D_s sum_n max(|w_sn| - kappa_s, 0) + C sum |v_sn|
         + sum_w (terms of its limits) - sum_w q_w V*_w,        kappa_s = sum over w of q_w kappa_w,

bounds the joint objective: the weighted sum is at most this by weak duality, and

    - max_w (V*_w - V_w) <= sum_w q_w (V_w - V*_w)

reduces the largest regret to a weighted sum.  Every bracket is piecewise linear in one angle,
with its kinks at the breakpoints of its own wind, so their sum has its maximum at a breakpoint
of one of them and the evaluation is exact but for rounding, which is moved outward.

With the dual in this form, good multipliers solve the cone program that minimises UB, its maxima
replaced by a few breakpoints for each station; the maximisers of the exact UB enter next and
those without a share in the optimum leave.  UB is convex in the multipliers, so that it is also
tried between the best and the new ones, which calms the swing from round to round.  The program's
optimum is the value of the convex hull relaxation of all winds together, which is at most the
sum of their own.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pitchopt.design.certificate import constant_terms, projected, station_values
from pitchopt.design.cones import ConeProgram
from pitchopt.design.joint import JointMultipliers, JointProblem
from pitchopt.design.multipliers import Multipliers
from pitchopt.design.problem import Objective

__all__ = ["JointBound", "joint_bound", "joint_lagrangian"]

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.intp]

_ROUNDING = 64.0 * np.finfo(np.float64).eps
_LEAST_STEP = 1e-9  # [rad]
_FIRST_POINTS = 7  # pitches per station in the first round, evenly spaced
_MIXED = (1.0, 0.75, 0.5, 0.25)  # shares of the new multipliers that are tried
_USED = 1e-2  # share of a pitch in the relaxed optimum below which it is left out again
_ACCURACY = 1e-6  # of the cone program; its multipliers bound at any accuracy
_LITTLE = 0.02  # of the gap to the value of the profiles; what is not worth another round


@dataclass(frozen=True, kw_only=True, eq=False)
class JointBound:
    """Bound on the joint objective [N m], the multipliers that prove it, rounds used."""

    upper_bound: float
    multipliers: JointMultipliers
    rounds: int
    closed: bool


def joint_lagrangian(
    joint: JointProblem, mult: JointMultipliers
) -> tuple[float, FloatArray, FloatArray]:
    """Upper bound on the joint objective of all feasible profiles, and where its maxima stand.

    Parameters
    ----------
    joint : JointProblem
    mult : JointMultipliers
        Any numbers at all; they are projected first, so that the result is always a bound.

    Returns
    -------
    bound : float
        Rounded outward [N m].
    grid, total : ndarray (S N, K)
        Breakpoints of all winds of every station [rad] and the sum of the brackets there [N m],
        for pricing; padded by infinity and minus infinity.
    """
    shares = _shares(joint, mult.shares)
    grid, last = joint.breakpoints(0.0)
    inside = np.arange(grid.shape[1]) <= last[:, None] + 1
    total = np.zeros(grid.shape)
    constants: list[float] = []
    size = 0.0
    for w, (problem, s) in enumerate(zip(joint.problems, joint.profile_of, strict=True)):
        curves = problem.curves
        objective = _scaled(joint.objectives[w], float(shares[w]))
        own = projected(problem, objective, replace(mult.winds[w], rate=np.zeros(curves.stations)))
        values = station_values(problem, objective, own)
        for n in range(curves.stations):
            i = s * curves.stations + n
            k = last[i] + 2
            total[i, :k] += np.interp(grid[i, :k], curves.beta[n], values[n])
        constants += constant_terms(problem, objective, own).tolist()
        if joint.targets is not None:
            constants.append(-float(shares[w] * joint.targets[w]))
        size += _size(joint, w, objective, own)
    rate, link = np.asarray(mult.rate, dtype=float), np.asarray(mult.link, dtype=float)
    linear = rate - np.roll(rate, 1, axis=1)
    linear[:-1] += link
    linear[1:] -= link
    pitch = np.where(inside, grid, 0.0)
    total = np.where(inside, total + linear.reshape(-1, 1) * pitch, -np.inf)
    for s, row in enumerate(rate):
        travel = sum(float(shares[w]) * joint.objectives[w].travel for w in joint.followers(s))
        constants.append(joint.steps[s] * float(np.sum(np.maximum(np.abs(row) - travel, 0.0))))
    if np.any(link):
        constants.append(joint.change * float(np.sum(np.abs(link))))
    size += float(np.sum(np.abs(linear).ravel() * np.abs(pitch).max(axis=1)))
    size += float(np.sum(np.abs(constants)))
    bound = float(np.sum(total.max(axis=1)) + np.sum(constants))
    count = grid.shape[0] * len(joint.problems)
    return bound + _ROUNDING * np.sqrt(count) * size, grid, total


def _shares(joint: JointProblem, shares: FloatArray) -> FloatArray:
    """Shares that the bound holds for: the weights, or a convex combination."""
    if joint.weights is not None:
        return joint.weights
    shares = np.maximum(np.nan_to_num(shares), 0.0)
    if not shares.sum() > 0:
        shares = np.ones(shares.size)
    return np.asarray(shares / shares.sum())


def _scaled(objective: Objective, share: float) -> Objective:
    """The objective with prices times a share; travel is counted once for each profile."""
    a, b, c, d, e = (share * price for price in objective.rms)
    return replace(objective, torque=share * objective.torque, rms=(a, b, c, d, e), travel=0.0)


def _size(joint: JointProblem, w: int, objective: Objective, mult: Multipliers) -> float:
    """Sum of the sizes of all terms that one wind brings in, for the rounding."""
    curves = joint.problems[w].curves
    y = np.abs(np.concatenate([np.tile(mult.loads, (1, curves.blades)), mult.blade[None]]))
    gain = objective.torque + mult.torque_min + mult.torque_max
    size = gain / curves.positions * float(np.sum(np.max(np.abs(curves.torque), axis=1)))
    size += float(np.sum(y * np.max(np.abs(curves.loads), axis=2)))
    if np.any(curves.rates):
        rate = gain / curves.positions * np.abs(curves.rates[0])
        rate = rate + np.sum(y * np.abs(curves.rates), axis=0)
        reach = float(np.max(np.abs(curves.beta[:, [0, -1]])))
        size += float(np.sum(rate)) * reach / curves.spacing
    return size


def joint_bound(
    joint: JointProblem,
    beta: FloatArray,
    *,
    multipliers: JointMultipliers | None = None,
    rounds: int = 12,
    tolerance: float = 1e-4,
) -> JointBound:
    """Bound a joint problem, near the value of its hull relaxation.

    Parameters
    ----------
    joint : JointProblem
        Harmonics are left out (the bound of the wider problem).
    beta : array (S N,)
        Good profiles; the breakpoints around them are always among the points.
    multipliers : JointMultipliers, optional
        Those of the last subproblem, none at all by default: a bound by themselves, should the
        cone solver fail.
    rounds : int
        At most this many rounds.
    tolerance : float
        Bound less the value of the cone program, as a share of torque, that ends them.  So does
        a fiftieth of the gap between the bound and the profiles' value.

    Returns
    -------
    JointBound
    """
    multipliers = joint.no_multipliers if multipliers is None else multipliers
    bound, grid, total = joint_lagrangian(joint, multipliers)
    best = JointBound(upper_bound=bound, multipliers=multipliers, rounds=0, closed=False)
    rows, last = np.arange(grid.shape[0]), np.isfinite(total).sum(axis=1) - 1
    known = joint.total(joint.values(beta))
    scale = max(problem.torque_scale for problem in joint.problems)
    always = np.zeros(grid.shape, dtype=bool)
    for share in np.linspace(0.0, 1.0, _FIRST_POINTS):
        always[rows, np.rint(share * last).astype(np.intp)] = True
    below = np.clip(np.sum(grid <= beta[:, None], axis=1) - 1, 0, last - 1)
    always[rows, below] = always[rows, below + 1] = True
    active = always.copy()
    for count in range(1, rounds + 1):
        station, column = np.nonzero(active)
        solved = _minimise(joint, station, grid[station, column], scale)
        if solved is None:
            break
        value, mult, used = solved
        active = always.copy()
        active[station[used > _USED], column[used > _USED]] = True
        # the bound is convex: between the best multipliers and the new ones it is often lower
        centre, least = best.multipliers, np.inf
        maxima: list[IntArray] = []
        for share in _MIXED if count > 1 else _MIXED[:1]:
            between = _mixed(centre, mult, share)
            bound, _, total = joint_lagrangian(joint, between)
            if bound < least:  # the new ones come first and always bring their maxima
                least, maxima = bound, [*maxima[:1], total.argmax(axis=1)]
            if bound < best.upper_bound:
                best = JointBound(
                    upper_bound=bound, multipliers=between, rounds=count, closed=False
                )
        left = best.upper_bound - value
        if left <= tolerance * scale:
            return replace(best, closed=True)
        if left <= _LITTLE * (best.upper_bound - known):
            break
        for at in maxima:
            for shift in (-1, 0, 1):
                active[rows, np.clip(at + shift, 0, last)] = True
    return best


def _mixed(one: JointMultipliers, two: JointMultipliers, share: float) -> JointMultipliers:
    """Multipliers between two, a share of the second."""

    def mix(a: Any, b: Any) -> Any:
        return (1.0 - share) * a + share * b

    names = ("loads", "blade", "torque_min", "torque_max", "cap")
    return JointMultipliers(
        shares=mix(one.shares, two.shares),
        winds=tuple(
            replace(b, **{name: mix(getattr(a, name), getattr(b, name)) for name in names})
            for a, b in zip(one.winds, two.winds, strict=True)
        ),
        rate=mix(one.rate, two.rate),
        link=mix(one.link, two.link),
        basis=two.basis,
    )


def _minimise(
    joint: JointProblem, station: IntArray, pitch: FloatArray, scale: float
) -> tuple[float, JointMultipliers, FloatArray] | None:
    """Least UB over multipliers with the maxima taken over some pitches of each station.

    Returns
    -------
    value : float
        UB with those maxima [N m]; no bound.
    multipliers : JointMultipliers
    share : ndarray
        Of each pitch in the relaxed optimum of its station, 0 to 1.
    """
    n, count, winds = joint.stations, joint.count, len(joint.problems)
    index = np.arange(count * n)
    program = ConeProgram()
    t = program.variables("t", index.size, cost=1.0).start
    w = program.variables("w", index.size).start
    # a price of zero would leave the multipliers of the rate without a limit
    price = np.maximum(np.repeat(joint.steps, n), _LEAST_STEP)
    excess = program.variables("excess", index.size, cost=price).start
    q = -1
    if joint.weights is None:
        assert joint.targets is not None
        # V* of about the same size each: their mean is taken out and put back at the end
        q = program.variables(
            "q", winds, cost=-(joint.targets - joint.targets.mean()) / scale
        ).start
    linked = bool(np.isfinite(joint.change)) and count > 1
    v = over = -1
    if linked:
        v = program.variables("v", index.size - n).start
        price = np.full(index.size - n, joint.change)
        over = program.variables("over", index.size - n, cost=price).start
    duals = [_WindDual(program, joint, k, -1 if q < 0 else q + k, scale) for k in range(winds)]
    if q >= 0:
        program.zero(np.ones(1), (np.zeros(winds, dtype=np.intp), q + np.arange(winds), 1.0))
        program.nonneg(np.zeros(winds), (np.arange(winds), q + np.arange(winds), -1.0))
    for sign in (1.0, -1.0):  # excess_n >= |w_n| - kappa
        entries: list[tuple[Any, Any, Any]] = [
            (index, w + index, sign),
            (index, excess + index, -1.0),
        ]
        kappa = np.zeros(index.size)
        for k, objective in enumerate(joint.objectives):
            mine = joint.profile_of[k] * n + np.arange(n)
            if objective.travel > 0 and joint.weights is None:
                entries.append((mine, np.full(n, q + k), -objective.travel / scale))
            elif joint.weights is not None:
                kappa[mine] += joint.weights[k] * objective.travel / scale
        program.nonneg(kappa, *entries)
        if linked:
            k_ = np.arange(index.size - n)
            program.nonneg(np.zeros(k_.size), (k_, v + k_, sign), (k_, over + k_, -1.0))
    program.nonneg(np.zeros(index.size), (index, excess + index, -1.0))
    # bracket(beta) - t <= 0 at every point
    row = np.arange(station.size)
    before = station - station % n + (station - 1) % n
    rows: list[tuple[Any, Any, Any]] = [
        (row, t + station, -1.0),
        (row, w + station, pitch),
        (row, w + before, -pitch),
    ]
    if linked:
        has, had = station < index.size - n, station >= n
        rows += [
            (row[has], v + station[has], pitch[has]),
            (row[had], v + station[had] - n, -pitch[had]),
        ]
    rhs = np.zeros(station.size)
    for dual in duals:
        bracket, fixed, where = dual.entries(station, pitch)
        rows += bracket
        rhs[where] -= fixed
    brackets = program.nonneg(rhs, *rows)
    for dual in duals:
        dual.cones(program)
    solution = program.solve(tolerance=_ACCURACY)
    if not solution.solved:
        solution = program.solve(reduced=True)
    if not solution.solved:
        return None
    x = solution.x
    shares = joint.weights if joint.weights is not None else x[q : q + winds]
    mult = JointMultipliers(
        shares=shares,
        winds=tuple(dual.multipliers(x) for dual in duals),
        rate=scale * joint.split(x[w : w + index.size]),
        link=scale * x[v : v + index.size - n].reshape(count - 1, n)
        if linked
        else np.zeros((count - 1, n)),
        basis=np.zeros((count, n)),
    )
    value = program.value(x) * scale + sum(dual.constant for dual in duals)
    if joint.targets is not None:
        value -= float(joint.targets.mean())
    return value, mult, solution.z[brackets]


class _WindDual:
    """Multipliers of one wind as variables: y in units of 1 / sqrt(m), nu, eta."""

    def __init__(
        self, program: ConeProgram, joint: JointProblem, number: int, q: int, scale: float
    ) -> None:
        self.problem, self.objective = joint.problems[number], joint.objectives[number]
        self.first = joint.profile_of[number] * joint.stations
        self.q, self.scale = q, scale
        self.share = 1.0 if joint.weights is None else float(joint.weights[number])
        curves, objective = self.problem.curves, self.objective
        self.sizes = np.where(np.arange(5) == 4, curves.stations, curves.positions)
        capped = np.isfinite(objective.blade_cap)
        prices = self.share * objective.lambdas
        self.loads = [k for k in range(5) if prices[k] > 0 or (k == 4 and capped)]
        self.y = {k: program.variables(f"y{k}", int(self.sizes[k])).start for k in self.loads}
        self.single: dict[str, int] = {}
        for name, limit, sign in (
            ("min", objective.torque_min, -1.0),
            ("max", objective.torque_max, 1.0),
            ("cap", objective.blade_cap, 1.0),
        ):
            if np.isfinite(limit):
                self.single[name] = program.variables(name, 1, cost=sign * limit / scale).start
        self.constant = 0.0

    def entries(
        self, station: IntArray, pitch: FloatArray
    ) -> tuple[list[tuple[Any, Any, Any]], FloatArray, IntArray]:
        """Entries of the bracket's rows, what stands in them without a variable, and its rows."""
        curves, objective = self.problem.curves, self.objective
        n, m = curves.stations, curves.positions
        row = np.flatnonzero((station >= self.first) & (station < self.first + n))
        station, pitch = station[row] - self.first, pitch[row]
        count = np.bincount(station, minlength=n)
        column = np.arange(row.size) - np.repeat(np.cumsum(count) - count, count)
        padded = np.zeros((n, int(count.max())))
        padded[station, column] = pitch
        j = curves.segment(padded)[station, column]
        slopes = curves.slopes[:, station, j]
        loads = curves.loads[:, station, j] + slopes * (pitch - curves.beta[station, j])
        # RMS values see no constant: what all stations have is left out
        centred = loads - loads.mean(axis=1, keepdims=True)
        half = 0.5 / curves.spacing
        before, after = (station - 1) % n, (station + 1) % n
        torque = loads[0] / m
        if np.any(curves.rates[0]):
            torque = torque + (curves.rates[0][before] - curves.rates[0][after]) * half * pitch / m
        torque = torque / self.scale
        entries: list[tuple[Any, Any, Any]] = []
        fixed = np.zeros(row.size)
        if self.q < 0:
            fixed = self.share * objective.torque * torque
        elif objective.torque > 0:
            entries.append((row, np.full(row.size, self.q), objective.torque * torque))
        for name, sign in (("min", 1.0), ("max", -1.0)):
            if name in self.single:
                entries.append((row, np.full(row.size, self.single[name]), sign * torque))
        for k in self.loads:
            unit = self.scale * np.sqrt(self.sizes[k])
            at = self.y[k] + station % self.sizes[k]
            entries.append((row, at, -centred[k] / unit))
            if np.any(curves.rates[k]):
                for other, sign in ((before, -1.0), (after, 1.0)):
                    at = self.y[k] + other % self.sizes[k]
                    share = sign * curves.rates[k][other] * half * pitch / unit
                    entries.append((row, at, share))
        return entries, fixed, row

    def cones(self, program: ConeProgram) -> None:
        """Zero mean and norm of every y, signs of the multipliers of limits."""
        zero = np.zeros(1, dtype=np.intp)
        for k, start in self.y.items():
            size = int(self.sizes[k])
            inside = np.arange(size)
            program.zero(np.zeros(1), (np.zeros(size, dtype=np.intp), start + inside, 1.0))
            price = float(self.objective.lambdas[k])
            rhs = np.zeros(1 + size)
            entries: list[tuple[Any, Any, Any]] = [(1 + inside, start + inside, -1.0)]
            if self.q < 0:
                rhs[0] = self.share * price
            elif price > 0:
                entries.append((zero, np.array([self.q]), -price))
            if k == 4 and "cap" in self.single:
                entries.append((zero, np.array([self.single["cap"]]), -1.0))
            program.second_order(rhs, *entries)
        for column in self.single.values():
            program.nonneg(np.zeros(1), (zero, np.array([column]), -1.0))

    def multipliers(self, x: FloatArray) -> Multipliers:
        """Multipliers of the wind in a solution."""
        curves = self.problem.curves
        loads, blade = np.zeros((4, curves.positions)), np.zeros(curves.stations)
        for k, start in self.y.items():
            y = x[start : start + self.sizes[k]] / np.sqrt(self.sizes[k])
            if k == 4:
                blade = y
            else:
                loads[k] = y
        single = {name: float(x[column]) for name, column in self.single.items()}
        return Multipliers(
            loads=loads,
            blade=blade,
            rate=np.zeros(curves.stations),
            torque_min=single.get("min", 0.0),
            torque_max=single.get("max", 0.0),
            cap=single.get("cap", 0.0),
        )
