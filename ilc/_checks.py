"""Checks of input: one clear error per field, ``field: got ..., expected ...``."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ilc.errors import LearningError

__all__ = ["FloatArray", "IntArray", "array_of", "count", "number"]

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.intp]


def number(
    name: str,
    value: object,
    *,
    above: float = -math.inf,
    at_least: float = -math.inf,
    at_most: float = math.inf,
) -> float:
    """One finite number within limits."""
    out = math.nan
    if not isinstance(value, (str, bytes, bool)):
        try:
            out = float(value)  # type: ignore[arg-type]
        except (TypeError, ValueError):
            out = math.nan
    if math.isfinite(out) and out > above and at_least <= out <= at_most:
        return out
    rules = [
        f"{words} {limit:g}"
        for words, limit in (("above", above), ("at least", at_least), ("at most", at_most))
        if math.isfinite(limit)
    ]
    rule = " and ".join(rules)
    raise LearningError(
        f"{name}: got {value!r}, expected a finite number{' ' if rule else ''}{rule}"
    )


def count(name: str, value: object, *, at_least: int = 0) -> int:
    """One whole number."""
    if isinstance(value, (int, np.integer)) and not isinstance(value, bool) and value >= at_least:
        return int(value)
    raise LearningError(f"{name}: got {value!r}, expected a whole number of at least {at_least}")


def array_of(
    name: str, value: ArrayLike, shape: tuple[int, ...], *, finite: bool = True
) -> FloatArray:
    """Float copy of an array of a given shape."""
    try:
        out = np.array(value, dtype=np.float64)
    except (TypeError, ValueError) as error:
        raise LearningError(f"{name}: got {type(value).__name__}, expected numbers") from error
    if out.shape != shape:
        raise LearningError(f"{name}: got shape {out.shape}, expected {shape}")
    if finite and not np.isfinite(out).all():
        raise LearningError(f"{name}: got {int((~np.isfinite(out)).sum())} NaN or infinite values")
    return out
