"""Finding points: objectives, starts, sweeps over mu.

One :class:`PointFinder` serves one call; it keeps what the points share: the constant pitch
compared with, the power maximum, the profiles found so far.  At anchor values of mu the local
solve starts from several profiles; elsewhere it starts from its neighbours in mu, upwards and
downwards.  Every profile found is then judged at every mu, flattened and constant ones beside it,
and where another one is better the local solve goes on from there.  A price whose profile is the
best of all known for its own objective makes the curve monotone: from T1 - mu1 J1 >= T2 - mu1 J2
and T2 - mu2 J2 >= T1 - mu2 J1 follows (mu2 - mu1) (J1 - J2) >= 0.
"""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from pitchopt.design.flatten import FlatProfiles
from pitchopt.design.judged import PRICES, Judge, finished
from pitchopt.design.power import maximise_torque
from pitchopt.design.problem import Objective
from pitchopt.design.proof import Certificate, ProofSettings
from pitchopt.design.relaxation import Relaxation, relax
from pitchopt.design.results import Design, Status
from pitchopt.design.search import Found, Start, search, valued
from pitchopt.design.task import DesignTask, Progress

__all__ = ["TORQUE_ALONE", "PointFinder"]

FloatArray = NDArray[np.float64]

_CLOSE = 2e-6  # bound met to this share of torque: no further start can gain
_APART = np.radians(0.05)  # somewhere, for a profile to be another one
_HANDOVERS = 10  # rounds of handing profiles over, at most
_CONTENDS = 2e-3  # share by which a profile may trail another and still be solved from
TORQUE_ALONE = Objective(torque=1.0, rms=(0.0, 0.0, 0.0, 0.0, 0.0))
_WAVE = np.radians(0.4)


@dataclass(eq=False)
class _Goal:
    """One point to be found, and the best profile for it so far."""

    kind: str
    number: float
    objective: Objective
    found: Found | None = None
    seconds: float = 0.0

    @property
    def label(self) -> str:
        """What the point is called on the way."""
        if self.kind == "mean_torque":
            return "mean torque"
        return f"mu {self.number:.3g}" if self.kind == "mu" else f"loss {100 * self.number:g} %"


class PointFinder:
    """What one call shares: references, profiles found so far, starts, progress."""

    def __init__(
        self,
        task: DesignTask,
        reference: Design,
        power: Design,
        starts: int,
        certify: bool | ProofSettings,
        seed: int,
        progress: Progress | None,
        *,
        total: int,
        resume: Certificate | None = None,
        best: Design | None = None,
    ) -> None:
        self.best = best or reference  # constant pitch of largest torque
        self.task = task.operating_at(float(reference.profile.mean()))
        self.reference, self.power = reference, power
        self.starts, self.certify = starts, bool(certify)
        self.proof = certify if isinstance(certify, ProofSettings) else None
        self.resume = resume
        self.judge = Judge(self)
        self.random = np.random.default_rng(seed)
        self.progress, self.total, self.done = progress, total, 1

    def tick(self, label: str) -> None:
        """One step further."""
        self.done = min(self.done + 1, self.total)
        if self.progress is not None:
            self.progress(self.done, self.total, label)

    # ---- objectives --------------------------------------------------------------------------

    @property
    def cap(self) -> float:
        """Largest J_blade [N m]."""
        share = self.task.blade_cap
        return np.inf if share is None else share * self.reference.loads.blade_rms

    def tradeoff_objective(self, mu: float) -> Objective:
        """Mean torque minus mu x weighted RMS."""
        return Objective.tradeoff(
            mu, self.task.weights, travel=self.task.travel, blade_cap=self.cap
        )

    def least_objective(self, low: float, high: float = np.inf) -> Objective:
        """Least weighted RMS between two mean torques."""
        return Objective.least_rms(
            self.task.weights,
            travel=self.task.travel,
            blade_cap=self.cap,
            torque_min=low,
            torque_max=high,
        )

    # ---- starts ------------------------------------------------------------------------------

    def first_starts(self, objective: Objective) -> list[Start]:
        """Starts for an anchor, the most different first.

        Best constant pitch, power maximum, the best of the flattened profiles, constants
        towards stall and towards feather, another flattened profile, the relaxation's
        rounding; random ones after that.
        """
        stations = self.reference.profile.size
        base = float(self.reference.profile.mean())
        low, high = self.task.mean_range
        starts = [
            Start(label="best constant", profile=self.reference.profile),
            Start(label="power maximum", profile=self.power.profile),
        ]
        if not self.task.frozen:
            flat = self._flattened(objective)
            starts += flat[:1]
            for share, end in ((0.5, low), (0.25, high)):
                pitch = base + share * (end - base)
                label = f"constant {np.degrees(pitch):.1f} deg"
                starts.append(Start(label=label, profile=np.full(stations, pitch)))
            starts += flat[1:]
            if len(starts) < self.starts:
                relaxed = self.bound(objective, None, None)
                if relaxed is not None:
                    starts.append(Start(label="relaxation", profile=relaxed.profile))
        psi = 2 * np.pi * np.arange(stations) / stations
        while len(starts) < self.starts:
            offset = self.random.uniform(low, high) if not self.task.frozen else base
            wave = sum(
                self.random.normal(0.0, np.radians(2.0) / n)
                * np.cos(n * psi + self.random.uniform(0, 2 * np.pi))
                for n in (1, 2, 3)
            )
            label = f"random {len(starts) + 1}"
            starts.append(Start(label=label, profile=np.asarray(offset + wave)))
        return starts[: self.starts]

    @cached_property
    def flat(self) -> FlatProfiles | None:
        """Flattened profiles of the task; None for few starts or a frozen wake."""
        if self.starts <= 2 or self.task.frozen:
            return None
        return FlatProfiles(self.task.problem(), float(self.best.profile.mean()))

    def _flattened(self, objective: Objective) -> list[Start]:
        return [] if self.flat is None else self.flat.starts(objective)

    def bound(
        self, objective: Objective, mean: float | None, profile: FloatArray | None
    ) -> Relaxation | None:
        """Hull relaxation of a problem."""
        return relax(self.task.problem(mean), objective, profile=profile)

    def solve(self, objective: Objective, starts: Sequence[Start]) -> Found:
        """Search from the starts, the first proven optimum ending it."""
        good_enough = None
        if self.task.problem(self.reference.mean_pitch).constant_only:
            starts = starts[:1]
        if not self.task.frozen and self.certify and len(starts) > 1:
            relaxed = self.bound(objective, None, starts[0].profile)
            if relaxed is not None:
                limit = relaxed.upper_bound - _CLOSE * self.power.mean_torque

                def good_enough(value: float) -> bool:
                    return value >= limit

        return search(self.task, objective, starts, good_enough=good_enough)

    # ---- points ------------------------------------------------------------------------------

    def point(self, mu: float) -> Design:
        """The design of one price."""
        return self._single(_Goal("mu", mu, self.tradeoff_objective(mu)))

    def loss_point(self, loss: float) -> Design:
        """Least weighted RMS for at most this loss of torque against the power maximum."""
        return self._single(_Goal("max_power_loss", loss, self._loss_objective(loss)))

    def _single(self, goal: _Goal) -> Design:
        began = time.perf_counter()
        self._improve(goal, self.first_starts(goal.objective))
        if goal.kind == "max_power_loss":
            self._use_allowance(goal)
        self._challenge(goal)
        self.tick(goal.label)
        return self._finished_goal(goal, began, [goal])

    def curve(self, prices: Sequence[float], losses: Sequence[float], anchors: int) -> list[Design]:
        """Points of all prices and losses.

        Anchors among the prices, sweeps over their neighbours both ways, flattened profiles as
        challengers, the losses from what was found, then every profile at every goal.
        """
        count = len(prices)
        goals = [_Goal("mu", price, self.tradeoff_objective(price)) for price in prices]
        if self.flat is not None:
            least = [self._loss_objective(loss) for loss in losses]
            self.flat.refine([*(goal.objective for goal in goals), *least])
        for i in np.unique(np.linspace(0, count - 1, min(anchors, count)).astype(int)):
            self._improve(goals[i], self.first_starts(goals[i].objective))
            self.tick(goals[i].label)
        anchored = [goal.found is not None for goal in goals]
        for order, side in ((range(count), "below"), (range(count - 1, -1, -1), "above")):
            previous: Found | None = None
            for i in order:
                if previous is not None and (side == "above" or not anchored[i]):
                    start = Start(label=f"mu {side}", profile=previous.solution.profile)
                    self._improve(goals[i], [start])
                if side == "below" and not anchored[i]:
                    self.tick(goals[i].label)
                previous = goals[i].found
        for goal in goals:
            self._challenge(goal)
        self._settle(goals)
        self._raise_power(goals)
        for loss in losses:
            goal = _Goal("max_power_loss", loss, self._loss_objective(loss))
            self._improve(goal, self._loss_starts(goal, goals))
            self._use_allowance(goal)
            self._challenge(goal)
            goals.append(goal)
            self.tick(goal.label)
        self._settle(goals)
        points = []
        for goal in goals:
            since = time.perf_counter() - goal.seconds
            points.append(self._finished_goal(goal, since, goals))
            if goal.kind == "mu":
                self.tick("certificates")
        return points

    def _improve(self, goal: _Goal, starts: Sequence[Start]) -> None:
        """Search from the starts and keep the better of the old and the new profile."""
        began = time.perf_counter()
        found = self.solve(goal.objective, starts)
        goal.seconds += time.perf_counter() - began
        if goal.found is None or self._rank(goal, found) > self._rank(goal, goal.found):
            goal.found = found

    def _challenge(self, goal: _Goal) -> None:
        """Start again from the best flattened or constant profile where that may gain.

        It may where it is better than what was found, or nearly as good and another one.
        """
        if goal.found is None or self.flat is None:
            return
        start, own = self.flat.best(goal.objective), goal.found.solution.profile
        value = valued(self.task.problem(), goal.objective, start.profile)
        lead = (value - self._rank(goal, goal.found)) / self._unit(goal)
        apart = np.max(np.abs(start.profile - own)) > _APART
        if lead > 0 or (apart and lead > -_CONTENDS):
            self._improve(goal, [start])

    def _unit(self, goal: _Goal) -> float:
        """What shares of a goal's value are counted of: torque or RMS [N m]."""
        by_torque = goal.objective.torque > 0
        return self.power.mean_torque if by_torque else self.reference.rms_weighted

    def _rank(self, goal: _Goal, found: Found) -> float:
        """Value of a found profile for a goal; broken limits are not forgiven."""
        solution = found.solution
        if solution.status is Status.SOLVER_FAILED:
            return -np.inf
        return valued(self.task.problem(found.mean_pitch), goal.objective, solution.profile)

    def _settle(self, goals: Sequence[_Goal]) -> None:
        """Hand profiles over until none is the better one for another goal.

        Then torque and RMS both fall with mu, and no point is beaten in both by another, by the
        power maximum or by the constant pitch compared with, where these keep the blade cap.
        """
        for _ in range(_HANDOVERS):
            if not self._exchange(goals):
                break

    def _exchange(self, goals: Sequence[_Goal]) -> bool:
        """Start again wherever a profile of another goal is the better one; True if any was."""
        changed = False
        for goal in goals:
            rivals = [
                (other.label, other.found.solution.profile, other.found.mean_pitch)
                for other in goals
                if other.found is not None
            ]
            rivals += [
                (label, design.profile, design.mean_pitch)
                for label, design in (
                    ("power maximum", self.power),
                    ("best constant", self.reference),
                )
            ]
            values = [
                valued(self.task.problem(mean), goal.objective, profile)
                for _, profile, mean in rivals
            ]
            best = int(np.argmax(values))
            label, profile, mean = rivals[best]
            own = -np.inf if goal.found is None else self._rank(goal, goal.found)
            if values[best] <= own + 1e-7 * self._unit(goal):
                continue
            self._improve(goal, [Start(label=label, profile=profile)])
            assert goal.found is not None
            failed = goal.found.solution.status is Status.SOLVER_FAILED
            if not failed and self._rank(goal, goal.found) < values[best]:
                goal.found = self._taken(goal, goal.found, label, profile, mean)
            changed = changed or self._rank(goal, goal.found) > own
        return changed

    def _taken(
        self, goal: _Goal, found: Found, label: str, profile: FloatArray, mean: float | None
    ) -> Found:
        """Another goal's profile as it is, where the local solve from it ended below it."""
        problem = self.task.problem(mean)
        solution = replace(
            found.solution,
            profile=profile,
            loads=problem.curves.evaluate(profile),
            value=problem.value(profile, goal.objective),
            status=Status.ITERATION_LIMIT,
            message=f"profile of {label}, from which the local solve gained nothing",
        )
        return replace(found, solution=solution, start=label, mean_pitch=mean)

    def _raise_power(self, goals: Sequence[_Goal]) -> None:
        """A local power maximum gives way to any profile that was found to give more torque."""
        found = [goal.found for goal in goals if goal.found is not None]
        top = max(found, key=lambda f: float(f.solution.loads.mean[0]))
        if float(top.solution.loads.mean[0]) > self.power.mean_torque * (1 + 1e-9):
            began = time.perf_counter()
            problem = self.task.problem(top.mean_pitch)
            solution = maximise_torque(problem, top.solution.profile)
            better = replace(top, solution=solution, start=f"{top.start}, then torque alone")
            relaxed = relax(problem, TORQUE_ALONE, profile=solution.profile)
            self.power = finished(
                self.task,
                TORQUE_ALONE,
                better,
                "power_max",
                0.0,
                None,
                began,
                relaxed,
                solution.value,
            )

    def _use_allowance(self, goal: _Goal) -> None:
        """Where a local optimum leaves torque unused, go on from the best that uses it up."""
        limit = goal.objective.torque_min
        if goal.found is None or goal.found.solution.status is Status.SOLVER_FAILED:
            return
        unused = float(goal.found.solution.loads.mean[0]) - limit
        if unused < 0.05 * (self.power.mean_torque - limit):
            return
        start = Start(label=goal.found.start, profile=goal.found.solution.profile)
        held = self.solve(self.least_objective(limit, limit), [start])
        self._improve(goal, [Start(label=f"{start.label}, held", profile=held.solution.profile)])

    def _loss_objective(self, loss: float) -> Objective:
        return self.least_objective((1.0 - loss) * self.power.mean_torque)

    def _loss_starts(self, goal: _Goal, goals: Sequence[_Goal]) -> list[Start]:
        """Profiles found so far that suit a loss best, those nearest to it, flattened ones."""
        limit = goal.objective.torque_min
        known = [other for other in goals if other.found is not None]
        torque = np.array([float(g.found.solution.loads.mean[0]) for g in known if g.found])
        ranks = np.array([self._rank(goal, g.found) for g in known if g.found])
        count = max(2, self.starts - 2)
        picked = dict.fromkeys(
            [
                *np.argsort(-ranks, kind="stable")[:2].tolist(),
                *np.argsort(np.abs(torque - limit), kind="stable")[:count].tolist(),
            ]
        )
        starts = [
            Start(label=known[i].label, profile=known[i].found.solution.profile) for i in picked
        ]
        return starts + self._flattened(goal.objective)

    def _finished_goal(self, goal: _Goal, began: float, goals: Sequence[_Goal]) -> Design:
        assert goal.found is not None
        if goal.kind == "mu":
            return self.judge.finish(goal.objective, goal.found, "mu", goal.number, None, began)
        return self.judge.priced(
            goal.objective,
            goal.found,
            goal.kind,
            goal.number,
            began,
            self.judge.others([goal.found for goal in goals]),
        )

    def torque_point(self, torque: float, other: float | None = None) -> Design:
        """Least weighted RMS at a mean torque held from both sides.

        Parameters
        ----------
        torque : float
            [N m].
        other : float, optional
            Constant pitch of the same torque on the other side of the best one [rad].
        """
        began = time.perf_counter()
        goal = _Goal("mean_torque", torque, self.least_objective(torque, torque))
        self._improve(goal, self._torque_starts(goal.objective, other))
        # flattened profiles hardly ever have the torque itself: those with no less are looked at
        flat = self._flattened(self.least_objective(torque))
        if flat:
            self._improve(goal, flat)
        self.tick(goal.label)
        assert goal.found is not None
        return self.judge.priced(goal.objective, goal.found, goal.kind, torque, began)

    def _torque_starts(self, objective: Objective, other: float | None) -> list[Start]:
        """Constant pitches of the torque, the better one first, and waves about the first."""
        reference = self.reference.profile
        starts = [Start(label="constant pitch", profile=reference)]
        if other is not None:
            label = f"constant {np.degrees(other):.1f} deg"
            starts.append(Start(label=label, profile=np.full(reference.size, other)))
            starts.sort(key=lambda start: -self._constant_value(objective, start.profile))
        if objective.torque_min > self.reference.mean_torque:
            starts.append(Start(label="power maximum", profile=self.power.profile))
        # small once-per-revolution waves: their phase is nearly free, and optima differ in it
        psi = 2 * np.pi * np.arange(reference.size) / reference.size
        waves = max(self.starts - len(starts), 0)
        for k in range(waves):
            angle = 2 * np.pi * k / waves - np.pi / 2
            wave = _WAVE * np.cos(psi + angle)
            label = f"{starts[0].label} + 1P at {-np.degrees(angle):.0f} deg"
            starts.append(Start(label=label, profile=starts[0].profile + wave))
        return starts[: self.starts]

    def _constant_value(self, objective: Objective, profile: FloatArray) -> float:
        return valued(self.task.problem(float(profile.mean())), objective, profile)

    def against(
        self,
        rivals: list[FloatArray],
        objective: Objective,
        found: Found,
        local: float,
        others: FloatArray,
    ) -> tuple[Found, FloatArray]:
        """Local solves at the price of a design, which moves as long as they find new rivals."""
        problem = self.task.problem(found.mean_pitch)
        for _ in range(PRICES):
            mu = self.judge.price(found, local, others)
            goal = _Goal("mu", mu, self.tradeoff_objective(mu))
            own = found.solution.profile
            near = [Start(label="own", profile=own)]
            near += [Start(label="rival", profile=profile) for profile in rivals[-2:]]
            self._improve(goal, [*near, *self.first_starts(goal.objective)])
            self._challenge(goal)
            assert goal.found is not None
            best = goal.found.solution.profile
            values = [problem.value(p, goal.objective) for p in (best, own, *rivals)]
            if self.task.frozen or values[0] <= max(values[1:]) + _CLOSE * self.power.mean_torque:
                break
            rivals.append(best)
            others = np.vstack([others, self.judge.place(found, best)])
            found = self.judge.continued(objective, found, best)
        return found, others
