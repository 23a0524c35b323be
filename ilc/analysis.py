"""Analysis of the fixed-gain loop on an affine plant: when it converges, and what noise does.

At each tracked position, with weighted errors e = W (y - y_mean), loads y = y_0 + D beta and means
held, a passage changes the distance d of the pitch from its fixed point by

    d <- M d,      M = I - kappa H W D                                         (B x B),

and the distance of the weighted loads by I - kappa W D H (4 x 4).  Both have the eigenvalues of M;
the second has 4 - B more (B < 4), and they are 1: B pitches move the four loads in B directions at
most, and what is left of the loads no pitch can change.  Its spectral radius is therefore never
below 1, however fast the pitch converges.

Measurement noise v with covariance S enters as d <- M d - kappa H W v.  The stationary covariance
of the pitch solves X = M X M' + kappa^2 H W S W H'.

Error of the model.  Loads that answer with D + E instead of D change M by -kappa H W E, and

    kappa |H| |W E| < 1 - |M|        (largest singular values)

keeps |M - kappa H W E| below 1: the distance shrinks in every passage, even if E differs from
passage to passage.  For the gain without damping, H = (W D)^+ and W D of full rank, this is
|W E| / |W D| < 1 / cond(W D) whatever kappa, and no larger bound holds: the smallest error by which
W D loses rank has just that size.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike
from scipy.linalg import solve_discrete_lyapunov

from ilc._checks import FloatArray, array_of, number
from ilc.errors import LearningError
from ilc.layout import Layout

__all__ = [
    "Contraction",
    "Noise",
    "RotationLoop",
    "contraction",
    "error_margin",
    "rotation_loop",
    "stationary_noise",
]

_ONE = 1e-7  # eigenvalues as near to 1 as this are counted as 1


class Contraction(NamedTuple):
    """Factors by which distances shrink in a passage, one for each tracked position.

    Attributes
    ----------
    pitch : ndarray (P,)
        Spectral radius of I - kappa H W D.  Below 1 the pitch converges.
    loads : ndarray (P,)
        Spectral radius of I - kappa W D H, at least 1 with fewer than four blades.
    """

    pitch: FloatArray
    loads: FloatArray


class Noise(NamedTuple):
    """What measurement noise does to the loop once it has settled.

    Attributes
    ----------
    pitch : ndarray (P, B, B)
        Covariance of the pitch at each tracked position [rad^2].
    loads : ndarray (P, 4, 4)
        Covariance of the exact loads.
    rms : ndarray (4,)
        Root of the expected square of each load's RMS deviation over the P positions [N m, N].
    """

    pitch: FloatArray
    loads: FloatArray
    rms: FloatArray


@dataclass(frozen=True, kw_only=True, eq=False)
class RotationLoop:
    """The loop from one rotation to the next, means and all positions together.

    Attributes
    ----------
    matrix : ndarray (V + 3, V + 3)
        Acts on the V pitches [rad] and the means of tilt, yaw [N m] and thrust [N].
    eigenvalues : ndarray (V + 3,)
        Largest modulus first.
    radius : float
        Largest modulus of the eigenvalues that are not 1.
    neutral : int
        Number of eigenvalues that are 1.
    """

    matrix: FloatArray
    eigenvalues: np.ndarray
    radius: float
    neutral: int


def contraction(
    jacobian: ArrayLike, gain: ArrayLike, weights: ArrayLike, learning_rate: float
) -> Contraction:
    """How fast pitch and loads approach their fixed point at each position, means held.

    Parameters
    ----------
    jacobian : array (P, 4, B)
        D of the plant [load/rad]; it may differ from that of which the gain was made.
    gain : array (P, B, 4)
        H, acts on weighted errors.
    weights : array (4,)
        Diagonal of W.
    learning_rate : float
        kappa.

    Returns
    -------
    Contraction
    """
    D, H, W, kappa = _loop(jacobian, gain, weights, learning_rate)
    weighted = W[:, None] * D
    return Contraction(
        pitch=_radius(np.eye(D.shape[2]) - kappa * H @ weighted),
        loads=_radius(np.eye(4) - kappa * weighted @ H),
    )


def error_margin(
    jacobian: ArrayLike, gain: ArrayLike, weights: ArrayLike, learning_rate: float
) -> FloatArray:
    """Relative error of the Jacobian below which the loop surely contracts, at each position.

    Parameters are those of :func:`contraction`.

    Returns
    -------
    ndarray (P,)
        r such that every error E with |W E| < r |W D| (largest singular values) keeps
        |I - kappa H W (D + E)| below 1.  0 where that norm is not below 1 without error, as at
        positions where the learner leaves a direction of the pitch alone.
    """
    D, H, W, kappa = _loop(jacobian, gain, weights, learning_rate)
    weighted = W[:, None] * D
    reserve = 1 - _norm(np.eye(D.shape[2]) - kappa * H @ weighted)
    size = kappa * _norm(H) * _norm(weighted)
    return np.where(reserve > 0, reserve / np.where(size > 0, size, 1.0), 0.0)


def stationary_noise(
    jacobian: ArrayLike,
    gain: ArrayLike,
    weights: ArrayLike,
    learning_rate: float,
    noise: ArrayLike,
) -> Noise:
    """Pitch and loads that noise of the measurements keeps in motion, means held, no delay.

    Parameters
    ----------
    jacobian, gain, weights, learning_rate
        Those of :func:`contraction`.
    noise : array (4,)
        Standard deviation of each load's measurement, independent from sample to sample.

    Returns
    -------
    Noise

    Raises
    ------
    LearningError
        If the loop does not contract at a position: the noise would grow without end.
    """
    D, H, W, kappa = _loop(jacobian, gain, weights, learning_rate)
    deviation = array_of("noise", noise, (4,))
    if np.any(deviation < 0):
        raise LearningError(f"noise: got {deviation}, expected numbers of at least 0")
    radius = contraction(D, H, W, kappa).pitch
    if radius.max() >= 1:
        raise LearningError(
            f"gain: the loop does not contract (factor {radius.max():.6g} at position "
            f"{int(radius.argmax())}), expected factors below 1"
        )
    M = np.eye(D.shape[2]) - kappa * H @ (W[:, None] * D)
    entry = kappa * H * (W * deviation)
    pitch = np.array([solve_discrete_lyapunov(m, e @ e.T) for m, e in zip(M, entry, strict=True)])
    loads = D @ pitch @ D.transpose(0, 2, 1)
    variances = np.diagonal(loads, axis1=1, axis2=2)
    # the deviation from a mean of P independent values has 1 - 1/P of their variance
    rms = np.sqrt(variances.mean(axis=0) * (1 - 1 / len(D)))
    return Noise(pitch=pitch, loads=loads, rms=rms)


def rotation_loop(
    layout: Layout,
    jacobian: ArrayLike,
    gain: ArrayLike,
    weights: ArrayLike,
    learning_rate: float,
    smoothing: float,
) -> RotationLoop:
    """The loop over one rotation with the means of tilt, yaw and thrust that follow the loads.

    In each of the B passages the positions met learn with the means held; after the last one

        mean <- (1 - q) mean + q (mean of the loads over the rotation).

    The mean of torque is the set-point and does not move.  No limit binds, nothing lags.

    Without neutral directions and with a radius below 1 there is one fixed point, and every start
    runs into it.  A mean that the pitches can take on at all positions alike is neutral: at
    each of its values the errors vanish, and nothing in the loop prefers one.  Where the positions
    differ a little, as those of a rotor do in constant tilt and yaw, its eigenvalue is a little
    below 1: the AC load settles long before that mean does, and noise moves it about.

    Parameters
    ----------
    layout : Layout
        With P tracked positions.
    jacobian, gain, weights, learning_rate
        Those of :func:`contraction`.
    smoothing : float
        q.

    Returns
    -------
    RotationLoop
    """
    D, H, W, kappa = _loop(jacobian, gain, weights, learning_rate)
    if D.shape != (layout.tracked, 4, layout.blades):
        raise LearningError(
            f"jacobian: got shape {D.shape}, expected {(layout.tracked, 4, layout.blades)}"
        )
    q = number("smoothing", smoothing, at_least=0, at_most=1)
    V = layout.variables
    start = np.eye(V + 3)
    pitch, means = start[:V], np.vstack([np.zeros(V + 3), start[V:]])
    total = np.zeros((4, V + 3))
    for passage in range(layout.blades):
        rows = layout.visit(passage)[0]
        index = layout.index[rows]
        loads = D[rows] @ pitch[index]
        total += loads.sum(axis=0)
        pitch = pitch.copy()
        pitch[index] -= kappa * H[rows] @ (W[:, None] * (loads - means))
    means = (1 - q) * means + q * total / layout.stations
    matrix = np.vstack([pitch, means[1:]])
    eigenvalues = np.linalg.eigvals(matrix)
    eigenvalues = eigenvalues[np.argsort(-np.abs(eigenvalues), kind="stable")]
    ones = np.abs(eigenvalues - 1) < _ONE
    radius = float(np.abs(eigenvalues[~ones]).max(initial=0.0))
    return RotationLoop(
        matrix=matrix, eigenvalues=eigenvalues, radius=radius, neutral=int(ones.sum())
    )


def _loop(
    jacobian: ArrayLike, gain: ArrayLike, weights: ArrayLike, learning_rate: float
) -> tuple[FloatArray, FloatArray, FloatArray, float]:
    """Checked D (P, 4, B), H (P, B, 4), W (4,) and kappa."""
    shape = np.shape(jacobian)
    if len(shape) != 3 or shape[1] != 4 or 0 in shape:
        raise LearningError(f"jacobian: got shape {shape}, expected (P, 4, B)")
    positions, _, blades = shape
    return (
        array_of("jacobian", jacobian, shape),
        array_of("gain", gain, (positions, blades, 4)),
        array_of("weights", weights, (4,)),
        number("learning_rate", learning_rate, at_least=0),
    )


def _radius(matrices: FloatArray) -> FloatArray:
    """Spectral radius of each matrix (P, n, n)."""
    return np.asarray(np.abs(np.linalg.eigvals(matrices)).max(axis=1))


def _norm(matrices: FloatArray) -> FloatArray:
    """Largest singular value of each matrix (P, n, k)."""
    return np.asarray(np.linalg.norm(matrices, ord=2, axis=(1, 2)))
