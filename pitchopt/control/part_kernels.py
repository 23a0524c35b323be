"""Compiled parts of the controller beside torque law and speed regulator.

Each function takes the numbers of its part (`pitchopt.control.parameters`), the memory and what
is measured; what the part does and where it comes from stands in the module of the part.
Nothing is allocated here.
"""

from __future__ import annotations

import math

import numba as nb

from pitchopt.control import signals
from pitchopt.control.parameters import CLIPPED, ELAPSED, INDIVIDUAL, ROTOR_SPEED, WIND

__all__ = [
    "aerodynamic_torque",
    "bracket",
    "clip",
    "estimate_wind",
    "individual_pitch",
    "interpolated",
    "lowest_pitch",
    "mean_pitch",
    "profile_deviation",
    "start_wind",
]

_AZIMUTH = signals.AZIMUTH
_GENERATOR_TORQUE = signals.GENERATOR_TORQUE
_OUT_OF_PLANE = signals.OUT_OF_PLANE
_PITCH = signals.PITCH
_PITCH_COMMAND = signals.PITCH_COMMAND
_ROTOR_SPEED = signals.ROTOR_SPEED

_THIRD = 2.0 * math.pi / 3.0
_SIDE = math.sqrt(0.75)
_SCAN = 200  # wind speeds that the start looks at, between lowest and highest
_BISECTIONS = 50
_STANDSTILL = 1e-3  # [rad/s]; the estimator needs a tip-speed ratio

_compiled = nb.njit(cache=True, nogil=True, error_model="numpy")


@_compiled
def clip(x, low, high):  # type: ignore[no-untyped-def]
    """x within [low, high]."""
    return min(max(x, low), high)


@_compiled
def bracket(knots, x):  # type: ignore[no-untyped-def]
    """Segment of ascending knots that holds x and the share of it, both ends held beyond."""
    low, high = 0, knots.size - 1
    while high - low > 1:
        middle = (low + high) // 2
        if knots[middle] <= x:
            low = middle
        else:
            high = middle
    return low, clip((x - knots[low]) / (knots[low + 1] - knots[low]), 0.0, 1.0)


@_compiled
def interpolated(knots, values, x):  # type: ignore[no-untyped-def]
    """Linear between ascending knots, held beyond them; one knot alone is a constant."""
    if knots.size == 1:
        return values[0]
    k, share = bracket(knots, x)
    return (1.0 - share) * values[k] + share * values[k + 1]


@_compiled
def aerodynamic_torque(p, rotor_speed, pitch, wind):  # type: ignore[no-untyped-def]
    """1/2 rho pi R^2 C_P V^3 / omega [N m] from the table of `EstimatorParameters`."""
    omega = max(rotor_speed, _STANDSTILL)
    i, s = bracket(p.tsr, omega * p.radius / wind)
    j, t = bracket(p.pitch, pitch)
    low = (1.0 - t) * p.cp[i, j] + t * p.cp[i, j + 1]
    high = (1.0 - t) * p.cp[i + 1, j] + t * p.cp[i + 1, j + 1]
    return p.pressure_area * ((1.0 - s) * low + s * high) * wind * wind * wind / omega


@_compiled
def mean_pitch(measured):  # type: ignore[no-untyped-def]
    """Collective part of the measured pitch."""
    return (measured[_PITCH] + measured[_PITCH + 1] + measured[_PITCH + 2]) / 3.0


@_compiled
def start_wind(p, memory, measured):  # type: ignore[no-untyped-def]
    """Lowest wind speed at which the measured state would be steady, into the memory.

    Where there is none the end of the range at which the torques differ less.
    """
    omega, pitch = measured[_ROTOR_SPEED], mean_pitch(measured)
    memory[ROTOR_SPEED] = omega
    needed = p.gear_ratio * measured[_GENERATOR_TORQUE]
    spacing = (p.highest - p.lowest) / _SCAN
    low = p.lowest
    below = aerodynamic_torque(p, omega, pitch, low) - needed
    found = False
    high = p.highest
    for k in range(1, _SCAN + 1):
        wind = p.lowest + k * spacing
        difference = aerodynamic_torque(p, omega, pitch, wind) - needed
        if below < 0.0 <= difference:
            high = wind
            found = True
            break
        low, below = wind, difference
    if found:
        for _ in range(_BISECTIONS):
            middle = 0.5 * (low + high)
            if aerodynamic_torque(p, omega, pitch, middle) < needed:
                low = middle
            else:
                high = middle
        memory[WIND] = high
    else:
        first = abs(aerodynamic_torque(p, omega, pitch, p.lowest) - needed)
        last = abs(aerodynamic_torque(p, omega, pitch, p.highest) - needed)
        memory[WIND] = p.lowest if first <= last else p.highest


@_compiled
def estimate_wind(p, step, memory, measured):  # type: ignore[no-untyped-def]
    """Advance the estimated wind speed by one step, from the last rotor speed to this one."""
    omega = measured[_ROTOR_SPEED]
    surplus = aerodynamic_torque(p, omega, mean_pitch(measured), memory[WIND])
    surplus -= p.gear_ratio * measured[_GENERATOR_TORQUE]
    change = p.gain * (omega - memory[ROTOR_SPEED] - step * surplus / p.inertia)
    memory[ROTOR_SPEED] = omega
    memory[WIND] = clip(memory[WIND] + change, p.lowest, p.highest)


@_compiled
def lowest_pitch(p, wind):  # type: ignore[no-untyped-def]
    """Lowest collective pitch of `MinimumParameters` at a wind speed."""
    place = clip((wind - p.first) / p.spacing, 0.0, p.values.size - 1.0)
    k = min(int(place), p.values.size - 2)
    share = place - k
    return (1.0 - share) * p.values[k] + share * p.values[k + 1]


@_compiled
def individual_pitch(  # type: ignore[no-untyped-def]
    p, step, memory, measured, collective, command
):
    """Add the individual part of each blade to its command."""
    share = 1.0
    if p.fade_to > p.fade_from:
        share = clip((collective - p.fade_from) / (p.fade_to - p.fade_from), 0.0, 1.0)
    if p.fade_time > 0.0:
        share *= min(memory[ELAPSED] / p.fade_time, 1.0)
    for h in range(p.order.size):
        n, place = p.order[h], INDIVIDUAL + 2 * h
        cos_n, sin_n = math.cos(n * measured[_AZIMUTH]), math.sin(n * measured[_AZIMUTH])
        side = _SIDE if int(n) % 3 == 1 else -_SIDE  # sine of n 2 pi / 3
        tilt = yaw = 0.0
        for b in range(3):
            tilt += measured[_OUT_OF_PLANE + b] * cos_n
            yaw += measured[_OUT_OF_PLANE + b] * sin_n
            cos_n, sin_n = -0.5 * cos_n - side * sin_n, side * cos_n - 0.5 * sin_n
        change = p.gain[h] * step * 2.0 / 3.0
        last = math.hypot(memory[place], memory[place + 1])
        tilt, yaw = memory[place] + change * tilt, memory[place + 1] + change * yaw
        size = math.hypot(tilt, yaw)
        allowed = share * p.limit[h]
        if memory[CLIPPED] > 0.0:
            allowed = min(allowed, last)
        if size > allowed:
            tilt *= allowed / size
            yaw *= allowed / size
        memory[place], memory[place + 1] = tilt, yaw
        # cos and sin of n (psi + offset), the turn by the offset moved to the two parts
        tilt, yaw = (
            tilt * p.lead_cos[h] + yaw * p.lead_sin[h],
            yaw * p.lead_cos[h] - tilt * p.lead_sin[h],
        )
        for b in range(3):
            command[_PITCH_COMMAND + b] += tilt * cos_n + yaw * sin_n
            cos_n, sin_n = -0.5 * cos_n - side * sin_n, side * cos_n - 0.5 * sin_n


@_compiled
def profile_deviation(  # type: ignore[no-untyped-def]
    p, memory, measured, collective, command
):
    """Add the scheduled profile at each blade's azimuth, with its lead, to its command.

    Harmonics n, n + 3, n + 6, ... turn alike from blade to blade, so their sum is made once.
    """
    scale = interpolated(p.at, p.scale, memory[WIND] if p.over_wind else collective)
    omega, azimuth = measured[_ROTOR_SPEED], measured[_AZIMUTH]
    turn_cos, turn_sin = math.cos(azimuth), math.sin(azimuth)
    triple_cos, triple_sin = math.cos(3.0 * azimuth), math.sin(3.0 * azimuth)
    cos_n, sin_n = turn_cos, turn_sin
    for first in range(3):  # 1, 2, 0 modulo 3
        even = odd = 0.0  # real and imaginary part of the sum of this class
        blade_cos = math.cos((first + 1) * _THIRD)
        blade_sin = math.sin((first + 1) * _THIRD)
        start_cos, start_sin = cos_n, sin_n
        for h in range(first, p.cosine.size, 3):
            speed = (h + 1) * omega
            real, imaginary = 1.0 - speed * speed * p.second, speed * p.first
            if not p.amplitude:
                size = math.hypot(real, imaginary)
                real, imaginary = real / size, imaginary / size
            # Re[(c - i s)(real + i imaginary) exp(i n psi)]
            part = p.cosine[h] * real + p.sine[h] * imaginary
            other = p.cosine[h] * imaginary - p.sine[h] * real
            even += part * cos_n - other * sin_n
            odd += part * sin_n + other * cos_n
            cos_n, sin_n = (
                cos_n * triple_cos - sin_n * triple_sin,
                sin_n * triple_cos + cos_n * triple_sin,
            )
        for b in range(3):
            command[_PITCH_COMMAND + b] += scale * even
            even, odd = even * blade_cos - odd * blade_sin, even * blade_sin + odd * blade_cos
        cos_n, sin_n = (
            start_cos * turn_cos - start_sin * turn_sin,
            start_sin * turn_cos + start_cos * turn_sin,
        )
