"""A cone program collected block by block and handed to Clarabel.

    minimise  x' P x / 2 + cost . x   subject to   b - A x in K,

K a product of zero, non-negative and second-order cones in row order, P diagonal and zero
unless set.  The dual z that comes back satisfies P x + cost + A' z = 0 and lies in the dual
cone; for P = 0, cost . x + z . (A x - b) is a lower bound on the minimum for every x.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

__all__ = ["ConeProgram", "ConeSolution"]

FloatArray = NDArray[np.float64]
Entry = tuple[Any, Any, Any]


@dataclass(frozen=True, kw_only=True, eq=False)
class ConeSolution:
    """Primal and dual of a solved program; a ray of the dual where it is infeasible."""

    x: FloatArray
    z: FloatArray
    status: str
    solved: bool
    infeasible: bool
    iterations: int
    seconds: float


def _spread(value: Any, size: int) -> Any:
    """An array as it is, a single number ``size`` times."""
    return value if isinstance(value, np.ndarray) else np.full(size, value)


class ConeProgram:
    """Variables and rows, in the order in which they are added."""

    def __init__(self) -> None:
        self.at: dict[str, slice] = {}
        self.width = 0
        self.height = 0
        self.quadratic: FloatArray | None = None  # diagonal of P on the first variables
        self._costs: list[FloatArray] = []
        self._rows: list[NDArray[np.intp]] = []
        self._cols: list[NDArray[np.intp]] = []
        self._vals: list[FloatArray] = []
        self._rhs: list[FloatArray] = []
        self._cones: list[tuple[str, int]] = []

    def variables(self, name: str, count: int, cost: Any = 0.0) -> slice:
        """Add ``count`` variables; their columns, also kept in ``at[name]``."""
        block = slice(self.width, self.width + count)
        self.at[name] = block
        self._costs.append(np.array(np.broadcast_to(cost, (count,)), dtype=np.float64))
        self.width += count
        return block

    @property
    def cost(self) -> FloatArray:
        """Cost of all variables, shape (width,)."""
        return np.concatenate(self._costs)

    def zero(self, rhs: FloatArray, *entries: Entry) -> slice:
        """Rows A x = rhs; an entry is (row, column, value), single numbers repeated."""
        return self._add("zero", rhs, entries)

    def nonneg(self, rhs: FloatArray, *entries: Entry) -> slice:
        """Rows A x <= rhs."""
        return self._add("nonneg", rhs, entries)

    def second_order(self, rhs: FloatArray, *entries: Entry) -> slice:
        """Rows of one cone: the norm of the later slacks is at most the first."""
        return self._add("second_order", rhs, entries)

    def _add(self, kind: str, rhs: FloatArray, entries: tuple[Entry, ...]) -> slice:
        for row, col, val in entries:
            arrays = [part.size for part in (row, col, val) if isinstance(part, np.ndarray)]
            size = arrays[0] if arrays else 1
            self._rows.append(_spread(row, size) + self.height)
            self._cols.append(_spread(col, size))
            self._vals.append(_spread(val, size))
        self._rhs.append(rhs)
        if self._cones and kind != "second_order" and self._cones[-1][0] == kind:
            self._cones[-1] = (kind, self._cones[-1][1] + rhs.size)
        else:
            self._cones.append((kind, rhs.size))
        start = self.height
        self.height += rhs.size
        return slice(start, self.height)

    def _diagonal(self, unit: float) -> Any:
        from scipy import sparse

        if self.quadratic is None:
            return sparse.csc_matrix((self.width, self.width))
        rest = np.zeros(self.width - self.quadratic.size)
        return sparse.diags_array(np.concatenate([self.quadratic, rest]) / unit, format="csc")

    def solve(self, *, reduced: bool = False, tolerance: float | None = None) -> ConeSolution:
        """Solve once.

        Parameters
        ----------
        reduced : bool
            Accept an answer of less accuracy, as a fallback.
        tolerance : float, optional
            Relative gap and feasibility at which the solver stops; its own (1e-8) by default.
        """
        import clarabel
        from scipy import sparse

        types = {
            "zero": clarabel.ZeroConeT,
            "nonneg": clarabel.NonnegativeConeT,
            "second_order": clarabel.SecondOrderConeT,
        }
        matrix = sparse.coo_matrix(
            (
                np.concatenate(self._vals),
                (np.concatenate(self._rows), np.concatenate(self._cols)),
            ),
            shape=(self.height, self.width),
        ).tocsc()
        settings = clarabel.DefaultSettings()
        settings.verbose = False
        settings.presolve_enable = False
        settings.max_iter = 100
        settings.max_threads = 1  # the programs are small; parallel work is for processes
        if tolerance is not None:
            settings.tol_gap_abs = settings.tol_gap_rel = settings.tol_feas = tolerance
        if reduced:
            settings.static_regularization_constant = 1e-7
            settings.reduced_tol_gap_abs = settings.reduced_tol_gap_rel = 1e-5
            settings.reduced_tol_feas = 1e-5
        cost = self.cost
        unit = float(np.max(np.abs(cost))) or 1.0
        result = clarabel.DefaultSolver(
            self._diagonal(unit),
            cost / unit,
            matrix,
            np.concatenate(self._rhs),
            [types[kind](size) for kind, size in self._cones if size],
            settings,
        ).solve()
        x, z = np.asarray(result.x), np.asarray(result.z) * unit
        status = str(result.status)
        finite = bool(np.all(np.isfinite(x)) and np.all(np.isfinite(z)))
        return ConeSolution(
            x=x,
            z=z,
            status=status,
            solved=finite and status in ("Solved", "AlmostSolved"),
            infeasible=status == "PrimalInfeasible" and bool(np.all(np.isfinite(z))),
            iterations=int(result.iterations),
            seconds=float(result.solve_time),
        )
