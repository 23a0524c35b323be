"""Surrogate of a tuner: posterior over one parameter, design space over two.

The process is `pitchopt.tuning.GaussianProcess` of a cost or of any measure of the same
evaluations, or anything with the attributes of `ProcessLike`.  Bands are two standard deviations
of the function on either side, without the noise of a further sample.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Literal, Protocol

import numpy as np
from numpy.typing import ArrayLike, NDArray

from pitchopt.errors import InputError
from pitchopt.plotting.style import BLACK, BLUE, GREEN, VERMILION, axes_or_new, light_grid

if TYPE_CHECKING:
    from matplotlib.axes import Axes

__all__ = [
    "ProcessLike",
    "plot_acquisition",
    "plot_design_space",
    "plot_posterior",
    "plot_progress",
]

FloatArray = NDArray[np.float64]

_LINE = 401
_GRID = 61


class ParameterLike(Protocol):
    """A parameter, with its bounds."""

    @property
    def name(self) -> str:
        """As axes name it."""
        ...

    @property
    def scale(self) -> str:
        """Of the axis: linear or log."""
        ...


class SpaceLike(Protocol):
    """Parameters and their unit coordinates."""

    @property
    def parameters(self) -> Sequence[ParameterLike]:
        """In their order."""
        ...

    def from_unit(self, u: ArrayLike) -> FloatArray:
        """Points (..., d) of unit coordinates (..., d)."""
        ...


class ProcessLike(Protocol):
    """A posterior that can be drawn."""

    @property
    def space(self) -> SpaceLike:
        """Where it lives."""
        ...

    @property
    def samples(self) -> tuple[FloatArray, FloatArray]:
        """Points (n, d) and outputs (n,)."""
        ...

    def predict(self, x: ArrayLike) -> tuple[FloatArray, FloatArray]:
        """Mean (...) and standard deviation (...) at points (..., d)."""
        ...


def plot_posterior(
    process: ProcessLike,
    *,
    truth: Callable[[FloatArray], FloatArray] | None = None,
    label: str = "cost",
    ax: Axes | None = None,
) -> Axes:
    """Mean with band and samples over the one parameter of a space.

    Parameters
    ----------
    process : ProcessLike
    truth : callable, optional
        The function itself, (m, 1) -> (m,).
    label : str
        Of the output, with its unit.
    ax : Axes, optional
        Where to draw; a new figure without.

    Raises
    ------
    InputError
        If the space has more than one parameter.
    """
    x = _line(process)
    mean, std = process.predict(x)
    ax = axes_or_new(ax)
    across = x[:, 0]
    ax.fill_between(
        across, mean - 2.0 * std, mean + 2.0 * std, color=BLUE, alpha=0.2, linewidth=0,
        label="two standard deviations",
    )  # fmt: skip
    if truth is not None:
        ax.plot(across, truth(x), color=GREEN, linestyle="--", linewidth=1.5, label="function")
    ax.plot(across, mean, color=BLACK, linewidth=1.5, label="posterior mean")
    points, outputs = process.samples
    ax.plot(
        points[:, 0], outputs, "o", color=VERMILION, markersize=5, label="samples", zorder=3
    )  # fmt: skip
    _over(ax, process.space.parameters[0], "x")
    light_grid(ax)
    ax.set_ylabel(label)
    ax.legend(frameon=False, fontsize="small")
    return ax


def plot_acquisition(
    process: ProcessLike,
    acquisition: Callable[[FloatArray], FloatArray],
    *,
    chosen: float | None = None,
    label: str = "acquisition",
    ax: Axes | None = None,
) -> Axes:
    """Acquisition over the one parameter of a space, and the point that it chooses.

    Parameters
    ----------
    process : ProcessLike
        Whose space it is.
    acquisition : callable
        Of points (m, 1) in the units of the space.
    chosen : float, optional
        Next sample.
    label : str
    ax : Axes, optional
        Where to draw; a new figure without.

    Raises
    ------
    InputError
        If the space has more than one parameter.
    """
    x = _line(process)
    values = acquisition(x)
    ax = axes_or_new(ax)
    ax.plot(x[:, 0], values, color=VERMILION, linewidth=1.3)
    if chosen is not None:
        ax.axvline(chosen, color=VERMILION, linewidth=1.0, linestyle=":")
    _over(ax, process.space.parameters[0], "x")
    light_grid(ax)
    ax.set_ylabel(label)
    return ax


def plot_design_space(
    process: ProcessLike,
    *,
    show: Literal["mean", "std"] = "mean",
    label: str = "cost",
    ax: Axes | None = None,
) -> Axes:
    """Mean or standard deviation over the two parameters of a space, with the samples.

    With the mean the samples have the colour of their output on the same scale, so that a dot
    that stands out is one that the surface does not follow.

    Parameters
    ----------
    process : ProcessLike
    show : {"mean", "std"}
    label : str
        Of the output, with its unit.
    ax : Axes, optional
        Where to draw; a new figure without.

    Raises
    ------
    InputError
        If the space has not two parameters or `show` is neither.
    """
    parameters = process.space.parameters
    if len(parameters) != 2:
        raise InputError(f"process: got {len(parameters)} parameters, expected 2 to draw over")
    if show not in ("mean", "std"):
        raise InputError(f"show: got {show!r}, expected mean or std")
    side = np.linspace(0.0, 1.0, _GRID)
    grid = process.space.from_unit(np.stack(np.meshgrid(side, side), axis=-1))
    mean, std = process.predict(grid)
    surface, points, outputs = (mean if show == "mean" else std), *process.samples
    ax = axes_or_new(ax)
    filled = ax.contourf(grid[..., 0], grid[..., 1], surface, levels=20, cmap="viridis")
    low, high = filled.get_clim()
    if show == "mean":
        ax.scatter(
            points[:, 0], points[:, 1], c=outputs, vmin=low, vmax=high, cmap="viridis",
            edgecolors="white", linewidths=0.8, s=28, zorder=3, clip_on=False,
        )  # fmt: skip
    else:
        ax.plot(
            points[:, 0], points[:, 1], "o", color=VERMILION, markersize=4, clip_on=False
        )  # fmt: skip
    _over(ax, parameters[0], "x")
    _over(ax, parameters[1], "y")
    figure = ax.get_figure()
    if figure is not None:
        bar = figure.colorbar(filled, ax=ax)
        bar.set_label(label if show == "mean" else f"standard deviation of {label}")
    return ax


def plot_progress(
    costs: ArrayLike, *, start: float | None = None, label: str = "cost", ax: Axes | None = None
) -> Axes:
    """Each cost in the order of evaluation and the least so far; failures are crosses below.

    Parameters
    ----------
    costs : (N,) array_like
        NaN where an evaluation failed.
    start : float, optional
        Cost to begin with, as a line.
    label : str
        Of the cost, with its unit.
    ax : Axes, optional
        Where to draw; a new figure without.
    """
    costs = np.asarray(costs, dtype=np.float64)
    ax = axes_or_new(ax)
    number = np.arange(1, costs.size + 1)
    ax.plot(number, costs, "o", ms=3.5, color=BLUE, label="evaluated")
    ax.step(number, np.fmin.accumulate(costs), where="post", color=BLACK, label="least so far")
    failed = np.isnan(costs)
    if np.any(failed):
        bottom = ax.get_ylim()[0]
        ax.plot(number[failed], np.full(failed.sum(), bottom), "x", color="0.4", label="failed")
    if start is not None:
        ax.axhline(start, color="0.6", ls="--", lw=1.0, label="start")
    light_grid(ax)
    ax.set(xlabel="evaluation", ylabel=label)
    ax.legend(frameon=False)
    return ax


def _line(process: ProcessLike) -> FloatArray:
    count = len(process.space.parameters)
    if count != 1:
        raise InputError(f"process: got {count} parameters, expected 1 to draw over")
    return process.space.from_unit(np.linspace(0.0, 1.0, _LINE)[:, None])


def _over(ax: Axes, parameter: ParameterLike, axis: Literal["x", "y"]) -> None:
    if axis == "x":
        ax.set_xscale(parameter.scale)
        ax.set_xlabel(parameter.name)
    else:
        ax.set_yscale(parameter.scale)
        ax.set_ylabel(parameter.name)
