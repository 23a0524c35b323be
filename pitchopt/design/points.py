"""Finding points: objectives, starts, sweeps over mu, and the result objects.

One :class:`PointFinder` serves one call; it keeps what the points share: the constant pitch
compared with, the power maximum, the profiles found so far.  At anchor values of mu the local
solve starts from several profiles; elsewhere it starts from its neighbours in mu, upwards and
downwards.  Every profile found is then judged at every mu, and where another one is better the
local solve goes on from there.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from pitchopt.aero.curves import RotorLoads
from pitchopt.design.flatten import flattened
from pitchopt.design.problem import Objective
from pitchopt.design.relaxation import Relaxation, relax
from pitchopt.design.results import Design, Status
from pitchopt.design.search import Found, Start, rank, search
from pitchopt.design.task import DesignTask, Progress
from pitchopt.errors import InfeasibleError

__all__ = ["PointFinder", "finished"]

FloatArray = NDArray[np.float64]

_CLOSE = 2e-6  # bound met to this share of torque: no further start can gain
_WAVE = np.radians(0.4)
_TOP_PRICE = 100.0  # price given to a torque limit without a multiplier, in torque over RMS


class PointFinder:
    """What one call shares: references, profiles found so far, starts, progress."""

    def __init__(
        self,
        task: DesignTask,
        reference: Design,
        power: Design,
        starts: int,
        certify: bool,
        seed: int,
        progress: Progress | None,
        *,
        total: int,
    ) -> None:
        self.task = task.operating_at(float(reference.profile.mean()))
        self.reference, self.power = reference, power
        self.starts, self.certify = starts, certify
        self.random = np.random.default_rng(seed)
        self.progress, self.total, self.done = progress, total, 1
        self.pool: list[tuple[Start, float]] = []  # with mean torque

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
    def _flat(self) -> tuple[FloatArray, list[RotorLoads]]:
        """Flattened profiles of the task and their loads; none with a frozen wake."""
        if self.task.frozen:
            return np.empty((0, 0)), []
        problem = self.task.problem()
        profiles = flattened(problem, float(self.reference.profile.mean()))
        return profiles, [problem.curves.evaluate(profile) for profile in profiles]

    def _flattened(self, objective: Objective, count: int = 2) -> list[Start]:
        """The flattened profiles that an objective likes best, a degree apart somewhere."""
        profiles, loads = self._flat
        if not loads:
            return []
        problem = self.task.problem()
        values = np.array(
            [
                rank(problem, objective, load, problem.value_of(load, travel, objective))
                for load, travel in zip(
                    loads, np.abs(np.diff(profiles, axis=1)).sum(axis=1), strict=True
                )
            ]
        )
        chosen: list[FloatArray] = []
        for i in np.argsort(-values):
            if all(np.max(np.abs(profiles[i] - other)) > np.radians(1.0) for other in chosen):
                chosen.append(profiles[i])
            if len(chosen) == count:
                break
        return [
            Start(label=f"flattened {i + 1}", profile=profile) for i, profile in enumerate(chosen)
        ]

    def bound(
        self, objective: Objective, mean: float | None, profile: FloatArray | None
    ) -> Relaxation | None:
        """Hull relaxation of a problem."""
        return relax(self.task.problem(mean), objective, profile=profile)

    def solve(self, objective: Objective, starts: Sequence[Start]) -> Found:
        """Search from the starts, the first proven optimum ending it."""
        good_enough = None
        if not self.task.frozen and self.certify and len(starts) > 1:
            relaxed = self.bound(objective, None, starts[0].profile)
            if relaxed is not None:
                limit = relaxed.upper_bound - _CLOSE * self.power.mean_torque

                def good_enough(value: float) -> bool:
                    return value >= limit

        return search(self.task, objective, starts, good_enough=good_enough)

    # ---- points ------------------------------------------------------------------------------

    def point(self, mu: float, starts: Sequence[Start]) -> Design:
        """The design of one price."""
        began = time.perf_counter()
        objective = self.tradeoff_objective(mu)
        found = self.solve(objective, starts)
        self.tick(f"mu {mu:.3g}")
        return self.finish(objective, found, "mu", mu, None, began)

    def curve(self, prices: list[float], anchors: int) -> list[Design]:
        """Points of all prices: anchors, sweeps both ways, then every profile at every price."""
        count = len(prices)
        chosen = set(np.unique(np.linspace(0, count - 1, min(anchors, count)).astype(int)))
        spent = [0.0] * count
        best: list[Found | None] = [None] * count

        def improve(i: int, starts: Sequence[Start]) -> None:
            t = time.perf_counter()
            found = self.solve(self.tradeoff_objective(prices[i]), starts)
            spent[i] += time.perf_counter() - t
            known = best[i]
            if known is None or self._value(found, prices[i]) > self._value(known, prices[i]):
                best[i] = found

        for i in sorted(chosen):
            improve(i, self.first_starts(self.tradeoff_objective(prices[i])))
            self.tick(f"mu {prices[i]:.3g}")
        for order, label in ((range(count), "below"), (range(count - 1, -1, -1), "above")):
            previous: Found | None = None
            for i in order:
                if previous is not None and (i not in chosen or label == "above"):
                    start = Start(label=f"mu {label}", profile=previous.solution.profile)
                    improve(i, [start])
                if label == "below" and i not in chosen:
                    self.tick(f"mu {prices[i]:.3g}")
                previous = best[i]
        for _ in range(3):
            if not self._exchange(prices, best, improve):
                break
        points = []
        for i, found in enumerate(best):
            assert found is not None
            start = Start(label=f"mu {prices[i]:.3g}", profile=found.solution.profile)
            self.pool.append((start, float(found.solution.loads.mean[0])))
            since = time.perf_counter() - spent[i]
            objective = self.tradeoff_objective(prices[i])
            points.append(self.finish(objective, found, "mu", prices[i], None, since))
            self.tick("certificates")
        return points

    def _value(self, found: Found, mu: float) -> float:
        """Objective of a found profile at another price; limits broken are not forgiven."""
        solution = found.solution
        if solution.status in (Status.INFEASIBLE, Status.SOLVER_FAILED):
            return -np.inf
        travel = self.task.problem(found.mean_pitch).travel(solution.profile)
        return self.task.problem(found.mean_pitch).value_of(
            solution.loads, travel, self.tradeoff_objective(mu)
        )

    def _exchange(
        self,
        prices: list[float],
        best: list[Found | None],
        improve: Callable[[int, Sequence[Start]], None],
    ) -> bool:
        """Start again wherever another price's profile is the better one; True if any was."""
        changed = False
        threshold = 1e-7 * self.power.mean_torque
        for i, mu in enumerate(prices):
            values = [self._value(found, mu) if found is not None else -np.inf for found in best]
            j = int(np.argmax(values))
            other = best[j]
            if other is None or values[j] <= values[i] + threshold:
                continue
            start = Start(label=f"mu {prices[j]:.3g}", profile=other.solution.profile)
            improve(i, [start])
            changed = True
        return changed

    def loss_point(self, loss: float, pool: Sequence[tuple[Start, float]]) -> Design:
        """Least weighted RMS for at most this loss of torque against the power maximum."""
        began = time.perf_counter()
        limit = (1.0 - loss) * self.power.mean_torque
        objective = self.least_objective(limit)
        if pool:
            gaps = [abs(torque - limit) for _, torque in pool]
            nearest = np.argsort(gaps, kind="stable")[: max(2, self.starts - 2)]
            starts = [pool[int(i)][0] for i in nearest] + self._flattened(objective)
        else:
            starts = self.first_starts(objective)
        found = self.solve(objective, starts)
        self.tick(f"loss {100 * loss:g} %")
        return self._priced(objective, found, "max_power_loss", loss, began)

    def torque_point(self, torque: float) -> Design:
        """Least weighted RMS at a mean torque held from both sides."""
        began = time.perf_counter()
        objective = self.least_objective(torque, torque)
        stations = self.reference.profile.size
        psi = 2 * np.pi * np.arange(stations) / stations
        starts = [Start(label="constant pitch", profile=self.reference.profile)]
        if torque > self.reference.mean_torque:
            starts.append(Start(label="power maximum", profile=self.power.profile))
        # small once-per-revolution waves: their phase is nearly free, and optima differ in it
        waves = max(self.starts - len(starts), 0)
        for k in range(waves):
            angle = 2 * np.pi * k / waves - np.pi / 2
            wave = _WAVE * np.cos(psi + angle)
            label = f"constant + 1P at {-np.degrees(angle):.0f} deg"
            starts.append(Start(label=label, profile=self.reference.profile + wave))
        found = self.solve(objective, starts)
        self.tick("mean torque")
        return self._priced(objective, found, "mean_torque", torque, began)

    def _priced(
        self, objective: Objective, found: Found, kind: str, target: float, began: float
    ) -> Design:
        """A design under a torque limit, with the price that the limit's multiplier implies."""
        mult = found.solution.multipliers
        price = abs(mult.torque_min - mult.torque_max)
        reference = self.reference
        top = _TOP_PRICE * reference.mean_torque / max(reference.rms_weighted, 1e-300)
        mu = min(1.0 / max(price, 1e-300), top)
        lower = None
        if self.certify:
            # of the RMS alone: travel has its price in the design, not in what is bounded
            bare = replace(objective, travel=0.0)
            relaxed = self.bound(bare, found.mean_pitch, found.solution.profile)
            if relaxed is not None:
                lower = max(0.0, -relaxed.upper_bound)
        result = self.finish(self.tradeoff_objective(mu), found, kind, mu, target, began)
        return replace(result, rms_lower_bound=lower)

    def finish(
        self,
        objective: Objective,
        found: Found,
        kind: str,
        mu: float,
        target: float | None,
        began: float,
    ) -> Design:
        """The result object, bounded if wanted."""
        relaxed = None
        if self.certify:
            relaxed = self.bound(objective, found.mean_pitch, found.solution.profile)
        return finished(
            self.task, objective, found, kind, mu, target, began, relaxed, self.power.mean_torque
        )


def finished(
    task: DesignTask,
    objective: Objective,
    found: Found,
    kind: str,
    mu: float,
    target: float | None,
    began: float,
    relaxed: Relaxation | None,
    scale: float | None = None,
) -> Design:
    """Result object of a profile that was found.

    Raises
    ------
    InfeasibleError
        If a mean torque was to be held and no profile holds it.
    """
    problem, solution = task.problem(found.mean_pitch), found.solution
    if solution.status is Status.INFEASIBLE and kind == "mean_torque":
        raise InfeasibleError(f"{kind}: {solution.message}")
    between = task.between(solution.profile, found.mean_pitch)
    value = problem.value(solution.profile, objective)
    bound = None if relaxed is None else relaxed.upper_bound
    return Design(
        kind=kind,
        mu=mu,
        target=target,
        azimuth=problem.curves.azimuth,
        profile=solution.profile,
        loads=solution.loads,
        between=between,
        rms_weighted=task.weights.weighted(solution.loads),
        rms_weighted_between=None if between is None else task.weights.weighted(between),
        objective=value,
        upper_bound=bound,
        gap=None if bound is None or scale is None else (bound - value) / scale,
        rms_lower_bound=None,
        certificate=None if relaxed is None else relaxed.multipliers,
        mean_pitch=found.mean_pitch,
        status=solution.status,
        message=solution.message,
        start=found.start,
        iterations=found.iterations,
        seconds=time.perf_counter() - began,
        history=solution.history,
    )
