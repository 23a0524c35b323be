"""A pitch profile beta(psi) as a feed-forward, with the lead that the actuator needs.

The deviations from the mean of the (N,) pitch angles at evenly spaced azimuths, one profile for
all blades, are written in harmonics,

    deviation(psi) = sum_n c_n cos(n psi) + s_n sin(n psi),    n = 1 ... H,

and every blade's command gets the sum at its own azimuth.  An actuator answers an harmonic at
n times the rotor speed omega with 1/A(i n omega), where

    A = 1 + i n omega tau                                       first order,
    A = 1 - (n omega/omega_a)^2 + 2 i zeta_a n omega/omega_a    second order,

so the command carries A, and the blade then moves as the profile says; or, without the
correction of the amplitude, A/|A|, the phase lead alone.  The rotor speed is the measured one.
A scale over the collective pitch or the estimated wind speed can fade the profile.

The mean of the profile is left to the collective pitch.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from pitchopt.checks import FloatArray, finite_array, finite_number, whole_number
from pitchopt.control.parameters import FeedforwardParameters, table
from pitchopt.errors import InputError

__all__ = ["PitchProfile"]


@dataclass(frozen=True, kw_only=True, eq=False)
class PitchProfile:
    """Harmonics of a profile and how they are played.

    Parameters
    ----------
    cosine, sine : array_like (H,)
        c_n and s_n, n = 1 ... H [rad].
    time_constant : float, optional
        tau of actuators of first order [s].
    frequency, damping : float, optional
        omega_a [rad/s] and zeta_a [-] of actuators of second order.
    amplitude : bool, optional
        Correct the amplitude as well as the phase.
    schedule_at, schedule : array_like (S,), optional
        Scale of the profile [-] over the collective pitch [rad], or over the estimated wind
        speed [m/s], ascending, held beyond the ends; 1 everywhere without.
    over_wind : bool, optional
        What ``schedule_at`` is.

    Raises
    ------
    InputError
        If a number is out of range, or both kinds of actuators or half of one are given.
    """

    cosine: FloatArray
    sine: FloatArray
    time_constant: float = 0.0
    frequency: float | None = None
    damping: float | None = None
    amplitude: bool = True
    schedule_at: ArrayLike = (0.0,)
    schedule: ArrayLike = (1.0,)
    over_wind: bool = False

    def __post_init__(self) -> None:
        cosine = finite_array("cosine", self.cosine)
        object.__setattr__(self, "cosine", cosine)
        object.__setattr__(self, "sine", finite_array("sine", self.sine, shape=cosine.shape))
        at = finite_array("schedule_at", self.schedule_at)
        if np.any(np.diff(at) <= 0.0):
            raise InputError("schedule_at: expected ascending values, got some that do not ascend")
        object.__setattr__(self, "schedule_at", at)
        object.__setattr__(
            self, "schedule", finite_array("schedule", self.schedule, shape=at.shape)
        )
        finite_number("time_constant", self.time_constant, at_least=0.0)
        if (self.frequency is None) != (self.damping is None):
            raise InputError(
                f"frequency, damping: got {self.frequency} and {self.damping}, expected both or "
                "neither"
            )
        if self.frequency is not None and self.damping is not None:
            finite_number("frequency", self.frequency, above=0.0)
            finite_number("damping", self.damping, above=0.0)
            if self.time_constant != 0.0:
                raise InputError(
                    "time_constant: got one beside frequency and damping, expected actuators of "
                    "first or of second order"
                )

    @classmethod
    def from_samples(
        cls,
        profile: ArrayLike,
        *,
        harmonics: int | None = None,
        time_constant: float = 0.0,
        frequency: float | None = None,
        damping: float | None = None,
        amplitude: bool = True,
        schedule_at: ArrayLike = (0.0,),
        schedule: ArrayLike = (1.0,),
        over_wind: bool = False,
    ) -> PitchProfile:
        """Profile from pitch angles (N,) [rad] at azimuths 2 pi j / N.

        Parameters
        ----------
        profile : array_like (N,)
            [rad]; its mean is dropped.
        harmonics : int, optional
            How many are kept; without, all that N angles have, and the sum then passes through
            every one of them.
        time_constant, frequency, damping, amplitude, schedule_at, schedule, over_wind
            As in the class.

        Raises
        ------
        InputError
            If there are fewer than three angles or more harmonics are asked for than they have.
        """
        samples = finite_array("profile", profile)
        count = samples.size
        if count < 3:
            raise InputError(f"profile: got {count} angles, expected three or more")
        kept = count // 2
        if harmonics is not None:
            kept = whole_number("harmonics", harmonics, at_least=1)
            if kept > count // 2:
                raise InputError(
                    f"harmonics: got {kept}, expected at most {count // 2} for {count} angles"
                )
        parts = np.fft.rfft(samples)[1 : kept + 1] * (2.0 / count)
        if count % 2 == 0 and kept == count // 2:
            parts[-1] *= 0.5
        return cls(
            cosine=parts.real,
            sine=-parts.imag,
            time_constant=time_constant,
            frequency=frequency,
            damping=damping,
            amplitude=amplitude,
            schedule_at=schedule_at,
            schedule=schedule,
            over_wind=over_wind,
        )

    def deviation(self, azimuth: ArrayLike) -> FloatArray:
        """Pitch that the blade should have beside the collective [rad], shape of `azimuth`."""
        angle = np.asarray(azimuth, dtype=np.float64)[..., None] * np.arange(
            1, self.cosine.size + 1
        )
        return np.asarray(np.cos(angle) @ self.cosine + np.sin(angle) @ self.sine)

    def parameters(self) -> FeedforwardParameters:
        """Numbers for the compiled sum."""
        first, second = self.time_constant, 0.0
        if self.frequency is not None and self.damping is not None:
            first, second = 2.0 * self.damping / self.frequency, 1.0 / self.frequency**2
        return FeedforwardParameters(
            on=1,
            cosine=table(self.cosine),
            sine=table(self.sine),
            first=float(first),
            second=float(second),
            amplitude=int(self.amplitude),
            over_wind=int(self.over_wind),
            at=table(np.asarray(self.schedule_at)),
            scale=table(np.asarray(self.schedule)),
        )
