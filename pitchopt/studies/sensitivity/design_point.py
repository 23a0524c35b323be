"""A pitch design that was found, and the same design problem with one parameter changed.

What a design is asked to solve has numbers in it that do not come from the parameter: the mean
torque to be kept, the cap on the blade load, the mean pitch at which a wake is frozen or around
which curves are sampled.  They stay what they are, in N m and rad, when a parameter changes, so
that estimate and re-solved truth speak of the same problem.

    rate    largest pitch rate of the actuators [rad/s]
    lower   lower end of the pitch range [rad]; stall limits are not moved
    upper   upper end of the pitch range [rad]
    mu      price of the weighted RMS [-]; designs with a price alone
    loss    allowed loss of mean torque, as a share of the largest; designs for a loss alone
    torque  mean torque that is held [N m]; designs for a torque alone
    shear   exponent of the vertical shear [-]; cases with one alone
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np

from pitchopt.checks import FloatArray, finite_number
from pitchopt.design.limits import lipschitz_lower, lipschitz_upper
from pitchopt.design.problem import DesignProblem, Objective
from pitchopt.errors import InfeasibleError, InputError, PitchoptError
from pitchopt.studies.sensitivity.stationary import Stationary, stationary

if TYPE_CHECKING:
    from pitchopt.aero.static_rotor import StaticRotor
    from pitchopt.cases import Case
    from pitchopt.design.results import Compared, Design
    from pitchopt.design.task import DesignTask

__all__ = ["PARAMETERS", "UNITS", "Changed", "DesignPoint"]

PARAMETERS = ("rate", "lower", "upper", "mu", "loss", "torque", "shear")

_GOALS = {"mu": "mu", "loss": "max_power_loss", "torque": "mean_torque"}
_DEGREE = float(np.pi / 180.0)

UNITS: Mapping[str, tuple[str, str, float]] = {
    "rate": ("pitch rate", "deg/s", float(np.degrees(1.0))),
    "lower": ("lower end of range", "deg", float(np.degrees(1.0))),
    "upper": ("upper end of range", "deg", float(np.degrees(1.0))),
    "mu": ("price mu", "-", 1.0),
    "loss": ("torque lost", "%", 100.0),
    "torque": ("mean torque", "kN m", 1e-3),
    "shear": ("shear exponent", "-", 1.0),
}
"""Name, unit and factor by which people read a parameter."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Changed:
    """The design problem with a parameter changed.

    Attributes
    ----------
    value : float
        Of the parameter, in its own unit.
    task : DesignTask
        With the pitch of the wake or of the curves held.
    objective : Objective
    """

    value: float
    task: DesignTask
    objective: Objective


@dataclass(frozen=True, kw_only=True, eq=False)
class DesignPoint:
    """A design, with what its problem is made of.

    Parameters
    ----------
    case : Case
    task : DesignTask
        The case's task.
    found : Compared
        The design with the constant pitch and the power maximum that it is judged by.

    Raises
    ------
    InputError
        If the design is not converged: it has no multipliers that mean anything.
    """

    case: Case
    task: DesignTask
    found: Compared

    def __post_init__(self) -> None:
        design = self.found.design
        if design.kind not in _GOALS.values():
            raise InputError(
                f"design: got kind {design.kind!r}, expected one of {', '.join(_GOALS.values())}"
            )
        if not design.status.ok:
            raise InputError(
                f"design: got one that ended with {design.status.value!r}, expected a converged "
                "one: there are no multipliers at any other"
            )

    # ---- what it is made of ------------------------------------------------------------------

    @property
    def design(self) -> Design:
        """The design itself."""
        return self.found.design

    @property
    def by_torque(self) -> bool:
        """True where the objective counts mean torque; else it is minus the weighted RMS."""
        return self.design.kind == "mu"

    @property
    def largest_torque(self) -> float:
        """Mean torque of the power maximum [N m]."""
        return self.found.power_max.mean_torque

    @property
    def pitch(self) -> float | None:
        """Pitch at which the wake is frozen or around which curves are sampled [rad]; held."""
        return self.design.mean_pitch if self.task.frozen else self.held.operating_pitch

    @cached_property
    def held(self) -> DesignTask:
        """The task, with the pitch around which curves are sampled held."""
        return self.task.operating_at(float(self.found.constant.profile.mean()))

    @cached_property
    def objective(self) -> Objective:
        """The normal form that the design solves."""
        return self._objective()

    def _objective(self, **other: float) -> Objective:
        design, task = self.design, self.task
        share = task.blade_cap
        cap = np.inf if share is None else share * self.found.constant.loads.blade_rms
        limits: dict[str, Any] = {"travel": task.travel, "blade_cap": cap}
        if design.kind == "mu":
            return Objective.tradeoff(other.get("mu", design.mu), task.weights, **limits)
        assert design.target is not None
        if design.kind == "max_power_loss":
            low = (1.0 - other.get("loss", design.target)) * self.largest_torque
            return Objective.least_rms(task.weights, torque_min=low, **limits)
        torque = other.get("torque", design.target)
        return Objective.least_rms(task.weights, torque_min=torque, torque_max=torque, **limits)

    @cached_property
    def problem(self) -> DesignProblem:
        """The problem on the design's own curves."""
        return self.held.problem(self.design.mean_pitch)

    @cached_property
    def stationary(self) -> Stationary:
        """Multipliers at the design."""
        return stationary(self.problem, self.objective, self.design.profile)

    @cached_property
    def price(self) -> float | None:
        """Torque that a N m of weighted RMS is worth at the design [-]; None without one."""
        if self.by_torque:
            return self.design.mu
        mult = self.stationary.multipliers
        held = mult.torque_min - mult.torque_max
        return 1.0 / held if held > 1e-9 else None

    # ---- parameters --------------------------------------------------------------------------

    @cached_property
    def parameters(self) -> tuple[str, ...]:
        """Parameters that the design has."""
        return tuple(name for name in PARAMETERS if self._missing(name) is None)

    def _missing(self, name: str) -> str | None:
        """Why the design lacks a parameter; None where it has it."""
        if name in _GOALS:
            if _GOALS[name] == self.design.kind:
                return None
            return f"the goal of the design is {self.design.kind.replace('_', ' ')}"
        if name == "shear":
            if self.case.table is not None:
                return "the case is a table of curves, whose wind is in it"
            if self.case.wind.disc is not None:
                return "the wind over the disc comes from a file"
            if self.case.wind.shear == "log":
                return "the case has a log law"
            return None
        table = self.case.table
        if table is not None and name in ("lower", "upper"):
            curves, limits = table.table, self.task.limits
            if name == "lower" and np.all(limits.lower <= curves.lower):
                return "the pitch range ends where the table of curves does"
            if name == "upper" and np.all(limits.upper >= curves.upper):
                return "the pitch range ends where the table of curves does"
        return None

    def require(self, name: str) -> None:
        """Check that the design has a parameter.

        Raises
        ------
        InputError
            If there is no such parameter, or the design lacks it.
        """
        if name not in PARAMETERS:
            raise InputError(f"parameter: got {name!r}, expected one of {', '.join(PARAMETERS)}")
        why = self._missing(name)
        if why is not None:
            raise InputError(
                f"{UNITS[name][0]}: the design has no such parameter, {why}; expected one of "
                f"{', '.join(self.parameters)}"
            )

    def value(self, name: str) -> float:
        """Present value of a parameter, in SI and radians."""
        self.require(name)
        limits = self.task.limits
        if name in _GOALS:
            value = self.design.mu if name == "mu" else self.design.target
            assert value is not None
            return float(value)
        if name == "shear":
            return self.case.wind.shear_exponent if self.case.wind.shear != "none" else 0.0
        return {"rate": limits.pitch_rate, "lower": limits.lower, "upper": limits.upper}[name]

    def default_step(self, name: str) -> float:
        """Change that is looked at when none is asked for, in SI and radians.

        A degree a second more rate, a degree wider range, a tenth lower price (0.1 more where it
        is zero), a share of 0.5 % of torque more to lose, 0.5 % of the held torque more, 0.02
        more shear.
        """
        if name == "mu":
            return -0.1 * self.value(name) or 0.1
        if name == "torque":
            return 5e-3 * self.value(name)
        if name == "loss":
            return 5e-3
        return {"rate": _DEGREE, "lower": -_DEGREE, "upper": _DEGREE, "shear": 0.02}[name]

    def changed(self, name: str, step: float) -> Changed:
        """The problem with a parameter changed by a step.

        Raises
        ------
        InputError
            If the design lacks the parameter or the new value is not allowed.
        InfeasibleError
            If the new value leaves no profile.
        """
        words, unit, factor = UNITS[name]
        step = finite_number(f"step of the {words}", step)
        value = self.value(name) + step
        shown = "" if unit == "-" else f" {unit}"
        try:
            return self._changed(name, value)
        except PitchoptError as error:
            raise type(error)(
                f"{words}: a change by {factor * step:+.6g} to {factor * value:.6g}{shown} is not "
                f"allowed: {error}"
            ) from error

    def _changed(self, name: str, value: float) -> Changed:
        if name in _GOALS:
            objective = self._objective(**{name: value})
            if name == "loss" and not 0.0 <= value < 1.0:
                raise InputError(f"got {value:g}, expected a share from 0 to below 1")
            if name == "torque" and value > self.largest_torque:
                raise InfeasibleError(
                    f"mean torque: got {value:.6g} N m, the largest of any profile is "
                    f"{self.largest_torque:.6g} N m"
                )
            return Changed(value=value, task=self.held, objective=objective)
        if name == "rate":
            if value < 0.0:
                raise InputError("expected a rate of 0 deg/s or more")
            task = replace(self.held, limits=replace(self.task.limits, pitch_rate=value))
            return Changed(value=value, task=task, objective=self.objective)
        if name == "shear":
            values: dict[str, Any] = {"wind.shear_exponent": value}
            if self.case.wind.shear == "none":
                values["wind.shear"] = "power"
            task = replace(self.held, model=self.case.with_values(values).model())
            return Changed(value=value, task=task, objective=self.objective)
        limits = self.task.limits
        end = {name: value}
        task = replace(self.held, limits=replace(limits, **end))
        wider = value < limits.lower if name == "lower" else value > limits.upper
        if wider and self.case.table is None:
            # curves end where the actuators' range does, and have to be made anew
            ends = (task.limits.lower, task.limits.upper)
            task = replace(task, model=replace(self.rotor_of(task), pitch_range=ends))
        return Changed(value=value, task=task, objective=self.objective)

    @staticmethod
    def rotor_of(task: DesignTask) -> StaticRotor:
        """Rotor model of a task that has one."""
        from pitchopt.aero.static_rotor import StaticRotor

        assert isinstance(task.model, StaticRotor)
        return task.model

    def raw_ends(self, task: DesignTask) -> tuple[FloatArray, FloatArray]:
        """What range and stall leave at each station in a changed problem [rad]."""
        if self.case.table is not None:
            low, high = self.case.table.table.lower, self.case.table.table.upper
        else:
            azimuth = self.problem.curves.azimuth
            low, high = self.rotor_of(task).pitch_limits(azimuth, self.pitch)
        return np.maximum(low, task.limits.lower), np.minimum(high, task.limits.upper)

    def ends(self, task: DesignTask) -> tuple[FloatArray, FloatArray]:
        """The same, tightened to what the rate can follow [rad]."""
        step = task.limits.step(self.problem.curves.stations)
        low, high = self.raw_ends(task)
        return lipschitz_lower(low, step), lipschitz_upper(high, step)
