"""What holds for every learner: invariances, gaps, states that go on, input that is refused."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from ilc_factories import (
    SCALE,
    WEIGHTS,
    AffinePlant,
    Turncoat,
    make_learner,
    same_as,
    turned,
)

from ilc import AdaptiveLearner, Learner, LearningError, StateError, load_state, save_state


@pytest.mark.parametrize("separate", [False, True])
@pytest.mark.parametrize("shift", [1, 3, 8, 13])
def test_shift_of_the_azimuth_grid_rolls_the_profiles(
    learner_type: type[Learner], separate: bool, shift: int
) -> None:
    """Station n of the shifted grid is station n + shift of the first."""
    if separate and learner_type is AdaptiveLearner:
        pytest.skip("it moves all pitches after each passage, so the order of passages counts")
    plant = AffinePlant.random(16, positions=5, separate=separate)
    layout = plant.layout
    P = layout.tracked
    if separate:
        # position q stands at q + shift; every blade stays itself
        order = (np.arange(P) + shift) % P
        other = AffinePlant(layout, plant.offset[order], plant.jacobian[order])
    else:
        # position k reaches the stations k + shift, and past m the blades change places
        offset, jacobian = np.empty_like(plant.offset), np.empty_like(plant.jacobian)
        for k in range(P):
            turns, q = divmod(k + shift, P)
            offset[k] = plant.offset[q]
            jacobian[k] = np.roll(plant.jacobian[q], -turns, axis=1)
        other = AffinePlant(layout, offset, jacobian)
    one, two = make_learner(plant, learner_type), make_learner(other, learner_type)
    for learner, where in ((one, plant), (two, other)):
        turned(where, learner, learner.experiment_passages)
    for _ in range(30):
        # whole rotations: separate profiles meet the positions in another order within one
        turned(plant, one, 3)
        turned(other, two, 3)
        np.testing.assert_allclose(
            two.profile, np.roll(one.profile, -shift, axis=-1), **same_as(learner_type)
        )
    assert np.ptp(one.profile) > 0.01


@pytest.mark.parametrize("units", [[1e-6, 1e-6, 1e-6, 1e-3], [0.7376, 2.0, 1e3, 0.2248]])
def test_change_of_load_units_with_matching_weights(
    learner_type: type[Learner], units: list[float]
) -> None:
    plant = AffinePlant.random(17, positions=5)
    scale = np.array(units)
    other = AffinePlant(plant.layout, scale * plant.offset, scale[:, None] * plant.jacobian)
    one = make_learner(plant, learner_type)
    two = make_learner(
        other, learner_type, weights=WEIGHTS / scale, setpoint=float(scale[0] * SCALE[0])
    )
    for a, b in zip(turned(plant, one, 60), turned(other, two, 60), strict=True):
        np.testing.assert_allclose(a, b, **same_as(learner_type))


def test_passage_with_too_few_samples_keeps_the_profile_and_says_so(
    learner_type: type[Learner],
) -> None:
    plant = AffinePlant.random(19, positions=8)
    learner = make_learner(plant, learner_type)
    turned(plant, learner, learner.experiment_passages + 4)
    before, passage = learner.profile, learner.passages
    loads = plant.passage(before, passage)
    loads[:, 3:] = np.nan  # 3 of 8 are left
    learner.tell(loads)
    np.testing.assert_array_equal(learner.profile, before)
    assert learner.events == [(passage, "too few samples: profile kept")]
    turned(plant, learner, 1)
    assert np.abs(learner.profile - before).max() > 0


@pytest.mark.parametrize("short", [slice(0, 4), slice(3, 4)])
def test_few_samples_are_no_measure_of_the_ac_load(
    learner_type: type[Learner], short: slice
) -> None:
    """One sample has no deviation: it must not pass for the best profile that there was."""
    plant = AffinePlant.random(19, positions=8)
    learner = make_learner(plant, learner_type)
    turned(plant, learner, learner.experiment_passages + 30)
    best = learner.state()["guard.numbers"][0]
    for _ in range(3):  # a whole rotation
        loads = plant.passage(learner.profile, learner.passages)
        loads[short, 1:] = np.nan
        learner.tell(loads)
    np.testing.assert_allclose(learner.state()["guard.numbers"][0], best, rtol=1e-6)


def test_setpoint_that_creeps_leaves_the_best_profile_behind(learner_type: type[Learner]) -> None:
    """Changes too small to start anew add up; a profile of the set-point of before is no best."""
    plant = AffinePlant.random(1, positions=8)
    learner = make_learner(plant, learner_type)
    turned(plant, learner, learner.experiment_passages)
    for _ in range(60):
        learner.setpoint *= 0.991
        turned(plant, learner, 3)
    assert not learner.events
    if learner_type is AdaptiveLearner:  # the paper's trades torque against the mean of thrust
        torque = plant.passage(learner.profile, learner.passages)[0].mean()
        np.testing.assert_allclose(torque, learner.setpoint, rtol=1e-4)


def test_load_without_a_weight_need_not_be_measured(learner_type: type[Learner]) -> None:
    plant = AffinePlant.random(19, positions=8)
    weights = WEIGHTS * [1, 1, 1, 0]
    one, two = (make_learner(plant, learner_type, weights=weights) for _ in range(2))
    for _ in range(60):
        loads = plant.passage(one.profile, one.passages)
        one.tell(loads)
        loads[3] = np.nan
        two.tell(loads)
        np.testing.assert_allclose(two.profile, one.profile, **same_as(learner_type))
    assert np.ptp(two.profile) > 0.01
    assert not two.events
    assert one.state()["guard.numbers"][0] < np.inf > two.state()["guard.numbers"][0]


def test_experiment_goes_on_when_samples_are_few(learner_type: type[Learner]) -> None:
    plant = AffinePlant.random(19, positions=8)
    learner = make_learner(plant, learner_type)
    turned(plant, learner, 3)
    learner.tell(np.full((4, 8), np.nan))
    assert learner.events == [(3, "too few samples")]


def test_experiment_without_an_answer_is_an_error(learner_type: type[Learner]) -> None:
    plant = AffinePlant.random(20, positions=6)
    learner = make_learner(plant, learner_type)
    for _ in range(learner.experiment_passages - 1):
        learner.tell(np.full((4, 6), np.nan))
    with pytest.raises(LearningError, match="experiment"):
        learner.tell(np.full((4, 6), np.nan))


@pytest.mark.parametrize("separate", [False, True])
@pytest.mark.parametrize("after", [0, 4, 29, 34, 50])
def test_saved_state_goes_on_exactly(
    learner_type: type[Learner], separate: bool, after: int, tmp_path: Any
) -> None:
    good = AffinePlant.random(23, positions=4, separate=separate)
    plant = Turncoat(good, 30)  # so that the guard has something to do as well
    learner = make_learner(good, learner_type, delay=1, patience=1)
    random = np.random.default_rng(0)
    noise = 0.01 * SCALE[:, None] * random.standard_normal((90, 4, 4))
    noise[random.random(noise.shape) < 0.05] = np.nan

    def go_on(learner: Learner, count: int) -> list[Any]:
        seen = []
        for _ in range(count):
            number = learner.passages
            learner.tell(plant.passage(learner.profile, number) + noise[number])
            # the guard's numbers as well: what they decide may come much later
            seen.append([*learner.profile.ravel(), *learner.state()["guard.numbers"]])
        return seen

    go_on(learner, after)
    save_state(tmp_path / "learner.npz", learner.state())
    expected = go_on(learner, 90 - after)
    again = make_learner(good, learner_type, delay=1, patience=1)
    again.restore(load_state(tmp_path / "learner.npz"))
    np.testing.assert_array_equal(go_on(again, 90 - after), expected)
    assert again.events == learner.events


def test_states_that_do_not_belong_are_refused(learner_type: type[Learner]) -> None:
    plant = AffinePlant.random(24, positions=4)
    learner = make_learner(plant, learner_type)
    turned(plant, learner, 12)
    state = learner.state()
    with pytest.raises(StateError, match="amplitude"):
        make_learner(plant, learner_type, amplitude=0.01).restore(state)
    broken = [
        {},
        {name: value for name, value in state.items() if name != "now"},
        {**state, "now": state["now"][1:]},
        {**state, "settings": np.array("{")},
        {**state, "guard.numbers": np.zeros(1)},
        {**state, "now": state["now"] + 20.0},
        {**state, "now": np.full_like(state["now"], np.nan)},
        {**state, "guard.numbers": np.array(1.0)},
        {**state, "guard.numbers": np.zeros((4, 2))},
        {**state, "guard.best": np.zeros((3, 5))},
        *({**state, name: np.zeros((3, 5, 2))} for name in state if name.startswith("model.")),
        {name: value for name, value in state.items() if not name.startswith("model.")},
    ]
    for damaged in broken:
        with pytest.raises(StateError):
            make_learner(plant, learner_type).restore(damaged)


def test_loads_of_another_shape_are_refused(learner_type: type[Learner]) -> None:
    learner = make_learner(AffinePlant.random(0, positions=8), learner_type)
    with pytest.raises(LearningError, match=r"loads: got shape \(4, 7\), expected \(4, 8\)"):
        learner.tell(np.zeros((4, 7)))
    assert learner.passages == 0
