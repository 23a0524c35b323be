"""Layout: which pitch acts at which rotor position.

A learner keeps one pitch for every station (N of them), or one for every blade and station (B N)
where blades differ.  It tracks the loads at P rotor positions: with one profile for all blades the
rotor looks the same after each passage and P = m; with a profile for each blade only after a whole
rotation, P = N.  At tracked position q, blade b has the pitch

    variable index[q, b] = q + b m                    (one profile)
                         = b N + (q + b m) mod N      (one for each blade)
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ilc._checks import FloatArray, IntArray, array_of, count
from ilc.errors import LearningError

__all__ = ["Layout"]


@dataclass(frozen=True, kw_only=True)
class Layout:
    """Blades, rotor positions and profiles of a learner.

    Parameters
    ----------
    blades : int
        Number of blades B.
    positions : int
        Samples m of a passage.
    separate : bool
        One profile for each blade.

    Raises
    ------
    LearningError
        If a number is below 1.
    """

    blades: int
    positions: int
    separate: bool = False

    def __post_init__(self) -> None:
        object.__setattr__(self, "blades", count("blades", self.blades, at_least=1))
        object.__setattr__(self, "positions", count("positions", self.positions, at_least=1))

    @property
    def stations(self) -> int:
        """N = B m."""
        return self.blades * self.positions

    @property
    def tracked(self) -> int:
        """P, the number of rotor positions whose loads are tracked."""
        return self.stations if self.separate else self.positions

    @property
    def variables(self) -> int:
        """Number of pitches that are learned, N or B N."""
        return self.stations * (self.blades if self.separate else 1)

    @property
    def dwell(self) -> int:
        """Passages until every tracked position has been met."""
        return self.blades if self.separate else 1

    @cached_property
    def index(self) -> IntArray:
        """Variable that sets the pitch of blade b at tracked position q, shape (P, B)."""
        q = np.arange(self.tracked)[:, None]
        b = np.arange(self.blades)
        station = (q + b * self.positions) % self.stations
        return np.asarray(station + (b * self.stations if self.separate else 0), dtype=np.intp)

    @cached_property
    def azimuth(self) -> FloatArray:
        """Azimuth of every variable's station from the first station [rad]."""
        turn = 2 * np.pi * np.arange(self.stations) / self.stations
        return np.tile(turn, self.blades) if self.separate else turn

    @cached_property
    def _visits(self) -> list[tuple[IntArray, IntArray]]:
        rows = np.split(np.arange(self.tracked), self.dwell)
        return [(row, self.index[row]) for row in rows]

    def visit(self, number: int) -> tuple[IntArray, IntArray]:
        """What passage `number` meets: tracked positions (m,) in order, their variables (m, B)."""
        return self._visits[number % self.dwell]

    @cached_property
    def ahead(self) -> IntArray:
        """The variable of the next station on the same profile, (V,)."""
        return self._rolled(-1)

    @cached_property
    def behind(self) -> IntArray:
        """The variable of the station before on the same profile, (V,)."""
        return self._rolled(1)

    def _rolled(self, shift: int) -> IntArray:
        chains = np.arange(self.variables).reshape(-1, self.stations)
        return np.asarray(np.roll(chains, shift, axis=1).reshape(-1))

    def profile(self, variables: FloatArray) -> FloatArray:
        """The profile as plants take it, (N,) or (B, N)."""
        return variables.reshape(self.blades, -1).copy() if self.separate else variables.copy()

    def values(self, profile: object) -> FloatArray:
        """Variables of a constant pitch, of a profile (N,) or of profiles (B, N) [rad].

        Raises
        ------
        LearningError
            If these are not numbers, the shape is none of these, or different blades are given
            one profile.
        """
        try:
            given = np.asarray(profile, dtype=np.float64)
        except (TypeError, ValueError) as error:
            raise LearningError(
                f"profile: got {type(profile).__name__}, expected numbers"
            ) from error
        if given.ndim == 0:
            return array_of("profile", np.full(self.variables, given), (self.variables,))
        if given.shape == (self.stations,):
            copies = self.blades if self.separate else 1
            return array_of("profile", np.tile(given, copies), (self.variables,))
        if self.separate and given.shape == (self.blades, self.stations):
            return array_of("profile", given.ravel(), (self.variables,))
        raise LearningError(
            f"profile: got shape {given.shape}, expected a number or ({self.stations},)"
            + (f" or ({self.blades}, {self.stations})" if self.separate else "")
        )
