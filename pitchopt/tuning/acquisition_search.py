"""Search for the largest value of a smooth function of unit coordinates, with gradients.

A Sobol sample over the whole space and normal clouds around given points, of spreads from a tenth
to a thousandth of each range, are looked at; the best of both kinds are then climbed from, all at
once, by L-BFGS-B on the sum of their values, which is one problem of independent blocks.
Coordinates that are periodic are not bounded on the way and come back by whole turns at the end.
"""

from __future__ import annotations

from typing import Protocol

import numpy as np
from scipy.optimize import minimize

from pitchopt.checks import FloatArray
from pitchopt.tuning.quasi_random import sobol
from pitchopt.tuning.space import Space

__all__ = ["Smooth", "maximise"]

_EXPONENT = 8  # of two: points of the wide sample
_CLOUD = 24
_SPREADS = (1e-1, 1e-2, 1e-3)
_STARTS = 6  # of each kind
_ITERATIONS = 60


class Smooth(Protocol):
    """Function of unit coordinates, for many points at once."""

    def values(self, u: FloatArray) -> FloatArray:
        """Values (m,) at points (m, d)."""
        ...

    def gradients(self, u: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Values (m,) and gradients (m, d) at points (m, d)."""
        ...


def maximise(
    space: Space, function: Smooth, *, near: FloatArray, rng: np.random.Generator
) -> tuple[FloatArray, float]:
    """Point (d,) of largest value that was found, and that value.

    Parameters
    ----------
    space : Space
    function : Smooth
    near : (k, d) ndarray
        Points around which a maximum is likely; they are starts themselves.
    rng : numpy.random.Generator
    """
    d = len(space)
    free = np.asarray(space.periodic)
    wide = sobol(_EXPONENT, d, rng)
    clouds = [
        (near[:, None] + spread * rng.standard_normal((len(near), _CLOUD, d))).reshape(-1, d)
        for spread in _SPREADS
    ]
    close = _inside(np.concatenate([near, *clouds]), free)
    begins = np.concatenate([_best(function, wide), _best(function, close)])
    shape = begins.shape
    lower = np.where(free, -np.inf, 0.0)
    upper = np.where(free, np.inf, 1.0)

    def down(flat: FloatArray) -> tuple[float, FloatArray]:
        values, gradients = function.gradients(flat.reshape(shape))
        return -float(values.sum()), -gradients.ravel()

    result = minimize(
        down,
        begins.ravel(),
        jac=True,
        method="L-BFGS-B",
        bounds=list(zip(np.tile(lower, shape[0]), np.tile(upper, shape[0]), strict=True)),
        options={"maxiter": _ITERATIONS, "ftol": 1e-10, "gtol": 1e-6},
    )
    ends = np.concatenate([_inside(result.x.reshape(shape), free), begins])
    values = function.values(ends)
    place = int(np.argmax(values))
    return ends[place], float(values[place])


def _best(function: Smooth, u: FloatArray) -> FloatArray:
    order = np.argsort(-function.values(u), kind="stable")
    return u[order[:_STARTS]]


def _inside(u: FloatArray, free: FloatArray) -> FloatArray:
    return np.where(free, np.mod(u, 1.0), np.clip(u, 0.0, 1.0))
