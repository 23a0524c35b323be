"""Results of one configuration of the tower study."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from pitchopt.checks import FloatArray
from pitchopt.studies.tower.estimates import CostMap, MassEstimates
from pitchopt.studies.tower.frozen_loads import OptimalTower
from pitchopt.studies.tower.outer import OuterMinimum

__all__ = ["CoDesign", "ConfigurationResult", "Effort"]


@dataclass(frozen=True, kw_only=True)
class Effort:
    """What a phase took.

    Attributes
    ----------
    sets : int
        Sets of simulations.
    seconds : float
        Wall time, that of sets which had been kept included [s].
    iterations : int
        Of an outer search; 0 for none.
    """

    sets: int
    seconds: float
    iterations: int = 0


@dataclass(frozen=True, kw_only=True, eq=False)
class CoDesign:
    """Lowest cost found by an outer search.

    Attributes
    ----------
    tower : OptimalTower
    energy : float
        Yearly [J].
    cost : float
        [$/MWh].
    search : OuterMinimum
        Over the hub height's factor, or over that and the root of the weight's share of the
        largest.
    """

    tower: OptimalTower
    energy: float
    cost: float
    search: OuterMinimum


@dataclass(frozen=True, kw_only=True, eq=False)
class ConfigurationResult:
    """All of one configuration.

    Attributes
    ----------
    configuration : str
    reference : OptimalTower
        At the reference height, c = 0.
    estimates : MassEstimates
    truth : tuple of OptimalTower
        Sized anew at the reference height for the weights of the estimates, the reference first.
    estimated_maps : mapping of str to CostMap
        See `cost_estimates`.
    true_map : CostMap or None
    reference_cost, reference_energy : float
        Of the reference tower [$/MWh, J].
    without, with_codesign : CoDesign
        Lowest cost over the height at c = 0, and over height and c.
    estimate_effort, without_effort, codesign_effort : Effort
    unsettled : tuple of OptimalTower
        Of all that were sized, those whose loads are not their own to the threshold.
    """

    configuration: str
    reference: OptimalTower
    estimates: MassEstimates
    truth: tuple[OptimalTower, ...]
    estimated_maps: Mapping[str, CostMap]
    true_map: CostMap | None
    reference_cost: float
    reference_energy: float
    without: CoDesign
    with_codesign: CoDesign
    estimate_effort: Effort
    without_effort: Effort
    codesign_effort: Effort
    unsettled: tuple[OptimalTower, ...]

    @property
    def true_change(self) -> FloatArray:
        """Change of the optimal mass over the weights (K,) [kg]."""
        return np.array([t.mass for t in self.truth]) - self.truth[0].mass

    @property
    def cost_change(self) -> dict[str, float]:
        """Change of the lowest cost by co-design, over that without [-].

        ``co-design`` from the two searches, the others from the estimated maps: their lowest
        against their lowest at c = 0.
        """
        found = {"co-design": self.with_codesign.cost / self.without.cost - 1.0}
        for name, part in self.estimated_maps.items():
            found[name] = part.lowest()[2] / part.lowest(0.0)[2] - 1.0
        return found
