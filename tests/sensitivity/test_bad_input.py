"""Bad input is one clear error each."""

import cvxpy as cp
import numpy as np
import pytest
from convex_examples import TIGHT

from pitchopt.errors import ComputationError, InputError
from pitchopt.sensitivity import PostOptimum, Thresholds


def small(status=None):
    x, c = cp.Variable(2, name="x"), cp.Parameter(name="c", value=1.0)
    constraints = [x >= c, cp.sum(x) <= 5.0]
    if status == "infeasible":
        constraints.append(x[0] <= 0.0)
    objective = cp.Minimize(-x[0] if status == "unbounded" else cp.sum_squares(x))
    if status == "unbounded":
        constraints = [x >= c]
    prob = cp.Problem(objective, constraints)
    if status != "fresh":
        prob.solve(**TIGHT)
    return prob, c


def mip():
    x, c = cp.Variable(integer=True), cp.Parameter(value=1.2)
    return cp.Problem(cp.Minimize(x), [x >= c]), c


def quasiconvex():
    x, c = cp.Variable(), cp.Parameter(value=1.0)
    return cp.Problem(cp.Minimize(cp.ceil(x)), [x >= c]), c


def without_duals():
    prob, c = small()
    prob.constraints[1].dual_variables[0].save_value(None)
    return prob, c


def stale():
    prob, c = small()
    x = prob.variables()[0]
    prob = cp.Problem(cp.Minimize(cp.sum_squares(x) + c), [x >= c])
    prob.solve(**TIGHT)
    c.value = 1.5
    return prob, c


def stale_in_constraint():
    prob, c = small()
    c.value = 1.5
    return prob, c


def inaccurate():
    prob, c = small()
    prob._status = "optimal_inaccurate"
    return prob, c


def unset():
    prob, c = small()
    c.save_value(None)
    return prob, c


def complex_variable():
    x, c = cp.Variable(complex=True), cp.Parameter(value=1.0)
    prob = cp.Problem(cp.Minimize(cp.abs(x)), [cp.real(x) >= c])
    prob.solve(solver="CLARABEL")
    return prob, c


def callback():
    prob = small()[0]
    return prob, cp.CallbackParam(callback=lambda: 1.0)


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: small("fresh"), r"problem: is not solved; call problem\.solve\(\) first"),
        (lambda: small("infeasible"), "problem: its status is infeasible, expected optimal"),
        (lambda: small("unbounded"), "problem: its status is unbounded, expected optimal"),
        (inaccurate, "problem: its status is optimal_inaccurate, .*tighten or change the solver"),
        (mip, "problem: has integer or boolean variables, whose solutions have no duals"),
        (quasiconvex, r"problem: is not convex by the rules of cvxpy \(not DCP\)"),
        (without_duals, "problem: constraint .* has no dual value; solve with a solver that gives"),
        (stale, "problem: its value was .* when it was solved and is .* now; .*solve it again"),
        (stale_in_constraint, "x: violates constraint .* at the reference"),
        (unset, "problem: c has no value; set the parameters"),
        (complex_variable, "problem: variable .* is complex"),
        (callback, "parameter: got a CallbackParam"),
        (lambda: (small()[0], cp.Parameter(name="d")), "parameter: d is not in the problem, .*: c"),
        (lambda: (small()[0], 3.0), r"parameter: got float, expected a cvxpy\.Parameter"),
        (lambda: (3.0, small()[1]), r"problem: got float, expected a cvxpy\.Problem"),
    ],
    ids=lambda v: getattr(v, "__name__", None),
)  # fmt: skip
def test_problems_that_say_nothing(make, message):
    with pytest.raises(InputError, match=message) as caught:
        PostOptimum.from_cvxpy(*make())
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("kind", ["approximate", "unknown"])
def test_constraints_without_duals(kind):
    x, c = cp.Variable(2), cp.Parameter(value=1.0)
    cone = cp.RelEntrConeQuad(x[0], x[1], 5.0 * c, 2, 2)
    prob = cp.Problem(cp.Minimize(cp.sum_squares(x - 1.0)), [cone])
    prob.solve(solver="CLARABEL")
    with pytest.raises(InputError, match="of type RelEntrConeQuad, which has no duals"):
        PostOptimum.from_cvxpy(prob, c)


@pytest.mark.parametrize(
    ("names", "message"),
    [
        (["one"], "names: got 1, expected 2, one for each constraint"),
        ("ab", "names: got 1, expected 2"),
        ({12345678: "x"}, "names: got 1 constraints that the problem does not have"),
    ],
)
def test_names_of_constraints(names, message):
    with pytest.raises(InputError, match=message):
        PostOptimum.from_cvxpy(*small(), names=names)


def test_names_from_a_mapping_and_from_cvxpy():
    prob, c = small()
    names = {prob.constraints[0]: "floor"}
    found = PostOptimum.from_cvxpy(prob, c, names=names).estimate(0.1)
    assert [k.name for k in found.largest()] == ["floor[0]", "floor[1]"]
    assert found.constraints[1].name == str(prob.constraints[1])


@pytest.mark.parametrize(
    ("dc", "message"),
    [
        ([1.0, 2.0], r"dc: got shape \(2,\), expected \(\)"),
        (np.nan, "dc: got nan, expected finite numbers"),
        ("wide", "dc: got 'wide', expected a number"),
        (2.0, r"dc: with 2\.0 no design meets all constraints; in the way: "),
    ],
)
def test_changes_that_cannot_be_made(dc, message):
    with pytest.raises(InputError, match=message):
        PostOptimum.from_cvxpy(*small()).estimate(dc)


def test_infeasible_change_names_what_is_in_the_way_and_can_be_let_through():
    prob, c = small()
    po = PostOptimum.from_cvxpy(prob, c, names=["floor", "sum"])
    with pytest.raises(InputError, match=r"in the way: (floor|sum)"):
        po.estimate(2.0)
    e = po.estimate(2.0, check_feasible=False)
    assert e.attained is None
    assert e.high_order == pytest.approx(8.0, rel=1e-6)
    # up to the last feasible parameter it is fine
    assert po.estimate(1.5).active_set.verdict == "broken"


@pytest.mark.parametrize("kind", ["SOC", "PSD", "equal", "exp", "power", "bounds"])
def test_infeasible_cones(kind):
    c = cp.Parameter(value=1.0)
    x = cp.Variable(2, name="x", bounds=[None, 2.0]) if kind == "bounds" else cp.Variable(2)
    other = {
        "SOC": lambda: [cp.SOC(2.0, x)],
        "PSD": lambda: [2.0 * np.eye(2) - cp.diag(x) >> 0],
        "equal": lambda: [cp.sum(x) == 2.5],
        "exp": lambda: [cp.ExpCone(x[0], 1.0, 10.0)],
        "power": lambda: [cp.PowCone3D(3.0, 3.0, x[0], 0.5)],
        "bounds": list,
    }[kind]()
    prob = cp.Problem(cp.Minimize(cp.sum_squares(x)), [x >= c, *other])
    prob.solve(solver="CLARABEL")
    po = PostOptimum.from_cvxpy(prob, c)
    po.estimate(0.1)
    with pytest.raises(InputError, match="no design meets all constraints; in the way"):
        po.estimate(4.0)


@pytest.mark.filterwarnings("ignore:You are solving a parameterized")
def test_domain_of_functions_and_attributes_of_the_parameter():
    x = cp.Variable()
    c = cp.Parameter(name="c", value=1.0)
    prob = cp.Problem(cp.Minimize(x**2 - cp.log(c)), [x >= cp.sqrt(c)])
    prob.solve(**TIGHT)
    po = PostOptimum.from_cvxpy(prob, c)
    with pytest.raises(InputError, match=r"dc: with -2\.0 the objective leaves the domain"):
        po.estimate(-2.0)
    c = cp.Parameter(name="c", value=1.0, nonneg=True)
    prob = cp.Problem(cp.Minimize(x**2), [x >= c])
    prob.solve(**TIGHT)
    with pytest.raises(InputError, match="dc: with -2 the parameter c would break its own attrib"):
        PostOptimum.from_cvxpy(prob, c).estimate(-2.0)


def made(**options):
    settings = {
        "f": lambda x, _c: x[0], "g": lambda x, c: [1.0 + c - x[0], x[0] - 3.0],
        "x": [1.0], "c": 0.0, "multipliers": [1.0, 0.0],
    } | options  # fmt: skip
    return PostOptimum.from_functions(**settings)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"multipliers": [-1.0, 0.0]}, "multipliers: number 0 is -1, expected none below zero"),
        ({"multipliers": [0.2, 0.0]}, r"multipliers: grad_x L is 0\.8 of the size of grad_x f"),
        ({"multipliers": [1.0, 0.7]}, r"multipliers: constraint g\[1\] has one and is not active"),
        ({"multipliers": None}, "g: expected the function and its multipliers, or neither"),
        ({"multipliers": [1.0]}, "g and h: returned 2 numbers, expected 1"),
        ({"x": [0.5]}, r"x: violates constraint g\[0\] at the reference by 1"),
        ({"x": [[1.0]]}, "x: got shape"),
        ({"c": np.inf}, "c: got inf, expected finite numbers"),
        ({"sense": "least"}, "sense: got 'least', expected min or max"),
        ({"f": 3.0}, "f: got float, expected a callable"),
        ({"f": lambda _x, _c: [1.0, 2.0]}, "f: returned 2 numbers, expected one"),
        ({"f": lambda _x, _c: "one"}, "f: returned str, expected numbers"),
        ({"x_gradients": "exact"}, "x_gradients: got 'exact', expected differences"),
        (
            {"x_gradients": lambda _x, _c: ([1.0],)},
            "x_gradients: expected gradients of f, g",
        ),
        ({"step": -0.1}, "step: got -0.1, expected a finite number above"),
        ({"x_scale": [0.0]}, "x_scale: expected positive sizes"),
        ({"names": ["a"]}, "names of g: got 1, expected 2"),
    ],
)
def test_functions_that_do_not_fit(options, message):
    with pytest.raises(InputError, match=message):
        made(**options)


def test_gradients_in_c_that_do_not_fit():
    with pytest.raises(InputError, match="c_gradients: got 1 and 1 rows, expected 1 for f and 2"):
        made(c_gradients=lambda _x, _c: (0.0, [1.0])).estimate(0.1)


def test_infeasible_to_first_order():
    with pytest.raises(InputError, match=r"dc: with 2\.5 no design .* to first order; in the way:"):
        made().estimate(2.5)
    assert made().estimate(2.5, check_feasible=False).high_order == pytest.approx(2.5)
    # without gradients in x it is not judged
    assert made(x_gradients="none").estimate(2.5).high_order == pytest.approx(2.5)


def test_equalities_that_cannot_be_met_to_first_order():
    po = PostOptimum.from_functions(
        lambda x, _c: x[0], lambda x, _c: -x[0], lambda x, c: x[0] - 1.0 + c,
        x=[1.0], c=0.0, multipliers=[0.0], equality_multipliers=[-1.0],
    )  # fmt: skip
    assert po.estimate(0.5).high_order == pytest.approx(-0.5)
    with pytest.raises(InputError, match="to first order; in the way"):
        po.estimate(2.0)


def test_functions_outside_their_domain():
    po = made(g=lambda x, c: [1.0 + (np.log(c + 1.0) if c > -1.0 else np.nan) - x[0], x[0] - 3.0])
    with pytest.raises(InputError, match=r"dc: with -2\.0 g returned NaN or infinite values"):
        po.estimate(-2.0)


def test_rough_functions_in_x():
    rng = np.random.default_rng(0)
    with pytest.raises(ComputationError, match="gradients in x: differences of two steps disagree"):
        made(f=lambda x, _c: x[0] + 0.1 * rng.standard_normal())


@pytest.mark.parametrize("name", ["active", "coupling", "wrong"])
def test_thresholds_are_checked(name):
    with pytest.raises(InputError, match=name):
        Thresholds(**{name: -1.0})


def test_gradients_that_leave_the_domain_say_so():
    with pytest.raises(InputError, match=r"f returned NaN or infinite values at an x near x\*"):
        PostOptimum.from_functions(
            lambda x, _c: x[0] if x[0] >= 1.0 else np.nan, lambda x, c: 1.0 + c - x[0],
            x=[1.0], c=0.0, multipliers=[1.0],
        )  # fmt: skip


@pytest.mark.filterwarnings("ignore:You are solving a parameterized problem.*:UserWarning:cvxpy")
def test_infeasible_problem_that_is_not_dpp_warns_of_nothing(recwarn):
    x, c = cp.Variable(), cp.Parameter(value=1.0, nonneg=True)
    prob = cp.Problem(cp.Minimize(x**2), [x >= c * c, x <= 2.0])
    prob.solve(**TIGHT)
    recwarn.clear()
    with pytest.raises(InputError, match="no design meets"):
        PostOptimum.from_cvxpy(prob, c).estimate(2.0)
    assert not recwarn.list
