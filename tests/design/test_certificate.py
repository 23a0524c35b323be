"""Bounds: never below a feasible objective, whatever the multipliers; tight where they can be."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise, product
from typing import Any

import cvxpy as cp
import numpy as np
import pytest
from design_factories import (
    Case,
    drawn_case,
    random_curves,
    random_profile,
    rotor_curves,
    slow_value,
    wide_limits,
)
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from pitchopt.design import (
    DesignProblem,
    Multipliers,
    Objective,
    lagrangian_bound,
    relax,
    solve_local,
)
from pitchopt.design.certificate import projected
from pitchopt.design.power import maximise_torque

FloatArray = NDArray[np.float64]


def best_known(case: Case, seed: int, count: int = 8) -> float:
    """Largest objective among random feasible profiles, by the slow sums."""
    problem, objective = case.problem, case.objective
    rng = np.random.default_rng(seed)
    values = [slow_value(problem.curves, case.profile, objective)]
    for _ in range(count):
        profile = random_profile(rng, problem)
        if max(problem.excess(problem.curves.evaluate(profile), objective)) <= 0:
            values.append(slow_value(problem.curves, profile, objective))
    return max(values)


def random_multipliers(seed: int, case: Case) -> Multipliers:
    rng = np.random.default_rng(seed)
    n, m = case.problem.curves.stations, case.problem.curves.positions
    size = 10.0 ** rng.uniform(-3, 2)
    per_pitch = size * case.size / float(np.ptp(case.problem.curves.beta))
    return Multipliers(
        loads=rng.normal(0, size, (4, m)),
        blade=rng.normal(0, size, n),
        rate=rng.normal(0, per_pitch, n),
        torque_min=float(rng.normal(0, size)),
        torque_max=float(rng.normal(0, size)),
        cap=float(rng.normal(0, size)),
        mean=float(rng.normal(0, per_pitch)),
    )


class TestNeverTooLow:
    @given(seed=st.integers(0, 10**6), degenerate=st.booleans())
    @settings(max_examples=150)
    def test_any_multipliers(self, seed: int, degenerate: bool) -> None:
        case = drawn_case(seed, degenerate=degenerate)
        known = best_known(case, seed)
        for k in range(3):
            bound, values = lagrangian_bound(
                case.problem, case.objective, random_multipliers(seed + k, case)
            )
            assert bound >= known - 1e-13 * abs(known), case.name
            assert values.shape == case.problem.curves.beta.shape

    @given(seed=st.integers(0, 10**6), degenerate=st.booleans())
    @settings(max_examples=80)
    def test_relaxation(self, seed: int, degenerate: bool) -> None:
        case = drawn_case(seed, degenerate=degenerate)
        relaxed = relax(case.problem, case.objective, profile=case.profile)
        assert relaxed is not None, case.name
        known = best_known(case, seed)
        assert relaxed.upper_bound >= known - 1e-13 * abs(known), case.name
        again, _ = lagrangian_bound(case.problem, case.objective, relaxed.multipliers)
        assert again == pytest.approx(relaxed.upper_bound, rel=1e-12, abs=1e-12 * case.size)

    @pytest.mark.parametrize("seed", range(25))
    def test_local_solutions_stay_below(self, seed: int) -> None:
        case = drawn_case(seed + 70_000)
        solution = solve_local(case.problem, case.objective, case.profile)
        relaxed = relax(case.problem, case.objective, profile=solution.profile)
        assert relaxed is not None
        excess = case.problem.excess(solution.loads, case.objective)
        prices = relaxed.multipliers  # what the tolerated violation is worth
        worth = excess[0] * (prices.torque_min + prices.torque_max) + excess[1] * prices.cap
        value = slow_value(case.problem.curves, solution.profile, case.objective)
        assert relaxed.upper_bound >= value - worth - 1e-9 * max(case.size, abs(value))

    @pytest.mark.parametrize("size", [1e-3, 1.0, 1e9])
    @pytest.mark.parametrize("span", [1e-4, 0.4])
    def test_scales(self, size: float, span: float) -> None:
        """The bound and its distance scale with the loads."""
        rng = np.random.default_rng(7)
        curves = random_curves(rng, size=size, span=span)
        problem = DesignProblem(curves=curves, limits=wide_limits(span))
        objective = Objective(torque=1.0, rms=(1.0, 0.5, 0.0, 2.0, 0.3))
        solution = solve_local(problem, objective, np.zeros(12))
        relaxed = relax(problem, objective, profile=solution.profile)
        assert relaxed is not None
        assert relaxed.upper_bound >= solution.value
        assert (relaxed.upper_bound - solution.value) / size < 1.0

    def test_rounding_is_covered(self) -> None:
        """Flat huge loads: the bound must not end an ulp below the only value there is."""
        n = 99
        psi = 2 * np.pi * np.arange(n) / n
        for load in (1 / 3, 1e9 / 7, -1e9 / 7):
            flat = np.full((n, 2), load)
            curves = type(rotor_curves())(
                blades=3,
                azimuth=psi,
                beta=np.tile([-0.1, 0.1], (n, 1)),
                torque=flat,
                bending=flat,
                thrust=flat,
            )
            problem = DesignProblem(curves=curves, limits=wide_limits())
            objective = Objective(torque=1.0, rms=(1.0, 1.0, 1.0, 1.0, 1.0))
            value = problem.value(np.zeros(n), objective)
            relaxed = relax(problem, objective)
            assert relaxed is not None
            assert value <= relaxed.upper_bound <= value + 1e-6 * abs(value)


class TestProjection:
    @given(seed=st.integers(0, 10**6))
    @settings(max_examples=60)
    def test_conditions_hold(self, seed: int) -> None:
        case = drawn_case(seed)
        mult = projected(case.problem, case.objective, random_multipliers(seed, case))
        n, m = case.problem.curves.stations, case.problem.curves.positions
        lam = case.objective.lambdas
        assert np.all(np.linalg.norm(mult.loads, axis=1) <= lam[:4] / np.sqrt(m))
        assert np.linalg.norm(mult.blade) <= (lam[4] + mult.cap) / np.sqrt(n)
        np.testing.assert_allclose(mult.loads.mean(axis=1), 0.0, atol=1e-12)
        assert min(mult.torque_min, mult.torque_max, mult.cap) >= 0
        assert mult.torque_min == 0 or np.isfinite(case.objective.torque_min)
        assert mult.torque_max == 0 or np.isfinite(case.objective.torque_max)
        assert mult.cap == 0 or np.isfinite(case.objective.blade_cap)
        assert mult.mean == 0 or case.problem.curves.mean_pitch is not None

    def test_valid_multipliers_stay(self) -> None:
        case = drawn_case(3, smooth=True)
        relaxed = relax(case.problem, case.objective)
        assert relaxed is not None
        again = projected(case.problem, case.objective, relaxed.multipliers)
        np.testing.assert_allclose(again.loads, relaxed.multipliers.loads, atol=1e-15)


def full_hull(case: Case) -> float:
    """The hull relaxation with every breakpoint, written again in cvxpy."""
    problem, objective, curves = case.problem, case.objective, case.problem.curves
    n, m, blades = curves.stations, curves.positions, curves.blades
    size = case.size
    theta = cp.Variable(curves.beta.shape, nonneg=True)
    beta = cp.sum(cp.multiply(theta, curves.beta), axis=1)
    shift = np.eye(n)[np.roll(np.arange(n), -1)]
    rate = (shift - shift.T) @ beta / (2 * curves.spacing)
    blade = [
        cp.sum(cp.multiply(theta, curves.loads[q] / size), axis=1)
        + cp.multiply(curves.rates[q] / size, rate)
        for q in range(5)
    ]
    fold = np.tile(np.eye(m), (1, blades))
    rotor = [fold @ blade[q] for q in range(4)]
    mean = cp.sum(rotor[0]) / m

    def rms(load: Any, count: int) -> Any:
        return cp.norm(load - cp.sum(load) / count) / np.sqrt(count)

    j = [rms(load, m) for load in rotor] + [rms(blade[4], n)]
    change = shift @ beta - beta
    rules = [cp.sum(theta, axis=1) == 1, cp.abs(change) <= problem.step]
    if curves.mean_pitch is not None:
        rules.append(cp.sum(beta) / n == curves.mean_pitch)
    if np.isfinite(objective.torque_min):
        rules.append(mean >= objective.torque_min / size)
    if np.isfinite(objective.torque_max):
        rules.append(mean <= objective.torque_max / size)
    if np.isfinite(objective.blade_cap):
        rules.append(j[4] <= objective.blade_cap / size)
    cost = objective.torque * mean - sum(lam * q for lam, q in zip(objective.rms, j, strict=True))
    cost = cost - objective.travel / size * cp.norm1(change)
    program = cp.Problem(cp.Maximize(cost), rules)
    program.solve(solver=cp.CLARABEL)
    assert program.status == "optimal"
    return float(program.value) * size


class TestTightness:
    @pytest.mark.parametrize("seed", range(16))
    def test_equals_the_full_hull(self, seed: int) -> None:
        case = drawn_case(seed + 900, harmonics=False, smooth=False)
        want = full_hull(case)
        relaxed = relax(case.problem, case.objective, rounds=40)
        assert relaxed is not None
        scale = float(np.abs(case.problem.curves.torque).max()) * case.problem.curves.blades
        assert relaxed.upper_bound >= want - 1e-6 * scale
        assert relaxed.upper_bound <= want + 1e-4 * scale
        assert relaxed.closed

    @pytest.mark.parametrize("rate", [0.02, 1.0])
    def test_no_gap_for_torque_alone(self, rate: float) -> None:
        problem = DesignProblem(curves=rotor_curves(), limits=wide_limits(rate))
        objective = Objective(torque=1.0, rms=(0.0, 0.0, 0.0, 0.0, 0.0))
        best = maximise_torque(problem, np.zeros(24))
        relaxed = relax(problem, objective, profile=best.profile)
        assert relaxed is not None
        assert best.value <= relaxed.upper_bound <= best.value * (1 + 1e-5)

    def test_no_gap_on_one_segment(self) -> None:
        """Affine loads make the whole problem convex: local optimum and bound meet."""
        for seed in range(12):
            rng = np.random.default_rng(seed)
            curves = random_curves(rng, knots=2, rates=bool(seed % 2), frozen=seed % 3 == 0)
            problem = DesignProblem(curves=curves, limits=wide_limits(0.3))
            objective = Objective(torque=1.0, rms=(0.3, 0.2, 0.5, 0.1, 0.2), travel=0.05)
            solution = solve_local(problem, objective, np.zeros(12))
            relaxed = relax(problem, objective)
            assert relaxed is not None
            assert -1e-9 <= relaxed.upper_bound - solution.value <= 2e-4

    def test_rounds_only_help(self) -> None:
        case = drawn_case(11, smooth=True)
        bounds = []
        for rounds in (1, 2, 4, 12):
            relaxed = relax(case.problem, case.objective, rounds=rounds)
            assert relaxed is not None
            bounds.append(relaxed.upper_bound)
            assert relaxed.rounds <= rounds
        assert all(b <= a + 1e-12 * abs(a) for a, b in pairwise(bounds))


class TestBruteForce:
    @pytest.mark.parametrize(
        ("blades", "positions"), [(1, 1), (2, 1), (3, 1), (1, 2), (1, 3), (2, 2)]
    )
    @pytest.mark.parametrize("seed", range(2))
    def test_bound_and_solver_on_a_grid(self, blades: int, positions: int, seed: int) -> None:
        """All profiles of a grid: below the bound, and not above the best local solution."""
        rng = np.random.default_rng(100 * seed + 10 * blades + positions)
        curves = random_curves(rng, blades=blades, positions=positions, knots=3, rates=seed == 1)
        problem = DesignProblem(curves=curves, limits=wide_limits(0.3))
        objective = Objective(torque=1.0, rms=(0.5, 0.4, 0.2, 0.6, 0.3), travel=0.1)
        n = curves.stations
        grids = [
            np.linspace(low, high, {1: 400, 2: 50, 3: 15, 4: 8}[n])
            for low, high in zip(problem.curves.lower, problem.curves.upper, strict=True)
        ]
        best, start = -np.inf, np.zeros(n)
        for pick in product(*grids):
            profile = np.array(pick)
            if problem.limits.violation(problem.curves, profile)[1] > 0:
                continue
            value = problem.value(profile, objective)
            if value > best:
                best, start = value, profile
        relaxed = relax(problem, objective, profile=start)
        assert relaxed is not None
        assert relaxed.upper_bound >= best
        solution = solve_local(problem, objective, start)
        assert best - 1e-9 <= solution.value <= relaxed.upper_bound + 1e-9


class TestFrozenMean:
    def test_bound_moves_with_the_mean(self) -> None:
        """With the mean held, the bound is that of profiles of this mean only."""
        free = DesignProblem(curves=rotor_curves(positions=4), limits=wide_limits())
        objective = Objective(torque=1.0, rms=(1.0, 0.0, 0.0, 1.0, 0.0))
        whole = relax(free, objective)
        held = relax(replace(free, curves=rotor_curves(positions=4, mean_pitch=0.2)), objective)
        assert whole is not None and held is not None
        assert held.upper_bound < whole.upper_bound - 1e3
