"""Rotor geometry: where the blade sections are, how they move and what wind they meet.

Frames.  Hub frame: origin at the rotor apex, x along the shaft downwind, turned by nacelle yaw
about the vertical and pointing down by the tilt.  A blade at azimuth psi has, in the hub frame,

    e_r = (0, -sin psi, cos psi),     y_b = e_r x x = (0, cos psi, sin psi).

Coned frame (does not pitch): x_c = cos(cone) x + sin(cone) e_r, z_c = cos(cone) e_r - sin(cone) x,
y_c = y_b; positive cone bends the tips upwind.  Aerodynamic centres lie at (x, y, hub radius +
span) in the coned frame, where the offsets turn with pitch beta,

    x = prebend cos beta + sweep sin beta,     y = sweep cos beta - prebend sin beta.

Relative wind in a section: normal component along x_c, tangential along y_b (positive from the
leading edge side, i.e. it contains + omega radius).  Pitch rate adds -beta_dot y and + beta_dot x.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple, Protocol

import numpy as np

from pitchopt.aero.blade import Blade
from pitchopt.checks import FloatArray, finite_number, whole_number
from pitchopt.errors import InputError

__all__ = ["Inflow", "Rotor", "SectionWind", "Sections", "hub_axes"]


class Inflow(Protocol):
    """What the rotor needs of a wind field."""

    def velocity(self, x: FloatArray, y: FloatArray, z: FloatArray, t: float = 0.0) -> FloatArray:
        """Velocity (..., 3) [m/s] at global positions [m]."""
        ...


class Sections(NamedTuple):
    """Aerodynamic centres of a blade, all (..., E) but `position` (..., E, 3).

    Attributes
    ----------
    x, y : offsets in the coned frame [m].
    radius : distance from the shaft axis within the rotor plane [m].
    radial : component of the position along e_r [m].
    width, lever_x, lever_y, lever_z : integration weights about the rotor apex, coned frame.
    position : global position [m].
    """

    x: FloatArray
    y: FloatArray
    radius: FloatArray
    radial: FloatArray
    width: FloatArray
    lever_x: FloatArray
    lever_y: FloatArray
    lever_z: FloatArray
    position: FloatArray


class SectionWind(NamedTuple):
    """Wind at the sections, (..., E) [m/s].

    Attributes
    ----------
    normal, tangential : wind relative to the moving section, without induction.
    free : global wind velocity at the sections, (..., E, 3).
    """

    normal: FloatArray
    tangential: FloatArray
    free: FloatArray


def hub_axes(tilt: float, yaw: float) -> FloatArray:
    """Rows are the hub frame's x (shaft, downwind), y and z in global coordinates, (3, 3)."""
    ct, st, cy, sy = np.cos(tilt), np.sin(tilt), np.cos(yaw), np.sin(yaw)
    return np.array([[ct * cy, ct * sy, -st], [-sy, cy, 0.0], [st * cy, st * sy, ct]])


@dataclass(frozen=True, kw_only=True, eq=False)
class Rotor:
    """Rotor geometry.

    Parameters
    ----------
    blade : Blade
    blades : int
        Number of blades, evenly spaced.
    hub_radius : float
        Distance of the blade root from the rotor apex along the blade [m].
    tilt : float
        Shaft tilt [rad]; positive lifts the upwind end, so that the shaft points down downwind.
    cone : float
        Cone angle [rad]; positive bends the tips upwind.
    overhang : float
        Distance of the rotor apex from the tower axis along the shaft, upwind [m].
    hub_height : float
        Height of the rotor apex above ground [m].

    Raises
    ------
    InputError
        On a negative radius, fewer than one blade, or tilt or cone beyond 45 degrees.
    """

    blade: Blade
    blades: int = 3
    hub_radius: float = 0.0
    tilt: float = 0.0
    cone: float = 0.0
    overhang: float = 0.0
    hub_height: float

    def __post_init__(self) -> None:
        set_ = object.__setattr__
        set_(self, "blades", whole_number("rotor.blades", self.blades, at_least=1))
        set_(self, "blades", int(self.blades))
        set_(self, "hub_radius", finite_number("rotor.hub_radius", self.hub_radius, at_least=0.0))
        set_(self, "hub_height", finite_number("rotor.hub_height", self.hub_height, above=0.0))
        set_(self, "overhang", finite_number("rotor.overhang", self.overhang))
        limit = float(np.pi / 4)
        for key in ("tilt", "cone"):
            value = finite_number(
                f"rotor.{key}", getattr(self, key), at_least=-limit, at_most=limit
            )
            set_(self, key, value)
        if self.hub_radius + float(self.blade.span[0]) <= 0.0:
            raise InputError("rotor.hub_radius: the innermost station lies on the rotor axis")

    @property
    def radius(self) -> float:
        """Hub radius plus blade length [m], not shortened by cone."""
        return self.hub_radius + self.blade.length

    def apex(self, yaw: float = 0.0) -> FloatArray:
        """Global position of the rotor apex (3,) [m]."""
        forward = -self.overhang * np.cos(self.tilt)
        return np.array([forward * np.cos(yaw), forward * np.sin(yaw), self.hub_height])

    def sections(self, azimuth: FloatArray, pitch: FloatArray, yaw: float = 0.0) -> Sections:
        """Aerodynamic centres at azimuths and pitches that broadcast to a shape (...)."""
        blade = self.blade
        prebend, sweep = blade.offsets
        psi = np.asarray(azimuth, dtype=np.float64)[..., None]
        if blade.straight:
            x = y = np.zeros(blade.span.size)
        else:
            beta = np.asarray(pitch, dtype=np.float64)[..., None]
            x = prebend * np.cos(beta) + sweep * np.sin(beta)
            y = sweep * np.cos(beta) - prebend * np.sin(beta)
        width, lever_x, lever_y, lever_z = blade.integration(x, y)
        lever_z = lever_z + self.hub_radius * width
        z = self.hub_radius + blade.span
        cc, sc = np.cos(self.cone), np.sin(self.cone)
        along = cc * x - sc * z  # along the shaft
        radial = cc * z + sc * x  # along e_r
        hub = hub_axes(self.tilt, yaw)
        c, s = np.cos(psi), np.sin(psi)
        lateral = y * c - radial * s
        upward = y * s + radial * c
        position = self.apex(yaw) + (
            np.broadcast_to(along, lateral.shape)[..., None] * hub[0]
            + lateral[..., None] * hub[1]
            + upward[..., None] * hub[2]
        )
        return Sections(
            x=x,
            y=y,
            radius=np.hypot(radial, y),
            radial=radial,
            width=width,
            lever_x=lever_x,
            lever_y=lever_y,
            lever_z=lever_z,
            position=position,
        )

    def wind(
        self,
        inflow: Inflow,
        sections: Sections,
        azimuth: FloatArray,
        rotor_speed: float,
        yaw: float = 0.0,
    ) -> SectionWind:
        """Wind relative to the sections of a rotor that turns and does not change its pitch."""
        place = sections.position
        free = np.asarray(inflow.velocity(place[..., 0], place[..., 1], place[..., 2]))
        hub = hub_axes(self.tilt, yaw)
        psi = np.asarray(azimuth, dtype=np.float64)[..., None]
        c, s = np.cos(psi), np.sin(psi)
        shaft, lateral, upward = free @ hub[0], free @ hub[1], free @ hub[2]
        outward = upward * c - lateral * s
        cc, sc = np.cos(self.cone), np.sin(self.cone)
        normal = cc * shaft + sc * outward - rotor_speed * sections.y * sc
        tangential = lateral * c + upward * s + rotor_speed * sections.radial
        return SectionWind(normal=normal, tangential=tangential, free=free)
