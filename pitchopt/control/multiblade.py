"""Multiblade (Coleman) transform of three blades at n times the rotor speed.

With psi_b = psi + 2 pi b / 3, b = 0, 1, 2, the blade up at psi = 0 and the sums of the paper,

    tilt_n = 2/3 sum_b M_b cos(n psi_b),      yaw_n = 2/3 sum_b M_b sin(n psi_b),

for out-of-plane moments M_b positive downwind: tilt_1 is positive when the upper half is pushed
harder, yaw_1 when the right half (looking downwind) is.  The inverse, with an azimuth offset,

    beta_b = tilt_n cos(n (psi_b + offset)) + yaw_n sin(n (psi_b + offset)),

inverts the forward transform on signals at n per turn if the offset is zero and n is no multiple
of three; at multiples of three all blades move alike, and the pair is not a transform.  A
positive offset leads.  Because the offset stands within n (psi + offset), it has the period
2 pi / n, and half of that turns the sign.

Source: S. Mulders, A. Pamososuryo, J.-W. van Wingerden, "Efficient tuning of Individual Pitch
Control", 2020, equations (2) and (3).
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike

from pitchopt.checks import FloatArray, whole_number
from pitchopt.errors import InputError

__all__ = ["from_fixed_frame", "to_fixed_frame"]

_BLADES = 2.0 * math.pi / 3.0 * np.arange(3)


def harmonic(order: object) -> int:
    """`order` as a harmonic that the transform of three blades has.

    Raises
    ------
    InputError
        If it is not a whole number of at least one, or a multiple of three.
    """
    n = whole_number("order", order, at_least=1)
    if n % 3 == 0:
        raise InputError(
            f"order: got {n}, expected no multiple of three: three blades move alike there"
        )
    return n


def to_fixed_frame(values: ArrayLike, azimuth: ArrayLike, order: int = 1) -> FloatArray:
    """Tilt and yaw part (..., 2) of the three blades' values (..., 3).

    Parameters
    ----------
    values : array_like (..., 3)
        Of the blades, in any unit.
    azimuth : array_like (...)
        Of blade 1 [rad].
    order : int
        n.

    Raises
    ------
    InputError
        If the last axis is not three long, or for a harmonic that three blades do not have.
    """
    n = harmonic(order)
    v = np.asarray(values, dtype=np.float64)
    if v.ndim == 0 or v.shape[-1] != 3:
        raise InputError(f"values: got shape {v.shape}, expected (..., 3)")
    angle = n * (np.asarray(azimuth, dtype=np.float64)[..., None] + _BLADES)
    tilt = np.sum(v * np.cos(angle), axis=-1)
    yaw = np.sum(v * np.sin(angle), axis=-1)
    return 2.0 / 3.0 * np.stack(np.broadcast_arrays(tilt, yaw), axis=-1)


def from_fixed_frame(
    parts: ArrayLike, azimuth: ArrayLike, order: int = 1, offset: float = 0.0
) -> FloatArray:
    """The blades' values (..., 3) of a tilt and a yaw part (..., 2).

    Parameters
    ----------
    parts : array_like (..., 2)
        Tilt and yaw part, in any unit.
    azimuth : array_like (...)
        Of blade 1 [rad].
    order : int
        n.
    offset : float
        Azimuth offset, positive leads [rad].

    Raises
    ------
    InputError
        If the last axis is not two long, or for a harmonic that three blades do not have.
    """
    n = harmonic(order)
    part = np.asarray(parts, dtype=np.float64)
    if part.ndim == 0 or part.shape[-1] != 2:
        raise InputError(f"parts: got shape {part.shape}, expected (..., 2)")
    angle = n * (np.asarray(azimuth, dtype=np.float64)[..., None] + _BLADES + offset)
    return np.asarray(part[..., :1] * np.cos(angle) + part[..., 1:] * np.sin(angle))
