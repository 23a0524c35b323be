"""Linear algebra of ordinary kriging at given hyperparameters.

With the covariance matrix of the samples K = s^2 (C + nugget I) + diag(noise), the vector
k of covariances between a point and the samples, and a constant mean that is not known:

    b      = (1' K^-1 y) / (1' K^-1 1)
    mean   = b + k' K^-1 (y - b 1)
    var    = s^2 - k' K^-1 k + (1 - 1' K^-1 k)^2 / (1' K^-1 1)

which are equations (13) to (19) of Zalkind et al. with the inverses that (19) lacks; the last
term is the share of the mean's own uncertainty.  The variance is that of the function, without
the noise of a further sample.  Points are unit coordinates of the space.
"""

from __future__ import annotations

import numpy as np
from scipy.linalg import lapack
from scipy.spatial.distance import cdist

from pitchopt.checks import FloatArray
from pitchopt.errors import ComputationError
from pitchopt.tuning.covariance import Covariance, Hyperparameters
from pitchopt.tuning.space import Space

__all__ = ["Kriging", "factorised", "inverse_of"]

_FIRST_JITTER = 1e-14  # of the mean of the diagonal, where a matrix is not positive definite
_LAST_JITTER = 1e-4
_LEAST_VARIANCE = 1e-14  # of s^2: rounding at the samples, where a variance is nil


def factorised(matrix: FloatArray) -> FloatArray:
    """Lower Cholesky factor of a covariance matrix, with as little added as keeps it alive.

    Raises
    ------
    ComputationError
        If the matrix is not finite or far from positive definite.
    """
    if not np.all(np.isfinite(matrix)):
        raise ComputationError("the covariance matrix of the samples is not finite")
    factor, failed = lapack.dpotrf(matrix, lower=1)
    jitter = _FIRST_JITTER * float(np.mean(np.diag(matrix)))
    largest = _LAST_JITTER / _FIRST_JITTER * jitter
    while failed:
        jitter *= 10.0
        if not jitter <= largest:
            raise ComputationError("the covariance matrix of the samples is not positive definite")
        factor, failed = lapack.dpotrf(matrix + jitter * np.eye(len(matrix)), lower=1)
    return np.asarray(factor)  # zero above the diagonal


def inverse_of(factor: FloatArray) -> FloatArray:
    """Inverse of a lower Cholesky factor.

    LAPACK's inverse of the matrix itself (potri) runs in parallel for matrices of any size: its
    bits depend on the number of threads, and threads that wait for a busy core make it slow.
    """
    inverse, _ = lapack.dtrtri(factor, lower=1)
    return np.asarray(inverse)


class Kriging:
    """Ordinary kriging on fixed points.

    Parameters
    ----------
    space : Space
    covariance : Covariance
    hyperparameters : Hyperparameters
    u : (n, d) ndarray
        Samples in unit coordinates.
    noise : (n,) ndarray
        Variance of each sample beside the nugget.

    Attributes
    ----------
    lengths : (f,) ndarray
        Length scale of each feature.
    factor : (n, n) ndarray
        Lower Cholesky factor of K.
    inverse_factor : (n, n) ndarray
        Its inverse.
    ones : (n,) ndarray
        K^-1 1.
    """

    def __init__(
        self,
        space: Space,
        covariance: Covariance,
        hyperparameters: Hyperparameters,
        u: FloatArray,
        noise: FloatArray,
    ) -> None:
        self.space, self.covariance, self.hyperparameters = space, covariance, hyperparameters
        self.u, self.noise = u, noise
        self.lengths = hyperparameters.lengths[space.groups]
        self.features = space.features(u)
        self._scaled = self.features / self.lengths
        variance, nugget = hyperparameters.variance, hyperparameters.nugget
        matrix = variance * covariance.value(cdist(self._scaled, self._scaled, "sqeuclidean"))
        self.prior = matrix  # of the function at the samples
        self.factor = factorised(matrix + np.diag(noise + variance * nugget))
        self.inverse_factor = inverse_of(self.factor)
        self.ones = self.inverse_factor.T @ self.inverse_factor.sum(axis=1)
        self.total = float(self.ones.sum())

    @property
    def inverse(self) -> FloatArray:
        """K^-1 (n, n)."""
        return np.asarray(self.inverse_factor.T @ self.inverse_factor)

    def weights(self, y: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Constant b (...) and K^-1 (y - b 1) for outputs y (n, ...)."""
        constant = np.asarray(self.ones @ y / self.total)
        residual = y - constant
        return constant, self.inverse_factor.T @ (self.inverse_factor @ residual)

    def cross(self, u: FloatArray) -> FloatArray:
        """Covariances k (m, n) of the function at points (m, d) with that at the samples."""
        return self.hyperparameters.variance * self.covariance.value(self._distance(u))

    def _distance(self, u: FloatArray) -> FloatArray:
        return cdist(self.space.features(u) / self.lengths, self._scaled, "sqeuclidean")

    def variances(self, k: FloatArray) -> FloatArray:
        """Posterior variance (m,) of the function where it has covariances k (m, n)."""
        half = k @ self.inverse_factor.T
        rest = 1.0 - k @ self.ones
        variance = self.hyperparameters.variance
        found = variance - np.einsum("mn,mn->m", half, half) + rest**2 / self.total
        return np.asarray(np.maximum(found, _LEAST_VARIANCE * variance))

    def variance_coefficients(self, k: FloatArray) -> FloatArray:
        """Derivatives (m, n) of the posterior variance in the covariances k (m, n)."""
        half = k @ self.inverse_factor.T
        rest = 1.0 - k @ self.ones
        return np.asarray(
            -2.0 * (half @ self.inverse_factor + np.outer(rest / self.total, self.ones))
        )

    def covariances(self, k: FloatArray, prior: FloatArray) -> FloatArray:
        """Joint posterior covariance (m, m) of points with covariances k and prior (m, m)."""
        half = k @ self.inverse_factor.T
        rest = 1.0 - k @ self.ones
        return np.asarray(prior - half @ half.T + np.outer(rest, rest) / self.total)

    def pulled(self, u: FloatArray, *coefficients: FloatArray) -> list[FloatArray]:
        """Gradients (m, d) in u of sum_n w_mn k(u_m, sample n), for each w (m, n) given."""
        features = self.space.features(u)
        slope = self.covariance.slope(self._distance(u))
        jacobian = self.space.jacobian(u)
        scale = 2.0 * self.hyperparameters.variance / self.lengths**2
        found = []
        for coefficient in coefficients:
            weight = coefficient * slope
            total = weight.sum(axis=1, keepdims=True)
            of_features = scale * (features * total - weight @ self.features)
            found.append(np.einsum("mf,mfd->md", of_features, jacobian))
        return found

    def leave_one_out(self, y: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Error of the prediction of each sample from all others, and its variance.

        Dubrule, Math. Geol. 15 (1983) 687-699, with the mean estimated anew each time.
        """
        projected = self.inverse - np.outer(self.ones, self.ones) / self.total
        diagonal = np.diag(projected)
        return projected @ y / diagonal, 1.0 / diagonal

    def root(self, matrix: FloatArray) -> FloatArray:
        """Lower root of a posterior covariance, which rounding may have left indefinite."""
        slack = 1e-10 * self.hyperparameters.variance
        symmetric = 0.5 * (matrix + matrix.T) + slack * np.eye(len(matrix))
        return factorised(symmetric)
