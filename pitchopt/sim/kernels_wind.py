"""Compiled wind: sheared mean flow, turbulence box and tower, at one point and time.

    v = V(t) (g(z) + k y) (cos gamma, sin gamma, 0) + box(x, y, z, t) + disturbance of the tower

as `windfield.StaticField`, `TransientField` and `TurbulentField` define it.  The vertical shear g
and the tower radius are tables over height, V one over time, all linear between entries.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from pitchopt.checks import FloatArray

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

_compiled = njit(
    cache=True, nogil=True, _nrt=False, error_model="numpy", fastmath={"contract", "nsz"}
)


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


@_compiled
def wind_speed(time: FloatArray, speed: FloatArray, t: float) -> float:
    """Hub wind speed at time t [m/s]."""
    last = time.size - 1
    if last == 0 or t <= time[0]:
        return speed[0]
    if t >= time[last]:
        return speed[last]
    i = np.searchsorted(time, t, side="right") - 1
    share = (t - time[i]) / (time[i + 1] - time[i])
    return speed[i] + share * (speed[i + 1] - speed[i])


@_compiled
def table(values: FloatArray, low: float, step: float, at: float) -> float:
    """Linear in an evenly spaced table, constant outside."""
    position = (at - low) / step
    if position <= 0.0:
        return values[0]
    i = int(position)
    if i >= values.size - 1:
        return values[values.size - 1]
    return values[i] + (position - i) * (values[i + 1] - values[i])


@_compiled
def fluctuation(
    box: NDArray[np.float32],
    polar: bool,
    periodic: bool,
    along: float,
    across: float,
    up: float,
    second_step: float,
    third_step: float,
) -> tuple[float, float, float]:
    """Velocity in a box [m/s], linear between its points.

    Parameters
    ----------
    along : float
        Fractional index along the wind.
    across, up : float
        Distance from the first point of a Cartesian grid, from the centre of a polar one [m].
    second_step, third_step : float
        Steps of the grid in its second and third index [m, or m and rad].
    """
    length, second, third = box.shape[0], box.shape[1], box.shape[2]
    if periodic:
        along -= length * math.floor(along / length)
    i0 = min(max(int(along), 0), length - 1)
    fi = along - i0
    i1 = i0 + 1
    if i1 >= length:
        i1 = 0 if periodic else i0
    if polar:
        j = math.sqrt(across * across + up * up) / second_step
        k = math.atan2(-across, up) / third_step
        if k < 0.0:
            k += third
        j0 = min(int(j), second - 2)
        k0 = min(int(k), third - 1)
        k1 = k0 + 1 if k0 + 1 < third else 0
    else:
        j = across / second_step
        k = up / third_step
        j0 = min(max(int(j), 0), second - 2)
        k0 = min(max(int(k), 0), third - 2)
        k1 = k0 + 1
    fj, fk = j - j0, k - k0
    j1 = j0 + 1
    ci, cj, ck = 1.0 - fi, 1.0 - fj, 1.0 - fk
    w00, w01, w10, w11 = cj * ck, cj * fk, fj * ck, fj * fk
    u = ci * (
        w00 * box[i0, j0, k0, 0]
        + w01 * box[i0, j0, k1, 0]
        + w10 * box[i0, j1, k0, 0]
        + w11 * box[i0, j1, k1, 0]
    ) + fi * (
        w00 * box[i1, j0, k0, 0]
        + w01 * box[i1, j0, k1, 0]
        + w10 * box[i1, j1, k0, 0]
        + w11 * box[i1, j1, k1, 0]
    )
    v = ci * (
        w00 * box[i0, j0, k0, 1]
        + w01 * box[i0, j0, k1, 1]
        + w10 * box[i0, j1, k0, 1]
        + w11 * box[i0, j1, k1, 1]
    ) + fi * (
        w00 * box[i1, j0, k0, 1]
        + w01 * box[i1, j0, k1, 1]
        + w10 * box[i1, j1, k0, 1]
        + w11 * box[i1, j1, k1, 1]
    )
    w = ci * (
        w00 * box[i0, j0, k0, 2]
        + w01 * box[i0, j0, k1, 2]
        + w10 * box[i0, j1, k0, 2]
        + w11 * box[i0, j1, k1, 2]
    ) + fi * (
        w00 * box[i1, j0, k0, 2]
        + w01 * box[i1, j0, k1, 2]
        + w10 * box[i1, j1, k0, 2]
        + w11 * box[i1, j1, k1, 2]
    )
    return u, v, w


@_compiled
def wind_velocity(
    tables: WindTables, x: float, y: float, z: float, t: float
) -> tuple[float, float, float]:
    """Velocity at a point without the tower [m/s].

    The loop over blade elements has the same steps with the tables taken out of the tuple, which
    the compiler would otherwise hand over element by element.
    """
    mean = wind_speed(tables.time, tables.speed, t) * (
        table(tables.shear, tables.shear_low, tables.shear_step, z) + tables.slope * y
    )
    u, v, w = mean, 0.0, 0.0
    if tables.kind != NO_BOX:
        u, v, w = fluctuation(
            tables.box,
            tables.kind == POLAR,
            tables.periodic,
            (tables.carrier * t - tables.cosine * x - tables.sine * y) / tables.step
            + tables.offset,
            tables.cosine * y - tables.sine * x - tables.low[0],
            z - tables.low[1],
            tables.steps[0],
            tables.steps[1],
        )
        u += mean
    return tables.cosine * u - tables.sine * v, tables.sine * u + tables.cosine * v, w


@_compiled
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
