"""One curve: torque and RMS fall with the price, and no point is beaten by anything known."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise
from typing import Any

import numpy as np
import pytest
from design_factories import SmoothModel, random_curves, rotor_curves, wide_limits

from pitchopt import load_case
from pitchopt.design import CurvesModel, DesignTask, Status, Tradeoff, power_max, tradeoff
from pitchopt.design.constant_pitch import best_constant
from pitchopt.design.points import PointFinder

SLACK = 2e-7  # of the largest torque (prices) or the RMS of constant pitch (losses)


def check(task: DesignTask, curve: Tradeoff) -> None:
    """Every point against every profile that is known, itself evaluated on the curves."""
    problem = task.operating_at(float(curve.constant.profile.mean())).problem()
    weights, unit = task.weights, curve.power_max.mean_torque
    cap = np.inf if task.blade_cap is None else task.blade_cap * curve.constant.loads.blade_rms
    stations = curve.constant.profile.size
    constants = [np.full(stations, pitch) for pitch in curve.constant_pitch]
    known = [p.profile for p in (*curve.points, curve.power_max, curve.constant)] + constants
    loads = [problem.curves.evaluate(profile) for profile in known]
    kept = [one for one in loads if one.blade_rms <= cap * (1 + 1e-6)]
    torque = np.array([one.mean[0] for one in kept])
    rms = np.array([weights.weighted(one) for one in kept])

    prices = sorted((p for p in curve.points if p.kind == "mu"), key=lambda p: p.mu)
    for point in prices:
        value = point.mean_torque - point.mu * point.rms_weighted
        assert np.max(torque - point.mu * rms) <= value + SLACK * unit
    for point in curve.points:
        if point.kind == "max_power_loss":
            allowed = torque >= (1 - point.target) * unit * (1 + 1e-9)
            slack = SLACK * curve.constant.rms_weighted
            assert np.min(rms[allowed], initial=np.inf) >= point.rms_weighted - slack
    for first, second in pairwise(prices):
        gap = second.mu - first.mu
        assert second.rms_weighted <= first.rms_weighted + 2 * SLACK * unit / gap
        assert second.mean_torque <= first.mean_torque + 2 * SLACK * unit * second.mu / gap
    for point in curve.points:
        beaten = (torque > point.mean_torque + 3e-6 * unit) & (
            rms < point.rms_weighted - 1e-6 * curve.constant.rms_weighted
        )
        assert not np.any(beaten)


def drawn_task(seed: int) -> DesignTask:
    """A rough random rotor of one to three blades, with or without cap and rate effects."""
    rng = np.random.default_rng(seed)
    blades, positions = int(rng.integers(1, 4)), int(rng.integers(2, 6))
    table = random_curves(
        rng,
        blades=blades,
        positions=positions,
        knots=int(rng.integers(3, 8)),
        concave=bool(rng.random() < 0.6),
        rates=bool(rng.random() < 0.4),
    )
    return DesignTask(
        model=CurvesModel(table=table),
        positions=positions,
        limits=wide_limits(float(rng.uniform(0.02, 1.0))),
        blade_cap=1.0 if rng.random() < 0.4 else None,
    )


@pytest.mark.parametrize("seed", range(6))
def test_random_rotors(seed: int) -> None:
    task = drawn_task(seed)
    check(task, tradeoff(task, points=6, certify=False))


@pytest.mark.parametrize(
    "change",
    [
        {},
        {"blade_cap": 1.0},
        {"model": SmoothModel(blades=2)},
        {"model": CurvesModel(table=rotor_curves(positions=4, rates=0.05))},
    ],
    ids=["plain", "cap", "two blades", "rate effects"],
)
def test_smooth_rotors(change: dict[str, Any]) -> None:
    task = DesignTask(model=SmoothModel(), positions=4, limits=wide_limits(), between_positions=8)
    task = replace(task, **change)
    check(task, tradeoff(task, points=8))


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "values"),
    [
        ("biegel2011", {}),
        ("nrel-5mw", {"limits.positions": 12, "wind.speed": 11.0}),
        ("iea-15-240", {"limits.positions": 12, "wind.speed": 9.0}),
    ],
)
def test_real_rotors(name: str, values: dict[str, Any]) -> None:
    task = load_case(name).with_values(values).task()
    check(task, tradeoff(task, points=10, certify=False))


def test_a_better_profile_is_taken_even_if_no_local_solve_gets_there(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Local solves that go nowhere: points keep or take profiles, and the curve stays clean."""
    task = DesignTask(model=SmoothModel(), positions=4, limits=wide_limits(), between_positions=8)
    reference = best_constant(task)
    finder = PointFinder(
        task, reference, power_max(task), 1, certify=False, seed=0, progress=None, total=9
    )
    solve = PointFinder.solve
    calls = 0

    def poor(self: PointFinder, objective: Any, starts: Any) -> Any:
        nonlocal calls
        calls += 1
        found = solve(self, objective, starts)
        if calls == 1:
            return found
        stuck = replace(
            found.solution,
            profile=reference.profile,
            loads=reference.loads,
            status=Status.CONVERGED,
        )
        return replace(found, solution=stuck)

    monkeypatch.setattr(PointFinder, "solve", poor)
    points = finder.curve([20.0, 30.0, 40.0], [], anchors=1)
    taken = [point for point in points if point.status is Status.ITERATION_LIMIT]
    assert len(taken) == 2
    assert all("profile of mu 20" in point.message for point in taken)
    for point in points[1:]:
        np.testing.assert_array_equal(point.profile, points[0].profile)
