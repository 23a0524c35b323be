"""Compiled kinematics: where rotor and blades are, and how they move.

The tower top turns by the mode's slope, theta_y = phi_fa' q_fa and theta_x = - phi_ss' q_ss, to
second order: I + [theta] + [theta][theta] / 2 ([.] the cross-product matrix).  The frame of a blade
follows from azimuth and cone; the integrals of its mode shapes are turned by its pitch.
"""

from __future__ import annotations

import math

from pitchopt.checks import FloatArray
from pitchopt.sim.compiling import inlined
from pitchopt.sim.kernels_body import AZIMUTH, FORE_AFT, SIDE_SIDE, BodyTables, MotionWork
from pitchopt.sim.kernels_planes import RotorWork

__all__ = ["frames"]


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
