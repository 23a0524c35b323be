"""Bayesian optimisation: samples where a Gaussian process of the cost promises most.

After its start points and a scrambled Sobol design, the tuner fits a process to all it was told
and asks for the maximum of an acquisition function, times the probability that constraints hold
and the evaluation goes well.  Candidates that are pending count as sampled at the process's mean
(noisy expected improvement draws them along; a Thompson draw needs no such thing), so that points
asked for together spread.  The best point is the evaluated feasible one of least posterior mean.

What a candidate depends on beside settings and evaluations is the last fit, from which the next
one starts: it stands in the candidate's note, so that a study goes on from its journal without
fitting anew, and to the same points.

Mulders et al. tune individual pitch this way; Jones et al. (1998) is the origin.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import get_args

import numpy as np
from numpy.typing import ArrayLike

from pitchopt.checks import FloatArray, finite_number, whole_number
from pitchopt.errors import InputError
from pitchopt.tuning.acquisition import (
    AcquisitionName,
    ConfidenceBound,
    ExpectedImprovement,
    LogExpectedImprovement,
    NoisyExpectedImprovement,
    ProbabilityOfImprovement,
    ThompsonSample,
)
from pitchopt.tuning.acquisition_search import Smooth, maximise
from pitchopt.tuning.covariance import CovarianceName, covariance_named
from pitchopt.tuning.evaluations import Best, Candidate, Evaluation
from pitchopt.tuning.likelihood import Criterion
from pitchopt.tuning.quasi_random import sobol
from pitchopt.tuning.space import Space
from pitchopt.tuning.surrogates import Noise, Surrogates, Weighed, surrogates_of
from pitchopt.tuning.tuner import Proposal, Tuner

__all__ = ["Bayesian"]

_NEAR = 5  # best samples around which acquisitions are searched


class Bayesian(Tuner):
    """Bayesian tuner.

    Parameters
    ----------
    space : Space
    seed : int
    start : (d,) or (k, d) array_like, optional
        Points to evaluate first.
    initial : int, optional
        Points of the design after them; 2 (d + 1) in all if not given.
    acquisition : str
        ``log-expected-improvement``, ``expected-improvement``, ``noisy-expected-improvement``,
        ``probability-of-improvement``, ``confidence-bound`` or ``thompson``.
    covariance : {"squared-exponential", "matern"}
    hyperparameters : {"map", "ml"}
        With priors or by likelihood alone.
    noise : {"told", "fitted"}
        Whether variances that are told count beside the fitted nugget.  Where they are of what is
        the same at every evaluation of a point, as with common random numbers, they had better
        not: sampling again teaches nothing.
    confidence : float
        Deviations below the mean that the confidence bound lies.

    Raises
    ------
    InputError
        If a setting has no meaning or a start point lies outside of the space.
    """

    name = "bayes"

    def __init__(
        self,
        space: Space,
        *,
        seed: int = 0,
        start: ArrayLike | None = None,
        initial: int | None = None,
        acquisition: AcquisitionName = "log-expected-improvement",
        covariance: CovarianceName = "squared-exponential",
        hyperparameters: Criterion = "map",
        noise: Noise = "told",
        confidence: float = 2.0,
    ) -> None:
        super().__init__(space, seed=seed)
        starts = np.empty((0, len(space))) if start is None else np.atleast_2d(np.asarray(start))
        self.start = np.array([space.point(x) for x in starts]).reshape(-1, len(space))
        if initial is None:
            initial = max(2 * (len(space) + 1) - len(self.start), 0)
        self.initial = whole_number("initial", initial, at_least=0)
        if len(self.start) + self.initial < 2:
            raise InputError(
                f"initial: got {self.initial} with {len(self.start)} start points, expected at "
                "least two points before the first fit"
            )
        if acquisition not in get_args(AcquisitionName):
            raise InputError(
                f"acquisition: got {acquisition!r}, expected one of "
                f"{', '.join(get_args(AcquisitionName))}"
            )
        if hyperparameters not in get_args(Criterion):
            raise InputError(f"hyperparameters: got {hyperparameters!r}, expected ml or map")
        if noise not in get_args(Noise):
            raise InputError(f"noise: got {noise!r}, expected told or fitted")
        self.acquisition, self.hyperparameters = acquisition, hyperparameters
        self.noise: Noise = noise
        self.covariance = covariance_named(covariance).name
        self.confidence = finite_number("confidence", confidence, at_least=0.0)
        self._last: tuple[int, Mapping[str, object]] | None = None
        self._current: Surrogates | None = None

    def settings(self) -> dict[str, object]:
        """Plain data that names the tuner."""
        return {
            "method": self.name,
            "seed": self.seed,
            "start": self.start.tolist(),
            "initial": self.initial,
            "acquisition": self.acquisition,
            "covariance": self.covariance,
            "hyperparameters": self.hyperparameters,
            "noise": self.noise,
            "confidence": self.confidence,
        }

    def best(self) -> Best:
        """The evaluated feasible point of least posterior mean, with its deviation.

        Raises
        ------
        ComputationError
            If nothing feasible was evaluated yet.
        """
        plain = super().best()
        if not self._fits:
            return plain
        found = self.surrogates()
        good = [e for e in self._evaluations if e.status == "ok"]
        mean, std = found.cost.moments(found.cost.kriging.u)
        place = int(np.argmin(np.where(found.feasible, mean, np.inf)))
        return Best(
            x=good[place].x,
            cost=found.cost.shift + found.cost.scale * float(mean[place]),
            std=found.cost.scale * float(std[place]),
            evaluation=good[place],
        )

    def surrogates(self) -> Surrogates:
        """Processes of all that the tuner was told: at least two points that did not fail.

        Raises
        ------
        InputError
            If there are fewer.
        """
        if not self._fits:
            raise InputError("surrogates: got fewer than two points that went well, expected two")
        if self._current is None:
            told, document = self._last if self._last is not None else (0, None)
            same = told == len(self._evaluations)
            self._current = surrogates_of(
                self.space,
                self._evaluations,
                covariance=self.covariance,
                criterion=self.hyperparameters,
                noise=self.noise,
                seed=self.seed,
                known=document if same else None,
                begin=document,
            )
        return self._current

    @property
    def _fits(self) -> bool:
        return sum(e.status == "ok" for e in self._evaluations) >= 2

    def _told(self, evaluation: Evaluation) -> None:  # noqa: ARG002
        self._current = None

    def _take_up(self, candidate: Candidate) -> bool:
        document = candidate.note.get("hyperparameters")
        if document is None:
            return False
        if not isinstance(document, Mapping):
            raise InputError(
                f"candidate: got hyperparameters {document!r}, expected those of a fit"
            )
        self._last = len(self._evaluations), document
        self._current = None
        return True

    def _propose(self) -> Proposal:
        index = self._asked
        if index < len(self.start):
            return Proposal(x=self.start[index], origin="start")
        place = index - len(self.start)
        if place < self.initial or not self._fits:
            return Proposal(x=self.space.from_unit(self._design(place)), origin="design")
        found = self.surrogates()
        document = found.document()
        self._last = len(self._evaluations), document
        rng = np.random.default_rng([self.seed, index])
        samples = found.cost.kriging.u
        mean, _ = found.cost.moments(samples)
        order = np.argsort(np.where(found.feasible, mean, mean + np.ptp(mean) + 1.0), kind="stable")
        u, value = maximise(
            self.space, self._to_maximise(found, rng), near=samples[order[:_NEAR]], rng=rng
        )
        return Proposal(
            x=self.space.from_unit(u),
            origin=self.acquisition,
            note={"hyperparameters": document, "acquisition": value},
        )

    def _design(self, place: int) -> FloatArray:
        """Point of the scrambled Sobol sequence."""
        rng = np.random.default_rng([self.seed, 0, 2])
        return np.asarray(sobol(max(place.bit_length(), 3), len(self.space), rng)[place])

    def _to_maximise(self, found: Surrogates, rng: np.random.Generator) -> Smooth:
        probabilities = found.probabilities()
        if not found.feasible.any():
            return Weighed(None, probabilities, logarithmic=True)
        acquisition = self._acquisition(found, rng)
        if not probabilities:
            return acquisition
        logarithmic = isinstance(
            acquisition,
            (LogExpectedImprovement, NoisyExpectedImprovement, ProbabilityOfImprovement),
        )
        floor = None
        if isinstance(acquisition, (ConfidenceBound, ThompsonSample)):
            floor = float(acquisition.values(found.cost.kriging.u).min())
        return Weighed(acquisition, probabilities, logarithmic=logarithmic, floor=floor)

    def _acquisition(self, found: Surrogates, rng: np.random.Generator) -> Smooth:
        pending = self.space.to_unit(
            np.array([c.x for c in self.pending]).reshape(-1, len(self.space))
        )
        if self.acquisition == "noisy-expected-improvement":
            return NoisyExpectedImprovement(
                found.cost, candidates=found.feasible, pending=pending, rng=rng
            )
        if self.acquisition == "thompson":
            return ThompsonSample(found.cost, rng=rng)
        believed = found.cost.believing(pending)
        able = np.concatenate([found.feasible, found.chance(pending) > 0.5])
        best = float(believed.moments(believed.kriging.u)[0][able].min())
        if self.acquisition == "confidence-bound":
            return ConfidenceBound(believed, self.confidence)
        if self.acquisition == "probability-of-improvement":
            return ProbabilityOfImprovement(believed, best)
        if self.acquisition == "expected-improvement":
            return ExpectedImprovement(believed, best)
        return LogExpectedImprovement(believed, best)
