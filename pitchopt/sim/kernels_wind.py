"""Compiled wind: sheared mean flow, turbulence box and tower, at one point and time.

    v = V(t) (g(z) + k y) (cos gamma, sin gamma, 0) + box(x, y, z, t) + disturbance of the tower

as `windfield.StaticField`, `TransientField` and `TurbulentField` define it.  The vertical shear g
and the tower radius are tables over height, V one over time, all linear between entries.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from pitchopt.checks import FloatArray
from pitchopt.sim.compiling import compiled, inlined

__all__ = [
    "CARTESIAN",
    "NO_BOX",
    "POLAR",
    "WindTables",
    "fluctuation",
    "table",
    "tower_disturbance",
    "wind_speed",
    "wind_velocity",
]

NO_BOX = 0
CARTESIAN = 1
POLAR = 2


class WindTables(NamedTuple):
    """A wind field as the time loop sees it.

    Attributes
    ----------
    time, speed : ndarray (K,)
        Hub wind speed over time [s, m/s].
    shear_low, shear_step : float
        First height and step of the shear table [m].
    shear : ndarray (S,)
        g at those heights.
    slope : float
        k [1/m].
    cosine, sine : float
        Of the direction gamma.
    tower_low, tower_step : float
        First height and step of the tower table [m].
    tower : ndarray (T,)
        Tower radius there, times the root of the shadow's weight (zero far above the top) [m].
    tower_radius : ndarray (T,)
        Tower radius alone, for the limit inside the tower [m].
    lateral : bool
        Whether the tower turns the wind.
    kind : int
        NO_BOX, CARTESIAN or POLAR.
    box : ndarray (Nx, N2, N3, 3) float32
        Fluctuations [m/s].
    carrier : float
        Speed that carries the box [m/s].
    step : float
        Of the box along the wind [m].
    offset : float
        Index that meets the tower axis at time zero.
    low, steps : ndarray (2,)
        First y and z of a Cartesian grid, centre of a polar one, and the steps of the second and
        third index: y and z, or radius and azimuth.
    periodic : bool
        Whether the box repeats along the wind.
    """

    time: FloatArray
    speed: FloatArray
    shear_low: float
    shear_step: float
    shear: FloatArray
    slope: float
    cosine: float
    sine: float
    tower_low: float
    tower_step: float
    tower: FloatArray
    tower_radius: FloatArray
    lateral: bool
    kind: int
    box: NDArray[np.float32]
    carrier: float
    step: float
    offset: float
    low: FloatArray
    steps: FloatArray
    periodic: bool


@compiled
def wind_speed(time: FloatArray, speed: FloatArray, t: float) -> float:
    """Hub wind speed at time t [m/s]."""
    last = time.size - 1
    if last == 0 or t <= time[0]:
        return float(speed[0])
    if t >= time[last]:
        return float(speed[last])
    i = np.searchsorted(time, t, side="right") - 1
    share = (t - time[i]) / (time[i + 1] - time[i])
    return float(speed[i] + share * (speed[i + 1] - speed[i]))


@inlined
def table(values: FloatArray, low: float, per_step: float, at: float) -> float:
    """Linear in an evenly spaced table, constant outside; `per_step` is one over the step.

    NaN counts as the first entry: a run that diverges reads nothing outside the table.
    """
    position = min(values.size - 1.0, max(0.0, (at - low) * per_step))
    i = min(max(int(position), 0), values.size - 1)
    value = values[i]
    return float(value + (position - i) * (values[min(i + 1, values.size - 1)] - value))


@inlined
def fluctuation(
    box: NDArray[np.float32],
    polar: bool,
    periodic: bool,
    along: float,
    across: float,
    up: float,
    per_second: float,
    per_third: float,
) -> tuple[float, float, float]:
    """Velocity in a box [m/s], linear between its points.

    Single precision as the box itself: sums of eight weighted numbers, relative error 2e-7.

    Parameters
    ----------
    along : float
        Fractional index along the wind.
    across, up : float
        Distance from the first point of a Cartesian grid, from the centre of a polar one [m].
    per_second, per_third : float
        One over the steps of the grid in its second and third index [1/m, or 1/m and 1/rad].
    """
    length, second, third = box.shape[0], box.shape[1], box.shape[2]
    if periodic and (along < 0.0 or along >= length):
        along -= length * math.floor(along / length)
    i0 = min(max(int(along), 0), length - 1)
    fi = along - i0
    i1 = i0 + 1
    if i1 >= length:
        i1 = 0 if periodic else i0
    if polar:
        j = math.sqrt(across * across + up * up) * per_second
        k = math.atan2(-across, up) * per_third
        if k < 0.0:
            k += third
        j0 = min(max(int(j), 0), second - 2)
        k0 = min(max(int(k), 0), third - 1)
        k1 = k0 + 1 if k0 + 1 < third else 0
    else:
        j = across * per_second
        k = up * per_third
        j0 = min(max(int(j), 0), second - 2)
        k0 = min(max(int(k), 0), third - 2)
        k1 = k0 + 1
    fj, fk = j - j0, k - k0
    j1 = j0 + 1
    w00, w01 = np.float32((1.0 - fi) * (1.0 - fj)), np.float32((1.0 - fi) * fj)
    w10, w11 = np.float32(fi * (1.0 - fj)), np.float32(fi * fj)
    low, high = np.float32(1.0 - fk), np.float32(fk)
    u0 = (w00 * box[i0, j0, k0, 0] + w01 * box[i0, j1, k0, 0]) + (
        w10 * box[i1, j0, k0, 0] + w11 * box[i1, j1, k0, 0]
    )
    v0 = (w00 * box[i0, j0, k0, 1] + w01 * box[i0, j1, k0, 1]) + (
        w10 * box[i1, j0, k0, 1] + w11 * box[i1, j1, k0, 1]
    )
    w0 = (w00 * box[i0, j0, k0, 2] + w01 * box[i0, j1, k0, 2]) + (
        w10 * box[i1, j0, k0, 2] + w11 * box[i1, j1, k0, 2]
    )
    u1 = (w00 * box[i0, j0, k1, 0] + w01 * box[i0, j1, k1, 0]) + (
        w10 * box[i1, j0, k1, 0] + w11 * box[i1, j1, k1, 0]
    )
    v1 = (w00 * box[i0, j0, k1, 1] + w01 * box[i0, j1, k1, 1]) + (
        w10 * box[i1, j0, k1, 1] + w11 * box[i1, j1, k1, 1]
    )
    w1 = (w00 * box[i0, j0, k1, 2] + w01 * box[i0, j1, k1, 2]) + (
        w10 * box[i1, j0, k1, 2] + w11 * box[i1, j1, k1, 2]
    )
    return low * u0 + high * u1, low * v0 + high * v1, low * w0 + high * w1


@inlined
def wind_velocity(
    tables: WindTables, x: float, y: float, z: float, t: float
) -> tuple[float, float, float]:
    """Velocity at a point without the tower [m/s].

    The loop over blade elements has the same steps with the tables taken out of the tuple, which
    the compiler would otherwise hand over element by element.
    """
    mean = wind_speed(tables.time, tables.speed, t) * (
        table(tables.shear, tables.shear_low, 1.0 / tables.shear_step, z) + tables.slope * y
    )
    u, v, w = mean, 0.0, 0.0
    if tables.kind != NO_BOX:
        along = tables.carrier * t - tables.cosine * x - tables.sine * y
        u, v, w = fluctuation(
            tables.box,
            tables.kind == POLAR,
            tables.periodic,
            along / tables.step + tables.offset,
            tables.cosine * y - tables.sine * x - tables.low[0],
            z - tables.low[1],
            1.0 / tables.steps[0],
            1.0 / tables.steps[1],
        )
        u += mean
    return tables.cosine * u - tables.sine * v, tables.sine * u + tables.cosine * v, w


@inlined
def tower_disturbance(
    radius: float, wall: float, lateral: bool, x: float, y: float, u: float, v: float
) -> tuple[float, float]:
    """Change of the horizontal wind (u, v) at x, y from the tower's axis [m/s].

    `radius` is the tower's radius times the root of the shadow's weight, `wall` the radius alone.
    """
    square = max(x * x + y * y, wall * wall)
    share = radius * radius / (square * square)
    even, odd = x * x - y * y, 2.0 * x * y
    if lateral:
        return -share * (u * even + v * odd), share * (v * even - u * odd)
    speed = u * u + v * v
    if speed <= 0.0:
        return 0.0, 0.0
    change = -share * ((u * u - v * v) * even + 2.0 * u * v * odd) / speed
    return change * u, change * v
