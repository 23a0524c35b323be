"""Cost of energy of a tower: equation (14), the site's wind, what follows the height."""

from __future__ import annotations

import dataclasses
import math

import numpy as np
import pytest
from tower_factories import SETTINGS, ClosedSets

from pitchopt.errors import InputError
from pitchopt.studies.tower import CostModel, Economics, scaled_start

MODEL = CostModel(rated_power=3.37e6, rotor_diameter=130.0, hub_height=110.0)
MWH = 3.6e9


@pytest.fixture
def found(turbine, weibull_loads):
    sets = ClosedSets(turbine, weibull_loads)
    return sets.run(scaled_start(turbine, 110.0), 0.0)


def with_power(found, power):
    return dataclasses.replace(found, power=np.array(power))


def test_equation_14_by_hand():
    reference = 14.9e3 * MWH
    economics = Economics(model=MODEL, settings=SETTINGS, operating_energy=reference)
    fixed = float(MODEL.initial_capital_cost(1.0)) - 1.5
    expenses = (0.007 + 0.00108) * reference / 3.6e6 + 10.7 * 3370.0  # $ a year
    for height, tonnes, energy in ((110.0, 331.07, 14.955), (120.0, 302.47, 15.014)):
        expected = 0.1158 * (fixed + 1.5 * 1e3 * tonnes) / (1e3 * energy)
        expected += expenses / (reference / MWH)
        cost = economics.cost(height, 1e3 * tonnes, 1e3 * energy * MWH)
        assert float(cost) == pytest.approx(expected, rel=1e-12)


def test_operating_expenses_are_held():
    """Twice the energy halves the capital's part alone."""
    economics = Economics(model=MODEL, settings=SETTINGS, operating_energy=14.9e3 * MWH)
    one, two = economics.cost(110.0, 3e5, np.array([14e3, 28e3]) * MWH)
    assert one - two == pytest.approx(
        0.5 * 0.1158 * float(MODEL.initial_capital_cost(3e5)) / 14e3, rel=1e-12
    )


def test_energy_of_constant_power_is_that_of_rayleigh(found):
    """Between cut-in and cut-out, at the height's own mean wind."""
    economics = Economics(model=MODEL, settings=SETTINGS, operating_energy=MWH)
    constant = with_power(found, [2e6, 2e6, 2e6])
    heights = np.array([99.0, 110.0, 132.0])
    energy = economics.energy(heights, constant)
    for height, value in zip(heights, energy, strict=True):
        mean = 7.5 * (height / 110.0) ** 0.2
        low, high = (math.exp(-math.pi / 4.0 * (v / mean) ** 2) for v in (5.0, 13.0))
        assert value == pytest.approx(2e6 * 8760.0 * 3600.0 * (low - high), rel=1e-10)


def test_energy_rises_with_height(found):
    economics = Economics(model=MODEL, settings=SETTINGS, operating_energy=MWH)
    energy = economics.energy(np.linspace(95.0, 135.0, 9), found)
    assert np.all(np.diff(energy) > 0.0)
    assert np.all(np.diff(energy, 2) < 0.0)


def test_height_alone_costs_nothing_unless_followed():
    for follow in (False, True):
        economics = Economics(
            model=MODEL, settings=SETTINGS, operating_energy=MWH, follow_height=follow
        )
        cost = economics.cost(np.array([99.0, 110.0, 121.0]), 3e5, 14e3 * MWH)
        assert cost.shape == (3,)
        if follow:
            assert np.all(np.diff(cost) > 0.0)
            higher = MODEL.initial_capital_cost(3e5, hub_height=121.0)
            more = float(higher - MODEL.initial_capital_cost(3e5))
            assert cost[2] - cost[1] == pytest.approx(0.1158 * more / 14e3, rel=1e-9)
        else:
            assert np.ptp(cost) == 0.0


def test_reference_of_a_turbine_and_a_set(turbine, found):
    economics = Economics.of(turbine, SETTINGS, found, follow_height=True)
    assert economics.follow_height
    assert economics.model.hub_height == turbine.rotor.hub_height == 110.0
    assert economics.model.rated_power == turbine.rated_power
    assert economics.model.rotor_diameter == 2.0 * turbine.rotor.radius
    assert economics.operating_energy == pytest.approx(float(economics.energy(110.0, found)))
    # at the reference energy the expenses are those of the model without a reference
    cost = economics.cost(110.0, 3e5, economics.operating_energy)
    plain = economics.model.cost_of_energy_per_mwh(3e5, economics.operating_energy)
    assert float(cost) == pytest.approx(float(plain), rel=1e-14)


@pytest.mark.parametrize("energy", [0.0, -1.0, math.nan, math.inf])
def test_reference_energy_has_to_be_positive(energy):
    with pytest.raises(InputError, match="operating_energy"):
        Economics(model=MODEL, settings=SETTINGS, operating_energy=energy)
