"""A learning run on the dynamic turbine: loads over rotations, and the profiles.

The load of a rotation is the weighted RMS in its passages, over that of the constant pitch in the
same passages of the same wind.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from pitchopt.plotting.style import BLACK, BLUE, GREY, VERMILION, axes_or_new, light_grid

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

__all__ = ["plot_turbine_learning", "plot_turbine_profiles", "turbine_learning_figure"]


def plot_turbine_learning(result: Any, *, ax: Axes | None = None) -> Axes:
    """Share of the constant pitch's load that is left, over the rotations of learning.

    Parameters
    ----------
    result : TurbineLearning
    """
    ax = axes_or_new(ax)
    rotations = np.arange(1, result.record.rotations + 1)
    ax.axhline(100.0, color=GREY, linewidth=0.8)
    ax.plot(rotations, [100.0 * result.left(int(n)) for n in rotations], "o-", color=BLUE, ms=3)
    ax.set_ylim(bottom=0.0)
    turns = result.turns
    ax.set_xlabel("rotation" if turns == 1 else f"rotation of the learner, {turns} of the rotor")
    ax.set_ylabel("RMS left of constant pitch's [%]")
    light_grid(ax)
    return ax


def plot_turbine_profiles(result: Any, *, ax: Axes | None = None) -> Axes:
    """Start, learned and model-based pitch over azimuth.

    Parameters
    ----------
    result : TurbineLearning
    """
    ax = axes_or_new(ax)
    azimuth = np.rad2deg(result.azimuth)
    for held, label, colour in (
        (result.start, "start", GREY),
        (result.design, "static design, turned by the lag", BLACK),
        (result.learned, "learned", VERMILION),
    ):
        for row, own in enumerate(np.atleast_2d(held.profile)):
            ax.plot(azimuth, np.rad2deg(own), color=colour, label=label if row == 0 else None)
    ax.set_xlabel("azimuth [deg]")
    ax.set_ylabel("pitch [deg]")
    ax.set_xticks(np.arange(0, 361, 60))
    ax.legend(frameon=False)
    light_grid(ax)
    return ax


def turbine_learning_figure(result: Any, *, title: str = "") -> Figure:
    """Both on one page."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(9.0, 3.8), layout="constrained")
    left, right = figure.subplots(1, 2)
    plot_turbine_learning(result, ax=left)
    plot_turbine_profiles(result, ax=right)
    if title:
        figure.suptitle(title)
    return figure
