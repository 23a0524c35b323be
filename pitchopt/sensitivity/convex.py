"""A solved cvxpy problem as a model: duals as cvxpy gives them, x frozen, nothing re-solved.

Signs, for a minimisation of F (F = -f for a maximisation; cvxpy's duals are those of F):

    a <= b:  L + y . (a - b),  y >= 0          a == b, Zero(a):  L + y . (a - b)
    NonNeg(a):  L - y . a,  y >= 0             NonPos(a):  L + y . a,  y >= 0
    cones (second-order, semidefinite, exponential, power) a in K:  L - y . a,  y in the dual cone

Signs and bounds that are attributes of variables are constraints without duals.  Where the
functions are smooth, their multipliers follow from stationarity: what is left of grad_x L at a
variable that is at its bound.

Everything of the problem's that is changed for an evaluation (values of variables and parameters)
is put back before the call returns.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy import sparse

from pitchopt.checks import FloatArray
from pitchopt.errors import InputError
from pitchopt.sensitivity.convex_pieces import Piece, attribute_pieces, constraint_piece
from pitchopt.sensitivity.convex_problem import checked_problem, domain_conditions, in_domain
from pitchopt.sensitivity.differences import settled_derivative
from pitchopt.sensitivity.elastic import unmet_convex
from pitchopt.sensitivity.model import Counts, Gradients, Slope, Unmet, Values, sizes, solid
from pitchopt.sensitivity.rows import Layout

__all__ = ["ConvexModel"]

AT_BOUND = 1e-4
STATIONARY = 1e-3
SOLVER_ZERO = 1e-7


class ConvexModel:
    """See the module.

    Parameters
    ----------
    problem : cvxpy.Problem
        Solved.
    parameter : cvxpy.Parameter
        Frozen, c.
    names : mapping of constraint to str, sequence of str, or None
        Of the constraints; in a sequence, in the order of ``problem.constraints``.
    x_scale : mapping of variable to array_like, or None
        Sizes of variables.
    """

    keeps_slopes = False

    def __init__(
        self,
        problem: Any,
        parameter: Any,
        *,
        names: Mapping[Any, str] | Sequence[str] | None = None,
        x_scale: Mapping[Any, ArrayLike] | None = None,
    ) -> None:
        checked_problem(problem, parameter)
        self._problem = problem
        self._parameter = parameter
        self._variables = problem.variables()
        self._optimum = [np.array(solid(v.value)) for v in self._variables]
        self._starts = np.concatenate([[0], np.cumsum([v.size for v in self._variables])])
        self._others = [
            (p, p.value)
            for p in problem.parameters()
            if p is not parameter and not hasattr(p, "_callback") and p.sparse_idx is None
        ]
        self.reference = np.array(solid(parameter.value))
        self.sense = 1.0 if problem.objective.NAME == "minimize" else -1.0
        self.counts = Counts()
        self._scale = self._sizes(x_scale or {})
        given = _names(problem, names)
        self._pieces: list[Piece] = [
            constraint_piece(constraint, name)
            for constraint, name in zip(problem.constraints, given, strict=True)
        ]
        listed = len(self._pieces)
        self._pieces += attribute_pieces(self._variables)
        self.layout = Layout(tuple(piece.block for piece in self._pieces))
        expressions = [(problem.objective.expr, "the objective")] + [
            (term.expression, f"constraint {piece.block.name}")
            for piece in self._pieces
            for term in piece.terms
        ]
        self._domains = [
            (condition, name)
            for expression, name in expressions
            for condition in domain_conditions(expression)
        ]
        self.multipliers = self._all_multipliers(listed)
        value = self.values(self.reference).objective * self.sense
        if abs(value - problem.value) > 1e-8 * max(abs(value), abs(problem.value)) + 1e-300:
            raise InputError(
                f"problem: its value was {problem.value:.8g} when it was solved and is {value:.8g} "
                "now; parameters or variables have changed since, solve it again"
            )

    @property
    def scale(self) -> FloatArray:
        """Sizes of the variables at the optimum (n,)."""
        return self._scale

    def values(self, c: NDArray[np.float64], move: FloatArray | None = None) -> Values:
        """F and r at (x* + move, c)."""
        with self._at(c, move):
            in_domain(self._domains, c - self.reference)
            f = self.sense * float(solid(self._problem.objective.expr.value).reshape(()))
            r = np.concatenate([np.zeros(0), *[piece.value() for piece in self._pieces]])
        if move is None:
            self.counts.frozen += 1
        else:
            self.counts.moved += 1
        if not (np.isfinite(f) and np.isfinite(r).all()):
            bad = "the objective" if not np.isfinite(f) else self._first_bad(r)
            raise InputError(
                f"dc: with {_short(c - self.reference)} {bad} is not finite; expected a dc within "
                "the domain of the problem's functions"
            )
        return Values(f, r)

    def gradients(self, c: NDArray[np.float64]) -> Gradients | None:
        """In x at (x*, c) as cvxpy differentiates; None outside the domain of a gradient."""
        n = int(self._starts[-1])
        self.counts.gradients += 1
        with self._at(c, None), np.errstate(all="ignore"):
            objective = self._jacobian(self._problem.objective.expr)
            if objective is None:
                return None
            parts: list[sparse.csr_array] = []
            for piece in self._pieces:
                rows = sparse.csr_array((piece.block.size, n))
                for term in piece.terms:
                    jacobian = self._jacobian(term.expression)
                    if jacobian is None:
                        return None
                    m = term.positions.size
                    place = sparse.csr_array(
                        (np.full(m, term.sign), (term.positions, np.arange(m))),
                        shape=(piece.block.size, m),
                    )
                    rows = rows + place @ jacobian
                parts.append(sparse.csr_array(rows))
        entries = sparse.csr_array(sparse.vstack(parts)) if parts else sparse.csr_array((0, n))
        f = self.sense * objective.toarray()[0]
        if not (np.isfinite(f).all() and np.isfinite(entries.data).all()):
            return None
        return Gradients(self.tangent(f), self._tangent_rows(entries))

    def tangent(self, vectors: FloatArray) -> FloatArray:
        """Without the entries that attributes hold at zero, symmetric where they say so."""
        return np.asarray(vectors @ self._projector())

    def slope(self, dc: NDArray[np.float64]) -> Slope:
        """Along dc by differences with a checked step, x frozen."""
        if not dc.any():
            return Slope(0.0, np.zeros(self.layout.size))

        def terms(t: float) -> FloatArray:
            return self.values(self.reference + t * dc).vector

        weights = np.concatenate([[1.0], self.multipliers])
        found = settled_derivative(terms, weights, name=f"dc = {_short(dc)}")
        return Slope(float(found.value[0]), found.value[1:], found.error, found.step)

    def unmet(self, c: NDArray[np.float64], tolerance: float) -> Unmet | None:
        """By one elastic feasibility problem of constraints of its own; values are put back."""
        with self._at(c, None):
            return unmet_convex(self._problem, self._pieces, tolerance)

    # -- inside ---------------------------------------------------------------------------------

    @contextmanager
    def _at(self, c: NDArray[np.float64], move: FloatArray | None) -> Iterator[None]:
        leaves = [*self._variables, *(p for p, _ in self._others), self._parameter]
        saved = [leaf._value for leaf in leaves]
        try:
            for i, (variable, x) in enumerate(zip(self._variables, self._optimum, strict=True)):
                if move is not None:
                    part = move[self._starts[i] : self._starts[i + 1]]
                    x = x + part.reshape(x.shape, order="F")
                variable.save_value(x)
            for parameter, value in self._others:
                parameter.save_value(value)
            try:
                self._parameter.value = c if c.ndim else float(c)
            except ValueError as error:
                raise InputError(
                    f"dc: with {_short(c - self.reference)} the parameter "
                    f"{self._parameter.name()} would break its own attributes ({error})"
                ) from error
            with np.errstate(all="ignore"):
                yield
        finally:
            for leaf, value in zip(leaves, saved, strict=True):
                leaf._value = value

    def _sizes(self, given: Mapping[Any, ArrayLike]) -> FloatArray:
        largest = max((float(np.max(np.abs(x), initial=0.0)) for x in self._optimum), default=0.0)
        other = largest if largest > SOLVER_ZERO else 1.0
        scale = self._flat(
            [
                sizes(x, 1e-5) if np.max(np.abs(x), initial=0.0) > SOLVER_ZERO else 0.0 * x + other
                for x in self._optimum
            ]
        )
        known = {key if isinstance(key, int) else key.id: value for key, value in given.items()}
        if set(known) - {variable.id for variable in self._variables}:
            raise InputError("x_scale: expected keys that are variables of the problem")
        for variable, start in zip(self._variables, self._starts[:-1], strict=True):
            if variable.id not in known:
                continue
            try:
                part = np.broadcast_to(solid(known[variable.id]), variable.shape)
            except (TypeError, ValueError) as error:
                raise InputError(
                    f"x_scale: that of {variable.name()} does not fit its shape {variable.shape}"
                ) from error
            if not (np.isfinite(part).all() and (part > 0.0).all()):
                raise InputError(f"x_scale: expected positive sizes of {variable.name()}")
            scale[start : start + variable.size] = part.ravel(order="F")
        return scale

    def _flat(self, values: Sequence[FloatArray]) -> FloatArray:
        return np.concatenate([np.zeros(0), *[v.ravel(order="F") for v in values]])

    def _jacobian(self, expression: Any) -> sparse.csr_array | None:
        """Rows for the entries of the expression, columns for all variables."""
        n, m = int(self._starts[-1]), int(expression.size)
        try:
            gradient = expression.grad
        except NotImplementedError:  # cvxpy has none for some functions, such as norm_inf
            return None
        rows, columns, data = [np.zeros(0, int)], [np.zeros(0, int)], [np.zeros(0)]
        for variable, start in zip(self._variables, self._starts[:-1], strict=True):
            if variable not in gradient:
                continue
            part = gradient[variable]
            if part is None:
                return None
            part = sparse.coo_array(np.atleast_2d(part) if np.ndim(part) == 0 else part)
            rows.append(part.coords[1])
            columns.append(part.coords[0] + start)
            data.append(part.data)
        return sparse.csr_array(
            (np.concatenate(data), (np.concatenate(rows), np.concatenate(columns))), shape=(m, n)
        )

    def _projector(self) -> sparse.csr_array:
        parts: list[Any] = []
        for variable in self._variables:
            n, attributes = variable.size, variable.attributes
            if attributes["diag"]:
                side = variable.shape[0]
                parts.append(sparse.diags_array(np.eye(side).ravel()))
            elif any(attributes[k] for k in ("symmetric", "PSD", "NSD")):
                side = variable.shape[0]
                swap = np.arange(n).reshape(side, side).ravel(order="F")
                eye = sparse.eye_array(n, format="csr")
                parts.append(0.5 * (eye + eye[swap]))
            else:
                parts.append(sparse.eye_array(n))
        return sparse.csr_array(sparse.block_diag(parts, format="csr"))

    def _tangent_rows(self, entries: sparse.csr_array) -> sparse.csr_array:
        return sparse.csr_array(entries @ self._projector())

    def _all_multipliers(self, listed: int) -> FloatArray:
        given = [piece.dual() for piece in self._pieces[:listed]]
        if listed == len(self._pieces):
            return np.concatenate([np.zeros(0), *given])
        start = sum(piece.block.size for piece in self._pieces[:listed])
        lam = np.zeros(self.layout.size)
        lam[:start] = np.concatenate([np.zeros(0), *given])
        held = [p for p in self._pieces[listed:] if p.depends_on(self._parameter)]
        gradients = self.gradients(self.reference)
        if gradients is None:
            if held:
                raise InputError(_unknown_bounds(held))
            return lam
        left = gradients.objective + gradients.entries.T @ lam
        r = self.values(self.reference).entries
        part: FloatArray
        for piece in self._pieces[listed:]:
            size, term = piece.block.size, piece.terms[0]
            first = next(
                k for v, k in zip(self._variables, self._starts, strict=False)
                if v is piece.variable
            )  # fmt: skip
            columns = int(first) + (np.arange(0) if piece.columns is None else piece.columns)
            # L = F + lam . r and r = sign x, so lam = -sign times what is left, at the bound
            part = -term.sign * left[columns]
            if piece.block.kind == "inequality":
                near = -r[start : start + size] <= AT_BOUND * self._scale[columns]
                part = np.where(near, np.maximum(part, 0.0), 0.0)
            else:
                z = part.reshape(piece.variable.shape)
                w, v = np.linalg.eigh(0.5 * (z + z.T))
                part = ((v * np.maximum(w, 0.0)) @ v.T).ravel()
            lam[start : start + size] = part
            start += size
        if held:
            left = (gradients.objective + gradients.entries.T @ lam) * self._scale
            slope = float(np.linalg.norm(gradients.objective * self._scale))
            if float(np.linalg.norm(left)) > STATIONARY * slope:
                raise InputError(_unknown_bounds(held))
        return lam

    def _first_bad(self, r: FloatArray) -> str:
        return f"constraint {self.layout.name(int(self.layout.row_of[np.argmin(np.isfinite(r))]))}"


def _unknown_bounds(held: Sequence[Piece]) -> str:
    return (
        f"problem: the bounds {held[0].block.name} hold the parameter and have no multiplier that "
        "can be told from stationarity; write them as constraints"
    )


def _short(dc: NDArray[np.float64]) -> str:
    if dc.size == 1:
        return f"{float(dc.reshape(())):.6g}" if dc.ndim == 0 else f"[{float(dc.ravel()[0]):.6g}]"
    return np.array2string(dc, precision=4, threshold=6, edgeitems=2).replace("\n", "")


def _names(problem: Any, names: Mapping[Any, str] | Sequence[str] | None) -> list[str]:
    constraints = problem.constraints
    if names is None:
        found: list[str] = []
        for i, constraint in enumerate(constraints):
            label = getattr(constraint, "label", None)
            text = str(label) if label else " ".join(str(constraint).split())
            text = text if len(text) <= 40 else text[:37] + "..."
            found.append(text if text not in found else f"{text} ({i})")
        return found
    if isinstance(names, Mapping):
        by_id = {key if isinstance(key, int) else key.id: str(v) for key, v in names.items()}
        unknown = set(by_id) - {con.id for con in constraints}
        if unknown:
            raise InputError(
                f"names: got {len(unknown)} constraints that the problem does not have; expected "
                "keys from problem.constraints"
            )
        default = _names(problem, None)
        return [by_id.get(con.id, text) for con, text in zip(constraints, default, strict=True)]
    if isinstance(names, str) or len(names) != len(constraints):
        got = 1 if isinstance(names, str) else len(names)
        raise InputError(f"names: got {got}, expected {len(constraints)}, one for each constraint")
    return [str(name) for name in names]
