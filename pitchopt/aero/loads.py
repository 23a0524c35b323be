"""Blade loads as linear functions of the section coefficients.

With phi the inflow angle (zero in the rotor plane) and q = rho W^2 / 2 the forces per length in
the coned frame are

    f_x = q c (Cl cos phi + Cd sin phi),     f_y = -q c (Cl sin phi - Cd cos phi),

and the moment per length about z_c is q c^2 Cm.  Integrated along the span (weights of
`Blade.integration`) and turned into the rotor frame they give one blade's

    torque   = cos(cone) M_x - sin(cone) M_z      about the shaft,
    bending  = M_y                                about y_b,
    radial   = sin(cone) M_x + cos(cone) M_z      about e_r,
    thrust   = cos(cone) F_x                      along the shaft,

all about the rotor apex, with M = p x F and M_x = -z f_y, M_y = z f_x, M_z = x f_y - y f_x + m.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from pitchopt.aero.rotor import Sections
from pitchopt.checks import FloatArray

__all__ = ["BladeLoads", "LoadMap", "load_map"]


class BladeLoads(NamedTuple):
    """Loads of one blade, each of the shape of azimuth and pitch.

    Attributes
    ----------
    torque, bending, radial : ndarray (...)
        Moments about the shaft, y_b and e_r at the rotor apex [N m].
    thrust : ndarray (...)
        Force along the shaft [N].
    """

    torque: FloatArray
    bending: FloatArray
    radial: FloatArray
    thrust: FloatArray


class LoadMap(NamedTuple):
    """Loads per unit of Cl, Cd and Cm of each section, (4, ..., E).

    The first axis is torque, bending, radial, thrust.
    """

    lift: FloatArray
    drag: FloatArray
    moment: FloatArray

    def apply(self, cl: FloatArray, cd: FloatArray, cm: FloatArray) -> FloatArray:
        """Loads (4, ...) for coefficients (..., E)."""
        terms = self.lift * cl
        terms += self.drag * cd
        terms += self.moment * cm
        return np.asarray(terms.sum(axis=-1))


def load_map(
    sections: Sections,
    chord: FloatArray,
    cone: float,
    phi: FloatArray,
    pressure: FloatArray,
    *,
    radial_moment: bool = True,
) -> LoadMap:
    """Load map at inflow angles `phi` (..., E) [rad] and dynamic pressures (..., E) [Pa]."""
    qc = pressure * chord
    cos_phi, sin_phi = np.cos(phi), np.sin(phi)
    cc, sc = np.cos(cone), np.sin(cone)

    def project(force_x: FloatArray, force_y: FloatArray) -> FloatArray:
        moment_x = -sections.lever_z * force_y
        moment_z = sections.lever_x * force_y - sections.lever_y * force_x
        out = np.empty((4, *force_x.shape))
        out[0] = cc * moment_x - sc * moment_z
        out[1] = sections.lever_z * force_x
        out[2] = (sc * moment_x + cc * moment_z) if radial_moment else 0.0
        out[3] = cc * sections.width * force_x
        return out

    twisting = qc * chord * sections.width
    moment = np.zeros((4, *twisting.shape))
    moment[0] = -sc * twisting
    if radial_moment:
        moment[2] = cc * twisting
    return LoadMap(
        lift=project(qc * cos_phi, -qc * sin_phi),
        drag=project(qc * sin_phi, qc * cos_phi),
        moment=moment,
    )
