"""Reduced blades and towers: frequencies and shapes of the NREL 5 MW, and the integrals."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from pitchopt.errors import InputError
from pitchopt.sim.structure import blade_model, tower_model
from pitchopt.turbines import load_turbine, names

HERTZ = 1.0 / (2.0 * np.pi)
# shapes in the input files of the turbine (OpenFAST/r-test): powers 2 to 6 of the relative span
FLAP = (0.0622, 1.7254, -3.2452, 4.7131, -2.2555)
EDGE = (0.3627, 2.5337, -3.5772, 2.376, -0.6952)
FORE_AFT = (0.7004, 2.1963, -5.6202, 6.2275, -2.504)
SIDE_SIDE = (1.385, -1.7684, 3.0871, -2.2395, 0.5357)


def polynomial(coefficients: tuple[float, ...], at: np.ndarray) -> np.ndarray:
    return np.polynomial.Polynomial([0.0, 0.0, *coefficients])(at)


def test_frequencies_of_the_nrel_5mw() -> None:
    """NREL/TP-500-38060, table 9-1: tower 0.32, flap 0.67 to 0.70, edge 1.08 to 1.09 Hz."""
    turbine = load_turbine("nrel-5mw")
    blade = blade_model(turbine)
    tower = tower_model(turbine, blade)
    assert tower.frequency * HERTZ == pytest.approx([0.3195, 0.3164], rel=0.015)  # by ADAMS
    assert blade.frequency * HERTZ == pytest.approx([0.68, 1.085], rel=0.01)


def test_shapes_of_the_nrel_5mw() -> None:
    turbine = load_turbine("nrel-5mw")
    blade = blade_model(turbine)
    share = np.clip(turbine.rotor.blade.span / 61.5, 0.0, 1.0)
    assert blade.node_shape[:, 0, 0] == pytest.approx(polynomial(FLAP, share), abs=0.008)
    assert blade.node_shape[:, 1, 1] == pytest.approx(polynomial(EDGE, share), abs=0.006)
    tower = tower_model(turbine, blade)
    height = tower.height / 87.6
    assert tower.shape[0] == pytest.approx(polynomial(FORE_AFT, height), abs=0.0095)
    assert tower.shape[1] == pytest.approx(polynomial(SIDE_SIDE, height), abs=0.0095)


def test_polynomial_tower_is_stiffer_than_the_eigenmode() -> None:
    """Rayleigh: no other shape has a lower frequency; that of the input file is 3 % above."""
    turbine = load_turbine("nrel-5mw")
    blade = blade_model(turbine)
    own = tower_model(turbine, blade)
    given = tower_model(turbine, blade, polynomials=(FORE_AFT, SIDE_SIDE))
    assert np.all(given.frequency > own.frequency)
    assert given.frequency[0] / own.frequency[0] == pytest.approx(1.034, abs=0.004)


@pytest.mark.parametrize("key", names()[1:])
def test_integrals(key: str) -> None:
    turbine = load_turbine(key)
    data = turbine.blade_structure
    assert data is not None
    blade = blade_model(turbine)
    tower = tower_model(turbine, blade, sections=7)
    assert blade.mass == pytest.approx(data.mass, rel=1e-12)
    fine = np.linspace(0.0, data.span[-1], 20001)
    mass = np.interp(fine, data.span, data.mass_per_length)
    arm = fine + turbine.rotor.hub_radius
    assert blade.first == pytest.approx(np.trapezoid(mass * arm, fine), rel=1e-6)
    assert blade.second == pytest.approx(np.trapezoid(mass * arm**2, fine), rel=1e-6)
    # matrices: symmetric, and positive where they must be
    for matrix in (blade.stiffness, blade.damping, blade.tension_gravity, blade.tension_rotation):
        assert matrix == pytest.approx(matrix.T, abs=1e-9 * np.abs(matrix).max())
        assert np.linalg.eigvalsh(matrix)[0] > 0.0
    modal = np.einsum("idjd->ij", blade.coupling)
    assert np.linalg.eigvalsh(modal)[0] > 0.0
    # loads that are uniform in the shape's direction: weights sum to the integral of U
    span = turbine.rotor.blade.span
    total = blade.node_weight.sum(axis=0)
    by_hand = np.trapezoid(blade.node_shape, span, axis=0)
    assert total == pytest.approx(by_hand, rel=0.03, abs=0.05)
    assert tower.shape[:, 0] == pytest.approx(0.0, abs=1e-12)
    assert tower.shape[:, -1] == pytest.approx(1.0)
    assert np.all(np.diff(tower.shape, axis=1) > 0.0)
    assert tower.mass_above[0] == pytest.approx(turbine.tower.mass, rel=1e-3)
    assert np.all(tower.frequency * HERTZ > 0.15)


def test_damping_ratios() -> None:
    """Blade modes at rest and the tower without its head have the ratio asked for."""
    turbine = load_turbine("nrel-5mw")
    blade = blade_model(turbine, damping_ratio=0.02)
    modal = np.einsum("idjd->ij", blade.coupling)
    ratio = np.diag(blade.damping) / (2.0 * np.sqrt(np.diag(blade.stiffness) * np.diag(modal)))
    assert ratio == pytest.approx(0.02, rel=1e-9)
    tower = tower_model(turbine, blade, damping_ratio=0.03)
    ratio = tower.damping / (2.0 * np.sqrt(tower.stiffness * tower.mass))
    assert ratio == pytest.approx(0.03, rel=1e-9)


def test_missing_data() -> None:
    turbine = load_turbine("nrel-5mw")
    blade = blade_model(turbine)
    with pytest.raises(InputError, match="has no blade structure"):
        blade_model(load_turbine("biegel2011"))
    with pytest.raises(InputError, match="mass of hub or nacelle is not known"):
        tower_model(dataclasses.replace(turbine, hub=None), blade)
    with pytest.raises(InputError, match="damping_ratio: got 2"):
        blade_model(turbine, damping_ratio=2.0)
    with pytest.raises(InputError, match="zero at the tower top"):
        tower_model(turbine, blade, polynomials=np.zeros((2, 5)))
