"""Decorators that compile the functions of the time loop.

Nothing in the time loop allocates memory, so arrays need no reference counts there and numba's
runtime is left out (`_nrt`): counting took a third of the time, and whatever would allocate does
not compile.  That option is numba's own business (here from 0.60 to 0.68); a numba without it
runs the same loop slower.  Functions that take whole tuples of tables are inlined, because
handing such a tuple over copies it word by word; functions called inside a loop over blade
elements are inlined so that the loop becomes one of vector instructions.

`compiled` and `inlined` keep the order of sums, `summing` lets the compiler change it.  The
cache of a compiled function does not see changes in another module that it has inlined.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from numba import njit
from numba.core.options import DefaultOptions

__all__ = ["compiled", "inlined", "summing"]

_OPTIONS: dict[str, Any] = {
    "cache": True,
    "nogil": True,
    "error_model": "numpy",
    "fastmath": {"contract", "nsz"},
}
if hasattr(DefaultOptions, "_nrt"):
    _OPTIONS["_nrt"] = False


def compiled(function: Callable[..., object]) -> Callable[..., Any]:
    """Compile a function."""
    out: Callable[..., Any] = njit(**_OPTIONS)(function)
    return out


def inlined(function: Callable[..., object]) -> Callable[..., Any]:
    """Compile a function into its callers."""
    out: Callable[..., Any] = njit(**_OPTIONS, forceinline=True)(function)
    return out


def summing(function: Callable[..., object]) -> Callable[..., Any]:
    """Compile a function whose sums may be taken in any order, and so in vectors."""
    options = {**_OPTIONS, "fastmath": {"contract", "nsz", "reassoc"}}
    out: Callable[..., Any] = njit(**options)(function)
    return out
