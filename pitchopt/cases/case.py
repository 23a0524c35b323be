"""A case: turbine, wind, operation, aerodynamic model, limits and objective of one design.

A case only names things; `model` and `task` build them:

    case.model()   the rotor in its wind (or a table of curves), what design calls a pitch model
    case.task()    model, limits, weights and restrictions together

What a case leaves open (None inside, "auto" in files) comes from the turbine.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from pitchopt.cases.kinds import PathName, Text
from pitchopt.cases.settings import (
    SCHEMA,
    SECTIONS,
    AeroSettings,
    LimitSettings,
    ObjectiveSettings,
    OperationSettings,
    WindSettings,
)
from pitchopt.design.limits import PitchLimits
from pitchopt.design.problem import LoadWeights
from pitchopt.errors import InputError

if TYPE_CHECKING:
    from pitchopt.aero.rotor import Rotor
    from pitchopt.aero.static_rotor import StaticRotor
    from pitchopt.design.results import Design
    from pitchopt.design.task import CurvesModel, DesignTask
    from pitchopt.turbines import Turbine
    from windfield import WindField

__all__ = ["Case"]

TABLE_RATE = float(np.deg2rad(8.0))


@dataclass(frozen=True, kw_only=True)
class Case:
    """Settings of one design.

    Parameters
    ----------
    name : str
        What the case is called in tables and files.
    turbine : str or path, optional
        Key of the catalogue, or a windIO v2 file.
    curves : path, optional
        Table of BladeCurves (.npz or .csv) from any aerodynamic code, used in place of rotor and
        wind.  Needs ``operation.rotor_speed``, unless a turbine is named as well, which then
        gives rotor speed, limits and hub height.
    wind, operation, aero, limits, objective
        The sections.

    Raises
    ------
    InputError
        If a value is not allowed, or neither turbine nor curves are named.
    """

    name: str
    turbine: str | None = None
    curves: Path | None = None
    wind: WindSettings = field(default_factory=WindSettings)
    operation: OperationSettings = field(default_factory=OperationSettings)
    aero: AeroSettings = field(default_factory=AeroSettings)
    limits: LimitSettings = field(default_factory=LimitSettings)
    objective: ObjectiveSettings = field(default_factory=ObjectiveSettings)

    def __post_init__(self) -> None:
        set_ = object.__setattr__
        set_(self, "name", Text().check("name", self.name))
        turbine = None if self.turbine is None else str(self.turbine)
        set_(self, "turbine", Text(optional=True).check("turbine", turbine))
        set_(self, "curves", PathName().check("curves", self.curves))
        for key, section in SECTIONS.items():
            if not isinstance(getattr(self, key), section):
                raise InputError(
                    f"{key}: got {type(getattr(self, key)).__name__}, expected {section.__name__}"
                )
        if self.turbine is None and self.curves is None:
            raise InputError("turbine: got nothing, expected a catalogue key or a windIO file")

    def with_values(self, values: Mapping[str, Any]) -> Case:
        """The case with other inner values.

        Parameters
        ----------
        values : mapping
            From dotted names (``wind.speed``, ``limits.pitch_rate``, ``curves``) to values in SI
            and radians.
        """
        changed: dict[str, Any] = {}
        sections: dict[str, dict[str, Any]] = {}
        for name, value in values.items():
            section, dot, attribute = name.partition(".")
            if dot:
                sections.setdefault(section, {})[attribute] = value
            else:
                changed[section] = value
        for section, mine in sections.items():
            changed[section] = replace(getattr(self, section), **mine)
        return replace(self, **changed) if changed else self

    # ---- what the case stands for --------------------------------------------------------

    @cached_property
    def turbine_data(self) -> Turbine | None:
        """The turbine, None if the case is a table of curves alone."""
        from pitchopt.turbines import load_turbine

        return None if self.turbine is None else load_turbine(self.turbine)

    @cached_property
    def table(self) -> CurvesModel | None:
        """The table of curves, None if the case has a rotor model."""
        if self.curves is None:
            return None
        from pitchopt.aero.curves import BladeCurves
        from pitchopt.design.task import CurvesModel

        return CurvesModel(table=BladeCurves.load(self.curves))

    @property
    def rotor_speed(self) -> float:
        """Rotor speed [rad/s]: given, or from the turbine's schedule.

        Below rated the schedule keeps the optimal tip-speed ratio, within the turbine's least
        and rated rotor speed.
        """
        if self.operation.rotor_speed is not None:
            return self.operation.rotor_speed
        turbine = self.turbine_data
        if turbine is None:
            raise InputError(
                "operation.rotor_speed_rpm: got 'auto', expected a number: a table of curves has "
                "no schedule"
            )
        least, rated = turbine.min_rotor_speed, turbine.rated_rotor_speed
        if least == rated:
            return rated
        if turbine.optimal_tip_speed_ratio is None:
            raise InputError(
                "operation.rotor_speed_rpm: got 'auto', expected a number: the turbine "
                f"{turbine.name!r} has no optimal tip-speed ratio"
            )
        wanted = turbine.optimal_tip_speed_ratio * self.wind.speed / turbine.rotor.radius
        return float(np.clip(wanted, least, rated))

    @property
    def blades(self) -> int:
        """Number of blades."""
        if self.table is not None:
            return self.table.table.blades
        return self._turbine("blades").rotor.blades

    @property
    def positions(self) -> int:
        """Rotor positions m in one blade passage; those of the table, if there is one."""
        return self.limits.positions if self.table is None else self.table.table.positions

    def rotor(self) -> Rotor:
        """Rotor with the wanted number of elements."""
        rotor = self._turbine("rotor").rotor
        if self.aero.elements is None:
            return rotor
        if self.turbine == "biegel2011":
            from pitchopt.turbines import biegel_blade

            return replace(rotor, blade=biegel_blade(self.aero.elements))
        return replace(rotor, blade=rotor.blade.elements(self.aero.elements))

    def wind_field(self) -> WindField:
        """Wind over the disc.

        Raises
        ------
        InputError
            If the values do not fit each other or the disc file cannot be used.
        """
        import windfield

        wind, turbine = self.wind, self._turbine("wind")
        hub = turbine.rotor.hub_height
        try:
            tower = None
            if wind.tower_shadow:
                tower = windfield.TowerShadow(
                    radius=turbine.tower.radius,
                    height=turbine.tower.height,
                    top=turbine.tower.top,
                    lateral=wind.tower_lateral,
                )
            if wind.disc is not None:
                return windfield.DiscField.from_csv(
                    wind.disc, hub_height=hub, direction=wind.direction, tower=tower
                )
            laws: dict[str, Any] = {
                "power": lambda: windfield.PowerLaw(exponent=wind.shear_exponent),
                "cubic": lambda: windfield.CubicShear(exponent=wind.shear_exponent),
                "log": lambda: windfield.LogLaw(roughness_length=wind.roughness_length),
                "none": lambda: None,
            }
            return windfield.StaticField(
                speed=wind.speed,
                hub_height=hub,
                vertical=laws[wind.shear](),
                horizontal_shear=wind.horizontal_shear,
                direction=wind.direction,
                tower=tower,
            )
        except windfield.WindFieldError as error:
            raise InputError(f"wind: {error}") from error

    def model(self) -> StaticRotor | CurvesModel:
        """The rotor in its wind, or the table of curves."""
        if self.table is not None:
            return self.table
        from pitchopt.aero.static_rotor import StaticRotor

        turbine, aero = self._turbine("model"), self.aero
        low, high = turbine.alpha_limits
        induction: Any = aero.induction
        return StaticRotor(
            rotor=self.rotor(),
            wind=self.wind_field(),
            rotor_speed=self.rotor_speed,
            air_density=_first(self.operation.air_density, turbine.air_density),
            yaw=self.operation.yaw,
            induction=induction,
            pitch_range=self.pitch_range,
            alpha_limits=(_first(aero.alpha_min, low), _first(aero.alpha_max, high)),
            segments=aero.segments,
            pitch_rate_terms=aero.pitch_rate_terms,
            radial_moment=aero.radial_moment,
            skew=aero.skew,
        )

    @property
    def pitch_range(self) -> tuple[float, float]:
        """Range of the actuators [rad]."""
        turbine, table = self.turbine_data, self.table
        if turbine is not None:
            ends = turbine.pitch_range
        elif table is not None:
            ends = float(table.table.lower.min()), float(table.table.upper.max())
        else:
            ends = (-np.pi, np.pi)
        low, high = _first(self.limits.pitch_min, ends[0]), _first(self.limits.pitch_max, ends[1])
        if low >= high:
            raise InputError(
                f"limits.pitch_min_deg, limits.pitch_max_deg: got {np.rad2deg(low):g} and "
                f"{np.rad2deg(high):g}, expected the first to be the smaller"
            )
        return low, high

    @property
    def pitch_limits(self) -> PitchLimits:
        """Range and rate of the actuators."""
        turbine = self.turbine_data
        low, high = self.pitch_range
        rate = TABLE_RATE if turbine is None else turbine.pitch_rate
        return PitchLimits(
            rotor_speed=self.rotor_speed,
            pitch_rate=_first(self.limits.pitch_rate, rate),
            lower=low,
            upper=high,
        )

    @property
    def weights(self) -> LoadWeights:
        """Weights of the loads."""
        chosen = self.objective.weights
        if isinstance(chosen, LoadWeights):
            return chosen
        if chosen == "unit":
            return LoadWeights.unit()
        turbine = self.turbine_data
        if turbine is None:
            raise InputError(
                "objective.weights: got 'tower-base', which needs a turbine's hub height, expected "
                "unit or weights such as torque=1,tilt=1,yaw=1,thrust=90"
            )
        return LoadWeights.tower_base(turbine.rotor.hub_height)

    @property
    def hub_height(self) -> float | None:
        """Height of the hub above ground [m]; None for a table of curves alone."""
        turbine = self.turbine_data
        return None if turbine is None else turbine.rotor.hub_height

    def model_report(self, rotor: Any, constant: Design) -> dict[str, Any]:
        """Coefficients at the constant pitch compared with, and the rotor model's own errors.

        Power and thrust coefficients refer to the wind speed at the hub and the rotor radius.
        The largest errors of the polar fits are absolute coefficients; those of a frozen wake,
        3 degrees from the mean pitch, are shares of the mean torque, bending and thrust.
        """
        turbine = self.turbine_data
        if self.table is not None or turbine is None:
            return {}
        mean = constant.mean_pitch
        force = 0.5 * rotor.air_density * np.pi * turbine.rotor.radius**2 * self.wind.speed**2
        torque, thrust = float(constant.loads.mean[0]), float(constant.loads.mean[3])
        report: dict[str, Any] = {
            "power_coefficient": torque * self.rotor_speed / (force * self.wind.speed),
            "thrust_coefficient": thrust / force,
        }
        if self.aero.induction != "equilibrium":
            fits = [fit for fit in rotor.section_fits(self.positions, mean) if fit is not None]
            report["polar_fit_lift_error"] = max((fit.cl_error for fit in fits), default=None)
            report["polar_fit_drag_error"] = max((fit.cd_error for fit in fits), default=None)
        if self.aero.induction == "frozen":
            errors = rotor.frozen_errors(self.positions, mean)
            names = ("torque", "bending", "thrust")
            report["frozen_fit_error"] = dict(zip(names, map(float, errors.fit), strict=True))
            report["frozen_projection_error"] = dict(
                zip(names, map(float, errors.projection), strict=True)
            )
        return report

    def task(self) -> DesignTask:
        """Model, limits, weights and restrictions together."""
        from pitchopt.design.task import DesignTask

        return DesignTask(
            model=self.model(),
            positions=self.positions,
            limits=self.pitch_limits,
            weights=self.weights,
            blade_cap=self.objective.blade_cap,
            harmonics=self.objective.harmonics,
            travel=self.objective.travel,
        )

    # ---- plain data ----------------------------------------------------------------------

    def plain(self) -> dict[str, Any]:
        """The case as a case file holds it; open values as "auto"."""
        out: dict[str, Any] = {"name": self.name}
        if self.turbine is not None:
            out["turbine"] = self.turbine
        if self.curves is not None:
            out["curves"] = str(self.curves)
        for entry in SCHEMA:
            section = out.setdefault(entry.section, {})
            value = getattr(getattr(self, entry.section), entry.attribute)
            section[entry.key] = entry.kind.show(value)
        return out

    def settings(self) -> dict[str, Any]:
        """The case as plain data, with what it leaves open filled in from the turbine."""
        limits = self.pitch_limits
        values: dict[str, Any] = {
            "operation.rotor_speed": self.rotor_speed,
            "limits.positions": self.positions,
            "limits.pitch_min": limits.lower,
            "limits.pitch_max": limits.upper,
            "limits.pitch_rate": limits.pitch_rate,
        }
        turbine = self.turbine_data
        if turbine is not None:
            low, high = turbine.alpha_limits
            values["operation.air_density"] = _first(
                self.operation.air_density, turbine.air_density
            )
            values["aero.alpha_min"] = _first(self.aero.alpha_min, low)
            values["aero.alpha_max"] = _first(self.aero.alpha_max, high)
        out = self.with_values(values).plain()
        out["objective"]["weights_name"] = self.weights.name
        out["objective"]["weights"] = {
            name: float(getattr(self.weights, name))
            for name in ("torque", "tilt", "yaw", "thrust", "blade")
        }
        return out

    def _turbine(self, what: str) -> Turbine:
        turbine = self.turbine_data
        if turbine is None:
            raise InputError(f"turbine: got nothing, a table of curves has no {what}")
        return turbine


def _first(value: Any, otherwise: Any) -> Any:
    return otherwise if value is None else value
