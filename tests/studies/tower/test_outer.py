"""Outer search: known minima, bounds, evaluations, bad input."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import minimize

from pitchopt.errors import InputError
from pitchopt.studies.tower.outer import minimise_in_box

LOW, HIGH, STEPS = [0.9, 0.0], [1.2, 1.0], [0.05, 0.5]
HALF = 0.5 * (np.array(HIGH) - np.array(LOW))


def counted(function):
    seen = []

    def call(x):
        seen.append(np.array(x))
        return function(x)

    return call, seen


@settings(deadline=None, max_examples=25)
@given(st.floats(0.9, 1.2), st.floats(0.1, 50.0), st.floats(0.5, 2.0))
def test_parabola_is_found_in_few_evaluations(at, curvature, start):
    first = 0.9 + 0.3 * (start - 0.5) / 1.5
    call, seen = counted(lambda x: 40.0 + curvature * (x[0] - at) ** 2)
    found = minimise_in_box(call, [first], [0.9], [1.2], first_steps=[0.05])
    # the grid of the model has 201 points a region, which is the whole box at first
    assert found.value - 40.0 <= curvature * 0.0016**2 + 4e-4
    assert found.converged
    assert len(seen) == len(found.values) <= 7
    np.testing.assert_array_equal(found.points, seen)


@settings(deadline=None, max_examples=25)
@given(
    st.tuples(st.floats(-1.5, 1.5), st.floats(-1.5, 1.5)),
    st.tuples(st.floats(0.3, 3.0), st.floats(0.3, 3.0), st.floats(-0.8, 0.8)),
    st.tuples(st.floats(0.0, 1.0), st.floats(0.0, 1.0)),
)
def test_convex_quadratics_in_two_variables(centre, shape, share):
    p, q, r = shape
    matrix = np.array([[p, r * np.sqrt(p * q)], [r * np.sqrt(p * q), q]])
    middle = 0.5 * (np.array(LOW) + np.array(HIGH))

    def function(x):
        u = (np.asarray(x) - middle) / HALF - np.array(centre)
        return float(40.0 + u @ matrix @ u)

    start = np.array(LOW) + np.array(share) * 2.0 * HALF
    call, seen = counted(function)
    found = minimise_in_box(call, start, LOW, HIGH, first_steps=STEPS)
    truth = minimize(function, middle, bounds=list(zip(LOW, HIGH, strict=True)), tol=1e-12)
    assert found.value >= truth.fun - 1e-9
    assert found.value - truth.fun < 2.5e-3  # against 1 to 20 between the ends of the box
    assert len(seen) <= 20
    assert all(np.all(x >= LOW) and np.all(x <= HIGH) for x in seen)
    np.testing.assert_array_equal(found.points, seen)
    assert found.value == found.values.min() == function(found.x)


@pytest.mark.parametrize("variables", [1, 2])
def test_functions_that_are_no_parabolas(variables):
    """A cost over height and root of the weight, with diminishing returns."""

    def function(x):
        height = x[0]
        root = x[1] if variables == 2 else 0.0
        c = 0.3 * root**2
        mass = 300.0 * height**1.7 * (1.0 - 0.08 * c / (c + 0.05) + 0.06 * (c / 0.3) ** 2)
        return 25.0 * (1.0 + mass / 1500.0) / height**0.35

    start = [1.0, 0.0][:variables]
    box = (LOW[:variables], HIGH[:variables])
    found = minimise_in_box(function, start, *box, first_steps=STEPS[:variables])
    truth = minimize(
        function, [1.0, 0.5][:variables], bounds=list(zip(*box, strict=True)), tol=1e-12
    )
    assert found.converged
    assert found.value - truth.fun < 1e-4 * truth.fun
    np.testing.assert_allclose(found.x, truth.x, atol=0.06 if variables == 2 else 0.005)


def test_minimum_on_the_bound_is_met_exactly():
    found = minimise_in_box(
        lambda x: 10.0 + 3.0 * x[0] - 2.0 * x[1], [1.0, 0.0], LOW, HIGH, first_steps=STEPS
    )
    np.testing.assert_array_equal(found.x, [0.9, 1.0])
    assert found.converged


@pytest.mark.parametrize(("curvature", "rise"), [(57.0, 0.5), (60.0, 1.0), (70.0, 0.9)])
def test_points_on_a_diagonal_do_not_end_the_search_in_a_corner(curvature, rise):
    """All points go to the far corner, where the second variable has passed its minimum."""

    def function(x):
        share = float(x[1]) ** 2
        gain = 0.3 * (1.0 - np.exp(-6.0 * share))
        cross = rise * (float(x[0]) - 0.9) / 0.3
        return float(47.0 + curvature * (x[0] - 1.25) ** 2 - gain + 0.3 * cross * share)

    found = minimise_in_box(function, [1.0, 0.0], LOW, HIGH, first_steps=STEPS)
    heights, roots = np.linspace(0.9, 1.2, 101), np.linspace(0.0, 1.0, 201)
    grid = min(function([h, w]) for h in heights for w in roots)
    assert found.converged
    assert found.value - grid < 0.05 * (function([1.2, 1.0]) - grid)
    away = np.abs(found.points - found.x) / HALF
    for i in range(2):  # each variable was moved alone
        alone = (away[:, i] > 0.049) & (away[:, i] < 0.4) & (away[:, 1 - i] < 0.051)
        assert alone.any()


@pytest.mark.parametrize("start", [0.9, 1.2, 1.0])
def test_first_points_stay_inside_and_apart(start):
    call, seen = counted(lambda x: (x[0] - 1.05) ** 2 + 1.0)
    minimise_in_box(call, [start], [0.9], [1.2], first_steps=[0.05], evaluations=4)
    first = np.sort(np.array(seen[:3]).ravel())
    assert first[0] >= 0.9 and first[-1] <= 1.2
    assert np.diff(first).min() >= 0.0249


@pytest.mark.parametrize("start", [0.99, 0.997, 1.0, 1.01])
def test_narrow_box_has_three_different_points(start):
    call, seen = counted(lambda x: (x[0] - 0.996) ** 2 + 1.0)
    found = minimise_in_box(call, [start], [0.99], [1.01], first_steps=[0.05], tolerance=1e-9)
    first = np.sort(np.array(seen[:3]).ravel())
    assert np.diff(first).min() > 0.003
    assert found.x[0] == pytest.approx(0.996, abs=2e-4)


def test_search_ends_at_the_largest_number_of_evaluations():
    rng = np.random.default_rng(1)
    call, seen = counted(lambda _: 1.0 + 0.1 * float(rng.random()))
    found = minimise_in_box(call, [1.0, 0.0], LOW, HIGH, first_steps=STEPS, evaluations=8)
    assert len(seen) <= 8
    assert found.value == found.values.min()
    call, seen = counted(lambda x: float(np.cos(40.0 * x[0])) + 2.0)
    found = minimise_in_box(call, [1.0], [0.9], [1.2], first_steps=[0.05], evaluations=4)
    assert len(seen) == 4
    assert not found.converged


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"start": [1.0, 0.0, 0.0], "low": [0.9] * 3, "high": [1.2] * 3, "first_steps": [0.1] * 3},
         "got 3 variables"),
        ({"start": [0.8, 0.0]}, "expected it between"),
        ({"start": [1.0, 1.5]}, "expected it between"),
        ({"low": [1.2, 0.0]}, "expected it between"),
        ({"start": [np.nan, 0.0]}, "start"),
        ({"high": [1.2]}, "high"),
        ({"first_steps": [0.05]}, "first_steps"),
        ({"first_steps": [0.05, 0.0]}, "first_steps: got"),
        ({"first_steps": [-0.05, 0.5]}, "first_steps: got"),
        ({"tolerance": 0.0}, "tolerance"),
        ({"evaluations": 5}, "evaluations"),
    ],
)  # fmt: skip
def test_bad_input(change, words):
    given_ = {"start": [1.0, 0.0], "low": LOW, "high": HIGH, "first_steps": STEPS, **change}
    with pytest.raises(InputError, match=words):
        minimise_in_box(lambda _: pytest.fail("asked"), **given_)
