"""A polar, its concave and convex piecewise-linear fits, and their limits (paper 003, figure 4)."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from pitchopt.plotting.style import BLUE, VERMILION, axes_or_new, light_grid

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from pitchopt.aero.fits import PolarFit
    from pitchopt.aero.polars import Polar

__all__ = ["plot_polar_fit"]


def plot_polar_fit(
    polar: Polar, fit: PolarFit, *, margin: float = 0.15, ax: Axes | None = None
) -> Axes:
    """Lift and drag coefficients over angle of attack: table, fit and limits.

    Parameters
    ----------
    polar : Polar
        The table.
    fit : PolarFit
        Its fit.
    margin : float
        How far the table is drawn beyond the limits [rad].
    ax : Axes, optional
        Where to draw; a new figure without.

    Returns
    -------
    Axes
        With lift on the left; drag has an axis of its own on the right, ``ax.child_axes`` apart
        from a twin found in ``ax.figure.axes``.
    """
    ax = axes_or_new(ax)
    low, high = fit.limits
    inside = polar.alpha[(polar.alpha > low - margin) & (polar.alpha < high + margin)]
    ends = np.clip([low - margin, high + margin], polar.alpha[0], polar.alpha[-1])
    alpha = np.union1d(inside, ends)
    cl, cd, _ = polar.coefficients(alpha)
    drag = ax.twinx()
    lines = [
        *ax.plot(np.rad2deg(alpha), cl, color=BLUE, alpha=0.45, linewidth=3.5, label="lift, table"),
        *ax.plot(
            np.rad2deg(fit.alpha), fit.cl, color=BLUE, marker=".", markersize=4, linewidth=1.0,
            label=f"lift, concave fit (largest error {fit.cl_error:.1g})",
        ),
        *drag.plot(
            np.rad2deg(alpha), cd, color=VERMILION, alpha=0.45, linewidth=3.5, linestyle="-",
            label="drag, table",
        ),
        *drag.plot(
            np.rad2deg(fit.alpha), fit.cd, color=VERMILION, marker="x", markersize=3.5,
            linewidth=1.0, label=f"drag, convex fit (largest error {fit.cd_error:.1g})",
        ),
    ]  # fmt: skip
    for limit in (low, high):
        last = ax.axvline(np.rad2deg(limit), color="0.3", linestyle=":", linewidth=1.2)
    last.set_label("limits of the fit")
    light_grid(ax)
    drag.spines["top"].set_visible(False)
    ax.set_xlabel("angle of attack [deg]")
    ax.set_ylabel("lift coefficient [-]", color=BLUE)
    drag.set_ylabel("drag coefficient [-]", color=VERMILION)
    # drag in the lower part, lift above it: the two tables do not cover each other
    drag.set_ylim(0.0, 2.2 * float(cd.max()))
    span = float(cl.max() - cl.min())
    ax.set_ylim(float(cl.min()) - 0.08 * span, float(cl.max()) + 0.08 * span)
    ax.set_title(polar.name, loc="left", fontsize="medium")
    ax.figure.legend(
        handles=[*lines, last], loc="outside lower center", ncols=2, frameon=False, fontsize="small"
    )
    return ax
