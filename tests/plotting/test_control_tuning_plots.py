"""Plots of individual pitch and minimum pitch tuning show the numbers they were given."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest

from pitchopt.control import MinimumPitchTable
from pitchopt.plotting import (
    PitchSamples,
    gain_samples,
    individual_pitch_figure,
    minimum_pitch_figure,
    pitch_tables_figure,
    plot_cost_progress,
    plot_gain_offset,
    plot_pitch_samples,
    plot_pitch_tables,
    progress_figure,
)

X = np.array([[1.0, 0.5, 2.0, -0.3], [2.0, -0.5, 1.0, 0.7], [3.0, 0.1, 0.5, 0.2], [1.5, 0, 1, 0]])
COSTS = [3.0, 1.0, np.nan, 2.0]


@pytest.fixture
def samples():
    found = [SimpleNamespace(x=x, cost=cost) for x, cost in zip(X, COSTS, strict=True)]
    return gain_samples(found, 2.5)


def points(ax):
    """Failed and good samples of a plot."""
    failed, good = ax.collections[:2]
    return np.asarray(failed.get_offsets()), np.asarray(good.get_offsets()), good.get_array()


@pytest.mark.parametrize("order", [1, 2])
def test_samples_in_both_planes(samples, order):
    gain, offset = X[:, 2 * order - 2], X[:, 2 * order - 1]
    worst_first = [0, 3, 1]
    failed, good, colour = points(plot_gain_offset(samples, order, plane="rectangular"))
    np.testing.assert_allclose(failed, [[np.degrees(offset[2]), gain[2]]])
    np.testing.assert_allclose(good, np.column_stack([np.degrees(offset), gain])[worst_first])
    np.testing.assert_allclose(colour, [3.0, 2.0, 1.0])
    _, good, _ = points(plot_gain_offset(samples, order))
    turn = np.exp(1j * order * offset) * gain
    np.testing.assert_allclose(good, np.column_stack([turn.real, turn.imag])[worst_first])


def test_progress_is_normalised(samples):
    ax = plot_cost_progress({"15 m/s": samples})
    np.testing.assert_allclose(ax.lines[0].get_ydata(), [2.0 / 1.5, 0.0, np.nan, 1.0 / 1.5])
    ax = plot_cost_progress({"15 m/s": samples}, least=True)
    np.testing.assert_allclose(ax.lines[0].get_ydata(), [2.0 / 1.5, 0.0, 0.0, 0.0])


def test_figures_have_a_row_for_each_study(samples):
    studies = {"7 m/s": samples, "25 m/s": samples}
    figure = individual_pitch_figure(studies)
    titles = [ax.get_title() for ax in figure.axes]
    assert titles[:4] == ["7 m/s, 1P", "7 m/s, 2P", "25 m/s, 1P", "25 m/s, 2P"]
    assert len(progress_figure(studies).axes) == 2


def test_tables_of_lowest_pitch():
    table = MinimumPitchTable(wind_speed=[5.0, 14.0, 50.0], pitch=np.radians([0.0, 2.0, 90.0]))
    ax = plot_pitch_tables({"tuned": table})
    curve, marks = ax.lines
    np.testing.assert_allclose(
        curve.get_ydata(), np.degrees(table.lowest(np.asarray(curve.get_xdata())))
    )
    np.testing.assert_allclose(marks.get_xydata(), [[5.0, 0.0], [14.0, 2.0]])
    assert pitch_tables_figure({"tuned": table}, title="t").axes[0].get_title() == "t"


def test_what_a_breakpoint_tried_and_its_gust():
    tried = PitchSamples(
        pitch=np.radians([1.0, 0.0, 2.0]),
        cost=np.array([0.99, 1.0, 1.01]),
        load=np.array([0.9, 1.0, 0.8]),
        power=np.array([0.999, 1.0, 0.99]),
    )
    load, power, cost = plot_pitch_samples(tried).lines
    np.testing.assert_allclose(cost.get_xdata(), [0.0, 1.0, 2.0])
    np.testing.assert_allclose(cost.get_ydata(), [0.0, -1.0, 1.0], atol=1e-9)
    np.testing.assert_allclose(load.get_ydata(), [0.0, -10.0, -20.0])
    np.testing.assert_allclose(power.get_ydata(), [0.0, -0.1, -1.0])

    class Run(dict):
        time = np.linspace(0.0, 200.0, 401)

    bump = np.exp(-(((Run.time - 120.0) / 5.0) ** 2))
    start_up = 9.0 * np.exp(-(((Run.time - 20.0) / 5.0) ** 2))
    run = Run(
        Wind1VelX=12.0 + bump, BldPitch1=0.1 * bump,
        RootMyb1=1e6 * (bump + start_up), RootMyb2=2e6 * bump, RootMyb3=0.5e6 * bump,
    )  # fmt: skip
    figure = minimum_pitch_figure(tried, {"tuned": run})
    moment = figure.axes[3]
    assert "blade 2" in moment.get_ylabel()
    x, y = moment.lines[0].get_xydata().T
    assert (x.min(), x.max()) == (80.0, 160.0)
    assert y.max() == pytest.approx(2.0)
