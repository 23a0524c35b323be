"""Hyperparameters of a Gaussian process from its samples.

Logarithm of the likelihood with the constant mean b at its generalised least squares,

    log p = -1/2 (y - b)' K^-1 (y - b) - 1/2 log det K - n/2 log 2 pi

and its gradient in theta = log (lengths, variance, nugget),

    d log p / d theta_j = 1/2 tr[(a a' - K^-1) dK/d theta_j],    a = K^-1 (y - b)

(Rasmussen and Williams, equation (5.9); that b moves with theta adds nothing, as b is optimal).

``ml`` maximises it.  ``map`` adds the logarithm of these priors:

- each length scale log-normal with mu = sqrt(2) + log(g) / 2, sigma = sqrt(3) for g groups, its
  density taken in the length: Hvarfner, Hellsten, Nardi, Vanilla Bayesian optimization performs
  great in high dimensions (2024).  It is largest near 0.2 sqrt(g) of a parameter's range.
- log variance normal about 0 with deviation 1.5: outputs come in scaled to unit variance.
- log nugget normal about log 1e-4 with deviation 4: a guess that rules out neither an exact
  function nor one drowned in noise.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal

import numpy as np
from scipy.optimize import Bounds, minimize

from pitchopt.checks import FloatArray
from pitchopt.errors import ComputationError, InputError
from pitchopt.tuning.covariance import Covariance, Hyperparameters
from pitchopt.tuning.kriging import factorised, inverse_of

__all__ = ["Criterion", "Likelihood", "fitted"]

Criterion = Literal["ml", "map"]

_BOUNDS = {"length": (1e-2, 30.0), "variance": (1e-3, 1e3), "nugget": (1e-10, 1e3)}
_LENGTH_SIGMA = math.sqrt(3.0)
_VARIANCE_SIGMA = 1.5
_NUGGET_CENTRE, _NUGGET_SIGMA = math.log(1e-4), 4.0
_ITERATIONS = 100


@dataclass(frozen=True, kw_only=True)
class Value:
    """Log likelihood and its gradient in the log hyperparameters."""

    value: float
    gradient: FloatArray


class Likelihood:
    """Log likelihood of samples as a function of log hyperparameters.

    Parameters
    ----------
    covariance : Covariance
    features : (n, f) ndarray
    groups : (f,) ndarray of int
    y : (n,) ndarray
    noise : (n,) ndarray
        Variance of each sample beside the nugget.
    """

    def __init__(
        self,
        covariance: Covariance,
        features: FloatArray,
        groups: np.ndarray,
        y: FloatArray,
        noise: FloatArray,
    ) -> None:
        self._covariance, self._y, self._noise = covariance, y, noise
        self.groups = int(groups.max()) + 1
        first, second = np.triu_indices(len(y), 1)
        self._places = first * len(y) + second  # of pairs in a flat matrix
        squares = (features[first] - features[second]) ** 2
        self._squares = np.stack(
            [squares[:, groups == group].sum(axis=1) for group in range(self.groups)]
        )

    def __call__(self, theta: FloatArray) -> Value:
        """Value at theta = log (lengths, variance, nugget)."""
        rates = np.exp(-2.0 * theta[:-2])
        variance, nugget = np.exp(theta[-2:])
        distance = rates @ self._squares
        pairs = variance * self._covariance.value(distance)
        count = len(self._y)
        matrix = np.zeros((count, count))
        matrix.ravel()[self._places] = pairs
        matrix += matrix.T
        matrix.ravel()[:: count + 1] = variance * (1.0 + nugget) + self._noise
        factor = factorised(matrix)
        half = inverse_of(factor)
        inverse = half.T @ half
        ones = inverse.sum(axis=1)
        residual = self._y - ones @ self._y / ones.sum()
        a = inverse @ residual
        value = (
            -0.5 * residual @ a
            - np.log(np.diag(factor)).sum()
            - 0.5 * count * math.log(2.0 * math.pi)
        )
        diagonal = a * a - np.diag(inverse)
        off = (np.outer(a, a) - inverse).take(self._places)
        slope = variance * self._covariance.slope(distance)
        lengths = -2.0 * rates * (self._squares @ (off * slope))
        of_variance = off @ pairs + 0.5 * variance * (1.0 + nugget) * diagonal.sum()
        of_nugget = 0.5 * variance * nugget * diagonal.sum()
        return Value(value=float(value), gradient=np.array([*lengths, of_variance, of_nugget]))


def log_prior(theta: FloatArray) -> Value:
    """Logarithm of the priors, up to a constant, and its gradient in theta."""
    groups = len(theta) - 2
    centre = np.array(
        [
            *([math.sqrt(2.0) + 0.5 * math.log(groups) - _LENGTH_SIGMA**2] * groups),
            0.0,
            _NUGGET_CENTRE,
        ]
    )
    sigma = np.array([*([_LENGTH_SIGMA] * groups), _VARIANCE_SIGMA, _NUGGET_SIGMA])
    z = (theta - centre) / sigma
    return Value(value=float(-0.5 * z @ z), gradient=-z / sigma)


def fitted(
    likelihood: Likelihood,
    criterion: Criterion,
    *,
    begin: Hyperparameters | None = None,
    starts: int,
    rng: np.random.Generator,
) -> Hyperparameters:
    """Hyperparameters that maximise the criterion.

    Parameters
    ----------
    likelihood : Likelihood
    criterion : {"ml", "map"}
    begin : Hyperparameters, optional
        A start to try before all others.
    starts : int
        Other starts: the centre of the priors and points drawn around it.
    rng : numpy.random.Generator

    Raises
    ------
    InputError
        If the criterion has another name.
    ComputationError
        If the likelihood cannot be computed from any start.
    """
    if criterion not in ("ml", "map"):
        raise InputError(f"hyperparameters: got {criterion!r}, expected ml or map")
    groups = likelihood.groups
    bounds = np.log([_BOUNDS["length"]] * groups + [_BOUNDS["variance"], _BOUNDS["nugget"]])
    centre = np.log([*([0.3 * math.sqrt(groups)] * groups), 1.0, 1e-4])
    spread = np.array([*([1.0] * groups), 0.5, 4.0])
    begins = [] if begin is None else [_theta(begin)]
    begins += [
        centre + (spread * rng.standard_normal(groups + 2) if number else 0.0)
        for number in range(starts)
    ]

    def down(theta: FloatArray) -> tuple[float, FloatArray]:
        found = likelihood(theta)
        value, gradient = found.value, found.gradient
        if criterion == "map":
            prior = log_prior(theta)
            value, gradient = value + prior.value, gradient + prior.gradient
        return -value, -gradient

    best, least = None, math.inf
    for theta in begins:
        try:
            result = minimize(
                down,
                np.clip(theta, *bounds.T),
                jac=True,
                method="L-BFGS-B",
                bounds=Bounds(*bounds.T),
                options={"maxiter": _ITERATIONS, "ftol": 1e-9, "gtol": 1e-4},
            )
        except ComputationError:
            continue
        if result.fun < least:
            best, least = result.x, float(result.fun)
    if best is None:
        raise ComputationError("the likelihood of the samples cannot be computed from any start")
    return Hyperparameters(
        lengths=np.exp(best[:-2]), variance=float(np.exp(best[-2])), nugget=float(np.exp(best[-1]))
    )


def _theta(hyperparameters: Hyperparameters) -> FloatArray:
    nugget = max(hyperparameters.nugget, _BOUNDS["nugget"][0])
    return np.log([*hyperparameters.lengths, hyperparameters.variance, nugget])
