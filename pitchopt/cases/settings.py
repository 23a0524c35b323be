"""Sections of a case, and the schema that files, command line and construction share.

Each section is a frozen dataclass in SI and radians.  `SCHEMA` gives every value its section,
its key in files (with the unit in the name where that is not SI), its kind and one line of
explanation; nothing else in the project knows a default or a bound of a case.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from pitchopt.cases.kinds import Choice, Count, Flag, Kind, Number, PathName, Weights
from pitchopt.design.problem import LoadWeights
from pitchopt.errors import InputError

__all__ = [
    "SCHEMA",
    "SECTIONS",
    "AeroSettings",
    "Entry",
    "LimitSettings",
    "ObjectiveSettings",
    "OperationSettings",
    "WindSettings",
]

DEG = float(np.pi / 180.0)
RPM = float(np.pi / 30.0)


@dataclass(frozen=True)
class Entry:
    """One value of a case.

    Attributes
    ----------
    section, attribute : str
        Where it stands in the case.
    key : str
        Its key in files, within the section.
    kind : Kind
    doc : str
        One line of explanation.
    """

    section: str
    attribute: str
    key: str
    kind: Kind
    doc: str

    @property
    def name(self) -> str:
        """Dotted key."""
        return f"{self.section}.{self.key}"


def _angle(limit: float, word: str | None = None) -> Number:
    return Number(unit="deg", factor=DEG, at_least=-limit, at_most=limit, word=word)


def _entries() -> tuple[Entry, ...]:
    number, e = Number, Entry
    rows = [
        e("wind", "speed", "speed", number(unit="m/s", above=0.0, at_most=100.0),
          "wind speed at the hub [m/s]; with a disc file it sets the rotor speed only"),
        e("wind", "shear", "shear", Choice(("power", "log", "cubic", "none")),
          "vertical shear: power, log, cubic (Taylor series of the power law) or none"),
        e("wind", "shear_exponent", "shear_exponent", number(at_least=-1.0, at_most=2.0),
          "exponent of power and cubic [-]"),
        e("wind", "roughness_length", "roughness_length", number(unit="m", above=0.0),
          "of log [m]"),
        e("wind", "horizontal_shear", "horizontal_shear", number(unit="1/m"),
          "linear shear [1/m], positive: faster on the left looking downwind"),
        e("wind", "direction", "direction_deg", _angle(60.0),
          "the wind blows along (cos, sin, 0) of this angle"),
        e("wind", "tower_shadow", "tower_shadow", Flag(),
          "potential flow round the turbine's tower"),
        e("wind", "tower_lateral", "tower_lateral", Flag(),
          "lateral part of that flow (the paper leaves it out)"),
        e("wind", "disc", "disc", PathName(),
          "CSV file of the speed over the disc; replaces speed and shear over the disc"),
        e("operation", "rotor_speed", "rotor_speed_rpm",
          number(unit="rpm", factor=RPM, above=0.0, word="auto"),
          "auto: optimal tip-speed ratio within the turbine's least and rated speed"),
        e("operation", "yaw", "yaw_deg", _angle(60.0),
          "nacelle yaw, positive counter-clockwise seen from above"),
        e("operation", "air_density", "air_density",
          number(unit="kg/m^3", above=0.0, word="auto"), "[kg/m^3]; auto: the turbine's"),
        e("aero", "induction", "induction", Choice(("none", "frozen", "equilibrium")),
          "none, frozen (at the mean pitch) or equilibrium (at every pitch)"),
        e("aero", "segments", "segments", Count(at_most=400),
          "segments d of the piecewise-linear polars"),
        e("aero", "elements", "elements", Count(at_most=1000, word="auto"),
          "blade elements n of equal length; auto: the turbine's own"),
        e("aero", "alpha_min", "alpha_min_deg",
          _angle(90.0, word="auto"),
          "least angle of attack; auto: the turbine's, or where lift stops being attached"),
        e("aero", "alpha_max", "alpha_max_deg",
          _angle(90.0, word="auto"),
          "largest angle of attack; auto: the turbine's, or stall"),
        e("aero", "pitch_rate_terms", "pitch_rate_terms", Flag(),
          "loads from the pitch rate"),
        e("aero", "radial_moment", "radial_moment", Flag(),
          "moment about the blade's own axis in tilt and yaw"),
        e("aero", "skew", "skew", Flag(), "skewed-wake correction of the induction"),
        e("limits", "positions", "positions", Count(at_most=20000),
          "rotor positions m in one blade passage"),
        e("limits", "pitch_min", "pitch_min_deg",
          _angle(180.0, word="auto"),
          "lower end of the actuator's range; auto: the turbine's"),
        e("limits", "pitch_max", "pitch_max_deg",
          _angle(180.0, word="auto"),
          "upper end of the actuator's range; auto: the turbine's"),
        e("limits", "pitch_rate", "pitch_rate_deg",
          number(unit="deg/s", factor=DEG, at_least=0.0, word="auto"),
          "largest pitch rate [deg/s], 0 for constant pitch only; auto: the turbine's"),
        e("objective", "weights", "weights", Weights(),
          "unit, tower-base (thrust times hub height) or { torque = 1.0, tilt = 1.0, ... }"),
        e("objective", "blade_cap", "blade_cap", number(above=0.0, word="none"),
          "largest RMS of a blade's bending relative to constant pitch"),
        e("objective", "harmonics", "harmonics", Count(at_least=0, at_most=10000, word="none"),
          "profile restricted to a mean and harmonics 1P to nP"),
        e("objective", "travel", "travel_penalty",
          number(unit="N m/deg", factor=1.0 / DEG, at_least=0.0),
          "price of a degree of pitch travel a revolution [N m/deg]"),
    ]  # fmt: skip
    return tuple(rows)


SCHEMA = _entries()


def _checked(section: str, owner: object) -> None:
    """Check every value of a section at construction."""
    for entry in SCHEMA:
        if entry.section == section:
            name = f"{section}.{entry.attribute}"
            value = entry.kind.check(name, getattr(owner, entry.attribute))
            object.__setattr__(owner, entry.attribute, value)


def _ordered(section: str, owner: object, low: str, high: str) -> None:
    a, b = getattr(owner, low), getattr(owner, high)
    if a is not None and b is not None and a >= b:
        raise InputError(
            f"{section}.{low}_deg, {section}.{high}_deg: got {np.rad2deg(a):g} and "
            f"{np.rad2deg(b):g}, expected the first to be the smaller"
        )


@dataclass(frozen=True, kw_only=True)
class WindSettings:
    """Wind over the disc; units and meaning in `SCHEMA`, angles in radians here."""

    speed: float = 8.0
    shear: str = "power"
    shear_exponent: float = 0.2
    roughness_length: float = 0.03
    horizontal_shear: float = 0.0
    direction: float = 0.0
    tower_shadow: bool = True
    tower_lateral: bool = True
    disc: Path | None = None

    def __post_init__(self) -> None:
        _checked("wind", self)


@dataclass(frozen=True, kw_only=True)
class OperationSettings:
    """Rotor speed [rad/s], nacelle yaw [rad] and air density [kg/m^3]; None: the turbine's."""

    rotor_speed: float | None = None
    yaw: float = 0.0
    air_density: float | None = None

    def __post_init__(self) -> None:
        _checked("operation", self)


@dataclass(frozen=True, kw_only=True)
class AeroSettings:
    """Aerodynamic model; angles of attack in radians, None: the turbine's."""

    induction: str = "equilibrium"
    segments: int = 40
    elements: int | None = None
    alpha_min: float | None = None
    alpha_max: float | None = None
    pitch_rate_terms: bool = True
    radial_moment: bool = True
    skew: bool = True

    def __post_init__(self) -> None:
        _checked("aero", self)
        _ordered("aero", self, "alpha_min", "alpha_max")


@dataclass(frozen=True, kw_only=True)
class LimitSettings:
    """Rotor positions and actuator: range [rad], rate [rad/s]; None: the turbine's."""

    positions: int = 36
    pitch_min: float | None = None
    pitch_max: float | None = None
    pitch_rate: float | None = None

    def __post_init__(self) -> None:
        _checked("limits", self)
        _ordered("limits", self, "pitch_min", "pitch_max")


@dataclass(frozen=True, kw_only=True)
class ObjectiveSettings:
    """Weights of the loads, cap on the blade load, harmonics, price of travel [N m/rad]."""

    weights: str | LoadWeights = "tower-base"
    blade_cap: float | None = 1.0
    harmonics: int | None = None
    travel: float = 0.0

    def __post_init__(self) -> None:
        _checked("objective", self)


SECTIONS: dict[str, type[Any]] = {
    "wind": WindSettings,
    "operation": OperationSettings,
    "aero": AeroSettings,
    "limits": LimitSettings,
    "objective": ObjectiveSettings,
}
