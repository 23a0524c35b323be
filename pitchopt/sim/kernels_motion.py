"""Compiled equations of motion of tower, shaft and blades.

Virtual work gives M q'' = Q for the coordinates of `kernels_body`, with the inertial loads of
`kernels_inertia`.  Deflections are of first order; of second order are kept the weight's and the
centrifugal force's geometric stiffness, and in the aerodynamics the shortening and the slope of
the deflected blade.  Left out: the change of the mode shapes' direction with pitch rate and
Coriolis forces of the shortening.
"""

from __future__ import annotations

from pitchopt.checks import FloatArray
from pitchopt.sim.compiling import inlined
from pitchopt.sim.kernels_body import AZIMUTH, BLADES, TWIST, BodyTables, MotionWork
from pitchopt.sim.kernels_inertia import apex_motion, blade_inertia
from pitchopt.sim.kernels_planes import RotorWork

__all__ = ["assemble", "solve"]


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
    apex_motion(body, rotor, work, v, v, 0.0, acceleration, angular)
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
        blade_inertia(body, rotor, work, k, acceleration, angular, q, v, v, 0.0)
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
