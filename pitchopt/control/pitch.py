"""Collective pitch: PI regulator of the generator speed with gain scheduling.

    beta = GK(beta) (K_P e + K_I int e dt),    e = filtered generator speed - reference.

Rigid drivetrain about the rated rotor speed Omega, with J on the low-speed side, gear ratio G and
constant generator torque; the aerodynamic torque varies with the pitch by (dP/dbeta)/Omega and
its change with the rotor speed is left out:

    J dOmega/dt = (dP/dbeta) beta / Omega,

so that phi = int e dt obeys, with the sensitivity of its own pitch in the gains,

    J phi'' + G (-dP/dbeta)/Omega K_P phi' + G (-dP/dbeta)/Omega K_I phi = 0

and a regulator mode (omega_reg, zeta_reg) asks for

    K_P = 2 J Omega omega_reg zeta_reg / (G (-dP/dbeta)),
    K_I = J Omega omega_reg^2 / (G (-dP/dbeta)).

The paper writes them with the generator speed omega_rat = G Omega and G^2, which is the same.
A generator that holds constant power takes off P0/Omega^2 of damping; with
``constant_power`` the gain K_P adds it back, scaled as the sensitivity is:
2 J omega_reg zeta_reg + P0/Omega^2.

The sensitivity is fitted over pitch, S(beta) = S(0) (1 + linear beta + quadratic beta^2), and
GK = 1/(1 + linear beta + quadratic beta^2).  In the linear fit of the report 1/linear is the
pitch at which the sensitivity has doubled.

Sources: D. Zalkind, E. Dall'Anese, L. Pao, "Automatic controller tuning using a zeroth-order
optimization algorithm", 2020, appendix A; NREL/TP-500-38060, section 7.2.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from pitchopt.checks import FloatArray, finite_array, finite_number
from pitchopt.control.parameters import PitchParameters, RangeParameters
from pitchopt.errors import InputError

__all__ = ["PitchRange", "PitchRegulator", "fit_sensitivity"]

_LEAST_SHARE = 0.2  # of the sensitivity at the lowest operating pitch that is left at zero pitch


@dataclass(frozen=True, kw_only=True)
class PitchRange:
    """Limits that every pitch command keeps.

    Parameters
    ----------
    lowest, highest : float
        Of the collective command [rad].
    rate : float
        Largest rate of the collective command and of each blade's [rad/s].
    blade_lowest, blade_highest : float, optional
        Of each blade's command, with the individual parts [rad]; those of the collective
        command without them.

    Raises
    ------
    InputError
        If the range is empty or the collective range is not within the blades'.
    """

    lowest: float
    highest: float
    rate: float
    blade_lowest: float | None = None
    blade_highest: float | None = None

    def __post_init__(self) -> None:
        finite_number("lowest", self.lowest)
        finite_number("highest", self.highest, above=self.lowest)
        finite_number("rate", self.rate, above=0.0)
        if self.blade_lowest is not None:
            finite_number("blade_lowest", self.blade_lowest, at_most=self.lowest)
        if self.blade_highest is not None:
            finite_number("blade_highest", self.blade_highest, at_least=self.highest)

    def parameters(self) -> RangeParameters:
        """Numbers for the compiled controller."""
        return RangeParameters(
            lowest=float(self.lowest),
            highest=float(self.highest),
            rate=float(self.rate),
            blade_lowest=float(self.lowest if self.blade_lowest is None else self.blade_lowest),
            blade_highest=float(self.highest if self.blade_highest is None else self.blade_highest),
        )


def fit_sensitivity(
    pitch: ArrayLike, sensitivity: ArrayLike, *, degree: int = 1
) -> tuple[float, float, float]:
    """Least-squares fit S(0) (1 + linear beta + quadratic beta^2) of a sensitivity.

    Parameters
    ----------
    pitch : array_like (W,)
        Operating pitch [rad].
    sensitivity : array_like (W,)
        dP/dbeta there at the rated rotor speed, negative [W/rad].
    degree : {1, 2}
        1 as in the report and the paper, 2 with the quadratic term.

    Returns
    -------
    at_zero : float
        S(0) [W/rad].
    linear : float
        [1/rad].
    quadratic : float
        [1/rad^2], 0 for degree 1.

    Raises
    ------
    InputError
        If there are too few points, the fit is not negative at every point and at zero pitch, or
        it has at zero pitch less than a fifth of what it has at the lowest pitch.

    Notes
    -----
    The report differentiates with the induced velocities held (frozen wake), which is what a
    rotor does within the seconds of the regulator.  With the wake in equilibrium the sensitivity
    tends to nothing towards the pitch of largest power, and a straight line through such
    values gives gains at low pitch that are many times too large.
    """
    if degree not in (1, 2):
        raise InputError(f"degree: got {degree!r}, expected 1 or 2")
    pitch = finite_array("pitch", pitch)
    sensitivity = finite_array("sensitivity", sensitivity, shape=pitch.shape)
    if np.unique(pitch).size <= degree:
        raise InputError(
            f"pitch: got {np.unique(pitch).size} different angles, expected at least {degree + 1} "
            f"for a fit of degree {degree}"
        )
    fit = np.polynomial.Polynomial.fit(pitch, sensitivity, degree)
    coefficients = np.zeros(3)
    coefficients[: degree + 1] = fit.convert().coef
    at_zero, at_first = float(coefficients[0]), float(fit(np.min(pitch)))
    if max(at_zero, float(np.max(fit(pitch)))) >= 0.0:
        raise InputError(
            "sensitivity: its fit over pitch is not negative throughout, so that more pitch does "
            "not mean less power; expected operating points above rated wind speed"
        )
    if at_zero > _LEAST_SHARE * at_first:
        raise InputError(
            f"sensitivity: its fit goes from {at_first:.3g} W/rad at the lowest pitch to "
            f"{at_zero:.3g} W/rad at zero pitch, and the gains there would be "
            f"{at_first / at_zero:.3g} times as large; expected sensitivities with the wake held, "
            "or degree 2"
        )
    return at_zero, float(coefficients[1]) / at_zero, float(coefficients[2]) / at_zero


@dataclass(frozen=True, kw_only=True)
class PitchRegulator:
    """Gains at zero pitch, their schedule and the speed to hold.

    Parameters
    ----------
    proportional : float
        K_P at zero pitch, of the generator speed [s].
    integral : float
        K_I at zero pitch [-].
    reference_speed : float
        Of the generator [rad/s].
    linear : float
        Of the gain schedule [1/rad].
    quadratic : float, optional
        [1/rad^2].

    Raises
    ------
    InputError
        If a number is out of range.
    """

    proportional: float
    integral: float
    reference_speed: float
    linear: float
    quadratic: float = 0.0

    def __post_init__(self) -> None:
        finite_number("proportional", self.proportional, at_least=0.0)
        finite_number("integral", self.integral, above=0.0)
        finite_number("reference_speed", self.reference_speed, above=0.0)
        finite_number("linear", self.linear)
        finite_number("quadratic", self.quadratic)

    @classmethod
    def tuned(
        cls,
        *,
        frequency: float,
        damping: float,
        pitch: ArrayLike,
        sensitivity: ArrayLike,
        rotor_speed: float,
        inertia: float,
        gear_ratio: float,
        degree: int = 1,
        constant_power: float = 0.0,
    ) -> PitchRegulator:
        """Regulator with the mode asked for.

        Parameters
        ----------
        frequency : float
            omega_reg [rad/s].
        damping : float
            zeta_reg [-].
        pitch, sensitivity : array_like (W,)
            Operating pitch [rad] and dP/dbeta at the rated rotor speed [W/rad].
        rotor_speed : float
            Rated [rad/s].
        inertia : float
            Rotor and generator about the low-speed shaft [kg m^2].
        gear_ratio : float
            [-].
        degree : {1, 2}
            Of the fit of the sensitivity.
        constant_power : float, optional
            Power P0 that the generator holds whatever its speed, to make up for the damping it
            takes off [W]; 0 for constant torque, or to leave it out as the report does.
        """
        frequency = finite_number("frequency", frequency, above=0.0)
        damping = finite_number("damping", damping, above=0.0)
        rotor_speed = finite_number("rotor_speed", rotor_speed, above=0.0)
        inertia = finite_number("inertia", inertia, above=0.0)
        gear_ratio = finite_number("gear_ratio", gear_ratio, above=0.0)
        power = finite_number("constant_power", constant_power, at_least=0.0)
        at_zero, linear, quadratic = fit_sensitivity(pitch, sensitivity, degree=degree)
        scale = rotor_speed / (gear_ratio * -at_zero)
        needed = 2.0 * inertia * frequency * damping + power / rotor_speed**2
        return cls(
            proportional=scale * needed,
            integral=scale * inertia * frequency**2,
            reference_speed=gear_ratio * rotor_speed,
            linear=linear,
            quadratic=quadratic,
        )

    def gain_factor(self, pitch: ArrayLike) -> FloatArray:
        """GK at a collective pitch [rad], same shape."""
        beta = np.asarray(pitch, dtype=np.float64)
        return 1.0 / (1.0 + self.linear * beta + self.quadratic * beta * beta)

    def gains(self, pitch: ArrayLike) -> tuple[FloatArray, FloatArray]:
        """K_P [s] and K_I [-] at a collective pitch [rad]."""
        factor = self.gain_factor(pitch)
        return self.proportional * factor, self.integral * factor

    def parameters(self, pitch_range: PitchRange) -> PitchParameters:
        """Numbers for the compiled regulator.

        Raises
        ------
        InputError
            If the gains change sign within the range of pitch.
        """
        candidates = [pitch_range.lowest, pitch_range.highest]
        if self.quadratic != 0.0:
            vertex = -self.linear / (2.0 * self.quadratic)
            candidates.append(min(max(vertex, pitch_range.lowest), pitch_range.highest))
        for beta in candidates:
            if 1.0 + self.linear * beta + self.quadratic * beta * beta <= 0.0:
                raise InputError(
                    f"linear: got {self.linear} 1/rad with quadratic {self.quadratic} 1/rad^2, "
                    f"whose sensitivity has changed sign at a pitch of {math.degrees(beta):.3g} "
                    "deg; expected a schedule that is positive over the range of pitch"
                )
        return PitchParameters(
            proportional=float(self.proportional),
            integral=float(self.integral),
            reference=float(self.reference_speed),
            linear=float(self.linear),
            quadratic=float(self.quadratic),
        )
