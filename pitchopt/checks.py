"""Checks of input shared by all parts: one clear error per field."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike, NDArray

from pitchopt.errors import InputError

__all__ = ["FloatArray", "finite_array", "finite_number", "whole_number"]

FloatArray = NDArray[np.float64]


def finite_array(
    name: str, value: ArrayLike, *, shape: tuple[int, ...] | None = None
) -> FloatArray:
    """Read-only float copy of `value`.

    Parameters
    ----------
    name : str
        Field that an error names.
    value : array_like
        Numbers.
    shape : tuple of int, optional
        Shape that is required; a one-dimensional array of any length without it.

    Raises
    ------
    InputError
        If `value` is not numeric, has another shape or holds NaN or infinite values.
    """
    try:
        array = np.array(value, dtype=np.float64)
    except (TypeError, ValueError) as error:
        raise InputError(f"{name}: expected numbers, got {type(value).__name__}") from error
    if shape is None:
        if array.ndim != 1 or array.size == 0:
            raise InputError(f"{name}: got shape {array.shape}, expected a non-empty vector")
    elif array.shape != shape:
        raise InputError(f"{name}: got shape {array.shape}, expected {shape}")
    if not np.all(np.isfinite(array)):
        raise InputError(f"{name}: got {np.sum(~np.isfinite(array))} NaN or infinite values")
    array.setflags(write=False)
    return array


def _plain(name: str, value: object) -> float:
    if isinstance(value, (str, bytes, bool)):
        raise InputError(f"{name}: got {value!r}, expected a number")
    try:
        return float(value)  # type: ignore[arg-type]
    except (TypeError, ValueError) as error:
        raise InputError(f"{name}: got {value!r}, expected a number") from error


def whole_number(name: str, value: object, *, at_least: int) -> int:
    """`value` as an int of at least `at_least`, or an `InputError` that names the field."""
    number = _plain(name, value)
    if not number.is_integer() or number < at_least:
        raise InputError(f"{name}: got {value!r}, expected a whole number of at least {at_least}")
    return int(number)


def finite_number(
    name: str,
    value: object,
    *,
    above: float | None = None,
    at_least: float | None = None,
    at_most: float | None = None,
) -> float:
    """`value` as a float within the stated bounds, or an `InputError` that names the field."""
    number = _plain(name, value)
    allowed = [
        text
        for text, bound in (
            (f"above {above}", above),
            (f"at least {at_least}", at_least),
            (f"at most {at_most}", at_most),
        )
        if bound is not None
    ]
    bad = (
        not math.isfinite(number)
        or (above is not None and number <= above)
        or (at_least is not None and number < at_least)
        or (at_most is not None and number > at_most)
    )
    if bad:
        raise InputError(f"{name}: got {number}, expected a finite number " + " and ".join(allowed))
    return number
