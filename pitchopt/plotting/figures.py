"""Whole figures of a trade-off, a design, a learning run or simulated runs, and their PNG files.

They use no pyplot, hence no state that others share, and return figures; `png` renders one.
"""

from __future__ import annotations

import io
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

from pitchopt.aero.curves import LOADS
from pitchopt.plotting.learning import (
    LearningLike,
    LoopLike,
    plot_contraction,
    plot_learned_profiles,
    plot_learning,
    plot_torque,
)
from pitchopt.plotting.passage import plot_loads, plot_profiles
from pitchopt.plotting.several import plot_regrets, plot_several_profiles
from pitchopt.plotting.simulation import (
    CURVES,
    OVER_TIME,
    OVER_WIND_SPEED,
    RunsLike,
    SteadyCurve,
    plot_channel,
    plot_over_wind_speed,
    plot_steady_curve,
)
from pitchopt.plotting.tradeoff import plot_tradeoff

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from pitchopt.checks import FloatArray
    from pitchopt.design.results import Design, Tradeoff
    from pitchopt.design.several_results import Several

__all__ = [
    "contraction_figure",
    "learned_profiles_figure",
    "learning_figure",
    "loads_figure",
    "png",
    "profiles_figure",
    "several_figures",
    "simulation_figure",
    "steady_curves_figure",
    "tradeoff_figure",
]


def _figure(width: float, height: float) -> Figure:
    from matplotlib.figure import Figure

    return Figure(figsize=(width, height), layout="constrained")


def tradeoff_figure(result: Tradeoff, *, weights_name: str = "", title: str = "") -> Figure:
    """Trade-off curve with its legend beside it."""
    figure = _figure(8.4, 4.6)
    ax = plot_tradeoff(result, weights_name=weights_name, ax=figure.add_subplot())
    ax.set_title(title, loc="left", fontsize="medium")
    return figure


def profiles_figure(
    designs: Mapping[str, Design],
    *,
    intervals: tuple[FloatArray, FloatArray] | None = None,
    title: str = "",
) -> Figure:
    """Pitch of all blades over one passage; intervals as in :func:`plot_profiles`."""
    figure = _figure(6.8, 4.6)
    plot_profiles(designs, intervals=intervals, ax=figure.add_subplot())
    figure.suptitle(title, x=0.01, ha="left", fontsize="medium")
    return figure


def loads_figure(designs: Mapping[str, Design], *, title: str = "") -> Figure:
    """Torque, tilt, yaw and thrust over one passage, one panel each."""
    figure = _figure(9.0, 6.4)
    for ax, load in zip(figure.subplots(2, 2, sharex=True).flat, LOADS, strict=True):
        plot_loads(designs, load=load, ax=ax)
        if load in LOADS[:2]:
            ax.set_xlabel("")
        legend = ax.get_legend()
        if legend is not None and load != LOADS[0]:
            legend.remove()
    figure.suptitle(title, x=0.01, ha="left", fontsize="medium")
    return figure


def several_figures(result: Several, *, title: str = "") -> tuple[Figure, Figure]:
    """Profiles of a design for several winds, and what each wind loses."""
    profiles = _figure(8.4, 4.6)
    ax = plot_several_profiles(result, ax=profiles.add_subplot())
    ax.set_title(title, loc="left", fontsize="medium")
    regrets = _figure(6.8, 1.6 + 0.3 * len(result.winds))
    plot_regrets(result, ax=regrets.add_subplot())
    regrets.suptitle(title, x=0.01, ha="left", fontsize="medium")
    return profiles, regrets


def learning_figure(result: LearningLike, *, weights_name: str = "unit", title: str = "") -> Figure:
    """Load above, torque below, over the same rotations (paper 003, figure 8)."""
    figure = _figure(7.6, 6.6)
    above, below = figure.subplots(2, 1, sharex=True, height_ratios=(3, 2))
    plot_learning(result, weights_name=weights_name, ax=above)
    above.set_xlabel("")
    plot_torque(result, ax=below)
    figure.suptitle(title, x=0.01, ha="left", fontsize="medium")
    return figure


def learned_profiles_figure(result: LearningLike, *, title: str = "") -> Figure:
    """Starting pitch, learned profile and design."""
    figure = _figure(6.8, 4.4)
    plot_learned_profiles(result, ax=figure.add_subplot())
    figure.suptitle(title, x=0.01, ha="left", fontsize="medium")
    return figure


def contraction_figure(loop: LoopLike, *, title: str = "") -> Figure:
    """Contraction of the paper's learner over the rotor positions."""
    figure = _figure(6.8, 4.0)
    plot_contraction(loop, ax=figure.add_subplot())
    figure.suptitle(title, x=0.01, ha="left", fontsize="medium")
    return figure


def simulation_figure(result: RunsLike, *, title: str = "") -> Figure:
    """Runs of one wind speed over time, those of several over wind speed; six channels at most."""
    known = [channel.name for channel in result.channels]
    several = len({run.wind_speed for run in result.runs}) > 1
    panels = OVER_WIND_SPEED if several else OVER_TIME
    names = [name for name in panels if name in known]
    names += [name for name in known if name not in names][: len(panels) - len(names)]
    if several:
        rows = -(-len(names) // 2)
        figure = _figure(9.0, 1.0 + 2.5 * rows)
        for number, name in enumerate(names, start=1):
            ax = figure.add_subplot(rows, 2, number)
            plot_over_wind_speed(result, name, label=False, ax=ax)
        handles = {
            text: handle
            for ax in figure.axes
            for handle, text in zip(*ax.get_legend_handles_labels(), strict=True)
        }
        figure.legend(handles.values(), handles, loc="outside lower center", frameon=False, ncols=2)
    else:
        figure = _figure(9.0, 1.0 + 1.55 * len(names))
        axes = figure.subplots(len(names), 1, sharex=True, squeeze=False)[:, 0]
        for ax, name in zip(axes, names, strict=True):
            plot_channel(result, name, ax=ax)
        axes[-1].set_xlabel("time [s]")
        figure.align_ylabels()
        if len(result.runs) > 1:
            figure.legend(
                *axes[0].get_legend_handles_labels(), loc="outside lower center", frameon=False,
                ncols=6,
            )  # fmt: skip
    figure.suptitle(title, x=0.01, ha="left", fontsize="medium")
    return figure


def steady_curves_figure(turbines: Sequence[SteadyCurve], *, title: str = "") -> Figure:
    """Power, thrust, rotor speed and pitch of turbines over wind speed."""
    figure = _figure(9.0, 6.6)
    axes = figure.subplots(2, 2).ravel()
    for ax, quantity in zip(axes, CURVES, strict=True):
        plot_steady_curve(turbines, quantity, ax=ax)
    figure.legend(
        *axes[0].get_legend_handles_labels(), loc="outside lower center", frameon=False, ncols=4
    )
    figure.suptitle(title, x=0.01, ha="left", fontsize="medium")
    return figure


def png(figure: Figure, *, dpi: int = 150) -> bytes:
    """Content of a PNG file."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg

    buffer = io.BytesIO()
    FigureCanvasAgg(figure).print_figure(buffer, dpi=dpi, format="png")
    return buffer.getvalue()
