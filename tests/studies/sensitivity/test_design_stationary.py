"""Multipliers of pitch designs: conditions, signs, kinks, slopes against re-solved designs."""

from __future__ import annotations

import numpy as np
import pytest

from pitchopt.cases import load_case
from pitchopt.design import compared
from pitchopt.design.problem import DesignProblem, LoadWeights
from pitchopt.design.scp import solve_local
from pitchopt.errors import InputError
from pitchopt.studies.sensitivity import DesignPoint, design_sensitivity
from pitchopt.studies.sensitivity.stationary import stationary

DEGREE = np.pi / 180.0


def point(goal, **values):
    case = load_case("biegel2011").with_values(
        {"limits.positions": 6, "aero.segments": 10}
        | {name.replace("__", "."): value for name, value in values.items()}
    )
    task = case.task()
    return DesignPoint(case=case, task=task, found=compared(task, starts=1, certify=False, **goal))


CASES = {
    "price": ({"mu": 3.0}, {}),
    "high price": ({"mu": 10.0}, {}),
    "loss": ({"max_power_loss": 0.03}, {}),
    "held torque": ({"mean_torque": 1.3e6}, {}),
    "slow actuator": ({"mu": 3.0}, {"limits__pitch_rate": 1.5 * DEGREE}),
    "slow actuator, loss": ({"max_power_loss": 0.01}, {"limits__pitch_rate": 1.5 * DEGREE}),
    "no actuator": ({"mu": 3.0}, {"limits__pitch_rate": 0.0}),
    "narrow range": (
        {"max_power_loss": 0.03},
        {"limits__pitch_min": -DEGREE, "limits__pitch_max": 0.5 * DEGREE},
    ),
    "narrow range, price": (
        {"mu": 3.0},
        {"limits__pitch_min": -0.3 * DEGREE, "limits__pitch_max": 0.8 * DEGREE},
    ),
    "harmonics": ({"mu": 3.0}, {"objective__harmonics": 2, "limits__pitch_rate": DEGREE}),
    "travel": (
        {"mu": 3.0},
        {"objective__travel": 5e3 / DEGREE, "limits__pitch_rate": 2 * DEGREE},
    ),
    "blade cap": ({"mu": 3.0}, {"objective__blade_cap": 0.05}),
    "blade weight": (
        {"mu": 3.0},
        {"objective__weights": LoadWeights(tilt=0.0, yaw=0.0, thrust=0.0, blade=0.5)},
    ),
    "frozen wake": (
        {"mu": 3.0},
        {"aero__induction": "frozen", "limits__pitch_rate": 2 * DEGREE},
    ),
    "pitch-rate terms": ({"mu": 3.0}, {"aero__pitch_rate_terms": True}),
}


@pytest.fixture(scope="module", params=list(CASES))
def found(request):
    goal, values = CASES[request.param]
    return point(goal, **values)


def slopes(problem, kkt, base):
    """Slope of the Lagrangian in each station's pitch, from its definition by differences."""
    curves, theta = problem.curves, kkt.theta
    y, g = kkt.prices, kkt.torque_price
    step = 1e-7

    def value(profile):
        rate = curves.profile_rate(profile)
        move = profile - base
        blade = (
            curves.contributions(base)
            + ((1 - theta) * kkt.left + theta * kkt.right) * move
            + curves.rates * rate
        )
        change = np.roll(profile, -1) - profile
        w = kkt.rate_up - kkt.rate_down + kkt.travel
        return (
            g * blade[0].sum() / curves.positions
            - np.sum(y * blade)
            - w @ change
            - kkt.multipliers.mean * profile.mean()
            - np.sum(kkt.multipliers.basis * profile)
            - (kkt.upper - kkt.lower) @ profile
        )

    return np.array(
        [(value(base + step * e) - value(base - step * e)) / (2 * step) for e in np.eye(base.size)]
    )


def test_the_lagrangian_is_flat_in_every_pitch(found):
    kkt = found.stationary
    residual = slopes(found.problem, kkt, found.design.profile)
    # rounding of the differences of a value of about 1e6 N m by steps of 1e-7 rad
    assert np.max(np.abs(residual)) <= 1e-5 * kkt.scale + 1e-2
    assert kkt.worst < 1e-6
    assert abs(kkt.gain) < 1e-7 * found.largest_torque


def test_multipliers_have_the_signs_and_sizes_of_their_constraints(found):
    kkt, objective, m = found.stationary, found.objective, found.problem.curves.positions
    for array in (kkt.rate_up, kkt.rate_down, kkt.lower, kkt.upper):
        assert np.all(array >= 0.0)
    assert np.all((kkt.theta >= 0.0) & (kkt.theta <= 1.0))
    mult = kkt.multipliers
    assert min(mult.torque_min, mult.torque_max, mult.cap) >= 0.0
    sizes = np.linalg.norm(mult.loads, axis=1) * np.sqrt(m)
    assert np.all(sizes <= objective.lambdas[:4] * (1 + 1e-6) + 1e-9)
    assert mult.loads.sum(axis=1) == pytest.approx(0.0, abs=1e-9)


def test_what_is_not_active_has_no_multiplier(found):
    kkt, problem, profile = found.stationary, found.problem, found.design.profile
    change = np.roll(profile, -1) - profile
    most = 1e-6 * kkt.scale
    assert np.all((kkt.rate_up <= most) | (change > problem.step - 1e-6))
    assert np.all((kkt.rate_down <= most) | (change < -problem.step + 1e-6))
    assert np.all((kkt.lower <= most) | (profile < problem.curves.lower + 1e-4))
    assert np.all((kkt.upper <= most) | (profile > problem.curves.upper - 1e-4))


def test_slopes_agree_with_designs_solved_again(found):
    """Central differences over a thousandth of the default steps, each design solved again."""
    # what local solves leave: shares of mean torque, or of the RMS where that is the objective
    unit = found.largest_torque if found.by_torque else 1e3 * found.design.rms_weighted
    steps = {name: 1e-3 * found.default_step(name) for name in found.parameters}
    checked = 0
    for row in design_sensitivity(found, steps).rows:
        ends = []
        for step in (row.step, -row.step):
            if row.parameter == "rate" and row.value + step < 0:
                ends.append(-ends[0])  # from one side, where the other has no rate
                continue
            changed = found.changed(row.parameter, step)
            problem = changed.task.problem(found.design.mean_pitch)
            solved = solve_local(problem, changed.objective, found.design.profile)
            ends.append(solved.value - found.stationary.value)
        truth = 0.5 * (ends[0] - ends[1])
        tolerance = 5e-4 * abs(truth) + 1e-9 * unit
        assert row.first == pytest.approx(truth, abs=tolerance), row.parameter
        assert row.high == pytest.approx(truth, abs=1.5e-3 * abs(truth) + 1e-9 * unit)
        checked += abs(truth) > 2e-8 * unit
    assert checked >= 1


def test_more_rate_and_a_wider_range_never_hurt(found):
    for row in design_sensitivity(found).rows:
        if row.parameter in ("rate", "lower", "upper"):
            assert row.first >= 0.0
            assert row.high >= 0.0


@pytest.mark.parametrize("name", ["slow actuator", "slow actuator, loss", "no actuator"])
def test_a_slow_actuator_is_worth_more_rate(name):
    goal, values = CASES[name]
    rows = {r.parameter: r for r in design_sensitivity(point(goal, **values)).rows}
    assert rows["rate"].first > 0.0
    assert rows["rate"].groups[0].name == "pitch rate"


def test_loads_held_flat_have_prices_below_their_limit():
    found = point({"mu": 10.0})
    flat = found.design.loads.rms < 1e-3
    assert flat.any()
    m = found.problem.curves.positions
    sizes = np.linalg.norm(found.stationary.multipliers.loads, axis=1) * np.sqrt(m)
    assert np.all(sizes[flat] < 0.999 * 10.0)
    assert np.any(sizes[flat] > 0.0)


def test_a_profile_that_is_no_optimum_is_told():
    found = point({"mu": 3.0})
    moved = found.problem.repaired(found.design.profile + 0.3 * DEGREE)
    kkt = stationary(found.problem, found.objective, moved)
    assert kkt.worst > 1e-3 or kkt.gain > 1e-6 * found.largest_torque


def test_multipliers_know_nothing_of_the_unit_of_torque():
    found = point({"mu": 3.0}, limits__pitch_rate=1.5 * DEGREE)
    curves, factor = found.problem.curves, 1e-3
    from dataclasses import replace

    names = ("torque", "bending", "thrust", "radial")
    small = replace(curves, **{name: factor * getattr(curves, name) for name in names})
    problem = DesignProblem(curves=small, limits=found.task.limits)
    kkt = stationary(problem, found.objective, found.design.profile)
    assert kkt.value == pytest.approx(factor * found.stationary.value)
    big = found.stationary
    assert kkt.rate_up == pytest.approx(factor * big.rate_up, abs=1e-6 * factor * big.scale)


def test_only_converged_designs_have_multipliers():
    found = point({"mu": 3.0})
    from dataclasses import replace

    from pitchopt.design.results import Status

    with pytest.raises(InputError, match="expected a converged one"):
        DesignPoint(
            case=found.case,
            task=found.task,
            found=replace(found.found, design=replace(found.design, status=Status.ITERATION_LIMIT)),
        )
    with pytest.raises(InputError, match="kind 'constant'"):
        DesignPoint(
            case=found.case,
            task=found.task,
            found=replace(found.found, design=found.found.constant),
        )
