"""Pitch limits in momentum balance: where no outboard section stalls.

The induced velocity answers to pitch, so the angle of attack is not known in closed form and is
sampled over pitch; `pitchopt.aero.stall` finds the intervals.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from pitchopt.aero.section_flow import SectionFlow
from pitchopt.aero.stall import StallLimits, attached_intervals, longest_interval
from pitchopt.checks import FloatArray

__all__ = ["attached_pitch", "balanced_limits"]

_REACH = float(np.deg2rad(25.0))  # limits are looked for this far around the mean pitch


def balanced_limits(
    sections: SectionFlow,
    psi: FloatArray,
    mean: float,
    pitch_range: tuple[float, float],
    limits: StallLimits,
) -> tuple[FloatArray, FloatArray]:
    """Pitch interval around `mean` [rad] in which no section that `limits` names stalls.

    Returns
    -------
    low, high : ndarray (N,)
        At azimuths `psi` (N,) [rad], within `pitch_range`.
    """
    grid = np.clip(mean + np.linspace(-_REACH, _REACH, 41), *pitch_range)
    grid = np.unique(np.append(grid, mean))
    alpha = np.empty((psi.size, grid.size, sections.rotor.blade.span.size))
    for rows in sections.chunks(psi.size, grid.size):
        beta = np.broadcast_to(grid, (psi[rows].size, grid.size))
        reference = np.full((psi[rows].size, 1), mean)
        flow = sections.balanced(psi[rows, None], beta, np.zeros(()), reference)
        alpha[rows] = flow.phi - sections.rotor.blade.twist - beta[..., None]
    at = int(np.searchsorted(grid, mean))
    return attached_intervals(grid, alpha, at, limits)


def attached_pitch(
    sections: SectionFlow,
    psi: FloatArray,
    pitch_range: tuple[float, float],
    limits: StallLimits,
) -> tuple[float, float]:
    """Longest interval of constant pitches [rad] that stall at none of the azimuths (N,) [rad].

    Raises
    ------
    InputError
        If every constant pitch stalls somewhere.
    """

    def attached(pitch: FloatArray) -> NDArray[np.bool_]:
        beta = np.broadcast_to(pitch, (psi.size, pitch.size))
        flow = sections.balanced(psi[:, None], beta, np.zeros(()), beta)
        alpha = (flow.phi - sections.rotor.blade.twist - beta[..., None])[..., limits.sections]
        inside = (alpha <= limits.above) & (alpha >= limits.below)
        return np.asarray(inside.all(axis=(0, 2)))

    return longest_interval(attached, *pitch_range)
