"""Frozen turbulence on a grid, carried through the rotor by the mean wind.

A box holds the fluctuations (u, v, w) of the wind on slices that stand upright, a distance dx
apart along the mean wind. Taylor's hypothesis lets the mean wind U carry it unchanged:

    (u, v, w)(x, y, z, t) = box at the fractional slice  i = (U t - x) / dx + offset,

so that slice i = `offset` stands at the tower axis at t = 0 and i grows with time. Between
slices and within a slice the velocity is linear. `TurbulenceBox` has a Cartesian grid in y and
z, `PolarBox` rings and spokes about the axis of a rotor.

Axes: x along the mean wind, y left looking downwind, z height above ground [m]; azimuth 0 up,
growing clockwise seen from upwind: y = -r sin a, z = centre height + r cos a.

References: G. I. Taylor, The spectrum of turbulence, Proc. R. Soc. A 164, 1938; IEC
61400-1:2019, annex C.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, cast

import numpy as np
from numpy.typing import ArrayLike, NDArray

from windfield._checks import (
    FloatArray,
    ValueSemantics,
    as_array,
    as_number,
    increasing,
    read_only,
)
from windfield._interpolation import Between, inside, trilinear, wrapped
from windfield.errors import WindFieldError
from windfield.field import broadcast_shape

__all__ = ["Box", "PolarBox", "TurbulenceBox"]

EDGE_TOLERANCE = 1e-9  # of the extent of an axis: rounding at the rim
UNEVEN = 1e-4  # of a step: rounding of coordinates in single precision
TURN = 2.0 * math.pi


@dataclass(frozen=True, kw_only=True, eq=False)
class Box(ValueSemantics):
    """What both kinds of box share: slices along the mean wind, and how it carries them.

    Parameters
    ----------
    velocity : (Nx, n1, n2, 3) array
        Fluctuations u, v, w [m/s], kept as float32, C-contiguous.
    spacing : float
        Distance dx of the slices along the mean wind [m], positive.
    mean_speed : float
        U [m/s] that carries the box, positive.
    periodic : bool
        Whether slice Nx is slice 0 again.
    offset : float
        Slice that stands at x = 0 at t = 0 [-].
    label : str
        Where the box is from: kind, class, seed, file.
    """

    velocity: NDArray[np.float32]
    spacing: float
    mean_speed: float
    periodic: bool = False
    offset: float = 0.0
    label: str = ""

    def __post_init__(self) -> None:
        object.__setattr__(self, "velocity", _velocity(self.velocity))
        spacing = as_number("spacing", self.spacing, "m", above=0.0)
        speed = as_number("mean_speed", self.mean_speed, "m/s", above=0.0)
        object.__setattr__(self, "spacing", spacing)
        object.__setattr__(self, "mean_speed", speed)
        object.__setattr__(self, "offset", as_number("offset", self.offset))
        object.__setattr__(self, "periodic", bool(self.periodic))
        object.__setattr__(self, "label", str(self.label))

    @property
    def interval(self) -> float:
        """Time between two slices at a fixed point [s]."""
        return self.spacing / self.mean_speed

    @property
    def duration(self) -> float:
        """Time after which a periodic box repeats, or another one is used up at x = 0 [s]."""
        slices = len(self.velocity)
        if self.periodic:
            return slices * self.interval
        return (slices - 1 - self.offset) * self.interval

    def require_time(
        self,
        duration: float,
        *,
        x_low: float = 0.0,
        x_high: float = 0.0,
        repeat: bool = False,
    ) -> None:
        """Raise unless the box lasts for a run.

        Parameters
        ----------
        duration : float
            Length of the run, which starts at t = 0 [s].
        x_low, x_high : float
            How far upwind (negative) and downwind the wind is asked for [m].
        repeat : bool
            Let a periodic box that is shorter than the run start again.

        Raises
        ------
        WindFieldError
            If it is used up, or repeats, before the end.
        """
        duration = as_number("duration", duration, "s", at_least=0.0)
        if self.periodic:
            if not repeat and self.duration < duration * (1.0 - EDGE_TOLERANCE):
                raise WindFieldError(
                    f"duration: got a run of {duration:g} s in a box ({self.label}) that repeats "
                    f"after {self.duration:g} s; must not be longer, or say repeat=True"
                )
            return
        last = self.velocity.shape[0] - 1
        first = self.offset - x_high / self.spacing
        end = self.offset + (self.mean_speed * duration - x_low) / self.spacing
        edge = EDGE_TOLERANCE * last
        if first < -edge:
            raise WindFieldError(
                f"offset: got {self.offset:g} in a box that is not periodic ({self.label}); must "
                f"be at least {x_high / self.spacing:g} for wind at x = {x_high:g} m from t = 0"
            )
        if end > last + edge:
            lasts = (last - self.offset) * self.interval + x_low / self.mean_speed
            raise WindFieldError(
                f"duration: got a run of {duration:g} s in a box ({self.label}) that lasts "
                f"{lasts:g} s at x = {x_low:g} m; must not be longer"
            )

    def fluctuation(
        self, x: ArrayLike, y: ArrayLike, z: ArrayLike, t: ArrayLike = 0.0
    ) -> FloatArray:
        """Velocity relative to the mean wind.

        Parameters
        ----------
        x, y, z : array_like
            Points [m], x along the mean wind, z above ground.
        t : array_like
            Time [s]. All four broadcast together.

        Returns
        -------
        ndarray, shape (..., 3)
            u, v, w [m/s].

        Raises
        ------
        WindFieldError
            For points outside of the box, and times outside of one that is not periodic.
        """
        x, y, z, t = as_array("x", x), as_array("y", y), as_array("z", z), as_array("t", t)
        shape = broadcast_shape(x, y, z, t)
        along = self._slices(x, t)
        return trilinear(self.velocity, along, *self._within(y, z), shape)

    def _slices(self, x: FloatArray, t: FloatArray) -> Between:
        count = self.velocity.shape[0]
        index = (self.mean_speed * t - x) / self.spacing + self.offset
        if self.periodic:
            return wrapped(index, count)
        edge = EDGE_TOLERANCE * count
        outside = (index < -edge) | (index > count - 1 + edge)
        if outside.any():
            k = np.unravel_index(int(np.argmax(outside)), outside.shape)
            at, time = np.broadcast_to(x, outside.shape)[k], np.broadcast_to(t, outside.shape)[k]
            begin, end = -self.offset * self.interval, self.duration
            raise WindFieldError(
                f"t: got t = {time:g} s at x = {at:g} m; the box ({self.label}) spans t = "
                f"{begin:g} to {end:g} s at x = 0 and is not periodic"
            )
        return inside(index, count)

    def _within(self, y: FloatArray, z: FloatArray) -> tuple[Between, Between]:
        raise NotImplementedError  # pragma: no cover


@dataclass(frozen=True, kw_only=True, eq=False)
class TurbulenceBox(Box):
    """Turbulence on a Cartesian grid; fields of `Box`, and the grid.

    Parameters
    ----------
    velocity : (Nx, Ny, Nz, 3) array
        Fluctuations u, v, w [m/s].
    y, z : (Ny,), (Nz,) arrays
        Evenly spaced, ascending, at least two each [m]; z above ground.

    Raises
    ------
    WindFieldError
        If a value is out of range or not finite, or shapes disagree.
    """

    y: FloatArray
    z: FloatArray

    def __post_init__(self) -> None:
        super().__post_init__()
        for name in ("y", "z"):
            object.__setattr__(self, name, _uniform(name, getattr(self, name)))
        if self.z[0] < 0.0:
            raise WindFieldError(f"z: got {self.z[0]:g} m; must be >= 0, above ground")
        _match(self.velocity, (self.y.size, self.z.size), "(Nx, Ny, Nz, 3)")

    def require(
        self,
        height_low: float,
        height_high: float,
        half_width: float,
        duration: float,
        *,
        x_low: float = 0.0,
        x_high: float = 0.0,
        repeat: bool = False,
    ) -> None:
        """Raise unless the box holds a rotor for a whole run.

        Parameters
        ----------
        height_low, height_high : float
            Lowest and highest point that is asked for [m].
        half_width : float
            Largest distance from the middle, to either side [m].
        duration, x_low, x_high, repeat
            As in `require_time`.

        Raises
        ------
        WindFieldError
            If the box is smaller than the rotor or shorter than the run.
        """
        edge_y, edge_z = (EDGE_TOLERANCE * np.ptp(a) for a in (self.y, self.z))
        room = min(-self.y[0], self.y[-1])
        if height_low < self.z[0] - edge_z or height_high > self.z[-1] + edge_z:
            raise WindFieldError(
                f"z: got heights from {height_low:g} to {height_high:g} m; the box "
                f"({self.label}) is smaller than the rotor, it spans {self.z[0]:g} to "
                f"{self.z[-1]:g} m"
            )
        if half_width > room + edge_y:
            raise WindFieldError(
                f"y: got {half_width:g} m to either side; the box ({self.label}) is smaller than "
                f"the rotor, it spans y = {self.y[0]:g} to {self.y[-1]:g} m"
            )
        self.require_time(duration, x_low=x_low, x_high=x_high, repeat=repeat)

    def _within(self, y: FloatArray, z: FloatArray) -> tuple[Between, Between]:
        return self._axis("y", y), self._axis("z", z)

    def _axis(self, name: str, values: FloatArray) -> Between:
        axis = cast(FloatArray, getattr(self, name))
        _check_range(name, axis, values, self.label)
        step = (axis[-1] - axis[0]) / (axis.size - 1)
        return inside(np.asarray((values - axis[0]) / step), axis.size)


@dataclass(frozen=True, kw_only=True, eq=False)
class PolarBox(Box):
    """Turbulence on rings and spokes about a rotor axis; fields of `Box`, and the grid.

    Parameters
    ----------
    velocity : (Nx, Nr, Na, 3) array
        Fluctuations u, v, w [m/s], along x, y, z as in a Cartesian box. Spoke k stands at
        azimuth 2 pi k / Na. At radius 0 all spokes agree.
    radius : (Nr,) array
        Evenly spaced from 0 on [m].
    centre_height : float
        [m] above ground, positive.

    Raises
    ------
    WindFieldError
        If a value is out of range or not finite, or shapes disagree.
    """

    radius: FloatArray
    centre_height: float

    def __post_init__(self) -> None:
        super().__post_init__()
        radius = _uniform("radius", self.radius)
        if radius[0] != 0.0:
            raise WindFieldError(f"radius: got {radius[0]:g} m first; must start at 0")
        object.__setattr__(self, "radius", radius)
        height = as_number("centre_height", self.centre_height, "m", above=0.0)
        object.__setattr__(self, "centre_height", height)
        _match(self.velocity, (radius.size, None), "(Nx, Nr, Na, 3)")
        if self.velocity.shape[2] < 3:
            raise WindFieldError(
                f"velocity: got {self.velocity.shape[2]} spokes; must be at least 3"
            )
        if (self.velocity[:, 0] != self.velocity[:, 0, :1]).any():
            raise WindFieldError("velocity: got different values at radius 0; must be one a slice")

    @property
    def azimuth(self) -> FloatArray:
        """Azimuth of the spokes (Na,) [rad]."""
        return np.asarray(np.arange(self.velocity.shape[2]) * (TURN / self.velocity.shape[2]))

    def require(
        self,
        height_low: float,
        height_high: float,
        half_width: float,
        duration: float,
        *,
        x_low: float = 0.0,
        x_high: float = 0.0,
        repeat: bool = False,
    ) -> None:
        """Raise unless the box holds a rotor for a whole run; see `TurbulenceBox.require`.

        The rotor is a disc: the corners of its frame need not lie inside the rings.
        """
        reach = max(half_width, self.centre_height - height_low, height_high - self.centre_height)
        if reach > self.radius[-1] * (1.0 + EDGE_TOLERANCE):
            raise WindFieldError(
                f"radius: got a rotor that reaches {reach:g} m from the axis (heights "
                f"{height_low:g} to {height_high:g} m, {half_width:g} m to either side); the box "
                f"({self.label}) is smaller, it spans {self.radius[-1]:g} m about height "
                f"{self.centre_height:g} m"
            )
        self.require_time(duration, x_low=x_low, x_high=x_high, repeat=repeat)

    def _within(self, y: FloatArray, z: FloatArray) -> tuple[Between, Between]:
        up = z - self.centre_height
        radius = np.asarray(np.hypot(y, up))
        _check_range("radius", self.radius, radius, self.label)
        count = self.velocity.shape[2]
        spoke = np.asarray(np.arctan2(-y, up) * (count / TURN))
        rings = self.radius.size
        ring = np.asarray(radius * ((rings - 1) / self.radius[-1]))
        return inside(ring, rings), wrapped(spoke, count)


def _velocity(value: object) -> NDArray[np.float32]:
    """Read-only float32 copy of velocities (Nx, n1, n2, 3)."""
    raw = np.asarray(cast(Any, value))
    if raw.dtype.kind not in "fiu":
        raise WindFieldError(f"velocity: got data of type {raw.dtype}; must be real numbers")
    if raw.ndim != 4 or raw.shape[-1] != 3 or min(raw.shape) < 2:
        raise WindFieldError(
            f"velocity: got shape {raw.shape}; must be (Nx, n1, n2, 3), no side shorter than 2"
        )
    with np.errstate(over="ignore"):  # too large for single precision: infinite, told below
        copy = np.array(raw, dtype=np.float32, order="C")
    if not np.isfinite(copy).all():
        bad = int(copy.size - np.count_nonzero(np.isfinite(copy)))
        raise WindFieldError(f"velocity: got {bad} NaN or infinite of {copy.size}; must be finite")
    copy.setflags(write=False)
    return copy


def _match(velocity: NDArray[np.float32], grid: tuple[int, int | None], expected: str) -> None:
    for have, want in zip(velocity.shape[1:3], grid, strict=True):
        if want is not None and have != want:
            raise WindFieldError(
                f"velocity: got shape {velocity.shape}; must be {expected} for axes of length "
                f"{' and '.join(str(n) for n in grid if n is not None)}"
            )


def _uniform(name: str, value: ArrayLike) -> FloatArray:
    """Read-only, ascending, evenly spaced coordinates."""
    axis = read_only(name, value)
    if axis.size < 2:
        raise WindFieldError(f"{name}: got {axis.size} value(s); must be at least 2")
    increasing(name, axis)
    steps = np.diff(axis)
    mean = (axis[-1] - axis[0]) / (axis.size - 1)
    if np.abs(steps - mean).max() > UNEVEN * mean:
        raise WindFieldError(
            f"{name}: got steps of {steps.min():g} to {steps.max():g} m; must be evenly spaced"
        )
    return axis


def _check_range(name: str, axis: FloatArray, values: FloatArray, label: str) -> None:
    edge = EDGE_TOLERANCE * (axis[-1] - axis[0])
    outside = (values < axis[0] - edge) | (values > axis[-1] + edge)
    if outside.any():
        worst = values[outside]
        worst = worst[np.argmax(np.abs(worst - 0.5 * (axis[0] + axis[-1])))]
        raise WindFieldError(
            f"{name}: got {worst:g} m; the box ({label}) is smaller than that, it spans "
            f"{axis[0]:g} to {axis[-1]:g} m"
        )
