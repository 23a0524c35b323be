"""A made-up rotor and the vectors of signals that the control tests share."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
from numpy.typing import ArrayLike, NDArray

from pitchopt.control import (
    IndividualPitch,
    MinimumPitchTable,
    PitchProfile,
    PitchRange,
    TurbineController,
    WindEstimator,
    nrel_5mw_baseline,
)
from pitchopt.control import signals as s
from pitchopt.control.part_kernels import aerodynamic_torque

FloatArray = NDArray[np.float64]

RADIUS = 63.0
DENSITY = 1.225
GEAR = 97.0
INERTIA = 43784725.0
RATED_SPEED = 1.2671  # rotor [rad/s]
TSR = np.linspace(1.0, 14.0, 105)
PITCH = np.radians(np.linspace(0.0, 30.0, 61))


def power_coefficient(tsr: ArrayLike, pitch: ArrayLike) -> FloatArray:
    """Heier's formula for the power coefficient of a modern rotor, pitch in radians."""
    ratio, degrees = np.asarray(tsr, float), np.degrees(np.asarray(pitch, float))
    inverse = 1.0 / (ratio + 0.08 * degrees) - 0.035 / (degrees**3 + 1.0)
    return np.asarray(
        0.5176 * (116.0 * inverse - 0.4 * degrees - 5.0) * np.exp(-21.0 * inverse) + 0.0068 * ratio
    )


def torque(omega: float, pitch: float, wind: float) -> float:
    """Aerodynamic torque [N m] of the made-up rotor, straight from the formula."""
    cp = float(power_coefficient(omega * RADIUS / wind, pitch))
    return 0.5 * DENSITY * np.pi * RADIUS**2 * cp * wind**3 / omega


def table_estimator(bandwidth: float = 0.5, **changes: float) -> WindEstimator:
    """Estimator that knows the rotor by a table, tuned at 11 m/s."""
    estimator = WindEstimator.tuned(
        bandwidth=bandwidth,
        wind_speed=11.0,
        rotor_speed=1.2,
        at_pitch=0.0,
        tsr=TSR,
        pitch=PITCH,
        power_coefficient=power_coefficient(TSR[:, None], PITCH),
        radius=RADIUS,
        air_density=DENSITY,
        inertia=INERTIA,
        gear_ratio=GEAR,
    )
    return replace(estimator, **changes) if changes else estimator


def torque_of(estimator: WindEstimator) -> Callable[[float, float, float], float]:
    """Torque [N m] of a rotor that is just as the estimator's table says."""
    p = estimator.parameters()
    return lambda omega, pitch, wind: float(aerodynamic_torque(p, omega, pitch, wind))


def measured(
    *,
    rotor_speed: float = RATED_SPEED,
    azimuth: float = 0.0,
    pitch: ArrayLike = 0.1,
    out_of_plane: ArrayLike = 0.0,
    generator_torque: float = 43000.0,
    **others: float,
) -> FloatArray:
    """Signals of a turbine with a rigid drivetrain."""
    out = np.zeros(s.MEASURED)
    out[s.ROTOR_SPEED] = rotor_speed
    out[s.GENERATOR_SPEED] = GEAR * rotor_speed
    out[s.AZIMUTH] = azimuth
    out[s.PITCH : s.PITCH + 3] = pitch
    out[s.OUT_OF_PLANE : s.OUT_OF_PLANE + 3] = out_of_plane
    out[s.GENERATOR_TORQUE] = generator_torque
    for name, value in others.items():
        out[getattr(s, name.upper())] = value
    return out


def pitches(command: FloatArray) -> FloatArray:
    """Pitch commands of the three blades."""
    return command[s.PITCH_COMMAND :]


def wide(controller: TurbineController) -> TurbineController:
    """The controller whose blades may move freely."""
    free = PitchRange(
        lowest=0.0,
        highest=np.radians(90.0),
        rate=1e3,
        blade_lowest=-np.radians(60.0),
        blade_highest=np.radians(150.0),
    )
    return replace(controller, pitch_range=free)


def full_controller() -> TurbineController:
    """A controller with every part but the linear quadratic regulator."""
    return replace(
        nrel_5mw_baseline(),
        pitch_range=PitchRange(
            lowest=0.0,
            highest=np.radians(90.0),
            rate=np.radians(8.0),
            blade_lowest=-np.radians(5.0),
        ),
        estimator=table_estimator(),
        minimum_pitch=MinimumPitchTable(
            wind_speed=[5.0, 11.0, 14.0, 24.0], pitch=np.radians([0.0, 3.0, 5.0, 8.0])
        ),
        individual=IndividualPitch(gain=[2e-9, 1e-9], offset=[0.3, 0.4], fade_time=5.0),
        feedforward=PitchProfile.from_samples(
            0.02 * np.cos(np.arange(24) * np.pi / 12) ** 3,
            time_constant=0.3,
            schedule_at=[5.0, 15.0],
            schedule=[0.2, 1.0],
            over_wind=True,
        ),
    )


def run_rotor(
    controller: TurbineController,
    wind: Callable[[float], float],
    *,
    duration: float,
    step: float = 0.02,
    rotor_speed: float = RATED_SPEED,
    pitch: float = 0.1,
    generator_torque: float = 43000.0,
    true_torque: Callable[[float, float, float], float] = torque,
) -> dict[str, FloatArray]:
    """Closed loop of a rigid rotor and a controller; the actuators follow at once."""
    omega, beta, held = rotor_speed, pitch, generator_torque
    now = measured(rotor_speed=omega, pitch=beta, generator_torque=held)
    controller.start(step, now)
    rows = []
    for k in range(round(duration / step)):
        v = wind(k * step)
        now = measured(rotor_speed=omega, pitch=beta, generator_torque=held)
        command = controller.command(now)
        rows.append((k * step, omega, beta, held, v, controller.wind_speed))
        beta, held = float(np.mean(pitches(command))), float(command[s.TORQUE])
        # Runge and Kutta's midpoint rule
        middle = omega + 0.5 * step / INERTIA * (true_torque(omega, beta, v) - GEAR * held)
        omega += step / INERTIA * (true_torque(middle, beta, v) - GEAR * held)
    columns = np.array(rows).T
    names = ("time", "rotor_speed", "pitch", "generator_torque", "wind", "estimate")
    return dict(zip(names, columns, strict=True))
