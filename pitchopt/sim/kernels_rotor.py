"""Compiled rotor aerodynamics of one step: wind, induction, wake and loads of all blades.

What is done in turn: `kernels_elements` places the elements and finds the wind that meets them,
`kernels_induction` balances momentum, `kernels_inflow` lets the wake follow with its delay and
skew, `kernels_loads` sums up.  Looking up wind and polars is left to loops of its own between
those over planes (`kernels_planes`).  Means over the rotor (axial induction, wind, skew) are
taken here, over all stations of all blades alike.
"""

from __future__ import annotations

import math

from pitchopt.checks import FloatArray
from pitchopt.sim.compiling import inlined
from pitchopt.sim.kernels_elements import place, relative_wind, wind_at
from pitchopt.sim.kernels_induction import balance_one, look_up_lift, newton, predict
from pitchopt.sim.kernels_inflow import dynamic_inflow, final_flow, quasi_steady
from pitchopt.sim.kernels_loads import integrate, look_up
from pitchopt.sim.kernels_planes import (
    LANES,
    S_RADIUS,
    S_UNSOLVED,
    InflowState,
    RotorTables,
    RotorWork,
)
from pitchopt.sim.kernels_wind import WindTables

__all__ = ["rotor_aerodynamics"]

_SKEW = 15.0 * math.pi / 32.0


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
    per = LANES * ((count + LANES - 1) // LANES)
    stop = blades * per
    rows, polar, first, last = state.row, tables.polar, tables.first, tables.last
    cone_c, cone_s = tables.cone_cosine, tables.cone_sine
    frame, axes, disc = work.frame, work.axes, state.disc
    sum_x, sum_y, sum_z = 0.0, 0.0, 0.0
    for k in range(blades):
        f, sk, tk, mk = frame[k], s[k * per :], t[k * per :], m[k * per :]
        place(
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
        wind_at(sk, wind, count, hub_speed, time, work.tower[0], work.tower[1], work.tower[2])
        bx, by, bz = relative_wind(sk, tk, per, f)
        sum_x += f[0, 0] * bx + f[0, 1] * by + f[0, 2] * bz
        sum_y += f[1, 0] * bx + f[1, 1] * by + f[1, 2] * bz
        sum_z += f[2, 0] * bx + f[2, 1] * by + f[2, 2] * bz
        predict(sk, tk, mk, per, pitch[k], cone_c, cone_s)
        look_up_lift(sk, rows[k], first, last, polar)
    counts = state.counts
    counts[0] += blades * count
    counts[1] += blades * count
    if newton(s, t, m, stop) > 0.0:
        for k in range(blades):
            for e in range(count):
                if s[S_UNSOLVED + k * per + e] > 0.0:
                    rows[k, e] = balance_one(
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
        per_tip = 1.0 / sk[S_RADIUS + count - 1]
        if tables.dynamic:
            dynamic_inflow(sk, mk, per, disc[3] == 0.0, step, tau, decay, per_tip)
        else:
            quasi_steady(sk, per)
        psi = work.angle[k]
        direction = (upward * math.cos(psi) - lateral * math.sin(psi)) / unit
        final_flow(sk, tk, per, skew, _SKEW * per_tip * direction)
        look_up(sk, rows[k], first, last, polar)
        induction_sum += integrate(
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
