"""Compiled rainflow counting over a signal, in one pass and without allocation.

Imported where it is used, not at the top: numba takes a while to load. The function is untyped
for the type checker because numba infers types of its own.
"""

from __future__ import annotations

import numba as nb
import numpy as np

__all__ = ["count_cycles", "count_spectra"]


@nb.njit(cache=True, nogil=True)
def count_cycles(signal, start, repeat, stack, ranges, means, counts):  # type: ignore[no-untyped-def]
    """Cycles of a signal; see `pitchopt.fatigue.counting`.

    Parameters
    ----------
    signal : (n,)
        Finite values.
    start : int
        Where to begin; with `repeat` the place of the largest value.
    repeat : bool
        Go once round the signal and back to `start`, and count whole cycles only. Otherwise
        `start` is 0, and what is left over is counted as half cycles.
    stack, ranges, means, counts : (n + 1,)
        Work space, and where the cycles go.

    Returns
    -------
    int
        Number of cycles and half cycles.
    """
    n = signal.size
    steps = n if repeat else n - 1
    top, found = 1, 0
    stack[0] = signal[start]
    value = stack[0]  # the last sample that differed from the one before
    direction = 0
    k = start
    for i in range(steps + 1):
        # a sample is a reversal when the next one turns back; after the last one all is over
        end = i == steps
        if not end:
            k += 1
            if k == n:
                k = 0
            sample = signal[k]
            if sample == value:
                continue
            heading = 1 if sample > value else -1
            if direction == heading or direction == 0:
                direction = heading
                value = sample
                continue
            direction = heading
        elif direction == 0:
            break  # constant
        stack[top] = value
        top += 1
        while top >= 3:
            recent = abs(stack[top - 1] - stack[top - 2])
            before = abs(stack[top - 2] - stack[top - 3])
            if recent < before:
                break
            ranges[found] = before
            means[found] = 0.5 * (stack[top - 2] + stack[top - 3])
            if top == 3 and not repeat:
                counts[found] = 0.5
                stack[0], stack[1] = stack[1], stack[2]
                top = 2
            else:
                counts[found] = 1.0
                stack[top - 3] = stack[top - 1]
                top -= 2
            found += 1
        if not end:
            value = sample
    for j in range(top - 1):
        ranges[found] = abs(stack[j + 1] - stack[j])
        means[found] = 0.5 * (stack[j + 1] + stack[j])
        counts[found] = 0.5
        found += 1
    return found


@nb.njit(cache=True, nogil=True)
def count_spectra(signals, log_first, width, bins):  # type: ignore[no-untyped-def]
    """Cycles of signals (K, n) by logarithmic bins of their ranges (K, bins).

    See `pitchopt.fatigue.spectrum`; residues count as half cycles.
    """
    rows, n = signals.shape
    stack = np.empty(n + 1)
    ranges = np.empty(n + 1)
    means = np.empty(n + 1)
    counts = np.empty(n + 1)
    out = np.zeros((rows, bins))
    for k in range(rows):
        found = count_cycles(signals[k], 0, False, stack, ranges, means, counts)
        for i in range(found):
            place = round((np.log(ranges[i]) - log_first) / width)
            out[k, int(min(max(place, 0), bins - 1))] += counts[i]
    return out
