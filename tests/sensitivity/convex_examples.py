"""Convex problems with a parameter, one for each kind of constraint."""

import cvxpy as cp
import numpy as np

TIGHT = {
    "solver": "CLARABEL",
    "tol_gap_abs": 1e-9,
    "tol_gap_rel": 1e-9,
    "tol_feas": 1e-9,
}


def objective(x, sense, extra=0.0):
    """A strongly convex objective, or its negative to maximise."""
    f = cp.sum_squares(x) + 3.0 * x[0] + x[1] + extra
    return cp.Minimize(f) if sense == "min" else cp.Maximize(-f)


def stacked(x, c):
    """Two cones of dimension two as columns."""
    first = cp.hstack([x[0] - 2.0 - c, x[0] + x[1] - 4.5])
    return cp.vstack([first, cp.hstack([x[1] - 1.0, 0.5 * c])])


CONSTRAINTS = {
    "at least, vector": (lambda x, c: x >= c, 1.0),
    "at most, scalar": (lambda x, c: -x[0] - 0.5 * x[1] <= -c, 1.0),
    "at most, matrix": (lambda x, c: cp.reshape(x, (1, 2), order="F") >= c * np.ones((1, 2)), 1.0),
    "convex": (lambda x, c: cp.norm(x - 3.0) <= c, 1.0),
    "equal": (lambda x, c: x[0] + 2.0 * x[1] == c, 1.0),
    "equal, vector": (lambda x, c: x == cp.hstack([c, -2.0 * c]), 1.0),
    "Zero": (lambda x, c: cp.Zero(x[0] - c), 1.0),
    "NonNeg": (lambda x, c: cp.NonNeg(x - c), 1.0),
    "NonPos": (lambda x, c: cp.NonPos(c - x), 1.0),
    "SOC, one cone": (lambda x, c: cp.SOC(c, x + np.array([2.0, -1.0])), 0.5),
    "SOC, scalar": (lambda x, c: cp.SOC(1.0 + 2.0 * c + 0.1 * x[1], x[0] - 4.0), 0.5),
    "SOC, columns": (
        lambda x, c: cp.SOC(cp.hstack([c, 1.2 * c]), stacked(x, c), axis=0), 1.0,
    ),
    "SOC, rows": (
        lambda x, c: cp.SOC(cp.hstack([c, 1.2 * c]), stacked(x, c).T, axis=1), 1.0,
    ),
    "PSD": (lambda x, c: cp.bmat([[x[0], c], [c, x[1]]]) >> 0, 1.0),
    "NSD": (lambda x, c: cp.bmat([[-x[0], c], [c, -x[1]]]) << 0, 1.0),
    "ExpCone": (lambda x, c: cp.ExpCone(cp.hstack([c, 2.0 * c]), np.ones(2), x), 0.3),
    "PowCone3D": (
        lambda x, c: cp.PowCone3D(x, np.ones(2), cp.hstack([c, c]), np.array([0.3, 0.4])), 0.9,
    ),
    "PowConeND": (lambda x, c: cp.PowConeND(x, c, np.array([0.3, 0.7])), 0.9),
    "PowConeND, columns": (
        lambda x, c: cp.PowConeND(
            cp.vstack([cp.hstack([x[0], x[1] + 1.0]), cp.hstack([x[1], x[0] + 2.0])]),
            cp.hstack([c, 1.7 * c]),
            np.array([[0.3, 0.6], [0.7, 0.4]]),
        ), 0.9,
    ),
}  # fmt: skip


def problem(kind, sense, where="constraint"):
    """Problem, parameter; c in the constraint, the objective or both."""
    make, start = CONSTRAINTS[kind]
    x = cp.Variable(2)
    c = cp.Parameter(value=start)
    inside = c if where != "objective" else start
    extra = (
        0.0
        if where == "constraint"
        else cp.sum(cp.multiply(c * np.array([1.0, -2.3]), x)) + 0.7 * c
    )
    return cp.Problem(objective(x, sense, extra), [make(x, inside)]), c


def solve(prob):
    """Optimal value, as accurate as the cones allow."""
    hard = any(isinstance(con, cp.constraints.PowConeND) for con in prob.constraints)
    return prob.solve(solver="CLARABEL") if hard else prob.solve(**TIGHT)


def solved_at(prob, parameter, value):
    """Optimal value with the parameter there; the parameter is put back."""
    before = parameter.value
    parameter.value = value
    try:
        return solve(prob)
    finally:
        parameter.value = before
