"""What a learner meets: something that turns with a periodic pitch profile and reports its loads.

The clocks.  A *passage* is one blade passage, a turn by 2 pi / B: after it the rotor looks the
same, with every blade in the place of the next one.  It is one iteration of a learner.  B passages
are one *rotation*.

Stations and signs.  N = B m azimuth stations; at sample k of passage j, blade b stands at station
((b + j) mod B) m + k.  A profile gives the pitch at every station: of shape (N,) for all blades
alike, or (B, N), one for each blade.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Protocol, runtime_checkable

import numpy as np

from ilc._checks import FloatArray

__all__ = ["LOADS", "Plant", "StatefulPlant"]

LOADS = ("torque", "tilt", "yaw", "thrust")
"""Order of the four rotor loads wherever they share an axis."""


@runtime_checkable
class Plant(Protocol):
    """A rotor that can be turned by one blade passage."""

    @property
    def blades(self) -> int:
        """Number of blades B."""
        ...

    @property
    def positions(self) -> int:
        """Rotor positions m at which the loads are sampled in a passage."""
        ...

    def passage(self, profile: FloatArray, number: int) -> FloatArray:
        """Turn by one blade passage.

        Parameters
        ----------
        profile : ndarray (N,) or (B, N)
            Pitch at the stations [rad], held over the passage.
        number : int
            Passages made before this one, since the start.

        Returns
        -------
        ndarray (4, m)
            Torque, tilt, yaw [N m] and thrust [N] of the rotor at its m positions; NaN where
            nothing was measured.
        """
        ...


@runtime_checkable
class StatefulPlant(Plant, Protocol):
    """A plant whose answer depends on what was before, and that can be saved and gone on with."""

    def state(self) -> Mapping[str, np.ndarray]:
        """All that the coming passages depend on, as arrays."""
        ...

    def restore(self, state: Mapping[str, np.ndarray]) -> None:
        """Go on exactly from what :meth:`state` gave.

        Anything raised for a state of another plant should be a ValueError.
        """
        ...
