"""Lowest collective pitch over the estimated wind speed.

Around rated wind speed the thrust peaks; a lowest pitch above the fine pitch there takes off the
peak for a little power.  The table is interpolated monotonically (PCHIP), so that it neither
overshoots nor falls between its points, and held beyond its ends.

Source: D. Zalkind, E. Dall'Anese, L. Pao, "Automatic controller tuning using a zeroth-order
optimization algorithm", 2020, section 3.3.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from pitchopt.checks import FloatArray, finite_array
from pitchopt.control.parameters import MinimumParameters
from pitchopt.errors import InputError

__all__ = ["MinimumPitchTable"]

_SPACING = 0.05  # of the evenly spaced table that the kernel reads [m/s]


@dataclass(frozen=True, kw_only=True, eq=False)
class MinimumPitchTable:
    """Lowest pitch over wind speed.

    Parameters
    ----------
    wind_speed : array_like (W,)
        Ascending [m/s].
    pitch : array_like (W,)
        Lowest pitch there [rad].

    Raises
    ------
    InputError
        If there are fewer than two points or the wind speeds do not ascend.
    """

    wind_speed: FloatArray
    pitch: FloatArray

    def __post_init__(self) -> None:
        wind = finite_array("wind_speed", self.wind_speed)
        if wind.size < 2 or np.any(np.diff(wind) <= 0.0):
            raise InputError(f"wind_speed: got {wind.tolist()}, expected two or more, ascending")
        object.__setattr__(self, "wind_speed", wind)
        object.__setattr__(self, "pitch", finite_array("pitch", self.pitch, shape=wind.shape))

    def lowest(self, wind_speed: ArrayLike) -> FloatArray:
        """Lowest pitch [rad] at wind speeds of any shape [m/s]."""
        from scipy.interpolate import PchipInterpolator

        wind = np.clip(np.asarray(wind_speed, float), self.wind_speed[0], self.wind_speed[-1])
        return np.asarray(PchipInterpolator(self.wind_speed, self.pitch)(wind), dtype=np.float64)

    def parameters(self) -> MinimumParameters:
        """Numbers for the compiled table, sampled every 0.05 m/s or finer."""
        first, last = float(self.wind_speed[0]), float(self.wind_speed[-1])
        intervals = math.ceil((last - first) / _SPACING)
        return MinimumParameters(
            on=1,
            first=first,
            spacing=(last - first) / intervals,
            values=self.lowest(np.linspace(first, last, intervals + 1)),
        )
