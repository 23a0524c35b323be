"""Natural frequencies of a tower with nacelle and rotor, and their slopes by its sections.

The clamped beam of `pitchopt.sim.structure.tower_model`, with the same elements, head and
weights, one plane at a time:

    (K - lambda M) phi = 0,      phi' M phi = 1,      f = lambda^(1/2) / (2 pi),

    d lambda = phi' (dK - lambda dM) phi,

K with the stiffness that the weights of head and tower take.  For a given height M and K are
linear in mass per length and bending stiffness at the tower's stations; the matrices of that
are made once, and phi is found by simultaneous inverse iteration with banded factors.

Source: R. L. Fox and M. P. Kapoor, Rates of change of eigenvalues and eigenvectors, AIAA Journal
6 (12), 1968, for the slopes; K.-J. Bathe, Finite Element Procedures, chapter 11, for the iteration.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from pitchopt.checks import FloatArray
from pitchopt.errors import ComputationError, InputError
from pitchopt.sim.beams import Beam
from pitchopt.sim.structure import GRAVITY, blade_model, head_matrices, tower_stations
from pitchopt.studies.tower.design import INSIDE, TowerDesign
from pitchopt.turbines import Turbine

__all__ = ["Frequencies", "frequency_curvature", "natural_frequencies"]

_MODES = 2
_BLOCK = 5  # vectors iterated together
_BAND = 4  # diagonals of a beam's matrix, from the main one down
_ROUNDS = 60
_CLOSE = 1e-13  # relative change of the eigenvalues at which the iteration ends


@dataclass(frozen=True)
class Frequencies:
    """Natural frequencies and slopes; rows are fore-aft and side-side.

    Attributes
    ----------
    value : ndarray (2, 2)
        Plane, mode [Hz].
    by_diameter : ndarray (2, 2, E + 1)
        Slope of the logarithm by that of the middle diameters.
    by_thickness : ndarray (2, 2, E)
    shape : ndarray (2, 2, N)
        Deflections and slopes of the modes at the beam's stations, base left out, of unit
        modal mass.
    """

    value: FloatArray
    by_diameter: FloatArray
    by_thickness: FloatArray
    shape: FloatArray


@dataclass(frozen=True)
class _Matrices:
    """Lower bands (4, 2 S - 2) as linear maps of the (H,) sections, and the head's share."""

    element: NDArray[np.intp]  # (H,) of the sections
    share: FloatArray  # (H,) their place in it, 0 to 1
    mass: FloatArray  # (4 N, H)
    elastic: FloatArray
    weight: FloatArray
    head_mass: list[FloatArray]  # (4 N,) each plane
    head_stiffness: list[FloatArray]

    def sections(
        self, design: TowerDesign
    ) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
        """Middle diameter, wall, mass per length, bending stiffness, (H,) each."""
        below, share = self.element, self.share
        t = design.thickness[below]
        d = (1.0 - share) * design.diameter[below] + share * design.diameter[below + 1]
        mu = design.density * np.pi * d * t
        return d, t, mu, design.youngs_modulus * np.pi / 8.0 * d * t * (d**2 + t**2)


def natural_frequencies(design: TowerDesign) -> Frequencies:
    """First two natural frequencies fore-aft and side-side of a tower with its head.

    Raises
    ------
    InputError
        If the turbine lacks what stands on the tower, or the tower buckles under its weights.
    """
    plan = _matrices(design.reference, design.hub_height, design.elements)
    below, share = plan.element, plan.share
    d, t, mu, ei = plan.sections(design)
    square = d**2 + t**2
    mass = plan.mass @ mu
    stiffness = plan.elastic @ ei - plan.weight @ mu
    value = np.empty((2, _MODES))
    by_diameter = np.zeros((2, _MODES, design.elements + 1))
    by_thickness = np.zeros((2, _MODES, design.elements))
    shape = np.empty((2, _MODES, mass.size // _BAND))
    for plane in range(2):
        values, vectors = _lowest(
            stiffness + plan.head_stiffness[plane], mass + plan.head_mass[plane]
        )
        value[plane] = np.sqrt(values) / (2.0 * np.pi)
        shape[plane] = vectors.T
        for mode, (eigenvalue, vector) in enumerate(zip(values, vectors.T, strict=True)):
            pairs = _products(vector)
            slope_mu = mu * (-(pairs @ plan.weight) - eigenvalue * (pairs @ plan.mass))
            slope_ei = ei * (pairs @ plan.elastic)
            # f goes with the root of lambda; mu with d t, EI with d t (d^2 + t^2)
            by_d = (slope_mu + slope_ei * (1.0 + 2.0 * d**2 / square)) / (2.0 * eigenvalue)
            by_t = (slope_mu + slope_ei * (1.0 + 2.0 * t**2 / square)) / (2.0 * eigenvalue)
            np.add.at(by_diameter[plane, mode], below, by_d * (1.0 - share) / d)
            np.add.at(by_diameter[plane, mode], below + 1, by_d * share / d)
            np.add.at(by_thickness[plane, mode], below, by_t)
    return Frequencies(value, by_diameter * design.diameter, by_thickness, shape)


def frequency_curvature(
    design: TowerDesign, frequencies: Frequencies, plane: int, mode: int
) -> FloatArray:
    """Second derivatives of the logarithm of a natural frequency by (ln d, ln t).

    With q_i = (K_i - lambda M_i) phi, m_i = phi' M_i phi and subscripts for derivatives,

        lambda_ij = 2 q_i' psi_j - lambda_i m_j - lambda_j m_i + phi' (K_ij - lambda M_ij) phi,
        (K - lambda M) psi_j = lambda_j M phi - q_j,      psi_j' M phi = 0.

    Terms of the order of (t / d)^2 of a section's own second derivative are left out.

    Returns
    -------
    ndarray (2 E + 1, 2 E + 1), of tower sections with frequencies from `natural_frequencies`.
    """
    plan = _matrices(design.reference, design.hub_height, design.elements)
    d, t, mu, ei = plan.sections(design)
    count, size = design.elements, 2 * design.elements + 1
    phi = frequencies.shape[plane, mode]
    eigenvalue = (2.0 * np.pi * frequencies.value[plane, mode]) ** 2
    rows = np.arange(d.size)
    # slopes of ln d and ln t of the sections by the design's
    below = (1.0 - plan.share) * design.diameter[plan.element] / d
    by_d, by_t = np.zeros((2, d.size, size))
    by_d[rows, plan.element] = below
    by_d[rows, plan.element + 1] = 1.0 - below
    by_t[rows, count + 1 + plan.element] = 1.0
    square = d**2 + t**2
    ln_mu = by_d + by_t
    power = (1.0 + 2.0 * d**2 / square)[:, None]
    ln_ei = power * by_d + (1.0 + 2.0 * t**2 / square)[:, None] * by_t
    mass_phi = _columns(plan.mass, phi) * mu
    weight_phi = _columns(plan.weight, phi) * mu
    elastic_phi = _columns(plan.elastic, phi) * ei
    residual = elastic_phi @ ln_ei - (weight_phi + eigenvalue * mass_phi) @ ln_mu  # q (N, 2E + 1)
    modal = phi @ mass_phi @ ln_mu
    slope = phi @ residual
    mass = _dense(plan.mass @ mu + plan.head_mass[plane])
    stiffness = _dense(plan.elastic @ ei - plan.weight @ mu + plan.head_stiffness[plane])
    inertia = mass @ phi
    bordered = np.zeros((phi.size + 1, phi.size + 1))
    bordered[:-1, :-1] = stiffness - eigenvalue * mass
    bordered[-1, :-1] = bordered[:-1, -1] = inertia
    right = np.vstack([np.outer(inertia, slope) - residual, np.zeros(size)])
    psi = np.linalg.solve(bordered, right)[:-1]
    second = 2.0 * residual.T @ psi
    second -= np.outer(slope, modal) + np.outer(modal, slope)
    s_mu = -(phi @ weight_phi) - eigenvalue * (phi @ mass_phi)
    s_ei = phi @ elastic_phi
    second += (ln_mu * s_mu[:, None]).T @ ln_mu + (ln_ei * s_ei[:, None]).T @ ln_ei
    bend = s_mu + s_ei * power[:, 0]  # of ln d, linear in d, by the logarithms at the nodes
    second += np.diag(bend @ by_d) - (by_d * bend[:, None]).T @ by_d
    second = 0.5 * (second + second.T)
    return np.asarray(0.5 * (second / eigenvalue - np.outer(slope, slope) / eigenvalue**2))


def _columns(bands: FloatArray, vector: FloatArray) -> FloatArray:
    """Products (N, H) of the matrices (4 N, H) in bands with a vector (N,)."""
    parts = bands.reshape(_BAND, vector.size, -1)
    out = parts[0] * vector[:, None]
    for b in range(1, _BAND):
        out[b:] += parts[b, :-b] * vector[:-b, None]
        out[:-b] += parts[b, :-b] * vector[b:, None]
    return np.asarray(out)


def _dense(bands: FloatArray) -> FloatArray:
    """Symmetric matrix (N, N) of its lower bands (4 N,)."""
    parts = bands.reshape(_BAND, -1)
    out = np.diag(parts[0])
    for b in range(1, _BAND):
        out += np.diag(parts[b, :-b], -b) + np.diag(parts[b, :-b], b)
    return out


def _products(vector: FloatArray) -> FloatArray:
    """phi_i phi_j in the order of the bands, off-diagonal ones twice, (4 N,)."""
    bands = np.zeros((_BAND, vector.size))
    bands[0] = vector**2
    for k in range(1, _BAND):
        bands[k, :-k] = 2.0 * vector[k:] * vector[:-k]
    return bands.ravel()


def _lowest(stiffness: FloatArray, mass: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Lowest eigenvalues (2,) and vectors (N, 2) with phi' M phi = 1 of banded matrices."""
    from scipy.linalg import LinAlgError, cho_solve_banded, cholesky_banded, eigh

    k = stiffness.reshape(_BAND, -1)
    count = k.shape[1]
    try:
        factor = cholesky_banded(k, lower=True, check_finite=False)
    except LinAlgError as error:
        raise InputError("tower: not stable under its own and its head's weight") from error
    full = _dense(mass)
    # shapes of rising order to begin with: sums of powers of the height
    height = np.linspace(0.0, 1.0, count // 2 + 1)[1:]
    vectors = np.zeros((count, _BLOCK))
    for b in range(_BLOCK):
        vectors[0::2, b] = height ** (b + 2)
        vectors[1::2, b] = (b + 2) * height ** (b + 1)
    vectors = vectors @ np.linalg.inv(np.linalg.cholesky(vectors.T @ (full @ vectors))).T
    image, last = full @ vectors, np.zeros(_BLOCK)
    for _ in range(_ROUNDS):
        vectors = cho_solve_banded((factor, True), image, check_finite=False)
        # K X = M Y with the Y before: X' K X without the cancellation of short elements
        projected = vectors.T @ image
        image = full @ vectors
        inverse, turn = eigh(vectors.T @ image, 0.5 * (projected + projected.T))
        turn = turn[:, ::-1] / np.sqrt(inverse[::-1])
        vectors, image, values = vectors @ turn, image @ turn, 1.0 / inverse[::-1]
        if np.all(np.abs(values[:_MODES] - last[:_MODES]) <= _CLOSE * values[:_MODES]):
            return values[:_MODES], vectors[:, :_MODES]
        last = values
    raise ComputationError("natural frequencies: the iteration did not settle")


@lru_cache(maxsize=16)
def _matrices(reference: Turbine, hub_height: float, elements: int) -> _Matrices:
    """Matrices of a tower with so many elements on which the reference's head stands."""
    tower = reference.tower
    length = hub_height - reference.rotor.hub_height + tower.top - tower.base
    part = length / elements
    height = np.linspace(0.0, length, elements * INSIDE + 1)
    station = tower_stations(height)
    ones = np.ones(station.size)
    beam = Beam(station, ones, ones[:, None, None] * np.eye(2))
    # the wall jumps at the nodes, so each element has sections of its own at its ends
    element = np.repeat(np.arange(elements), INSIDE + 1)
    share = np.tile(np.linspace(0.0, 1.0, INSIDE + 1), elements)
    inside = beam.points / part
    hats = np.stack(
        [
            np.where(inside.astype(np.intp) == e, 1.0, 0.0)
            * np.maximum(1.0 - np.abs(inside - e - x) * INSIDE, 0.0)
            for e, x in zip(element, share, strict=True)
        ]
    )
    above = np.stack([beam.beyond(hat) for hat in hats])
    head_mass, head = _heads(reference)

    def bands(weight: FloatArray, order: int) -> FloatArray:
        """Bands of the integral of u^(order) w u^(order), rows clamped at the base left out."""
        basis = beam.basis[order]
        element = np.einsum("ep,hep,epa,epb->abeh", beam.weights, weight, basis, basis)
        out = np.zeros((_BAND, 2 * station.size, weight.shape[0]))
        for a in range(4):
            for b in range(a + 1):  # at row a, column b of an element's lower triangle
                out[a - b, b : b + 2 * (station.size - 1) : 2] += element[a, b]
        return out[:, 2:].reshape(-1, weight.shape[0])

    elastic = bands(hats, 2)
    weight = GRAVITY * bands(above, 1)
    under_head = bands(np.full((1, *beam.points.shape), GRAVITY * head_mass), 1)[:, 0]
    masses, stiffnesses = [], []
    for matrix in head:
        mass, stiff = np.zeros((2, _BAND, 2 * station.size - 2))
        mass[0, -2:] = np.diag(matrix)
        mass[1, -2] = matrix[1, 0]
        stiff[0, -1] = -GRAVITY * matrix[0, 1]
        masses.append(mass.ravel())
        stiffnesses.append(stiff.ravel() - under_head)
    return _Matrices(
        element=element,
        share=share,
        mass=bands(hats, 0),
        elastic=elastic,
        weight=weight,
        head_mass=masses,
        head_stiffness=stiffnesses,
    )


@lru_cache(maxsize=4)
def _heads(reference: Turbine) -> tuple[float, list[FloatArray]]:
    return head_matrices(reference, blade_model(reference))
