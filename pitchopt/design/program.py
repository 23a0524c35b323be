"""The same convex subproblem written for reading, in cvxpy.

Built once per problem with parameters for everything that changes (the DPP rules hold, so that
cvxpy compiles it once), it is the fallback of the direct path, the check on it, and the place
for constraints of a user's own: anything convex in the profile, or in what is affine in it.
"""

from __future__ import annotations

import warnings
from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pitchopt.design.direct import SubproblemSolution
from pitchopt.design.linear import LinearModel, torque_lines
from pitchopt.design.multipliers import Multipliers
from pitchopt.design.problem import DesignProblem, Objective
from pitchopt.errors import ComputationError, InputError

__all__ = ["ConvexSubproblem", "UserConstraints"]

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.intp]
UserConstraints = Callable[[Any], list[Any]]
"""Takes the profile as a cvxpy expression (N,) [rad], returns cvxpy constraints."""


class ConvexSubproblem:
    """The convex subproblem of one design problem and one objective, in cvxpy.

    Parameters
    ----------
    problem : DesignProblem
    objective : Objective
        Its numbers are constants of the program.
    constraints : callable, optional
        Further convex constraints on the profile.
    lines : int
        Torque lines per station that the program has room for.
    sparse : bool
        False writes the mean of each load out, as one would at first: the same problem with
        full rows, for comparison.

    Raises
    ------
    InputError
        If the constraints given are not convex, or break the rules for parameters.
    """

    def __init__(
        self,
        problem: DesignProblem,
        objective: Objective,
        *,
        constraints: UserConstraints | None = None,
        lines: int = 32,
        sparse: bool = True,
    ) -> None:
        import cvxpy as cp

        self.problem, self.objective, self._lines = problem, objective, lines
        self._constraints = constraints
        curves = problem.curves
        n, m, blades = curves.stations, curves.positions, curves.blades
        lam = objective.lambdas
        capped = np.isfinite(objective.blade_cap)
        self._loads = [q for q in range(5) if lam[q] > 0 or (q == 4 and capped)]
        self._with_torque = objective.torque > 0 or np.isfinite(objective.torque_min)

        self.change = cp.Variable(n, name="change")  # (beta - point) / radius
        x = self.change
        self.point = cp.Parameter(n, name="point")
        self.radius = cp.Parameter(nonneg=True, name="radius")
        self.beta = self.point + self.radius * x
        self.low, self.high = cp.Parameter(n), cp.Parameter(n)
        self.room_up, self.room_down = cp.Parameter(n), cp.Parameter(n)
        following = cp.hstack([x[1:], x[:1]]) if n > 1 else x
        rules = [x >= self.low, x <= self.high]
        self._rate_up = following - x <= self.room_up
        self._rate_down = x - following <= self.room_down
        rules += [self._rate_up, self._rate_down]

        self.torque_rate = cp.Parameter(n)
        mean_torque: Any = self.torque_rate @ x
        if self._with_torque:
            t = cp.Variable(n, name="torque")
            self.line_value = cp.Parameter((lines, n))
            self.line_slope = cp.Parameter((lines, n))
            rules += [
                t <= self.line_value[i] + cp.multiply(self.line_slope[i], x) for i in range(lines)
            ]
            mean_torque = mean_torque + cp.sum(t) / m
        cost: Any = -objective.torque * mean_torque

        self.gradient = {q: cp.Parameter(n) for q in self._loads}
        self.rate_share = {q: cp.Parameter(n) for q in self._loads}
        self.offset = {q: cp.Parameter(n if q == 4 else m) for q in self._loads}
        previous = cp.hstack([x[-1:], x[:-1]]) if n > 1 else x
        self.units = cp.Parameter(5, nonneg=True)
        rms: dict[int, Any] = {}
        self._cones: dict[int, Any] = {}
        for q in self._loads:
            blade = cp.multiply(self.gradient[q], x)
            if np.any(curves.rates):
                blade = blade + cp.multiply(self.rate_share[q], following - previous)
            load = blade if q == 4 else sum(blade[b * m : (b + 1) * m] for b in range(blades))
            size = n if q == 4 else m
            value = self.offset[q] + load
            # a free variable is the mean at its best, and keeps the rows of the cone sparse
            mean = cp.Variable() if sparse else cp.sum(value) / size
            rms[q] = cp.Variable(nonneg=True)
            self._cones[q] = cp.SOC(np.sqrt(size) * rms[q], value - mean)
            rules.append(self._cones[q])
            if lam[q] > 0:
                cost = cost + lam[q] * (self.units[q] * rms[q])
        self.penalty = cp.Parameter(2, nonneg=True)
        self.limit = cp.Parameter(3)
        self._single: dict[str, Any] = {}
        if np.isfinite(objective.torque_min):
            slack = cp.Variable(nonneg=True)
            self._single["min"] = mean_torque + slack >= self.limit[0]
            cost = cost + self.penalty[0] * slack
        if np.isfinite(objective.torque_max):
            slack = cp.Variable(nonneg=True)
            self.torque_gradient = cp.Parameter(n)
            self._single["max"] = self.torque_gradient @ x - slack <= self.limit[1]
            cost = cost + self.penalty[0] * slack
        if capped:
            slack = cp.Variable(nonneg=True)
            self._single["cap"] = rms[4] - slack <= self.limit[2]
            cost = cost + self.penalty[1] * slack
        rules += list(self._single.values())
        if objective.travel > 0:
            self.change0 = cp.Parameter(n)
            self.travel_cost = cp.Parameter(nonneg=True)
            travel = cp.Variable()
            steps = cp.Variable(n)
            self._travel = (
                following - x - steps <= -self.change0,
                x - following - steps <= self.change0,
            )
            rules += [*self._travel, cp.sum(steps) <= travel]
            cost = cost + self.travel_cost * travel
        if curves.mean_pitch is not None:
            self.mean_gap = cp.Parameter()
            self._mean = cp.sum(x) == self.mean_gap
            rules.append(self._mean)
        if problem.basis is not None:
            self.start = cp.Parameter(n)  # the point in units of the box
            coefficients = cp.Variable(problem.basis.shape[1])
            self._basis = x + self.start == problem.basis @ coefficients
            rules.append(self._basis)
        if constraints is not None:
            rules += list(constraints(self.beta))
        self.program = cp.Problem(cp.Minimize(cost), rules)
        if not self.program.is_dcp(dpp=True):
            raise InputError(
                "constraints: not convex in the profile, or not affine in cvxpy's parameters"
                if constraints is not None
                else "program: breaks cvxpy's rules for parameters"
            )

    def project(self, profile: FloatArray) -> FloatArray:
        """Nearest profile that keeps range, rate, mean, harmonics and the user's constraints.

        Raises
        ------
        ComputationError
            If there is none.
        """
        import cvxpy as cp

        curves, n = self.problem.curves, self.problem.curves.stations
        beta = cp.Variable(n)
        following = cp.hstack([beta[1:], beta[:1]]) if n > 1 else beta
        rules = [
            beta >= curves.lower,
            beta <= curves.upper,
            cp.abs(following - beta) <= self.problem.step,
        ]
        if curves.mean_pitch is not None:
            rules.append(cp.sum(beta) / n == curves.mean_pitch)
        if self.problem.basis is not None:
            width = self.problem.basis.shape[1]
            rules.append(beta == self.problem.basis @ cp.Variable(width))
        if self._constraints is not None:
            rules += list(self._constraints(beta))
        program = cp.Problem(cp.Minimize(cp.sum_squares(beta - profile)), rules)
        program.solve(solver=cp.CLARABEL)
        if beta.value is None or program.status not in ("optimal", "optimal_inaccurate"):
            raise ComputationError(
                f"constraints: no profile satisfies them together with the limits "
                f"({program.status})"
            )
        return np.asarray(beta.value)

    def solve(
        self,
        point: FloatArray,
        objective: Objective,
        *,
        low: FloatArray,
        high: FloatArray,
        penalty: tuple[float, float] = (0.0, 0.0),
        segments: IntArray | None = None,
        tight: bool = False,  # noqa: ARG002  (one scaling only)
    ) -> SubproblemSolution:
        """Same question and answer as :meth:`pitchopt.design.direct.Subproblem.solve`.

        Raises
        ------
        InputError
            If the objective is not the one that the program was built for.
        """
        if objective != self.objective:
            raise InputError("objective: differs from the one that this program was built for")
        import cvxpy as cp

        curves = self.problem.curves
        low, high = np.maximum(low, curves.lower), np.minimum(high, curves.upper)
        model = LinearModel(self.problem, point, segments, low, high)
        scale = self._fill(model, penalty)
        status = "failed"
        try:
            with warnings.catch_warnings():
                warnings.simplefilter("ignore", UserWarning)  # inaccuracy is in the status
                self.program.solve(solver=cp.CLARABEL, warm_start=False)
            status = str(self.program.status)
        except cp.SolverError as error:
            status = f"failed ({error})"
        solved = status in ("optimal", "optimal_inaccurate") and self.change.value is not None
        stats = self.program.solver_stats
        x = np.asarray(self.change.value) if solved else np.zeros(curves.stations)
        value = objective.torque * model.torque
        if solved:
            value -= float(self.program.value) * scale
        return SubproblemSolution(
            profile=point + model.radius * x,
            value=value,
            multipliers=(
                self._multipliers(model)
                if solved
                else Multipliers.zero(curves.stations, curves.positions)
            ),
            status=status,
            solved=solved,
            iterations=int(stats.num_iters or 0) if stats is not None and solved else 0,
            solve_seconds=float(stats.solve_time or 0.0) if stats is not None and solved else 0.0,
        )

    # ---- numbers ---------------------------------------------------------------------------

    def _fill(self, model: LinearModel, penalty: tuple[float, float]) -> float:
        """Set every parameter; the unit of the objective [N m]."""
        problem, objective, curves = self.problem, self.objective, self.problem.curves
        r = model.radius
        unit = model.torque_unit
        self.point.value, self.radius.value = model.point, r
        self.low.value = (model.low - model.point) / r
        self.high.value = (model.high - model.point) / r
        change = np.roll(model.point, -1) - model.point
        self.room_up.value = (problem.step - change) / r
        self.room_down.value = (problem.step + change) / r
        self.torque_rate.value = model.torque_rate * (r / unit)
        if self._with_torque:
            station, value, slope = torque_lines(
                curves, model.point, model.segment, model.low, model.high
            )
            self._fill_lines(
                station,
                (value - model.blade_static[0, station]) / unit,
                slope * (r / unit),
            )
        units = np.ones(5)
        for q in self._loads:
            units[q] = model.unit(q, False)
            share = model.half * r / units[q]
            self.gradient[q].value = model.slopes[q] * (r / units[q])
            self.rate_share[q].value = curves.rates[q] * share
            self.offset[q].value = model.residual(q) / units[q]
        self.units.value = units / unit
        if curves.mean_pitch is not None:
            gap = curves.mean_pitch - float(model.point.mean())
            self.mean_gap.value = gap * curves.stations / r
        if problem.basis is not None:
            self.start.value = model.point / r
        cap = objective.blade_cap / units[4] if np.isfinite(objective.blade_cap) else 0.0
        limits = [
            (limit - model.torque) / unit if np.isfinite(limit) else 0.0
            for limit in (objective.torque_min, objective.torque_max)
        ]
        self.limit.value = np.array([*limits, cap])
        self.penalty.value = np.array([penalty[0], penalty[1] * units[4] / unit])
        if "max" in self._single:
            self.torque_gradient.value = model.torque_gradient * (r / unit)
        if objective.travel > 0:
            self.change0.value = change / r
            self.travel_cost.value = objective.travel * r / unit
        self._unit = unit
        return unit

    def _fill_lines(self, station: IntArray, value: FloatArray, slope: FloatArray) -> None:
        """Lines of each station in columns; a station with fewer repeats its first."""
        n = self.problem.curves.stations
        count = np.bincount(station, minlength=n)
        first = np.concatenate([[0], np.cumsum(count)[:-1]])
        pick = np.arange(self._lines)[:, None]
        if int(count.max()) > self._lines:
            # more than the program has room for: spread the selection over all of them
            spread = np.linspace(0.0, 1.0, self._lines)[:, None] * (count - 1)
            index = first + np.rint(spread).astype(np.intp)
        else:
            index = first + np.where(pick < count, pick, 0)
        self.line_value.value = value[index]
        self.line_slope.value = slope[index]

    def _multipliers(self, model: LinearModel) -> Multipliers:
        """Multipliers in the units of the direct path."""
        curves, unit = self.problem.curves, self._unit
        n, m = curves.stations, curves.positions
        y_loads, y_blade = np.zeros((4, m)), np.zeros(n)
        units = np.asarray(self.units.value) * unit
        dual = {name: float(np.sum(rule.dual_value)) for name, rule in self._single.items()}
        cap = dual.get("cap", 0.0) * unit / units[4]
        for q, cone in self._cones.items():
            y = -np.ravel(cone.dual_value[1]) * (unit / units[q])
            if q == 4:
                y_blade = y - y.mean()
            else:
                y_loads[q] = y - y.mean()
        w = np.asarray(self._rate_up.dual_value) - np.asarray(self._rate_down.dual_value)
        if self.objective.travel > 0:
            w = w + np.asarray(self._travel[0].dual_value) - np.asarray(self._travel[1].dual_value)
        per_radian = unit / model.radius
        mean: Any = 0.0
        if curves.mean_pitch is not None:
            mean = float(np.sum(self._mean.dual_value)) * n * per_radian
        basis: Any = 0.0
        if self.problem.basis is not None:
            basis = np.asarray(self._basis.dual_value) * per_radian
        return Multipliers(
            loads=y_loads,
            blade=y_blade,
            rate=w * per_radian,
            torque_min=dual.get("min", 0.0),
            torque_max=dual.get("max", 0.0),
            cap=cap,
            mean=mean,
            basis=basis,
        )
