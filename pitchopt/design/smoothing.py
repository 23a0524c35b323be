"""Smoothed curves: loads without kinks, to tell starts apart by.

    f_w(beta) = (1 / 2w) integral of f from beta - w to beta + w,

the moving average of a piecewise-linear curve, at its breakpoints; w shrinks towards the ends,
where the curve stays as it is.  Torque is left alone: its segments are exact in the subproblem,
and averaging near an end would break its concavity.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from pitchopt.aero.curves import BladeCurves

__all__ = ["smoothed"]

FloatArray = NDArray[np.float64]

_WIDTH = float(np.radians(1.0))


def smoothed(curves: BladeCurves, width: float = _WIDTH) -> BladeCurves:
    """Curves whose bending, thrust and radial moment are averaged over pitch.

    Parameters
    ----------
    curves : BladeCurves
    width : float
        Half-width w of the average [rad].
    """
    bending, thrust, radial = (
        _averaged(curves, np.asarray(values), width)
        for values in (curves.bending, curves.thrust, curves.radial)
    )
    return replace(curves, bending=bending, thrust=thrust, radial=radial)


def _averaged(curves: BladeCurves, values: FloatArray, width: float) -> FloatArray:
    beta = curves.beta
    gaps = np.diff(beta, axis=1)
    slope = np.diff(values, axis=1) / gaps
    area = np.zeros_like(values)
    area[:, 1:] = np.cumsum(0.5 * gaps * (values[:, 1:] + values[:, :-1]), axis=1)
    rows = np.arange(curves.stations)[:, None]

    def primitive(x: FloatArray) -> FloatArray:
        j = curves.segment(x)
        t = x - beta[rows, j]
        return np.asarray(area[rows, j] + t * (values[rows, j] + 0.5 * t * slope[rows, j]))

    half = np.minimum(width, np.minimum(beta - beta[:, :1], beta[:, -1:] - beta))
    inside = half > 1e-7
    safe = np.where(inside, half, 1.0)
    mean = (primitive(beta + half) - primitive(beta - half)) / (2 * safe)
    return np.where(inside, mean, values)
