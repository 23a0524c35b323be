"""Towers when they are asked for: starts, counts of sets, what was known."""

from __future__ import annotations

import numpy as np
import pytest
from tower_factories import ClosedSets

from pitchopt.studies.tower import TowerLimits, Towers
from pitchopt.studies.tower import towers as module

SOFT = TowerLimits(frequency_margin=None)


@pytest.fixture
def sets(turbine, weibull_loads):
    return ClosedSets(turbine, weibull_loads, coupling=0.4, lift=0.5)


@pytest.fixture
def starts(monkeypatch):
    """Starts that `optimal_tower` was given."""
    given = []
    original = module.optimal_tower

    def watched(*args, **options):
        given.append(options["start"])
        return original(*args, **options)

    monkeypatch.setattr(module, "optimal_tower", watched)
    return given


def test_sets_are_counted_once(sets):
    towers = Towers(sets, SOFT)
    tower = towers.at(110.0, 0.0)
    towers.at(110.0, 0.1)
    assert set(towers.used) == set(sets.asked)
    assert list(towers.used.values()) == [2.0] * sets.simulated
    assert towers.seconds == pytest.approx(2.0 * sets.simulated + towers.sizing_seconds)
    assert towers.sizing_seconds > 0.0
    asked = len(sets.asked)
    assert towers.at(110, 0) is tower
    assert len(sets.asked) == asked
    found = towers.loads_on(tower.simulated, 0.3)
    assert found.key in towers.used
    before = towers.seconds
    assert towers.loads_on(tower.simulated, 0.3) is found
    assert towers.seconds == before
    assert set(towers.used) == set(sets.asked)


def test_changes_over_the_weight_are_settled(turbine, weibull_loads):
    """Small gains as those of the study, 0.4 to 1.3 %, beside those of settled fixed points."""

    def masses(**options):
        towers = Towers(
            ClosedSets(turbine, weibull_loads, coupling=0.5, a=0.02, b=0.1), SOFT, **options
        )
        return np.array([towers.at(110.0, c).mass for c in (0.0, 0.03, 0.1, 0.2, 0.3)])

    exact = masses(threshold=1e-5)
    found = masses()
    np.testing.assert_allclose(found[1:] - found[0], exact[1:] - exact[0], rtol=0.06)
    coarse = masses(threshold=0.002)
    assert abs((coarse[1] - coarse[0]) / (exact[1] - exact[0]) - 1.0) > 0.2


def test_counts_of_two_are_their_own(sets):
    """Sets that another made count as when none had been kept."""
    first, second = Towers(sets, SOFT), Towers(sets, SOFT)
    first.at(110.0, 0.1)
    simulated = sets.simulated
    second.at(110.0, 0.1)
    assert sets.simulated == simulated
    assert first.used == second.used


def test_second_and_third_tower_start_from_the_closest(sets, starts):
    towers = Towers(sets, SOFT)
    for place in ((110.0, 0.0), (121.0, 0.0), (110.0, 0.3)):
        towers.at(*place)
    assert starts[0] is None
    assert starts[1] is towers.at(110.0, 0.0).design
    assert starts[2] is towers.at(110.0, 0.0).design


def test_later_towers_start_from_what_others_predict(sets, starts):
    """The corner of a grid whose other three are known, and where all but one height are."""
    towers = Towers(sets, SOFT, threshold=1e-3)
    for place in ((110.0, 0.0), (121.0, 0.0), (110.0, 0.3), (121.0, 0.3)):
        towers.at(*place)
    corner, closest = towers.at(121.0, 0.3).design, towers.at(121.0, 0.0).design
    assert starts[-1].change_from(corner) < 0.3 * closest.change_from(corner)
    for place in ((99.0, 0.0), (99.0, 0.3), (115.0, 0.0), (115.0, 0.3), (115.0, 0.1)):
        towers.at(*place)
    middle, closest = towers.at(115.0, 0.1).design, towers.at(115.0, 0.0).design
    assert starts[-1].change_from(middle) < 0.3 * closest.change_from(middle)


def test_known_towers_are_answers_and_cost_nothing(sets, starts):
    solved = Towers(sets, SOFT).at(110.0, 0.0)
    asked = len(sets.asked)
    towers = Towers(sets, SOFT, known=(solved,))
    assert towers.at(110.0, 0.0) is solved
    assert towers.used == {}
    assert towers.seconds == 0.0
    assert len(sets.asked) == asked
    towers.at(112.0, 0.0)
    assert starts[-1] is solved.design
    assert set(towers.used) == set(sets.asked[asked:])


def test_rounds_are_told_with_their_place(sets):
    told = []
    towers = Towers(sets, SOFT, threshold=0.01, on_round=lambda *args: told.append(args))
    tower = towers.at(115.0, 0.1)
    assert told == [(115.0, 0.1, turn) for turn in tower.rounds]
    assert tower.rounds[-1].change <= 0.01
