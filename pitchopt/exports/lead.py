"""The command that makes an actuator with a lag move its blade as a profile says.

At constant rotor speed omega harmonic n of the pitch turns at n omega, where an actuator answers
a command with 1/A(i n omega).  The command therefore carries A (phase lead and amplitude), or
A/|A| (phase lead alone):

    A(s) = 1 + tau s                                    first order,
    A(s) = 1 + 2 zeta s/omega_a + (s/omega_a)^2         second order.

The mean passes an actuator as it is.  A grows with n: what a profile has in high harmonics makes
a led command fast, so the harmonics that are kept matter, and :func:`harmonics_within` says how
many a rate and a range let through.

The sum over harmonics is that of the feed-forward of `pitchopt.control.feedforward`, called at
as many azimuths as determine the series; nothing of it is written here a second time.  What
prescribes the motion itself, as the AeroDyn driver does, needs no lead.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from pitchopt.checks import finite_number, whole_number
from pitchopt.control import PitchProfile, signals
from pitchopt.errors import InputError
from pitchopt.exports.harmonics import Harmonics, harmonics

__all__ = ["ActuatorLag", "fastest", "harmonics_within", "led_command", "truncated"]


_POINTS = 64  # that the highest harmonic's turn is looked at


@dataclass(frozen=True, kw_only=True)
class ActuatorLag:
    """Actuator that a command makes up for.

    Parameters
    ----------
    time_constant : float, optional
        tau of a first-order actuator [s].
    frequency, damping : float, optional
        omega_a [rad/s] and zeta [-] of a second-order actuator.
    amplitude : bool, optional
        Make up for the amplitude as well as for the phase.

    Raises
    ------
    InputError
        If neither or both kinds are given, or a number is out of range.
    """

    time_constant: float | None = None
    frequency: float | None = None
    damping: float | None = None
    amplitude: bool = True

    def __post_init__(self) -> None:
        if (self.frequency is None) != (self.damping is None):
            raise InputError(
                f"frequency, damping: got {self.frequency} and {self.damping}, expected both or "
                "neither"
            )
        if (self.time_constant is None) == (self.frequency is None):
            raise InputError(
                f"time_constant: got {self.time_constant} with frequency {self.frequency}, "
                "expected an actuator of first order or one of second order"
            )
        if self.time_constant is not None:
            finite_number("time_constant", self.time_constant, above=0.0)
        if self.frequency is not None and self.damping is not None:
            finite_number("frequency", self.frequency, above=0.0)
            finite_number("damping", self.damping, above=0.0)

    @property
    def order(self) -> int:
        """1 or 2."""
        return 2 if self.time_constant is None else 1

    def answer(self, rate: ArrayLike) -> np.ndarray:
        """1/A at angular rates [rad/s], complex: what becomes of a sine of the command."""
        s = 1j * np.asarray(rate, dtype=np.float64)
        if self.time_constant is not None:
            return np.asarray(1.0 / (1.0 + self.time_constant * s))
        assert self.frequency is not None  # as __post_init__ saw
        assert self.damping is not None
        part = s / self.frequency
        return np.asarray(1.0 / (1.0 + 2.0 * self.damping * part + part * part))


def truncated(series: Harmonics, kept: int | None) -> Harmonics:
    """Mean and the first `kept` harmonics; all of them with None.

    Raises
    ------
    InputError
        If the series has fewer.
    """
    if kept is None:
        return series
    count = whole_number("keep_harmonics", kept, at_least=1)
    if count >= series.cosine.size:
        raise InputError(
            f"keep_harmonics: got {count}, expected at most {series.cosine.size - 1}, which the "
            "profile has"
        )
    return Harmonics(cosine=series.cosine[: count + 1], sine=series.sine[: count + 1])


def led_command(series: Harmonics, lag: ActuatorLag, rotor_speed: float) -> Harmonics:
    """Command of a blade at constant rotor speed whose actuator then follows `series`.

    Parameters
    ----------
    series : Harmonics
        Pitch that the blade should have [rad].
    lag : ActuatorLag
    rotor_speed : float
        omega [rad/s], positive.
    """
    from pitchopt.control.parameters import MEMORY_SIZE
    from pitchopt.control.part_kernels import profile_deviation

    omega = finite_number("rotor_speed", rotor_speed, above=0.0)
    top = series.cosine.size - 1
    if top == 0:
        return series
    parameters = PitchProfile(
        cosine=series.cosine[1:],
        sine=series.sine[1:],
        time_constant=0.0 if lag.time_constant is None else lag.time_constant,
        frequency=lag.frequency,
        damping=lag.damping,
        amplitude=lag.amplitude,
    ).parameters()
    azimuth = math.pi / (top + 1) * np.arange(2 * (top + 1))
    memory, measured = np.zeros(MEMORY_SIZE), np.zeros(signals.MEASURED)
    measured[signals.ROTOR_SPEED] = omega
    deviation = np.empty_like(azimuth)
    for k, psi in enumerate(azimuth):
        measured[signals.AZIMUTH] = psi
        command = np.zeros(signals.COMMANDS)
        profile_deviation(parameters, memory, measured, 0.0, command)
        deviation[k] = command[signals.PITCH_COMMAND]
    led = harmonics(azimuth, deviation)
    cosine, sine = np.array(led.cosine[: top + 1]), np.array(led.sine[: top + 1])
    cosine[0], sine[0] = series.mean, 0.0
    return Harmonics(cosine=cosine, sine=sine)


def fastest(series: Harmonics, rotor_speed: float) -> tuple[float, float, float]:
    """Bounds of rate [rad/s], from below and from above of pitch [rad], at most 0.2 % too wide.

    A trigonometric polynomial of degree M sampled at spacing h is nowhere larger than
    1/cos(M h/2) times its largest sample (Ehlich and Zeller, 1964).
    """
    count = _POINTS * max(series.cosine.size, 8)
    psi = 2.0 * np.pi / count * np.arange(count)
    beyond = 1.0 / math.cos(math.pi / _POINTS)
    away = series(psi) - series.mean
    middle, half = 0.5 * (away.max() + away.min()), 0.5 * float(np.ptp(away))
    centre = series.mean + float(middle)
    speed = float(np.abs(series(psi, 1)).max()) * rotor_speed
    return speed * beyond, centre - half * beyond, centre + half * beyond


def harmonics_within(
    series: Harmonics,
    lag: ActuatorLag,
    rotor_speed: float,
    *,
    rate: float,
    lowest: float = -np.inf,
    highest: float = np.inf,
) -> int:
    """Largest number of first harmonics whose led command keeps a rate and a range; 0 for none."""
    for count in range(series.cosine.size - 1, 0, -1):
        led = led_command(truncated(series, count), lag, rotor_speed)
        speed, low, high = fastest(led, rotor_speed)
        if speed <= rate and low >= lowest and high <= highest:
            return count
    return 0
