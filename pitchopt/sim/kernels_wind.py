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

__all__ = ["NO_BOX", "CARTESIAN", "POLAR", "WindTables", "wind_speed", "wind_velocity"]

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
        First value and step of the second and third index: y and z, or radius and azimuth.
    centre : float
        Height of the polar grid's centre [m].
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
    centre: float
    periodic: bool


@njit(cache=True, nogil=True)
def wind_speed(tables: WindTables, t: float) -> float:
    """Hub wind speed at time t [m/s]."""
    time, speed = tables.time, tables.speed
    last = time.size - 1
    if last == 0 or t <= time[0]:
        return speed[0]
    if t >= time[last]:
        return speed[last]
    i = np.searchsorted(time, t, side="right") - 1
    share = (t - time[i]) / (time[i + 1] - time[i])
    return speed[i] + share * (speed[i + 1] - speed[i])


@njit(cache=True, nogil=True)
def _table(values: FloatArray, low: float, step: float, at: float) -> float:
    """Linear in an evenly spaced table, constant outside."""
    position = (at - low) / step
    if position <= 0.0:
        return values[0]
    i = int(position)
    if i >= values.size - 1:
        return values[values.size - 1]
    return values[i] + (position - i) * (values[i + 1] - values[i])


@njit(cache=True, nogil=True)
def wind_velocity(
    tables: WindTables, hub_speed: float, x: float, y: float, z: float, t: float
) -> tuple[float, float, float]:
    """Velocity at a point [m/s]; `hub_speed` is `wind_speed` at that time."""
    mean = hub_speed * (
        _table(tables.shear, tables.shear_low, tables.shear_step, z) + tables.slope * y
    )
    u, v, w = mean * tables.cosine, mean * tables.sine, 0.0
    if tables.kind != NO_BOX:
        box = tables.box
        length, second, third = box.shape[0], box.shape[1], box.shape[2]
        along = tables.cosine * x + tables.sine * y
        across = tables.cosine * y - tables.sine * x
        i = (tables.carrier * t - along) / tables.step + tables.offset
        if tables.periodic:
            i -= length * math.floor(i / length)
        i0 = int(i)
        if i0 >= length:
            i0 = length - 1
        fi = i - i0
        i1 = i0 + 1
        if i1 >= length:
            i1 = 0 if tables.periodic else i0
        if tables.kind == CARTESIAN:
            j = (across - tables.low[0]) / tables.steps[0]
            k = (z - tables.low[1]) / tables.steps[1]
            j0 = min(max(int(j), 0), second - 2)
            k0 = min(max(int(k), 0), third - 2)
            k1 = k0 + 1
        else:
            dz = z - tables.centre
            j = math.sqrt(across * across + dz * dz) / tables.steps[0]
            angle = math.atan2(-across, dz) / tables.steps[1]
            if angle < 0.0:
                angle += third
            k = angle
            j0 = min(int(j), second - 2)
            k0 = min(int(k), third - 1)
            k1 = k0 + 1 if k0 + 1 < third else 0
        fj, fk = j - j0, k - k0
        j1 = j0 + 1
        ci, cj, ck = 1.0 - fi, 1.0 - fj, 1.0 - fk
        w00, w01, w10, w11 = cj * ck, cj * fk, fj * ck, fj * fk
        near = box[i0]
        far = box[i1]
        du = ci * (
            w00 * near[j0, k0, 0]
            + w01 * near[j0, k1, 0]
            + w10 * near[j1, k0, 0]
            + w11 * near[j1, k1, 0]
        ) + fi * (
            w00 * far[j0, k0, 0]
            + w01 * far[j0, k1, 0]
            + w10 * far[j1, k0, 0]
            + w11 * far[j1, k1, 0]
        )
        dv = ci * (
            w00 * near[j0, k0, 1]
            + w01 * near[j0, k1, 1]
            + w10 * near[j1, k0, 1]
            + w11 * near[j1, k1, 1]
        ) + fi * (
            w00 * far[j0, k0, 1]
            + w01 * far[j0, k1, 1]
            + w10 * far[j1, k0, 1]
            + w11 * far[j1, k1, 1]
        )
        w = ci * (
            w00 * near[j0, k0, 2]
            + w01 * near[j0, k1, 2]
            + w10 * near[j1, k0, 2]
            + w11 * near[j1, k1, 2]
        ) + fi * (
            w00 * far[j0, k0, 2]
            + w01 * far[j0, k1, 2]
            + w10 * far[j1, k0, 2]
            + w11 * far[j1, k1, 2]
        )
        u += tables.cosine * du - tables.sine * dv
        v += tables.sine * du + tables.cosine * dv
    return u, v, w


@njit(cache=True, nogil=True)
def tower_disturbance(
    tables: WindTables, x: float, y: float, z: float, u: float, v: float
) -> tuple[float, float]:
    """Change of the horizontal wind (u, v) at x, y from the tower axis at height z [m/s]."""
    radius = _table(tables.tower, tables.tower_low, tables.tower_step, z)
    if radius <= 0.0:
        return 0.0, 0.0
    wall = _table(tables.tower_radius, tables.tower_low, tables.tower_step, z)
    square = max(x * x + y * y, wall * wall)
    share = radius * radius / (square * square)
    even, odd = x * x - y * y, 2.0 * x * y
    if tables.lateral:
        return -share * (u * even + v * odd), share * (v * even - u * odd)
    speed = u * u + v * v
    if speed <= 0.0:
        return 0.0, 0.0
    change = -share * ((u * u - v * v) * even + 2.0 * u * v * odd) / speed
    return change * u, change * v
