"""What changed limits, prices or winds would buy a pitch design: estimates beside the truth.

Drawn from the records of ``pitchopt sensitivity``: changes of the optimal value in N m, larger is
better.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from pitchopt.plotting.style import (
    BLACK,
    BLUE,
    GREY,
    VERMILION,
    axes_or_new,
    engineering,
    light_grid,
)

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

__all__ = ["plot_design_curve", "plot_design_sensitivity", "sensitivity_figure"]

_KINDS = (
    ("first_order", "first-order", VERMILION, "//"),
    ("high_order", "high-order", BLUE, None),
    ("resolved", "re-solved", BLACK, None),
)
_BAR = 0.26
_NONE = 1e-2  # [N m], changes that show nothing but rounding


def plot_design_sensitivity(record: Mapping[str, Any], *, ax: Axes | None = None) -> Axes:
    """Bars for every parameter: both estimates and, where there is one, the truth.

    Parameters
    ----------
    record : mapping
        As `pitchopt.studies.sensitivity` makes it of a design.
    ax : Axes, optional
        Where to draw; a new figure without.
    """
    ax = axes_or_new(ax)
    rows = record["rows"]
    values = {
        key: np.array([np.nan if row[key] is None else row[key] for row in rows], dtype=float)
        for key, *_ in _KINDS
    }
    shown = [kind for kind in _KINDS if np.isfinite(values[kind[0]]).any()]
    peak = max((float(np.nanmax(np.abs(values[key]))) for key, *_ in shown), default=0.0)
    factor, prefix = engineering(peak)
    place = np.arange(len(rows))[::-1]
    for k, (key, label, colour, hatch) in enumerate(shown):
        offset = (0.5 * (len(shown) - 1) - k) * _BAR
        ax.barh(
            place + offset, values[key] / factor, height=0.9 * _BAR, color=colour, label=label,
            hatch=hatch, edgecolor="white", linewidth=0.0,
        )  # fmt: skip
    ax.axvline(0.0, color=BLACK, linewidth=0.8)
    ax.set_yticks(place, [f"{row['label']}\n{_step(row)}" for row in rows])
    ax.set_xlabel(f"{_what(record)} [{prefix}N m]")
    light_grid(ax)
    if rows:
        ax.legend(frameon=False)
    return ax


def plot_design_curve(
    records: Sequence[Mapping[str, Any]], *, label: str = "", ax: Axes | None = None
) -> Axes:
    """Estimates and truth over a range of one parameter.

    Parameters
    ----------
    records : sequence of mappings
        Of one parameter, one for each change, in rising order of the change.
    label : str
        Of the parameter.
    ax : Axes, optional
        Where to draw; a new figure without.
    """
    ax = axes_or_new(ax)
    columns = {
        key: np.array([np.nan if r[key] is None else r[key] for r in records], dtype=float)
        for key in ("step_shown", "first_order", "high_order", "resolved")
    }
    other = np.array([bool(r["other_optimum"]) for r in records])
    step = columns.pop("step_shown")
    peak = max(float(np.nanmax(np.abs(v))) for v in columns.values() if np.isfinite(v).any())
    factor, prefix = engineering(peak)
    scaled = {key: value / factor for key, value in columns.items()}
    ax.axhline(0.0, color=GREY, linewidth=0.8)
    ax.axvline(0.0, color=GREY, linewidth=0.8)
    ax.plot(step, scaled["resolved"], color=BLACK, linewidth=1.2, marker="o", markersize=4.5,
            label="re-solved")  # fmt: skip
    if other.any():
        ax.plot(step[other], scaled["resolved"][other], linestyle="none", marker="o", markersize=8,
                markerfacecolor="none", color=BLACK, label="another optimum")  # fmt: skip
    ax.plot(step, scaled["first_order"], color=VERMILION, linestyle="--", label="first-order")
    ax.plot(step, scaled["high_order"], color=BLUE, linestyle="-.", label="high-order")
    if peak < _NONE:
        ax.set_ylim(-1.0, 1.0)
    ax.locator_params(axis="x", nbins=5)
    unit = records[0]["unit"]
    ax.set_xlabel(f"change of {label or records[0]['parameter']}" + _in(unit))
    ax.set_ylabel(f"change of the optimum [{prefix}N m]")
    light_grid(ax)
    return ax


def sensitivity_figure(
    record: Mapping[str, Any], curves: Sequence[Mapping[str, Any]] = (), *, title: str = ""
) -> Figure:
    """Bars of all parameters or, where there are curves, a panel for each of theirs.

    Parameters
    ----------
    record : mapping
        Of a design.
    curves : sequence of mappings
        Records of curves, of all parameters one after the other.
    title : str
    """
    from matplotlib.figure import Figure

    if not curves:
        figure = Figure(
            figsize=(8.0, 1.4 + 0.75 * max(len(record["rows"]), 1)), layout="constrained"
        )
        plot_design_sensitivity(record, ax=figure.add_subplot())
    else:
        names = list(dict.fromkeys(r["parameter"] for r in curves))
        labels = {row["parameter"]: row["label"] for row in record["rows"]}
        across = min(3, len(names))
        down = -(-len(names) // across)
        figure = Figure(figsize=(4.3 * across, 3.4 * down), layout="constrained")
        panels = np.atleast_1d(figure.subplots(down, across, squeeze=False)).ravel()
        for ax, name in zip(panels, names, strict=False):
            plot_design_curve(
                [r for r in curves if r["parameter"] == name], label=labels.get(name, name), ax=ax
            )
        for ax in panels[len(names) :]:
            ax.set_axis_off()
        panels[0].legend(frameon=False, fontsize="small")
    if title:
        figure.suptitle(title)
    return figure


def _in(unit: str) -> str:
    return "" if unit == "-" else f" [{unit}]"


def _step(row: Mapping[str, Any]) -> str:
    return f"{row['step_shown']:+.3g}" + ("" if row["unit"] == "-" else f" {row['unit']}")


def _what(record: Mapping[str, Any]) -> str:
    """What a change is a change of."""
    if record["objective"].startswith("mean"):
        return "gain of mean torque less mu x RMS"
    return "cut of the weighted RMS"
