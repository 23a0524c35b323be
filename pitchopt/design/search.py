"""The best profile over several starts and, with a frozen wake, over the mean pitch.

A wake frozen around one profile must not be frozen anew around the profile found in it: that
iteration runs to a fixed point which is no optimum.  Deviations from the mean pitch see the
frozen wake, the mean sees equilibrium.  So the inner problem holds mean(beta) = beta_mean with
the wake frozen there, and the outer search moves beta_mean.  At constant pitch the frozen
loads are the equilibrium loads, hence the inner value is what equilibrium yields for that mean.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike, NDArray

from pitchopt.aero.curves import RotorLoads
from pitchopt.design.coarse import interpolated
from pitchopt.design.direct import Subproblem
from pitchopt.design.problem import DesignProblem, Objective
from pitchopt.design.results import LocalSolution
from pitchopt.design.scp import ScpSettings, solve_local
from pitchopt.design.task import DesignTask
from pitchopt.errors import InputError

__all__ = ["Found", "Start", "best_local", "climb", "graded", "rank", "search", "valued"]

FloatArray = NDArray[np.float64]


_ROUGH = 1e-4  # share of torque that finishing a rough profile may still gain
_NEAR = 2e-3  # share of torque by which a rough profile may trail the best and still be finished
_BASIN = np.radians(1.0)  # profiles of mean pitches further apart do not compare while rough
_FINISHED = 2  # how many of the rough profiles are finished


@dataclass(frozen=True, kw_only=True, eq=False)
class Start:
    """A first profile and what it is called in results."""

    label: str
    profile: FloatArray


@dataclass(frozen=True, kw_only=True, eq=False)
class Found:
    """The best local solution, the start that led there, and the mean pitch of its wake."""

    solution: LocalSolution
    start: str
    mean_pitch: float | None
    iterations: int


def rank(objective: Objective, loads: RotorLoads, value: float) -> float:
    """Value to compare profiles by; broken limits weigh more than any value."""
    return float(graded(objective, value, float(loads.mean[0]), loads.blade_rms))


def valued(problem: DesignProblem, objective: Objective, profile: FloatArray) -> float:
    """:func:`rank` of a profile."""
    loads = problem.curves.evaluate(profile)
    value = problem.value_of(loads, problem.travel(profile), objective)
    return rank(objective, loads, value)


def graded(
    objective: Objective, value: ArrayLike, torque: ArrayLike, blade_rms: ArrayLike
) -> FloatArray:
    """The same from value, mean torque and J_blade of one profile or of many."""
    torque = np.asarray(torque)
    scale = np.maximum(np.abs(torque), 1.0)
    over = np.maximum(objective.torque_min - torque, torque - objective.torque_max)
    broken = np.maximum(over, 0.0) / scale
    if np.isfinite(objective.blade_cap):
        broken = broken + np.maximum(np.asarray(blade_rms) / objective.blade_cap - 1.0, 0.0)
    heavy = 1e3 * scale * max(1.0, *objective.rms)
    return np.asarray(value - np.where(broken > 2e-6, heavy * broken, 0.0))


def _rank(objective: Objective, solution: LocalSolution) -> float:
    return rank(objective, solution.loads, solution.value)


def best_local(
    problem: DesignProblem,
    objective: Objective,
    starts: Sequence[Start],
    *,
    settings: ScpSettings | None = None,
    good_enough: Callable[[float], bool] | None = None,
) -> Found:
    """Best of the local solutions from several starts.

    Several starts are told apart by rough solves on smoothed curves, at fewer rotor positions
    where there are many; the best few are finished on the curves themselves.  With many positions
    so is what the same starts lead to at two dozen of them: many stations hold a local solve back
    where few let it pass.

    Parameters
    ----------
    good_enough : callable, optional
        Asked with the value after each start; True leaves the other starts out (a proven
        bound has been met).
    """
    if not starts:
        raise InputError("starts: got none, expected at least one profile")
    subproblem = Subproblem(problem)
    full = settings or ScpSettings()
    total = 0

    def finished(profile: FloatArray, chosen: ScpSettings) -> tuple[float, LocalSolution]:
        nonlocal total
        solution = solve_local(problem, objective, profile, settings=chosen, subproblem=subproblem)
        total += solution.iterations
        return _rank(objective, solution), solution

    def result(solution: LocalSolution, label: str) -> Found:
        mean = problem.curves.mean_pitch
        return Found(solution=solution, start=label, mean_pitch=mean, iterations=total)

    if len(starts) == 1 or problem.constant_only:
        return result(finished(starts[0].profile, full)[1], starts[0].label)
    screened = problem.coarse or problem
    step = problem.curves.stations // screened.curves.stations
    soft = screened.softened
    screen = Subproblem(soft)
    found: list[tuple[float, FloatArray, str]] = []
    for start in starts:
        rough = solve_local(
            soft, objective, start.profile[::step], settings=full.rough(), subproblem=screen
        )
        total += rough.iterations
        # on the curves themselves an exact start may be better than what smoothing made of it
        ends = [screened.repaired(end) for end in (rough.profile, start.profile[::step])]
        value, coarse = max(
            ((valued(screened, objective, end), end) for end in ends), key=lambda one: one[0]
        )
        profile = problem.repaired(interpolated(coarse, step)) if step > 1 else coarse
        found.append((value, profile, start.label))
        if good_enough is not None and good_enough(value + _ROUGH * problem.torque_scale):
            value, solution = finished(profile, full.finishing())
            if good_enough(value):
                return result(solution, start.label)
    found.sort(key=lambda one: -one[0])
    near = found[0][0] - _NEAR * problem.torque_scale
    chosen = [one for one in found[:_FINISHED] if one[0] >= near]
    means = [float(profile.mean()) for _, profile, _ in chosen]
    apart = [one for one in found if min(abs(one[1].mean() - mean) for mean in means) > _BASIN]
    finals = [
        (*finished(profile, full.finishing()), label) for _, profile, label in chosen + apart[:1]
    ]
    if problem.coarsest is not None:
        stride = problem.curves.stations // problem.coarsest.curves.stations
        few = [replace(start, profile=start.profile[::stride]) for start in starts]
        ahead = best_local(problem.coarsest, objective, few, settings=settings)
        total += ahead.iterations
        profile = problem.repaired(interpolated(ahead.solution.profile, stride))
        finals.append((*finished(profile, full.finishing()), ahead.start))
    _, solution, label = max(finals, key=lambda one: one[0])
    return result(solution, label)


def search(
    task: DesignTask,
    objective: Objective,
    starts: Sequence[Start],
    *,
    settings: ScpSettings | None = None,
    good_enough: Callable[[float], bool] | None = None,
    mean_tolerance: float = np.radians(0.01),
) -> Found:
    """Best profile of a task from the given starts.

    Without a frozen wake this is :func:`best_local`.  With one, all starts are tried at the
    mean pitch of the first, then the outer search goes on from the best.
    """
    if not task.frozen:
        return best_local(
            task.problem(),
            objective,
            starts,
            settings=settings,
            good_enough=good_enough,
        )
    low, high = task.mean_range
    known: dict[float, Found] = {}
    iterations = 0

    def evaluate(mean: float, profiles: Sequence[Start]) -> float:
        nonlocal iterations
        if mean in known:
            return _rank(objective, known[mean].solution)
        problem = task.problem(mean)
        shifted = [
            Start(label=s.label, profile=s.profile - s.profile.mean() + mean) for s in profiles
        ]
        found = best_local(problem, objective, shifted, settings=settings)
        iterations += found.iterations
        known[mean] = found
        return _rank(objective, found.solution)

    def at(mean: float) -> float:
        mean = float(np.clip(mean, low, high))
        nearest = min(known, key=lambda other: abs(other - mean))
        best = known[nearest]
        return evaluate(mean, [Start(label=best.start, profile=best.solution.profile)])

    centre = float(np.clip(starts[0].profile.mean(), low, high))
    evaluate(centre, starts)
    best_mean = climb(at, centre, low, high, mean_tolerance)
    found = known[best_mean]
    return Found(
        solution=found.solution, start=found.start, mean_pitch=best_mean, iterations=iterations
    )


def climb(
    value: Callable[[float], float],
    centre: float,
    low: float,
    high: float,
    tolerance: float = np.radians(0.01),
) -> float:
    """Maximiser of a one-dimensional function: bracket by doubling steps, then parabolas.

    The values are those of local solves and may be rough; every step keeps the best point in
    the middle of the bracket, and golden sections replace parabolas that do not shrink it.
    """
    if high - low <= tolerance:
        return centre
    step = np.radians(0.3)
    points: dict[float, float] = {}

    def f(x: float) -> float:
        x = float(np.clip(x, low, high))
        if x not in points:
            points[x] = value(x)
        return points[x]

    b = centre
    f(b)
    a, c = max(b - step, low), min(b + step, high)
    f(a), f(c)
    for _ in range(24):
        b = max(points, key=lambda x: points[x])
        step *= 1.7
        if b == min(points) and b > low:
            f(b - step)
        elif b == max(points) and b < high:
            f(b + step)
        else:
            break
    for count in range(24):
        b = max(points, key=lambda x: points[x])
        left = [x for x in points if x < b]
        right = [x for x in points if x > b]
        a, c = (max(left) if left else b), (min(right) if right else b)
        if c - a <= 2 * tolerance:
            break
        x = _vertex(a, b, c, points) if a < b < c and count % 3 != 2 else np.nan
        wide = c if c - b > b - a else a
        if not a < x < c or min(abs(x - a), abs(x - c)) < 0.1 * tolerance:
            x = b + 0.382 * (wide - b)
        elif abs(x - b) < 0.5 * tolerance:
            x = b + np.sign(wide - b) * min(0.9 * tolerance, 0.5 * abs(wide - b))
        f(x)
    return max(points, key=lambda x: points[x])


def _vertex(a: float, b: float, c: float, points: dict[float, float]) -> float:
    """Top of the parabola through three points."""
    fa, fb, fc = points[a], points[b], points[c]
    p = (b - a) ** 2 * (fb - fc) - (b - c) ** 2 * (fb - fa)
    q = (b - a) * (fb - fc) - (b - c) * (fb - fa)
    return b - 0.5 * p / q if abs(q) > 1e-300 else float("nan")
