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
from pitchopt.sim.kernels_wind import WindTables, tower_disturbance, wind_velocity

__all__ = ["InflowState", "RotorTables", "RotorWork", "rotor_aerodynamics"]

_SKEW = 15.0 * math.pi / 32.0
_EDGE = 1e-6
_STILL = 1e-3
_MIN_LOSS = 1e-4
_ACCEPT = 2e-3  # correction of phi relative to sin phi below which one evaluation does
_NEWTON = 12
_FAR = 12.0  # exp(-12) is nothing beside 1


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


@njit(cache=True, nogil=True)
def _row(alpha: FloatArray, first: int, last: int, row: int, at: float) -> int:
    """Row whose interval holds `at`, searched from `row`."""
    if row < first or row >= last:
        row = first
    while row > first and at < alpha[row]:
        row -= 1
    while row < last - 1 and at >= alpha[row + 1]:
        row += 1
    return row


@njit(cache=True, nogil=True)
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


@njit(cache=True, nogil=True)
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


@njit(cache=True, nogil=True)
def _lift(
    tables: RotorTables, e: int, row: int, at: float
) -> tuple[float, float, int]:
    """Lift coefficient, its slope and the row."""
    alpha = tables.alpha
    first, last = tables.first[e], tables.last[e]
    row = _row(alpha, first, last, row, at)
    if at < alpha[first]:
        return tables.cl[first], 0.0, row
    if at > alpha[last]:
        return tables.cl[last], 0.0, row
    slope = (tables.cl[row + 1] - tables.cl[row]) / (alpha[row + 1] - alpha[row])
    return tables.cl[row] + slope * (at - alpha[row]), slope, row


@njit(cache=True, nogil=True)
def _residual(
    tables: RotorTables, e: int, row: int, phi: float, x: float, theta: float, solidity: float,
    negative: bool,
) -> tuple[float, float, float, int]:
    """Residual of the general balance at phi, with kappa and kappa' (any sign of phi)."""
    s, c = math.sin(phi), math.cos(phi)
    cl, _, row = _lift(tables, e, row, phi - theta)
    loss, _ = _loss(tables.outer[e], tables.inner[e], abs(s), c)
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


@njit(cache=True, nogil=True)
def _bisect(
    tables: RotorTables, e: int, row: int, x: float, theta: float, solidity: float,
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
        at_low, _, _, row = _residual(tables, e, row, low, x, theta, solidity, negative)
        at_high, _, _, row = _residual(tables, e, row, high, x, theta, solidity, negative)
        if not (at_low * at_high <= 0.0):
            continue
        side = 0
        for _ in range(200):
            # Illinois' rule: false position that halves the weight of an end kept twice
            middle = (low * at_high - high * at_low) / (at_high - at_low)
            if not (min(low, high) < middle < max(low, high)):
                middle = 0.5 * (low + high)
            value, _, _, row = _residual(tables, e, row, middle, x, theta, solidity, negative)
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
        _, kappa, swirl, row = _residual(tables, e, row, phi, x, theta, solidity, negative)
        loss, _ = _loss(tables.outer[e], tables.inner[e], abs(math.sin(phi)), math.cos(phi))
        if (phi > 0.0) != negative:
            a = _axial(kappa, loss)
        else:
            a = kappa / (kappa - 1.0)
        tangential = swirl / (1.0 - swirl)
        return phi, min(max(a, -1.0), 1.5), min(max(tangential, -1.0), 1.0), row
    return math.nan, 0.0, 0.0, row


@njit(cache=True, nogil=True)
def _balance(
    tables: RotorTables, state: InflowState, k: int, e: int, vn: float, vt: float, theta: float,
    radius: float,
) -> tuple[float, float]:
    """Induction factors a and a' of blade k's station e in momentum balance."""
    if tables.outer[e] <= 0.0 or tables.inner[e] <= 0.0:
        return 1.0, 0.0
    if abs(vn) <= _STILL or abs(vt) <= _STILL:
        return 0.0, 0.0
    solidity = tables.blades * tables.chord[e] / (2.0 * math.pi * radius)
    x = vn / vt
    root = state.root[k, e]
    state.counts[1] += 1
    phi = root[0] + root[3] * (x - root[1]) + root[4] * (theta - root[2])
    row = state.row[k, e]
    alpha = tables.alpha
    if x > 0.0 and root[0] > 0.0:
        for _ in range(_NEWTON):
            if not (_EDGE < phi < math.pi / 2 - 1e-3):
                break
            state.counts[0] += 1
            s, c = math.sin(phi), math.cos(phi)
            cl, rise, row = _lift(tables, e, row, phi - theta)
            loss, loss_rate = _loss(tables.outer[e], tables.inner[e], s, c)
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
                root[0], root[1], root[2] = phi, x, theta
                root[3] = c * rest / slope
                by_theta = common * rise * (-c / s)
                if kappa <= 2.0 / 3.0:
                    by_theta = s * by_theta
                else:
                    by_theta = s * inverse * inverse * by_kappa * by_theta
                root[4] = -(by_theta - x * c * common * rise * s / c) / slope
                state.row[k, e] = row
                return min(max(a, -1.0), 1.5), min(max(tangential, -1.0), 1.0)
            phi += change
    state.counts[2] += 1
    phi, a, tangential, row = _bisect(tables, e, row, x, theta, solidity, vn < 0.0)
    state.row[k, e] = row
    root[1], root[2], root[3], root[4] = x, theta, 0.0, 0.0
    root[0] = phi if phi == phi else 0.0
    return a, tangential


@njit(cache=True, nogil=True)
def _filtered(
    old: float, new: float, middle: float, induced: float, h: float, tau: float, ratio: float,
    decay: float, decay2: float,
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


@njit(cache=True, nogil=True)
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
    count = tables.span.size
    cone_c, cone_s = tables.cone_cosine, tables.cone_sine
    apex, velocity, spin = work.apex, work.apex_velocity, work.spin
    sum_x, sum_y, sum_z, normal_sum = 0.0, 0.0, 0.0, 0.0
    for k in range(tables.blades):
        frame = work.frame[k]
        f00, f01, f02 = frame[0, 0], frame[0, 1], frame[0, 2]
        f10, f11, f12 = frame[1, 0], frame[1, 1], frame[1, 2]
        f20, f21, f22 = frame[2, 0], frame[2, 1], frame[2, 2]
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
            shape = tables.shape[e]
            # deflection before it is turned by pitch
            px = q0 * shape[0, 0] + q1 * shape[1, 0]
            py = q0 * shape[0, 1] + q1 * shape[1, 1]
            rx = d0 * shape[0, 0] + d1 * shape[1, 0]
            ry = d0 * shape[0, 1] + d1 * shape[1, 1]
            slope = tables.slope[e]
            sx = q0 * slope[0, 0] + q1 * slope[1, 0]
            sy = q0 * slope[0, 1] + q1 * slope[1, 1]
            tilt = sx * cb + sy * sb
            short = tables.shortening[e]
            z = tables.hub_radius + tables.span[e] - 0.5 * (
                q0 * (q0 * short[0, 0] + q1 * short[0, 1])
                + q1 * (q0 * short[1, 0] + q1 * short[1, 1])
            )
            ox = tables.prebend[e] * cb + tables.sweep[e] * sb
            oy = tables.sweep[e] * cb - tables.prebend[e] * sb
            x = ox + px * cb + py * sb
            y = oy + py * cb - px * sb
            ux = vx + wy * z - wz * y + rx * cb + ry * sb + rate * oy
            uy = vy + wz * x - wx * z + ry * cb - rx * sb - rate * ox
            uz = vz + wx * y - wy * x
            gx = apex[0] + f00 * x + f01 * y + f02 * z
            gy = apex[1] + f10 * x + f11 * y + f12 * z
            gz = apex[2] + f20 * x + f21 * y + f22 * z
            a, b, c = wind_velocity(wind, hub_speed, gx, gy, gz, time)
            if wind.tower.size > 1:
                share = min(gz / work.tower[2], 1.0)
                share *= share  # the deflected axis, nearly a parabola
                da, db = tower_disturbance(
                    wind, gx - share * work.tower[0], gy - share * work.tower[1], gz, a, b
                )
                a += da
                b += db
            nx = f00 * a + f10 * b + f20 * c - ux
            ny = f01 * a + f11 * b + f21 * c - uy
            nz = f02 * a + f12 * b + f22 * c - uz
            bx += nx
            by += ny
            bz += nz
            flow = work.flow[k, e]
            flow[0] = (nx - tilt * nz) / math.sqrt(1.0 + tilt * tilt)
            flow[1] = ny
            flow[2], flow[3], flow[4], flow[5] = x, y, z, tilt
            normal_sum += flow[0]
        sum_x += f00 * bx + f01 * by + f02 * bz
        sum_y += f10 * bx + f11 * by + f12 * bz
        sum_z += f20 * bx + f21 * by + f22 * bz
    axes = work.axes
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
        tip = work.flow[k, count - 1]
        tip_radius = math.hypot(cone_c * tip[4] + cone_s * tip[2], tip[3])
        for e in range(count):
            flow = work.flow[k, e]
            vn, vt, x, y, z, tilt = flow[0], flow[1], flow[2], flow[3], flow[4], flow[5]
            theta = tables.twist[e] + pitch[k]
            radial = cone_c * z + cone_s * x
            radius = math.sqrt(radial * radial + y * y)
            a, swirl = _balance(tables, state, k, e, vn, vt, theta, radius)
            induction_sum += a
            wn, wt = -a * vn, swirl * vt
            share = radius / tip_radius
            if tables.dynamic:
                quasi, middle, induced = (
                    state.quasi[k, e], state.middle[k, e], state.induced[k, e]
                )
                if moving:
                    ratio = 0.39 - 0.26 * share * share
                    decay2 = math.exp(-step / (ratio * tau))
                    middle[0], induced[0] = _filtered(
                        quasi[0], wn, middle[0], induced[0], step, tau, ratio, decay, decay2
                    )
                    middle[1], induced[1] = _filtered(
                        quasi[1], wt, middle[1], induced[1], step, tau, ratio, decay, decay2
                    )
                elif state.disc[3] == 0.0:
                    middle[0], middle[1] = wn, wt
                    induced[0], induced[1] = wn, wt
                quasi[0], quasi[1] = wn, wt
                wn, wt = induced[0], induced[1]
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
            first, last = tables.first[e], tables.last[e]
            row = _row(tables.alpha, first, last, state.row[k, e], alpha)
            gap = tables.alpha[row + 1] - tables.alpha[row]
            part = min(max((alpha - tables.alpha[row]) / gap, 0.0), 1.0)
            cl = tables.cl[row] + part * (tables.cl[row + 1] - tables.cl[row])
            cd = tables.cd[row] + part * (tables.cd[row + 1] - tables.cd[row])
            cm = tables.cm[row] + part * (tables.cm[row + 1] - tables.cm[row])
            force = 0.5 * tables.density * square * tables.chord[e]
            fx = force * (cl * c + cd * s)
            fy = -force * (cl * s - cd * c)
            fz = -tilt * fx
            width = tables.width[e]
            lever = tables.lever[e] + width * (z - tables.hub_radius - tables.span[e])
            fx_sum += width * fx
            fy_sum += width * fy
            fz_sum += width * fz
            mx_sum += width * y * fz - lever * fy
            my_sum += lever * fx - width * x * fz
            mz_sum += width * (x * fy - y * fx + force * tables.chord[e] * cm)
            # turn the force back by pitch, to the frame of the mode shapes
            bx = fx * cb - fy * sb
            by = fy * cb + fx * sb
            weight = tables.weight[e]
            m0 += bx * weight[0, 0] + by * weight[0, 1]
            m1 += bx * weight[1, 0] + by * weight[1, 1]
        work.force[k, 0], work.force[k, 1], work.force[k, 2] = fx_sum, fy_sum, fz_sum
        work.moment[k, 0], work.moment[k, 1], work.moment[k, 2] = mx_sum, my_sum, mz_sum
        work.modal[k, 0], work.modal[k, 1] = m0, m1
    state.disc[0] = induction_sum / total
    state.disc[1] = along
    state.disc[2] = tau
    state.disc[3] = 1.0
