"""Towers of one configuration, solved when they are asked for, and what they took.

A new tower starts from the solved one that is closest in hub height and controller weight, so that
neighbours take two or three sets of simulations.
"""

from __future__ import annotations

from collections.abc import Callable

from pitchopt.studies.tower.design import TowerDesign
from pitchopt.studies.tower.frozen_loads import OptimalTower, Round, optimal_tower
from pitchopt.studies.tower.limits import TowerLimits
from pitchopt.studies.tower.load_sets import LoadSet, LoadSets

__all__ = ["Towers"]

_HEIGHT, _WEIGHT = 10.0, 0.3  # as far apart [m, s^2/m^2]


class Towers:
    """Optimal towers over hub height and controller weight.

    Parameters
    ----------
    sets : LoadSets
    limits : TowerLimits
    threshold : float
        Of `optimal_tower`.
    known : iterable of OptimalTower
        Solved elsewhere; they are starts and answers, and what they took does not count.
    on_round : callable, optional
        Called with hub height, weight and `Round`.

    Attributes
    ----------
    used : dict of str to float
        Digests of the sets that were asked for, and the wall time that each took [s].
    sizing_seconds : float
    """

    def __init__(
        self,
        sets: LoadSets,
        limits: TowerLimits,
        *,
        threshold: float = 0.002,
        known: tuple[OptimalTower, ...] = (),
        on_round: Callable[[float, float, Round], None] | None = None,
    ) -> None:
        self.sets, self.limits, self.threshold = sets, limits, threshold
        self.on_round = on_round
        self.used: dict[str, float] = {}
        self.sizing_seconds = 0.0
        self._solved = {(t.hub_height, t.tower_velocity): t for t in known}

    @property
    def seconds(self) -> float:
        """Wall time of all sets, as when none had been kept, and of the sizings [s]."""
        return sum(self.used.values()) + self.sizing_seconds

    def at(self, hub_height: float, tower_velocity: float) -> OptimalTower:
        """Tower for a hub height [m] and a weight [s^2/m^2].

        Raises
        ------
        InputError, ComputationError
            See `optimal_tower`.
        """
        key = (float(hub_height), float(tower_velocity))
        if key not in self._solved:
            tower = optimal_tower(
                self.sets,
                self.limits,
                *key,
                start=self._closest(*key),
                threshold=self.threshold,
                on_round=None if self.on_round is None else lambda r: self._told(*key, r),
            )
            for turn in tower.rounds:
                self.used[turn.key] = turn.set_seconds
                self.sizing_seconds += turn.sizing_seconds
            self._solved[key] = tower
        return self._solved[key]

    def loads_on(self, design: TowerDesign, tower_velocity: float) -> LoadSet:
        """Set of a given design, counted like those of the towers."""
        found = self.sets.run(design, tower_velocity)
        self.used[found.key] = found.seconds
        return found

    def _told(self, hub_height: float, tower_velocity: float, turn: Round) -> None:
        if self.on_round is not None:
            self.on_round(hub_height, tower_velocity, turn)

    def _closest(self, hub_height: float, tower_velocity: float) -> TowerDesign | None:
        if not self._solved:
            return None
        best = min(
            self._solved,
            key=lambda key: (
                abs(key[0] - hub_height) / _HEIGHT + abs(key[1] - tower_velocity) / _WEIGHT
            ),
        )
        return self._solved[best].design
