"""Pitch profiles and rotor loads over one blade passage (paper 003, figures 6 and 7).

The plots run over the paper's rotor position theta, measured from the horizontal: blade 1 stands
at azimuth psi = theta - 90 degrees, blade b another b - 1 parts of a turn ahead.  One passage,
theta from 0 to 2 pi / B, shows everything: afterwards the next blade does the same.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any, Literal, TypeVar

import numpy as np
from numpy.typing import NDArray

from pitchopt.aero.curves import LOADS
from pitchopt.errors import InputError
from pitchopt.plotting.style import (
    BLACK,
    BLADE_COLOURS,
    BLUE,
    VERMILION,
    axes_or_new,
    engineering,
    light_grid,
)

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.lines import Line2D

    from pitchopt.design.results import Design

__all__ = ["plot_loads", "plot_profiles", "theta_of"]

FloatArray = NDArray[np.float64]
LineStyle = Literal["-", "--", ":", "-."]
T = TypeVar("T")

THETA_ZERO = float(np.pi / 2)
"""theta - psi of blade 1 [rad]."""

_STYLES: tuple[LineStyle, ...] = ("-", "--", ":", "-.")
_LOAD_STYLES: tuple[dict[str, Any], ...] = (
    {"color": VERMILION, "linestyle": "-"},
    {"color": BLUE, "linestyle": "--"},
    {"color": BLACK, "linestyle": "none", "marker": "x", "markersize": 4},
    {"color": BLADE_COLOURS[2], "linestyle": "-."},
)
_NAMES = {"torque": "torque", "tilt": "tilt moment", "yaw": "yaw moment", "thrust": "thrust"}


def theta_of(azimuth: FloatArray, blades: int) -> FloatArray:
    """Rotor position theta of blade 1's azimuth, within one blade passage [rad]."""
    passage = 2 * np.pi / blades
    theta = np.mod(azimuth + THETA_ZERO, passage)
    return np.where(np.isclose(theta, passage, rtol=0.0, atol=1e-9), 0.0, theta)


def _named(designs: Design | Mapping[str, Design]) -> dict[str, Design]:
    if isinstance(designs, Mapping):
        if not designs:
            raise InputError("designs: got none, expected at least one")
        return dict(designs)
    return {designs.kind: designs}


def plot_profiles(
    designs: Design | Mapping[str, Design],
    *,
    intervals: tuple[FloatArray, FloatArray] | None = None,
    ax: Axes | None = None,
) -> Axes:
    """Pitch of every blade over one passage.

    Parameters
    ----------
    designs : Design or mapping of str to Design
        Colours tell the blades apart, line styles the designs.
    intervals : pair of arrays (N,), optional
        Lowest and highest pitch at the stations of the first design, shaded [rad]: such as what
        holds every better profile (``Certificate.intervals``).
    ax : Axes, optional
        Where to draw; a new figure without.
    """
    from matplotlib.lines import Line2D

    ax = axes_or_new(ax)
    named = _named(designs)
    blades = 1
    for (_, design), style in zip(named.items(), _cycle(_STYLES, len(named)), strict=True):
        first = style == _STYLES[0] and intervals is not None
        blades = design.profile.size // design.loads.rotor.shape[1]
        passage = 2 * np.pi / blades
        stations = theta_of(design.azimuth[: design.loads.rotor.shape[1]], blades)
        theta = np.union1d(stations, [0.0, passage])
        for b in range(blades):
            psi = theta - THETA_ZERO + b * passage
            pitch = np.interp(psi, design.azimuth, design.profile, period=2 * np.pi)
            ax.plot(
                theta, np.rad2deg(pitch), linestyle=style, linewidth=1.5,
                color=BLADE_COLOURS[b % len(BLADE_COLOURS)],
            )  # fmt: skip
            if first and intervals is not None:
                low, high = (
                    np.rad2deg(np.interp(psi, design.azimuth, end, period=2 * np.pi))
                    for end in intervals
                )
                colour = BLADE_COLOURS[b % len(BLADE_COLOURS)]
                ax.fill_between(theta, low, high, color=colour, alpha=0.12, linewidth=0)
    _passage_axis(ax, blades)
    ax.set_ylabel("pitch, towards feather [deg]")
    handles = [
        Line2D([], [], color=BLADE_COLOURS[b % len(BLADE_COLOURS)], label=f"blade {b + 1}")
        for b in range(blades)
    ]
    handles += [
        Line2D([], [], color="0.3", linestyle=style, label=label)
        for label, style in zip(named, _cycle(_STYLES, len(named)), strict=True)
    ]
    if intervals is not None:
        handles.append(
            Line2D([], [], color="0.3", alpha=0.25, linewidth=6, label="better ones lie here")
        )
    _legend_above(ax, handles)
    return ax


def plot_loads(
    designs: Design | Mapping[str, Design], *, load: str = "torque", ax: Axes | None = None
) -> Axes:
    """One rotor load over one blade passage, for one or several designs.

    Parameters
    ----------
    designs : Design or mapping of str to Design
    load : {"torque", "tilt", "yaw", "thrust"}
    ax : Axes, optional
        Where to draw; a new figure without.
    """
    if load not in LOADS:
        raise InputError(f"load: got {load!r}, expected one of {', '.join(LOADS)}")
    ax = axes_or_new(ax)
    named = _named(designs)
    row = LOADS.index(load)
    peak = max(float(np.abs(d.loads.rotor[row]).max()) for d in named.values())
    unit, prefix = engineering(peak)
    blades = 1
    for (label, design), style in zip(named.items(), _cycle(_LOAD_STYLES, len(named)), strict=True):
        count = design.loads.rotor.shape[1]
        blades = design.profile.size // count
        theta = theta_of(design.azimuth[:count], blades)
        order = np.argsort(theta)
        passage = 2 * np.pi / blades
        place, values = theta[order], design.loads.rotor[row, order] / unit
        if style["linestyle"] != "none":  # the line goes on to the end of the passage
            end = np.interp(passage, [place[-1], place[0] + passage], [values[-1], values[0]])
            start = np.interp(0.0, [place[-1] - passage, place[0]], [values[-1], values[0]])
            place = np.concatenate([[0.0], place, [passage]])
            values = np.concatenate([[start], values, [end]])
        ax.plot(place, values, label=label, linewidth=1.5, clip_on=False, **style)
    _passage_axis(ax, blades)
    ax.set_ylabel(f"{_NAMES[load]} [{prefix}N{'' if load == 'thrust' else ' m'}]")
    _legend_above(ax, None)
    return ax


def _cycle(styles: tuple[T, ...], count: int) -> list[T]:
    return [styles[i % len(styles)] for i in range(count)]


def _passage_axis(ax: Axes, blades: int) -> None:
    light_grid(ax)
    passage = 2 * np.pi / blades
    ax.set_xlim(0.0, passage)
    ax.set_xlabel(r"rotor position $\theta$ [rad], blade 1 at azimuth $\theta - 90°$")


def _legend_above(ax: Axes, handles: list[Line2D] | None) -> None:
    given: dict[str, Any] = {} if handles is None else {"handles": handles}
    ax.legend(
        loc="lower left", bbox_to_anchor=(0.0, 1.0), ncols=6, frameon=False, fontsize="small",
        borderaxespad=0.2, handlelength=1.8, columnspacing=1.4, **given,
    )  # fmt: skip
