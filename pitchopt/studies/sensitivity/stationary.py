"""Multipliers of a pitch design that was found: the last convex subproblem, solved once more.

The last subproblem of a local solve stands on one segment of each station, and a row of its box
may be a segment's end, a trust region or the actuator's range.  Its multipliers do not tell.
Here the subproblem is posed once more at the converged profile beta*, with both segments that
meet there: with moves up and down p, q >= 0 of every station,

    beta_n = beta*_n + p_n - q_n,    load_ln = load_ln(beta*_n) + right_ln p_n - left_ln q_n,

right and left the slopes of the segments above and below.  It is the convex hull of the curves
around beta*, as far as the next breakpoints.  If it gains nothing over the design, the design
solves it, and its multipliers satisfy

    g torque_n' / m - sum_l y_ln load_ln' + w_n - w_{n-1} - (mean, harmonics) = r_n,

r_n = 0 at stations free to move, with the slopes weighted (1 - theta_n) left + theta_n right; r_n
>= 0 only at the upper end of what limits leave, r_n <= 0 only at the lower.  theta_n are the
multipliers of the two lines that meet in a kink, and r_n those of the range.  Both are taken from
the curves' own slopes, not from the solver, so that what is left is a residual that can be
reported.  g is the price of mean torque, y_l the prices of loads (norm at most lambda_l / sqrt(m),
also where the design holds a load flat and J_l is zero), w those of the rate.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pitchopt.checks import FloatArray
from pitchopt.design.cones import ConeProgram
from pitchopt.design.multipliers import Multipliers
from pitchopt.design.problem import DesignProblem, Objective
from pitchopt.errors import ComputationError

__all__ = ["REACH", "Stationary", "stationary"]

REACH = 2e-6
"""Breakpoints and limits nearer than this count as touched [rad]; local solves stop as near."""
_UNIT = 1e-3  # [rad], the size of a move in the program
_LEAST_SPREAD = 0.02  # of a load, below which its unit does not fall


@dataclass(frozen=True, kw_only=True, eq=False)
class Stationary:
    """Multipliers at a profile, and how well they satisfy the conditions.

    Attributes
    ----------
    multipliers : Multipliers
        Of loads, torque limits, cap, mean, harmonics; ``rate`` without the price of travel.
    torque_price : float
        g: a + torque_min - torque_max [-].
    rate_up, rate_down : ndarray (N,)
        Multipliers of +/-(beta_{n+1} - beta_n) <= D, 0 or more [N m/rad].
    travel : ndarray (N,)
        Price of travel of each change of pitch, of either sign [N m/rad].
    lower, upper : ndarray (N,)
        Multipliers of the ends of the pitch range at each station, 0 or more [N m/rad].
    theta : ndarray (N,)
        Weight of the segment above, 1 - theta of the one below [-].
    at_kink : bool ndarray (N,)
        Stations at a breakpoint inside their range.
    left, right : ndarray (5, N)
        Slopes of the five loads below and above.
    residual : ndarray (N,)
        What stationarity misses at each station [N m/rad].
    scale : float
        Largest size of a single term of the stationarity conditions [N m/rad].
    value : float
        z: the objective of the design [N m].
    gain : float
        What the convex subproblem promises over the design [N m]; 0 for a stationary one.
    """

    multipliers: Multipliers
    torque_price: float
    rate_up: FloatArray
    rate_down: FloatArray
    travel: FloatArray
    lower: FloatArray
    upper: FloatArray
    theta: FloatArray
    at_kink: NDArray[np.bool_]
    left: FloatArray
    right: FloatArray
    residual: FloatArray
    scale: float
    value: float
    gain: float

    @property
    def prices(self) -> FloatArray:
        """y of the five loads at every station, (5, N) [-]."""
        mult = self.multipliers
        turns = self.theta.size // mult.loads.shape[1]
        return np.concatenate([np.tile(mult.loads, (1, turns)), mult.blade[None]])

    @property
    def worst(self) -> float:
        """Largest residual as a share of the largest term."""
        return float(np.max(np.abs(self.residual))) / self.scale


@dataclass(frozen=True, kw_only=True, eq=False)
class _Neighbours:
    """Slopes and room on both sides of every station."""

    left: FloatArray
    right: FloatArray
    down: FloatArray
    up: FloatArray
    at_bottom: NDArray[np.bool_]
    at_top: NDArray[np.bool_]
    at_kink: NDArray[np.bool_]


def _neighbours(problem: DesignProblem, profile: FloatArray) -> _Neighbours:
    curves = problem.curves
    rows = np.arange(curves.stations)
    below = curves.segment(profile - REACH)
    above = curves.segment(profile + REACH)
    return _Neighbours(
        left=curves.slopes[:, rows, below],
        right=curves.slopes[:, rows, above],
        down=np.maximum(profile - curves.beta[rows, below], 0.0),
        up=np.maximum(curves.beta[rows, above + 1] - profile, 0.0),
        at_bottom=profile - curves.lower <= REACH,
        at_top=curves.upper - profile <= REACH,
        at_kink=above > below,
    )


def stationary(problem: DesignProblem, objective: Objective, profile: FloatArray) -> Stationary:
    """Multipliers of the design problem at a profile that solves it locally.

    Parameters
    ----------
    problem, objective
        As in :func:`pitchopt.design.scp.solve_local`.
    profile : array (N,)
        A converged profile [rad].

    Raises
    ------
    ComputationError
        If the cone solver fails.
    """
    return _Local(problem, objective, np.asarray(profile, dtype=np.float64)).solve()


class _Local:
    """The convex subproblem around a profile, with both neighbouring segments."""

    def __init__(self, problem: DesignProblem, objective: Objective, profile: FloatArray) -> None:
        self.problem, self.objective, self.profile = problem, objective, profile
        self.curves = problem.curves
        self.near = _neighbours(problem, profile)
        self.loads = self.curves.evaluate(profile)
        self.index = np.arange(profile.size)
        self.program = ConeProgram()
        self.single: dict[str, slice] = {}
        self.unit_torque = max(
            float(np.mean(np.abs(self.near.right[0]) + np.abs(self.near.left[0]))) * _UNIT, 1e-300
        )

    # ---- the program -------------------------------------------------------------------------

    def _moves(self, row: NDArray[np.intp], right: FloatArray, left: FloatArray) -> list:
        """Entries of a sum over stations of right p - left q."""
        return [(row, self.p + self.index, right * _UNIT), (row, self.q + self.index, -left * _UNIT)]

    def _shifted(self, row: NDArray[np.intp], factor: FloatArray, shift: int) -> list:
        """Entries of factor_n (move of station n + shift)."""
        other = np.roll(self.index, -shift)
        return [(row, self.p + other, factor * _UNIT), (row, self.q + other, -factor * _UNIT)]

    def solve(self) -> Stationary:
        problem, objective, curves, near = self.problem, self.objective, self.curves, self.near
        program, idx, n, m = self.program, self.index, self.profile.size, self.curves.positions
        self.p = program.variables("up", n).start
        self.q = program.variables("down", n).start
        half = 0.5 / curves.spacing
        folded = (np.roll(curves.rates[0], 1) - np.roll(curves.rates[0], -1)) * half / m
        right, left = near.right[0] / m + folded, near.left[0] / m + folded
        a = objective.torque
        program.add_cost(self.p + idx, -a * right * _UNIT)
        program.add_cost(self.q + idx, a * left * _UNIT)
        loads = [
            k for k in range(5)
            if objective.lambdas[k] > 0 or (k == 4 and np.isfinite(objective.blade_cap))
        ]
        values = [*self.loads.rotor, self.loads.bending]
        units, spread = {}, {}
        for k in loads:
            change = float(np.sqrt(np.mean(near.right[k] ** 2 + near.left[k] ** 2))) * _UNIT
            units[k] = max(change, _LEAST_SPREAD * float(values[k].std())) or 1.0
            spread[k] = program.variables(f"s{k}", 1).start
            program.variables(f"mean{k}", 1)
            program.add_cost(np.array([spread[k]]), np.array([objective.lambdas[k] * units[k]]))
        if objective.travel > 0:
            travel = program.variables("u", n, cost=objective.travel * _UNIT).start
        for start, room in ((self.p, near.up), (self.q, near.down)):
            program.nonneg(np.zeros(n), (idx, start + idx, -1.0))
            program.nonneg(room / _UNIT, (idx, start + idx, 1.0))
        one = np.full(n, 1.0 / _UNIT)
        mean = basis = None
        if curves.mean_pitch is not None:
            gap = (curves.mean_pitch - float(self.profile.mean())) * n / _UNIT
            mean = program.zero(np.array([gap]), *self._shifted(np.zeros(n, dtype=np.intp), one, 0))
        if problem.basis is not None:
            wide = problem.basis.shape[1]
            f = program.variables("fourier", wide).start
            column = np.tile(f + np.arange(wide), n)
            basis = program.zero(
                np.zeros(n),
                *self._shifted(idx, one, 0),
                (np.repeat(idx, wide), column, -problem.basis.ravel()),
            )
        change = np.roll(self.profile, -1) - self.profile
        rates = []
        for sign in (1.0, -1.0):
            room = np.maximum(problem.step - sign * change, 0.0) / _UNIT
            rates.append(
                program.nonneg(
                    room, *self._shifted(idx, sign * one, 1), *self._shifted(idx, -sign * one, 0)
                )
            )
        travels = []
        if objective.travel > 0:
            travels = [
                program.nonneg(
                    -sign * change / _UNIT,
                    *self._shifted(idx, sign * one, 1),
                    *self._shifted(idx, -sign * one, 0),
                    (idx, travel + idx, -1.0),
                )
                for sign in (1.0, -1.0)
            ]
        torque = float(self.loads.mean[0])
        zero = np.zeros(n, dtype=np.intp)
        for name, sign, limit in (
            ("min", -1.0, objective.torque_min),
            ("max", 1.0, objective.torque_max),
        ):
            if np.isfinite(limit):
                room = max(sign * (limit - torque), 0.0) / self.unit_torque
                entries = self._moves(
                    zero, sign * right / self.unit_torque, sign * left / self.unit_torque
                )
                self.single[name] = program.nonneg(np.array([room]), *entries)
        if np.isfinite(objective.blade_cap):
            cap = max(objective.blade_cap, self.loads.blade_rms) / units[4]
            self.single["cap"] = program.nonneg(np.array([cap]), (0, spread[4], 1.0))
        cones = {}
        for k in loads:
            residual = values[k] - values[k].mean()
            weight = 1.0 / (np.sqrt(residual.size) * units[k])
            at = 1 + (idx if k == 4 else idx % m)
            entries = [
                (0, spread[k], -1.0),
                *self._moves(at, -near.right[k] * weight, -near.left[k] * weight),
                (1 + np.arange(residual.size), spread[k] + 1, 1.0 / np.sqrt(residual.size)),
            ]
            if np.any(curves.rates):
                share = curves.rates[k] * (half * weight)
                entries += [*self._shifted(at, -share, 1), *self._shifted(at, share, -1)]
            cones[k] = program.second_order(np.concatenate([[0.0], residual * weight]), *entries)
        solution = program.solve(tolerance=1e-10)
        if not solution.solved:
            solution = program.solve(reduced=True)
        if not solution.solved:
            raise ComputationError(
                f"multipliers: the cone solver ended with {solution.status} at the converged profile"
            )
        z = solution.z
        y, blade = np.zeros((4, m)), np.zeros(n)
        for k, rows in cones.items():
            price = -z[rows][1:] / (np.sqrt(rows.stop - rows.start - 1) * units[k])
            if k == 4:
                blade = price - price.mean()
            else:
                y[k] = price - price.mean()
        up, down = z[rates[0]] / _UNIT, z[rates[1]] / _UNIT
        single = {
            name: float(z[rows][0]) / (units[4] if name == "cap" else self.unit_torque)
            for name, rows in self.single.items()
        }
        moved = sum((z[r] * s for r, s in zip(travels, (1.0, -1.0), strict=False)), np.zeros(n))
        mult = Multipliers(
            loads=y,
            blade=blade,
            rate=up - down,
            torque_min=single.get("min", 0.0),
            torque_max=single.get("max", 0.0),
            cap=single.get("cap", 0.0),
            mean=0.0 if mean is None else float(z[mean][0]) * n / _UNIT,
            basis=0.0 if basis is None else z[basis] / _UNIT,
        )
        value = problem.value_of(self.loads, problem.travel(self.profile), objective)
        promised = a * torque - program.value(solution.x)
        return self._judged(mult, up, down, moved / _UNIT, value, promised - value)

    # ---- the conditions ----------------------------------------------------------------------

    def _judged(
        self,
        mult: Multipliers,
        up: FloatArray,
        down: FloatArray,
        travel: FloatArray,
        value: float,
        gain: float,
    ) -> Stationary:
        from pitchopt.design.scp import _rate_terms

        curves, near = self.curves, self.near
        g = self.objective.torque + mult.torque_min - mult.torque_max
        y = np.concatenate([np.tile(mult.loads, (1, curves.blades)), mult.blade[None]])
        torque_rate, load_rate = _rate_terms(curves, y, g)
        w = up - down + travel
        common = (
            torque_rate - load_rate + w - np.roll(w, 1) - mult.mean / curves.stations - mult.basis
        )

        def own(slopes: FloatArray) -> FloatArray:
            return np.asarray(g * slopes[0] / curves.positions - np.sum(y * slopes, axis=0))

        left, right = own(near.left) + common, own(near.right) + common
        with np.errstate(divide="ignore", invalid="ignore"):
            theta = np.clip(np.nan_to_num(left / (left - right), nan=0.5), 0.0, 1.0)
        theta = np.where(near.at_kink, theta, 0.5)
        slope = (1 - theta) * left + theta * right
        upper = np.where(near.at_top, np.maximum(slope, 0.0), 0.0)
        lower = np.where(near.at_bottom, np.maximum(-slope, 0.0), 0.0)
        terms = [np.abs(g * near.left[0] / curves.positions), np.abs(y * near.left).max(axis=0), np.abs(w)]
        return Stationary(
            multipliers=mult,
            torque_price=g,
            rate_up=up,
            rate_down=down,
            travel=travel,
            lower=lower,
            upper=upper,
            theta=theta,
            at_kink=near.at_kink,
            left=near.left,
            right=near.right,
            residual=slope - upper + lower,
            scale=max(float(np.max(term)) for term in terms) or 1.0,
            value=value,
            gain=gain,
        )
