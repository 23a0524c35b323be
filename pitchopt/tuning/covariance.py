"""Covariance of a Gaussian process over the features of a space.

    k(f, g) = s^2 c(q),    q = sum_i (f_i - g_i)^2 / l_i^2

with one length scale l for each group of features (`Space.groups`), which is one per parameter or
per pair of gain and offset (automatic relevance determination).

    squared exponential    c = exp(-q / 2)
    Matern 5/2             c = (1 + sqrt(5 q) + 5 q / 3) exp(-sqrt(5 q))

Rasmussen and Williams, Gaussian processes for machine learning (2006), chapter 4.  Zalkind et al.,
equation (17), write the first with distances nu at which it falls to 1/e: nu = sqrt(2) l.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Literal

import numpy as np

from pitchopt.checks import FloatArray, finite_array, finite_number
from pitchopt.errors import InputError

__all__ = ["Covariance", "CovarianceName", "Hyperparameters", "covariance_named"]

CovarianceName = Literal["squared-exponential", "matern"]


@dataclass(frozen=True, kw_only=True)
class Covariance:
    """Shape of a covariance as a function of the squared scaled distance q.

    Attributes
    ----------
    name : str
    value : callable
        c(q), any shape.
    slope : callable
        dc/dq, finite at q = 0.
    degrees : int or None
        Degrees of freedom of the Student t that is the spectral density; None for the normal.
    """

    name: CovarianceName
    value: Callable[[FloatArray], FloatArray]
    slope: Callable[[FloatArray], FloatArray]
    degrees: int | None

    def frequencies(self, count: int, features: int, rng: np.random.Generator) -> FloatArray:
        """Draws (count, features) from the spectral density at unit length scales [rad]."""
        normal = rng.standard_normal((count, features))
        if self.degrees is None:
            return normal
        return normal * np.sqrt(self.degrees / rng.chisquare(self.degrees, (count, 1)))


def _exponential(q: FloatArray) -> FloatArray:
    return np.exp(-0.5 * q)


def _exponential_slope(q: FloatArray) -> FloatArray:
    return -0.5 * np.exp(-0.5 * q)


def _matern(q: FloatArray) -> FloatArray:
    r = np.sqrt(5.0 * q)
    return (1.0 + r + r * r / 3.0) * np.exp(-r)


def _matern_slope(q: FloatArray) -> FloatArray:
    r = np.sqrt(5.0 * q)
    return -5.0 / 6.0 * (1.0 + r) * np.exp(-r)


_COVARIANCES: dict[str, Covariance] = {
    "squared-exponential": Covariance(
        name="squared-exponential", value=_exponential, slope=_exponential_slope, degrees=None
    ),
    "matern": Covariance(name="matern", value=_matern, slope=_matern_slope, degrees=5),
}


def covariance_named(name: str) -> Covariance:
    """The covariance of a name.

    Raises
    ------
    InputError
        If there is none.
    """
    if name not in _COVARIANCES:
        raise InputError(f"covariance: got {name!r}, expected {' or '.join(_COVARIANCES)}")
    return _COVARIANCES[name]


@dataclass(frozen=True, kw_only=True)
class Hyperparameters:
    """What a likelihood is maximised over.

    Attributes
    ----------
    lengths : (g,) ndarray
        Length scale of each group of features.
    variance : float
        s^2, in squares of the scale that the process sees outputs in.
    nugget : float
        Variance of the noise that no sample's own variance accounts for, over s^2.
    """

    lengths: FloatArray
    variance: float
    nugget: float

    def __post_init__(self) -> None:
        lengths = finite_array("lengths", self.lengths)
        if np.any(lengths <= 0.0):
            raise InputError(f"lengths: got {lengths.min():g}, expected positive numbers")
        object.__setattr__(self, "lengths", lengths)
        object.__setattr__(self, "variance", finite_number("variance", self.variance, above=0.0))
        object.__setattr__(self, "nugget", finite_number("nugget", self.nugget, at_least=0.0))

    def document(self) -> dict[str, object]:
        """Plain data, exact to the last bit through JSON."""
        return {
            "lengths": self.lengths.tolist(),
            "variance": self.variance,
            "nugget": self.nugget,
        }

    @classmethod
    def from_document(cls, document: Mapping[str, object]) -> Hyperparameters:
        """Back from plain data.

        Raises
        ------
        InputError
            If a field is missing or is no number.
        """
        try:
            lengths, variance, nugget = (document[key] for key in ("lengths", "variance", "nugget"))
        except KeyError as error:
            raise InputError(f"hyperparameters: {error} is missing") from error
        return cls(
            lengths=finite_array("lengths", lengths),  # type: ignore[arg-type]
            variance=finite_number("variance", variance),
            nugget=finite_number("nugget", nugget),
        )
