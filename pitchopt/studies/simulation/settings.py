"""SimulationSettings: winds, length and output of the runs of a dynamic turbine."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from itertools import pairwise
from typing import Any

from pitchopt.checks import finite_array, finite_number, whole_number
from pitchopt.errors import InputError

__all__ = ["TURBSIM", "WIND_SPEED", "SimulationSettings"]

WIND_SPEED = 12.0
TURBSIM = ".bts"
SHEAR = 0.2  # exponent of the normal wind profile, IEC 61400-1


@dataclass(frozen=True, kw_only=True)
class SimulationSettings:
    """What is simulated besides turbine and controller.

    Parameters
    ----------
    wind_speeds : tuple of float, optional
        Mean speeds at the hub [m/s], different and ascending; 12 m/s, or that of the .bts file,
        without.
    turbulence : str
        ``A+``, ``A``, ``B``, ``C``, an intensity such as ``0.14``, ``none``, a .bts file, or the
        HAWC2 box of which ``FILE_u.bin`` is the first of three files.
    seeds : tuple of int, optional
        Of Kaimal boxes; 1 without.
    duration : float
        That statistics are taken over [s].
    skip : float
        Simulated before that and left out of them [s].
    interval : float
        Between two instants of the series [s], rounded to whole steps of the loop.
    shear : float, optional
        Exponent of the mean wind's power law; 0.2 without, or the shear that a .bts file holds.
    tower_shadow : bool
    box_points : int
        Of a Kaimal box across and upward.
    box_interval : float
        Between two slices of it [s].
    box_shape : tuple of int, optional
        Nx, Ny, Nz of a HAWC2 box.
    box_spacing : tuple of float, optional
        dx, dy, dz of a HAWC2 box [m].
    channels : tuple of str, optional
        Channels of statistics and files; a selection without, all of them for ``("all",)``.
    weibull_mean : float, optional
        Mean wind speed of the site [m/s]; that of the turbine's class without.

    Raises
    ------
    InputError
        If a value is out of range or two of them contradict each other.
    """

    wind_speeds: tuple[float, ...] | None = None
    turbulence: str = "B"
    seeds: tuple[int, ...] | None = None
    duration: float = 600.0
    skip: float = 60.0
    interval: float = 0.05
    shear: float | None = None
    tower_shadow: bool = True
    box_points: int = 13
    box_interval: float = 0.1
    box_shape: tuple[int, int, int] | None = None
    box_spacing: tuple[float, float, float] | None = None
    channels: tuple[str, ...] | None = None
    weibull_mean: float | None = None

    def __post_init__(self) -> None:
        finite_number("interval", self.interval, above=0.0)
        if finite_number("duration", self.duration) < 2.0 * self.interval:
            raise InputError(
                f"duration: got {self.duration:g} s, expected at least two intervals of the "
                f"series, {2.0 * self.interval:g} s"
            )
        finite_number("skip", self.skip, at_least=0.0)
        finite_number("box_interval", self.box_interval, above=0.0)
        whole_number("box_points", self.box_points, at_least=2)
        if self.wind_speeds is not None:
            speeds = finite_array("wind_speeds", self.wind_speeds).tolist()
            if any(b <= a for a, b in pairwise(speeds)) or speeds[0] <= 0.0:
                raise InputError(
                    f"wind_speeds: got {', '.join(f'{s:g}' for s in speeds)} m/s, expected "
                    "positive speeds, different and ascending"
                )
        if self.seeds is not None:
            for seed in self.seeds:
                whole_number("seeds", seed, at_least=0)
            if len(set(self.seeds)) != len(self.seeds) or not self.seeds:
                raise InputError(f"seeds: got {self.seeds}, expected one or more, different")
        if self.shear is not None:
            finite_number("shear", self.shear, at_least=-1.0, at_most=1.0)
        if (self.box_shape is None) != (self.box_spacing is None):
            raise InputError(
                "box_shape, box_spacing: got one of them, expected both for a HAWC2 box"
            )
        if self.weibull_mean is not None:
            finite_number("weibull_mean", self.weibull_mean, above=0.0)

    @property
    def length(self) -> float:
        """Of a run [s]."""
        return self.skip + self.duration

    @property
    def exponent(self) -> float | None:
        """Of the mean wind's power law; None where a .bts file holds the shear."""
        if self.shear is None and not self.turbulence.lower().endswith(TURBSIM):
            return SHEAR
        return self.shear

    def plain(self) -> dict[str, Any]:
        """As plain data."""
        return asdict(self)
