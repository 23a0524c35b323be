"""S-N curves and damage by the rule of Palmgren and Miner.

A curve is straight in logarithms, with one slope or two that meet at a knee,

    N(S) = N_0 (S_0 / S)^m            for S >= S_k,      S_k = S_0 (N_0 / N_k)^(1 / m),
    N(S) = N_k (S_k / S)^m_2          for S < S_k,

N cycles of the range S to failure, through the point (N_0, S_0). Ranges below the one that
would take the endurance N_e may be without damage. Damage adds up over cycles whatever their
order, D = sum_i n_i / N(S_i), and failure is expected at D = 1. Means of the cycles are not
corrected for.

Thicker plates last shorter: DNV-RP-C203 raises the ranges by (t / t_0)^k for t above the
thickness t_0 that the curve was made for, which is a curve with S_0 lowered by it.

References: M. A. Miner, Cumulative damage in fatigue, J. Appl. Mech. 12, 1945; DNV-RP-C203,
section 2.4; EN 1993-1-9, section 7.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike

from pitchopt.checks import FloatArray, finite_number
from pitchopt.errors import InputError
from pitchopt.fatigue.counting import Cycles

__all__ = ["SNCurve", "miner_damage"]


@dataclass(frozen=True, kw_only=True)
class SNCurve:
    """Cycles to failure over the range of a stress or load.

    Parameters
    ----------
    slope : float
        m, positive [-].
    reference_range : float
        S_0 [unit of the ranges], positive.
    reference_cycles : float
        N_0 [-], positive; 1 makes S_0 the ultimate range.
    second_slope, knee_cycles : float or None
        m_2 and N_k [-], positive; both or none.
    endurance_cycles : float or None
        N_e [-]; ranges that would take more cycles do no damage. Not below the knee.

    Raises
    ------
    InputError
        If a number is out of range, or they do not fit together.
    """

    slope: float
    reference_range: float
    reference_cycles: float = 2e6
    second_slope: float | None = None
    knee_cycles: float | None = None
    endurance_cycles: float | None = None

    def __post_init__(self) -> None:
        for name in ("slope", "reference_range", "reference_cycles"):
            object.__setattr__(self, name, finite_number(name, getattr(self, name), above=0.0))
        for name in ("second_slope", "knee_cycles", "endurance_cycles"):
            value = getattr(self, name)
            if value is not None:
                object.__setattr__(self, name, finite_number(name, value, above=0.0))
        if (self.second_slope is None) != (self.knee_cycles is None):
            raise InputError(
                f"second_slope, knee_cycles: got {self.second_slope} and {self.knee_cycles}, "
                "expected both or none"
            )
        if self.endurance_cycles is not None and self.endurance_cycles < (self.knee_cycles or 0.0):
            raise InputError(
                f"endurance_cycles: got {self.endurance_cycles}, expected at least knee_cycles = "
                f"{self.knee_cycles}"
            )

    def for_thickness(
        self, thickness: float, *, reference: float = 0.025, exponent: float = 0.2
    ) -> SNCurve:
        """Curve for a plate of this thickness [m]; the same up to the reference [m]."""
        t = finite_number("thickness", thickness, above=0.0)
        t0 = finite_number("reference", reference, above=0.0)
        k = finite_number("exponent", exponent, at_least=0.0)
        return replace(self, reference_range=self.reference_range * min(1.0, (t0 / t) ** k))

    def life(self, ranges: ArrayLike) -> FloatArray:
        """Cycles to failure [-] of the shape of `ranges`; infinite where there is no damage."""
        s = np.asarray(ranges, dtype=np.float64)
        if not np.isfinite(s).all() or (s < 0.0).any():
            raise InputError("ranges: got NaN, infinite or negative values, expected ranges >= 0")
        with np.errstate(divide="ignore", over="ignore"):  # small ranges last for ever
            log_s = np.log(s / self.reference_range)
            log_n = np.log(self.reference_cycles) - self.slope * log_s
            if self.second_slope is not None and self.knee_cycles is not None:
                # above the knee in cycles, the distance from it grows by the ratio of the slopes
                knee = np.log(self.knee_cycles)
                beyond = np.maximum(log_n - knee, 0.0)
                log_n = np.minimum(log_n, knee) + beyond * (self.second_slope / self.slope)
            life = np.exp(log_n)
        if self.endurance_cycles is not None:
            life = np.where(life > self.endurance_cycles * (1.0 + 1e-12), np.inf, life)
        return np.asarray(life)


def miner_damage(cycles: Cycles, curve: SNCurve, *, scale: float = 1.0) -> float:
    """Damage D of counted cycles [-]; 1 is failure.

    Parameters
    ----------
    cycles : Cycles
        Of a load or a stress.
    curve : SNCurve
    scale : float
        Ranges of the curve's unit in one of the cycles', such as stress in a section over the
        moment on it; positive.

    Raises
    ------
    InputError
        If `scale` is out of range.
    """
    factor = finite_number("scale", scale, above=0.0)
    return float(np.sum(cycles.counts / curve.life(cycles.ranges * factor)))
