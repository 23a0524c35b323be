"""Compiled momentum balance of one blade element.

The balance is that of `pitchopt.aero.induction` with drag left out of it (AeroDyn's default):
with x = V_n / V_t, solidity sigma and loss factor F, below the empirical region

    R(phi) = sin phi - x cos phi + sigma C_l (cos phi + x sin phi) / (4 F sin phi) = 0.

`newton_step` is one step of Newton's method without branches, which the compiler vectorises over
blade elements; `balance` goes on with steps where one is not enough and, where they do not
converge, with Ning's brackets.

Source: S. A. Ning, Wind Energy 17, 2014, 1327-1345; M. L. Buhl, NREL/TP-500-36834, for the
empirical region.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from pitchopt.checks import FloatArray
from pitchopt.sim.compiling import compiled, inlined
from pitchopt.sim.kernels_math import angle, falling, sine_cosine

__all__ = ["ACCEPT", "EDGE", "HIGH", "STILL", "balance", "loss", "newton_step", "polar_row"]

EDGE = 1e-6
HIGH = math.pi / 2 - 1e-3  # largest inflow angle that Newton's method is used at
STILL = 1e-3  # no balance below this speed [m/s]
ACCEPT = 2e-3  # correction of phi relative to sin phi below which one step does
_MIN_LOSS = 1e-4
_NEWTON = 12
_FAR = 24.0  # exp(-24) is nothing beside 1


@compiled
def polar_row(polar: FloatArray, first: int, last: int, row: int, at: float) -> int:
    """Row of the polar whose interval holds `at`, searched from `row`.

    Rows `first` to `last` of `polar`, (P, 7), are the angle of attack, and lift, drag and moment
    coefficient each followed by its slope up to the next row.
    """
    if row < first or row >= last:
        row = first
    while row > first and at < polar[row, 0]:
        row -= 1
    while row < last - 1 and at >= polar[row + 1, 0]:
        row += 1
    return row


@inlined
def _one_loss(exponent):  # type: ignore[no-untyped-def]
    """Arc acos(exp(-f)) of one loss, and its derivative by f as two factors: e over the root."""
    e = falling(exponent)
    root = math.sqrt(max((1.0 - e) * (1.0 + e), 1e-300))
    far = exponent >= _FAR
    return 0.5 * math.pi if far else angle(root, e), 0.0 if far else e, root


@inlined
def loss(outer, inner, s, c):  # type: ignore[no-untyped-def]
    """Loss factor F at sin phi = s > 0, and its derivative by phi relative to F."""
    inverse = 1.0 / s
    tip, tip_e, tip_root = _one_loss(outer * inverse)
    hub, hub_e, hub_root = _one_loss(inner * inverse)
    factor = (4.0 / math.pi**2) * tip * hub
    tip *= tip_root
    hub *= hub_root
    rate = -c * inverse * inverse * (outer * tip_e * hub + inner * hub_e * tip) / (tip * hub)
    low = factor < _MIN_LOSS
    return _MIN_LOSS if low else factor, 0.0 if low else rate


@inlined
def newton_step(s, c, x, lift, rise, factor, fall, solidity):  # type: ignore[no-untyped-def]
    """One step of Newton's method at the inflow angle of sine `s` and cosine `c`, both positive.

    Parameters
    ----------
    x : float
        V_n / V_t, positive.
    lift, rise : float
        Lift coefficient and its slope.
    factor, fall : float
        From `loss`.

    Returns
    -------
    change : float
        Of the inflow angle.
    a, tangential : float
        Induction factors, moved along their derivatives by the change.
    by_x, by_theta : float
        Derivatives of the root by x and by twist plus pitch.
    good : bool
        Whether the step means anything.
    """
    cot, tan = c / s, s / c
    common = solidity / (4.0 * factor * s)
    kappa, swirl = common * lift * cot, common * lift * tan
    kappa_rate = common * cot * (rise - lift * (tan + 2.0 * cot + fall))
    swirl_rate = common * tan * (rise + lift * (tan - fall))
    kappa_theta = -common * rise * cot
    # Buhl's parabola, a = (g1 - root) / g3
    heavy = kappa > 2.0 / 3.0
    two = 2.0 * factor * kappa
    root = math.sqrt(max(two - factor * (4.0 / 3.0 - factor), 1e-12))
    g3 = two - (25.0 / 9.0 - 2.0 * factor)
    regular = abs(g3) > 1e-6
    g3 = g3 if regular else 1.0
    a_heavy = (two - (10.0 / 9.0 - factor) - root) / g3
    by_kappa = factor * (2.0 - 1.0 / root - 2.0 * a_heavy) / g3
    by_factor = (
        2.0 * kappa + 1.0 - (kappa - 2.0 / 3.0 + factor) / root - a_heavy * (2.0 * kappa + 2.0)
    ) / g3
    # momentum theory, 1 / (1 - a) = 1 + kappa
    inverse = 1.0 / (1.0 - a_heavy) if heavy else 1.0 + kappa
    square = inverse * inverse
    a = a_heavy if heavy else kappa / inverse
    inverse_kappa = square * by_kappa if heavy else 1.0
    inverse_rate = inverse_kappa * kappa_rate
    inverse_rate += square * by_factor * fall * factor if heavy else 0.0
    rest = 1.0 - swirl
    residual = s * inverse - x * c * rest
    slope = c * inverse + s * inverse_rate + x * (s * rest + c * swirl_rate)
    good = (kappa > -0.9) & (swirl < 0.9) & (slope > 0.0) & (regular | (kappa <= 2.0 / 3.0))
    per = 1.0 / (slope if slope > 0.0 else 1.0)
    change = -residual * per
    a += inverse_rate / square * change
    turning = swirl_rate * change
    tangential = (swirl + turning) / (rest - turning)
    by_x = c * rest * per
    by_theta = -(s * inverse_kappa * kappa_theta - x * s * common * rise) * per
    a = min(max(a, -1.0), 1.5)
    tangential = min(max(tangential, -1.0), 1.0)
    return change, a, tangential, by_x, by_theta, good


@compiled
def _axial(kappa: float, factor: float) -> float:
    """Induction factor of momentum theory and of Buhl's parabola, kappa > -1."""
    if kappa <= 2.0 / 3.0:
        return kappa / (1.0 + kappa)
    two = 2.0 * factor * kappa
    root = math.sqrt(abs(two - factor * (4.0 / 3.0 - factor)))
    g3 = two - (25.0 / 9.0 - 2.0 * factor)
    if abs(g3) < 1e-6:
        return 1.0 - 0.5 / root
    return (two - (10.0 / 9.0 - factor) - root) / g3


@compiled
def _lift(
    polar: FloatArray, first: int, last: int, row: int, at: float
) -> tuple[float, float, int]:
    """Lift coefficient, its slope and the row."""
    row = polar_row(polar, first, last, row, at)
    if at < polar[first, 0]:
        return polar[first, 1], 0.0, row
    if at > polar[last, 0]:
        return polar[last, 1], 0.0, row
    return polar[row, 1] + polar[row, 2] * (at - polar[row, 0]), polar[row, 2], row


@compiled
def _residual(
    polar: FloatArray,
    first: int,
    last: int,
    row: int,
    outer: float,
    inner: float,
    phi: float,
    x: float,
    theta: float,
    solidity: float,
    negative: bool,
) -> tuple[float, float, float, int]:
    """Residual of the general balance at phi, with kappa and kappa' (any sign of phi)."""
    s, c = math.sin(phi), math.cos(phi)
    cl, _, row = _lift(polar, first, last, row, phi - theta)
    factor, _ = loss(outer, inner, abs(s), c)
    common = solidity * cl / (4.0 * factor * s)
    kappa = common * c / s
    swirl = common * s / c
    if negative:
        swirl = -swirl
    if (phi > 0.0) != negative:
        inverse = 1.0 + kappa
        if kappa > 2.0 / 3.0:
            inverse = 1.0 / (1.0 - _axial(kappa, factor))
    else:
        inverse = 1.0 - kappa
    return s * inverse - x * c * (1.0 - swirl), kappa, swirl, row


@compiled
def _bisect(
    polar: FloatArray,
    first: int,
    last: int,
    row: int,
    outer: float,
    inner: float,
    x: float,
    theta: float,
    solidity: float,
    negative: bool,
) -> tuple[float, float, float, int]:
    """Inflow angle, a and a' by Ning's brackets in turn; phi is NaN where there is no root."""
    sign = -1.0 if negative else 1.0
    for bracket in range(3):
        if bracket == 0:
            low, high = EDGE, math.pi / 2 - EDGE
        elif bracket == 1:
            low, high = -math.pi / 4, -EDGE
        else:
            low, high = math.pi / 2 + EDGE, math.pi - EDGE
        low, high = sign * low, sign * high
        at_low, _, _, row = _residual(
            polar, first, last, row, outer, inner, low, x, theta, solidity, negative
        )
        at_high, _, _, row = _residual(
            polar, first, last, row, outer, inner, high, x, theta, solidity, negative
        )
        if not (at_low * at_high <= 0.0):
            continue
        side = 0
        for _ in range(200):
            # Illinois' rule: false position that halves the weight of an end kept twice
            middle = (low * at_high - high * at_low) / (at_high - at_low)
            if not (min(low, high) < middle < max(low, high)):
                middle = 0.5 * (low + high)
            value, _, _, row = _residual(
                polar, first, last, row, outer, inner, middle, x, theta, solidity, negative
            )
            if value * at_high > 0.0:
                high, at_high = middle, value
                if side == -1:
                    at_low *= 0.5
                side = -1
            else:
                low, at_low = middle, value
                if side == 1:
                    at_high *= 0.5
                side = 1
            if abs(high - low) < 1e-13 or value == 0.0 or abs(value) < 1e-14:
                break
        phi = middle
        _, kappa, swirl, row = _residual(
            polar, first, last, row, outer, inner, phi, x, theta, solidity, negative
        )
        factor, _ = loss(outer, inner, abs(math.sin(phi)), math.cos(phi))
        if (phi > 0.0) != negative:
            a = _axial(kappa, factor)
        else:
            a = kappa / (kappa - 1.0)
        tangential = swirl / (1.0 - swirl)
        return phi, min(max(a, -1.0), 1.5), min(max(tangential, -1.0), 1.0), row
    return math.nan, 0.0, 0.0, row


@compiled
def balance(
    polar: FloatArray,
    first: int,
    last: int,
    row: int,
    outer: float,
    inner: float,
    phi: float,
    vn: float,
    vt: float,
    theta: float,
    solidity: float,
    counts: NDArray[np.int64],
) -> tuple[float, float, float, float, float, int]:
    """Inflow angle, induction factors a and a', derivatives of the angle, and row of the polar.

    Newton's method from the inflow angle `phi`, then brackets; `counts` as in `InflowState`.
    """
    x = vn / vt
    if vn > 0.0 and vt > 0.0:
        for _ in range(_NEWTON):
            if not (EDGE < phi < HIGH):
                break
            counts[0] += 1
            s, c = sine_cosine(phi)
            lift, rise, row = _lift(polar, first, last, row, phi - theta)
            factor, fall = loss(outer, inner, s, c)
            change, a, tangential, by_x, by_theta, good = newton_step(
                s, c, x, lift, rise, factor, fall, solidity
            )
            if not good:
                break
            phi += change
            if abs(change) < ACCEPT * s:
                return phi, a, tangential, by_x, by_theta, row
    counts[2] += 1
    phi, a, tangential, row = _bisect(
        polar, first, last, row, outer, inner, x, theta, solidity, vn < 0.0
    )
    return phi if phi == phi else 0.0, a, tangential, 0.0, 0.0, row
