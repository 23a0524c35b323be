"""Rainflow counting of a load or stress signal.

ASTM E1049-85 (2017), section 5.4.4, on the reversals of the signal (first and last sample
included): with X the latest range and Y the one before it, Y is counted as soon as X >= Y, as
a full cycle, or as half a cycle if it contains the first point of what is left. What remains
at the end, ranges that grow and then shrink, is the residue.

`residue` says what becomes of it:

    "half"      each of its ranges is half a cycle, as the standard has it
    "repeat"    the signal is one period of a load that repeats itself (section 5.4.5): it is
                counted from its largest value once round, and all cycles are full ones

Ranges are from valley to peak, not amplitudes. Samples that repeat the one before are no
reversals; a constant signal has no cycles. Nothing is binned.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, get_args

import numpy as np
from numpy.typing import ArrayLike

from pitchopt.checks import FloatArray, finite_array
from pitchopt.errors import InputError

__all__ = ["Cycles", "Residue", "rainflow"]

Residue = Literal["half", "repeat"]


@dataclass(frozen=True, kw_only=True, eq=False)
class Cycles:
    """Cycles of a signal, in the order in which they were closed.

    Attributes
    ----------
    ranges : (C,) array
        From valley to peak, positive [unit of the signal].
    means : (C,) array
        Halfway between the two [unit of the signal].
    counts : (C,) array
        1 for a cycle, 0.5 for half of one [-].
    """

    ranges: FloatArray
    means: FloatArray
    counts: FloatArray

    def __post_init__(self) -> None:
        size = np.size(self.ranges)
        for name in ("ranges", "means", "counts"):
            object.__setattr__(self, name, finite_array(name, getattr(self, name), shape=(size,)))
        for name in ("ranges", "counts"):
            values = getattr(self, name)
            if size and values.min() <= 0.0:
                raise InputError(f"{name}: got {values.min()}, expected positive numbers")


def rainflow(signal: ArrayLike, *, residue: Residue = "half") -> Cycles:
    """Count the cycles of a signal.

    Parameters
    ----------
    signal : (n,) array_like
        At least two samples, finite.
    residue : {"half", "repeat"}
        See the module.

    Raises
    ------
    InputError
        If the signal is too short, not one-dimensional or holds NaN, or `residue` is another.
    """
    from pitchopt.fatigue.kernels import count_cycles

    values = finite_array("signal", signal)
    if values.size < 2:
        raise InputError(f"signal: got {values.size} sample, expected at least 2")
    if residue not in get_args(Residue):
        raise InputError(f"residue: got {residue!r}, expected one of {get_args(Residue)}")
    repeat = residue == "repeat"
    start = int(np.argmax(values)) if repeat else 0
    stack, ranges, means, counts = np.empty((4, values.size + 1))
    found = count_cycles(values, start, repeat, stack, ranges, means, counts)
    return Cycles(ranges=ranges[:found], means=means[:found], counts=counts[:found])
