"""Plots of simulated runs: what they draw, from runs that are made up."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pytest
from matplotlib.figure import Figure

from pitchopt.exports import TimeSeries
from pitchopt.plotting import (
    SteadyCurve,
    plot_channel,
    plot_over_wind_speed,
    plot_steady_curve,
    png,
    simulation_figure,
    steady_curves_figure,
)
from pitchopt.sim import Channel, ChannelStatistics, average

CHANNELS = (
    Channel("GenPwr", "kW", 1e-3, "power"),
    Channel("TwrBsMyt", "kN-m", 1e-3, "moment"),
    Channel("Azimuth", "deg", 180 / np.pi, "azimuth"),
)


@dataclass(frozen=True)
class Run:
    wind_speed: float
    seed: int | None
    status: str
    series: TimeSeries
    statistics: dict[str, ChannelStatistics]


@dataclass(frozen=True)
class Speed:
    wind_speed: float
    statistics: dict[str, ChannelStatistics] | None


@dataclass(frozen=True)
class Settings:
    skip: float


@dataclass(frozen=True)
class Runs:
    runs: tuple[Run, ...]
    channels: tuple[Channel, ...] = CHANNELS
    settings: Settings = Settings(2.0)

    def summary(self):
        speeds = sorted({run.wind_speed for run in self.runs})
        return [
            Speed(u, average([run.statistics for run in self.runs if run.wind_speed == u]))
            for u in speeds
        ]


def make(speed=9.0, seed=1, status="finished", rows=50):
    time = 0.2 * np.arange(rows)
    values = np.column_stack(
        [1000 * speed + np.sin(time + (seed or 0)), 100 * speed + 0 * time, time]
    )
    series = TimeSeries(
        time=time, channels=[c.name for c in CHANNELS], units=[c.unit for c in CHANNELS],
        values=values,
    )  # fmt: skip
    statistics = {
        c.name: ChannelStatistics(
            mean=values[:, k].mean() / c.factor, std=speed / c.factor, least=0.0, largest=1.0,
            slope=4.0 if c.name == "TwrBsMyt" else None,
            equivalent_load=50 * speed / c.factor if c.name == "TwrBsMyt" else None,
        )
        for k, c in enumerate(CHANNELS)
    }  # fmt: skip
    return Run(speed, seed, status, series, statistics)


@pytest.fixture
def ax():
    return Figure().add_subplot()


def test_channel_over_time(ax):
    runs = Runs(tuple(make(seed=seed) for seed in range(8)))
    assert plot_channel(runs, "GenPwr", ax=ax) is ax
    assert len(ax.lines) == 6  # more than six would be no picture
    np.testing.assert_allclose(ax.lines[2].get_ydata(), 1e-3 * runs.runs[2].series["GenPwr"])
    assert [line.get_label() for line in ax.lines[:2]] == ["seed 0", "seed 1"]
    assert ax.get_ylabel() == "power\n[MW]"
    (shaded,) = ax.patches
    assert shaded.get_width() == 2.0


def test_end_of_a_run_that_diverged(ax):
    plot_channel(Runs((make(seed=None, status="diverged", rows=20),)), "TwrBsMyt", ax=ax)
    line, cross = ax.lines
    assert cross.get_marker() == "x"
    assert cross.get_xdata()[0] == line.get_xdata()[-1] == pytest.approx(3.8)
    assert line.get_label() == "steady"


def test_statistics_over_wind_speed(ax):
    runs = Runs(tuple(make(speed, seed) for speed in (6.0, 9.0) for seed in (1, 2)))
    plot_over_wind_speed(runs, "TwrBsMyt", ax=ax)
    (bars,) = ax.containers
    np.testing.assert_allclose(bars.lines[0].get_ydata(), [0.6, 0.9])
    loads = next(line for line in ax.lines if line.get_linestyle() == "--")
    np.testing.assert_allclose(loads.get_ydata(), [0.3, 0.45])
    assert ax.get_ylabel().endswith("[MN-m]")
    plain = plot_over_wind_speed(runs, "GenPwr", ax=Figure().add_subplot())
    assert not [line for line in plain.lines if line.get_linestyle() == "--"]


def test_figures():
    one = simulation_figure(Runs((make(), make(seed=2))), title="here")
    # usual channels in their order, then what else was asked for
    assert [ax.get_ylabel().split("\n")[0] for ax in one.axes] == ["power", "tower base", "Azimuth"]
    assert png(one).startswith(b"\x89PNG")
    several = simulation_figure(Runs((make(6.0), make(9.0))))
    assert len(several.axes) == 3 and several.axes[0].get_xlabel() == "wind speed [m/s]"
    png(several)
    few = Runs((make(),), channels=CHANNELS[2:])
    assert simulation_figure(few).axes[0].get_ylabel() == "Azimuth\n[deg]"


@dataclass(frozen=True)
class Points:
    wind_speed: np.ndarray
    power: np.ndarray
    thrust: np.ndarray
    rotor_speed: np.ndarray
    pitch: np.ndarray


def test_steady_curves(ax):
    wind = np.linspace(4.0, 20.0, 5)
    points = Points(wind, 1e6 * wind, 1e5 * wind, 0.1 * wind, 0.01 * wind)
    simulated = {
        "wind_speed": [8.0], "power": [7e6], "thrust": [8e5], "rotor_speed": [0.7],
        "pitch": [0.0],
    }  # fmt: skip
    curve = SteadyCurve(name="one", rated_power=2e7, curve=points, simulated=simulated)
    plot_steady_curve([curve], "power", ax=ax)
    np.testing.assert_allclose(ax.lines[0].get_ydata(), wind / 20)
    assert ax.lines[1].get_ydata()[0] == pytest.approx(0.35)
    figure = steady_curves_figure([curve, SteadyCurve(name="two", rated_power=1e7, curve=points)])
    assert [ax.get_ylabel() for ax in figure.axes] == [
        "power over rated [-]", "thrust [MN]", "rotor speed [rpm]", "pitch [deg]",
    ]  # fmt: skip
    assert figure.axes[2].lines[0].get_ydata()[0] == pytest.approx(0.4 * 30 / np.pi)
    assert png(figure).startswith(b"\x89PNG")
