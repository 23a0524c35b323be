"""Piecewise-linear functions summed over elements: exact breakpoints of each row.

An element's load is linear between the pitch angles at which its angle of attack passes a knot
of its polar.  The sum over the elements is therefore linear between the union of those angles.
Sorting them and adding up the slope changes gives the sum at every breakpoint in
O(K log K) per row instead of K times the number of elements.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from pitchopt.aero.tables import pad_row
from pitchopt.checks import FloatArray

__all__ = ["MERGE", "accumulate", "pad_rows", "sample_points", "thin"]

MERGE = 1e-8
"""Breakpoints closer than this are merged [rad]."""


def accumulate(
    start: FloatArray,
    slope: FloatArray,
    knots: FloatArray,
    changes: FloatArray,
    low: FloatArray,
    high: FloatArray,
) -> tuple[FloatArray, FloatArray]:
    """Values of piecewise-linear functions at all their breakpoints.

    Parameters
    ----------
    start : ndarray (L, N)
        Values at `low`.
    slope : ndarray (L, N)
        Slopes far below every knot.
    knots : ndarray (N, P)
        Where slopes change, in any order.
    changes : ndarray (L, N, P)
        By how much.
    low, high : ndarray (N,)
        Interval of interest; knots outside are moved to its ends.

    Returns
    -------
    points : ndarray (N, P + 2)
        Both ends and the knots, not decreasing.
    values : ndarray (L, N, P + 2)
    """
    clipped = np.clip(knots, low[:, None], high[:, None])
    order = np.argsort(clipped, axis=1, kind="stable")
    points = np.concatenate(
        [low[:, None], np.take_along_axis(clipped, order, axis=1), high[:, None]], axis=1
    )
    steps = np.diff(points, axis=1)
    values = np.empty((start.shape[0], *points.shape))
    for load in range(start.shape[0]):
        slopes = np.empty_like(steps)
        slopes[:, 0] = slope[load]
        slopes[:, 1:] = np.take_along_axis(changes[load], order, axis=1)
        np.cumsum(slopes, axis=1, out=slopes)
        slopes *= steps
        values[load, :, 0] = start[load]
        np.cumsum(slopes, axis=1, out=slopes)
        values[load, :, 1:] = start[load][:, None] + slopes
    return points, values


def thin(points: FloatArray, tolerance: float = MERGE) -> NDArray[np.bool_]:
    """Mask (N, K) of sorted points to keep: both ends, and inner ones `tolerance` apart."""
    low, high = points[:, :1], points[:, -1:]
    keep = (points > low + tolerance) & (points < high - tolerance)
    # one point per cell of width `tolerance` removes equal points at once
    cell = np.floor((points - low) / tolerance)
    keep[:, 1:] &= cell[:, 1:] != cell[:, :-1]
    keep[:, 0] = True
    order = np.arange(points.shape[1])
    while True:
        # points too close to the one kept before them, unless that one is about to go itself
        last = np.maximum.accumulate(np.where(keep, order, 0), axis=1)
        before = np.concatenate([np.zeros_like(last[:, :1]), last[:, :-1]], axis=1)
        gap = points - np.take_along_axis(points, before, axis=1)
        close = keep & (gap < tolerance)
        close[:, 0] = False
        drop = close & ~np.take_along_axis(close, before, axis=1)
        if not np.any(drop):
            break
        keep &= ~drop
    keep[:, -1] = True
    return keep


def pad_rows(
    points: FloatArray, values: FloatArray, keep: NDArray[np.bool_]
) -> tuple[FloatArray, FloatArray]:
    """Drop what is not kept and split the widest intervals until all rows are equally long.

    Splitting an interval of a piecewise-linear function changes no value of it.

    Parameters
    ----------
    points : ndarray (N, P)
    values : ndarray (L, N, P)
    keep : ndarray (N, P) of bool

    Returns
    -------
    points : ndarray (N, K)
    values : ndarray (L, N, K)
    """
    count = keep.sum(axis=1)
    width = int(count.max())
    loads, rows = values.shape[0], points.shape[0]
    out_points = np.empty((rows, width))
    out_values = np.empty((loads, rows, width))
    for n in range(rows):
        row = points[n, keep[n]]
        new = pad_row(row, width)
        out_points[n] = new
        for load in range(loads):
            table = values[load, n, keep[n]]
            out_values[load, n] = table if new is row else np.interp(new, row, table)
    return out_points, out_values


def sample_points(
    low: FloatArray, high: FloatArray, centre: float | None, count: int
) -> FloatArray:
    """Pitches at which curves without exact breakpoints are sampled.

    Parameters
    ----------
    low, high : ndarray (N,)
        Interval of each row [rad]; both ends are samples.
    centre : float, optional
        Where samples are to be dense [rad]; a sample itself where a row's interval holds it.
    count : int
        Samples per row without a centre; else samples within 9 degrees of it, followed by
        others 0.375 and then 2 degrees apart.

    Returns
    -------
    ndarray (N, K)
        Increasing rows; shorter ones are filled up by halving the widest intervals.
    """
    if centre is None:
        share = np.linspace(0.0, 1.0, count)
        return np.asarray(low[:, None] * (1.0 - share) + high[:, None] * share)
    half = max(count // 2, 1)
    offsets = np.concatenate(
        [
            np.deg2rad(9.0) * np.arange(1, half + 1) / half,
            np.deg2rad(np.arange(9.375, 20.1, 0.375)),
            np.deg2rad(np.arange(22.0, 180.0, 2.0)),
        ]
    )
    grid = centre + np.concatenate([-offsets[::-1], [0.0], offsets])
    rows = [
        np.concatenate([[a], grid[(grid > a + 1e-4) & (grid < b - 1e-4)], [b]])
        for a, b in zip(low, high, strict=True)
    ]
    width = max(row.size for row in rows)
    return np.stack([pad_row(row, width) for row in rows])
