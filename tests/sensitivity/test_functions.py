"""Estimates from functions: closed forms, differences, counts, signs."""

import numpy as np
import pytest

from pitchopt.errors import ComputationError
from pitchopt.sensitivity import PostOptimum
from pitchopt.sensitivity.differences import settled_derivative

C = 0.3
# min (x1 - 2)^2 + (x2 - 1)^2 + c^3  s.t.  x1 + x2 <= e^c,  x1 - x2 = 1 + sin c
# at c: x1 - 2 and x2 - 1 shift together by t = (e^c - 3) / 2 off (2, 1) + (d, -d), d = sin(c) / 2


def objective(x, c):
    return (x[0] - 2.0) ** 2 + (x[1] - 1.0) ** 2 + c**3


def inequality(x, c):
    return [x[0] + x[1] - np.exp(c), x[0] - 10.0]


def equality(x, c):
    return x[0] - x[1] - 1.0 - np.sin(c)


def optimum(c):
    t, d = 0.5 * (np.exp(c) - 3.0), 0.5 * np.sin(c)
    x = np.array([2.0 + t + d, 1.0 + t - d])
    return x, 2.0 * t**2 + 2.0 * d**2 + c**3, np.array([-2.0 * t, 0.0]), np.array([-2.0 * d])


def exact_slope(c):
    t, d = 0.5 * (np.exp(c) - 3.0), 0.5 * np.sin(c)
    return 2.0 * t * np.exp(c) + 2.0 * d * np.cos(c) + 3.0 * c**2


def made(sense="min", **options):
    x, _, lam, nu = optimum(C)
    sign = 1.0 if sense == "min" else -1.0
    return PostOptimum.from_functions(
        lambda x, c: sign * objective(x, c), inequality, equality, x=x, c=C, multipliers=lam,
        equality_multipliers=nu, sense=sense, names=["sum", "far"], equality_names="difference",
        **options,
    )  # fmt: skip


@pytest.mark.parametrize("sense", ["min", "max"])
def test_both_estimates_in_closed_form(sense):
    sign = 1.0 if sense == "min" else -1.0
    po = made(sense)
    x, z, lam, nu = optimum(C)
    assert po.reference == pytest.approx(sign * z, rel=1e-14)
    assert po.stationarity < 1e-9
    for dc in (0.05, -0.2, 0.4):
        e = po.estimate(dc)
        assert e.first_order == pytest.approx(sign * exact_slope(C) * dc, rel=1e-8)
        assert abs(e.first_order - sign * exact_slope(C) * dc) <= e.first_order_error
        high = (C + dc) ** 3 - C**3 - lam[0] * (np.exp(C + dc) - np.exp(C))
        high -= nu[0] * (np.sin(C + dc) - np.sin(C))
        assert e.high_order == pytest.approx(sign * high, rel=1e-12)
        # linear constraints: the predicted design is feasible, and here it is the optimum
        assert e.attained == pytest.approx(sign * (optimum(C + dc)[1] - z), rel=1e-6)
        assert x + e.predicted_step == pytest.approx(optimum(C + dc)[0], rel=1e-7)


def test_contributions_are_named_sorted_and_add_up():
    e = made().estimate(0.2)
    rows = e.largest()
    assert [k.name for k in rows] == ["sum", "difference[0]"]
    _, _, lam, nu = optimum(C)
    assert [k.multiplier for k in rows] == pytest.approx([lam[0], nu[0]])
    parts = [e.objective, *rows]
    assert sum(k.high_order for k in parts) == pytest.approx(e.high_order, rel=1e-13)
    assert sum(abs(k.share) for k in parts) == pytest.approx(1.0, rel=1e-13)
    sizes = [abs(k.high_order) for k in rows]
    assert sizes == sorted(sizes, reverse=True)
    assert [k.name for k in e.constraints] == ["g", "difference"]
    assert len(e.largest(1)) == 1


def test_given_gradients_are_exact_and_cost_nothing_in_c():
    x, _, lam, nu = optimum(C)
    po = PostOptimum.from_functions(
        objective, inequality, equality, x=x, c=C, multipliers=lam, equality_multipliers=nu,
        c_gradients=lambda _x, c: (3.0 * c**2, [-np.exp(c), 0.0], -np.cos(c)),
        x_gradients=lambda x, _c: (
            [2.0 * (x[0] - 2.0), 2.0 * (x[1] - 1.0)], [[1.0, 1.0], [1.0, 0.0]], [[1.0, -1.0]],
        ),
    )  # fmt: skip
    e = po.estimate(0.1)
    assert e.first_order == pytest.approx(exact_slope(C) * 0.1, rel=1e-13)
    assert e.first_order_error == 0.0 and e.step is None
    assert po.evaluations.frozen == 2  # c_r and c_r + dc
    # the probe of the objective's size, and the predicted design at both parameters
    assert po.evaluations.moved == 3
    by_differences = made().estimate(0.1)
    for mine, other in zip(e.assumptions, by_differences.assumptions, strict=True):
        assert mine.verdict == other.verdict
    assert e.linearity.measure == pytest.approx(by_differences.linearity.measure, rel=1e-6)


def test_prescribed_step_is_one_more_evaluation_or_none():
    called = []

    def counted(x, c):
        called.append((tuple(x), c))
        return objective(x, c)

    x, _, lam, nu = optimum(C)
    po = PostOptimum.from_functions(
        counted, inequality, equality, x=x, c=C, multipliers=lam, equality_multipliers=nu,
        step=0.03, x_gradients="none",
    )  # fmt: skip
    first = po.estimates([0.03, 0.1, 0.2])
    assert len(called) == len(set(called)) == 4  # c_r, and the three
    again = po.estimates([0.2, 0.03])
    assert len(called) == 4
    assert again[0].first_order == first[2].first_order
    at_step = first[0]
    assert at_step.first_order == pytest.approx(at_step.high_order, rel=1e-12)
    assert at_step.first_order_error is None and at_step.step == 0.03
    po.estimate(0.15)
    assert len(called) == 5
    po.estimate(-0.03)  # another direction: c_r - step, which is this dc
    assert len(called) == 6


def test_without_gradients_in_x_nothing_is_called_fine():
    e = made(x_gradients="none").estimate(0.1)
    for assumption in e.assumptions:
        assert assumption.verdict == "not judged"
        assert assumption.measure is None
    assert e.attained is None and e.predicted_step is None
    assert e.high_order == pytest.approx(made().estimate(0.1).high_order, rel=1e-14)


def test_derivative_is_taken_where_dc_is_smallest_and_used_for_all():
    po = made(x_gradients="none")
    small, large = po.estimates([1.0, 1e-3])[::-1]
    assert small.first_order / 1e-3 == pytest.approx(large.first_order, rel=1e-12)
    before = po.evaluations.frozen
    po.estimate(0.5)
    assert po.evaluations.frozen == before + 1


def test_vector_parameter_along_its_direction():
    x = np.array([1.0])
    po = PostOptimum.from_functions(
        lambda x, _c: x[0], lambda x, c: c[0] * c[1] - x[0], x=x, c=[0.5, 2.0], multipliers=[1.0]
    )
    e = po.estimate([0.1, -0.3])
    assert e.first_order == pytest.approx(0.1 * 2.0 - 0.3 * 0.5, rel=1e-9)
    assert e.high_order == pytest.approx(0.6 * 1.7 - 1.0, rel=1e-12)
    assert e.broken == ()


def test_zero_change_is_zero():
    e = made().estimate(0.0)
    assert (e.first_order, e.high_order, e.attained) == (0.0, 0.0, 0.0)
    assert e.broken == ()


def test_one_sided_where_the_other_side_does_not_exist():
    po = PostOptimum.from_functions(
        lambda x, _c: x[0], lambda x, c: np.sqrt(1.0 + c) - x[0] if c >= 0.0 else np.nan,
        x=[1.0], c=0.0, multipliers=[1.0],
    )  # fmt: skip
    assert po.estimate(0.1).first_order == pytest.approx(0.05, rel=1e-9)


def test_kink_counts_from_the_side_of_dc():
    po = PostOptimum.from_functions(
        lambda x, _c: x[0], lambda x, c: 2.0 + max(c, -3.0 * c) - x[0],
        x=[2.0], c=0.0, multipliers=[1.0],
    )  # fmt: skip
    assert po.estimate(0.1).first_order == pytest.approx(0.1)
    assert po.estimate(-0.1).first_order == pytest.approx(0.3)


def test_noise_that_swamps_the_derivative_is_an_error():
    rng = np.random.default_rng(0)
    with pytest.raises(ComputationError, match=r"dc = 1\.0: differences do not settle.*give grad"):
        settled_derivative(
            lambda t: np.array([1.0 + t + rng.standard_normal()]), np.ones(1), name="dc = 1.0"
        )


def test_error_of_a_noisy_derivative_is_said():
    rng = np.random.default_rng(0)
    found = settled_derivative(
        lambda t: np.array([1.0 + t + 1e-5 * rng.standard_normal()]), np.ones(1), name="t"
    )
    assert 1e-5 < found.error < 1e-2
    assert abs(found.value[0] - 1.0) < 10.0 * found.error


@pytest.mark.parametrize("function", [np.exp, np.sin, lambda t: 1e-8 * t + 5.0, np.cos])
def test_derivative_of_smooth_functions_and_its_error(function):
    found = settled_derivative(lambda t: np.array([function(t)]), np.ones(1), name="t")
    exact = {np.exp: 1.0, np.sin: 1.0, np.cos: 0.0}.get(function, 1e-8)
    assert abs(found.value[0] - exact) <= found.error <= 1e-6
