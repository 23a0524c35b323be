"""Simulated runs over time and over wind speed, and steady operating curves.

The plots take runs as the study of `pitchopt.studies.simulation` makes them, or anything with the
attributes of `RunsLike`.  Units are OpenFAST's, kW and kN-m brought to MW and MN-m.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Protocol

import numpy as np

from pitchopt.plotting.style import (
    BLADE_COLOURS,
    BLUE,
    GREY,
    VERMILION,
    axes_or_new,
    light_grid,
)

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from pitchopt.aero.steady import OperatingPoints
    from pitchopt.exports.series import TimeSeries
    from pitchopt.sim import Channel, ChannelStatistics

__all__ = [
    "CURVES",
    "OVER_TIME",
    "OVER_WIND_SPEED",
    "RunsLike",
    "SteadyCurve",
    "plot_channel",
    "plot_over_wind_speed",
    "plot_steady_curve",
]

OVER_TIME = ("Wind1VelX", "RotSpeed", "GenPwr", "BldPitch1", "TwrBsMyt", "RootMyc1")
OVER_WIND_SPEED = ("GenPwr", "RotSpeed", "BldPitch1", "RotThrust", "TwrBsMyt", "RootMyc1")
CURVES = ("power", "thrust", "rotor_speed", "pitch")
_MOST_SEEDS = 6
_WORDS = {
    "Wind1VelX": "wind at the hub",
    "RotSpeed": "rotor speed",
    "GenPwr": "power",
    "BldPitch1": "pitch of blade 1",
    "RotThrust": "thrust",
    "TwrBsMyt": "tower base\nfore-aft",
    "RootMyc1": "blade root\nout of plane",
}
_SCALED = {"kW": ("MW", 1e-3), "kN-m": ("MN-m", 1e-3), "kN": ("MN", 1e-3)}
_CURVE_LABELS = {
    "power": ("power over rated [-]", 1.0),
    "thrust": ("thrust [MN]", 1e-6),
    "rotor_speed": ("rotor speed [rpm]", 30.0 / np.pi),
    "pitch": ("pitch [deg]", 180.0 / np.pi),
}


class RunLike(Protocol):
    """One run."""

    @property
    def wind_speed(self) -> float:
        """Mean [m/s]."""
        ...

    @property
    def seed(self) -> int | None:
        """Of the turbulence."""
        ...

    @property
    def status(self) -> str:
        """``finished`` or ``diverged``."""
        ...

    @property
    def series(self) -> TimeSeries:
        """Channels over time."""
        ...


class SpeedLike(Protocol):
    """Runs of a wind speed together."""

    @property
    def wind_speed(self) -> float:
        """Mean [m/s]."""
        ...

    @property
    def statistics(self) -> Mapping[str, ChannelStatistics] | None:
        """By channel."""
        ...


class SettingsLike(Protocol):
    """What the runs were told."""

    @property
    def skip(self) -> float:
        """Start that is left out of statistics [s]."""
        ...


class RunsLike(Protocol):
    """Runs over wind speeds and seeds."""

    @property
    def runs(self) -> Sequence[RunLike]:
        """All of them."""
        ...

    @property
    def channels(self) -> Sequence[Channel]:
        """Of the series."""
        ...

    @property
    def settings(self) -> SettingsLike:
        """What they were told."""
        ...

    def summary(self) -> Sequence[SpeedLike]:
        """By wind speed."""
        ...


def _label(channel: Channel) -> tuple[str, float]:
    unit, factor = _SCALED.get(channel.unit, (channel.unit, 1.0))
    return f"{_WORDS.get(channel.name, channel.name)}\n[{unit}]", factor


def _channel(result: RunsLike, name: str) -> Channel:
    (found,) = (channel for channel in result.channels if channel.name == name)
    return found


def plot_channel(result: RunsLike, name: str, *, ax: Axes | None = None) -> Axes:
    """A channel over time in the first six runs; what statistics leave out on shaded ground.

    Parameters
    ----------
    result : RunsLike
    name : str
        Of a channel that the runs have.
    ax : Axes, optional
        Where to draw; a new figure without.
    """
    ax = axes_or_new(ax)
    text, factor = _label(_channel(result, name))
    runs = result.runs[:_MOST_SEEDS]
    for run, colour in zip(runs, BLADE_COLOURS[1:] + BLADE_COLOURS[:1], strict=False):
        time, values = run.series.time, factor * run.series[name]
        label = "steady" if run.seed is None else f"seed {run.seed}"
        ax.plot(
            time, values, color=colour, linewidth=0.9, alpha=1.0 if len(runs) == 1 else 0.8,
            label=label,
        )  # fmt: skip
        if run.status == "diverged":
            ax.plot(time[-1:], values[-1:], "x", color=colour, markersize=8, markeredgewidth=2)
    last = max(float(run.series.time[-1]) for run in runs)
    skip = min(result.settings.skip, last)
    if skip > 0.0:
        ax.axvspan(0.0, skip, color="0.92", linewidth=0, zorder=0)
    light_grid(ax)
    ax.set_xlim(0.0, last or 1.0)
    ax.set_ylabel(text)
    return ax


def plot_over_wind_speed(
    result: RunsLike, name: str, *, label: bool = True, ax: Axes | None = None
) -> Axes:
    """Mean and standard deviation of a channel over wind speed, and its equivalent load.

    Parameters
    ----------
    result : RunsLike
    name : str
        Of a channel that the runs have.
    label : bool
        With a legend.
    ax : Axes, optional
        Where to draw; a new figure without.
    """
    ax = axes_or_new(ax)
    channel = _channel(result, name)
    text, scale = _label(channel)
    factor = scale * channel.factor
    known = [(s.wind_speed, s.statistics[name]) for s in result.summary() if s.statistics]
    speed = [entry[0] for entry in known]
    mean, std = (
        factor * np.array([getattr(entry[1], key) for entry in known]) for key in ("mean", "std")
    )
    ax.errorbar(
        speed, mean, std, color=BLUE, marker="o", markersize=4, linewidth=1.4, capsize=3,
        elinewidth=1.0, label="mean and standard deviation",
    )  # fmt: skip
    loads = [entry[1].equivalent_load for entry in known]
    if loads and all(load is not None for load in loads):
        ax.plot(
            speed, factor * np.array(loads, dtype=np.float64), color=VERMILION, marker="s",
            markersize=4, linewidth=1.4, linestyle="--", label="equivalent load, 1 Hz",
        )  # fmt: skip
    light_grid(ax)
    ax.set_xlabel("wind speed [m/s]")
    ax.set_ylabel(text)
    if label:
        ax.legend(
            loc="lower left", bbox_to_anchor=(0.0, 1.0), frameon=False, fontsize="small",
            borderaxespad=0.2, ncols=2,
        )  # fmt: skip
    return ax


@dataclass(frozen=True, kw_only=True, eq=False)
class SteadyCurve:
    """Steady operation of a turbine, and simulated points to compare with it.

    Attributes
    ----------
    name : str
        Of the turbine.
    rated_power : float
        Of the generator, mechanical [W].
    curve : OperatingPoints
        Computed, in uniform wind.
    simulated : mapping of str to array (P,), optional
        ``wind_speed`` [m/s], ``power`` [W], mechanical, ``thrust`` [N], ``rotor_speed`` [rad/s],
        ``pitch`` [rad].
    """

    name: str
    rated_power: float
    curve: OperatingPoints
    simulated: Mapping[str, Sequence[float]] | None = None


def plot_steady_curve(
    turbines: Sequence[SteadyCurve], quantity: str, *, ax: Axes | None = None
) -> Axes:
    """One quantity of steady operation over wind speed, a line a turbine, points as simulated.

    Parameters
    ----------
    turbines : sequence of SteadyCurve
    quantity : str
        Of `CURVES`.
    ax : Axes, optional
        Where to draw; a new figure without.
    """
    ax = axes_or_new(ax)
    text, factor = _CURVE_LABELS[quantity]
    for turbine, colour in zip(turbines, BLADE_COLOURS, strict=False):
        scale = factor / turbine.rated_power if quantity == "power" else factor
        curve = np.asarray(getattr(turbine.curve, quantity))
        ax.plot(
            turbine.curve.wind_speed, scale * curve, color=colour, linewidth=1.5,
            label=turbine.name,
        )  # fmt: skip
        if turbine.simulated is not None:
            ax.plot(
                turbine.simulated["wind_speed"], scale * np.asarray(turbine.simulated[quantity]),
                linestyle="none", marker="o", markersize=4, markerfacecolor="white",
                markeredgecolor=colour,
            )  # fmt: skip
    if any(turbine.simulated is not None for turbine in turbines):
        ax.plot(
            [], [], linestyle="none", marker="o", markersize=4, markerfacecolor="white",
            markeredgecolor=GREY, label="simulated",
        )  # fmt: skip
    light_grid(ax)
    ax.set_xlabel("wind speed [m/s]")
    ax.set_ylabel(text)
    return ax
