"""Damage-equivalent loads.

The constant range that, at a frequency f for the length T of the signal, does the damage of all
its cycles on an S-N curve of slope m (N proportional to S^-m),

    DEL = (sum_i n_i S_i^m / (f T))^(1 / m),

S_i the rainflow ranges (peak to peak) and n_i their counts, without a correction for the means.
For steel m is 3 to 5, for glass-fibre blades about 10.

Reference: IEC 61400-1:2019, annex G; G. J. Hayman, MLife Theory Manual, NREL, 2012.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from pitchopt.checks import finite_number
from pitchopt.errors import InputError
from pitchopt.fatigue.counting import Cycles, Residue, rainflow

__all__ = ["damage_equivalent_load", "equivalent_load"]


def equivalent_load(
    cycles: Cycles, slope: float, *, duration: float, frequency: float = 1.0
) -> float:
    """Damage-equivalent load of cycles that were counted already [unit of the signal].

    Parameters
    ----------
    cycles : Cycles
    slope : float
        m, positive [-].
    duration : float
        T [s], positive.
    frequency : float
        f [Hz], positive.

    Raises
    ------
    InputError
        If a number is out of range.
    """
    m = finite_number("slope", slope, above=0.0)
    length = finite_number("duration", duration, above=0.0)
    rate = finite_number("frequency", frequency, above=0.0)
    if not cycles.ranges.size:
        return 0.0
    largest = float(cycles.ranges.max())  # taken out, so that no power overflows
    total = float(cycles.counts @ (cycles.ranges / largest) ** m)
    return float(largest * (total / (rate * length)) ** (1.0 / m))


def damage_equivalent_load(
    signal: ArrayLike,
    slope: float,
    *,
    duration: float | None = None,
    sample_rate: float | None = None,
    frequency: float = 1.0,
    residue: Residue = "half",
) -> float:
    """Damage-equivalent load of a signal [unit of the signal]; 0 for a constant one.

    Parameters
    ----------
    signal : (n,) array_like
        At least two samples, finite, evenly spaced in time.
    slope, frequency
        As in `equivalent_load`.
    duration : float
        Length of the signal [s].
    sample_rate : float
        Instead of the duration: samples a second [Hz]; the length is then that from the first
        sample to the last, (n - 1) / rate.
    residue : {"half", "repeat"}
        As in `rainflow`.

    Raises
    ------
    InputError
        For a bad signal, a number out of range, or unless exactly one of `duration` and
        `sample_rate` is given.
    """
    if (duration is None) == (sample_rate is None):
        raise InputError(
            f"duration, sample_rate: got {duration} and {sample_rate}, expected exactly one of them"
        )
    cycles = rainflow(signal, residue=residue)
    if duration is None:
        rate = finite_number("sample_rate", sample_rate, above=0.0)
        duration = (np.size(np.asarray(signal)) - 1) / rate
    return equivalent_load(cycles, slope, duration=duration, frequency=frequency)
