"""A learning run over its rotations (paper 003, figure 8), its profiles, its contraction.

Rotations of learning are 1, 2, ...; those of the experiment 0 and below, on shaded ground.  A load
at a rotation is that of its last passage.  The plots take a learning result as the study of
`pitchopt.studies.learning` makes it, or anything with the attributes of `LearningLike`.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Protocol

import numpy as np
from numpy.typing import NDArray

from pitchopt.plotting.style import (
    BLACK,
    BLADE_COLOURS,
    BLUE,
    GREY,
    ORANGE,
    VERMILION,
    axes_or_new,
    engineering,
    light_grid,
)

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from ilc import Record

__all__ = [
    "LearningLike",
    "LoopLike",
    "plot_contraction",
    "plot_learned_profiles",
    "plot_learning",
    "plot_torque",
]

FloatArray = NDArray[np.float64]


class FiguresLike(Protocol):
    """A profile and its load."""

    @property
    def profile(self) -> FloatArray:
        """Pitch (N,) or (B, N) [rad]."""
        ...

    @property
    def rms_weighted(self) -> float:
        """Weighted AC load."""
        ...


class StretchLike(Protocol):
    """Rotations with the same wind, and what is compared with there."""

    @property
    def first(self) -> int:
        """First rotation."""
        ...

    @property
    def last(self) -> int:
        """Last rotation."""
        ...

    @property
    def mean_wind(self) -> bool:
        """The wind drifts, and the others are for its mean."""
        ...

    @property
    def design(self) -> FiguresLike:
        """Model-based profile."""
        ...

    @property
    def constant(self) -> FiguresLike:
        """Best constant pitch."""
        ...


class LearningLike(Protocol):
    """A learning run."""

    @property
    def record(self) -> Record:
        """What happened."""
        ...

    @property
    def stretches(self) -> Sequence[StretchLike]:
        """Where the wind stays."""
        ...

    @property
    def azimuth(self) -> FloatArray:
        """Stations (N,) [rad]."""
        ...

    @property
    def start(self) -> FiguresLike:
        """Starting pitch."""
        ...

    @property
    def learned(self) -> FiguresLike:
        """Last profile."""
        ...


class LoopLike(Protocol):
    """Factors on the distance of the pitch from its fixed point."""

    @property
    def azimuth(self) -> FloatArray:
        """Azimuth of blade 1 (P,) [rad]."""
        ...

    @property
    def estimated(self) -> FloatArray:
        """By the Jacobian of the experiment, (P,)."""
        ...

    @property
    def true(self) -> FloatArray:
        """By the Jacobian of the plant, (P,)."""
        ...


def plot_learning(
    result: LearningLike, *, weights_name: str = "unit", ax: Axes | None = None
) -> Axes:
    """Weighted AC load over rotations, with constant pitch and design.

    Parameters
    ----------
    result : LearningLike
    weights_name : str
        Named in the label of the load's axis.
    ax : Axes, optional
        Where to draw; a new figure without.
    """
    from matplotlib.ticker import LogLocator

    ax = axes_or_new(ax)
    record = result.record
    rotation = _rotations(record)
    load = np.concatenate([record.experiment.ac_load, record.learning.ac_load])
    measured = np.concatenate(
        [record.experiment.ac_load_measured, record.learning.ac_load_measured]
    )
    unit, prefix = engineering(float(load.max()))
    if not np.allclose(measured, load, rtol=1e-9, equal_nan=False):
        ax.plot(
            rotation, measured / unit, color=BLUE, alpha=0.35, linewidth=1.0, label="as measured"
        )
    whole = np.concatenate([record.experiment.ac_load_rotation, record.learning.ac_load_rotation])
    ax.plot(
        rotation, whole / unit, color=BLUE, alpha=0.5, linestyle=":", linewidth=1.2,
        label="whole rotation",
    )  # fmt: skip
    ax.plot(
        rotation, load / unit, color=BLUE, marker="o", markersize=3, linewidth=1.5,
        label="learning, last passage", zorder=3,
    )  # fmt: skip
    for number, stretch in enumerate(result.stretches):
        ends = _span(stretch, record)
        where = ", mean wind" if stretch.mean_wind else ""
        for figures, style, colour, name in (
            (stretch.constant, "-.", GREY, "best constant pitch"),
            (stretch.design, "--", VERMILION, "designed with a model"),
        ):
            level = figures.rms_weighted / unit
            ax.plot(
                ends, (level, level), linestyle=style, color=colour, linewidth=1.3,
                label=name + where if number == 0 else None,
            )  # fmt: skip
    ax.set_yscale("log")
    ax.yaxis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0)))
    ax.yaxis.set_minor_formatter("")
    ax.yaxis.set_major_formatter("{x:g}")
    name = "" if weights_name == "unit" else f", weights {weights_name}"
    ax.set_ylabel(f"sum of RMS{name} [{prefix}N m]")
    _over_rotations(ax, record)
    return ax


def plot_torque(result: LearningLike, *, ax: Axes | None = None) -> Axes:
    """Mean torque of every rotation, and the set-point.

    Parameters
    ----------
    result : LearningLike
    ax : Axes, optional
        Where to draw; a new figure without.
    """
    ax = axes_or_new(ax)
    record = result.record
    rotation = _rotations(record)
    torque, setpoint = (
        np.concatenate([getattr(record.experiment, name), getattr(record.learning, name)])
        for name in ("mean_torque", "setpoint")
    )
    unit, prefix = engineering(float(np.abs(torque).max()))
    ax.plot(
        rotation, torque / unit, color=BLUE, marker="o", markersize=3, linewidth=1.5,
        label="learning",
    )  # fmt: skip
    ax.step(
        np.append(rotation - 0.5, rotation[-1] + 0.5), np.append(setpoint, setpoint[-1]) / unit,
        where="post", color=BLACK, linestyle="--", linewidth=1.2, label="set-point",
    )  # fmt: skip
    ax.set_ylabel(f"mean torque [{prefix}N m]")
    _over_rotations(ax, record)
    return ax


def plot_contraction(loop: LoopLike, *, ax: Axes | None = None) -> Axes:
    """Factor on the distance of the pitch from its fixed point in a passage, over the positions.

    Parameters
    ----------
    loop : LoopLike
    ax : Axes, optional
        Where to draw; a new figure without.
    """
    ax = axes_or_new(ax)
    psi = np.rad2deg(loop.azimuth)
    ax.plot(psi, loop.true, color=BLUE, marker="o", markersize=3, label="with the plant's slopes")
    ax.plot(
        psi, loop.estimated, color=ORANGE, linestyle="--", linewidth=1.5,
        label="with the estimated slopes",
    )  # fmt: skip
    ax.axhline(1.0, color=BLACK, linewidth=1.0, linestyle=":", label="no convergence above")
    top = float(max(loop.true.max(), loop.estimated.max(), 1.0))
    ax.set_ylim(0.0, 1.08 * top)
    light_grid(ax)
    ax.set_xlabel("azimuth of blade 1 [deg]")
    ax.set_ylabel("factor on the distance in a passage [-]")
    _legend_above(ax, 3)
    return ax


def plot_learned_profiles(result: LearningLike, *, ax: Axes | None = None) -> Axes:
    """Pitch over azimuth: where the run started, what it learned, and the last wind's design.

    Parameters
    ----------
    result : LearningLike
    ax : Axes, optional
        Where to draw; a new figure without.
    """
    ax = axes_or_new(ax)
    psi = np.rad2deg(np.append(result.azimuth, result.azimuth[0] + 2 * np.pi))

    def closed(profile: FloatArray) -> FloatArray:
        return np.asarray(np.rad2deg(np.append(profile, profile[0])))

    ax.plot(
        psi, closed(np.atleast_2d(result.start.profile)[0]), color=GREY, linestyle="-.",
        linewidth=1.3, label="start",
    )  # fmt: skip
    learned = np.atleast_2d(result.learned.profile)
    for blade, profile in enumerate(learned):
        single = len(learned) == 1
        ax.plot(
            psi, closed(profile), linewidth=1.6,
            color=BLUE if single else BLADE_COLOURS[blade % len(BLADE_COLOURS)],
            label="learned" if single else f"learned, blade {blade + 1}",
        )  # fmt: skip
    if result.stretches:
        ax.plot(
            psi, closed(result.stretches[-1].design.profile), linewidth=1.3, linestyle="--",
            color=VERMILION if len(learned) == 1 else BLACK, label="designed with a model",
        )  # fmt: skip
    light_grid(ax)
    ax.set_xlim(psi[0], psi[-1])
    ax.set_xticks(psi[0] + 45.0 * np.arange(9))
    ax.set_xlabel("azimuth of the blade [deg]")
    ax.set_ylabel("pitch, towards feather [deg]")
    _legend_above(ax, 3)
    return ax


def _rotations(record: Record) -> FloatArray:
    parts = record.experiment.rotation, record.learning.rotation
    return np.asarray(np.concatenate(parts), dtype=np.float64)


def _span(stretch: StretchLike, record: Record) -> tuple[float, float]:
    """Where a stretch is drawn; the first one over the experiment as well."""
    first = float(record.experiment.rotation[0]) if stretch.first == 1 else stretch.first
    return first - 0.5, stretch.last + 0.5


def _over_rotations(ax: Axes, record: Record) -> None:
    rotation = _rotations(record)
    ax.axvspan(rotation[0] - 0.5, 0.5, color="0.92", linewidth=0, label="experiment", zorder=0)
    light_grid(ax)
    ax.set_xlim(rotation[0] - 0.5, rotation[-1] + 0.5)
    ax.set_xlabel("rotation")
    _legend_above(ax, 3)


def _legend_above(ax: Axes, columns: int) -> None:
    ax.legend(
        loc="lower left", bbox_to_anchor=(0.0, 1.0), ncols=columns, frameon=False,
        fontsize="small", borderaxespad=0.2, handlelength=2.2, columnspacing=1.2,
    )  # fmt: skip
