"""Winds of simulated runs: steady, Kaimal boxes by class and seed, boxes from files.

A Kaimal box reaches a hundredth of its width beyond where the blades go; files must reach as far
as the blades and last as long as the run.  Shear and tower shadow are those of the mean wind.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from pathlib import Path

from pitchopt.errors import InputError
from pitchopt.sim import DynamicTurbine
from pitchopt.sim.wind import Wind
from pitchopt.studies.simulation.settings import TURBSIM, WIND_SPEED, SimulationSettings
from windfield import (
    BoxCache,
    PowerLaw,
    StaticField,
    TowerShadow,
    TurbulenceBox,
    TurbulentField,
    kaimal_box,
    read_bts,
    read_hawc2,
)
from windfield.turbulent import SPEED_TOLERANCE

__all__ = ["CLASSES", "WindCase", "turbulence_level", "wind_cases"]

CLASSES = ("A+", "A", "B", "C")
_MARGIN = 1.01
_BOX = "_u.bin"


@dataclass(frozen=True)
class WindCase:
    """One wind of a study.

    Attributes
    ----------
    wind_speed : float
        Mean at the hub [m/s].
    turbulence : str
        What the wind is, in words.
    seed : int or None
        None for a wind that has none.
    mean : StaticField
        Mean wind.
    make : callable
        Returns the wind.
    """

    wind_speed: float
    turbulence: str
    seed: int | None
    mean: StaticField
    make: Callable[[], Wind]


def wind_cases(
    dynamic: DynamicTurbine, settings: SimulationSettings, cache: BoxCache | None = None
) -> list[WindCase]:
    """Winds in the order of speeds, then seeds; Kaimal boxes are made when they are asked for.

    Raises
    ------
    InputError
        If the turbulence is none of the known kinds, or other settings do not go with it.
    windfield.WindFieldError
        If a file is missing or damaged.
    """
    kind = _kind(settings)
    if kind != "Kaimal" and settings.seeds is not None:
        raise InputError(
            f"seeds: got {', '.join(map(str, settings.seeds))} with turbulence "
            f"{settings.turbulence!r}, expected none: the wind is given"
        )
    if kind != "HAWC2" and settings.box_shape is not None:
        raise InputError(
            f"box_shape: got one with turbulence {settings.turbulence!r}, expected none: only a "
            "HAWC2 box needs it"
        )
    if kind == "TurbSim":
        return [_turbsim(dynamic, settings)]
    speeds = (WIND_SPEED,) if settings.wind_speeds is None else settings.wind_speeds
    means = {speed: _mean(dynamic, settings, speed) for speed in speeds}
    if kind == "none":
        return [WindCase(u, "none", None, mean, partial(_same, mean)) for u, mean in means.items()]
    if kind == "HAWC2":
        box = _hawc2(dynamic, settings, speeds[0])
        return [
            WindCase(u, box.label, None, mean, partial(_carried, mean, box))
            for u, mean in means.items()
        ]
    level = turbulence_level(settings.turbulence)
    word = f"class {level}" if isinstance(level, str) else f"intensity {level:g}"
    return [
        WindCase(
            u, f"Kaimal, {word}", seed, mean,
            partial(_kaimal, mean, seed, dynamic, settings, cache),
        )
        for u, mean in means.items()
        for seed in settings.seeds or (1,)
    ]  # fmt: skip


def _same(wind: Wind) -> Wind:
    return wind


def _carried(mean: StaticField, box: TurbulenceBox) -> Wind:
    """Turbulence of a box that holds no mean speed, in a mean wind."""
    return TurbulentField(mean=mean, box=dataclasses.replace(box, mean_speed=mean.speed))


def _kind(settings: SimulationSettings) -> str:
    text = settings.turbulence
    if text == "none":
        return "none"
    if isinstance(turbulence_level(settings.turbulence), float) or text in CLASSES:
        return "Kaimal"
    if text.lower().endswith(TURBSIM):
        return "TurbSim"
    if text.endswith(_BOX) or Path(text + _BOX).is_file():
        return "HAWC2"
    raise InputError(
        f"turbulence: got {text!r}, expected one of {', '.join(CLASSES)}, none, an intensity such "
        f"as 0.14, a file ending in .bts, or FILE of a HAWC2 box in FILE{_BOX}, FILE_v.bin and "
        "FILE_w.bin"
    )


def turbulence_level(text: str) -> str | float:
    """Turbulence as `windfield.kaimal_box` takes it: a number for an intensity, else the text.

    Raises
    ------
    InputError
        If an intensity is out of range.
    """
    try:
        level = float(text)
    except ValueError:
        return text
    if not 0.0 < level <= 1.0:
        raise InputError(
            f"turbulence: got {level:g}, expected an intensity above 0 and at most 1; none for "
            "steady wind"
        )
    return level


def _shadow(dynamic: DynamicTurbine, settings: SimulationSettings) -> TowerShadow | None:
    tower = dynamic.turbine.tower
    if not settings.tower_shadow:
        return None
    return TowerShadow(radius=tower.radius, height=tower.height, top=tower.top)


def _mean(dynamic: DynamicTurbine, settings: SimulationSettings, speed: float) -> StaticField:
    exponent = settings.exponent
    return StaticField(
        speed=speed,
        hub_height=dynamic.turbine.rotor.hub_height,
        vertical=None if exponent is None else PowerLaw(exponent=exponent),
        tower=_shadow(dynamic, settings),
    )


def _kaimal(
    mean: StaticField,
    seed: int,
    dynamic: DynamicTurbine,
    settings: SimulationSettings,
    cache: BoxCache | None,
) -> Wind:
    reach, hub = dynamic.reach, dynamic.turbine.rotor.hub_height
    half = _MARGIN * max(reach.half_width, reach.high - hub, hub - reach.low)
    box = kaimal_box(
        mean.speed,
        settings.length,
        settings.box_interval,
        hub_height=hub,
        width=2.0 * half,
        height=2.0 * min(half, hub),
        points=(settings.box_points, settings.box_points),
        turbulence=turbulence_level(settings.turbulence),
        seed=seed,
        cache=cache,
    )
    return TurbulentField(mean=mean, box=box)


def _turbsim(dynamic: DynamicTurbine, settings: SimulationSettings) -> WindCase:
    if settings.shear is not None:
        raise InputError(
            f"shear: got {settings.shear:g} with turbulence {settings.turbulence!r}, expected "
            "none: the file holds its own"
        )
    wind = read_bts(settings.turbulence)
    field = wind.field(_shadow(dynamic, settings))
    speed, hub = field.mean.speed, dynamic.turbine.rotor.hub_height
    given = settings.wind_speeds
    if given is not None and (
        len(given) > 1 or not math.isclose(given[0], speed, rel_tol=SPEED_TOLERANCE)
    ):
        raise InputError(
            f"wind_speeds: got {', '.join(f'{u:g}' for u in given)} m/s with turbulence "
            f"{settings.turbulence!r}, expected the file's own {speed:g} m/s or nothing"
        )
    if abs(wind.reference_height - hub) > SPEED_TOLERANCE * hub:
        raise InputError(
            f"turbulence: {settings.turbulence}: its mean speed holds at "
            f"{wind.reference_height:g} m, expected the hub height of {hub:g} m"
        )
    return WindCase(speed, wind.box.label, None, field.mean, partial(_same, field))


def _hawc2(dynamic: DynamicTurbine, settings: SimulationSettings, speed: float) -> TurbulenceBox:
    if settings.box_shape is None or settings.box_spacing is None:
        raise InputError(
            f"box_shape: got none with turbulence {settings.turbulence!r}, expected the points "
            "and the spacing of the HAWC2 box, which its files do not hold"
        )
    prefix = settings.turbulence.removesuffix(_BOX)
    return read_hawc2(
        *(f"{prefix}_{component}.bin" for component in "uvw"),
        shape=settings.box_shape,
        spacing=settings.box_spacing,
        mean_speed=speed,
        centre_height=dynamic.turbine.rotor.hub_height,
    )
