"""What the compiled rotor aerodynamics read, remember and write: planes of numbers.

The elements of all blades are worked on together, in loops without branches over *planes*: rows
of `PLANE` numbers in one flat array, one row a quantity, element e of blade k in column
k * padded + e.  Such loops the compiler turns into vector instructions.  Each blade is padded to
a multiple of `LANES` with copies of its last station that carry no weight.

Three arrays are made of planes, and the constants here say where in them a quantity begins: the
tables of the rotor (`T_`), the memory from step to step (`M_`) and the scratch of one evaluation
(`S_`).
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from pitchopt.checks import FloatArray
from pitchopt.errors import InputError

__all__ = [
    "InflowState",
    "RotorTables",
    "RotorWork",
    "element_planes",
    "padded",
    "polar_rows",
]

PLANE = 392  # columns of a plane: the most elements of all blades together, padded
LANES = 8

# planes of the tables
T_SPAN = 0 * PLANE  # with the hub's radius [m]
T_CHORD = 1 * PLANE
T_TWIST = 2 * PLANE
T_PREBEND = 3 * PLANE
T_SWEEP = 4 * PLANE
T_WIDTH = 5 * PLANE
T_LEVER = 6 * PLANE
T_OUTER = 7 * PLANE
T_INNER = 8 * PLANE
T_OPEN = 9 * PLANE  # 0 where blocked
T_REAL = 10 * PLANE  # 0 in the padding
T_SOLID = 11 * PLANE  # solidity times radius [m]
T_SHAPE = 12 * PLANE  # of mode 0 in x and y, of mode 1 in x and y
T_SLOPE = 16 * PLANE
T_SHORT = 20 * PLANE  # by q0^2, q0 q1 and q1^2
T_WEIGHT = 23 * PLANE
TABLE_PLANES = 27

# planes of the memory
M_PHI = 0 * PLANE
M_X = 1 * PLANE
M_THETA = 2 * PLANE
M_BY_X = 3 * PLANE
M_BY_THETA = 4 * PLANE
M_QUASI = 5 * PLANE  # normal, then tangential
M_MIDDLE = 7 * PLANE
M_INDUCED = 9 * PLANE
MEMORY_PLANES = 11

# planes of the scratch
S_X = 0 * PLANE
S_Y = 1 * PLANE
S_Z = 2 * PLANE
S_TILT = 3 * PLANE
S_UX = 4 * PLANE  # the element's own velocity, then the relative wind
S_UY = 5 * PLANE
S_UZ = 6 * PLANE
S_GX = 7 * PLANE  # place in global coordinates, then the wind
S_GY = 8 * PLANE
S_GZ = 9 * PLANE
S_VN = 10 * PLANE
S_VT = 11 * PLANE
S_RADIUS = 12 * PLANE
S_PHI = 13 * PLANE
S_SIN = 14 * PLANE
S_COS = 15 * PLANE
S_LOSS = 16 * PLANE
S_FALL = 17 * PLANE
S_ALPHA = 18 * PLANE
S_LIFT = 19 * PLANE
S_RISE = 20 * PLANE
S_OPEN = 21 * PLANE  # 1 where one step of Newton's method is to do
S_UNSOLVED = 22 * PLANE  # 1 where it did not
S_A = 23 * PLANE
S_SWIRL = 24 * PLANE
S_THETA = 25 * PLANE
S_DRAG = 26 * PLANE
S_MOMENT = 27 * PLANE
S_EN = 28 * PLANE
S_ET = 29 * PLANE
WORK_PLANES = 30


class RotorTables(NamedTuple):
    """A rotor as the time loop sees it; E stations on each of B blades.

    Attributes
    ----------
    blades, stations : int
    planes : ndarray
        Of the stations, see `element_planes`.
    radius : float
        [m].
    cone_cosine, cone_sine : float
    density : float
        [kg/m^3].
    polar : ndarray (P, 7)
        Rows of all polars one after the other, see `polar_rows`.
    first, last : ndarray (E,) int
        First and last row of each station's polar.
    skew, dynamic : bool
        Whether the wake's skew and dynamic inflow are on.
    """

    blades: int
    stations: int
    planes: FloatArray
    radius: float
    cone_cosine: float
    cone_sine: float
    density: float
    polar: FloatArray
    first: NDArray[np.int64]
    last: NDArray[np.int64]
    skew: bool
    dynamic: bool


class InflowState(NamedTuple):
    """What the aerodynamics remember from step to step.

    Attributes
    ----------
    row : ndarray (B, E) int
        Row of the polar used last.
    planes : ndarray
        `MEMORY_PLANES` planes: inflow angle of the last root, V_n / V_t and twist plus pitch it
        belongs to, its derivatives by both; W_qs, W_int and W, each normal and tangential [m/s].
    disc : ndarray (4,)
        Mean axial induction, mean normal wind [m/s], time constant tau_1 [s], 1 once set.
    counts : ndarray (3,) int
        Evaluations of the balance, balances, balances that went to bisection.
    """

    row: NDArray[np.int64]
    planes: FloatArray
    disc: FloatArray
    counts: NDArray[np.int64]


class RotorWork(NamedTuple):
    """Scratch and results of one evaluation.

    Attributes
    ----------
    frame : ndarray (B, 3, 3)
        Columns are x_c, y_b and z_c of each blade in global coordinates.
    axes : ndarray (3, 3)
        Columns are the axes of the hub frame that does not turn.
    apex, apex_velocity, spin : ndarray (3,)
        Position and velocity of the rotor apex, angular velocity of the rotor, global.
    angle : ndarray (B,)
        Azimuth of each blade [rad].
    tower : ndarray (3,)
        Displacement of the tower's top downwind and to the left, and its height [m].
    planes : ndarray
        Scratch of all elements, see `element_planes`.
    force, moment : ndarray (B, 3)
        Aerodynamic, about the apex, in each blade's frame [N, N m].
    modal : ndarray (B, 2)
        Aerodynamic modal forces [N].
    disc_wind : ndarray (3,)
        Mean relative wind over all stations, hub frame [m/s].
    """

    frame: FloatArray
    axes: FloatArray
    apex: FloatArray
    apex_velocity: FloatArray
    spin: FloatArray
    angle: FloatArray
    tower: FloatArray
    planes: FloatArray
    force: FloatArray
    moment: FloatArray
    modal: FloatArray
    disc_wind: FloatArray


def padded(stations: int) -> int:
    """Columns of a blade in a plane."""
    return LANES * -(-stations // LANES)


def polar_rows(
    alpha: FloatArray, lift: FloatArray, drag: FloatArray, moment: FloatArray
) -> FloatArray:
    """Rows (P + 2, 7) of one polar: angle of attack, then each coefficient and its slope.

    The first and the last row hold the end values for a turn beyond the ends.
    """
    rows = np.zeros((alpha.size + 2, 7))
    rows[:, 0] = np.pad(alpha, 1, mode="edge")
    rows[0, 0] -= 2.0 * math.pi
    rows[-1, 0] += 2.0 * math.pi
    for column, values in ((1, lift), (3, drag), (5, moment)):
        rows[:, column] = np.pad(values, 1, mode="edge")
        rows[:-1, column + 1] = np.diff(rows[:, column]) / np.diff(rows[:, 0])
    return rows


def element_planes(
    *,
    blades: int,
    hub_radius: float,
    span: FloatArray,
    chord: FloatArray,
    twist: FloatArray,
    prebend: FloatArray,
    sweep: FloatArray,
    width: FloatArray,
    lever: FloatArray,
    outer: FloatArray,
    inner: FloatArray,
    shape: FloatArray,
    slope: FloatArray,
    shortening: FloatArray,
    weight: FloatArray,
) -> FloatArray:
    """Tables of the stations as planes, one flat array.

    Parameters
    ----------
    hub_radius : float
        [m].
    span, chord, twist, prebend, sweep : ndarray (E,)
        [m, m, rad, m, m].
    width, lever : ndarray (E,)
        Integration weights of the force and of its moment about the apex along z [m, m^2].
    outer, inner : ndarray (E,)
        Constants of tip and hub loss; not positive where the station is blocked.
    shape, slope, shortening, weight : ndarray (E, 2, 2)
        Of the elastic blade, see `pitchopt.sim.structure.BladeModel`.

    Raises
    ------
    InputError
        If the elements do not fit into a plane.
    """
    count = span.size
    per = padded(count)
    if blades * per > PLANE:
        raise InputError(
            f"blade: got {count} stations on each of {blades} blades, expected at most "
            f"{PLANE // blades // LANES * LANES}"
        )
    columns = np.zeros((TABLE_PLANES, per))
    open_ = (outer > 0.0) & (inner > 0.0)
    rows = {
        T_SPAN: hub_radius + span,
        T_CHORD: chord,
        T_TWIST: twist,
        T_PREBEND: prebend,
        T_SWEEP: sweep,
        T_WIDTH: width,
        T_LEVER: lever,
        T_OUTER: np.where(open_, outer, 1.0),
        T_INNER: np.where(open_, inner, 1.0),
        T_OPEN: open_,
        T_REAL: np.ones(count),
        T_SOLID: blades * chord / (2.0 * math.pi),
        T_SHORT: shortening[:, 0, 0],
        T_SHORT + PLANE: shortening[:, 0, 1] + shortening[:, 1, 0],
        T_SHORT + 2 * PLANE: shortening[:, 1, 1],
    }
    for place, values in ((T_SHAPE, shape), (T_SLOPE, slope), (T_WEIGHT, weight)):
        for j in range(2):
            for d in range(2):
                rows[place + (2 * j + d) * PLANE] = values[:, j, d]
    for place, values in rows.items():
        columns[place // PLANE, :count] = values
        columns[place // PLANE, count:] = values[-1]
    for place in (T_WIDTH, T_LEVER, T_REAL, *(T_WEIGHT + j * PLANE for j in range(4))):
        columns[place // PLANE, count:] = 0.0
    planes = np.zeros((TABLE_PLANES, PLANE))
    planes[:, : blades * per] = np.tile(columns, blades)
    return planes.ravel()
