"""Energy of a year from a power curve and a distribution of wind speeds.

With the mean power P(v) between the wind speeds of cut-in and cut-out and none outside, and
wind speeds of a Weibull distribution of shape k and mean V,

    E = T a (1 - l) int P(v) f(v) dv,
    f(v) = k / A (v / A)^(k - 1) exp(-(v / A)^k),       A = V / Gamma(1 + 1 / k),

T the 8760 hours of a year, a the availability and l the losses. P is known at a few speeds.
Between them it is a monotone cubic (PCHIP), which rises to rated power without going past it;
the integral over it is by Gauss-Legendre, to rounding. `annual_energy_by_bins` is the plain sum
with P held over bins, the outer of which reach half a step past the first and the last speed.

Wind grows with height as (h / h_ref)^alpha, alpha = 0.2 in the normal wind profile of
IEC 61400-1, so a higher hub sees more of it.

References: IEC 61400-1:2019, section 6.3; F. N. Fritsch, R. E. Carlson, Monotone piecewise
cubic interpolation, SIAM J. Numer. Anal. 17, 1980.
"""

from __future__ import annotations

import itertools
import math
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from pitchopt.checks import FloatArray, finite_array, finite_number
from pitchopt.errors import InputError
from pitchopt.fatigue.lifetime import bin_edges, weibull_weights

if TYPE_CHECKING:
    from scipy.interpolate import PchipInterpolator

__all__ = ["YEAR", "annual_energy", "annual_energy_by_bins", "mean_wind_at", "positive_array"]

YEAR = 8760.0 * 3600.0  # [s]
_NODES = 16  # of Gauss-Legendre on a piece
_PIECE = 0.25  # longest piece of the integral in scales of the distribution
_MOST_PIECES = 1000  # between two speeds; longer ones lie where there is no wind


def positive_array(name: str, value: ArrayLike) -> FloatArray:
    """Read-only float copy of `value`, of any shape, with finite numbers above zero.

    Raises
    ------
    InputError
        If `value` is anything else.
    """
    try:
        shape = np.shape(value)
    except ValueError as error:
        raise InputError(f"{name}: got lists of unequal lengths, expected numbers") from error
    array = finite_array(name, value, shape=shape)
    if array.size and array.min() <= 0.0:
        raise InputError(f"{name}: got {array.min()}, expected numbers above 0")
    return array


def mean_wind_at(
    height: ArrayLike,
    *,
    reference_height: float,
    reference_speed: float,
    exponent: float = 0.2,
) -> FloatArray:
    """Mean wind speed [m/s] at heights (...) by the power law.

    Parameters
    ----------
    height : (...) array_like
        Above ground [m], positive.
    reference_height : float
        Height [m] of the known speed.
    reference_speed : float
        Mean wind speed there [m/s], positive.
    exponent : float
        alpha [-].

    Raises
    ------
    InputError
        If a number is out of range.
    """
    h = positive_array("height", height)
    h_ref = finite_number("reference_height", reference_height, above=0.0)
    speed = finite_number("reference_speed", reference_speed, above=0.0)
    alpha = finite_number("exponent", exponent, at_least=0.0, at_most=1.0)
    return np.asarray(speed * (h / h_ref) ** alpha)


def annual_energy(
    speeds: ArrayLike,
    power: ArrayLike,
    mean_wind_speed: ArrayLike,
    *,
    shape: float = 2.0,
    availability: float = 1.0,
    losses: float = 0.0,
) -> FloatArray:
    """Energy of a year [J] for mean wind speeds (...), by the interpolated power curve.

    Parameters
    ----------
    speeds : (n,) array_like
        Wind speeds at the hub [m/s], increasing, at least two. The first is cut-in, the last
        cut-out.
    power : (n,) array_like
        Mean electrical power at them [W].
    mean_wind_speed : (...) array_like
        V at the hub [m/s], positive.
    shape : float
        k, at least 1 [-]; 2 is Rayleigh's distribution.
    availability : float
        a, share of time in which the turbine is ready, 0 to 1 [-].
    losses : float
        l, share of energy lost to wakes, soiling and cables, 0 to 1 [-].

    Raises
    ------
    InputError
        If a number is out of range or the arrays do not fit.
    """
    v, p = _curve(speeds, power)
    mean = positive_array("mean_wind_speed", mean_wind_speed)
    k = finite_number("shape", shape, at_least=1.0)
    share = _delivered(availability, losses)
    from scipy.interpolate import PchipInterpolator

    curve = PchipInterpolator(v, p)
    scales = np.atleast_1d(mean).ravel() / math.gamma(1.0 + 1.0 / k)
    energy = np.array([YEAR * share * _mean_power(curve, v, k, float(a)) for a in scales])
    return energy.reshape(mean.shape)


def annual_energy_by_bins(
    speeds: ArrayLike,
    power: ArrayLike,
    mean_wind_speed: ArrayLike,
    *,
    shape: float = 2.0,
    availability: float = 1.0,
    losses: float = 0.0,
) -> FloatArray:
    """Energy of a year [J] for mean wind speeds (...), with power held over bins.

    The bins are those of `pitchopt.fatigue.bin_edges`; parameters and errors are as in
    `annual_energy`.
    """
    v, p = _curve(speeds, power)
    mean = positive_array("mean_wind_speed", mean_wind_speed)
    k = finite_number("shape", shape, at_least=1.0)
    share = _delivered(availability, losses)
    edges = bin_edges(v)
    energy = np.array(
        [
            YEAR * share * float(weibull_weights(edges, shape=k, mean=float(one)) @ p)
            for one in np.atleast_1d(mean).ravel()
        ]
    )
    return energy.reshape(mean.shape)


def _mean_power(curve: PchipInterpolator, speeds: FloatArray, shape: float, scale: float) -> float:
    """Integral of the curve over the density between the first and the last speed [W].

    By parts, as the share of time 1 - F above a speed is smoother than f at zero:

        int P f dv = P(v_1) (1 - F(v_1)) - P(v_n) (1 - F(v_n)) + int P' (1 - F) dv.
    """
    pieces = [speeds[:1]]
    for low, high in itertools.pairwise(speeds):
        count = min(math.ceil((high - low) / (_PIECE * scale)), _MOST_PIECES)
        pieces.append(np.linspace(low, high, count + 1)[1:])
    edges = np.concatenate(pieces)
    node, weight = np.polynomial.legendre.leggauss(_NODES)
    half = 0.5 * np.diff(edges)[:, np.newaxis]
    v = 0.5 * (edges[1:] + edges[:-1])[:, np.newaxis] + half * node
    rise = np.sum(half * weight * curve(v, 1) * np.exp(-((v / scale) ** shape)))
    ends = speeds[[0, -1]]
    first, last = curve(ends) * np.exp(-((ends / scale) ** shape))
    return float(first - last + rise)


def _curve(speeds: ArrayLike, power: ArrayLike) -> tuple[FloatArray, FloatArray]:
    v = finite_array("speeds", speeds)
    if v.size < 2 or np.diff(v).min() <= 0.0 or v[0] < 0.0:
        raise InputError(
            f"speeds: got {v.tolist()}, expected at least 2 increasing speeds from 0 on"
        )
    return v, finite_array("power", power, shape=v.shape)


def _delivered(availability: float, losses: float) -> float:
    ready = finite_number("availability", availability, at_least=0.0, at_most=1.0)
    return ready * (1.0 - finite_number("losses", losses, at_least=0.0, at_most=1.0))
