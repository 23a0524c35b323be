"""Towers of one configuration, solved when they are asked for, and what they took.

A new tower starts from what those solved before predict for its hub height and controller weight,
so that neighbours take one or two sets of simulations.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Callable

import numpy as np

from pitchopt.checks import FloatArray
from pitchopt.studies.tower.design import TowerDesign
from pitchopt.studies.tower.frozen_loads import (
    OptimalTower,
    Round,
    design_logarithms,
    optimal_tower,
)
from pitchopt.studies.tower.limits import TowerLimits
from pitchopt.studies.tower.load_sets import LoadSet, LoadSets

__all__ = ["Towers"]

_HEIGHT, _WEIGHT = 10.0, 0.3  # as far apart [m, s^2/m^2]
_FEWEST, _QUADRATIC = 3, 8  # towers that make a linear and a quadratic fit
_FURTHEST = 0.2  # step of a logarithm


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
        threshold: float = 0.0005,
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

    @property
    def solved(self) -> tuple[OptimalTower, ...]:
        """All that are known."""
        return tuple(self._solved.values())

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
                start=self._start(*key),
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

    def _start(self, hub_height: float, tower_velocity: float) -> TowerDesign | None:
        """The closest solved tower, moved by what the others say; None where there is none.

        Logarithms of sizes are fitted about the closest by the smallest linear (from eight towers
        on quadratic) model of hub height and root of the weight, close towers counting more.
        """
        if not self._solved:
            return None
        keys = np.array(list(self._solved))
        towers = list(self._solved.values())
        place = np.stack([keys[:, 0] / _HEIGHT, np.sqrt(keys[:, 1] / _WEIGHT)], axis=1)
        here = np.array([hub_height / _HEIGHT, np.sqrt(tower_velocity / _WEIGHT)])
        distance = np.abs(place - here).sum(axis=1)
        best = int(np.argmin(distance))
        design = towers[best].design
        if len(towers) < _FEWEST:
            return design
        others = np.arange(len(towers)) != best
        moves = _terms(place[others] - place[best], quadratic=len(towers) >= _QUADRATIC)
        sizes = np.stack([design_logarithms(t.design) for t in towers])
        weight = (1.0 / (0.1 + distance[others]))[:, None]
        slopes = np.linalg.lstsq(
            weight * moves, weight * (sizes[others] - sizes[best]), rcond=1e-6
        )[0]
        step = _terms((here - place[best])[None], quadratic=len(towers) >= _QUADRATIC)[0] @ slopes
        sized = np.exp(sizes[best] + np.clip(step, -_FURTHEST, _FURTHEST))
        nodes = design.elements + 1
        return dataclasses.replace(design, diameter=sized[:nodes], thickness=sized[nodes:])


def _terms(move: FloatArray, *, quadratic: bool) -> FloatArray:
    """Linear terms of moves (n, 2), and quadratic ones."""
    if not quadratic:
        return move
    return np.column_stack([move, move**2, move[:, 0] * move[:, 1]])
