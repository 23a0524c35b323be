"""Ground: the turbine, its winds and its actuators, the same for every method.

The case gives turbine, mean wind, range and rate of the actuators, weights of the design.  The
rotor turns freely under the turbine's baseline controller, blades and tower bend, the wake lags;
the actuators have one lag and one range, that reaches below the turbine's own so that blades can
pitch about a collective pitch at its end.  Tuners meet seeds 1 ... T of a wind, the learner seed
1, and all of them are judged in seeds from `FIRST_FRESH` on.
"""

from __future__ import annotations

import dataclasses
from functools import cached_property

import numpy as np

from pitchopt.cases import Case
from pitchopt.control import TurbineController
from pitchopt.errors import InputError
from pitchopt.sim import Operation, Start
from pitchopt.studies.comparison.settings import STEADY, ComparisonSettings
from pitchopt.studies.learning import TurbineSettings
from pitchopt.studies.learning.turbine_setup import TurbineSetup, structural_turbine
from pitchopt.studies.tuning import FIRST_FRESH, PlantRun, TuningPlant
from windfield import BoxCache

__all__ = ["Ground"]


class Ground:
    """What all methods have in common.

    Parameters
    ----------
    case : Case
        With a turbine whose structure is known, in wind with a power law or none, straight on.
    settings : ComparisonSettings
    workers : int, optional
        Threads of one controller's runs; as many as there are cores without.
    cache : BoxCache, optional
        Where Kaimal boxes are kept.

    Attributes
    ----------
    case : Case
        With the range of the actuators in it, and the rotor speed of steady operation.

    Raises
    ------
    InputError
        If the turbine or the wind cannot be simulated.
    """

    def __init__(
        self,
        case: Case,
        settings: ComparisonSettings,
        *,
        workers: int | None = None,
        cache: BoxCache | None = None,
    ) -> None:
        turbine = structural_turbine(case)
        _check(case)
        low, high = case.pitch_range
        if case.limits.pitch_min is None:
            low -= settings.pitch_below
        self.settings = settings
        self.wind_speed = case.wind.speed
        self._wide = case.with_values({"limits.pitch_min": low, "limits.pitch_max": high})
        self._first = TuningPlant(
            dataclasses.replace(
                turbine, pitch_range=(low, high), pitch_rate=case.pitch_limits.pitch_rate
            ),
            turbulence="none",
            duration=settings.duration,
            skip=STEADY * settings.skip,
            pitch_lag=settings.pitch_lag,
            shear=case.wind.shear_exponent if case.wind.shear == "power" else 0.0,
            tower_shadow=case.wind.tower_shadow,
            workers=workers,
            cache=cache,
        )
        self._first.check([(self.wind_speed, 1)])
        self._plant: tuple[str, TuningPlant] | None = None

    @property
    def operation(self) -> Operation:
        """Steady operation of the turbine."""
        return self._first.operation

    @cached_property
    def start(self) -> Start:
        """Steady operation at the mean wind speed."""
        return self.operation.start(self.wind_speed)

    @property
    def rotor_speed(self) -> float:
        """Of steady operation at the mean wind speed [rad/s]."""
        return self.start.rotor_speed

    @property
    def rate(self) -> float:
        """Largest rate of pitch commands: the controller's, or the actuators' if less [rad/s]."""
        return min(self.base.pitch_range.rate, self.case.pitch_limits.pitch_rate)

    def run_length(self, wind: str) -> float:
        """Of a simulation in a wind, start-up included [s]."""
        return self.plant(wind).settings.length

    @cached_property
    def case(self) -> Case:
        """See the class."""
        return self._wide.with_values({"operation.rotor_speed": self.rotor_speed})

    @cached_property
    def base(self) -> TurbineController:
        """Torque law and collective pitch of all methods."""
        return self.operation.baseline()

    @property
    def winds(self) -> tuple[str, ...]:
        """The winds by their turbulence, in the order of its intensity."""
        return self.settings.winds(self.wind_speed)

    def plant(self, wind: str) -> TuningPlant:
        """Plant in a wind; its boxes are in memory until that of another wind is asked for."""
        if self._plant is None or self._plant[0] != wind:
            self.operation  # noqa: B018  (made once, and shared by all plants)
            skip = (STEADY if wind == "none" else 1.0) * self.settings.skip
            self._plant = wind, self._first.in_turbulence(wind, skip=skip)
        return self._plant[1]

    def tuning_seeds(self, wind: str) -> tuple[int, ...]:
        """Seeds that tuners have; one stands for the steady wind."""
        return tuple(range(1, 1 + (1 if wind == "none" else self.settings.tuning_seeds)))

    def judge(self, controller: TurbineController, wind: str) -> list[PlantRun]:
        """Runs of a controller in the seeds of a wind that no method has met."""
        count = 1 if wind == "none" else self.settings.seeds
        seeds = range(FIRST_FRESH, FIRST_FRESH + count)
        return self.plant(wind).run(controller, [(self.wind_speed, seed) for seed in seeds])

    def setup(
        self, wind: str, *, lag: float, averaged: int = 0, harmonics: int | None = None
    ) -> TurbineSetup:
        """Plants of a learner in a wind, with actuators of a time constant [s]."""
        case = self._wide
        if harmonics is not None and case.objective.harmonics is None:
            case = case.with_values({"objective.harmonics": harmonics})
        return TurbineSetup(
            case,
            TurbineSettings(turbulence=wind, rotor="controlled", pitch_lag=lag, averaged=averaged),
            0.0,
        )


def _check(case: Case) -> None:
    wind = case.wind
    if not case.pitch_limits.pitch_rate:
        raise InputError(
            "limits.pitch_rate_deg: got 0, expected a rate above 0: there is nothing to compare "
            "without moving blades"
        )
    if case.operation.rotor_speed is not None:
        raise InputError(
            f"operation.rotor_speed_rpm: got {case.operation.rotor_speed * 30.0 / np.pi:g}, "
            "expected 'auto': in a comparison the rotor turns freely under its controller"
        )
    if wind.disc is not None or wind.shear not in ("power", "none"):
        what = "a disc file" if wind.disc is not None else f"shear {wind.shear!r}"
        raise InputError(f"wind: got {what}, expected a power law: simulations know no other shear")
    for section, name, word in (
        ("wind", "horizontal_shear", "wind.horizontal_shear"),
        ("wind", "direction", "wind.direction_deg"),
        ("operation", "yaw", "operation.yaw_deg"),
    ):
        value = getattr(getattr(case, section), name)
        if value:
            raise InputError(f"{word}: got {value:g}, expected 0 in a comparison")
