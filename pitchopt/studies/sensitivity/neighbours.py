"""What a profile meets at every station: the segments of the curves below and above it.

Curves are piecewise linear between the breakpoints of each station.  A station at a breakpoint has
another slope to either side, one at the end of its range has no room beyond.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pitchopt.checks import FloatArray
from pitchopt.design.problem import DesignProblem

__all__ = ["Neighbours", "neighbours"]


@dataclass(frozen=True, kw_only=True, eq=False)
class Neighbours:
    """Slopes and room on both sides of every station.

    Attributes
    ----------
    left, right : ndarray (5, N)
        Slopes of the five loads below and above.
    down, up : ndarray (N,)
        Room to the next breakpoints [rad].
    at_bottom, at_top : bool ndarray (N,)
        Whether the station touches the lower and the upper end of its range.
    at_kink : bool ndarray (N,)
        Whether it touches a breakpoint.
    """

    left: FloatArray
    right: FloatArray
    down: FloatArray
    up: FloatArray
    at_bottom: NDArray[np.bool_]
    at_top: NDArray[np.bool_]
    at_kink: NDArray[np.bool_]


def neighbours(problem: DesignProblem, profile: FloatArray, reach: float) -> Neighbours:
    """Both segments at every station; what is nearer than `reach` [rad] counts as touched."""
    curves = problem.curves
    rows = np.arange(curves.stations)
    below = curves.segment(profile - reach)
    above = curves.segment(profile + reach)
    return Neighbours(
        left=curves.slopes[:, rows, below],
        right=curves.slopes[:, rows, above],
        down=np.maximum(profile - curves.beta[rows, below], 0.0),
        up=np.maximum(curves.beta[rows, above + 1] - profile, 0.0),
        at_bottom=profile - curves.lower <= reach,
        at_top=curves.upper - profile <= reach,
        at_kink=above > below,
    )
