"""Tables of lowest pitch, what tuning one breakpoint tried, and a gust with and without.

Source of the layout: D. Zalkind, E. Dall'Anese, L. Pao, "Automatic controller tuning using a
zeroth-order optimization algorithm", 2020, figures 7 and 8.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, NamedTuple, Protocol

import numpy as np
from numpy.typing import ArrayLike

from pitchopt.plotting.style import BLACK, BLADE_COLOURS, BLUE, VERMILION, axes_or_new, light_grid

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from pitchopt.checks import FloatArray

__all__ = [
    "PitchSamples",
    "minimum_pitch_figure",
    "pitch_tables_figure",
    "plot_over_time",
    "plot_pitch_samples",
    "plot_pitch_tables",
]

_HIGHEST_SHOWN = 26.0  # [m/s]
_AROUND = 40.0  # of a peak, before and after [s]


class TableLike(Protocol):
    """A table of lowest pitch."""

    @property
    def wind_speed(self) -> FloatArray:
        """[m/s]."""
        ...

    @property
    def pitch(self) -> FloatArray:
        """[rad]."""
        ...

    def lowest(self, wind_speed: ArrayLike) -> FloatArray:
        """Lowest pitch [rad]."""
        ...


class SeriesLike(Protocol):
    """A run."""

    @property
    def time(self) -> FloatArray:
        """[s]."""
        ...

    def __getitem__(self, name: str) -> FloatArray: ...


class PitchSamples(NamedTuple):
    """What tuning one breakpoint tried, in the order of evaluation.

    Attributes
    ----------
    pitch : ndarray (N,)
        [rad].
    cost, load, power : ndarray (N,)
        Over those of the pitch to begin with.
    """

    pitch: FloatArray
    cost: FloatArray
    load: FloatArray
    power: FloatArray


def plot_pitch_tables(tables: Mapping[str, TableLike], *, ax: Axes | None = None) -> Axes:
    """Lowest pitch over wind speed, points and interpolation."""
    ax = axes_or_new(ax)
    wind = np.linspace(3.0, _HIGHEST_SHOWN, 231)
    for colour, (label, table) in zip(BLADE_COLOURS, tables.items(), strict=False):
        ax.plot(wind, np.degrees(table.lowest(wind)), color=colour, label=label)
        shown = table.wind_speed <= _HIGHEST_SHOWN
        points = np.degrees(table.pitch[shown])
        ax.plot(table.wind_speed[shown], points, "o", color=colour, ms=5)
    light_grid(ax)
    ax.set(xlabel="estimated wind speed [m/s]", ylabel="lowest pitch [deg]")
    ax.legend(frameon=False)
    return ax


def plot_pitch_samples(samples: PitchSamples, *, ax: Axes | None = None) -> Axes:
    """Cost, load and power of the pitches that were tried, less one, in percent."""
    ax = axes_or_new(ax)
    order = np.argsort(samples.pitch)
    pitch = np.degrees(samples.pitch[order])
    for label, values, colour, marker in (
        ("load", samples.load, VERMILION, "s"),
        ("power", samples.power, BLUE, "^"),
        ("cost", samples.cost, BLACK, "o"),
    ):
        ax.plot(
            pitch, 100.0 * (values[order] - 1.0), marker=marker, ms=4, color=colour, label=label
        )
    light_grid(ax)
    ax.set_yscale("symlog", linthresh=0.1)
    ax.set(xlabel="lowest pitch at the breakpoint [deg]", ylabel="change [%]")
    ax.legend(frameon=False)
    return ax


def plot_over_time(
    runs: Mapping[str, SeriesLike],
    channel: str,
    *,
    around: float,
    factor: float = 1.0,
    label: str = "",
    ax: Axes | None = None,
) -> Axes:
    """A channel of several runs around an instant.

    Parameters
    ----------
    runs : mapping of str to run
    channel : str
    around : float
        [s].
    factor : float
        From SI to the unit shown.
    label : str
        Of the axis.
    ax : Axes, optional
    """
    ax = axes_or_new(ax)
    for colour, (name, run) in zip(BLADE_COLOURS, runs.items(), strict=False):
        near = np.abs(run.time - around) <= _AROUND
        ax.plot(run.time[near], factor * run[channel][near], color=colour, lw=1.1, label=name)
    light_grid(ax)
    ax.set(xlabel="time [s]", ylabel=label)
    return ax


def minimum_pitch_figure(
    samples: PitchSamples,
    runs: Mapping[str, SeriesLike],
    *,
    skip: float = 60.0,
    title: str = "",
) -> Figure:
    """What was tried at a breakpoint, and pitch and flapwise moment around the first run's peak.

    Parameters
    ----------
    samples : PitchSamples
    runs : mapping of str to run
    skip : float
        Start of the runs that the peak is not looked for in [s].
    title : str
    """
    from matplotlib.figure import Figure

    first = next(iter(runs.values()))
    counted = first.time >= skip
    moments = np.array([first[f"RootMyb{k}"][counted] for k in (1, 2, 3)])
    place = np.unravel_index(int(np.argmax(moments)), moments.shape)
    blade, peak = 1 + int(place[0]), float(first.time[counted][place[1]])
    figure = Figure(figsize=(9.0, 6.4), layout="constrained")
    (costs, wind), (pitch, moment) = figure.subplots(2, 2)
    plot_pitch_samples(samples, ax=costs)
    plot_over_time(
        {"wind": first}, "Wind1VelX", around=peak, label="wind at the hub [m/s]", ax=wind
    )
    plot_over_time(
        runs, "BldPitch1", around=peak, factor=180.0 / np.pi, label="pitch [deg]", ax=pitch
    )
    plot_over_time(
        runs,
        f"RootMyb{blade}",
        around=peak,
        factor=1e-6,
        label=f"flapwise moment of blade {blade} [MN m]",
        ax=moment,
    )
    pitch.legend(frameon=False)
    figure.suptitle(title)
    return figure


def pitch_tables_figure(tables: Mapping[str, TableLike], *, title: str = "") -> Figure:
    """Tables of lowest pitch on a page."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(6.4, 4.4), layout="constrained")
    ax = plot_pitch_tables(tables, ax=figure.add_subplot())
    ax.set_title(title)
    return figure
