"""The compiled controller: torque, collective pitch and commands of the blades, one call a step.

``update`` is what both the time loop and `pitchopt.control.controller.TurbineController` call.
In the order of the baseline controller of NREL/TP-500-38060:

1. the generator speed passes a first-order low pass;
2. torque from the filtered speed and the last collective command, within its rate;
3. collective pitch: the integral of the speed error is kept where it alone asks for no more than
   the range of pitch (anti-windup), proportional and integral parts are scheduled with the last
   collective command, then range and rate;
4. each blade's command, within the blades' range and rate.

A measurement that is NaN, infinite or absurd (beyond 1e12) leaves the memory as it was and the
last command stands; ``memory[HELD]`` counts such calls.

Nothing is allocated here.  The module is imported where it is used, not at the top: numba takes
a while to load.  The functions are untyped for the type checker because numba infers the types.
"""

from __future__ import annotations

import numba as nb

from pitchopt.control import signals
from pitchopt.control.parameters import (
    COLLECTIVE,
    FILTERED_SPEED,
    HELD,
    INTEGRAL,
    LAST_PITCH,
    LAST_TORQUE,
)

__all__ = ["collective_pitch", "start", "static_torque", "update"]

_ABSURD = 1e12  # no signal in SI units is larger; squares and products stay finite

_MEASURED = signals.MEASURED
_GENERATOR_SPEED = signals.GENERATOR_SPEED
_GENERATOR_TORQUE = signals.GENERATOR_TORQUE
_PITCH = signals.PITCH
_TORQUE = signals.TORQUE
_PITCH_COMMAND = signals.PITCH_COMMAND

_compiled = nb.njit(cache=True, nogil=True, error_model="numpy")


@_compiled
def clip(x, low, high):  # type: ignore[no-untyped-def]
    """x within [low, high]."""
    return min(max(x, low), high)


@_compiled
def static_torque(p, speed, pitch):  # type: ignore[no-untyped-def]
    """Torque of the law `TorqueParameters` at a speed and a collective pitch, without its rate."""
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
def gain_factor(p, pitch):  # type: ignore[no-untyped-def]
    """Share of the gains at zero pitch."""
    return 1.0 / (1.0 + p.linear * pitch + p.quadratic * pitch * pitch)


@_compiled
def collective_pitch(p, step, memory, lowest):  # type: ignore[no-untyped-def]
    """Collective command of the PI regulator `PitchParameters`, before its rate."""
    factor = gain_factor(p, memory[COLLECTIVE])
    error = memory[FILTERED_SPEED] - p.reference
    scale = factor * p.integral
    memory[INTEGRAL] = clip(memory[INTEGRAL] + error * step, lowest / scale, p.highest / scale)
    return clip(factor * p.proportional * error + scale * memory[INTEGRAL], lowest, p.highest)


@_compiled
def usable(measured):  # type: ignore[no-untyped-def]
    """Whether every signal is a number that can be."""
    good = True
    for k in range(_MEASURED):
        good &= abs(measured[k]) < _ABSURD
    return good


@_compiled
def start(p, memory, measured):  # type: ignore[no-untyped-def]
    """Memory of a controller that takes over a running turbine.

    The filter stands at the measured speed, the last commands at what is measured, and the
    integral where the first command is the measured pitch, if the range of pitch lets it be.
    """
    memory[:] = 0.0
    memory[FILTERED_SPEED] = measured[_GENERATOR_SPEED]
    memory[LAST_TORQUE] = clip(measured[_GENERATOR_TORQUE], 0.0, p.torque.largest)
    mean = 0.0
    for k in range(3):
        memory[LAST_PITCH + k] = clip(
            measured[_PITCH + k], p.pitch.blade_lowest, p.pitch.blade_highest
        )
        mean += measured[_PITCH + k] / 3.0
    mean = clip(mean, p.pitch.lowest, p.pitch.highest)
    memory[COLLECTIVE] = mean
    factor = gain_factor(p.pitch, mean)
    error = memory[FILTERED_SPEED] - p.pitch.reference
    wanted = (mean / factor - p.pitch.proportional * error) / p.pitch.integral
    scale = factor * p.pitch.integral
    memory[INTEGRAL] = (
        clip(wanted, p.pitch.lowest / scale, p.pitch.highest / scale) - error * p.step
    )


@_compiled
def update(p, memory, measured, command):  # type: ignore[no-untyped-def]
    """One call of the controller.

    Parameters
    ----------
    p : ControlParameters
    memory : (MEMORY_SIZE,)
        From `start`; changed.
    measured : (MEASURED,)
        Now.
    command : (COMMANDS,)
        Filled.
    """
    if not usable(measured):
        memory[HELD] += 1.0
        command[_TORQUE] = memory[LAST_TORQUE]
        for k in range(3):
            command[_PITCH_COMMAND + k] = memory[LAST_PITCH + k]
        return

    memory[FILTERED_SPEED] = (1.0 - p.keep) * measured[_GENERATOR_SPEED] + p.keep * memory[
        FILTERED_SPEED
    ]

    wanted = static_torque(p.torque, memory[FILTERED_SPEED], memory[COLLECTIVE])
    change = p.torque.rate * p.step
    torque = clip(wanted, memory[LAST_TORQUE] - change, memory[LAST_TORQUE] + change)
    memory[LAST_TORQUE] = torque
    command[_TORQUE] = torque

    lowest = p.pitch.lowest
    change = p.pitch.rate * p.step
    wanted = collective_pitch(p.pitch, p.step, memory, lowest)
    collective = clip(wanted, memory[COLLECTIVE] - change, memory[COLLECTIVE] + change)
    memory[COLLECTIVE] = collective

    for k in range(3):
        last = memory[LAST_PITCH + k]
        wanted = clip(collective, p.pitch.blade_lowest, p.pitch.blade_highest)
        memory[LAST_PITCH + k] = clip(wanted, last - change, last + change)
        command[_PITCH_COMMAND + k] = memory[LAST_PITCH + k]
