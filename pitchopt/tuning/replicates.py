"""A cost that is a mean over seeds, with common random numbers.

Each point is evaluated with the same seeds, so that two points are compared in the same wind.
With y_s the cost with seed s, the mean over S seeds has the variance var(y_s) / S about the mean
over all seeds.  Most of it is common to all points and does not touch their order.  What does is
the variance of y_s less the seed's own effect, which the replicates r_s of a reference point show:
y_s - r_s has twice that variance, if it is alike at both points.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import ArrayLike

from pitchopt.checks import FloatArray, finite_array
from pitchopt.errors import InputError
from pitchopt.tuning.evaluations import Outcome

__all__ = ["Replicated", "variance_of_mean"]


def variance_of_mean(replicates: ArrayLike, reference: ArrayLike | None = None) -> float | None:
    """Variance of the mean of replicates; with a reference's, without what seeds have in common.

    Parameters
    ----------
    replicates : (S,) array_like
    reference : (S,) array_like, optional
        Of another point, with the same seeds in the same order.

    Returns
    -------
    float or None
        None where there is one replicate alone, or where the reference is the same point, whose
        differences say nothing.

    Raises
    ------
    InputError
        If the two differ in length.
    """
    values = finite_array("replicates", replicates)
    if values.size < 2:
        return None
    if reference is None:
        return float(np.var(values, ddof=1) / values.size)
    other = finite_array("reference", reference, shape=values.shape)
    if np.array_equal(values, other):
        return None
    return float(np.var(values - other, ddof=1) / (2 * values.size))


class Replicated:
    """Mean of a function over seeds, as an `Outcome` with variance and replicates.

    Parameters
    ----------
    function : callable
        Takes a point (d,) and a seed and returns a cost.
    seeds : sequence of int
        Common to all points.
    reference : (S,) array_like, optional
        Costs of a reference point with these seeds.

    Raises
    ------
    InputError
        If there are no seeds, or one stands twice.
    """

    def __init__(
        self,
        function: Callable[[FloatArray, int], float],
        seeds: Sequence[int],
        reference: ArrayLike | None = None,
    ) -> None:
        self.function = function
        self.seeds = tuple(seeds)
        if not self.seeds or len(set(self.seeds)) < len(self.seeds):
            raise InputError(f"seeds: got {self.seeds}, expected at least one, each once")
        shape = (len(self.seeds),)
        self.reference = (
            None if reference is None else finite_array("reference", reference, shape=shape)
        )

    def __call__(self, x: FloatArray) -> Outcome:
        """Mean over the seeds; one of them that fails makes the point fail."""
        costs = tuple(float(self.function(x, seed)) for seed in self.seeds)
        if not np.all(np.isfinite(costs)):
            return Outcome(cost=float("nan"), replicates=costs)
        return Outcome(
            cost=float(np.mean(costs)),
            variance=variance_of_mean(costs, self.reference),
            replicates=costs,
        )
