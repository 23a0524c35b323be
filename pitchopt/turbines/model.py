"""What the project knows of a turbine: rotor, operation, masses, stiffnesses, tower.

Signs and frames are the project's (NOMENCLATURE): x downwind, prebend positive downwind, sweep
positive towards the trailing edge, twist and pitch positive towards feather, tilt positive with
the upwind end of the shaft up, cone positive with the tips upwind.  SI units and radians.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from itertools import pairwise
from types import MappingProxyType
from typing import Any

import numpy as np

from pitchopt.aero.rotor import Rotor
from pitchopt.checks import finite_number
from pitchopt.errors import InputError
from pitchopt.turbines.structure import (
    BladeSections,
    BladeStructure,
    Drivetrain,
    Hub,
    Nacelle,
    Tower,
)

__all__ = ["Turbine"]


def _put(owner: object, key: str, value: object) -> None:
    object.__setattr__(owner, key, value)


@dataclass(frozen=True, kw_only=True, eq=False)
class Turbine:
    """A turbine.

    Parameters
    ----------
    name, source, description : str
        Key or name, where the data come from, one paragraph.
    rotor : Rotor
        Blades, polars and rotor geometry.
    rated_power : float
        Electrical [W].
    rated_rotor_speed, min_rotor_speed : float
        [rad/s].
    max_rotor_speed : float, optional
        Overspeed limit [rad/s].
    max_tip_speed : float, optional
        [m/s].
    rated_wind_speed, cut_in_wind_speed, cut_out_wind_speed : float, optional
        [m/s].
    optimal_tip_speed_ratio, fine_pitch : float, optional
        Set-points below rated [-, rad].
    pitch_range : tuple of float
        Lower and upper limit of the actuators [rad].
    pitch_rate : float
        Largest rate [rad/s]; zero allows constant pitch only.
    torque_rate : float, optional
        Largest rate of the generator torque, high-speed side [N m/s].
    alpha_limits : tuple
        Angles of attack within which the sections are to stay [rad]; None in place of a limit
        leaves the choice (stall) to the aerodynamics.
    air_density : float
        [kg/m^3].
    iec_class : str, optional
        Wind and turbulence class, e.g. ``IB``.
    tower : Tower
    sections : BladeSections, optional
    blade_structure : BladeStructure, optional
    hub : Hub, optional
    nacelle : Nacelle, optional
    drivetrain : Drivetrain
    notes : mapping of str to str
        Part of the data -> where it comes from, or how it was derived.

    Raises
    ------
    InputError
        If limits cross or a value is not finite or has the wrong sign.
    """

    name: str
    source: str
    description: str = ""
    rotor: Rotor
    rated_power: float
    rated_rotor_speed: float
    min_rotor_speed: float
    max_rotor_speed: float | None = None
    max_tip_speed: float | None = None
    rated_wind_speed: float | None = None
    cut_in_wind_speed: float | None = None
    cut_out_wind_speed: float | None = None
    optimal_tip_speed_ratio: float | None = None
    fine_pitch: float | None = None
    pitch_range: tuple[float, float]
    pitch_rate: float
    torque_rate: float | None = None
    alpha_limits: tuple[float | None, float | None] = (None, None)
    air_density: float = 1.225
    iec_class: str | None = None
    tower: Tower
    sections: BladeSections | None = None
    blade_structure: BladeStructure | None = None
    hub: Hub | None = None
    nacelle: Nacelle | None = None
    drivetrain: Drivetrain = field(default_factory=Drivetrain)
    notes: Mapping[str, str] = field(default_factory=dict)

    def __post_init__(self) -> None:
        if not isinstance(self.rotor, Rotor):
            raise InputError(f"turbine.rotor: got {type(self.rotor).__name__}, expected a Rotor")
        for key in ("rated_power", "rated_rotor_speed", "air_density"):
            _put(self, key, finite_number(f"turbine.{key}", getattr(self, key), above=0.0))
        for key in ("min_rotor_speed", "pitch_rate"):
            _put(self, key, finite_number(f"turbine.{key}", getattr(self, key), at_least=0.0))
        for key in (
            "max_rotor_speed",
            "max_tip_speed",
            "rated_wind_speed",
            "cut_in_wind_speed",
            "cut_out_wind_speed",
            "optimal_tip_speed_ratio",
            "torque_rate",
        ):
            value = getattr(self, key)
            if value is not None:
                _put(self, key, finite_number(f"turbine.{key}", value, above=0.0))
        if self.fine_pitch is not None:
            _put(self, "fine_pitch", finite_number("turbine.fine_pitch", self.fine_pitch))
        _put(self, "pitch_range", _pair("turbine.pitch_range", self.pitch_range))
        _put(self, "alpha_limits", _limits(self.alpha_limits))
        self._ordered("min_rotor_speed", "rated_rotor_speed", "max_rotor_speed")
        self._ordered("cut_in_wind_speed", "rated_wind_speed", "cut_out_wind_speed")
        if self.tower.top > self.rotor.hub_height:
            raise InputError(
                f"turbine.tower.height: top at {self.tower.top:g} m, "
                f"above the hub at {self.rotor.hub_height:g} m"
            )
        _put(self, "notes", MappingProxyType(dict(self.notes)))

    def __getstate__(self) -> dict[str, Any]:
        return {**self.__dict__, "notes": dict(self.notes)}  # a proxy cannot be pickled

    def __setstate__(self, state: dict[str, Any]) -> None:
        self.__dict__.update(state, notes=MappingProxyType(state["notes"]))

    def _ordered(self, *keys: str) -> None:
        """Refuse values that do not grow in the order of `keys`; absent ones are skipped."""
        known = [(key, getattr(self, key)) for key in keys if getattr(self, key) is not None]
        for (low, a), (high, b) in pairwise(known):
            if a > b:
                raise InputError(f"turbine.{low}: got {a:g}, more than {high} = {b:g}")

    @property
    def rotor_inertia(self) -> float | None:
        """Blades and hub about the shaft [kg m^2], prebend left out; None if not known."""
        if self.blade_structure is None or self.hub is None:
            return None
        second = self.blade_structure.moment(2, offset=self.rotor.hub_radius)
        blades = self.rotor.blades * second * float(np.cos(self.rotor.cone)) ** 2
        return blades + self.hub.inertia

    @property
    def rated_torque(self) -> float | None:
        """Aerodynamic torque at rated power [N m], None where the efficiency is not known."""
        if self.drivetrain.efficiency is None:
            return None
        return self.rated_power / (self.drivetrain.efficiency * self.rated_rotor_speed)


def _pair(name: str, value: tuple[float, float]) -> tuple[float, float]:
    try:
        low, high = value
    except (TypeError, ValueError) as error:
        raise InputError(f"{name}: got {value!r}, expected a lower and an upper limit") from error
    low, high = finite_number(name, low), finite_number(name, high)
    if low > high:
        raise InputError(f"{name}: lower limit {low:g} is above the upper limit {high:g} [rad]")
    return low, high


def _limits(value: tuple[float | None, float | None]) -> tuple[float | None, float | None]:
    name = "turbine.alpha_limits"
    try:
        low, high = value
    except (TypeError, ValueError) as error:
        raise InputError(f"{name}: got {value!r}, expected a lower and an upper limit") from error
    low = None if low is None else finite_number(name, low)
    high = None if high is None else finite_number(name, high)
    if low is not None and high is not None and low >= high:
        raise InputError(f"{name}: lower limit {low:g} is not below the upper limit {high:g} [rad]")
    return low, high
