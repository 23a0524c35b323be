"""Cost of energy of a wind turbine on land.

The design cost and scaling model of L. Fingersh, M. Hand and A. Laxson (Wind turbine design
cost and scaling model, NREL/TP-500-40566, 2006, doi 10.2172/897434): masses and costs of the
components as functions of rated power P [kW], rotor diameter D [m] and hub height h [m], in
dollars of 2002, here for three blades, a three-stage gearbox and a high-speed generator. The
tower is bought by its mass m [kg]. With the initial capital cost ICC [$], the net energy of a
year E and the annual operating expenses AOE [$ a year],

    CoE = (FCR ICC + AOE) / E,          AOE = L E + O E + R P,

FCR the fixed charge rate, L and O what land lease and operation and maintenance cost for a unit
of energy, R what replacements cost each year for a unit of rated power. The report divides AOE by
E, L + (O&M + R P) / E, which is the same.

The study that the tower is taken from lets ICC vary with the tower's mass alone and holds AOE
for a unit of energy (its eq. 14): leave `hub_height` out of the calls, so that foundation and
installation stay those of the model's own height, and give `operating_energy`.

Energy is in joules and power in watts at the surface; `cost_of_energy_per_mwh` says its unit.
Coefficients are those of the report as others quote and implement it, but for the low-speed
shaft (see `CostModel`); docs/sensitivity.md says against what they were checked.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Literal, get_args

import numpy as np
from numpy.typing import ArrayLike

from pitchopt.checks import FloatArray, finite_number
from pitchopt.errors import InputError
from pitchopt.studies.tower.energy import positive_array

__all__ = ["JOULES_PER_MWH", "BladeDesign", "CostModel"]

JOULES_PER_MWH = 3.6e9
_JOULES_PER_KWH = 3.6e6
_BLADES = 3
_PLATFORM_SHARE = 0.125  # of the mainframe's mass

BladeDesign = Literal["baseline", "advanced"]
# mass a R^b of a blade [kg], and the part of its material's cost that is taken off [$]
_BLADE = {"baseline": (0.1452, 2.9158, 955.24), "advanced": (0.4948, 2.53, 21051.0)}


def _together(**named: FloatArray) -> list[FloatArray]:
    """Arrays broadcast against each other."""
    try:
        return list(np.broadcast_arrays(*named.values()))
    except ValueError as error:
        shapes = ", ".join(f"{name} {value.shape}" for name, value in named.items())
        raise InputError(f"shapes do not broadcast: got {shapes}") from error


@dataclass(frozen=True, kw_only=True)
class CostModel:
    """What a turbine on land costs but for its tower, and what its energy costs with one.

    Parameters
    ----------
    rated_power : float
        P [W], electrical.
    rotor_diameter : float
        D [m].
    hub_height : float
        h [m] that foundation and installation are for unless a call has its own.
    blade_design : {"baseline", "advanced"}
        Mass and cost of the blades: of the glass blades of 2002, or of lighter ones.
    fixed_charge_rate : float
        FCR [1/year].
    tower_price : float
        Of the tower for its mass [$/kg].
    low_speed_shaft_factor : float
        f in the cost of the low-speed shaft, f D^2.887 [$]. The report is quoted with 0.01, with
        which a shaft would cost 0.7 $/kg; NREL's own later implementation has 0.0998.
    replacement_cost : float
        R, levelised [$ a year for each W].
    maintenance_cost, land_lease : float
        O and L [$/J].
    tax_rate : float
        Share of the operating expenses that taxes bear [-]; none in the report's formula, and
        0.4 in NREL's later implementation.
    escalation : float
        Dollars of the wanted year for one of 2002, on everything.

    Raises
    ------
    InputError
        If a number is out of range, or the turbine so small that a relation gives a cost that
        is not above zero.
    """

    rated_power: float
    rotor_diameter: float
    hub_height: float
    blade_design: BladeDesign = "baseline"
    fixed_charge_rate: float = 0.1158
    tower_price: float = 1.50
    low_speed_shaft_factor: float = 0.1
    replacement_cost: float = 10.7e-3
    maintenance_cost: float = 0.007 / _JOULES_PER_KWH
    land_lease: float = 0.00108 / _JOULES_PER_KWH
    tax_rate: float = 0.0
    escalation: float = 1.0

    def __post_init__(self) -> None:
        for name in ("rated_power", "rotor_diameter", "hub_height", "fixed_charge_rate"):
            object.__setattr__(self, name, finite_number(name, getattr(self, name), above=0.0))
        for name in ("tower_price", "low_speed_shaft_factor", "escalation"):
            object.__setattr__(self, name, finite_number(name, getattr(self, name), above=0.0))
        for name in ("replacement_cost", "maintenance_cost", "land_lease"):
            object.__setattr__(self, name, finite_number(name, getattr(self, name), at_least=0.0))
        tax = finite_number("tax_rate", self.tax_rate, at_least=0.0, at_most=1.0)
        object.__setattr__(self, "tax_rate", tax)
        if self.blade_design not in get_args(BladeDesign):
            raise InputError(
                f"blade_design: got {self.blade_design!r}, expected one of {get_args(BladeDesign)}"
            )
        costs = self._turbine_costs() | self._site_costs()
        low = [name for name, cost in costs.items() if cost <= 0.0]
        if low:
            raise InputError(
                f"rated_power, rotor_diameter: got {self.rated_power} W and "
                f"{self.rotor_diameter} m, for which the model's {', '.join(low)} would cost "
                "nothing; the model needs a larger turbine"
            )

    @property
    def blade_mass(self) -> float:
        """Of one blade [kg]."""
        factor, exponent, _ = _BLADE[self.blade_design]
        return float(factor * (self.rotor_diameter / 2.0) ** exponent)

    @property
    def swept_area(self) -> float:
        """[m2]."""
        return math.pi * self.rotor_diameter**2 / 4.0

    def statistical_tower_mass(self, *, advanced: bool = False) -> float:
        """What a tower of this height weighs in the model [kg]; it enters no cost here."""
        if not advanced:
            return 0.3973 * self.swept_area * self.hub_height - 1414.0
        return 0.2694 * self.swept_area * self.hub_height + 1779.0

    def component_masses(self, *, rotor_torque: float | None = None) -> Mapping[str, float]:
        """Masses above the tower by component [kg]; three blades are one item.

        Parameters
        ----------
        rotor_torque : float, optional
            Of the low-speed shaft at rated power [N m]; the gearbox is left out without it.

        Raises
        ------
        InputError
            If it is not above zero.
        """
        power, d = self.rated_power / 1e3, self.rotor_diameter
        blades = _BLADES * self.blade_mass
        mainframe = 2.233 * d**1.953
        masses = {
            "blades": blades,
            "hub": 0.954 * self.blade_mass + 5680.3,
            "pitch system": 1.328 * (0.1295 * blades + 491.31) + 555.0,
            "nose cone": self._nose_cone_mass(),
            "low-speed shaft": 0.0142 * d**2.888,
            "main bearings": 2.0 * self._bearing_mass(),  # as much again for the housings
            "brake and coupling": (1.9894 * power - 0.1141) / 10.0,
            "generator": 6.47 * power**0.9223,
            "yaw system": 1.6 * 0.0009 * d**3.314,
            "mainframe": mainframe,
            "platforms": _PLATFORM_SHARE * mainframe,
            "hydraulics and cooling": 0.08 * power,
            "nacelle cover": (11.537 * power + 3849.7) / 10.0,
        }
        if rotor_torque is not None:
            torque = finite_number("rotor_torque", rotor_torque, above=0.0) / 1e3
            masses["gearbox"] = 70.94 * torque**0.759
        return MappingProxyType(masses)

    def capital_costs(
        self, tower_mass: ArrayLike, *, hub_height: ArrayLike | None = None
    ) -> Mapping[str, FloatArray]:
        """Initial capital cost by item [$], each of the shape of the arguments together.

        Parameters
        ----------
        tower_mass : (...) array_like
            m [kg].
        hub_height : (...) array_like, optional
            h [m] that foundation and installation follow; that of the model otherwise.

        Raises
        ------
        InputError
            If a number is not above zero or the shapes do not fit.
        """
        mass = positive_array("tower_mass", tower_mass)
        height = positive_array("hub_height", self.hub_height if hub_height is None else hub_height)
        mass, height = _together(tower_mass=mass, hub_height=height)
        costs: dict[str, float | FloatArray] = dict(self._turbine_costs())
        costs["tower"] = self.tower_price * mass
        costs.update(self._site_costs())
        costs["foundation"] = 303.24 * (height * self.swept_area) ** 0.4037
        costs["assembly and installation"] = 1.965 * (height * self.rotor_diameter) ** 1.1736
        items = {}
        for name, cost in costs.items():
            items[name] = np.broadcast_to(self.escalation * np.asarray(cost), mass.shape)
            items[name].setflags(write=False)
        return MappingProxyType(items)

    def initial_capital_cost(
        self, tower_mass: ArrayLike, *, hub_height: ArrayLike | None = None
    ) -> FloatArray:
        """ICC [$], the sum of `capital_costs`, which says what the arguments are."""
        costs = self.capital_costs(tower_mass, hub_height=hub_height)
        return np.asarray(np.sum(list(costs.values()), axis=0))

    def annual_operating_expenses(self, energy: ArrayLike) -> FloatArray:
        """AOE [$ a year] of a net energy (...) [J a year].

        Raises
        ------
        InputError
            If a number is not above zero.
        """
        net = positive_array("energy", energy)
        expenses = (self.land_lease + self.maintenance_cost) * net
        expenses = expenses + self.replacement_cost * self.rated_power
        return np.asarray((1.0 - self.tax_rate) * self.escalation * expenses)

    def cost_of_energy_per_mwh(
        self,
        tower_mass: ArrayLike,
        energy: ArrayLike,
        *,
        hub_height: ArrayLike | None = None,
        operating_energy: ArrayLike | None = None,
    ) -> FloatArray:
        """CoE [$/MWh], of the shape of the arguments together.

        Parameters
        ----------
        tower_mass : (...) array_like
            m [kg].
        energy : (...) array_like
            Net energy of a year, E [J].
        hub_height : (...) array_like, optional
            As in `capital_costs`.
        operating_energy : (...) array_like, optional
            Energy [J a year] at which the operating expenses for a unit of energy are taken and
            held; `energy` otherwise.

        Raises
        ------
        InputError
            If a number is not above zero or the shapes do not fit.
        """
        capital = self.initial_capital_cost(tower_mass, hub_height=hub_height)
        net = positive_array("energy", energy)
        held = (
            net
            if operating_energy is None
            else positive_array("operating_energy", operating_energy)
        )
        capital, net, held = _together(
            tower_mass_and_hub_height=capital, energy=net, operating_energy=held
        )
        per_joule = self.fixed_charge_rate * capital / net
        per_joule = per_joule + self.annual_operating_expenses(held) / held
        return np.asarray(JOULES_PER_MWH * per_joule)

    def _nose_cone_mass(self) -> float:
        return 18.5 * self.rotor_diameter - 520.5

    def _bearing_mass(self) -> float:
        d = self.rotor_diameter
        return float((8.0 / 600.0 * d - 0.033) * 0.0092 * d**2.5)

    def _turbine_costs(self) -> dict[str, float]:
        """Rotor, drive train and nacelle, in dollars of 2002."""
        power, d, radius = self.rated_power / 1e3, self.rotor_diameter, self.rotor_diameter / 2.0
        material = 0.4019 * radius**3 - _BLADE[self.blade_design][2]
        labour = 2.7445 * radius**2.5025
        return {
            # materials and labour are 72 % of a blade's cost
            "blades": _BLADES * (material + labour) / (1.0 - 0.28),
            "hub": 4.25 * (0.954 * self.blade_mass + 5680.3),
            "pitch system": 2.28 * 0.2106 * d**2.6578,
            "nose cone": 5.57 * self._nose_cone_mass(),
            "low-speed shaft": self.low_speed_shaft_factor * d**2.887,
            "main bearings": 17.6 * 2.0 * self._bearing_mass(),
            "gearbox": 16.45 * power**1.249,
            "brake and coupling": 1.9894 * power - 0.1141,
            "generator": 65.0 * power,
            "variable-speed electronics": 79.0 * power,
            "yaw system": 2.0 * 0.0339 * d**2.964,
            "mainframe": 9.489 * d**1.953,
            "platforms": 8.7 * _PLATFORM_SHARE * 2.233 * d**1.953,
            "electrical connections": 40.0 * power,
            "hydraulics and cooling": 12.0 * power,
            "nacelle cover": 11.537 * power + 3849.7,
            "control and monitoring": 35000.0,
        }

    def _site_costs(self) -> dict[str, float]:
        """Balance of station that no tower changes, in dollars of 2002."""
        power = self.rated_power / 1e3
        return {
            "transport": power * (1.581e-5 * power**2 - 0.0375 * power + 54.7),
            "roads and civil work": power * (2.17e-6 * power**2 - 0.0145 * power + 69.54),
            "electrical interface": power * (3.49e-6 * power**2 - 0.0221 * power + 109.7),
            "engineering and permits": power * (9.94e-4 * power + 20.31),
        }
