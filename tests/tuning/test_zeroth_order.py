"""Zeroth-order tuner: its estimator in closed form, its limits, its line search and resets."""

from __future__ import annotations

import json

import numpy as np
import pytest
from driving import drive
from hypothesis import given
from hypothesis import strategies as st

from pitchopt.errors import ComputationError, InputError
from pitchopt.tuning import Outcome, Parameter, Space, ZerothOrder, settling


def box(size, low=-2.0, high=3.0):
    return Space([Parameter(name=f"z{i}", low=low, high=high) for i in range(size)])


class Quadratic:
    def __init__(self, size, seed=0):
        rng = np.random.default_rng(seed)
        root = rng.normal(size=(size, size))
        self.hessian = root @ root.T + 0.5 * np.eye(size)
        self.centre = rng.uniform(-1.0, 1.0, size)

    def __call__(self, x):
        away = x - self.centre
        return float(0.5 * away @ self.hessian @ away)

    def gradient(self, x):
        return self.hessian @ (x - self.centre)


def first_gradient(function, size, **settings):
    tuner = ZerothOrder(
        box(size), start=np.full(size, 0.7), radius=0.4, coordinates="own", stages=1, **settings
    )
    drive(tuner, function, 100)
    assert tuner.ask(1) == []
    return tuner.records[0].gradient, tuner.start


# --- the estimator (3) ---


def test_one_parameter_gives_the_central_difference():
    cubic = np.poly1d([1.0, -2.0, 0.5, 3.0])
    gradient, start = first_gradient(lambda x: float(cubic(x[0])), 1)
    expected = (cubic(start + 0.4) - cubic(start - 0.4)) / 0.8
    assert gradient == pytest.approx(expected, rel=1e-12)


@pytest.mark.parametrize("samples", [4, 5, 6, 9])
def test_from_four_even_directions_on_it_is_half_of_a_quadratics_gradient(samples):
    function = Quadratic(2)
    gradient, start = first_gradient(function, 2, samples=samples, seed=5)
    assert gradient == pytest.approx(function.gradient(start) / 2.0, rel=1e-12)


def test_three_directions_miss_it_by_a_vector_that_turns_with_the_first_angle():
    # (mu/2)(1/3) sum (phi' H phi) phi = mu A/4 exp(i (3 psi_0 - theta)): its length is constant,
    # its mean over psi_0 is zero
    function = Quadratic(2)
    (a, b), (_, c) = function.hessian
    size = 0.4 * np.hypot(0.5 * (a - c), b) / 4.0
    errors = []
    for seed in range(200):
        gradient, start = first_gradient(function, 2, samples=3, seed=seed)
        errors.append(gradient - function.gradient(start) / 2.0)
    assert np.linalg.norm(errors, axis=1) == pytest.approx(np.full(200, size), rel=1e-9)
    assert np.linalg.norm(np.mean(errors, axis=0)) < 4.0 * size / np.sqrt(200)


def test_orthogonal_directions_are_exact_for_a_quadratic_of_any_size():
    function = Quadratic(4)
    gradient, start = first_gradient(function, 4, samples=8, directions="orthogonal", seed=3)
    assert gradient == pytest.approx(function.gradient(start) / 4.0, rel=1e-12)


def test_random_directions_are_right_in_the_mean():
    function = Quadratic(3)
    found = []
    for seed in range(400):
        gradient, start = first_gradient(function, 3, samples=4, seed=seed)
        found.append(gradient)
    error = np.mean(found, axis=0) - function.gradient(start) / 3.0
    assert np.all(np.abs(error) < 4.0 * np.std(found, axis=0) / np.sqrt(400))


@pytest.mark.parametrize("samples", [2, 3, 7])
def test_directions_are_evenly_spaced_for_any_number_of_samples(samples):
    tuner = ZerothOrder(box(2), start=[0, 0], radius=0.3, samples=samples, coordinates="own")
    points = np.array([candidate.x for candidate in tuner.ask(100)])
    assert len(points) == samples + 1
    around = (points[1:] - points[0]) @ [1.0, 1.0j]
    assert np.abs(around) == pytest.approx(np.full(samples, 0.3))
    turns = np.mod(np.angle(around / np.roll(around, 1)), 2.0 * np.pi)
    assert turns == pytest.approx(np.full(samples, 2.0 * np.pi / samples))


def test_radii_of_their_own_are_the_same_as_other_units():
    function = Quadratic(2)
    stretch = np.array([1.0, 100.0])
    wide = Space([Parameter(name="a", low=-2, high=3), Parameter(name="b", low=-200.0, high=300.0)])
    plain = ZerothOrder(box(2), radius=[0.1, 0.2], coordinates="own", step=0.1, stages=4)
    other = ZerothOrder(
        wide,
        radius=[0.1, 20.0],
        coordinates="own",
        step=0.1,
        scaling=stretch**2,
        stages=4,
    )
    points = [candidate.x for candidate in drive(plain, function, 100)]
    others = [candidate.x for candidate in drive(other, lambda x: function(x / stretch), 100)]
    assert np.array(others) / stretch == pytest.approx(np.array(points), abs=1e-9)


@pytest.mark.slow
@given(factor=st.floats(1e-6, 1e9), seed=st.integers(0, 5))
def test_units_of_the_cost_do_not_matter(factor, seed):
    function = Quadratic(2, seed)
    plain = drive(ZerothOrder(box(2), stages=4, seed=seed), function, 100)
    other = drive(ZerothOrder(box(2), stages=4, seed=seed), lambda x: factor * function(x), 100)
    assert len(plain) == len(other)
    for a, b in zip(plain, other, strict=True):
        assert a.x == pytest.approx(b.x, abs=1e-8)


# --- limits, stages, line search, reset ---

MIXED = Space(
    [
        Parameter(name="a", low=-2.0, high=3.0),
        Parameter(name="l", low=1e-3, high=10.0, scale="log"),
        Parameter(name="p", low=0.0, high=6.0, periodic=True),
    ]
)


@pytest.mark.slow
@given(
    seed=st.integers(0, 10**6),
    unit=st.lists(st.floats(0.0, 1.0), min_size=3, max_size=3),
    radius=st.floats(0.01, 0.45),
    step=st.one_of(st.none(), st.floats(1e-3, 1e3)),
    coordinates=st.sampled_from(["unit", "own"]),
    line_search=st.sampled_from(["sequential", "parallel"]),
    directions=st.sampled_from(["random", "orthogonal"]),
    failing=st.floats(0.0, 1.0),
)
def test_limits_hold_and_costs_of_stages_never_grow(
    seed, unit, radius, step, coordinates, line_search, directions, failing
):
    width = np.ones(3) if coordinates == "unit" else MIXED.upper - MIXED.lower
    tuner = ZerothOrder(
        MIXED,
        start=MIXED.from_unit(unit),
        radius=radius * width,
        step=step,
        stages=5,
        coordinates=coordinates,
        line_search=line_search,
        directions=directions,
        seed=seed,
    )
    noise = np.random.default_rng(seed)

    def function(x):
        smooth = (x[0] - 1.0) ** 2 + np.log(x[1]) ** 2 + np.cos(x[2])
        return np.nan if noise.random() < 0.5 * failing else smooth + noise.normal()

    asked = drive(tuner, function, 1000, parallel=3)
    points = np.array([candidate.x for candidate in asked])
    assert np.all(points >= MIXED.lower)
    assert np.all(points <= MIXED.upper)
    assert len(asked) <= tuner.most_evaluations
    assert len(np.unique(points, axis=0)) == len(points)
    assert tuner.finished
    assert len(tuner.records) == 5
    inward = MIXED.to_unit if coordinates == "unit" else np.asarray
    low, high = inward(MIXED.lower) + tuner.radius, inward(MIXED.upper) - tuner.radius
    for record in tuner.records:
        z = inward(record.x)
        assert np.all((z >= low - 1e-9) & (z <= high + 1e-9) | MIXED.periodic)
    costs = tuner.stage_costs
    known = costs[np.flatnonzero(np.isfinite(costs))[0] :] if np.any(np.isfinite(costs)) else []
    assert np.all(np.diff(known) <= 0.0)


def test_an_accepted_step_is_the_first_that_satisfies_armijo_as_projected():
    function = Quadratic(2, seed=4)
    tuner = ZerothOrder(box(2), start=[2.5, -1.5], stages=8, coordinates="own", radius=0.1)
    drive(tuner, function, 1000)
    evaluated = {e.origin: e for e in tuner.evaluations}
    accepted = [record for record in tuner.records if not record.reset]
    assert len(accepted) >= 3
    first = None
    for record in accepted:
        for k in range(1, record.accepted + 1):
            point = evaluated.get(f"step {record.stage}.{k}")
            if point is None:  # projected to a point that is known
                continue
            expected = 0.05 * record.gradient @ (record.x - point.x)
            assert (record.cost - point.cost > expected > 0.0) == (k == record.accepted)
        first = first or record.step / 0.5 ** (record.accepted - 1)
        assert record.step == pytest.approx(first * 0.5 ** (record.accepted - 1))
    norm = np.linalg.norm(tuner.records[0].gradient)
    assert first * norm == pytest.approx(1.0)


def test_a_step_that_the_bounds_cut_short_is_judged_by_what_is_left_of_it():
    # linear, at the bound but for 0.01: the full step would promise far more than is gained
    tuner = ZerothOrder(
        box(1, 0.0, 1.0), start=[0.11], radius=0.1, step=10.0, stages=1, coordinates="own"
    )
    drive(tuner, lambda x: float(x[0]), 100)
    assert tuner.records[0].accepted == 1
    assert tuner.records[0].next_x == pytest.approx([0.1])


@pytest.mark.parametrize("stages", [1, 2])
def test_a_reset_stays_inside_the_shrunken_bounds_until_the_last_stage(stages):
    # the sample at 0.05 is best and steps end at 0.1, where there is a bump
    values = {0.15: 0.0, 0.05: -1.0, 0.25: 0.5, 0.1: 2.0}
    tuner = ZerothOrder(
        box(1, 0.0, 1.0), start=[0.15], radius=0.1, step=10.0, stages=stages, coordinates="own"
    )
    drive(tuner, lambda x: values[round(float(x[0]), 9)], 100)
    assert tuner.records[0].reset
    expected = 0.05 if stages == 1 else 0.15
    assert tuner.records[0].next_x == pytest.approx([expected])
    assert len(tuner.evaluations) == 4  # stage 2 is as stage 1, so nothing is evaluated twice


def test_a_reset_evaluates_the_projection_of_the_best_sample():
    # the gradient points up, steps fail, the sample below is best and lies outside
    def function(x):
        return {0.15: 0.0, 0.05: -1.0, 0.25: -2.0}.get(round(float(x[0]), 9), 1.0 + x[0])

    tuner = ZerothOrder(
        box(1, 0.0, 0.3), start=[0.15], radius=0.1, step=1e-3, stages=2, coordinates="own"
    )
    asked = drive(tuner, function, 7)
    assert asked[-1].origin == "reset 1"
    assert asked[-1].x == pytest.approx([0.2])
    drive(tuner, function, 1)
    assert tuner.records[0].next_x == pytest.approx([0.15])  # the projection is worse


def test_line_search_side_by_side_accepts_the_same_points():
    function = Quadratic(2, seed=1)
    one = ZerothOrder(box(2), stages=1, seed=2)
    other = ZerothOrder(box(2), stages=1, seed=2, line_search="parallel")
    drive(one, function, 100)
    for candidate in other.ask(10):
        other.tell(candidate, function(candidate.x))
    together = other.ask(10)
    assert [candidate.origin for candidate in together] == ["step 1.1", "step 1.2", "step 1.3"]
    for candidate in reversed(together):
        other.tell(candidate, function(candidate.x))
    assert other.finished
    assert one.records[0].accepted == other.records[0].accepted > 1
    assert np.array_equal(one.records[0].next_x, other.records[0].next_x)


def test_a_start_outside_of_the_shrunken_bounds_is_moved_inside():
    tuner = ZerothOrder(box(2), start=[-2.0, 3.0], radius=0.2, coordinates="own")
    assert tuner.start == pytest.approx([-1.8, 2.8])
    assert tuner.ask(1)[0].x == pytest.approx([-1.8, 2.8])


def test_a_periodic_parameter_goes_across_the_ends_of_its_period():
    space = Space([Parameter(name="p", low=0.0, high=360.0, periodic=True)])
    tuner = ZerothOrder(space, start=[20.0], radius=5.0, coordinates="own", step=1000.0, stages=8)
    drive(tuner, lambda x: -float(np.cos(np.radians(x[0] - 330.0))), 100)
    assert np.abs(np.mod(tuner.best().x - 330.0 + 180.0, 360.0) - 180.0) < 5.0
    assert all(0.0 <= e.x[0] < 360.0 for e in tuner.evaluations)


# --- what the paper does with it ---


def torque(x):
    power = 1.8e6 * (1.0 - 0.15 * (x[0] - 0.93) ** 2)
    return Outcome(cost=-power, measures={"power": power})


@pytest.mark.parametrize("over", ["cost", "power"])
def test_settings_of_the_papers_torque_gain(over):
    space = Space([Parameter(name="factor", low=0.3, high=1.7)])
    tuner = ZerothOrder(
        space,
        start=[0.5],
        radius=0.05,
        samples=2,
        stages=7,
        step=10.0,
        step_over=over,
        coordinates="own",
    )
    drive(tuner, torque, 1000)
    start = 1.8e6 * (1.0 - 0.15 * 0.43**2)
    accepted = [record for record in tuner.records if not record.reset]
    assert accepted[0].step == pytest.approx(10.0 / start * 0.5 ** (accepted[0].accepted - 1))
    assert len(tuner.evaluations) <= 31  # the paper's run
    assert tuner.best().x == pytest.approx([0.93], abs=0.05)
    settled = settling(tuner.stage_costs)
    assert settled[0] == 1.0
    assert settled[-1] == 0.0
    assert np.all(np.diff(settled) <= 0.0)
    assert settled[5] < 0.01  # after 5 stages


def test_where_no_step_helps_each_stage_takes_all_of_its_evaluations():
    # the count of the paper's settings, 1 + 7 (2 + 3), with other directions in every stage
    tuner = ZerothOrder(box(2), stages=7, samples=2, step=1e-3)
    rng = np.random.default_rng(0)
    count = 0
    while asked := tuner.ask(1):
        (candidate,) = asked
        kind = candidate.origin.split()[0]
        tuner.tell(candidate, {"start": 0.0, "search": 1.0 + rng.random(), "step": 9.0}[kind])
        count += 1
    assert count == 36
    assert tuner.most_evaluations == 36 + 6
    assert all(record.reset and record.next_cost == 0.0 for record in tuner.records)


def test_settling_of_a_run_that_gained_nothing():
    assert np.array_equal(settling([2.0, 2.0, 2.0]), np.zeros(3))
    assert np.array_equal(settling([4.0, 3.0, 2.0]), [1.0, 0.5, 0.0])
    with pytest.raises(InputError, match="costs"):
        settling([np.nan, 1.0])


def test_settings_are_plain_data():
    settings = ZerothOrder(MIXED, radius=0.02, step=2.0, step_over="power").settings()
    assert json.loads(json.dumps(settings)) == settings
    assert settings["samples"] == 4


# --- failures and constraints ---


def test_nothing_but_failures_ends_without_a_step():
    one = ZerothOrder(box(1), stages=5)
    assert len(drive(one, lambda _: np.nan, 100)) == 3
    two = ZerothOrder(box(2), stages=5)
    assert len(drive(two, lambda _: np.nan, 100)) == 1 + 5 * 3
    for tuner in (one, two):
        assert tuner.finished
        assert all(record.reset and not np.any(record.gradient) for record in tuner.records)
        with pytest.raises(ComputationError, match="none of"):
            tuner.best()


def test_the_gradient_points_away_from_a_failed_sample():
    tuner = ZerothOrder(box(1), start=[0.5], stages=1, radius=0.1, coordinates="own")
    drive(tuner, lambda x: np.nan if x[0] > 0.55 else 1.0, 4)
    assert tuner.evaluations[2].status == "failed"
    drive(tuner, lambda _: 1.0, 10)
    assert tuner.records[0].gradient[0] > 0.0
    for e in tuner.evaluations[3:]:
        assert e.x[0] < 0.5


def test_a_failed_start_is_left_for_the_best_sample():
    tuner = ZerothOrder(box(1), start=[0.0], stages=4, radius=0.1, coordinates="own")
    drive(tuner, lambda x: np.nan if abs(x[0]) < 0.05 else float((x[0] - 1.0) ** 2), 100)
    assert tuner.records[0].reset
    assert tuner.records[0].next_x == pytest.approx([0.1])
    assert tuner.best().x == pytest.approx([1.0], abs=0.15)


def test_it_finds_its_way_out_of_where_constraints_are_broken():
    def function(x):
        return Outcome(cost=float(x[0] + x[1]), constraints=(float(1.0 - x[0] * x[1]), -x[0]))

    tuner = ZerothOrder(box(2, 0.0, 3.0), start=[0.2, 0.4], stages=25, radius=0.03, seed=1)
    assert not tuner.evaluations
    drive(tuner, function, 1000)
    assert not tuner.evaluations[0].feasible
    best = tuner.best()
    assert best.evaluation.feasible
    assert best.cost < 2.6  # the least is 2 at (1, 1)


# --- input ---


@pytest.mark.parametrize(
    ("settings", "message"),
    [
        ({"radius": 0.0}, "radius"),
        ({"radius": 0.5}, "below half of its range"),
        ({"radius": [0.1, 0.1, 0.1]}, "radius"),
        ({"radius": "wide"}, "radius"),
        ({"samples": 1}, "directions"),
        ({"stages": 0}, "stages"),
        ({"step": -1.0}, "step"),
        ({"step_over": "power"}, "without a step"),
        ({"product": 0.0}, "product"),
        ({"scaling": [1.0, 0.0]}, "scaling"),
        ({"scaling": [1.0]}, "scaling"),
        ({"shrinkage": 1.0}, "shrinkage"),
        ({"threshold": 1.5}, "threshold"),
        ({"steps": 0}, "steps"),
        ({"directions": "sideways"}, "directions"),
        ({"coordinates": "polar"}, "coordinates"),
        ({"line_search": "none"}, "line_search"),
        ({"start": [9.0, 0.0]}, "z0 = 9"),
    ],
)
def test_bad_settings_are_named(settings, message):
    with pytest.raises(InputError, match=message):
        ZerothOrder(box(2), **settings)


def test_even_directions_are_for_one_and_two_parameters():
    with pytest.raises(InputError, match="even with 4 samples of 3"):
        ZerothOrder(box(3), directions="even")
    with pytest.raises(InputError, match="even with 3 samples of 1"):
        ZerothOrder(box(1), samples=3)


def test_a_measure_that_is_not_there_is_named():
    space = Space([Parameter(name="factor", low=0.3, high=1.7)])
    tuner = ZerothOrder(space, start=[0.5], step=10.0, step_over="load")
    with pytest.raises(InputError, match=r"'load'.*of: cost, power"):
        drive(tuner, torque, 10)
