"""The compiled controller: torque, collective pitch and commands of the blades, one call a step.

``update`` is what both the time loop and `pitchopt.control.controller.TurbineController` call.
In the order of the baseline controller of NREL/TP-500-38060:

1. the generator speed passes a first-order low pass, the wind speed is estimated;
2. torque from the filtered speed and how far the last collective command is above the lowest
   pitch, within its rate;
3. collective pitch: the integral of the speed error is kept where it alone asks for no more than
   the range of pitch (anti-windup), proportional and integral parts are scheduled with the last
   collective command, then range and rate;
4. each blade's command: collective, profile and individual part, within the blades' range and
   rate.

With a linear quadratic regulator it takes the place of 2 and 3; range and rate stay.

A measurement that is NaN, infinite or absurd (beyond 1e12) leaves the memory as it was and the
last command stands; ``memory[HELD]`` counts such calls.

Nothing is allocated here.  The module is imported where it is used, not at the top: numba takes
a while to load.  The functions are untyped for the type checker because numba infers the types.
"""

from __future__ import annotations

import numba as nb

from pitchopt.control import signals
from pitchopt.control.parameters import (
    CLIPPED,
    COLLECTIVE,
    ELAPSED,
    FILTERED_SPEED,
    HELD,
    INTEGRAL,
    LAST_PITCH,
    LAST_TORQUE,
    SCHEDULED,
    WIND,
)
from pitchopt.control.part_kernels import (
    bracket,
    clip,
    estimate_wind,
    individual_pitch,
    lowest_pitch,
    mean_pitch,
    profile_deviation,
    start_wind,
)

__all__ = ["start", "static_torque", "update"]

_ABSURD = 1e12  # no signal in SI units is larger; squares and products stay finite

_MEASURED = signals.MEASURED
_GENERATOR_SPEED = signals.GENERATOR_SPEED
_GENERATOR_TORQUE = signals.GENERATOR_TORQUE
_PITCH = signals.PITCH
_TOWER_VX = signals.TOWER_VX
_TOWER_X = signals.TOWER_X
_TORQUE = signals.TORQUE
_PITCH_COMMAND = signals.PITCH_COMMAND

_compiled = nb.njit(cache=True, nogil=True, error_model="numpy")


@_compiled
def static_torque(p, speed, pitch):  # type: ignore[no-untyped-def]
    """Torque of `TorqueParameters` at a speed and a pitch above the lowest, without its rate."""
    if speed >= p.region3 or pitch >= p.region3_pitch:
        torque = p.power / speed if p.constant_power and speed > 0.0 else p.rated
    elif speed <= p.cut_in:
        torque = 0.0
    elif speed < p.region2:
        torque = p.slope_15 * (speed - p.cut_in)
    elif speed < p.transition:
        torque = p.gain * speed * speed
    else:
        torque = p.slope_25 * (speed - p.synchronous)
    return min(torque, p.largest)


@_compiled
def _gain_factor(p, pitch):  # type: ignore[no-untyped-def]
    """Share of the gains at zero pitch."""
    return 1.0 / (1.0 + p.linear * pitch + p.quadratic * pitch * pitch)


@_compiled
def _proportional_integral(p, step, memory, lowest, highest):  # type: ignore[no-untyped-def]
    """Collective command of the PI regulator `PitchParameters`, before its rate."""
    factor = _gain_factor(p, memory[COLLECTIVE])
    error = memory[FILTERED_SPEED] - p.reference
    scale = factor * p.integral
    memory[INTEGRAL] = clip(memory[INTEGRAL] + error * step, lowest / scale, highest / scale)
    wanted = factor * p.proportional * error + scale * memory[INTEGRAL]
    return clip(wanted, lowest, highest)


@_compiled
def _linear_quadratic(p, rotor_speed, memory, measured):  # type: ignore[no-untyped-def]
    """Pitch and torque that u = u_ref - K (x - x_ref) asks for, and what the integral does.

    `rotor_speed` has passed the low pass.  Returns pitch, torque, and the change of both with the
    integral.
    """
    k, share = bracket(p.wind, memory[SCHEDULED])
    speed = (1.0 - share) * p.reference[k, 0] + share * p.reference[k + 1, 0]
    tower = (1.0 - share) * p.reference[k, 1] + share * p.reference[k + 1, 1]
    pitch = (1.0 - share) * p.reference[k, 2] + share * p.reference[k + 1, 2]
    torque = (1.0 - share) * p.reference[k, 3] + share * p.reference[k + 1, 3]
    states = (
        rotor_speed - speed,
        measured[_TOWER_X] - tower,
        measured[_TOWER_VX],
        mean_pitch(measured) - pitch,
        (measured[_GENERATOR_TORQUE] - torque) / p.torque_scale,
        memory[INTEGRAL],
    )
    gain = 0.0
    to_pitch = to_torque = 0.0
    for i in range(6):
        gain = (1.0 - share) * p.gains[k, 0, i] + share * p.gains[k + 1, 0, i]
        pitch -= gain * states[i]
        to_pitch = -gain
        gain = p.torque_scale * ((1.0 - share) * p.gains[k, 1, i] + share * p.gains[k + 1, 1, i])
        torque -= gain * states[i]
        to_torque = -gain
    return pitch, torque, to_pitch, to_torque, states[0]


@_compiled
def _beyond(wanted, low, high, push):  # type: ignore[no-untyped-def]
    """Whether a command is outside its range, or on its end, and pushed further out."""
    return (wanted <= low and push <= 0.0) or (wanted >= high and push >= 0.0)


@_compiled
def _largest_integral(p, to_pitch, to_torque):  # type: ignore[no-untyped-def]
    """Integral that alone takes both commands across their ranges."""
    bound = 0.0
    if to_pitch != 0.0:
        bound = (p.range.highest - p.range.lowest) / abs(to_pitch)
    if to_torque != 0.0:
        bound = max(bound, p.torque.largest / abs(to_torque))
    return bound


@_compiled
def _usable(measured):  # type: ignore[no-untyped-def]
    """Whether every signal is a number that can be."""
    good = True
    for k in range(_MEASURED):
        good &= abs(measured[k]) < _ABSURD
    return good


@_compiled
def _lowest(p, memory):  # type: ignore[no-untyped-def]
    """Lowest collective pitch now."""
    if p.minimum.on:
        return clip(lowest_pitch(p.minimum, memory[WIND]), p.range.lowest, p.range.highest)
    return p.range.lowest


@_compiled
def start(p, memory, measured):  # type: ignore[no-untyped-def]
    """Memory of a controller that takes over a running turbine.

    The filter stands at the measured speed, the last commands at what is measured, the wind
    speed where the measured state would be steady, and the integral where the first command is
    the measured pitch, if the range of pitch lets it be.
    """
    memory[:] = 0.0
    memory[FILTERED_SPEED] = measured[_GENERATOR_SPEED]
    memory[LAST_TORQUE] = clip(measured[_GENERATOR_TORQUE], 0.0, p.torque.largest)
    for k in range(3):
        memory[LAST_PITCH + k] = clip(
            measured[_PITCH + k], p.range.blade_lowest, p.range.blade_highest
        )
    if p.estimator.on:
        start_wind(p.estimator, memory, measured)
    memory[SCHEDULED] = memory[WIND]
    mean = clip(mean_pitch(measured), p.range.lowest, p.range.highest)
    memory[COLLECTIVE] = mean
    if p.linear_quadratic.on:
        q, rotor_speed = p.linear_quadratic, memory[FILTERED_SPEED] / p.estimator.gear_ratio
        pitch, torque, to_pitch, to_torque, error = _linear_quadratic(
            q, rotor_speed, memory, measured
        )
        weight = 1.0 / (q.torque_scale * q.torque_scale)
        size = to_pitch * to_pitch + weight * to_torque * to_torque
        missing = to_pitch * (mean - pitch) + weight * to_torque * (memory[LAST_TORQUE] - torque)
        memory[INTEGRAL] = missing / size if size > 0.0 else 0.0
    else:
        factor = _gain_factor(p.pitch, mean)
        error = memory[FILTERED_SPEED] - p.pitch.reference
        scale = factor * p.pitch.integral
        wanted = (mean - factor * p.pitch.proportional * error) / scale
        memory[INTEGRAL] = clip(wanted, _lowest(p, memory) / scale, p.range.highest / scale)
        memory[INTEGRAL] -= error * p.step


@_compiled
def update(p, memory, measured, command):  # type: ignore[no-untyped-def]
    """One call of the controller.

    Parameters
    ----------
    p : ControlParameters
    memory : (memory_size,)
        From `start`; changed.
    measured : (MEASURED,)
        Now.
    command : (COMMANDS,)
        Filled.
    """
    if not _usable(measured):
        memory[HELD] += 1.0
        command[_TORQUE] = memory[LAST_TORQUE]
        for k in range(3):
            command[_PITCH_COMMAND + k] = memory[LAST_PITCH + k]
        return

    memory[FILTERED_SPEED] = (1.0 - p.keep) * measured[_GENERATOR_SPEED] + p.keep * memory[
        FILTERED_SPEED
    ]
    if p.estimator.on:
        estimate_wind(p.estimator, p.step, memory, measured)
    lowest, highest = _lowest(p, memory), p.range.highest

    if p.linear_quadratic.on:
        q, rotor_speed = p.linear_quadratic, memory[FILTERED_SPEED] / p.estimator.gear_ratio
        memory[SCHEDULED] = memory[WIND] + q.keep * (memory[SCHEDULED] - memory[WIND])
        pitch, torque, to_pitch, to_torque, error = _linear_quadratic(
            q, rotor_speed, memory, measured
        )
        if not (
            _beyond(pitch, lowest, highest, to_pitch * error)
            and _beyond(torque, 0.0, p.torque.largest, to_torque * error)
        ):
            bound = _largest_integral(p, to_pitch, to_torque)
            memory[INTEGRAL] = clip(memory[INTEGRAL] + error * p.step, -bound, bound)
        pitch = clip(pitch, lowest, highest)
        torque = clip(torque, 0.0, p.torque.largest)
    else:
        torque = static_torque(p.torque, memory[FILTERED_SPEED], memory[COLLECTIVE] - lowest)
        pitch = _proportional_integral(p.pitch, p.step, memory, lowest, highest)

    change = p.torque.rate * p.step
    memory[LAST_TORQUE] = clip(torque, memory[LAST_TORQUE] - change, memory[LAST_TORQUE] + change)
    command[_TORQUE] = memory[LAST_TORQUE]

    change = p.range.rate * p.step
    collective = clip(pitch, memory[COLLECTIVE] - change, memory[COLLECTIVE] + change)
    memory[COLLECTIVE] = collective
    for k in range(3):
        command[_PITCH_COMMAND + k] = collective
    if p.feedforward.on:
        profile_deviation(p.feedforward, memory, measured, collective, command)
    if p.individual.on:
        individual_pitch(p.individual, p.step, memory, measured, collective, command)
    memory[CLIPPED] = 0.0
    for k in range(3):
        last, wanted = memory[LAST_PITCH + k], command[_PITCH_COMMAND + k]
        pitch = clip(wanted, p.range.blade_lowest, p.range.blade_highest)
        pitch = clip(pitch, last - change, last + change)
        if pitch != wanted:
            memory[CLIPPED] = 1.0
        memory[LAST_PITCH + k] = pitch
        command[_PITCH_COMMAND + k] = pitch
    memory[ELAPSED] += p.step
