"""Gaussian process of a noisy function over a space: ordinary kriging with fitted hyperparameters.

    y_i = f(x_i) + e_i,    f = b + GP(0, k),    e_i normal with variance noise_i + nugget

Equations in `kriging`, likelihood and priors in `likelihood`.  Outputs are shifted and scaled to
mean 0 and deviation 1 within; everything that comes out is in the units of the samples.  A
standard deviation is that of the function f, not of a further noisy sample of it.

This draws the design-space pictures of Zalkind et al. (their section 2.6), for a cost as for any
measure of the same evaluations; `minimum` is the minimum of their kriging surface, `curvature` the
second derivatives of their equation (37) and `gradient` the slopes of (38).
"""

from __future__ import annotations

import copy
import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from pitchopt.checks import FloatArray, finite_array, whole_number
from pitchopt.errors import InputError
from pitchopt.tuning.acquisition_search import maximise
from pitchopt.tuning.covariance import CovarianceName, Hyperparameters, covariance_named
from pitchopt.tuning.kriging import Kriging
from pitchopt.tuning.likelihood import Criterion, Likelihood, fitted
from pitchopt.tuning.space import Space

__all__ = ["GaussianProcess", "PosteriorMinimum"]

_STEP = 1e-4  # of a range, for second derivatives from analytic first ones


@dataclass(frozen=True, kw_only=True)
class PosteriorMinimum:
    """Where the posterior mean is least.

    Attributes
    ----------
    x : (d,) ndarray
    mean : float
    std : float
        Standard deviation of the function there.
    """

    x: FloatArray
    mean: float
    std: float


class GaussianProcess:
    """Posterior of a function given samples and hyperparameters; `fit` finds the latter.

    Parameters
    ----------
    space : Space
    x : (n, d) array_like
        Samples; repeated points are repeated measurements.
    y : (n,) array_like
    noise_variance : (n,) array_like, optional
        Variance of each sample, such as that of a mean over seeds; zero without.
    covariance : {"squared-exponential", "matern"}
    hyperparameters : Hyperparameters
        For outputs of deviation 1.

    Attributes
    ----------
    kriging : Kriging
        The same in unit coordinates and scaled outputs.
    shift, scale : float
        y = shift + scale times the scaled output.

    Raises
    ------
    InputError
        If a point lies outside of the space, or shapes do not fit.
    """

    def __init__(
        self,
        space: Space,
        x: ArrayLike,
        y: ArrayLike,
        *,
        noise_variance: ArrayLike | None = None,
        covariance: CovarianceName = "squared-exponential",
        hyperparameters: Hyperparameters,
    ) -> None:
        samples = _Samples(space, x, y, noise_variance)
        self._condition(samples, covariance, hyperparameters)

    @classmethod
    def fit(
        cls,
        space: Space,
        x: ArrayLike,
        y: ArrayLike,
        *,
        noise_variance: ArrayLike | None = None,
        covariance: CovarianceName = "squared-exponential",
        criterion: Criterion = "map",
        starts: int = 6,
        begin: Hyperparameters | None = None,
        seed: int | list[int] = 0,
    ) -> GaussianProcess:
        """Posterior with the hyperparameters of largest likelihood.

        Parameters
        ----------
        space, x, y, noise_variance, covariance
            As of the class.
        criterion : {"map", "ml"}
            With priors (see `likelihood`) or without.
        starts : int
            Of the search for hyperparameters.
        begin : Hyperparameters, optional
            A further start.
        seed : int or list of int
            Of the starts.

        Raises
        ------
        InputError
            As the class, or if there are fewer than two samples.
        """
        samples = _Samples(space, x, y, noise_variance)
        if len(samples.y) < 2:
            raise InputError(f"y: got {len(samples.y)} sample, expected at least 2 for a fit")
        likelihood = Likelihood(
            covariance_named(covariance),
            space.features(samples.u),
            space.groups,
            samples.y,
            samples.noise,
        )
        hyperparameters = fitted(
            likelihood,
            criterion,
            begin=begin,
            starts=whole_number("starts", starts, at_least=0 if begin else 1),
            rng=np.random.default_rng(seed),
        )
        process = cls.__new__(cls)
        process._condition(samples, covariance, hyperparameters)
        return process

    def _condition(
        self, samples: _Samples, covariance: CovarianceName, hyperparameters: Hyperparameters
    ) -> None:
        space = self.space = samples.space
        groups = int(space.groups.max()) + 1
        if len(hyperparameters.lengths) != groups:
            raise InputError(
                f"hyperparameters: got {len(hyperparameters.lengths)} lengths, expected {groups}"
            )
        self.hyperparameters = hyperparameters
        self.shift, self.scale = samples.shift, samples.scale
        self.y = samples.y
        self.kriging = Kriging(
            space, covariance_named(covariance), hyperparameters, samples.u, samples.noise
        )
        constant, self.weights = self.kriging.weights(self.y)
        self.constant = float(constant)

    def believing(self, u: FloatArray) -> GaussianProcess:
        """The process as if its own mean had been sampled at unit coordinates (p, d).

        The mean stays as it is everywhere and the deviation shrinks around these points, whose
        results are pending (the kriging believer of Ginsbourger, Le Riche, Carraro, 2010).
        """
        if not len(u):
            return self
        believed, kriging = copy.copy(self), self.kriging
        noise = np.concatenate([kriging.noise, np.full(len(u), kriging.noise.mean())])
        believed.y = np.concatenate([self.y, self.moments(u)[0]])
        believed.kriging = Kriging(
            self.space,
            kriging.covariance,
            self.hyperparameters,
            np.concatenate([kriging.u, u]),
            noise,
        )
        constant, believed.weights = believed.kriging.weights(believed.y)
        believed.constant = float(constant)
        return believed

    def scaled(self, y: float) -> float:
        """An output as the process scales it."""
        return (y - self.shift) / self.scale

    @property
    def samples(self) -> tuple[FloatArray, FloatArray]:
        """Points (n, d) and outputs (n,) that the process was given."""
        return self.space.from_unit(self.kriging.u), self.shift + self.scale * self.y

    @property
    def mean(self) -> float:
        """Constant b that the function varies about, by generalised least squares."""
        return self.shift + self.scale * self.constant

    @property
    def process_std(self) -> float:
        """Standard deviation s of the function about b, sigma_proc of equation (20)."""
        return self.scale * math.sqrt(self.hyperparameters.variance)

    @property
    def nugget_std(self) -> float:
        """Standard deviation of the noise that the samples' own variances do not hold."""
        return self.process_std * math.sqrt(self.hyperparameters.nugget)

    def predict(self, x: ArrayLike) -> tuple[FloatArray, FloatArray]:
        """Mean (...) and standard deviation (...) of the function at points (..., d).

        Raises
        ------
        InputError
            If a point lies outside of the space.
        """
        points = np.asarray(x, dtype=np.float64)
        shape = points.shape[:-1]
        u = _unit(self.space, points.reshape(-1, points.shape[-1]) if points.ndim else points)
        mean, std = self.moments(u)
        return (self.shift + self.scale * mean).reshape(shape), (self.scale * std).reshape(shape)

    def moments(self, u: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Mean and standard deviation (m,) of the scaled output at unit coordinates (m, d)."""
        k = self.kriging.cross(u)
        return self.constant + k @ self.weights, np.sqrt(self.kriging.variances(k))

    def moments_with_gradients(
        self, u: FloatArray
    ) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
        """Mean, standard deviation (m,) and their gradients (m, d) in unit coordinates (m, d)."""
        kriging = self.kriging
        k = kriging.cross(u)
        std = np.sqrt(kriging.variances(k))
        of_mean, of_variance = kriging.pulled(
            u, np.broadcast_to(self.weights, k.shape), kriging.variance_coefficients(k)
        )
        mean = self.constant + k @ self.weights
        return mean, std, of_mean, of_variance / (2.0 * std[:, None])

    def gradient(self, x: ArrayLike) -> FloatArray:
        """Slopes (d,) of the posterior mean at a point, in its units per unit of a parameter."""
        point = self.space.point(x)
        u = self.space.to_unit(point)[None]
        return np.asarray(self.scale * self._slopes(u)[0] / self._stretch(point))

    def curvature(self, x: ArrayLike) -> FloatArray:
        """Second derivatives (d,) of the posterior mean at a point, one for each parameter."""
        point = self.space.point(x)
        u, d = self.space.to_unit(point), len(self.space)
        moves = _STEP * np.eye(d)
        slopes = self._slopes(np.concatenate([u + moves, u - moves, u[None]]))
        second = np.diag(slopes[:d] - slopes[d : 2 * d]) / (2.0 * _STEP)
        logarithms = np.array(
            [math.log(p.high / p.low) if p.scale == "log" else 0.0 for p in self.space.parameters]
        )
        second -= logarithms * slopes[-1]
        return np.asarray(self.scale * second / self._stretch(point) ** 2)

    def _slopes(self, u: FloatArray) -> FloatArray:
        weights = np.broadcast_to(self.weights, (len(u), len(self.weights)))
        return self.kriging.pulled(u, weights)[0]

    def _stretch(self, x: FloatArray) -> FloatArray:
        """Derivative (d,) of the parameters in their unit coordinates."""
        return np.array(
            [
                value * math.log(p.high / p.low) if p.scale == "log" else p.width
                for value, p in zip(x, self.space.parameters, strict=True)
            ]
        )

    def leave_one_out(self) -> tuple[FloatArray, FloatArray]:
        """Sample less prediction from all others (n,), and that difference's deviation (n,)."""
        error, variance = self.kriging.leave_one_out(self.y)
        return self.scale * error, self.scale * np.sqrt(variance)

    def minimum(self, *, seed: int = 0) -> PosteriorMinimum:
        """Where the posterior mean is least over the whole space."""
        means, _ = self.moments(self.kriging.u)
        near = self.kriging.u[np.argsort(means, kind="stable")[:5]]
        u, value = maximise(self.space, _Descent(self), near=near, rng=np.random.default_rng(seed))
        _, std = self.moments(u[None])
        return PosteriorMinimum(
            x=self.space.from_unit(u),
            mean=self.shift - self.scale * value,
            std=self.scale * float(std[0]),
        )


class _Descent:
    """The negative posterior mean, to be maximised."""

    def __init__(self, process: GaussianProcess) -> None:
        self._process = process

    def values(self, u: FloatArray) -> FloatArray:
        return -self._process.moments(u)[0]

    def gradients(self, u: FloatArray) -> tuple[FloatArray, FloatArray]:
        return self.values(u), -self._process._slopes(u)


class _Samples:
    """Samples, checked, in unit coordinates and scaled outputs."""

    def __init__(
        self, space: Space, x: ArrayLike, y: ArrayLike, noise_variance: ArrayLike | None
    ) -> None:
        self.space = space
        values = finite_array("y", y)
        self.u = _unit(space, x, rows=len(values))
        self.shift = float(values.mean())
        spread = float(values.std())
        self.scale = spread if spread > 1e-12 * float(np.abs(values).max()) else 1.0
        self.y = (values - self.shift) / self.scale
        if noise_variance is None:
            self.noise = np.zeros(len(values))
            return
        noise = finite_array("noise_variance", noise_variance, shape=values.shape)
        if np.any(noise < 0.0):
            raise InputError(f"noise_variance: got {noise.min():g}, expected none below zero")
        self.noise = noise / self.scale**2


def _unit(space: Space, x: ArrayLike, *, rows: int | None = None) -> FloatArray:
    """Unit coordinates (n, d) of points of the space, which are checked."""
    given = np.asarray(x, dtype=np.float64)
    if given.ndim != 2 or given.shape[1] != len(space) or (rows or len(given)) != len(given):
        wanted = "any number" if rows is None else str(rows)
        raise InputError(
            f"x: got shape {given.shape}, expected {wanted} of points of {len(space)} parameters"
        )
    inside = space.project(given)
    far = ~np.isclose(inside, given, rtol=0.0, atol=1e-9 * (space.upper - space.lower))
    bad = np.flatnonzero(np.any(far & ~space.periodic | ~np.isfinite(given), axis=1))
    if bad.size:
        space.point(given[bad[0]])
    return space.to_unit(inside)
