"""The local solve: feasible, monotone, and a true local optimum of the BladeCurves."""

from __future__ import annotations

from itertools import pairwise
from typing import Any

import numpy as np
import pytest
from design_factories import (
    best_nudge,
    drawn_case,
    random_profile,
    rotor_curves,
    slow_value,
    wide_limits,
)
from numpy.typing import NDArray

from pitchopt.design import (
    ConvexSubproblem,
    DesignProblem,
    LoadWeights,
    Objective,
    PitchLimits,
    ScpSettings,
    Status,
    solve_local,
)
from pitchopt.errors import InputError

FloatArray = NDArray[np.float64]
UNIT = LoadWeights.unit()


def rotor_problem(**change: Any) -> DesignProblem:
    good: dict[str, Any] = {"curves": rotor_curves(positions=6), "limits": wide_limits(0.3)}
    return DesignProblem(**(good | change))


class TestEveryKind:
    @pytest.mark.parametrize("seed", [*range(24), 45, 207, 901, 1111, 1452, 1528, 1641, 1840, 1857])
    def test_local_optimum(self, seed: int) -> None:
        """Those from 45 on once ended early: called converged beside a segment that gains, or
        infeasible from a feasible start."""
        case = drawn_case(seed)
        problem, objective = case.problem, case.objective
        solution = solve_local(problem, objective, case.profile)
        assert solution.status is Status.CONVERGED, solution.message
        # feasible
        outside, over = problem.limits.violation(problem.curves, solution.profile)
        assert outside <= 1e-6
        assert over <= 1e-6
        torque, blade = problem.excess(solution.loads, objective)
        assert torque <= 1e-6 * abs(solution.loads.mean[0])
        assert blade <= 1e-6 * min(objective.blade_cap, 1e300)
        mean = problem.curves.mean_pitch
        if mean is not None:
            assert solution.profile.mean() == pytest.approx(mean, abs=1e-9)
        if problem.basis is not None:
            fit = np.linalg.lstsq(problem.basis, solution.profile)[0]
            assert np.abs(solution.profile - problem.basis @ fit).max() < 1e-12
        # what is said is true
        value = slow_value(problem.curves, solution.profile, objective)
        scale = max(abs(value), abs(float(solution.loads.mean[0])))
        assert solution.value == pytest.approx(value, abs=1e-9 * scale)
        if (
            torque == blade == 0
            and not np.isfinite(
                [objective.torque_min, objective.torque_max, objective.blade_cap]
            ).any()
        ):
            assert value >= slow_value(problem.curves, case.profile, objective) - 1e-9 * scale
            assert np.all(np.diff(solution.history) >= 0)
        # no small move gains
        gain = best_nudge(problem, objective, solution.profile, np.random.default_rng(seed))
        assert gain <= 1e-7 * scale, case.name

    @pytest.mark.parametrize("seed", range(6))
    def test_no_start_beats_the_bound_of_a_convex_problem(self, seed: int) -> None:
        """One segment per station: every start ends at the same value."""
        rng = np.random.default_rng(seed)
        problem = rotor_problem(curves=rotor_curves(positions=4, knots=2, rates=0.01))
        objective = Objective.tradeoff(3.0, UNIT, travel=1e3)
        values = [
            solve_local(problem, objective, random_profile(rng, problem)).value for _ in range(3)
        ]
        assert np.ptp(values) <= 2e-6 * abs(values[0])


class TestRestrictions:
    def test_mean_torque_held_from_both_sides(self) -> None:
        problem = rotor_problem()
        for target in (0.95, 0.8, 0.6):
            torque = target * 3 * 4e5
            objective = Objective.least_rms(UNIT, torque_min=torque, torque_max=torque)
            solution = solve_local(problem, objective, np.full(18, 0.05))
            assert solution.status is Status.CONVERGED
            assert solution.loads.mean[0] == pytest.approx(torque, rel=1e-6)

    def test_torque_limit_that_binds_and_one_that_does_not(self) -> None:
        problem = rotor_problem()
        loose = solve_local(problem, Objective.least_rms(UNIT, torque_min=1.0), np.zeros(18))
        assert loose.multipliers.torque_min == pytest.approx(0.0, abs=1e-4)
        tight = solve_local(problem, Objective.least_rms(UNIT, torque_min=1.15e6), np.zeros(18))
        assert tight.loads.mean[0] == pytest.approx(1.15e6, rel=1e-6)
        assert tight.multipliers.torque_min > 0
        assert tight.value < loose.value

    def test_unreachable_torque_is_infeasible(self) -> None:
        problem = rotor_problem()
        solution = solve_local(problem, Objective.least_rms(UNIT, torque_min=1e8), np.zeros(18))
        assert solution.status is Status.INFEASIBLE
        assert "torque limit missed by" in solution.message
        assert not solution.status.ok
        assert problem.limits.violation(problem.curves, solution.profile)[0] <= 1e-9

    def test_blade_cap(self) -> None:
        problem = rotor_problem()
        objective = Objective.tradeoff(5.0, UNIT)
        free = solve_local(problem, objective, np.zeros(18))
        cap = 0.7 * free.loads.blade_rms
        capped = Objective.tradeoff(5.0, UNIT, blade_cap=cap)
        solution = solve_local(problem, capped, np.zeros(18))
        assert solution.status is Status.CONVERGED
        assert solution.loads.blade_rms <= cap * (1 + 1e-6)
        assert solution.value < free.value

    @pytest.mark.parametrize("order", [1, 2, 4])
    def test_harmonics_restrict(self, order: int) -> None:
        free = rotor_problem()
        problem = rotor_problem(harmonics=order)
        objective = Objective.tradeoff(20.0, UNIT)
        whole = solve_local(free, objective, np.zeros(18)).value
        solution = solve_local(problem, objective, np.zeros(18))
        spectrum = np.abs(np.fft.rfft(solution.profile)) / 18
        assert np.all(spectrum[order + 1 :] < 1e-12)
        assert spectrum[1] > 1e-4
        assert solution.value < whole

    def test_travel_penalty_reduces_travel(self) -> None:
        problem = rotor_problem()
        travel = [
            problem.travel(
                solve_local(
                    problem, Objective.tradeoff(10.0, UNIT, travel=price), np.zeros(18)
                ).profile
            )
            for price in (0.0, 1e4, 1e5, 1e8)
        ]
        assert all(b <= a + 1e-9 for a, b in pairwise(travel))
        assert travel[-1] < 1e-6 < 0.01 < travel[0]

    def test_rate_limit_binds(self) -> None:
        problem = rotor_problem(limits=wide_limits(0.01))
        solution = solve_local(problem, Objective.tradeoff(20.0, UNIT), np.zeros(18))
        change = np.abs(np.roll(solution.profile, -1) - solution.profile)
        assert change.max() == pytest.approx(problem.step, rel=1e-6)
        assert np.any(np.abs(solution.multipliers.rate) > 0)

    def test_frozen_mean_is_kept(self) -> None:
        problem = rotor_problem(curves=rotor_curves(positions=6, mean_pitch=0.07))
        solution = solve_local(problem, Objective.tradeoff(5.0, UNIT), np.zeros(18))
        assert solution.profile.mean() == pytest.approx(0.07, abs=1e-10)


class TestInvariance:
    def test_loads_in_other_units(self) -> None:
        objective = Objective.tradeoff(5.0, UNIT)
        base = solve_local(rotor_problem(), objective, np.zeros(18))
        for size in (1e-2, 1e12):
            problem = rotor_problem(curves=rotor_curves(positions=6, size=size))
            other = solve_local(problem, objective, np.zeros(18))
            assert other.status is Status.CONVERGED
            assert other.value / size == pytest.approx(base.value / 1e5, rel=1e-5)

    def test_first_station_elsewhere(self) -> None:
        objective = Objective.tradeoff(5.0, UNIT)
        base = solve_local(rotor_problem(), objective, np.zeros(18))
        c = rotor_curves(positions=6)
        fields: dict[str, Any] = {
            name: np.roll(getattr(c, name), -5, axis=0)
            for name in ("torque", "bending", "thrust", "radial")
        }
        turned = type(c)(blades=3, azimuth=c.azimuth + 5 * c.spacing, beta=c.beta, **fields)
        other = solve_local(rotor_problem(curves=turned), objective, np.zeros(18))
        assert other.value == pytest.approx(base.value, rel=1e-5)


class TestUserConstraints:
    def test_kept_through_the_local_solve(self) -> None:
        problem, objective = rotor_problem(), Objective.tradeoff(20.0, UNIT)
        free = solve_local(problem, objective, np.full(18, 0.02))
        where = int(np.argmax(free.profile))
        limit = 0.5 * (float(free.profile[where]) + float(free.profile.min()))
        program = ConvexSubproblem(
            problem, objective, constraints=lambda beta: [beta[where] <= limit]
        )
        start = program.project(free.profile)
        solution = solve_local(problem, objective, start, subproblem=program)
        assert solution.status is Status.CONVERGED
        assert solution.profile[where] <= limit + 1e-6
        assert solution.value <= free.value + 1e-6 * abs(free.value)

    def test_same_answer_as_the_direct_path(self) -> None:
        problem, objective = rotor_problem(), Objective.tradeoff(5.0, UNIT)
        one = solve_local(problem, objective, np.zeros(18))
        two = solve_local(
            problem, objective, np.zeros(18), subproblem=ConvexSubproblem(problem, objective)
        )
        assert two.status is Status.CONVERGED
        assert two.value == pytest.approx(one.value, rel=1e-6)

    def test_regression_kept_when_the_solver_falls_back(
        self, monkeypatch: pytest.MonkeyPatch
    ) -> None:
        """The last fallback must not build a program without the user's constraints."""
        problem, objective = rotor_problem(), Objective.tradeoff(20.0, UNIT)
        program = ConvexSubproblem(problem, objective, constraints=lambda beta: [beta >= 0.08])
        real, calls = type(program).solve, []

        def flaky(self: ConvexSubproblem, *args: Any, **kwargs: Any) -> Any:
            out = real(self, *args, **kwargs)
            calls.append(self)
            if self is program:
                return type(out)(**(vars(out) | {"solved": False}))
            return out

        monkeypatch.setattr(ConvexSubproblem, "solve", flaky)
        solution = solve_local(problem, objective, np.full(18, 0.1), subproblem=program)
        assert calls
        assert solution.profile.min() >= 0.08 - 1e-6


class TestStatus:
    def test_few_steps_are_not_called_converged(self) -> None:
        problem, objective = rotor_problem(), Objective.tradeoff(20.0, UNIT)
        best = solve_local(problem, objective, np.full(18, 0.2))
        for steps, cells in ((1, 1), (2, 1), (0, 1)):
            settings = ScpSettings(max_steps=steps, max_cells=cells)
            solution = solve_local(problem, objective, np.full(18, 0.2), settings=settings)
            assert solution.status is Status.ITERATION_LIMIT
            assert solution.value < best.value
            assert not solution.status.ok

    def test_regression_nothing_tried_is_no_solver_failure(self) -> None:
        problem, objective = rotor_problem(), Objective.tradeoff(20.0, UNIT)
        solution = solve_local(problem, objective, np.zeros(18), should_stop=lambda: True)
        assert solution.status is Status.ITERATION_LIMIT
        assert solution.iterations == 0

    def test_stop_in_the_middle(self) -> None:
        problem, objective = rotor_problem(), Objective.tradeoff(20.0, UNIT)
        asked = []

        def stop() -> bool:
            asked.append(1)
            return len(asked) > 3

        solution = solve_local(problem, objective, np.full(18, 0.2), should_stop=stop)
        assert solution.status is Status.ITERATION_LIMIT
        assert solution.value >= problem.value(np.full(18, 0.2), objective)

    @pytest.mark.parametrize("start", [np.zeros(17), np.zeros((18, 1)), np.full(18, np.nan)])
    def test_refuses_starts(self, start: FloatArray) -> None:
        with pytest.raises(InputError, match="start: got shape"):
            solve_local(rotor_problem(), Objective.tradeoff(1.0, UNIT), start)

    def test_start_outside_the_limits_is_moved(self) -> None:
        limits = PitchLimits(rotor_speed=2.0, pitch_rate=0.3, lower=0.0, upper=0.1)
        problem = rotor_problem(limits=limits)
        solution = solve_local(problem, Objective.tradeoff(1.0, UNIT), np.linspace(-3, 3, 18))
        assert solution.status is Status.CONVERGED
        assert problem.limits.violation(problem.curves, solution.profile)[0] <= 1e-9
