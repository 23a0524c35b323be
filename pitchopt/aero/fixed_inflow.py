"""Loads of one blade in a flow that does not answer to pitch: exactly piecewise linear.

With the flow of every section held, pitch only turns the section in it, alpha = phi - twist -
beta, and the loads are linear in Cl, Cd, Cm.  Sections come in two kinds:

* fitted: concave Cl and convex Cd of `fits`, piecewise linear between angle-of-attack limits.
  With a mean pitch given they are shifted by a constant to match the table exactly there
  ("anchored"); the shift changes no slope, so concavity stays;
* linear: the tangent to the table at the mean pitch (its slope is the secant over
  +/- `TANGENT`), for sections that work outside attached flow and have no concave fit.

Both make the torque concave in pitch.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pitchopt.aero.breakpoints import accumulate, pad_rows, thin
from pitchopt.aero.fits import PolarFit
from pitchopt.aero.induction import SectionPolars
from pitchopt.aero.loads import LoadMap
from pitchopt.checks import FloatArray

__all__ = ["TANGENT", "FixedInflow"]

TANGENT = float(np.deg2rad(2.0))
"""Half width of the secant that gives the slope of a linear section [rad]."""


@dataclass(frozen=True, kw_only=True, eq=False)
class FixedInflow:
    """Sections in a held flow at a set of azimuths.

    Parameters
    ----------
    base : ndarray (..., E)
        Inflow angle minus twist [rad]: alpha at zero pitch.
    load_map : LoadMap
        Loads per unit coefficient, (4, ..., E).
    fits : sequence of (PolarFit or None), length E
        None marks a linear section.
    value, slope : ndarray (3, ..., E)
        Fitted sections: the shift of Cl, Cd, Cm (slope zero).  Linear sections: their values
        at `mean_pitch` and their slopes in alpha [1/rad].
    mean_pitch : float
        Pitch at which linear sections have their values [rad].
    """

    base: FloatArray
    load_map: LoadMap
    fits: tuple[PolarFit | None, ...]
    value: FloatArray
    slope: FloatArray
    mean_pitch: float

    @classmethod
    def build(
        cls,
        base: FloatArray,
        load_map: LoadMap,
        fits: tuple[PolarFit | None, ...],
        polars: SectionPolars,
        mean_pitch: float | None,
    ) -> FixedInflow:
        """Anchor the fits at `mean_pitch`; without one all sections must be fitted."""
        value = np.zeros((3, *base.shape))
        slope = np.zeros((3, *base.shape))
        if mean_pitch is not None:
            alpha = base - mean_pitch
            table = np.stack(polars.coefficients(alpha))
            above = np.stack(polars.coefficients(alpha + TANGENT))
            below = np.stack(polars.coefficients(alpha - TANGENT))
            for e, fit in enumerate(fits):
                if fit is None:
                    value[..., e] = table[..., e]
                    slope[..., e] = (above[..., e] - below[..., e]) / (2 * TANGENT)
                else:
                    value[..., e] = table[..., e] - np.stack(fit.coefficients(alpha[..., e]))
        return cls(
            base=base,
            load_map=load_map,
            fits=fits,
            value=value,
            slope=slope,
            mean_pitch=0.0 if mean_pitch is None else mean_pitch,
        )

    def coefficients(self, pitch: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Cl, Cd, Cm (..., E) at pitches (...) [rad]."""
        alpha = self.base - pitch[..., None]
        shift = alpha - (self.base - self.mean_pitch)
        result = self.value + self.slope * shift
        for e, fit in enumerate(self.fits):
            if fit is not None:
                result[..., e] += np.stack(fit.coefficients(alpha[..., e]))
        return result[0], result[1], result[2]

    def loads(self, pitch: FloatArray) -> FloatArray:
        """Torque, bending, radial, thrust (4, ...) at pitches (...) [rad]."""
        return self.load_map.apply(*self.coefficients(pitch))

    def limits(self, restricting: NDArray[np.bool_]) -> tuple[FloatArray, FloatArray]:
        """Pitch interval (...) that keeps the `restricting` (E,) sections in their fits [rad]."""
        low = np.full(self.base.shape[:-1], -np.inf)
        high = np.full(self.base.shape[:-1], np.inf)
        for e, fit in enumerate(self.fits):
            if fit is not None and restricting[e]:
                low = np.maximum(low, self.base[..., e] - fit.limits[1])
                high = np.minimum(high, self.base[..., e] - fit.limits[0])
        return low, high

    def breakpoints(self, low: FloatArray, high: FloatArray) -> tuple[FloatArray, FloatArray]:
        """All breakpoints between `low` and `high` (N,): pitch (N, K) and loads (4, N, K)."""
        parts = (self.load_map.lift, self.load_map.drag, self.load_map.moment)
        slope = np.zeros((4, low.size))
        for part, rate in zip(parts, self.slope, strict=True):
            slope -= (part * rate).sum(axis=-1)
        knots, changes = [np.empty((low.size, 0))], [np.empty((4, low.size, 0))]
        for e, fit in enumerate(self.fits):
            if fit is None:
                continue
            # pitch grows as alpha falls: far below all knots the last segment holds
            slope -= sum(part[..., e] * p[-1] for part, p in zip(parts, fit.pieces, strict=True))
            knots.append(self.base[:, e, None] - fit.alpha[1:-1])
            bends = np.diff(fit.pieces, axis=1)
            changes.append(
                np.asarray(
                    sum(part[..., e, None] * b for part, b in zip(parts, bends, strict=True))
                )
            )
        points, values = accumulate(
            self.loads(low),
            slope,
            np.concatenate(knots, axis=1),
            np.concatenate(changes, axis=2),
            low,
            high,
        )
        return pad_rows(points, values, thin(points))
