"""Constraints of cvxpy as blocks of entries: which value goes where, with which sign."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pitchopt.checks import FloatArray
from pitchopt.errors import InputError
from pitchopt.sensitivity.model import solid
from pitchopt.sensitivity.rows import Block

__all__ = ["Piece", "Term", "attribute_pieces", "constraint_piece"]


@dataclass(frozen=True)
class Term:
    """Where the entries of an expression, in Fortran order, go in a block, and with which sign."""

    expression: Any
    positions: NDArray[np.intp]
    sign: float
    dual: Any = None


@dataclass(frozen=True)
class Piece:
    """A block and the expressions that fill it; of attributes also whose entries they are."""

    block: Block
    terms: tuple[Term, ...]
    variable: Any = None
    columns: NDArray[np.intp] | None = None

    def value(self) -> FloatArray:
        """Entries r at the present values."""
        out = np.zeros(self.block.size)
        for term in self.terms:
            out[term.positions] = term.sign * solid(term.expression.value).ravel(order="F")
        return out

    def dual(self) -> FloatArray:
        """Multipliers of the entries, as the solver left them."""
        out = np.zeros(self.block.size)
        for term in self.terms:
            value = None if term.dual is None else term.dual.value
            if value is None:
                raise InputError(
                    f"problem: constraint {self.block.name} has no dual value; solve with a "
                    "solver that gives duals, such as CLARABEL"
                )
            out[term.positions] = solid(value).ravel(order="F")
        if not np.isfinite(out).all():
            raise InputError(f"problem: constraint {self.block.name} has duals that are not finite")
        return out

    def depends_on(self, parameter: Any) -> bool:
        """Whether a term holds the parameter."""
        return any(
            p is parameter or (hasattr(p, "_callback"))
            for term in self.terms
            for p in term.expression.parameters()
        )


def constraint_piece(constraint: Any, name: str) -> Piece:
    """Block of a constraint; `InputError` for one that has no duals."""
    import cvxpy as cp

    kinds = cp.constraints
    if isinstance(constraint, (kinds.Inequality, kinds.NonPos, kinds.NonNeg)):
        expression = (
            constraint.expr if isinstance(constraint, kinds.Inequality) else constraint.args[0]
        )
        sign = -1.0 if isinstance(constraint, kinds.NonNeg) else 1.0
        return _plain(constraint, name, expression, sign, "inequality")
    if isinstance(constraint, (kinds.Equality, kinds.Zero)):
        return _plain(constraint, name, constraint.expr, 1.0, "equality")
    if isinstance(constraint, kinds.SOC):
        return _second_order(constraint, name)
    if type(constraint) is kinds.PSD and len(constraint.args[0].shape) == 2:
        a = constraint.args[0]
        block = Block(name=name, kind="semidefinite", rows=1, width=a.size)
        return Piece(block, (Term(a, np.arange(a.size), -1.0, constraint.dual_variables[0]),))
    if isinstance(constraint, kinds.PowCone3D):
        return _elementwise(constraint, name, "power")
    if isinstance(constraint, kinds.PowConeND):
        return _power_nd(constraint, name)
    if isinstance(constraint, kinds.ExpCone):
        return _elementwise(constraint, name, "exponential")
    raise InputError(
        f"problem: constraint {name} is of type {type(constraint).__name__}, which has no duals to "
        "work with; expected inequalities, equalities, second-order, semidefinite, exponential or "
        "power cones"
    )


def _plain(constraint: Any, name: str, expression: Any, sign: float, kind: Any) -> Piece:
    block = Block(name=name, kind=kind, rows=expression.size, shape=expression.shape)
    term = Term(expression, np.arange(expression.size), sign, constraint.dual_variables[0])
    return Piece(block, (term,))


def _cones(rows: int, width: int) -> NDArray[np.intp]:
    return np.arange(rows * width).reshape(rows, width)


def _second_order(constraint: Any, name: str) -> Piece:
    t, x = constraint.args
    rows = t.size
    width = 1 + x.size // rows
    place = _cones(rows, width)
    # Fortran order of X: cone by cone if a column is a cone, component by component if a row is
    tail = place[:, 1:].ravel() if constraint.axis == 0 else place[:, 1:].T.ravel()
    duals = constraint.dual_variables
    block = Block(
        name=name, kind="second-order", rows=rows, width=width, shape=() if rows == 1 else (rows,)
    )
    return Piece(block, (Term(t, place[:, 0], -1.0, duals[0]), Term(x, tail, -1.0, duals[1])))


def _elementwise(constraint: Any, name: str, kind: Any) -> Piece:
    rows = constraint.args[0].size
    place = _cones(rows, 3)
    powers = None
    if kind == "power":
        flat = np.broadcast_to(solid(constraint.alpha.value).ravel(order="F"), (rows,))
        powers = np.column_stack([flat, 1.0 - flat])
    block = Block(
        name=name, kind=kind, rows=rows, width=3, shape=constraint.args[0].shape, powers=powers
    )
    return Piece(
        block,
        tuple(
            Term(a, place[:, i], -1.0, dual)
            for i, (a, dual) in enumerate(
                zip(constraint.args, constraint.dual_variables, strict=True)
            )
        ),
    )


def _power_nd(constraint: Any, name: str) -> Piece:
    w, z = constraint.args
    rows = z.size
    width = 1 + w.size // rows
    place = _cones(rows, width)
    columns = constraint.axis == 0
    head = place[:, :-1].ravel() if columns else place[:, :-1].T.ravel()
    alpha = solid(constraint.alpha.value).ravel(order="F")
    powers = alpha.reshape(rows, -1) if columns else alpha.reshape(-1, rows).T
    block = Block(
        name=name, kind="power", rows=rows, width=width,
        shape=() if rows == 1 else (rows,), powers=powers,
    )  # fmt: skip
    duals = constraint.dual_variables
    return Piece(block, (Term(w, head, -1.0, duals[0]), Term(z, place[:, -1], -1.0, duals[1])))


def attribute_pieces(variables: Sequence[Any]) -> list[Piece]:
    """Blocks of the signs, bounds and definiteness that variables carry."""
    pieces: list[Piece] = []
    for variable in variables:
        attributes, name = variable.attributes, variable.name()
        limits: list[tuple[str, Any, float]] = []
        if attributes["nonneg"] or attributes["pos"]:
            limits.append((">= 0", None, -1.0))
        if attributes["nonpos"] or attributes["neg"]:
            limits.append(("<= 0", None, 1.0))
        if variable.bounds is not None:
            lower, upper = variable.bounds
            limits += [(">= lower bound", lower, -1.0), ("<= upper bound", upper, 1.0)]
        for text, limit, sign in limits:
            pieces += _bound(variable, f"{name} {text}", limit, sign)
        for key, sign in (("PSD", -1.0), ("NSD", 1.0)):
            if attributes[key]:
                block = Block(
                    name=f"{name} is {key}", kind="semidefinite", rows=1, width=variable.size
                )
                term = Term(1.0 * variable, np.arange(variable.size), sign)
                pieces.append(Piece(block, (term,), variable, term.positions))
    return pieces


def _bound(variable: Any, name: str, limit: Any, sign: float) -> list[Piece]:
    import cvxpy as cp

    flat = cp.vec(variable, order="F")
    n = variable.size
    rows = np.arange(n)
    if limit is None:
        expression = flat
    elif isinstance(limit, cp.Expression):
        expression = flat - (cp.vec(limit, order="F") if limit.size == n else limit)
    else:
        level = np.broadcast_to(solid(limit), variable.shape).ravel(order="F")
        rows = np.flatnonzero(np.isfinite(level))
        if rows.size == 0:
            return []
        expression = flat[rows] - level[rows]
    shape: tuple[int, ...] = variable.shape
    names = None
    if rows.size < n:
        full = Block(name=name, kind="inequality", rows=n, shape=shape)
        names = tuple(full.row_name(int(i)) for i in rows)
    block = Block(name=name, kind="inequality", rows=rows.size, shape=shape, names=names)
    return [Piece(block, (Term(expression, np.arange(rows.size), sign),), variable, rows)]
