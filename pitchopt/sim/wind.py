"""Wind fields as tables for the time loop.

The compiled loop evaluates the very definition of `windfield`'s fields; vertical shear and tower
radius are tabulated over height.  Linear interpolation errs by less than 1e-5 of the wind speed at
any height a blade reaches, and by up to 2e-4 where the tower's shadow ends within a metre.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from pitchopt.checks import FloatArray
from pitchopt.errors import InputError
from pitchopt.sim.kernels_wind import CARTESIAN, NO_BOX, POLAR, WindTables
from pitchopt.turbines import Turbine
from windfield import StaticField, TransientField, TurbulentField, WindFieldError
from windfield.boxes import PolarBox, TurbulenceBox

__all__ = [
    "Reach",
    "Wind",
    "check_speeds",
    "check_wind",
    "hub_speed_range",
    "wind_direction",
    "wind_tables",
]


class Reach(NamedTuple):
    """Where the blades of a turbine go, seen along the mean wind.

    Attributes
    ----------
    low, high : float
        Least and largest height [m].
    half_width : float
        To either side [m].
    upwind, downwind : float
        From the tower axis, not negative [m].
    """

    low: float
    high: float
    half_width: float
    upwind: float
    downwind: float


Wind = StaticField | TransientField | TurbulentField

_SHEAR_STEP = 0.5  # [m]
_TOWER_STEP = 0.1


def hub_speed_range(wind: Wind) -> tuple[float, float]:
    """Least and largest mean wind speed at the hub [m/s]."""
    if isinstance(wind, TransientField):
        return float(wind.speed.min()), float(wind.speed.max())
    speed = wind.speed if isinstance(wind, StaticField) else wind.mean.speed
    return speed, speed


def wind_direction(wind: Wind) -> float:
    """Direction of the mean wind [rad].

    Raises
    ------
    InputError
        If the field is of another kind.
    """
    if isinstance(wind, StaticField):
        return wind.direction
    if isinstance(wind, TransientField | TurbulentField):
        return wind.mean.direction
    raise _foreign(wind)


def check_speeds(turbine: Turbine, slowest: float, fastest: float) -> None:
    """Refuse mean wind speeds at the hub [m/s] below cut-in or above cut-out.

    Raises
    ------
    InputError
        Saying which limit is passed.
    """
    low, high = turbine.cut_in_wind_speed, turbine.cut_out_wind_speed
    for limit, name, speed, outside in (
        (low, "cut-in", slowest, low is not None and slowest < low - 1e-9),
        (high, "cut-out", fastest, high is not None and fastest > high + 1e-9),
    ):
        if outside:
            raise InputError(
                f"wind: got a mean speed of {speed:g} m/s at the hub, turbine {turbine.name!r} "
                f"has its {name} at {limit:g} m/s"
            )


def check_wind(
    turbine: Turbine,
    reach: Reach,
    wind: Wind,
    duration: float,
    *,
    any_wind: bool = False,
    repeat: bool = False,
) -> None:
    """Refuse a wind that the turbine cannot run in for `duration` [s].

    Parameters
    ----------
    reach : Reach
        In the direction of the wind.
    any_wind : bool
        Allow mean winds below cut-in and above cut-out.
    repeat : bool
        Allow a periodic box shorter than the run.

    Raises
    ------
    InputError
        Saying what is wrong and what the limit is.
    """
    if not isinstance(wind, StaticField | TransientField | TurbulentField):
        raise _foreign(wind)
    if not any_wind:
        check_speeds(turbine, *hub_speed_range(wind))
    if isinstance(wind, TurbulentField):
        try:
            wind.box.require(
                reach.low,
                reach.high,
                reach.half_width,
                duration,
                x_low=-reach.upwind,
                x_high=reach.downwind,
                repeat=repeat,
            )
        except WindFieldError as error:
            raise InputError(f"wind: {error}") from error


def _foreign(wind: object) -> InputError:
    return InputError(
        f"wind: got {type(wind).__name__}, expected a StaticField, TransientField or "
        "TurbulentField of windfield"
    )


def wind_tables(wind: Wind, reach: Reach) -> WindTables:
    """Tables of a wind field for where the blades go.

    Raises
    ------
    InputError
        If the field is of another kind.
    """
    if isinstance(wind, StaticField):
        mean, time, speed = wind, np.zeros(1), np.array([wind.speed])
    elif isinstance(wind, TransientField):
        mean, time, speed = wind.mean, np.array(wind.time), np.array(wind.speed)
    elif isinstance(wind, TurbulentField):
        mean, time, speed = wind.mean, np.zeros(1), np.array([wind.mean.speed])
    else:
        raise _foreign(wind)
    start = max(reach.low - 2.0, 0.5 * _SHEAR_STEP)
    count = math.ceil((reach.high + 2.0 - start) / _SHEAR_STEP) + 1
    heights = start + _SHEAR_STEP * np.arange(count)
    shear = np.ones(heights.size)
    if mean.vertical is not None:
        shear = np.array(mean.vertical.factor(heights, mean.hub_height))
    tower, wall, tower_low = _tower(mean, start)
    return WindTables(
        time=time,
        speed=speed,
        shear_low=start,
        shear_step=_SHEAR_STEP,
        shear=shear,
        slope=mean.horizontal_shear,
        cosine=math.cos(mean.direction),
        sine=math.sin(mean.direction),
        tower_low=tower_low,
        tower_step=_TOWER_STEP,
        tower=tower,
        tower_radius=wall,
        lateral=True if mean.tower is None else mean.tower.lateral,
        **_box(wind.box if isinstance(wind, TurbulentField) else None),
    )


def _tower(mean: StaticField, low: float) -> tuple[FloatArray, FloatArray, float]:
    """Tower radius with and without the shadow's weight over height, and the first height."""
    shadow = mean.tower
    if shadow is None or shadow.strength == 0.0:
        return np.zeros(1), np.ones(1), low
    assert shadow.smoothing is not None  # set by TowerShadow
    top = shadow.top + max(shadow.smoothing, _TOWER_STEP)
    heights = low + _TOWER_STEP * np.arange(max(math.ceil((top - low) / _TOWER_STEP), 1) + 2)
    wall = np.array(shadow.radius_at(heights))
    return wall * np.sqrt(shadow.strength * shadow.weight(heights)), wall, low


def _box(box: TurbulenceBox | PolarBox | None) -> dict[str, Any]:
    if box is None:
        empty = np.zeros((2, 2, 2, 3), dtype=np.float32)
        empty.setflags(write=False)  # like that of a box: one type for the compiler
        return {
            "kind": NO_BOX,
            "box": empty,
            "carrier": 1.0,
            "step": 1.0,
            "offset": 0.0,
            "low": np.zeros(2),
            "steps": np.ones(2),
            "periodic": True,
        }
    if isinstance(box, TurbulenceBox):
        axes = (box.y, box.z)
        low = np.array([axis[0] for axis in axes])
        steps = np.array([(axis[-1] - axis[0]) / (axis.size - 1) for axis in axes])
        kind = CARTESIAN
    else:
        spokes = box.velocity.shape[2]
        low = np.array([0.0, box.centre_height])
        steps = np.array([box.radius[-1] / (box.radius.size - 1), 2.0 * math.pi / spokes])
        kind = POLAR
    return {
        "kind": kind,
        "box": box.velocity,
        "carrier": box.mean_speed,
        "step": box.spacing,
        "offset": box.offset,
        "low": low,
        "steps": steps,
        "periodic": box.periodic,
    }
