"""Fewer rotor positions as a start: what they hold, and that results do not depend on them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from design_factories import best_nudge, drawn_case, random_profile, rotor_curves, wide_limits

from pitchopt.design.certificate import lagrangian_bound, station_values
from pitchopt.design.coarse import interpolated, stride, widened
from pitchopt.design.multipliers import Multipliers
from pitchopt.design.power import maximise_torque
from pitchopt.design.problem import DesignProblem, Objective
from pitchopt.design.relaxation import relax
from pitchopt.design.results import Status
from pitchopt.design.scp import ScpSettings, solve_local

OBJECTIVE = Objective(torque=1.0, rms=(3.0, 3.0, 3.0, 1.0, 0.0))


@pytest.fixture(scope="module")
def large() -> DesignProblem:
    return DesignProblem(curves=rotor_curves(positions=120, knots=65), limits=wide_limits())


def without_coarse(problem: DesignProblem) -> DesignProblem:
    """The same problem with its coarse one taken away."""
    other = replace(problem)
    other.__dict__["coarse"] = None
    return other


class TestStations:
    @pytest.mark.parametrize(
        ("positions", "step"),
        [(1, 1), (24, 1), (119, 1), (120, 2), (127, 1), (180, 3), (240, 4), (250, 2), (360, 6)],
    )
    def test_stride(self, positions: int, step: int) -> None:
        assert stride(positions) == step

    def test_loads_of_shared_positions(self, large: DesignProblem) -> None:
        """Without pitch-rate terms a shared position has the same loads."""
        coarse = large.coarse
        assert coarse is not None
        assert coarse.curves.positions == 60
        profile = random_profile(np.random.default_rng(3), large)
        few = coarse.curves.evaluate(profile[::2])
        all_of_them = large.curves.evaluate(profile)
        assert np.allclose(few.rotor, all_of_them.rotor[:, ::2], rtol=1e-12)
        assert np.allclose(few.bending, all_of_them.bending[::2], rtol=1e-12)

    def test_rate_limit_of_the_interpolated_profile(self, large: DesignProblem) -> None:
        coarse = large.coarse
        assert coarse is not None
        rng = np.random.default_rng(5)
        for _ in range(20):
            profile = interpolated(random_profile(rng, coarse), 2)
            assert large.limits.violation(large.curves, profile)[1] < 1e-12

    def test_interpolated_is_periodic_and_exact_on_its_points(self) -> None:
        values = np.array([[1.0, 4.0, -2.0], [0.0, 3.0, 6.0]])
        fine = interpolated(values, 3)
        assert np.array_equal(fine[:, ::3], values)
        assert fine[0] == pytest.approx([1, 2, 3, 4, 2, 0, -2, -1, 0])
        assert np.array_equal(interpolated(values, 1), values)

    def test_columns_keep_their_rates(self) -> None:
        curves = rotor_curves(positions=8, rates=0.01, mean_pitch=0.05)
        few = curves.thinned(2)
        assert few.positions == 2
        assert few.mean_pitch == curves.mean_pitch
        assert np.array_equal(few.rates, curves.rates[:, ::4])


class TestResults:
    @pytest.mark.slow
    def test_local_optimum(self, large: DesignProblem) -> None:
        start = np.full(large.curves.stations, 0.04)
        found = solve_local(large, OBJECTIVE, start)
        whole = solve_local(large, OBJECTIVE, start, settings=ScpSettings(coarse=False))
        assert found.status is Status.CONVERGED
        assert found.value == pytest.approx(whole.value, rel=1e-4)
        gain = best_nudge(large, OBJECTIVE, found.profile, np.random.default_rng(1), tries=20)
        assert gain <= 1e-7 * abs(found.value)

    def test_a_better_start_is_kept(self, large: DesignProblem) -> None:
        """From an optimum the fewer positions cannot lead anywhere worse."""
        best = solve_local(large, OBJECTIVE, np.full(large.curves.stations, 0.04))
        again = solve_local(large, OBJECTIVE, best.profile)
        assert again.value >= best.value

    def test_power_maximum_is_exact(self, large: DesignProblem) -> None:
        start = np.full(large.curves.stations, 0.04)
        found = maximise_torque(large, start)
        assert found.status is Status.EXACT
        whole = maximise_torque(without_coarse(large), start)
        assert found.value == pytest.approx(whole.value, rel=1e-9)

    @pytest.mark.parametrize("mu", [0.1, 3.0, 100.0])
    def test_bound(self, large: DesignProblem, mu: float) -> None:
        """The coarse multipliers bound the fine problem, closely; the rounds close the rest."""
        objective = replace(OBJECTIVE, rms=tuple(mu * v for v in OBJECTIVE.rms))
        assert large.coarse is not None
        coarse = relax(large.coarse, objective)
        closed = relax(large, objective)
        alone = relax(without_coarse(large), objective)
        assert coarse is not None and closed is not None and alone is not None
        first, _ = lagrangian_bound(large, objective, widened(coarse.multipliers, 2))
        assert first <= alone.upper_bound + 1e-3 * large.torque_scale
        assert closed.upper_bound == pytest.approx(alone.upper_bound, abs=3e-5 * large.torque_scale)
        rng = np.random.default_rng(2)
        for _ in range(20):
            value = large.value(random_profile(rng, large), objective)
            assert value <= min(first, closed.upper_bound)
        solution = solve_local(large, objective, closed.profile)
        assert solution.value <= min(first, closed.upper_bound, alone.upper_bound)


class TestBrackets:
    @pytest.mark.parametrize("seed", range(12))
    def test_station_values(self, seed: int) -> None:
        """Brackets of the bound against their formula, term by term."""
        case = drawn_case(seed + 300)
        problem, objective, curves = case.problem, case.objective, case.problem.curves
        rng = np.random.default_rng(seed)
        n, m = curves.stations, curves.positions
        mult = Multipliers(
            loads=rng.normal(size=(4, m)) * (rng.random((4, 1)) < 0.7),
            blade=rng.normal(size=n),
            rate=rng.normal(size=n),
            torque_min=float(rng.random()),
            torque_max=float(rng.random()),
            mean=float(rng.normal()),
        )
        gain = objective.torque + mult.torque_min - mult.torque_max
        values = station_values(problem, objective, mult)
        half = 0.5 / curves.spacing
        per_rate = np.array(
            [
                gain / m * curves.rates[0, i]
                - sum(mult.loads[q, i % m] * curves.rates[q, i] for q in range(4))
                - mult.blade[i] * curves.rates[4, i]
                for i in range(n)
            ]
        )
        for i in range(n):
            linear = mult.rate[i] - mult.rate[i - 1]
            linear += (per_rate[i - 1] - per_rate[(i + 1) % n]) * half
            if curves.mean_pitch is not None:
                linear -= mult.mean / n
            bracket = gain / m * curves.torque[i] + linear * curves.beta[i]
            for q in range(4):
                bracket = bracket - mult.loads[q, i % m] * curves.loads[q, i]
            bracket = bracket - mult.blade[i] * curves.bending[i]
            size = np.abs(curves.loads[:, i]).max() * 10 + 10
            assert values[i] == pytest.approx(bracket, abs=1e-12 * size)

    def test_largest_loads(self) -> None:
        problem = drawn_case(42).problem
        expected = np.abs(problem.curves.loads).max(axis=2)
        assert np.array_equal(problem.largest_loads, expected)
