"""The optimum seen from close by: sizes, active rows, stationarity, and the predicted step.

Everything is made free of scales by the sizes D of the variables: a row's length is the norm of its
gradient times D, the objective's size F' is the norm of D grad F or, where that vanishes inside
the feasible set, what a step of a tenth of D changes F by, ten times.  A row is

    carrying   if its scaled multiplier m, times its length over F', stands out against its scaled
               distance d from the limit, over its length: m > 100 d and m > 1e-5, or m > d and
               m > 1e-3 (an interior-point solver leaves both positive, m d equal for all rows,
               and about equal where a row is active by chance),
    idle       if it is at its limit, d <= 1e-6 or d <= 100 m, and does not carry,
    inactive   otherwise.  Equalities always carry.

The predicted step is the smallest, in variables over D, that keeps the carrying rows where they
were: grad_x r_i . dx = -(r_i(x*, c_r + dc) - r_i(x*, c_r)); of a cone, what its multiplier holds
(`pitchopt.sensitivity.faces`).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from pitchopt.checks import FloatArray
from pitchopt.errors import InputError
from pitchopt.sensitivity.estimate import Thresholds
from pitchopt.sensitivity.faces import held_sums
from pitchopt.sensitivity.model import Gradients, Model, Values

__all__ = ["Local", "Rows", "check_optimum", "rows_without_gradients"]

PROBE = 0.1
DENSE = 4_000_000
ROUNDING = 1e-12
CLEAR = 100.0


@dataclass(frozen=True)
class Rows:
    """Which rows do what, masks (M,), their lengths (M,) and scaled distances (M,)."""

    carrying: NDArray[np.bool_]
    idle: NDArray[np.bool_]
    inactive: NDArray[np.bool_]
    length: FloatArray
    distance: FloatArray


def classify(
    model: Model, values: Values, length: FloatArray, size: float, thresholds: Thresholds
) -> Rows:
    """Carrying, idle and inactive rows."""
    layout = model.layout
    distance = -layout.excess(values.entries) / length
    with np.errstate(over="ignore"):
        carried = np.abs(layout.multiplier(model.multipliers)) * length / size
    clear = (carried > CLEAR * distance) & (carried > thresholds.multiplier)
    clear |= (carried > distance) & (carried > CLEAR * thresholds.multiplier)
    carrying = layout.equality | clear
    idle = ~carrying & ((distance <= thresholds.active) | (distance <= CLEAR * carried))
    return Rows(carrying, idle, ~carrying & ~idle, length, distance)


def rows_without_gradients(model: Model, values: Values, thresholds: Thresholds) -> Rows:
    """Rows measured by their own sizes, where there are no gradients in x."""
    layout, r = model.layout, values.entries
    own = np.sqrt(layout.sums(r**2))
    length = np.where(own > 0.0, own, 1.0)
    carried = np.abs(layout.multiplier(model.multipliers)) * length
    size = float(np.max(carried, initial=0.0)) or 1.0
    return classify(model, values, length, size, thresholds)


class Local:
    """Gradients at c_r and what follows from them."""

    def __init__(
        self, model: Model, values: Values, gradients: Gradients, thresholds: Thresholds
    ) -> None:
        scale = model.scale
        if scale is None:
            raise InputError("x: a model with gradients in x needs the sizes of x")
        self._model, self._values, self.gradients = model, values, gradients
        self.scale = scale
        layout = model.layout
        self.scaled = sparse.csr_array(gradients.entries * scale[None, :])
        square = np.asarray(self.scaled.multiply(self.scaled).sum(axis=1), dtype=np.float64).ravel()
        length = np.sqrt(layout.sums(square))
        # a row that no variable moves is measured by its own size
        own = np.sqrt(layout.sums(values.entries**2))
        length = np.where(length > 0.0, length, np.where(own > 0.0, own, 1.0))
        self.size = self._objective_size()
        self.rows = classify(model, values, length, self.size, thresholds)
        self.lagrangian = self._lagrangian(gradients)
        self.stationarity = float(np.linalg.norm(self.lagrangian)) / self.size
        self._held = held_sums(layout, model.multipliers, self.rows.carrying)
        self._factors: tuple[FloatArray, FloatArray, FloatArray] | None = None

    def _objective_size(self) -> float:
        slope = float(np.linalg.norm(self.gradients.objective * self.scale))
        move = self._model.tangent(PROBE * self.scale)
        try:
            there = self._model.values(self._model.reference, move).objective
            probed = abs(there - self._values.objective) / PROBE
        except InputError:  # the probe left the domain
            probed = 0.0
        return max(slope, probed) or 1.0

    def _lagrangian(self, gradients: Gradients) -> FloatArray:
        """D grad_x L."""
        total = gradients.objective + gradients.entries.T @ self._model.multipliers
        return np.asarray(total * self.scale)

    def coupling(self, there: Gradients) -> float:
        """What dc changes grad_x L by, over the size of the objective's gradient."""
        change = self._lagrangian(there) - self.lagrangian
        pieces = abs(self.gradients.entries).T @ np.abs(self._model.multipliers)
        noise = ROUNDING + max(there.error, self.gradients.error)
        terms = (np.abs(self.gradients.objective) + pieces) * self.scale
        noise *= float(np.linalg.norm(terms))
        off = float(np.linalg.norm(change))
        return 0.0 if off <= noise else off / self.size

    def step(self, change: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Predicted dx (n,) for changes of the entries, and what it leaves of each row (M,).

        What is left is the excess of the carrying rows after the step, over their length.
        """
        held = self._held
        length = self.rows.length[held.owner]
        if length.size == 0:
            return np.zeros(self.scale.size), np.zeros(self.rows.length.size)
        matrix = sparse.csr_array(sparse.diags_array(1.0 / length) @ (held.weights @ self.scaled))
        wanted = -(held.weights @ change) / length
        u = self._smallest(matrix, wanted)
        left_over = held.by_row(np.asarray(matrix @ u - wanted), self.rows.length.size)
        return self._model.tangent(u * self.scale), left_over

    @property
    def determined(self) -> bool:
        """Whether the held rows leave no freedom to the step; known once a step was asked for."""
        return self._factors is not None and self._factors[1].size == self.scale.size

    def _smallest(self, matrix: sparse.csr_array, wanted: FloatArray) -> FloatArray:
        if matrix.shape[0] * matrix.shape[1] > DENSE:
            from scipy.sparse.linalg import lsmr

            found = lsmr(matrix, wanted, atol=1e-12, btol=1e-12, maxiter=20 * max(matrix.shape))
            return np.asarray(found[0])
        if self._factors is None:
            u, s, vt = np.linalg.svd(matrix.toarray(), full_matrices=False)
            kept = s > 1e-10 * s[0]
            self._factors = (u[:, kept], s[kept], vt[kept])
        u, s, vt = self._factors
        return np.asarray(vt.T @ ((u.T @ wanted) / s))


def check_optimum(
    local: Local, model: Model, values: Values, limit: float, *, smooth: bool
) -> None:
    """`InputError` if x* and the multipliers are no optimum at c_r.

    Parameters
    ----------
    local : Local
    model : Model
    values : Values
        At x* and c_r.
    limit : float
        Violation, slack with a multiplier and stationarity that are accepted.
    smooth : bool
        Whether stationarity has to hold, as it does without kinks.
    """
    layout, rows = model.layout, local.rows
    excess = layout.excess(values.entries) / rows.length
    carried = np.abs(layout.multiplier(model.multipliers)) * rows.length / local.size
    worst = int(np.argmax(excess)) if excess.size else 0
    if excess.size and excess[worst] > limit:
        raise InputError(
            f"x: violates constraint {layout.name(worst)} at the reference by "
            f"{excess[worst]:.2g} of the size of x; expected the optimum at c_r"
        )
    slack = np.minimum(np.where(layout.equality, 0.0, -excess), carried)
    worst = int(np.argmax(slack)) if slack.size else 0
    if slack.size and slack[worst] > limit:
        raise InputError(
            f"multipliers: constraint {layout.name(worst)} has one and is not active at the "
            f"reference (off by {-excess[worst]:.2g} of the size of x); expected those of the "
            "optimum at c_r, and x_scale where x is near zero"
        )
    if smooth and local.stationarity > limit:
        raise InputError(
            f"multipliers: grad_x L is {local.stationarity:.2g} of the size of grad_x f at x*, "
            f"expected at most {limit:.2g}: they do not belong to this optimum, or their signs "
            "or those of the constraints are turned (Thresholds(wrong=inf) accepts any)"
        )
