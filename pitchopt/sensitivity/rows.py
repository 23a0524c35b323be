"""Constraints as one vector of entries, in rows, in blocks.

A solved problem is kept as a minimisation of F with a Lagrangian that is linear in a vector of
entries r (N,),

    L(x, c, lambda) = F(x, c) + lambda . r(x, c).

An inequality has one entry a row, r = g <= 0 with lambda >= 0; an equality one entry of any sign.
A row of a cone K holds several entries, r = -a where a in K is asked for, and lambda in the dual
cone.  A block is what the user named: one constraint with all its rows.

What says whether a row holds is its excess e, at most zero where it does,

    inequality r,   equality |r|,   second-order ||X|| - t,   positive semidefinite -lambda_min(A),
    exponential y exp(x / y) - z,   power |z| - prod w_i^alpha_i.

One number stands for the multiplier of a row: lambda itself, that of t, the trace, or the norm for
the exponential and power cones.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from pitchopt.checks import FloatArray

__all__ = ["Block", "Kind", "Layout"]

Kind = Literal["inequality", "equality", "second-order", "semidefinite", "exponential", "power"]


@dataclass(frozen=True, kw_only=True)
class Block:
    """Rows of one kind under one name.

    Attributes
    ----------
    name : str
    kind : Kind
    rows : int
    width : int
        Entries of a row.
    shape : tuple of int
        That rows are numbered by, in Fortran order; () for a single row without number.
    names : tuple of str or None
        Of the rows, where each has its own.
    powers : (rows, width - 1) ndarray or None
        Exponents alpha of power cones.
    """

    name: str
    kind: Kind
    rows: int
    width: int = 1
    shape: tuple[int, ...] = ()
    names: tuple[str, ...] | None = None
    powers: FloatArray | None = None

    @property
    def size(self) -> int:
        """Entries."""
        return self.rows * self.width

    def row_name(self, row: int) -> str:
        """Such as ``cap[3]``."""
        if self.names is not None:
            return self.names[row]
        if self.shape == ():
            return self.name
        index = np.unravel_index(row, self.shape, order="F")
        return f"{self.name}[{', '.join(str(int(i)) for i in index)}]"

    def excess(self, entries: FloatArray) -> FloatArray:
        """What each row is above its limit (rows,), of entries (rows, width)."""
        if self.kind == "inequality":
            return entries[:, 0]
        if self.kind == "equality":
            return np.abs(entries[:, 0])
        if self.kind == "second-order":
            return np.asarray(np.linalg.norm(entries[:, 1:], axis=1) + entries[:, 0])
        if self.kind == "semidefinite":
            side = round(np.sqrt(self.width))
            matrices = entries.reshape(self.rows, side, side)
            return np.asarray(np.linalg.eigvalsh(0.5 * (matrices + matrices.swapaxes(1, 2)))[:, -1])
        if self.kind == "exponential":
            return _exponential_excess(-entries)
        return self._power_excess(-entries)

    def _power_excess(self, a: FloatArray) -> FloatArray:
        w, z = a[:, :-1], a[:, -1]
        powers = self.powers if self.powers is not None else np.ones_like(w)
        mean: FloatArray = np.prod(np.maximum(w, 0.0) ** powers, axis=1)
        below = np.max(-w, axis=1)
        return np.asarray(np.maximum(np.abs(z) - mean, np.where(below > 0.0, below, -np.inf)))

    def multiplier(self, entries: FloatArray) -> FloatArray:
        """Number that stands for the multiplier of each row (rows,), of entries (rows, width)."""
        if self.width == 1 or self.kind == "second-order":
            return entries[:, 0]
        if self.kind == "semidefinite":
            side = round(np.sqrt(self.width))
            return np.asarray(np.trace(entries.reshape(-1, side, side), axis1=1, axis2=2))
        return np.asarray(np.linalg.norm(entries, axis=1))

    def bent(self, multipliers: FloatArray, entries: FloatArray) -> float:
        """What cones add to L of the same rows written as excess <= 0: w e(r) - lambda . r >= 0.

        w is the multiplier of such a row; e is convex and lambda / w its gradient at the optimum.
        """
        if self.width == 1:
            return 0.0
        if self.kind == "exponential":
            weight = np.maximum(multipliers[:, 2], 0.0)
        elif self.kind == "power":
            weight = np.abs(multipliers[:, -1])
        else:
            weight = np.maximum(self.multiplier(multipliers), 0.0)
        above = weight * self.excess(entries) - np.sum(multipliers * entries, axis=1)
        return float(np.sum(np.maximum(above, 0.0)))


def _exponential_excess(a: FloatArray) -> FloatArray:
    x, y, z = a.T
    with np.errstate(all="ignore"):
        inside = np.exp(np.minimum(x / np.where(y > 0.0, y, 1.0), 700.0)) * y - z
    # on the face y = 0 the cone is x <= 0, z >= 0
    outside = np.maximum.reduce([-y, x, -z])
    return np.asarray(np.where(y > 0.0, inside, outside))


@dataclass(frozen=True)
class Layout:
    """Blocks one after the other: N entries, M rows.

    Attributes
    ----------
    blocks : tuple of Block
    """

    blocks: tuple[Block, ...]

    @cached_property
    def size(self) -> int:
        """N, entries of all blocks."""
        return sum(block.size for block in self.blocks)

    @cached_property
    def rows(self) -> int:
        """M, rows of all blocks."""
        return sum(block.rows for block in self.blocks)

    @cached_property
    def starts(self) -> NDArray[np.intp]:
        """First entry of each row and N, (M + 1,)."""
        widths = [np.full(block.rows, block.width) for block in self.blocks]
        return np.concatenate([[0], np.cumsum(np.concatenate([[], *widths]))]).astype(np.intp)

    @cached_property
    def row_of(self) -> NDArray[np.intp]:
        """Row of each entry (N,)."""
        return np.repeat(np.arange(self.rows), np.diff(self.starts))

    @cached_property
    def block_of(self) -> NDArray[np.intp]:
        """Block of each row (M,)."""
        return np.repeat(np.arange(len(self.blocks)), [block.rows for block in self.blocks])

    @cached_property
    def first_rows(self) -> NDArray[np.intp]:
        """First row of each block and M."""
        return np.concatenate([[0], np.cumsum([b.rows for b in self.blocks])]).astype(np.intp)

    @cached_property
    def equality(self) -> NDArray[np.bool_]:
        """Whether a row is an equality (M,)."""
        kinds = np.array([block.kind == "equality" for block in self.blocks], dtype=bool)
        return kinds[self.block_of] if self.blocks else np.zeros(0, dtype=bool)

    @cached_property
    def conic(self) -> NDArray[np.bool_]:
        """Whether a row holds several entries (M,)."""
        wide = np.array(
            [block.kind not in ("equality", "inequality") for block in self.blocks], dtype=bool
        )
        return wide[self.block_of] if self.blocks else np.zeros(0, dtype=bool)

    def name(self, row: int) -> str:
        """Name of a row, counted over all blocks."""
        block = int(self.block_of[row])
        return self.blocks[block].row_name(row - int(self.first_rows[block]))

    def sums(self, entries: FloatArray) -> FloatArray:
        """Sum of the entries of each row (M,)."""
        total = np.bincount(self.row_of, weights=entries, minlength=self.rows)
        return np.asarray(total, dtype=np.float64)

    def excess(self, entries: FloatArray) -> FloatArray:
        """What each row is above its limit (M,), of all entries (N,)."""
        return self._by_block("excess", entries)

    def multiplier(self, entries: FloatArray) -> FloatArray:
        """One number for the multiplier of each row (M,), of all multipliers (N,)."""
        return self._by_block("multiplier", entries)

    def bent(self, multipliers: FloatArray, entries: FloatArray) -> float:
        """What cones add to L of the same rows written as excess <= 0, of all entries (N,)."""
        total, start = 0.0, 0
        for block in self.blocks:
            part = slice(start, start + block.size)
            shape = (block.rows, block.width)
            total += block.bent(multipliers[part].reshape(shape), entries[part].reshape(shape))
            start += block.size
        return total

    def _by_block(self, method: Literal["excess", "multiplier"], entries: FloatArray) -> FloatArray:
        parts: list[FloatArray] = []
        start = 0
        for block in self.blocks:
            part = entries[start : start + block.size].reshape(block.rows, block.width)
            parts.append(block.excess(part) if method == "excess" else block.multiplier(part))
            start += block.size
        return np.concatenate(parts) if parts else np.zeros(0)


def listed(names: Sequence[str], most: int = 3) -> str:
    """Names in a row of text, the first few of them."""
    text = ", ".join(names[:most])
    return text if len(names) <= most else f"{text} and {len(names) - most} more"
