"""Plots of a comparison: changes of loads by method and wind, over intensity, and in two turns.

The first two take the document of ``pitchopt compare``, so that they can be drawn again from its
JSON.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any, Protocol

import numpy as np

from pitchopt.plotting.style import (
    BLACK,
    BLUE,
    GREEN,
    GREY,
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

    from pitchopt.checks import FloatArray

__all__ = [
    "ExcerptLike",
    "method_figures",
    "plot_changes",
    "plot_excerpts",
    "plot_over_intensity",
]

_COLOURS = {
    "collective": BLACK,
    "feed-forward": BLUE,
    "learned": GREEN,
    "ipc-handbook": SKY,
    "ipc-grid": GREY,
    "ipc-zoo": ORANGE,
    "ipc-bayes": VERMILION,
    "feed-forward+ipc": PURPLE,
}
_MARKERS = {
    "feed-forward": "o",
    "learned": "s",
    "ipc-handbook": "X",
    "ipc-grid": "v",
    "ipc-zoo": "^",
    "ipc-bayes": "D",
    "feed-forward+ipc": "P",
}
_LABELS = {
    "blade": "blade out of plane",
    "tower": "tower fore-aft",
    "tilt": "tilt",
    "yaw": "yaw",
    "torque": "torque",
}


class ExcerptLike(Protocol):
    """A short time series of blade 1."""

    @property
    def time(self) -> FloatArray:
        """(R,) [s]."""

    @property
    def pitch(self) -> FloatArray:
        """Less the mean of the blades, (R,) [rad]."""

    @property
    def moment(self) -> FloatArray:
        """At the root out of plane, (R,) [N m]."""


def plot_changes(
    document: Mapping[str, Any], wind: str, *, kind: str = "del", ax: Axes | None = None
) -> Axes:
    """Bars of the change of each load by each method in a wind, with confidence intervals.

    Parameters
    ----------
    document : mapping
        Of ``pitchopt compare``.
    wind : str
    kind : {"del", "rms"}
        Damage-equivalent loads, or RMS about the mean.
    ax : Axes, optional
    """
    ax = axes_or_new(ax)
    records = [
        one
        for one in document["entries"]
        if one["wind"] == wind and one["method"] != "collective" and f"{kind}_cut" in one
    ]
    width = 0.8 / max(len(records), 1)
    loads = list(_LABELS)
    for i, record in enumerate(records):
        found = [record[f"{kind}_cut"][load] for load in loads]
        places = np.arange(len(loads)) + (i - 0.5 * (len(records) - 1)) * width
        spread = [100.0 * (one["half_width"] or 0.0) for one in found]
        ax.bar(
            places,
            [-100.0 * one["mean"] for one in found],
            width,
            yerr=spread if any(spread) else None,
            color=_COLOURS.get(record["method"], BLACK),
            error_kw={"elinewidth": 0.8},
            label=record["method"],
        )
    ax.axhline(0.0, color=BLACK, linewidth=0.8)
    ax.set_xticks(range(len(loads)), [_LABELS[load] for load in loads])
    ax.set_ylim(*_reach([one for r in records for one in r[f"{kind}_cut"].values()]))
    name = "equivalent load" if kind == "del" else "RMS"
    ax.set_ylabel(f"change of {name} [%]")
    light_grid(ax)
    return ax


def plot_over_intensity(
    document: Mapping[str, Any],
    load: str,
    *,
    methods: Sequence[str] | None = None,
    ax: Axes | None = None,
) -> Axes:
    """Change of one equivalent load over the turbulence intensity, a line for each method.

    Parameters
    ----------
    document : mapping
        Of ``pitchopt compare``.
    load : str
        ``blade``, ``tower``, ``tilt``, ``yaw`` or ``torque``.
    methods : sequence of str, optional
        All without.
    ax : Axes, optional
    """
    ax = axes_or_new(ax)
    level = {one["wind"]: one["intensity"] for one in document["winds"]}
    wanted = document["knowledge"] if methods is None else methods
    drawn = []
    for method in wanted:
        rows = [
            one
            for one in document["entries"]
            if one["method"] == method and method != "collective" and "del_cut" in one
        ]
        if not rows:
            continue
        found = [one["del_cut"][load] for one in rows]
        drawn += found
        ax.errorbar(
            [100.0 * level[one["wind"]] for one in rows],
            [-100.0 * one["mean"] for one in found],
            yerr=[100.0 * (one["half_width"] or 0.0) for one in found],
            color=_COLOURS.get(method, BLACK),
            marker=_MARKERS.get(method, "o"),
            markersize=4,
            linewidth=1.2,
            elinewidth=0.8,
            label=method,
        )
    ax.axhline(0.0, color=BLACK, linewidth=0.8)
    ax.set_ylim(*_reach(drawn))
    ax.set_xlabel("turbulence intensity [%]")
    ax.set_ylabel("change of equivalent load [%]")
    ax.set_title(_LABELS[load], loc="left", fontsize="medium")
    light_grid(ax)
    return ax


def plot_excerpts(
    excerpts: Mapping[str, ExcerptLike], quantity: str, *, ax: Axes | None = None
) -> Axes:
    """Pitch or root moment of blade 1 over two turns, a line for each method.

    Parameters
    ----------
    excerpts : mapping
        From methods to series.
    quantity : {"pitch", "moment"}
    ax : Axes, optional
    """
    ax = axes_or_new(ax)
    for method, series in excerpts.items():
        values = np.rad2deg(series.pitch) if quantity == "pitch" else 1e-3 * series.moment
        ax.plot(series.time, values, color=_COLOURS.get(method, BLACK), linewidth=1.2, label=method)
    ax.set_xlabel("time [s]")
    ax.set_ylabel(
        "pitch less the mean of the blades [deg]"
        if quantity == "pitch"
        else "root moment out of plane [kN m]"
    )
    light_grid(ax)
    return ax


def method_figures(
    document: Mapping[str, Any], excerpts: Mapping[str, Mapping[str, ExcerptLike]]
) -> dict[str, Figure]:
    """Figures by name: ``changes``, ``intensity`` (of several winds), ``turns``.

    Parameters
    ----------
    document : mapping
    excerpts : mapping
        From winds to methods to series.
    """
    from matplotlib.figure import Figure

    winds = [one["wind"] for one in document["winds"]]
    names = {one["wind"]: _wind(one) for one in document["winds"]}
    figures = {}
    figure = Figure(figsize=(8.6, 2.9 * len(winds) + 0.5), layout="constrained")
    for i, wind in enumerate(winds):
        ax = plot_changes(document, wind, ax=figure.add_subplot(len(winds), 1, i + 1))
        ax.set_title(names[wind], loc="left", fontsize="medium")
    _legend(figure)
    figures["changes"] = figure
    if len(winds) > 1:
        figure = Figure(figsize=(10.2, 6.0), layout="constrained")
        for i, load in enumerate(_LABELS):
            plot_over_intensity(document, load, ax=figure.add_subplot(2, 3, i + 1))
        _legend(figure)
        figures["intensity"] = figure
    shown = [wind for wind in (winds[0], winds[-1]) if excerpts.get(wind)]
    shown = list(dict.fromkeys(shown))
    if shown:
        figure = Figure(figsize=(10.2, 3.2 * len(shown) + 0.5), layout="constrained")
        for row, wind in enumerate(shown):
            for column, quantity in enumerate(("pitch", "moment")):
                place = 2 * row + column + 1
                ax = plot_excerpts(
                    excerpts[wind], quantity, ax=figure.add_subplot(len(shown), 2, place)
                )
                ax.set_title(names[wind], loc="left", fontsize="medium")
        _legend(figure)
        figures["turns"] = figure
    return figures


def _reach(found: Sequence[Mapping[str, Any]]) -> tuple[float, float]:
    """Range of the changes [%]; long confidence intervals leave the picture."""
    means = [-100.0 * one["mean"] for one in found] or [0.0]
    least, most = min(0.0, *means), max(0.0, *means)
    room = 0.5 * (most - least) or 1.0
    ends = [(m, 100.0 * (one["half_width"] or 0.0)) for m, one in zip(means, found, strict=False)]
    low = min([least, *(m - h for m, h in ends)])
    high = max([most, *(m + h for m, h in ends)])
    return max(low, least - room) - 0.1 * room, min(high, most + room) + 0.1 * room


def _wind(one: Mapping[str, Any]) -> str:
    if one["intensity"] == 0.0:
        return "steady wind"
    kind = "" if one["wind"][0] in ".0123456789" else f"class {one['wind']}, "
    return f"{kind}intensity {100 * one['intensity']:.1f} %"


def _legend(figure: Figure) -> None:
    """One legend for all axes, below them."""
    found: dict[str, Any] = {}
    for ax in figure.axes:
        handles, labels = ax.get_legend_handles_labels()
        found |= dict(zip(labels, handles, strict=True))
    if found:
        figure.legend(
            list(found.values()),
            list(found),
            loc="outside lower center",
            ncols=len(found),
            frameon=False,
            fontsize="small",
        )
