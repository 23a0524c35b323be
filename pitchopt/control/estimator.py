"""Rotor-effective wind speed from rotor speed, pitch and generator torque.

The rotor as a rigid body under an aerodynamic torque from a table of power coefficients,

    J domega/dt = T(omega, beta, V) - G T_g,
    T = 1/2 rho pi R^2 C_P(omega R / V, beta) V^3 / omega,

and an estimator by immersion and invariance,

    V_hat = V_I + gamma omega,    dV_I/dt = -gamma/J [T(omega, beta, V_hat) - G T_g],

so that dV_hat/dt = gamma/J [T(omega, beta, V) - T(omega, beta, V_hat)]: where the torque grows
with the wind speed the estimate runs to the true one with the bandwidth (gamma/J) dT/dV, and in a
steady state it is exact.  Between two calls the step is

    V_hat += gamma [omega - last omega - step/J (T - G T_g)],

kept within the range of wind speeds.  It starts where the first measurement would be steady.

Source: R. Ortega, F. Mancilla-David, F. Jaramillo, "A globally convergent wind speed estimator
for wind turbine systems", Int. J. Adapt. Control Signal Process. 27, 2013.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from pitchopt.checks import FloatArray, finite_array, finite_number
from pitchopt.control.parameters import EstimatorParameters, table
from pitchopt.errors import InputError

__all__ = ["WindEstimator"]

_WIND_STEP = 0.01  # for a central difference [m/s]


@dataclass(frozen=True, kw_only=True, eq=False)
class WindEstimator:
    """Estimator of the wind speed that the whole rotor feels.

    Parameters
    ----------
    tsr : array_like (T,)
        Tip-speed ratios, ascending [-].
    pitch : array_like (P,)
        Ascending [rad].
    power_coefficient : array_like (T, P)
        C_P [-], interpolated linearly.
    radius : float
        Of the tip-speed ratio and of the swept area [m].
    air_density : float
        [kg/m^3].
    inertia : float
        Rotor and generator about the low-speed shaft [kg m^2].
    gear_ratio : float
        [-].
    gain : float
        gamma [m/s per rad/s]; `tuned` finds it from a bandwidth.
    lowest, highest : float, optional
        Range of the estimate [m/s].

    Raises
    ------
    InputError
        If a number or a table is out of range.
    """

    tsr: FloatArray
    pitch: FloatArray
    power_coefficient: FloatArray
    radius: float
    air_density: float
    inertia: float
    gear_ratio: float
    gain: float
    lowest: float = 2.0
    highest: float = 50.0

    def __post_init__(self) -> None:
        for name in ("tsr", "pitch"):
            axis = finite_array(name, getattr(self, name))
            if axis.size < 2 or np.any(np.diff(axis) <= 0.0):
                raise InputError(f"{name}: got {axis.size} values, expected two or more, ascending")
            object.__setattr__(self, name, axis)
        if self.tsr[0] < 0.0:
            raise InputError(f"tsr: got {self.tsr[0]}, expected no negative tip-speed ratio")
        shape = (self.tsr.size, self.pitch.size)
        cp = finite_array("power_coefficient", self.power_coefficient, shape=shape)
        object.__setattr__(self, "power_coefficient", cp)
        for name in ("radius", "air_density", "inertia", "gear_ratio", "gain"):
            finite_number(name, getattr(self, name), above=0.0)
        finite_number("lowest", self.lowest, above=0.0)
        finite_number("highest", self.highest, above=self.lowest)

    @classmethod
    def tuned(
        cls,
        *,
        bandwidth: float,
        wind_speed: float,
        rotor_speed: float,
        at_pitch: float,
        tsr: ArrayLike,
        pitch: ArrayLike,
        power_coefficient: ArrayLike,
        radius: float,
        air_density: float,
        inertia: float,
        gear_ratio: float,
        lowest: float = 2.0,
        highest: float = 50.0,
    ) -> WindEstimator:
        """Estimator with a bandwidth [rad/s] at one operating point.

        Parameters
        ----------
        bandwidth : float
            (gamma/J) dT/dV [rad/s] at the operating point.
        wind_speed, rotor_speed, at_pitch : float
            The operating point [m/s], [rad/s], [rad].
        tsr, pitch, power_coefficient, radius, air_density, inertia, gear_ratio, lowest, highest
            As in the class.

        Raises
        ------
        InputError
            If the torque does not grow with the wind speed there.
        """
        bandwidth = finite_number("bandwidth", bandwidth, above=0.0)
        wind_speed = finite_number("wind_speed", wind_speed, above=2.0 * _WIND_STEP)
        one = cls(
            tsr=np.asarray(tsr),
            pitch=np.asarray(pitch),
            power_coefficient=np.asarray(power_coefficient),
            radius=radius,
            air_density=air_density,
            inertia=inertia,
            gear_ratio=gear_ratio,
            gain=1.0,
            lowest=lowest,
            highest=highest,
        )
        slope = one.torque(rotor_speed, at_pitch, wind_speed + _WIND_STEP)
        slope -= one.torque(rotor_speed, at_pitch, wind_speed - _WIND_STEP)
        slope /= 2.0 * _WIND_STEP
        if slope <= 0.0:
            raise InputError(
                f"wind_speed: at {wind_speed} m/s, {rotor_speed} rad/s and a pitch of "
                f"{math.degrees(at_pitch):.3g} deg the torque does not grow with the wind speed; "
                "expected an operating point away from stall"
            )
        return cls(
            **{name: getattr(one, name) for name in cls.__dataclass_fields__ if name != "gain"},
            gain=bandwidth * one.inertia / slope,
        )

    def torque(self, rotor_speed: float, pitch: float, wind_speed: float) -> float:
        """Aerodynamic torque T [N m] of the table."""
        from pitchopt.control.part_kernels import aerodynamic_torque

        omega = finite_number("rotor_speed", rotor_speed, above=0.0)
        wind = finite_number("wind_speed", wind_speed, above=0.0)
        return float(
            aerodynamic_torque(self.parameters(), omega, finite_number("pitch", pitch), wind)
        )

    def parameters(self) -> EstimatorParameters:
        """Numbers for the compiled estimator."""
        return EstimatorParameters(
            on=1,
            gain=float(self.gain),
            inertia=float(self.inertia),
            gear_ratio=float(self.gear_ratio),
            pressure_area=0.5 * self.air_density * math.pi * self.radius**2,
            radius=float(self.radius),
            lowest=float(self.lowest),
            highest=float(self.highest),
            tsr=table(self.tsr),
            pitch=table(self.pitch),
            cp=table(self.power_coefficient),
        )
