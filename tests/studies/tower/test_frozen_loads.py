"""Iteration between loads and sizing, on loads that depend on the design in closed form."""

from __future__ import annotations

import functools

import numpy as np
import pytest
from tower_factories import ClosedSets

from pitchopt.errors import ComputationError, InputError
from pitchopt.studies.tower import (
    TowerLimits,
    optimal_tower,
    scaled_start,
    size_tower,
    station_damage,
)
from pitchopt.studies.tower import frozen_loads as module

SOFT = TowerLimits(frequency_margin=None)


@pytest.fixture
def sets(turbine, weibull_loads):
    def make(**values):
        return ClosedSets(turbine, weibull_loads, **values)

    return make


@pytest.fixture
def fine(monkeypatch):
    """Simulated designs without rounding, sizings to seven digits."""
    monkeypatch.setattr(module, "_DIGITS", 13)
    monkeypatch.setattr(module, "size_tower", exact)


exact = functools.partial(size_tower, tolerance=1e-7)


def plain(made, c, *, change):
    """Sizing and loads in turn until no size changes by more; the design and the sets it took."""
    design = scaled_start(made.reference, 110.0)
    for count in range(1, 60):
        sized = exact(110.0, made.run(design, c).loads, SOFT, made.reference, start=design)
        assert sized.converged
        if sized.design.change_from(design) <= change:
            return sized, count
        design = sized.design
    pytest.fail("no fixed point")


@pytest.mark.parametrize("coupling", [0.6, 0.9, -0.6])
def test_fixed_point_of_plain_iteration_in_fewer_sets(sets, fine, coupling):
    expected, _ = plain(sets(coupling=coupling), 0.1, change=1e-8)
    _, slow = plain(sets(coupling=coupling), 0.1, change=1e-5)
    made = sets(coupling=coupling)
    found = optimal_tower(made, SOFT, 110.0, 0.1, threshold=1e-5, rounds=30)
    assert found.converged
    assert found.mass == pytest.approx(expected.mass, rel=1e-5)
    assert found.design.change_from(expected.design) < 2e-5
    assert len(made.asked) == len(found.rounds) < slow


@pytest.mark.parametrize("coupling", [0.6, -0.6])
def test_fixed_point_to_a_millionth(sets, fine, coupling):
    expected, _ = plain(sets(coupling=coupling), 0.0, change=1e-8)
    found = optimal_tower(sets(coupling=coupling), SOFT, 110.0, 0.0, threshold=1e-6, rounds=30)
    assert found.mass == pytest.approx(expected.mass, rel=1e-6)
    assert found.design.change_from(expected.design) < 1e-6


@pytest.mark.parametrize("threshold", [0.05, 0.01, 0.002])
def test_threshold(sets, threshold):
    told = []
    made = sets(coupling=0.8)
    found = optimal_tower(made, SOFT, 110.0, 0.0, threshold=threshold, on_round=told.append)
    changes = [turn.change for turn in found.rounds]
    assert found.converged
    assert changes[-1] <= threshold < min(changes[:-1])
    assert tuple(told) == found.rounds
    assert [turn.key for turn in found.rounds] == made.asked
    assert found.rounds[-1].mass == found.mass == found.sizing.mass == found.design.mass
    assert found.design.change_from(found.simulated) == changes[-1]
    assert found.load_set is made.run(found.simulated, 0.0)
    # safe under the loads of the simulated design, which are frozen
    assert station_damage(found.design, found.load_set).max() <= 1.0 + 1e-5
    assert found.sizing.constraints.largest[2] < 1e-5


def test_loads_that_ignore_the_design_take_two_sets(sets):
    found = optimal_tower(sets(), SOFT, 110.0, 0.0)
    assert len(found.rounds) == 2
    # simulated designs are rounded to a hundredth of a millimetre
    assert found.rounds[1].change < 0.5e-5 / found.design.thickness.min() + 1e-6


@pytest.mark.parametrize("coupling", [0.0, 0.4, -0.4])
def test_threshold_below_the_rounding_of_designs(sets, coupling):
    """It ends as soon as a sized tower rounds to the simulated one."""
    found = optimal_tower(sets(coupling=coupling), SOFT, 110.0, 0.0, threshold=1e-6, rounds=30)
    assert found.converged
    assert found.rounds[-1].change > 1e-6
    np.testing.assert_allclose(found.design.thickness, found.simulated.thickness, atol=0.51e-5)
    np.testing.assert_allclose(found.design.diameter, found.simulated.diameter, atol=0.51e-5)


def test_iteration_that_does_not_contract_is_told(sets):
    """Loads that fall with the square of the mass: heavier and lighter in turn."""
    made = sets(coupling=-2.0, base=6e6)
    found = optimal_tower(made, SOFT, 110.0, 0.0, threshold=0.002, rounds=4)
    assert not found.converged
    assert len(found.rounds) == len(made.asked) == 4
    assert found.rounds[-1].change > 0.002
    masses = [turn.mass for turn in found.rounds]
    assert masses[0] < masses[2] < masses[1]


def test_start(sets, turbine):
    """From its own answer one set suffices; a start of another height is taken at the asked one."""
    first = optimal_tower(sets(coupling=0.5), SOFT, 110.0, 0.0, threshold=0.001)
    again = optimal_tower(sets(coupling=0.5), SOFT, 110.0, 0.0, threshold=0.002, start=first.design)
    assert len(again.rounds) == 1
    assert again.mass == pytest.approx(first.mass, rel=0.002)
    higher = optimal_tower(
        sets(coupling=0.5), SOFT, 115.0, 0.0, threshold=0.001, start=first.design
    )
    assert higher.hub_height == higher.design.hub_height == higher.simulated.hub_height == 115.0
    alone = optimal_tower(sets(coupling=0.5), SOFT, 115.0, 0.0, threshold=0.001)
    assert higher.mass == pytest.approx(alone.mass, rel=0.005)


def test_tower_that_cannot_be_made(sets):
    with pytest.raises(
        ComputationError,
        match=r"no soft-soft tower at a hub height of 110 m with c = 0\.1: .*missed: largest_dia",
    ):
        optimal_tower(sets(base=64e6), SOFT, 110.0, 0.1)
    with pytest.raises(ComputationError, match=r"no standard tower .*frequency"):
        optimal_tower(sets(), TowerLimits(frequency_margin=0.6), 110.0, 0.0)


@pytest.mark.parametrize(
    ("values", "words"),
    [
        ({"threshold": 0.0}, "threshold"),
        ({"threshold": float("nan")}, "threshold"),
        ({"rounds": 0}, "rounds"),
    ],
)
def test_bad_input(sets, values, words):
    made = sets()
    with pytest.raises(InputError, match=words):
        optimal_tower(made, SOFT, 110.0, 0.0, **values)
    assert made.asked == []
