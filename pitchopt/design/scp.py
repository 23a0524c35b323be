"""Sequential convex programming: the local solve of one design problem from one start.

The walk of :mod:`pitchopt.design.walk` with the subproblem of :mod:`pitchopt.design.direct`, a
failure of which is tried again with the other scaling and then by cvxpy; its steps are brought
back to their loads by :mod:`pitchopt.design.restoration`, its cells are the segments of the
curves.  With many rotor positions the trust region runs on every s-th of them first
(:mod:`pitchopt.design.coarse`).
"""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from pitchopt.design.coarse import interpolated, stride, widened
from pitchopt.design.direct import Subproblem, SubproblemSolution
from pitchopt.design.multipliers import Multipliers
from pitchopt.design.problem import DesignProblem, Objective
from pitchopt.design.restoration import restored
from pitchopt.design.results import LocalSolution
from pitchopt.design.uniform import solve_uniform
from pitchopt.design.walk import PENALTY_START, ScpSettings, Walk
from pitchopt.errors import InputError

if TYPE_CHECKING:
    from pitchopt.aero.curves import BladeCurves
    from pitchopt.design.program import ConvexSubproblem

    Solver = Subproblem | ConvexSubproblem

__all__ = ["LocalSolution", "ScpSettings", "reduced_slope", "solve_local"]

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.intp]

_COARSE_TOLERANCE = 1e-5  # enough for a start


class _Merit:
    """True merit of profiles, with the exact-penalty weights of the moment."""

    def __init__(self, problem: DesignProblem, objective: Objective, start: FloatArray) -> None:
        self.problem = problem
        self.objective = objective
        self.scale = max(abs(float(problem.curves.evaluate(start).mean[0])), 1e-300)
        self.penalty = (PENALTY_START, PENALTY_START * max(1.0, *objective.rms))

    def __call__(self, profile: FloatArray) -> float:
        loads = self.problem.curves.evaluate(profile)
        travel = self.problem.travel(profile) if self.objective.travel > 0 else 0.0
        value = self.problem.value_of(loads, travel, self.objective)
        torque, blade = self.problem.excess(loads, self.objective)
        return value - self.penalty[0] * torque - self.penalty[1] * blade

    def broken(self, profile: FloatArray, share: float) -> tuple[bool, bool]:
        torque, blade = self.excess(profile)
        cap = self.objective.blade_cap
        return torque > share * self.scale, bool(blade > share * cap) and np.isfinite(cap)

    def missed(self, profile: FloatArray) -> str:
        torque, blade = self.excess(profile)
        return f"torque limit missed by {torque:.4g} N m, blade cap by {blade:.4g} N m"

    def excess(self, profile: FloatArray) -> tuple[float, float]:
        return self.problem.excess(self.problem.curves.evaluate(profile), self.objective)


class _Run(Walk[SubproblemSolution]):
    """The local solve of one problem."""

    def __init__(
        self,
        problem: DesignProblem,
        objective: Objective,
        start: FloatArray,
        settings: ScpSettings,
        subproblem: Solver,
        should_stop: Callable[[], bool] | None,
    ) -> None:
        curves = problem.curves
        super().__init__(
            start,
            merit=_Merit(problem, objective, problem.repaired(start)),
            repaired=problem.repaired,
            edges=curves.beta,
            last=curves.beta.shape[1] - 2,
            settings=settings,
            should_stop=should_stop,
        )
        self.problem, self.objective, self.subproblem = problem, objective, subproblem
        self.fallback: ConvexSubproblem | None = None
        self.multipliers: Multipliers | None = None

    def begin_coarse(self) -> None:
        """Go on from the end of phase 1 on fewer rotor positions, if that is the better start."""
        coarse = self.problem.coarse
        if coarse is None:
            return
        step = stride(self.problem.curves.positions)
        found = solve_local(
            coarse,
            self.objective,
            self.profile[::step],
            settings=replace(
                self.settings,
                coarse=False,
                max_cells=0,
                tolerance=max(self.settings.tolerance, _COARSE_TOLERANCE),
            ),
            should_stop=self.should_stop,
        )
        self.solves += found.iterations
        self.solver_seconds += found.solver_seconds
        profile = self.problem.repaired(interpolated(found.profile, step))
        merit = self.merit(profile)
        if merit > self.best:
            self.accept(profile, merit)
            self.multipliers = widened(found.multipliers, step)
            self.settings = self.settings.finishing()

    def brought_back(self, out: SubproblemSolution, candidate: FloatArray) -> FloatArray:
        """A step brought back to the loads that its model promised."""
        curves = self.problem.curves
        point = np.clip(self.profile, curves.lower, curves.upper)
        price = out.multipliers.cap
        return restored(self.problem, self.objective, point, candidate, cap_price=price)

    def cell(self, profile: FloatArray) -> IntArray:
        """Segment that holds each station's pitch."""
        return self.problem.curves.segment(profile)

    def solve(
        self, low: FloatArray, high: FloatArray, segments: IntArray | None = None
    ) -> SubproblemSolution:
        """One subproblem; a failure is tried again with the other scaling, then by cvxpy.

        A cvxpy subproblem handed in by the caller may hold constraints that no other path
        knows, and stands alone.
        """
        point = np.clip(self.profile, low, high)
        direct = isinstance(self.subproblem, Subproblem)
        for attempt in range(3 if direct else 1):
            self.solves += 1
            if attempt == 2 and self.fallback is None:
                from pitchopt.design.program import ConvexSubproblem

                self.fallback = ConvexSubproblem(self.problem, self.objective)
            solver = self.subproblem if attempt < 2 or self.fallback is None else self.fallback
            options: dict[str, Any] = {}
            if isinstance(solver, Subproblem):
                options["chord"] = self.chord(low, high, segments)
                options["multipliers"] = self.multipliers
            out = solver.solve(
                point,
                self.objective,
                low=low,
                high=high,
                penalty=self.merit.penalty,
                segments=segments,
                tight=attempt == 1,
                **options,
            )
            self.solver_seconds += out.solve_seconds
            if out.solved:
                self.last, self.multipliers = out, out.multipliers
                return out
        self.failures += 1
        return out

    def reduced_slope(self, out: SubproblemSolution, segment: IntArray) -> FloatArray:
        """Slope of the Lagrangian in each station's pitch on the given segments [N m/rad]."""
        return reduced_slope(self.problem.curves, self.objective.torque, out.multipliers, segment)


def reduced_slope(
    curves: BladeCurves, torque: float, mult: Multipliers, segment: IntArray
) -> FloatArray:
    """Slope of the Lagrangian in each station's pitch on the given segments, (N,) [N m/rad].

    ``torque`` is the price of mean torque in the objective.
    """
    slopes = curves.slopes[:, np.arange(curves.stations), segment]
    gain = torque + mult.torque_min - mult.torque_max
    y = np.concatenate([np.tile(mult.loads, (1, curves.blades)), mult.blade[None]])
    torque_rate, load_rate = _rate_terms(curves, y, gain)
    return np.asarray(
        gain * slopes[0] / curves.positions
        - np.sum(y * slopes, axis=0)
        + torque_rate
        - load_rate
        + mult.rate
        - np.roll(mult.rate, 1)
        - mult.mean / curves.stations
        - mult.basis
    )


def _rate_terms(curves: BladeCurves, y: FloatArray, gain: float) -> tuple[FloatArray, FloatArray]:
    """Pitch-rate terms of neighbouring stations, folded onto each station's pitch."""
    half = 0.5 / curves.spacing
    torque = gain * curves.rates[0] / curves.positions
    loads = np.sum(y * curves.rates, axis=0)
    return (
        (np.roll(torque, 1) - np.roll(torque, -1)) * half,
        (np.roll(loads, 1) - np.roll(loads, -1)) * half,
    )


def solve_local(
    problem: DesignProblem,
    objective: Objective,
    start: FloatArray,
    *,
    settings: ScpSettings | None = None,
    subproblem: Solver | None = None,
    should_stop: Callable[[], bool] | None = None,
) -> LocalSolution:
    """Local optimum of the design problem from one start.

    Parameters
    ----------
    problem : DesignProblem
    objective : Objective
    start : array (N,)
        First profile [rad]; moved to the nearest feasible one.
    settings : ScpSettings, optional
    subproblem : Subproblem, optional
        Cone data built for ``problem`` before, to be used again.
    should_stop : callable, optional
        Asked before every subproblem; True ends the run with what it has.

    Returns
    -------
    LocalSolution
        Feasible in range and rate always; ``status`` says the rest.
    """
    began = time.perf_counter()
    start = np.asarray(start, dtype=np.float64)
    if start.shape != (problem.curves.stations,) or not np.all(np.isfinite(start)):
        raise InputError(
            f"start: got shape {start.shape}, expected ({problem.curves.stations},) finite angles"
        )
    if problem.constant_only:
        return solve_uniform(problem, objective)
    run = _Run(
        problem,
        objective,
        start,
        settings or ScpSettings(),
        subproblem or Subproblem(problem),
        should_stop,
    )
    if run.settings.coarse and isinstance(run.subproblem, Subproblem):
        run.begin_coarse()
    status, message = run.walk()
    loads = problem.curves.evaluate(run.profile)
    n, m = problem.curves.stations, problem.curves.positions
    return LocalSolution(
        profile=run.profile,
        loads=loads,
        value=problem.value(run.profile, objective),
        multipliers=run.multipliers or Multipliers.zero(n, m),
        status=status,
        message=message,
        iterations=run.solves,
        seconds=time.perf_counter() - began,
        solver_seconds=run.solver_seconds,
        history=tuple(run.history),
    )
