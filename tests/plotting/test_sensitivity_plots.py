"""Plots of estimates beside re-solved optima."""

import matplotlib as mpl
import numpy as np
import pytest
from matplotlib.figure import Figure

from pitchopt.errors import InputError
from pitchopt.plotting import estimates_figure, plot_design_plane, plot_estimates, png
from pitchopt.studies.sensitivity import active_set_program, coupling_programs, estimated_curve


@pytest.fixture(scope="module")
def curve():
    return estimated_curve(active_set_program(), [0.0, 0.1, 0.7])


def test_lines_are_the_curves(curve):
    before = dict(mpl.rcParams)
    ax = plot_estimates(curve, label="mass (t)", ax=Figure().add_subplot())
    lines = {line.get_label(): line for line in ax.get_lines()}
    for label, values in (
        ("re-solved", curve.truth), ("first-order", curve.first_order),
        ("high-order", curve.high_order),
    ):  # fmt: skip
        np.testing.assert_array_equal(lines[label].get_xdata(), curve.dc)
        np.testing.assert_array_equal(lines[label].get_ydata(), values)
    assert ax.get_ylabel() == "mass (t)" and ax.get_title() == curve.name
    assert dict(mpl.rcParams) == before


def test_plane_has_limits_and_optima(curve):
    ax = plot_design_plane(curve, ax=Figure().add_subplot())
    across = [float(line.get_xdata()[0]) for line in ax.get_lines()[:4]]
    assert across == pytest.approx([1.0, 1.55, 2.75, 2.0])
    np.testing.assert_allclose(ax.get_lines()[4].get_xdata(), [1.0, 1.55, 2.0], atol=1e-5)


def test_plane_needs_limits_on_the_first_variable_and_known_values(curve):
    with pytest.raises(InputError, match="at: got"):
        plot_design_plane(curve, at=[0.33])


def test_page_has_a_panel_a_curve(curve):
    other = estimated_curve(coupling_programs()[0], [0.0, 1.0])
    figure = estimates_figure([curve, other], title="two")
    assert [ax.get_title() for ax in figure.axes] == [curve.name, other.name]
    assert png(figure, dpi=40).startswith(b"\x89PNG")
    with pytest.raises(InputError, match="curves: got none"):
        estimates_figure([])
