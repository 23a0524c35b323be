"""Experiment: the perturbed passages from which a first model of the loads is estimated.

At every rotor position the pitches of the B blades have to move in B independent directions.  A
collective change and harmonics 1P .. floor(B/2)P in cosine and sine do that at all positions alike
(they are the discrete Fourier basis over the blades) and are smooth enough for the actuators.
Each is applied upwards and downwards; the unperturbed profile comes first, often enough to show
the noise and to fill the last rotation.
"""

from __future__ import annotations

import numpy as np

from ilc._checks import FloatArray
from ilc.layout import Layout

__all__ = ["perturbations"]

_LEAST_REPEATS = 2


def perturbations(layout: Layout, amplitude: float) -> FloatArray:
    """Offsets from the starting profile, one row a slot of ``layout.dwell`` passages.

    Parameters
    ----------
    layout : Layout
    amplitude : float
        Size of the perturbations [rad].

    Returns
    -------
    ndarray (E, V)
        The first rows, at least two, are zero.  E x dwell is a whole number of rotations.
    """
    psi = layout.azimuth
    waves = [np.ones(psi.size)]
    for order in range(1, layout.blades // 2 + 1):
        waves += [np.cos(order * psi), np.sin(order * psi)]
    signed = [sign * amplitude * wave for wave in waves for sign in (1.0, -1.0)]
    slots = layout.blades // layout.dwell
    repeats = _LEAST_REPEATS + (-(len(signed) + _LEAST_REPEATS)) % slots
    return np.array([np.zeros(psi.size)] * repeats + signed)
