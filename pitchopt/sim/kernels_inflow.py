"""Compiled dynamic inflow and skewed wake: from the induction to the flow at the sections.

Dynamic inflow (S. Oye's two-stage filter) on the induced velocity W of each element,

    W_int + tau_1 dW_int/dt = W_qs + k tau_1 dW_qs/dt,        W + tau_2 dW/dt = W_int,
    tau_1 = 1.1 / (1 - 1.3 a) R / V,    tau_2 = (0.39 - 0.26 (r/R)^2) tau_1,    k = 0.6,

with a (at most 0.5) and V the means over the rotor, integrated exactly for W_qs linear over the
step.  The skewed wake redistributes the result, as in `pitchopt.aero.induction`.

Source: M. O. L. Hansen, Aerodynamics of Wind Turbines, 2nd ed., chapter 9; the order of filter
and skew is AeroDyn's.
"""

from __future__ import annotations

import math

from pitchopt.sim.compiling import inlined, summing
from pitchopt.sim.kernels_math import angle, falling, sine_cosine
from pitchopt.sim.kernels_planes import (
    M_INDUCED,
    M_MIDDLE,
    M_QUASI,
    PLANE,
    S_A,
    S_ALPHA,
    S_EN,
    S_ET,
    S_RADIUS,
    S_SWIRL,
    S_THETA,
    S_VN,
    S_VT,
    T_OPEN,
)

__all__ = ["dynamic_inflow", "final_flow", "quasi_steady"]

_FILTER = 0.6  # k of the first stage


@inlined
def _filtered(old, new, middle, induced, step, per_step, tau, lag, per, decay, decay2):  # type: ignore[no-untyped-def]
    """W_int and W after a step over which W_qs goes linearly from `old` to `new`.

    `lag` is tau_1 + tau_2, `per` 1 / (1 - tau_2 / tau_1), `decay` and `decay2` are
    exp(- step / tau) of both stages.
    """
    rate = (new - old) * per_step
    level = old + rate * _FILTER * tau
    first = middle - level + rate * tau
    second = induced - first * per - level + rate * lag
    return (
        first * decay + level + rate * (step - tau),
        second * decay2 + level + rate * (step - lag) + first * per * decay,
    )


@summing
def dynamic_inflow(s, m, stop, fresh, step, tau, decay, per_tip):  # type: ignore[no-untyped-def]
    """Filter the induced velocity of one blade's elements; `fresh` sets it instead."""
    per_tau = step / tau
    rate = 1.0 / step if step > 0.0 else 0.0
    for e in range(stop):
        wn, wt = -s[S_A + e] * s[S_VN + e], s[S_SWIRL + e] * s[S_VT + e]
        share = s[S_RADIUS + e] * per_tip
        ratio = 0.39 - 0.26 * share * share
        decay2 = falling(per_tau / ratio)
        per = 1.0 / (1.0 - ratio)
        lag = tau * (1.0 + ratio)
        mn, qn = _filtered(
            m[M_QUASI + e],
            wn,
            m[M_MIDDLE + e],
            m[M_INDUCED + e],
            step,
            rate,
            tau,
            lag,
            per,
            decay,
            decay2,
        )
        mt, qt = _filtered(
            m[M_QUASI + PLANE + e],
            wt,
            m[M_MIDDLE + PLANE + e],
            m[M_INDUCED + PLANE + e],
            step,
            rate,
            tau,
            lag,
            per,
            decay,
            decay2,
        )
        qn, qt = wn if fresh else qn, wt if fresh else qt
        m[M_QUASI + e], m[M_QUASI + PLANE + e] = wn, wt
        m[M_MIDDLE + e] = wn if fresh else mn
        m[M_MIDDLE + PLANE + e] = wt if fresh else mt
        m[M_INDUCED + e], m[M_INDUCED + PLANE + e] = qn, qt
        s[S_EN + e], s[S_ET + e] = qn, qt


@summing
def quasi_steady(s, stop):  # type: ignore[no-untyped-def]
    """Induced velocity of the momentum balance itself."""
    for e in range(stop):
        s[S_EN + e] = -s[S_A + e] * s[S_VN + e]
        s[S_ET + e] = s[S_SWIRL + e] * s[S_VT + e]


@summing
def final_flow(s, t, stop, skew, direction):  # type: ignore[no-untyped-def]
    """Relative wind with induction and skew, and the angle of attack, of one blade's elements.

    Stations that are blocked keep their induction whatever the skew.
    """
    for e in range(stop):
        vn, wn = s[S_VN + e], s[S_EN + e]
        used = -wn / (vn if vn != 0.0 else 1.0)
        half = min(max(0.5 * (1.0 + 0.6 * used) * skew, -0.25 * math.pi), 0.25 * math.pi)
        sine, cosine = sine_cosine(half)
        turned = t[T_OPEN + e] * direction * s[S_RADIUS + e] * sine / cosine
        en = vn + wn * (1.0 + turned)
        et = s[S_VT + e] + s[S_ET + e]
        s[S_EN + e], s[S_ET + e] = en, et
        s[S_ALPHA + e] = angle(en, et) - s[S_THETA + e]
