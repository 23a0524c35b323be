"""Spectra of load ranges: cycles of many signals in bins of equal width in the logarithm.

Bin b is centred at S_b = S_0 exp(b w) and holds the ranges that are nearest to it in the logarithm;
ranges beyond the ends go to the end bins.  Laid on an S-N curve of slope m, a bin's centre in place
of the ranges spread over it changes their damage by m^2 w^2 / 24.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike

from pitchopt.checks import FloatArray, finite_array, finite_number, whole_number
from pitchopt.errors import InputError

__all__ = ["range_spectra"]


def range_spectra(signals: ArrayLike, *, first: float, width: float, bins: int) -> FloatArray:
    """Rainflow cycles of signals by bins of their ranges, residues as half cycles.

    Parameters
    ----------
    signals : (K, n) array_like
        Of two or more samples each, finite.
    first : float
        S_0 [unit of the signals], positive.
    width : float
        w, positive [-].
    bins : int

    Returns
    -------
    ndarray (K, bins)
        Cycles [-].

    Raises
    ------
    InputError
        If the shape is another, signals hold NaN or infinite values, or a number is out of range.
    """
    from pitchopt.fatigue.kernels import count_spectra

    shape = np.shape(signals)
    if len(shape) != 2 or shape[0] < 1 or shape[1] < 2:
        raise InputError(f"signals: got shape {shape}, expected (signals, two samples or more)")
    values = finite_array("signals", signals, shape=shape)
    start = math.log(finite_number("first", first, above=0.0))
    step = finite_number("width", width, above=0.0)
    return np.asarray(
        count_spectra(
            np.ascontiguousarray(values), start, step, whole_number("bins", bins, at_least=1)
        )
    )
