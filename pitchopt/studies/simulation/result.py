"""What simulated runs give: series, statistics, and their sums over seeds and wind speeds."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal

import numpy as np

from pitchopt.checks import FloatArray
from pitchopt.exports import TimeSeries
from pitchopt.fatigue import bin_edges, combine_loads, weibull_weights
from pitchopt.sim import Channel, ChannelStatistics, average
from pitchopt.studies.simulation.settings import SimulationSettings

__all__ = ["Lifetime", "RunResult", "SimulationResult", "SpeedResult"]

_CLASS_MEAN = {"I": 10.0, "II": 8.5, "III": 7.5}  # 0.2 V_ref, IEC 61400-1:2019, table 1


@dataclass(frozen=True, kw_only=True, eq=False)
class RunResult:
    """One run.

    Attributes
    ----------
    wind_speed : float
        Mean at the hub [m/s].
    turbulence : str
    seed : int or None
    status : {"finished", "diverged"}
    message : str
    diverged_at : float or None
        From the beginning of the run [s].
    seconds : float
        Wall time of the time loop.
    statistics : mapping of str to ChannelStatistics, or None
        By channel, SI units; None if the run diverged before there was anything to take them over.
    series : TimeSeries
        The whole run, OpenFAST's units.
    step_error : float
        Error check of the time loop: largest distance between predicted and final rate of any
        degree of freedom, over the largest rate.
    evaluations : float
        Of the momentum balance, mean per blade element and step.
    """

    wind_speed: float
    turbulence: str
    seed: int | None
    status: Literal["finished", "diverged"]
    message: str
    diverged_at: float | None
    seconds: float
    statistics: Mapping[str, ChannelStatistics] | None
    series: TimeSeries
    step_error: float
    evaluations: float


@dataclass(frozen=True, kw_only=True, eq=False)
class SpeedResult:
    """The runs of one wind speed together.

    Attributes
    ----------
    wind_speed : float
        [m/s].
    runs, diverged : int
        All of them, and those of them that diverged.
    statistics : mapping or None
        Of those that finished, see `pitchopt.sim.average`; None if none did.
    """

    wind_speed: float
    runs: int
    diverged: int
    statistics: Mapping[str, ChannelStatistics] | None


@dataclass(frozen=True, kw_only=True, eq=False)
class Lifetime:
    """Sums over the wind speeds, weighted with their Rayleigh distribution.

    Attributes
    ----------
    mean_wind_speed : float
        Of the site [m/s].
    weights : ndarray (W,)
        Of the wind speeds, sum one.
    share : float
        Of all time that the bins around the wind speeds stand for.
    means : mapping of str to float
        Weighted means of channels, SI units.
    equivalent_loads : mapping of str to float
    """

    mean_wind_speed: float
    weights: FloatArray
    share: float
    means: Mapping[str, float]
    equivalent_loads: Mapping[str, float]


@dataclass(frozen=True, kw_only=True, eq=False)
class SimulationResult:
    """A study.

    Attributes
    ----------
    turbine, controller : str
        Names.
    iec_class : str or None
        Of the turbine.
    settings : SimulationSettings
    step : float
        Of the time loop [s].
    interval : float
        Between two instants of the series, whole steps [s].
    channels : tuple of Channel
        Of statistics and series.
    runs : tuple of RunResult
        In the order of wind speeds, then seeds.
    seconds : float
        Wall time of everything.
    """

    turbine: str
    controller: str
    iec_class: str | None
    settings: SimulationSettings
    step: float
    interval: float
    channels: tuple[Channel, ...]
    runs: tuple[RunResult, ...]
    seconds: float

    @property
    def diverged(self) -> bool:
        """True if any run did."""
        return any(run.status == "diverged" for run in self.runs)

    def summary(self) -> list[SpeedResult]:
        """The wind speeds, ascending."""
        found = []
        for speed in sorted({run.wind_speed for run in self.runs}):
            runs = [run for run in self.runs if run.wind_speed == speed]
            good = [
                dict(run.statistics)
                for run in runs
                if run.status == "finished" and run.statistics is not None
            ]
            found.append(
                SpeedResult(
                    wind_speed=speed,
                    runs=len(runs),
                    diverged=sum(run.status == "diverged" for run in runs),
                    statistics=average(good) if good else None,
                )
            )
        return found

    def lifetime(self) -> Lifetime | None:
        """Sums over two or more wind speeds; None for one, or without a mean wind speed."""
        mean = self.settings.weibull_mean
        if mean is None and self.iec_class is not None:
            mean = _CLASS_MEAN.get(self.iec_class.rstrip("ABCS+"))
        speeds = self.summary()
        parts = [speed.statistics for speed in speeds if speed.statistics is not None]
        if mean is None or len(speeds) < 2 or len(parts) < len(speeds):
            return None
        weights = weibull_weights(bin_edges([s.wind_speed for s in speeds]), mean=mean)
        share = float(weights.sum())
        if share <= 0.0:
            return None
        weights = weights / share
        means: dict[str, float] = {}
        loads: dict[str, float] = {}
        for name, first in parts[0].items():
            means[name] = float(weights @ np.array([part[name].mean for part in parts]))
            if first.slope is not None:
                values = np.array([part[name].equivalent_load for part in parts], dtype=np.float64)
                loads[name] = float(combine_loads(values, weights, first.slope))
        return Lifetime(
            mean_wind_speed=mean,
            weights=weights,
            share=share,
            means=means,
            equivalent_loads=loads,
        )
