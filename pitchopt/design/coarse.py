"""Coarser rotor positions: a small problem that shows a large one where to start.

Every s-th station of the curves makes a problem of its own (:attr:`DesignProblem.coarse`), where
s divides the number of rotor positions so that stations n, n + m, ... stay together.  A profile
found there is interpolated linearly, which keeps the rate limit.  Multipliers of loads are
densities over the turn and shrink by s.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from pitchopt.design.multipliers import Multipliers

__all__ = ["interpolated", "stride", "widened"]

FloatArray = NDArray[np.float64]

_FEWEST = 60  # positions that still show every load of a rotor passing a tower


def stride(positions: int, fewest: int = _FEWEST) -> int:
    """The largest divisor of the positions that leaves so many of them; 1 when none does."""
    return max(s for s in range(1, max(positions // fewest, 1) + 1) if positions % s == 0)


def interpolated(values: FloatArray, step: int) -> FloatArray:
    """Periodic linear interpolation of values (..., n) to n ``step`` points."""
    share = np.arange(step) / step
    after = np.roll(values, -1, axis=-1)
    mixed = values[..., None] * (1 - share) + after[..., None] * share
    return np.asarray(mixed.reshape(*values.shape[:-1], -1))


def widened(mult: Multipliers, step: int) -> Multipliers:
    """Multipliers for ``step`` times as many stations."""
    return replace(
        mult,
        loads=interpolated(mult.loads, step) / step,
        blade=interpolated(mult.blade, step) / step,
        rate=interpolated(mult.rate, step),
        basis=0.0,
    )
