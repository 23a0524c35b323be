"""Correlated noise at the points of a grid whose symmetry splits the correlation matrix.

Wanted are Gaussian vectors x (one value a grid point) with E[x x^T] = C, C_ij = c(d_ij) a
function of the distance alone, for many functions c at once (one for each frequency). With any
factor C = F F^T and white noise e, x = F e (P. S. Veers). C commutes with the symmetries of the
grid, so an orthonormal basis Q of functions that each symmetry maps to themselves or their
negatives, or that it turns, makes it block diagonal:

    C = Q diag(B_1, B_2, ...) Q^T,      x = Q (L_1 e_1, L_2 e_2, ...),      B_b = L_b L_b^T.

Cartesian grid: even and odd functions in y and in z, four blocks of a quarter of the points.
Polar grid: harmonics in azimuth, a block of one value a ring for each; the centre belongs to
harmonic 0. The factors are exact, of Cholesky, batched over c.

Reference: P. S. Veers, Three-Dimensional Wind Simulation, SAND88-0152, Sandia, 1988.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from windfield._checks import FloatArray

__all__ = ["CartesianNoise", "Correlation", "GridNoise", "PolarNoise"]

# distances (n,) [m] -> correlations (K, n) [-] of the K functions c
Correlation = Callable[[FloatArray], FloatArray]


class GridNoise(Protocol):
    """Grid of `points` distinct points, the closest two `nearest` [m] apart, to put noise on."""

    points: int
    nearest: float

    def correlate(self, correlation: Correlation, white: FloatArray) -> FloatArray:
        """White noise (K, points, M) to noise that is correlated over the points."""
        ...  # pragma: no cover

    def on_grid(self, values: NDArray[Any]) -> NDArray[Any]:
        """Values (K, points, M) at distinct points to the grid (K, n1, n2, M)."""
        ...  # pragma: no cover


class CartesianNoise:
    """Grid of n_y x n_z points, `step_y` and `step_z` apart [m]; points in C order."""

    def __init__(self, count: tuple[int, int], step: tuple[float, float]) -> None:
        self.points = count[0] * count[1]
        self.nearest = min(step)
        self.count = count
        self._basis = tuple(_parity_basis(n) for n in count)
        reps = [np.arange((n + 1) // 2) for n in count]
        self._distance = np.hypot(
            (np.arange(count[0]) * step[0])[:, None], np.arange(count[1]) * step[1]
        ).ravel()
        # images[s][t]: entry of the distances between a point and another one's mirror image
        y0, z0 = (grid.ravel() for grid in np.meshgrid(*reps, indexing="ij"))
        offsets_y = [_offset(y0, y0), _offset(y0, count[0] - 1 - y0)]
        offsets_z = [_offset(z0, z0), _offset(z0, count[1] - 1 - z0)]
        self._images = [[a * count[1] + b for b in offsets_z] for a in offsets_y]
        middle = [
            np.where(2 * v == n - 1, np.sqrt(0.5), 1.0)
            for v, n in zip((y0, z0), count, strict=True)
        ]
        self._norm = middle[0] * middle[1]
        self._blocks = []
        for odd_y in (0, 1):
            for odd_z in (0, 1):
                keep = (2 * y0 + odd_y < count[0]) & (2 * z0 + odd_z < count[1])
                rows = np.flatnonzero(keep)
                if rows.size:
                    column_y = y0[rows] + odd_y * reps[0].size
                    column_z = z0[rows] + odd_z * reps[1].size
                    place = column_y * count[1] + column_z
                    self._blocks.append(((-1.0) ** odd_y, (-1.0) ** odd_z, rows, place))

    def correlate(self, correlation: Correlation, white: FloatArray) -> FloatArray:
        """See `GridNoise`."""
        table = correlation(self._distance)
        (same, flip_z), (flip_y, both) = (
            [np.take(table, index, axis=1) for index in row] for row in self._images
        )
        scale = np.multiply.outer(self._norm, self._norm)
        out = np.empty_like(white)
        for p, q, rows, place in self._blocks:
            block = scale * (same + p * flip_y + q * (flip_z + p * both))
            if rows.size < scale.shape[0]:
                block = block[:, rows[:, None], rows]
            out[:, place] = np.linalg.cholesky(block) @ white[:, place]
        count, columns = white.shape[0], white.shape[2]
        ny, nz = self.count
        inner = self._basis[1] @ out.reshape(count, ny, nz, columns)
        outer = self._basis[0] @ inner.reshape(count, ny, nz * columns)
        return np.asarray(outer.reshape(white.shape))

    def on_grid(self, values: NDArray[Any]) -> NDArray[Any]:
        """See `GridNoise`."""
        return values.reshape(values.shape[0], *self.count, values.shape[2])


class PolarNoise:
    """Rings at `radius` (n,) [m], the first one 0, with `spokes` points each; centre first."""

    def __init__(self, radius: FloatArray, spokes: int) -> None:
        self._rings, self.spokes = radius.size, spokes
        self.points = 1 + (radius.size - 1) * spokes
        self.radius = radius
        outer = radius[1:]
        angle = np.arange(spokes) * (2.0 * np.pi / spokes)
        square = (outer[:, None] ** 2 + outer**2)[..., None] - 2.0 * (outer[:, None] * outer)[
            ..., None
        ] * np.cos(angle)
        self._distance = np.concatenate([outer, np.sqrt(np.maximum(square, 0.0)).ravel()])
        self.nearest = float(outer[0] * min(1.0, 2.0 * np.sin(np.pi / spokes)))
        self._basis = _harmonic_basis(spokes)
        harmonics = np.concatenate([[0], np.repeat(np.arange(1, spokes), 2)])[:spokes]
        self._harmonic = harmonics
        self._cosines = np.cos(np.outer(np.arange(spokes // 2 + 1), angle))

    def correlate(self, correlation: Correlation, white: FloatArray) -> FloatArray:
        """See `GridNoise`."""
        count, columns = white.shape[0], white.shape[2]
        outer, spokes = self._rings - 1, self.spokes
        table = correlation(self._distance)
        to_centre = table[:, :outer] * np.sqrt(spokes)
        around = table[:, outer:].reshape(count, outer, outer, spokes)
        blocks = np.moveaxis(around @ self._cosines.T, -1, 0)
        # coefficients: the centre, then harmonic by harmonic the rings
        rings = white[:, 1:].reshape(count, spokes, outer, columns)
        out = np.empty((count, spokes, outer, columns))
        mean = np.empty((count, outer + 1, outer + 1))
        mean[:, 0, 0] = 1.0
        mean[:, 0, 1:] = mean[:, 1:, 0] = to_centre
        mean[:, 1:, 1:] = blocks[0]
        first = np.linalg.cholesky(mean) @ np.concatenate([white[:, :1], rings[:, 0]], axis=1)
        out[:, 0] = first[:, 1:]
        for m in range(1, spokes // 2 + 1):
            factor = np.linalg.cholesky(blocks[m])
            for k in np.flatnonzero(self._harmonic == m):
                out[:, k] = factor @ rings[:, k]
        values = np.empty_like(white)
        values[:, 0] = first[:, 0]
        spread = self._basis @ out.reshape(count, spokes, outer * columns)
        values[:, 1:] = spread.reshape(count, spokes * outer, columns)
        return values

    def on_grid(self, values: NDArray[Any]) -> NDArray[Any]:
        """See `GridNoise`."""
        count, columns = values.shape[0], values.shape[2]
        grid = np.empty((count, self._rings, self.spokes, columns), dtype=values.dtype)
        grid[:, 0] = values[:, :1]
        rings = values[:, 1:].reshape(count, self.spokes, self._rings - 1, columns)
        grid[:, 1:] = rings.swapaxes(1, 2)
        return grid


def _offset(a: NDArray[np.intp], b: NDArray[np.intp]) -> NDArray[np.intp]:
    return np.asarray(np.abs(a[:, None] - b))


def _parity_basis(count: int) -> FloatArray:
    """Orthonormal columns on `count` points: even functions, then odd ones."""
    half = (count + 1) // 2
    basis = np.zeros((count, count))
    for a in range(half):
        mirror = count - 1 - a
        if a == mirror:
            basis[a, a] = 1.0
            continue
        basis[[a, mirror], a] = np.sqrt(0.5)
        basis[a, half + a], basis[mirror, half + a] = np.sqrt(0.5), -np.sqrt(0.5)
    return basis


def _harmonic_basis(count: int) -> FloatArray:
    """Orthonormal columns 1, cos, sin, cos 2, sin 2, ... on `count` points of a circle."""
    angle = np.arange(count) * (2.0 * np.pi / count)
    columns = [np.full(count, np.sqrt(1.0 / count))]
    for m in range(1, (count - 1) // 2 + 1):
        columns += [
            np.sqrt(2.0 / count) * np.cos(m * angle),
            np.sqrt(2.0 / count) * np.sin(m * angle),
        ]
    if count % 2 == 0:
        columns.append(np.sqrt(1.0 / count) * np.cos(np.pi * np.arange(count)))
    return np.column_stack(columns)
