"""Validation shared by the wind fields, and value semantics for frozen dataclasses.

Every message reads ``field: what arrived; what is allowed``.
"""

from __future__ import annotations

from dataclasses import fields
from typing import Any, cast

import numpy as np
from numpy.typing import ArrayLike, NDArray

from windfield.errors import WindFieldError

__all__ = [
    "FloatArray",
    "ValueSemantics",
    "as_array",
    "as_count",
    "as_number",
    "increasing",
    "read_only",
]

FloatArray = NDArray[np.float64]


def as_array(name: str, value: ArrayLike) -> FloatArray:
    """Real, finite numbers of any shape as float64 (not copied when they already are)."""
    try:
        raw = np.asarray(value)
    except ValueError as error:
        raise WindFieldError(f"{name}: got a ragged sequence; must be an array") from error
    if raw.dtype.kind not in "fiub":
        raise WindFieldError(f"{name}: got data of type {raw.dtype}; must be real numbers")
    array = raw.astype(np.float64, copy=False)
    if not np.isfinite(array).all():
        bad = array[~np.isfinite(array)]
        raise WindFieldError(
            f"{name}: got {bad.size} NaN or infinite of {array.size}; must be finite"
        )
    return array


def as_number(
    name: str,
    value: ArrayLike,
    unit: str = "-",
    *,
    above: float | None = None,
    at_least: float | None = None,
) -> float:
    """One finite number, optionally with an open (`above`) or closed (`at_least`) lower limit."""
    rule = "a finite number"
    if above is not None:
        rule += f" > {above:g}"
    if at_least is not None:
        rule += f" >= {at_least:g}"
    problem = f"{name}: got {value!r}; must be {rule} [{unit}]"
    try:
        array = as_array(name, value)
    except WindFieldError as error:
        raise WindFieldError(problem) from error
    if array.ndim:
        raise WindFieldError(problem)
    number = float(array) + 0.0  # no negative zero, so that equal values hash equally
    if (above is not None and number <= above) or (at_least is not None and number < at_least):
        raise WindFieldError(problem)
    return number


def as_count(name: str, value: object, *, at_least: int) -> int:
    """One whole number not below `at_least`."""
    whole = isinstance(value, int | np.integer) and not isinstance(value, bool)
    if not whole or int(cast(int, value)) < at_least:
        raise WindFieldError(f"{name}: got {value!r}; must be a whole number >= {at_least}")
    return int(cast(int, value))


def read_only(name: str, value: ArrayLike, *, ndim: int = 1) -> FloatArray:
    """Copy of an array of real, finite numbers that cannot be written to."""
    array = as_array(name, value)
    if array.ndim != ndim:
        raise WindFieldError(f"{name}: got shape {array.shape}; must have {ndim} dimension(s)")
    copy = array + 0.0
    copy.setflags(write=False)
    return copy


def increasing(name: str, array: FloatArray) -> None:
    """Raise unless a 1-D array increases strictly."""
    steps = np.diff(array)
    if (steps <= 0.0).any():
        k = int(np.argmax(steps <= 0.0))
        raise WindFieldError(
            f"{name}: got {array[k + 1]:g} after {array[k]:g}; must increase strictly"
        )


class ValueSemantics:
    """Equality, hash and pickling by value for frozen dataclasses that hold arrays.

    To be combined with ``@dataclass(frozen=True, kw_only=True, eq=False)``.
    """

    def _key(self) -> tuple[object, ...]:
        values = (getattr(self, item.name) for item in fields(cast(Any, self)))
        return tuple((v.shape, v.tobytes()) if isinstance(v, np.ndarray) else v for v in values)

    def __eq__(self, other: object) -> bool:
        if type(other) is not type(self):
            return NotImplemented
        return self._key() == other._key()

    def __hash__(self) -> int:
        return hash((type(self).__name__, self._key()))

    def __setstate__(self, state: dict[str, Any]) -> None:
        for value in state.values():
            if isinstance(value, np.ndarray):
                value.setflags(write=False)  # pickle restores arrays writable
        self.__dict__.update(state)
