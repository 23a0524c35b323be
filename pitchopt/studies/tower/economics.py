"""Cost of energy of a turbine on a tower, from the tower's mass and the simulated power.

    CoE(h, m, E) = FCR ICC(m) / E + AOE,

with the capital cost of `pitchopt.studies.tower.cost`, the energy of the simulated power curve in
the wind at the hub height (`energy`), and operating expenses per energy that are held at those of a
reference energy, as in equation (14) of the paper.  Foundation and installation stay those of the
reference height unless they are told to follow.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from pitchopt.checks import FloatArray, finite_number
from pitchopt.studies.tower.cost import CostModel
from pitchopt.studies.tower.energy import annual_energy, mean_wind_at
from pitchopt.studies.tower.load_sets import LoadSet
from pitchopt.studies.tower.load_settings import LoadSettings
from pitchopt.turbines import Turbine

__all__ = ["Economics"]


@dataclass(frozen=True, kw_only=True)
class Economics:
    """Costs and energy of one turbine at one site.

    Parameters
    ----------
    model : CostModel
    settings : LoadSettings
        For the site: mean wind speed at the model's hub height, and shear.
    operating_energy : float
        Yearly energy that operating expenses per energy are taken at [J].
    follow_height : bool
        Let foundation and installation follow the hub height.

    Raises
    ------
    InputError
        If the energy is not positive.
    """

    model: CostModel
    settings: LoadSettings
    operating_energy: float
    follow_height: bool = False

    def __post_init__(self) -> None:
        finite_number("operating_energy", self.operating_energy, above=0.0)

    @classmethod
    def of(
        cls,
        turbine: Turbine,
        settings: LoadSettings,
        found: LoadSet,
        *,
        follow_height: bool = False,
    ) -> Economics:
        """Economics with the energy of a set at the turbine's own height as reference."""
        model = CostModel(
            rated_power=turbine.rated_power,
            rotor_diameter=2.0 * turbine.rotor.radius,
            hub_height=turbine.rotor.hub_height,
        )
        energy = annual_energy(found.wind_speeds, found.power, settings.mean_wind_speed)
        return cls(
            model=model,
            settings=settings,
            operating_energy=float(energy),
            follow_height=follow_height,
        )

    def energy(self, hub_height: ArrayLike, found: LoadSet) -> FloatArray:
        """Yearly energy [J] at hub heights (...) [m] with the power of a set."""
        site = mean_wind_at(
            hub_height,
            reference_height=self.model.hub_height,
            reference_speed=self.settings.mean_wind_speed,
            exponent=self.settings.shear,
        )
        return annual_energy(found.wind_speeds, found.power, site)

    def cost(self, hub_height: ArrayLike, mass: ArrayLike, energy: ArrayLike) -> FloatArray:
        """Cost of energy [$/MWh] for hub heights [m], tower masses [kg] and energies [J] (...)."""
        height = np.asarray(hub_height, dtype=np.float64)
        found = self.model.cost_of_energy_per_mwh(
            mass,
            energy,
            hub_height=height if self.follow_height else None,
            operating_energy=self.operating_energy,
        )
        return np.broadcast_to(found, np.broadcast_shapes(found.shape, height.shape)).copy()
