"""Problems as users bring them: active rows, cones beside norms, functions without gradients."""

from __future__ import annotations

import cvxpy as cp
import numpy as np
import pytest

from pitchopt.errors import InputError
from pitchopt.sensitivity import PostOptimum

RETURNS = np.array([0.1, 0.2, 0.15, 0.05, 0.12])


def portfolio(kind: str) -> tuple[cp.Problem, cp.Parameter]:
    """Largest return for a limit of risk, written as a norm or as a cone."""
    rng = np.random.default_rng(3)
    factors = rng.normal(size=(5, 5)) * 0.1
    root = np.linalg.cholesky(factors @ factors.T + 0.01 * np.eye(5))
    w = cp.Variable(5, nonneg=True)
    risk = cp.Parameter(nonneg=True, value=0.12)
    limit = cp.norm(root.T @ w) <= risk if kind == "norm" else cp.SOC(risk, root.T @ w)
    problem = cp.Problem(cp.Maximize(RETURNS @ w), [cp.sum(w) == 1, limit])
    problem.solve(solver=cp.CLARABEL)
    return problem, risk


def optimum(problem: cp.Problem, parameter: cp.Parameter, value: float) -> float:
    """Optimal value solved again."""
    parameter.value = value
    return float(problem.solve(solver=cp.CLARABEL))


@pytest.mark.parametrize("dc", [-0.02, -0.002, 0.002, 0.02])
def test_tightened_active_row_is_judged_feasible(dc):
    # the limit of risk is active: its own value is what the solver left, some 1e-9
    problem, risk = portfolio("norm")
    start = problem.value
    estimate = PostOptimum.from_cvxpy(problem, risk).estimate(dc)
    truth = optimum(problem, risk, 0.12 + dc) - start
    assert truth <= estimate.high_order + 1e-8  # jointly concave: never less than the truth
    assert estimate.high_order == pytest.approx(truth, rel=0.2)


@pytest.mark.parametrize("dc", [-0.1, 0.1])
def test_multipliers_that_are_not_unique_are_no_feasibility_failure(dc):
    x, c = cp.Variable(2), cp.Parameter(value=1.0)
    problem = cp.Problem(cp.Minimize(-cp.sum(x)), [x <= c, x <= 1, x <= 2 - c])
    problem.solve(solver=cp.CLARABEL)
    estimate = PostOptimum.from_cvxpy(problem, c).estimate(dc)
    assert estimate.active_set.verdict == "broken"


def test_row_far_smaller_than_its_neighbours_is_in_the_way():
    x, c = cp.Variable(2), cp.Parameter(value=1.0)
    rows = cp.hstack([x[0], -1e-7 * x[0], 1e6 * x[1]]) >= cp.hstack([c, -2e-7, 1.0])
    problem = cp.Problem(cp.Minimize(x[0] + 1e-6 * x[1]), [rows])
    problem.solve(solver=cp.CLARABEL)
    post = PostOptimum.from_cvxpy(problem, c)
    assert post.estimate(0.5).high_order == pytest.approx(0.5, rel=1e-6)
    with pytest.raises(InputError, match="no design meets all"):
        post.estimate(1.5)


@pytest.mark.parametrize("dc", [-0.02, -0.002, 0.002, 0.02])
def test_cone_and_norm_have_the_same_curvature(dc):
    norm, cone = (PostOptimum.from_cvxpy(*portfolio(k)).estimate(dc) for k in ("norm", "cone"))
    assert cone.linearity.measure == pytest.approx(norm.linearity.measure, rel=0.02)
    assert cone.linearity.verdict == norm.linearity.verdict
    # the larger steps are off by 8 and 15 %
    assert cone.linearity.verdict == ("broken" if abs(dc) > 0.01 else "holds")


def test_cone_that_is_not_bent_adds_nothing():
    x, c = cp.Variable(3), cp.Parameter(value=1.0)
    problem = cp.Problem(cp.Maximize(np.array([1.0, 2.0, 2.0]) @ x), [cp.SOC(c, x)])
    problem.solve(solver=cp.CLARABEL)
    estimate = PostOptimum.from_cvxpy(problem, c, x_scale={x: 1.0}).estimate(0.5)
    assert estimate.high_order == pytest.approx(1.5, rel=1e-7)
    assert estimate.linearity.measure == pytest.approx(0.0, abs=1e-6)


def test_function_whose_gradient_cvxpy_does_not_have():
    x, c = cp.Variable(3), cp.Parameter(value=1.0)
    pull = cp.sum_squares(x - np.array([1.0, 2.0, 4.0]))
    problem = cp.Problem(cp.Minimize(cp.norm_inf(x) + pull), [cp.sum(x) <= 5 * c])
    problem.solve(solver=cp.CLARABEL)
    start = problem.value
    post = PostOptimum.from_cvxpy(problem, c)
    estimate = post.estimate(1e-3)
    truth = optimum(problem, c, 1.001) - start
    assert post.stationarity is None
    assert estimate.first_order == pytest.approx(truth, rel=5e-3)
    assert {a.verdict for a in estimate.assumptions} == {"not judged"}


@pytest.mark.parametrize("dc", ["0.1", True, 1j, None])
def test_change_that_is_not_a_number(dc):
    problem, risk = portfolio("norm")
    post = PostOptimum.from_cvxpy(problem, risk)
    with pytest.raises(InputError, match="dc: got"):
        post.estimate(dc)


def test_step_of_several_numbers_is_refused():
    with pytest.raises(InputError, match="step: got"):
        PostOptimum.from_functions(lambda x, c: c * x[0] ** 2, x=[0.0], c=1.0, step=[0.1, 0.2])
    with pytest.raises(InputError, match="step: got"):
        PostOptimum.from_table([0.0, 0.1], [0.0, 1.0], step=-0.1)


def test_function_that_writes_into_its_parameter_harms_no_other():
    def f(x, c):
        value = (x[0] - 2.0) ** 2
        c[:] = 99.0
        return value

    post = PostOptimum.from_functions(
        f, lambda x, c: [x[0] - c[0]], x=[1.0], c=[1.0], multipliers=[2.0]
    )
    assert post.estimate([0.1]).first_order == pytest.approx(-0.2, rel=1e-6)
