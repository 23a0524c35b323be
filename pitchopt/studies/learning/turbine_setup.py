"""TurbineSettings and TurbineSetup: from a case to the dynamic turbine that a learner runs on.

A case names turbine, wind and limits; the settings say what of it moves, what turbulence is on top
of the wind and whether a controller runs the rotor.  A setup makes plants of them: the same in
steady wind and in turbulence of any seed.

Lag.  A learner takes the loads at a position for the answer to the pitch there.  Here they
answer later: commands are half a station late, the actuators lag, and a flapping blade follows its
loads after 2 zeta / omega of its first mode (that of the `nrel-5mw` at 0.7 Hz with aerodynamic
damping: 0.2 to 0.3 s, or 13 to 20 degrees of azimuth).  The lag is measured from the loads:
under cyclic pitch beta = a cos(psi - eps) the mean tilt and yaw are

    (tilt, yaw) = -g a (cos(eps + phi), sin(eps + phi)),

so that the two by two matrix of tilt and yaw over the cosine and the sine part of the pitch is a
rotation by phi, the azimuth offset of individual pitch control.  The learner is told the next
whole number of stations above phi as the delay of its measurements: it then takes loads and the
pitch before them together.  With a lag that is too short, what a passage changes at its end appears
as the answer to the one that follows; one that is too long pairs loads with the wrong pitch too.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, Literal

import numpy as np

from pitchopt.cases import Case
from pitchopt.checks import FloatArray, finite_number, whole_number
from pitchopt.control import PitchActuator, TurbineController
from pitchopt.errors import InputError
from pitchopt.sim import FREEDOMS, DynamicTurbine, Operation, Start
from pitchopt.sim.wind import Wind, check_wind, wind_direction
from pitchopt.studies.learning.dynamic_plant import DynamicPlant, whole_step
from pitchopt.studies.simulation.winds import turbulence_level
from pitchopt.turbines import Turbine
from windfield import StaticField, TurbulentField, WindFieldError
from windfield.iec import CLASSES
from windfield.kaimal import kaimal_box

__all__ = ["Lag", "TurbineSettings", "TurbineSetup"]

_BOX_SECONDS = 600.0
_BOX_INTERVAL = 0.1
_BOX_POINTS = (13, 13)
_BOXES_KEPT = 4
_BOX_MARGIN = 1.1  # of the rotor's diameter
_STRUCTURE = tuple(name for name in FREEDOMS if name not in ("rotor-speed", "shaft-torsion"))
_LAG_AMPLITUDE = math.radians(0.5)
_LAG_SETTLE, _LAG_MEAN = 4, 4  # rotations
_WARM_UP = 40


@dataclass(frozen=True, kw_only=True)
class TurbineSettings:
    """What of the turbine moves, and in what turbulence.

    Parameters
    ----------
    turbulence : str
        ``none``, ``A+``, ``A``, ``B`` or ``C`` of the normal turbulence model of IEC 61400-1, or an
        intensity such as ``0.05``; Kaimal spectra.
    structure : {"flexible", "rigid"}
        Whether blades and tower bend.
    rotor : {"held", "controlled"}
        Held at the case's rotor speed, or free with the turbine's baseline controller.
    pitch_lag : float
        Time constant of the pitch actuators [s]; 0 for ones that follow at once within their rate.
    averaged : int
        Rotations over which the loads of a profile are averaged, see `DynamicPlant`.
    longest_step : float
        Of the time loop [s].

    Raises
    ------
    InputError
        If a value is out of range.
    """

    turbulence: str = "none"
    structure: Literal["flexible", "rigid"] = "flexible"
    rotor: Literal["held", "controlled"] = "held"
    pitch_lag: float = 0.0
    averaged: int = 0
    longest_step: float = 0.025

    def __post_init__(self) -> None:
        for name, allowed in (
            ("structure", ("flexible", "rigid")),
            ("rotor", ("held", "controlled")),
        ):
            if getattr(self, name) not in allowed:
                raise InputError(
                    f"{name}: got {getattr(self, name)!r}, expected one of {', '.join(allowed)}"
                )
        level = turbulence_level(self.turbulence)
        if isinstance(level, str) and level not in ("none", *CLASSES):
            raise InputError(
                f"turbulence: got {self.turbulence!r}, expected one of "
                f"{', '.join(('none', *CLASSES))}, or an intensity such as 0.05"
            )
        finite_number("pitch_lag", self.pitch_lag, at_least=0.0, at_most=10.0)
        finite_number("longest_step", self.longest_step, above=0.0, at_most=0.2)
        whole_number("averaged", self.averaged, at_least=0)


@dataclass(frozen=True, kw_only=True, eq=False)
class Lag:
    """How late the loads answer the pitch.

    Attributes
    ----------
    response : ndarray (2, 2)
        Mean tilt and yaw over the cosine and the sine part of a cyclic pitch [N m/rad].
    angle : float
        phi [rad].
    samples : int
        What a learner is told.
    """

    response: FloatArray
    angle: float
    samples: int


class TurbineSetup:
    """Plants of one case.

    Parameters
    ----------
    case : Case
    settings : TurbineSettings
    start_pitch : float
        Constant pitch that plants start from with a rotor that is held [rad]; with a controller
        that of its steady operation is taken instead.

    Raises
    ------
    InputError
        If the case has no turbine with a structure, or a wind that the time loop does not know.
    """

    def __init__(self, case: Case, settings: TurbineSettings, start_pitch: float) -> None:
        self.case, self.settings = case, settings
        self.wind = steady_wind(case)
        self.turbine = structural_turbine(case)
        self.controller: TurbineController | None = None
        self._fields: dict[int, TurbulentField] = {}
        speed = case.rotor_speed
        if settings.rotor == "controlled":
            operation = Operation(self._dynamic(speed))
            self.start = operation.start(case.wind.speed)
            self.controller = operation.baseline()
            speed = self.start.rotor_speed
        else:
            self.start = Start(rotor_speed=speed, pitch=start_pitch)
        self.rotor_speed = speed
        self.dynamic = self._dynamic(speed)
        reach = self.dynamic.reach_in(wind_direction(self.wind))
        check_wind(self.turbine, reach, self.wind, self.dynamic.step)

    @property
    def stations(self) -> int:
        """N."""
        return self.case.blades * self.case.positions

    def _dynamic(self, rotor_speed: float) -> DynamicTurbine:
        case, settings = self.case, self.settings
        limits = case.pitch_limits
        freedoms = _STRUCTURE if settings.structure == "flexible" else ()
        if settings.rotor == "controlled":
            freedoms = ("rotor-speed", *freedoms)
        return DynamicTurbine(
            turbine=self.turbine,
            freedoms=freedoms,
            skew=case.aero.skew,
            yaw=case.operation.yaw,
            step=whole_step(rotor_speed, self.stations, settings.longest_step),
            actuator=PitchActuator(
                lowest=limits.lower,
                highest=limits.upper,
                rate=limits.pitch_rate,
                time_constant=settings.pitch_lag or None,
            ),
        )

    def field(self, seed: int | None) -> Wind:
        """The steady wind, with the turbulence of a seed on it unless that is None.

        The boxes of the last few seeds are kept.
        """
        if seed is None or self.settings.turbulence == "none":
            return self.wind
        if seed not in self._fields:
            while len(self._fields) >= _BOXES_KEPT:
                self._fields.pop(next(iter(self._fields)))
            self._fields[seed] = self._turbulent(seed)
        return self._fields[seed]

    def _turbulent(self, seed: int) -> TurbulentField:
        rotor = self.turbine.rotor
        width = 2.0 * rotor.radius * _BOX_MARGIN
        try:
            box = kaimal_box(
                self.wind.speed,
                _BOX_SECONDS,
                _BOX_INTERVAL,
                hub_height=rotor.hub_height,
                width=width,
                height=width,
                points=_BOX_POINTS,
                turbulence=turbulence_level(self.settings.turbulence),
                seed=seed,
            )
            return TurbulentField(mean=self.wind, box=box)
        except WindFieldError as error:
            raise InputError(f"turbulence: {error}") from error

    def plant(self, seed: int | None = None, *, averaged: int = 0) -> DynamicPlant:
        """A fresh plant, in the turbulence of a seed or in the steady wind."""
        return DynamicPlant(
            self.dynamic,
            self.field(seed),
            positions=self.case.positions,
            start=self.start,
            controller=self.controller,
            averaged=averaged,
            warm_up=_WARM_UP,
        )

    @cached_property
    def mean_torque(self) -> float:
        """Mean torque in the steady wind at the starting pitch [N m]."""
        loads = self.plant().warm_loads[-10:]
        return float(loads[:, :, 0].mean())

    @cached_property
    def lag(self) -> Lag:
        """How late the loads answer, measured in the steady wind with cyclic pitch."""
        plant = self.plant()
        psi = 2.0 * np.pi * np.arange(self.stations) / self.stations
        response = np.zeros((2, 2))
        for column, wave in enumerate((np.cos(psi), np.sin(psi))):
            for sign in (1.0, -1.0):
                profile = self.start.pitch + sign * _LAG_AMPLITUDE * wave
                loads = plant.held(profile, _LAG_SETTLE + _LAG_MEAN)[_LAG_SETTLE:]
                mean = loads.mean(axis=(0, 1, 3))
                response[:, column] += sign * mean[1:3] / (2.0 * _LAG_AMPLITUDE)
        # the rotation nearest to -response
        angle = math.atan2(response[0, 1] - response[1, 0], -(response[0, 0] + response[1, 1]))
        station = 2.0 * np.pi / self.stations
        samples = max(math.floor(angle / station) + 1, 1)
        return Lag(response=response, angle=angle, samples=min(samples, self.case.positions))

    def plain(self) -> dict[str, Any]:
        """Settings as plain data."""
        return {
            name: getattr(self.settings, name)
            for name in (
                *("turbulence", "structure", "rotor", "pitch_lag", "averaged"),
                "longest_step",
            )
        }


def structural_turbine(case: Case) -> Turbine:
    """The case's turbine, with its air density.

    Raises
    ------
    InputError
        If there is none, or its structure is not known.
    """
    turbine = case.turbine_data
    if turbine is None or case.table is not None:
        raise InputError(
            f"case {case.name!r}: got a table of curves, expected a turbine: the dynamic plant "
            "needs its structure"
        )
    missing = [
        what
        for what, there in (
            ("blade structure", turbine.blade_structure),
            ("hub", turbine.hub),
            ("nacelle", turbine.nacelle),
        )
        if there is None
    ]
    if missing:
        raise InputError(
            f"turbine {turbine.name!r}: {', '.join(missing)} not known, expected a turbine with "
            "structure, such as nrel-5mw: the dynamic plant needs it"
        )
    if case.aero.elements is not None:
        raise InputError(
            f"aero.elements: got {case.aero.elements}, expected 'auto': the dynamic plant has the "
            "turbine's own blade elements"
        )
    density = case.operation.air_density
    return turbine if density is None else replace(turbine, air_density=density)


def steady_wind(case: Case) -> StaticField:
    """The case's wind.

    Raises
    ------
    InputError
        If it is given by a disc file.
    """
    if case.table is not None:
        structural_turbine(case)
    field = case.wind_field()
    if not isinstance(field, StaticField):
        raise InputError(
            "wind.disc: got a disc file, expected shear given by a law: the dynamic plant needs "
            "the wind around the disc as well"
        )
    return field
