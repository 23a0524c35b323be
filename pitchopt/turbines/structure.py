"""Masses and stiffnesses of a turbine's parts: blade, tower, hub, nacelle, drivetrain.

SI units and radians.  A steel tower of diameter D and wall t has, per length and in bending,

    mu = rho pi/4 (D^2 - (D - 2t)^2) k,       EI = E pi/64 (D^4 - (D - 2t)^4)

with k the outfitting factor.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from pitchopt.checks import FloatArray, finite_array, finite_number
from pitchopt.errors import InputError

__all__ = ["BladeSections", "BladeStructure", "Drivetrain", "Hub", "Nacelle", "Tower"]


def _put(owner: object, key: str, value: object) -> None:
    object.__setattr__(owner, key, value)


def _rising(name: str, value: FloatArray, *, at_least: float | None = None) -> FloatArray:
    array = finite_array(name, value)
    if array.size < 2 or np.any(np.diff(array) <= 0.0):
        raise InputError(f"{name}: expected at least 2 strictly increasing values")
    if at_least is not None and array[0] < at_least:
        raise InputError(f"{name}: got {array[0]:g}, expected at least {at_least:g}")
    return array


def _vectors(
    owner: object, label: str, size: int, keys: tuple[str, ...], *, positive: bool
) -> None:
    """Check and freeze the optional vectors `keys` of `owner`, all (size,)."""
    for key in keys:
        value = getattr(owner, key)
        if value is None:
            continue
        array = finite_array(f"{label}.{key}", value, shape=(size,))
        if positive and np.any(array <= 0.0):
            raise InputError(f"{label}.{key}: got {array.min():g}, every value must be positive")
        _put(owner, key, array)


@dataclass(frozen=True, kw_only=True, eq=False)
class BladeSections:
    """Shape of the blade beside what the aerodynamics need, at the stations of the rotor's blade.

    Parameters
    ----------
    span : array (E,)
        Distance from the blade root [m].
    relative_thickness : array (E,)
        Section thickness over chord [-].
    pitch_axis : array (E,), optional
        Distance of the pitch axis from the leading edge over chord [-].
    """

    span: FloatArray
    relative_thickness: FloatArray
    pitch_axis: FloatArray | None = None

    def __post_init__(self) -> None:
        span = _rising("blade.span", self.span, at_least=0.0)
        _put(self, "span", span)
        _vectors(self, "blade", span.size, ("relative_thickness",), positive=True)
        _vectors(self, "blade", span.size, ("pitch_axis",), positive=False)


@dataclass(frozen=True, kw_only=True, eq=False)
class BladeStructure:
    """Beam properties along one blade.

    Parameters
    ----------
    span : array (S,)
        Distance from the root along the blade axis [m], from 0.
    mass_per_length : array (S,)
        [kg/m].
    flap_stiffness, edge_stiffness : array (S,)
        Bending stiffness of the section about its chordwise and its normal axis [N m^2].
    structural_twist : array (S,)
        Twist of those axes [rad], sign as the aerodynamic twist.
    coupling_stiffness : array (S,), optional
        Off-diagonal bending stiffness in those axes [N m^2]; zero if they are principal.
    torsion_stiffness : array (S,), optional
        [N m^2].
    mass_centre_x, mass_centre_y : array (S,), optional
        Centre of mass from the blade axis, towards suction side and trailing edge [m].
    damping_ratio : float, optional
        Modal damping, fraction of critical.

    Raises
    ------
    InputError
        If shapes differ, values are not finite, or mass or stiffness is not positive.
    """

    span: FloatArray
    mass_per_length: FloatArray
    flap_stiffness: FloatArray
    edge_stiffness: FloatArray
    structural_twist: FloatArray
    coupling_stiffness: FloatArray | None = None
    torsion_stiffness: FloatArray | None = None
    mass_centre_x: FloatArray | None = None
    mass_centre_y: FloatArray | None = None
    damping_ratio: float | None = None

    def __post_init__(self) -> None:
        span = _rising("blade_structure.span", self.span, at_least=0.0)
        _put(self, "span", span)
        positive = ("mass_per_length", "flap_stiffness", "edge_stiffness", "torsion_stiffness")
        others = ("structural_twist", "coupling_stiffness", "mass_centre_x", "mass_centre_y")
        _vectors(self, "blade_structure", span.size, positive, positive=True)
        _vectors(self, "blade_structure", span.size, others, positive=False)
        if self.damping_ratio is not None:
            _put(
                self,
                "damping_ratio",
                finite_number(
                    "blade_structure.damping_ratio", self.damping_ratio, at_least=0.0, at_most=1.0
                ),
            )

    @property
    def mass(self) -> float:
        """Mass of one blade [kg], mass per length linear between stations."""
        return float(np.trapezoid(self.mass_per_length, self.span))

    def moment(self, order: int, *, offset: float = 0.0) -> float:
        """Integral of mass times (span + offset) to the power `order` [kg m^order]."""
        arm = (self.span + offset) ** order
        return float(np.trapezoid(self.mass_per_length * arm, self.span))


@dataclass(frozen=True, kw_only=True, eq=False)
class Tower:
    """Tower, stations from its base to its top.

    Parameters
    ----------
    height : array (N,)
        Height above ground (or mean sea level) [m].
    diameter : array (N,)
        Outer diameter [m].
    thickness : array (N,), optional
        Wall thickness [m].
    density, youngs_modulus, poisson_ratio : float, optional
        Of the wall [kg/m^3, Pa, -].
    outfitting_factor : float
        Mass with equipment over mass of the wall.
    mass_per_length, bending_stiffness : array (N,), optional
        [kg/m, N m^2]; computed from wall and material where absent.
    drag_coefficient : array (N,), optional
    damping_ratio : float, optional
        Of the first bending modes, fraction of critical.

    Raises
    ------
    InputError
        If shapes differ, heights do not increase, or a diameter, wall or material constant is
        not positive.
    """

    height: FloatArray
    diameter: FloatArray
    thickness: FloatArray | None = None
    density: float | None = None
    youngs_modulus: float | None = None
    poisson_ratio: float | None = None
    outfitting_factor: float = 1.0
    mass_per_length: FloatArray | None = None
    bending_stiffness: FloatArray | None = None
    drag_coefficient: FloatArray | None = None
    damping_ratio: float | None = None

    def __post_init__(self) -> None:
        height = _rising("tower.height", self.height)
        _put(self, "height", height)
        positive = ("diameter", "thickness", "mass_per_length", "bending_stiffness")
        _vectors(self, "tower", height.size, positive, positive=True)
        _vectors(self, "tower", height.size, ("drag_coefficient",), positive=False)
        for key, low, high in (
            ("density", 0.0, None),
            ("youngs_modulus", 0.0, None),
            ("outfitting_factor", 0.0, None),
            ("poisson_ratio", -1.0, 0.5),
            ("damping_ratio", 0.0, 1.0),
        ):
            value = getattr(self, key)
            if value is not None:
                check = {"at_least": low} if key == "damping_ratio" else {"above": low}
                _put(self, key, finite_number(f"tower.{key}", value, at_most=high, **check))
        if self.thickness is None:
            return
        inner = self.diameter - 2.0 * self.thickness
        if np.any(inner < 0.0):
            raise InputError("tower.thickness: more than half the diameter")
        if self.mass_per_length is None and self.density is not None:
            area = np.pi / 4.0 * (self.diameter**2 - inner**2)
            mass = area * (self.density * self.outfitting_factor)
            _put(self, "mass_per_length", finite_array("tower.mass_per_length", mass))
        if self.bending_stiffness is None and self.youngs_modulus is not None:
            stiffness = self.youngs_modulus * np.pi / 64.0 * (self.diameter**4 - inner**4)
            _put(self, "bending_stiffness", finite_array("tower.bending_stiffness", stiffness))

    @property
    def radius(self) -> FloatArray:
        """Outer radius (N,) [m]."""
        return self.diameter / 2.0

    @property
    def base(self) -> float:
        """Height of the tower base [m]."""
        return float(self.height[0])

    @property
    def top(self) -> float:
        """Height of the tower top [m]."""
        return float(self.height[-1])

    @property
    def mass(self) -> float | None:
        """Mass [kg], None where it is not known."""
        if self.mass_per_length is None:
            return None
        return float(np.trapezoid(self.mass_per_length, self.height))


@dataclass(frozen=True, kw_only=True, eq=False)
class Hub:
    """Hub without blades: mass [kg] and inertia about the shaft [kg m^2]."""

    mass: float
    inertia: float

    def __post_init__(self) -> None:
        _put(self, "mass", finite_number("hub.mass", self.mass, at_least=0.0))
        _put(self, "inertia", finite_number("hub.inertia", self.inertia, at_least=0.0))


@dataclass(frozen=True, kw_only=True, eq=False)
class Nacelle:
    """Nacelle without hub and blades.

    Parameters
    ----------
    mass : float
        [kg], without the yaw bearing.
    yaw_inertia : float, optional
        About the tower axis [kg m^2].
    centre : array (3,), optional
        Centre of mass from the tower top: downwind, left, up [m].
    yaw_bearing_mass : float
        At the tower top [kg].
    """

    mass: float
    yaw_inertia: float | None = None
    centre: FloatArray | None = None
    yaw_bearing_mass: float = 0.0

    def __post_init__(self) -> None:
        for key in ("mass", "yaw_inertia", "yaw_bearing_mass"):
            value = getattr(self, key)
            if value is not None:
                _put(self, key, finite_number(f"nacelle.{key}", value, at_least=0.0))
        if self.centre is not None:
            _put(self, "centre", finite_array("nacelle.centre", self.centre, shape=(3,)))


@dataclass(frozen=True, kw_only=True, eq=False)
class Drivetrain:
    """Gearbox and generator.

    Parameters
    ----------
    gear_ratio : float
        Generator speed over rotor speed, 1 for direct drive.
    efficiency : float, optional
        Electrical over mechanical power at rated, gearbox included.
    generator_inertia : float, optional
        About the high-speed shaft [kg m^2].
    torsion_stiffness, torsion_damping : float, optional
        Of the shaft, low-speed side [N m/rad, N m s/rad].
    """

    gear_ratio: float = 1.0
    efficiency: float | None = None
    generator_inertia: float | None = None
    torsion_stiffness: float | None = None
    torsion_damping: float | None = None

    def __post_init__(self) -> None:
        _put(self, "gear_ratio", finite_number("drivetrain.gear_ratio", self.gear_ratio, above=0.0))
        for key in ("efficiency", "generator_inertia", "torsion_stiffness", "torsion_damping"):
            value = getattr(self, key)
            if value is not None:
                high = 1.0 if key == "efficiency" else None
                value = finite_number(f"drivetrain.{key}", value, at_least=0.0, at_most=high)
                if key == "efficiency" and value == 0.0:
                    raise InputError("drivetrain.efficiency: got 0, expected above 0 and at most 1")
                _put(self, key, value)
