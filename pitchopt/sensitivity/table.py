"""Values of f, g and h over a table of dc as a model: nothing is evaluated.

For problems where an evaluation is a set of simulations.  Estimates exist at the dc of the table;
the derivative comes from the table too, by the prescribed step or from the two shortest steps of
the same direction, extrapolated: T = (k D(h) - D(k h)) / (k - 1) for steps h and k h, with
|T - D(h)| as its error.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike, NDArray

from pitchopt.checks import FloatArray, finite_number
from pitchopt.errors import InputError
from pitchopt.sensitivity.functions import Parts, parameter_array, sense_sign
from pitchopt.sensitivity.model import Counts, Gradients, Slope, Unmet, Values

__all__ = ["TableModel"]

SAME = 1e-9


class TableModel:
    """See `PostOptimum.from_table` for the parameters."""

    keeps_slopes = False

    def __init__(
        self,
        dcs: ArrayLike,
        f: ArrayLike,
        g: ArrayLike | None,
        h: ArrayLike | None,
        *,
        c: ArrayLike,
        sense: str,
        multipliers: ArrayLike | None,
        equality_multipliers: ArrayLike | None,
        names: str | Sequence[str] | None,
        equality_names: str | Sequence[str] | None,
        step: float | None,
    ) -> None:
        self.sense = sense_sign(sense)
        self.reference = parameter_array("c", c)
        steps = parameter_array("dcs", dcs)
        shape = (steps.shape[0] if steps.ndim else 0, *self.reference.shape)
        if steps.shape != shape:
            raise InputError(
                f"dcs: got shape {steps.shape}, expected (K, {', '.join(map(str, shape[1:]))}): K "
                "changes of c, one of them zero"
            )
        count = steps.shape[0]
        flat = steps.reshape(count, -1)
        zero = np.flatnonzero(~flat.any(axis=1))
        if zero.size != 1:
            raise InputError(f"dcs: got {zero.size} that are zero, expected one, the reference")
        self._steps, self._zero = flat, int(zero[0])
        values = parameter_array("f", f)
        if values.shape != (count,):
            raise InputError(f"f: got shape {values.shape}, expected ({count},) as dcs")
        lam = _rows("multipliers", multipliers, "g", g, count)
        nu = _rows("equality_multipliers", equality_multipliers, "h", h, count)
        parts = Parts(lam[0], nu[0], names, equality_names)
        self.layout, self.multipliers = parts.layout, parts.multipliers
        self._objective = self.sense * values
        self._entries = np.concatenate([np.zeros((count, 0)), lam[1], nu[1]], axis=1)
        self._step = None if step is None else finite_number("step", step, above=0.0)
        self.counts = Counts()

    @property
    def scale(self) -> None:
        """x is unknown."""
        return

    def values(self, c: NDArray[np.float64], move: FloatArray | None = None) -> Values:
        """Row of the table."""
        if move is not None:
            raise InputError("move: a table has no other x")
        i = self._find((c - self.reference).ravel())
        return Values(float(self._objective[i]), self._entries[i])

    def gradients(self, c: NDArray[np.float64]) -> Gradients | None:  # noqa: ARG002
        """None."""
        return None

    def tangent(self, vectors: FloatArray) -> FloatArray:
        """All steps are possible."""
        return vectors

    def slope(self, dc: NDArray[np.float64]) -> Slope:
        """Along dc, from the rows of the table in its direction."""
        length = float(np.linalg.norm(dc))
        if length == 0.0:
            return Slope(0.0, np.zeros(self.layout.size))
        along = self._steps @ (dc.ravel() / length)
        norms = np.linalg.norm(self._steps, axis=1)
        same = np.flatnonzero((norms > 0.0) & (norms - along <= SAME * norms))
        same = same[np.argsort(norms[same])]
        if self._step is not None:
            match = same[np.abs(norms[same] - self._step) <= 1e-6 * self._step]
            if match.size == 0:
                raise InputError(
                    f"step: {self._step:.6g} is not in the table in the direction of "
                    f"{dc.tolist()}, whose steps are {norms[same].round(9).tolist()}"
                )
            d = self._quotient(int(match[0]), float(norms[match[0]]))
            return Slope(float(d[0] * length), d[1:] * length, None, self._step)
        d = self._quotient(int(same[0]), float(norms[same[0]]))
        step = float(norms[same[0]])
        if same.size == 1:
            return Slope(float(d[0] * length), d[1:] * length, None, step)
        far = self._quotient(int(same[1]), float(norms[same[1]]))
        k = float(norms[same[1]]) / step
        value = (k * d - far) / (k - 1.0)
        weights = np.concatenate([[1.0], self.multipliers])
        error = float(np.sum(np.abs(weights * (value - d)))) * length
        return Slope(float(value[0] * length), value[1:] * length, error, step)

    def unmet(self, c: NDArray[np.float64], tolerance: float) -> Unmet | None:  # noqa: ARG002
        """Not judged."""
        return None

    def _find(self, dc: FloatArray) -> int:
        off = np.linalg.norm(self._steps - dc, axis=1)
        i = int(np.argmin(off))
        if off[i] > SAME * max(float(np.max(np.abs(self._steps))), 1e-300):
            known = self._steps[:, 0].tolist() if dc.size == 1 else f"{len(self._steps)} rows"
            raise InputError(
                f"dc: got {dc.tolist()}, which is not in the table ({known}); expected one that is"
            )
        return i

    def _quotient(self, i: int, step: float) -> FloatArray:
        f = self._objective[i] - self._objective[self._zero]
        r = self._entries[i] - self._entries[self._zero]
        return np.concatenate([[f], r]) / step


def _rows(
    name: str, multipliers: ArrayLike | None, key: str, values: ArrayLike | None, count: int
) -> tuple[FloatArray | None, FloatArray]:
    if (values is None) != (multipliers is None):
        raise InputError(f"{key}: expected the values and their multipliers, or neither")
    if values is None or multipliers is None:
        return None, np.zeros((count, 0))
    lam = np.atleast_1d(parameter_array(name, multipliers))
    table = parameter_array(key, values)
    if table.shape == (count,) and lam.size == 1:
        table = table[:, None]
    if lam.ndim != 1 or table.shape != (count, lam.size):
        raise InputError(
            f"{key}: got shape {table.shape}, expected ({count}, {lam.size}): a row for each dc, a "
            f"column for each of the {name}"
        )
    return lam, table
