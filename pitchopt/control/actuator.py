"""Pitch actuators and the generator's lag: their parameters.

Motion and its exact discrete form: `pitchopt.control.actuator_kernels`.  The first-order
actuator 1 / (tau s + 1) is that of S. Mulders, A. Pamososuryo, J.-W. van Wingerden, "Efficient
tuning of Individual Pitch Control", 2020, with tau = 0.4 s there.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from pitchopt.checks import finite_number
from pitchopt.errors import InputError

__all__ = ["ActuatorParameters", "GeneratorLag", "PitchActuator"]

IMMEDIATE = 0
FIRST_ORDER = 1
SECOND_ORDER = 2


class ActuatorParameters(NamedTuple):
    """Numbers of a `PitchActuator` for one step; the a's are the second-order transition."""

    kind: int
    step: float
    lowest: float
    highest: float
    rate: float
    tau: float
    a11: float
    a12: float
    a21: float
    a22: float


@dataclass(frozen=True, kw_only=True)
class PitchActuator:
    """Actuator of each blade.

    Without dynamics it follows the command at once, within the rate.

    Parameters
    ----------
    lowest, highest : float
        Range [rad].
    rate : float
        Largest speed [rad/s].
    time_constant : float, optional
        tau of a first-order actuator [s].
    frequency, damping : float, optional
        omega [rad/s] and zeta [-] of a second-order actuator.

    Raises
    ------
    InputError
        If a number is out of range, or both kinds of dynamics or half of one are given.
    """

    lowest: float
    highest: float
    rate: float
    time_constant: float | None = None
    frequency: float | None = None
    damping: float | None = None

    def __post_init__(self) -> None:
        finite_number("lowest", self.lowest)
        finite_number("highest", self.highest, above=self.lowest)
        finite_number("rate", self.rate, above=0.0)
        if (self.frequency is None) != (self.damping is None):
            raise InputError(
                f"frequency, damping: got {self.frequency} and {self.damping}, expected both or "
                "neither"
            )
        if self.time_constant is not None:
            finite_number("time_constant", self.time_constant, above=0.0)
            if self.frequency is not None:
                raise InputError(
                    "time_constant: got one beside frequency and damping, expected an actuator "
                    "of first or of second order"
                )
        if self.frequency is not None and self.damping is not None:
            finite_number("frequency", self.frequency, above=0.0)
            finite_number("damping", self.damping, above=0.0)

    @property
    def kind(self) -> int:
        """0 immediate, 1 first order, 2 second order."""
        if self.frequency is not None:
            return SECOND_ORDER
        return IMMEDIATE if self.time_constant is None else FIRST_ORDER

    def parameters(self, step: float) -> ActuatorParameters:
        """Numbers for `pitchopt.control.actuator_kernels.pitch_actuator` with this step [s]."""
        step = finite_number("step", step, above=0.0)
        transition = np.zeros((2, 2))
        if self.frequency is not None and self.damping is not None:
            from scipy.linalg import expm

            omega, zeta = self.frequency, self.damping
            transition = expm(step * np.array([[0.0, 1.0], [-(omega**2), -2.0 * zeta * omega]]))
        return ActuatorParameters(
            kind=self.kind,
            step=step,
            lowest=float(self.lowest),
            highest=float(self.highest),
            rate=float(self.rate),
            tau=float(self.time_constant or 0.0),
            a11=float(transition[0, 0]),
            a12=float(transition[0, 1]),
            a21=float(transition[1, 0]),
            a22=float(transition[1, 1]),
        )


@dataclass(frozen=True, kw_only=True)
class GeneratorLag:
    """First-order lag of the generator torque behind its command.

    Parameters
    ----------
    time_constant : float, optional
        [s]; 0 for a torque that follows at once.

    Raises
    ------
    InputError
        If it is negative.
    """

    time_constant: float = 0.0

    def __post_init__(self) -> None:
        finite_number("time_constant", self.time_constant, at_least=0.0)

    def keep(self, step: float) -> float:
        """Share of the distance to the command that is left after a step [s]."""
        step = finite_number("step", step, above=0.0)
        return math.exp(-step / self.time_constant) if self.time_constant > 0.0 else 0.0
