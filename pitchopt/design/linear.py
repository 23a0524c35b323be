"""Linear models of the loads around a profile, and the lines that bound torque there.

Around beta0, on the segments that its stations stand on,

    load_l(beta) = load_l(beta0) + G_l (beta - beta0),

exact as long as no station leaves its segment.  Torque is modelled by its own segments, which
is exact where it is concave; where it is not, slopes are made monotone from beta0 outwards, so
that the model never promises more than beta0's own concave neighbourhood.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from pitchopt.design.problem import DesignProblem

if TYPE_CHECKING:
    from pitchopt.aero.curves import BladeCurves

__all__ = ["LinearModel", "torque_lines"]

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.intp]

_DENSE_REACH = 4  # segments on either side of beta0 that always enter
_NO_CHANGE = 1e-9  # share of torque below which the box does not change it
_MAX_LINES = 20  # torque lines per station; farther ones are thinned out


class LinearModel:
    """Loads around a point on given segments, and what the box can change them by."""

    def __init__(
        self,
        problem: DesignProblem,
        point: FloatArray,
        segments: IntArray | None,
        low: FloatArray,
        high: FloatArray,
        chord: float = 0.0,
        radius: float | None = None,
    ) -> None:
        curves = problem.curves
        rows = np.arange(curves.stations)
        self.curves = curves
        self.point, self.low, self.high = point, low, high
        self.affine = segments is not None
        self.segment = curves.segment(point) if segments is None else segments
        reach = float(np.max(np.maximum(high - point, point - low)))
        self.radius = max(reach, 1e-9) if radius is None else radius
        self.slopes = curves.slopes[:, rows, self.segment]
        offset = point - curves.beta[rows, self.segment]
        self.blade_static = curves.loads[:, rows, self.segment] + self.slopes * offset
        self.curvature: FloatArray | None = None
        if chord > 0:
            self._bend(chord)
        self.blade = self.blade_static + curves.rates * curves.profile_rate(point)
        self.rotor = self.blade[:4].reshape(4, curves.blades, curves.positions).sum(axis=1)
        self.half = 0.5 / curves.spacing
        self.torque = float(self.rotor[0].mean())
        folded = (np.roll(curves.rates[0], 1) - np.roll(curves.rates[0], -1)) * self.half
        self.torque_rate = folded / curves.positions  # d(mean torque)/d beta_n by pitch rate
        self.torque_gradient = self.slopes[0] / curves.positions + self.torque_rate

    def _bend(self, chord: float) -> None:
        """Curvature of the loads over a chord around the point."""
        curves, point = self.curves, self.point
        left = np.maximum(point - chord, curves.lower)
        right = np.minimum(point + chord, curves.upper)
        before, after = np.maximum(point - left, 1e-12), np.maximum(right - point, 1e-12)
        down = (self.blade_static - curves.contributions(left)) / before
        up = (curves.contributions(right) - self.blade_static) / after
        down = np.where(before > 1e-9, down, up)
        up = np.where(after > 1e-9, up, down)
        self.curvature = 2.0 * (up - down) / (before + after)

    @property
    def torque_unit(self) -> float:
        """What the box can change torque by [N m]; torque itself where pitch does not change it."""
        change = float(np.mean(np.abs(self.slopes[0]))) * self.radius
        size = abs(self.torque)
        return change if change > _NO_CHANGE * size else size or 1.0

    def unit(self, load: int, tight: bool) -> float:
        """Size of a load in the box, which scales its cone.

        What the box can change, but not far below what is there: a cone of numbers around 1e6
        that vary by 1 is beyond the solver.
        """
        change = float(np.sqrt(np.mean(self.slopes[load] ** 2))) * self.radius
        spread = float(self.blade[4].std() if load == 4 else self.rotor[load].std())
        return max(change, (1.0 if tight else 0.02) * spread) or 1.0

    def residual(self, load: int) -> FloatArray:
        """Deviation of a load from its mean at the point."""
        values = self.blade[4] if load == 4 else self.rotor[load]
        return np.asarray(values - values.mean())


def torque_lines(
    curves: BladeCurves, point: FloatArray, j0: IntArray, low: FloatArray, high: FloatArray
) -> tuple[IntArray, FloatArray, FloatArray]:
    """Lines that bound a blade's torque inside the box: stations, values at ``point``, slopes.

    All segments in reach enter when they are few; farther ones are thinned out, which leaves
    an upper bound that later iterations refine.
    """
    rows = np.arange(curves.stations)
    first, last = np.minimum(curves.segment(low), j0), np.maximum(curves.segment(high), j0)
    reach = max(int(np.max(j0 - first)), int(np.max(last - j0)))
    offsets = np.arange(-reach, reach + 1)
    if curves.concave and offsets.size > _MAX_LINES:
        side = np.unique(
            np.concatenate(
                [
                    np.arange(_DENSE_REACH + 1),
                    np.geomspace(_DENSE_REACH, reach, _MAX_LINES // 2 - _DENSE_REACH).astype(int),
                ]
            )
        )
        offsets = np.concatenate([-side[:0:-1], side])
    j = j0[:, None] + offsets
    valid = (j >= first[:, None]) & (j <= last[:, None])
    jc = np.clip(j, 0, curves.beta.shape[1] - 2)
    slope = curves.slopes[0][rows[:, None], jc]
    if curves.concave:
        value = curves.torque[rows[:, None], jc] + slope * (
            point[:, None] - curves.beta[rows[:, None], jc]
        )
    else:
        slope, value = _monotone_lines(curves, point, j0, jc, slope)
    n, k = np.nonzero(valid)
    return n, value[n, k], slope[n, k]


def _monotone_lines(
    curves: BladeCurves, point: FloatArray, j0: IntArray, j: IntArray, slope: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Slopes made non-increasing outwards from ``point``, and their values at ``point``."""
    rows = np.arange(curves.stations)[:, None]
    centre = j.shape[1] // 2
    out = slope.copy()
    out[:, centre:] = np.minimum.accumulate(slope[:, centre:], axis=1)
    out[:, : centre + 1] = np.maximum.accumulate(slope[:, centre::-1], axis=1)[:, ::-1]
    left, right = curves.beta[rows, j], curves.beta[rows, j + 1]
    f0 = curves.torque[rows[:, 0], j0] + slope[:, centre] * (point - curves.beta[rows[:, 0], j0])
    value = np.empty_like(out)
    value[:, centre] = f0
    # value at point of the line through a breakpoint: it changes by the slope's change there
    for k in range(centre + 1, j.shape[1]):
        at = left[:, k] - point
        value[:, k] = value[:, k - 1] + (out[:, k - 1] - out[:, k]) * at
    for k in range(centre - 1, -1, -1):
        at = right[:, k] - point
        value[:, k] = value[:, k + 1] + (out[:, k + 1] - out[:, k]) * at
    return out, value
