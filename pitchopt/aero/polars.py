"""Airfoil polars: lift, drag and moment coefficients over the angle of attack.

Between the rows of the table the coefficients are linear, outside they keep the end values
(a full table spans -180 to 180 degrees).  Angles in radians; the moment coefficient is about
the aerodynamic centre and positive nose-up.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property, lru_cache

import numpy as np
from numpy.typing import ArrayLike

from pitchopt.checks import FloatArray, finite_array
from pitchopt.errors import InputError

__all__ = ["Polar", "blend"]

_ATTACHED = np.deg2rad(25.0)  # the zero-lift angle is looked for within this of zero
_MIN_LIFT = 0.3  # below this largest lift coefficient a section is a bluff body


@dataclass(frozen=True, kw_only=True, eq=False)
class Polar:
    """Table of section coefficients.

    Parameters
    ----------
    name : str
        Name of the airfoil.
    alpha : array (P,)
        Angles of attack [rad], strictly increasing.
    cl, cd : array (P,)
        Lift and drag coefficients [-].
    cm : array (P,), optional
        Moment coefficient about the aerodynamic centre, nose-up positive [-]; zero if absent.

    Raises
    ------
    InputError
        If shapes differ, angles do not increase or values are not finite.
    """

    name: str = ""
    alpha: FloatArray
    cl: FloatArray
    cd: FloatArray
    cm: FloatArray | None = None

    def __post_init__(self) -> None:
        alpha = finite_array("polar.alpha", self.alpha)
        if alpha.size < 2 or np.any(np.diff(alpha) <= 0.0):
            raise InputError(
                f"polar.alpha: airfoil {self.name!r} needs at least 2 strictly increasing angles"
            )
        object.__setattr__(self, "alpha", alpha)
        for key in ("cl", "cd", "cm"):
            value = getattr(self, key)
            if value is None:
                value = np.zeros(alpha.size)
            object.__setattr__(self, key, finite_array(f"polar.{key}", value, shape=alpha.shape))

    @property
    def moment(self) -> FloatArray:
        """Moment coefficients (P,), zeros where the table has none."""
        assert self.cm is not None  # set in __post_init__
        return self.cm

    def coefficients(self, alpha: ArrayLike) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Cl, Cd, Cm at angles of attack of any shape [rad], linear between the rows."""
        x = np.asarray(alpha, dtype=np.float64)
        return (
            np.interp(x, self.alpha, self.cl),
            np.interp(x, self.alpha, self.cd),
            np.interp(x, self.alpha, self.moment),
        )

    @cached_property
    def _attached(self) -> tuple[int, int] | None:
        """Rows of negative and positive stall, or None where lift never rises through zero.

        Small local maxima in the linear range (tables of thick airfoils have them) do not count:
        Cl must have reached half of its largest value within `_ATTACHED`.
        """
        near = np.flatnonzero(np.abs(self.alpha) <= _ATTACHED)
        if near.size < 3 or float(self.cl[near].max()) < _MIN_LIFT:
            return None
        first, last = int(near[0]), int(near[-1])
        half = 0.5 * float(self.cl[near].max())
        rows = [
            i for i in range(first, last) if self.cl[i] >= half and self.cl[i + 1] <= self.cl[i]
        ]
        high = rows[0] if rows else last
        below = [i for i in range(first, high) if self.cl[i] <= 0.0]
        if not below:
            return None
        start = below[-1]
        half = 0.5 * float(self.cl[first : start + 1].min())
        rows = [
            i
            for i in range(start, first, -1)
            if self.cl[i] <= min(half, -1e-9) and self.cl[i - 1] >= self.cl[i]
        ]
        low = rows[0] if rows else first
        return low, high

    @property
    def lifting(self) -> bool:
        """Whether the section has an attached range at all (a cylinder has none)."""
        return self._attached is not None

    def stall_angle(self) -> float:
        """First local maximum of Cl above the zero-lift angle [rad].

        Raises
        ------
        InputError
            If the section has no attached range, e.g. a cylinder.
        """
        return self.attached_range()[1]

    def attached_range(self) -> tuple[float, float]:
        """Angles of attack of negative and positive stall [rad]: Cl increases in between."""
        if self._attached is None:
            raise InputError(
                f"polar {self.name!r}: no attached range (lift does not rise through zero near "
                "zero angle of attack), so it has no stall angle"
            )
        low, high = self._attached
        return float(self.alpha[low]), float(self.alpha[high])

    def zero_lift_angle(self) -> float:
        """Highest angle of attack below stall at which lift vanishes [rad]."""
        if self._attached is None:
            raise InputError(f"polar {self.name!r}: no attached range, no zero-lift angle")
        low, high = self._attached
        start = max(i for i in range(low, high) if self.cl[i] <= 0.0)
        rise = self.cl[start + 1] - self.cl[start]
        share = -self.cl[start] / rise
        return float(self.alpha[start] + share * (self.alpha[start + 1] - self.alpha[start]))

    def concave_range(self, cl_error: float = 0.01, cd_error: float = 0.002) -> tuple[float, float]:
        """Widest range below stall in which lift is nearly concave and drag nearly convex [rad].

        The best concave approximation of a function errs by half the largest gap to its concave
        envelope.  From the stall angle down, rows are added while that error stays within
        `cl_error` for lift and, for the convex approximation of drag, within `cd_error`, but not
        beyond negative stall.
        """
        return _concave_range(self, cl_error, cd_error)


@lru_cache(maxsize=1024)
def _concave_range(polar: Polar, cl_error: float, cd_error: float) -> tuple[float, float]:
    low, high = polar.attached_range()
    top = int(np.searchsorted(polar.alpha, high))
    best = top - 1
    for row in range(top - 1, -1, -1):
        if polar.alpha[row] < low:
            break
        rows = slice(row, top + 1)
        if _hull_gap(polar.alpha[rows], polar.cl[rows]) > 2 * cl_error:
            break
        if _hull_gap(polar.alpha[rows], -polar.cd[rows]) > 2 * cd_error:
            break
        best = row
    return float(polar.alpha[best]), high


def _hull_gap(x: FloatArray, y: FloatArray) -> float:
    """Largest distance of a piecewise-linear function below its concave envelope."""
    hull: list[int] = []
    for i in range(x.size):
        while len(hull) > 1:
            a, b = hull[-2], hull[-1]
            if (y[b] - y[a]) * (x[i] - x[a]) <= (y[i] - y[a]) * (x[b] - x[a]):
                hull.pop()
            else:
                break
        hull.append(i)
    return float(np.max(np.interp(x, x[hull], y[hull]) - y))


def blend(first: Polar, second: Polar, weight: float, *, name: str | None = None) -> Polar:
    """Polar between two: (1 - weight) first + weight second on the union of their angles."""
    if not 0.0 <= weight <= 1.0:
        raise InputError(f"weight: got {weight}, expected a number from 0 to 1")
    if weight == 0.0 or first is second:
        return first
    if weight == 1.0:
        return second
    alpha = np.union1d(first.alpha, second.alpha)
    one, two = first.coefficients(alpha), second.coefficients(alpha)
    cl, cd, cm = ((1.0 - weight) * a + weight * b for a, b in zip(one, two, strict=True))
    label = name or f"{first.name}-{second.name} {weight:.3f}"
    return Polar(name=label, alpha=alpha, cl=cl, cd=cd, cm=cm)
