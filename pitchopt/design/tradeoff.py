"""The designs that users ask for: one profile, or the curve between torque and load variation.

The curve is made of points that maximise mean torque - mu x weighted RMS for a grid of mu, and
of the designs of least RMS for a given loss of torque.  At a few anchor values of mu the local
solve starts from several profiles; elsewhere it starts from its neighbours in mu, upwards and
downwards.  Every profile found is then judged at every mu: where another one is better, the
local solve goes on from there, so that the curve is one and Pareto-clean among all that was
found.  The knee is the point farthest below the chord between the ends of the curve, with
both axes scaled to the unit interval.
"""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import ArrayLike, NDArray

from pitchopt.design.constant import best_constant, constant_for_torque, constant_set
from pitchopt.design.power import maximise_torque
from pitchopt.design.problem import Objective
from pitchopt.design.relaxation import Relaxation, relax
from pitchopt.design.results import Design, Status, Tradeoff
from pitchopt.design.scp import LocalSolution
from pitchopt.design.search import Found, Start, climb, search
from pitchopt.design.task import DesignTask, Progress
from pitchopt.errors import InfeasibleError, InputError

__all__ = ["constant", "default_mu", "design", "power_max", "tradeoff"]

FloatArray = NDArray[np.float64]

_LOSSES = (0.03, 0.07)
_CLOSE = 2e-6  # bound met to this share of torque: no further start can gain
_MU_CEILING = 1e6


def default_mu(count: int = 20) -> FloatArray:
    """Prices of RMS that span a trade-off curve, evenly spaced in their logarithm."""
    if count < 1:
        raise InputError(f"points: got {count}, expected at least 1")
    return np.geomspace(0.1, 400.0, count)


def constant(task: DesignTask) -> Design:
    """The constant pitch of largest mean torque."""
    return best_constant(task)


def power_max(task: DesignTask, *, reference: Design | None = None) -> Design:
    """The profile of largest mean torque, the cap on blade load not counted.

    Exact where torque is concave in pitch; with a frozen wake exact for each mean pitch, and
    the outer search over the mean is local.
    """
    began = time.perf_counter()
    start = reference or best_constant(task)
    nothing = Objective(torque=1.0, rms=(0.0, 0.0, 0.0, 0.0, 0.0))
    if not task.frozen:
        solution = maximise_torque(task.problem(), start.profile)
        mean = None
    else:
        known: dict[float, LocalSolution] = {}

        def value(pitch: float) -> float:
            problem = task.problem(pitch)
            known[pitch] = maximise_torque(problem, np.full(problem.curves.stations, pitch))
            return known[pitch].value

        mean = climb(value, float(start.profile.mean()), *task.mean_range)
        solution = known[mean]
    found = Found(
        solution=solution, start=start.message, mean_pitch=mean, iterations=solution.iterations
    )
    return _finished(task, nothing, found, "power_max", 0.0, None, began, None)


def design(
    task: DesignTask,
    *,
    mu: float | None = None,
    max_power_loss: float | None = None,
    mean_torque: float | None = None,
    starts: int = 5,
    certify: bool = True,
    seed: int = 0,
    progress: Progress | None = None,
) -> Design:
    """One pitch profile.

    Exactly one of the three goals is given.

    Parameters
    ----------
    task : DesignTask
    mu : float
        Price of the weighted RMS against mean torque [-].
    max_power_loss : float
        Least weighted RMS for at most this share of the largest mean torque lost.
    mean_torque : float
        Least weighted RMS at this mean torque, held from both sides [N m].
    starts : int
        Profiles that the local solve starts from.
    certify : bool
        Bound the result by the hull relaxation.
    seed : int
        Seed of the random starts beyond the first five.
    progress : callable, optional

    Raises
    ------
    InputError
        If not exactly one goal is given, or it is out of range.
    InfeasibleError
        If no profile gives the mean torque asked for.
    """
    goals = {"mu": mu, "max_power_loss": max_power_loss, "mean_torque": mean_torque}
    given = [name for name, value in goals.items() if value is not None]
    if len(given) != 1:
        raise InputError(
            f"goal: got {' and '.join(given) or 'none'}, expected exactly one of "
            "mu, max_power_loss, mean_torque"
        )
    _check_count("starts", starts)
    if max_power_loss is not None and not 0 < max_power_loss < 1:
        raise InputError(f"max_power_loss: got {max_power_loss}, expected a share between 0 and 1")
    if mean_torque is not None and not np.isfinite(mean_torque):
        raise InputError(f"mean_torque: got {mean_torque}, expected a number [N m]")
    if mu is not None:
        Objective.tradeoff(mu, task.weights)
    work = _Work(task, starts, certify, seed, progress, total=starts + 3)
    work.tick("constant pitch")
    if mean_torque is not None:
        work.reference = constant_for_torque(task, float(mean_torque))
    else:
        work.reference = best_constant(task)
    work.tick("power maximum")
    work.power = power_max(task, reference=best_constant(task))
    if mu is not None:
        return work.point(float(mu), work.first_starts(float(mu)))
    if max_power_loss is not None:
        return work.loss_point(float(max_power_loss), ())
    assert mean_torque is not None
    return work.torque_point(float(mean_torque))


def tradeoff(
    task: DesignTask,
    *,
    mu: ArrayLike | None = None,
    losses: Sequence[float] = _LOSSES,
    starts: int = 5,
    anchors: int = 5,
    certify: bool = True,
    seed: int = 0,
    progress: Progress | None = None,
) -> Tradeoff:
    """Power maximum, best constant pitch and the trade-off curve between torque and RMS.

    Parameters
    ----------
    task : DesignTask
    mu : array, optional
        Prices of the weighted RMS [-]; 20 between 0.1 and 400 by default.
    losses : sequence of float
        Shares of mean torque lost at which the design of least RMS is added.
    starts, anchors : int
        Starts at each anchor value of mu, and the number of anchors.
    certify : bool
        Bound every point by the hull relaxation.
    seed : int
        Seed of the random starts beyond the first five.
    progress : callable, optional
        Called with steps done, steps in all and a label.
    """
    began = time.perf_counter()
    prices = np.sort(default_mu() if mu is None else np.atleast_1d(np.asarray(mu, dtype=float)))
    if prices.size == 0 or not np.all(np.isfinite(prices)) or np.any(prices < 0):
        raise InputError("mu: expected finite prices of 0 or more")
    for loss in losses:
        if not 0 < loss < 1:
            raise InputError(f"losses: got {loss}, expected shares between 0 and 1")
    _check_count("starts", starts)
    _check_count("anchors", anchors)
    work = _Work(task, starts, certify, seed, progress, total=2 * prices.size + len(losses) + 2)
    work.tick("constant pitch")
    work.reference = best_constant(task)
    pitch, torque, rms, pareto = constant_set(task)
    work.tick("power maximum")
    work.power = power_max(task, reference=work.reference)
    points = [
        *work.curve([float(p) for p in prices], anchors),
        *(work.loss_point(float(loss), work.pool) for loss in losses),
    ]
    points.sort(key=lambda point: (point.mu, -point.mean_torque))
    return Tradeoff(
        constant=work.reference,
        power_max=work.power,
        points=tuple(points),
        knee=_knee(work.power, points),
        constant_pitch=pitch,
        constant_torque=torque,
        constant_rms=rms,
        constant_pareto=pareto,
        settings={
            "positions": task.positions,
            "weights": dict(
                zip(("torque", "tilt", "yaw", "thrust", "blade"), task.weights.array, strict=True)
            ),
            "blade_cap": task.blade_cap,
            "harmonics": task.harmonics,
            "travel": task.travel,
            "starts": starts,
            "anchors": anchors,
            "seed": seed,
        },
        seconds=time.perf_counter() - began,
    )


def _check_count(name: str, value: int) -> None:
    if isinstance(value, bool) or int(value) != value or value < 1:
        raise InputError(f"{name}: got {value!r}, expected a whole number of at least 1")


def _knee(power: Design, points: Sequence[Design]) -> int:
    """Index of the point farthest below the chord, both axes scaled to [0, 1]."""
    torque = np.array([power.mean_torque, *(p.mean_torque for p in points)])
    rms = np.array([power.rms_weighted, *(p.rms_weighted for p in points)])
    x = (torque.max() - torque) / max(float(np.ptp(torque)), 1e-300)
    y = (rms - rms.min()) / max(float(np.ptp(rms)), 1e-300)
    return int(np.argmin((x + y)[1:]))


class _Work:
    """What one call shares: references, profiles found so far, starts, progress."""

    def __init__(
        self,
        task: DesignTask,
        starts: int,
        certify: bool,
        seed: int,
        progress: Progress | None,
        *,
        total: int,
    ) -> None:
        self.task, self.starts, self.certify = task, starts, certify
        self.random = np.random.default_rng(seed)
        self.progress, self.total, self.done = progress, total, 0
        self.pool: list[Start] = []
        self.reference: Design
        self.power: Design

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

    def first_starts(self, mu: float) -> list[Start]:
        """Starts for an anchor: constants, power maximum, the relaxation's rounding, random."""
        stations = self.reference.profile.size
        base = float(self.reference.profile.mean())
        low, high = self.task.mean_range
        starts = [
            Start(label="best constant", profile=self.reference.profile),
            Start(label="power maximum", profile=self.power.profile),
        ]
        if not self.task.frozen:
            relaxed = self.bound(self.tradeoff_objective(mu), None, None)
            if relaxed is not None:
                starts.append(Start(label="relaxation", profile=relaxed.profile))
            for share in (0.25, 0.5):
                pitch = base + share * (high - base)
                starts.append(
                    Start(
                        label=f"constant {np.degrees(pitch):.1f} deg",
                        profile=np.full(stations, pitch),
                    )
                )
        psi = 2 * np.pi * np.arange(stations) / stations
        while len(starts) < self.starts:
            offset = self.random.uniform(low, high) if not self.task.frozen else base
            wave = sum(
                self.random.normal(0.0, np.radians(2.0) / n)
                * np.cos(n * psi + self.random.uniform(0, 2 * np.pi))
                for n in (1, 2, 3)
            )
            starts.append(
                Start(label=f"random {len(starts) + 1}", profile=np.asarray(offset + wave))
            )
        return starts[: self.starts]

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
        began = [0.0] * count
        best: list[Found | None] = [None] * count

        def improve(i: int, starts: Sequence[Start]) -> None:
            t = time.perf_counter()
            found = self.solve(self.tradeoff_objective(prices[i]), starts)
            began[i] += time.perf_counter() - t
            known = best[i]
            if known is None or self._value(found, prices[i]) > self._value(known, prices[i]):
                best[i] = found

        for i in sorted(chosen):
            improve(i, self.first_starts(prices[i]))
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
            self.pool.append(Start(label=f"mu {prices[i]:.3g}", profile=found.solution.profile))
            start = time.perf_counter() - began[i]
            points.append(
                self.finish(self.tradeoff_objective(prices[i]), found, "mu", prices[i], None, start)
            )
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

    def _exchange(self, prices: list[float], best: list[Found | None], improve: object) -> bool:
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
            improve(i, [start])  # type: ignore[operator]
            changed = True
        return changed

    def loss_point(self, loss: float, pool: Sequence[Start]) -> Design:
        """Least weighted RMS for at most this loss of torque against the power maximum."""
        began = time.perf_counter()
        limit = (1.0 - loss) * self.power.mean_torque
        objective = self.least_objective(limit)
        starts = list(pool)
        if pool:
            problem = self.task
            gaps = [
                abs(float(problem.problem(None).curves.evaluate(s.profile).mean[0]) - limit)
                if not problem.frozen
                else float(i)
                for i, s in enumerate(pool)
            ]
            starts = [pool[int(i)] for i in np.argsort(gaps)[: max(2, self.starts - 1)]]
        else:
            starts = self.first_starts(30.0)
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
        for k in range(1, self.starts):
            angle = 2 * np.pi * (k - 1) / max(self.starts - 1, 1)
            wave = np.radians(1.0) * np.cos(psi - angle)
            starts.append(
                Start(
                    label=f"constant + 1P at {np.degrees(angle):.0f} deg",
                    profile=self.reference.profile + wave,
                )
            )
        found = self.solve(objective, starts)
        self.tick("mean torque")
        return self._priced(objective, found, "mean_torque", torque, began)

    def _priced(
        self, objective: Objective, found: Found, kind: str, target: float, began: float
    ) -> Design:
        """A design under a torque limit, with the price that the limit's multiplier implies."""
        mult = found.solution.multipliers
        price = abs(mult.torque_min - mult.torque_max)
        mu = min(1.0 / max(price, 1.0 / _MU_CEILING), _MU_CEILING)
        lower = None
        if self.certify:
            relaxed = self.bound(objective, found.mean_pitch, found.solution.profile)
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
        return _finished(
            self.task, objective, found, kind, mu, target, began, relaxed, self.power.mean_torque
        )


def _finished(
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
