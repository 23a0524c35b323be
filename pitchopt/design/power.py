"""The largest mean torque: an exact concave program where torque is concave in pitch.

    maximise  sum_n torque_n(beta_n) / m   subject to range, stall and rate limits.

Each torque_n is the lower envelope of its segments' lines.  The lines near the present profile
and a thinned selection of the far ones give an upper bound; the solution moves the selection,
and the bound meets the true torque after a few solves.  With many rotor positions the first
profile comes from every s-th of them (:mod:`pitchopt.design.coarse`).  Where torque is not
concave (sampled equilibrium curves) the result is a local optimum, and the hull relaxation
bounds it.
"""

from __future__ import annotations

import time

import numpy as np
from numpy.typing import NDArray

from pitchopt.design.coarse import interpolated, stride
from pitchopt.design.direct import Subproblem
from pitchopt.design.problem import DesignProblem, Objective
from pitchopt.design.relaxation import relax
from pitchopt.design.results import LocalSolution, Status
from pitchopt.design.scp import solve_local
from pitchopt.design.uniform import solve_uniform

__all__ = ["maximise_torque"]

FloatArray = NDArray[np.float64]

_COARSE_TOLERANCE = 1e-6  # at fewer rotor positions, enough for a start
_NOTHING = (0.0, 0.0, 0.0, 0.0, 0.0)


def maximise_torque(
    problem: DesignProblem,
    start: FloatArray,
    *,
    blade_cap: float = np.inf,
    tolerance: float = 1e-9,
    max_solves: int = 30,
) -> LocalSolution:
    """Profile of largest mean torque.

    Parameters
    ----------
    problem : DesignProblem
    start : array (N,)
        First profile [rad].
    blade_cap : float
        Largest J_blade [N m]; a finite one makes the problem non-convex.
    tolerance : float
        Bound minus torque, as a share of torque, at which the answer is exact.

    Returns
    -------
    LocalSolution
        Status ``EXACT`` when the bound proves it, ``CONVERGED`` for a local optimum.
    """
    began = time.perf_counter()
    objective = Objective(torque=1.0, rms=_NOTHING, blade_cap=blade_cap)
    curves = problem.curves
    if problem.constant_only:
        return solve_uniform(problem, objective)
    if not curves.concave or np.isfinite(blade_cap):
        relaxed = relax(problem, objective, profile=start)
        starts = [start] if relaxed is None else [start, relaxed.profile]
        return max(
            (solve_local(problem, objective, first) for first in starts),
            key=lambda found: found.value,
        )
    if problem.coarse is not None:
        step = stride(curves.positions)
        coarse = maximise_torque(problem.coarse, start[::step], tolerance=_COARSE_TOLERANCE)
        start = interpolated(coarse.profile, step)
    subproblem = Subproblem(problem)
    profile = top = problem.repaired(start)
    best = problem.value(top, objective)
    history, bound = [best], np.inf
    multipliers, solver_seconds = None, 0.0
    for _ in range(max_solves):
        out = subproblem.solve(profile, objective, low=curves.lower, high=curves.upper)
        solver_seconds += out.solve_seconds
        if not out.solved:
            break
        multipliers = out.multipliers
        bound = min(bound, out.value)
        candidate = problem.repaired(out.profile)
        value = problem.value(candidate, objective)
        if value > best:
            top, best = candidate, value
        history.append(best)
        if bound - best <= tolerance * abs(best):
            break
        profile = candidate  # the lines around an overshoot cut it off next time
    if multipliers is None or bound - best > 1e-6 * abs(best):
        return solve_local(problem, objective, top)
    return LocalSolution(
        profile=top,
        loads=curves.evaluate(top),
        value=best,
        multipliers=multipliers,
        status=Status.EXACT,
        message=f"bound and torque agree to {max(bound - best, 0.0) / abs(best):.1e}",
        iterations=len(history) - 1,
        seconds=time.perf_counter() - began,
        solver_seconds=solver_seconds,
        history=tuple(history),
    )
