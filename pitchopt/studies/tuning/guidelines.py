"""Zeroth-order tuning by the guidelines of Zalkind et al., section 4, with the closing check.

A coarse grid comes first (their preliminary analysis).  Ordinary kriging of its costs gives the
second derivatives at its minimum, and with them the scaling

    D_i ~ (d2C/dz_i2)^-1,                                                                   (37)

brought to a largest entry of one, since the size of a step is set by the next rule: alpha_0 such
that alpha_0 |G| = 1 at the first gradient, within the 0.5 to 1.5 of (38).  Both hold in unit
coordinates, where ranges are of the order of one.  A second derivative below a twentieth of the
largest, or a negative one, counts as that, so that no step is all along one parameter.

At the end kriging of all costs, the grid's and the tuner's, answers their second question, whether
the result is near the minimum of the estimated cost.  An estimate is worth little where nothing
was sampled, so kriging's minimum x_k is simulated too.  With sigma the deviation of the noise that
kriging finds, z^1 the start and x_t the tuner's minimum, the two agree if

    C(x_t) - C(x_k) <= max(2 sigma, [C(z^1) - C(x_t)] / 20):

what is left to gain is within the noise, or a twentieth of what was gained.  The distance of the
two is told in kriging's length scales; in a flat valley it may be long.

Source: Zalkind, Dall'Anese, Pao, Automatic controller tuning using a zeroth-order optimization
algorithm, Wind Energy Science 5 (2020), sections 2.6 and 4.3.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from pitchopt.checks import FloatArray, whole_number
from pitchopt.errors import ComputationError
from pitchopt.studies.tuning.problem import TuningProblem
from pitchopt.tuning import (
    Evaluation,
    GaussianProcess,
    Space,
    StudyResult,
    ZerothOrder,
    run_study,
)
from pitchopt.tuning.grid import Grid

__all__ = ["Agreement", "GuidedTuning", "agreement", "newton_scaling", "tune_by_guidelines"]

_LEAST_CURVATURE = 0.05  # of the largest
_DEVIATIONS = 2.0  # of the noise, within which costs are the same
_SHARE = 0.05  # of the gain, that may be left


@dataclass(frozen=True, kw_only=True)
class Agreement:
    """The tuner's and kriging's minimum side by side.

    Attributes
    ----------
    tuner, kriging : (d,) ndarray
        x_t and x_k.
    gap : float
        C(x_t) - C(x_k), in the unit of the cost; minus infinity if x_k cannot be simulated.
    tolerance : float
        Gap up to which they agree.
    distance : float
        Between them, in length scales.
    process : GaussianProcess
        Kriging of all costs, for pictures.
    """

    tuner: FloatArray
    kriging: FloatArray
    gap: float
    tolerance: float
    distance: float
    process: GaussianProcess

    @property
    def agrees(self) -> bool:
        """Whether the gap is within the tolerance."""
        return self.gap <= self.tolerance


@dataclass(frozen=True, kw_only=True)
class GuidedTuning:
    """What a tuning by the guidelines found.

    Attributes
    ----------
    problem : TuningProblem
    tuner : ZerothOrder
        As it is at the end.
    evaluations : tuple of Evaluation
        The grid's, then the tuner's.
    scaling : (d,) ndarray
        D.
    agreement : Agreement
    """

    problem: TuningProblem
    tuner: ZerothOrder
    evaluations: tuple[Evaluation, ...]
    scaling: FloatArray
    agreement: Agreement

    @property
    def x(self) -> FloatArray:
        """Best point of the tuner."""
        return self.tuner.best().x

    @property
    def cost(self) -> float:
        """There."""
        return self.tuner.best().cost

    @property
    def simulations(self) -> int:
        """That were needed, that of kriging's minimum among them."""
        return self.problem.simulations_in(
            [*(e.x for e in self.evaluations), self.agreement.kriging]
        )


def _kriging(space: Space, evaluations: Sequence[Evaluation]) -> GaussianProcess:
    """Kriging of the costs of the points that did not fail, each once."""
    good = {tuple(e.x): e.cost for e in evaluations if e.status == "ok"}
    if len(good) < 2:
        raise ComputationError(
            f"kriging: {len(good)} of {len(evaluations)} evaluations did not fail, at least 2 are "
            "needed"
        )
    return GaussianProcess.fit(space, list(good), list(good.values()))


def newton_scaling(space: Space, evaluations: Sequence[Evaluation]) -> FloatArray:
    """Diagonal of D by (37) in unit coordinates, largest entry one: (d,), for linear scales.

    Raises
    ------
    ComputationError
        If fewer than two evaluations did not fail.
    """
    process = _kriging(space, evaluations)
    width = space.upper - space.lower
    curvature = process.curvature(process.minimum().x) * width**2
    largest = float(curvature.max())
    if largest <= 0.0:
        return np.ones(len(space))
    inverse = 1.0 / np.maximum(curvature, _LEAST_CURVATURE * largest)
    return np.asarray(np.clip(inverse / inverse.max(), _LEAST_CURVATURE, 1.0))


def agreement(
    space: Space,
    evaluations: Sequence[Evaluation],
    best: Evaluation,
    start: Evaluation,
    cost: Callable[[FloatArray], float],
) -> Agreement:
    """Compare a tuner's result with the minimum of kriging of its evaluations.

    Parameters
    ----------
    space : Space
    evaluations : sequence of Evaluation
    best, start : Evaluation
        The tuner's minimum and z^1.
    cost : callable
        Of a point; NaN where it fails.

    Raises
    ------
    ComputationError
        If fewer than two evaluations did not fail.
    """
    process = _kriging(space, evaluations)
    minimum = process.minimum()
    there = cost(minimum.x)
    features = space.features(space.to_unit(np.array([best.x, minimum.x])))
    lengths = process.hyperparameters.lengths[space.groups]
    return Agreement(
        tuner=best.x,
        kriging=minimum.x,
        gap=best.cost - there if math.isfinite(there) else -math.inf,
        tolerance=max(_DEVIATIONS * process.nugget_std, _SHARE * (start.cost - best.cost)),
        distance=float(np.linalg.norm((features[0] - features[1]) / lengths)),
        process=process,
    )


def tune_by_guidelines(
    problem: TuningProblem,
    *,
    preliminary: int = 4,
    stages: int = 7,
    samples: int | None = None,
    seed: int = 0,
    run: Callable[..., StudyResult] = run_study,
) -> GuidedTuning:
    """Tune a problem with the settings that the guidelines give.

    Parameters
    ----------
    problem : TuningProblem
    preliminary : int
        Points of the grid each way; a single parameter needs no scaling and is spared the grid.
    stages : int
    samples : int, optional
        Of a stage; one more than there are parameters without.
    seed : int
        Of the directions.
    run : callable
        `run_study`, or with further arguments of it filled in.

    Raises
    ------
    ComputationError
        If evaluations fail throughout.
    """
    whole_number("preliminary", preliminary, at_least=2)
    space = problem.space
    before: tuple[Evaluation, ...] = ()
    scaling = np.ones(len(space))
    if len(space) > 1:
        grid = Grid(space, points=preliminary)
        before = run(problem, grid, evaluations=preliminary ** len(space)).evaluations
        scaling = newton_scaling(space, before)
    tuner = ZerothOrder(
        space, start=problem.start, samples=samples, stages=stages, scaling=scaling, seed=seed
    )
    most = tuner.most_evaluations + 1  # more than it takes, so that it ends by itself
    result = run(problem, tuner, evaluations=most)
    evaluations = before + result.evaluations
    return GuidedTuning(
        problem=problem,
        tuner=tuner,
        evaluations=evaluations,
        scaling=scaling,
        agreement=agreement(
            space,
            evaluations,
            tuner.best().evaluation,
            result.evaluations[0],
            lambda x: problem(x).cost,
        ),
    )
