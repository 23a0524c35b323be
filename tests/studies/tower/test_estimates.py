"""Estimates from multipliers against closed forms, and against towers sized anew."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from tower_factories import SETTINGS, SLOPE, ClosedSets

from pitchopt.errors import InputError
from pitchopt.studies.tower import (
    CostMap,
    CostModel,
    Economics,
    TowerLimits,
    Towers,
    cost_estimates,
    mass_estimates,
    size_tower,
    station_damage,
    station_joints,
)

SOFT = TowerLimits(frequency_margin=None)
WEIGHTS = np.array([0.0, 0.03, 0.1, 0.2, 0.3])


@pytest.fixture(scope="module")
def solved(turbine, weibull_loads):
    """Towers, that of the reference height and c = 0, and its estimates."""
    sets = ClosedSets(turbine, weibull_loads)
    towers = Towers(sets, SOFT)
    reference = towers.at(110.0, 0.0)
    asked = len(sets.asked)
    changes = mass_estimates(towers, reference, WEIGHTS, step=0.03)
    return sets, towers, reference, changes, sets.asked[asked:]


def powers(sets, weights):
    """Damage over that at c = 0."""
    return np.array([sets.controller(c) for c in weights]) ** SLOPE


def price(tower):
    """Sum of the multipliers of fatigue."""
    return float(tower.sizing.multipliers.fatigue.sum())


def test_damage_is_a_power_of_the_moment(solved):
    sets, _, reference, changes, _ = solved
    np.testing.assert_allclose(
        changes.damage_change,
        np.broadcast_to(powers(sets, WEIGHTS)[:, None] - 1.0, changes.damage.shape),
        rtol=2e-4, atol=1e-12,
    )  # fmt: skip
    np.testing.assert_array_equal(
        changes.damage[0], station_damage(reference.design, reference.load_set)
    )


def test_estimates_by_hand(solved):
    """lambda dD summed over the joints; stations with a multiplier have a damage of one."""
    sets, _, reference, changes, _ = solved
    change = powers(sets, WEIGHTS) - 1.0
    np.testing.assert_allclose(changes.high_order, price(reference) * change, rtol=3e-4, atol=1e-9)
    np.testing.assert_allclose(
        changes.first_order, price(reference) * WEIGHTS / 0.03 * change[1], rtol=3e-4, atol=1e-9
    )
    assert changes.high_order[0] == changes.first_order[0] == 0.0
    assert changes.first_order[1] == pytest.approx(changes.high_order[1], rel=1e-9)


def test_first_order_overstates_what_saturates(solved):
    _, _, _, changes, _ = solved
    assert np.all(changes.first_order[2:] < changes.high_order[2:])
    assert np.all(changes.high_order[1:] < 0.0)


def test_each_weight_takes_a_set_on_the_simulated_design(solved):
    sets, towers, reference, changes, asked = solved
    assert len(set(asked)) == len(asked) == WEIGHTS.size - 1
    for weight, key in zip(WEIGHTS[1:], asked, strict=True):
        assert sets.run(reference.simulated, float(weight)).key == key
        assert key in towers.used
    assert len(changes.estimates) == WEIGHTS.size - 1


def test_joints_are_the_rows_of_fatigue(solved):
    _, _, reference, changes, _ = solved
    rows = reference.sizing.rows
    place = rows.of("fatigue")
    np.testing.assert_allclose(changes.joint_damage[0] - 1.0, rows.value[place], atol=1e-12)
    worst = np.zeros(SETTINGS.stations)
    for station, value in zip(rows.place[place], changes.joint_damage[0], strict=True):
        worst[station] = max(worst[station], value)
    np.testing.assert_array_equal(worst, changes.damage[0])
    joints = station_joints(SETTINGS.stations, 10)
    np.testing.assert_array_equal(joints.station, rows.place[place])


def test_estimates_are_tangent_to_the_truth(turbine, weibull_loads, solved):
    """The difference to towers sized anew falls with the square of the change."""
    reference, price_ = solved[2], price(solved[2])
    errors = []
    for a in (0.08, 0.04, 0.02):
        sets = ClosedSets(turbine, weibull_loads, a=a)
        estimate = price_ * ((1.0 - 0.5 * a) ** SLOPE - 1.0)
        truth = size_tower(110.0, sets.loads(1.0 - 0.5 * a), SOFT, turbine, reference.design)
        assert truth.converged
        errors.append(truth.mass - reference.mass - estimate)
        assert abs(errors[-1]) < 1.5 * a * abs(estimate)
    assert abs(errors[0]) > 3.0 * abs(errors[1]) > 8.0 * abs(errors[2])
    # damage falls slower and slower with the walls: the truth saves more than the estimate
    assert max(errors) < 0.0


@pytest.mark.parametrize("limit", [1.0, 0.25])
def test_cost_maps_by_hand(turbine, weibull_loads, limit):
    """Equation (16): multipliers of the height, damage of the reference height."""
    sets = ClosedSets(turbine, weibull_loads, lift=0.5, coupling=0.2)
    towers = Towers(sets, dataclasses.replace(SOFT, largest_damage=limit))
    solved = {h: towers.at(h, 0.0) for h in (99.0, 110.0, 121.0)}
    reference = solved[110.0]
    changes = mass_estimates(towers, reference, WEIGHTS, step=0.03)
    economics = Economics(
        model=CostModel(rated_power=3.37e6, rotor_diameter=130.0, hub_height=110.0),
        settings=SETTINGS,
        operating_energy=14e3 * 3.6e9,
    )
    unknown = dataclasses.replace(changes, load_response=None)
    assert "with response" not in cost_estimates(solved, unknown, economics)
    known = dataclasses.replace(changes, load_response=0.25)
    maps = cost_estimates(solved, known, economics)
    first, high, followed = (maps[k] for k in ("first-order", "high-order", "with response"))
    change = powers(sets, WEIGHTS) - 1.0
    linear = WEIGHTS / 0.03 * change[1]
    # active stations have a damage of the limit, so that lambda dD / limit is lambda (f^4 - 1)
    for found, part in ((first, linear), (high, change)):
        for k, (height, tower) in enumerate(solved.items()):
            assert tower.sizing.limits.largest_damage == limit
            kept = tower.sizing.row_multipliers[tower.sizing.rows.of("fatigue")]
            expected = part * float(kept @ changes.joint_damage[0]) / limit
            np.testing.assert_allclose(
                found.mass[k] - tower.mass, expected, rtol=3e-4, atol=1e-6 * abs(tower.mass)
            )
            energy = float(economics.energy(height, tower.load_set))
            np.testing.assert_array_equal(found.energy[k], energy)
            np.testing.assert_allclose(
                found.cost[k], economics.cost(height, found.mass[k], energy), rtol=1e-14
            )
        np.testing.assert_array_equal(found.heights, [99.0, 110.0, 121.0])
        np.testing.assert_array_equal(found.weights, WEIGHTS)
    np.testing.assert_allclose(high.mass[1] - reference.mass, changes.high_order, rtol=1e-8)
    for k, tower in enumerate(solved.values()):
        np.testing.assert_allclose(
            (followed.mass[k] - tower.mass) * 0.75, high.mass[k] - tower.mass, atol=1e-6
        )
    np.testing.assert_allclose(first.mass[1] - reference.mass, changes.first_order, rtol=1e-8)


@pytest.mark.parametrize(
    ("weights", "step"),
    [
        ([0.03, 0.1], 0.03),
        ([0.0, 0.1, 0.1], 0.1),
        ([0.0, 0.1, 0.05], 0.1),
        ([0.0, 0.1, 0.2], 0.03),
        ([0.0, np.nan, 0.2], 0.2),
    ],
)
def test_bad_weights(solved, weights, step):
    sets, towers, reference, *_ = solved
    asked = len(sets.asked)
    with pytest.raises(InputError, match="weights"):
        mass_estimates(towers, reference, weights, step=step)
    assert len(sets.asked) == asked


def test_reference_of_another_weight(solved):
    _, towers, reference, *_ = solved
    other = dataclasses.replace(reference, tower_velocity=0.1)
    with pytest.raises(InputError, match=r"reference: got one with c = 0\.1"):
        mass_estimates(towers, other, WEIGHTS, step=0.03)


HEIGHTS = np.array([99.0, 110.0, 121.0, 132.0])


class Shared:
    """Costs that are mass over energy."""

    def cost(self, hub_height, mass, energy):
        return np.asarray(mass) / energy


def mass_at(h):
    return np.exp(0.02 * (h - 99.0))


def energy_at(h):
    return 1.0 + 0.05 * (h - 99.0) - 7e-4 * (h - 99.0) ** 2


def cost_map(share):
    """Mass exponential and energy quadratic in the height, which the map keeps exactly."""
    mass = mass_at(HEIGHTS[:, None]) * share(HEIGHTS[:, None], WEIGHTS)
    energy = energy_at(HEIGHTS[:, None]) + 0.0 * WEIGHTS
    return CostMap(heights=HEIGHTS, weights=WEIGHTS, mass=mass, energy=energy, economics=Shared())


def test_map_between_its_points():
    made = cost_map(lambda h, c: 1.0 - 0.2 * c / (c + 0.05) + 0.0 * h)
    h, _, cost = made.fine(331)
    np.testing.assert_allclose(h, np.linspace(99.0, 132.0, 331))
    np.testing.assert_allclose(cost[:, 0], mass_at(h) / energy_at(h), rtol=1e-12)
    np.testing.assert_allclose(cost[::110, ::110][:, 1], made.cost[:, 2], rtol=1e-12)  # c = 0.1
    np.testing.assert_allclose(cost[::110, ::110][:, 2], made.cost[:, 3], rtol=1e-12)
    assert np.all(np.diff(cost, axis=1) < 0.0)


def test_saving_at_one_height_makes_no_cost_at_another():
    """A limit that comes between two heights: savings end there and do not turn round."""
    made = cost_map(lambda h, c: 1.0 - 0.06 * c * (h < 105.0))
    _, _, cost = made.fine()
    assert np.all(np.diff(cost, axis=1) <= 1e-12)
    assert np.all(cost[-150:, -1] == pytest.approx(cost[-150:, 0], rel=1e-12))


def test_map_of_many_heights_does_not_swing():
    """Energies are averages over seeds, off by 1e-4; a polynomial makes 40 times that of it."""
    heights = np.linspace(99.0, 132.0, 11)
    noise = 1e-4 * (-1.0) ** np.arange(11)
    energy = np.repeat((energy_at(heights) * (1.0 + noise))[:, None], WEIGHTS.size, axis=1)
    mass = np.repeat(mass_at(heights)[:, None], WEIGHTS.size, axis=1)
    made = CostMap(heights=heights, weights=WEIGHTS, mass=mass, energy=energy, economics=Shared())
    h, _, cost = made.fine(331)
    np.testing.assert_allclose(cost[:, 0], mass_at(h) / energy_at(h), rtol=5e-4)


def test_lowest_of_a_map():
    made = cost_map(lambda h, c: 1.0 - 0.1 * np.sqrt(c) + 0.0 * h)
    h = np.linspace(99.0, 132.0, 100001)
    every = mass_at(h) / energy_at(h)
    k = int(np.argmin(every))
    assert 0 < k < h.size - 1
    height, weight, cost = made.lowest()
    assert height == pytest.approx(h[k], abs=0.07)  # points are 0.1375 m apart
    assert weight == 0.3
    assert cost == pytest.approx(every[k] * (1.0 - 0.1 * np.sqrt(0.3)), rel=1e-5)
    for c in WEIGHTS[[0, 2, 3]]:
        height, weight, cost = made.lowest(float(c))
        assert weight == pytest.approx(c, abs=1e-12)
        assert cost == pytest.approx(every[k] * (1.0 - 0.1 * np.sqrt(c)), rel=1e-5)


@pytest.fixture(scope="module")
def followed(turbine, weibull_loads):
    """Moments that grow with the root of the tower's mass."""
    sets = ClosedSets(turbine, weibull_loads, coupling=0.5)
    towers = Towers(sets, SOFT, threshold=1e-3)
    reference = towers.at(110.0, 0.0)
    return sets, towers, reference, mass_estimates(towers, reference, WEIGHTS, step=0.03)


def test_response_of_the_loads_is_the_slope_of_the_sized_mass(followed):
    """Beside sizings for the loads of a heavier and a lighter design."""
    sets, _, reference, changes = followed
    masses = []
    for factor in (0.99, 1.01):
        design = dataclasses.replace(
            reference.design,
            diameter=reference.design.diameter * factor,
            thickness=reference.design.thickness * factor,
        )
        found = sets.run(design, 0.0)
        sized = size_tower(110.0, found.loads, SOFT, sets.reference, start=reference.design)
        masses.append((design.mass, sized.mass))
    (m0, s0), (m1, s1) = masses
    slope = (s1 - s0) / (m1 - m0)
    assert slope > 0.2
    assert reference.load_response == changes.load_response == pytest.approx(slope, rel=0.1)


def test_estimates_with_response_are_closer_to_towers_sized_anew(followed):
    _, towers, reference, changes = followed
    truth = np.array([towers.at(110.0, c).mass for c in WEIGHTS]) - reference.mass
    high, with_response = changes.high_order[1:], changes.with_response[1:]
    np.testing.assert_array_less(np.abs(with_response - truth[1:]), 0.4 * np.abs(high - truth[1:]))
    np.testing.assert_array_less(truth[1:], high)  # frozen loads leave savings out


def test_response_is_not_known_from_one_round(followed):
    reference = followed[2]
    alone = dataclasses.replace(reference, rounds=reference.rounds[-1:])
    assert alone.load_response is None
