"""What the estimators know of a solved problem.

A model is a minimisation of F(x, c) (for a maximisation F = -f), its entries r(x, c), the optimum
x*, multipliers lambda and the reference c_r.  `pitchopt.sensitivity.functions`, `table` and
`convex` make models; nothing here knows where the numbers come from.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from pitchopt.checks import FloatArray
from pitchopt.sensitivity.rows import Layout

__all__ = ["Counts", "Gradients", "Model", "Slope", "Values"]


@dataclass(frozen=True)
class Values:
    """F and r (N,) at a point."""

    objective: float
    entries: FloatArray

    @property
    def vector(self) -> FloatArray:
        """Both, F first (1 + N,)."""
        return np.concatenate([[self.objective], self.entries])


@dataclass(frozen=True)
class Gradients:
    """Gradients in x at (x*, c).

    Attributes
    ----------
    objective : (n,) ndarray
        Of F.
    entries : (N, n) sparse array
        Of r.
    error : float
        Estimate of the relative error of finite differences; 0 for exact gradients.
    """

    objective: FloatArray
    entries: sparse.csr_array
    error: float = 0.0


@dataclass(frozen=True)
class Slope:
    """Derivative along dc, already times dc: first-order changes.

    Attributes
    ----------
    objective : float
        Of F.
    entries : (N,) ndarray
        Of r.
    error : float or None
        Estimate of the error of dF + lambda . dr; 0 where exact, None where unknown.
    step : float or None
        Shortest step relative to dc of the differences; None where exact.
    """

    objective: float
    entries: FloatArray
    error: float | None = 0.0
    step: float | None = None


@dataclass
class Counts:
    """Evaluations so far; of functions each point counts once, asked for again it costs nothing.

    Attributes
    ----------
    frozen : int
        Of F and r with x* frozen, at values of c.
    moved : int
        At other x: predicted steps and differences in x.
    gradients : int
        In x, given by the user or by the problem.
    """

    frozen: int = 0
    moved: int = 0
    gradients: int = 0


class Model(Protocol):
    """A solved problem; `keeps_slopes` if the slope of a shorter dc serves a longer one."""

    layout: Layout
    sense: float
    reference: NDArray[np.float64]
    multipliers: FloatArray
    counts: Counts
    keeps_slopes: bool

    @property
    def scale(self) -> FloatArray | None:
        """Typical size of each variable (n,), positive; None if x is unknown."""
        ...

    def values(self, c: NDArray[np.float64], move: FloatArray | None = None) -> Values:
        """F and r at (x* + move, c); `InputError` outside the domain."""
        ...

    def gradients(self, c: NDArray[np.float64]) -> Gradients | None:
        """In x at (x*, c); None where there are none."""
        ...

    def tangent(self, vectors: FloatArray) -> FloatArray:
        """Steps (n,) projected on those that the variables can make at all."""
        ...

    def slope(self, dc: NDArray[np.float64]) -> Slope:
        """Derivative along dc at (x*, c_r), from the side of dc."""
        ...

    def unmet(self, c: NDArray[np.float64], tolerance: float) -> Unmet | None:
        """What no x can meet at c; None if it is not judged."""
        ...


@dataclass(frozen=True)
class Unmet:
    """Names of rows that cannot be met together; none if the problem is feasible.

    Attributes
    ----------
    names : tuple of str
    note : str
        How it was decided, such as "to first order".
    """

    names: tuple[str, ...]
    note: str = ""


def solid(value: object) -> FloatArray:
    """Dense float array of a number, an array or a sparse matrix."""
    toarray = getattr(value, "toarray", None)
    if toarray is not None:
        value = toarray()
    return np.asarray(value, dtype=np.float64)


def sizes(x: FloatArray, zero: float = 1e-12) -> FloatArray:
    """Typical sizes of variables: their own, or the largest's where they are below `zero` of it."""
    largest = float(np.max(np.abs(x), initial=0.0)) or 1.0
    return np.where(np.abs(x) > zero * largest, np.abs(x), largest)
