"""Whether all constraints can be met at once, and if not, which are in the way.

Every row gets a slack s >= 0 that lets it be exceeded, and the sum of the slacks is minimised: the
problem is feasible if that is zero, and the rows with slack left name what cannot be met.
"""

from __future__ import annotations

import warnings
from collections.abc import Sequence
from typing import Any

import numpy as np
from scipy import sparse

from pitchopt.checks import FloatArray
from pitchopt.errors import ComputationError
from pitchopt.sensitivity.convex_pieces import Piece
from pitchopt.sensitivity.model import Unmet, solid
from pitchopt.sensitivity.rows import Layout

__all__ = ["unmet_convex", "unmet_linear"]

TINY = 1e-9
LEAVE_OUT = "check_feasible=False leaves it out"


def unmet_convex(problem: Any, pieces: Sequence[Piece], tolerance: float) -> Unmet:
    """Rows of a convex problem that cannot be met, at the present values of its parameters.

    Attributes of variables stay as they are.

    Raises
    ------
    ComputationError
        If the solver fails.
    """
    import cvxpy as cp

    relaxed: list[Any] = []
    slacks: list[tuple[Piece, Any, FloatArray]] = []
    for constraint, piece in zip(problem.constraints, pieces, strict=False):
        block = piece.block
        s = cp.Variable(block.rows, nonneg=True)
        size = _sizes(constraint, piece)
        slacks.append((piece, s, size))
        relaxed += _relaxed(constraint, piece, s, cp)
    if not slacks:
        return Unmet(())
    total = sum((1.0 / size) @ s for _, s, size in slacks)
    elastic = cp.Problem(cp.Minimize(total), relaxed)
    try:
        with warnings.catch_warnings():  # whether it is DPP, or accurate, matters to nobody here
            warnings.simplefilter("ignore")
            elastic.solve(solver=cp.CLARABEL)
    except cp.error.SolverError as error:
        raise ComputationError(f"feasibility at the new parameter: {error}; {LEAVE_OUT}") from error
    if elastic.status == cp.INFEASIBLE:
        return Unmet(("signs and bounds of variables, or the domain of a function",))
    if elastic.status not in (cp.OPTIMAL, cp.OPTIMAL_INACCURATE):
        raise ComputationError(
            f"feasibility at the new parameter: the solver ended with {elastic.status}; {LEAVE_OUT}"
        )
    names = []
    for piece, s, size in slacks:
        above = np.flatnonzero(solid(s.value) > tolerance * size)
        names += [piece.block.row_name(int(i)) for i in above]
    return Unmet(tuple(names))


def _sizes(constraint: Any, piece: Piece) -> FloatArray:
    """What the slack of each row counts against: the sides of a constraint and their terms.

    Their difference would not do, which is next to nothing where the constraint is active.
    """
    rows = piece.block.rows
    own, largest = np.zeros(rows), 0.0
    for side in constraint.args:
        for part in (side, *side.args):
            if part.value is None:
                continue
            value = np.abs(solid(part.value)).ravel(order="F")
            largest = max(largest, float(np.max(value, initial=0.0)))
            if value.size == rows or (part is side and value.size == 1):
                own = np.maximum(own, value)
    largest = largest or 1.0
    return np.where(own > TINY * largest, own, largest)


def _relaxed(constraint: Any, piece: Piece, s: Any, cp: Any) -> list[Any]:
    kind, terms = piece.block.kind, piece.terms
    first = terms[0].expression
    if kind == "inequality":
        return [cp.vec(terms[0].sign * first, order="F") <= s]
    if kind == "equality":
        return [cp.vec(first, order="F") <= s, -cp.vec(first, order="F") <= s]
    if kind == "second-order":
        return [cp.SOC(first + s, terms[1].expression, axis=constraint.axis)]
    if kind == "semidefinite":
        return [first + s[0] * np.eye(first.shape[0]) >> 0]
    flat = [cp.vec(term.expression, order="F") for term in terms]
    if kind == "exponential":
        return [cp.ExpCone(flat[0], flat[1], flat[2] + s)]
    # |z| <= product + s: z meets the cone when it comes s closer to zero
    w, z = cp.Variable(s.shape), flat[-1]
    near = [cp.abs(z - w) <= s]
    if isinstance(constraint, cp.PowCone3D):
        powers = piece.block.powers
        alpha = powers[:, 0] if powers is not None else 0.5
        return [*near, cp.PowCone3D(flat[0], flat[1], w, alpha)]
    return [*near, cp.PowConeND(first, w, constraint.alpha, axis=constraint.axis)]


def unmet_linear(
    layout: Layout, entries: FloatArray, jacobian: sparse.csr_array, scale: FloatArray,
    tolerance: float,
) -> Unmet:  # fmt: skip
    """Rows that no step meets to first order, by a linear program.

    Parameters
    ----------
    layout : Layout
        Of inequalities and equalities.
    entries : (N,) ndarray
        r at (x*, c).
    jacobian : (N, n) sparse array
        Of r in x there.
    scale : (n,) ndarray
        Sizes of the variables, which `tolerance` is relative to.

    Raises
    ------
    ComputationError
        If the solver fails.
    """
    import scipy.optimize

    linprog: Any = scipy.optimize.linprog
    a = sparse.csr_array(jacobian * scale[None, :])
    size = np.sqrt(np.asarray(a.multiply(a).sum(axis=1)).ravel())
    size = np.where(size > 0.0, size, np.maximum(np.abs(entries), 1e-300))
    a = sparse.csr_array(sparse.diags_array(1.0 / size) @ a)
    r = entries / size
    n, m = scale.size, r.size
    equal = layout.equality
    eye = sparse.eye_array(m, format="csr")
    above = sparse.hstack([a, -eye])
    below = sparse.hstack([-a[equal], -eye[equal]])
    found = linprog(
        np.concatenate([np.zeros(n), np.ones(m)]),
        A_ub=sparse.csr_array(sparse.vstack([above, below])),
        b_ub=np.concatenate([-r, r[equal]]),
        bounds=[(None, None)] * n + [(0.0, None)] * m,
        method="highs",
    )
    if found.status != 0:
        raise ComputationError(f"feasibility to first order: {found.message}; {LEAVE_OUT}")
    rows = np.flatnonzero(found.x[n:] > tolerance)
    return Unmet(tuple(layout.name(int(i)) for i in rows), "to first order")
