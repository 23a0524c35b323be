"""The tower study: what designing tower and controller together gains.

For a standard tower, kept clear of 1P, and for a soft-soft one:

    1. the tower at the reference height for c = 0, its multipliers,
    2. damage of this tower over c, and estimates of the optimal mass over c from it,
    3. towers sized anew for each c: the truth,
    4. towers at other heights for c = 0, and maps of the estimated cost of energy over (h, c),
    5. the lowest cost over h at c = 0, and over (h, c): the co-design optimum,
    6. the map of the true cost over (h, c).

Source: J. Iori, C. Bottasso, M. McWilliam, "A sensitivity-based estimation method for
investigating control co-design relevance", 2024, sections 3 to 5.
"""

from __future__ import annotations

import dataclasses
import time as clock
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field

import numpy as np

from pitchopt.checks import FloatArray, finite_array, finite_number
from pitchopt.errors import InputError
from pitchopt.studies.tower.economics import Economics
from pitchopt.studies.tower.estimates import (
    CostMap,
    cost_estimates,
    mass_estimates,
)
from pitchopt.studies.tower.frozen_loads import OptimalTower, Round
from pitchopt.studies.tower.limits import TowerLimits
from pitchopt.studies.tower.load_sets import LEAST_HUB, LoadSets
from pitchopt.studies.tower.load_settings import LoadSettings
from pitchopt.studies.tower.outer import minimise_in_box
from pitchopt.studies.tower.results import CoDesign, ConfigurationResult, Effort
from pitchopt.studies.tower.towers import Towers

__all__ = [
    "CONFIGURATIONS",
    "TowerStudy",
    "TowerStudySettings",
    "run_tower_study",
]

CONFIGURATIONS = ("standard", "soft-soft")


@dataclass(frozen=True, kw_only=True)
class TowerStudySettings:
    """What is studied.

    Parameters
    ----------
    loads : LoadSettings
    limits : TowerLimits
        Of the standard tower; the soft-soft one has no frequency margin.
    configurations : tuple of str
        Of ``standard`` and ``soft-soft``.
    weights : tuple of float
        c, ascending from 0 [s^2/m^2].
    height_factors : tuple of float
        Hub heights over the reference's, ascending, 1 among them.
    step : float
        Forward step of the first-order estimate, one of the weights [s^2/m^2].
    threshold : float
        Largest change of a diameter or wall that leaves the loads frozen [-].  What is left of it
        goes into every change of the mass, some of which are smaller than the paper's threshold
        of 1 %.
    true_map : bool
        Size a tower at every point of the map.
    follow_height : bool
        Let foundation and installation cost follow the hub height.

    Raises
    ------
    InputError
        If a value is out of range.
    """

    loads: LoadSettings = field(default_factory=LoadSettings)
    limits: TowerLimits = field(default_factory=TowerLimits)
    configurations: tuple[str, ...] = CONFIGURATIONS
    weights: tuple[float, ...] = (0.0, 0.03, 0.1, 0.2, 0.3)
    height_factors: tuple[float, ...] = (0.9, 1.0, 1.1, 1.2)
    step: float = 0.03
    threshold: float = 0.0005
    true_map: bool = True
    follow_height: bool = False

    def __post_init__(self) -> None:
        if not self.configurations or not set(self.configurations) <= set(CONFIGURATIONS):
            raise InputError(
                f"configurations: got {self.configurations}, expected some of "
                f"{', '.join(CONFIGURATIONS)}"
            )
        if "standard" in self.configurations and self.limits.frequency_margin is None:
            raise InputError("limits: got no frequency margin, which the standard tower needs")
        weights = finite_array("weights", self.weights)
        if weights.size < 3 or weights[0] != 0.0 or np.any(np.diff(weights) <= 0.0):
            raise InputError(
                f"weights: got {self.weights}, expected three or more, ascending from 0"
            )
        if self.step not in self.weights[1:]:
            raise InputError(f"step: got {self.step:g}, expected one of the weights above 0")
        factors = finite_array("height_factors", self.height_factors)
        if 1.0 not in self.height_factors or np.any(np.diff(factors) <= 0.0) or factors.size < 3:
            raise InputError(
                f"height_factors: got {self.height_factors}, expected three or more, ascending, 1 "
                "among them"
            )
        finite_number("threshold", self.threshold, above=0.0, at_most=0.01)


@dataclass(frozen=True, kw_only=True, eq=False)
class TowerStudy:
    """Result of the study.

    Attributes
    ----------
    settings : TowerStudySettings
    turbine : str
    reference_height : float
        [m].
    results : mapping of str to ConfigurationResult
    economics : Economics
    sets_simulated : int
        In this run; others had been kept.
    seconds : float
    """

    settings: TowerStudySettings
    turbine: str
    reference_height: float
    results: Mapping[str, ConfigurationResult]
    economics: Economics
    sets_simulated: int
    seconds: float


def run_tower_study(
    sets: LoadSets,
    settings: TowerStudySettings | None = None,
    *,
    on_phase: Callable[[str, str], None] | None = None,
    on_round: Callable[[float, float, Round], None] | None = None,
) -> TowerStudy:
    """Run the study; sets that are kept in the folder of `sets` are not simulated again.

    Parameters
    ----------
    sets : LoadSets
        With the settings' own `LoadSettings`.
    settings : TowerStudySettings, optional
    on_phase : callable, optional
        Called with configuration and what begins, for progress.
    on_round : callable, optional
        Called after each sizing with hub height, weight and round.

    Raises
    ------
    InputError
        If the sets have other settings, or a hub height is too low for them.
    ComputationError
        If a run diverges or a tower cannot be sized.
    """
    settings = TowerStudySettings() if settings is None else settings
    if sets.settings != settings.loads:
        raise InputError("sets: got load settings other than those of the study")
    height = sets.reference.rotor.hub_height
    if settings.height_factors[0] * height < LEAST_HUB:
        raise InputError(
            f"height_factors: got {settings.height_factors[0]:g} of {height:g} m, expected hub "
            f"heights of at least {LEAST_HUB:g} m"
        )
    began, simulated = clock.perf_counter(), sets.simulated
    parts = {}
    economics: Economics | None = None
    for name in settings.configurations:
        part = _Configuration(name, sets, settings, on_phase, on_round)
        reference = part.reference
        if economics is None:
            economics = Economics.of(
                sets.reference,
                settings.loads,
                reference.load_set,
                follow_height=settings.follow_height,
            )
        parts[name] = part.run(economics)
    assert economics is not None  # there is a configuration
    return TowerStudy(
        settings=settings,
        turbine=sets.reference.name,
        reference_height=sets.reference.rotor.hub_height,
        results=parts,
        economics=economics,
        sets_simulated=sets.simulated - simulated,
        seconds=clock.perf_counter() - began,
    )


class _Configuration:
    """Phases of one configuration."""

    def __init__(
        self,
        name: str,
        sets: LoadSets,
        settings: TowerStudySettings,
        on_phase: Callable[[str, str], None] | None,
        on_round: Callable[[float, float, Round], None] | None,
    ) -> None:
        self.name, self.sets, self.settings = name, sets, settings
        self._on_phase, self.on_round = on_phase, on_round
        self.height = sets.reference.rotor.hub_height
        soft = dataclasses.replace(settings.limits, frequency_margin=None)
        self.limits = settings.limits if name == "standard" else soft
        self._every: list[Towers] = []
        self.towers = self._towers()
        self._phase("reference tower")
        self.reference = self.towers.at(self.height, 0.0)

    def _towers(self, known: tuple[OptimalTower, ...] = ()) -> Towers:
        towers = Towers(
            self.sets,
            self.limits,
            threshold=self.settings.threshold,
            known=known,
            on_round=self.on_round,
        )
        self._every.append(towers)
        return towers

    def _unsettled(self) -> tuple[OptimalTower, ...]:
        """By hub height and weight, whichever search they belong to."""
        found = {
            (tower.hub_height, tower.tower_velocity): tower
            for towers in self._every
            for tower in towers.solved
            if not tower.converged
        }
        return tuple(found[key] for key in sorted(found))

    def _phase(self, what: str) -> None:
        if self._on_phase is not None:
            self._on_phase(self.name, what)

    def run(self, economics: Economics) -> ConfigurationResult:
        settings, height = self.settings, self.height
        self._phase("damage over c")
        changes = mass_estimates(self.towers, self.reference, settings.weights, step=settings.step)
        self._phase("heights at c = 0")
        factors = settings.height_factors
        solved = {height * f: self.towers.at(height * f, 0.0) for f in factors}
        estimated = cost_estimates(solved, changes, economics)
        estimate_effort = Effort(sets=len(self.towers.used), seconds=self.towers.seconds)
        self._phase("towers over c")
        again = self._towers((self.reference,))
        truth = tuple(again.at(height, c) for c in settings.weights)
        self._phase("lowest cost without co-design")
        without, without_effort = self._search(economics, with_weight=False)
        self._phase("lowest cost with co-design")
        codesign, codesign_effort = self._search(economics, with_weight=True)
        true_map = None
        if settings.true_map:
            self._phase("map of the true cost")
            true_map = self._true_map((*solved.values(), *truth[1:]), economics)
        energy = float(economics.energy(height, self.reference.load_set))
        return ConfigurationResult(
            configuration=self.name,
            reference=self.reference,
            estimates=changes,
            truth=truth,
            estimated_maps=estimated,
            true_map=true_map,
            reference_cost=float(economics.cost(height, self.reference.mass, energy)),
            reference_energy=energy,
            without=without,
            with_codesign=codesign,
            estimate_effort=estimate_effort,
            without_effort=without_effort,
            codesign_effort=codesign_effort,
            unsettled=self._unsettled(),
        )

    def _search(self, economics: Economics, *, with_weight: bool) -> tuple[CoDesign, Effort]:
        """Outer search from the reference height and c = 0, on towers of its own.

        The weight is searched over the root of its share of the largest, in which costs that fall
        with diminishing returns are closer to a parabola.
        """
        towers = self._towers()
        factors, weights = self.settings.height_factors, self.settings.weights
        low, high, steps = [factors[0]], [factors[-1]], [0.05]
        if with_weight:
            low, high, steps = [*low, 0.0], [*high, 1.0], [*steps, 0.5]

        def place(x: FloatArray) -> tuple[float, float]:
            weight = weights[-1] * float(x[1]) ** 2 if with_weight else 0.0
            return self.height * float(x[0]), weight

        def cost(x: FloatArray) -> float:
            tower = towers.at(*place(x))
            energy = economics.energy(tower.hub_height, tower.load_set)
            return float(economics.cost(tower.hub_height, tower.mass, energy))

        start = [1.0, 0.0] if with_weight else [1.0]
        found = minimise_in_box(cost, start, low, high, first_steps=steps)
        tower = towers.at(*place(found.x))
        energy = float(economics.energy(tower.hub_height, tower.load_set))
        effort = Effort(sets=len(towers.used), seconds=towers.seconds, iterations=found.iterations)
        return CoDesign(tower=tower, energy=energy, cost=found.value, search=found), effort

    def _true_map(self, known: tuple[OptimalTower, ...], economics: Economics) -> CostMap:
        towers = self._towers(known)
        heights = [self.height * f for f in self.settings.height_factors]
        grid = [[towers.at(h, c) for c in self.settings.weights] for h in heights]
        mass = np.array([[t.mass for t in row] for row in grid])
        energy = np.array(
            [[float(economics.energy(t.hub_height, t.load_set)) for t in row] for row in grid]
        )
        return CostMap(
            heights=np.array(heights),
            weights=np.array(self.settings.weights),
            mass=mass,
            energy=energy,
            economics=economics,
        )
