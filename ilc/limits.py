"""Limits of the actuators, kept within every profile and from one passage to the next.

Within a profile |beta_{n+1} - beta_n| <= D, across the wrap as well.  When the profile changes
between two passages, each blade goes from the last station of one profile to the next station of
the other, and the actuator has to make that step too:

    |beta_new[e] - beta_old[e - 1]| <= D      at the stations e where the blades enter.

The profile in use always satisfies the second line for itself, so what is left is never empty.
Envelopes of a profile with slope D are the nearest profiles above and below it that keep the rate;
the maximum and the minimum of profiles that keep the rate keep it too, and so projection is exact.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ilc._checks import FloatArray, number
from ilc.errors import LearningError
from ilc.layout import Layout

__all__ = ["ActuatorLimits"]

_ROUNDING = 1e-15  # [rad] by which a profile that was projected may break them


@dataclass(frozen=True, kw_only=True)
class ActuatorLimits:
    """Range and rate of the pitch actuators.

    Parameters
    ----------
    lower, upper : float
        Range [rad].
    step : float
        Largest change of pitch from one station to the next [rad]:
        pitch rate x 2 pi / (N x rotor speed).

    Raises
    ------
    LearningError
        If a number is not finite, the step negative or the range empty.
    """

    lower: float
    upper: float
    step: float

    def __post_init__(self) -> None:
        for name in ("lower", "upper"):
            object.__setattr__(self, name, number(name, getattr(self, name)))
        object.__setattr__(self, "step", number("step", self.step, at_least=0))
        if self.lower >= self.upper:
            raise LearningError(
                f"lower, upper: got {self.lower:g} and {self.upper:g} rad, expected the first to "
                "be the smaller"
            )

    @classmethod
    def from_rate(
        cls, *, lower: float, upper: float, pitch_rate: float, rotor_speed: float, stations: int
    ) -> ActuatorLimits:
        """Limits from a pitch rate [rad/s], a rotor speed [rad/s] and the number of stations."""
        rate = number("pitch_rate", pitch_rate, at_least=0)
        speed = number("rotor_speed", rotor_speed, above=0)
        return cls(lower=lower, upper=upper, step=rate * 2 * np.pi / (stations * speed))

    def bounds(
        self, layout: Layout, current: FloatArray, passage: int
    ) -> tuple[FloatArray, FloatArray]:
        """Lowest and highest pitch of every variable in `passage`, after `current` [rad].

        The rate within the profile is not in them.
        """
        low = np.full(layout.variables, self.lower)
        high = np.full(layout.variables, self.upper)
        entry = layout.visit(passage)[1][0]
        before = current[layout.behind[entry]]
        low[entry] = np.maximum(low[entry], before - self.step)
        high[entry] = np.minimum(high[entry], before + self.step)
        return low, high

    def projected(
        self, layout: Layout, wish: FloatArray, current: FloatArray, passage: int
    ) -> FloatArray:
        """The profile for `passage` that keeps all limits and is nearest to a wish.

        Nearest in the largest change of one pitch, once the wish is brought into the range; a wish
        that keeps the limits is returned as it is, and where it is NaN stands for `current`, the
        profile of the passage before.
        """
        low, high = self.bounds(layout, current, passage)
        wanted = np.clip(np.where(np.isnan(wish), current, wish), self.lower, self.upper)
        if self._excess(layout, wanted, low, high) <= _ROUNDING:
            return wanted
        rows = np.stack([wanted, -wanted, low, -high]).reshape(-1, layout.stations)
        above, below, lowest, highest = _above(rows, self.step).reshape(4, -1)
        kept = np.minimum(np.maximum(0.5 * (above - below), lowest), -highest)
        return np.clip(kept, self.lower, self.upper)  # the envelopes are off by rounding

    def violation(
        self, layout: Layout, profile: FloatArray, before: FloatArray, passage: int
    ) -> float:
        """Largest violation of any limit by `profile` in `passage` [rad]; 0 or less is allowed."""
        return self._excess(layout, profile, *self.bounds(layout, before, passage))

    def _excess(
        self, layout: Layout, profile: FloatArray, low: FloatArray, high: FloatArray
    ) -> float:
        step = np.abs(profile[layout.ahead] - profile).max() - self.step
        return float(max((low - profile).max(), (profile - high).max(), step))


def _above(bound: FloatArray, step: float) -> FloatArray:
    """Smallest cyclic rows above `bound` (R, N) whose neighbours differ by at most `step`."""
    size = bound.shape[1]
    step = min(step, float(np.ptp(bound)))  # a larger one binds nothing and loses digits
    ramp = step * np.arange(2 * size)
    twice = np.concatenate([bound, bound], axis=1)
    forward = np.maximum.accumulate(twice + ramp, axis=1) - ramp
    backward = np.maximum.accumulate((twice + ramp[::-1])[:, ::-1], axis=1)[:, ::-1] - ramp[::-1]
    return np.asarray(np.maximum(forward[:, size:], backward[:, :size]))
