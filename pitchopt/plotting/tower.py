"""Plots of the tower study: damage, designs, multipliers, masses and cost of energy.

They take plain arrays, or what `pitchopt.studies.tower` returns by the attributes named in
`CostMapLike` and `TowerLike`.  Figure numbers in docstrings are those of J. Iori et al., "A
sensitivity-based estimation method for investigating control co-design relevance", 2024.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Protocol

import numpy as np
from numpy.typing import ArrayLike

from pitchopt.plotting.style import (
    BLACK,
    BLADE_COLOURS,
    BLUE,
    GREEN,
    VERMILION,
    axes_or_new,
    light_grid,
)

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from pitchopt.checks import FloatArray

__all__ = [
    "CostMapLike",
    "TowerLike",
    "plot_cost_map",
    "plot_damage_over_weight",
    "plot_mass_change",
    "plot_multipliers",
    "plot_tower_diameters",
    "plot_tower_walls",
]

_LINES = ("-", "--", ":", "-.")
_WEIGHT = "weight c on the tower-top velocity [s$^2$/m$^2$]"


class TowerLike(Protocol):
    """A tower of elements."""

    @property
    def diameter(self) -> FloatArray:
        """At the nodes (E + 1,) [m]."""
        ...

    @property
    def thickness(self) -> FloatArray:
        """Of the elements (E,) [m]."""
        ...

    @property
    def length(self) -> float:
        """[m]."""
        ...


class CostMapLike(Protocol):
    """Costs over hub height and weight."""

    def fine(self, count: int = 241) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Heights (n,), weights (n,) and costs (n, n)."""
        ...

    def lowest(self, weight: float | None = None) -> tuple[float, float, float]:
        """Height, weight and cost of the lowest cost."""
        ...


def plot_damage_over_weight(
    weights: ArrayLike,
    change: ArrayLike,
    *,
    stations: Sequence[int] | None = None,
    ax: Axes | None = None,
) -> Axes:
    """Fatigue damage of one tower over the controller's weight, figure 2.

    Parameters
    ----------
    weights : (K,) array_like
        c.
    change : (K, S) array_like
        Of the damage at the stations, over that at c = 0 [-].
    stations : sequence of int
        Drawn beside the mean, 0 at the base; base, middle and top without.
    """
    axes = axes_or_new(ax)
    c, values = np.asarray(weights), 100.0 * np.asarray(change)
    count = values.shape[1]
    shown = (0, count // 2, count - 1) if stations is None else stations
    axes.plot(c, values.mean(axis=1), "o-", color=BLACK, label="mean")
    for k, s in enumerate(shown):
        colour = BLADE_COLOURS[k % len(BLADE_COLOURS)]
        label = f"station {s + 1} of {count}"
        axes.plot(c, values[:, s], "s", ls=_LINES[(k + 1) % 4], color=colour, label=label)
    axes.set_xlabel(_WEIGHT)
    axes.set_ylabel("change of fatigue damage [%]")
    axes.legend(frameon=False)
    light_grid(axes)
    return axes


def plot_tower_diameters(towers: Mapping[str, TowerLike], *, ax: Axes | None = None) -> Axes:
    """Diameters of the wall's middle over the height above the base, figure 3 a."""
    axes = axes_or_new(ax)
    for k, (name, tower) in enumerate(towers.items()):
        z = np.linspace(0.0, tower.length, tower.diameter.size)
        axes.plot(
            tower.diameter,
            z,
            "o",
            ls=_LINES[k % 4],
            color=BLADE_COLOURS[k % len(BLADE_COLOURS)],
            label=name,
        )
    axes.set_xlabel("diameter [m]")
    axes.set_ylabel("height above base [m]")
    axes.legend(frameon=False)
    light_grid(axes)
    return axes


def plot_tower_walls(towers: Mapping[str, TowerLike], *, ax: Axes | None = None) -> Axes:
    """Walls of the elements over the height above the base, figure 3 a."""
    axes = axes_or_new(ax)
    for k, (name, tower) in enumerate(towers.items()):
        z = np.linspace(0.0, tower.length, tower.diameter.size)
        axes.stairs(
            1e3 * tower.thickness,
            z,
            orientation="horizontal",
            baseline=None,
            ls=_LINES[k % 4],
            color=BLADE_COLOURS[k % len(BLADE_COLOURS)],
            label=name,
        )
    axes.set_xlabel("wall [mm]")
    axes.set_ylabel("height above base [m]")
    axes.legend(frameon=False)
    light_grid(axes)
    return axes


def plot_multipliers(
    multipliers: Mapping[str, ArrayLike],
    *,
    labels: Sequence[str] | None = None,
    ax: Axes | None = None,
) -> Axes:
    """Multipliers of several towers as bars side by side, figure 3 b and c.

    Parameters
    ----------
    multipliers : mapping of str to array_like (N,)
        By tower; relative mass per unit of the constraint [-].
    labels : sequence of str
        Of the N places; numbers without, every second of many.
    """
    axes = axes_or_new(ax)
    width = 0.8 / len(multipliers)
    for k, (name, given) in enumerate(multipliers.items()):
        values = np.asarray(given, dtype=np.float64)
        at = np.arange(values.size) + (k - 0.5 * (len(multipliers) - 1)) * width
        axes.bar(
            at,
            values,
            width,
            color=BLADE_COLOURS[k % len(BLADE_COLOURS)],
            label=name,
            hatch="//" if k else None,
        )
        every = np.arange(0, values.size, 1 if values.size <= 12 or labels is not None else 2)
        places = [str(n + 1) for n in every] if labels is None else list(labels)
        axes.set_xticks(every, places, fontsize=None if labels is None else 7)
    axes.set_ylabel("multiplier over mass [-]")
    axes.legend(frameon=False)
    light_grid(axes)
    return axes


def plot_mass_change(
    weights: ArrayLike,
    first_order: ArrayLike,
    high_order: ArrayLike,
    truth: ArrayLike | None = None,
    with_response: ArrayLike | None = None,
    *,
    mass: float,
    ax: Axes | None = None,
) -> Axes:
    """Estimated and true change of the optimal mass over the weight, figure 4.

    Parameters
    ----------
    weights, first_order, high_order : (K,) array_like
        c, and changes [kg].
    truth : (K,) array_like, optional
        Of towers sized anew [kg].
    with_response : (K,) array_like, optional
        High-order changes with the loads' response [kg].
    mass : float
        Of the reference tower [kg].
    """
    axes = axes_or_new(ax)
    c = np.asarray(weights)
    for values, look, colour, label in (
        (first_order, "--", VERMILION, "first-order"),
        (high_order, "s-", BLUE, "high-order"),
        (with_response, "^-.", GREEN, "with the loads' response"),
        (truth, "o:", BLACK, "sized anew"),
    ):
        if values is not None:
            axes.plot(c, 100.0 * np.asarray(values) / mass, look, color=colour, label=label)
    axes.set_xlabel(_WEIGHT)
    axes.set_ylabel("change of optimal mass [%]")
    axes.legend(frameon=False)
    light_grid(axes)
    return axes


def plot_cost_map(
    costs: CostMapLike, *, reference_height: float, reference_cost: float, ax: Axes | None = None
) -> Axes:
    """Change of the cost of energy over hub height and weight, figure 5.

    The cross stands at the lowest cost of all, the circle at the lowest for c = 0.

    Parameters
    ----------
    costs : CostMapLike
    reference_height, reference_cost : float
        [m, $/MWh], both axes and colours are changes from them.
    """
    axes = axes_or_new(ax)
    heights, weights, cost = costs.fine()
    change = 100.0 * (cost / reference_cost - 1.0)
    x = 100.0 * (heights / reference_height - 1.0)
    filled = axes.contourf(x, weights, change.T, levels=16, cmap="cividis")
    lines = axes.contour(x, weights, change.T, levels=8, colors="w", linewidths=0.6)
    axes.clabel(lines, fmt="%.2f", fontsize=7)
    axes.figure.colorbar(filled, ax=axes, label="change of cost of energy [%]")
    for (h, c, _), look, colour, label in (
        (costs.lowest(0.0), "o", GREEN, "lowest, c = 0"),
        (costs.lowest(), "X", VERMILION, "lowest of all"),
    ):
        axes.plot(
            100.0 * (h / reference_height - 1.0),
            c,
            look,
            color=colour,
            mec="w",
            ms=9,
            clip_on=False,
            linestyle="none",
            label=label,
        )
    axes.legend(loc="upper left", fontsize=7)
    axes.set_xlabel("change of hub height [%]")
    axes.set_ylabel(_WEIGHT)
    return axes
