"""The quadratic programs against optima in closed form, and what the reports say of them.

With y'Py = p (x1^2 + x2^2) - 2 b c x2, q = (q1, q2), G = (1, 0): x2 = (2 b c - q2) / (2 p) is free,
and x1 = min(-q1 / (2 p), g(c), h0) as f falls in x1 up to -q1 / (2 p).
"""

import numpy as np
import pytest

from pitchopt.errors import InputError
from pitchopt.studies.sensitivity import (
    QuadraticProgram,
    active_set_program,
    coupling_programs,
    estimated_curve,
    linearity_programs,
)

DC = np.round(np.linspace(0.0, 1.0, 21), 12)


def optimum(program, c):
    """Design and value of the closed form."""
    p, coupling = program.P[0, 0], -program.P[1, 2]
    x2 = (2.0 * coupling * c - program.q[1]) / (2.0 * p)
    x1 = min(-program.q[0] / (2.0 * p), program.limit(c))
    if program.H is not None:
        x1 = min(x1, program.h0)
    return np.array([x1, x2]), float(program.objective(x1, x2, c))


def multiplier(program):
    """Of the first constraint at c = 0, where it is active; otherwise zero."""
    (x1, _), _ = optimum(program, 0.0)
    return max(-(2.0 * program.P[0, 0] * x1 + program.q[0]), 0.0) if x1 == program.limit(0) else 0.0


PROGRAMS = {
    "C2 b=20": linearity_programs()[0],
    "C2 b=5": linearity_programs()[1],
    "C2 b=0.1": linearity_programs()[2],
    "C3 b=10": coupling_programs()[0],
    "C3 b=5": coupling_programs()[1],
    "C3 b=0.1": coupling_programs()[2],
    "C4": active_set_program(),
}


@pytest.fixture(scope="module")
def curves():
    return {key: estimated_curve(program, DC) for key, program in PROGRAMS.items()}


@pytest.mark.parametrize("key", PROGRAMS)
def test_resolved_optimum_is_the_closed_form(curves, key):
    curve, program = curves[key], PROGRAMS[key]
    start = optimum(program, 0.0)[1]
    exact = np.array([optimum(program, c)[1] - start for c in DC])
    np.testing.assert_allclose(curve.truth, exact, atol=1e-6 * max(1.0, np.abs(exact).max()))
    designs = np.array([optimum(program, c)[0] for c in DC])
    # b = 5 is active without a multiplier at c = 0, where a solver is less accurate
    np.testing.assert_allclose(curve.designs, designs, atol=1e-3)


@pytest.mark.parametrize("key", PROGRAMS)
def test_estimates_are_the_closed_form(curves, key):
    curve, program = curves[key], PROGRAMS[key]
    lam = multiplier(program)
    g2, g1, _ = program.g
    (_, x2), _ = optimum(program, 0.0)
    f = 2.0 * program.P[1, 2] * x2  # of the objective, per c
    tolerance = 1e-6 if key != "C2 b=5" else 1e-3
    np.testing.assert_allclose(curve.first_order, (f - lam * g1) * DC, atol=tolerance)
    np.testing.assert_allclose(
        curve.high_order, f * DC - lam * (g2 * DC**2 + g1 * DC), atol=tolerance
    )


def test_multipliers_as_printed_and_with_one_half():
    printed = [multiplier(p) for p in linearity_programs()]
    assert printed == pytest.approx([0.0, 0.0, 9.8])
    halved = [multiplier(p.halved()) for p in linearity_programs()]
    assert halved == pytest.approx([0.0, 5.0, 9.9])


def test_errors_at_one():
    """Figures of the report: true change, first and high order at dc = 1."""
    rows = {
        "C2 b=0.1": (9.9, -29.4, 9.8),
        "C3 b=10": (-1009.7, -58.8, -9.8),
        "C3 b=5": (-259.7, -58.8, -9.8),
        "C3 b=0.1": (-9.8, -58.8, -9.8),
        "C4": (-4.7, -28.8, -4.8),
    }
    for key, expected in rows.items():
        curve = estimated_curve(PROGRAMS[key], [1.0])
        found = (curve.truth[0], curve.first_order[0], curve.high_order[0])
        assert found == pytest.approx(expected, abs=1e-5)


def verdicts(curve, name):
    return np.array([getattr(e, name).verdict == "broken" for e in curve.estimates])


def test_report_where_the_objective_curves(curves):
    # inactive: violated where g(c) < 1/4, beyond c = (3 + sqrt 21) / 8 = 0.948
    np.testing.assert_array_equal(verdicts(curves["C2 b=20"], "active_set"), DC > 0.948)
    weak = curves["C2 b=5"]
    assert verdicts(weak, "active_set")[1:].sum() == DC.size - 2  # g(0.75) = g(0): none changes
    messages = [e.active_set.message for e in weak.estimates]
    assert all("left" in messages[i] for i in np.flatnonzero((DC > 0.0) & (DC < 0.75)))
    assert all("tightened" in messages[i] for i in np.flatnonzero(DC > 0.75))
    assert not any(e.broken for e in curves["C2 b=0.1"].estimates)


def test_report_where_the_curved_objective_carries():
    """One half before P, b = 5: the change of L over the estimate is dx / 2."""
    curve = estimated_curve(linearity_programs()[1].halved(), DC)
    dx = -4.0 * DC**2 + 3.0 * DC
    measures = [e.linearity.measure for e in curve.estimates]
    np.testing.assert_allclose(measures, np.abs(dx) / 2.0, atol=1e-5)
    np.testing.assert_array_equal(verdicts(curve, "linearity"), np.abs(dx) / 2.0 > 0.1)


@pytest.mark.parametrize(("key", "b"), [("C3 b=10", 10.0), ("C3 b=5", 5.0), ("C3 b=0.1", 0.1)])
def test_report_where_design_and_parameter_couple(curves, key, b):
    curve = curves[key]
    measures = np.array([e.coupling.measure for e in curve.estimates])
    np.testing.assert_allclose(measures, 2.0 * b * DC / 9.8, rtol=1e-5, atol=1e-9)
    np.testing.assert_array_equal(verdicts(curve, "coupling"), measures > 0.1)
    assert not verdicts(curve, "active_set").any()
    # the estimates see nothing of b
    np.testing.assert_allclose(curve.high_order, curves["C3 b=0.1"].high_order, atol=1e-6)


def test_report_where_a_constraint_becomes_active(curves):
    curve = curves["C4"]
    np.testing.assert_array_equal(verdicts(curve, "active_set"), DC >= 0.2)
    assert "reached by the predicted step: H x <= h0" in curve.estimates[10].active_set.message
    assert not verdicts(curve, "linearity").any() and not verdicts(curve, "coupling").any()
    # with the printed h0 = 0 the second constraint binds from the start
    printed = estimated_curve(active_set_program(h0=0.0), [0.0, 0.1, 0.7])
    np.testing.assert_allclose(printed.truth, 0.0, atol=1e-6)
    np.testing.assert_allclose(printed.high_order, 0.0, atol=1e-6)


@pytest.mark.parametrize("key", PROGRAMS)
def test_attained_change_bounds_the_true_one(curves, key):
    curve = curves[key]
    for e, truth in zip(curve.estimates, curve.truth, strict=True):
        if e.attained is not None:
            assert truth <= e.attained + 1e-6
    assert any(e.attained is not None for e in curve.estimates)


def test_programs_that_are_not_convex_or_symmetric():
    base = {"name": "bad", "q": np.ones(3), "G": np.ones(2), "g": np.ones(3)}
    with pytest.raises(InputError, match="P: the block of x has the eigenvalue -1"):
        QuadraticProgram(P=np.diag([1.0, -1.0, 0.0]), **base)
    with pytest.raises(InputError, match="P: expected a symmetric matrix"):
        QuadraticProgram(P=np.triu(np.ones((3, 3))), **base)
