"""The wind over the rotor disc, as seen when looking downwind (paper 003, figure 2).

The horizontal axis is y, which is positive to the left looking downwind and therefore grows to
the left in the plot; z is up from the hub.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from pitchopt.plotting.style import axes_or_new

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from windfield import DiscSample

__all__ = ["plot_wind_field"]

_LABELS = {
    "speed": "wind speed [m/s]",
    "downwind": "downwind velocity [m/s]",
    "lateral": "lateral velocity [m/s]",
    "vertical": "vertical velocity [m/s]",
}


def plot_wind_field(sample: DiscSample, *, levels: int = 24, ax: Axes | None = None) -> Axes:
    """Colours of the wind speed over the disc.

    Parameters
    ----------
    sample : DiscSample
        From :func:`windfield.sample_disc`.
    levels : int
        Number of colour steps, about.
    ax : Axes, optional
        Where to draw; a new figure without.

    Returns
    -------
    Axes
        A colour bar stands beside it.
    """
    from matplotlib.ticker import MaxNLocator

    ax = axes_or_new(ax)
    y, z, speed = sample.y, sample.z, sample.speed
    if not np.isclose(sample.azimuth[-1] - sample.azimuth[0], 2 * np.pi):
        y, z, speed = (np.concatenate([a, a[:, :1]], axis=1) for a in (y, z, speed))
    low, high = float(speed.min()), float(speed.max())
    if high - low < 1e-9 * max(abs(high), 1.0):
        low, high = low - 0.5, high + 0.5
    edges = np.asarray(MaxNLocator(levels, steps=[1, 2, 2.5, 5, 10]).tick_values(low, high))
    filled = ax.contourf(y, z, speed, levels=edges, cmap="viridis")
    rim = float(sample.radius[-1])
    turn = np.linspace(0, 2 * np.pi, 181)
    ax.plot(rim * np.sin(turn), rim * np.cos(turn), color="0.2", linewidth=1.0)
    ax.set_aspect("equal")
    ax.set_xlim(1.06 * rim, -1.06 * rim)
    ax.set_ylim(-1.06 * rim, 1.06 * rim)
    ax.set_xlabel("y from the hub, left looking downwind [m]")
    ax.set_ylabel("z from the hub, up [m]")
    ax.spines[["top", "right"]].set_visible(False)
    bar = ax.figure.colorbar(filled, ax=ax, shrink=0.85)
    bar.set_label(_LABELS[sample.component])
    bar.set_ticks(edges[:: max(1, round(edges.size / 8))].tolist())
    return ax
