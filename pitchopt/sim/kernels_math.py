"""Compiled elementary functions without branches, which the compiler vectorises inside loops.

All are polynomials on a reduced range; their absolute errors (relative for the exponential) are
far below any other of the time loop:

    sine_cosine     |x| <= pi/2       Taylor, degrees 19 and 20     1e-15
    falling         0 <= x <= 24      Taylor of exp(-x/32), ^32     3e-10 (3e-14 up to 12)
    angle           any quadrant      Chebyshev, degree 31          5e-14
"""

from __future__ import annotations

import math

from pitchopt.sim.compiling import inlined

__all__ = ["angle", "falling", "sine_cosine"]


# of atan(t) / t in t^2 on [0, 1]
_A0, _A1, _A2, _A3 = (
    0.9999999999999597,
    -0.33333333331217585,
    0.19999999814897854,
    -0.14285707852637877,
)
_A4, _A5, _A6, _A7 = (
    0.111109929760219,
    -0.0908958678507372,
    0.07682489359461969,
    -0.06615566698083647,
)
_A8, _A9, _A10, _A11 = (
    0.05688664494383411,
    -0.04713074933058081,
    0.035636526553678216,
    -0.022994755615528106,
)
_A12, _A13, _A14, _A15 = (
    0.011746433861176797,
    -0.0043446454560580605,
    0.001018270464555826,
    -0.00011243685730732977,
)


@inlined
def sine_cosine(x):  # type: ignore[no-untyped-def]
    """Sine and cosine of x in [-pi/2, pi/2]."""
    z = x * x
    s = 1.0 / 355687428096000.0 - z * (1.0 / 121645100408832000.0)
    s = -1.0 / 1307674368000.0 + z * s
    s = 1.0 / 6227020800.0 + z * s
    s = -1.0 / 39916800.0 + z * s
    s = 1.0 / 362880.0 + z * s
    s = -1.0 / 5040.0 + z * s
    s = 1.0 / 120.0 + z * s
    s = -1.0 / 6.0 + z * s
    c = -1.0 / 6402373705728000.0 + z * (1.0 / 2432902008176640000.0)
    c = 1.0 / 20922789888000.0 + z * c
    c = -1.0 / 87178291200.0 + z * c
    c = 1.0 / 479001600.0 + z * c
    c = -1.0 / 3628800.0 + z * c
    c = 1.0 / 40320.0 + z * c
    c = -1.0 / 720.0 + z * c
    c = 1.0 / 24.0 + z * c
    c = -0.5 + z * c
    return x + x * (z * s), 1.0 + z * c


@inlined
def falling(x):  # type: ignore[no-untyped-def]
    """exp(-x) for x >= 0; beyond 24, where it is below 4e-11, it stays at that."""
    y = min(x, 24.0) * (-1.0 / 32.0)
    p = 1.0 / 39916800.0 + y * (1.0 / 479001600.0)
    p = 1.0 / 3628800.0 + y * p
    p = 1.0 / 362880.0 + y * p
    p = 1.0 / 40320.0 + y * p
    p = 1.0 / 5040.0 + y * p
    p = 1.0 / 720.0 + y * p
    p = 1.0 / 120.0 + y * p
    p = 1.0 / 24.0 + y * p
    p = 1.0 / 6.0 + y * p
    p = 1.0 / 2.0 + y * p
    p = 1.0 + y * p
    p = 1.0 + y * p
    p *= p
    p *= p
    p *= p
    p *= p
    return p * p


@inlined
def angle(y, x):  # type: ignore[no-untyped-def]
    """Angle of the point (x, y) in (-pi, pi], as atan2(y, x); zero at the origin."""
    up, side = abs(y), abs(x)
    large = max(up, side)
    t = min(up, side) / (large if large > 0.0 else 1.0)
    z = t * t
    p = _A14 + z * _A15
    p = _A13 + z * p
    p = _A12 + z * p
    p = _A11 + z * p
    p = _A10 + z * p
    p = _A9 + z * p
    p = _A8 + z * p
    p = _A7 + z * p
    p = _A6 + z * p
    p = _A5 + z * p
    p = _A4 + z * p
    p = _A3 + z * p
    p = _A2 + z * p
    p = _A1 + z * p
    p = _A0 + z * p
    p *= t
    p = 0.5 * math.pi - p if up > side else p
    p = math.pi - p if x < 0.0 else p
    return -p if y < 0.0 else p
