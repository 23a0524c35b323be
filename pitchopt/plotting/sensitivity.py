"""Estimated change of an optimum beside the re-solved one, and the plane that it moves in."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Protocol

import numpy as np
from numpy.typing import ArrayLike, NDArray

from pitchopt.errors import InputError
from pitchopt.plotting.style import BLACK, BLUE, ORANGE, VERMILION, axes_or_new, light_grid

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

__all__ = [
    "CurveLike",
    "PlaneCurveLike",
    "estimates_figure",
    "plot_design_plane",
    "plot_estimates",
]

FloatArray = NDArray[np.float64]


class CurveLike(Protocol):
    """Re-solved and estimated changes over a parameter."""

    @property
    def name(self) -> str:
        """As a title says it."""
        ...

    @property
    def dc(self) -> FloatArray:
        """Changes of the parameter (K,)."""
        ...

    @property
    def truth(self) -> FloatArray:
        """Re-solved changes (K,)."""
        ...

    @property
    def first_order(self) -> FloatArray:
        """Estimated changes (K,)."""
        ...

    @property
    def high_order(self) -> FloatArray:
        """Estimated changes (K,)."""
        ...


class ProgramLike(Protocol):
    """A program of two variables under a limit on the first that moves with c."""

    @property
    def H(self) -> FloatArray | None:  # noqa: N802
        """Row of the constraint that stays."""
        ...

    @property
    def G(self) -> FloatArray:  # noqa: N802
        """Row of the constraint that moves."""
        ...

    @property
    def h0(self) -> float:
        """Limit that stays."""
        ...

    def limit(self, c: float) -> float:
        """Limit that moves."""
        ...

    def objective(self, x1: ArrayLike, x2: ArrayLike, c: float) -> FloatArray:
        """Over the plane."""
        ...


class PlaneCurveLike(CurveLike, Protocol):
    """The same with designs in a plane."""

    @property
    def program(self) -> ProgramLike:
        """What was solved."""
        ...

    @property
    def designs(self) -> FloatArray:
        """Optima (K, 2)."""
        ...


def plot_estimates(
    curve: CurveLike, *, label: str = "change of the optimum", ax: Axes | None = None
) -> Axes:
    """Re-solved change of the optimum over dc, and both estimates.

    Parameters
    ----------
    curve : CurveLike
    label : str
        Of the change, with its unit.
    ax : Axes, optional
        Where to draw; a new figure without.
    """
    ax = axes_or_new(ax)
    ax.plot(curve.dc, curve.truth, color=BLACK, linewidth=1.8, label="re-solved")
    ax.plot(
        curve.dc, curve.first_order, color=VERMILION, linestyle="--", linewidth=1.5,
        label="first-order",
    )  # fmt: skip
    ax.plot(
        curve.dc, curve.high_order, color=BLUE, linestyle="-.", linewidth=1.5, label="high-order"
    )
    light_grid(ax)
    ax.set(xlabel="dc", ylabel=label, title=curve.name)
    ax.legend(frameon=False, fontsize="small")
    return ax


def plot_design_plane(
    curve: PlaneCurveLike, *, at: Sequence[float] = (0.0, 0.1, 0.7), ax: Axes | None = None
) -> Axes:
    """Contours of the objective at the first c, limits and optima at several.

    Parameters
    ----------
    curve : PlaneCurveLike
        With a moving limit on x1 alone.
    at : sequence of float
        Values of c, each within the curve.
    ax : Axes, optional
        Where to draw; a new figure without.

    Raises
    ------
    InputError
        If a limit is not one on x1, or a value of c is not in the curve.
    """
    program = curve.program
    rows = [program.G] if program.H is None else [program.G, program.H]
    if any(row[1] != 0.0 or row[0] <= 0.0 for row in rows):
        raise InputError("curve: expected limits on the first variable to draw as lines")
    values = np.asarray(at, dtype=np.float64)
    nearest = [int(np.argmin(np.abs(curve.dc - c))) for c in values]
    off = np.abs(curve.dc[nearest] - values)
    if values.size == 0 or (off > 1e-9).any():
        raise InputError(f"at: got {list(at)}, expected values of dc of the curve")
    ax = axes_or_new(ax)
    points = curve.designs[nearest]
    limits = [program.limit(float(c)) / float(program.G[0]) for c in values]
    fixed = [] if program.H is None else [program.h0 / float(program.H[0])]
    left, right = min([*limits, *fixed, points[:, 0].min()]), max([*limits, *fixed])
    width = max(right - left, 1.0)
    height = max(float(np.ptp(points[:, 1])), width)
    x1 = np.linspace(left - 0.5 * width, right + 0.5 * width, 81)
    x2 = np.linspace(points[:, 1].min() - height, points[:, 1].max() + height, 81)
    plane = program.objective(*np.meshgrid(x1, x2), float(values[0]))
    ax.contour(x1, x2, plane, levels=14, colors="0.7", linewidths=0.8, linestyles="solid")
    styles = ("-", "--", "-.", ":")
    for i, (c, limit) in enumerate(zip(values, limits, strict=True)):
        style = styles[i % len(styles)]
        ax.axvline(limit, color=ORANGE, linestyle=style, label=f"moving limit, c = {c:g}")
    for limit in fixed:
        ax.axvline(limit, color=BLUE, linewidth=2.0, label="limit that stays")
    ax.plot(points[:, 0], points[:, 1], "*", color=BLACK, markersize=11, label="optima", zorder=3)
    for c, (across, up) in zip(values, points, strict=True):
        ax.annotate(f"{c:g}", (across, up), xytext=(-7, 7), textcoords="offset points", ha="right")
    ax.set(xlabel="x1", ylabel="x2", xlim=(x1[0], x1[-1]), ylim=(x2[0], x2[-1]))
    ax.legend(frameon=True, framealpha=0.9, fontsize="small", loc="lower right")
    return ax


def estimates_figure(
    curves: Sequence[CurveLike], *, label: str = "change of the optimum", title: str = ""
) -> Figure:
    """One panel a curve, side by side."""
    from matplotlib.figure import Figure

    if not curves:
        raise InputError("curves: got none, expected at least one")
    figure = Figure(figsize=(1.0 + 3.6 * len(curves), 3.8), layout="constrained")
    panels = figure.subplots(1, len(curves), squeeze=False)[0]
    for i, (curve, ax) in enumerate(zip(curves, panels, strict=True)):
        plot_estimates(curve, label=label if i == 0 else "", ax=ax)
        if i > 0:
            ax.get_legend().set_visible(False)
    figure.suptitle(title, x=0.01, ha="left", fontsize="medium")
    return figure
