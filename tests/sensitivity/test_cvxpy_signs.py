"""Slopes of re-solved optima for every kind of constraint, minimising and maximising."""

import warnings

import cvxpy as cp
import numpy as np
import pytest
from convex_examples import CONSTRAINTS, problem, solve, solved_at

from pitchopt.sensitivity import PostOptimum

pytestmark = pytest.mark.filterwarnings(r"ignore:\s*Explicitly invoking")


def resolved_slope(prob, c, h=2e-3):
    """Central difference of fourth order."""
    z = [solved_at(prob, c, c.value + k * h) for k in (-2, -1, 1, 2)]
    return (z[0] - 8.0 * z[1] + 8.0 * z[2] - z[3]) / (12.0 * h)


@pytest.mark.parametrize("where", ["constraint", "objective", "both"])
@pytest.mark.parametrize("sense", ["min", "max"])
@pytest.mark.parametrize("kind", CONSTRAINTS)
def test_first_order_is_the_slope_of_the_resolved_optimum(kind, sense, where):
    prob, c = problem(kind, sense, where)
    slope = resolved_slope(prob, c)
    solve(prob)
    po = PostOptimum.from_cvxpy(prob, c)
    assert po.stationarity < 1e-6
    estimate = po.estimate(0.01)
    assert abs(slope) > 1e-2
    assert estimate.first_order == pytest.approx(0.01 * slope, rel=1e-4 if "ND" in kind else 2e-5)
    # both estimates have the same slope
    small = po.estimate(1e-4)
    assert small.high_order == pytest.approx(1e-4 * slope, rel=2e-3)
    # carried by the constraint, the objective or both, and nothing is lost
    total = estimate.objective.first_order + sum(k.first_order for k in estimate.largest(None))
    assert total == pytest.approx(estimate.first_order, rel=1e-12)
    if where == "objective":
        assert estimate.constraints[0].high_order == 0.0
    if where == "constraint":
        assert estimate.objective_high_order == 0.0


@pytest.mark.parametrize("sense", ["min", "max"])
@pytest.mark.parametrize("kind", ["SOC, columns", "SOC, rows", "PSD", "ExpCone", "PowCone3D"])
def test_high_order_of_a_cone_bounds_the_optimum_from_the_right_side(kind, sense):
    """The Lagrangian is convex in x and stationary there: L(x*, c + dc) is close to its least."""
    prob, c = problem(kind, sense)
    start = solved_at(prob, c, c.value)
    po = PostOptimum.from_cvxpy(prob, c)
    for dc in (0.02, -0.02):
        truth = solved_at(prob, c, c.value + dc) - start
        high = po.estimate(dc).high_order
        assert abs(high - truth) < 0.2 * abs(truth)
        # min of L in x is a bound; without coupling that min is at x*
        if kind in ("SOC, columns", "SOC, rows", "ExpCone", "PowCone3D", "PSD"):
            sign = 1.0 if sense == "min" else -1.0
            assert sign * high <= sign * truth + 1e-7


def bounded(kind, c):
    x = {
        "nonneg": lambda: cp.Variable(2, nonneg=True),
        "nonpos": lambda: cp.Variable(2, nonpos=True),
        "bounds": lambda: cp.Variable(2, bounds=[0.0, np.array([np.inf, 3.0])]),
        "bounds hold c": lambda: cp.Variable(2, bounds=[c, 5.0]),
        "bounds hold c, scalar": lambda: cp.Variable(2, bounds=[-5.0, -c]),
    }[kind]()
    target = np.array([-3.0, -2.0]) if kind not in ("nonpos", "bounds hold c, scalar") else 2.0
    return x, target


@pytest.mark.parametrize("sense", ["min", "max"])
@pytest.mark.parametrize(
    "kind", ["nonneg", "nonpos", "bounds", "bounds hold c", "bounds hold c, scalar"]
)
def test_bounds_of_variables_are_constraints_too(kind, sense):
    c = cp.Parameter(value=1.0)
    x, target = bounded(kind, c)
    f = cp.sum_squares(x - target) + 0.3 * (0.0 if "hold" in kind else c) * cp.sum(x)
    prob = cp.Problem(cp.Minimize(f) if sense == "min" else cp.Maximize(-f), [x[0] <= 4.0])
    slope = resolved_slope(prob, c)
    solve(prob)
    po = PostOptimum.from_cvxpy(prob, c)
    assert po.stationarity < 1e-5
    estimate = po.estimate(0.1)
    assert estimate.first_order == pytest.approx(0.1 * slope, rel=1e-5, abs=1e-8)
    if kind.startswith("bounds hold"):
        assert estimate.largest(1)[0].name.startswith(x.name())


@pytest.mark.parametrize("key", ["PSD", "NSD"])
def test_definite_variables_are_constraints_too(key):
    c = cp.Parameter(value=1.0)
    X = cp.Variable((2, 2), **{key: True})
    sign = 1.0 if key == "PSD" else -1.0
    target = sign * np.array([[1.0, 3.0], [3.0, 1.0]])
    prob = cp.Problem(cp.Minimize(cp.sum_squares(X - target)), [sign * X[0, 0] >= 2.5 * c])
    slope = resolved_slope(prob, c)
    solve(prob)
    po = PostOptimum.from_cvxpy(prob, c)
    assert po.stationarity < 1e-5
    assert po.estimate(0.1).first_order == pytest.approx(0.1 * slope, rel=1e-4)


@pytest.mark.parametrize("attribute", ["symmetric", "diag"])
def test_gradients_respect_the_pattern_of_a_variable(attribute):
    c = cp.Parameter(value=1.0)
    X = cp.Variable((2, 2), **{attribute: True})
    target = np.array([[1.0, 2.0], [-4.0, 1.0]])
    prob = cp.Problem(cp.Minimize(cp.sum_squares(X - c * target)), [cp.trace(X) == 3.0])
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        slope = resolved_slope(prob, c)
        solve(prob)
        po = PostOptimum.from_cvxpy(prob, c)
        estimate = po.estimate(0.1)
    assert po.stationarity < 1e-6
    assert estimate.first_order == pytest.approx(0.1 * slope, rel=1e-5)


@pytest.mark.parametrize("shape", [(3,), (3, 2)])
def test_vector_and_matrix_parameters(shape):
    rng = np.random.default_rng(1)
    c = cp.Parameter(shape, value=rng.standard_normal(shape))
    x = cp.Variable(shape)
    weights = rng.standard_normal(shape)
    prob = cp.Problem(
        cp.Minimize(cp.sum_squares(x) + cp.sum(cp.multiply(weights, x))),
        [x >= c, cp.sum(x) >= 1.0],
    )
    solve(prob)
    po = PostOptimum.from_cvxpy(prob, c, names=["floor", "total"])
    direction = rng.standard_normal(shape)
    h = 1e-4
    z = [solved_at(prob, c, c.value + s * h * direction) for s in (-1.0, 1.0)]
    estimate = po.estimate(direction)
    assert estimate.first_order == pytest.approx((z[1] - z[0]) / (2.0 * h), rel=1e-5)
    assert estimate.dc.shape == shape
    name = estimate.largest(1)[0].name
    assert name.startswith("floor[") and name.count(",") == len(shape) - 1
