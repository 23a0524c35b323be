"""How far curves of a frozen wake are from what they stand for.

Two things part them: polars are fitted or replaced by tangents, and the offsets of the aerodynamic
centres are projected at the mean pitch.  Both are measured in the same held wake, against the
tables of the polars.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from pitchopt.aero.flow import free_flow
from pitchopt.aero.section_flow import SectionFlow
from pitchopt.checks import FloatArray

__all__ = ["FrozenErrors", "frozen_errors"]


class FrozenErrors(NamedTuple):
    """How far frozen curves are from what they stand for, as shares of the mean load.

    Each is the largest over the stations at mean pitch -/+ the window, for torque, bending and
    thrust, divided by the mean over the stations at the mean pitch.

    Attributes
    ----------
    fit : ndarray (3,)
        Fits and tangents against the tables in the same held wake.
    projection : ndarray (3,)
        Offsets of the aerodynamic centres held at the mean pitch against turning with it.
    """

    fit: FloatArray
    projection: FloatArray


def frozen_errors(
    sections: SectionFlow, psi: FloatArray, mean: float, window: float
) -> FrozenErrors:
    """Errors at stations `psi` (N,) and pitches `mean` -/+ `window` [rad]."""
    model = sections.held(psi, mean)
    zero = np.zeros(())
    held = sections.balanced(psi, np.full(psi.size, mean), zero, np.asarray(mean))
    induced = (held.induced_normal, held.induced_tangential)
    picked = [0, 1, 3]
    scale = np.abs(model.loads(np.full(psi.size, mean))[picked]).mean(axis=1)
    fit, projection = np.zeros(3), np.zeros(3)
    for sign in (-1.0, 1.0):
        pitch = np.full(psi.size, mean + sign * window)
        turned = free_flow(
            sections.rotor,
            sections.wind,
            sections.rotor_speed,
            psi,
            pitch,
            yaw=sections.yaw,
            induced=induced,
        )
        table = sections.table_loads(held, pitch)[picked]
        ours = model.loads(pitch)[picked]
        moved = sections.table_loads(turned, pitch)[picked]
        fit = np.maximum(fit, np.abs(ours - table).max(axis=1) / scale)
        projection = np.maximum(projection, np.abs(moved - table).max(axis=1) / scale)
    return FrozenErrors(fit=fit, projection=projection)
