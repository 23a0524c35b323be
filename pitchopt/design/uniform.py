"""The best constant profile, where the limits leave nothing else.

A rate limit of zero, a restriction to the mean alone or a fixed mean with either of them makes
the problem one-dimensional.  Mean torque is piecewise linear in the constant pitch, so its
breakpoints and the points at which it meets the torque limits are exact; the RMS values bend
between breakpoints, and a bounded search refines the best interval.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import minimize_scalar

from pitchopt.design.multipliers import Multipliers
from pitchopt.design.problem import DesignProblem, Objective
from pitchopt.design.results import LocalSolution, Status

__all__ = ["best_uniform", "solve_uniform"]

FloatArray = NDArray[np.float64]

_MOST_BREAKPOINTS = 2000
_BROKEN = 1e-6  # share of torque, or of the cap, by which a limit may be missed


def solve_uniform(problem: DesignProblem, objective: Objective) -> LocalSolution:
    """Constant profile of best value among those that keep the torque limits and the cap.

    Status ``EXACT`` when mean torque alone is maximised, ``CONVERGED`` otherwise, and
    ``INFEASIBLE`` when no constant pitch keeps the limits: the profile that misses them least.
    """
    began = time.perf_counter()
    curves = problem.curves
    pitch, tried = best_uniform(
        [problem], [objective], lambda pitch: _score(problem, objective, pitch)
    )
    profile = np.full(curves.stations, pitch)
    loads = curves.evaluate(profile)
    torque, blade = problem.excess(loads, objective)
    kept = torque <= _BROKEN * max(abs(float(loads.mean[0])), 1e-300) and (
        np.isinf(objective.blade_cap) or blade <= _BROKEN * objective.blade_cap
    )
    status, message = Status.CONVERGED, "limits leave constant pitch only"
    if not kept:
        status = Status.INFEASIBLE
        message += f"; torque limit missed by {torque:.4g} N m, blade cap by {blade:.4g} N m"
    elif not any(objective.rms) and np.isinf(objective.blade_cap):
        status = Status.EXACT
    value = problem.value(profile, objective)
    return LocalSolution(
        profile=profile,
        loads=loads,
        value=value,
        multipliers=Multipliers.zero(curves.stations, curves.positions),
        status=status,
        message=message,
        iterations=tried,
        seconds=time.perf_counter() - began,
        solver_seconds=0.0,
        history=(value,),
    )


def best_uniform(
    problems: Sequence[DesignProblem],
    objectives: Sequence[Objective],
    score: Callable[[float], float],
) -> tuple[float, int]:
    """The constant pitch of best score that all problems admit [rad], and how many were tried.

    Breakpoints of all curves, the pitches at which a mean torque meets its limits, and a bounded
    search around the best of them.
    """
    low = max(problem.constant_range[0] for problem in problems)
    high = min(problem.constant_range[1] for problem in problems)
    pitches = np.array([low])
    if high > low:
        beta = np.concatenate([problem.curves.beta.ravel() for problem in problems])
        inside = np.unique(beta[(beta > low) & (beta < high)])
        if inside.size > _MOST_BREAKPOINTS:
            inside = inside[np.linspace(0, inside.size - 1, _MOST_BREAKPOINTS).astype(int)]
        grid = np.concatenate([[low], inside, [high]])
        pitches = grid
        for problem, objective in zip(problems, objectives, strict=True):
            pitches = np.union1d(pitches, _crossings(problem, objective, grid))
    scores = np.array([score(float(p)) for p in pitches])
    best = int(np.argmax(scores))
    pitch = float(pitches[best])
    if pitches.size > 1:
        bounds = (float(pitches[max(best - 1, 0)]), float(pitches[min(best + 1, pitches.size - 1)]))
        found = minimize_scalar(
            lambda p: -score(float(p)), bounds=bounds, method="bounded", options={"xatol": 1e-10}
        )
        if -float(found.fun) > scores[best]:
            pitch = float(found.x)
    return pitch, int(pitches.size)


def _score(problem: DesignProblem, objective: Objective, pitch: float) -> float:
    """Value, less a price on broken limits that no gain outweighs."""
    profile = np.full(problem.curves.stations, pitch)
    loads = problem.curves.evaluate(profile)
    torque, blade = problem.excess(loads, objective)
    scale = 1e6 * max(1.0, *objective.rms)
    return problem.value_of(loads, 0.0, objective) - scale * (torque + blade)


def _crossings(problem: DesignProblem, objective: Objective, pitches: FloatArray) -> FloatArray:
    """Pitches at which mean torque meets one of its limits, between neighbours of the list."""
    rotor, _ = problem.curves.evaluate_constant(pitches)
    torque = rotor[:, 0].mean(axis=1)
    found = []
    for limit in (objective.torque_min, objective.torque_max):
        if np.isfinite(limit):
            gap = torque - limit
            k = np.flatnonzero(gap[:-1] * gap[1:] < 0)
            share = gap[k] / (gap[k] - gap[k + 1])
            found.append(pitches[k] + share * (pitches[k + 1] - pitches[k]))
    return np.concatenate(found) if found else np.empty(0)
