"""Compiled section loads: blade roots, hub and tower top.

They follow from equilibrium: what the aerodynamics put on the parts beyond a section less what
these parts need for their acceleration, weight included (`kernels_inertia`).
"""

from __future__ import annotations

from pitchopt.checks import FloatArray
from pitchopt.sim.compiling import inlined
from pitchopt.sim.kernels_body import AZIMUTH, FORE_AFT, SIDE_SIDE, BodyTables, MotionWork
from pitchopt.sim.kernels_inertia import apex_motion, blade_inertia
from pitchopt.sim.kernels_planes import RotorWork

__all__ = ["reactions"]


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
    apex_motion(body, rotor, work, v, a, 1.0, acceleration, angular)
    total, moment = scratch[2], scratch[3]
    total[:] = 0.0
    moment[:] = 0.0
    for k in range(body.blades):
        blade_inertia(body, rotor, work, k, acceleration, angular, q, v, a, 1.0)
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
