"""What a full set of simulations holds besides tower and controller: winds, site, counting."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from pitchopt.checks import finite_number, whole_number
from pitchopt.errors import InputError
from pitchopt.fatigue import bin_edges
from pitchopt.studies.simulation import SimulationSettings
from pitchopt.studies.simulation.winds import CLASSES

__all__ = ["LoadSettings"]


@dataclass(frozen=True, kw_only=True)
class LoadSettings:
    """What a set holds besides tower and controller.

    Parameters
    ----------
    wind_speeds : tuple of float
        Mean speeds at the hub [m/s]; 3 to 25 in steps of 2 in the paper.
    seeds : tuple of int
        Of the turbulence at each of them.
    duration, skip : float
        Length of a run, and its beginning that is left out [s].
    interval : float
        Between two samples of a moment [s].  Peaks between samples are missed: against samples of
        0.025 s, 0.05 s lose 0.2 % of the damage at the base of the IEA 3.4 MW's tower, and 1 to
        3 % at its top.
    turbulence : str
        IEC class, or an intensity.
    mean_wind_speed : float
        Of the Rayleigh distribution at the reference turbine's hub height [m/s]; 7.5 for class III.
    shear : float
        Exponent of the mean wind, in time and from one hub height to another.
    lifetime : float
        [years].
    stations, axes : int
        Of the tower, and across it.
    box_points : int
        Of a turbulence box across and upward.

    Raises
    ------
    InputError
        If a number is out of range.
    """

    wind_speeds: tuple[float, ...] = tuple(np.arange(3.0, 26.0, 2.0).tolist())
    seeds: tuple[int, ...] = (1, 2, 3, 4, 5, 6)
    duration: float = 600.0
    skip: float = 30.0
    interval: float = 0.05
    turbulence: str = "A"
    mean_wind_speed: float = 7.5
    shear: float = 0.2
    lifetime: float = 20.0
    stations: int = 19
    axes: int = 8
    box_points: int = 13

    def __post_init__(self) -> None:
        finite_number("duration", self.duration, above=0.0)
        finite_number("skip", self.skip, at_least=0.0)
        if self.skip > 0.5 * self.duration:
            raise InputError(
                f"duration, skip: got {self.duration:g} and {self.skip:g} s, expected runs "
                "at least twice as long as what is left out of them"
            )
        finite_number("mean_wind_speed", self.mean_wind_speed, above=0.0)
        finite_number("lifetime", self.lifetime, above=0.0)
        whole_number("stations", self.stations, at_least=2)
        whole_number("axes", self.axes, at_least=1)
        bin_edges(self.wind_speeds)
        finite_number("shear", self.shear, at_least=0.0, at_most=1.0)
        if self.turbulence not in CLASSES and not _is_intensity(self.turbulence):
            raise InputError(
                f"turbulence: got {self.turbulence!r}, expected one of {', '.join(CLASSES)}, or an "
                "intensity above 0 and at most 1; the winds of a set come from seeds"
            )
        self.simulated  # noqa: B018  (raises what is wrong)

    @property
    def simulated(self) -> SimulationSettings:
        """Settings of the runs."""
        return SimulationSettings(
            wind_speeds=tuple(self.wind_speeds),
            turbulence=self.turbulence,
            seeds=tuple(self.seeds),
            duration=self.duration - self.skip,
            skip=self.skip,
            interval=self.interval,
            shear=self.shear,
            box_points=self.box_points,
        )


def _is_intensity(text: str) -> bool:
    try:
        return 0.0 < float(text) <= 1.0
    except ValueError:
        return False
