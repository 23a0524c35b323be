"""Scrambled Sobol points, even in the unit cube of any dimension.

Owen, J. Complexity 14 (1998) 466-489, through SciPy, whose statistics load on first use.
"""

from __future__ import annotations

import numpy as np

from pitchopt.checks import FloatArray

__all__ = ["sobol"]


def sobol(exponent: int, dimensions: int, rng: np.random.Generator) -> FloatArray:
    """The first 2^exponent points (2^exponent, dimensions) of a sequence scrambled by `rng`."""
    from scipy.stats import qmc

    return np.asarray(qmc.Sobol(dimensions, scramble=True, seed=rng).random_base2(exponent))
