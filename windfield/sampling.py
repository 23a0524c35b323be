"""Samples of a wind field over the rotor disc, for plots and for CSV profiles.

The disc stands upright at x in the global frame, its centre at hub height. Points lie on rings
and spokes: azimuth psi = 0 up, clockwise seen from upwind, hub-centred

    y = -r sin psi (left looking downwind),  z = r cos psi (up).
"""

from __future__ import annotations

import os
from dataclasses import dataclass
from typing import Literal, cast

import numpy as np
from numpy.typing import ArrayLike

from windfield._checks import FloatArray, ValueSemantics, as_count, as_number, read_only
from windfield.discfile import POLAR, write_disc_csv
from windfield.errors import WindFieldError
from windfield.field import WindField

__all__ = ["Component", "DiscSample", "disc_points", "sample_disc"]

Component = Literal["speed", "downwind", "lateral", "vertical"]
COMPONENTS: tuple[Component, ...] = ("speed", "downwind", "lateral", "vertical")


@dataclass(frozen=True, kw_only=True, eq=False)
class DiscSample(ValueSemantics):
    """Wind over a disc, on rings and spokes.

    Attributes
    ----------
    radius, azimuth : (n,), (m,) arrays
        [m] and [rad].
    speed : (n, m) array
        The sampled component [m/s].
    hub_height, x : float
        Centre of the disc in the global frame [m].
    component : str
        What was sampled: `speed` (length of the velocity), `downwind`, `lateral`, `vertical`.
    """

    radius: FloatArray
    azimuth: FloatArray
    speed: FloatArray
    hub_height: float
    x: float = 0.0
    component: Component = "speed"

    def __post_init__(self) -> None:
        for name, ndim in (("radius", 1), ("azimuth", 1), ("speed", 2)):
            object.__setattr__(self, name, read_only(name, getattr(self, name), ndim=ndim))
        if self.speed.shape != (self.radius.size, self.azimuth.size):
            raise WindFieldError(
                f"speed: got shape {self.speed.shape}; must be "
                f"{(self.radius.size, self.azimuth.size)}"
            )

    @property
    def y(self) -> FloatArray:
        """Hub-centred lateral positions (n, m) [m], + left looking downwind."""
        return np.asarray(-self.radius[:, None] * np.sin(self.azimuth))

    @property
    def z(self) -> FloatArray:
        """Hub-centred vertical positions (n, m) [m], + up."""
        return np.asarray(self.radius[:, None] * np.cos(self.azimuth))

    def to_csv(self, path: str | os.PathLike[str]) -> None:
        """Write columns radius, azimuth_deg, speed, which `DiscField.from_csv` reads.

        The file is written whole or not at all.

        Raises
        ------
        WindFieldError
            If the sample is not the `speed` component, or the file cannot be written.
        """
        if self.component != "speed":
            raise WindFieldError(
                f"component: got {self.component!r}; must be 'speed' to be written as a profile"
            )
        write_disc_csv(path, POLAR, self.radius, np.rad2deg(self.azimuth), self.speed)


def disc_points(
    radius: float,
    *,
    rings: int = 24,
    azimuths: int = 72,
    inner_radius: float = 0.0,
    closed: bool = False,
) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
    """Points on rings and spokes of a disc or an annulus.

    Parameters
    ----------
    radius : float
        Outer radius [m], positive.
    rings, azimuths : int
        Number of rings between `inner_radius` and `radius`, both included (at least 2), and
        of spokes (at least 3).
    inner_radius : float
        [m], >= 0 and below `radius`.
    closed : bool
        Repeat the first spoke one turn later, as plots of filled contours need.

    Returns
    -------
    radii, azimuth : (rings,), (azimuths or azimuths + 1,) arrays
        [m], [rad].
    y, z : (rings, azimuths or azimuths + 1) arrays
        Hub-centred positions [m].
    """
    outer = as_number("radius", radius, "m", above=0.0)
    inner = as_number("inner_radius", inner_radius, "m", at_least=0.0)
    if inner >= outer:
        raise WindFieldError(f"inner_radius: got {inner:g} m; must be below radius = {outer:g} m")
    count = as_count("azimuths", azimuths, at_least=3)
    radii = np.linspace(inner, outer, as_count("rings", rings, at_least=2))
    azimuth = np.linspace(0.0, 2.0 * np.pi, count + 1)
    if not closed:
        azimuth = azimuth[:-1]
    return radii, azimuth, -radii[:, None] * np.sin(azimuth), radii[:, None] * np.cos(azimuth)


def sample_disc(
    field: WindField,
    radius: float,
    *,
    hub_height: float | None = None,
    x: float = 0.0,
    t: float = 0.0,
    rings: int = 24,
    azimuths: int = 72,
    inner_radius: float = 0.0,
    closed: bool = False,
    component: Component = "speed",
) -> DiscSample:
    """Sample a wind field on an upright disc at hub height.

    Parameters
    ----------
    field : WindField
        Anything with the `velocity` method.
    radius, rings, azimuths, inner_radius, closed
        As in `disc_points`.
    hub_height : float or None
        Height of the centre [m]; None: the field's own `hub_height`.
    x : float
        Position of the disc [m]; a rotor in front of the tower has a negative one.
    t : float
        Time [s].
    component : {"speed", "downwind", "lateral", "vertical"}
        Length of the velocity, or its part along x, y or z [m/s].

    Raises
    ------
    WindFieldError
        If an argument is out of range, the field has no hub height, or the field itself raises.
    """
    if component not in COMPONENTS:
        raise WindFieldError(f"component: got {component!r}; must be one of {COMPONENTS}")
    if hub_height is None:
        hub_height = getattr(field, "hub_height", None)
        if hub_height is None:
            raise WindFieldError(
                f"hub_height: got None and {type(field).__name__} has none; must be given [m]"
            )
    hub = as_number("hub_height", hub_height, "m", above=0.0)
    at, time = as_number("x", x, "m"), as_number("t", t, "s")
    radii, azimuth, y, z = disc_points(
        radius, rings=rings, azimuths=azimuths, inner_radius=inner_radius, closed=closed
    )
    velocity = field.velocity(at, y, hub + z, time)
    if component == "speed":
        values: ArrayLike = np.sqrt(np.sum(velocity**2, axis=-1))
    else:
        values = velocity[..., COMPONENTS.index(component) - 1]
    return DiscSample(
        radius=radii,
        azimuth=azimuth,
        speed=cast(FloatArray, values),
        hub_height=hub,
        x=at,
        component=component,
    )
