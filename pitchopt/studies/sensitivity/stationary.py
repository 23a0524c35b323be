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
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pitchopt.checks import FloatArray
from pitchopt.design.cones import ConeProgram
from pitchopt.design.multipliers import Multipliers
from pitchopt.design.problem import DesignProblem, Objective
from pitchopt.errors import ComputationError
from pitchopt.studies.sensitivity.neighbours import neighbours

Entry = tuple[Any, Any, Any]

__all__ = ["Stationary", "stationary"]

_REACHES = (2e-6, 1e-5, 5e-5)
"""Breakpoints and limits nearer than this count as touched [rad]; local solves stop as near."""
_GOOD = 1e-6  # residual that a nearer reach is enough for
_TOLERANCE = 1e-10
_NO_STEP = 1e-9  # [rad]
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
    reach : float
        How near a breakpoint or a limit counts as touched [rad].
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
    reach: float

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


def stationary(problem: DesignProblem, objective: Objective, profile: FloatArray) -> Stationary:
    """Multipliers of the design problem at a profile that solves it locally.

    A local solve stops near the breakpoint that an exact one would stand on.  So breakpoints count
    as touched within a reach, which is widened while conditions are missed.

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
    beta = np.asarray(profile, dtype=np.float64)
    best: Stationary | None = None
    for reach in _REACHES:
        found = _Local(problem, objective, beta, reach).solve()
        if best is None or found.worst < best.worst:
            best = found
        if best.worst <= _GOOD:
            break
    assert best is not None
    return best


class _Local:
    """The convex subproblem around a profile, with both neighbouring segments."""

    def __init__(
        self, problem: DesignProblem, objective: Objective, profile: FloatArray, reach: float
    ) -> None:
        self.problem, self.objective, self.profile = problem, objective, profile
        self.reach = reach
        self.curves = problem.curves
        self.near = neighbours(problem, profile, reach)
        self.loads = self.curves.evaluate(profile)
        self.index = np.arange(profile.size)
        self.program = ConeProgram()
        self.rows: dict[str, slice] = {}
        self.cones: dict[int, slice] = {}
        self.units: dict[int, float] = {}
        self.half = 0.5 / self.curves.spacing
        self.unit_torque = max(
            float(np.mean(np.abs(self.near.right[0]) + np.abs(self.near.left[0]))) * _UNIT, 1e-300
        )

    # ---- the program -------------------------------------------------------------------------

    def _moves(self, row: NDArray[np.intp], right: FloatArray, left: FloatArray) -> list[Entry]:
        """Entries of a sum over stations of right p - left q."""
        return [
            (row, self.p + self.index, right * _UNIT),
            (row, self.q + self.index, -left * _UNIT),
        ]

    def _shifted(self, row: NDArray[np.intp], factor: FloatArray, shift: int) -> list[Entry]:
        """Entries of factor_n (move of station n + shift)."""
        other = np.roll(self.index, -shift)
        return [(row, self.p + other, factor * _UNIT), (row, self.q + other, -factor * _UNIT)]

    def solve(self) -> Stationary:
        """Pose the program, solve it, and read its multipliers."""
        self._moves_and_torque()
        self._profile_rows()
        self._torque_rows()
        self._load_rows()
        solution = self.program.solve(tolerance=_TOLERANCE)
        if not solution.solved:
            solution = self.program.solve(reduced=True)
        if not solution.solved:
            raise ComputationError(
                f"multipliers: the cone solver ended with {solution.status} at the design"
            )
        z, rows = solution.z, self.rows
        w = (z[rows["rate up"]] - z[rows["rate down"]]) / _UNIT
        if self.problem.step <= _NO_STEP:
            # no change at all: both rows of a station hold, and a constant added to all w_n is
            # as good; of all multipliers the least say what a little rate is worth
            w = w - np.median(w)
        up, down = np.maximum(w, 0.0), np.maximum(-w, 0.0)
        travel = np.zeros(up.size)
        if "travel up" in rows:
            travel = (z[rows["travel up"]] - z[rows["travel down"]]) / _UNIT
        value = self.problem.value_of(self.loads, self.problem.travel(self.profile), self.objective)
        torque = self.objective.torque * float(self.loads.mean[0])
        gain = torque - self.program.value(solution.x) - value
        return self._judged(self._multipliers(z, w), up, down, travel, value, gain)

    def _moves_and_torque(self) -> None:
        """Variables p and q with their room, and what they do to mean torque."""
        program, near, idx, n = self.program, self.near, self.index, self.profile.size
        self.p = program.variables("up", n).start
        self.q = program.variables("down", n).start
        for start, room in ((self.p, near.up), (self.q, near.down)):
            program.nonneg(np.zeros(n), (idx, start + idx, -1.0))
            program.nonneg(room / _UNIT, (idx, start + idx, 1.0))
        curves = self.curves
        folded = (np.roll(curves.rates[0], 1) - np.roll(curves.rates[0], -1)) * self.half
        self.right, self.left = (
            (slopes[0] + folded) / curves.positions for slopes in (near.right, near.left)
        )
        a = self.objective.torque * _UNIT
        program.add_cost(self.p + idx, -a * self.right)
        program.add_cost(self.q + idx, a * self.left)

    def _profile_rows(self) -> None:
        """Mean pitch, harmonics, rate limits and price of travel."""
        problem, program, idx, n = self.problem, self.program, self.index, self.profile.size
        one = np.full(n, 1.0 / _UNIT)
        mean = self.curves.mean_pitch
        if mean is not None:
            gap = (mean - float(self.profile.mean())) * n / _UNIT
            self.rows["mean"] = program.zero(np.array([gap]), *self._shifted(0 * idx, one, 0))
        if problem.basis is not None:
            wide = problem.basis.shape[1]
            column = program.variables("fourier", wide).start + np.tile(np.arange(wide), n)
            self.rows["basis"] = program.zero(
                np.zeros(n),
                *self._shifted(idx, one, 0),
                (np.repeat(idx, wide), column, -problem.basis.ravel()),
            )
        priced = self.objective.travel > 0
        if priced:
            travel = program.variables("u", n, cost=self.objective.travel * _UNIT).start
        change = np.roll(self.profile, -1) - self.profile
        for word, sign in (("up", 1.0), ("down", -1.0)):
            entries = [*self._shifted(idx, sign * one, 1), *self._shifted(idx, -sign * one, 0)]
            room = np.maximum(problem.step - sign * change, 0.0) / _UNIT
            self.rows[f"rate {word}"] = program.nonneg(room, *entries)
            if priced:
                self.rows[f"travel {word}"] = program.nonneg(
                    -sign * change / _UNIT, *entries, (idx, travel + idx, -1.0)
                )

    def _torque_rows(self) -> None:
        """Limits of mean torque."""
        torque, unit = float(self.loads.mean[0]), self.unit_torque
        for name, sign, limit in (
            ("min", -1.0, self.objective.torque_min),
            ("max", 1.0, self.objective.torque_max),
        ):
            if np.isfinite(limit):
                room = max(sign * (limit - torque), 0.0) / unit
                scale = sign / unit
                self.rows[name] = self.program.nonneg(
                    np.array([room]),
                    *self._moves(0 * self.index, scale * self.right, scale * self.left),
                )

    def _load_rows(self) -> None:
        """Cones of the RMS values, and the cap on that of a blade."""
        program, near, idx, m = self.program, self.near, self.index, self.curves.positions
        lambdas, cap = self.objective.lambdas, self.objective.blade_cap
        values = [*self.loads.rotor, self.loads.bending]
        for k in range(5):
            if lambdas[k] == 0 and not (k == 4 and np.isfinite(cap)):
                continue
            change = float(np.sqrt(np.mean(near.right[k] ** 2 + near.left[k] ** 2))) * _UNIT
            unit = max(change, _LEAST_SPREAD * float(values[k].std())) or 1.0
            s = program.variables(f"s{k}", 1).start
            program.variables(f"mean{k}", 1)  # the column after that of s
            program.add_cost(np.array([s]), np.array([lambdas[k] * unit]))
            residual = values[k] - values[k].mean()
            weight = 1.0 / (np.sqrt(residual.size) * unit)
            at = 1 + (idx if k == 4 else idx % m)
            entries: list[Entry] = [
                (0, s, -1.0),
                *self._moves(at, -near.right[k] * weight, -near.left[k] * weight),
                (1 + np.arange(residual.size), s + 1, 1.0 / np.sqrt(residual.size)),
            ]
            if np.any(self.curves.rates):
                share = self.curves.rates[k] * (self.half * weight)
                entries += [*self._shifted(at, -share, 1), *self._shifted(at, share, -1)]
            self.units[k] = unit
            self.cones[k] = program.second_order(
                np.concatenate([[0.0], residual * weight]), *entries
            )
            if k == 4 and np.isfinite(cap):
                room = max(cap, self.loads.blade_rms) / unit
                self.rows["cap"] = program.nonneg(np.array([room]), (0, s, 1.0))

    def _multipliers(self, z: FloatArray, rate: FloatArray) -> Multipliers:
        """Multipliers in N m, N m/rad and without unit."""
        n, m, rows = self.profile.size, self.curves.positions, self.rows
        y, blade = np.zeros((4, m)), np.zeros(n)
        for k, cone in self.cones.items():
            price = -z[cone][1:] / (np.sqrt(n if k == 4 else m) * self.units[k])
            if k == 4:
                blade = price - price.mean()
            else:
                y[k] = price - price.mean()

        def single(name: str, unit: float) -> float:
            return float(z[rows[name]][0]) / unit if name in rows else 0.0

        return Multipliers(
            loads=y,
            blade=blade,
            rate=rate,
            torque_min=single("min", self.unit_torque),
            torque_max=single("max", self.unit_torque),
            cap=single("cap", self.units.get(4, 1.0)),
            mean=single("mean", _UNIT / n),
            basis=z[rows["basis"]] / _UNIT if "basis" in rows else 0.0,
        )

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
        curves, near = self.curves, self.near
        g = self.objective.torque + mult.torque_min - mult.torque_max
        y = np.concatenate([np.tile(mult.loads, (1, curves.blades)), mult.blade[None]])
        priced = g * curves.rates[0] / curves.positions - np.sum(y * curves.rates, axis=0)
        by_rate = (np.roll(priced, 1) - np.roll(priced, -1)) * (0.5 / curves.spacing)
        w = up - down + travel
        common = by_rate + w - np.roll(w, 1) - mult.mean / curves.stations - mult.basis

        def own(slopes: FloatArray) -> FloatArray:
            return np.asarray(g * slopes[0] / curves.positions - np.sum(y * slopes, axis=0))

        left, right = own(near.left) + common, own(near.right) + common
        with np.errstate(divide="ignore", invalid="ignore"):
            theta = np.clip(np.nan_to_num(left / (left - right), nan=0.5), 0.0, 1.0)
        theta = np.where(near.at_kink, theta, 0.5)
        slope = (1 - theta) * left + theta * right
        upper = np.where(near.at_top, np.maximum(slope, 0.0), 0.0)
        lower = np.where(near.at_bottom, np.maximum(-slope, 0.0), 0.0)
        sizes = [
            np.abs(g * near.left[0] / curves.positions),
            np.abs(y * near.left).max(axis=0),
            np.abs(w),
        ]
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
            scale=max(float(np.max(size)) for size in sizes) or 1.0,
            value=value,
            gain=gain,
            reach=self.reach,
        )
