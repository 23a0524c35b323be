"""Bending modes of slender beams, clamped at one end, by finite elements.

Euler-Bernoulli beam with bending in two directions u = (u_1, u_2) along s,

    m u'' (time) + (EI u'')'' - (N u')' - c u = 0     (primes along s but the first),

with EI a symmetric 2 x 2 stiffness per section, N the axial force (tension positive: centrifugal
force of a blade, minus the weight above in a tower) and c a stiffness per length (rotation
softens in-plane bending, c = m Omega^2).  Each element is a cubic Hermite polynomial per
direction, integrals by Gauss's rule with four points, properties linear between the stations.

Source: any text on structural dynamics, e.g. R. D. Cook et al., Concepts and Applications of
Finite Element Analysis, chapters 2 and 11.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from pitchopt.checks import FloatArray
from pitchopt.errors import InputError

__all__ = ["Beam", "BeamModes"]

_POINTS, _WEIGHTS = np.polynomial.legendre.leggauss(4)
_POINTS, _WEIGHTS = 0.5 * (_POINTS + 1.0), 0.5 * _WEIGHTS  # on 0 to 1


def _hermite(share: FloatArray, length: float, order: int) -> FloatArray:
    """Cubic Hermite functions (u_0, u_0', u_1, u_1') or derivatives at `share` (P,), (P, 4)."""
    x, h = share, length
    one = np.ones_like(x)
    if order == 0:
        rows = (
            1 - 3 * x**2 + 2 * x**3,
            h * (x - 2 * x**2 + x**3),
            3 * x**2 - 2 * x**3,
            h * (x**3 - x**2),
        )
    elif order == 1:
        rows = (
            (6 * x**2 - 6 * x) / h,
            1 - 4 * x + 3 * x**2,
            (6 * x - 6 * x**2) / h,
            3 * x**2 - 2 * x,
        )
    else:
        rows = (
            (12 * x - 6 * one) / h**2,
            (6 * x - 4 * one) / h,
            (6 * one - 12 * x) / h**2,
            (6 * x - 2 * one) / h,
        )
    return np.stack(rows, axis=1)


@dataclass(frozen=True)
class BeamModes:
    """Natural frequencies and mode shapes of a beam.

    Attributes
    ----------
    frequency : ndarray (K,)
        [rad/s], ascending.
    station : ndarray (S,)
        Positions along the beam [m].
    shape, slope : ndarray (K, S, 2)
        Deflection and its derivative along the beam in the two directions; each mode has a
        largest deflection of 1.
    """

    frequency: FloatArray
    station: FloatArray
    shape: FloatArray
    slope: FloatArray


class Beam:
    """Clamped beam with properties at stations.

    Parameters
    ----------
    station : ndarray (S,)
        Distance from the clamped end [m], ascending from 0.
    mass : ndarray (S,)
        Per length [kg/m].
    stiffness : ndarray (S, 2, 2)
        Bending stiffness [N m^2].

    Attributes
    ----------
    points, weights : ndarray (S - 1, P)
        Gauss points and their weights [m].
    basis : list of ndarray (S - 1, P, 4)
        By order of derivative, the functions of (u, u', u, u') at an element's two ends.
    """

    def __init__(self, station: FloatArray, mass: FloatArray, stiffness: FloatArray) -> None:
        if station.size < 3 or station[0] != 0.0 or np.any(np.diff(station) <= 0.0):
            raise InputError("beam: expected at least 3 ascending stations from 0")
        self.station = station
        length = np.diff(station)
        self.points = station[:-1, None] + length[:, None] * _POINTS
        self.weights = length[:, None] * _WEIGHTS
        self.mass = np.interp(self.points, station, mass)
        self.stiffness = np.empty((*self.points.shape, 2, 2))
        for i in range(2):
            for j in range(2):
                self.stiffness[..., i, j] = np.interp(self.points, station, stiffness[:, i, j])
        self.basis = [
            np.stack([_hermite(_POINTS, float(h), order) for h in length]) for order in range(3)
        ]

    def beyond(self, density: FloatArray) -> FloatArray:
        """Integral of `density`, given at the Gauss points (E, P), from each of them to the tip.

        Within an element the integrand is the polynomial through its Gauss points.
        """
        total = (self.weights * density).sum(axis=1)
        after = np.concatenate([np.cumsum(total[::-1])[::-1][1:], [0.0]])
        inside = np.empty_like(density)
        vandermonde = np.vander(_POINTS, increasing=True)
        powers = np.arange(1, _POINTS.size + 1)
        tails = (1.0 - _POINTS[:, None] ** powers) / powers  # integral of x^(p-1) from x to 1
        rule = tails @ np.linalg.inv(vandermonde)
        inside = density @ rule.T * np.diff(self.station)[:, None]
        return np.asarray(inside + after[:, None])

    def assemble(self, weight: FloatArray, order: int) -> FloatArray:
        """Matrix of the integral of u^(order) . weight . u^(order), (4 S / 2, 4 S / 2).

        Parameters
        ----------
        weight : ndarray (E, P) or (E, P, 2, 2)
            At the Gauss points.
        order : int
            Derivative, 0 to 2.

        Returns
        -------
        ndarray (4 S, 4 S) with unknowns u_1, u_1', u_2, u_2' at each station in turn.
        """
        full = weight if weight.ndim == 4 else weight[..., None, None] * np.eye(2)
        basis = self.basis[order]
        element = np.einsum("ep,epij,epa,epb->eiajb", self.weights, full, basis, basis)
        count = self.station.size
        matrix = np.zeros((4 * count, 4 * count))
        for e in range(count - 1):
            # unknown of direction i, local a = (u0, u0', u1, u1')
            index = np.array(
                [
                    [4 * e + 2 * i, 4 * e + 2 * i + 1, 4 * e + 4 + 2 * i, 4 * e + 5 + 2 * i]
                    for i in range(2)
                ]
            ).ravel()
            matrix[np.ix_(index, index)] += element[e].reshape(8, 8)
        return matrix

    def sample(self, unknowns: FloatArray, order: int) -> FloatArray:
        """Deflection or derivative at the Gauss points, (E, P, 2), of nodal unknowns (4 S,)."""
        nodes = unknowns.reshape(self.station.size, 2, 2)
        local = np.concatenate([nodes[:-1], nodes[1:]], axis=2)  # (E, 2, 4)
        return np.asarray(np.einsum("epa,eia->epi", self.basis[order], local))

    def at(self, unknowns: FloatArray, where: FloatArray, order: int) -> FloatArray:
        """Deflection or derivative (W, 2) at positions `where` (W,) [m]."""
        nodes = unknowns.reshape(self.station.size, 2, 2)
        last = self.station.size - 2
        element = np.clip(np.searchsorted(self.station, where, side="right") - 1, 0, last)
        out = np.empty((where.size, 2))
        for w, e in enumerate(element):
            length = float(self.station[e + 1] - self.station[e])
            share = np.array([(where[w] - self.station[e]) / length])
            basis = _hermite(share, length, order)[0]
            out[w] = np.concatenate([nodes[e], nodes[e + 1]], axis=1) @ basis
        return out

    def modes(
        self, mass: FloatArray, stiffness: FloatArray, count: int
    ) -> tuple[FloatArray, FloatArray]:
        """Lowest natural frequencies [rad/s] and unknowns (count, 4 S) of the clamped beam.

        `mass` and `stiffness` are assembled matrices; the first station is clamped.  Each mode
        is scaled to a largest deflection of 1 at any station, positive there in the direction
        in which it is largest.

        Raises
        ------
        InputError
            If the stiffness is not positive, e.g. a tower that buckles under its own weight.
        """
        from scipy.linalg import LinAlgError, eigh  # heavy import, only needed here

        size = mass.shape[0] - 4
        try:
            # the inverse, whose largest values short elements do not spoil
            inverse, vectors = eigh(
                mass[4:, 4:], stiffness[4:, 4:], subset_by_index=(size - count, size - 1)
            )
        except LinAlgError as error:
            raise InputError(
                "beam: not stable under its axial load, lowest stiffness is negative"
            ) from error
        values, vectors = 1.0 / inverse[::-1], vectors[:, ::-1]
        shapes = np.zeros((count, mass.shape[0]))
        shapes[:, 4:] = vectors.T
        for shape in shapes:
            deflection = shape.reshape(-1, 2, 2)[:, :, 0].ravel()
            shape /= deflection[int(np.argmax(np.abs(deflection)))]
        return np.sqrt(values), shapes
