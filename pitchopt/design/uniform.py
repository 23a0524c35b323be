"""The best constant profile, where the limits leave nothing else.

A rate limit of zero, a restriction to the mean alone or a fixed mean with either of them makes
the problem one-dimensional.  Mean torque is piecewise linear in the constant pitch, so its
breakpoints and the points at which it meets the torque limits are exact; the RMS values bend
between breakpoints, and a bounded search refines the best interval.
"""

from __future__ import annotations

import time

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import minimize_scalar

from pitchopt.design.multipliers import Multipliers
from pitchopt.design.problem import DesignProblem, Objective
from pitchopt.design.results import LocalSolution, Status

__all__ = ["solve_uniform"]

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
    low, high = problem.constant_range
    pitches = np.array([low])
    if high > low:
        inside = np.unique(curves.beta[(curves.beta > low) & (curves.beta < high)])
        if inside.size > _MOST_BREAKPOINTS:
            inside = inside[np.linspace(0, inside.size - 1, _MOST_BREAKPOINTS).astype(int)]
        pitches = np.concatenate([[low], inside, [high]])
        pitches = np.union1d(pitches, _crossings(problem, objective, pitches))
    scores = np.array([_score(problem, objective, float(p)) for p in pitches])
    best = int(np.argmax(scores))
    pitch = float(pitches[best])
    if pitches.size > 1:
        bounds = (float(pitches[max(best - 1, 0)]), float(pitches[min(best + 1, pitches.size - 1)]))
        found = minimize_scalar(
            lambda p: -_score(problem, objective, float(p)),
            bounds=bounds,
            method="bounded",
            options={"xatol": 1e-10},
        )
        if -float(found.fun) > scores[best]:
            pitch = float(found.x)
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
        iterations=int(pitches.size),
        seconds=time.perf_counter() - began,
        solver_seconds=0.0,
        history=(value,),
    )


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
