"""The whole study on loads in closed form: phases, truth, counts of sets, resumption."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from tower_factories import SETTINGS, ClosedSets

from pitchopt.errors import ComputationError, InputError
from pitchopt.studies.tower import (
    LoadSettings,
    TowerLimits,
    TowerStudySettings,
    run_tower_study,
    size_tower,
    tower_document,
)

SMALL = TowerStudySettings(
    loads=SETTINGS, weights=(0.0, 0.03, 0.3), height_factors=(0.9, 1.0, 1.1, 1.2), threshold=0.002
)
PHASES = [
    "reference tower", "damage over c", "heights at c = 0", "towers over c",
    "lowest cost without co-design", "lowest cost with co-design", "map of the true cost",
]  # fmt: skip


@pytest.fixture(scope="module")
def done(turbine, weibull_loads):
    """Study, its sets, sets asked for by configuration and phase."""
    sets = ClosedSets(turbine, weibull_loads, coupling=0.3, lift=1.2)
    begun: list[tuple[str, str, int]] = []
    told: list[tuple[float, float]] = []
    study = run_tower_study(
        sets, SMALL,
        on_phase=lambda name, what: begun.append((name, what, len(sets.asked))),
        on_round=lambda height, weight, _: told.append((height, weight)),
    )  # fmt: skip
    ends = [at for *_, at in begun[1:]] + [len(sets.asked)]
    asked = {
        (name, what): sets.asked[at:end] for (name, what, at), end in zip(begun, ends, strict=True)
    }
    return study, sets, asked, told


@pytest.fixture(params=["standard", "soft-soft"])
def part(request, done):
    return done[0].results[request.param]


def test_phases_in_their_order(done):
    assert list(done[2]) == [(name, what) for name in ("standard", "soft-soft") for what in PHASES]
    assert all(
        height in {99.0, 110.0, 121.0, 132.0} or 99.0 < height < 132.0 for height, _ in done[3]
    )


def test_truth_is_sized_for_its_own_loads(done, part, turbine):
    """Against a sizing from elsewhere, under the loads of the tower that it answers with."""
    _, sets, *_ = done
    limits = part.reference.sizing.limits
    assert (limits.frequency_margin is None) is (part.configuration == "soft-soft")
    for tower, weight in zip(part.truth, SMALL.weights, strict=True):
        assert (tower.hub_height, tower.tower_velocity) == (110.0, weight)
        assert tower.converged
        factor = sets.factor(tower.simulated, weight)
        alone = size_tower(110.0, sets.loads(factor), limits, turbine)
        assert tower.mass == pytest.approx(alone.mass, rel=1e-5)
        assert tower.design.change_from(tower.simulated) <= SMALL.threshold
    assert part.truth[0] is part.reference
    np.testing.assert_allclose(
        part.true_change, [tower.mass - part.reference.mass for tower in part.truth]
    )
    assert part.true_change[0] == 0.0


def test_efforts_count_the_sets_of_their_phases(done, part):
    asked = {what: done[2][part.configuration, what] for what in PHASES}
    estimate = {key for what in PHASES[:3] for key in asked[what]}
    without, codesign = set(asked[PHASES[4]]), set(asked[PHASES[5]])
    for effort, keys in (
        (part.estimate_effort, estimate),
        (part.without_effort, without),
        (part.codesign_effort, codesign),
    ):
        assert effort.sets == len(keys) > 4
        # each set took two seconds when it was simulated, found again or not
        assert 2.0 * len(keys) < effort.seconds < 2.0 * len(keys) + 20.0
    assert part.estimate_effort.iterations == 0
    for found, effort in (
        (part.without, part.without_effort),
        (part.with_codesign, part.codesign_effort),
    ):
        assert effort.iterations == found.search.iterations > 0


def test_estimated_maps_begin_with_the_towers_at_no_weight(done, part):
    study = done[0]
    true = part.true_map
    first, high = (part.estimated_maps[kind] for kind in ("first-order", "high-order"))
    for costs in (first, high):
        np.testing.assert_allclose(costs.mass[:, 0], true.mass[:, 0], rtol=1e-12)
        np.testing.assert_allclose(costs.cost[:, 0], true.cost[:, 0], rtol=1e-12)
        np.testing.assert_allclose(costs.heights, 110.0 * np.array(SMALL.height_factors))
    np.testing.assert_allclose(first.mass[:, :2], high.mass[:, :2], rtol=1e-9)  # at the step
    np.testing.assert_allclose(high.mass[1] - part.reference.mass, part.estimates.high_order)
    np.testing.assert_allclose(true.mass[1], [tower.mass for tower in part.truth])
    np.testing.assert_allclose(
        true.cost,
        study.economics.cost(true.heights[:, None], true.mass, true.energy),
    )
    assert part.reference_cost == pytest.approx(true.cost[1, 0])
    assert part.reference_energy == pytest.approx(true.energy[1, 0])


def test_searches_find_what_the_map_shows(done, part):
    """Lowest costs beside those of the map between its points."""
    true = part.true_map
    assert part.without.tower.tower_velocity == 0.0
    assert part.without.search.points.shape[1] == 1
    assert part.with_codesign.search.points.shape[1] == 2
    height, _, cost = true.lowest(0.0)
    assert part.without.cost == pytest.approx(cost, rel=2e-4)
    assert part.without.tower.hub_height == pytest.approx(height, abs=3.0)
    assert part.with_codesign.cost <= true.cost.min() * (1.0 + 1e-4)
    assert part.with_codesign.cost <= part.without.cost * (1.0 + 1e-9)
    changes = part.cost_change
    assert changes["co-design"] == part.with_codesign.cost / part.without.cost - 1.0
    for kind, costs in part.estimated_maps.items():
        _, _, cost = costs.fine()
        assert changes[kind] == pytest.approx(cost.min() / cost[:, 0].min() - 1.0, rel=1e-12)
    assert changes["first-order"] < changes["high-order"] <= 0.0


def test_codesign_answers_belong_together(done, part):
    study = done[0]
    for found in (part.without, part.with_codesign):
        tower = found.tower
        weight = 0.3 * found.search.x[1] ** 2 if found.search.x.size == 2 else 0.0
        assert tower.hub_height == pytest.approx(110.0 * found.search.x[0])
        assert tower.tower_velocity == pytest.approx(weight)
        energy = float(study.economics.energy(tower.hub_height, tower.load_set))
        assert found.energy == energy
        assert found.cost == float(study.economics.cost(tower.hub_height, tower.mass, energy))


def test_soft_soft_gains_more(done):
    """Frequency holds the standard tower, not fatigue."""
    standard, soft = (done[0].results[name] for name in ("standard", "soft-soft"))
    assert standard.reference.sizing.multipliers.frequency[0] > 0.0
    assert soft.reference.sizing.multipliers.frequency.size == 0
    assert soft.reference.mass < standard.reference.mass
    assert soft.true_change[-1] < 3.0 * standard.true_change[-1] < 0.0
    assert soft.cost_change["co-design"] < standard.cost_change["co-design"]


def timeless(value):
    """A document without clocks and counts of what was simulated."""
    skipped = ("seconds", "sets_simulated")
    if isinstance(value, dict):
        if str(value.get("quantity", "")).startswith("time of"):
            return None
        return {key: timeless(item) for key, item in value.items() if key not in skipped}
    if isinstance(value, list | tuple):
        return [timeless(item) for item in value]
    return value.tolist() if isinstance(value, np.ndarray) else value


@pytest.mark.slow
def test_study_that_is_taken_up_simulates_nothing(done, turbine, weibull_loads):
    study, sets, *_ = done
    assert study.sets_simulated == sets.simulated == len(set(sets.asked))
    again = run_tower_study(sets, SMALL)
    assert again.sets_simulated == 0
    assert sets.simulated == study.sets_simulated
    assert timeless(tower_document(again)) == timeless(tower_document(study))
    for name, part in again.results.items():
        assert part.estimate_effort.sets == study.results[name].estimate_effort.sets
        assert part.codesign_effort.sets == study.results[name].codesign_effort.sets


@pytest.mark.slow
def test_study_that_was_stopped_asks_for_the_rest_alone(done, turbine, weibull_loads):
    """Stopped in the middle of a phase; the two together simulate each set once."""
    _, whole, *_ = done
    sets = ClosedSets(turbine, weibull_loads, coupling=0.3, lift=1.2)
    original = sets.run

    def stopping(design, weight):
        if sets.simulated == 20:
            raise KeyboardInterrupt
        return original(design, weight)

    sets.run = stopping
    alone = dataclasses.replace(SMALL, configurations=("standard",), true_map=False)
    with pytest.raises(KeyboardInterrupt):
        run_tower_study(sets, alone)
    sets.run = original
    study = run_tower_study(sets, alone)
    assert study.sets_simulated == sets.simulated - 20
    assert set(sets.asked) <= set(whole.asked)
    assert study.results["standard"].true_map is None


def test_sets_of_other_settings(turbine, weibull_loads):
    sets = ClosedSets(turbine, weibull_loads)
    with pytest.raises(InputError, match="sets: got load settings other than"):
        run_tower_study(sets, dataclasses.replace(SMALL, loads=LoadSettings()))
    assert sets.asked == []


def test_heights_that_are_too_low_are_refused_at_once(turbine, weibull_loads):
    sets = ClosedSets(turbine, weibull_loads)
    with pytest.raises(InputError, match=r"height_factors: got 0\.5 of 110 m, expected .* 60 m"):
        run_tower_study(sets, dataclasses.replace(SMALL, height_factors=(0.5, 1.0, 1.1)))
    assert sets.asked == []


def test_tower_that_cannot_be_made_ends_the_study(turbine, weibull_loads):
    with pytest.raises(ComputationError, match="no standard tower at a hub height of 110 m"):
        run_tower_study(ClosedSets(turbine, weibull_loads, base=64e6), SMALL)


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"configurations": ()}, "configurations"),
        ({"configurations": ("soft",)}, "configurations"),
        ({"limits": TowerLimits(frequency_margin=None)}, "frequency margin"),
        ({"weights": (0.03, 0.1, 0.3)}, "weights"),
        ({"weights": (0.0, 0.03)}, "weights"),
        ({"weights": (0.0, 0.3, 0.03)}, "weights"),
        ({"weights": (0.0, 0.03, float("nan"))}, "weights"),
        ({"step": 0.05}, "step"),
        ({"step": 0.0}, "step"),
        ({"height_factors": (0.9, 1.1, 1.2)}, "height_factors"),
        ({"height_factors": (0.9, 1.0)}, "height_factors"),
        ({"height_factors": (1.1, 1.0, 0.9)}, "height_factors"),
        ({"threshold": 0.0}, "threshold"),
        ({"threshold": 0.02}, "threshold"),
    ],
)
def test_bad_settings(change, words):
    with pytest.raises(InputError, match=words):
        dataclasses.replace(SMALL, **change)


def test_soft_soft_alone_needs_no_margin():
    limits = TowerLimits(frequency_margin=None)
    made = TowerStudySettings(limits=limits, configurations=("soft-soft",))
    assert made.limits.frequency_margin is None
