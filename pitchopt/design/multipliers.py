"""Lagrange multipliers that subproblems and the hull relaxation share, and certificates store."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

__all__ = ["Multipliers"]

FloatArray = NDArray[np.float64]


@dataclass(frozen=True, kw_only=True, eq=False)
class Multipliers:
    """Multipliers of the normal form in :mod:`pitchopt.design.problem`.

    Attributes
    ----------
    loads : ndarray (4, m)
        y_l over rotor positions, zero mean and norm at most lambda_l / sqrt(m) [-].
    blade : ndarray (N,)
        The same for one blade's bending, norm at most (lambda_b + cap) / sqrt(N).
    rate : ndarray (N,)
        w_n of the change from station n to n + 1, in either direction [N m/rad].
    torque_min, torque_max, cap : float
        Multipliers of the torque limits [-] and of the blade cap [-], 0 or more.
    mean : float
        Multiplier of the mean-pitch condition [N m/rad].
    box : ndarray (4,)
        Multipliers of boxes on the means of torque, tilt, yaw and thrust [-], positive for the
        upper end; zero without boxes.
    basis : ndarray (N,) or float
        Multipliers of the restriction to harmonics [N m/rad]; bounds leave them out.
    """

    loads: FloatArray
    blade: FloatArray
    rate: FloatArray
    torque_min: float = 0.0
    torque_max: float = 0.0
    cap: float = 0.0
    mean: float = 0.0
    box: FloatArray = field(default_factory=lambda: np.zeros(4))
    basis: FloatArray | float = 0.0

    @property
    def finite(self) -> bool:
        """True when every number that a bound uses is finite."""
        arrays = (self.loads, self.blade, self.rate, self.box)
        single = (self.torque_min, self.torque_max, self.cap, self.mean)
        return all(bool(np.all(np.isfinite(a))) for a in arrays) and bool(
            np.all(np.isfinite(single))
        )

    @classmethod
    def zero(cls, stations: int, positions: int) -> Multipliers:
        """No multipliers at all."""
        return cls(
            loads=np.zeros((4, positions)), blade=np.zeros(stations), rate=np.zeros(stations)
        )
