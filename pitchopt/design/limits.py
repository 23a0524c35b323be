"""Limits of the pitch actuators and the set of profiles that respect them.

A profile beta_n, n = 0..N-1, is held over one turn and repeats.  Range and stall limits bound
each beta_n; the actuator's rate bounds the change between neighbouring stations, across the
wrap as well:

    |beta_{n+1} - beta_n| <= D,   D = pitch_rate 2 pi / (N rotor_speed),   n + 1 modulo N.

The tightened interval of a station is the largest that its neighbours can follow; its lower
and upper ends are themselves profiles that keep the rate, which makes the repair exact.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pitchopt.aero.curves import BladeCurves
from pitchopt.checks import finite_number
from pitchopt.errors import InputError

__all__ = ["PitchLimits", "lipschitz_lower", "lipschitz_upper"]

FloatArray = NDArray[np.float64]


@dataclass(frozen=True, kw_only=True)
class PitchLimits:
    """Range and rate of the pitch actuators, and the rotor speed they work against.

    Parameters
    ----------
    rotor_speed : float
        Rotor speed omega [rad/s].
    pitch_rate : float
        Largest pitch rate [rad/s]; zero is legal and leaves constant pitch only.
    lower, upper : float
        Range of the actuator [rad]; the stall limits come with the curves.

    Raises
    ------
    InputError
        If a number is not finite, the speed not positive, the rate negative or the range
        empty.
    """

    rotor_speed: float
    pitch_rate: float
    lower: float = -np.pi
    upper: float = np.pi

    def __post_init__(self) -> None:
        set_ = object.__setattr__
        set_(self, "rotor_speed", finite_number("rotor_speed", self.rotor_speed, above=0))
        set_(self, "pitch_rate", finite_number("pitch_rate", self.pitch_rate, at_least=0))
        set_(self, "lower", finite_number("lower", self.lower))
        set_(self, "upper", finite_number("upper", self.upper))
        if self.lower >= self.upper:
            raise InputError(
                f"pitch range: lower limit {np.degrees(self.lower):g} deg is not below the "
                f"upper limit {np.degrees(self.upper):g} deg"
            )

    def step(self, stations: int) -> float:
        """D, the largest change between neighbouring stations [rad]."""
        return float(self.pitch_rate * 2 * np.pi / (stations * self.rotor_speed))

    def applied(self, curves: BladeCurves) -> BladeCurves:
        """The curves on the pitch that range, stall and rate leave at each station.

        Raises
        ------
        InputError
            If no constant pitch is left.
        """
        lower = np.maximum(curves.lower, self.lower)
        upper = np.minimum(curves.upper, self.upper)
        if lower.max() >= upper.min():
            raise InputError(
                "pitch limits: no constant pitch satisfies the range "
                f"{np.degrees(self.lower):g} to {np.degrees(self.upper):g} deg and the stall "
                f"limits at every azimuth (lower limit up to {np.degrees(lower.max()):.3f} deg, "
                f"upper limit down to {np.degrees(upper.min()):.3f} deg)"
            )
        step = self.step(curves.stations)
        return curves.with_limits(lipschitz_lower(lower, step), lipschitz_upper(upper, step))

    def repaired(self, curves: BladeCurves, profile: FloatArray) -> FloatArray:
        """The profile moved by no more than its violation so that it keeps every limit.

        ``curves`` must come from :meth:`applied`: their ends keep the rate, and the maximum
        or minimum of profiles that keep the rate keeps it too.
        """
        step = self.step(curves.stations)
        middle = 0.5 * (lipschitz_lower(profile, step) + lipschitz_upper(profile, step))
        return np.asarray(np.clip(middle, curves.lower, curves.upper))

    def violation(self, curves: BladeCurves, profile: FloatArray) -> tuple[float, float]:
        """Largest violation of range [rad] and of rate [rad/s]; zero or less is feasible."""
        out_of_range = max(
            float(np.max(curves.lower - profile)), float(np.max(profile - curves.upper))
        )
        step = np.abs(np.roll(profile, -1) - profile).max() if profile.size > 1 else 0.0
        rate = float(step) * profile.size * self.rotor_speed / (2 * np.pi)
        return out_of_range, rate - self.pitch_rate


def lipschitz_lower(bound: FloatArray, step: float) -> FloatArray:
    """Smallest cyclic profile above ``bound`` whose neighbours differ by at most ``step``."""
    out = np.array(bound, dtype=np.float64)
    if step <= 0:
        return np.full_like(out, out.max())
    step = min(step, float(np.ptp(out)))  # a larger one binds nothing and loses digits
    twice = np.concatenate([out, out])
    ramp = step * np.arange(twice.size)
    forward = np.maximum.accumulate(twice + ramp) - ramp
    backward = (np.maximum.accumulate((twice + ramp[::-1])[::-1]) - ramp)[::-1]
    raised = np.maximum(forward[out.size :], backward[: out.size])
    # a bound that its neighbours can follow comes back as it was, not moved by rounding
    rounding = 8 * np.finfo(np.float64).eps * (float(np.abs(out).max()) + step * twice.size)
    return np.asarray(np.where(raised - out <= rounding, out, raised))


def lipschitz_upper(bound: FloatArray, step: float) -> FloatArray:
    """Largest cyclic profile below ``bound`` whose neighbours differ by at most ``step``."""
    return -lipschitz_lower(-np.asarray(bound, dtype=np.float64), step)
