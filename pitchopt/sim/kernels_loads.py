"""Compiled loads of a blade: coefficients of its sections, and the sums of their forces.

With the relative wind (e_n, e_t), lift L and drag D per length, the force on a section is

    f_x = L cos(phi) + D sin(phi),    f_y = D cos(phi) - L sin(phi),    tan(phi) = e_n / e_t,

in the blade's frame, f_z from the slope of the deflected axis; moments are about the rotor apex.
"""

from __future__ import annotations

import math

from pitchopt.sim.compiling import summing
from pitchopt.sim.kernels_balance import polar_row
from pitchopt.sim.kernels_planes import (
    PLANE,
    S_A,
    S_ALPHA,
    S_DRAG,
    S_EN,
    S_ET,
    S_LIFT,
    S_MOMENT,
    S_TILT,
    S_X,
    S_Y,
    S_Z,
    T_CHORD,
    T_LEVER,
    T_REAL,
    T_SPAN,
    T_WEIGHT,
    T_WIDTH,
)

__all__ = ["integrate", "look_up"]


@summing
def look_up(s, rows, first, last, polar):  # type: ignore[no-untyped-def]
    """All coefficients for the elements of one blade."""
    for e in range(rows.size):
        low, high = first[e], last[e]
        alpha = min(max(s[S_ALPHA + e], polar[low, 0]), polar[high, 0])
        row = polar_row(polar, low, high, rows[e], alpha)
        gap = alpha - polar[row, 0]
        s[S_LIFT + e] = polar[row, 1] + gap * polar[row, 2]
        s[S_DRAG + e] = polar[row, 3] + gap * polar[row, 4]
        s[S_MOMENT + e] = polar[row, 5] + gap * polar[row, 6]


@summing
def integrate(s, t, stop, density, cb, sb, force, moment, modal):  # type: ignore[no-untyped-def]
    """Loads of one blade; returns the sum of its axial induction factors."""
    fx_sum, fy_sum, fz_sum = 0.0, 0.0, 0.0
    mx_sum, my_sum, mz_sum = 0.0, 0.0, 0.0
    m0, m1, total = 0.0, 0.0, 0.0
    for e in range(stop):
        en, et = s[S_EN + e], s[S_ET + e]
        x, y, z = s[S_X + e], s[S_Y + e], s[S_Z + e]
        chord = t[T_CHORD + e]
        # pressure times speed: the sine and cosine of the inflow angle are en and et over it
        speed = math.sqrt(en * en + et * et)
        pressure = 0.5 * density * chord * speed
        lift, drag = pressure * s[S_LIFT + e], pressure * s[S_DRAG + e]
        fx = lift * et + drag * en
        fy = drag * et - lift * en
        fz = -s[S_TILT + e] * fx
        twisting = pressure * speed * chord * s[S_MOMENT + e]
        width = t[T_WIDTH + e]
        lever = t[T_LEVER + e] + width * (z - t[T_SPAN + e])
        fx_sum += width * fx
        fy_sum += width * fy
        fz_sum += width * fz
        mx_sum += width * y * fz - lever * fy
        my_sum += lever * fx - width * x * fz
        mz_sum += width * (x * fy - y * fx + twisting)
        # turned back by pitch, to the frame of the mode shapes
        bx, by = fx * cb - fy * sb, fy * cb + fx * sb
        m0 += bx * t[T_WEIGHT + e] + by * t[T_WEIGHT + PLANE + e]
        m1 += bx * t[T_WEIGHT + 2 * PLANE + e] + by * t[T_WEIGHT + 3 * PLANE + e]
        total += t[T_REAL + e] * s[S_A + e]
    force[0], force[1], force[2] = fx_sum, fy_sum, fz_sum
    moment[0], moment[1], moment[2] = mx_sum, my_sum, mz_sum
    modal[0], modal[1] = m0, m1
    return total
