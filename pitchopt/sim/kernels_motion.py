"""Compiled equations of motion of tower, shaft and blades.

Generalised coordinates q, ``(4 + 2 B,)``:

    q[FORE_AFT], q[SIDE_SIDE]   displacement of the tower top downwind, to the left [m]
    q[AZIMUTH]                  of blade 1 about the shaft [rad]
    q[TWIST]                    of the shaft: generator minus rotor, low-speed side [rad]
    q[4 + 2 k], q[5 + 2 k]      flapwise and edgewise deflection of blade k [m]

The tower top turns by the mode's slope, theta_y = phi_fa' q_fa and theta_x = - phi_ss' q_ss.
With apex acceleration A (gravity taken off), angular velocity w and acceleration a of the rotor,
all in the frame of a blade, and W = [a] + [w][w] ([.] the cross-product matrix), the material
point at z has the acceleration

    A + z W e_z + sum_jd c_jd U_jd(z),    c_jd = (q_j W + 2 q_j' [w] + q_j'') e_d,

so that every inertial load of a blade is a sum of the integrals in `pitchopt.sim.structure`.
Virtual work gives M q'' = Q.  Deflections are of first order; of second order are kept the
weight's and the centrifugal force's geometric stiffness, and in the aerodynamics the shortening
and the slope of the deflected blade.  Left out: the change of the mode shapes' direction with
pitch rate and Coriolis forces of the shortening.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from pitchopt.checks import FloatArray
from pitchopt.sim.compiling import inlined
from pitchopt.sim.kernels_planes import RotorWork

__all__ = ["BodyTables", "MotionWork", "assemble", "frames", "reactions", "solve"]

FORE_AFT = 0
SIDE_SIDE = 1
AZIMUTH = 2
TWIST = 3
BLADES = 4


class BodyTables(NamedTuple):
    """Masses and stiffnesses as the time loop sees them.

    Attributes
    ----------
    blades : int
    gravity : float
        [m/s^2].
    mass, first, second : float
        Of a blade, see `BladeModel`.
    force, lever : ndarray (2, 2)
    coupling : ndarray (2, 2, 2, 2)
    stiffness, damping, tension_gravity, tension_rotation : ndarray (2, 2)
        Of a blade.
    hub_radius : float
        Distance of the blade roots from the apex [m].
    cone_cosine, cone_sine : float
    hub_mass, hub_inertia : float
        [kg, kg m^2].
    apex : ndarray (3,)
        Rotor apex from the tower top, undeflected [m].
    top : float
        Height of the tower top [m].
    axes : ndarray (3, 3)
        Columns are the hub frame's axes, undeflected.
    nacelle_mass, bearing_mass : float
        [kg].
    nacelle : ndarray (3,)
        Its centre of mass from the tower top [m].
    generator_inertia : float
        Low-speed side [kg m^2].
    shaft_stiffness, shaft_damping : float
        [N m/rad, N m s/rad].
    tower_mass, tower_stiffness, tower_damping, tower_slope : ndarray (2,)
        The stiffness is without the loss to weight.
    tower_weight : ndarray (2,)
        Loss of stiffness to weight [N/m].
    active : ndarray (4 + 2 B,) int
        1 for the coordinates that move.
    """

    blades: int
    gravity: float
    mass: float
    first: float
    second: float
    force: FloatArray
    lever: FloatArray
    coupling: FloatArray
    stiffness: FloatArray
    damping: FloatArray
    tension_gravity: FloatArray
    tension_rotation: FloatArray
    hub_radius: float
    cone_cosine: float
    cone_sine: float
    hub_mass: float
    hub_inertia: float
    apex: FloatArray
    top: float
    axes: FloatArray
    nacelle_mass: float
    bearing_mass: float
    nacelle: FloatArray
    generator_inertia: float
    shaft_stiffness: float
    shaft_damping: float
    tower_mass: FloatArray
    tower_stiffness: FloatArray
    tower_damping: FloatArray
    tower_slope: FloatArray
    tower_weight: FloatArray
    active: NDArray[np.int64]


class MotionWork(NamedTuple):
    """Scratch and results.

    Attributes
    ----------
    turn : ndarray (3, 3)
        Rotation of the nacelle.
    hub, nacelle : ndarray (3,)
        Rotor apex and nacelle's centre of mass from the tower top, deflected [m].
    nacelle_spin : ndarray (3,)
        [rad/s].
    shape_force, shape_lever : ndarray (B, 2, 2)
        The integrals turned by each blade's pitch.
    shape_coupling : ndarray (B, 2, 2, 2, 2)
    matrix : ndarray (D, D)
        Mass matrix; overwritten by `solve`.
    right : ndarray (D,)
        Forces without those of the linear stiffness and damping.
    inertial : ndarray (B, 8)
        Inertial force (3) and moment about the apex (3) of each blade in its frame, and its
        modal forces.
    w, c : ndarray
        Matrices (3, 3), and coefficients (2, 2, 3) of one blade.
    """

    turn: FloatArray
    hub: FloatArray
    nacelle: FloatArray
    nacelle_spin: FloatArray
    shape_force: FloatArray
    shape_lever: FloatArray
    shape_coupling: FloatArray
    matrix: FloatArray
    right: FloatArray
    inertial: FloatArray
    w: FloatArray
    c: FloatArray


@inlined
def frames(
    body: BodyTables,
    rotor: RotorWork,
    work: MotionWork,
    q: FloatArray,
    v: FloatArray,
    pitch: FloatArray,
) -> None:
    """Positions, velocities and frames of the rotor for a state, and pitched integrals."""
    tx = -body.tower_slope[1] * q[SIDE_SIDE]
    ty = body.tower_slope[0] * q[FORE_AFT]
    turn = work.turn
    # I + [t] + [t][t] / 2
    turn[0, 0] = 1.0 - 0.5 * ty * ty
    turn[0, 1] = 0.5 * tx * ty
    turn[0, 2] = ty
    turn[1, 0] = 0.5 * tx * ty
    turn[1, 1] = 1.0 - 0.5 * tx * tx
    turn[1, 2] = -tx
    turn[2, 0] = -ty
    turn[2, 1] = tx
    turn[2, 2] = 1.0 - 0.5 * (tx * tx + ty * ty)
    spin = work.nacelle_spin
    spin[0] = -body.tower_slope[1] * v[SIDE_SIDE]
    spin[1] = body.tower_slope[0] * v[FORE_AFT]
    spin[2] = 0.0
    for i in range(3):
        hub_i, nacelle_i = 0.0, 0.0
        for j in range(3):
            hub_i += turn[i, j] * body.apex[j]
            nacelle_i += turn[i, j] * body.nacelle[j]
        work.hub[i], work.nacelle[i] = hub_i, nacelle_i
        for j in range(3):
            total = 0.0
            for m in range(3):
                total += turn[i, m] * body.axes[m, j]
            rotor.axes[i, j] = total
    hub = work.hub
    rotor.apex[0] = q[FORE_AFT] + hub[0]
    rotor.apex[1] = q[SIDE_SIDE] + hub[1]
    rotor.apex[2] = body.top + hub[2]
    rotor.apex_velocity[0] = v[FORE_AFT] + spin[1] * hub[2] - spin[2] * hub[1]
    rotor.apex_velocity[1] = v[SIDE_SIDE] + spin[2] * hub[0] - spin[0] * hub[2]
    rotor.apex_velocity[2] = spin[0] * hub[1] - spin[1] * hub[0]
    for i in range(3):
        rotor.spin[i] = spin[i] + v[AZIMUTH] * rotor.axes[i, 0]
    rotor.tower[0], rotor.tower[1], rotor.tower[2] = q[FORE_AFT], q[SIDE_SIDE], body.top
    cone_c, cone_s = body.cone_cosine, body.cone_sine
    for k in range(body.blades):
        psi = q[AZIMUTH] + 2.0 * math.pi * k / body.blades
        rotor.angle[k] = psi
        cp, sp = math.cos(psi), math.sin(psi)
        for i in range(3):
            radial = -sp * rotor.axes[i, 1] + cp * rotor.axes[i, 2]
            rotor.frame[k, i, 0] = cone_c * rotor.axes[i, 0] + cone_s * radial
            rotor.frame[k, i, 1] = cp * rotor.axes[i, 1] + sp * rotor.axes[i, 2]
            rotor.frame[k, i, 2] = cone_c * radial - cone_s * rotor.axes[i, 0]
        cb, sb = math.cos(pitch[k]), math.sin(pitch[k])
        for i in range(2):
            for table, out in (
                (body.force, work.shape_force[k]),
                (body.lever, work.shape_lever[k]),
            ):
                out[i, 0] = table[i, 0] * cb + table[i, 1] * sb
                out[i, 1] = table[i, 1] * cb - table[i, 0] * sb
            for j in range(2):
                xx, xy = body.coupling[i, 0, j, 0], body.coupling[i, 0, j, 1]
                yx, yy = body.coupling[i, 1, j, 0], body.coupling[i, 1, j, 1]
                # both directions turned
                ax, ay = xx * cb + yx * sb, xy * cb + yy * sb
                bx, by = yx * cb - xx * sb, yy * cb - xy * sb
                out4 = work.shape_coupling[k]
                out4[i, 0, j, 0] = ax * cb + ay * sb
                out4[i, 0, j, 1] = ay * cb - ax * sb
                out4[i, 1, j, 0] = bx * cb + by * sb
                out4[i, 1, j, 1] = by * cb - bx * sb


@inlined
def _blade_inertia(
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
def _apex_motion(
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


@inlined
def assemble(
    body: BodyTables,
    rotor: RotorWork,
    work: MotionWork,
    q: FloatArray,
    v: FloatArray,
    generator_torque: float,
    scratch: FloatArray,
) -> None:
    """Mass matrix and right-hand side for the state that `frames` was called with.

    The right-hand side leaves out what `solve` takes implicitly: the linear stiffness and
    damping of tower, blades and shaft.

    Parameters
    ----------
    generator_torque : float
        Low-speed side [N m].
    scratch : ndarray (6, 3)
    """
    blades = body.blades
    size = BLADES + 2 * blades
    matrix, right = work.matrix, work.right
    acceleration, angular = scratch[0], scratch[1]
    _apex_motion(body, rotor, work, v, v, 0.0, acceleration, angular)
    matrix[:] = 0.0
    right[:] = 0.0
    slope_y, slope_x = body.tower_slope[0], -body.tower_slope[1]
    hub, axes = work.hub, rotor.axes
    # columns: velocity of the apex and angular velocity per fore-aft, side-side, azimuth
    v0x, v0y, v0z = 1.0 + slope_y * hub[2], 0.0, -slope_y * hub[0]
    v1x, v1y, v1z = 0.0, 1.0 - slope_x * hub[2], slope_x * hub[1]
    force_x, force_y, force_z = 0.0, 0.0, 0.0
    moment_x, moment_y, moment_z = 0.0, 0.0, 0.0
    for k in range(blades):
        _blade_inertia(body, rotor, work, k, acceleration, angular, q, v, v, 0.0)
        frame = rotor.frame[k]
        inertial = work.inertial[k]
        g0 = rotor.force[k, 0] - inertial[0]
        g1 = rotor.force[k, 1] - inertial[1]
        g2 = rotor.force[k, 2] - inertial[2]
        h0 = rotor.moment[k, 0] - inertial[3]
        h1 = rotor.moment[k, 1] - inertial[4]
        h2 = rotor.moment[k, 2] - inertial[5]
        force_x += frame[0, 0] * g0 + frame[0, 1] * g1 + frame[0, 2] * g2
        force_y += frame[1, 0] * g0 + frame[1, 1] * g1 + frame[1, 2] * g2
        force_z += frame[2, 0] * g0 + frame[2, 1] * g1 + frame[2, 2] * g2
        moment_x += frame[0, 0] * h0 + frame[0, 1] * h1 + frame[0, 2] * h2
        moment_y += frame[1, 0] * h0 + frame[1, 1] * h1 + frame[1, 2] * h2
        moment_z += frame[2, 0] * h0 + frame[2, 1] * h1 + frame[2, 2] * h2
        start = BLADES + 2 * k
        lever, coupling = work.shape_lever[k], work.shape_coupling[k]
        shape_force = work.shape_force[k]
        x0, x1 = q[start], q[start + 1]
        # first moments of mass with deflection, and the inertia about the apex
        sx = x0 * shape_force[0, 0] + x1 * shape_force[1, 0]
        sy = x0 * shape_force[0, 1] + x1 * shape_force[1, 1]
        sz = body.first
        lx = x0 * lever[0, 0] + x1 * lever[1, 0]
        ly = x0 * lever[0, 1] + x1 * lever[1, 1]
        xx, xy, yy = 0.0, 0.0, 0.0
        for i in range(2):
            for j in range(2):
                product = q[start + i] * q[start + j]
                xx += product * coupling[i, 0, j, 0]
                xy += product * coupling[i, 0, j, 1]
                yy += product * coupling[i, 1, j, 1]
        # in the blade frame: velocities and spins of the three columns
        for column in range(3):
            if column == 0:
                ux, uy, uz, rx, ry, rz = v0x, v0y, v0z, 0.0, slope_y, 0.0
            elif column == 1:
                ux, uy, uz, rx, ry, rz = v1x, v1y, v1z, slope_x, 0.0, 0.0
            else:
                ux, uy, uz = 0.0, 0.0, 0.0
                rx, ry, rz = axes[0, 0], axes[1, 0], axes[2, 0]
            scratch[2, 0] = frame[0, 0] * ux + frame[1, 0] * uy + frame[2, 0] * uz
            scratch[2, 1] = frame[0, 1] * ux + frame[1, 1] * uy + frame[2, 1] * uz
            scratch[2, 2] = frame[0, 2] * ux + frame[1, 2] * uy + frame[2, 2] * uz
            scratch[3, 0] = frame[0, 0] * rx + frame[1, 0] * ry + frame[2, 0] * rz
            scratch[3, 1] = frame[0, 1] * rx + frame[1, 1] * ry + frame[2, 1] * rz
            scratch[3, 2] = frame[0, 2] * rx + frame[1, 2] * ry + frame[2, 2] * rz
            a0, a1, a2 = scratch[2, 0], scratch[2, 1], scratch[2, 2]
            b0, b1, b2 = scratch[3, 0], scratch[3, 1], scratch[3, 2]
            # momentum and angular momentum about the apex of unit rate of this column
            p0 = body.mass * a0 + b1 * sz - b2 * sy
            p1 = body.mass * a1 + b2 * sx - b0 * sz
            p2 = body.mass * a2 + b0 * sy - b1 * sx
            l0 = sy * a2 - sz * a1 + (body.second + yy) * b0 - xy * b1 - lx * b2
            l1 = sz * a0 - sx * a2 - xy * b0 + (body.second + xx) * b1 - ly * b2
            l2 = sx * a1 - sy * a0 - lx * b0 - ly * b1 + (xx + yy) * b2
            gx = frame[0, 0] * p0 + frame[0, 1] * p1 + frame[0, 2] * p2
            gy = frame[1, 0] * p0 + frame[1, 1] * p1 + frame[1, 2] * p2
            gz = frame[2, 0] * p0 + frame[2, 1] * p1 + frame[2, 2] * p2
            mx = frame[0, 0] * l0 + frame[0, 1] * l1 + frame[0, 2] * l2
            my = frame[1, 0] * l0 + frame[1, 1] * l1 + frame[1, 2] * l2
            mz = frame[2, 0] * l0 + frame[2, 1] * l1 + frame[2, 2] * l2
            matrix[0, column] += v0x * gx + v0y * gy + v0z * gz + slope_y * my
            matrix[1, column] += v1x * gx + v1y * gy + v1z * gz + slope_x * mx
            matrix[2, column] += axes[0, 0] * mx + axes[1, 0] * my + axes[2, 0] * mz
            for j in range(2):
                fx, fy = shape_force[j, 0], shape_force[j, 1]
                # int m rho x U_j
                cross = 0.0
                for i in range(2):
                    cross += q[start + i] * (coupling[i, 0, j, 1] - coupling[i, 1, j, 0])
                value = fx * a0 + fy * a1 - lever[j, 1] * b0 + lever[j, 0] * b1 + cross * b2
                matrix[start + j, column] += value
                matrix[column, start + j] += value
        for i in range(2):
            for j in range(2):
                matrix[start + i, start + j] = coupling[i, 0, j, 0] + coupling[i, 1, j, 1]
            right[start + i] = rotor.modal[k, i] - inertial[6 + i]
    # hub at the apex
    mass = body.hub_mass
    matrix[0, 0] += mass * (v0x * v0x + v0z * v0z)
    matrix[1, 1] += mass * (v1y * v1y + v1z * v1z)
    matrix[0, 1] += mass * v0z * v1z
    matrix[1, 0] += mass * v0z * v1z
    force_x -= mass * acceleration[0]
    force_y -= mass * acceleration[1]
    force_z -= mass * acceleration[2]
    inertia = body.hub_inertia
    spins = (slope_y * axes[1, 0], slope_x * axes[0, 0], 1.0)
    for i in range(3):
        for j in range(3):
            matrix[i, j] += inertia * spins[i] * spins[j]
    spin = work.nacelle_spin
    omega = v[AZIMUTH]
    # hub's angular momentum turns with the nacelle
    moment_x -= inertia * omega * spin[1] * axes[2, 0]
    moment_y += inertia * omega * spin[0] * axes[2, 0]
    moment_z -= inertia * omega * (spin[0] * axes[1, 0] - spin[1] * axes[0, 0])
    right[0] += v0x * force_x + v0y * force_y + v0z * force_z + slope_y * moment_y
    right[1] += v1x * force_x + v1y * force_y + v1z * force_z + slope_x * moment_x
    right[2] += axes[0, 0] * moment_x + axes[1, 0] * moment_y + axes[2, 0] * moment_z
    # nacelle
    mass = body.nacelle_mass
    centre = work.nacelle
    n0x, n0z = 1.0 + slope_y * centre[2], -slope_y * centre[0]
    n1y, n1z = 1.0 - slope_x * centre[2], slope_x * centre[1]
    matrix[0, 0] += mass * (n0x * n0x + n0z * n0z) + body.bearing_mass + body.tower_mass[0]
    matrix[1, 1] += mass * (n1y * n1y + n1z * n1z) + body.bearing_mass + body.tower_mass[1]
    matrix[0, 1] += mass * n0z * n1z
    matrix[1, 0] += mass * n0z * n1z
    dot = spin[0] * centre[0] + spin[1] * centre[1]
    square = spin[0] * spin[0] + spin[1] * spin[1]
    nx = spin[0] * dot - square * centre[0]
    ny = spin[1] * dot - square * centre[1]
    nz = -square * centre[2] + body.gravity
    right[0] -= mass * (n0x * nx + n0z * nz)
    right[1] -= mass * (n1y * ny + n1z * nz)
    # weight takes stiffness from the tower
    right[0] += body.tower_weight[0] * q[0]
    right[1] += body.tower_weight[1] * q[1]
    # generator turns with azimuth and shaft twist
    generator = body.generator_inertia
    matrix[2, 2] += generator
    matrix[2, 3] += generator
    matrix[3, 2] += generator
    matrix[3, 3] += generator
    right[2] -= generator_torque
    right[3] -= generator_torque
    for i in range(size):
        if body.active[i] == 0:
            for j in range(size):
                matrix[i, j] = 0.0
                matrix[j, i] = 0.0
            matrix[i, i] = 1.0


@inlined
def solve(
    body: BodyTables, work: MotionWork, q: FloatArray, v: FloatArray, step: float, a: FloatArray
) -> bool:
    """Accelerations `a` (overwritten) from the matrix and right-hand side of `assemble`.

    Stiffness K and damping C act at q + h^2/4 a and v + h/2 a, with q and v the explicit parts
    of the step (trapezium rule; h = 0: at the state itself).  The matrix is an arrow: blades are
    tied to tower and shaft but not to each other, so each blade's two coordinates are eliminated
    first and four remain.  Returns whether the matrix is positive definite.
    """
    matrix, right, active = work.matrix, work.right, body.active
    stiffness, damping = body.stiffness, body.damping
    quarter, half = 0.25 * step * step, 0.5 * step
    for i in range(BLADES):
        a[i] = right[i] if active[i] == 1 else 0.0
    for i in range(2):
        if active[i] == 1:
            a[i] -= body.tower_stiffness[i] * q[i] + body.tower_damping[i] * v[i]
            matrix[i, i] += quarter * body.tower_stiffness[i] + half * body.tower_damping[i]
    if active[TWIST] == 1:
        a[TWIST] -= body.shaft_stiffness * q[TWIST] + body.shaft_damping * v[TWIST]
        matrix[TWIST, TWIST] += quarter * body.shaft_stiffness + half * body.shaft_damping
    for k in range(body.blades):
        flap, edge = BLADES + 2 * k, BLADES + 2 * k + 1
        on_flap, on_edge = active[flap] == 1, active[edge] == 1
        b00, b01, b11 = matrix[flap, flap], matrix[flap, edge], matrix[edge, edge]
        q0, q1, v0, v1 = q[flap], q[edge], v[flap], v[edge]
        r0, r1 = 0.0, 0.0
        if on_flap:
            r0 = right[flap] - stiffness[0, 0] * q0 - stiffness[0, 1] * q1
            r0 -= damping[0, 0] * v0 + damping[0, 1] * v1
            b00 += quarter * stiffness[0, 0] + half * damping[0, 0]
        if on_edge:
            r1 = right[edge] - stiffness[1, 0] * q0 - stiffness[1, 1] * q1
            r1 -= damping[1, 0] * v0 + damping[1, 1] * v1
            b11 += quarter * stiffness[1, 1] + half * damping[1, 1]
        if on_flap and on_edge:
            b01 += quarter * stiffness[0, 1] + half * damping[0, 1]
        determinant = b00 * b11 - b01 * b01
        if not (b00 > 0.0 and determinant > 0.0):
            return False
        # inverse of the blade's block, kept for the way back
        per = 1.0 / determinant
        b00, b01, b11 = b11 * per, -b01 * per, b00 * per
        matrix[flap, flap], matrix[flap, edge], matrix[edge, edge] = b00, b01, b11
        a[flap], a[edge] = r0, r1
        for i in range(TWIST):  # the twist is not tied to the blades
            c0, c1 = matrix[flap, i], matrix[edge, i]
            y0, y1 = b00 * c0 + b01 * c1, b01 * c0 + b11 * c1
            a[i] -= y0 * r0 + y1 * r1
            for j in range(i + 1):
                matrix[i, j] -= y0 * matrix[flap, j] + y1 * matrix[edge, j]
    # L D L' of what remains, in place
    for j in range(BLADES):
        pivot = matrix[j, j]
        if not (pivot > 0.0):
            return False
        per = 1.0 / pivot
        for i in range(j + 1, BLADES):
            share = matrix[i, j] * per
            a[i] -= share * a[j]
            for m in range(j + 1, i + 1):
                matrix[i, m] -= share * matrix[m, j]
        matrix[j, j] = per
    for i in range(BLADES - 1, -1, -1):
        total = a[i]
        for m in range(i + 1, BLADES):
            total -= matrix[m, i] * a[m]
        a[i] = total * matrix[i, i]
    for k in range(body.blades):
        flap, edge = BLADES + 2 * k, BLADES + 2 * k + 1
        r0, r1 = a[flap], a[edge]
        for i in range(TWIST):
            r0 -= matrix[flap, i] * a[i]
            r1 -= matrix[edge, i] * a[i]
        b00, b01, b11 = matrix[flap, flap], matrix[flap, edge], matrix[edge, edge]
        a[flap], a[edge] = b00 * r0 + b01 * r1, b01 * r0 + b11 * r1
    return True


@inlined
def reactions(
    body: BodyTables,
    rotor: RotorWork,
    work: MotionWork,
    q: FloatArray,
    v: FloatArray,
    a: FloatArray,
    root: FloatArray,
    hub: FloatArray,
    top: FloatArray,
    scratch: FloatArray,
) -> None:
    """Section loads for state and accelerations, in the configuration of `frames`.

    Parameters
    ----------
    root : ndarray (B, 6)
        Force and moment at the blade roots, each in its coned frame [N, N m].
    hub : ndarray (6,)
        Force and moment of the rotor, hub included, at the apex in the hub frame that does not
        turn.
    top : ndarray (6,)
        Force and moment that nacelle and rotor put on the tower top, global.
    scratch : ndarray (6, 3)
    """
    acceleration, angular = scratch[0], scratch[1]
    _apex_motion(body, rotor, work, v, a, 1.0, acceleration, angular)
    total, moment = scratch[2], scratch[3]
    total[:] = 0.0
    moment[:] = 0.0
    for k in range(body.blades):
        _blade_inertia(body, rotor, work, k, acceleration, angular, q, v, a, 1.0)
        inertial, frame = work.inertial[k], rotor.frame[k]
        for i in range(3):
            root[k, i] = rotor.force[k, i] - inertial[i]
            root[k, 3 + i] = rotor.moment[k, i] - inertial[3 + i]
        for i in range(3):
            for j in range(3):
                total[i] += frame[i, j] * root[k, j]
                moment[i] += frame[i, j] * root[k, 3 + j]
        # about the root: minus hub_radius e_z cross force
        root[k, 3] += body.hub_radius * root[k, 1]
        root[k, 4] -= body.hub_radius * root[k, 0]
    axes = rotor.axes
    about = 0.0
    for i in range(3):
        total[i] -= body.hub_mass * acceleration[i]
        about += angular[i] * axes[i, 0]
    spin, omega = work.nacelle_spin, v[AZIMUTH]
    inertia = body.hub_inertia
    moment[0] -= inertia * (about * axes[0, 0] + omega * spin[1] * axes[2, 0])
    moment[1] -= inertia * (about * axes[1, 0] - omega * spin[0] * axes[2, 0])
    moment[2] -= inertia * (
        about * axes[2, 0] + omega * (spin[0] * axes[1, 0] - spin[1] * axes[0, 0])
    )
    for i in range(3):
        hub[i] = axes[0, i] * total[0] + axes[1, i] * total[1] + axes[2, i] * total[2]
        hub[3 + i] = axes[0, i] * moment[0] + axes[1, i] * moment[1] + axes[2, i] * moment[2]
    arm = work.hub
    top[3] = moment[0] + arm[1] * total[2] - arm[2] * total[1]
    top[4] = moment[1] + arm[2] * total[0] - arm[0] * total[2]
    top[5] = moment[2] + arm[0] * total[1] - arm[1] * total[0]
    centre = work.nacelle
    ax = -body.tower_slope[1] * a[SIDE_SIDE]
    ay = body.tower_slope[0] * a[FORE_AFT]
    dot = spin[0] * centre[0] + spin[1] * centre[1]
    square = spin[0] * spin[0] + spin[1] * spin[1]
    n = scratch[4]
    n[0] = a[FORE_AFT] + spin[0] * dot - square * centre[0] + ay * centre[2]
    n[1] = a[SIDE_SIDE] + spin[1] * dot - square * centre[1] - ax * centre[2]
    n[2] = -square * centre[2] + ax * centre[1] - ay * centre[0] + body.gravity
    for i in range(3):
        n[i] *= -body.nacelle_mass
        top[i] = total[i] + n[i]
    top[3] += centre[1] * n[2] - centre[2] * n[1]
    top[4] += centre[2] * n[0] - centre[0] * n[2]
    top[5] += centre[0] * n[1] - centre[1] * n[0]
    top[0] -= body.bearing_mass * a[FORE_AFT]
    top[1] -= body.bearing_mass * a[SIDE_SIDE]
    top[2] -= body.bearing_mass * body.gravity
