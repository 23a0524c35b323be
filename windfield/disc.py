"""Wind field from a gridded profile of the speed over the rotor disc.

    v(x, y, z) = s(y, z - H) (cos gamma, sin gamma, 0)  +  disturbance of the tower

with s the linear interpolation of the grid: bilinear in hub-centred y and z, or in radius and
azimuth (periodic). Azimuth psi = 0 up, clockwise seen from upwind: y = -r sin psi,
z - H = r cos psi. Nothing is extrapolated. Everything else is as in `windfield.field`.
"""

from __future__ import annotations

import os
from dataclasses import dataclass
from typing import Literal, cast

import numpy as np
from numpy.typing import ArrayLike

from windfield._checks import FloatArray, ValueSemantics, increasing, read_only
from windfield.discfile import POLAR, read_disc_csv
from windfield.errors import WindFieldError
from windfield.field import check_common, compose, resolve_points
from windfield.tower import TowerShadow

__all__ = ["DiscField"]

EDGE_TOLERANCE = 1e-9  # of the extent of an axis: rounding at the rim
LARGEST_GAP = np.deg2rad(120.0) * (1.0 + 1e-9)
TURN = 2.0 * np.pi


@dataclass(frozen=True, kw_only=True, eq=False)
class DiscField(ValueSemantics):
    """Wind whose speed is given on a regular grid over the disc.

    Give either `y` and `z` or `radius` and `azimuth`.

    Parameters
    ----------
    speed : (n0, n1) array
        Wind speed [m/s], >= 0, over (y, z) or over (radius, azimuth).
    hub_height : float
        [m], positive.
    y, z : (n0,), (n1,) arrays
        Hub-centred, strictly increasing, at least two each [m].
    radius, azimuth : (n0,), (n1,) arrays
        Strictly increasing [m] and [rad]; radii >= 0, azimuths inside one turn, no two further
        apart than 120 degrees. A last azimuth one turn after the first repeats it. At radius 0
        the speed is the same for all azimuths.
    direction : float
        Flow direction gamma [rad].
    tower : TowerShadow or None

    Raises
    ------
    WindFieldError
        If a value is out of range or not finite, or shapes disagree.
    """

    speed: ArrayLike
    hub_height: float
    y: ArrayLike | None = None
    z: ArrayLike | None = None
    radius: ArrayLike | None = None
    azimuth: ArrayLike | None = None
    direction: float = 0.0
    tower: TowerShadow | None = None

    def __post_init__(self) -> None:
        hub, direction = check_common(self.hub_height, self.direction, self.tower)
        object.__setattr__(self, "hub_height", hub)
        object.__setattr__(self, "direction", direction)
        given = [n for n in ("y", "z", "radius", "azimuth") if getattr(self, n) is not None]
        if given not in (["y", "z"], ["radius", "azimuth"]):
            raise WindFieldError(
                f"y, z, radius, azimuth: got {', '.join(given) or 'none'}; must be y and z or "
                "radius and azimuth"
            )
        axes = []
        for name in given:
            axis = read_only(name, getattr(self, name))
            if axis.size < 2:
                raise WindFieldError(f"{name}: got {axis.size} value(s); must be at least 2")
            increasing(name, axis)
            axes.append(axis)
        speed = read_only("speed", self.speed, ndim=2)
        if speed.shape != (axes[0].size, axes[1].size):
            raise WindFieldError(
                f"speed: got shape {speed.shape}; must be {(axes[0].size, axes[1].size)}, the "
                f"lengths of {' and '.join(given)}"
            )
        if speed.min() < 0.0:
            raise WindFieldError(f"speed: got {speed.min():g}; must be >= 0 [m/s]")
        if given[0] == "radius":
            axes[1], speed = _one_turn(axes[0], axes[1], speed)
        for name, axis in zip(given, axes, strict=True):
            object.__setattr__(self, name, axis)
        object.__setattr__(self, "speed", speed)

    @classmethod
    def from_csv(
        cls,
        path: str | os.PathLike[str],
        *,
        hub_height: float,
        direction: float = 0.0,
        tower: TowerShadow | None = None,
    ) -> DiscField:
        """Field from a CSV file; `windfield.discfile` tells the two layouts.

        Raises
        ------
        WindFieldError
            If the file is not such a file, or its grid is not a valid one.
        """
        table = read_disc_csv(path)
        try:
            if table.columns == POLAR:
                return cls(
                    speed=table.speed,
                    hub_height=hub_height,
                    radius=table.first,
                    azimuth=np.deg2rad(table.second),
                    direction=direction,
                    tower=tower,
                )
            return cls(
                speed=table.speed,
                hub_height=hub_height,
                y=table.first,
                z=table.second,
                direction=direction,
                tower=tower,
            )
        except WindFieldError as error:
            raise WindFieldError(f"{path}: {error}") from error

    @property
    def layout(self) -> Literal["cartesian", "polar"]:
        """Which pair of axes the grid has."""
        return "cartesian" if self.y is not None else "polar"

    def undisturbed_speed(self, y: ArrayLike, z: ArrayLike) -> FloatArray:
        """Wind speed [m/s] without the tower at y, z [m], z above ground."""
        points = resolve_points(0.0, y, z, 0.0, self.hub_height)
        return self._speed(points.y, points.z)

    def velocity(self, x: ArrayLike, y: ArrayLike, z: ArrayLike, t: ArrayLike = 0.0) -> FloatArray:
        """Wind velocity (..., 3) [m/s]; the same at all times. See `WindField.velocity`.

        Raises
        ------
        WindFieldError
            For bad coordinates and for points outside the grid.
        """
        points = resolve_points(x, y, z, t, self.hub_height)
        return compose(self._speed(points.y, points.z), self.direction, self.tower, points)

    def _speed(self, y: FloatArray, z: FloatArray) -> FloatArray:
        z = z - self.hub_height
        speed = cast(FloatArray, self.speed)
        if self.y is not None:
            first, second = cast(FloatArray, self.y), cast(FloatArray, self.z)
            y, z = np.broadcast_arrays(y, z)
            return _bilinear(speed, first, second, _inside("y", first, y), _inside("z", second, z))
        first, second = cast(FloatArray, self.radius), cast(FloatArray, self.azimuth)
        radius = _inside("radius", first, np.hypot(y, z))
        azimuth = np.mod(np.arctan2(-y, z) - second[0], TURN) + second[0]
        closed = np.append(second, second[0] + TURN)
        return _bilinear(np.hstack([speed, speed[:, :1]]), first, closed, radius, azimuth)


def _one_turn(
    radius: FloatArray, azimuth: FloatArray, speed: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Check a polar grid; azimuths and speeds without a repeated last azimuth."""
    if radius[0] < 0.0:
        raise WindFieldError(f"radius: got {radius[0]:g}; must be >= 0 [m]")
    span = azimuth[-1] - azimuth[0]
    if span > TURN * (1.0 + 1e-12):
        raise WindFieldError(
            f"azimuth: got a span of {np.rad2deg(span):g} degrees; must lie inside one turn"
        )
    tolerance = 1e-9 * max(1.0, float(speed.max()))
    if span >= TURN * (1.0 - 1e-12):
        if (np.abs(speed[:, -1] - speed[:, 0]) > tolerance).any():
            raise WindFieldError(
                "speed: got different values at the first azimuth and one turn later; must agree"
            )
        azimuth, speed = azimuth[:-1].copy(), speed[:, :-1].copy()
        azimuth.setflags(write=False)
        speed.setflags(write=False)
    gap = float(np.diff(np.append(azimuth, azimuth[0] + TURN)).max())
    if gap > LARGEST_GAP:
        raise WindFieldError(
            f"azimuth: got a gap of {np.rad2deg(gap):g} degrees; must cover the turn with gaps "
            "of at most 120 degrees"
        )
    if radius[0] == 0.0 and np.ptp(speed[0]) > tolerance:
        raise WindFieldError(
            f"speed: got {speed[0].min():g} to {speed[0].max():g} at radius 0; must be one value"
        )
    return azimuth, speed


def _inside(name: str, axis: FloatArray, values: FloatArray) -> FloatArray:
    """Values clipped to the axis against rounding; an error for those truly outside."""
    edge = EDGE_TOLERANCE * (axis[-1] - axis[0])
    outside = (values < axis[0] - edge) | (values > axis[-1] + edge)
    if outside.any():
        raise WindFieldError(
            f"{name}: got {np.asarray(values)[outside][0]:g} m (hub-centred); must be within the "
            f"grid, {axis[0]:g} to {axis[-1]:g} m, the profile is not extrapolated"
        )
    return np.asarray(np.clip(values, axis[0], axis[-1]))


def _bilinear(
    table: FloatArray, first: FloatArray, second: FloatArray, a: FloatArray, b: FloatArray
) -> FloatArray:
    """Linear interpolation of a table (n0, n1) at points that lie inside the axes."""
    i = np.clip(np.searchsorted(first, a, side="right") - 1, 0, first.size - 2)
    j = np.clip(np.searchsorted(second, b, side="right") - 1, 0, second.size - 2)
    p = (a - first[i]) / np.diff(first)[i]
    q = (b - second[j]) / np.diff(second)[j]
    flat = table.ravel()
    k = i * second.size + j
    low = flat[k] * (1.0 - q) + flat[k + 1] * q
    k = k + second.size
    high = flat[k] * (1.0 - q) + flat[k + 1] * q
    return np.asarray(low * (1.0 - p) + high * p)
