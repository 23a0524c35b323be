"""Bending moments of a tower as counted cycles, and the damage they do to any section.

Loads are frozen: cycles of the bending moment, counted once for a simulated design, are laid on
the sections of another,

    S = gamma M / W (t / t_0)^k,       D = sum_i n_i / N(S_i) <= 1,

with W the section modulus and the last factor of DNV-RP-C203 and EN 1993-1-9 for walls thicker
than t_0.  Moments are taken about several axes across the tower, M_a = M_fa cos a + M_ss sin a;
the largest damage over the axes counts.  Mean stresses and the weight's axial force, which hardly
changes, do no damage to welds.

Cycles go into bins 1 % wide, which changes a damage of slope m by m^2 1e-4 / 24, less than 2e-4.
Where the wall thickness passes t_0 the exponent's onset is rounded over 2 % of the thickness, on
the safe side by at most 0.3 % of the stress, so that damage has a derivative.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from pitchopt.checks import FloatArray, finite_array, finite_number
from pitchopt.errors import InputError
from pitchopt.fatigue import SNCurve
from pitchopt.studies.tower.design import Joints

__all__ = ["BIN_WIDTH", "MOMENT_BINS", "FatigueLoads", "JointDamage", "Weld", "section_modulus"]

BIN_WIDTH = 0.01
MOMENT_BINS = np.exp(np.arange(np.log(1e3), np.log(1e9), BIN_WIDTH))  # centres [N m]
MOMENT_BINS.setflags(write=False)
_ONSET = 0.02
_DIFFERENCE = 1e-3  # of the logarithm of the stress
_CURVE_D = SNCurve(
    slope=3.0,
    reference_range=52.63e6,
    reference_cycles=1e7,
    second_slope=5.0,
    knee_cycles=1e7,
)


def section_modulus(diameter: FloatArray, thickness: FloatArray) -> FloatArray:
    """W [m^3] of circular walls with these middle diameters and thicknesses [m]."""
    d, t = diameter, thickness
    return np.asarray(np.pi / 4.0 * d * t * (d**2 + t**2) / (d + t))


@dataclass(frozen=True, kw_only=True)
class Weld:
    """What a circumferential weld of the tower endures.

    The default is curve D of DNV-RP-C203 in air (detail category 90 of EN 1993-1-9), for stress
    ranges at 97.7 % survival, with the partial factors 1.1 for welds and 1.15 for a component of
    class 2 of IEC 61400-1, section 7.6.3.

    Parameters
    ----------
    curve : SNCurve
        Of stress ranges [Pa].
    safety_factor : float
        On the stress [-].
    reference_thickness : float
        t_0 [m].
    thickness_exponent : float
        k [-].

    Raises
    ------
    InputError
        If a number is out of range.
    """

    curve: SNCurve = _CURVE_D
    safety_factor: float = 1.1 * 1.15
    reference_thickness: float = 0.025
    thickness_exponent: float = 0.2

    def __post_init__(self) -> None:
        finite_number("safety_factor", self.safety_factor, above=0.0)
        finite_number("reference_thickness", self.reference_thickness, above=0.0)
        finite_number("thickness_exponent", self.thickness_exponent, at_least=0.0)

    def stress_per_moment(
        self, diameter: FloatArray, thickness: FloatArray
    ) -> tuple[FloatArray, FloatArray, FloatArray]:
        """gamma / W (t / t_0)^k [1/m^3], and its logarithm's slopes by ln d and ln t."""
        d, t = diameter, thickness
        k = self.thickness_exponent
        beyond = np.log(t / self.reference_thickness) / _ONSET
        factor = np.exp(k * _ONSET * np.logaddexp(0.0, beyond))
        onset = 0.5 * (1.0 + np.tanh(0.5 * beyond))
        square = d**2 + t**2
        by_diameter = -(1.0 + 2.0 * d**2 / square - d / (d + t))
        by_thickness = -(1.0 + 2.0 * t**2 / square - t / (d + t)) + k * onset
        return self.safety_factor * factor / section_modulus(d, t), by_diameter, by_thickness


@dataclass(frozen=True)
class JointDamage:
    """Damage at joints, all (P,).

    Attributes
    ----------
    value : lifetime damage [-].
    by_diameter, by_thickness : slopes of its logarithm by those of the middle diameter and the
        wall thickness.
    """

    value: FloatArray
    by_diameter: FloatArray
    by_thickness: FloatArray


@dataclass(frozen=True, kw_only=True, eq=False)
class FatigueLoads:
    """Cycles of the bending moment over a lifetime.

    Parameters
    ----------
    cycles : array_like (S, A, B)
        Cycles at each station about each axis in the bins of `MOMENT_BINS`.
    weld : Weld

    Raises
    ------
    InputError
        If the shape is another or a number is negative.
    """

    cycles: FloatArray
    weld: Weld = Weld()

    def __post_init__(self) -> None:
        shape = np.shape(self.cycles)
        if len(shape) != 3 or shape[2] != MOMENT_BINS.size or 0 in shape:
            raise InputError(
                f"cycles: got shape {shape}, expected (stations, axes, {MOMENT_BINS.size})"
            )
        cycles = finite_array("cycles", self.cycles, shape=shape)
        if cycles.min() < 0.0:
            raise InputError(f"cycles: got {cycles.min()}, expected numbers of at least 0")
        object.__setattr__(self, "cycles", cycles)

    @property
    def stations(self) -> int:
        """Number of stations S."""
        return int(self.cycles.shape[0])

    def damage(self, joints: Joints, diameter: FloatArray, thickness: FloatArray) -> JointDamage:
        """Damage at joints with these sections.

        Parameters
        ----------
        joints : Joints (P,)
        diameter, thickness : ndarray (P,)
            Of the wall's middle, and of the wall [m].
        """
        stress, by_diameter, by_thickness = self.weld.stress_per_moment(diameter, thickness)
        low, high = 1.0 - 0.5 * _DIFFERENCE, 1.0 + 0.5 * _DIFFERENCE
        value, below, above = (self._over_axes(joints, stress * f) for f in (1.0, low, high))
        tiny = np.finfo(np.float64).tiny
        slope = np.log(np.maximum(above, tiny) / np.maximum(below, tiny)) / np.log(high / low)
        return JointDamage(value, slope * by_diameter, slope * by_thickness)

    def _over_axes(self, joints: Joints, stress: FloatArray) -> FloatArray:
        rate = 1.0 / self.weld.curve.life(stress[:, None] * MOMENT_BINS)  # (P, B)
        return np.asarray(np.einsum("pab,pb->pa", self.cycles[joints.station], rate).max(axis=1))
