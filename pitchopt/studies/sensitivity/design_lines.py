"""Loads of a frozen profile in another wind, on the lines that it stands on.

The curves of a station are made of lines between breakpoints, and in another wind the breakpoints
move.  A profile of an optimum often stands on them.  Evaluated on the moved curves, a frozen pitch
falls off its breakpoint to one side or the other, and what it loses there is no property of the
optimum.  So the lines themselves are re-evaluated, those below and those above the profile, and
weighted as the optimum weights them (theta of :mod:`pitchopt.studies.sensitivity.stationary`):

    load_ln(c) = (1 - theta_n) below_ln(beta*_n; c) + theta_n above_ln(beta*_n; c).

Which line that is: with held flow (induction ``none`` and ``frozen``) breakpoints are knots of the
sections' polars, so that every section keeps its piece between two knots, and one that stands on a
knot the two that meet there.  With ``equilibrium`` breakpoints
are the pitches at which the curves were sampled, and stay where they are.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from pitchopt.checks import FloatArray

if TYPE_CHECKING:
    from pitchopt.aero.curves import BladeCurves
    from pitchopt.aero.fixed_inflow import FixedInflow
    from pitchopt.aero.static_rotor import StaticRotor
    from pitchopt.studies.sensitivity.stationary import Stationary

__all__ = ["FrozenLines", "Lines"]

_RATE_STEP = 0.02  # [rad/s], for the central difference in pitch rate, as the curves have it


class Lines(NamedTuple):
    """Lines of the five loads of a blade at every station.

    Attributes
    ----------
    value : ndarray (5, N)
        At the profile, without pitch rate.
    slope : ndarray (5, N)
        Per pitch [1/rad].
    rates : ndarray (5, N)
        Per unit of d beta / d psi.
    """

    value: FloatArray
    slope: FloatArray
    rates: FloatArray


@dataclass(frozen=True, kw_only=True, eq=False)
class FrozenLines:
    """The lines that a profile stands on, to be evaluated with other rotor models.

    Attributes
    ----------
    curves : BladeCurves
        On which the profile was found.
    profile : ndarray (N,)
        beta* [rad].
    point : Stationary
        Which gives the weights.
    pitch : float or None
        Pitch at which the wake is frozen or around which curves were sampled [rad]; held.
    rotor : StaticRotor or None
        The model behind the curves; None for a table.
    """

    curves: BladeCurves
    profile: FloatArray
    point: Stationary
    pitch: float | None
    rotor: StaticRotor | None

    def own(self) -> Lines:
        """The lines of the curves themselves."""
        value = self.curves.contributions(self.profile)
        theta = self.point.theta
        slope = (1 - theta) * self.point.left + theta * self.point.right
        return Lines(value=value, slope=slope, rates=self.curves.rates)

    def of(self, rotor: StaticRotor) -> Lines:
        """The same lines with another rotor model."""
        if rotor.induction == "equilibrium":
            value, slope = self._sampled(rotor)
        else:
            positions = self.curves.positions
            assert self.rotor is not None
            before = self.rotor.fixed_inflow(positions, self.pitch)
            after = rotor.fixed_inflow(positions, self.pitch)
            theta, reach = self.point.theta, self.point.reach
            below, above = self._side(before, after, -reach), self._side(before, after, reach)
            value, slope = (
                (1 - theta) * low + theta * high for low, high in zip(below, above, strict=True)
            )
        value, slope, rates = (
            _five(parts, self.curves.azimuth) for parts in (value, slope, self._rates(rotor))
        )
        return Lines(value=value, slope=slope, rates=rates)

    # ---- held flow ---------------------------------------------------------------------------

    def _side(
        self, before: FixedInflow, after: FixedInflow, reach: float
    ) -> tuple[FloatArray, FloatArray]:
        """Torque, bending, radial, thrust (4, N) and slopes on the pieces at pitch + reach."""
        value = np.stack(after.coefficients(self.profile))
        slope = -after.slope
        for e, (old, new) in enumerate(zip(before.fits, after.fits, strict=True)):
            if new is None:
                continue
            base, fit = before.base[:, e], old
            if fit is None or fit.alpha.size != new.alpha.size:  # it has another kind now
                base, fit = after.base[:, e], new
            alpha = base - (self.profile + reach)
            piece = np.clip(np.searchsorted(fit.alpha, alpha) - 1, 0, fit.alpha.size - 2)
            moved = after.base[:, e] - self.profile - new.alpha[piece]
            for k, knots in enumerate((new.cl, new.cd, new.cm)):
                value[k, :, e] = knots[piece] + new.pieces[k, piece] * moved + after.value[k, :, e]
                slope[k, :, e] = -new.pieces[k, piece]
        return after.load_map.apply(*value), after.load_map.apply(*slope)

    # ---- sampled curves ----------------------------------------------------------------------

    def _sampled(self, rotor: StaticRotor) -> tuple[FloatArray, FloatArray]:
        """The same on the lines between the pitches at which the curves were sampled."""
        curves, rows, theta = self.curves, np.arange(self.profile.size), self.point.theta
        below = curves.segment(self.profile - self.point.reach)
        above = curves.segment(self.profile + self.point.reach)
        pitch = curves.beta[rows, np.stack([below, below + 1, above, above + 1])]
        found = np.stack(rotor.blade_loads(curves.azimuth, pitch, mean_pitch=self.pitch))
        slopes = (found[:, 1::2] - found[:, ::2]) / (pitch[1::2] - pitch[::2])
        values = found[:, ::2] + slopes * (self.profile - pitch[::2])
        return (
            (1 - theta) * values[:, 0] + theta * values[:, 1],
            (1 - theta) * slopes[:, 0] + theta * slopes[:, 1],
        )

    # ---- both --------------------------------------------------------------------------------

    def _rates(self, rotor: StaticRotor) -> FloatArray:
        """Torque, bending, radial, thrust (4, N) per unit of d beta / d psi."""
        curves = self.curves
        if not rotor.pitch_rate_terms:
            return np.zeros((4, self.profile.size))
        if rotor.induction != "none" and self.pitch is not None:
            at = np.full(self.profile.size, self.pitch)
        else:
            low, high = rotor.pitch_limits(curves.azimuth, self.pitch)
            at = 0.5 * (low + high)
        up, down = (
            np.stack(
                rotor.blade_loads(curves.azimuth, at, sign * _RATE_STEP, mean_pitch=self.pitch)
            )
            for sign in (1.0, -1.0)
        )
        return np.asarray((up - down) * (rotor.rotor_speed / (2 * _RATE_STEP)))


def _five(parts: FloatArray, azimuth: FloatArray) -> FloatArray:
    """Torque, tilt, yaw, thrust, bending of torque, bending, radial, thrust."""
    torque, bending, radial, thrust = parts
    c, s = np.cos(azimuth), np.sin(azimuth)
    return np.stack([torque, bending * c - radial * s, bending * s + radial * c, thrust, bending])
