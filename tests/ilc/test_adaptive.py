"""The adaptive learner: optima of affine plants under limits, noise, changes, harmonics."""

from __future__ import annotations

from typing import Any

import cvxpy as cp
import numpy as np
import pytest
from ilc_factories import SCALE, WEIGHTS, AffinePlant, make_learner, turned

from ilc import (
    ActuatorLimits,
    AdaptiveLearner,
    FixedLearner,
    Learner,
    LearningError,
    Sensors,
    run,
)
from ilc.learner import ac_load


def adaptive(plant: AffinePlant, **changes: Any) -> AdaptiveLearner:
    learner = make_learner(plant, AdaptiveLearner, **changes)
    assert isinstance(learner, AdaptiveLearner)
    return learner


def least_load(plant: AffinePlant, limits: ActuatorLimits, basis: Any = None) -> float:
    """Least weighted AC load with the set-point as mean torque: a convex program."""
    layout = plant.layout
    if basis is None:
        beta = cp.Variable(layout.variables)
        free = []
    else:
        part = cp.Variable(basis.shape[1])
        beta, free = cp.Variable(layout.variables), []
        free = [beta == basis @ part]
    means = cp.Variable(4)
    at = [beta[row] for row in layout.index]
    loads = [
        cp.hstack(
            [plant.offset[q, i] + plant.jacobian[q, i] @ at[q] for q in range(layout.tracked)]
        )
        / SCALE[i]
        for i in range(4)
    ]
    total = sum(
        WEIGHTS[i] * SCALE[i] * cp.norm(loads[i] - means[i]) / np.sqrt(layout.tracked)
        for i in range(4)
    )
    tie = beta[layout.ahead] - beta
    held = [
        means[0] == 1.0,
        cp.sum(loads[0]) / layout.tracked == 1.0,
        beta >= limits.lower,
        beta <= limits.upper,
        cp.abs(tie) <= limits.step,
        *free,
    ]
    return float(cp.Problem(cp.Minimize(total), held).solve(solver=cp.CLARABEL))


LIMITS = [
    pytest.param(ActuatorLimits(lower=-2, upper=2, step=2), id="free"),
    pytest.param(ActuatorLimits(lower=-0.02, upper=0.03, step=0.2), id="range"),
    pytest.param(ActuatorLimits(lower=-0.5, upper=0.5, step=0.006), id="rate"),
    pytest.param(ActuatorLimits(lower=-0.04, upper=0.05, step=0.01), id="both"),
]


@pytest.mark.parametrize("limits", LIMITS)
def test_affine_plant_ends_at_the_optimum(limits: ActuatorLimits) -> None:
    """Where the paper's learner is stuck at a projection, this one solves the whole problem."""
    plant = AffinePlant.random(3, positions=8)
    best = least_load(plant, limits)
    learner = adaptive(plant, limits=limits)
    turned(plant, learner, learner.experiment_passages + 90)
    loads = plant.passage(learner.profile, 0)
    start = ac_load(plant.passage(np.zeros(24), 0), WEIGHTS)
    assert loads[0].mean() == pytest.approx(SCALE[0], rel=2e-3)
    assert ac_load(loads, WEIGHTS) <= 1.02 * best + 2e-3 * start
    paper = make_learner(plant, limits=limits)
    turned(plant, paper, paper.experiment_passages + 90)
    assert ac_load(loads, WEIGHTS) <= 1.001 * ac_load(plant.passage(paper.profile, 0), WEIGHTS)


@pytest.mark.parametrize("separate", [False, True])
def test_harmonics_are_kept(separate: bool) -> None:
    plant = AffinePlant.random(5, positions=8, separate=separate)
    limits = ActuatorLimits(lower=-0.5, upper=0.5, step=0.1)
    learner = adaptive(plant, harmonics=2, limits=limits)
    turned(plant, learner, learner.experiment_passages + 60)
    spectrum = np.abs(np.fft.rfft(learner.profile, axis=-1))
    assert spectrum[..., 3:].max() < 1e-8 * spectrum.max()
    if not separate:
        best = least_load(plant, limits, learner._basis)
        assert ac_load(plant.passage(learner.profile, 0), WEIGHTS) <= 1.02 * best


@pytest.mark.slow
def test_noise_is_averaged() -> None:
    """Noise adds less than one measurement of it, and leaves less than a fixed gain does."""
    plant = AffinePlant.random(6, positions=12)
    noise = 0.05 * plant.passage(np.zeros(36), 0).std(axis=1)
    wide = float(np.deg2rad(2.0))  # perturbations that show above the noise

    def late(kind: type[Learner], **sensors: Any) -> float:
        learner = make_learner(plant, kind, amplitude=wide)
        record = run(plant, learner, rotations=40, sensors=Sensors(**sensors))
        return float(record.learning.ac_load[-5:].mean())

    left = np.mean([late(AdaptiveLearner, noise=noise, seed=seed) for seed in range(4)])
    floor = late(AdaptiveLearner)
    assert floor < left < floor + 0.75 * float(WEIGHTS @ noise)
    assert left < late(FixedLearner)  # which is not disturbed at all


@pytest.mark.parametrize("delay", [1, 4, 8])
def test_delay_is_undone(delay: int) -> None:
    plant = AffinePlant.random(7, positions=8)
    learner = adaptive(plant, delay=delay)
    record = run(plant, learner, rotations=12, sensors=Sensors(delay=delay))
    prompt = run(plant, adaptive(plant), rotations=12)
    assert record.learning.ac_load[-1] <= 1.05 * prompt.learning.ac_load[-1]
    unaware = run(plant, adaptive(plant), rotations=12, sensors=Sensors(delay=delay))
    if delay < 8:  # a whole passage is noticed less: the profile hardly changes any more
        assert unaware.learning.ac_load[-1] > 2 * record.learning.ac_load[-1]


def test_change_of_plant_is_followed() -> None:
    """A step of all loads and slopes: within five rotations as good as after a new experiment."""
    one, two = (AffinePlant.random(8, positions=8, spread=s) for s in (0.1, 0.12))
    learner = adaptive(one)
    turned(one, learner, learner.experiment_passages + 30)
    shifted = AffinePlant(one.layout, two.offset * 1.05, two.jacobian)
    learner.setpoint = 1.02 * SCALE[0]
    turned(shifted, learner, 15)
    fresh = adaptive(shifted, setpoint=1.02 * SCALE[0])
    turned(shifted, fresh, fresh.experiment_passages + 30)
    now, best = (ac_load(shifted.passage(one_.profile, 0), WEIGHTS) for one_ in (learner, fresh))
    start = ac_load(shifted.passage(np.zeros(24), 0), WEIGHTS)
    assert now - best < 0.02 * start


@pytest.mark.parametrize(
    ("changes", "text"),
    [
        ({"harmonics": 0}, "harmonics: got 0"),
        ({"harmonics": 1.5}, "harmonics: got 1.5"),
        ({"reach": 0.0}, "reach: got 0"),
        ({"harmonics": 1, "start": 0.01 * np.cos(4 * np.pi * np.arange(24) / 24)}, "above 1P"),
    ],
)
def test_bad_input_is_named(changes: Any, text: str) -> None:
    with pytest.raises(LearningError, match=text):
        adaptive(AffinePlant.random(1, positions=8), **changes)
