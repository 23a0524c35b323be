"""What the compiled motion reads and writes: coordinates, masses and stiffnesses, scratch.

Generalised coordinates q, ``(4 + 2 B,)``:

    q[FORE_AFT], q[SIDE_SIDE]   displacement of the tower top downwind, to the left [m]
    q[AZIMUTH]                  of blade 1 about the shaft [rad]
    q[TWIST]                    of the shaft: generator minus rotor, low-speed side [rad]
    q[4 + 2 k], q[5 + 2 k]      flapwise and edgewise deflection of blade k [m]
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from pitchopt.checks import FloatArray

__all__ = ["BodyTables", "MotionWork"]

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
