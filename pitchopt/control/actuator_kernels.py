"""Compiled steps of the pitch actuator of one blade and of the generator.

The command stands still over a step, so the linear motion is advanced exactly whatever the step.

First order, with the rate as a limit of the actuator's own speed,

    dbeta/dt = clip((command - beta) / tau, -rate, rate),

which has a closed form as well: a straight line while the distance exceeds rate tau, an
exponential from there.  Second order,

    d2beta/dt2 = omega^2 (command - beta) - 2 zeta omega dbeta/dt,

is advanced with its matrix exponential; speed and travel of the step are then cut to the rate.
Range and rate hold for every kind.  A command that is not a number leaves the blade where it is.
"""

from __future__ import annotations

import math

import numba as nb

from pitchopt.control.actuator import FIRST_ORDER, SECOND_ORDER

__all__ = ["generator_torque", "pitch_actuator"]

_compiled = nb.njit(cache=True, nogil=True, error_model="numpy")


@_compiled
def _clip(x, low, high):  # type: ignore[no-untyped-def]
    return min(max(x, low), high)


@_compiled
def pitch_actuator(p, position, velocity, command):  # type: ignore[no-untyped-def]
    """Pitch [rad] and its speed [rad/s] after one step.

    Parameters
    ----------
    p : ActuatorParameters
    position, velocity : float
        Now [rad], [rad/s].
    command : float
        Over the step [rad].
    """
    if not math.isfinite(command):
        command = position
    target = _clip(command, p.lowest, p.highest)
    travel = p.rate * p.step
    if p.kind == SECOND_ORDER:
        gap = position - target
        new = target + p.a11 * gap + p.a12 * velocity
        speed = p.a21 * gap + p.a22 * velocity
        new = _clip(new, position - travel, position + travel)
        speed = _clip(speed, -p.rate, p.rate)
    elif p.kind == FIRST_ORDER:
        gap = target - position
        time = p.step
        new = position
        excess = abs(gap) - p.rate * p.tau
        if excess > 0.0:
            straight = min(excess / p.rate, time)
            new += math.copysign(p.rate * straight, gap)
            time -= straight
        if time > 0.0:
            new = target + (new - target) * math.exp(-time / p.tau)
        speed = _clip((target - new) / p.tau, -p.rate, p.rate)
    else:
        new = _clip(target, position - travel, position + travel)
        speed = (new - position) / p.step
    if new <= p.lowest:
        new, speed = p.lowest, max(speed, 0.0)
    elif new >= p.highest:
        new, speed = p.highest, min(speed, 0.0)
    return new, speed


@_compiled
def generator_torque(keep, torque, command):  # type: ignore[no-untyped-def]
    """Torque [N m] after one step; ``keep`` is that of `GeneratorLag`."""
    return command + keep * (torque - command)
