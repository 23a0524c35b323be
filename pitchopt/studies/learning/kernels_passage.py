"""Compiled loop over one blade passage of the dynamic turbine with a table of pitch commands.

Places are azimuth in stations since the start of the passage: place 0 is half a station before
the first rotor position, so that position k is in the middle of the interval from k to k + 1, over
which its loads are averaged,

    load(k) = integral of load(x) dx from k to k + 1,

with the loads linear in x between two steps.  The average keeps what is faster than the positions
out of the samples, as the filter in front of a sampled measurement does.  Commands are linear in x
between the columns 0 ... m of the table.  What a step reaches beyond place m is kept for the next
passage.

A profile may drive all blades at their rate limit, B times a turn.  That is no controller that
hunts, for which the time loop ends runs, and is not counted as such.

The module is imported where it is used, not at the top: numba takes a while to load.  The
function is untyped for the type checker because numba infers the types of its own.
"""

from __future__ import annotations

import math

import numba as nb

from pitchopt.control import signals
from pitchopt.control.kernels import update
from pitchopt.sim.kernels_body import AZIMUTH
from pitchopt.sim.kernels_march import RUNNING, advance, measure

__all__ = ["march_passage"]

_compiled = nb.njit(cache=True, nogil=True, error_model="numpy")

_EDGE = 1e-6  # of a station; closer to the edge of an interval is at the edge
_PITCH_COMMAND = signals.PITCH_COMMAND
_TORQUE = signals.TORQUE


@_compiled
def march_passage(  # type: ignore[no-untyped-def]
    model, state, work, control, memory, controlled, torque, commands, station, place, before,
    carry, loads,
):  # fmt: skip
    """Turn by one blade passage.

    Parameters
    ----------
    model, state, work
        Of `pitchopt.sim.TurbineRun`.
    control, memory
        Of a controller; not touched unless it is on.
    controlled : bool
        Whether the controller gives torque and collective pitch, to which the commands add.
    torque : float
        Of the generator without controller [N m].
    commands : ndarray (B, m + 1)
        Pitch of each blade at places 0 ... m [rad].
    station : float
        Azimuth between two positions [rad].
    place : ndarray (1,)
        Where the turbine is, and afterwards where it is in the next passage.
    before : ndarray (4,)
        Torque, tilt, yaw, thrust at the last step.
    carry : ndarray (4,)
        Integral of the loads in interval 0 so far, and afterwards that of the next passage.
    loads : ndarray (4, m)
        Filled with torque, tilt, yaw [N m] and thrust [N].

    Returns
    -------
    int
        RUNNING or DIVERGED.
    """
    blades, m = commands.shape[0], commands.shape[1] - 1
    q, v = state.q, state.v
    loads[:] = 0.0
    loads[:, 0] = carry
    carry[:] = 0.0
    command = work.command
    x = place[0]
    while x < m - _EDGE:
        measure(model, state, work, work.measured)
        if controlled:
            update(control, memory, work.measured, command)
        else:
            command[_TORQUE] = torque
            command[_PITCH_COMMAND : _PITCH_COMMAND + blades] = 0.0
        ahead = min(max(x + v[AZIMUTH] * model.step / station, 0.0), float(m))
        column = min(int(ahead), m - 1)
        share = ahead - column
        for k in range(blades):
            command[_PITCH_COMMAND + k] += (1.0 - share) * commands[k, column] + (
                share * commands[k, column + 1]
            )
        angle = q[AZIMUTH]
        state.hunting[0], state.hunting[1] = 0.0, 0.0
        status = advance(model, state, work, command)
        if status != RUNNING:
            return status
        turned = q[AZIMUTH] - angle
        if turned < -math.pi:
            turned += 2.0 * math.pi
        reached = x + turned / station
        low = x
        while low < reached:
            interval = max(int(low + _EDGE), 0)
            high = min(interval + 1.0, reached)
            if high > reached - _EDGE:
                high = reached
            middle = (0.5 * (low + high) - x) / (reached - x)
            for i in range(4):
                now = work.hub[3 + i] if i < 3 else work.hub[0]
                part = (high - low) * (before[i] + middle * (now - before[i]))
                if interval < m:
                    loads[i, interval] += part
                else:
                    carry[i] += part
            low = high
        for i in range(3):
            before[i] = work.hub[3 + i]
        before[3] = work.hub[0]
        x = reached
    place[0] = x - m
    return RUNNING
