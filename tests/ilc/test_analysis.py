"""Analysis: factors, margins and noise against learners that run, and against closed forms."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from ilc_factories import SCALE, WEIGHTS, AffinePlant, make_learner, turned

from ilc import FixedLearner, LearningError, Sensors
from ilc.analysis import contraction, error_margin, rotation_loop, stationary_noise
from ilc.fixed import gains


def settled(plant: AffinePlant, **changes: Any) -> FixedLearner:
    """A learner after the experiment."""
    learner = make_learner(plant, FixedLearner, **changes)
    assert isinstance(learner, FixedLearner)
    turned(plant, learner, learner.experiment_passages)
    return learner


@pytest.mark.parametrize("damping", [0.0, 0.4])
@pytest.mark.parametrize("blades", [1, 2, 3])
def test_loads_have_the_factors_of_the_pitch_and_ones(blades: int, damping: float) -> None:
    plant = AffinePlant.random(31, blades=blades, spread=0.4)
    H = gains(plant.jacobian, WEIGHTS, damping)
    found = contraction(plant.jacobian, H, WEIGHTS, 0.3)
    A = WEIGHTS[:, None] * plant.jacobian
    for q in range(plant.positions):
        pitch = np.sort(np.linalg.eigvals(np.eye(blades) - 0.3 * H[q] @ A[q]).real)
        loads = np.sort(np.linalg.eigvals(np.eye(4) - 0.3 * A[q] @ H[q]).real)
        np.testing.assert_allclose(loads, [*pitch, *np.ones(4 - blades)], atol=1e-9)
        # in terms of the singular values of W D
        s = np.linalg.svd(A[q], compute_uv=False)
        nu = damping * np.mean(s**2)
        np.testing.assert_allclose(found.pitch[q], np.max(1 - 0.3 * s**2 / (s**2 + nu)))
    np.testing.assert_allclose(found.loads, 1.0, rtol=1e-9)
    if damping == 0:
        np.testing.assert_allclose(found.pitch, 0.7, rtol=1e-9)


def test_factor_with_another_plant_is_what_a_learner_shows() -> None:
    plant = AffinePlant.random(32, positions=5, spread=0.2)
    learner = settled(plant, learning_rate=0.4, smoothing=1e-14)
    random = np.random.default_rng(2)
    D = plant.jacobian * (1 + 0.25 * random.standard_normal(plant.jacobian.shape))
    other = AffinePlant(plant.layout, plant.offset, D)
    factors = contraction(D, learner.gain, WEIGHTS, 0.4).pitch
    assert factors.max() < 0.95
    assert np.ptp(factors) > 0.05
    index = plant.layout.index
    profiles = np.array(turned(other, learner, 400))
    distance = np.linalg.norm(profiles[:, index] - profiles[-1][index], axis=2)
    early, late = 20, 60
    shown = (distance[late] / distance[early]) ** (1 / (late - early))
    np.testing.assert_allclose(shown, factors, rtol=0.02)


def test_margin_without_damping_is_the_inverse_condition_and_sharp() -> None:
    plant = AffinePlant.random(33, spread=0.3)
    D = plant.jacobian
    H = gains(D, WEIGHTS, 0.0)
    A = WEIGHTS[:, None] * D
    for kappa in (0.1, 0.7, 1.0):
        margin = error_margin(D, H, WEIGHTS, kappa)
        np.testing.assert_allclose(margin, 1 / np.linalg.cond(A), rtol=1e-8)
    u, s, vt = np.linalg.svd(A)
    worst = -(s[:, 2, None, None] * u[:, :, 2, None] * vt[:, None, 2]) / WEIGHTS[:, None]
    size = np.linalg.norm(WEIGHTS[:, None] * worst, ord=2, axis=(1, 2)) / s[:, 0]
    np.testing.assert_allclose(size, 1 / np.linalg.cond(A), rtol=1e-9)
    assert contraction(D + 0.999 * worst, H, WEIGHTS, 0.7).pitch.max() < 1
    assert contraction(D + 1.001 * worst, H, WEIGHTS, 0.7).pitch.min() > 1


@given(
    st.integers(0, 10_000),
    st.sampled_from([0.0, 0.1, 1.0]),
    st.floats(0.05, 1.0),
    st.floats(0.0, 0.999),
)
@settings(max_examples=150)
def test_errors_within_the_margin_keep_the_contraction(
    seed: int, damping: float, kappa: float, share: float
) -> None:
    plant = AffinePlant.random(seed, positions=3, spread=0.5)
    D = plant.jacobian
    H = gains(D, WEIGHTS, damping)
    margin = error_margin(D, H, WEIGHTS, kappa)
    assert np.all(margin > 0)
    A = WEIGHTS[:, None] * D
    E = np.random.default_rng(seed).standard_normal(A.shape)
    # as unkindly as can be: rank one along the direction in which the gain is the largest
    u, _, vt = np.linalg.svd(H)
    if seed % 2:
        E = -u[:, None, :, 0] * vt[:, 0, :, None]
    E *= (share * margin * np.linalg.norm(A, 2, axis=(1, 2)) / np.linalg.norm(E, 2, axis=(1, 2)))[
        :, None, None
    ]
    after = np.eye(3) - kappa * H @ (A + E)
    assert np.linalg.norm(after, 2, axis=(1, 2)).max() < 1
    assert contraction(D + E / WEIGHTS[:, None], H, WEIGHTS, kappa).pitch.max() < 1


def test_margin_is_zero_where_nothing_contracts() -> None:
    plant = AffinePlant.random(34)
    H = gains(plant.jacobian, WEIGHTS, 0.0)
    H[2] = 0
    margin = error_margin(plant.jacobian, H, WEIGHTS, 0.5)
    assert margin[2] == 0
    assert np.delete(margin, 2).min() > 0
    assert not error_margin(plant.jacobian, -H, WEIGHTS, 0.5).any()
    assert not error_margin(plant.jacobian, H, WEIGHTS, 0.0).any()


@pytest.mark.parametrize("kappa", [0.1, 0.5, 1.0])
def test_noise_of_one_pitch_and_one_load_in_closed_form(kappa: float) -> None:
    D = np.zeros((5, 4, 1))
    D[:, 0] = -2.0
    found = stationary_noise(D, gains(D, np.ones(4), 0.0), np.ones(4), kappa, [3.0, 1.0, 1.0, 1.0])
    variance = kappa / (2 - kappa) * 9.0  # of a first-order filter with gain kappa
    np.testing.assert_allclose(found.loads[:, 0, 0], variance)
    np.testing.assert_allclose(found.pitch[:, 0, 0], variance / 4)
    np.testing.assert_allclose(found.rms, [np.sqrt(0.8 * variance), 0, 0, 0])


@pytest.mark.parametrize("separate", [False, True])
def test_noise_is_what_a_learner_shows(separate: bool) -> None:
    plant = AffinePlant.random(35, positions=4, separate=separate, spread=0.3)
    kappa, count = 0.5, 9000
    noise = np.array([0.02, 0.05, 0.01, 0.03]) * SCALE
    learner = settled(plant, learning_rate=kappa, smoothing=1e-14, damping=0.1, patience=count)
    sensors = Sensors(noise=noise, seed=1)
    layout = plant.layout
    expected = stationary_noise(plant.jacobian, learner.gain, WEIGHTS, kappa, noise)
    met = []
    for _ in range(count):
        learner.tell(sensors.read(plant.passage(learner.profile, learner.passages)))
        if learner.passages % layout.dwell == 0:
            met.append(layout.values(learner.profile)[layout.index])
    pitch = np.array(met)[50:]
    pitch -= pitch.mean(axis=0)
    # of a variance from n samples with correlation r^k: sqrt(2 / n (1 + r^2) / (1 - r^2))
    r = contraction(plant.jacobian, learner.gain, WEIGHTS, kappa).pitch.max()
    error = np.sqrt(2 / len(pitch) * (1 + r**2) / (1 - r**2))
    assert error < 0.06
    covariance = np.einsum("nqb,nqc->qbc", pitch, pitch) / len(pitch)
    size = np.sqrt(np.einsum("qbb,qcc->qbc", expected.pitch, expected.pitch))
    assert np.abs((covariance - expected.pitch) / size).max() < 4 * error
    loads = np.einsum("qlb,nqb->nql", plant.jacobian, pitch)
    rms = np.sqrt(np.mean(loads.var(axis=1), axis=0))
    np.testing.assert_allclose(rms, expected.rms, rtol=2 * error / np.sqrt(layout.tracked) + 1e-3)


def test_noise_in_a_loop_that_does_not_contract_is_an_error() -> None:
    plant = AffinePlant.random(36)
    H = gains(plant.jacobian, WEIGHTS, 0.0)
    H[3] *= -1
    with pytest.raises(LearningError, match=r"does not contract .* position 3"):
        stationary_noise(plant.jacobian, H, WEIGHTS, 0.5, np.ones(4))


@pytest.mark.parametrize("separate", [False, True])
def test_loop_over_a_rotation_is_what_a_learner_does(separate: bool) -> None:
    plant = AffinePlant.random(37, positions=4, separate=separate, spread=0.3)
    learner = settled(plant, learning_rate=0.6, smoothing=0.4, damping=0.2)
    layout = plant.layout
    loop = rotation_loop(layout, learner.jacobian, learner.gain, WEIGHTS, 0.6, 0.4)
    assert loop.matrix.shape == (layout.variables + 3,) * 2
    start = learner.state()
    random = np.random.default_rng(3)
    ends, moves = [], []
    for size in (0.0, 1.0):
        pitch = 0.01 * size * random.standard_normal(layout.variables)
        means = 0.01 * size * SCALE * np.array([0, *random.standard_normal(3)])
        learner.restore(
            start | {"now": start["now"] + pitch, "model.means": start["model.means"] + means}
        )
        turned(plant, learner, 3)
        end = learner.state()
        ends.append(np.concatenate([end["now"], end["model.means"][1:]]))
        moves.append(np.concatenate([pitch, means[1:]]))
    scale = np.concatenate([np.full(layout.variables, 0.01), 0.01 * SCALE[1:]])
    change = (ends[1] - ends[0]) / scale
    np.testing.assert_allclose(change, loop.matrix @ moves[1] / scale, rtol=0, atol=1e-9)


def test_loop_with_means_held_has_the_factors_of_the_positions() -> None:
    plant = AffinePlant.random(38, positions=3, spread=0.3)
    H = gains(plant.jacobian, WEIGHTS, 0.3)
    loop = rotation_loop(plant.layout, plant.jacobian, H, WEIGHTS, 0.5, 0.0)
    assert loop.neutral == 3  # the means, which nothing moves
    factor = contraction(plant.jacobian, H, WEIGHTS, 0.5).pitch.max()
    assert loop.radius == pytest.approx(factor**3, rel=1e-9)  # three passages a rotation
    assert np.all(np.diff(np.abs(loop.eigenvalues)) <= 1e-12)


def test_means_that_all_positions_can_take_on_are_neutral() -> None:
    """Positions alike: constant tilt and yaw are free, and thrust is tied to torque."""
    alike = AffinePlant.random(39, positions=4, spread=0.0)
    H = gains(alike.jacobian, WEIGHTS, 0.0)
    loop = rotation_loop(alike.layout, alike.jacobian, H, WEIGHTS, 0.5, 0.5)
    assert loop.neutral == 2
    assert loop.radius < 0.99
    for spread, slowest in ((0.1, 0.999), (0.8, 0.9)):
        plant = AffinePlant.random(39, positions=12, spread=spread)
        H = gains(plant.jacobian, WEIGHTS, 0.0)
        loop = rotation_loop(plant.layout, plant.jacobian, H, WEIGHTS, 0.5, 0.5)
        assert loop.neutral == 0
        assert slowest < loop.radius < 1


def test_too_high_a_rate_diverges() -> None:
    plant = AffinePlant.random(40, positions=4)
    H = gains(plant.jacobian, WEIGHTS, 0.0)
    assert contraction(plant.jacobian, H, WEIGHTS, 2.1).pitch.min() > 1
    held = rotation_loop(plant.layout, plant.jacobian, H, WEIGHTS, 2.1, 0.0)
    assert held.radius == pytest.approx(1.1**3, rel=1e-9)
    assert rotation_loop(plant.layout, plant.jacobian, H, WEIGHTS, 2.1, 0.5).radius > 1
    assert error_margin(plant.jacobian, H, WEIGHTS, 2.1).max() == 0


def test_bad_input_is_named() -> None:
    plant = AffinePlant.random(41)
    D, H = plant.jacobian, gains(plant.jacobian, WEIGHTS, 0.0)
    with pytest.raises(LearningError, match=r"jacobian: got shape \(4, 3\)"):
        contraction(D[0], H, WEIGHTS, 0.3)
    with pytest.raises(LearningError, match=r"gain: got shape \(8, 4, 3\), expected \(8, 3, 4\)"):
        contraction(D, D, WEIGHTS, 0.3)
    with pytest.raises(LearningError, match="weights"):
        error_margin(D, H, WEIGHTS[:3], 0.3)
    with pytest.raises(LearningError, match="learning_rate"):
        contraction(D, H, WEIGHTS, -0.3)
    with pytest.raises(LearningError, match="noise"):
        stationary_noise(D, H, WEIGHTS, 0.3, [1, 1, 1, -1])
    with pytest.raises(LearningError, match="smoothing"):
        rotation_loop(plant.layout, D, H, WEIGHTS, 0.3, 1.5)
    with pytest.raises(LearningError, match=r"jacobian: got shape \(4, 4, 3\)"):
        rotation_loop(plant.layout, D[:4], H[:4], WEIGHTS, 0.3, 0.5)
