"""Restoration: loads promised by the linear model are met on the curves, limits are kept."""

from __future__ import annotations

import numpy as np
import pytest
from design_factories import best_nudge, rotor_curves, wide_limits

from pitchopt.aero.curves import BladeCurves
from pitchopt.cases import load_case
from pitchopt.design import constant, scp
from pitchopt.design.limits import PitchLimits
from pitchopt.design.problem import DesignProblem, Objective
from pitchopt.design.restoration import restored
from pitchopt.design.results import Status

ALL = Objective(torque=1.0, rms=(10.0, 10.0, 10.0, 0.0, 0.0))
SMOOTH = 201  # knots: segments far narrower than the steps


def promised_rotor(
    curves: BladeCurves, point: np.ndarray, profile: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Rotor loads (4, m) and bending (N,) of the linear model, station by station."""
    n, m = curves.stations, curves.positions
    station = np.zeros((5, n))
    rate = (np.roll(profile, -1) - np.roll(profile, 1)) / (2 * curves.spacing)
    for i in range(n):
        j = int(np.searchsorted(curves.beta[i], point[i], side="right")) - 1
        j = min(max(j, 0), curves.beta.shape[1] - 2)
        left, right = curves.loads[:, i, j], curves.loads[:, i, j + 1]
        share = (profile[i] - curves.beta[i, j]) / (curves.beta[i, j + 1] - curves.beta[i, j])
        station[:, i] = left + share * (right - left) + rate[i] * curves.rates[:, i]
    rotor = np.zeros((4, m))
    for i in range(n):
        rotor[:, i % m] += station[:4, i]
    return rotor, station[4]


def wave(n: int, size: float, phase: float = 0.3) -> np.ndarray:
    psi = 2 * np.pi * np.arange(n) / n
    return 0.06 + size * np.cos(psi + phase) + 0.3 * size * np.sin(2 * psi)


class TestLoads:
    @pytest.mark.parametrize("rates", [0.0, 0.01])
    def test_three_loads_are_met(self, rates: float) -> None:
        """Three blades have three pitch angles for torque, tilt and yaw."""
        curves = rotor_curves(positions=12, knots=SMOOTH, rates=rates)
        problem = DesignProblem(curves=curves, limits=wide_limits(np.radians(60.0)))
        point = np.full(36, 0.06)
        profile = wave(36, 0.02)
        target, _ = promised_rotor(problem.curves, point, profile)
        moved = restored(problem, ALL, point, profile)
        before = np.abs(problem.curves.evaluate(profile).rotor - target)[:3].max()
        after = np.abs(problem.curves.evaluate(moved).rotor - target)[:3].max()
        assert before > 100.0  # the curves bend
        assert after < (0.01 if rates == 0 else 0.1) * before

    def test_bending_alone(self) -> None:
        """Where only the blade's own load has a price, it is met at every station."""
        problem = DesignProblem(
            curves=rotor_curves(positions=6, knots=SMOOTH), limits=wide_limits(np.radians(60.0))
        )
        objective = Objective(torque=1.0, rms=(0.0, 0.0, 0.0, 0.0, 1.0))
        point, profile = np.full(18, 0.06), wave(18, 0.02)
        _, target = promised_rotor(problem.curves, point, profile)
        moved = restored(problem, objective, point, profile)
        before = np.abs(problem.curves.evaluate(profile).bending - target).max()
        after = np.abs(problem.curves.evaluate(moved).bending - target).max()
        assert after < 1e-2 * before

    def test_nothing_priced_moves_nothing(self) -> None:
        problem = DesignProblem(curves=rotor_curves(positions=6), limits=wide_limits())
        profile = problem.repaired(wave(18, 0.02))
        objective = Objective(torque=1.0, rms=(0.0, 0.0, 0.0, 0.0, 0.0))
        assert np.array_equal(restored(problem, objective, profile, profile), profile)

    @pytest.mark.parametrize(("blades", "positions"), [(1, 1), (1, 7), (2, 5), (4, 3)])
    def test_any_rotor(self, blades: int, positions: int) -> None:
        """Fewer or more blades than loads: the priced squared misses do not grow."""
        curves = rotor_curves(blades=blades, positions=positions, knots=SMOOTH)
        problem = DesignProblem(curves=curves, limits=wide_limits(np.radians(60.0)))
        point = np.full(curves.stations, 0.06)
        profile = np.clip(wave(curves.stations, 0.02), curves.lower, curves.upper)
        target, _ = promised_rotor(problem.curves, point, profile)
        moved = restored(problem, ALL, point, profile)
        price = 1.0 / np.maximum(target[:3].std(axis=1, keepdims=True), 1.0)
        miss = [
            float(np.sum(price * (problem.curves.evaluate(p).rotor - target)[:3] ** 2))
            for p in (profile, moved)
        ]
        assert np.all(np.isfinite(moved))
        assert miss[1] <= miss[0] * (1 + 1e-9)


class TestLimits:
    def test_range_is_kept_and_its_ends_are_held(self) -> None:
        problem = DesignProblem(
            curves=rotor_curves(positions=8), limits=wide_limits(np.radians(90.0))
        )
        curves = problem.curves
        profile = np.clip(wave(24, 0.3), curves.lower, curves.upper)
        ends = (profile == curves.lower) | (profile == curves.upper)
        assert 0 < ends.sum() < 24
        moved = restored(problem, ALL, np.full(24, 0.06), profile)
        assert np.all(moved >= curves.lower)
        assert np.all(moved <= curves.upper)
        assert np.abs(moved - profile)[ends].max() < 1e-2 * np.abs(moved - profile)[~ends].max()

    def test_neighbours_at_the_rate_limit_move_together(self) -> None:
        curves = rotor_curves(positions=12, knots=SMOOTH)
        problem = DesignProblem(
            curves=curves, limits=PitchLimits(rotor_speed=2.0, pitch_rate=np.radians(2.0))
        )
        profile = problem.repaired(wave(36, 0.03))
        step = np.abs(np.roll(profile, -1) - profile)
        tied = step >= problem.step * (1 - 1e-9)
        tied[11::12] = False  # the band does not reach from one passage to the next
        assert 3 < tied.sum() < 33
        moved = restored(problem, ALL, np.full(36, 0.06), profile)
        change = np.abs((np.roll(moved, -1) - moved) - (np.roll(profile, -1) - profile))
        assert np.abs(moved - profile).max() > 1e-4
        assert change[tied].max() < 1e-2 * np.abs(moved - profile).max()

    def test_a_fixed_mean_is_kept(self) -> None:
        curves = rotor_curves(positions=8, knots=SMOOTH, mean_pitch=0.06)
        problem = DesignProblem(curves=curves, limits=wide_limits(np.radians(60.0)))
        profile = wave(24, 0.02)
        profile += 0.06 - profile.mean()
        moved = restored(problem, ALL, np.full(24, 0.06), profile)
        assert np.abs(moved - profile).max() > 1e-5
        assert moved.mean() == pytest.approx(0.06, abs=1e-12)

    def test_harmonics_are_left_alone(self) -> None:
        problem = DesignProblem(curves=rotor_curves(positions=8), limits=wide_limits(), harmonics=2)
        profile = wave(24, 0.02)
        assert np.array_equal(restored(problem, ALL, np.full(24, 0.06), profile), profile)


class TestLocalSolve:
    def test_flat_loads_at_a_high_price(self, monkeypatch: pytest.MonkeyPatch) -> None:
        """From constant pitch a short walk reaches flat loads; without restoration it is long."""
        task = load_case("biegel2011").with_values({"limits.positions": 24}).task()
        problem = task.problem()
        objective = Objective.tradeoff(1000.0, task.weights)
        start = constant(task).profile
        solution = scp.solve_local(problem, objective, start)
        assert solution.status is Status.CONVERGED
        assert np.all(solution.loads.rms[:3] < 1e-4 * solution.loads.rms[3])
        gain = best_nudge(problem, objective, solution.profile, np.random.default_rng(0))
        assert gain <= 1e-7 * abs(solution.value)
        monkeypatch.setattr(scp, "restored", lambda *args, **_: args[3])
        without = scp.solve_local(problem, objective, start)
        assert solution.value > 0.99 * without.value  # they end in different optima
        assert solution.iterations < 0.5 * without.iterations
