"""Steady operation: performance surfaces, operating points and their pitch sensitivities.

Power, thrust and their coefficients are means over the azimuth of the rotor in momentum
balance (`StaticRotor` with ``equilibrium``):

    C_p = torque omega / (1/2 rho pi R^2 U^3),     C_t = thrust / (1/2 rho pi R^2 U^2),

U the wind speed at the hub and R = hub radius + blade length.  Below rated power the rotor runs
at its optimal tip-speed ratio within its speed limits and at fine pitch; above it runs at rated
speed with the pitch that yields rated power.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from pitchopt.aero.rotor import Inflow, Rotor
from pitchopt.aero.static_rotor import StaticRotor
from pitchopt.checks import FloatArray, finite_array, finite_number
from pitchopt.errors import InputError

__all__ = [
    "OperatingPoints",
    "Surfaces",
    "UniformInflow",
    "mean_loads",
    "operating_points",
    "performance",
]

_PITCH_STEP = float(np.deg2rad(0.05))  # for central differences


@dataclass(frozen=True)
class UniformInflow:
    """The same horizontal wind everywhere, along x.

    Parameters
    ----------
    speed : float
        [m/s].
    """

    speed: float

    def velocity(self, x: ArrayLike, y: ArrayLike, z: ArrayLike, t: ArrayLike = 0.0) -> FloatArray:
        """Velocity (..., 3) [m/s]."""
        out = np.zeros((*np.broadcast_shapes(*(np.shape(a) for a in (x, y, z, t))), 3))
        out[..., 0] = self.speed
        return out


@dataclass(frozen=True, kw_only=True, eq=False)
class Surfaces:
    """Power and thrust coefficients over tip-speed ratio and pitch.

    Attributes
    ----------
    tip_speed_ratio : ndarray (S,)
    pitch : ndarray (P,)
        [rad].
    cp, ct : ndarray (S, P)
    """

    tip_speed_ratio: FloatArray
    pitch: FloatArray
    cp: FloatArray
    ct: FloatArray

    def best(self) -> tuple[float, float, float]:
        """Tip-speed ratio, pitch [rad] and C_p of the largest C_p on the grid."""
        i, j = np.unravel_index(int(np.argmax(self.cp)), self.cp.shape)
        return float(self.tip_speed_ratio[i]), float(self.pitch[j]), float(self.cp[i, j])


@dataclass(frozen=True, kw_only=True, eq=False)
class OperatingPoints:
    """Steady operation over wind speed, every array of shape (W,).

    Attributes
    ----------
    wind_speed : [m/s].
    rotor_speed : [rad/s].
    pitch : [rad].
    torque : [N m]; power : aerodynamic [W]; thrust : [N].
    cp, ct : power and thrust coefficient.
    power_sensitivity, thrust_sensitivity : dP/dbeta [W/rad] and dT/dbeta [N/rad] at constant
        rotor speed.
    """

    wind_speed: FloatArray
    rotor_speed: FloatArray
    pitch: FloatArray
    torque: FloatArray
    power: FloatArray
    thrust: FloatArray
    cp: FloatArray
    ct: FloatArray
    power_sensitivity: FloatArray
    thrust_sensitivity: FloatArray


def mean_loads(
    rotor: Rotor,
    inflow: Inflow,
    rotor_speed: float,
    pitch: ArrayLike,
    *,
    air_density: float = 1.225,
    yaw: float = 0.0,
    azimuths: int = 8,
    skew: bool = True,
) -> tuple[FloatArray, FloatArray]:
    """Mean torque [N m] and thrust [N] of the rotor at constant pitches (...) [rad].

    The mean is over `azimuths` evenly spaced blade azimuths; one is exact for uniform wind along
    the shaft, 8 suffice for shear and tilt, a tower shadow needs 36 and more.
    """
    if isinstance(azimuths, bool) or int(azimuths) != azimuths or azimuths < 1:
        raise InputError(f"azimuths: got {azimuths!r}, expected a whole number >= 1")
    model = StaticRotor(
        rotor=rotor,
        wind=inflow,
        rotor_speed=rotor_speed,
        air_density=air_density,
        yaw=yaw,
        induction="equilibrium",
        skew=skew,
    )
    beta = np.asarray(pitch, dtype=np.float64)
    psi = 2 * np.pi * np.arange(azimuths) / azimuths
    loads = model.blade_loads(psi, beta[..., None])
    torque = rotor.blades * loads.torque.mean(axis=-1)
    thrust = rotor.blades * loads.thrust.mean(axis=-1)
    return np.asarray(torque), np.asarray(thrust)


def performance(
    rotor: Rotor,
    tip_speed_ratio: ArrayLike,
    pitch: ArrayLike,
    *,
    wind_speed: float = 10.0,
    air_density: float = 1.225,
    azimuths: int = 8,
    inflow: Callable[[float], Inflow] = UniformInflow,
) -> Surfaces:
    """C_p and C_t over tip-speed ratios (S,) and pitches (P,) [rad].

    Parameters
    ----------
    rotor : Rotor
    tip_speed_ratio, pitch : array_like
        omega R / U and [rad].
    wind_speed : float
        U [m/s]; with polars that do not depend on Reynolds number the surfaces do not either.
    inflow : callable
        ``inflow(U)`` gives the wind field; uniform by default.
    """
    ratios = finite_array("tip_speed_ratio", tip_speed_ratio)
    angles = finite_array("pitch", pitch)
    if np.any(ratios <= 0.0):
        raise InputError(f"tip_speed_ratio: got {ratios.min()}, expected positive values")
    speed = finite_number("wind_speed", wind_speed, above=0.0)
    field = inflow(speed)
    pressure = 0.5 * air_density * np.pi * rotor.radius**2 * speed**2
    cp, ct = np.empty((2, ratios.size, angles.size))
    for i, ratio in enumerate(ratios):
        omega = float(ratio) * speed / rotor.radius
        torque, thrust = mean_loads(
            rotor, field, omega, angles, air_density=air_density, azimuths=azimuths
        )
        cp[i] = torque * omega / (pressure * speed)
        ct[i] = thrust / pressure
    return Surfaces(tip_speed_ratio=ratios, pitch=angles, cp=cp, ct=ct)


def operating_points(
    rotor: Rotor,
    wind_speed: ArrayLike,
    *,
    rated_power: float,
    optimal_tip_speed_ratio: float,
    rated_rotor_speed: float,
    min_rotor_speed: float = 0.0,
    fine_pitch: float = 0.0,
    max_pitch: float = float(np.deg2rad(35.0)),
    air_density: float = 1.225,
    azimuths: int = 8,
    inflow: Callable[[float], Inflow] = UniformInflow,
) -> OperatingPoints:
    """Steady operating points of a variable-speed, pitch-regulated turbine.

    Parameters
    ----------
    rotor : Rotor
    wind_speed : array_like (W,)
        Hub wind speeds [m/s].
    rated_power : float
        Largest aerodynamic power [W] (electrical rated power over the efficiency).
    optimal_tip_speed_ratio : float
    rated_rotor_speed, min_rotor_speed : float
        Limits of the rotor speed [rad/s].
    fine_pitch, max_pitch : float
        Pitch below rated power and the upper end of the search above it [rad].
    inflow : callable
        ``inflow(U)`` gives the wind field; uniform by default.

    Raises
    ------
    InputError
        If the limits cross, or rated power cannot be held below `max_pitch`.
    """
    speeds = finite_array("wind_speed", wind_speed)
    if np.any(speeds <= 0.0):
        raise InputError(f"wind_speed: got {speeds.min()} m/s, expected positive values")
    rated = finite_number("rated_power", rated_power, above=0.0)
    ratio = finite_number("optimal_tip_speed_ratio", optimal_tip_speed_ratio, above=0.0)
    slowest = finite_number("min_rotor_speed", min_rotor_speed, at_least=0.0)
    fastest = finite_number("rated_rotor_speed", rated_rotor_speed, above=slowest)
    fine = finite_number("fine_pitch", fine_pitch)
    feather = finite_number("max_pitch", max_pitch, above=fine)
    rows = []
    for speed in speeds:
        field = inflow(float(speed))
        omega = float(np.clip(ratio * speed / rotor.radius, slowest, fastest))

        def loads(
            pitch: ArrayLike, field: Inflow = field, omega: float = omega
        ) -> tuple[FloatArray, FloatArray]:
            return mean_loads(
                rotor, field, omega, pitch, air_density=air_density, azimuths=azimuths
            )

        pitch = fine
        if float(loads(fine)[0]) * omega > rated:
            pitch = _pitch_for_torque(
                lambda b: np.asarray(loads(b)[0]), rated / omega, fine, feather, float(speed)
            )
        sides = np.array([pitch - _PITCH_STEP, pitch, pitch + _PITCH_STEP])
        torque, thrust = loads(sides)
        pressure = 0.5 * air_density * np.pi * rotor.radius**2 * speed**2
        rows.append(
            (
                omega,
                pitch,
                torque[1],
                torque[1] * omega,
                thrust[1],
                torque[1] * omega / (pressure * speed),
                thrust[1] / pressure,
                (torque[2] - torque[0]) * omega / (2 * _PITCH_STEP),
                (thrust[2] - thrust[0]) / (2 * _PITCH_STEP),
            )
        )
    table = np.array(rows).T
    names = (
        "rotor_speed",
        "pitch",
        "torque",
        "power",
        "thrust",
        "cp",
        "ct",
        "power_sensitivity",
        "thrust_sensitivity",
    )
    return OperatingPoints(wind_speed=speeds, **dict(zip(names, table, strict=True)))


def _pitch_for_torque(
    torque: Callable[[FloatArray], FloatArray],
    target: float,
    fine: float,
    feather: float,
    speed: float,
) -> float:
    """Smallest pitch above `fine` at which the torque has fallen to `target`."""
    from scipy.optimize import brentq  # heavy import, only needed here

    grid = np.linspace(fine, feather, 24)
    over = torque(grid) - target
    below = np.flatnonzero(over <= 0.0)
    if below.size == 0:
        raise InputError(
            f"max_pitch: at {speed:g} m/s rated power is exceeded up to "
            f"{np.rad2deg(feather):.1f} deg; raise max_pitch or rated_power"
        )
    k = int(below[0])
    return float(
        brentq(lambda b: float(torque(np.asarray(b)) - target), grid[k - 1], grid[k], xtol=1e-9)
    )
