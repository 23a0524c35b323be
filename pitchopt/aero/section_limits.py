"""Angle-of-attack limits between which a section's polar is fitted.

A section that works in attached flow at the mean pitch is fitted from a lower limit to its stall
angle.  One that does not (a cylinder, a stalled root, the tip itself) has no limits and stays
unfitted, so that limits can never exclude the mean pitch.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from pitchopt.aero.polars import Polar
from pitchopt.checks import FloatArray

__all__ = ["MARGIN", "section_limits"]

MARGIN = float(np.deg2rad(0.5))  # a fitted section keeps this much room at the mean pitch
_ROOM = float(np.deg2rad(6.0))  # fits reach this far below the angles at the mean pitch, ...
_COARSE = (0.03, 0.006)  # ... at the price of errors up to these in Cl and Cd
_STEP = float(np.deg2rad(2.0))  # limits are widened in such steps, so that fits are reused

Limits = tuple[float, float] | None


def section_limits(
    polars: Sequence[Polar],
    wanted: tuple[float | None, float | None],
    alpha: FloatArray | None = None,
    blocked: NDArray[np.bool_] | None = None,
) -> tuple[Limits, ...]:
    """Limits of each section's fit [rad], None for sections without one.

    Parameters
    ----------
    polars : sequence of Polar, length E
    wanted : (float or None, float or None)
        Limits for all sections.  None above: each polar's stall angle.  None below: where
        `Polar.concave_range` starts, and with `alpha` down to 6 degrees below the lowest angle
        as far as a coarser fit reaches.
    alpha : ndarray (..., E), optional
        Angles of attack at the mean pitch [rad].  Without them every section is fitted.
    blocked : ndarray (E,) of bool, optional
        Sections at the very tip or root, where the loss factor leaves no inflow to speak of.

    Raises
    ------
    InputError
        Without `alpha`, if a section has no attached range that could give a missing limit.
    """
    low, high = wanted
    result: list[Limits] = []
    for e, polar in enumerate(polars):
        if alpha is not None and (not polar.lifting or (blocked is not None and blocked[e])):
            result.append(None)
            continue
        above = polar.stall_angle() if high is None else high
        below = polar.concave_range()[0] if low is None else low
        if alpha is not None:
            least, most = float(alpha[..., e].min()), float(alpha[..., e].max())
            if low is None and least - _ROOM < below:
                extended = float(np.floor((least - _ROOM) / _STEP) * _STEP)
                below = min(below, max(extended, polar.concave_range(*_COARSE)[0]))
            if least < below + MARGIN or most > above - MARGIN:
                result.append(None)
                continue
        result.append((below, above))
    return tuple(result)
