"""Random problems: where the estimates are exact, on which side they lie, what reports miss."""

import cvxpy as cp
import numpy as np
import pytest
from convex_examples import TIGHT, solved_at
from hypothesis import HealthCheck, assume, given, settings
from hypothesis import strategies as st

from pitchopt.errors import InputError
from pitchopt.sensitivity import PostOptimum

QUICK = settings(
    max_examples=40, deadline=None, derandomize=True,
    suppress_health_check=[HealthCheck.filter_too_much, HealthCheck.too_slow],
)  # fmt: skip


def random_lp(seed, sense):
    """LP with a right-hand side quadratic in c; c of order one."""
    rng = np.random.default_rng(seed)
    n, m = int(rng.integers(2, 5)), int(rng.integers(5, 9))
    a = rng.standard_normal((m, n))
    inside = rng.standard_normal(n)
    b = a @ inside + rng.uniform(0.5, 2.0, m)
    q = -a[:n].T @ rng.uniform(0.2, 1.0, n)  # bounded: -q is in the cone of the rows
    d, e = 0.3 * rng.standard_normal((2, m))
    x, c = cp.Variable(n), cp.Parameter(value=0.0)
    square = cp.CallbackParam(callback=lambda: c.value**2)
    objective = cp.Minimize(q @ x + 0.5 * c) if sense == "min" else cp.Maximize(-q @ x - 0.5 * c)
    return cp.Problem(objective, [a @ x <= b + d * c + e * square]), c


@QUICK
@given(seed=st.integers(0, 10**6), dc=st.floats(-1.0, 1.0), sense=st.sampled_from(["min", "max"]))
def test_high_order_of_an_lp_is_exact_if_the_active_set_is_said_to_hold(seed, dc, sense):
    assume(abs(dc) > 1e-3)
    prob, c = random_lp(seed, sense)
    prob.solve(**TIGHT)
    assume(prob.status == "optimal")
    start = prob.value
    po = PostOptimum.from_cvxpy(prob, c)
    try:
        e = po.estimate(dc)
    except InputError:  # no design left: then the solver finds none either
        solved_at(prob, c, dc)
        assert prob.status == "infeasible"
        return
    truth = solved_at(prob, c, dc) - start
    size = 1.0 + abs(start)
    assert e.coupling.measure == 0.0
    assert e.linearity.verdict == "holds"
    if e.active_set.verdict == "holds":
        assert abs(e.high_order - truth) < 1e-6 * size
        assert abs(e.attained - truth) < 1e-6 * size
    # weak duality: L at a dual feasible point bounds the optimum
    sign = 1.0 if sense == "min" else -1.0
    assert sign * e.high_order <= sign * truth + 1e-6 * size


def random_convex(seed):
    """Jointly convex in (x, c): a quadratic in both, linear, norm and cone constraints."""
    rng = np.random.default_rng(seed)
    n = 3
    x, c = cp.Variable(n), cp.Parameter(value=0.0)
    w = rng.standard_normal((n + 2, n))
    u = rng.standard_normal(n + 2)
    a, d = rng.standard_normal((4, n)), rng.standard_normal(4)
    b = rng.uniform(0.3, 1.0, 4)
    f = cp.sum_squares(w @ x - 3.0 * rng.standard_normal(n + 2) + c * u)
    constraints = [
        a @ x + 0.2 * c * d <= b,
        cp.norm(x + 0.1 * c * d[:n]) <= 1.5,
        cp.SOC(1.2 + 0.2 * c, x[:2] - 0.1),
    ]
    return cp.Problem(cp.Minimize(f), constraints), c


@pytest.mark.slow
@QUICK
@given(seed=st.integers(0, 10**6))
def test_first_order_has_the_resolved_slope_and_bounds_convex_problems_from_below(seed):
    prob, c = random_convex(seed)
    start = prob.solve(**TIGHT)
    assume(prob.status == "optimal")
    po = PostOptimum.from_cvxpy(prob, c)
    assert po.stationarity < 1e-4
    size = 1.0 + abs(start)
    h = 1e-3
    first = po.estimate(h).first_order
    truth = 0.5 * (solved_at(prob, c, h) - solved_at(prob, c, -h))
    # an active set that changes within h bends the optimum; its slope differs by order h
    assert abs(first - truth) < 1e-4 * size
    for dc in (-0.8, -0.2, 0.2, 0.8):
        e = po.estimate(dc, check_feasible=False)
        z = solved_at(prob, c, dc)
        assume(prob.status == "optimal")
        assert e.first_order <= z - start + 1e-6 * size
        if e.attained is not None:
            assert z - start <= e.attained + 1e-6 * size
