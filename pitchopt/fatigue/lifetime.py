"""Fatigue over the wind speeds of a lifetime.

Wind speeds have a Weibull distribution of shape k and scale A,

    F(v) = 1 - exp(-(v / A)^k),         mean = A Gamma(1 + 1 / k),

k = 2 is Rayleigh's. A bin of wind speeds has the weight p = F(upper edge) - F(lower edge), the
share of time spent in it. Equivalent loads (at one frequency) and damages of the bins combine as

    DEL = (sum_i p_i DEL_i^m)^(1 / m),      D = sum_i p_i D_i lifetime / duration.

Reference: IEC 61400-1:2019, sections 6.3.1 and annex G.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike

from pitchopt.checks import FloatArray, finite_array, finite_number
from pitchopt.errors import InputError

__all__ = ["bin_edges", "combine_damage", "combine_loads", "weibull_weights"]


def bin_edges(speeds: ArrayLike) -> FloatArray:
    """Edges (n + 1,) [m/s] of bins around wind speeds (n,): midway between them.

    The outer ones are as far from the first and the last speed as the inner ones; none is
    below zero.

    Raises
    ------
    InputError
        Unless there are at least two, increasing and not below zero.
    """
    centres = finite_array("speeds", speeds)
    steps = np.diff(centres)
    if centres.size < 2 or steps.min() <= 0.0 or centres[0] < 0.0:
        raise InputError(
            f"speeds: got {centres.tolist()}, expected at least 2 increasing speeds from 0 on"
        )
    middle = 0.5 * (centres[1:] + centres[:-1])
    first = max(0.0, centres[0] - 0.5 * steps[0])
    return np.concatenate([[first], middle, [centres[-1] + 0.5 * steps[-1]]])


def weibull_weights(
    edges: ArrayLike,
    *,
    shape: float = 2.0,
    scale: float | None = None,
    mean: float | None = None,
    normalised: bool = False,
) -> FloatArray:
    """Weights (n,) [-] of n bins of wind speed.

    Parameters
    ----------
    edges : (n + 1,) array_like
        Increasing, >= 0 [m/s]; see `bin_edges`.
    shape : float
        k, positive [-].
    scale, mean : float
        A, or the mean wind speed [m/s], positive; exactly one of the two.
    normalised : bool
        Scale them to a sum of one. Otherwise the sum is the share of time within the edges.

    Raises
    ------
    InputError
        If a value is out of range, or the edges hold no share of time at all.
    """
    if (scale is None) == (mean is None):
        raise InputError(f"scale, mean: got {scale} and {mean}, expected exactly one of them")
    k = finite_number("shape", shape, above=0.0)
    if scale is None:
        scale = finite_number("mean", mean, above=0.0) / math.gamma(1.0 + 1.0 / k)
    a = finite_number("scale", scale, above=0.0)
    v = finite_array("edges", edges)
    if v.size < 2 or np.diff(v).min() <= 0.0 or v[0] < 0.0:
        raise InputError(
            f"edges: got {v.tolist()}, expected at least 2 increasing speeds from 0 on"
        )
    weights = -np.diff(np.exp(-((v / a) ** k)))
    if not normalised:
        return weights
    total = float(weights.sum())
    if total <= 0.0:
        raise InputError(f"edges: got {v[0]} to {v[-1]}, where the distribution has no weight")
    return weights / total


def combine_loads(loads: ArrayLike, weights: ArrayLike | None, slope: float) -> FloatArray:
    """Equivalent load over bins, or over seeds, of equivalent loads of the same frequency.

    Parameters
    ----------
    loads : (..., n) array_like
        Equivalent loads, >= 0.
    weights : (n,) array_like or None
        >= 0; None: 1 / n each, as for seeds.
    slope : float
        m, positive [-].

    Returns
    -------
    ndarray, shape (...)

    Raises
    ------
    InputError
        If shapes disagree or a number is out of range.
    """
    values, p = _weighted("loads", loads, weights)
    m = finite_number("slope", slope, above=0.0)
    largest = values.max(axis=-1, keepdims=True)
    share = values / np.where(largest > 0.0, largest, 1.0)
    return np.asarray(largest[..., 0] * (share**m @ p) ** (1.0 / m))


def combine_damage(
    damages: ArrayLike, weights: ArrayLike | None, *, duration: float, lifetime: float
) -> FloatArray:
    """Damage over a lifetime of the damages of bins.

    Parameters
    ----------
    damages : (..., n) array_like
        Damage in `duration` in each bin, >= 0 [-].
    weights : (n,) array_like or None
        >= 0; None: 1 / n each, as for seeds.
    duration, lifetime : float
        Positive, of the same unit.

    Returns
    -------
    ndarray, shape (...)

    Raises
    ------
    InputError
        If shapes disagree or a number is out of range.
    """
    values, p = _weighted("damages", damages, weights)
    factor = finite_number("lifetime", lifetime, above=0.0) / finite_number(
        "duration", duration, above=0.0
    )
    return np.asarray(factor * (values @ p))


def _weighted(
    name: str, values: ArrayLike, weights: ArrayLike | None
) -> tuple[FloatArray, FloatArray]:
    array = finite_array(name, values, shape=np.shape(values))
    if not array.ndim or not array.size:
        raise InputError(f"{name}: got shape {array.shape}, expected (..., n) with n at least 1")
    n = array.shape[-1]
    p = finite_array("weights", np.full(n, 1.0 / n) if weights is None else weights, shape=(n,))
    for label, numbers in ((name, array), ("weights", p)):
        if numbers.min() < 0.0:
            raise InputError(f"{label}: got {numbers.min()}, expected numbers >= 0")
    return array, p
