"""What the reports say, on problems where the right answer is known."""

import time

import cvxpy as cp
import numpy as np
import pytest
from convex_examples import TIGHT, solved_at

from pitchopt.sensitivity import PostOptimum, Thresholds


def corner(c=1.0, **options):
    """max x1 + x2 with x1 <= c, x2 <= 2, x1 + x2 <= 3.5: the last joins at c = 1.5."""
    return PostOptimum.from_functions(
        lambda x, _c: x[0] + x[1],
        lambda x, c: [x[0] - c, x[1] - 2.0, x[0] + x[1] - 3.5],
        x=[c, 2.0], c=c, multipliers=[1.0, 1.0, 0.0], sense="max",
        names=["moving", "fixed", "sum"], **options,
    )  # fmt: skip


def test_constraint_without_the_parameter_is_reached_by_the_predicted_step():
    po = corner()
    assert po.estimate(0.4).active_set.verdict == "holds"
    assert po.estimate(0.4).attained == pytest.approx(0.4)
    e = po.estimate(0.8)
    assert e.active_set.verdict == "broken"
    assert "reached by the predicted step: sum" in e.active_set.message
    assert e.active_set.measure == 1.0
    assert e.attained is None  # x* + dx is not feasible
    assert e.predicted_step == pytest.approx([0.8, 0.0])


def test_re_evaluated_constraint_becomes_active_or_violated():
    po = PostOptimum.from_functions(
        lambda x, _c: x[0], lambda x, c: [1.0 - x[0], 2.0 * c - x[0]],
        x=[1.0], c=0.0, multipliers=[1.0, 0.0],
    )  # fmt: skip
    assert po.estimate(0.4).active_set.verdict == "holds"
    assert "becoming active: g[1]" in po.estimate(0.5).active_set.message
    e = po.estimate(0.7)
    assert "violated at the old design: g[1]" in e.active_set.message
    assert "0.4 of the size of x" in e.active_set.message


def test_row_that_the_step_of_a_vertex_repairs_does_not_count():
    """c <= x <= c + 1: at c - 2 the old x is above both, the new one between them."""
    po = PostOptimum.from_functions(
        lambda x, _c: x[0], lambda x, c: [c - x[0], x[0] - c - 1.0],
        x=[1.0], c=1.0, multipliers=[1.0, 0.0],
    )  # fmt: skip
    e = po.estimate(-2.0)
    assert e.active_set.verdict == "holds"
    assert e.high_order == pytest.approx(-2.0)
    assert e.attained == pytest.approx(-2.0)


def test_active_constraint_without_a_multiplier_is_left_or_tightened():
    po = PostOptimum.from_functions(
        lambda x, _c: (x[0] - 1.0) ** 2, lambda x, c: x[0] - 1.0 - c,
        x=[1.0], c=0.0, multipliers=[0.0], names=["weak"],
    )  # fmt: skip
    assert "left: weak" in po.estimate(0.2).active_set.message
    assert "active without a multiplier and tightened: weak" in po.estimate(-0.2).active_set.message


def test_active_constraints_that_cannot_be_held_together():
    """Two multipliers for one variable: only one of the two constraints can stay active."""
    po = PostOptimum.from_functions(
        lambda x, _c: x[0], lambda x, c: [1.0 + c - x[0], 1.0 - x[0]],
        x=[1.0], c=0.0, multipliers=[0.5, 0.5], names=["moving", "fixed"],
    )  # fmt: skip
    e = po.estimate(0.2)
    assert e.active_set.verdict == "broken"
    assert "left: fixed" in e.active_set.message
    assert "not to be held together: moving" in e.active_set.message


def coupled(strength):
    return PostOptimum.from_functions(
        lambda x, c: -x[0] + x[1] ** 2 - strength * c * x[1],
        lambda x, c: x[0] - 1.0 - c,
        x=[1.0, 0.0], c=0.0, multipliers=[1.0],
    )  # fmt: skip


def test_coupling_is_zero_without_coupling_and_grows_with_it():
    assert coupled(0.0).estimate(1.0).coupling.measure == 0.0
    weak, strong = coupled(0.05).estimate(1.0), coupled(2.0).estimate(1.0)
    # grad f is (-1, 0) and what dc adds is (0, -strength)
    assert weak.coupling.measure == pytest.approx(0.05, rel=1e-6)
    assert weak.coupling.verdict == "holds"
    assert strong.coupling.measure == pytest.approx(2.0, rel=1e-6)
    assert strong.coupling.verdict == "broken"
    assert strong.active_set.verdict == "holds"


def test_coupling_in_a_constraint_counts():
    po = PostOptimum.from_functions(
        lambda x, _c: x[0], lambda x, c: 1.0 - (1.0 + c) * x[0],
        x=[1.0], c=0.0, multipliers=[1.0],
    )  # fmt: skip
    assert po.estimate(0.5).coupling.measure == pytest.approx(0.5, rel=1e-6)


def test_coupling_where_the_objective_is_flat():
    """An optimum inside: the size of the objective comes from a step, not from its gradient."""
    po = PostOptimum.from_functions(lambda x, c: (x[0] - c) ** 2, x=[1.0], c=1.0)
    e = po.estimate(0.5)
    assert e.coupling.verdict == "broken"
    assert e.high_order == pytest.approx(0.25) and e.first_order == pytest.approx(0.0, abs=1e-9)


def test_linearity_measures_the_second_order_of_the_lagrangian():
    """min b x^2 - 10 x with x <= 1 + c: L adds b dx^2, the estimate is -(10 - 2 b) dx."""
    for b, verdict in ((0.1, "holds"), (4.0, "broken")):
        po = PostOptimum.from_functions(
            lambda x, _c, b=b: b * x[0] ** 2 - 10.0 * x[0], lambda x, c: x[0] - 1.0 - c,
            x=[1.0], c=0.0, multipliers=[10.0 - 2.0 * b],
        )  # fmt: skip
        e = po.estimate(0.5)
        assert e.linearity.measure == pytest.approx(b * 0.5 / (10.0 - 2.0 * b), rel=1e-6)
        assert e.linearity.verdict == verdict


def test_thresholds_move_verdicts_and_stand_in_words():
    po = PostOptimum.from_functions(
        lambda x, c: -x[0] + x[1] ** 2 - 0.05 * c * x[1], lambda x, c: x[0] - 1.0 - c,
        x=[1.0, 0.0], c=0.0, multipliers=[1.0], thresholds=Thresholds(coupling=0.01),
    )  # fmt: skip
    e = po.estimate(1.0)
    assert e.coupling.verdict == "broken" and e.coupling.threshold == 0.01
    assert "0.05 of the size of grad_x f, above 0.01" in str(e.coupling)
    assert e.broken == (e.coupling,)


def test_multipliers_that_do_not_fit_are_flagged_if_errors_are_switched_off():
    po = PostOptimum.from_functions(
        lambda x, _c: x[0], lambda x, c: 1.0 + c - x[0], x=[1.0], c=0.0, multipliers=[0.5],
        thresholds=Thresholds(wrong=np.inf),
    )  # fmt: skip
    e = po.estimate(0.1)
    assert po.stationarity == pytest.approx(0.5, rel=1e-6)
    assert e.stationarity.verdict == "broken"
    assert "do not belong to this optimum" in e.stationarity.message


def scaled(kx, kf, kg, kc):
    """The same problem in other units."""
    kx = np.asarray(kx)

    def f(x, c):
        y = x / kx
        return kf * (y[0] ** 2 + 0.5 * y[1] ** 2 + 0.3 * y[0] * c / kc - 4.0 * y[1])

    def g(x, c):
        y = x / kx
        return [
            kg * (1.0 + (c / kc) ** 2 - y[0]),
            5.0 * kg * (y[1] - 3.0 - c / kc),
            y[0] + y[1] - 6.0,
        ]

    lam = [kf * 2.0 / kg, kf * 1.0 / (5.0 * kg), 0.0]
    return PostOptimum.from_functions(
        f, g, x=kx * np.array([1.0, 3.0]), c=0.0, multipliers=lam
    )  # fmt: skip


@pytest.mark.parametrize("units", [((1e3, 1e-4), 1e6, 1e-3, 1e2), ((1e-5, 1e5), 1e-7, 1e4, 1e-3)])
def test_reports_do_not_depend_on_units(units):
    plain, other = scaled((1.0, 1.0), 1.0, 1.0, 1.0), scaled(*units)
    assert other.stationarity < 1e-8 and plain.stationarity < 1e-8
    for dc in (0.3, 1.2):
        a, b = plain.estimate(dc), other.estimate(dc * units[3])
        assert b.high_order == pytest.approx(units[1] * a.high_order, rel=1e-9)
        assert b.first_order == pytest.approx(units[1] * a.first_order, rel=1e-7)
        for mine, same in zip(a.assumptions[:3], b.assumptions[:3], strict=True):
            assert mine.verdict == same.verdict
            assert mine.measure == pytest.approx(same.measure, rel=1e-5, abs=1e-9)
    assert a.active_set.verdict == "broken" and "g[2]" in a.active_set.message


def test_kink_of_a_convex_problem_shows_as_coupling():
    x, c = cp.Variable(), cp.Parameter(value=1.0)
    prob = cp.Problem(cp.Minimize(cp.abs(x - c)), [x <= 10.0])
    prob.solve(**TIGHT)
    assert PostOptimum.from_cvxpy(prob, c).estimate(0.5).coupling.verdict == "broken"


def test_inactive_and_active_cones():
    c = cp.Parameter(value=1.0)
    x = cp.Variable(2)
    cone = cp.SOC(c, x)
    prob = cp.Problem(cp.Minimize(x[0]), [cone, x[1] == 0.0, cp.SOC(2.0, x)])
    prob.solve(**TIGHT)
    po = PostOptimum.from_cvxpy(prob, c, names=["disc", "axis", "outer"])
    assert po.estimate(0.5).active_set.verdict == "holds"
    assert po.estimate(0.5).attained == pytest.approx(-0.5, abs=1e-6)
    assert "reached by the predicted step: outer" in po.estimate(1.5).active_set.message


def test_definite_cone_is_reached():
    c = cp.Parameter(value=1.0)
    x = cp.Variable(2)
    matrix = cp.bmat([[2.0, x[0]], [x[0], 2.0]])
    prob = cp.Problem(cp.Maximize(x[0] - x[1] ** 2), [x[0] <= c, matrix >> 0])
    prob.solve(**TIGHT)
    po = PostOptimum.from_cvxpy(prob, c, names=["limit", "definite"])
    assert po.estimate(0.9).active_set.verdict == "holds"
    assert "definite" in po.estimate(1.2).active_set.message


def test_thousands_of_rows_stay_fast():
    rng = np.random.default_rng(0)
    n, m = 60, 3000
    a = rng.standard_normal((m, n))
    x = cp.Variable(n)
    c = cp.Parameter(value=1.0)
    prob = cp.Problem(cp.Minimize(cp.sum_squares(x - 2.0)), [a @ x <= 10.0 * c])
    prob.solve(solver="CLARABEL")
    truth = solved_at(prob, c, 1.01) - solved_at(prob, c, 1.0)
    prob.solve(solver="CLARABEL")
    start = time.perf_counter()
    po = PostOptimum.from_cvxpy(prob, c, names=["rows"])
    estimates = po.estimates([0.01, -0.01, 0.02])
    seconds = time.perf_counter() - start
    assert estimates[0].first_order == pytest.approx(truth, rel=0.1)
    assert len(estimates[0].largest(5)) == 5
    assert seconds < 5.0


def test_apex_of_a_cone_that_cannot_be_held():
    """At radius zero the multiplier is not unique: the derivative is -sqrt(5), not what it says."""
    x, c = cp.Variable(3), cp.Parameter(value=0.0)
    prob = cp.Problem(cp.Minimize(x[0] + 2.0 * x[1]), [cp.SOC(c, x[:2]), x[2] == 1.0])
    prob.solve(**TIGHT)
    e = PostOptimum.from_cvxpy(prob, c, names=["disc", "axis"]).estimate(0.2)
    assert e.active_set.verdict == "broken"
    assert "not to be held together: disc" in e.active_set.message


def test_apex_of_a_cone_that_moves_as_a_whole():
    """min t + 0.3 x1 with ||x - c|| <= t: t = 0, all entries are held, and x follows c."""
    x, t, c = cp.Variable(2, name="x"), cp.Variable(), cp.Parameter(value=1.0)
    prob = cp.Problem(cp.Minimize(0.3 * x[0] + t), [cp.SOC(t, x - c), cp.sum(x) <= 9.0])
    prob.solve(**TIGHT)
    e = PostOptimum.from_cvxpy(prob, c).estimate(0.5)
    assert e.active_set.verdict == "holds" and e.linearity.verdict == "holds"
    assert sorted(e.predicted_step) == pytest.approx([0.0, 0.5, 0.5], abs=1e-6)
    assert e.high_order == pytest.approx(0.15, abs=1e-6)
    assert e.attained == pytest.approx(0.15, abs=1e-6)


def test_definite_constraint_of_rank_two_holds_a_block():
    """diag(x1 - c, x2 - c, 1) >= 0 with both pushed down: both follow c."""
    x, c = cp.Variable(2), cp.Parameter(value=1.0)
    prob = cp.Problem(
        cp.Minimize(2.0 * x[0] + x[1]), [cp.diag(cp.hstack([x - c, 1.0])) >> 0, x <= 7.0]
    )
    prob.solve(**TIGHT)
    e = PostOptimum.from_cvxpy(prob, c).estimate(0.5)
    assert e.predicted_step == pytest.approx([0.5, 0.5], abs=1e-5)
    assert e.active_set.verdict == "holds"
    assert e.high_order == pytest.approx(1.5, abs=1e-5)


def test_numbers_alone_are_the_same_and_judge_nothing():
    po = corner()
    judged, plain = po.estimate(0.8), po.estimate(0.8, judge=False)
    assert (plain.first_order, plain.high_order) == (judged.first_order, judged.high_order)
    assert plain.row_high_order.tolist() == judged.row_high_order.tolist()
    assert {a.verdict for a in plain.assumptions} == {"not judged"}
    assert plain.broken == () and plain.attained is None
    count = po.evaluations
    po.estimates([0.8, 0.4], judge=False)
    assert po.evaluations == count  # both are kept
