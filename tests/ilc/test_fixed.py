"""FixedLearner on affine plants: its fixed point and rate, gaps, going back to the best."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from ilc_factories import EXACT, SCALE, WEIGHTS, AffinePlant, Turncoat, make_learner, turned

from ilc import FixedLearner, Layout, LearningError
from ilc.fixed import affine_fit, gains


def fixed(plant: AffinePlant, **changes: Any) -> FixedLearner:
    learner = make_learner(plant, FixedLearner, **changes)
    assert isinstance(learner, FixedLearner)
    return learner


def practised(plant: AffinePlant, learner: FixedLearner) -> FixedLearner:
    turned(plant, learner, learner.experiment_passages)
    return learner


def settling(seed: int, separate: bool) -> AffinePlant:
    """A plant whose positions differ so much that the means settle within 900 rotations."""
    return AffinePlant.random(seed, positions=12, separate=separate, spread=0.8)


def errors(plant: AffinePlant, pitch: np.ndarray, means: np.ndarray) -> np.ndarray:
    """Weighted errors (P, 4) of a plant at pitches (P, B)."""
    loads = plant.offset + np.einsum("plb,pb->pl", plant.jacobian, pitch)
    return WEIGHTS * (loads - means)


@pytest.mark.parametrize("separate", [False, True])
@pytest.mark.parametrize("blades", [1, 2, 3])
def test_experiment_finds_the_jacobian_and_the_gain(blades: int, separate: bool) -> None:
    plant = AffinePlant.random(11, blades=blades, positions=5, separate=separate)
    learner = practised(plant, fixed(plant, start=0.03, damping=0.2))
    scale = np.abs(plant.jacobian).max()
    np.testing.assert_allclose(learner.jacobian, plant.jacobian, rtol=0, atol=1e-9 * scale)
    np.testing.assert_allclose(learner.layout.values(learner.profile), 0.03, rtol=0, atol=1e-15)
    for D, H in zip(plant.jacobian, learner.gain, strict=True):
        A = WEIGHTS[:, None] * D
        nu = 0.2 * np.trace(A.T @ A) / blades
        # the step -H e minimises |e + A d|^2 + nu |d|^2 for every e: normal equations
        np.testing.assert_allclose(
            (A.T @ A + nu * np.eye(blades)) @ H, A.T, rtol=0, atol=1e-8 * np.abs(A).max()
        )


@pytest.mark.parametrize("separate", [False, True])
def test_fixed_point_leaves_no_error_that_the_pitch_can_change(separate: bool) -> None:
    plant = settling(12, separate)
    learner = practised(plant, fixed(plant, learning_rate=0.7, smoothing=1.0))
    profiles = turned(plant, learner, 2700)
    np.testing.assert_allclose(profiles[-1], profiles[-4], **EXACT)
    pitch = learner.layout.values(profiles[-1])[learner.layout.index]
    loads = plant.offset + np.einsum("plb,pb->pl", plant.jacobian, pitch)
    means = loads.mean(axis=0)
    means[0] = learner.setpoint  # of torque it is the set-point, of the others what is measured
    e = errors(plant, pitch, means)
    gradient = np.einsum("plb,pl->pb", WEIGHTS[:, None] * plant.jacobian, e)
    start = np.einsum("plb,pl->pb", WEIGHTS[:, None] * plant.jacobian, WEIGHTS * plant.offset)
    assert np.abs(gradient).max() <= 1e-10 * np.abs(start).max()


@pytest.mark.parametrize(
    ("separate", "damping", "kappa"), [(False, 0.0, 0.3), (False, 0.5, 0.8), (True, 0.1, 0.6)]
)
def test_rate_is_exactly_that_of_the_contraction(
    separate: bool, damping: float, kappa: float
) -> None:
    plant = AffinePlant.random(13, positions=4, separate=separate)
    # so little smoothing that the means stand still
    learner = practised(plant, fixed(plant, damping=damping, learning_rate=kappa, smoothing=1e-14))
    layout = learner.layout
    means = plant.offset.mean(axis=0)  # the start is zero pitch
    means[0] = learner.setpoint
    A = WEIGHTS[:, None] * plant.jacobian
    HA = learner.gain @ A
    target = -np.linalg.solve(
        HA, learner.gain @ errors(plant, np.zeros(layout.index.shape), means)[:, :, None]
    )[:, :, 0]
    factor = np.eye(layout.blades) - kappa * HA
    assert np.abs(np.linalg.eigvals(factor)).max() < 1
    distance = layout.values(learner.profile)[layout.index] - target
    assert np.abs(distance).max() > 0.01
    for _ in range(12):
        rows = layout.visit(learner.passages)[0]
        learner.tell(plant.passage(learner.profile, learner.passages))
        now = layout.values(learner.profile)[layout.index] - target
        distance[rows] = np.einsum("pbc,pc->pb", factor[rows], distance[rows])
        np.testing.assert_allclose(now, distance, **EXACT)


def test_one_step_with_full_rate_is_the_least_squares_solution() -> None:
    plant = AffinePlant.random(14)
    learner = practised(plant, fixed(plant, learning_rate=1.0))
    learner.tell(plant.passage(learner.profile, learner.passages))
    means = plant.offset.mean(axis=0)
    means[0] = learner.setpoint
    pitch = learner.profile[learner.layout.index]
    for q, D in enumerate(plant.jacobian):
        best = np.linalg.lstsq(
            WEIGHTS[:, None] * D, WEIGHTS * (means - plant.offset[q]), rcond=None
        )[0]
        np.testing.assert_allclose(pitch[q], best, **EXACT)


def test_means_follow_once_a_rotation_and_torque_follows_the_setpoint() -> None:
    plant = AffinePlant.random(15, spread=0.2)
    learner = practised(plant, fixed(plant, smoothing=0.25))
    expected = plant.offset.mean(axis=0)
    for _ in range(3):
        measured = []
        for _ in range(3):
            np.testing.assert_allclose(learner.state()["model.means"], expected, rtol=1e-9)
            loads = plant.passage(learner.profile, learner.passages)
            measured.append(loads)
            learner.tell(loads)
        expected += 0.25 * (np.concatenate(measured, axis=1).mean(axis=1) - expected)
    learner.setpoint = 0.98 * SCALE[0]
    turned(plant, learner, 900)
    torque = plant.passage(learner.profile, learner.passages)[0].mean()
    # at the fixed point torque is off by what four loads with three pitches leave
    assert torque == pytest.approx(0.98 * SCALE[0], rel=0.01)


@pytest.mark.parametrize("missing", [np.nan, np.inf, -np.inf, 1e200])
def test_position_with_a_missing_load_keeps_its_pitch(missing: float) -> None:
    plant = AffinePlant.random(18, positions=8)
    learner, whole = practised(plant, fixed(plant)), practised(plant, fixed(plant))
    before = learner.profile
    loads = plant.passage(before, learner.passages)
    whole.tell(loads)
    loads[2, 5] = missing
    learner.tell(loads)
    index = learner.layout.index
    np.testing.assert_array_equal(learner.profile[index[5]], before[index[5]])
    others = np.delete(index, 5, axis=0)
    np.testing.assert_array_equal(learner.profile[others], whole.profile[others])
    assert np.abs(learner.profile[others] - before[others]).min(axis=1).max() > 1e-4


def test_experiment_with_gaps_still_finds_the_jacobian() -> None:
    plant = AffinePlant.random(20, positions=6)
    learner = fixed(plant)
    random = np.random.default_rng(0)
    gaps = 0
    while not learner.learning:
        loads = plant.passage(learner.profile, learner.passages)
        lost = random.random(loads.shape) < 0.1
        gaps += lost.sum()
        learner.tell(np.where(lost, np.nan, loads))
    assert gaps > 10
    scale = np.abs(plant.jacobian).max()
    np.testing.assert_allclose(learner.jacobian, plant.jacobian, rtol=0, atol=1e-8 * scale)


def test_affine_fit_leaves_out_what_was_measured_too_seldom() -> None:
    random = np.random.default_rng(1)
    pitch = random.normal(size=(30, 2, 3))
    loads = np.einsum("plb,epb->elp", random.normal(size=(2, 4, 3)), pitch)
    loads[:28, 1, 0] = np.nan  # two measurements are left for four unknowns
    loads[:, 2, 1] = np.nan
    offset, jacobian, known = affine_fit(pitch, loads)
    assert not jacobian[0, 1].any()
    assert not jacobian[1, 2].any()
    np.testing.assert_array_equal(known, [[True, False, True, True], [True, True, False, True]])
    assert np.isnan(offset[2, 1])
    assert offset[1, 0] == pytest.approx(loads[28:, 1, 0].mean())
    assert jacobian[0, 0].all()


def test_gain_leaves_alone_what_the_loads_do_not_show() -> None:
    D = np.zeros((2, 4, 3))
    D[0, 0] = D[0, 3] = 1.0  # only the collective pitch
    H = gains(D, np.ones(4), 0.0)
    np.testing.assert_allclose(H[0], np.array([[1, 0, 0, 1]] * 3) / 6, atol=1e-12)
    assert not H[1].any()


@pytest.mark.parametrize("separate", [False, True])
def test_growing_loads_bring_the_best_profile_back(separate: bool) -> None:
    good = AffinePlant.random(21, positions=6, separate=separate)
    learner = fixed(good, patience=3)
    plant = Turncoat(good, learner.experiment_passages)
    practised(plant, learner)
    used = [good.layout.profile(np.zeros(good.layout.variables))]
    while not learner.events:
        assert learner.rotation < 30
        used += turned(plant, learner, 3)[:-1]
    assert learner.events == [
        (learner.passages - 1, "AC load grew for 3 rotations: back to the best profile")
    ]
    assert learner.rotation >= 3
    best = learner.profile
    assert any(np.array_equal(best, profile) for profile in used[: -2 * 3])

    def load(profile: np.ndarray) -> float:
        turn = [plant.passage(profile, learner.passages + j) for j in range(3)]
        return float(WEIGHTS @ np.concatenate(turn, axis=1).std(axis=1))

    assert load(best) < 0.9 * load(used[-1])
    held = turned(plant, learner, 5)
    for profile in held:
        np.testing.assert_array_equal(profile, best)
    turned(plant, learner, 2)
    assert np.abs(learner.profile - best).max() > 0  # then it tries again, in smaller steps
    assert learner.state()["model.share"] == 0.5


def test_setpoint_changed_while_the_best_profile_is_held() -> None:
    good = AffinePlant.random(21, positions=6)
    learner = fixed(good, patience=3)
    plant = Turncoat(good, learner.experiment_passages)
    while not learner.events:
        turned(plant, learner, 1)
    before = learner.profile
    learner.setpoint = 0.9 * SCALE[0]  # the old best is no measure any more
    turned(plant, learner, 1)
    assert np.abs(learner.profile - before).max() > 0


@pytest.mark.parametrize(("separate", "delay"), [(False, 1), (False, 12), (True, 5)])
def test_delay_that_is_known_leads_to_the_same_fixed_point(separate: bool, delay: int) -> None:
    plant = settling(22, separate)
    prompt, late = (fixed(plant, delay=lag, smoothing=1.0) for lag in (0, delay))
    turned(plant, prompt, 2700)
    stream = np.full((4, delay), np.nan)
    for _ in range(2700):
        stream = np.concatenate([stream, plant.passage(late.profile, late.passages)], axis=1)
        late.tell(stream[:, :12])
        stream = stream[:, 12:]
    scale = np.abs(plant.jacobian).max()
    np.testing.assert_allclose(late.jacobian, plant.jacobian, rtol=0, atol=1e-9 * scale)
    np.testing.assert_allclose(late.profile, prompt.profile, rtol=0, atol=1e-9)


@pytest.mark.parametrize(
    ("changes", "name"),
    [
        ({"learning_rate": 0.0}, "learning_rate"),
        ({"learning_rate": 1.01}, "learning_rate"),
        ({"damping": -0.1}, "damping"),
        ({"smoothing": 0.0}, "smoothing"),
        ({"weights": [1, 1, 1]}, "weights"),
        ({"weights": [0, 0, 0, 0]}, "weights"),
        ({"weights": [1, 1, -1, 1]}, "weights"),
        ({"amplitude": 0.0}, "amplitude"),
        ({"delay": 9}, "delay"),
        ({"patience": 0}, "patience"),
        ({"setpoint": np.nan}, "setpoint"),
        ({"start": 11.0}, "start"),
        ({"start": np.zeros(7)}, "profile"),
    ],
)
def test_bad_settings_are_named(changes: dict[str, Any], name: str) -> None:
    with pytest.raises(LearningError, match=name):
        fixed(AffinePlant.random(0, positions=8), **changes)


def test_blades_that_differ_are_levelled_with_separate_profiles_only() -> None:
    """One blade with a pitch offset: one profile cannot undo it, three can."""
    m = 12
    alike = settling(25, False)
    layout = Layout(blades=3, positions=m, separate=True)
    # blade b at position q = j m + k stands at the common plant's station ((b + j) mod 3) m + k
    jacobian = np.array([np.roll(alike.jacobian[q % m], -(q // m), axis=1) for q in range(3 * m)])
    offset = np.tile(alike.offset, (3, 1)) + jacobian @ np.array([0.02, 0.0, 0.0])
    uneven = AffinePlant(layout, offset, jacobian)
    left = {}
    for separate in (True, False):
        own = Layout(blades=3, positions=m, separate=separate)
        # the guard would take back what is left of the start, so it is not to interfere
        learner = fixed(uneven, layout=own, learning_rate=0.5, smoothing=1.0, patience=9999)
        turned(uneven, learner, 2700)
        turn = [uneven.passage(learner.profile, 2700 + j) for j in range(3)]
        left[separate] = WEIGHTS @ np.concatenate(turn, axis=1).std(axis=1)
    best = fixed(alike, learning_rate=0.5, smoothing=1.0)
    turned(alike, best, 2700)
    target = WEIGHTS @ alike.passage(best.profile, 2700).std(axis=1)
    assert left[True] == pytest.approx(target, rel=1e-6)
    assert left[False] > 3 * target
