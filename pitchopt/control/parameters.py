"""Numbers that the compiled controller works with, and the places of its memory.

The parts of a controller turn into these tuples, always with the same types, so that one
compilation serves every combination: a part that is absent stands there with ``on = 0`` and
tables without entries.  All tables are contiguous and writable, for the same reason; nobody
writes to them.

The memory of a running controller is one vector of float64, `MEMORY_SIZE` entries and two more
for each harmonic of the individual pitch control.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from pitchopt.checks import FloatArray

__all__ = [
    "MEMORY_SIZE",
    "NO_ESTIMATOR",
    "NO_FEEDFORWARD",
    "NO_INDIVIDUAL",
    "NO_LINEAR_QUADRATIC",
    "NO_MINIMUM",
    "NO_PITCH",
    "ControlParameters",
    "EstimatorParameters",
    "FeedforwardParameters",
    "IndividualParameters",
    "LinearQuadraticParameters",
    "MinimumParameters",
    "PitchParameters",
    "RangeParameters",
    "TorqueParameters",
    "table",
]

# places in the memory
FILTERED_SPEED = 0  # of the generator [rad/s]
INTEGRAL = 1  # of the speed error: generator for the PI regulator, rotor for the LQR [rad]
COLLECTIVE = 2  # last collective command [rad]
LAST_TORQUE = 3  # last torque command [N m]
LAST_PITCH = 4  # last command of each blade [rad]
HELD = 7  # calls answered by holding the last command
WIND = 8  # estimated rotor-effective wind speed [m/s]
ROTOR_SPEED = 9  # at the last call [rad/s]
CLIPPED = 10  # 1 if the range or rate of a blade cut its last command
ELAPSED = 11  # time since the start [s]
SCHEDULED = 12  # estimated wind speed after the LQR's low pass [m/s]
INDIVIDUAL = 13  # tilt and yaw part of each harmonic [rad], to the end
MEMORY_SIZE = 13


def table(values: FloatArray) -> FloatArray:
    """Writable contiguous copy, the one type of table that the kernels are compiled for."""
    return np.array(values, dtype=np.float64, order="C")


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


class RangeParameters(NamedTuple):
    """Of `pitchopt.control.pitch.PitchRange`."""

    lowest: float
    highest: float
    rate: float
    blade_lowest: float
    blade_highest: float


class PitchParameters(NamedTuple):
    """Of `pitchopt.control.pitch.PitchRegulator`."""

    proportional: float
    integral: float
    reference: float
    linear: float
    quadratic: float


class EstimatorParameters(NamedTuple):
    """Of `pitchopt.control.estimator.WindEstimator`; cp (T, P) over tsr (T,) and pitch (P,)."""

    on: int
    gain: float
    inertia: float
    gear_ratio: float
    pressure_area: float
    radius: float
    lowest: float
    highest: float
    tsr: FloatArray
    pitch: FloatArray
    cp: FloatArray


class MinimumParameters(NamedTuple):
    """Of `pitchopt.control.minimum_pitch.MinimumPitchTable`, evenly spaced in wind speed."""

    on: int
    first: float
    spacing: float
    values: FloatArray


class IndividualParameters(NamedTuple):
    """Of `pitchopt.control.individual.IndividualPitch`, (H,) each.

    ``lead_cos`` and ``lead_sin`` are those of n times the azimuth offset.
    """

    on: int
    order: FloatArray
    gain: FloatArray
    lead_cos: FloatArray
    lead_sin: FloatArray
    limit: FloatArray
    fade_from: float
    fade_to: float
    fade_time: float


class FeedforwardParameters(NamedTuple):
    """Of `pitchopt.control.feedforward.PitchProfile`: cosine and sine parts (H,), n = 1 to H."""

    on: int
    cosine: FloatArray
    sine: FloatArray
    first: float
    second: float
    amplitude: int
    over_wind: int
    at: FloatArray
    scale: FloatArray


class LinearQuadraticParameters(NamedTuple):
    """Of `pitchopt.control.lqr.LinearQuadratic` over the wind speed (W,).

    ``gains`` is (W, 2, 6), of pitch and torque; ``reference`` (W, 4), rotor speed, tower-top
    displacement, pitch and torque.  ``keep`` is the share of the scheduling wind speed that a call
    leaves.
    """

    on: int
    keep: float
    wind: FloatArray
    gains: FloatArray
    reference: FloatArray
    torque_scale: float


class ControlParameters(NamedTuple):
    """All numbers of a `pitchopt.control.controller.TurbineController` for one step."""

    step: float
    keep: float
    torque: TorqueParameters
    range: RangeParameters
    pitch: PitchParameters
    linear_quadratic: LinearQuadraticParameters
    estimator: EstimatorParameters
    minimum: MinimumParameters
    individual: IndividualParameters
    feedforward: FeedforwardParameters


_NONE = np.zeros(0)

NO_PITCH = PitchParameters(0.0, 1.0, 1.0, 0.0, 0.0)
NO_LINEAR_QUADRATIC = LinearQuadraticParameters(
    0, 0.0, _NONE, np.zeros((0, 2, 6)), np.zeros((0, 4)), 1.0
)
NO_ESTIMATOR = EstimatorParameters(
    0, 0.0, 1.0, 1.0, 0.0, 1.0, 0.0, 0.0, _NONE, _NONE, np.zeros((0, 0))
)
NO_MINIMUM = MinimumParameters(0, 0.0, 1.0, _NONE)
NO_INDIVIDUAL = IndividualParameters(0, _NONE, _NONE, _NONE, _NONE, _NONE, 0.0, 0.0, 0.0)
NO_FEEDFORWARD = FeedforwardParameters(0, _NONE, _NONE, 0.0, 0.0, 0, 0, _NONE, _NONE)
