"""Compiled induction of all elements at once: one step of Newton's method from a prediction.

The momentum balance (`pitchopt.sim.kernels_balance`) is solved by Newton's method from a
prediction: the last root moved along its derivatives by the change of x = V_n / V_t and of the
pitch since.  In most steps one evaluation does; elements where it does not are gone through one
by one.
"""

from __future__ import annotations

import math

from pitchopt.sim.compiling import summing
from pitchopt.sim.kernels_balance import (
    ACCEPT,
    EDGE,
    HIGH,
    STILL,
    balance,
    loss,
    newton_step,
    polar_row,
)
from pitchopt.sim.kernels_math import sine_cosine
from pitchopt.sim.kernels_planes import (
    M_BY_THETA,
    M_BY_X,
    M_PHI,
    M_THETA,
    M_X,
    S_A,
    S_ALPHA,
    S_COS,
    S_FALL,
    S_LIFT,
    S_LOSS,
    S_OPEN,
    S_PHI,
    S_RADIUS,
    S_RISE,
    S_SIN,
    S_SWIRL,
    S_THETA,
    S_UNSOLVED,
    S_VN,
    S_VT,
    S_X,
    S_Y,
    S_Z,
    T_INNER,
    T_OPEN,
    T_OUTER,
    T_REAL,
    T_SOLID,
    T_TWIST,
)

__all__ = ["balance_one", "look_up_lift", "newton", "predict"]


@summing
def predict(s, t, m, stop, pitch, cone_c, cone_s):  # type: ignore[no-untyped-def]
    """Predicted inflow angle of one blade's elements, and what goes with it."""
    for e in range(stop):
        vn, vt = s[S_VN + e], s[S_VT + e]
        theta = t[T_TWIST + e] + pitch
        radial, y = cone_c * s[S_Z + e] + cone_s * s[S_X + e], s[S_Y + e]
        s[S_THETA + e] = theta
        s[S_RADIUS + e] = math.sqrt(radial * radial + y * y)
        plain = (vn > STILL) & (vt > STILL)
        x = vn / (vt if plain else 1.0)
        last = m[M_PHI + e]
        phi = last + m[M_BY_X + e] * (x - m[M_X + e]) + m[M_BY_THETA + e] * (theta - m[M_THETA + e])
        inside = plain & (last > 0.0) & (phi > EDGE) & (phi < HIGH)
        s[S_OPEN + e] = 1.0 if inside else 0.0
        phi = phi if inside else 0.5
        sine, cosine = sine_cosine(phi)
        s[S_PHI + e], s[S_SIN + e], s[S_COS + e] = phi, sine, cosine
        s[S_ALPHA + e] = phi - theta
        s[S_LOSS + e], s[S_FALL + e] = loss(t[T_OUTER + e], t[T_INNER + e], sine, cosine)


@summing
def look_up_lift(s, rows, first, last, polar):  # type: ignore[no-untyped-def]
    """Lift coefficient and its slope for the elements of one blade."""
    for e in range(rows.size):
        alpha = s[S_ALPHA + e]
        row = polar_row(polar, first[e], last[e], rows[e], alpha)
        rows[e] = row
        gap = alpha - polar[row, 0]
        s[S_LIFT + e] = polar[row, 1] + gap * polar[row, 2]
        s[S_RISE + e] = polar[row, 2]


@summing
def newton(s, t, m, stop):  # type: ignore[no-untyped-def]
    """One step of Newton's method in all columns; marks those where it does not do."""
    missing = 0.0
    for e in range(stop):
        vn, vt, sine = s[S_VN + e], s[S_VT + e], s[S_SIN + e]
        go = s[S_OPEN + e] > 0.0
        x = vn / (vt if go else 1.0)
        change, a, swirl, by_x, by_theta, good = newton_step(
            sine,
            s[S_COS + e],
            x if go else 1.0,
            s[S_LIFT + e],
            s[S_RISE + e],
            s[S_LOSS + e],
            s[S_FALL + e],
            t[T_SOLID + e] / s[S_RADIUS + e],
        )
        unblocked = t[T_OPEN + e] > 0.0
        still = (abs(vn) <= STILL) | (abs(vt) <= STILL)
        done = go & good & (abs(change) < ACCEPT * sine) & unblocked
        m[M_PHI + e] = s[S_PHI + e] + change if done else m[M_PHI + e]
        m[M_X + e] = x if done else m[M_X + e]
        m[M_THETA + e] = s[S_THETA + e] if done else m[M_THETA + e]
        m[M_BY_X + e] = by_x if done else m[M_BY_X + e]
        m[M_BY_THETA + e] = by_theta if done else m[M_BY_THETA + e]
        a = a if done else 0.0
        s[S_A + e] = a if unblocked else 1.0
        s[S_SWIRL + e] = swirl if done else 0.0
        todo = 0.0 if (done | still) | (not unblocked) else t[T_REAL + e]
        s[S_UNSOLVED + e] = todo
        missing += todo
    return missing


@summing
def balance_one(s, t, m, e, row, first, last, polar, counts):  # type: ignore[no-untyped-def]
    """Momentum balance in column e without a usable prediction."""
    vn, vt, theta = s[S_VN + e], s[S_VT + e], s[S_THETA + e]
    phi, a, swirl, by_x, by_theta, row = balance(
        polar,
        first,
        last,
        row,
        t[T_OUTER + e],
        t[T_INNER + e],
        s[S_PHI + e] if s[S_OPEN + e] > 0.0 else -1.0,
        vn,
        vt,
        theta,
        t[T_SOLID + e] / s[S_RADIUS + e],
        counts,
    )
    m[M_PHI + e], m[M_X + e], m[M_THETA + e] = phi, vn / vt, theta
    m[M_BY_X + e], m[M_BY_THETA + e] = by_x, by_theta
    s[S_A + e], s[S_SWIRL + e] = a, swirl
    return row
