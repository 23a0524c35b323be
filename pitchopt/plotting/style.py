"""Colours and small helpers of the plots.

The colours are those of M. Okabe and K. Ito, Color Universal Design (2008), which readers with
any kind of colour vision tell apart; line styles and markers repeat what colours say.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from matplotlib.axes import Axes

__all__ = ["BLACK", "BLADE_COLOURS", "BLUE", "GREEN", "GREY", "ORANGE", "VERMILION", "axes_or_new"]

BLACK = "#000000"
BLUE = "#0072B2"
GREEN = "#009E73"
ORANGE = "#E69F00"
SKY = "#56B4E9"
VERMILION = "#D55E00"
PURPLE = "#CC79A7"
GREY = "#7F7F7F"
BLADE_COLOURS = (VERMILION, BLUE, GREEN, PURPLE, ORANGE, SKY)


def axes_or_new(ax: Axes | None) -> Axes:
    """The given axes, or those of a new figure."""
    if ax is not None:
        return ax
    from matplotlib import pyplot as plt

    return plt.figure(figsize=(6.4, 4.4), layout="constrained").add_subplot()


def light_grid(ax: Axes) -> None:
    """Thin grid behind the data, no box on top and right."""
    ax.grid(visible=True, color="0.9", linewidth=0.8)
    ax.set_axisbelow(True)
    ax.spines[["top", "right"]].set_visible(False)


def engineering(peak: float) -> tuple[float, str]:
    """Factor and prefix that bring a peak value to between 1 and 1000."""
    for factor, prefix in ((1e6, "M"), (1e3, "k")):
        if peak >= factor:
            return factor, prefix
    return 1.0, ""
