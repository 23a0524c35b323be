"""Wind that changes while a plant runs: hub wind speed over rotations.

Rotations are counted from the end of a learner's experiment: 0 is the beginning of the first
rotation of learning, and what lies before it has the starting speed.  Within a blade passage the
speed is held.

Schedules that take a few speeds only name them in `levels`, and curves are made for exactly
these.  The others pass through an evenly spaced grid around the starting speed, and what is
known at its speeds is interpolated linearly: x(v) = (1 - s) x(v_i) + s x(v_i+1).
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache
from typing import Protocol, runtime_checkable

import numpy as np

from pitchopt.checks import FloatArray, finite_array, finite_number, whole_number
from pitchopt.errors import InputError

__all__ = [
    "DRIFT_CUT",
    "ConstantWind",
    "WindDrift",
    "WindRamp",
    "WindSchedule",
    "WindStep",
    "interpolated",
]

DRIFT_CUT = 3.0
"""Standard deviations at which a drift is cut off."""

_LARGEST_STD = 0.2  # share of the speed, so that the cut-off drift stays above 0
_ON_GRID = 1e-9  # share of the spacing
_BLOCK = 1024  # rotations of drift drawn at a time


@runtime_checkable
class WindSchedule(Protocol):
    """Hub wind speed over rotations."""

    @property
    def speed(self) -> float:
        """Speed at the start [m/s]."""
        ...

    @property
    def levels(self) -> tuple[float, ...] | None:
        """All speeds that are taken [m/s], None if there is no end of them."""
        ...

    def at(self, rotation: float) -> float:
        """Speed [m/s] at so many rotations since the end of the experiment."""
        ...


@dataclass(frozen=True, kw_only=True)
class ConstantWind:
    """The same speed [m/s] throughout."""

    speed: float

    def __post_init__(self) -> None:
        _set(self, "speed", finite_number("wind speed", self.speed, above=0))

    @property
    def levels(self) -> tuple[float, ...]:
        """The speed."""
        return (self.speed,)

    def at(self, rotation: float) -> float:  # noqa: ARG002  part of the protocol
        """Speed [m/s]."""
        return self.speed


@dataclass(frozen=True, kw_only=True)
class WindStep:
    """A sudden change: `rotation` whole rotations see the old speed, all that follow the new one.

    Parameters
    ----------
    speed, change : float
        Speed at the start and what is added to it [m/s].
    rotation : int
        22: the 23rd rotation is the first at the new speed.
    """

    speed: float
    change: float
    rotation: int

    def __post_init__(self) -> None:
        _changing(self)
        _set(self, "rotation", whole_number("wind step rotation", self.rotation, at_least=0))

    @property
    def levels(self) -> tuple[float, ...]:
        """Old and new speed."""
        return self.speed, self.speed + self.change

    def at(self, rotation: float) -> float:
        """Speed [m/s]."""
        return self.speed if rotation < self.rotation else self.speed + self.change


@dataclass(frozen=True, kw_only=True)
class WindRamp:
    """A change that is linear in rotations.

    Parameters
    ----------
    speed, change : float
        Speed at the start and what is added to it [m/s].
    first, last : float
        Rotations at which the ramp begins and ends, 0 <= first < last.
    """

    speed: float
    change: float
    first: float
    last: float

    def __post_init__(self) -> None:
        _changing(self)
        _set(self, "first", finite_number("wind ramp first", self.first, at_least=0))
        _set(self, "last", finite_number("wind ramp last", self.last, above=self.first))

    @property
    def levels(self) -> None:
        """None."""
        return None

    def at(self, rotation: float) -> float:
        """Speed [m/s]."""
        share = (rotation - self.first) / (self.last - self.first)
        return self.speed + self.change * min(max(share, 0.0), 1.0)


@dataclass(frozen=True, kw_only=True)
class WindDrift:
    """A slow random drift about the starting speed, an Ornstein-Uhlenbeck process.

        x_0 = 0,   x_n+1 = a x_n + std sqrt(1 - a^2) w_n,   a = exp(-1 / rotations_correlation),

    with w_n from ``numpy.random.default_rng(seed)``; linear between whole rotations and cut off
    at three standard deviations.  It is a function of the rotation alone: a run that is taken up
    again sees the same wind.

    Parameters
    ----------
    speed : float
        [m/s].
    std : float
        Standard deviation [m/s], above 0 and at most a fifth of the speed.
    rotations_correlation : float
        Rotations after which the correlation has fallen to 1/e.
    seed : int
    """

    speed: float
    std: float
    rotations_correlation: float
    seed: int = 0

    def __post_init__(self) -> None:
        _set(self, "speed", finite_number("wind speed", self.speed, above=0))
        most = _LARGEST_STD * self.speed
        _set(self, "std", finite_number("wind drift std", self.std, above=0, at_most=most))
        name = "wind drift rotations_correlation"
        correlation = finite_number(name, self.rotations_correlation, above=0)
        _set(self, "rotations_correlation", correlation)
        _set(self, "seed", whole_number("wind drift seed", self.seed, at_least=0))

    @property
    def levels(self) -> None:
        """None."""
        return None

    def at(self, rotation: float) -> float:
        """Speed [m/s]."""
        if rotation <= 0:
            return self.speed
        whole = math.floor(rotation)
        blocks = (whole + 2) // _BLOCK + 1
        path = _drift(self.rotations_correlation, self.seed, blocks)
        share = rotation - whole
        place = (1 - share) * path[whole] + share * path[whole + 1]
        return self.speed + self.std * float(np.clip(place, -DRIFT_CUT, DRIFT_CUT))


def interpolated(
    wind: WindSchedule, speed: float, spacing: float, value: Callable[[float], FloatArray]
) -> FloatArray:
    """What is known at exact wind speeds, at any speed of a schedule.

    Parameters
    ----------
    wind : WindSchedule
    speed : float
        A speed that it takes [m/s].
    spacing : float
        Of the grid speeds [m/s].
    value : callable
        Called with a speed of `levels`, or with the one or two grid speeds about `speed`.
    """
    if wind.levels is not None:
        return value(speed)
    steps = (speed - wind.speed) / spacing
    low = math.floor(steps + _ON_GRID)
    share = steps - low
    near = value(wind.speed + spacing * low)
    if share <= _ON_GRID:
        return near
    return np.asarray((1 - share) * near + share * value(wind.speed + spacing * (low + 1)))


@lru_cache(maxsize=32)
def _drift(correlation: float, seed: int, blocks: int) -> FloatArray:
    """The process with unit standard deviation; a longer one begins as a shorter one does."""
    decay = math.exp(-1.0 / correlation)
    shocks = math.sqrt(1 - decay**2) * np.random.default_rng(seed).standard_normal(blocks * _BLOCK)
    path = np.zeros(shocks.size)
    for n in range(1, shocks.size):
        path[n] = decay * path[n - 1] + shocks[n - 1]
    return finite_array("wind drift", path)


def _changing(wind: WindStep | WindRamp) -> None:
    _set(wind, "speed", finite_number("wind speed", wind.speed, above=0))
    _set(wind, "change", finite_number("wind change", wind.change))
    if wind.speed + wind.change <= 0:
        raise InputError(
            f"wind change: got {wind.change:g} m/s, which from {wind.speed:g} m/s leaves "
            f"{wind.speed + wind.change:g} m/s, expected a speed above 0"
        )


def _set(owner: object, name: str, value: object) -> None:
    object.__setattr__(owner, name, value)
