"""Linear interpolation on evenly spaced grids, by fractional indices."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from windfield._checks import FloatArray

__all__ = ["Between", "inside", "trilinear", "wrapped"]

IntArray = NDArray[np.intp]


class Between(NamedTuple):
    """Indices of the grid points on either side and the share of the upper one."""

    low: IntArray
    high: IntArray
    share: FloatArray


def inside(index: FloatArray, count: int) -> Between:
    """Neighbours of fractional indices in 0 .. count - 1, which rounding may exceed."""
    index = np.clip(index, 0.0, count - 1.0)
    low = np.minimum(index.astype(np.intp), count - 2)
    return Between(low, low + 1, np.asarray(index - low))


def wrapped(index: FloatArray, count: int) -> Between:
    """Neighbours of fractional indices on a ring of `count`."""
    whole = np.floor(index)
    low = np.mod(whole, count).astype(np.intp)
    return Between(low, (low + 1) % count, np.asarray(index - whole))


def trilinear(
    velocity: NDArray[np.float32], i: Between, j: Between, k: Between, shape: tuple[int, ...]
) -> FloatArray:
    """Velocities (..., 3) of the given shape between the points of a grid (n0, n1, n2, 3)."""
    n1, n2 = velocity.shape[1:3]
    flat = velocity.reshape(-1, 3)
    out = np.zeros((*shape, 3))
    for a, p in ((i.low, 1.0 - i.share), (i.high, i.share)):
        for b, q in ((j.low, 1.0 - j.share), (j.high, j.share)):
            for c, r in ((k.low, 1.0 - k.share), (k.high, k.share)):
                out += (p * q * r)[..., None] * flat[(a * n1 + b) * n2 + c]
    return out
