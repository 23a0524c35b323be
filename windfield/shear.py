"""Vertical wind shear: wind speed over height, relative to the speed at the hub.

Each law is a factor g with g(H) = 1 at hub height H, so that v(z) = v(H) g(z):

    PowerLaw     g = (z / H)^xi
    LogLaw       g = ln(z / z0) / ln(H / z0)
    CubicShear   g = 1 + xi s + xi (xi - 1) / 2 s^2 + xi (xi - 1) (xi - 2) / 6 s^3,
                 s = (z - H) / H, the third-order Taylor series of the power law about the hub
    TableShear   g = v(z) / v(H), v linear between the heights of a table, constant outside

Heights z are above ground [m], not hub-centred.

References: IEC 61400-1:2019 section 6.3 (power law); T. Burton et al., Wind Energy Handbook,
section 2.6 (log law); B. Biegel et al., Wind Turbine Pitch Optimization, 2011, section III.A
(cubic; printed there with 1/2 where the Taylor series has 1/6, and 1/6 is used here).
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Protocol, runtime_checkable

import numpy as np
from numpy.typing import ArrayLike

from windfield._checks import (
    FloatArray,
    ValueSemantics,
    as_array,
    as_number,
    increasing,
    read_only,
)
from windfield.errors import WindFieldError

__all__ = ["CubicShear", "LogLaw", "PowerLaw", "TableShear", "VerticalShear"]


@runtime_checkable
class VerticalShear(Protocol):
    """Anything that tells the ratio of the wind speed at a height to that at the hub."""

    def factor(self, height: ArrayLike, hub_height: float) -> FloatArray:
        """Speed ratio v(height) / v(hub_height) [-], of the shape of `height`."""
        ...  # pragma: no cover


def _heights(height: ArrayLike, hub_height: float) -> tuple[FloatArray, float]:
    heights = as_array("height", height)
    hub = as_number("hub_height", hub_height, "m", above=0.0)
    if heights.size and heights.min() < 0.0:
        raise WindFieldError(
            f"height: got {heights.min():g} m, below ground; must be >= 0 (heights are above "
            "ground, not hub-centred)"
        )
    return heights, hub


@dataclass(frozen=True, kw_only=True)
class PowerLaw:
    """Power law (z / H)^xi.

    Parameters
    ----------
    exponent : float
        Shear exponent xi [-]; about 0.1 to 0.3 over land. Negative values (wind falling with
        height) are allowed, but then there is no value at height zero.
    """

    exponent: float

    def __post_init__(self) -> None:
        object.__setattr__(self, "exponent", as_number("exponent", self.exponent))

    def factor(self, height: ArrayLike, hub_height: float) -> FloatArray:
        """Speed ratio at heights above ground [m], any shape; zero at the ground if xi > 0.

        Raises
        ------
        WindFieldError
            For a negative height, and for height zero with a negative exponent.
        """
        heights, hub = _heights(height, hub_height)
        if self.exponent < 0.0 and heights.size and heights.min() == 0.0:
            raise WindFieldError(
                f"height: got 0 m with exponent {self.exponent:g}; must be > 0, the power law "
                "with a negative exponent is infinite at the ground"
            )
        return np.asarray((heights / hub) ** self.exponent)


@dataclass(frozen=True, kw_only=True)
class LogLaw:
    """Logarithmic law ln(z / z0) / ln(H / z0), zero at and below the roughness length.

    Parameters
    ----------
    roughness_length : float
        z0 [m], positive and below the hub; about 0.0002 at sea, 0.03 over grass.
    """

    roughness_length: float

    def __post_init__(self) -> None:
        length = as_number("roughness_length", self.roughness_length, "m", above=0.0)
        object.__setattr__(self, "roughness_length", length)

    def factor(self, height: ArrayLike, hub_height: float) -> FloatArray:
        """Speed ratio at heights above ground [m], any shape.

        Raises
        ------
        WindFieldError
            For a negative height, and if the hub is not above the roughness length.
        """
        heights, hub = _heights(height, hub_height)
        length = self.roughness_length
        if hub <= length:
            raise WindFieldError(
                f"roughness_length: got {length:g} m; must be below hub_height = {hub:g} m"
            )
        return np.asarray(np.log(np.maximum(heights, length) / length) / math.log(hub / length))


@dataclass(frozen=True, kw_only=True)
class CubicShear:
    """Third-order Taylor series of the power law about the hub.

    The remainder is xi (xi - 1) (xi - 2) (xi - 3) / 24 s^4 to leading order; with xi = 0.2 the
    error at half the hub height is 0.3 % of the hub speed. The series stays finite at the
    ground, where the power law goes to zero.

    Parameters
    ----------
    exponent : float
        Shear exponent xi [-].
    """

    exponent: float

    def __post_init__(self) -> None:
        object.__setattr__(self, "exponent", as_number("exponent", self.exponent))

    def factor(self, height: ArrayLike, hub_height: float) -> FloatArray:
        """Speed ratio at heights above ground [m], any shape; negative heights are refused."""
        heights, hub = _heights(height, hub_height)
        xi = self.exponent
        s = heights / hub - 1.0
        third = xi * (xi - 1.0) * (xi - 2.0) / 6.0
        return np.asarray(1.0 + s * (xi + s * (xi * (xi - 1.0) / 2.0 + s * third)))


@dataclass(frozen=True, kw_only=True, eq=False)
class TableShear(ValueSemantics):
    """Table of speeds over height, of which only the ratios matter.

    Parameters
    ----------
    height : (K,) array
        Above ground [m], >= 0, strictly increasing, at least two.
    speed : (K,) array
        [m/s], >= 0; positive at any hub height that is asked for.

    Raises
    ------
    WindFieldError
        If a value is out of range or not finite, or shapes disagree.
    """

    height: FloatArray
    speed: FloatArray

    def __post_init__(self) -> None:
        height, speed = read_only("height", self.height), read_only("speed", self.speed)
        if height.shape != speed.shape or height.size < 2:
            raise WindFieldError(
                f"height, speed: got shapes {height.shape} and {speed.shape}; must be equal, with "
                "at least 2 entries"
            )
        increasing("height", height)
        if height[0] < 0.0 or speed.min() < 0.0:
            raise WindFieldError(
                f"height, speed: got {height[0]:g} m and {speed.min():g} m/s; must be >= 0"
            )
        object.__setattr__(self, "height", height)
        object.__setattr__(self, "speed", speed)

    def factor(self, height: ArrayLike, hub_height: float) -> FloatArray:
        """Speed ratio v(height) / v(hub_height) [-], of the shape of `height`.

        Raises
        ------
        WindFieldError
            For a height below ground, or a hub height at which the table has no wind.
        """
        heights, hub = _heights(height, hub_height)
        at_hub = float(np.interp(hub, self.height, self.speed))
        if at_hub <= 0.0:
            raise WindFieldError(
                f"hub_height: got {hub:g} m, where the table has a speed of 0; must be positive"
            )
        return np.asarray(np.interp(heights, self.height, self.speed) / at_hub)
