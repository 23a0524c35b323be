"""The convex subproblem as cone data, handed to Clarabel directly.

Around a profile beta0, inside a box [low, high] of pitch per station,

    maximise   a sum_n t_n / m + (rate terms) - sum_l lambda_l s_l - kappa sum_n u_n - rho . slack
    subject to t_n <= value_nj + slope_nj (beta_n - beta0_n)       the segments in reach of the box
               s_l >= || load_l(beta0) + G_l (beta - beta0) - mean_l 1 ||_2 / sqrt(m)
               rate limits, box, torque limits, blade cap, mean pitch, Fourier basis,

where G_l holds the slopes of the segment that each station stands on.  The free variable
mean_l is at its best the mean, which keeps the rows sparse.  Torque is modelled by its own
segments, which is exact where it is concave; where it is not, slopes are made monotone from
beta0 outwards, so that the model never promises more than beta0's own concave neighbourhood.

Pitch is scaled by the box, loads by what the box can change them by.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from pitchopt.design.cones import ConeProgram, ConeSolution
from pitchopt.design.multipliers import Multipliers
from pitchopt.design.problem import DesignProblem, Objective

if TYPE_CHECKING:
    from pitchopt.aero.curves import BladeCurves

__all__ = ["LinearModel", "Subproblem", "SubproblemSolution", "torque_lines"]

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.intp]

_DENSE_REACH = 4  # segments on either side of beta0 that always enter
_MAX_LINES = 20  # torque lines per station; farther ones are thinned out


@dataclass(frozen=True, kw_only=True, eq=False)
class SubproblemSolution:
    """Profile, model value [N m], multipliers and the solver's own word on them."""

    profile: FloatArray
    value: float
    multipliers: Multipliers
    status: str
    solved: bool
    iterations: int
    solve_seconds: float


@dataclass(kw_only=True)
class _Blocks:
    """Where the rows stand whose duals are read back, and the units of their rows."""

    units: dict[int, float]
    torque_unit: float
    mean: slice | None = None
    basis: slice | None = None
    rate: list[tuple[slice, IntArray, float]] = field(default_factory=list)
    single: dict[str, slice] = field(default_factory=dict)
    load: dict[int, slice] = field(default_factory=dict)


class LinearModel:
    """Loads around a point on given segments, and what the box can change them by."""

    def __init__(
        self,
        problem: DesignProblem,
        point: FloatArray,
        segments: IntArray | None,
        low: FloatArray,
        high: FloatArray,
        chord: float = 0.0,
    ) -> None:
        curves = problem.curves
        rows = np.arange(curves.stations)
        self.curves = curves
        self.point, self.low, self.high = point, low, high
        self.affine = segments is not None
        self.segment = curves.segment(point) if segments is None else segments
        self.radius = max(float(np.max(np.maximum(high - point, point - low))), 1e-9)
        self.slopes = curves.slopes[:, rows, self.segment]
        offset = point - curves.beta[rows, self.segment]
        self.blade_static = curves.loads[:, rows, self.segment] + self.slopes * offset
        self.curvature: FloatArray | None = None
        if chord > 0:
            self._bend(chord)
        self.blade = self.blade_static + curves.rates * curves.profile_rate(point)
        self.rotor = self.blade[:4].reshape(4, curves.blades, curves.positions).sum(axis=1)
        self.half = 0.5 / curves.spacing
        self.torque = float(self.rotor[0].mean())
        folded = (np.roll(curves.rates[0], 1) - np.roll(curves.rates[0], -1)) * self.half
        self.torque_rate = folded / curves.positions  # d(mean torque)/d beta_n by pitch rate
        self.torque_gradient = self.slopes[0] / curves.positions + self.torque_rate

    def _bend(self, chord: float) -> None:
        """Curvature of the loads over a chord around the point."""
        curves, point = self.curves, self.point
        left = np.maximum(point - chord, curves.lower)
        right = np.minimum(point + chord, curves.upper)
        before, after = np.maximum(point - left, 1e-12), np.maximum(right - point, 1e-12)
        down = (self.blade_static - curves.contributions(left)) / before
        up = (curves.contributions(right) - self.blade_static) / after
        down = np.where(before > 1e-9, down, up)
        up = np.where(after > 1e-9, up, down)
        self.curvature = 2.0 * (up - down) / (before + after)

    def unit(self, load: int, tight: bool) -> float:
        """Size of a load in the box, which scales its cone.

        What the box can change, but not far below what is there: a cone of numbers around 1e6
        that vary by 1 is beyond the solver.
        """
        change = float(np.sqrt(np.mean(self.slopes[load] ** 2))) * self.radius
        spread = float(self.blade[4].std() if load == 4 else self.rotor[load].std())
        return max(change, (1.0 if tight else 0.02) * spread) or 1.0

    def residual(self, load: int) -> FloatArray:
        """Deviation of a load from its mean at the point."""
        values = self.blade[4] if load == 4 else self.rotor[load]
        return np.asarray(values - values.mean())


class Subproblem:
    """The subproblem of one design problem; :meth:`solve` fills in numbers and solves it."""

    def __init__(self, problem: DesignProblem) -> None:
        self.problem = problem
        curves = problem.curves
        self._index = np.arange(curves.stations)
        self._next = np.roll(self._index, -1)
        self._previous = np.roll(self._index, 1)
        self._position = self._index % curves.positions
        self._has_rates = bool(np.any(curves.rates))

    def solve(
        self,
        point: FloatArray,
        objective: Objective,
        *,
        low: FloatArray,
        high: FloatArray,
        penalty: tuple[float, float] = (0.0, 0.0),
        segments: IntArray | None = None,
        tight: bool = False,
        chord: float = 0.0,
        multipliers: Multipliers | None = None,
    ) -> SubproblemSolution:
        """Solve around ``point`` inside the box.

        Parameters
        ----------
        point : array (N,)
            beta0 [rad].
        objective : Objective
        low, high : array (N,)
            Box of the profile [rad]; cut at the pitch limits.
        penalty : (float, float)
            Exact-penalty weights of the torque limits [-] and of the blade cap [-].
        segments : int array (N,), optional
            Segments that the box stays on: torque is affine there, like the loads.  By default
            the loads are modelled by the segments that hold ``point``, torque by all in reach.
        tight : bool
            Scale by the loads' own size and accept less accuracy: the fallback.
        chord : float
            Half-width [rad] over which the curvature of the loads is taken; zero for none.
        multipliers : Multipliers, optional
            With a chord: the curvature of the loads, weighted by these, enters the objective
            where it is convex, as in sequential quadratic programming.
        """
        curves = self.problem.curves
        low, high = np.maximum(low, curves.lower), np.minimum(high, curves.upper)
        model = LinearModel(self.problem, point, segments, low, high, chord)
        program = ConeProgram()
        if model.curvature is not None and multipliers is not None:
            y = np.concatenate(
                [np.tile(multipliers.loads, (1, curves.blades)), multipliers.blade[None]]
            )
            bend = np.maximum(np.sum(y * model.curvature, axis=0), 0.0)
            program.quadratic = bend * model.radius**2
        blocks = self._assemble(program, model, objective, penalty, tight)
        solution = program.solve(reduced=tight)
        return self._read(program, model, objective, blocks, solution)

    # ---- assembly --------------------------------------------------------------------------

    def _assemble(
        self,
        program: ConeProgram,
        model: LinearModel,
        objective: Objective,
        penalty: tuple[float, float],
        tight: bool,
    ) -> _Blocks:
        problem, curves = self.problem, self.problem.curves
        n, m, idx = curves.stations, curves.positions, self._index
        lam, capped = objective.lambdas, np.isfinite(objective.blade_cap)
        loads = [q for q in range(5) if lam[q] > 0 or (q == 4 and capped)]
        units = {q: model.unit(q, tight) for q in loads}
        torque_unit = max(float(np.mean(np.abs(model.slopes[0]))) * model.radius, 1e-300)
        blocks = _Blocks(units=units, torque_unit=torque_unit)
        with_torque = objective.torque > 0 or np.isfinite(objective.torque_min)
        in_segments = with_torque and not model.affine

        # pitch moves in units of the box, t_n in units of its torque, from the point's values
        gradient = model.torque_rate if in_segments else model.torque_gradient
        program.variables("pitch", n, cost=-objective.torque * gradient * model.radius)
        if in_segments:
            t = program.variables("t", n, cost=-objective.torque * torque_unit / m).start
        for q in loads:
            program.variables(f"s{q}", 1, cost=lam[q] * units[q])
            program.variables(f"mean{q}", 1)
        if objective.travel > 0:
            program.variables("u", n, cost=objective.travel * model.radius)

        if curves.mean_pitch is not None:
            gap = (curves.mean_pitch - float(model.point.mean())) * n / model.radius
            blocks.mean = program.zero(np.array([gap]), (0, idx, 1.0))
        if problem.basis is not None:
            basis = problem.basis
            f = program.variables("fourier", basis.shape[1]).start
            column = np.tile(f + np.arange(basis.shape[1]), n)
            blocks.basis = program.zero(
                -model.point / model.radius,
                (idx, idx, 1.0),
                (np.repeat(idx, basis.shape[1]), column, -basis.ravel()),
            )

        program.nonneg((model.high - model.point) / model.radius, (idx, idx, 1.0))
        program.nonneg((model.point - model.low) / model.radius, (idx, idx, -1.0))
        change = (model.point[self._next] - model.point) / model.radius
        for sign in (1.0, -1.0):
            room = problem.step / model.radius - sign * change
            near = np.flatnonzero(room < 2.0)
            k = np.arange(near.size)
            rows = program.nonneg(room[near], (k, self._next[near], sign), (k, near, -sign))
            blocks.rate.append((rows, near, sign))
        if objective.travel > 0:
            u = program.at["u"].start + idx
            for sign in (1.0, -1.0):
                rows = program.nonneg(
                    -sign * change, (idx, self._next, sign), (idx, idx, -sign), (idx, u, -1.0)
                )
                blocks.rate.append((rows, idx, sign))
        if in_segments:
            station, value, slope = torque_lines(
                curves, model.point, model.segment, model.low, model.high
            )
            k = np.arange(station.size)
            program.nonneg(
                (value - model.blade_static[0, station]) / torque_unit,
                (k, t + station, 1.0),
                (k, station, -slope * (model.radius / torque_unit)),
            )
        self._torque_limits(program, model, objective, penalty, blocks)
        for q in loads:
            blocks.load[q] = self._load_cone(program, model, q, units[q])
        return blocks

    def _torque_limits(
        self,
        program: ConeProgram,
        model: LinearModel,
        objective: Objective,
        penalty: tuple[float, float],
        blocks: _Blocks,
    ) -> None:
        """Limits of mean torque and of the blade's RMS, each with a priced slack."""
        m, idx, unit = model.curves.positions, self._index, blocks.torque_unit
        gradient = model.torque_gradient * (model.radius / unit)
        if np.isfinite(objective.torque_min):
            slack = program.variables("slack_min", 1, cost=penalty[0] * unit).start
            if model.affine:
                entries = [(0, idx, -gradient)]
            else:
                entries = [
                    (0, program.at["t"].start + idx, -1.0 / m),
                    (0, idx, -model.torque_rate * (model.radius / unit)),
                ]
            blocks.single["min"] = program.nonneg(
                np.array([(model.torque - objective.torque_min) / unit]),
                *entries,
                (0, slack, -1.0),
            )
            program.nonneg(np.zeros(1), (0, slack, -1.0))
        if np.isfinite(objective.torque_max):
            slack = program.variables("slack_max", 1, cost=penalty[0] * unit).start
            blocks.single["max"] = program.nonneg(
                np.array([(objective.torque_max - model.torque) / unit]),
                (0, idx, gradient),
                (0, slack, -1.0),
            )
            program.nonneg(np.zeros(1), (0, slack, -1.0))
        if np.isfinite(objective.blade_cap):
            slack = program.variables("slack_cap", 1, cost=penalty[1] * blocks.units[4]).start
            blocks.single["cap"] = program.nonneg(
                np.array([objective.blade_cap / blocks.units[4]]),
                (0, program.at["s4"].start, 1.0),
                (0, slack, -1.0),
            )
            program.nonneg(np.zeros(1), (0, slack, -1.0))

    def _load_cone(self, program: ConeProgram, model: LinearModel, load: int, unit: float) -> slice:
        idx = self._index
        at = idx if load == 4 else self._position
        residual = model.residual(load)
        weight = 1.0 / (np.sqrt(residual.size) * unit)
        entries: list[tuple[Any, Any, Any]] = [
            (0, program.at[f"s{load}"].start, -1.0),
            (1 + at, idx, -model.slopes[load] * (model.radius * weight)),
            (
                1 + np.arange(residual.size),
                program.at[f"mean{load}"].start,
                1.0 / np.sqrt(residual.size),
            ),
        ]
        if self._has_rates:
            share = model.curves.rates[load] * (model.half * model.radius * weight)
            entries += [(1 + at, self._next, -share), (1 + at, self._previous, share)]
        return program.second_order(np.concatenate([[0.0], residual * weight]), *entries)

    # ---- answer ----------------------------------------------------------------------------

    def _read(
        self,
        program: ConeProgram,
        model: LinearModel,
        objective: Objective,
        blocks: _Blocks,
        solution: ConeSolution,
    ) -> SubproblemSolution:
        n, m = model.curves.stations, model.curves.positions
        x = solution.x if solution.solved else np.zeros(program.width)
        z = solution.z if solution.solved else np.zeros(program.height)
        y_loads, y_blade = np.zeros((4, m)), np.zeros(n)
        for q, rows in blocks.load.items():
            y = -z[rows][1:] / (np.sqrt(n if q == 4 else m) * blocks.units[q])
            if q == 4:
                y_blade = y - y.mean()
            else:
                y_loads[q] = y - y.mean()
        w = np.zeros(n)
        for rows, near, sign in blocks.rate:
            w[near] += sign * z[rows] / model.radius
        single = {
            name: float(z[rows][0]) / (blocks.units[4] if name == "cap" else blocks.torque_unit)
            for name, rows in blocks.single.items()
        }
        value = objective.torque * model.torque - float(program.cost @ x)
        if program.quadratic is not None:
            value -= 0.5 * float(program.quadratic @ x[:n] ** 2)
        if objective.travel > 0 and not solution.solved:
            value = -np.inf
        return SubproblemSolution(
            profile=model.point + model.radius * x[:n],
            value=value,
            multipliers=Multipliers(
                loads=y_loads,
                blade=y_blade,
                rate=w,
                torque_min=single.get("min", 0.0),
                torque_max=single.get("max", 0.0),
                cap=single.get("cap", 0.0),
                mean=0.0 if blocks.mean is None else float(z[blocks.mean][0]) * n / model.radius,
                basis=0.0 if blocks.basis is None else z[blocks.basis] / model.radius,
            ),
            status=solution.status,
            solved=solution.solved,
            iterations=solution.iterations,
            solve_seconds=solution.seconds,
        )


def torque_lines(
    curves: BladeCurves, point: FloatArray, j0: IntArray, low: FloatArray, high: FloatArray
) -> tuple[IntArray, FloatArray, FloatArray]:
    """Lines that bound a blade's torque inside the box: stations, values at ``point``, slopes.

    All segments in reach enter when they are few; farther ones are thinned out, which leaves
    an upper bound that later iterations refine.
    """
    rows = np.arange(curves.stations)
    first, last = np.minimum(curves.segment(low), j0), np.maximum(curves.segment(high), j0)
    reach = max(int(np.max(j0 - first)), int(np.max(last - j0)))
    offsets = np.arange(-reach, reach + 1)
    if curves.concave and offsets.size > _MAX_LINES:
        side = np.unique(
            np.concatenate(
                [
                    np.arange(_DENSE_REACH + 1),
                    np.geomspace(_DENSE_REACH, reach, _MAX_LINES // 2 - _DENSE_REACH).astype(int),
                ]
            )
        )
        offsets = np.concatenate([-side[:0:-1], side])
    j = j0[:, None] + offsets
    valid = (j >= first[:, None]) & (j <= last[:, None])
    jc = np.clip(j, 0, curves.beta.shape[1] - 2)
    slope = curves.slopes[0][rows[:, None], jc]
    if curves.concave:
        value = curves.torque[rows[:, None], jc] + slope * (
            point[:, None] - curves.beta[rows[:, None], jc]
        )
    else:
        slope, value = _monotone_lines(curves, point, j0, jc, slope)
    n, k = np.nonzero(valid)
    return n, value[n, k], slope[n, k]


def _monotone_lines(
    curves: BladeCurves, point: FloatArray, j0: IntArray, j: IntArray, slope: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Slopes made non-increasing outwards from ``point``, and their values at ``point``."""
    rows = np.arange(curves.stations)[:, None]
    centre = j.shape[1] // 2
    out = slope.copy()
    out[:, centre:] = np.minimum.accumulate(slope[:, centre:], axis=1)
    out[:, : centre + 1] = np.maximum.accumulate(slope[:, centre::-1], axis=1)[:, ::-1]
    left, right = curves.beta[rows, j], curves.beta[rows, j + 1]
    f0 = curves.torque[rows[:, 0], j0] + slope[:, centre] * (point - curves.beta[rows[:, 0], j0])
    value = np.empty_like(out)
    value[:, centre] = f0
    # value at point of the line through a breakpoint: it changes by the slope's change there
    for k in range(centre + 1, j.shape[1]):
        at = left[:, k] - point
        value[:, k] = value[:, k - 1] + (out[:, k - 1] - out[:, k]) * at
    for k in range(centre - 1, -1, -1):
        at = right[:, k] - point
        value[:, k] = value[:, k + 1] + (out[:, k + 1] - out[:, k]) * at
    return out, value
