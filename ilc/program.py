"""StepProgram: the change of profile in one passage, a quadratic program with actuator limits.

    minimise    1/2 x'H x + g'x
    subject to  low <= beta + x <= high,    |(beta + x)_{n+1} - (beta + x)_n| <= D  (cyclic)

H is a block of B x B for every tracked position and a few squares s u u', s = +1 or -1: those of
means, which are held or free.  Only neighbouring stations are tied by the rate, so with the
positions folded (first, last, second, last but one, ...) everything but the squares lies in a band
of 3 B - 1 subdiagonals, and one iteration of the interior-point method (Mehrotra's predictor and
corrector) costs a time in proportion to the number of stations.  With a basis, x = F c, the few
coefficients c are the unknowns and the matrices are dense and small.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cached_property
from typing import NamedTuple

import numpy as np
from scipy.linalg import LinAlgError, cho_factor, cho_solve, cho_solve_banded, cholesky_banded

from ilc._checks import FloatArray, IntArray
from ilc.layout import Layout

__all__ = ["Quadratic", "StepProgram"]

Solver = Callable[[FloatArray], FloatArray]
"""From a right-hand side (V,) or (V, L) to the solution."""

_ITERATIONS = 40
_TOLERANCE = 1e-9  # of gap and residuals, relative
_RIDGE = 1e-10  # of the largest curvature
_TO_BOUNDARY = 0.995


class Quadratic(NamedTuple):
    """1/2 x'H x + g'x with H = blocks + sum of signed squares.

    Attributes
    ----------
    blocks : ndarray (P, B, B)
        Symmetric, for the pitches at each tracked position.
    squares : ndarray (L, P, B)
        Rows u of the squares s u u'; H as a whole has no negative curvature.
    signs : ndarray (L,)
        s, +1 or -1.
    slope : ndarray (P, B)
        g.
    """

    blocks: FloatArray
    squares: FloatArray
    signs: FloatArray
    slope: FloatArray


class _Point(NamedTuple):
    """Iterate: unknowns, slacks and multipliers of the four kinds of limits (4, V)."""

    x: FloatArray
    slack: FloatArray
    dual: FloatArray


class StepProgram:
    """The program for one layout and one rate limit.

    Parameters
    ----------
    layout : Layout
    step : float
        D, largest change of pitch between neighbouring stations [rad].
    basis : ndarray (V, K), optional
        Independent columns; changes are combinations of them.
    """

    def __init__(self, layout: Layout, step: float, basis: FloatArray | None = None) -> None:
        self.layout = layout
        self.step = step
        self.basis = basis

    # ---- matrices ------------------------------------------------------------------------

    @cached_property
    def _place(self) -> IntArray:
        """Place of every variable in the folded order, (V,)."""
        layout = self.layout
        fold = np.empty(layout.tracked, dtype=np.intp)
        half = (layout.tracked + 1) // 2
        fold[0::2], fold[1::2] = np.arange(half), np.arange(layout.tracked - 1, half - 1, -1)
        place = np.empty(layout.variables, dtype=np.intp)
        place[layout.index[fold].ravel()] = np.arange(layout.variables)
        return place

    @cached_property
    def _band(self) -> tuple[int, IntArray, IntArray, IntArray, IntArray]:
        """Width of the band, and where blocks and ties go in it."""
        index, place = self.layout.index, self._place
        blades = self.layout.blades
        row, column = np.tril_indices(blades)
        first = place[index[:, row]]
        second = place[index[:, column]]
        tied = place[self.layout.ahead]
        low, high = np.minimum(place, tied), np.maximum(place, tied)
        width = int(max((high - low).max(), blades - 1))
        size = place.size
        inside = ((first - second) * size + second).ravel()
        across = (high - low) * size + low
        return width, row, column, inside, across

    def _factor(self, blocks: FloatArray, box: FloatArray, tie: FloatArray) -> Solver:
        """Solver of (blocks + diag(box) + sum of tie (x_next - x)^2) y = r."""
        if self.basis is not None:
            basis, along = self.basis, self._basis_ahead
            at = basis[self.layout.index]
            dense = np.einsum("pbi,pbc,pcj->ij", at, blocks, at, optimize=True)
            dense += (basis.T * box) @ basis + (along.T * tie) @ along
            factor = cho_factor(dense, lower=True)
            return lambda right: np.asarray(cho_solve(factor, right))
        width, row, column, inside, across = self._band
        size = self._place.size
        band = np.zeros((width + 1) * size)
        np.add.at(band, inside, blocks[:, row, column].ravel())
        np.add.at(band, self._place, box + tie)
        np.add.at(band, self._place[self.layout.ahead], tie)
        np.add.at(band, across, -tie)
        banded = cholesky_banded(
            band.reshape(width + 1, size), lower=True, overwrite_ab=True, check_finite=False
        )

        def solve(right: FloatArray) -> FloatArray:
            sorted_right = np.empty_like(right)
            sorted_right[self._place] = right
            return np.asarray(
                cho_solve_banded((banded, True), sorted_right, check_finite=False)[self._place]
            )

        return solve

    @cached_property
    def _basis_ahead(self) -> FloatArray:
        assert self.basis is not None  # asked for only with a basis
        return np.asarray(self.basis[self.layout.ahead] - self.basis)

    def _spread(self, x: FloatArray) -> FloatArray:
        """Changes of pitch (V,) from the unknowns."""
        return x if self.basis is None else np.asarray(self.basis @ x)

    def _gather(self, values: FloatArray) -> FloatArray:
        """The transpose of :meth:`_spread`, (V, ...)."""
        return values if self.basis is None else np.asarray(self.basis.T @ values)

    def _limits_of(self, x: FloatArray) -> FloatArray:
        """G x for the four kinds of limits, (4, V)."""
        change = self._spread(x)
        ahead = change[self.layout.ahead] - change
        return np.stack([change, -change, ahead, -ahead])

    def _limits_transposed(self, dual: FloatArray) -> FloatArray:
        """G'z of multipliers (4, V)."""
        tie = dual[2] - dual[3]
        out = dual[0] - dual[1] - tie
        np.add.at(out, self.layout.ahead, tie)
        return self._gather(out)

    # ---- solution ------------------------------------------------------------------------

    def solve(
        self, quadratic: Quadratic, current: FloatArray, low: FloatArray, high: FloatArray
    ) -> FloatArray:
        """The best change of profile.

        Parameters
        ----------
        quadratic : Quadratic
        current : ndarray (V,)
            Profile in use; it keeps the limits.
        low, high : ndarray (V,)
            Limits of the new profile [rad].

        Returns
        -------
        ndarray (V,)
            Change x; keeps the limits to the tolerance of the method.
        """
        layout = self.layout
        blocks, squares, signs, slope = quadratic
        scale = float(np.abs(slope).max())
        reach = float(np.max(high - low))
        if scale == 0.0 or reach <= 0.0:
            return np.zeros(layout.variables)  # nothing to gain, or nowhere to go
        # unknowns in units of `reach`, objective in units of scale x reach
        blocks = blocks * (reach / scale)
        ridge = _RIDGE * float(np.abs(blocks).max() or 1.0)
        blocks = blocks + ridge * np.eye(layout.blades)
        wide = self._gather(self._flat(squares * np.sqrt(reach / scale)).T)
        linear = self._gather(self._flat(slope[None] / scale)[0])
        ahead = current[self.layout.ahead] - current
        room = np.stack([high - current, current - low, self.step - ahead, self.step + ahead])
        room = np.maximum(room, 0.0) / reach

        def curved(x: FloatArray) -> FloatArray:
            change = self._spread(x)[layout.index]
            flat = np.empty(layout.variables)
            flat[layout.index] = np.einsum("pbc,pc->pb", blocks, change)
            return np.asarray(self._gather(flat) + (wide * signs) @ (wide.T @ x))

        unknowns = layout.variables if self.basis is None else self.basis.shape[1]
        point = _Point(np.zeros(unknowns), np.maximum(room, 1e-2), np.full(room.shape, 1e-1))
        for _ in range(_ITERATIONS):
            x, slack, dual = point
            dual_residual = curved(x) + linear + self._limits_transposed(dual)
            primal_residual = self._limits_of(x) + slack - room
            gap = float(np.vdot(slack, dual)) / slack.size
            worst = max(float(np.abs(dual_residual).max()), float(np.abs(primal_residual).max()))
            if gap < _TOLERANCE and worst < _TOLERANCE:
                break
            weight = dual / slack
            try:
                factor = self._factor(blocks, weight[0] + weight[1], weight[2] + weight[3])
            except LinAlgError:
                break  # as near to the limits as rounding admits
            solve = self._with_squares(factor, wide, signs)

            def direction(
                complement: FloatArray,
                *,
                solve: Solver = solve,
                weight: FloatArray = weight,
                slack: FloatArray = slack,
                dual_residual: FloatArray = dual_residual,
                primal_residual: FloatArray = primal_residual,
            ) -> _Point:
                """Newton step towards slack x dual = -complement + slack x dual."""
                push = weight * primal_residual - complement / slack
                dx = solve(-dual_residual - self._limits_transposed(push))
                ds = -primal_residual - self._limits_of(dx)
                return _Point(dx, ds, -(complement / slack) - weight * ds)

            affine = direction(slack * dual)
            reached = [_longest(slack, affine.slack), _longest(dual, affine.dual)]
            after = (
                float(np.vdot(slack + reached[0] * affine.slack, dual + reached[1] * affine.dual))
                / slack.size
            )
            centre = gap * (after / gap) ** 3
            step = direction(slack * dual + affine.slack * affine.dual - centre)
            length = min(
                1.0,
                _TO_BOUNDARY * min(_longest(slack, step.slack), _longest(dual, step.dual)),
            )
            point = _Point(*(old + length * new for old, new in zip(point, step, strict=True)))
        return self._spread(point.x) * reach

    def _flat(self, values: FloatArray) -> FloatArray:
        """Rows (L, P, B) in the order of the variables, (L, V)."""
        out = np.empty((values.shape[0], self.layout.variables))
        out[:, self.layout.index] = values
        return out

    @staticmethod
    def _with_squares(solve: Solver, wide: FloatArray, signs: FloatArray) -> Solver:
        """Solver with the signed squares added, by the Sherman-Morrison-Woodbury formula."""
        if wide.shape[1] == 0:
            return solve
        through = solve(wide)
        small = np.diag(signs) + wide.T @ through

        def solve_all(right: FloatArray) -> FloatArray:
            plain = solve(right)
            return np.asarray(plain - through @ np.linalg.solve(small, wide.T @ plain))

        return solve_all


def _longest(values: FloatArray, change: FloatArray) -> float:
    """Longest step that keeps positive values positive, at most about 1."""
    falling = change < 0
    if not falling.any():
        return 1.0 / _TO_BOUNDARY
    return float(min(1.0 / _TO_BOUNDARY, np.min(-values[falling] / change[falling])))
