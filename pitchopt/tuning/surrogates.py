"""Gaussian processes of all that a tuner was told: cost, constraints, failures.

Cost and constraints come from the evaluations that went well.  Where some failed, a process of
labels, +1 for a failure and -1 else, takes its place beside the constraints: that is
classification by regression on labels (Rasmussen and Williams, section 6.5).  The probability
that a point is feasible is the product of the probabilities that each of these is below zero,
or the label below -1/2, so that samples do not crowd on the failing side of an edge.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

from pitchopt.checks import FloatArray
from pitchopt.errors import InputError
from pitchopt.tuning.acquisition import ProbabilityOfImprovement
from pitchopt.tuning.acquisition_search import Smooth
from pitchopt.tuning.covariance import CovarianceName, Hyperparameters
from pitchopt.tuning.evaluations import Evaluation
from pitchopt.tuning.gaussian_process import GaussianProcess
from pitchopt.tuning.likelihood import Criterion
from pitchopt.tuning.space import Space

__all__ = ["Noise", "Surrogates", "Weighed", "surrogates_of"]

Noise = Literal["told", "fitted"]

_MANY = 40  # samples from which a fit starts where the last one ended and at the priors' centre
_STARTS = 4
_FAILURE = "failure"
_LEVEL = -0.5  # of labels: a point counts as safe on its side of a quarter of the way across


@dataclass(frozen=True, kw_only=True)
class Surrogates:
    """Processes of cost and of what makes a point feasible.

    Attributes
    ----------
    cost : GaussianProcess
    limits : mapping of str to GaussianProcess
        Each to be at most zero: constraints, and labels of failures.
    feasible : (n,) ndarray of bool
        Which samples of the cost were feasible.
    """

    cost: GaussianProcess
    limits: Mapping[str, GaussianProcess]
    feasible: FloatArray

    def document(self) -> dict[str, object]:
        """Hyperparameters of all processes as plain data."""
        processes = {"cost": self.cost, **self.limits}
        return {name: process.hyperparameters.document() for name, process in processes.items()}

    def chance(self, u: FloatArray) -> FloatArray:
        """Probability (m,) that unit coordinates (m, d) are feasible."""
        return np.exp(Weighed(None, self.probabilities(), logarithmic=True).values(u))

    def probabilities(self) -> list[ProbabilityOfImprovement]:
        """Logarithms of the probabilities that the limits hold, as functions of a point."""
        return [
            ProbabilityOfImprovement(process, process.scaled(_LEVEL if name == _FAILURE else 0.0))
            for name, process in self.limits.items()
        ]


class Weighed:
    """A positive acquisition times, or a logarithmic one plus that of, the probability to hold.

    Parameters
    ----------
    acquisition : Smooth or None
        None for the probability alone.
    probabilities : sequence of Smooth
        Their logarithms.
    logarithmic : bool
        Whether the acquisition is a logarithm.
    floor : float, optional
        An acquisition that may be negative counts from here, as log(1 + exp(value - floor)).
    """

    def __init__(
        self,
        acquisition: Smooth | None,
        probabilities: Sequence[Smooth],
        *,
        logarithmic: bool,
        floor: float | None = None,
    ) -> None:
        self._acquisition, self._probabilities = acquisition, probabilities
        self._logarithmic, self._floor = logarithmic, floor

    def values(self, u: FloatArray) -> FloatArray:
        """Values (m,)."""
        total = np.zeros(len(u))
        for probability in self._probabilities:
            total = total + probability.values(u)
        if self._acquisition is None:
            return total
        value = self._acquisition.values(u)
        if self._logarithmic:
            return value + total
        if self._floor is not None:
            value = np.logaddexp(0.0, value - self._floor)
        return np.asarray(value * np.exp(total))

    def gradients(self, u: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Values (m,) and gradients (m, d)."""
        total, slopes = np.zeros(len(u)), np.zeros_like(u)
        for probability in self._probabilities:
            value, slope = probability.gradients(u)
            total, slopes = total + value, slopes + slope
        if self._acquisition is None:
            return total, slopes
        value, slope = self._acquisition.gradients(u)
        if self._logarithmic:
            return value + total, slope + slopes
        if self._floor is not None:
            above = value - self._floor
            value = np.logaddexp(0.0, above)
            slope = np.exp(above - value)[:, None] * slope
        share = np.exp(total)
        return value * share, share[:, None] * (slope + value[:, None] * slopes)


def _variances(evaluations: Sequence[Evaluation]) -> FloatArray:
    """Told variances (n,); the mean of the others where none was told, beside the nugget."""
    told = [e.variance for e in evaluations if e.variance is not None]
    mean = float(np.mean(told)) if told else 0.0
    return np.array([mean if e.variance is None else e.variance for e in evaluations])


def surrogates_of(
    space: Space,
    evaluations: Sequence[Evaluation],
    *,
    covariance: CovarianceName,
    criterion: Criterion,
    noise: Noise,
    seed: int,
    known: Mapping[str, object] | None = None,
    begin: Mapping[str, object] | None = None,
) -> Surrogates:
    """Processes of evaluations, of which at least two went well.

    Parameters
    ----------
    space : Space
    evaluations : sequence of Evaluation
    covariance, criterion
        See `GaussianProcess.fit`.
    noise : {"told", "fitted"}
        Whether the variances of the evaluations count beside the nugget.
    seed : int
    known : mapping, optional
        Hyperparameters of all processes, as `Surrogates.document` has them: nothing is fitted.
    begin : mapping, optional
        The same, to start fits from; may lack some.

    Raises
    ------
    InputError
        If the evaluations differ in their number of constraints, or `known` lacks a process.
    """

    def process(
        name: str, x: FloatArray, y: FloatArray, noise: FloatArray | None = None
    ) -> GaussianProcess:
        if known is not None:
            return GaussianProcess(
                space,
                x,
                y,
                noise_variance=noise,
                covariance=covariance,
                hyperparameters=_found(known, name),
            )
        last = _found(begin, name) if begin and name in begin else None
        return GaussianProcess.fit(
            space,
            x,
            y,
            noise_variance=noise,
            covariance=covariance,
            criterion=criterion,
            begin=last,
            starts=_STARTS if last is None or len(y) < _MANY else 1,
            seed=[seed, len(evaluations), 1],
        )

    good = [e for e in evaluations if e.status == "ok"]
    x = np.array([e.x for e in good])
    cost = process(
        "cost",
        x,
        np.array([e.cost for e in good]),
        _variances(good) if noise == "told" else None,
    )
    counts = sorted({len(e.constraints) for e in good})
    if len(counts) > 1:
        raise InputError(f"constraints: got {counts} at different points, expected as many at all")
    limits = {
        f"constraint {number}": process(
            f"constraint {number}", x, np.array([e.constraints[number] for e in good])
        )
        for number in range(counts[0])
    }
    if len(good) < len(evaluations):
        labels = np.array([-1.0 if e.status == "ok" else 1.0 for e in evaluations])
        limits[_FAILURE] = process(_FAILURE, np.array([e.x for e in evaluations]), labels)
    return Surrogates(cost=cost, limits=limits, feasible=np.array([e.feasible for e in good]))


def _found(documents: Mapping[str, object], name: str) -> Hyperparameters:
    document = documents.get(name)
    if not isinstance(document, Mapping):
        raise InputError(f"hyperparameters: got none of the {name}, expected those of a fit")
    return Hyperparameters.from_document(document)
