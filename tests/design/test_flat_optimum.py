"""The optimum by exact flattening: a local optimum, and the convex programs' own."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from design_factories import SmoothModel, rotor_curves, wide_limits

from pitchopt import compared, load_case
from pitchopt.design import (
    DesignProblem,
    DesignTask,
    LoadWeights,
    Objective,
    constant,
    flat_optimum,
    power_max,
    solve_local,
)
from pitchopt.errors import InfeasibleError, InputError

TASK = DesignTask(model=SmoothModel(), positions=6, limits=wide_limits(1.0))
PROBLEM = TASK.problem()
PITCH = float(constant(TASK).profile[0])
WEIGHTS = LoadWeights.unit()
STEEP = Objective.tradeoff(100.0, WEIGHTS)


@pytest.mark.parametrize("loss", [0.05, 0.1])
def test_a_local_solve_gains_nothing(loss: float) -> None:
    torque = (1 - loss) * power_max(TASK).mean_torque
    objective = Objective.least_rms(WEIGHTS, torque_min=torque)
    flat = flat_optimum(PROBLEM, objective, PITCH)
    assert flat.flat == ("torque", "tilt", "yaw")
    assert flat.loads.rms[:3].max() < 1e-6 * flat.loads.rms[3]
    assert flat.loads.mean[0] == pytest.approx(torque, rel=2e-6)
    assert max(PROBLEM.limits.violation(PROBLEM.curves, flat.profile)) <= 1e-9
    assert flat.value == pytest.approx(PROBLEM.value(flat.profile, objective), rel=1e-9)
    solved = solve_local(PROBLEM, objective, flat.profile)
    assert solved.value == pytest.approx(flat.value, rel=1e-3)


def test_heavy_thrust_leaves_the_torque_to_vary() -> None:
    objective = Objective.tradeoff(3.0, LoadWeights(thrust=1000.0))
    flat = flat_optimum(PROBLEM, objective, PITCH)
    assert flat.flat == ("tilt", "yaw", "thrust")
    assert flat.loads.rms[1:].max() < 1e-6 * flat.loads.rms[0]


@pytest.mark.slow
def test_same_result_every_time() -> None:
    first, second = (flat_optimum(PROBLEM, STEEP, PITCH) for _ in range(2))
    np.testing.assert_array_equal(first.profile, second.profile)


@pytest.mark.parametrize(
    ("problem", "message"),
    [
        (replace(TASK, model=SmoothModel(blades=2)).problem(), "got 2 blades, expected three"),
        (
            DesignProblem(curves=rotor_curves(mean_pitch=0.05), limits=wide_limits()),
            "got a frozen wake",
        ),
        (replace(TASK, harmonics=2).problem(), "got 2 harmonics, expected none"),
    ],
)
def test_refusals(problem: DesignProblem, message: str) -> None:
    with pytest.raises(InputError, match=message):
        flat_optimum(problem, STEEP, PITCH)


@pytest.mark.parametrize("rate", [0.0, 1e-3])
def test_a_rate_limit_that_binds_is_said(rate: float) -> None:
    problem = DesignProblem(curves=rotor_curves(positions=6), limits=wide_limits(rate))
    with pytest.raises(InfeasibleError, match="keeps range, rate"):
        flat_optimum(problem, STEEP, PITCH)


def test_a_cap_that_no_flat_profile_keeps_is_said() -> None:
    capped = Objective.tradeoff(100.0, WEIGHTS, blade_cap=1.0)
    with pytest.raises(InfeasibleError, match="limits of the objective"):
        flat_optimum(PROBLEM, capped, PITCH)


@pytest.mark.slow
@pytest.mark.parametrize("loss", [0.03, 0.07])
def test_paper_case_agrees_with_the_convex_programs(loss: float) -> None:
    """RMS within 0.05 % of the design's, found by a route with no convex program in it."""
    task = load_case("biegel2011").task()
    design = compared(task, max_power_loss=loss, certify=False)
    torque = (1 - loss) * design.power_max.mean_torque
    objective = Objective.least_rms(task.weights, torque_min=torque)
    flat = flat_optimum(task.problem(), objective, float(design.constant.profile[0]))
    assert task.weights.weighted(flat.loads) == pytest.approx(design.design.rms_weighted, rel=5e-4)
    assert flat.loads.mean[0] == pytest.approx(design.design.mean_torque, rel=2e-6)
    assert np.abs(flat.profile - design.design.profile).max() < np.radians(0.2)
