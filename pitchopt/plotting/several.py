"""Designs for several winds: profiles over azimuth, and what each wind loses."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from pitchopt.plotting.style import BLACK, BLUE, ORANGE, axes_or_new, engineering, light_grid

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from pitchopt.design.several_results import Several

__all__ = ["plot_regrets", "plot_several_profiles"]


def plot_several_profiles(result: Several, *, ax: Axes | None = None) -> Axes:
    """Pitch over azimuth: the shared profile among the winds' own optima, or the schedule.

    Parameters
    ----------
    result : Several
    ax : Axes, optional
        Where to draw; a new figure without.
    """
    from matplotlib import colormaps

    ax = axes_or_new(ax)
    psi = np.append(result.azimuth, result.azimuth[0] + 2 * np.pi)
    shades = colormaps["viridis"](np.linspace(0.0, 0.92, len(result.winds)))
    single = result.profiles.shape[0] == 1
    for number, (wind, shade) in enumerate(zip(result.winds, shades, strict=True)):
        profile = wind.own_profile if single else result.profiles[number]
        ax.plot(
            np.rad2deg(psi), np.rad2deg(np.append(profile, profile[0])), color=shade,
            linewidth=0.8 if single else 1.5, linestyle="--" if single else "-",
            label=f"{wind.label} alone" if single else wind.label,
        )  # fmt: skip
    if single:
        shared = np.append(result.profile, result.profile[0])
        label = "for all winds"
        ax.plot(np.rad2deg(psi), np.rad2deg(shared), color=BLACK, linewidth=2.0, label=label)
    light_grid(ax)
    ax.set_xlim(np.rad2deg(psi[0]), np.rad2deg(psi[-1]))
    ax.set_xticks(np.rad2deg(psi[0]) + 45.0 * np.arange(9))
    ax.set_xlabel("azimuth of the blade [deg]")
    ax.set_ylabel("pitch, towards feather [deg]")
    ax.legend(loc="center left", bbox_to_anchor=(1.01, 0.5), frameon=False, fontsize="small")
    return ax


def plot_regrets(result: Several, *, ax: Axes | None = None) -> Axes:
    """What each wind loses against its own optimum, and the best constant pitch beside it.

    Parameters
    ----------
    result : Several
    ax : Axes, optional
        Where to draw; a new figure without.
    """
    ax = axes_or_new(ax)
    place = np.arange(len(result.winds))
    regret = np.array([wind.regret for wind in result.winds])
    unit, prefix = engineering(float(np.abs(regret).max()))
    ax.barh(place, regret / unit, color=BLUE, height=0.6, label="this design")
    ax.axvline(
        result.largest_regret / unit, color=ORANGE, linestyle="--", linewidth=1.0,
        label="largest regret",
    )  # fmt: skip
    ax.set_yticks(place, [wind.label for wind in result.winds])
    ax.invert_yaxis()
    light_grid(ax)
    ax.set_xlabel(f"objective below the wind's own optimum [{prefix}N m]")
    ax.legend(loc="lower left", bbox_to_anchor=(0.0, 1.0), ncols=2, frameon=False, fontsize="small")
    return ax
