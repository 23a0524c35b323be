"""When cone solvers fail: fallbacks in order, and no failure that is called an answer."""

from __future__ import annotations

from typing import Any

import cvxpy as cp
import numpy as np
import pytest
from design_factories import SmoothModel, rotor_curves, wide_limits

from pitchopt.design import (
    DesignProblem,
    DesignTask,
    LoadWeights,
    Objective,
    Status,
    design,
    relax,
    solve_local,
    tradeoff,
)
from pitchopt.design.cones import ConeProgram, ConeSolution
from pitchopt.design.power import maximise_torque

OBJECTIVE = Objective.tradeoff(5.0, LoadWeights.unit())
PROBLEM = DesignProblem(curves=rotor_curves(positions=4), limits=wide_limits(0.3))


def failed(program: ConeProgram) -> ConeSolution:
    return ConeSolution(
        x=np.full(program.width, np.nan),
        z=np.full(program.height, np.nan),
        status="NumericalError",
        solved=False,
        infeasible=False,
        iterations=0,
        seconds=0.0,
    )


@pytest.fixture
def broken_cones(monkeypatch: pytest.MonkeyPatch) -> None:
    """Every direct solve fails; cvxpy still works."""

    def refuse(
        self: ConeProgram, *, reduced: bool = False, tolerance: float | None = None
    ) -> ConeSolution:
        del reduced, tolerance
        return failed(self)

    monkeypatch.setattr(ConeProgram, "solve", refuse)


@pytest.fixture
def broken_cvxpy(monkeypatch: pytest.MonkeyPatch) -> None:
    def refuse(self: cp.Problem, *args: Any, **kwargs: Any) -> None:
        raise cp.SolverError("out of order")

    monkeypatch.setattr(cp.Problem, "solve", refuse)


class TestFallbacks:
    def test_the_looser_scaling_comes_first(self, monkeypatch: pytest.MonkeyPatch) -> None:
        real, reduced_calls = ConeProgram.solve, []

        def flaky(
            self: ConeProgram, *, reduced: bool = False, tolerance: float | None = None
        ) -> ConeSolution:
            reduced_calls.append(reduced)
            return real(self, reduced=reduced, tolerance=tolerance) if reduced else failed(self)

        want = solve_local(PROBLEM, OBJECTIVE, np.zeros(12))
        monkeypatch.setattr(ConeProgram, "solve", flaky)
        solution = solve_local(PROBLEM, OBJECTIVE, np.zeros(12))
        assert reduced_calls[:2] == [False, True]
        assert solution.status is Status.CONVERGED
        assert solution.value == pytest.approx(want.value, rel=1e-3)

    @pytest.mark.usefixtures("broken_cones")
    def test_cvxpy_steps_in(self) -> None:
        solution = solve_local(PROBLEM, OBJECTIVE, np.full(12, 0.05))
        assert solution.status is Status.CONVERGED
        assert solution.value > PROBLEM.value(np.full(12, 0.05), OBJECTIVE)

    def test_one_failure_in_between_does_no_harm(self, monkeypatch: pytest.MonkeyPatch) -> None:
        want = solve_local(PROBLEM, OBJECTIVE, np.zeros(12))
        real, count = ConeProgram.solve, [0]

        def flaky(
            self: ConeProgram, *, reduced: bool = False, tolerance: float | None = None
        ) -> ConeSolution:
            count[0] += 1
            return (
                failed(self)
                if count[0] % 3 == 1
                else real(self, reduced=reduced, tolerance=tolerance)
            )

        monkeypatch.setattr(ConeProgram, "solve", flaky)
        solution = solve_local(PROBLEM, OBJECTIVE, np.zeros(12))
        assert solution.status is Status.CONVERGED
        assert solution.value == pytest.approx(want.value, rel=1e-3)

    def test_not_numbers_from_the_solver_are_a_failure(self) -> None:
        program = ConeProgram()
        program.variables("x", 1, cost=1.0)
        program.nonneg(np.array([-1.0]), (0, 0, 1.0))  # x <= -1, unbounded below
        solution = program.solve()
        assert not solution.solved
        assert solution.status == "DualInfeasible"


@pytest.mark.usefixtures("broken_cones", "broken_cvxpy")
class TestNothingWorks:
    def test_local_solve_says_so(self) -> None:
        start = np.full(12, 0.05)
        solution = solve_local(PROBLEM, OBJECTIVE, start)
        assert solution.status is Status.SOLVER_FAILED
        assert not solution.status.ok
        assert "failed" in solution.message
        np.testing.assert_allclose(solution.profile, start, atol=1e-12)
        assert np.isfinite(solution.value)

    def test_power_maximum_says_so(self) -> None:
        assert maximise_torque(PROBLEM, np.zeros(12)).status is Status.SOLVER_FAILED

    def test_no_bound_is_none(self) -> None:
        assert relax(PROBLEM, OBJECTIVE) is None

    def test_curve_says_so(self) -> None:
        task = DesignTask(
            model=SmoothModel(), positions=3, limits=wide_limits(), between_positions=6
        )
        out = tradeoff(task, mu=[1.0, 10.0], losses=[0.03])
        assert {p.status for p in (out.power_max, *out.points)} == {Status.SOLVER_FAILED}
        assert all(p.upper_bound is None and p.gap is None for p in out.points)
        one = design(task, mu=1.0)
        assert one.status is Status.SOLVER_FAILED


class TestWorksUntilItFails:
    def test_a_failure_later_is_not_called_converged(self, monkeypatch: pytest.MonkeyPatch) -> None:
        real, count = ConeProgram.solve, [0]

        def dies(
            self: ConeProgram, *, reduced: bool = False, tolerance: float | None = None
        ) -> ConeSolution:
            count[0] += 1
            return (
                failed(self) if count[0] > 2 else real(self, reduced=reduced, tolerance=tolerance)
            )

        def refuse(self: cp.Problem, *args: Any, **kwargs: Any) -> None:
            raise cp.SolverError("out of order")

        monkeypatch.setattr(ConeProgram, "solve", dies)
        monkeypatch.setattr(cp.Problem, "solve", refuse)
        start = np.full(12, 0.15)
        solution = solve_local(PROBLEM, OBJECTIVE, start)
        assert solution.status is Status.SOLVER_FAILED
        assert solution.value >= PROBLEM.value(start, OBJECTIVE)


def test_regression_a_load_that_is_the_same_everywhere_has_a_bound() -> None:
    """Constant thrust made the relaxation divide by nothing and give no bound at all."""
    curves = rotor_curves(positions=4)
    level = type(curves)(
        blades=3,
        azimuth=curves.azimuth,
        beta=curves.beta,
        torque=curves.torque,
        bending=curves.bending,
        thrust=np.full(curves.beta.shape, 7e4),
    )
    problem = DesignProblem(curves=level, limits=wide_limits(0.3))
    relaxed = relax(problem, OBJECTIVE)
    assert relaxed is not None
    assert relaxed.upper_bound >= solve_local(problem, OBJECTIVE, np.zeros(12)).value
