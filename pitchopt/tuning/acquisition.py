"""Acquisition functions: how much a further sample at a point is worth, to be maximised.

With posterior mean m and deviation s of the function at a point, the best value so far y* and
z = (y* - m) / s (costs are minimised):

    expected improvement         EI = s h(z),  h(z) = phi(z) + z Phi(z)
    its logarithm                log s + log h(z), which has slopes where EI is zero to rounding
    probability of improvement   log Phi(z)
    lower confidence bound       kappa s - m
    noisy expected improvement   log of the mean of EI over joint draws of the function at the
                                 samples, each with its own y* and conditioned without noise
    Thompson sampling            minus one draw of the function as a whole

Jones, Schonlau, Welch, J. Global Optim. 13 (1998) 455-492; Ament et al., Unexpected improvements to
expected improvement (2023) for the logarithm; Letham et al., Bayesian Anal. 14 (2019) 495-519 for
noise, with quasi-Monte Carlo; Wilson et al., Efficiently sampling functions from Gaussian process
posteriors (2020) for draws: a sum of waves from the prior, corrected at the samples.

All work in unit coordinates (m, d) and scaled outputs, and give values (m,) and gradients (m, d).
"""

from __future__ import annotations

import math
from typing import Literal

import numpy as np
from scipy.special import erfcx, log_ndtr, logsumexp, ndtr, ndtri, softmax

from pitchopt.checks import FloatArray
from pitchopt.tuning.covariance import Hyperparameters
from pitchopt.tuning.gaussian_process import GaussianProcess
from pitchopt.tuning.kriging import Kriging
from pitchopt.tuning.quasi_random import sobol

__all__ = [
    "AcquisitionName",
    "ConfidenceBound",
    "ExpectedImprovement",
    "LogExpectedImprovement",
    "NoisyExpectedImprovement",
    "ProbabilityOfImprovement",
    "ThompsonSample",
    "log_improvement",
]

AcquisitionName = Literal[
    "log-expected-improvement",
    "expected-improvement",
    "noisy-expected-improvement",
    "probability-of-improvement",
    "confidence-bound",
    "thompson",
]

_LOG_ROOT_TWO_PI = 0.5 * math.log(2.0 * math.pi)
_FAR = -200.0  # below, the series beats the difference of two equal numbers
_EXPONENT = 5  # of two: joint draws at the samples
_WAVES = 1024
_NUGGET_OF_DRAWS = 1e-8


def log_improvement(z: FloatArray) -> FloatArray:
    """log h(z) of h(z) = phi(z) + z Phi(z), accurate for every z.

    Below -1 through the scaled complementary error function, h = phi (1 - |z| Phi / phi); far
    below by h = phi / z^2 (1 - 3 / z^2 + 15 / z^4 - ...).
    """
    z = np.asarray(z, dtype=np.float64)
    near = np.maximum(z, -1.0)
    direct = np.log(np.exp(-0.5 * near**2 - _LOG_ROOT_TWO_PI) + near * ndtr(near))
    tail = np.minimum(z, -1.0)
    density = -0.5 * tail**2 - _LOG_ROOT_TWO_PI
    return np.where(z > -1.0, direct, density + _log_of_density(tail))


def _log_of_density(z: FloatArray) -> FloatArray:
    """log (h / phi) at z of at most -1."""
    middle, far = np.maximum(z, _FAR), np.minimum(z, _FAR)
    scaled = np.log1p(middle * _mills(middle))
    series = -2.0 * np.log(-far) + np.log1p(-3.0 / far**2 + 15.0 / far**4)
    return np.where(z > _FAR, scaled, series)


def _mills(z: FloatArray) -> FloatArray:
    """Phi / phi at z of at most 0."""
    return np.asarray(math.sqrt(0.5 * math.pi) * erfcx(-z / math.sqrt(2.0)))


def _shares(z: FloatArray, log_h: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Phi / h and phi / h, without differences of large logarithms in the tail."""
    close, near, tail = z > -1.0, np.maximum(z, -1.0), np.minimum(z, -1.0)
    over = np.exp(-np.where(close, log_h, 0.0))
    density = np.exp(-0.5 * near**2 - _LOG_ROOT_TWO_PI) * over
    far = np.exp(-_log_of_density(tail))
    return np.where(close, ndtr(near) * over, far * _mills(tail)), np.where(close, density, far)


class _OfMoments:
    """Acquisition of posterior mean and deviation alone.

    Parameters
    ----------
    process : GaussianProcess
    """

    def __init__(self, process: GaussianProcess) -> None:
        self.process = process

    def values(self, u: FloatArray) -> FloatArray:
        """Values (m,)."""
        return self._of(*self.process.moments(u))[0]

    def gradients(self, u: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Values (m,) and gradients (m, d)."""
        mean, std, of_mean, of_std = self.process.moments_with_gradients(u)
        value, by_mean, by_std = self._of(mean, std)
        return value, by_mean[:, None] * of_mean + by_std[:, None] * of_std

    def _of(self, mean: FloatArray, std: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Value and its derivatives in mean and deviation."""
        raise NotImplementedError


class _Improvement(_OfMoments):
    """Acquisition that counts from the best value so far.

    Parameters
    ----------
    process : GaussianProcess
    best : float
        y*, scaled as the process scales outputs.
    """

    def __init__(self, process: GaussianProcess, best: float) -> None:
        super().__init__(process)
        self.best = best


class ExpectedImprovement(_Improvement):
    """Expected improvement over the best value so far, in scaled outputs."""

    def _of(self, mean: FloatArray, std: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        z = (self.best - mean) / std
        density = np.exp(-0.5 * z**2 - _LOG_ROOT_TWO_PI)
        return std * np.exp(log_improvement(z)), -ndtr(z), density


class LogExpectedImprovement(_Improvement):
    """Logarithm of the expected improvement."""

    def _of(self, mean: FloatArray, std: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        z = (self.best - mean) / std
        log_h = log_improvement(z)
        probability, density = _shares(z, log_h)
        return np.log(std) + log_h, -probability / std, density / std


class ProbabilityOfImprovement(_Improvement):
    """Logarithm of the probability that a point is better than the best so far."""

    def _of(self, mean: FloatArray, std: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        z = (self.best - mean) / std
        value = log_ndtr(z)
        likely = np.maximum(z, 0.0)
        density = np.exp(-0.5 * likely**2 - _LOG_ROOT_TWO_PI)
        hazard = np.where(z > 0.0, density / ndtr(likely), 1.0 / _mills(np.minimum(z, 0.0)))
        return value, -hazard / std, -hazard * z / std


class ConfidenceBound(_OfMoments):
    """Minus the lower confidence bound of the function.

    Parameters
    ----------
    process : GaussianProcess
    kappa : float
        Deviations below the mean.
    """

    def __init__(self, process: GaussianProcess, kappa: float) -> None:
        super().__init__(process)
        self.kappa = kappa

    def _of(self, mean: FloatArray, std: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        return self.kappa * std - mean, -np.ones_like(mean), np.full_like(std, self.kappa)


class NoisyExpectedImprovement:
    """Logarithm of expected improvement over what the function itself may be at the samples.

    Parameters
    ----------
    process : GaussianProcess
    candidates : (n,) ndarray of bool
        Which samples may be the best so far, such as the feasible ones.
    pending : (p, d) ndarray
        Further points whose results are not known; they take part in the draws.
    rng : numpy.random.Generator
    exponent : int
        Of two: number of draws.
    """

    def __init__(
        self,
        process: GaussianProcess,
        *,
        candidates: FloatArray,
        pending: FloatArray,
        rng: np.random.Generator,
        exponent: int = _EXPONENT,
    ) -> None:
        kriging = process.kriging
        points = np.concatenate([kriging.u, pending])
        hyper = kriging.hyperparameters
        exact = Hyperparameters(
            lengths=hyper.lengths, variance=hyper.variance, nugget=_NUGGET_OF_DRAWS
        )
        self._kriging = Kriging(
            kriging.space, kriging.covariance, exact, points, np.zeros(len(points))
        )
        k = kriging.cross(points)
        root = kriging.root(kriging.covariances(k, self._kriging.prior))
        normal = ndtri(np.clip(sobol(exponent, len(points), rng), 1e-12, 1.0 - 1e-12))
        mean = process.constant + k @ process.weights
        functions = mean[:, None] + root @ normal.T  # (n + p, draws)
        self._constant, self._weights = self._kriging.weights(functions)
        able = np.concatenate([candidates, np.ones(len(pending), dtype=bool)])
        self._best = functions[able].min(axis=0)

    def values(self, u: FloatArray) -> FloatArray:
        """Values (m,)."""
        k = self._kriging.cross(u)
        std = np.sqrt(self._kriging.variances(k))
        return self._logarithms(k, std)[2]

    def gradients(self, u: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Values (m,) and gradients (m, d)."""
        k = self._kriging.cross(u)
        std = np.sqrt(self._kriging.variances(k))
        z, log_h, value = self._logarithms(k, std)
        probability, density = _shares(z, log_h)
        weights = softmax(log_h, axis=1)
        by_mean = -weights * probability / std[:, None]
        by_std = (weights * density).sum(axis=1) / std
        coefficients = by_mean @ self._weights.T
        coefficients += (0.5 * by_std / std)[:, None] * self._kriging.variance_coefficients(k)
        return value, self._kriging.pulled(u, coefficients)[0]

    def _logarithms(
        self, k: FloatArray, std: FloatArray
    ) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Scaled improvements z (m, draws), log h(z), and that of the mean improvement (m,)."""
        mean = self._constant + k @ self._weights
        z = (self._best - mean) / std[:, None]
        log_h = log_improvement(z)
        return z, log_h, np.log(std) + logsumexp(log_h, axis=1) - math.log(z.shape[1])


class ThompsonSample:
    """Minus one draw of the function from its posterior.

    f(u) = g(u) + b + k(u)' K^-1 (r - b 1),  r = y - g(samples) - noise

    with a draw g of the prior as a sum of waves, a draw of the noise and the constant b by
    generalised least squares of r, so that the draw is one of a process whose mean is not known.

    Parameters
    ----------
    process : GaussianProcess
    rng : numpy.random.Generator
    waves : int
    """

    def __init__(
        self, process: GaussianProcess, *, rng: np.random.Generator, waves: int = _WAVES
    ) -> None:
        kriging = self._kriging = process.kriging
        hyper = kriging.hyperparameters
        scaled = kriging.covariance.frequencies(waves, len(kriging.lengths), rng)
        self._frequencies = scaled / kriging.lengths
        self._phases = rng.uniform(0.0, 2.0 * np.pi, waves)
        self._amplitudes = math.sqrt(2.0 * hyper.variance / waves) * rng.standard_normal(waves)
        noise = np.sqrt(kriging.noise + hyper.variance * hyper.nugget)
        residual = process.y - noise * rng.standard_normal(len(noise))
        self._constant, self._weights = kriging.weights(residual - self._prior(kriging.features))

    def _angles(self, features: FloatArray) -> FloatArray:
        return np.asarray(features @ self._frequencies.T + self._phases)

    def _prior(self, features: FloatArray) -> FloatArray:
        return np.asarray(np.cos(self._angles(features)) @ self._amplitudes)

    def values(self, u: FloatArray) -> FloatArray:
        """Values (m,)."""
        prior = self._prior(self._kriging.space.features(u))
        return np.asarray(-prior - self._constant - self._kriging.cross(u) @ self._weights)

    def gradients(self, u: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Values (m,) and gradients (m, d)."""
        space = self._kriging.space
        angles = self._angles(space.features(u))
        of_features = -(np.sin(angles) * self._amplitudes) @ self._frequencies
        slopes = np.einsum("mf,mfd->md", of_features, space.jacobian(u))
        weights = np.broadcast_to(self._weights, (len(u), len(self._weights)))
        slopes += self._kriging.pulled(u, weights)[0]
        k = self._kriging.cross(u)
        values = -np.cos(angles) @ self._amplitudes - self._constant - k @ self._weights
        return values, -slopes
