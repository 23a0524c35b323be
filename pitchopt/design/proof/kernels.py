"""Compiled loops over piecewise-linear curves on pitch intervals.

A curve of station n is the row n of an array of values at the breakpoints ``beta[n]``; on an
interval [lo_n, hi_n] its extremes stand on breakpoints inside or on the interval's ends, so
that every range, maximum and level set here is exact but for rounding, which the callers
cover by moving levels outward.

The module is imported where it is used, not at the top: numba takes a while to load.  The
functions are untyped for the type checker because numba infers the types of its own.
"""

from __future__ import annotations

import numba as nb
import numpy as np
from numpy.typing import NDArray

__all__ = ["level_hulls", "linear_maxima", "newton_pass", "ranges", "triple_scan"]

FloatArray = NDArray[np.float64]

_STEEPEST = (
    1e5  # of a slope times its width over its spread: any rows are valid, these stay solvable
)

_compiled = nb.njit(cache=True, error_model="numpy")


@_compiled
def _segment(knots, x):  # type: ignore[no-untyped-def]
    """Segment of ascending knots that holds x; the first or last one outside."""
    j = np.searchsorted(knots, x, side="right") - 1
    return min(max(j, 0), knots.size - 2)


@_compiled
def _value(knots, values, x):  # type: ignore[no-untyped-def]
    """Value at x."""
    j = _segment(knots, x)
    share = (x - knots[j]) / (knots[j + 1] - knots[j])
    return (1.0 - share) * values[j] + share * values[j + 1]


@_compiled
def _range(knots, values, lo, hi):  # type: ignore[no-untyped-def]
    """Least and largest value on [lo, hi]."""
    a, b = _value(knots, values, lo), _value(knots, values, hi)
    least, largest = min(a, b), max(a, b)
    j = _segment(knots, lo) + 1
    while j < knots.size and knots[j] < hi:
        least, largest = min(least, values[j]), max(largest, values[j])
        j += 1
    return least, largest


@_compiled
def _level_hull(knots, values, lo, hi, low, high):  # type: ignore[no-untyped-def]
    """Smallest interval around {x in [lo, hi]: low <= value <= high}; reversed if empty."""
    first, last = hi + 1.0, lo - 1.0
    x0, v0 = lo, _value(knots, values, lo)
    if low <= v0 <= high:
        first = last = lo
    j = _segment(knots, lo) + 1
    while True:
        if j < knots.size and knots[j] < hi:
            x1, v1 = knots[j], values[j]
        else:
            x1, v1 = hi, _value(knots, values, hi)
        if max(v0, v1) >= low and min(v0, v1) <= high:
            if v0 < low:
                enter = x0 + (low - v0) / (v1 - v0) * (x1 - x0)
            elif v0 > high:
                enter = x0 + (high - v0) / (v1 - v0) * (x1 - x0)
            else:
                enter = x0
            if v1 < low:
                leave = x1 - (low - v1) / (v0 - v1) * (x1 - x0)
            elif v1 > high:
                leave = x1 - (high - v1) / (v0 - v1) * (x1 - x0)
            else:
                leave = x1
            first, last = min(first, max(enter, lo)), max(last, min(leave, hi))
        if x1 >= hi:
            return first, last
        x0, v0 = x1, v1
        j += 1


@_compiled
def ranges(beta, loads, lo, hi):  # type: ignore[no-untyped-def]
    """Least and largest value of each load on each interval, shape (L, N, 2)."""
    count, stations = loads.shape[0], beta.shape[0]
    out = np.empty((count, stations, 2))
    for q in range(count):
        for n in range(stations):
            out[q, n, 0], out[q, n, 1] = _range(beta[n], loads[q, n], lo[n], hi[n])
    return out


@_compiled
def _linear(coefficients, loads, beta, n, j):  # type: ignore[no-untyped-def]
    """Sum of coefficient times pitch and loads at breakpoint j."""
    total = coefficients[0, n] * beta[n, j]
    for q in range(loads.shape[0]):
        total += coefficients[q + 1, n] * loads[q, n, j]
    return total


@_compiled
def _row(coefficients, loads, beta, n, lo, hi, out):  # type: ignore[no-untyped-def]
    """The linear combination at the breakpoints around [lo, hi]; first and last index."""
    first, last = _segment(beta[n], lo), _segment(beta[n], hi) + 1
    for j in range(first, last + 1):
        out[j] = _linear(coefficients, loads, beta, n, j)
    return first, last


@_compiled
def linear_maxima(beta, loads, coefficients, lo, hi):  # type: ignore[no-untyped-def]
    """Largest c_0n beta + sum_q c_qn load_qn on each interval, shape (N,).

    Parameters
    ----------
    beta : (N, K)
    loads : (L, N, K)
    coefficients : (L + 1, N)
    lo, hi : (N,)
    """
    stations = beta.shape[0]
    out, row = np.empty(stations), np.empty(beta.shape[1])
    for n in range(stations):
        first, last = _row(coefficients, loads, beta, n, lo[n], hi[n], row)
        out[n] = _range(beta[n, first : last + 1], row[first : last + 1], lo[n], hi[n])[1]
    return out


@_compiled
def level_hulls(beta, loads, coefficients, lo, hi, level):  # type: ignore[no-untyped-def]
    """Smallest intervals around where the same combination is at least ``level`` (N,).

    A station whose maximum is below its level gets a reversed interval.
    """
    stations = beta.shape[0]
    new_lo, new_hi, row = np.empty(stations), np.empty(stations), np.empty(beta.shape[1])
    for n in range(stations):
        first, last = _row(coefficients, loads, beta, n, lo[n], hi[n], row)
        new_lo[n], new_hi[n] = _level_hull(
            beta[n, first : last + 1], row[first : last + 1], lo[n], hi[n], level[n], np.inf
        )
    return new_lo, new_hi


@_compiled
def triple_scan(  # type: ignore[no-untyped-def]
    beta, torque, thrust, without, lo, hi, low, high, low_without, high_without, slices
):
    """Pitch that some triple of blades can have, for three blades.

    At position k the blades stand at n_0, n_1, n_2.  Turning the moments into the axis of blade
    l leaves an equation without its bending,

        sum_b without_l,n_b(beta_n_b) in [low_without_lk, high_without_lk],

    in which n_l enters with its radial moment only.  For every slice of one blade's interval the
    two such equations give an interval for each of the other two, and torque and thrust of the
    three say whether the slice can be.  What survives is the new interval of all three.

    Parameters
    ----------
    beta, torque, thrust : (N, K)
    without : (3, N, K)
        Contribution of station n to the moment about the axis of the blade l of its position.
    lo, hi : (N,)
    low, high : (4, m)
        Range of torque, tilt, yaw, thrust at each position.
    low_without, high_without : (3, m)
    slices : int

    Returns
    -------
    lo, hi : (N,)
    empty : bool
        True when some position has no triple left.
    """
    m = low.shape[1]
    new_lo, new_hi = lo.copy(), hi.copy()
    for k in range(m):
        for blade in range(3):
            second, third = (blade + 1) % 3, (blade + 2) % 3
            i, j, l = k + blade * m, k + second * m, k + third * m  # noqa: E741
            to_j, to_l = without[third], without[second]
            rest = _range(beta[l], to_j[l], new_lo[l], new_hi[l])
            j_low, j_high = low_without[third, k] - rest[1], high_without[third, k] - rest[0]
            rest = _range(beta[j], to_l[j], new_lo[j], new_hi[j])
            l_low, l_high = low_without[second, k] - rest[1], high_without[second, k] - rest[0]
            i_first, i_last = np.inf, -np.inf
            j_first, j_last, l_first, l_last = np.inf, -np.inf, np.inf, -np.inf
            width = (new_hi[i] - new_lo[i]) / slices
            for s in range(slices):
                x0 = new_lo[i] + s * width
                x1 = new_hi[i] if s == slices - 1 else new_lo[i] + (s + 1) * width
                part = _range(beta[i], to_j[i], x0, x1)
                j0, j1 = _level_hull(
                    beta[j], to_j[j], new_lo[j], new_hi[j], j_low - part[1], j_high - part[0]
                )
                if j0 > j1:
                    continue
                part = _range(beta[i], to_l[i], x0, x1)
                l0, l1 = _level_hull(
                    beta[l], to_l[l], new_lo[l], new_hi[l], l_low - part[1], l_high - part[0]
                )
                if l0 > l1:
                    continue
                a = _range(beta[i], torque[i], x0, x1)
                b = _range(beta[j], torque[j], j0, j1)
                c = _range(beta[l], torque[l], l0, l1)
                if a[1] + b[1] + c[1] < low[0, k] or a[0] + b[0] + c[0] > high[0, k]:
                    continue
                a = _range(beta[i], thrust[i], x0, x1)
                b = _range(beta[j], thrust[j], j0, j1)
                c = _range(beta[l], thrust[l], l0, l1)
                if a[1] + b[1] + c[1] < low[3, k] or a[0] + b[0] + c[0] > high[3, k]:
                    continue
                i_first, i_last = min(i_first, x0), max(i_last, x1)
                j_first, j_last = min(j_first, j0), max(j_last, j1)
                l_first, l_last = min(l_first, l0), max(l_last, l1)
            if i_first > i_last:
                return new_lo, new_hi, True
            new_lo[i], new_hi[i] = max(new_lo[i], i_first), min(new_hi[i], i_last)
            new_lo[j], new_hi[j] = max(new_lo[j], j_first), min(new_hi[j], j_last)
            new_lo[l], new_hi[l] = max(new_lo[l], l_first), min(new_hi[l], l_last)
    return new_lo, new_hi, False


@_compiled
def newton_pass(beta, loads, lo, hi, low, high, pad):  # type: ignore[no-untyped-def]
    """Interval Newton step on the four loads of each position.

    For any row a of four numbers,

        beta_n = a . load(k) - sum_b [a . f_n_b(beta_n_b) - delta beta_n],

    so that the range of load(k) and of the brackets bound beta_n.  The rows are those of the
    linear estimate of the pitches from the loads, with the widths of the pitch intervals and of
    the loads' ranges as its uncertainties; whatever they are, the result holds.

    Parameters
    ----------
    beta : (N, K)
    loads : (L, N, K)
        Torque, tilt, yaw, thrust first.
    lo, hi : (N,)
    low, high : (4, m)
    pad : float
        Rounding in the sums, as a share of their terms.

    Returns
    -------
    lo, hi : (N,)
        Reversed where nothing is left.
    """
    stations, m = beta.shape[0], low.shape[1]
    blades = stations // m
    new_lo, new_hi = lo.copy(), hi.copy()
    slope, spread = np.empty((4, blades)), np.empty(4)
    normal, right = np.empty((blades, blades)), np.empty((blades, 4))
    row = np.empty(beta.shape[1])
    for k in range(m):
        for q in range(4):
            spread[q] = high[q, k] - low[q, k]
            for b in range(blades):
                n = k + b * m
                knots, values = beta[n], loads[q, n]
                width = hi[n] - lo[n]
                start = _value(knots, values, lo[n])
                slope[q, b] = 0.0
                if width > 1e-12:
                    slope[q, b] = (_value(knots, values, hi[n]) - start) / width
                above, below = 0.0, 0.0
                j = _segment(knots, lo[n]) + 1
                while j < knots.size and knots[j] < hi[n]:
                    off = values[j] - start - slope[q, b] * (knots[j] - lo[n])
                    above, below = max(above, off), min(below, off)
                    j += 1
                spread[q] += above - below
        # in units of the widths and of the spreads, so that the system is at least the identity
        for b in range(blades):
            width = max(hi[k + b * m] - lo[k + b * m], 1e-9)
            for q in range(4):
                share = 0.0
                if spread[q] < 1e200:
                    share = slope[q, b] * width / max(spread[q], 1e-200)
                right[b, q] = min(max(share, -_STEEPEST), _STEEPEST)
        for b in range(blades):
            for c in range(blades):
                normal[b, c] = 1.0 if b == c else 0.0
                for q in range(4):
                    normal[b, c] += right[b, q] * right[c, q]
        estimate = np.linalg.solve(normal, right)
        for b in range(blades):
            width = max(hi[k + b * m] - lo[k + b * m], 1e-9)
            for q in range(4):
                if estimate[b, q] != 0.0:
                    estimate[b, q] *= width / max(spread[q], 1e-200)
        for b in range(blades):
            n = k + b * m
            top, bottom, size = 0.0, 0.0, 0.0
            for q in range(4):
                a = estimate[b, q]
                if a == 0.0 or not np.isfinite(a):
                    estimate[b, q] = 0.0
                    continue
                top += max(a * low[q, k], a * high[q, k])
                bottom += min(a * low[q, k], a * high[q, k])
                size += abs(a) * max(abs(low[q, k]), abs(high[q, k]))
            for c in range(blades):
                o = k + c * m
                first, last = _segment(beta[o], lo[o]), _segment(beta[o], hi[o]) + 1
                for j in range(first, last + 1):
                    total = beta[o, j] if o == n else 0.0
                    for q in range(4):
                        total -= estimate[b, q] * loads[q, o, j]
                    row[j] = total
                part = _range(beta[o, first : last + 1], row[first : last + 1], lo[o], hi[o])
                top += part[1]
                bottom += part[0]
                for q in range(4):
                    largest = 0.0
                    for j in range(first, last + 1):
                        largest = max(largest, abs(loads[q, o, j]))
                    size += abs(estimate[b, q]) * largest
            size += abs(hi[n]) + abs(lo[n])
            new_hi[n] = min(new_hi[n], top + pad * size)
            new_lo[n] = max(new_lo[n], bottom - pad * size)
    return new_lo, new_hi
