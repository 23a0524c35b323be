"""Tower shadow of an upwind rotor: potential flow past the tower, height by height.

For undisturbed wind W along x' at a point (x', y') seen from the tower axis, a cylinder of
radius a disturbs the wind by

    du' = -W a^2 (x'^2 - y'^2) / (x'^2 + y'^2)^2        along the wind
    dv' = -W a^2 2 x' y'       / (x'^2 + y'^2)^2        to the left of it

which follows from the complex velocity u - i v = conj(V) - V a^2 / zeta^2, V = U + i V', of
the dipole that cancels the flow through the surface |zeta| = a. In front of the tower
(x' = -d, y' = 0) the wind is slower by W a^2 / d^2. `W` is the undisturbed wind at the point
itself, `x'` follows the direction of that wind, `a` is the tower radius at that height.

Above the tower top the disturbance is multiplied by cos^2(pi/2 (z - top) / smoothing), which
is 1 up to `top` and 0 from `top + smoothing` on. With the default smoothing, one tower radius,
this is what AeroDyn does for TwrPotent = 1, where the radius of the tower is multiplied by the
cosine. (AeroDyn takes W on the tower axis, at the height of the point or at the top; W here is
that of the point itself. Under vertical shear alone the two differ only above the top.)
`TowerShadow.below_hub` puts the centre of the transition at hub height, for the
idealised shadow below the hub of the paper.

Axes: origin on the tower axis at ground level, x downwind, y left looking downwind, z up [m].

References: L. M. Milne-Thomson, Theoretical Hydrodynamics, chapter 6 (circle theorem);
B. Biegel et al., Wind Turbine Pitch Optimization, 2011, section III.A, printed there with a
garbled square; AeroDyn (OpenFAST), tower influence on the blade nodes.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import cast

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

__all__ = ["TowerShadow"]


@dataclass(frozen=True, kw_only=True, eq=False)
class TowerShadow(ValueSemantics):
    """Potential flow past a cylindrical or tapering tower.

    Inside the tower the denominator is held at its surface value, (x'^2 + y'^2) -> a^2: the
    disturbance is continuous at the surface, falls to zero on the axis and is never infinite.

    Parameters
    ----------
    radius : float or (K,) array
        Tower radius [m], positive; with `height` a table over height.
    height : None or (K,) array
        Heights above ground of the radii [m], strictly increasing. Between them the radius is
        linear, outside of them constant.
    top : float
        Height up to which the shadow has its full strength [m]: the tower top.
    lateral : bool
        False leaves out dv', as the paper does; the wind then keeps its direction.
    smoothing : float or None
        Height [m] over which the shadow falls to zero above `top`. None: the radius at the
        top. Zero: a sharp cut, with the full shadow at `top` itself.
    strength : float
        Factor t_s on the disturbance [-], >= 0. 1 is the potential flow, 0 switches it off.

    Raises
    ------
    WindFieldError
        If a value is out of range, not finite, or the table is inconsistent.
    """

    radius: ArrayLike
    height: ArrayLike | None = None
    top: float
    lateral: bool = True
    smoothing: float | None = None
    strength: float = 1.0

    def __post_init__(self) -> None:
        if self.height is None:
            radius: float | FloatArray = as_number("radius", self.radius, "m", above=0.0)
        else:
            radius = read_only("radius", self.radius)
            height = read_only("height", self.height)
            if radius.shape != height.shape or height.size < 2:
                raise WindFieldError(
                    f"radius, height: got shapes {radius.shape} and {height.shape}; must be "
                    "equal, with at least 2 entries"
                )
            if radius.min() <= 0.0:
                raise WindFieldError(f"radius: got {radius.min():g}; must be > 0 [m]")
            if height[0] < 0.0:
                raise WindFieldError(f"height: got {height[0]:g}; must be >= 0 [m]")
            increasing("height", height)
            object.__setattr__(self, "height", height)
        object.__setattr__(self, "radius", radius)
        object.__setattr__(self, "top", as_number("top", self.top, "m", above=0.0))
        if self.smoothing is None:
            smoothing = float(self.radius_at(self.top))
        else:
            smoothing = as_number("smoothing", self.smoothing, "m", at_least=0.0)
        object.__setattr__(self, "smoothing", smoothing)
        strength = as_number("strength", self.strength, at_least=0.0)
        object.__setattr__(self, "strength", strength)
        object.__setattr__(self, "lateral", bool(self.lateral))

    @classmethod
    def below_hub(
        cls,
        *,
        radius: float,
        hub_height: float,
        smoothing: float | None = None,
        lateral: bool = True,
        strength: float = 1.0,
    ) -> TowerShadow:
        """Shadow of a uniform tower that is cut at hub height.

        The transition is centred at the hub: full strength below `hub_height - smoothing / 2`,
        half at the hub, nothing above `hub_height + smoothing / 2`.

        Parameters
        ----------
        radius, hub_height : float
            [m], positive.
        smoothing : float or None
            Height of the transition [m], below twice the hub height; None: twice the radius.
        lateral, strength
            As in the class.
        """
        radius = as_number("radius", radius, "m", above=0.0)
        hub = as_number("hub_height", hub_height, "m", above=0.0)
        width = 2.0 * radius if smoothing is None else smoothing
        width = as_number("smoothing", width, "m", at_least=0.0)
        if width >= 2.0 * hub:
            raise WindFieldError(
                f"smoothing: got {width:g} m; must be below twice hub_height = {hub:g} m"
            )
        return cls(
            radius=radius,
            top=hub - 0.5 * width,
            smoothing=width,
            lateral=lateral,
            strength=strength,
        )

    def radius_at(self, z: ArrayLike) -> FloatArray:
        """Tower radius [m] at heights `z` [m], of the shape of `z`; not cut at the top."""
        heights = np.asarray(z, dtype=np.float64)
        if self.height is None:
            return np.full(heights.shape, cast(float, self.radius))
        table = cast(FloatArray, self.height), cast(FloatArray, self.radius)
        return np.asarray(np.interp(heights, *table))

    def weight(self, z: ArrayLike) -> FloatArray:
        """Share of the disturbance left at heights `z` [m]: 1 up to `top`, 0 well above [-]."""
        heights = np.asarray(z, dtype=np.float64)
        smoothing = cast(float, self.smoothing)
        if smoothing == 0.0:
            return np.where(heights <= self.top, 1.0, 0.0)
        above = np.clip((heights - self.top) / smoothing, 0.0, 1.0)
        return np.asarray(0.5 * (1.0 + np.cos(np.pi * above)))

    def disturbance(
        self, x: ArrayLike, y: ArrayLike, z: ArrayLike, u: ArrayLike, v: ArrayLike = 0.0
    ) -> tuple[FloatArray, FloatArray]:
        """Change of the horizontal wind at points around the tower.

        Parameters
        ----------
        x, y, z : array_like
            Points in the global frame [m].
        u, v : array_like
            Undisturbed wind there, along x and y [m/s]. All five broadcast together.

        Returns
        -------
        du, dv : ndarray
            To be added to `u` and `v` [m/s].
        """
        x, y = as_array("x", x), as_array("y", y)
        z, u, v = as_array("z", z), as_array("u", u), as_array("v", v)
        radius2 = self.radius_at(z) ** 2
        share = (self.strength * radius2) * self.weight(z) / np.maximum(x * x + y * y, radius2) ** 2
        even, odd = x * x - y * y, 2.0 * x * y
        if self.lateral:
            du = -share * (u * even + v * odd)
            dv = share * (v * even - u * odd)
            return np.asarray(du), np.asarray(dv)
        square = u * u + v * v
        along = (u * u - v * v) * even + 2.0 * u * v * odd
        # calm air has no direction and nothing to disturb
        change = -share * along / np.where(square > 0.0, square, 1.0)
        return np.asarray(change * u), np.asarray(change * v)

    def apply(self, velocity: ArrayLike, x: ArrayLike, y: ArrayLike, z: ArrayLike) -> FloatArray:
        """Undisturbed velocity (..., 3) [m/s] at points (...) [m] -> velocity with the tower."""
        wind = as_array("velocity", velocity)
        if wind.ndim < 1 or wind.shape[-1] != 3:
            raise WindFieldError(f"velocity: got shape {wind.shape}; must be (..., 3)")
        du, dv = self.disturbance(x, y, z, wind[..., 0], wind[..., 1])
        out = np.empty((*du.shape, 3))
        out[...] = wind
        out[..., 0] += du
        out[..., 1] += dv
        return out
