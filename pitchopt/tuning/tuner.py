"""What all tuners share: ask, tell, best.

A tuner knows a space, a seed and what it was told, nothing else.  What it asks for next depends
on these and on the order of asking and telling alone, so a study that is taken up again from its
journal goes on as an unbroken one would have.
(With many points the last bits of linear algebra may depend on its number of threads.)
"""

from __future__ import annotations

import dataclasses
import math
from abc import ABC, abstractmethod
from collections.abc import Generator, Sequence
from typing import ClassVar

import numpy as np
from numpy.typing import ArrayLike

from pitchopt.checks import FloatArray, whole_number
from pitchopt.errors import ComputationError, InputError
from pitchopt.tuning.evaluations import Best, Candidate, Evaluation, Outcome, evaluation_of
from pitchopt.tuning.space import Space

__all__ = ["Proposal", "StagedTuner", "Stages", "Tuner"]


@dataclasses.dataclass(frozen=True, kw_only=True)
class Proposal:
    """A point before it has its number: see `Candidate`."""

    x: FloatArray
    origin: str = ""
    note: dict[str, object] = dataclasses.field(default_factory=dict)


class Tuner(ABC):
    """Base of all tuners.

    Parameters
    ----------
    space : Space
    seed : int
        Of all that is random in the tuner.
    """

    name: ClassVar[str]
    """As the commands call it."""

    def __init__(self, space: Space, *, seed: int = 0) -> None:
        if not isinstance(space, Space):
            raise InputError(f"space: got {type(space).__name__}, expected a Space")
        self.space = space
        self.seed = whole_number("seed", seed, at_least=0)
        self._asked = 0
        self._pending: dict[int, Candidate] = {}
        self._evaluations: list[Evaluation] = []

    @property
    def evaluations(self) -> tuple[Evaluation, ...]:
        """What the tuner was told, in that order."""
        return tuple(self._evaluations)

    @property
    def pending(self) -> tuple[Candidate, ...]:
        """Candidates that were asked for and not yet told, in the order of asking."""
        return tuple(self._pending.values())

    @property
    def finished(self) -> bool:
        """Whether the tuner wants nothing more, whatever it is told."""
        return False

    def ask(self, n: int = 1) -> list[Candidate]:
        """Up to `n` points to evaluate.

        Fewer, or none, where the tuner waits for results or is finished.
        """
        found: list[Candidate] = []
        while len(found) < whole_number("n", n, at_least=1) and not self.finished:
            proposal = self._propose()
            if proposal is None:
                break
            found.append(self._register(proposal))
        return found

    def adopt(self, candidate: Candidate) -> Candidate | None:
        """Take the next candidate from a journal, as if it had just been asked for.

        None where `ask` would give nothing yet.

        Raises
        ------
        InputError
            If the tuner would have asked for another point: the journal is of another study.
        """
        if candidate.index != self._asked:
            raise InputError(
                f"candidate: got number {candidate.index}, expected {self._asked}: candidates are "
                "taken up in their order"
            )
        x = self.space.point(candidate.x)
        if not self._take_up(candidate):
            proposal = None if self.finished else self._propose()
            if proposal is None:
                return None
            would = self.space.point(proposal.x)
            width = self.space.upper - self.space.lower
            if np.any(np.abs(would - x) > 1e-9 * width):
                raise InputError(
                    f"candidate: number {candidate.index} is {np.array2string(x)} and the tuner "
                    f"would ask for {np.array2string(would)}: it comes from another study"
                )
        return self._register(Proposal(x=x, origin=candidate.origin, note=dict(candidate.note)))

    def tell(
        self,
        x: Candidate | ArrayLike,
        y: float | Outcome | Evaluation,
        variance: float | None = None,
        *,
        constraints: Sequence[float] = (),
    ) -> Evaluation:
        """Report what became of a point.

        Parameters
        ----------
        x : Candidate or (d,) array_like
            A candidate, its point, or any other point of the space that was evaluated.
        y : float, Outcome or Evaluation
            Cost; NaN for a failure.
        variance : float, optional
            Of a plain cost.
        constraints : sequence of float
            Beside a plain cost; at most zero where they hold.

        Raises
        ------
        InputError
            If the point lies outside of the space or the numbers cannot be used.
        """
        candidate = self._match(x)
        if isinstance(y, Evaluation):
            if y.status == "ok" and not np.all(np.isfinite([y.cost, *y.constraints])):
                raise InputError(f"y: got a cost of {y.cost} that is ok, expected finite numbers")
            evaluation = dataclasses.replace(
                y,
                index=candidate.index,
                x=candidate.x,
                origin=candidate.origin,
                note=candidate.note,
            )
        else:
            if not isinstance(y, Outcome):
                y = Outcome(cost=y, variance=variance, constraints=tuple(constraints))
            evaluation = evaluation_of(candidate, y)
        self._pending.pop(candidate.index, None)
        self._evaluations.append(evaluation)
        self._told(evaluation)
        return evaluation

    def best(self) -> Best:
        """The feasible evaluation of least cost.

        Raises
        ------
        ComputationError
            If there is none yet.
        """
        feasible = [e for e in self._evaluations if e.feasible]
        if not feasible:
            raise ComputationError(self._none_yet())
        best = min(feasible, key=lambda e: e.cost)
        return Best(x=best.x, cost=best.cost, std=0.0, evaluation=best)

    @abstractmethod
    def settings(self) -> dict[str, object]:
        """Plain data that names the tuner with all that its candidates depend on but the space."""

    @abstractmethod
    def _propose(self) -> Proposal | None:
        """Next point, or None to wait for results."""

    def _told(self, evaluation: Evaluation) -> None:  # noqa: B027  most need no notice
        """Take notice of an evaluation that has just been added."""

    def _take_up(self, candidate: Candidate) -> bool:  # noqa: ARG002  for tuners that can
        """Take over a candidate's state without computing it, if the tuner can."""
        return False

    def _register(self, proposal: Proposal) -> Candidate:
        candidate = Candidate(
            index=self._asked,
            x=self.space.point(proposal.x),
            origin=proposal.origin,
            note=proposal.note,
        )
        self._asked += 1
        self._pending[candidate.index] = candidate
        return candidate

    def _match(self, x: Candidate | ArrayLike) -> Candidate:
        if isinstance(x, Candidate):
            pending = self._pending.get(x.index)
            if pending is None or not np.array_equal(pending.x, x.x):
                raise InputError(
                    f"x: got candidate {x.index} at {np.array2string(np.asarray(x.x))}, expected "
                    "one that was asked for and not yet told"
                )
            return pending
        point = self.space.point(x)
        for candidate in self._pending.values():
            if np.array_equal(candidate.x, point):
                return candidate
        return Candidate(index=-1, x=point, origin="told")

    def _none_yet(self) -> str:
        count = len(self._evaluations)
        if count == 0:
            return "best: nothing was evaluated yet"
        last = next((e.message for e in reversed(self._evaluations) if e.message), "")
        return f"best: none of {count} evaluations is feasible" + (
            f"; the last: {last}" if last else ""
        )

    def merit(self, evaluation: Evaluation) -> float:
        """Cost for tuners that compare costs alone: see `merits`."""
        return float(self.merits([evaluation])[0])

    def merits(self, evaluations: Sequence[Evaluation]) -> FloatArray:
        """Costs for tuners that compare costs alone, of points as they stand to all known so far.

        A point that breaks constraints ranks behind the worst feasible one by its violation, a
        failed one by the whole range of costs.  While nothing feasible is known the violation alone
        counts, and a failed point ranks behind the worst; infinity while all failed.
        """
        known = [e.cost for e in self._evaluations if e.feasible]
        base = math.nextafter(max(known, default=0.0), math.inf)
        if not known:
            known = [e.violation for e in self._evaluations if e.status == "ok"]
        if not known:
            return np.full(len(evaluations), math.inf)
        failed = behind(known)
        return np.array(
            [
                e.cost if e.feasible else base + e.violation if e.status == "ok" else failed
                for e in evaluations
            ]
        )


def behind(values: Sequence[float]) -> float:
    """A value behind the worst of `values`, by their whole range."""
    worst = max(values)
    return worst + max(worst - min(values), 0.1 * abs(worst), 1e-12)


Stages = Generator[list[Proposal], list[Evaluation], None]


class StagedTuner(Tuner):
    """Tuner that is written as a generator of stages.

    `_stages` yields the points of a stage, which may be evaluated side by side, and receives their
    evaluations in the same order; the tuner is finished when it returns.
    """

    def __init__(self, space: Space, *, seed: int = 0) -> None:
        super().__init__(space, seed=seed)
        self._generator: Stages | None = None
        self._queue: list[Proposal] = []
        self._stage: dict[int, Evaluation | None] = {}
        self._done = False

    @abstractmethod
    def _stages(self) -> Stages:
        """Stages, one list of points after the other."""

    @property
    def finished(self) -> bool:
        """Whether the last stage is done."""
        if not self._queue and all(e is not None for e in self._stage.values()):
            self._advance()
        return self._done

    def _advance(self) -> None:
        """Go on to the next stage with points in it."""
        if self._done:
            return
        try:
            if self._generator is None:
                self._generator = self._stages()
                self._queue = list(next(self._generator))
            while not self._queue:
                told = [e for e in self._stage.values() if e is not None]
                self._stage = {}
                self._queue = list(self._generator.send(told))
        except StopIteration:
            self._done = True

    def _propose(self) -> Proposal | None:
        return self._queue.pop(0) if self._queue else None

    def _register(self, proposal: Proposal) -> Candidate:
        candidate = super()._register(proposal)
        self._stage[candidate.index] = None
        return candidate

    def _told(self, evaluation: Evaluation) -> None:
        if evaluation.index in self._stage:
            self._stage[evaluation.index] = evaluation
