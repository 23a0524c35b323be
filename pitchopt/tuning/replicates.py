"""How sure a mean over seeds is, with common random numbers.

Each point is evaluated with the same seeds, so that two points are compared in the same wind.
With y_s the cost with seed s, the mean over S seeds has the variance var(y_s) / S about the mean
over all seeds.  Most of it is common to all points and does not touch their order.  What does is
the variance of y_s less the seed's own effect, which the replicates r_s of a reference point show:
y_s - r_s has twice that variance, if it is alike at both points.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from pitchopt.checks import finite_array

__all__ = ["variance_of_mean"]


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
