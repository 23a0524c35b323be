"""Compiled rotor aerodynamics: flow at every blade element, induction, blade loads.

The elements of all blades are worked on together, in loops without branches over *planes*: rows
of `PLANE` numbers in one flat array, one row a quantity, element e of blade k in column
k * padded + e.  Such loops the compiler turns into vector instructions; looking up wind and
polars is left to loops of its own between them.  Each blade is padded to a multiple of eight
with copies of its last station that carry no weight.

The momentum balance (`pitchopt.sim.kernels_balance`) is solved by Newton's method from a
prediction: the last root moved along its derivatives by the change of x and of the pitch since.
In most steps one evaluation does; elements where it does not are gone through one by one.

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
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from pitchopt.checks import FloatArray
from pitchopt.errors import InputError
from pitchopt.sim.compiling import inlined, summing
from pitchopt.sim.kernels_balance import (
    ACCEPT,
    EDGE,
    HIGH,
    STILL,
    balance,
    loss,
    newton_step,
    polar_row,
)
from pitchopt.sim.kernels_math import angle, falling, sine_cosine
from pitchopt.sim.kernels_wind import (
    NO_BOX,
    POLAR,
    WindTables,
    fluctuation,
    table,
    tower_disturbance,
)

__all__ = [
    "MEMORY_PLANES",
    "PLANE",
    "WORK_PLANES",
    "InflowState",
    "RotorTables",
    "RotorWork",
    "element_planes",
    "padded",
    "polar_rows",
    "rotor_aerodynamics",
]

_SKEW = 15.0 * math.pi / 32.0
_FILTER = 0.6  # k of the first stage

PLANE = 392  # columns of a plane: the most elements of all blades together, padded
_LANES = 8

# planes of the tables
_T_SPAN = 0 * PLANE  # with the hub's radius [m]
_T_CHORD = 1 * PLANE
_T_TWIST = 2 * PLANE
_T_PREBEND = 3 * PLANE
_T_SWEEP = 4 * PLANE
_T_WIDTH = 5 * PLANE
_T_LEVER = 6 * PLANE
_T_OUTER = 7 * PLANE
_T_INNER = 8 * PLANE
_T_OPEN = 9 * PLANE  # 0 where blocked
_T_REAL = 10 * PLANE  # 0 in the padding
_T_SOLID = 11 * PLANE  # solidity times radius [m]
_T_SHAPE = 12 * PLANE  # of mode 0 in x and y, of mode 1 in x and y
_T_SLOPE = 16 * PLANE
_T_SHORT = 20 * PLANE  # by q0^2, q0 q1 and q1^2
_T_WEIGHT = 23 * PLANE
_TABLE_PLANES = 27

# planes of the memory
_M_PHI = 0 * PLANE
_M_X = 1 * PLANE
_M_THETA = 2 * PLANE
_M_BY_X = 3 * PLANE
_M_BY_THETA = 4 * PLANE
_M_QUASI = 5 * PLANE  # normal, then tangential
_M_MIDDLE = 7 * PLANE
_M_INDUCED = 9 * PLANE
MEMORY_PLANES = 11

# planes of the scratch
_X = 0 * PLANE
_Y = 1 * PLANE
_Z = 2 * PLANE
_TILT = 3 * PLANE
_UX = 4 * PLANE  # the element's own velocity, then the relative wind
_UY = 5 * PLANE
_UZ = 6 * PLANE
_GX = 7 * PLANE  # place in global coordinates, then the wind
_GY = 8 * PLANE
_GZ = 9 * PLANE
_VN = 10 * PLANE
_VT = 11 * PLANE
_RADIUS = 12 * PLANE
_PHI = 13 * PLANE
_SIN = 14 * PLANE
_COS = 15 * PLANE
_LOSS = 16 * PLANE
_FALL = 17 * PLANE
_ALPHA = 18 * PLANE
_LIFT = 19 * PLANE
_RISE = 20 * PLANE
_OPEN = 21 * PLANE  # 1 where one step of Newton's method is to do
_UNSOLVED = 22 * PLANE  # 1 where it did not
_A = 23 * PLANE
_SWIRL = 24 * PLANE
_THETA = 25 * PLANE
_DRAG = 26 * PLANE
_MOMENT = 27 * PLANE
_EN = 28 * PLANE
_ET = 29 * PLANE
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
    return _LANES * -(-stations // _LANES)


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
            f"{PLANE // blades // _LANES * _LANES}"
        )
    columns = np.zeros((_TABLE_PLANES, per))
    open_ = (outer > 0.0) & (inner > 0.0)
    rows = {
        _T_SPAN: hub_radius + span,
        _T_CHORD: chord,
        _T_TWIST: twist,
        _T_PREBEND: prebend,
        _T_SWEEP: sweep,
        _T_WIDTH: width,
        _T_LEVER: lever,
        _T_OUTER: np.where(open_, outer, 1.0),
        _T_INNER: np.where(open_, inner, 1.0),
        _T_OPEN: open_,
        _T_REAL: np.ones(count),
        _T_SOLID: blades * chord / (2.0 * math.pi),
        _T_SHORT: shortening[:, 0, 0],
        _T_SHORT + PLANE: shortening[:, 0, 1] + shortening[:, 1, 0],
        _T_SHORT + 2 * PLANE: shortening[:, 1, 1],
    }
    for place, values in ((_T_SHAPE, shape), (_T_SLOPE, slope), (_T_WEIGHT, weight)):
        for j in range(2):
            for d in range(2):
                rows[place + (2 * j + d) * PLANE] = values[:, j, d]
    for place, values in rows.items():
        columns[place // PLANE, :count] = values
        columns[place // PLANE, count:] = values[-1]
    for place in (_T_WIDTH, _T_LEVER, _T_REAL, *(_T_WEIGHT + j * PLANE for j in range(4))):
        columns[place // PLANE, count:] = 0.0
    planes = np.zeros((_TABLE_PLANES, PLANE))
    planes[:, : blades * per] = np.tile(columns, blades)
    return planes.ravel()


@summing
def _place(s, t, stop, frame, apex, velocity, spin, cb, sb, rate, q, d):  # type: ignore[no-untyped-def]
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
        s00, s01 = t[_T_SHAPE + e], t[_T_SHAPE + PLANE + e]
        s10, s11 = t[_T_SHAPE + 2 * PLANE + e], t[_T_SHAPE + 3 * PLANE + e]
        px, py = q0 * s00 + q1 * s10, q0 * s01 + q1 * s11
        rx, ry = d0 * s00 + d1 * s10, d0 * s01 + d1 * s11
        ox = t[_T_PREBEND + e] * cb + t[_T_SWEEP + e] * sb
        oy = t[_T_SWEEP + e] * cb - t[_T_PREBEND + e] * sb
        s[_X + e], s[_Y + e] = ox + px * cb + py * sb, oy + py * cb - px * sb
        s[_UX + e] = rx * cb + ry * sb + rate * oy
        s[_UY + e] = ry * cb - rx * sb - rate * ox
    for e in range(stop):
        sx = q0 * t[_T_SLOPE + e] + q1 * t[_T_SLOPE + 2 * PLANE + e]
        sy = q0 * t[_T_SLOPE + PLANE + e] + q1 * t[_T_SLOPE + 3 * PLANE + e]
        s[_TILT + e] = sx * cb + sy * sb
        s[_Z + e] = t[_T_SPAN + e] - (
            q00 * t[_T_SHORT + e]
            + q01 * t[_T_SHORT + PLANE + e]
            + q11 * t[_T_SHORT + 2 * PLANE + e]
        )
    for e in range(stop):
        x, y, z = s[_X + e], s[_Y + e], s[_Z + e]
        s[_UX + e] += vx + wy * z - wz * y
        s[_UY + e] += vy + wz * x - wx * z
        s[_UZ + e] = vz + wx * y - wy * x
        s[_GX + e] = ax + f00 * x + f01 * y + f02 * z
        s[_GY + e] = ay + f10 * x + f11 * y + f12 * z
        s[_GZ + e] = az + f20 * x + f21 * y + f22 * z


@inlined
def _wind(s, wind, stop, hub_speed, time, top_x, top_y, top_height):  # type: ignore[no-untyped-def]
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
        x, y, z = s[_GX + e], s[_GY + e], s[_GZ + e]
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
        s[_GX + e], s[_GY + e], s[_GZ + e] = a, b, w


@summing
def _relative(s, t, stop, frame):  # type: ignore[no-untyped-def]
    """Relative wind of one blade's elements; its sum in the blade's frame."""
    f00, f01, f02 = frame[0, 0], frame[0, 1], frame[0, 2]
    f10, f11, f12 = frame[1, 0], frame[1, 1], frame[1, 2]
    f20, f21, f22 = frame[2, 0], frame[2, 1], frame[2, 2]
    sum_x, sum_y, sum_z = 0.0, 0.0, 0.0
    for e in range(stop):
        a, b, c = s[_GX + e], s[_GY + e], s[_GZ + e]
        nx = f00 * a + f10 * b + f20 * c - s[_UX + e]
        ny = f01 * a + f11 * b + f21 * c - s[_UY + e]
        nz = f02 * a + f12 * b + f22 * c - s[_UZ + e]
        real = t[_T_REAL + e]
        sum_x += real * nx
        sum_y += real * ny
        sum_z += real * nz
        tilt = s[_TILT + e]
        s[_VN + e] = (nx - tilt * nz) / math.sqrt(1.0 + tilt * tilt)
        s[_VT + e] = ny
    return sum_x, sum_y, sum_z


@summing
def _predict(s, t, m, stop, pitch, cone_c, cone_s):  # type: ignore[no-untyped-def]
    """Predicted inflow angle of one blade's elements, and what goes with it."""
    for e in range(stop):
        vn, vt = s[_VN + e], s[_VT + e]
        theta = t[_T_TWIST + e] + pitch
        radial, y = cone_c * s[_Z + e] + cone_s * s[_X + e], s[_Y + e]
        s[_THETA + e] = theta
        s[_RADIUS + e] = math.sqrt(radial * radial + y * y)
        plain = (vn > STILL) & (vt > STILL)
        x = vn / (vt if plain else 1.0)
        last = m[_M_PHI + e]
        phi = (
            last
            + m[_M_BY_X + e] * (x - m[_M_X + e])
            + m[_M_BY_THETA + e] * (theta - m[_M_THETA + e])
        )
        inside = plain & (last > 0.0) & (phi > EDGE) & (phi < HIGH)
        s[_OPEN + e] = 1.0 if inside else 0.0
        phi = phi if inside else 0.5
        sine, cosine = sine_cosine(phi)
        s[_PHI + e], s[_SIN + e], s[_COS + e] = phi, sine, cosine
        s[_ALPHA + e] = phi - theta
        s[_LOSS + e], s[_FALL + e] = loss(t[_T_OUTER + e], t[_T_INNER + e], sine, cosine)


@summing
def _look_up_lift(s, rows, first, last, polar):  # type: ignore[no-untyped-def]
    """Lift coefficient and its slope for the elements of one blade."""
    for e in range(rows.size):
        alpha = s[_ALPHA + e]
        row = polar_row(polar, first[e], last[e], rows[e], alpha)
        rows[e] = row
        gap = alpha - polar[row, 0]
        s[_LIFT + e] = polar[row, 1] + gap * polar[row, 2]
        s[_RISE + e] = polar[row, 2]


@summing
def _newton(s, t, m, stop):  # type: ignore[no-untyped-def]
    """One step of Newton's method in all columns; marks those where it does not do."""
    missing = 0.0
    for e in range(stop):
        vn, vt, sine = s[_VN + e], s[_VT + e], s[_SIN + e]
        go = s[_OPEN + e] > 0.0
        x = vn / (vt if go else 1.0)
        change, a, swirl, by_x, by_theta, good = newton_step(
            sine,
            s[_COS + e],
            x if go else 1.0,
            s[_LIFT + e],
            s[_RISE + e],
            s[_LOSS + e],
            s[_FALL + e],
            t[_T_SOLID + e] / s[_RADIUS + e],
        )
        unblocked = t[_T_OPEN + e] > 0.0
        still = (abs(vn) <= STILL) | (abs(vt) <= STILL)
        done = go & good & (abs(change) < ACCEPT * sine) & unblocked
        m[_M_PHI + e] = s[_PHI + e] + change if done else m[_M_PHI + e]
        m[_M_X + e] = x if done else m[_M_X + e]
        m[_M_THETA + e] = s[_THETA + e] if done else m[_M_THETA + e]
        m[_M_BY_X + e] = by_x if done else m[_M_BY_X + e]
        m[_M_BY_THETA + e] = by_theta if done else m[_M_BY_THETA + e]
        a = a if done else 0.0
        s[_A + e] = a if unblocked else 1.0
        s[_SWIRL + e] = swirl if done else 0.0
        todo = 0.0 if (done | still) | (not unblocked) else t[_T_REAL + e]
        s[_UNSOLVED + e] = todo
        missing += todo
    return missing


@summing
def _balance_one(s, t, m, e, row, first, last, polar, counts):  # type: ignore[no-untyped-def]
    """Momentum balance in column e without a usable prediction."""
    vn, vt, theta = s[_VN + e], s[_VT + e], s[_THETA + e]
    phi, a, swirl, by_x, by_theta, row = balance(
        polar,
        first,
        last,
        row,
        t[_T_OUTER + e],
        t[_T_INNER + e],
        s[_PHI + e] if s[_OPEN + e] > 0.0 else -1.0,
        vn,
        vt,
        theta,
        t[_T_SOLID + e] / s[_RADIUS + e],
        counts,
    )
    m[_M_PHI + e], m[_M_X + e], m[_M_THETA + e] = phi, vn / vt, theta
    m[_M_BY_X + e], m[_M_BY_THETA + e] = by_x, by_theta
    s[_A + e], s[_SWIRL + e] = a, swirl
    return row


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
def _dynamic_inflow(s, m, stop, fresh, step, tau, decay, per_tip):  # type: ignore[no-untyped-def]
    """Filter the induced velocity of one blade's elements; `fresh` sets it instead."""
    per_tau = step / tau
    rate = 1.0 / step if step > 0.0 else 0.0
    for e in range(stop):
        wn, wt = -s[_A + e] * s[_VN + e], s[_SWIRL + e] * s[_VT + e]
        share = s[_RADIUS + e] * per_tip
        ratio = 0.39 - 0.26 * share * share
        decay2 = falling(per_tau / ratio)
        per = 1.0 / (1.0 - ratio)
        lag = tau * (1.0 + ratio)
        mn, qn = _filtered(
            m[_M_QUASI + e],
            wn,
            m[_M_MIDDLE + e],
            m[_M_INDUCED + e],
            step,
            rate,
            tau,
            lag,
            per,
            decay,
            decay2,
        )
        mt, qt = _filtered(
            m[_M_QUASI + PLANE + e],
            wt,
            m[_M_MIDDLE + PLANE + e],
            m[_M_INDUCED + PLANE + e],
            step,
            rate,
            tau,
            lag,
            per,
            decay,
            decay2,
        )
        qn, qt = wn if fresh else qn, wt if fresh else qt
        m[_M_QUASI + e], m[_M_QUASI + PLANE + e] = wn, wt
        m[_M_MIDDLE + e] = wn if fresh else mn
        m[_M_MIDDLE + PLANE + e] = wt if fresh else mt
        m[_M_INDUCED + e], m[_M_INDUCED + PLANE + e] = qn, qt
        s[_EN + e], s[_ET + e] = qn, qt


@summing
def _quasi_steady(s, stop):  # type: ignore[no-untyped-def]
    """Induced velocity of the momentum balance itself."""
    for e in range(stop):
        s[_EN + e] = -s[_A + e] * s[_VN + e]
        s[_ET + e] = s[_SWIRL + e] * s[_VT + e]


@summing
def _final(s, t, stop, skew, direction):  # type: ignore[no-untyped-def]
    """Relative wind with induction and skew, and the angle of attack, of one blade's elements.

    Stations that are blocked keep their induction whatever the skew.
    """
    for e in range(stop):
        vn, wn = s[_VN + e], s[_EN + e]
        used = -wn / (vn if vn != 0.0 else 1.0)
        half = min(max(0.5 * (1.0 + 0.6 * used) * skew, -0.25 * math.pi), 0.25 * math.pi)
        sine, cosine = sine_cosine(half)
        turned = t[_T_OPEN + e] * direction * s[_RADIUS + e] * sine / cosine
        en = vn + wn * (1.0 + turned)
        et = s[_VT + e] + s[_ET + e]
        s[_EN + e], s[_ET + e] = en, et
        s[_ALPHA + e] = angle(en, et) - s[_THETA + e]


@summing
def _look_up(s, rows, first, last, polar):  # type: ignore[no-untyped-def]
    """All coefficients for the elements of one blade."""
    for e in range(rows.size):
        low, high = first[e], last[e]
        alpha = min(max(s[_ALPHA + e], polar[low, 0]), polar[high, 0])
        row = polar_row(polar, low, high, rows[e], alpha)
        gap = alpha - polar[row, 0]
        s[_LIFT + e] = polar[row, 1] + gap * polar[row, 2]
        s[_DRAG + e] = polar[row, 3] + gap * polar[row, 4]
        s[_MOMENT + e] = polar[row, 5] + gap * polar[row, 6]


@summing
def _integrate(s, t, stop, density, cb, sb, force, moment, modal):  # type: ignore[no-untyped-def]
    """Loads of one blade; returns the sum of its axial induction factors."""
    fx_sum, fy_sum, fz_sum = 0.0, 0.0, 0.0
    mx_sum, my_sum, mz_sum = 0.0, 0.0, 0.0
    m0, m1, total = 0.0, 0.0, 0.0
    for e in range(stop):
        en, et = s[_EN + e], s[_ET + e]
        x, y, z = s[_X + e], s[_Y + e], s[_Z + e]
        chord = t[_T_CHORD + e]
        # pressure times speed: the sine and cosine of the inflow angle are en and et over it
        speed = math.sqrt(en * en + et * et)
        pressure = 0.5 * density * chord * speed
        lift, drag = pressure * s[_LIFT + e], pressure * s[_DRAG + e]
        fx = lift * et + drag * en
        fy = drag * et - lift * en
        fz = -s[_TILT + e] * fx
        twisting = pressure * speed * chord * s[_MOMENT + e]
        width = t[_T_WIDTH + e]
        lever = t[_T_LEVER + e] + width * (z - t[_T_SPAN + e])
        fx_sum += width * fx
        fy_sum += width * fy
        fz_sum += width * fz
        mx_sum += width * y * fz - lever * fy
        my_sum += lever * fx - width * x * fz
        mz_sum += width * (x * fy - y * fx + twisting)
        # turned back by pitch, to the frame of the mode shapes
        bx, by = fx * cb - fy * sb, fy * cb + fx * sb
        m0 += bx * t[_T_WEIGHT + e] + by * t[_T_WEIGHT + PLANE + e]
        m1 += bx * t[_T_WEIGHT + 2 * PLANE + e] + by * t[_T_WEIGHT + 3 * PLANE + e]
        total += t[_T_REAL + e] * s[_A + e]
    force[0], force[1], force[2] = fx_sum, fy_sum, fz_sum
    moment[0], moment[1], moment[2] = mx_sum, my_sum, mz_sum
    modal[0], modal[1] = m0, m1
    return total


@inlined
def rotor_aerodynamics(
    tables: RotorTables,
    wind: WindTables,
    state: InflowState,
    work: RotorWork,
    hub_speed: float,
    time: float,
    step: float,
    pitch: FloatArray,
    pitch_rate: FloatArray,
    bend: FloatArray,
    bend_rate: FloatArray,
) -> None:
    """Aerodynamic loads of all blades at `time`, a step after the last call.

    Parameters
    ----------
    hub_speed : float
        Of the wind [m/s].
    step : float
        Time since the last evaluation [s], zero to evaluate without moving the inflow on.
    pitch, pitch_rate : ndarray (B,)
        [rad, rad/s].
    bend, bend_rate : ndarray (B, 2)
        Modal deflections and their rates [m, m/s].
    """
    blades, count, t, m, s = (
        tables.blades,
        tables.stations,
        tables.planes,
        state.planes,
        work.planes,
    )
    per = _LANES * ((count + _LANES - 1) // _LANES)
    stop = blades * per
    rows, polar, first, last = state.row, tables.polar, tables.first, tables.last
    cone_c, cone_s = tables.cone_cosine, tables.cone_sine
    frame, axes, disc = work.frame, work.axes, state.disc
    sum_x, sum_y, sum_z = 0.0, 0.0, 0.0
    for k in range(blades):
        f, sk, tk, mk = frame[k], s[k * per :], t[k * per :], m[k * per :]
        _place(
            sk,
            tk,
            per,
            f,
            work.apex,
            work.apex_velocity,
            work.spin,
            math.cos(pitch[k]),
            math.sin(pitch[k]),
            pitch_rate[k],
            bend[k],
            bend_rate[k],
        )
        _wind(sk, wind, count, hub_speed, time, work.tower[0], work.tower[1], work.tower[2])
        bx, by, bz = _relative(sk, tk, per, f)
        sum_x += f[0, 0] * bx + f[0, 1] * by + f[0, 2] * bz
        sum_y += f[1, 0] * bx + f[1, 1] * by + f[1, 2] * bz
        sum_z += f[2, 0] * bx + f[2, 1] * by + f[2, 2] * bz
        _predict(sk, tk, mk, per, pitch[k], cone_c, cone_s)
        _look_up_lift(sk, rows[k], first, last, polar)
    counts = state.counts
    counts[0] += blades * count
    counts[1] += blades * count
    if _newton(s, t, m, stop) > 0.0:
        for k in range(blades):
            for e in range(count):
                if s[_UNSOLVED + k * per + e] > 0.0:
                    rows[k, e] = _balance_one(
                        s, t, m, k * per + e, rows[k, e], first[e], last[e], polar, counts
                    )
    total = blades * count
    along = (axes[0, 0] * sum_x + axes[1, 0] * sum_y + axes[2, 0] * sum_z) / total
    lateral = (axes[0, 1] * sum_x + axes[1, 1] * sum_y + axes[2, 1] * sum_z) / total
    upward = (axes[0, 2] * sum_x + axes[1, 2] * sum_y + axes[2, 2] * sum_z) / total
    work.disc_wind[0], work.disc_wind[1], work.disc_wind[2] = along, lateral, upward
    across = math.sqrt(lateral * lateral + upward * upward)
    skew = math.atan2(across, along) if tables.skew else 0.0
    unit = across if across > 0.0 else 1.0
    tau, decay = 0.0, 0.0
    if tables.dynamic:
        tau = 1.1 * tables.radius / ((1.0 - 1.3 * min(disc[0], 0.5)) * max(disc[1], 0.1))
        tau = min(tau, 100.0)
        decay = math.exp(-step / tau)
    induction_sum = 0.0
    for k in range(blades):
        sk, tk, mk = s[k * per :], t[k * per :], m[k * per :]
        per_tip = 1.0 / sk[_RADIUS + count - 1]
        if tables.dynamic:
            _dynamic_inflow(sk, mk, per, disc[3] == 0.0, step, tau, decay, per_tip)
        else:
            _quasi_steady(sk, per)
        psi = work.angle[k]
        direction = (upward * math.cos(psi) - lateral * math.sin(psi)) / unit
        _final(sk, tk, per, skew, _SKEW * per_tip * direction)
        _look_up(sk, rows[k], first, last, polar)
        induction_sum += _integrate(
            sk,
            tk,
            per,
            tables.density,
            math.cos(pitch[k]),
            math.sin(pitch[k]),
            work.force[k],
            work.moment[k],
            work.modal[k],
        )
    disc[0] = induction_sum / total
    disc[1] = along
    disc[2] = tau
    disc[3] = 1.0
