"""Wind that changes in time: turbulence carried by a mean wind, and a hub speed from a table.

    TurbulentField   v = (V (g(z) + k y) + u, v, w)   turned by the mean direction, tower on top
    TransientField   v = V(t) / V  times the velocity of a steady field, tower included

The tower disturbs the whole horizontal wind at the point, mean and fluctuation together: its
potential flow (`windfield.tower`) is linear in the wind. The box of fluctuations stands along
the mean direction gamma, and so do its components; its x axis passes through the tower axis.

Axes: as in `windfield.field`.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike

from windfield._checks import (
    FloatArray,
    ValueSemantics,
    as_array,
    increasing,
    read_only,
)
from windfield.boxes import PolarBox, TurbulenceBox
from windfield.errors import WindFieldError
from windfield.field import StaticField, broadcast_shape, resolve_points

__all__ = ["TransientField", "TurbulentField"]

SPEED_TOLERANCE = 0.01  # speeds stored in single precision, or taken at another height


@dataclass(frozen=True, kw_only=True, eq=False)
class TurbulentField(ValueSemantics):
    """Turbulence on top of a sheared mean wind, with the tower's shadow on both.

    Parameters
    ----------
    mean : StaticField
        Mean wind: speed, shear, direction, tower.
    box : TurbulenceBox or PolarBox
        Fluctuations. Its `mean_speed` must be the speed of the mean wind, within 1 %.

    Raises
    ------
    WindFieldError
        If the two do not belong together.
    """

    mean: StaticField
    box: TurbulenceBox | PolarBox

    def __post_init__(self) -> None:
        _check_static("mean", self.mean)
        if not isinstance(self.box, TurbulenceBox | PolarBox):
            raise WindFieldError(
                f"box: got {type(self.box).__name__}; must be a TurbulenceBox or a PolarBox"
            )
        carried = self.box.mean_speed
        if abs(self.mean.speed - carried) > SPEED_TOLERANCE * carried:
            raise WindFieldError(
                f"box: got one that {carried:g} m/s carries ({self.box.label}) in a mean wind of "
                f"{self.mean.speed:g} m/s; must agree"
            )

    @property
    def hub_height(self) -> float:
        """Hub height of the mean wind [m]."""
        return self.mean.hub_height

    def velocity(self, x: ArrayLike, y: ArrayLike, z: ArrayLike, t: ArrayLike = 0.0) -> FloatArray:
        """Wind velocity (..., 3) [m/s]. See `WindField.velocity`.

        Raises
        ------
        WindFieldError
            For bad coordinates, and for points and times outside of the box.
        """
        points = resolve_points(x, y, z, t, self.hub_height)
        c, s = math.cos(self.mean.direction), math.sin(self.mean.direction)
        along, across = c * points.x + s * points.y, c * points.y - s * points.x
        wind = self.box.fluctuation(along, across, points.z, t)
        wind[..., 0] += self.mean.undisturbed_speed(points.y, points.z)
        if s:
            u, v = wind[..., 0].copy(), wind[..., 1].copy()
            wind[..., 0], wind[..., 1] = c * u - s * v, s * u + c * v
        if self.mean.tower is None:
            return wind
        return self.mean.tower.apply(wind, points.x, points.y, points.z)


@dataclass(frozen=True, kw_only=True, eq=False)
class TransientField(ValueSemantics):
    """Steady field whose hub speed follows a table: steps, ramps and gusts.

    The whole field changes at once, shear, direction and shadow of the tower keep their shape.

    Parameters
    ----------
    mean : StaticField
        Shape of the wind; kept with a speed of 1 m/s, whatever its own.
    time : (K,) array
        Strictly increasing, at least one [s].
    speed : (K,) array
        Speed at the hub [m/s], >= 0; linear in between, held before and after.

    Raises
    ------
    WindFieldError
        If a value is out of range or not finite, or shapes disagree.
    """

    mean: StaticField
    time: FloatArray
    speed: FloatArray

    def __post_init__(self) -> None:
        _check_static("mean", self.mean)
        time, speed = read_only("time", self.time), read_only("speed", self.speed)
        if time.shape != speed.shape or not time.size:
            raise WindFieldError(
                f"time, speed: got shapes {time.shape} and {speed.shape}; must be equal, with at "
                "least 1 entry"
            )
        increasing("time", time)
        if speed.min() < 0.0:
            raise WindFieldError(f"speed: got {speed.min():g}; must be >= 0 [m/s]")
        object.__setattr__(self, "time", time)
        object.__setattr__(self, "speed", speed)
        object.__setattr__(self, "mean", replace(self.mean, speed=1.0))

    @property
    def hub_height(self) -> float:
        """Hub height of the steady field [m]."""
        return self.mean.hub_height

    def hub_speed(self, t: ArrayLike) -> FloatArray:
        """Speed at the hub without tower at times `t` [s], of the shape of `t` [m/s]."""
        return np.asarray(np.interp(as_array("t", t), self.time, self.speed))

    def velocity(self, x: ArrayLike, y: ArrayLike, z: ArrayLike, t: ArrayLike = 0.0) -> FloatArray:
        """Wind velocity (..., 3) [m/s]. See `WindField.velocity`.

        Raises
        ------
        WindFieldError
            For coordinates that are not finite, do not broadcast or lie below ground.
        """
        arrays = as_array("x", x), as_array("y", y), as_array("z", z), as_array("t", t)
        broadcast_shape(*arrays)
        return self.mean.velocity(*arrays) * self.hub_speed(t)[..., None]


def _check_static(name: str, value: object) -> None:
    if not isinstance(value, StaticField):
        raise WindFieldError(f"{name}: got {type(value).__name__}; must be a StaticField")
