"""Derivative of a vector of terms along a direction, with a step that is checked.

One-sided differences D(h) = (v(t = h) - v(0)) / h with h = h0 / 2^j are extrapolated twice,

    T(h) = (4 T1(h / 2) - T1(h)) / 3,     T1(h) = 2 D(h / 2) - D(h),

which is exact for cubics.  One-sided, since c_r + t dc with 0 <= t <= 1 is where the estimate is
used, often the only side where the functions are defined, and the one that counts at a kink.  The
error of T is taken as that of the last extrapolation plus rounding, summed over the weighted
terms; steps are halved until it is small against them.

References: L. F. Richardson, Phil. Trans. R. Soc. A 210, 1911; C. J. F. Ridders,
Adv. Eng. Software 4, 1982.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from pitchopt.checks import FloatArray
from pitchopt.errors import ComputationError

__all__ = ["Derivative", "settled_derivative"]

FIRST = 2.0**-5
MOST = 24
SETTLED = 1e-6
USABLE = 1e-2
NEGLIGIBLE = 1e-8
ROUNDING = 64.0 * np.finfo(np.float64).eps


@dataclass(frozen=True)
class Derivative:
    """Derivative (m,), the error of its weighted sum, and the shortest step."""

    value: FloatArray
    error: float
    step: float


def settled_derivative(
    values: Callable[[float], FloatArray], weights: FloatArray, *, name: str
) -> Derivative:
    """Derivative of `values` at t = 0 towards t = 1.

    Parameters
    ----------
    values : callable
        t -> (m,), defined on 0 <= t <= 1.
    weights : (m,) ndarray
        Of the values in the sum that has to be right.
    name : str
        Of the direction, for the error.

    Raises
    ------
    ComputationError
        If no step gives the derivative to a hundredth of the size of its terms.
    """

    def size(terms: FloatArray) -> float:
        return float(np.sum(np.abs(weights * terms)))

    start = values(0.0)
    largest = size(start)
    quotients: list[FloatArray] = []
    best: Derivative | None = None
    for j in range(MOST):
        step = FIRST * 2.0**-j
        there = values(step)
        largest = max(largest, size(there))
        quotients.append((there - start) / step)
        if j < 2:
            continue
        a, b, c = quotients[-3:]
        once = 2.0 * c - b
        value = (4.0 * once - (2.0 * b - a)) / 3.0
        rounding = ROUNDING * largest / step
        error = float(size(value - once) + rounding)
        if best is None or error < best.error:
            best = Derivative(value, error, step)
        total = size(value)
        if error <= SETTLED * total or (error <= 2.0 * rounding and total <= 10.0 * rounding):
            return best
        if rounding > 10.0 * best.error:
            break
    if best is not None and best.error <= max(USABLE * size(best.value), NEGLIGIBLE * largest):
        return best
    least, at = (math.inf, math.nan) if best is None else (best.error, best.step)
    raise ComputationError(
        f"{name}: differences do not settle, the best error is {least:.3g} with a step of "
        f"{at:.1e} of dc; give gradients or a step"
    )
