"""Static wind field over a rotor: baseline, shear, direction and tower shadow.

    v(x, y, z) = V (g(z) + k y) (cos gamma, sin gamma, 0)  +  disturbance of the tower

with V the wind speed at the hub, g the vertical shear (`windfield.shear`), k the linear
horizontal shear and gamma the flow direction. The tower (`windfield.tower`) disturbs the
sheared wind at each point.

Axes: origin on the tower axis at ground level, x downwind, y left looking downwind, z height
above ground [m]. gamma is measured from +x towards +y. k > 0: faster on the left looking
downwind. B. Biegel et al. 2011 count y to the other side: their xi_hs and gamma enter with
the opposite sign, `horizontal_shear = -xi_hs` and `direction = -gamma`.

Reference: B. Biegel et al., Wind Turbine Pitch Optimization, 2011, section III.A.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Protocol, runtime_checkable

import numpy as np
from numpy.typing import ArrayLike

from windfield._checks import FloatArray, ValueSemantics, as_array, as_number
from windfield.errors import WindFieldError
from windfield.shear import VerticalShear
from windfield.tower import TowerShadow

__all__ = [
    "Points",
    "StaticField",
    "WindField",
    "broadcast_shape",
    "compose",
    "resolve_points",
]

GROUND_TOLERANCE = 1e-9  # of the hub height: rounding of hub_height - radius


@runtime_checkable
class WindField(Protocol):
    """Anything that tells the wind velocity at points and times."""

    def velocity(self, x: ArrayLike, y: ArrayLike, z: ArrayLike, t: ArrayLike = 0.0) -> FloatArray:
        """Wind velocity.

        Parameters
        ----------
        x, y, z : array_like
            Points in the global frame [m], z above ground.
        t : array_like
            Time [s]. All four broadcast together.

        Returns
        -------
        ndarray, shape (..., 3)
            Velocity along x, y and z [m/s].
        """
        ...  # pragma: no cover


@dataclass(frozen=True, eq=False)
class Points:
    """Checked coordinates, not yet broadcast, and the shape that they broadcast to."""

    x: FloatArray
    y: FloatArray
    z: FloatArray
    shape: tuple[int, ...]


def broadcast_shape(x: FloatArray, y: FloatArray, z: FloatArray, t: FloatArray) -> tuple[int, ...]:
    """Shape that coordinates and time broadcast to, or a `WindFieldError`."""
    try:
        return np.broadcast_shapes(x.shape, y.shape, z.shape, t.shape)
    except ValueError as error:
        raise WindFieldError(
            f"x, y, z, t: got shapes {x.shape}, {y.shape}, {z.shape}, {t.shape}; must broadcast"
        ) from error


def resolve_points(
    x: ArrayLike, y: ArrayLike, z: ArrayLike, t: ArrayLike, hub_height: float
) -> Points:
    """Check coordinates [m] and time [s]: finite, of matching shapes, not below ground."""
    x, y, z, t = as_array("x", x), as_array("y", y), as_array("z", z), as_array("t", t)
    shape = broadcast_shape(x, y, z, t)
    if z.size and z.min() < 0.0:
        if z.min() < -GROUND_TOLERANCE * hub_height:
            raise WindFieldError(
                f"z: got a height of {z.min():g} m, below ground; must be >= 0 (z is the height "
                "above ground, not hub-centred)"
            )
        z = np.maximum(z, 0.0)
    return Points(x, y, z, shape)


def compose(
    speed: FloatArray, direction: float, tower: TowerShadow | None, points: Points
) -> FloatArray:
    """Velocity (..., 3) [m/s] of wind of a given speed and direction [rad] round a tower."""
    u, v = speed * math.cos(direction), speed * math.sin(direction)
    if tower is not None and tower.strength > 0.0:
        du, dv = tower.disturbance(points.x, points.y, points.z, u, v)
        u, v = u + du, v + dv
    out = np.empty((*points.shape, 3))
    out[..., 0] = u
    out[..., 1] = v
    out[..., 2] = 0.0
    return out


def check_common(
    hub_height: float, direction: float, tower: TowerShadow | None
) -> tuple[float, float]:
    """Check what all fields share; returns hub height [m] and direction [rad]."""
    if tower is not None and not isinstance(tower, TowerShadow):
        raise WindFieldError(f"tower: got {type(tower).__name__}; must be a TowerShadow or None")
    hub = as_number("hub_height", hub_height, "m", above=0.0)
    return hub, as_number("direction", direction, "rad")


@dataclass(frozen=True, kw_only=True, eq=False)
class StaticField(ValueSemantics):
    """Steady wind with vertical and horizontal shear, a direction and a tower shadow.

    Parameters
    ----------
    speed : float
        Wind speed V at the hub [m/s], >= 0.
    hub_height : float
        [m], positive.
    vertical : PowerLaw, LogLaw, CubicShear or None
        Vertical shear; None: none. Any object with their `factor` method will do.
    horizontal_shear : float
        k [1/m]; the part V k y is linear and has no lower limit.
    direction : float
        Flow direction gamma [rad]: the wind blows towards (cos gamma, sin gamma, 0).
    tower : TowerShadow or None

    Raises
    ------
    WindFieldError
        If a value is out of range or not finite.
    """

    speed: float
    hub_height: float
    vertical: VerticalShear | None = None
    horizontal_shear: float = 0.0
    direction: float = 0.0
    tower: TowerShadow | None = None

    def __post_init__(self) -> None:
        hub, direction = check_common(self.hub_height, self.direction, self.tower)
        object.__setattr__(self, "hub_height", hub)
        object.__setattr__(self, "direction", direction)
        object.__setattr__(self, "speed", as_number("speed", self.speed, "m/s", at_least=0.0))
        shear = as_number("horizontal_shear", self.horizontal_shear, "1/m")
        object.__setattr__(self, "horizontal_shear", shear)
        if self.vertical is not None:
            if isinstance(self.vertical, type) or not isinstance(self.vertical, VerticalShear):
                raise WindFieldError(
                    f"vertical: got {self.vertical!r}; must be None, PowerLaw, LogLaw, "
                    "CubicShear or an object with a method factor(height, hub_height)"
                )
            self.vertical.factor(hub, hub)  # the law must admit this hub height

    def undisturbed_speed(self, y: ArrayLike, z: ArrayLike) -> FloatArray:
        """Wind speed V (g(z) + k y) [m/s] without the tower at y, z [m], z above ground."""
        return self._speed(resolve_points(0.0, y, z, 0.0, self.hub_height))

    def velocity(self, x: ArrayLike, y: ArrayLike, z: ArrayLike, t: ArrayLike = 0.0) -> FloatArray:
        """Wind velocity (..., 3) [m/s]; the same at all times. See `WindField.velocity`.

        Raises
        ------
        WindFieldError
            For coordinates that are not finite, do not broadcast or lie below ground.
        """
        points = resolve_points(x, y, z, t, self.hub_height)
        return compose(self._speed(points), self.direction, self.tower, points)

    def _speed(self, points: Points) -> FloatArray:
        ratio = np.ones(())
        if self.vertical is not None:
            ratio = self.vertical.factor(points.z, self.hub_height)
        if self.horizontal_shear:
            ratio = ratio + self.horizontal_shear * points.y
        return np.asarray(self.speed * ratio)
