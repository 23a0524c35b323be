"""Plots draw what they are given, and leave matplotlib's state alone."""

from __future__ import annotations

import matplotlib as mpl
import numpy as np
import pytest
from matplotlib import pyplot as plt
from matplotlib.figure import Figure

from pitchopt.aero import fit_polar
from pitchopt.errors import InputError
from pitchopt.plotting import (
    loads_figure,
    plot_loads,
    plot_polar_fit,
    plot_profiles,
    plot_regrets,
    plot_several_profiles,
    plot_tradeoff,
    plot_wind_field,
    png,
    profiles_figure,
    several_figures,
    tradeoff_figure,
)
from pitchopt.plotting.passage import theta_of
from pitchopt.plotting.tradeoff import bound_on_torque
from windfield import sample_disc


@pytest.fixture
def ax():
    return Figure().add_subplot()


@pytest.fixture(scope="session")
def sample(small_case):
    return sample_disc(small_case.wind_field(), 40.0, x=-5.5, rings=8, azimuths=24)


@pytest.fixture(scope="session")
def polar_and_fit(small_case):
    polar = small_case.rotor().blade.polars[0]
    return polar, fit_polar(polar, (np.deg2rad(-5), polar.stall_angle()), 12)


def labels(ax) -> list[str]:
    return [text.get_text() for text in ax.get_legend().get_texts()]


def test_settings_and_figures_are_left_alone(small_tradeoff, sample, polar_and_fit, ax):
    before = mpl.rcParams.copy()
    point = small_tradeoff.points[0]
    assert plot_tradeoff(small_tradeoff, ax=ax) is ax
    for draw, args in (
        (plot_wind_field, (sample,)),
        (plot_polar_fit, polar_and_fit),
        (plot_profiles, (point,)),
        (plot_loads, (point,)),
    ):
        other = Figure().add_subplot()
        assert draw(*args, ax=other) is other
    assert mpl.rcParams == before
    assert plt.get_fignums() == []


def test_new_axes_without_ax(small_tradeoff):
    ax = plot_profiles(small_tradeoff.points[0])
    assert ax.figure.number in plt.get_fignums()
    plt.close(ax.figure)


def test_tradeoff_shows_every_point(small_tradeoff, ax):
    plot_tradeoff(small_tradeoff, weights_name="unit", ax=ax)
    lines = {line.get_label(): line for line in ax.lines}
    curve = lines["trade-off"]
    assert sorted(curve.get_ydata()) == pytest.approx(
        sorted(p.mean_torque / 1e6 for p in small_tradeoff.points)
    )
    assert sorted(curve.get_xdata()) == pytest.approx(
        sorted(p.rms_weighted / 1e3 for p in small_tradeoff.points)
    )
    assert len(lines["least RMS for a given loss"].get_xdata()) == 2
    knee = small_tradeoff.points[small_tradeoff.knee]
    assert lines["knee"].get_ydata()[0] == pytest.approx(knee.mean_torque / 1e6)
    assert "unit" in ax.get_xlabel()
    assert "[MN m]" in ax.get_ylabel()
    assert {"best constant pitch", "power maximum", "knee"} <= set(labels(ax))
    low, high = ax.get_ylim()
    assert all(low < p.mean_torque / 1e6 < high for p in small_tradeoff.points)


def test_bound_is_above_every_design(small_tradeoff, ax):
    bound = bound_on_torque(small_tradeoff)
    assert bound is not None
    designs = [small_tradeoff.constant, small_tradeoff.power_max, *small_tradeoff.points]
    for design in designs:
        assert bound(np.array([design.rms_weighted]))[0] >= design.mean_torque * (1 - 1e-9)
    points = list(zip(small_tradeoff.constant_rms, small_tradeoff.constant_torque, strict=True))
    assert all(bound(np.array([rms]))[0] >= torque * (1 - 1e-9) for rms, torque in points)


def test_profiles_over_theta(small_tradeoff, ax):
    point = small_tradeoff.points[-1]
    plot_profiles({"a": point, "b": small_tradeoff.power_max}, ax=ax)
    assert len(ax.lines) == 6
    first = ax.lines[0]
    # theta = pi/2 is blade 1 up: azimuth 0
    up = np.interp(np.pi / 2, first.get_xdata(), first.get_ydata())
    assert up == pytest.approx(np.rad2deg(point.profile[0]), abs=1e-9)
    # blade 2 is a third of a turn ahead of blade 1
    second = ax.lines[1]
    ahead = np.interp(np.pi / 2, second.get_xdata(), second.get_ydata())
    third = point.profile.size // 3
    assert ahead == pytest.approx(np.rad2deg(point.profile[third]), abs=1e-9)
    # one blade ends where the next begins
    assert first.get_ydata()[-1] == pytest.approx(second.get_ydata()[0])
    assert labels(ax) == ["blade 1", "blade 2", "blade 3", "a", "b"]
    assert ax.get_xlim() == pytest.approx((0.0, 2 * np.pi / 3))


def test_tower_passage_is_at_thirty_degrees():
    assert theta_of(np.array([np.pi]), 3)[0] == pytest.approx(np.pi / 6)


@pytest.mark.parametrize(("load", "row"), [("torque", 0), ("tilt", 1), ("yaw", 2), ("thrust", 3)])
def test_loads_over_theta(small_tradeoff, ax, load, row):
    constant = small_tradeoff.constant
    plot_loads({"p*": small_tradeoff.power_max, "c": constant, "x": constant}, load=load, ax=ax)
    assert labels(ax) == ["p*", "c", "x"]
    values = ax.lines[2].get_ydata()
    exact = constant.loads.rotor[row]
    assert np.ptp(values) / np.ptp(exact) == pytest.approx(values.max() / exact.max())
    assert len(values) == exact.size
    unit = ax.get_ylabel()
    assert ("N m" in unit) == (load != "thrust")


def test_unknown_load_and_nothing_to_draw(small_tradeoff):
    with pytest.raises(InputError, match="load: got 'power'"):
        plot_loads(small_tradeoff.constant, load="power", ax=Figure().add_subplot())
    with pytest.raises(InputError, match="designs"):
        plot_profiles({})


def test_wind_field_colours_cover_the_speeds(sample, ax):
    plot_wind_field(sample, ax=ax)
    levels = ax.collections[0].levels
    assert levels[0] <= sample.speed.min()
    assert levels[-1] >= sample.speed.max()
    low, high = ax.get_xlim()
    assert low > 0 > high  # y grows to the left
    assert len(ax.figure.axes) == 2
    assert "m/s" in ax.figure.axes[1].get_ylabel()


def test_even_wind_can_be_drawn(small_case, ax):
    even = small_case.with_values(
        {"wind.shear": "none", "wind.horizontal_shear": 0.0, "wind.tower_shadow": False}
    )
    plot_wind_field(sample_disc(even.wind_field(), 40.0, rings=4, azimuths=12, closed=True), ax=ax)
    assert ax.collections[0].levels[0] < 15.0 < ax.collections[0].levels[-1]


def test_polar_fit_shows_table_fit_and_limits(polar_and_fit, ax):
    polar, fit = polar_and_fit
    plot_polar_fit(polar, fit, ax=ax)
    (drag,) = [other for other in ax.figure.axes if other is not ax]
    assert ax.lines[1].get_ydata() == pytest.approx(fit.cl)
    assert drag.lines[1].get_ydata() == pytest.approx(fit.cd)
    limits = [line.get_xdata()[0] for line in ax.lines[2:]]
    assert limits == pytest.approx(np.rad2deg(fit.limits))


def test_figures_are_png(small_tradeoff):
    shown = {"knee": small_tradeoff.points[small_tradeoff.knee]}
    for figure in (
        tradeoff_figure(small_tradeoff, title="t"),
        profiles_figure(shown),
        loads_figure(shown),
    ):
        assert png(figure, dpi=40).startswith(b"\x89PNG\r\n\x1a\n")


# ---- several winds -------------------------------------------------------------------------


@pytest.fixture(scope="session")
def small_winds(small_case):
    from pitchopt.design import robust

    tasks = [small_case.with_values({"wind.speed": speed}).task() for speed in (14.0, 16.0)]
    return robust(tasks, mu=10.0, labels=("low", "high"), starts=1, certify=False)


@pytest.fixture(scope="session")
def small_schedule(small_case):
    from pitchopt.design import schedule

    tasks = [small_case.with_values({"wind.speed": speed}).task() for speed in (14.0, 16.0)]
    options = {"labels": ("low", "high"), "starts": 1, "certify": False}
    return schedule(tasks, mu=10.0, change=np.inf, **options)


def test_shared_profile_among_own_optima(small_winds, ax):
    assert plot_several_profiles(small_winds, ax=ax) is ax
    assert labels(ax) == ["low alone", "high alone", "for all winds"]
    shared = ax.lines[-1].get_ydata()
    np.testing.assert_allclose(shared[:-1], np.rad2deg(small_winds.profile))
    assert shared[-1] == shared[0]


def test_schedule_has_a_line_for_each_wind(small_schedule, ax):
    plot_several_profiles(small_schedule, ax=ax)
    assert labels(ax) == ["low", "high"]
    for line, profile in zip(ax.lines, small_schedule.profiles, strict=True):
        np.testing.assert_allclose(line.get_ydata()[:-1], np.rad2deg(profile))


def test_regrets_are_bars(small_winds, ax):
    assert plot_regrets(small_winds, ax=ax) is ax
    widths = np.array([bar.get_width() for bar in ax.patches])
    regret = np.array([wind.regret for wind in small_winds.winds])
    np.testing.assert_allclose(widths / widths.max(), regret / regret.max())
    assert [text.get_text() for text in ax.get_yticklabels()] == ["low", "high"]


def test_several_figures(small_winds, small_schedule):
    for result in (small_winds, small_schedule):
        for figure in several_figures(result, title="case"):
            assert png(figure).startswith(b"\x89PNG")
