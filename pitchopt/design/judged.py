"""Judging points: prices, bounds, proofs and the result objects of profiles that were found.

A design for a given loss of torque is judged at a price (:mod:`pitchopt.design.price`), every
design by the hull relaxation and, if wanted, by branch and bound (:mod:`pitchopt.design.proof`).
What these come upon that is better replaces the design.
"""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from pitchopt.design.price import supporting_price
from pitchopt.design.problem import Objective
from pitchopt.design.proof import FIRST_GAP, Certificate, ProvenBound, prove_in_stages
from pitchopt.design.relaxation import Relaxation
from pitchopt.design.results import Design, Status
from pitchopt.design.scp import solve_local
from pitchopt.design.search import Found, valued
from pitchopt.design.task import DesignTask
from pitchopt.errors import InfeasibleError

if TYPE_CHECKING:
    from pitchopt.design.points import PointFinder

__all__ = ["PRICES", "Judge", "finished"]

FloatArray = NDArray[np.float64]

PRICES = 8  # tried for a loss
_RESERVE = 0.1  # of the gap, for small gains that a branch and bound does not end for
_TOP_PRICE = 100.0  # in torque over RMS; a limit with a higher one counts as not binding


class Judge:
    """Prices, bounds and result objects for the points of one finder."""

    def __init__(self, finder: PointFinder) -> None:
        self.finder = finder

    def others(self, profiles: Sequence[Found | None]) -> FloatArray:
        """Mean torque less the price of travel, and weighted RMS, of the profiles known, (P, 2)."""
        solutions = [found.solution for found in profiles if found is not None]
        known = [
            (design.profile, design.loads) for design in (self.finder.reference, self.finder.power)
        ]
        known += [(s.profile, s.loads) for s in solutions if s.status is not Status.SOLVER_FAILED]
        weights, most = self.finder.task.weights, self.finder.cap * (1 + 1e-9)
        rows = [
            np.array(
                [
                    (float(loads.mean[0]) - self._travel(profile), weights.weighted(loads))
                    for profile, loads in known
                    if loads.blade_rms <= most
                ]
            ).reshape(-1, 2)
        ]
        if self.finder.flat is not None:
            pool = self.finder.flat.pool
            worth = pool.torque - self.finder.task.travel * pool.travel
            rows.append(np.stack([worth, weights.array @ pool.rms], axis=1)[pool.rms[4] <= most])
        return np.concatenate(rows)

    def _travel(self, profile: FloatArray) -> float:
        """Price of a profile's pitch travel [N m]."""
        if not self.finder.task.travel:
            return 0.0
        return self.finder.task.travel * float(np.abs(np.roll(profile, -1) - profile).sum())

    def priced(
        self,
        objective: Objective,
        found: Found,
        kind: str,
        target: float,
        began: float,
        others: FloatArray | None = None,
    ) -> Design:
        """A design under a torque limit, with the price that the limit's multiplier implies.

        Where the limit has a multiplier, objective and bound are those of the trade-off at that
        price, or at one at which no other known profile is better
        (:mod:`pitchopt.design.price`).  Without one (the limit does not bind, or only through
        the outer search of a frozen wake) there is no price, mu is NaN, and they are those of the
        least RMS itself; so they are for a torque held from both sides.
        """
        mult = found.solution.multipliers
        price = mult.torque_min - mult.torque_max
        top = (
            _TOP_PRICE
            * self.finder.power.mean_torque
            / max(self.finder.reference.rms_weighted, 1e-300)
        )
        mu = 1.0 / price if price > 1.0 / top else np.nan
        lower = None
        if self.finder.certify:
            # of the RMS alone: travel has its price in the design, not in what is bounded
            bare = replace(objective, travel=0.0)
            relaxed = self.finder.bound(bare, found.mean_pitch, found.solution.profile)
            if relaxed is not None:
                lower = max(0.0, -relaxed.upper_bound)
        if kind == "max_power_loss" and np.isfinite(mu):
            assert others is not None
            result = self._supported(objective, found, target, began, float(mu), others)
            mu = result.mu
        else:
            result = self.finish(objective, found, kind, float(mu), target, began)
        if lower is not None and result.upper_bound is not None and self.finder.task.travel == 0:
            # T - mu J <= bound at mean torques of the limit and above
            if kind == "max_power_loss" and np.isfinite(mu):
                lower = max(lower, (objective.torque_min - result.upper_bound) / mu)
            else:
                lower = max(lower, -result.upper_bound)
        return replace(result, rms_lower_bound=lower)

    def _supported(
        self,
        objective: Objective,
        found: Found,
        loss: float,
        began: float,
        local: float,
        others: FloatArray,
    ) -> Design:
        """A design for a loss, judged at a price at which no other known profile is better.

        With a branch and bound, rivals are looked for first: local solves at the price, which
        moves until none is better than the design, or until the price that it falls behind
        least at is found.  One that the branch and bound still comes upon ends it, and the
        price moves on.
        """
        problem = self.finder.task.problem(found.mean_pitch)
        rivals: list[FloatArray] = []
        left = np.inf if self.finder.proof is None else self.finder.proof.seconds
        for attempt in range(PRICES):
            since = time.perf_counter()
            if self.finder.resume is not None:
                mu = self._resumed_price(self.finder.resume)
            else:
                if self.finder.proof is not None:
                    found, others = self.finder.against(rivals, objective, found, local, others)
                mu = self.price(found, local, others)
            judged = self.finder.tradeoff_objective(mu)
            relaxed, proven = None, None
            if self.finder.certify:
                relaxed = self.finder.bound(judged, found.mean_pitch, found.solution.profile)
            if relaxed is not None and self.finder.proof is not None:
                last = attempt == PRICES - 1 or self.finder.resume is not None
                known = [found.solution.profile, *rivals]
                best = max(known, key=lambda profile: problem.value(profile, judged))
                reserve = 0.0 if last else _RESERVE
                proven = self._proven(judged, found, relaxed, left, best=best, reserve=reserve)
                left = max(left - (time.perf_counter() - since), 0.0)
            if proven is None or proven.ended != "better profile":
                break
            rivals.append(proven.profile)
            others = np.vstack([others, self.place(found, proven.profile)])
            found = self.continued(objective, found, proven.profile)
        return finished(
            self.finder.task, judged, found, "max_power_loss", mu, loss, began, relaxed,
            self.finder.power.mean_torque, proven,
        )  # fmt: skip

    def _resumed_price(self, certificate: Certificate) -> float:
        """The price in the objective of an earlier proof."""
        weights = self.finder.task.weights.array
        heaviest = int(np.argmax(weights))
        return certificate.objective.rms[heaviest] / (float(weights[heaviest]) or 1.0)

    def place(self, found: Found, profile: FloatArray) -> tuple[float, float]:
        """Mean torque less the price of travel, and weighted RMS, of a profile."""
        loads = self.finder.task.problem(found.mean_pitch).curves.evaluate(profile)
        worth = float(loads.mean[0]) - self._travel(profile)
        return worth, self.finder.task.weights.weighted(loads)

    def price(self, found: Found, local: float, others: FloatArray) -> float:
        """The price that a design for a loss is judged at."""
        if (
            self.finder.task.frozen
        ):  # profiles of other means are no rivals: bounds are for one mean
            return local
        return supporting_price(*self.place(found, found.solution.profile), others, local)

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
        relaxed, proven = None, None
        if self.finder.certify:
            relaxed = self.finder.bound(objective, found.mean_pitch, found.solution.profile)
        if relaxed is not None and self.finder.proof is not None:
            proven = self._proven(objective, found, relaxed, self.finder.proof.seconds)
            if proven is not None and proven.improved:
                found = self.continued(objective, found, proven.profile)
        return finished(
            self.finder.task,
            objective,
            found,
            kind,
            mu,
            target,
            began,
            relaxed,
            self.finder.power.mean_torque,
            proven,
        )

    def _proven(
        self,
        objective: Objective,
        found: Found,
        relaxed: Relaxation,
        seconds: float,
        *,
        best: FloatArray | None = None,
        reserve: float = 0.0,
    ) -> ProvenBound | None:
        """Branch and bound, where the hull relaxation leaves a larger gap than wanted.

        ``best`` is a profile that is known to be better by the objective than the design.  With a
        ``reserve``, a share of the gap, it ends when it finds one better than that by so much.
        """
        assert self.finder.proof is not None
        problem, profile = self.finder.task.problem(found.mean_pitch), found.solution.profile
        scale = self.finder.power.mean_torque
        if objective.torque == 0:  # then nothing is worth torque: the RMS measures itself
            scale = self.finder.task.weights.weighted(found.solution.loads)
        value = problem.value(profile, objective)
        room = max(relaxed.upper_bound - value, 0.0)
        if scale <= 0 or (self.finder.resume is None and room <= self.finder.proof.gap * scale):
            return None
        best = profile if best is None else best
        behind = (problem.value(best, objective) - value) / scale
        gap = self.finder.proof.gap
        settings = replace(
            self.finder.proof, seconds=seconds, gap=max((1.0 - reserve) * gap - behind, 0.1 * gap)
        )

        def tell(gap: float, regions: int, still_open: int) -> None:
            if self.finder.progress is not None:
                label = f"gap {100 * gap:.2f} %, {still_open} of {regions} regions open"
                self.finder.progress(self.finder.done, self.finder.total, label)

        return prove_in_stages(
            problem,
            objective,
            best,
            scale=scale,
            multipliers=relaxed.multipliers,
            settings=settings,
            enough=reserve * max(gap, FIRST_GAP) * scale if reserve else np.inf,
            resume=None if self.finder.resume is None else self.finder.resume.proof,
            progress=tell,
        )

    def continued(self, objective: Objective, found: Found, profile: FloatArray) -> Found:
        """The better of a design and the local optimum from a profile of the branch and bound."""
        problem = self.finder.task.problem(found.mean_pitch)
        solution = solve_local(problem, objective, profile)
        own = valued(problem, objective, found.solution.profile)
        if valued(problem, objective, solution.profile) <= own:
            return found
        return replace(
            found,
            solution=solution,
            start="branch and bound",
            iterations=found.iterations + solution.iterations,
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
    proven: ProvenBound | None = None,
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
    bound, certificate = None, None
    if relaxed is not None:
        bound = relaxed.upper_bound
        tree = None
        if proven is not None and proven.upper_bound <= bound:
            bound, tree = proven.upper_bound, proven.proof
        certificate = Certificate.of(problem, objective, bound, relaxed.multipliers, tree)
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
        certificate=certificate,
        proof_ended="" if proven is None else proven.ended,
        mean_pitch=found.mean_pitch,
        status=solution.status,
        message=solution.message,
        start=found.start,
        iterations=found.iterations,
        seconds=time.perf_counter() - began,
        history=solution.history,
    )
