"""One profile for several winds, and a schedule of profiles over wind speed.

    robust     maximise sum_w p_w V_w(beta), or minimise max_w (V*_w - V_w(beta)), one beta
    schedule   maximise sum_s p_s V_s(beta_s),  |beta_n^(s+1) - beta_n^(s)| <= C

V_w is mean torque - mu x weighted RMS of wind w (and its price of travel) under its cap on blade
load, V*_w what the single-wind search finds for that wind alone.  All of it is solved jointly
(:mod:`pitchopt.design.joint_scp`) and bounded jointly (:mod:`pitchopt.design.joint_bound`).
Each wind's own optimum, shared or laid side by side, is among the starts, so that the result is
never worse than any of them.
"""

from __future__ import annotations

import contextlib
import time
from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike

from pitchopt.checks import finite_number
from pitchopt.design.joint import JointProblem
from pitchopt.design.scp import ScpSettings
from pitchopt.design.several_results import Several, WindResult
from pitchopt.design.task import DesignTask, Progress
from pitchopt.design.team import Team
from pitchopt.errors import InputError

__all__ = ["Several", "WindResult", "robust", "schedule"]

_ZERO_CHANGE = 1e-9  # [rad]; a smaller change leaves one profile for all speeds


def robust(
    tasks: Sequence[DesignTask],
    *,
    mu: ArrayLike,
    goal: str = "mean",
    weights: ArrayLike | None = None,
    labels: Sequence[str] | None = None,
    starts: int = 3,
    certify: bool = True,
    seed: int = 0,
    progress: Progress | None = None,
) -> Several:
    """One profile for a set of winds.

    Parameters
    ----------
    tasks : sequence of DesignTask
        One for each wind, with the same stations; rate and range are the strictest of all.
    mu : float or array (W,)
        Price of the weighted RMS, the same for all winds or one for each.
    goal : {"mean", "regret"}
        Largest weighted sum of the objectives, or least largest regret.
    weights : array (W,), optional
        p_w of 0 or more, brought to sum one; equal by default. Not with ``regret``.
    labels : sequence of str, optional
        What the winds are called.
    starts : int
        Starts of the search for each wind's own optimum, and of the joint search.
    certify : bool
        Bound the result.
    seed : int
        Seed of random starts beyond the first five.
    progress : callable, optional

    Raises
    ------
    InputError
        If there are no winds, they do not share their stations, a wake is frozen, a number is
        out of range, or no profile keeps the limits of all winds.
    """
    if goal not in ("mean", "regret"):
        raise InputError(f"goal: got {goal!r}, expected mean or regret")
    if goal == "regret" and weights is not None:
        raise InputError("weights: got some with the goal regret, which counts every wind alike")
    began = time.perf_counter()
    team = Team(tasks, mu, weights, labels, starts, seed, progress, more=3 if certify else 2)
    problems, objectives = team.problems, team.objectives
    mean = JointProblem.of(problems, objectives, weights=team.weights)
    team.find_own()
    joint = mean
    quick = ScpSettings().rough() if goal == "regret" else None
    found = team.solve(mean, team.own_starts(), 2 * team.starts, settings=quick)
    if goal == "regret":
        for _ in range(3):
            joint = JointProblem.of(problems, objectives, targets=team.targets.copy())
            candidates = [("weighted mean", found.profile), *team.own_starts()]
            found = team.solve(joint, candidates, 2 * team.starts)
            if not team.improve_own(found.profile[None, :]):
                break
        # own optima that the last profile raised count in what is reported
        joint = JointProblem.of(problems, objectives, targets=team.targets.copy())
    else:
        team.improve_own(found.profile[None, :])
    return team.result(goal, joint, found, np.inf, certify, began)


def schedule(
    tasks: Sequence[DesignTask],
    *,
    mu: ArrayLike,
    change: float,
    weights: ArrayLike | None = None,
    labels: Sequence[str] | None = None,
    starts: int = 3,
    certify: bool = True,
    seed: int = 0,
    progress: Progress | None = None,
) -> Several:
    """A profile for each wind of a row, with a bounded change from one to the next.

    Parameters
    ----------
    tasks : sequence of DesignTask
        In the order of the table, usually over wind speed.
    change : float
        Largest change of pitch between neighbours at any station [rad]; zero makes one profile
        for all, infinity leaves them free of each other.
    mu, weights, labels, starts, certify, seed, progress
        As in :func:`robust`.

    Raises
    ------
    InputError
        As :func:`robust`; and if a restriction to harmonics is to be scheduled, or the limits
        of neighbours are farther apart than the change.
    """
    change = _change(change)
    began = time.perf_counter()
    team = Team(tasks, mu, weights, labels, starts, seed, progress, more=4 if certify else 3)
    shared = change <= _ZERO_CHANGE
    count = len(team.problems)
    joint = JointProblem.of(
        team.problems,
        team.objectives,
        profile_of=None if shared else range(count),
        weights=team.weights,
        change=change,
    )
    team.find_own()
    if shared:
        first = team.own_starts()
    else:
        first = [("own optima", np.concatenate(team.own)), *team.shifted(change)]
        alike = team.own_starts()
        with contextlib.suppress(InputError):  # the winds' limits may leave nothing in common
            mean = JointProblem.of(team.problems, team.objectives, weights=team.weights)
            alike.append(("one profile for all", team.solve(mean, alike, 2 * team.starts).profile))
        first += [(label, np.tile(profile, count)) for label, profile in alike]
    found = team.solve(joint, first, 2 * team.starts)
    rows = np.tile(found.profile, (count, 1)) if shared else joint.split(found.profile)
    if team.improve_own(rows) and not shared:
        found = team.solve(joint, [(found.start, found.profile)], 1)
    return team.result("schedule", joint, found, change, certify, began)


def _change(change: float) -> float:
    return np.inf if change == np.inf else finite_number("change", change, at_least=0)
