"""Samples of gain and azimuth offset, coloured by cost, and how a study's cost goes down.

A gain with its offset is a point in a plane: the angle is n times the offset, so that one period of
the offset, 360/n degrees, is one turn, and all offsets of gain zero are one point.  Costs
above the highest colour have that colour.

Source of the layout: S. Mulders, A. Pamososuryo, J.-W. van Wingerden, "Efficient tuning of
Individual Pitch Control", 2020, figures 3 and 4.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Literal, NamedTuple, Protocol

import numpy as np

from pitchopt.plotting.style import BLADE_COLOURS, axes_or_new, light_grid

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from pitchopt.checks import FloatArray

__all__ = [
    "GainSamples",
    "gain_samples",
    "individual_pitch_figure",
    "plot_cost_progress",
    "plot_gain_offset",
    "progress_figure",
]

_COLOURS = "viridis_r"
_ORDERS = (1, 2)


class EvaluationLike(Protocol):
    """One evaluation."""

    @property
    def x(self) -> FloatArray:
        """gain_1p, offset_1p, gain_2p, offset_2p."""
        ...

    @property
    def cost(self) -> float:
        """NaN for one that failed."""
        ...


class GainSamples(NamedTuple):
    """Samples of a study of individual pitch.

    Attributes
    ----------
    gain, offset : ndarray (N, 2)
        Of both harmonics [rad/(N m s)], [rad].
    cost : ndarray (N,)
        In the order of evaluation; NaN where it failed.
    highest : float
        Cost of the highest colour and of one in normalised plots.
    """

    gain: FloatArray
    offset: FloatArray
    cost: FloatArray
    highest: float


def gain_samples(
    evaluations: Sequence[EvaluationLike], highest: float | None = None
) -> GainSamples:
    """Samples of evaluations; the highest colour is their largest cost without `highest`."""
    x = np.array([evaluation.x for evaluation in evaluations])
    cost = np.array([evaluation.cost for evaluation in evaluations])
    return GainSamples(
        gain=x[:, 0::2],
        offset=x[:, 1::2],
        cost=cost,
        highest=float(np.nanmax(cost)) if highest is None else float(highest),
    )


def plot_gain_offset(
    samples: GainSamples,
    order: int,
    *,
    plane: Literal["polar", "rectangular"] = "polar",
    ax: Axes | None = None,
) -> Axes:
    """Gain and offset of one harmonic, coloured by cost; failures are crosses.

    Parameters
    ----------
    samples : GainSamples
    order : int
        n, 1 or 2.
    plane : {"polar", "rectangular"}
        Points gain (cos, sin)(n offset), or gain over offset.
    ax : Axes, optional
    """
    ax = axes_or_new(ax)
    gain, offset = samples.gain[:, order - 1], samples.offset[:, order - 1]
    if plane == "polar":
        x, y = gain * np.cos(order * offset), gain * np.sin(order * offset)
        ax.set_aspect("equal")
        angle = np.linspace(0.0, 2.0 * np.pi, 181)
        for share in (0.5, 1.0):
            size = share * gain.max()
            ax.plot(size * np.cos(angle), size * np.sin(angle), color="0.85", lw=0.8, zorder=0)
        ax.axhline(0.0, color="0.85", lw=0.8, zorder=0)
        ax.axvline(0.0, color="0.85", lw=0.8, zorder=0)
        angle_name = "offset" if order == 1 else f"{order} offset"
        ax.set(xlabel=f"gain cos({angle_name}) [rad/(N m s)]", ylabel=f"gain sin({angle_name})")
    else:
        x, y = np.degrees(offset), gain
        light_grid(ax)
        ax.set(xlabel="azimuth offset [deg]", ylabel="gain [rad/(N m s)]")
    good = np.isfinite(samples.cost)
    ax.scatter(x[~good], y[~good], marker="x", color="0.4", s=18)
    worst_first = np.flatnonzero(good)[np.argsort(-samples.cost[good])]
    ax.scatter(
        x[worst_first],
        y[worst_first],
        c=samples.cost[worst_first],
        cmap=_COLOURS,
        vmin=float(np.nanmin(samples.cost)),
        vmax=samples.highest,
        s=26,
        edgecolors="0.3",
        linewidths=0.4,
    )
    best = int(np.nanargmin(samples.cost))
    ax.plot(x[best], y[best], marker="o", ms=11, mfc="none", mec="black", mew=1.4)
    ax.set_title(f"{order}P")
    return ax


def plot_cost_progress(
    studies: Mapping[str, GainSamples], *, least: bool = False, ax: Axes | None = None
) -> Axes:
    """Costs in the order of evaluation, from 0 at the least to 1 at the highest colour.

    Parameters
    ----------
    studies : mapping of str to GainSamples
    least : bool
        The least so far in place of each.
    ax : Axes, optional
    """
    ax = axes_or_new(ax)
    for colour, (label, samples) in zip(BLADE_COLOURS, studies.items(), strict=False):
        low = float(np.nanmin(samples.cost))
        share = (samples.cost - low) / max(samples.highest - low, np.finfo(float).tiny)
        number = np.arange(1, share.size + 1)
        if least:
            ax.step(number, np.fmin.accumulate(share), where="post", color=colour, label=label)
        else:
            ax.plot(number, share, marker="o", ms=3, lw=0.7, color=colour, label=label)
    light_grid(ax)
    ax.set(xlabel="evaluation", ylabel="least cost so far [-]" if least else "cost [-]")
    ax.set_ylim(-0.05, 1.6)
    ax.legend(frameon=False)
    return ax


def individual_pitch_figure(
    studies: Mapping[str, GainSamples],
    *,
    plane: Literal["polar", "rectangular"] = "polar",
    unit: tuple[float, str] = (1e-6, "MN m"),
) -> Figure:
    """Studies in rows, harmonics in columns.

    Parameters
    ----------
    studies : mapping of str to GainSamples
        By their titles, such as wind speeds.
    plane : {"polar", "rectangular"}
    unit : tuple
        Factor and name of the costs' unit at the colours.
    """
    from matplotlib import colormaps
    from matplotlib.cm import ScalarMappable
    from matplotlib.colors import Normalize
    from matplotlib.figure import Figure

    figure = Figure(figsize=(9.0, 4.2 * len(studies)), layout="constrained")
    grid = figure.subplots(len(studies), len(_ORDERS), squeeze=False)
    factor, name = unit
    for row, (label, samples) in zip(grid, studies.items(), strict=True):
        for order, ax in zip(_ORDERS, row, strict=True):
            plot_gain_offset(samples, order, plane=plane, ax=ax)
            ax.set_title(f"{label}, {order}P")
        colours = ScalarMappable(
            Normalize(factor * float(np.nanmin(samples.cost)), factor * samples.highest),
            colormaps[_COLOURS],
        )
        figure.colorbar(colours, ax=list(row), label=f"damage-equivalent load [{name}]")
    return figure


def progress_figure(studies: Mapping[str, GainSamples]) -> Figure:
    """Each cost and the least so far, side by side."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(9.0, 3.8), layout="constrained")
    left, right = figure.subplots(1, 2)
    plot_cost_progress(studies, ax=left)
    plot_cost_progress(studies, least=True, ax=right)
    return figure
