"""Plots of a learning run show its record."""

from __future__ import annotations

import matplotlib as mpl
import numpy as np
import pytest
from matplotlib import pyplot as plt
from matplotlib.figure import Figure

from pitchopt.plotting import (
    contraction_figure,
    learned_profiles_figure,
    learning_figure,
    plot_contraction,
    plot_learned_profiles,
    plot_learning,
    plot_torque,
    png,
)
from pitchopt.studies.learning import LearningSettings, WindDrift, WindStep, learn


@pytest.fixture(scope="module")
def stepped(small_case):
    wind = WindStep(speed=15.0, change=2.0, rotation=3)
    return learn(small_case, LearningSettings(rotations=6, learner="paper", wind=wind, noise=0.02))


@pytest.fixture
def ax():
    return Figure().add_subplot()


def by_label(ax) -> dict:
    return {line.get_label(): line for line in ax.lines}


def texts(ax) -> list[str]:
    return [text.get_text() for text in ax.get_legend().get_texts()]


def test_load_over_rotations(stepped, ax):
    assert plot_learning(stepped, weights_name="tower-base", ax=ax) is ax
    lines, record = by_label(ax), stepped.record
    x, y = lines["learning, last passage"].get_data()
    np.testing.assert_array_equal(x, np.arange(-2, 7))
    whole = np.concatenate([record.experiment.ac_load_rotation, record.learning.ac_load_rotation])
    np.testing.assert_allclose(lines["whole rotation"].get_ydata(), whole / 1e3)
    both = np.concatenate([record.experiment.ac_load, record.learning.ac_load])
    np.testing.assert_allclose(y, both / 1e3)
    measured = np.concatenate(
        [record.experiment.ac_load_measured, record.learning.ac_load_measured]
    )
    np.testing.assert_allclose(lines["as measured"].get_ydata(), measured / 1e3)
    assert ax.get_yscale() == "log"
    assert ax.get_ylabel() == "sum of RMS, weights tower-base [kN m]"
    assert ax.patches[0].get_x() == -2.5
    assert ax.patches[0].get_x() + ax.patches[0].get_width() == 0.5


def test_references_are_drawn_where_they_hold(stepped, ax):
    plot_learning(stepped, ax=ax)
    for style, name in (("--", "design"), ("-.", "constant")):
        drawn = [line for line in ax.lines if line.get_linestyle() == style]
        ends = [tuple(line.get_xdata()) for line in drawn]
        assert ends == [(-2.5, 3.5), (3.5, 6.5)]
        levels = [line.get_ydata()[0] for line in drawn]
        wanted = [getattr(stretch, name).rms_weighted / 1e3 for stretch in stepped.stretches]
        assert levels == pytest.approx(wanted)
    assert texts(ax).count("designed with a model") == 1


def test_exact_measurements_are_not_drawn_twice(small_case, ax):
    drift = WindDrift(speed=15.0, std=0.1, rotations_correlation=5.0)
    result = learn(small_case, LearningSettings(rotations=2, learner="paper", wind=drift))
    plot_learning(result, ax=ax)
    assert "as measured" not in texts(ax)
    assert "designed with a model, mean wind" in texts(ax)


def test_torque_and_setpoint(stepped, ax):
    assert plot_torque(stepped, ax=ax) is ax
    lines = by_label(ax)
    learning, experiment = stepped.record.learning, stepped.record.experiment
    torque = np.concatenate([experiment.mean_torque, learning.mean_torque])
    np.testing.assert_allclose(lines["learning"].get_ydata(), torque / 1e6)
    x, y = lines["set-point"].get_data()
    assert y[np.searchsorted(x, 3.5, side="right") - 1] == learning.setpoint[3] / 1e6
    assert "[MN m]" in ax.get_ylabel()


def test_contraction(stepped, ax):
    assert plot_contraction(stepped.loop, ax=ax) is ax
    lines = by_label(ax)
    np.testing.assert_allclose(lines["with the plant's slopes"].get_ydata(), stepped.loop.true)
    np.testing.assert_allclose(
        lines["with the estimated slopes"].get_ydata(), stepped.loop.estimated
    )
    assert ax.get_ylim()[1] > 1


def test_profiles_of_one_and_of_each_blade(stepped, small_case, ax):
    assert plot_learned_profiles(stepped, ax=ax) is ax
    lines = by_label(ax)
    np.testing.assert_allclose(
        lines["learned"].get_ydata()[:-1], np.rad2deg(stepped.learned.profile)
    )
    np.testing.assert_allclose(
        lines["designed with a model"].get_ydata()[:-1], np.rad2deg(stepped.design_after.profile)
    )
    assert lines["learned"].get_ydata()[0] == lines["learned"].get_ydata()[-1]
    settings = LearningSettings(rotations=1, learner="paper", separate=True)
    other = Figure().add_subplot()
    plot_learned_profiles(learn(small_case, settings), ax=other)
    assert {f"learned, blade {blade}" for blade in (1, 2, 3)} <= set(by_label(other))


def test_figures_render_and_leave_settings_alone(stepped):
    before = mpl.rcParams.copy()
    for figure in (
        learning_figure(stepped, title="a run"),
        learned_profiles_figure(stepped, title="a run"),
        contraction_figure(stepped.loop, title="a run"),
    ):
        assert png(figure, dpi=40).startswith(b"\x89PNG")
    assert mpl.rcParams == before
    assert plt.get_fignums() == []


@pytest.mark.parametrize("draw", [plot_learning, plot_torque, plot_learned_profiles])
def test_new_axes_without_ax(stepped, draw):
    ax = draw(stepped)
    assert ax.figure.number in plt.get_fignums()
    plt.close(ax.figure)
