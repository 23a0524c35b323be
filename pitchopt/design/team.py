"""What a design for several winds shares: the winds, their own optima, starts, the joint search.

One :class:`Team` serves one call.  Each wind's own optimum V*_w comes from the single-wind search
and is what regret is counted from; all of them, shared, shifted or laid side by side, are starts
of the joint search.
"""

from __future__ import annotations

import time
from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike, NDArray

from pitchopt.checks import finite_array, whole_number
from pitchopt.design.constant_pitch import best_constant
from pitchopt.design.goals import power_max
from pitchopt.design.joint import JointProblem
from pitchopt.design.joint_bound import JointBound, joint_bound
from pitchopt.design.joint_scp import JointLocal, best_joint, joint_rank, solve_joint
from pitchopt.design.points import PointFinder
from pitchopt.design.problem import DesignProblem, Objective
from pitchopt.design.scp import ScpSettings, solve_local
from pitchopt.design.search import Start, best_local, rank
from pitchopt.design.several_results import Several, WindResult
from pitchopt.design.task import DesignTask, Progress
from pitchopt.errors import InputError

__all__ = ["Team"]

FloatArray = NDArray[np.float64]

_EVERY = 12  # of so many winds one is searched from all starts, the others from what is known
_LARGEST_SHIFT = float(np.radians(5.0))
_SHIFTS = 21  # shifts that are tried from one wind to the next


class Team:
    """What one call shares: winds, their own optima, progress."""

    def __init__(
        self,
        tasks: Sequence[DesignTask],
        mu: ArrayLike,
        weights: ArrayLike | None,
        labels: Sequence[str] | None,
        starts: int,
        seed: int,
        progress: Progress | None,
        *,
        more: int,
    ) -> None:
        tasks = list(tasks)
        if not tasks:
            raise InputError("winds: got none, expected at least one")
        count = len(tasks)
        for number, task in enumerate(tasks):
            if task.frozen:
                raise InputError(
                    f"winds: number {number} has a frozen wake, expected induction none or "
                    "equilibrium: each frozen wake holds for one mean pitch only"
                )
        self.starts = whole_number("starts", starts, at_least=1)
        self.seed = whole_number("seed", seed, at_least=0)
        self.weights = _weights(weights, count)
        self.mu = _prices(mu, count)
        names = [f"wind {w + 1}" for w in range(count)] if labels is None else list(labels)
        if len(names) != count:
            raise InputError(f"labels: got {len(names)}, expected {count}, one for each wind")
        self.labels = [str(name) for name in names]
        self.progress, self.total, self.done = progress, count + more, 0
        self.constants = [best_constant(task) for task in tasks]
        self.tasks = [
            task.operating_at(float(best.profile.mean()))
            for task, best in zip(tasks, self.constants, strict=True)
        ]
        self.problems: list[DesignProblem] = [task.problem() for task in self.tasks]
        self.objectives: list[Objective] = [
            Objective.tradeoff(
                float(price),
                task.weights,
                travel=task.travel,
                blade_cap=np.inf
                if task.blade_cap is None
                else task.blade_cap * best.loads.blade_rms,
            )
            for price, task, best in zip(self.mu, self.tasks, self.constants, strict=True)
        ]
        self.own: list[FloatArray] = []
        self.pool: list[Start] = []  # starts of the winds that are searched from all
        self.targets = np.zeros(count)

    def tick(self, label: str) -> None:
        """One step further."""
        self.done = min(self.done + 1, self.total)
        if self.progress is not None:
            self.progress(self.done, self.total, label)

    # ---- own optima ------------------------------------------------------------------------

    def find_own(self) -> None:
        """Each wind's own optimum by the single-wind search.

        The first, the last and some winds between from all starts, the others from whichever
        of those starts and of the optima before suits them best; then every wind goes on from
        any other's optimum that suits it better.
        """
        for w, task in enumerate(self.tasks):
            problem, objective = self.problems[w], self.objectives[w]
            if w % _EVERY == 0 or w == len(self.tasks) - 1:
                constant = self.constants[w]
                power = power_max(task, reference=constant)
                finder = PointFinder(
                    task, constant, power, self.starts, False, self.seed, None, total=1
                )
                first = finder.first_starts(objective)
                self.pool += first
                if self.own:
                    first.append(Start(label="neighbour", profile=self.own[-1]))
                found = best_local(problem, objective, first).solution
            else:
                known = [
                    problem.repaired(p)
                    for p in [self.constants[w].profile, *(s.profile for s in self.pool), *self.own]
                ]
                best = max(known, key=lambda profile: self._value(w, profile))
                found = solve_local(problem, objective, best, settings=ScpSettings().finishing())
            self.own.append(found.profile)
            self.targets[w] = self._value(w, found.profile)
            self.tick(self.labels[w])
        for w, profile in enumerate(self.own):  # an own optimum may suit another wind better
            for profile_ in self.own:
                if profile_ is not profile:
                    self._raise(w, profile_)

    def _value(self, w: int, profile: FloatArray) -> float:
        problem, objective = self.problems[w], self.objectives[w]
        loads = problem.curves.evaluate(profile)
        value = problem.value_of(loads, problem.travel(profile), objective)
        return rank(objective, loads, value)

    def _raise(self, w: int, profile: FloatArray) -> bool:
        """Go on from a profile that suits a wind better than its own optimum; True if it does."""
        problem, objective = self.problems[w], self.objectives[w]
        profile = problem.repaired(profile)
        gain = self._value(w, profile) - self.targets[w]
        if gain <= 1e-9 * abs(self.targets[w]):
            if gain > 0:
                self.own[w], self.targets[w] = profile, self.targets[w] + gain
            return False
        found = solve_local(problem, objective, profile, settings=ScpSettings().finishing())
        best = max((profile, found.profile), key=lambda beta: self._value(w, beta))
        self.own[w], self.targets[w] = best, self._value(w, best)
        return True

    def improve_own(self, rows: FloatArray) -> bool:
        """Let the joint solution improve own optima that it beats; True if it beat any."""
        better = False
        for w in range(len(self.own)):
            better = self._raise(w, rows[w % rows.shape[0]]) or better
        return better

    def own_starts(self) -> list[tuple[str, FloatArray]]:
        """Own optima, what some of them were searched from, and what they are called."""
        own = [(f"optimum of {name}", p) for name, p in zip(self.labels, self.own, strict=True)]
        return own + [(start.label, start.profile) for start in self.pool]

    def shifted(self, change: float) -> list[tuple[str, FloatArray]]:
        """For every wind its own optimum, carried on to the others by the best constant shifts.

        From one wind to the next the profile moves as a whole, by the shift within the change
        that suits the next wind best.
        """
        count = len(self.own)
        reach = min(change, _LARGEST_SHIFT)
        starts = []
        for first, label in enumerate(self.labels):
            rows = [self.own[first]] * count
            for side in (range(first + 1, count), range(first - 1, -1, -1)):
                previous = self.own[first]
                for w in side:
                    moved = [previous + shift for shift in np.linspace(-reach, reach, _SHIFTS)]
                    moved = [self.problems[w].repaired(profile) for profile in moved]
                    values = [self._value(w, profile) for profile in moved]
                    previous = moved[int(np.argmax(values))]
                    rows[w] = previous
            starts.append((f"optimum of {label}, shifted", np.concatenate(rows)))
        return starts

    # ---- joint -----------------------------------------------------------------------------

    def solve(
        self,
        joint: JointProblem,
        starts: list[tuple[str, FloatArray]],
        count: int,
        *,
        settings: ScpSettings | None = None,
    ) -> JointLocal:
        """Joint search from so many of the starts, those that the joint objective likes best.

        The result is never worse than the best of the starts, all of them repaired.  Settings
        are given where it is only a start itself.
        """
        ranked = []
        for label, profile in starts:
            start = Start(label=label, profile=joint.repaired(profile))
            ranked.append((joint_rank(joint, start.profile), start))
        ranked.sort(key=lambda one: -one[0])
        chosen = [start for _, start in ranked[:count]]
        found = best_joint(joint, chosen, settings=settings)
        if ranked[0][0] > joint_rank(joint, found.profile):
            found = solve_joint(joint, chosen[0])
        self.tick("joint design")
        return found

    def result(
        self,
        goal: str,
        joint: JointProblem,
        found: JointLocal,
        change: float,
        certify: bool,
        began: float,
    ) -> Several:
        """The result object, bounded if wanted."""
        bound: JointBound | None = None
        if certify:
            bound = joint_bound(joint, found.profile, multipliers=found.multipliers)
            self.tick("bound")
        shares = self.weights
        if goal == "regret" and found.multipliers is not None:
            shares = found.multipliers.shares
        torque = np.array([abs(best.mean_torque) for best in self.constants])
        scale = float(torque.max()) if goal == "regret" else float(self.weights @ torque)
        value = joint.total(found.values)
        rows = joint.split(found.profile)
        if goal == "schedule" and joint.count < len(self.tasks):
            rows = np.tile(rows, (len(self.tasks), 1))
        return Several(
            goal=goal,
            azimuth=self.problems[0].curves.azimuth,
            profiles=rows,
            change=change,
            winds=tuple(
                WindResult(
                    label=self.labels[w],
                    weight=float(shares[w]),
                    constant=self.constants[w],
                    loads=found.loads[w],
                    rms_weighted=task.weights.weighted(found.loads[w]),
                    objective=float(found.values[w]),
                    own_objective=float(self.targets[w]),
                    own_profile=self.own[w],
                )
                for w, task in enumerate(self.tasks)
            ),
            objective=value,
            upper_bound=None if bound is None else bound.upper_bound,
            gap=None if bound is None else (bound.upper_bound - value) / scale,
            certificate=None if bound is None else bound.multipliers,
            status=found.status,
            message=found.message,
            start=found.start,
            iterations=found.iterations,
            seconds=time.perf_counter() - began,
            history=found.history,
            settings={
                "goal": goal,
                "mu": self.mu.tolist(),
                "weights": None if goal == "regret" else self.weights.tolist(),
                "change": None if np.isinf(change) else change,
                "starts": self.starts,
                "seed": self.seed,
            },
        )


def _weights(weights: ArrayLike | None, count: int) -> FloatArray:
    if weights is None:
        return np.full(count, 1.0 / count)
    array = finite_array("weights", weights)
    if array.size != count:
        raise InputError(f"weights: got {array.size}, expected {count}, one for each wind")
    if np.any(array < 0) or not array.sum() > 0:
        raise InputError(
            f"weights: got {array.tolist()}, expected numbers of 0 or more that are not all 0"
        )
    return np.asarray(array / array.sum())


def _prices(mu: ArrayLike, count: int) -> FloatArray:
    array = finite_array("mu", np.atleast_1d(np.asarray(mu)))
    if array.size not in (1, count):
        raise InputError(f"mu: got {array.size} numbers, expected one, or {count}, one a wind")
    return np.broadcast_to(array, (count,))
