"""Turbulence of IEC 61400-1: classes, Kaimal spectra, exponential coherence.

Standard deviation of the normal turbulence model (NTM), with I_ref of the class,

    sigma_1 = I_ref (0.75 U + 5.6 m/s),       sigma = (1, 0.8, 0.5) sigma_1   of (u, v, w);

one-sided spectrum of component k over the frequency f, and its integral from 0 to f,

    S_k(f) = sigma_k^2 (4 L_k / U) / (1 + 6 f L_k / U)^(5/3),
    int_0^f S_k = sigma_k^2 [1 - (1 + 6 f L_k / U)^(-2/3)],

    L = (8.1, 2.7, 0.66) Lambda_1,            Lambda_1 = 0.7 min(hub height, 60 m);

coherence of one component at two points a distance d apart across the wind, the cross spectrum
over S_k,

    Coh(f, d) = exp(-12 sqrt((f d / U)^2 + (0.12 d / L_c)^2)),      L_c = 8.1 Lambda_1.

Different components are not correlated. The standard states the coherence for u alone.

References: IEC 61400-1:2005 (edition 3) and 2019 (edition 4), section 6.3 and annexes B.2, C.3;
class A+ is of edition 4.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from windfield._checks import FloatArray, as_array, as_number
from windfield.errors import WindFieldError

__all__ = [
    "CLASSES",
    "band_variance",
    "coherence",
    "iec_sigma",
    "kaimal_spectrum",
    "length_scales",
]

CLASSES = {"A+": 0.18, "A": 0.16, "B": 0.14, "C": 0.12}  # I_ref [-]
SIGMA_RATIOS = np.array([1.0, 0.8, 0.5])
LENGTH_RATIOS = np.array([8.1, 2.7, 0.66])
DECAY = 12.0
OFFSET = 0.12


def iec_sigma(turbulence: str | float, mean_speed: float) -> float:
    """Standard deviation sigma_1 of the wind along the mean [m/s].

    Parameters
    ----------
    turbulence : {"A+", "A", "B", "C"} or float
        Class, for the normal turbulence model; or the intensity sigma_1 / U [-].
    mean_speed : float
        U at hub height [m/s], positive.

    Raises
    ------
    WindFieldError
        For another class or a value out of range.
    """
    speed = as_number("mean_speed", mean_speed, "m/s", above=0.0)
    if isinstance(turbulence, str):
        if turbulence not in CLASSES:
            raise WindFieldError(
                f"turbulence: got {turbulence!r}; must be one of {', '.join(CLASSES)} or an "
                "intensity"
            )
        return CLASSES[turbulence] * (0.75 * speed + 5.6)
    return as_number("turbulence", turbulence, above=0.0) * speed


def length_scales(hub_height: float) -> FloatArray:
    """Kaimal length scales L of u, v, w [m], shape (3,)."""
    return np.asarray(
        LENGTH_RATIOS * (0.7 * min(as_number("hub_height", hub_height, "m", above=0.0), 60.0))
    )


def kaimal_spectrum(
    frequency: ArrayLike, *, sigma: float, mean_speed: float, hub_height: float
) -> FloatArray:
    """One-sided spectra of u, v, w.

    Parameters
    ----------
    frequency : array_like
        f [Hz], >= 0.
    sigma : float
        sigma_1 [m/s].
    mean_speed, hub_height : float
        [m/s], [m], positive.

    Returns
    -------
    ndarray, shape (..., 3)
        S [(m/s)^2/Hz].
    """
    scale = length_scales(hub_height) / as_number("mean_speed", mean_speed, "m/s", above=0.0)
    variance = (SIGMA_RATIOS * as_number("sigma", sigma, "m/s", at_least=0.0)) ** 2
    f = _frequencies(frequency)[..., None]
    return np.asarray(variance * 4.0 * scale / (1.0 + 6.0 * f * scale) ** (5.0 / 3.0))


def band_variance(
    low: ArrayLike, high: ArrayLike, *, sigma: float, mean_speed: float, hub_height: float
) -> FloatArray:
    """Variance of u, v, w between two frequencies [Hz], shape (..., 3) [(m/s)^2]."""
    scale = length_scales(hub_height) / as_number("mean_speed", mean_speed, "m/s", above=0.0)
    variance = (SIGMA_RATIOS * as_number("sigma", sigma, "m/s", at_least=0.0)) ** 2
    above = [(1.0 + 6.0 * _frequencies(f)[..., None] * scale) ** (-2.0 / 3.0) for f in (low, high)]
    return np.asarray(variance * (above[0] - above[1]))


def coherence(
    frequency: ArrayLike, distance: ArrayLike, *, mean_speed: float, hub_height: float
) -> FloatArray:
    """Coherence of one component at points `distance` [m] apart at `frequency` [Hz] [-].

    The two broadcast together.
    """
    speed = as_number("mean_speed", mean_speed, "m/s", above=0.0)
    longest = length_scales(hub_height)[0]
    rate = DECAY * np.hypot(_frequencies(frequency) / speed, OFFSET / longest)
    return np.asarray(np.exp(-rate * as_array("distance", distance)))


def _frequencies(value: ArrayLike) -> FloatArray:
    frequency = as_array("frequency", value)
    if frequency.size and frequency.min() < 0.0:
        raise WindFieldError(f"frequency: got {frequency.min():g}; must be >= 0 [Hz]")
    return frequency
