"""Compiled rotor aerodynamics: flow at every blade element, momentum balance, blade loads.

The balance is that of `pitchopt.aero.induction` with drag left out of it (AeroDyn's default):
with x = V_n / V_t, solidity sigma and loss factor F, below the empirical region

    R(phi) = sin phi - x cos phi + sigma C_l (cos phi + x sin phi) / (4 F sin phi) = 0.

It is solved by Newton's method from a prediction: the last root moved along its derivatives by
the change of x and of the pitch since.  In most steps one evaluation does, its correction is
applied to the induction factors too; whatever does not converge goes to bisection in Ning's
brackets.

Dynamic inflow (S. Oye's two-stage filter) on the induced velocity W of each element,

    W_int + tau_1 dW_int/dt = W_qs + k tau_1 dW_qs/dt,        W + tau_2 dW/dt = W_int,
    tau_1 = 1.1 / (1 - 1.3 a) R / V,    tau_2 = (0.39 - 0.26 (r/R)^2) tau_1,    k = 0.6,

with a (at most 0.5) and V the means over the rotor, integrated exactly for W_qs linear over the
step.  The skewed wake redistributes the result, as in `pitchopt.aero.induction`.

Source: S. A. Ning, Wind Energy 17, 2014, 1327-1345; M. O. L. Hansen, Aerodynamics of Wind
Turbines, 2nd ed., chapter 9; the order of filter and skew is AeroDyn's.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from pitchopt.checks import FloatArray
from pitchopt.sim.kernels_wind import (
    NO_BOX,
    POLAR,
    WindTables,
    fluctuation,
    table,
    tower_disturbance,
)

__all__ = ["InflowState", "RotorTables", "RotorWork", "rotor_aerodynamics"]

_SKEW = 15.0 * math.pi / 32.0
_EDGE = 1e-6
_STILL = 1e-3
_MIN_LOSS = 1e-4
_ACCEPT = 2e-3  # correction of phi relative to sin phi below which one evaluation does
_NEWTON = 12
_FAR = 12.0  # exp(-12) is nothing beside 1

_compiled = njit(cache=True, nogil=True, error_model="numpy", fastmath={"contract", "nsz"})


class RotorTables(NamedTuple):
    """A rotor as the time loop sees it; E stations on each of B blades.

    Attributes
    ----------
    blades : int
    span, chord, twist, prebend, sweep : ndarray (E,)
        [m, m, rad, m, m].
    width, lever : ndarray (E,)
        Integration weights of the force and of its moment about the apex along z [m, m^2].
    outer, inner : ndarray (E,)
        Constants of tip and hub loss; not positive where the station is blocked.
    hub_radius, radius : float
        [m].
    cone_cosine, cone_sine : float
    density : float
        [kg/m^3].
    alpha, cl, cd, cm : ndarray (P,)
        Rows of all polars one after the other.
    first, last : ndarray (E,) int
        First and last row of each station's polar.
    shape, slope, shortening, weight : ndarray (E, 2, 2)
        Of the elastic blade, see `pitchopt.sim.structure.BladeModel`.
    skew, dynamic : bool
        Whether the wake's skew and dynamic inflow are on.
    """

    blades: int
    span: FloatArray
    chord: FloatArray
    twist: FloatArray
    prebend: FloatArray
    sweep: FloatArray
    width: FloatArray
    lever: FloatArray
    outer: FloatArray
    inner: FloatArray
    hub_radius: float
    radius: float
    cone_cosine: float
    cone_sine: float
    density: float
    alpha: FloatArray
    cl: FloatArray
    cd: FloatArray
    cm: FloatArray
    first: NDArray[np.int64]
    last: NDArray[np.int64]
    shape: FloatArray
    slope: FloatArray
    shortening: FloatArray
    weight: FloatArray
    skew: bool
    dynamic: bool


class InflowState(NamedTuple):
    """What the aerodynamics remember from step to step.

    Attributes
    ----------
    row : ndarray (B, E) int
        Row of the polar used last.
    root : ndarray (B, E, 5)
        Last inflow angle, V_n / V_t, twist plus pitch and the root's derivatives by both.
    quasi, middle, induced : ndarray (B, E, 2)
        W_qs, W_int and W, normal and tangential [m/s].
    disc : ndarray (4,)
        Mean axial induction, mean normal wind [m/s], time constant tau_1 [s], 1 once set.
    counts : ndarray (3,) int
        Evaluations of the balance, balances, balances that went to bisection.
    """

    row: NDArray[np.int64]
    root: FloatArray
    quasi: FloatArray
    middle: FloatArray
    induced: FloatArray
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
    flow : ndarray (B, E, 6)
        Normal and tangential wind, x, y, z in the blade frame, slope of the blade's axis.
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
    flow: FloatArray
    force: FloatArray
    moment: FloatArray
    modal: FloatArray
    disc_wind: FloatArray


@_compiled
def _row(alpha: FloatArray, first: int, last: int, row: int, at: float) -> int:
    """Row whose interval holds `at`, searched from `row`."""
    if row < first or row >= last:
        row = first
    while row > first and at < alpha[row]:
        row -= 1
    while row < last - 1 and at >= alpha[row + 1]:
        row += 1
    return row


@_compiled
def _loss(outer: float, inner: float, s: float, c: float) -> tuple[float, float]:
    """Loss factor F at sin phi = s > 0 and its derivative by phi."""
    factor, rate = 1.0, 0.0
    scale = 2.0 / math.pi
    if outer < _FAR * s:
        e = math.exp(-outer / s)
        root = math.sqrt(max(1.0 - e * e, 1e-300))
        part = scale * math.acos(e)
        slope = -scale * e * outer * c / (s * s * root)
        factor, rate = part, slope
    if inner < _FAR * s:
        e = math.exp(-inner / s)
        root = math.sqrt(max(1.0 - e * e, 1e-300))
        part = scale * math.acos(e)
        slope = -scale * e * inner * c / (s * s * root)
        rate = rate * part + factor * slope
        factor *= part
    if factor < _MIN_LOSS:
        return _MIN_LOSS, 0.0
    return factor, rate


@_compiled
def _axial(kappa: float, loss: float) -> float:
    """Induction factor of momentum theory and of Buhl's parabola, kappa > -1."""
    if kappa <= 2.0 / 3.0:
        return kappa / (1.0 + kappa)
    two = 2.0 * loss * kappa
    root = math.sqrt(abs(two - loss * (4.0 / 3.0 - loss)))
    g3 = two - (25.0 / 9.0 - 2.0 * loss)
    if abs(g3) < 1e-6:
        return 1.0 - 0.5 / root
    return (two - (10.0 / 9.0 - loss) - root) / g3


@_compiled
def _lift(
    alpha: FloatArray, cl: FloatArray, first: int, last: int, row: int, at: float
) -> tuple[float, float, int]:
    """Lift coefficient, its slope and the row."""
    row = _row(alpha, first, last, row, at)
    if at < alpha[first]:
        return cl[first], 0.0, row
    if at > alpha[last]:
        return cl[last], 0.0, row
    slope = (cl[row + 1] - cl[row]) / (alpha[row + 1] - alpha[row])
    return cl[row] + slope * (at - alpha[row]), slope, row


@_compiled
def _residual(
    alpha: FloatArray,
    lift: FloatArray,
    first: int,
    last: int,
    row: int,
    outer: float,
    inner: float,
    phi: float,
    x: float,
    theta: float,
    solidity: float,
    negative: bool,
) -> tuple[float, float, float, int]:
    """Residual of the general balance at phi, with kappa and kappa' (any sign of phi)."""
    s, c = math.sin(phi), math.cos(phi)
    cl, _, row = _lift(alpha, lift, first, last, row, phi - theta)
    loss, _ = _loss(outer, inner, abs(s), c)
    common = solidity * cl / (4.0 * loss * s)
    kappa = common * c / s
    swirl = common * s / c
    if negative:
        swirl = -swirl
    if (phi > 0.0) != negative:
        inverse = 1.0 + kappa
        if kappa > 2.0 / 3.0:
            inverse = 1.0 / (1.0 - _axial(kappa, loss))
    else:
        inverse = 1.0 - kappa
    return s * inverse - x * c * (1.0 - swirl), kappa, swirl, row


@_compiled
def _bisect(
    alpha: FloatArray,
    lift: FloatArray,
    first: int,
    last: int,
    row: int,
    outer: float,
    inner: float,
    x: float,
    theta: float,
    solidity: float,
    negative: bool,
) -> tuple[float, float, float, int]:
    """Inflow angle, a and a' by Ning's brackets in turn; phi is NaN where there is no root."""
    sign = -1.0 if negative else 1.0
    for bracket in range(3):
        if bracket == 0:
            low, high = _EDGE, math.pi / 2 - _EDGE
        elif bracket == 1:
            low, high = -math.pi / 4, -_EDGE
        else:
            low, high = math.pi / 2 + _EDGE, math.pi - _EDGE
        low, high = sign * low, sign * high
        at_low, _, _, row = _residual(
            alpha, lift, first, last, row, outer, inner, low, x, theta, solidity, negative
        )
        at_high, _, _, row = _residual(
            alpha, lift, first, last, row, outer, inner, high, x, theta, solidity, negative
        )
        if not (at_low * at_high <= 0.0):
            continue
        side = 0
        for _ in range(200):
            # Illinois' rule: false position that halves the weight of an end kept twice
            middle = (low * at_high - high * at_low) / (at_high - at_low)
            if not (min(low, high) < middle < max(low, high)):
                middle = 0.5 * (low + high)
            value, _, _, row = _residual(
                alpha, lift, first, last, row, outer, inner, middle, x, theta, solidity, negative
            )
            if value * at_high > 0.0:
                high, at_high = middle, value
                if side == -1:
                    at_low *= 0.5
                side = -1
            else:
                low, at_low = middle, value
                if side == 1:
                    at_high *= 0.5
                side = 1
            if abs(high - low) < 1e-13 or value == 0.0 or abs(value) < 1e-14:
                break
        phi = middle
        _, kappa, swirl, row = _residual(
            alpha, lift, first, last, row, outer, inner, phi, x, theta, solidity, negative
        )
        loss, _ = _loss(outer, inner, abs(math.sin(phi)), math.cos(phi))
        if (phi > 0.0) != negative:
            a = _axial(kappa, loss)
        else:
            a = kappa / (kappa - 1.0)
        tangential = swirl / (1.0 - swirl)
        return phi, min(max(a, -1.0), 1.5), min(max(tangential, -1.0), 1.0), row
    return math.nan, 0.0, 0.0, row


@_compiled
def _balance(
    alpha: FloatArray,
    lift: FloatArray,
    first: int,
    last: int,
    outer: float,
    inner: float,
    rows: NDArray[np.int64],
    root: FloatArray,
    counts: NDArray[np.int64],
    k: int,
    e: int,
    vn: float,
    vt: float,
    theta: float,
    solidity: float,
) -> tuple[float, float]:
    """Induction factors a and a' of blade k's station e in momentum balance.

    `rows`, `root` and `counts` are those of `InflowState`.
    """
    if outer <= 0.0 or inner <= 0.0:
        return 1.0, 0.0
    if abs(vn) <= _STILL or abs(vt) <= _STILL:
        return 0.0, 0.0
    x = vn / vt
    counts[1] += 1
    phi = (
        root[k, e, 0]
        + root[k, e, 3] * (x - root[k, e, 1])
        + root[k, e, 4] * (theta - root[k, e, 2])
    )
    row = rows[k, e]
    if x > 0.0 and root[k, e, 0] > 0.0:
        for _ in range(_NEWTON):
            if not (_EDGE < phi < math.pi / 2 - 1e-3):
                break
            counts[0] += 1
            s, c = math.sin(phi), math.cos(phi)
            cl, rise, row = _lift(alpha, lift, first, last, row, phi - theta)
            loss, loss_rate = _loss(outer, inner, s, c)
            common = solidity / (4.0 * loss * s)
            kappa = common * cl * c / s
            swirl = common * cl * s / c
            fall = loss_rate / loss
            kappa_rate = common * c / s * (rise - cl * (s / c + 2.0 * c / s + fall))
            swirl_rate = common * s / c * (rise + cl * (s / c - fall))
            if kappa <= -0.9 or swirl >= 0.9:
                break
            if kappa <= 2.0 / 3.0:
                a = kappa / (1.0 + kappa)
                inverse = 1.0 + kappa
                inverse_rate = kappa_rate
                a_rate = kappa_rate / (inverse * inverse)
            else:
                a = _axial(kappa, loss)
                step = 1e-6 * kappa
                by_kappa = (_axial(kappa + step, loss) - a) / step
                by_loss = (_axial(kappa, loss + 1e-6) - a) / 1e-6
                a_rate = by_kappa * kappa_rate + by_loss * loss_rate
                inverse = 1.0 / (1.0 - a)
                inverse_rate = inverse * inverse * a_rate
            rest = 1.0 - swirl
            residual = s * inverse - x * c * rest
            slope = c * inverse + s * inverse_rate + x * (s * rest + c * swirl_rate)
            if slope <= 0.0:
                break
            change = -residual / slope
            if abs(change) < _ACCEPT * s:
                phi += change
                a += a_rate * change
                tangential = (swirl + swirl_rate * change) / (rest - swirl_rate * change)
                root[k, e, 0], root[k, e, 1], root[k, e, 2] = phi, x, theta
                root[k, e, 3] = c * rest / slope
                by_theta = common * rise * (-c / s)
                if kappa <= 2.0 / 3.0:
                    by_theta = s * by_theta
                else:
                    by_theta = s * inverse * inverse * by_kappa * by_theta
                root[k, e, 4] = -(by_theta - x * c * common * rise * s / c) / slope
                rows[k, e] = row
                return min(max(a, -1.0), 1.5), min(max(tangential, -1.0), 1.0)
            phi += change
    counts[2] += 1
    phi, a, tangential, row = _bisect(
        alpha, lift, first, last, row, outer, inner, x, theta, solidity, vn < 0.0
    )
    rows[k, e] = row
    root[k, e, 1], root[k, e, 2], root[k, e, 3], root[k, e, 4] = x, theta, 0.0, 0.0
    root[k, e, 0] = phi if phi == phi else 0.0
    return a, tangential


@_compiled
def _filtered(
    old: float,
    new: float,
    middle: float,
    induced: float,
    h: float,
    tau: float,
    ratio: float,
    decay: float,
    decay2: float,
) -> tuple[float, float]:
    """W_int and W after a step h over which W_qs goes linearly from `old` to `new`."""
    rate = (new - old) / h
    level = old + rate * 0.6 * tau
    first = middle - level + rate * tau
    second = induced - first / (1.0 - ratio) - level + rate * tau * (1.0 + ratio)
    return (
        first * decay + level + rate * (h - tau),
        second * decay2 + level + rate * (h - tau * (1.0 + ratio)) + first / (1.0 - ratio) * decay,
    )


@_compiled
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
    t_span, t_chord, t_twist = tables.span, tables.chord, tables.twist
    t_prebend, t_sweep, t_width, t_lever = (
        tables.prebend,
        tables.sweep,
        tables.width,
        tables.lever,
    )
    t_shape, t_slope, t_shortening, t_weight = (
        tables.shape,
        tables.slope,
        tables.shortening,
        tables.weight,
    )
    t_alpha, t_cl, t_cd, t_cm = tables.alpha, tables.cl, tables.cd, tables.cm
    t_first, t_last, t_outer, t_inner = tables.first, tables.last, tables.outer, tables.inner
    hub_radius = tables.hub_radius
    shear, shear_low, shear_step = wind.shear, wind.shear_low, wind.shear_step
    shear_slope, wind_c, wind_s = wind.slope, wind.cosine, wind.sine
    tower, wall, tower_low, tower_step = (
        wind.tower,
        wind.tower_radius,
        wind.tower_low,
        wind.tower_step,
    )
    shadow, lateral_tower = tower.size > 1, wind.lateral
    top_x, top_y, top_height = work.tower[0], work.tower[1], work.tower[2]
    box, turbulent, polar, periodic = (
        wind.box,
        wind.kind != NO_BOX,
        wind.kind == POLAR,
        wind.periodic,
    )
    box_rate, box_start = 1.0 / wind.step, wind.carrier * time / wind.step + wind.offset
    second_low, third_low = wind.low[0], wind.low[1]
    second_step, third_step = wind.steps[0], wind.steps[1]
    rows, root, counts = state.row, state.root, state.counts
    force_out, moment_out, modal_out = work.force, work.moment, work.modal
    count = t_span.size
    cone_c, cone_s = tables.cone_cosine, tables.cone_sine
    apex, velocity, spin = work.apex, work.apex_velocity, work.spin
    flow = work.flow
    sum_x, sum_y, sum_z = 0.0, 0.0, 0.0
    for k in range(tables.blades):
        frame = work.frame
        f00, f01, f02 = frame[k, 0, 0], frame[k, 0, 1], frame[k, 0, 2]
        f10, f11, f12 = frame[k, 1, 0], frame[k, 1, 1], frame[k, 1, 2]
        f20, f21, f22 = frame[k, 2, 0], frame[k, 2, 1], frame[k, 2, 2]
        vx = f00 * velocity[0] + f10 * velocity[1] + f20 * velocity[2]
        vy = f01 * velocity[0] + f11 * velocity[1] + f21 * velocity[2]
        vz = f02 * velocity[0] + f12 * velocity[1] + f22 * velocity[2]
        wx = f00 * spin[0] + f10 * spin[1] + f20 * spin[2]
        wy = f01 * spin[0] + f11 * spin[1] + f21 * spin[2]
        wz = f02 * spin[0] + f12 * spin[1] + f22 * spin[2]
        cb, sb = math.cos(pitch[k]), math.sin(pitch[k])
        rate = pitch_rate[k]
        q0, q1 = bend[k, 0], bend[k, 1]
        d0, d1 = bend_rate[k, 0], bend_rate[k, 1]
        bx, by, bz = 0.0, 0.0, 0.0
        for e in range(count):
            # deflection before it is turned by pitch
            px = q0 * t_shape[e, 0, 0] + q1 * t_shape[e, 1, 0]
            py = q0 * t_shape[e, 0, 1] + q1 * t_shape[e, 1, 1]
            rx = d0 * t_shape[e, 0, 0] + d1 * t_shape[e, 1, 0]
            ry = d0 * t_shape[e, 0, 1] + d1 * t_shape[e, 1, 1]
            sx = q0 * t_slope[e, 0, 0] + q1 * t_slope[e, 1, 0]
            sy = q0 * t_slope[e, 0, 1] + q1 * t_slope[e, 1, 1]
            tilt = sx * cb + sy * sb
            z = (
                hub_radius
                + t_span[e]
                - 0.5
                * (
                    q0 * (q0 * t_shortening[e, 0, 0] + q1 * t_shortening[e, 0, 1])
                    + q1 * (q0 * t_shortening[e, 1, 0] + q1 * t_shortening[e, 1, 1])
                )
            )
            ox = t_prebend[e] * cb + t_sweep[e] * sb
            oy = t_sweep[e] * cb - t_prebend[e] * sb
            x = ox + px * cb + py * sb
            y = oy + py * cb - px * sb
            ux = vx + wy * z - wz * y + rx * cb + ry * sb + rate * oy
            uy = vy + wz * x - wx * z + ry * cb - rx * sb - rate * ox
            uz = vz + wx * y - wy * x
            gx = apex[0] + f00 * x + f01 * y + f02 * z
            gy = apex[1] + f10 * x + f11 * y + f12 * z
            gz = apex[2] + f20 * x + f21 * y + f22 * z
            mean = hub_speed * (table(shear, shear_low, shear_step, gz) + shear_slope * gy)
            u, v, c = mean, 0.0, 0.0
            if turbulent:
                u, v, c = fluctuation(
                    box,
                    polar,
                    periodic,
                    box_start - (wind_c * gx + wind_s * gy) * box_rate,
                    wind_c * gy - wind_s * gx - second_low,
                    gz - third_low,
                    second_step,
                    third_step,
                )
                u += mean
            a, b = wind_c * u - wind_s * v, wind_s * u + wind_c * v
            if shadow:
                radius = table(tower, tower_low, tower_step, gz)
                if radius > 0.0:
                    share = min(gz / top_height, 1.0)
                    share *= share  # the deflected axis, nearly a parabola
                    da, db = tower_disturbance(
                        radius,
                        table(wall, tower_low, tower_step, gz),
                        lateral_tower,
                        gx - share * top_x,
                        gy - share * top_y,
                        a,
                        b,
                    )
                    a += da
                    b += db
            nx = f00 * a + f10 * b + f20 * c - ux
            ny = f01 * a + f11 * b + f21 * c - uy
            nz = f02 * a + f12 * b + f22 * c - uz
            bx += nx
            by += ny
            bz += nz
            flow[k, e, 0] = (nx - tilt * nz) / math.sqrt(1.0 + tilt * tilt)
            flow[k, e, 1] = ny
            flow[k, e, 2], flow[k, e, 3], flow[k, e, 4] = x, y, z
            flow[k, e, 5] = tilt
        sum_x += f00 * bx + f01 * by + f02 * bz
        sum_y += f10 * bx + f11 * by + f12 * bz
        sum_z += f20 * bx + f21 * by + f22 * bz
    axes = work.axes
    quasi, middle, induced = state.quasi, state.middle, state.induced
    total = tables.blades * count
    along = (axes[0, 0] * sum_x + axes[1, 0] * sum_y + axes[2, 0] * sum_z) / total
    lateral = (axes[0, 1] * sum_x + axes[1, 1] * sum_y + axes[2, 1] * sum_z) / total
    upward = (axes[0, 2] * sum_x + axes[1, 2] * sum_y + axes[2, 2] * sum_z) / total
    work.disc_wind[0], work.disc_wind[1], work.disc_wind[2] = along, lateral, upward
    across = math.sqrt(lateral * lateral + upward * upward)
    skew = math.atan2(across, along)
    if not tables.skew:
        skew = 0.0
    unit = across if across > 0.0 else 1.0
    moving = tables.dynamic and step > 0.0 and state.disc[3] > 0.0
    tau, decay = 0.0, 0.0
    if tables.dynamic:
        limited = min(state.disc[0], 0.5)
        tau = 1.1 * tables.radius / ((1.0 - 1.3 * limited) * max(state.disc[1], 0.1))
        tau = min(tau, 100.0)
        decay = math.exp(-step / tau) if step > 0.0 else 1.0
    induction_sum = 0.0
    for k in range(tables.blades):
        psi = work.angle[k]
        direction = (upward * math.cos(psi) - lateral * math.sin(psi)) / unit
        cb, sb = math.cos(pitch[k]), math.sin(pitch[k])
        fx_sum, fy_sum, fz_sum = 0.0, 0.0, 0.0
        mx_sum, my_sum, mz_sum = 0.0, 0.0, 0.0
        m0, m1 = 0.0, 0.0
        tip_radius = math.hypot(
            cone_c * flow[k, count - 1, 4] + cone_s * flow[k, count - 1, 2],
            flow[k, count - 1, 3],
        )
        for e in range(count):
            vn, vt = flow[k, e, 0], flow[k, e, 1]
            x, y, z, tilt = flow[k, e, 2], flow[k, e, 3], flow[k, e, 4], flow[k, e, 5]
            theta = t_twist[e] + pitch[k]
            radial = cone_c * z + cone_s * x
            radius = math.sqrt(radial * radial + y * y)
            first, last = t_first[e], t_last[e]
            solidity = tables.blades * t_chord[e] / (2.0 * math.pi * radius)
            a, swirl = _balance(
                t_alpha,
                t_cl,
                first,
                last,
                t_outer[e],
                t_inner[e],
                rows,
                root,
                counts,
                k,
                e,
                vn,
                vt,
                theta,
                solidity,
            )
            induction_sum += a
            wn, wt = -a * vn, swirl * vt
            share = radius / tip_radius
            if tables.dynamic:
                if moving:
                    ratio = 0.39 - 0.26 * share * share
                    decay2 = math.exp(-step / (ratio * tau))
                    middle[k, e, 0], induced[k, e, 0] = _filtered(
                        quasi[k, e, 0],
                        wn,
                        middle[k, e, 0],
                        induced[k, e, 0],
                        step,
                        tau,
                        ratio,
                        decay,
                        decay2,
                    )
                    middle[k, e, 1], induced[k, e, 1] = _filtered(
                        quasi[k, e, 1],
                        wt,
                        middle[k, e, 1],
                        induced[k, e, 1],
                        step,
                        tau,
                        ratio,
                        decay,
                        decay2,
                    )
                elif state.disc[3] == 0.0:
                    middle[k, e, 0], middle[k, e, 1] = wn, wt
                    induced[k, e, 0], induced[k, e, 1] = wn, wt
                quasi[k, e, 0], quasi[k, e, 1] = wn, wt
                wn, wt = induced[k, e, 0], induced[k, e, 1]
            if skew > 0.0:
                a_used = -wn / vn if vn != 0.0 else 0.0
                chi = (1.0 + 0.6 * a_used) * skew
                chi = min(max(chi, -math.pi / 2), math.pi / 2)
                wn *= 1.0 + _SKEW * math.tan(0.5 * chi) * share * direction
            en, et = vn + wn, vt + wt
            square = en * en + et * et
            alpha = math.atan2(en, et) - theta
            speed = math.sqrt(square)
            s, c = en / speed, et / speed
            row = _row(t_alpha, first, last, rows[k, e], alpha)
            gap = t_alpha[row + 1] - t_alpha[row]
            part = min(max((alpha - t_alpha[row]) / gap, 0.0), 1.0)
            cl = t_cl[row] + part * (t_cl[row + 1] - t_cl[row])
            cd = t_cd[row] + part * (t_cd[row + 1] - t_cd[row])
            cm = t_cm[row] + part * (t_cm[row + 1] - t_cm[row])
            force = 0.5 * tables.density * square * t_chord[e]
            fx = force * (cl * c + cd * s)
            fy = -force * (cl * s - cd * c)
            fz = -tilt * fx
            width = t_width[e]
            lever = t_lever[e] + width * (z - hub_radius - t_span[e])
            fx_sum += width * fx
            fy_sum += width * fy
            fz_sum += width * fz
            mx_sum += width * y * fz - lever * fy
            my_sum += lever * fx - width * x * fz
            mz_sum += width * (x * fy - y * fx + force * t_chord[e] * cm)
            # turn the force back by pitch, to the frame of the mode shapes
            bx = fx * cb - fy * sb
            by = fy * cb + fx * sb
            m0 += bx * t_weight[e, 0, 0] + by * t_weight[e, 0, 1]
            m1 += bx * t_weight[e, 1, 0] + by * t_weight[e, 1, 1]
        force_out[k, 0], force_out[k, 1], force_out[k, 2] = fx_sum, fy_sum, fz_sum
        moment_out[k, 0], moment_out[k, 1], moment_out[k, 2] = mx_sum, my_sum, mz_sum
        modal_out[k, 0], modal_out[k, 1] = m0, m1
    state.disc[0] = induction_sum / total
    state.disc[1] = along
    state.disc[2] = tau
    state.disc[3] = 1.0
