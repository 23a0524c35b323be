"""Compiled motion of the blade elements and the wind that meets them.

Seen from the apex an element at z lies at r = p + d + (z - s) e_z in its blade's frame: prebend and
sweep p and deflection d of the mode shapes, both turned by the pitch, and the shortening s of the
deflected blade.  Its velocity is the apex's plus spin x r plus those of deflection and pitch.  Wind
less velocity is the relative wind: V_n normal to the deflected axis, V_t along y_b.
"""

from __future__ import annotations

import math

from pitchopt.sim.compiling import inlined, summing
from pitchopt.sim.kernels_planes import (
    PLANE,
    S_GX,
    S_GY,
    S_GZ,
    S_TILT,
    S_UX,
    S_UY,
    S_UZ,
    S_VN,
    S_VT,
    S_X,
    S_Y,
    S_Z,
    T_PREBEND,
    T_REAL,
    T_SHAPE,
    T_SHORT,
    T_SLOPE,
    T_SPAN,
    T_SWEEP,
)
from pitchopt.sim.kernels_wind import NO_BOX, POLAR, fluctuation, table, tower_disturbance

__all__ = ["place", "relative_wind", "wind_at"]


@summing
def place(s, t, stop, frame, apex, velocity, spin, cb, sb, rate, q, d):  # type: ignore[no-untyped-def]
    """Place and velocity of the elements of one blade."""
    f00, f01, f02 = frame[0, 0], frame[0, 1], frame[0, 2]
    f10, f11, f12 = frame[1, 0], frame[1, 1], frame[1, 2]
    f20, f21, f22 = frame[2, 0], frame[2, 1], frame[2, 2]
    vx = f00 * velocity[0] + f10 * velocity[1] + f20 * velocity[2]
    vy = f01 * velocity[0] + f11 * velocity[1] + f21 * velocity[2]
    vz = f02 * velocity[0] + f12 * velocity[1] + f22 * velocity[2]
    wx = f00 * spin[0] + f10 * spin[1] + f20 * spin[2]
    wy = f01 * spin[0] + f11 * spin[1] + f21 * spin[2]
    wz = f02 * spin[0] + f12 * spin[1] + f22 * spin[2]
    ax, ay, az = apex[0], apex[1], apex[2]
    q0, q1, d0, d1 = q[0], q[1], d[0], d[1]
    q00, q01, q11 = 0.5 * q0 * q0, 0.5 * q0 * q1, 0.5 * q1 * q1
    # in three loops: the compiler gives up on one that touches too many planes
    for e in range(stop):
        # deflection before it is turned by pitch
        s00, s01 = t[T_SHAPE + e], t[T_SHAPE + PLANE + e]
        s10, s11 = t[T_SHAPE + 2 * PLANE + e], t[T_SHAPE + 3 * PLANE + e]
        px, py = q0 * s00 + q1 * s10, q0 * s01 + q1 * s11
        rx, ry = d0 * s00 + d1 * s10, d0 * s01 + d1 * s11
        ox = t[T_PREBEND + e] * cb + t[T_SWEEP + e] * sb
        oy = t[T_SWEEP + e] * cb - t[T_PREBEND + e] * sb
        s[S_X + e], s[S_Y + e] = ox + px * cb + py * sb, oy + py * cb - px * sb
        s[S_UX + e] = rx * cb + ry * sb + rate * oy
        s[S_UY + e] = ry * cb - rx * sb - rate * ox
    for e in range(stop):
        sx = q0 * t[T_SLOPE + e] + q1 * t[T_SLOPE + 2 * PLANE + e]
        sy = q0 * t[T_SLOPE + PLANE + e] + q1 * t[T_SLOPE + 3 * PLANE + e]
        s[S_TILT + e] = sx * cb + sy * sb
        s[S_Z + e] = t[T_SPAN + e] - (
            q00 * t[T_SHORT + e] + q01 * t[T_SHORT + PLANE + e] + q11 * t[T_SHORT + 2 * PLANE + e]
        )
    for e in range(stop):
        x, y, z = s[S_X + e], s[S_Y + e], s[S_Z + e]
        s[S_UX + e] += vx + wy * z - wz * y
        s[S_UY + e] += vy + wz * x - wx * z
        s[S_UZ + e] = vz + wx * y - wy * x
        s[S_GX + e] = ax + f00 * x + f01 * y + f02 * z
        s[S_GY + e] = ay + f10 * x + f11 * y + f12 * z
        s[S_GZ + e] = az + f20 * x + f21 * y + f22 * z


@inlined
def wind_at(s, wind, stop, hub_speed, time, top_x, top_y, top_height):  # type: ignore[no-untyped-def]
    """Wind at the places of one blade's elements, written over them."""
    shear, shear_low, per_shear = wind.shear, wind.shear_low, 1.0 / wind.shear_step
    shear_slope, wind_c, wind_s = wind.slope, wind.cosine, wind.sine
    tower, wall, tower_low, per_tower = (
        wind.tower,
        wind.tower_radius,
        wind.tower_low,
        1.0 / wind.tower_step,
    )
    shadow, lateral = tower.size > 1, wind.lateral
    box, turbulent, polar, periodic = (
        wind.box,
        wind.kind != NO_BOX,
        wind.kind == POLAR,
        wind.periodic,
    )
    box_rate = 1.0 / wind.step
    box_start = wind.carrier * time * box_rate + wind.offset
    if periodic:
        box_start -= box.shape[0] * math.floor(box_start / box.shape[0])
    second_low, third_low = wind.low[0], wind.low[1]
    per_second, per_third = 1.0 / wind.steps[0], 1.0 / wind.steps[1]
    for e in range(stop):
        x, y, z = s[S_GX + e], s[S_GY + e], s[S_GZ + e]
        mean = hub_speed * (table(shear, shear_low, per_shear, z) + shear_slope * y)
        u, v, w = mean, 0.0, 0.0
        if turbulent:
            u, v, w = fluctuation(
                box,
                polar,
                periodic,
                box_start - (wind_c * x + wind_s * y) * box_rate,
                wind_c * y - wind_s * x - second_low,
                z - third_low,
                per_second,
                per_third,
            )
            u += mean
        a, b = wind_c * u - wind_s * v, wind_s * u + wind_c * v
        if shadow:
            radius = table(tower, tower_low, per_tower, z)
            if radius > 0.0:
                share = min(z / top_height, 1.0)
                share *= share  # the deflected axis, nearly a parabola
                da, db = tower_disturbance(
                    radius,
                    table(wall, tower_low, per_tower, z),
                    lateral,
                    x - share * top_x,
                    y - share * top_y,
                    a,
                    b,
                )
                a += da
                b += db
        s[S_GX + e], s[S_GY + e], s[S_GZ + e] = a, b, w


@summing
def relative_wind(s, t, stop, frame):  # type: ignore[no-untyped-def]
    """Relative wind of one blade's elements; its sum in the blade's frame."""
    f00, f01, f02 = frame[0, 0], frame[0, 1], frame[0, 2]
    f10, f11, f12 = frame[1, 0], frame[1, 1], frame[1, 2]
    f20, f21, f22 = frame[2, 0], frame[2, 1], frame[2, 2]
    sum_x, sum_y, sum_z = 0.0, 0.0, 0.0
    for e in range(stop):
        a, b, c = s[S_GX + e], s[S_GY + e], s[S_GZ + e]
        nx = f00 * a + f10 * b + f20 * c - s[S_UX + e]
        ny = f01 * a + f11 * b + f21 * c - s[S_UY + e]
        nz = f02 * a + f12 * b + f22 * c - s[S_UZ + e]
        real = t[T_REAL + e]
        sum_x += real * nx
        sum_y += real * ny
        sum_z += real * nz
        tilt = s[S_TILT + e]
        s[S_VN + e] = (nx - tilt * nz) / math.sqrt(1.0 + tilt * tilt)
        s[S_VT + e] = ny
    return sum_x, sum_y, sum_z
