"""Candidates that a tuner asks for and what became of them."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Literal

import numpy as np

from pitchopt.checks import FloatArray, finite_number
from pitchopt.errors import InputError

__all__ = ["Best", "Candidate", "Evaluation", "EvaluationStatus", "Outcome"]

EvaluationStatus = Literal["ok", "failed", "timeout"]


@dataclass(frozen=True, kw_only=True)
class Candidate:
    """A point that a tuner wants evaluated.

    Attributes
    ----------
    index : int
        Number in the order of asking, from 0.
    x : (d,) ndarray
        Parameters in the units of the space.
    origin : str
        What the tuner wants it for, such as ``search 2.1``.
    note : mapping
        Plain data that the tuner needs to take the candidate up again from a journal.
    """

    index: int
    x: FloatArray
    origin: str = ""
    note: Mapping[str, object] = field(default_factory=dict)


@dataclass(frozen=True, kw_only=True)
class Outcome:
    """What an evaluated function returns where it has more to say than a cost.

    Parameters
    ----------
    cost : float
        To be made small; NaN or infinite for a failure.
    variance : float, optional
        Of `cost`, as an estimate of the mean over what is random.
    constraints : tuple of float
        At most zero where they hold; as many for every point.
    measures : mapping of str to float
        What the cost is made of, for tables and pictures.
    replicates : tuple of float
        Costs of the seeds one by one.
    message : str
        Why there is no cost, where the function knows.
    """

    cost: float
    variance: float | None = None
    constraints: tuple[float, ...] = ()
    measures: Mapping[str, float] = field(default_factory=dict)
    replicates: tuple[float, ...] = ()
    message: str = ""

    def __post_init__(self) -> None:
        try:
            object.__setattr__(self, "cost", float(self.cost))
            object.__setattr__(self, "constraints", tuple(float(c) for c in self.constraints))
            object.__setattr__(self, "replicates", tuple(float(r) for r in self.replicates))
            measures = {str(name): float(value) for name, value in self.measures.items()}
        except (TypeError, ValueError, AttributeError) as error:
            raise InputError(
                "outcome: got something else than numbers, expected a cost and, where given, "
                "numbers for constraints, replicates and measures"
            ) from error
        object.__setattr__(self, "measures", measures)
        if self.variance is not None:
            variance = finite_number("variance", self.variance, at_least=0.0)
            object.__setattr__(self, "variance", variance)


@dataclass(frozen=True, kw_only=True)
class Evaluation:
    """An evaluated point.

    Attributes
    ----------
    index : int
        That of the candidate; -1 for a point that was told without having been asked for.
    x : (d,) ndarray
    status : {"ok", "failed", "timeout"}
    cost : float
        NaN unless ok.
    variance : float or None
    constraints : tuple of float
    measures : mapping
    replicates : tuple of float
    message : str
        Why it failed.
    seconds : float
        Wall time of the evaluation.
    origin : str
    note : mapping
    """

    index: int
    x: FloatArray
    status: EvaluationStatus = "ok"
    cost: float = math.nan
    variance: float | None = None
    constraints: tuple[float, ...] = ()
    measures: Mapping[str, float] = field(default_factory=dict)
    replicates: tuple[float, ...] = ()
    message: str = ""
    seconds: float = 0.0
    origin: str = ""
    note: Mapping[str, object] = field(default_factory=dict)

    @property
    def violation(self) -> float:
        """Sum of what constraints are above zero."""
        return float(sum(max(value, 0.0) for value in self.constraints))

    @property
    def feasible(self) -> bool:
        """Whether it is ok and all constraints hold."""
        return self.status == "ok" and all(value <= 0.0 for value in self.constraints)


@dataclass(frozen=True, kw_only=True)
class Best:
    """The best point of a tuner.

    Attributes
    ----------
    x : (d,) ndarray
    cost : float
        Evaluated, or the posterior mean where a tuner has a surrogate.
    std : float
        Standard deviation of that estimate; 0 where the evaluation is taken at its word.
    evaluation : Evaluation
        The evaluated point.
    """

    x: FloatArray
    cost: float
    std: float
    evaluation: Evaluation


def evaluation_of(candidate: Candidate, outcome: Outcome, *, seconds: float = 0.0) -> Evaluation:
    """Evaluation of a candidate; a cost or constraint that is no finite number is a failure."""
    numbers = np.array([outcome.cost, *outcome.constraints])
    ok = bool(np.all(np.isfinite(numbers)))
    message = outcome.message
    if not ok and not message:
        message = f"the cost or a constraint is {numbers[~np.isfinite(numbers)][0]}"
    return Evaluation(
        index=candidate.index,
        x=candidate.x,
        status="ok" if ok else "failed",
        cost=outcome.cost if ok else math.nan,
        variance=outcome.variance if ok else None,
        constraints=outcome.constraints if ok else (),
        measures=outcome.measures,
        replicates=outcome.replicates,
        message="" if ok else message,
        seconds=seconds,
        origin=candidate.origin,
        note=candidate.note,
    )
