"""Plots of a tuner's surrogate show its posterior and its samples."""

from __future__ import annotations

import numpy as np
import pytest
from matplotlib.figure import Figure

from pitchopt.errors import InputError
from pitchopt.plotting import plot_acquisition, plot_design_space, plot_posterior
from pitchopt.tuning import GaussianProcess, Parameter, Space
from pitchopt.tuning.known_functions import branin, forrester

LINE = np.linspace(0, 1, 6)[:, None]


@pytest.fixture
def ax():
    return Figure().add_subplot()


@pytest.fixture(scope="module")
def over_one():
    return GaussianProcess.fit(forrester().space, LINE, forrester().formula(LINE))


@pytest.fixture(scope="module")
def over_two():
    x = branin().space.from_unit(np.random.default_rng(0).random((15, 2)))
    return GaussianProcess.fit(branin().space, x, branin().formula(x))


def test_posterior_with_band_samples_and_truth(over_one, ax):
    assert plot_posterior(over_one, truth=forrester().formula, label="f [-]", ax=ax) is ax
    lines = {line.get_label(): line for line in ax.lines}
    x, mean = lines["posterior mean"].get_data()
    expected, std = over_one.predict(x[:, None])
    np.testing.assert_allclose(mean, expected)
    np.testing.assert_allclose(lines["samples"].get_ydata(), forrester().formula(LINE), atol=1e-9)
    np.testing.assert_allclose(lines["function"].get_ydata(), forrester().formula(x[:, None]))
    band = ax.collections[0].get_paths()[0].vertices
    assert band[:, 1].max() == pytest.approx((expected + 2 * std).max())
    assert band[:, 1].min() == pytest.approx((expected - 2 * std).min())
    assert (ax.get_xlabel(), ax.get_ylabel()) == ("x1", "f [-]")


def test_acquisition_and_the_chosen_point(over_one, ax):
    assert plot_acquisition(over_one, lambda x: x[:, 0] ** 2, chosen=0.4, ax=ax) is ax
    curve, chosen = ax.lines
    np.testing.assert_allclose(curve.get_ydata(), curve.get_xdata() ** 2)
    assert list(chosen.get_xdata()) == [0.4, 0.4]


@pytest.mark.parametrize("show", ["mean", "std"])
def test_design_space_with_its_samples(over_two, show, ax):
    assert plot_design_space(over_two, show=show, label="cost [MN m]", ax=ax) is ax
    points, outputs = over_two.samples
    if show == "mean":
        dots = ax.collections[-1]
        np.testing.assert_allclose(dots.get_offsets(), points)
        np.testing.assert_allclose(dots.get_array(), outputs)
        assert dots.get_clim() == ax.collections[0].get_clim()
    else:
        np.testing.assert_allclose(ax.lines[0].get_xydata(), points)
    bar = ax.figure.axes[-1]
    named = {"mean": "cost [MN m]", "std": "standard deviation of cost [MN m]"}
    assert bar.get_ylabel() == named[show]
    assert (ax.get_xlabel(), ax.get_ylabel()) == ("x1", "x2")


def test_axes_follow_the_scale_of_parameters(ax):
    space = Space([Parameter(name="rate", low=0.01, high=10.0, scale="log")])
    process = GaussianProcess.fit(space, [[0.01], [0.3], [10.0]], [1.0, 0.0, 2.0])
    assert plot_posterior(process, ax=ax).get_xscale() == "log"


def test_other_numbers_of_parameters_are_refused(over_one, over_two):
    with pytest.raises(InputError, match="got 2 parameters, expected 1"):
        plot_posterior(over_two)
    with pytest.raises(InputError, match="got 1 parameters, expected 2"):
        plot_design_space(over_one)
    with pytest.raises(InputError, match="show: got 'both', expected mean or std"):
        plot_design_space(over_two, show="both")
