"""Compiled time loop: one fixed step of the whole turbine, its measurements and its outputs.

A step of length h from t_n to t_n+1:

1. the controller sees the state at t_n, actuators move pitch and torque over the step;
2. the state is predicted, v* = v + h (3 a_n - a_n-1) / 2, q* = q + h v + h^2 (4 a_n - a_n-1) / 6;
3. wind, induction and loads are evaluated once, at t_n+1 in the predicted state;
4. M a = Q - C v - K q is solved for a_n+1 with the linear stiffness and damping of the structure
   by the trapezium rule, v_n+1 = v + h (a_n + a_n+1) / 2, q_n+1 = q + h v + h^2 (a_n + a_n+1) / 4.

A run has diverged when the rotor runs at twice its rated speed or backward, a deflection passes
half the radius, or the collective pitch has raced back and forth at its rate limit for a third of
the last half minute (a loop that its gains destabilise ends in such a cycle, bounded by the
limits).  As much counts as was done in both directions: starting from feather, or feathering, takes
a slow actuator longer than that, at its limit all the way.

The scheme is of second order and stable for any stiffness of tower, blades and shaft; what it
takes explicitly are aerodynamic and gyroscopic forces.  The distance of prediction and result,
|v_n+1 - v*|, is the error check: its largest value relative to the largest velocity so far is
kept for each coordinate.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from pitchopt.checks import FloatArray
from pitchopt.control import signals
from pitchopt.control.actuator import ActuatorParameters
from pitchopt.control.actuator_kernels import generator_torque, pitch_actuator
from pitchopt.control.kernels import update
from pitchopt.sim.channels import PER_BLADE, SCALARS
from pitchopt.sim.compiling import compiled, inlined
from pitchopt.sim.kernels_body import (
    AZIMUTH,
    BLADES,
    FORE_AFT,
    SIDE_SIDE,
    TWIST,
    BodyTables,
    MotionWork,
)
from pitchopt.sim.kernels_frames import frames
from pitchopt.sim.kernels_motion import assemble, solve
from pitchopt.sim.kernels_planes import InflowState, RotorTables, RotorWork
from pitchopt.sim.kernels_reactions import reactions
from pitchopt.sim.kernels_rotor import rotor_aerodynamics
from pitchopt.sim.kernels_wind import WindTables, wind_speed, wind_velocity

__all__ = ["Model", "State", "Work", "advance", "march", "measure", "output"]


RUNNING = 0
DIVERGED = 1

_RACING = 0.98  # of the rate limit
_BACKWARD = 0.125  # of the largest speed: a feathered rotor may drift backward
_HUNT_TIME = 30.0  # over which hunting of the collective pitch is judged [s]
HUNTING = 0.35

_PITCH = signals.PITCH
_OUT_OF_PLANE = signals.OUT_OF_PLANE
_IN_PLANE = signals.IN_PLANE
_PITCH_COMMAND = signals.PITCH_COMMAND


class Model(NamedTuple):
    """Everything that does not change in a run.

    Attributes
    ----------
    rotor, wind, body, actuator
        Tables of the parts.
    torque_keep : float
        Share of the generator's lag left after a step.
    step : float
        [s].
    gear_ratio, efficiency : float
    hub_height : float
        Where the undisturbed wind is reported [m].
    base : float
        Height of the tower base [m].
    heights : ndarray (H,)
        Of the tower stations [m].
    tower_shape, tower_inertia_force, tower_inertia_moment, tower_weight_moment : ndarray (2, H)
    tower_mass_above : ndarray (H,)
    tip_shape : ndarray (2, 2)
    fastest : float
        Rotor speed beyond which the run counts as diverged [rad/s].
    largest : float
        Deflection beyond which it does [m].
    """

    rotor: RotorTables
    wind: WindTables
    body: BodyTables
    actuator: ActuatorParameters
    torque_keep: float
    step: float
    gear_ratio: float
    efficiency: float
    hub_height: float
    base: float
    heights: FloatArray
    tower_shape: FloatArray
    tower_inertia_force: FloatArray
    tower_inertia_moment: FloatArray
    tower_weight_moment: FloatArray
    tower_mass_above: FloatArray
    tip_shape: FloatArray
    fastest: float
    largest: float


class State(NamedTuple):
    """Everything that changes and matters for what follows.

    Attributes
    ----------
    q, v, a, before : ndarray (D,)
        Coordinates, rates, accelerations now and a step ago.
    pitch, pitch_rate : ndarray (B,)
    torque : ndarray (1,)
        Of the generator, high-speed side [N m].
    count : ndarray (1,) int
        Steps done.
    error, scale : ndarray (D,)
        Largest distance of predicted and final rate, largest rate.
    hunting : ndarray (2,)
        Shares of the last half minute, fading, in which the collective pitch ran up and down at
        its rate limit.
    inflow : InflowState
    """

    q: FloatArray
    v: FloatArray
    a: FloatArray
    before: FloatArray
    pitch: FloatArray
    pitch_rate: FloatArray
    torque: FloatArray
    count: NDArray[np.int64]  # type: ignore[assignment]  # hides tuple.count
    error: FloatArray
    scale: FloatArray
    hunting: FloatArray
    inflow: InflowState


class Work(NamedTuple):
    """Scratch and the loads of the last step.

    Attributes
    ----------
    rotor, motion
        Of the parts.
    q, v, bend, bend_rate : ndarray
        Predicted state.
    root : ndarray (B, 6); hub, top : ndarray (6,)
        See `pitchopt.sim.kernels_reactions.reactions`.
    scratch : ndarray (6, 3)
    measured, command : ndarray
        Signals of the controller.
    """

    rotor: RotorWork
    motion: MotionWork
    q: FloatArray
    v: FloatArray
    bend: FloatArray
    bend_rate: FloatArray
    root: FloatArray
    hub: FloatArray
    top: FloatArray
    scratch: FloatArray
    measured: FloatArray
    command: FloatArray


@inlined
def hunting(shares: FloatArray) -> float:
    """Share of the last half minute in which the collective pitch raced back and forth."""
    return float(2.0 * min(shares[0], shares[1]))


@inlined
def _loads(
    model: Model, state: State, work: Work, q: FloatArray, v: FloatArray, time: float, step: float
) -> None:
    """Frames, aerodynamics and equations of motion at a state and time."""
    for k in range(model.body.blades):
        for j in range(2):
            work.bend[k, j] = q[BLADES + 2 * k + j]
            work.bend_rate[k, j] = v[BLADES + 2 * k + j]
    frames(model.body, work.rotor, work.motion, q, v, state.pitch)
    rotor_aerodynamics(
        model.rotor,
        model.wind,
        state.inflow,
        work.rotor,
        wind_speed(model.wind.time, model.wind.speed, time),
        time,
        step,
        state.pitch,
        state.pitch_rate,
        work.bend,
        work.bend_rate,
    )
    assemble(
        model.body,
        work.rotor,
        work.motion,
        q,
        v,
        state.torque[0] * model.gear_ratio,
        work.scratch,
    )


@compiled
def begin(model: Model, state: State, work: Work) -> bool:
    """Accelerations and loads of the first instant."""
    time = state.count[0] * model.step
    _loads(model, state, work, state.q, state.v, time, 0.0)
    good = solve(model.body, work.motion, state.q, state.v, 0.0, state.a)
    for i in range(state.a.size):
        state.before[i] = state.a[i]
    reactions(
        model.body,
        work.rotor,
        work.motion,
        state.q,
        state.v,
        state.a,
        work.root,
        work.hub,
        work.top,
        work.scratch,
    )
    return bool(good)


@inlined
def advance(model: Model, state: State, work: Work, command: FloatArray) -> int:
    """One step under a command that is held; returns RUNNING or DIVERGED."""
    h = model.step
    body = model.body
    q, v, a, before = state.q, state.v, state.a, state.before
    collective = 0.0
    for k in range(body.blades):
        state.pitch[k], state.pitch_rate[k] = pitch_actuator(
            model.actuator, state.pitch[k], state.pitch_rate[k], command[_PITCH_COMMAND + k]
        )
        collective += state.pitch_rate[k]
    racing = _RACING * model.actuator.rate * body.blades
    for i, speed in enumerate((collective, -collective)):
        state.hunting[i] += h / _HUNT_TIME * ((1.0 if speed > racing else 0.0) - state.hunting[i])
    state.torque[0] = generator_torque(model.torque_keep, state.torque[0], command[signals.TORQUE])
    for i in range(q.size):
        work.q[i] = q[i] + h * v[i] + h * h * (4.0 * a[i] - before[i]) / 6.0
        work.v[i] = v[i] + 0.5 * h * (3.0 * a[i] - before[i])
        # explicit parts of the trapezium rule
        q[i] += h * v[i] + 0.25 * h * h * a[i]
        v[i] += 0.5 * h * a[i]
    state.count[0] += 1
    _loads(model, state, work, work.q, work.v, state.count[0] * h, h)
    for i in range(a.size):
        before[i] = a[i]
    good = solve(body, work.motion, q, v, h, a)
    for i in range(q.size):
        q[i] += 0.25 * h * h * a[i]
        v[i] += 0.5 * h * a[i]
        state.error[i] = max(state.error[i], abs(v[i] - work.v[i]))
        state.scale[i] = max(state.scale[i], abs(v[i]))
    if q[AZIMUTH] > 2.0 * math.pi:
        q[AZIMUTH] -= 2.0 * math.pi
    reactions(
        body,
        work.rotor,
        work.motion,
        work.q,
        work.v,
        a,
        work.root,
        work.hub,
        work.top,
        work.scratch,
    )
    speed = v[AZIMUTH]
    good &= (-_BACKWARD * model.fastest < speed < model.fastest) & (
        hunting(state.hunting) < HUNTING
    )
    for i in range(q.size):
        if i != AZIMUTH and i != TWIST:
            good &= abs(q[i]) < model.largest
        good &= abs(v[i]) < 1e6
    return RUNNING if good else DIVERGED


@inlined
def measure(model: Model, state: State, work: Work, measured: FloatArray) -> None:
    """Fill the controller's view of the turbine."""
    q, v, a = state.q, state.v, state.a
    measured[signals.TIME] = state.count[0] * model.step
    measured[signals.ROTOR_SPEED] = v[AZIMUTH]
    generator = (v[AZIMUTH] + v[TWIST]) * model.gear_ratio
    measured[signals.GENERATOR_SPEED] = generator
    turn = 2.0 * math.pi
    measured[signals.AZIMUTH] = q[AZIMUTH] - turn * math.floor(q[AZIMUTH] / turn)
    for k in range(model.body.blades):
        measured[_PITCH + k] = state.pitch[k]
        measured[_OUT_OF_PLANE + k] = work.root[k, 4]
        measured[_IN_PLANE + k] = work.root[k, 3]
    measured[signals.TOWER_X] = q[FORE_AFT]
    measured[signals.TOWER_Y] = q[SIDE_SIDE]
    measured[signals.TOWER_VX] = v[FORE_AFT]
    measured[signals.TOWER_VY] = v[SIDE_SIDE]
    measured[signals.TOWER_AX] = a[FORE_AFT]
    measured[signals.TOWER_AY] = a[SIDE_SIDE]
    measured[signals.GENERATOR_TORQUE] = state.torque[0]
    measured[signals.SHAFT_TORQUE] = work.hub[3]
    measured[signals.POWER] = model.efficiency * state.torque[0] * generator


@inlined
def output(model: Model, state: State, work: Work, out: FloatArray) -> None:
    """Fill the output vector in the order of `pitchopt.sim.channels`, SI units."""
    q, v, a = state.q, state.v, state.a
    body, rotor = model.body, work.rotor
    blades = body.blades
    time = state.count[0] * model.step
    out[0] = time
    out[1], out[2], out[3] = wind_velocity(model.wind, 0.0, 0.0, model.hub_height, time)
    out[4] = rotor.disc_wind[0]
    generator = (v[AZIMUTH] + v[TWIST]) * model.gear_ratio
    out[5], out[6] = v[AZIMUTH], generator
    turn = 2.0 * math.pi
    out[7] = q[AZIMUTH] - turn * math.floor(q[AZIMUTH] / turn)
    out[8] = state.torque[0]
    out[9] = model.efficiency * state.torque[0] * generator
    out[10], out[11] = work.hub[3], work.hub[0]
    thrust, torque = 0.0, 0.0
    for k in range(blades):
        for i in range(3):
            thrust += rotor.axes[i, 0] * (
                rotor.frame[k, i, 0] * rotor.force[k, 0]
                + rotor.frame[k, i, 1] * rotor.force[k, 1]
                + rotor.frame[k, i, 2] * rotor.force[k, 2]
            )
            torque += rotor.axes[i, 0] * (
                rotor.frame[k, i, 0] * rotor.moment[k, 0]
                + rotor.frame[k, i, 1] * rotor.moment[k, 1]
                + rotor.frame[k, i, 2] * rotor.moment[k, 2]
            )
    out[12], out[13] = thrust, torque
    out[14], out[15] = work.hub[4], work.hub[5]
    out[16] = q[TWIST]
    out[17], out[18] = q[FORE_AFT], q[SIDE_SIDE]
    out[19], out[20] = a[FORE_AFT], a[SIDE_SIDE]
    turning, top = work.motion.turn, work.top
    for i in range(3):
        out[21 + i] = turning[0, i] * top[0] + turning[1, i] * top[1] + turning[2, i] * top[2]
        out[24 + i] = turning[0, i] * top[3] + turning[1, i] * top[4] + turning[2, i] * top[5]
    sections = model.heights.size
    start = SCALARS + PER_BLADE * blades
    for s in range(sections - 1):
        length = body.top - model.heights[s]
        dx = q[FORE_AFT] * (1.0 - model.tower_shape[0, s])
        dy = q[SIDE_SIDE] * (1.0 - model.tower_shape[1, s])
        mx = (
            top[3]
            + dy * top[2]
            - length * top[1]
            + model.tower_inertia_moment[1, s] * a[SIDE_SIDE]
            - body.gravity * model.tower_weight_moment[1, s] * q[SIDE_SIDE]
        )
        my = (
            top[4]
            + length * top[0]
            - dx * top[2]
            - model.tower_inertia_moment[0, s] * a[FORE_AFT]
            + body.gravity * model.tower_weight_moment[0, s] * q[FORE_AFT]
        )
        if s == 0:
            out[27] = top[0] - model.tower_inertia_force[0, s] * a[FORE_AFT]
            out[28] = top[1] - model.tower_inertia_force[1, s] * a[SIDE_SIDE]
            out[29] = top[2] - body.gravity * model.tower_mass_above[s]
            out[30], out[31] = mx, my
            out[32] = top[5] + dx * top[1] - dy * top[0]
        else:
            out[start + 2 * (s - 1)] = mx
            out[start + 2 * (s - 1) + 1] = my
    for k in range(blades):
        cb, sb = math.cos(state.pitch[k]), math.sin(state.pitch[k])
        place = SCALARS + k
        out[place] = state.pitch[k]
        for i in range(6):
            out[place + (1 + i) * blades] = work.root[k, i]
        mx, my = work.root[k, 3], work.root[k, 4]
        # the pitching frame: x_b = (cos, -sin), y_b = (sin, cos) in the coned frame
        out[place + 7 * blades] = mx * cb - my * sb
        out[place + 8 * blades] = mx * sb + my * cb
        x0, x1 = q[BLADES + 2 * k], q[BLADES + 2 * k + 1]
        tip = model.tip_shape
        ux, uy = x0 * tip[0, 0] + x1 * tip[1, 0], x0 * tip[0, 1] + x1 * tip[1, 1]
        out[place + 9 * blades] = ux * cb + uy * sb
        out[place + 10 * blades] = uy * cb - ux * sb


@compiled
def march(
    model: Model,
    state: State,
    work: Work,
    control: Any,
    memory: FloatArray,
    steps: int,
    every: int,
    record: FloatArray,
) -> tuple[int, int]:
    """Run the closed loop with a compiled controller.

    Parameters
    ----------
    control : ControlParameters
    memory : ndarray
        Of the controller.
    steps : int
        How many.
    every : int
        Steps between two rows of the record.
    record : ndarray (R, C)
        Filled from its first row on, one row every `every` steps counted from time zero.

    Returns
    -------
    status, rows : int
        RUNNING or DIVERGED, and the rows written.
    """
    rows = 0
    for _ in range(steps):
        measure(model, state, work, work.measured)
        update(control, memory, work.measured, work.command)
        status = advance(model, state, work, work.command)
        if status != RUNNING:
            return status, rows
        if state.count[0] % every == 0:
            output(model, state, work, record[rows])
            rows += 1
    return RUNNING, rows
