"""What an estimate says: changes, what carries them, and what they rest on."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field
from functools import cached_property
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from pitchopt.checks import FloatArray, finite_number
from pitchopt.sensitivity.rows import Layout, listed

__all__ = ["Assumption", "Contribution", "Estimate", "Thresholds", "Verdict"]

Verdict = Literal["holds", "broken", "not judged"]


@dataclass(frozen=True, kw_only=True)
class Thresholds:
    """Where measures turn into verdicts.

    Lengths are relative to the sizes of the variables, gradients to that of the objective.

    Parameters
    ----------
    active : float
        Distance below which a row counts as active.
    multiplier : float
        Scaled multiplier below which a row counts as carrying nothing.
    coupling, linearity : float
        Measures of assumptions A2 and A1 above which they count as broken.
    stationarity : float
        Norm of grad_x L over that of grad_x f at the optimum above which multipliers are said not
        to fit.
    wrong : float
        The same, and the violation and the slack of a row with a multiplier, above which the
        optimum is not accepted; infinite to accept any.
    feasible : float
        Excess, relative as a length, up to which a row counts as met.
    """

    active: float = 1e-6
    multiplier: float = 1e-5
    coupling: float = 0.1
    linearity: float = 0.1
    stationarity: float = 1e-3
    wrong: float = 0.1
    feasible: float = 1e-6

    def __post_init__(self) -> None:
        for name in ("active", "multiplier", "coupling", "linearity", "stationarity", "feasible"):
            value = finite_number(name, getattr(self, name), at_least=0.0)
            object.__setattr__(self, name, value)
        wrong = float(self.wrong)
        if wrong != np.inf:
            wrong = finite_number("wrong", wrong, above=0.0)
        object.__setattr__(self, "wrong", wrong)


@dataclass(frozen=True, kw_only=True)
class Assumption:
    """An assumption and what was found.

    Attributes
    ----------
    name : str
        Such as ``A2 coupling``.
    verdict : {"holds", "broken", "not judged"}
    measure : float or None
        None where not judged; for the active set the number of rows that change sides.
    threshold : float
        Above which it counts as broken.
    message : str
        In words, with numbers.
    """

    name: str
    verdict: Verdict
    measure: float | None
    threshold: float
    message: str

    def __str__(self) -> str:
        return f"{self.name} {self.verdict}: {self.message}"


@dataclass(frozen=True, kw_only=True)
class Contribution:
    """What one constraint, one row of it, or the objective adds to an estimate.

    Attributes
    ----------
    name : str
        Of the constraint or row; ``objective`` for f itself.
    multiplier : float or None
        lambda of a row (for cones see `pitchopt.sensitivity.rows`); of a whole constraint the sum
        over its rows; None for the objective.
    first_order, high_order : float
        Of the change of f.
    share : float
        high_order over the sum of the absolute values of all contributions, -1 to 1.
    """

    name: str
    multiplier: float | None
    first_order: float
    high_order: float
    share: float


@dataclass(frozen=True, kw_only=True)
class Estimate:
    """Estimated change of an optimal value.

    Attributes
    ----------
    dc : ndarray
        Change of the parameter, in its shape.
    reference : float
        Optimal value z* at c_r.
    first_order, high_order : float
        Estimates of z*(c_r + dc) - z*(c_r).
    first_order_error : float or None
        Of the differences in first_order; 0 for exact gradients, None where unknown (one
        prescribed step).
    step : float or None
        Of those differences: a length of dc, for cvxpy problems a fraction of it; None where exact.
    attained : float or None
        Change that is attained for sure, f(x* + dx, c_r + dc) - f*, if the predicted design
        satisfies all constraints as well as x* does or within the threshold: the true change is
        at most (minimising) or at least (maximising) that.
    row_first_order, row_high_order, row_multipliers : (M,) ndarray
        Contributions and multipliers of all rows.
    objective_first_order, objective_high_order : float
        Contribution of f itself.
    active_set, coupling, linearity, stationarity : Assumption
        A3, A2, A1, and whether the multipliers belong to the optimum.
    predicted_step : (n,) ndarray or None
        dx, the smallest step that keeps the active rows active.
    """

    dc: NDArray[np.float64]
    reference: float
    first_order: float
    high_order: float
    first_order_error: float | None
    step: float | None
    attained: float | None
    row_first_order: FloatArray
    row_high_order: FloatArray
    row_multipliers: FloatArray
    objective_first_order: float
    objective_high_order: float
    active_set: Assumption
    coupling: Assumption
    linearity: Assumption
    stationarity: Assumption
    predicted_step: FloatArray | None = None
    layout: Layout = field(repr=False)

    @property
    def assumptions(self) -> tuple[Assumption, ...]:
        """All, A1 first."""
        return (self.linearity, self.coupling, self.active_set, self.stationarity)

    @property
    def broken(self) -> tuple[Assumption, ...]:
        """Those that look broken."""
        return tuple(a for a in self.assumptions if a.verdict == "broken")

    @cached_property
    def _size(self) -> float:
        total = np.sum(np.abs(self.row_high_order)) + abs(self.objective_high_order)
        return float(total) or 1.0

    @property
    def objective(self) -> Contribution:
        """What f itself adds."""
        return Contribution(
            name="objective",
            multiplier=None,
            first_order=self.objective_first_order,
            high_order=self.objective_high_order,
            share=self.objective_high_order / self._size,
        )

    def largest(self, count: int | None = 10) -> tuple[Contribution, ...]:
        """Rows that carry most of the estimate, largest first; all with None.

        Rows that add nothing to either estimate are left out.
        """
        weight = np.maximum(np.abs(self.row_high_order), np.abs(self.row_first_order))
        order = np.argsort(-weight, kind="stable")[:count]
        return tuple(self._row(int(i)) for i in order if weight[i] > 0.0)

    @cached_property
    def constraints(self) -> tuple[Contribution, ...]:
        """Whole constraints, their rows added, largest first."""
        layout = self.layout
        count = len(layout.blocks)
        sums = [
            np.bincount(layout.block_of, weights=rows, minlength=count)
            for rows in (self.row_multipliers, self.row_first_order, self.row_high_order)
        ]
        order = np.argsort(-np.maximum(np.abs(sums[1]), np.abs(sums[2])), kind="stable")
        return tuple(
            Contribution(
                name=layout.blocks[i].name,
                multiplier=float(sums[0][i]),
                first_order=float(sums[1][i]),
                high_order=float(sums[2][i]),
                share=float(sums[2][i]) / self._size,
            )
            for i in order
        )

    def _row(self, i: int) -> Contribution:
        return Contribution(
            name=self.layout.name(i),
            multiplier=float(self.row_multipliers[i]),
            first_order=float(self.row_first_order[i]),
            high_order=float(self.row_high_order[i]),
            share=float(self.row_high_order[i]) / self._size,
        )


def rows_text(layout: Layout, rows: Iterable[int]) -> str:
    """Names of rows in a sentence."""
    return listed([layout.name(int(i)) for i in rows])
