"""Sets of loads in closed form, in place of simulations."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable

import numpy as np

from pitchopt.fatigue import SNCurve
from pitchopt.studies.tower import (
    FatigueLoads,
    LoadSet,
    LoadSettings,
    TowerDesign,
    Weld,
    scaled_start,
)
from pitchopt.turbines import Turbine

SLOPE = 4.0
WELD = Weld(  # one slope and no effect of thickness: damage is a power of the moment over W
    curve=SNCurve(slope=SLOPE, reference_range=52.63e6, reference_cycles=1e7),
    thickness_exponent=0.0,
)
SETTINGS = LoadSettings(
    wind_speeds=(5.0, 9.0, 13.0), seeds=(1,), duration=60.0, stations=5, axes=1, box_points=5
)
POWER = np.array([0.4e6, 2.0e6, 3.3e6])


class ClosedSets:
    """Like `LoadSets`: moments times (1 - a c / (c + b)) (m / m_0)^p (h / h_0)^q.

    Attributes
    ----------
    asked : list of str
        Keys in the order in which they were asked for.
    simulated : int
        Different ones.
    """

    def __init__(
        self,
        reference: Turbine,
        make: Callable[..., FatigueLoads],
        *,
        settings: LoadSettings = SETTINGS,
        a: float = 0.2,
        b: float = 0.1,
        coupling: float = 0.0,
        lift: float = 0.0,
        base: float = 6.4e6,
    ) -> None:
        self.reference, self.settings, self.weld = reference, settings, WELD
        self._make, self._base = make, base
        self.a, self.b, self.coupling, self.lift = a, b, coupling, lift
        self.reference_mass = scaled_start(reference, 110.0).mass
        self.asked: list[str] = []
        self.simulated = 0
        self._kept: dict[str, LoadSet] = {}

    def controller(self, c: float) -> float:
        """Factor of the moments for a weight."""
        return 1.0 - self.a * c / (c + self.b)

    def factor(self, design: TowerDesign, c: float) -> float:
        """Of the moments."""
        heavier, higher = design.mass / self.reference_mass, design.hub_height / 110.0
        return self.controller(c) * heavier**self.coupling * higher**self.lift

    def loads(self, factor: float) -> FatigueLoads:
        """With moments times a factor."""
        made = self._make(
            factor * self._base, factor * 1.2e6, stations=self.settings.stations, weld=WELD
        )
        return dataclasses.replace(made, cycles=made.cycles[:, :1])

    def run(self, design: TowerDesign, tower_velocity: float) -> LoadSet:
        """Set of a design and a weight."""
        numbers = [design.hub_height, tower_velocity, *design.diameter, *design.thickness]
        key = ",".join(float(n).hex() for n in numbers)
        self.asked.append(key)
        if key not in self._kept:
            self.simulated += 1
            self._kept[key] = LoadSet(
                loads=self.loads(self.factor(design, tower_velocity)),
                wind_speeds=np.array(self.settings.wind_speeds),
                power=POWER,
                power_deviation=0.1 * POWER,
                largest_speed=1.3,
                simulations=3,
                seconds=2.0,
                key=key,
            )
        return self._kept[key]
