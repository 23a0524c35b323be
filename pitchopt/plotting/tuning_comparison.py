"""Searches of several methods over the same two parameters: where they end, what they cost.

The plots take what `pitchopt.studies.tuning.compare_with_grids` returns, or anything with the
attributes of `ComparisonLike`.  The background is the finest grid's cost, blank where a run
diverged; costs are over that of the suggested point.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Protocol

import numpy as np
from numpy.typing import NDArray

from pitchopt.plotting.style import (
    BLACK,
    BLUE,
    GREEN,
    ORANGE,
    PURPLE,
    SKY,
    VERMILION,
    axes_or_new,
    light_grid,
)

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

__all__ = [
    "ComparisonLike",
    "SearchLike",
    "comparison_figure",
    "plot_costs_by_simulations",
    "plot_found_minima",
]

_LOOKS = (
    (BLACK, "o"),
    (PURPLE, "s"),
    (SKY, "D"),
    (BLUE, "^"),
    (ORANGE, "v"),
    (GREEN, "P"),
    (VERMILION, "X"),
)
_SHADES = 1.6  # cost over the suggested point's from which on the background stays the same
_WORDS = {"omega": "natural frequency [rad/s]", "zeta": "damping ratio [-]"}


class SearchLike(Protocol):
    """One search."""

    @property
    def method(self) -> str:
        """Name that groups searches."""
        ...

    @property
    def quadrant(self) -> str:
        """Where it began; empty for a grid."""
        ...

    @property
    def start(self) -> NDArray[np.float64]:
        """First point (2,)."""
        ...

    @property
    def x(self) -> NDArray[np.float64]:
        """Best point (2,)."""
        ...

    @property
    def cost(self) -> float:
        """Least, normalised."""
        ...

    @property
    def simulations(self) -> int:
        """That it took."""
        ...


class ComparisonLike(Protocol):
    """Searches with their background."""

    @property
    def searches(self) -> Sequence[SearchLike]:
        """All of them."""
        ...

    @property
    def methods(self) -> tuple[str, ...]:
        """Each once, in order."""
        ...

    @property
    def axes(self) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Values of the two parameters on the background's grid."""
        ...

    @property
    def costs(self) -> NDArray[np.float64]:
        """Of the background, rows over the second parameter."""
        ...

    @property
    def names(self) -> tuple[str, ...]:
        """Of the parameters."""
        ...

    @property
    def suggested(self) -> NDArray[np.float64]:
        """Point (2,) that costs are normalised by."""
        ...


def _looks(comparison: ComparisonLike) -> dict[str, tuple[str, str]]:
    return {m: _LOOKS[i % len(_LOOKS)] for i, m in enumerate(comparison.methods)}


def plot_found_minima(
    comparison: ComparisonLike, quadrant: str = "", *, ax: Axes | None = None
) -> Axes:
    """Best points of the searches that began in a quadrant, or of the grids for ``""``."""
    ax = axes_or_new(ax)
    first, second = comparison.axes
    shown = np.ma.masked_invalid(comparison.costs)
    picture = ax.contourf(
        first,
        second,
        np.minimum(shown, _SHADES),
        levels=np.linspace(float(shown.min()), _SHADES, 17),
        cmap="Greys",
    )
    ticks = np.arange(np.ceil(10.0 * float(shown.min())) / 10.0, _SHADES + 0.01, 0.2)
    ax.figure.colorbar(picture, ax=ax, ticks=ticks, label="cost over the suggested point's [-]")
    looks = _looks(comparison)
    part = [search for search in comparison.searches if search.quadrant == quadrant]
    for method in comparison.methods:
        points = np.array([search.x for search in part if search.method == method])
        if points.size:
            colour, marker = looks[method]
            ax.plot(
                *points.T, marker, color=colour, markersize=7, markeredgecolor="white",
                label=method, clip_on=False, zorder=3,
            )  # fmt: skip
    if quadrant and part:
        ax.plot(*part[0].start, "+", color=VERMILION, markersize=13, markeredgewidth=2.5,
                label="start")  # fmt: skip
    else:
        ax.plot(*comparison.suggested, "+", color=VERMILION, markersize=13, markeredgewidth=2.5,
                label="suggested")  # fmt: skip
    ax.set(
        xlabel=_WORDS.get(comparison.names[0], comparison.names[0]),
        ylabel=_WORDS.get(comparison.names[1], comparison.names[1]),
        title=f"start {quadrant}" if quadrant else "grids",
    )
    return ax


def plot_costs_by_simulations(comparison: ComparisonLike, *, ax: Axes | None = None) -> Axes:
    """Least cost of each search over the simulations that it took."""
    ax = axes_or_new(ax)
    light_grid(ax)
    looks = _looks(comparison)
    for method in comparison.methods:
        part = [search for search in comparison.searches if search.method == method]
        colour, marker = looks[method]
        ax.plot(
            [search.simulations for search in part],
            [search.cost for search in part],
            marker, color=colour, markersize=7, markeredgecolor="white", label=method,
        )  # fmt: skip
    ax.set(
        xlabel="simulations",
        ylabel="least cost over the suggested point's [-]",
        xlim=(0.0, None),
    )
    ax.legend(fontsize="small")
    return ax


def comparison_figure(comparison: ComparisonLike) -> Figure:
    """Best points from each start and of the grids, and costs over simulations, on one page."""
    from matplotlib import pyplot as plt

    quadrants = [q for q in dict.fromkeys(s.quadrant for s in comparison.searches) if q]
    count = len(quadrants) + 2
    rows = -(-count // 2)
    figure, axes = plt.subplots(rows, 2, figsize=(11.0, 3.9 * rows), layout="constrained")
    for ax, quadrant in zip(axes.flat, [*quadrants, ""], strict=False):
        plot_found_minima(comparison, quadrant, ax=ax)
    plot_costs_by_simulations(comparison, ax=axes.flat[count - 1])
    for ax in axes.flat[count:]:
        ax.set_axis_off()
    return figure
