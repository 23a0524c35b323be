"""Limits: the projection is the nearest profile, and no loads make a learner break them."""

from __future__ import annotations

import itertools
from typing import Any

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from ilc_factories import SCALE, AffinePlant, make_learner
from scipy.optimize import linprog

from ilc import ActuatorLimits, Layout, Learner, LearningError

LAYOUTS = st.builds(
    Layout, blades=st.integers(1, 3), positions=st.integers(1, 4), separate=st.booleans()
)
PITCH = st.floats(-1.0, 1.0)
STEPS = st.one_of(st.just(0.0), st.floats(1e-3, 0.6), st.just(5.0))


def cases() -> st.SearchStrategy[tuple[Layout, ActuatorLimits, Any, Any, int]]:
    """Layout, limits, a profile in use that keeps them, a wish, a passage."""

    def build(layout: Layout, step: float, lower: float) -> st.SearchStrategy[Any]:
        limits = ActuatorLimits(lower=lower, upper=lower + 0.7, step=step)
        rows = arrays(np.float64, layout.variables, elements=PITCH)
        start = np.full(layout.variables, lower + 0.35)
        current = rows.map(lambda wish: limits.projected(layout, wish, start, 0))
        return st.tuples(st.just(layout), st.just(limits), current, rows, st.integers(0, 5))

    return st.builds(build, LAYOUTS, STEPS, PITCH).flatmap(lambda strategy: strategy)


def nearest(layout: Layout, limits: ActuatorLimits, wish: Any, current: Any, passage: int) -> float:
    """Smallest largest distance from the wish of any profile that keeps the limits, by an LP."""
    V, N, m = layout.variables, layout.stations, layout.positions
    rows, bounds = [], []
    for v in range(V):  # |x - wish| <= t
        for sign in (1.0, -1.0):
            row = np.zeros(V + 1)
            row[v], row[V] = sign, -1.0
            rows.append(row)
            bounds.append(sign * wish[v])
    for chain in range(0, V, N):  # |x[n + 1] - x[n]| <= step, across the wrap as well
        for n in range(N):
            for sign in (1.0, -1.0):
                row = np.zeros(V + 1)
                row[chain + (n + 1) % N] += sign
                row[chain + n] -= sign
                rows.append(row)
                bounds.append(limits.step)
    box = [[limits.lower, limits.upper] for _ in range(V)] + [[0.0, None]]
    for blade in range(layout.blades):  # from the last station in one profile to the other's next
        station = ((blade + passage) % layout.blades) * m
        chain = blade * N if layout.separate else 0
        before = current[chain + (station - 1) % N]
        box[chain + station][0] = max(limits.lower, before - limits.step)
        box[chain + station][1] = min(limits.upper, before + limits.step)
    cost = np.zeros(V + 1)
    cost[V] = 1.0
    solved = linprog(cost, A_ub=np.array(rows), b_ub=bounds, bounds=box, method="highs-ds")
    assert solved.status == 0
    return float(solved.fun)


@given(cases())
@settings(max_examples=150)
def test_projection_is_the_nearest_profile_that_keeps_the_limits(case: Any) -> None:
    layout, limits, current, wish, passage = case
    # what is out of range is first brought to its end
    wish = np.clip(wish, limits.lower, limits.upper)
    kept = limits.projected(layout, wish, current, passage)
    assert limits.violation(layout, kept, current, passage) <= 1e-14
    distance = np.abs(kept - wish).max()
    assert distance == pytest.approx(
        nearest(layout, limits, wish, current, passage), rel=1e-7, abs=1e-7
    )


@given(cases(), st.integers(0, 11))
def test_projection_leaves_what_keeps_the_limits(case: Any, missing: int) -> None:
    layout, limits, current, wish, passage = case
    kept = limits.projected(layout, wish, current, passage)
    np.testing.assert_array_equal(limits.projected(layout, kept, current, passage), kept)
    # the profile in use may always stay, and NaN stands for it
    holes = current.copy()
    holes[missing % holes.size] = np.nan
    for stay in (current, holes):
        np.testing.assert_array_equal(limits.projected(layout, stay, current, passage), current)


@given(cases(), st.integers(0, 200))
def test_violation_is_what_the_definition_says(case: Any, seed: int) -> None:
    layout, limits, current, _, passage = case
    profile = np.random.default_rng(seed).uniform(-1.5, 1.5, layout.variables)
    worst = [limits.lower - profile.min(), profile.max() - limits.upper]
    m, N = layout.positions, layout.stations
    chains = profile.reshape(-1, N)
    before = current.reshape(-1, N)
    for blade in range(layout.blades):
        chain = blade if layout.separate else 0
        worst += [
            abs(chains[chain, (n + 1) % N] - chains[chain, n]) - limits.step for n in range(N)
        ]
        station = ((blade + passage) % layout.blades) * m
        seam = abs(chains[chain, station] - before[chain, (station - 1) % N])
        worst.append(seam - limits.step)
    assert limits.violation(layout, profile, current, passage) == pytest.approx(
        max(worst), abs=1e-15
    )


def test_step_from_a_rate() -> None:
    limits = ActuatorLimits.from_rate(
        lower=0.0, upper=1.0, pitch_rate=np.deg2rad(10), rotor_speed=2.0, stations=72
    )
    # in a time of 2 pi / (72 x 2) s
    assert limits.step == pytest.approx(np.deg2rad(10) * 2 * np.pi / 144, rel=1e-15)


@pytest.mark.parametrize(
    ("changes", "name"),
    [
        ({"lower": 2.0}, "lower, upper"),
        ({"upper": np.nan}, "upper"),
        ({"step": -0.1}, "step"),
        ({"step": np.inf}, "step"),
    ],
)
def test_bad_limits_are_named(changes: dict[str, float], name: str) -> None:
    with pytest.raises(LearningError, match=name):
        ActuatorLimits(**({"lower": 0.0, "upper": 1.0, "step": 0.1} | changes))


WILD = st.one_of(
    st.floats(allow_nan=True, allow_infinity=True),
    st.sampled_from([np.nan, np.inf, -np.inf, 1e300, -1e300, 1e-300, 0.0, 1.7e308]),
    st.floats(-1e7, 1e7),
)


@pytest.mark.slow
@given(
    separate=st.booleans(),
    step=st.sampled_from([0.0, 1e-3, 0.02, 1.0]),
    delay=st.sampled_from([0, 1, 3]),
    wild_from=st.integers(0, 40),
    loads=st.lists(arrays(np.float64, (4, 3), elements=WILD, fill=WILD), min_size=1, max_size=12),
    start=st.floats(-0.05, 0.1),
)
@example(
    separate=False,
    step=1e-3,
    delay=0,
    wild_from=9,
    loads=[np.zeros((4, 3))],
    start=-0.049999999999999996,
)
@settings(max_examples=60)
def test_no_loads_make_a_learner_break_the_limits(
    learner_type: type[Learner],
    separate: bool,
    step: float,
    delay: int,
    wild_from: int,
    loads: list[Any],
    start: float,
) -> None:
    limits = ActuatorLimits(lower=-0.05, upper=0.1, step=step)
    plant = AffinePlant.random(3, blades=3, positions=3, separate=separate)
    layout = plant.layout
    learner = make_learner(plant, learner_type, limits=limits, start=start, delay=delay)
    before = layout.values(learner.profile)
    for number in range(60):
        wild = number >= wild_from
        exact = plant.passage(learner.profile, number)
        try:
            learner.tell(loads[number % len(loads)] if wild else exact)
        except LearningError:  # nothing could be learnt from such an experiment
            # or the actuators hardly move, from a start at the edge of the range
            assert wild or step <= 1e-3
            assert number + 1 == learner.experiment_passages
            break
        now = layout.values(learner.profile)
        assert np.isfinite(now).all()
        assert limits.violation(layout, now, before, number + 1) <= 1e-13
        before = now


@pytest.mark.parametrize(("reach", "step"), [(0.005, 0.2), (0.2, 0.004), (0.005, 0.004)])
def test_limits_bind_and_hold_while_learning(
    learner_type: type[Learner], reach: float, step: float
) -> None:
    plant = AffinePlant.random(8, positions=6)
    limits = ActuatorLimits(lower=-reach, upper=reach, step=step)
    learner = make_learner(plant, learner_type, limits=limits, setpoint=float(1.02 * SCALE[0]))
    profiles = [learner.profile]
    for number in range(60):
        learner.tell(plant.passage(learner.profile, number))
        profiles.append(learner.profile)
    excess = [
        limits.violation(plant.layout, new, old, number + 1)
        for number, (old, new) in enumerate(itertools.pairwise(profiles))
    ]
    assert max(excess) <= 1e-14
    last = profiles[-1]
    if reach < 0.1:
        most = np.abs(profiles[learner.experiment_passages + 1 :]).max()
        assert most == pytest.approx(reach, rel=1e-9)
    if step < 0.1:
        assert np.abs(last - np.roll(last, 1)).max() == pytest.approx(step, rel=1e-9)
