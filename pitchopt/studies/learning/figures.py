"""ProfileFigures: what a plant answers to a profile that is held.

    J_l = RMS over the positions of (load_l - mean of load_l),     sum of RMS = sum over l of J_l,

on the exact loads of the last passage of a rotation, as in the record of a run.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from ilc import LOADS
from pitchopt.checks import FloatArray
from pitchopt.studies.learning.plant import StaticPlant

__all__ = ["ProfileFigures", "judged"]


@dataclass(frozen=True, kw_only=True, eq=False)
class ProfileFigures:
    """A profile and its exact loads.

    Attributes
    ----------
    profile : ndarray (N,) or (B, N)
        Pitch [rad].
    weights : ndarray (4,)
        Weights of torque, tilt, yaw and thrust.
    loads : ndarray (4, m)
        Torque, tilt, yaw [N m] and thrust [N] in the passage.
    rotation_loads : ndarray (4, N)
        The same over a whole rotation.
    bending : ndarray (B, N)
        Bending moment of every blade at the stations [N m].
    outside : int
        Samples of the passage, of B m, at which a pitch is beyond what design admits.
    """

    profile: FloatArray
    weights: FloatArray
    loads: FloatArray
    rotation_loads: FloatArray
    bending: FloatArray
    outside: int

    @property
    def mean(self) -> FloatArray:
        """Means of torque, tilt, yaw [N m] and thrust [N], (4,)."""
        return np.asarray(self.loads.mean(axis=1))

    @property
    def rms(self) -> dict[str, float]:
        """J of each load [N m, N]."""
        return dict(zip(LOADS, map(float, self.loads.std(axis=1)), strict=True))

    @property
    def rms_sum(self) -> float:
        """Plain sum of the four."""
        return sum(self.rms.values())

    @property
    def rms_weighted(self) -> float:
        """Weighted sum [N m]."""
        return float(self.weights @ self.loads.std(axis=1))

    @property
    def rms_weighted_rotation(self) -> float:
        """Weighted sum over all samples of a rotation [N m]; more where blades differ."""
        return float(self.weights @ self.rotation_loads.std(axis=1))

    @property
    def blade_rms(self) -> float:
        """J_blade [N m], that of the blade where it is largest."""
        return float(self.bending.std(axis=1).max())

    @property
    def pitch_travel(self) -> float:
        """Pitch travel of one revolution [rad], of the blade that travels farthest."""
        profiles = np.atleast_2d(self.profile)
        return float(np.abs(np.roll(profiles, -1, axis=1) - profiles).sum(axis=1).max())

    @property
    def mean_pitch(self) -> float:
        """Mean over stations and blades [rad]."""
        return float(self.profile.mean())


def judged(
    plant: StaticPlant, profile: ArrayLike, number: int, weights: FloatArray
) -> ProfileFigures:
    """Figures of a profile held in passage `number` of a plant."""
    held = np.array(profile, dtype=np.float64)
    return ProfileFigures(
        profile=held,
        weights=weights,
        loads=plant.passage(held, number),
        rotation_loads=plant.rotation(held, number),
        bending=plant.bending(held, number),
        outside=plant.outside(held, number),
    )
