"""Compiled inertial loads of a blade, and the motion of the rotor apex that causes them.

With apex acceleration A (gravity taken off), angular velocity w and acceleration a of the rotor,
all in the frame of a blade, and W = [a] + [w][w] ([.] the cross-product matrix), the material
point at z has the acceleration

    A + z W e_z + sum_jd c_jd U_jd(z),    c_jd = (q_j W + 2 q_j' [w] + q_j'') e_d,

so that every inertial load of a blade is a sum of the integrals in `pitchopt.sim.structure`.
"""

from __future__ import annotations

from pitchopt.checks import FloatArray
from pitchopt.sim.compiling import inlined
from pitchopt.sim.kernels_body import AZIMUTH, BLADES, FORE_AFT, SIDE_SIDE, BodyTables, MotionWork
from pitchopt.sim.kernels_planes import RotorWork

__all__ = ["apex_motion", "blade_inertia"]


@inlined
def blade_inertia(
    body: BodyTables,
    rotor: RotorWork,
    work: MotionWork,
    k: int,
    acceleration: FloatArray,
    angular: FloatArray,
    q: FloatArray,
    v: FloatArray,
    a: FloatArray,
    with_acceleration: float,
) -> None:
    """Inertial loads of blade k, gravity included, for given motion of the apex.

    `acceleration` and `angular` are the apex's acceleration less gravity and the rotor's angular
    acceleration, global.  Modal accelerations are those of `a` times `with_acceleration`.
    """
    frame = rotor.frame[k]
    a0 = (
        frame[0, 0] * acceleration[0]
        + frame[1, 0] * acceleration[1]
        + frame[2, 0] * acceleration[2]
    )
    a1 = (
        frame[0, 1] * acceleration[0]
        + frame[1, 1] * acceleration[1]
        + frame[2, 1] * acceleration[2]
    )
    a2 = (
        frame[0, 2] * acceleration[0]
        + frame[1, 2] * acceleration[1]
        + frame[2, 2] * acceleration[2]
    )
    wx = frame[0, 0] * rotor.spin[0] + frame[1, 0] * rotor.spin[1] + frame[2, 0] * rotor.spin[2]
    wy = frame[0, 1] * rotor.spin[0] + frame[1, 1] * rotor.spin[1] + frame[2, 1] * rotor.spin[2]
    wz = frame[0, 2] * rotor.spin[0] + frame[1, 2] * rotor.spin[1] + frame[2, 2] * rotor.spin[2]
    bx = frame[0, 0] * angular[0] + frame[1, 0] * angular[1] + frame[2, 0] * angular[2]
    by = frame[0, 1] * angular[0] + frame[1, 1] * angular[1] + frame[2, 1] * angular[2]
    bz = frame[0, 2] * angular[0] + frame[1, 2] * angular[1] + frame[2, 2] * angular[2]
    w = work.w
    w[0, 0] = -(wy * wy + wz * wz)
    w[0, 1] = wx * wy - bz
    w[0, 2] = wx * wz + by
    w[1, 0] = wx * wy + bz
    w[1, 1] = -(wx * wx + wz * wz)
    w[1, 2] = wy * wz - bx
    w[2, 0] = wx * wz - by
    w[2, 1] = wy * wz + bx
    w[2, 2] = -(wx * wx + wy * wy)
    c = work.c
    start = BLADES + 2 * k
    for j in range(2):
        x, dx = q[start + j], 2.0 * v[start + j]
        ddx = with_acceleration * a[start + j]
        # columns of [spin] for x and y
        c[j, 0, 0] = x * w[0, 0] + ddx
        c[j, 0, 1] = x * w[1, 0] + dx * wz
        c[j, 0, 2] = x * w[2, 0] - dx * wy
        c[j, 1, 0] = x * w[0, 1] - dx * wz
        c[j, 1, 1] = x * w[1, 1] + ddx
        c[j, 1, 2] = x * w[2, 1] + dx * wx
    force, lever, coupling = work.shape_force[k], work.shape_lever[k], work.shape_coupling[k]
    out = work.inertial[k]
    p0 = body.mass * a0 + body.first * w[0, 2]
    p1 = body.mass * a1 + body.first * w[1, 2]
    p2 = body.mass * a2 + body.first * w[2, 2]
    z0 = body.first * a0 + body.second * w[0, 2]
    z1 = body.first * a1 + body.second * w[1, 2]
    for j in range(2):
        for d in range(2):
            p0 += c[j, d, 0] * force[j, d]
            p1 += c[j, d, 1] * force[j, d]
            p2 += c[j, d, 2] * force[j, d]
            z0 += c[j, d, 0] * lever[j, d]
            z1 += c[j, d, 1] * lever[j, d]
    mx, my, mz = -z1, z0, 0.0
    for i in range(2):
        total = 0.0
        for e in range(2):
            y0 = force[i, e] * a0 + lever[i, e] * w[0, 2]
            y1 = force[i, e] * a1 + lever[i, e] * w[1, 2]
            y2 = force[i, e] * a2 + lever[i, e] * w[2, 2]
            for j in range(2):
                for d in range(2):
                    m = coupling[i, e, j, d]
                    y0 += m * c[j, d, 0]
                    y1 += m * c[j, d, 1]
                    y2 += m * c[j, d, 2]
            x = q[start + i]
            if e == 0:  # e_x cross y
                my -= x * y2
                mz += x * y1
                total += y0
            else:  # e_y cross y
                mx += x * y2
                mz -= x * y0
                total += y1
        for j in range(2):
            total -= q[start + j] * (
                a2 * body.tension_gravity[i, j] + w[2, 2] * body.tension_rotation[i, j]
            )
        out[6 + i] = total
    out[0], out[1], out[2] = p0, p1, p2
    out[3], out[4], out[5] = mx, my, mz


@inlined
def apex_motion(
    body: BodyTables,
    rotor: RotorWork,
    work: MotionWork,
    v: FloatArray,
    a: FloatArray,
    share: float,
    acceleration: FloatArray,
    angular: FloatArray,
) -> None:
    """Apex acceleration less gravity and angular acceleration of the rotor, global.

    Generalised accelerations are those of `a` times `share`.
    """
    spin, hub = work.nacelle_spin, work.hub
    axes = rotor.axes
    ax = -share * a[SIDE_SIDE] * body.tower_slope[1]
    ay = share * a[FORE_AFT] * body.tower_slope[0]
    omega, alpha = v[AZIMUTH], share * a[AZIMUTH]
    # (spin) x ((spin) x hub), spin_z = 0
    dot = spin[0] * hub[0] + spin[1] * hub[1]
    square = spin[0] * spin[0] + spin[1] * spin[1]
    acceleration[0] = share * a[FORE_AFT] + spin[0] * dot - square * hub[0] + ay * hub[2]
    acceleration[1] = share * a[SIDE_SIDE] + spin[1] * dot - square * hub[1] - ax * hub[2]
    acceleration[2] = -square * hub[2] + ax * hub[1] - ay * hub[0] + body.gravity
    angular[0] = ax + alpha * axes[0, 0] + omega * (spin[1] * axes[2, 0])
    angular[1] = ay + alpha * axes[1, 0] - omega * (spin[0] * axes[2, 0])
    angular[2] = alpha * axes[2, 0] + omega * (spin[0] * axes[1, 0] - spin[1] * axes[0, 0])
