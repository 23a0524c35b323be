"""What a row that carries a multiplier holds still.

By complementarity a multiplier keeps the entries of its row on a face of their cone.  For an
inequality that is its limit, for an equality its value.  A multiplier on the boundary of the dual
cone leaves a supporting plane, lambda . r = 0.  One inside the dual second-order cone holds all
entries at zero, the apex; a semidefinite one of rank k > 1 with range U holds U' A U = 0, which are
k (k + 1) / 2 numbers.  Rows of a face have both signs: nothing may move them, one way or the other.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from pitchopt.checks import FloatArray
from pitchopt.sensitivity.rows import Block, Layout

__all__ = ["Held", "held_sums"]

INSIDE = 1e-4


class Held:
    """Sums of entries that are held: weights (S, N), rows that they belong to, both-sided or not.

    Parameters
    ----------
    weights : (S, N) sparse array
    owner : (S,) ndarray
    both : (S,) ndarray of bool
        Whether the sum may leave its value neither upwards nor downwards.
    """

    def __init__(
        self, weights: sparse.csr_array, owner: NDArray[np.intp], both: NDArray[np.bool_]
    ) -> None:
        self.weights, self.owner, self.both = weights, owner, both

    def by_row(self, left_over: FloatArray, rows: int) -> FloatArray:
        """What is left of the sums as the excess of all rows (rows,); absolute where both-sided."""
        off = np.zeros(rows)
        one = ~self.both
        off[self.owner[one]] = left_over[one]
        np.maximum.at(off, self.owner[self.both], np.abs(left_over[self.both]))
        return off


def held_sums(layout: Layout, multipliers: FloatArray, carrying: NDArray[np.bool_]) -> Held:
    """What the carrying rows hold."""
    plain = np.flatnonzero(carrying & ~layout.conic)
    count = plain.size
    parts = [(np.ones(count), np.arange(count), layout.starts[plain])]
    owner: list[NDArray[np.intp]] = [plain]
    both: list[NDArray[np.bool_]] = [layout.equality[plain]]
    for row in np.flatnonzero(carrying & layout.conic):
        start, end = int(layout.starts[row]), int(layout.starts[row + 1])
        block = layout.blocks[int(layout.block_of[row])]
        face, two_sided = _face(block, multipliers[start:end])
        k, width = face.shape
        columns = np.tile(np.arange(start, end), k)
        parts.append((face.ravel(), count + np.repeat(np.arange(k), width), columns))
        owner.append(np.full(k, row))
        both.append(np.full(k, two_sided))
        count += k
    data, at, columns = (np.concatenate([part[i] for part in parts]) for i in range(3))
    weights = sparse.csr_array((data, (at, columns)), shape=(count, layout.size))
    return Held(weights, np.concatenate(owner), np.concatenate(both))


def _face(block: Block, lam: FloatArray) -> tuple[FloatArray, bool]:
    plane = (lam / block.multiplier(lam[None, :])[0])[None, :]
    if block.kind == "second-order":
        inside = lam[0] - np.linalg.norm(lam[1:]) > INSIDE * lam[0]
        return (np.eye(lam.size), True) if inside else (plane, False)
    if block.kind == "semidefinite":
        side = round(np.sqrt(lam.size))
        matrix = lam.reshape(side, side)
        w, v = np.linalg.eigh(0.5 * (matrix + matrix.T))
        u = v[:, w > INSIDE * w[-1]]
        if u.shape[1] > 1:
            pairs = [
                0.5 * (np.outer(u[:, i], u[:, j]) + np.outer(u[:, j], u[:, i])).ravel()
                for i in range(u.shape[1])
                for j in range(i + 1)
            ]
            return np.array(pairs), True
    return plane, False
