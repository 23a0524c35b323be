"""Sums of piecewise-linear functions at all their breakpoints."""

from __future__ import annotations

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from pitchopt.aero.breakpoints import MERGE, accumulate, pad_rows, thin


@given(st.integers(0, 2**32 - 1), st.integers(0, 12), st.integers(1, 4))
def test_accumulate_equals_evaluation(seed: int, count: int, rows: int) -> None:
    rng = np.random.default_rng(seed)
    knots = rng.normal(size=(rows, count))
    changes = rng.normal(size=(2, rows, count))
    slope = rng.normal(size=(2, rows))
    low, high = np.full(rows, -1.0), np.full(rows, 0.7)

    def exact(x: np.ndarray) -> np.ndarray:
        bends = np.maximum(x[:, :, None] - knots[:, None, :], 0.0)
        return np.asarray(slope[..., None] * x + np.einsum("lnp,nkp->lnk", changes, bends))

    start = exact(low[:, None])[..., 0]
    points, values = accumulate(start, slope, knots, changes, low, high)
    np.testing.assert_allclose(values, exact(points), atol=1e-12)
    assert np.all(np.diff(points, axis=1) >= 0.0)
    keep = thin(points)
    beta, loads = pad_rows(points, values, keep)
    assert np.all(np.diff(beta, axis=1) > 0.0)
    assert beta[:, 0].tolist() == low.tolist()
    assert beta[:, -1].tolist() == high.tolist()
    x = rng.uniform(-1.0, 0.7, size=(rows, 5))
    for load in range(2):
        for n in range(rows):
            got = np.interp(x[n], beta[n], loads[load, n])
            np.testing.assert_allclose(got, exact(x)[load, n], atol=1e-6)


def test_close_points_are_merged() -> None:
    points = np.array([[0.0, 0.4 * MERGE, 0.8 * MERGE, 1.2 * MERGE, 0.5, 1.0 - 0.1 * MERGE, 1.0]])
    assert thin(points).tolist() == [[True, False, False, True, True, False, True]]


def test_padding_splits_the_widest_interval() -> None:
    points = np.array([[0.0, 1.0, 4.0, 4.0], [0.0, 1.0, 2.0, 3.0]])
    values = np.stack([points**2])
    keep = np.array([[True, True, True, False], [True] * 4])
    beta, loads = pad_rows(points, values, keep)
    assert beta[0].tolist() == [0.0, 1.0, 2.5, 4.0]
    assert loads[0, 0].tolist() == [0.0, 1.0, 8.5, 16.0]
