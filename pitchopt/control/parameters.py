"""Numbers that the compiled controller works with, and the places of its memory.

The parts of a controller turn into these tuples, always with the same types, so that one
compilation serves every combination: a part that is absent stands there with ``on = 0`` and
tables of one entry.  All tables are contiguous and writable, for the same reason; nobody writes
to them.

The memory of a running controller is one vector (`MEMORY_SIZE`,) of float64.
"""

from __future__ import annotations

from typing import NamedTuple

from pitchopt.checks import FloatArray

__all__ = ["MEMORY_SIZE", "ControlParameters", "PitchParameters", "TorqueParameters"]

# places in the memory
FILTERED_SPEED = 0  # of the generator [rad/s]
INTEGRAL = 1  # of the filtered speed error [rad]
COLLECTIVE = 2  # last collective command [rad]
LAST_TORQUE = 3  # last torque command [N m]
LAST_PITCH = 4  # last command of each blade [rad]
HELD = 7  # calls answered by holding the last command
MEMORY_SIZE = 8


class TorqueParameters(NamedTuple):
    """Of `pitchopt.control.torque.TorqueLaw`; generator side."""

    cut_in: float
    region2: float
    transition: float
    region3: float
    synchronous: float
    slope_15: float
    slope_25: float
    gain: float
    constant_power: int
    power: float
    rated: float
    region3_pitch: float
    largest: float
    rate: float


class PitchParameters(NamedTuple):
    """Of `pitchopt.control.pitch.PitchRegulator` and of the range of pitch."""

    proportional: float
    integral: float
    reference: float
    linear: float
    quadratic: float
    lowest: float
    highest: float
    rate: float
    blade_lowest: float
    blade_highest: float


class ControlParameters(NamedTuple):
    """All numbers of a `pitchopt.control.controller.TurbineController` for one step."""

    step: float
    keep: float
    torque: TorqueParameters
    pitch: PitchParameters


def table(values: FloatArray) -> FloatArray:
    """Writable contiguous copy, the one type of table that the kernels are compiled for."""
    return values.copy(order="C")
