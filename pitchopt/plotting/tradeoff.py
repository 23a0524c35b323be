"""Mean torque against weighted RMS: constant pitches, points, knee, bound (paper 003, figure 5).

Every point with price mu proves for all profiles T - mu J <= P, its upper bound.  Together they
say that no profile with weighted RMS J has more torque than

    min over the points of P + mu J,

which is drawn where it holds for all profiles: not with a frozen wake, whose bounds each hold
for one mean pitch only, and not with a price on pitch travel.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from pitchopt.plotting.style import (
    BLACK,
    BLUE,
    GREEN,
    GREY,
    ORANGE,
    VERMILION,
    axes_or_new,
    engineering,
    light_grid,
)

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from pitchopt.design.results import Design, Tradeoff

__all__ = ["bound_on_torque", "plot_tradeoff"]

FloatArray = NDArray[np.float64]


def plot_tradeoff(
    result: Tradeoff, *, weights_name: str = "", log: bool = True, ax: Axes | None = None
) -> Axes:
    """The trade-off curve.

    Parameters
    ----------
    result : Tradeoff
    weights_name : str
        Named in the label of the RMS axis.
    log : bool
        Logarithmic RMS axis; RMS spans decades between constant pitch and the flat designs.
    ax : Axes, optional
        Where to draw; a new figure without.
    """
    ax = axes_or_new(ax)
    usable = [point for point in result.points if point.status.ok]
    designs = [result.constant, result.power_max, *result.points]
    rms_unit, rms_prefix = engineering(max(d.rms_weighted for d in designs))
    unit, prefix = engineering(abs(result.power_max.mean_torque))

    order = np.argsort(result.constant_pitch)
    x, y = result.constant_rms[order] / rms_unit, result.constant_torque[order] / unit
    ax.plot(x, y, color=GREY, linewidth=0.8, marker=".", markersize=3, label="constant pitch")
    keep = result.constant_pareto[order]
    if np.count_nonzero(keep) > 1:
        ax.plot(
            np.where(keep, x, np.nan), np.where(keep, y, np.nan), color=GREY, linewidth=3.0,
            alpha=0.6, label="constant pitch that no other beats",
        )  # fmt: skip

    x, y = _places(sorted(usable, key=lambda p: p.rms_weighted))
    ax.plot(
        x / rms_unit, y / unit, color=BLUE, marker="o", markersize=4, linewidth=1.2,
        label="trade-off", zorder=3,
    )  # fmt: skip
    losses = [p for p in usable if p.kind == "max_power_loss"]
    if losses:
        x, y = _places(losses)
        ax.plot(
            x / rms_unit, y / unit, linestyle="none", marker="s", markersize=7, color=GREEN,
            markerfacecolor="none", markeredgewidth=1.6, label="least RMS for a given loss",
            zorder=4,
        )  # fmt: skip
        for point in losses:
            if point.target is not None:
                ax.annotate(
                    f"{100 * point.target:g} %",
                    (point.rms_weighted / rms_unit, point.mean_torque / unit),
                    xytext=(7, -11), textcoords="offset points", color=GREEN, fontsize="small",
                )  # fmt: skip
    bound = bound_on_torque(result)
    if bound is not None:
        at = np.geomspace(
            max(min(d.rms_weighted for d in designs), 1e-9 * rms_unit),
            max(d.rms_weighted for d in designs),
            400,
        )
        ax.plot(
            at / rms_unit, bound(at) / unit, color=ORANGE, linestyle="--", linewidth=1.2,
            label="proven: no profile above", zorder=2,
        )  # fmt: skip
        x, y = _places(sorted([result.power_max, *usable], key=lambda p: p.rms_weighted))
        known = np.maximum.accumulate(np.interp(at, x, y))
        ax.fill_between(
            at / rms_unit, known / unit, bound(at) / unit, color=ORANGE, alpha=0.15, linewidth=0,
            label="gap", zorder=1,
        )  # fmt: skip
    for design, marker, colour, label in (
        (result.constant, "X", BLACK, "best constant pitch"),
        (result.power_max, "^", VERMILION, "power maximum"),
    ):
        ax.plot(
            design.rms_weighted / rms_unit, design.mean_torque / unit, linestyle="none",
            marker=marker, markersize=9, color=colour, label=label, zorder=5,
        )  # fmt: skip
    if result.points:
        knee = result.points[result.knee]
        ax.plot(
            knee.rms_weighted / rms_unit, knee.mean_torque / unit, linestyle="none", marker="*",
            markersize=15, color=ORANGE, markeredgecolor=BLACK, label="knee", zorder=6,
        )  # fmt: skip

    light_grid(ax)
    low = min(d.mean_torque for d in designs)
    high = max(d.mean_torque for d in designs)
    room = max(0.08 * (high - low), 1e-3 * abs(high))
    ax.set_ylim((low - room) / unit, (high + 2 * room) / unit)
    if log and min(d.rms_weighted for d in designs) > 0:
        ax.set_xscale("log")
        widest = max(d.rms_weighted for d in designs)
        ax.xaxis.set_major_formatter("{x:g}")
        ax.set_xlim(0.8 * min(d.rms_weighted for d in designs) / rms_unit, 2 * widest / rms_unit)
    else:
        ax.set_xlim(0.0, 1.3 * max(d.rms_weighted for d in designs) / rms_unit)
    name = f", weights {weights_name}" if weights_name else ""
    ax.set_xlabel(f"weighted sum of RMS load variations{name} [{rms_prefix}N m]")
    ax.set_ylabel(f"mean torque [{prefix}N m]")
    ax.legend(loc="center left", bbox_to_anchor=(1.01, 0.5), frameon=False, fontsize="small")
    return ax


def bound_on_torque(result: Tradeoff) -> Callable[[FloatArray], FloatArray] | None:
    """Upper bound on the mean torque [N m] of any profile, over its weighted RMS [N m].

    None where the points do not carry bounds that hold for all profiles.
    """
    known = [p for p in result.points if p.upper_bound is not None and np.isfinite(p.mu)]
    if not known or any(p.mean_pitch is not None for p in known):
        return None
    if result.settings.get("travel"):
        return None
    bound = np.array([p.upper_bound for p in known], dtype=np.float64)
    mu = np.array([p.mu for p in known])

    def at(rms: FloatArray) -> FloatArray:
        return np.asarray((bound + mu * np.asarray(rms)[..., None]).min(axis=-1))

    return at


def _places(points: list[Design]) -> tuple[FloatArray, FloatArray]:
    return (
        np.array([p.rms_weighted for p in points]),
        np.array([p.mean_torque for p in points]),
    )
