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
from typing import TYPE_CHECKING

import numpy as np

from pitchopt.checks import FloatArray
from pitchopt.studies.sensitivity.stationary import REACH

if TYPE_CHECKING:
    from pitchopt.aero.curves import BladeCurves
    from pitchopt.aero.fixed_inflow import FixedInflow
    from pitchopt.aero.static_rotor import StaticRotor
    from pitchopt.studies.sensitivity.stationary import Stationary

__all__ = ["FrozenLines"]

_RATE_STEP = 0.02  # [rad/s], for the central difference in pitch rate, as the curves have it


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
    rotor : StaticRotor
        The model behind the curves.
    """

    curves: BladeCurves
    profile: FloatArray
    point: Stationary
    pitch: float | None
    rotor: StaticRotor

    def loads(self, rotor: StaticRotor) -> FloatArray:
        """Five loads of the blade at each station with another rotor model, rate terms too.

        Returns
        -------
        ndarray (5, N)
        """
        if rotor.induction == "equilibrium":
            parts = self._sampled(rotor)
        else:
            positions = self.curves.positions
            parts = self._pieces(
                self.rotor.fixed_inflow(positions, self.pitch),
                rotor.fixed_inflow(positions, self.pitch),
            )
        total = parts + self._rates(rotor) * self.curves.profile_rate(self.profile)
        return _five(total, self.curves.azimuth)

    # ---- held flow ---------------------------------------------------------------------------

    def _pieces(self, before: FixedInflow, after: FixedInflow) -> FloatArray:
        """Torque, bending, radial, thrust (4, N) on the pieces that the profile stands on."""
        theta = self.point.theta
        below, above = self._side(before, after, -REACH), self._side(before, after, REACH)
        return (1 - theta) * below + theta * above

    def _side(self, before: FixedInflow, after: FixedInflow, reach: float) -> FloatArray:
        coefficients = np.stack(after.coefficients(self.profile))
        for e, (old, new) in enumerate(zip(before.fits, after.fits, strict=True)):
            if old is None or new is None or old.alpha.size != new.alpha.size:
                continue
            alpha = before.base[:, e] - (self.profile + reach)
            piece = np.clip(np.searchsorted(old.alpha, alpha) - 1, 0, old.alpha.size - 2)
            moved = after.base[:, e] - self.profile - new.alpha[piece]
            for k, values in enumerate((new.cl, new.cd, new.cm)):
                line = values[piece] + new.pieces[k, piece] * moved
                coefficients[k, :, e] = line + after.value[k, :, e]
        return after.load_map.apply(*coefficients)

    # ---- sampled curves ----------------------------------------------------------------------

    def _sampled(self, rotor: StaticRotor) -> FloatArray:
        """The same on the lines between the pitches at which the curves were sampled."""
        curves, rows, theta = self.curves, np.arange(self.profile.size), self.point.theta
        below = curves.segment(self.profile - REACH)
        above = curves.segment(self.profile + REACH)
        ends = np.stack([below, below + 1, above, above + 1])
        pitch = curves.beta[rows, ends]
        found = np.stack(rotor.blade_loads(curves.azimuth, pitch, mean_pitch=self.pitch))
        share = (self.profile - pitch[::2]) / (pitch[1::2] - pitch[::2])
        lines = (1 - share) * found[:, ::2] + share * found[:, 1::2]
        return np.asarray((1 - theta) * lines[:, 0] + theta * lines[:, 1])

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
            np.stack(rotor.blade_loads(curves.azimuth, at, sign * _RATE_STEP, mean_pitch=self.pitch))
            for sign in (1.0, -1.0)
        )
        return np.asarray((up - down) * (rotor.rotor_speed / (2 * _RATE_STEP)))


def _five(parts: FloatArray, azimuth: FloatArray) -> FloatArray:
    """Torque, tilt, yaw, thrust, bending of torque, bending, radial, thrust."""
    torque, bending, radial, thrust = parts
    c, s = np.cos(azimuth), np.sin(azimuth)
    return np.stack(
        [torque, bending * c - radial * s, bending * s + radial * c, thrust, bending]
    )
