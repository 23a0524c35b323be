"""A problem is left as it was found, and what was read from it stays."""

import warnings

import cvxpy as cp
import numpy as np
import pytest
from convex_examples import TIGHT, problem

from pitchopt.errors import InputError
from pitchopt.sensitivity import PostOptimum


def state(prob):
    """All that a user can see of a solved problem."""
    duals = [np.array(v.value) for con in prob.constraints for v in con.dual_variables]
    return (
        prob.status, prob.value, [np.array(v.value) for v in prob.variables()],
        [np.array(p.value) for p in prob.parameters()], duals,
        prob.solver_stats.num_iters,
    )  # fmt: skip


def same(a, b):
    assert a[:2] == b[:2] and a[5] == b[5]
    for one, other in zip(a[2:5], b[2:5], strict=True):
        for x, y in zip(one, other, strict=True):
            np.testing.assert_array_equal(x, y)


@pytest.mark.parametrize("kind", ["at least, vector", "SOC, rows", "PSD", "ExpCone"])
def test_estimates_leave_the_problem_alone(kind):
    prob, c = problem(kind, "min")
    prob.solve(**TIGHT)
    before = state(prob)
    PostOptimum.from_cvxpy(prob, c).estimates([0.05, -0.05])
    same(before, state(prob))


def blocked():
    """Feasible up to c = 2."""
    x, c = cp.Variable(name="x"), cp.Parameter(name="c", value=1.0)
    prob = cp.Problem(cp.Minimize(x**2), [x >= c, x <= 2.0])
    prob.solve(**TIGHT)
    return prob, c


def test_failed_estimates_leave_the_problem_alone():
    prob, c = blocked()
    before = state(prob)
    po = PostOptimum.from_cvxpy(prob, c)
    with pytest.raises(InputError, match="no design"):
        po.estimate(2.0)
    with pytest.raises(InputError, match="shape"):
        po.estimate([1.0, 2.0])
    same(before, state(prob))


def test_later_changes_of_the_problem_do_not_reach_the_estimates():
    x = cp.Variable(2)
    c, other = cp.Parameter(value=1.0), cp.Parameter(value=2.0)
    prob = cp.Problem(cp.Minimize(cp.sum_squares(x) + other * x[0]), [x >= c])
    prob.solve(**TIGHT)
    po = PostOptimum.from_cvxpy(prob, c)
    first = po.estimate(0.3)
    c.value, other.value = 5.0, -9.0
    prob.solve(**TIGHT)
    after = state(prob)
    again = po.estimate(0.3)
    assert (again.first_order, again.high_order) == (first.first_order, first.high_order)
    assert again.reference == first.reference
    same(after, state(prob))


def test_problem_that_is_not_dpp_works():
    x, c = cp.Variable(2), cp.Parameter(value=1.0, nonneg=True)
    prob = cp.Problem(cp.Minimize(cp.sum_squares(x)), [x[0] >= c * c, x[1] >= cp.exp(c)])
    assert not prob.is_dpp()
    with warnings.catch_warnings():
        warnings.filterwarnings("ignore", message="You are solving a parameterized")
        prob.solve(**TIGHT)
    e = PostOptimum.from_cvxpy(prob, c, names=["square", "power"]).estimate(0.1)
    slope = 2.0 * 1.0 * 2.0 + 2.0 * np.exp(1.0) ** 2
    assert e.first_order == pytest.approx(0.1 * slope, rel=1e-6)
    high = 2.0 * (1.1**2 - 1.0) + 2.0 * np.e * (np.exp(1.1) - np.e)
    assert e.high_order == pytest.approx(high, rel=1e-6)
    assert [k.name for k in e.largest()] == ["power", "square"]


@pytest.mark.parametrize("attribute", ["symmetric", "diag", "PSD"])
def test_parameters_with_attributes(attribute):
    c = cp.Parameter((2, 2), value=np.diag([1.0, 2.0]), **{attribute: True})
    x = cp.Variable((2, 2))
    prob = cp.Problem(cp.Minimize(cp.sum_squares(x)), [x >= c])
    prob.solve(**TIGHT)
    po = PostOptimum.from_cvxpy(prob, c)
    e = po.estimate(0.1 * np.eye(2))
    assert e.first_order == pytest.approx(2.0 * 0.1 * 3.0, rel=1e-6)
    with pytest.raises(InputError, match="would break its own attributes"):
        po.estimate(np.array([[0.0, 1.0], [0.0, 0.0]]))


def test_loosely_solved_problem_does_not_ask_for_feasibility():
    """What x* violates at c_r already is not held against dc."""
    x, c = cp.Variable(2), cp.Parameter(value=1.0)
    prob = cp.Problem(cp.Minimize(cp.sum_squares(x)), [cp.sum(x) >= c, x[0] <= 4.0])
    prob.solve(solver="SCS", eps_abs=1e-4, eps_rel=1e-4)
    po = PostOptimum.from_cvxpy(prob, c)
    e = po.estimate(0.2)
    assert e.attained == pytest.approx(0.22, abs=1e-3)
    assert e.first_order == pytest.approx(0.2, abs=1e-3)
