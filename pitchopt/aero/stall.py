"""Stall: which pitch keeps the outboard sections attached, and which tables cover the flow.

alpha = phi - (twist + beta) falls as pitch grows, also in momentum balance, so a section's
limits on the angle of attack become limits on pitch: the stall angle a lower, the negative stall
angle an upper one.  Angles in radians.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from pitchopt.aero.polars import Polar
from pitchopt.aero.section_limits import MARGIN
from pitchopt.checks import FloatArray
from pitchopt.errors import InputError

__all__ = [
    "StallLimits",
    "attached_intervals",
    "check_alpha_limits",
    "check_coverage",
    "longest_interval",
    "stall_limits",
]

_FULL_TURN = 2 * np.pi - 1e-6
_EDGE = float(np.deg2rad(0.01))  # ends of an interval are found to this


class StallLimits(NamedTuple):
    """Sections that restrict pitch, and their largest and least angles of attack."""

    sections: NDArray[np.intp]
    above: FloatArray
    below: FloatArray


def stall_limits(
    polars: Sequence[Polar],
    wanted: tuple[float | None, float | None],
    restricting: NDArray[np.bool_],
) -> StallLimits:
    """Limits of the lifting sections among the restricting ones, half a degree inside.

    Parameters
    ----------
    polars : sequence of Polar, length E
    wanted : (float or None, float or None)
        Lower and upper limit for all sections; None for each polar's own stall angles.
    restricting : ndarray (E,) of bool
    """
    low, high = wanted
    picked = [e for e in np.flatnonzero(restricting).tolist() if polars[e].lifting]
    above = [polars[e].stall_angle() if high is None else high for e in picked]
    below = [polars[e].attached_range()[0] if low is None else low for e in picked]
    return StallLimits(
        sections=np.array(picked, dtype=np.intp),
        above=np.array(above) - MARGIN,
        below=np.array(below) + MARGIN,
    )


def longest_interval(
    attached: Callable[[FloatArray], NDArray[np.bool_]], low: float, high: float
) -> tuple[float, float]:
    """Ends of the longest run of attached constant pitches, looked for every degree.

    Raises
    ------
    InputError
        If there is none.
    """
    grid = np.linspace(low, high, max(int(np.ceil((high - low) / np.deg2rad(1.0))), 2) + 1)
    good = attached(grid)
    edges = np.flatnonzero(np.diff(np.concatenate([[False], good, [False]])))
    if edges.size == 0:
        raise InputError(
            "alpha_limits, pitch_range: every constant pitch from "
            f"{np.rad2deg(low):.2f} to {np.rad2deg(high):.2f} deg stalls an outboard section "
            "at some azimuth; widen the pitch range or check wind and rotor speed"
        )
    starts, ends = edges[::2], edges[1::2] - 1
    run = int(np.argmax(ends - starts))
    result = []
    for inside, step in ((int(starts[run]), -1), (int(ends[run]), 1)):
        kept = lost = float(grid[inside])
        if 0 <= inside + step < grid.size:
            lost = float(grid[inside + step])
        while abs(lost - kept) > _EDGE:
            middle = 0.5 * (kept + lost)
            kept, lost = (middle, lost) if attached(np.array([middle]))[0] else (kept, middle)
        result.append(kept)
    return result[0], result[1]


def attached_intervals(
    grid: FloatArray, alpha: FloatArray, at: int, limits: StallLimits
) -> tuple[FloatArray, FloatArray]:
    """Pitch intervals (N,) around grid entry `at` in which no restricting section stalls.

    Parameters
    ----------
    grid : ndarray (G,)
        Increasing pitch.
    alpha : ndarray (N, G, E)
        Angles of attack at the stations.
    at : int
    limits : StallLimits
    """
    low = np.full(alpha.shape[0], -np.inf)
    high = np.full(alpha.shape[0], np.inf)
    for e, above, below in zip(*limits, strict=True):
        for n in range(alpha.shape[0]):
            left, right = crossings(grid, alpha[n, :, e], at, (below, above))
            low[n] = max(low[n], left)
            high[n] = min(high[n], right)
    return low, high


def check_alpha_limits(polars: Sequence[Polar], wanted: tuple[float | None, float | None]) -> None:
    """Limits asked for lie inside every lifting section's table, in the right order.

    Raises
    ------
    InputError
        Naming the limit and the polar.
    """
    low, high = wanted
    for polar in polars:
        if not polar.lifting:
            continue
        first, last = float(polar.alpha[0]), float(polar.alpha[-1])
        for i, value in enumerate((low, high)):
            if value is not None and not first <= value <= last:
                raise InputError(
                    f"alpha_limits[{i}]: got {np.rad2deg(value):g} deg, polar "
                    f"{polar.name!r} covers {np.rad2deg(first):g} to {np.rad2deg(last):g} deg"
                )
        top = polar.stall_angle() if high is None else high
        if low is not None and low >= top:
            raise InputError(
                f"alpha_limits[0]: got {np.rad2deg(low):g} deg, expected less than the upper "
                f"limit of polar {polar.name!r}, {np.rad2deg(top):g} deg"
            )


def check_coverage(polars: Sequence[Polar], alpha: FloatArray) -> None:
    """Angles of attack (..., E) stay inside the tables that do not go all round.

    Raises
    ------
    InputError
        Naming the polar, what it covers and what is needed.
    """
    for e, polar in enumerate(polars):
        first, last = float(polar.alpha[0]), float(polar.alpha[-1])
        if last - first >= _FULL_TURN:
            continue
        least, most = float(alpha[..., e].min()), float(alpha[..., e].max())
        if least < first - 1e-9 or most > last + 1e-9:
            raise InputError(
                f"polar {polar.name!r}: covers {np.rad2deg(first):g} to {np.rad2deg(last):g} "
                f"deg, the section needs {np.rad2deg(least):.2f} to {np.rad2deg(most):.2f} "
                "deg; extend the table or narrow the pitch range"
            )


def crossings(
    pitch: FloatArray, alpha: FloatArray, at: int, bounds: tuple[float, float]
) -> tuple[float, float]:
    """Pitches around entry `at` where alpha (G,), falling with pitch, leaves its bounds."""
    left = right = at
    while left > 0 and alpha[left - 1] <= bounds[1]:
        left -= 1
    while right < pitch.size - 1 and alpha[right + 1] >= bounds[0]:
        right += 1
    low, high = -np.inf, np.inf
    if left > 0:
        share = (bounds[1] - alpha[left]) / (alpha[left - 1] - alpha[left])
        low = float(pitch[left] + share * (pitch[left - 1] - pitch[left]))
    if right < pitch.size - 1:
        share = (alpha[right] - bounds[0]) / (alpha[right] - alpha[right + 1])
        high = float(pitch[right] + share * (pitch[right + 1] - pitch[right]))
    return low, high
