"""Plots of the tower study draw the numbers they are given."""

from __future__ import annotations

from types import SimpleNamespace

import matplotlib as mpl
import numpy as np
import pytest
from matplotlib.container import BarContainer
from matplotlib.figure import Figure
from matplotlib.patches import StepPatch

from pitchopt.plotting.tower import (
    plot_cost_map,
    plot_damage_over_weight,
    plot_mass_change,
    plot_multipliers,
    plot_tower_diameters,
    plot_tower_walls,
)
from pitchopt.studies.tower import CostMap

WEIGHTS = np.array([0.0, 0.03, 0.1, 0.2, 0.3])
TOWERS = {
    "standard": SimpleNamespace(
        diameter=np.array([6.0, 5.0, 4.0]), thickness=np.array([0.05, 0.03]), length=100.0
    ),
    "soft-soft": SimpleNamespace(
        diameter=np.array([5.5, 4.5, 3.5, 3.0]), thickness=np.array([0.06, 0.04, 0.02]), length=90.0
    ),
}


@pytest.fixture(autouse=True)
def no_state():
    """Neither pyplot's figures nor settings change."""
    from matplotlib import _pylab_helpers

    before, figures = dict(mpl.rcParams), len(_pylab_helpers.Gcf.figs)
    yield
    assert dict(mpl.rcParams) == before
    assert len(_pylab_helpers.Gcf.figs) == figures


@pytest.fixture
def axes():
    return Figure().add_subplot()


def lines_of(axes):
    return {line.get_label(): line for line in axes.get_lines()}


@pytest.mark.parametrize(("stations", "shown"), [(None, [0, 3, 6]), ([1, 5], [1, 5])])
def test_damage(axes, stations, shown):
    change = -WEIGHTS[:, None] * np.linspace(0.1, 0.9, 7)
    assert plot_damage_over_weight(WEIGHTS, change, stations=stations, ax=axes) is axes
    lines = lines_of(axes)
    assert list(lines) == ["mean", *(f"station {s + 1} of 7" for s in shown)]
    np.testing.assert_allclose(lines["mean"].get_ydata(), 100.0 * change.mean(axis=1))
    for s in shown:
        line = lines[f"station {s + 1} of 7"]
        np.testing.assert_array_equal(line.get_xdata(), WEIGHTS)
        np.testing.assert_allclose(line.get_ydata(), 100.0 * change[:, s])
    assert "[%]" in axes.get_ylabel()


def test_diameters(axes):
    plot_tower_diameters(TOWERS, ax=axes)
    for name, line in lines_of(axes).items():
        tower = TOWERS[name]
        np.testing.assert_array_equal(line.get_xdata(), tower.diameter)
        np.testing.assert_allclose(
            line.get_ydata(), np.linspace(0.0, tower.length, tower.diameter.size)
        )
    assert len(axes.get_lines()) == 2


def test_walls(axes):
    plot_tower_walls(TOWERS, ax=axes)
    steps = [p for p in axes.patches if isinstance(p, StepPatch)]
    for step, (name, tower) in zip(steps, TOWERS.items(), strict=True):
        values, edges, _ = step.get_data()
        np.testing.assert_allclose(values, 1e3 * tower.thickness)
        np.testing.assert_allclose(edges, np.linspace(0.0, tower.length, tower.diameter.size))
        assert step.get_label() == name
        assert step.orientation == "horizontal"


def test_more_towers_than_colours(axes):
    many = {str(k): TOWERS["standard"] for k in range(8)}
    plot_tower_diameters(many, ax=axes)
    plot_tower_walls(many, ax=Figure().add_subplot())
    plot_multipliers({name: [1.0] for name in many}, ax=Figure().add_subplot())
    assert len(axes.get_lines()) == 8


@pytest.mark.parametrize("labels", [None, ["a", "b", "c"]])
def test_multipliers(axes, labels):
    values = {"standard": [0.1, 0.0, 2.4], "soft-soft": [0.3, 0.2, 0.0]}
    plot_multipliers(values, labels=labels, ax=axes)
    groups = [c for c in axes.containers if isinstance(c, BarContainer)]
    middles = []
    for group, (name, heights) in zip(groups, values.items(), strict=True):
        assert [bar.get_height() for bar in group] == heights
        assert group.get_label() == name
        middles.append([bar.get_x() + 0.5 * bar.get_width() for bar in group])
    np.testing.assert_allclose(np.mean(middles, axis=0), [0.0, 1.0, 2.0], atol=1e-12)
    np.testing.assert_allclose(np.diff(middles, axis=0), groups[0][0].get_width())  # side by side
    assert [t.get_text() for t in axes.get_xticklabels()] == (labels or ["1", "2", "3"])


def test_every_second_of_many_places_has_a_number(axes):
    plot_multipliers({"one": np.ones(19)}, ax=axes)
    assert [t.get_text() for t in axes.get_xticklabels()] == [str(n) for n in range(1, 20, 2)]
    np.testing.assert_array_equal(axes.get_xticks(), np.arange(0, 19, 2))


@pytest.mark.parametrize("known", [True, False])
def test_mass_change(axes, known):
    first, high, truth = -1e3 * WEIGHTS, -800.0 * WEIGHTS, -900.0 * WEIGHTS
    plot_mass_change(WEIGHTS, first, high, truth if known else None, mass=2e4, ax=axes)
    drawn = [np.asarray(line.get_ydata()) for line in axes.get_lines()]
    for values, wanted in ((first, True), (high, True), (truth, known)):
        assert any(np.allclose(line, 100.0 * values / 2e4) for line in drawn) is wanted
    assert all(np.array_equal(line.get_xdata(), WEIGHTS) for line in axes.get_lines()
               if len(line.get_xdata()) == 5)  # fmt: skip
    assert "[%]" in axes.get_ylabel()


def test_cost_map(axes):
    heights = np.array([99.0, 110.0, 121.0, 132.0])
    cost = 41.0 + 2e-3 * (heights[:, None] - 114.0) ** 2 + 2.0 * (WEIGHTS - 0.2) ** 2

    class Mass:
        def cost(self, hub_height, mass, energy):
            return np.asarray(mass)

    costs = CostMap(heights=heights, weights=WEIGHTS, mass=cost, energy=cost, economics=Mass())
    plot_cost_map(costs, reference_height=110.0, reference_cost=41.0, ax=axes)
    alone, both = axes.get_lines()
    for line, weight in ((alone, 0.0), (both, None)):
        height, c, _ = costs.lowest(weight)
        (x,), (y,) = line.get_xdata(), line.get_ydata()
        assert x == pytest.approx(100.0 * (height / 110.0 - 1.0))
        assert y == c
    assert alone.get_marker() == "o"
    assert both.get_marker() == "X"
    words = [text.get_text() for text in axes.get_legend().get_texts()]
    assert words == ["lowest, c = 0", "lowest of all"]
    assert float(both.get_ydata()[0]) == pytest.approx(0.2, abs=0.01)
    filled = axes.collections[0]
    low, high = filled.get_clim()
    change = 100.0 * (costs.fine()[2] / 41.0 - 1.0)
    assert low <= change.min()
    assert high >= change.max()
    assert len(axes.figure.axes) == 2  # with the bar of colours
    x0, x1 = axes.get_xlim()
    assert (x0, x1) == pytest.approx((-10.0, 20.0), abs=1e-6)
    axes.figure.canvas.draw_idle()


@pytest.mark.parametrize(
    "draw",
    [
        lambda: plot_damage_over_weight(WEIGHTS, np.zeros((5, 3))),
        lambda: plot_tower_diameters(TOWERS),
        lambda: plot_tower_walls(TOWERS),
        lambda: plot_multipliers({"one": [1.0]}),
        lambda: plot_mass_change(WEIGHTS, WEIGHTS, WEIGHTS, mass=1.0),
    ],
)
def test_axes_of_their_own(draw):
    from matplotlib import pyplot as plt

    axes = draw()
    assert axes.figure.axes == [axes]
    plt.close(axes.figure)
