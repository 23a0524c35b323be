"""Natural frequencies of a tower: the dynamic turbine's, and their derivatives."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from pitchopt.checks import FloatArray
from pitchopt.errors import InputError
from pitchopt.sim import DynamicTurbine
from pitchopt.sim.beams import Beam
from pitchopt.sim.structure import GRAVITY, blade_model, head_matrices, tower_stations
from pitchopt.studies.tower.design import TowerDesign
from pitchopt.studies.tower.frequencies import (
    Frequencies,
    frequency_curvature,
    natural_frequencies,
)
from pitchopt.turbines import Turbine


def _design(
    turbine: Turbine, *, hub_height: float = 110.0, elements: int = 10, seed: int | None = None
) -> TowerDesign:
    diameter = np.linspace(5.9, 3.0, elements + 1)
    thickness = np.linspace(0.05, 0.02, elements)
    if seed is not None:
        rng = np.random.default_rng(seed)
        diameter *= np.exp(0.1 * rng.standard_normal(elements + 1))
        thickness *= np.exp(0.2 * rng.standard_normal(elements))
    return TowerDesign(
        hub_height=hub_height, diameter=diameter, thickness=thickness, reference=turbine
    )


def _by_both(found: Frequencies) -> FloatArray:
    return np.concatenate([found.by_diameter, found.by_thickness], axis=2)


def _moved(design: TowerDesign, step: FloatArray) -> TowerDesign:
    nodes = design.diameter.size
    return dataclasses.replace(
        design,
        diameter=design.diameter * np.exp(step[:nodes]),
        thickness=design.thickness * np.exp(step[nodes:]),
    )


@pytest.mark.parametrize(
    ("hub_height", "elements", "seed"),
    [(110.0, 10, None), (132.0, 10, 3), (99.0, 3, None), (110.0, 30, 4)],
)
def test_first_frequencies_are_those_of_the_dynamic_turbine(
    turbine: Turbine, hub_height: float, elements: int, seed: int | None
) -> None:
    design = _design(turbine, hub_height=hub_height, elements=elements, seed=seed)
    model = DynamicTurbine(turbine=design.turbine).tower.frequency / (2.0 * np.pi)
    assert natural_frequencies(design).value[:, 0] == pytest.approx(model, rel=5e-5)


def test_second_frequency_is_that_of_the_same_beam(turbine: Turbine) -> None:
    """Both planes at once, assembled and solved as the dynamic turbine's tower is."""
    design = _design(turbine, seed=2)
    tower = design.tower
    station = tower_stations(tower.height - tower.base)
    assert tower.mass_per_length is not None
    assert tower.bending_stiffness is not None
    mu = np.interp(station + tower.base, tower.height, tower.mass_per_length)
    ei = np.interp(station + tower.base, tower.height, tower.bending_stiffness)
    beam = Beam(station, mu, ei[:, None, None] * np.eye(2))
    head_mass, head = head_matrices(design.turbine, blade_model(design.turbine))
    inertia = beam.assemble(beam.mass, 0)
    weight = beam.assemble(head_mass + beam.beyond(beam.mass), 1)
    stiff = beam.assemble(beam.stiffness, 2) - GRAVITY * weight
    for plane in range(2):
        part = slice(inertia.shape[0] - 4 + 2 * plane, inertia.shape[0] - 2 + 2 * plane)
        inertia[part, part] += head[plane]
        stiff[part.stop - 1, part.stop - 1] -= GRAVITY * head[plane][0, 1]
    modes, _ = beam.modes(inertia, stiff, 4)
    value = natural_frequencies(design).value
    assert np.sort(value.ravel()) == pytest.approx(modes / (2.0 * np.pi), rel=1e-3)
    assert value[:, 1] == pytest.approx(np.sort(modes)[2:] / (2.0 * np.pi), rel=1e-3)


def test_slopes_are_the_differences(turbine: Turbine) -> None:
    design = _design(turbine, seed=1)
    slopes = _by_both(natural_frequencies(design))
    step = 3e-4
    for k, unit in enumerate(np.eye(21)):
        high, low = (natural_frequencies(_moved(design, s * unit)).value for s in (step, -step))
        difference = (np.log(high) - np.log(low)) / (2.0 * step)
        assert np.allclose(slopes[:, :, k], difference, atol=1e-6), k


def test_slopes_of_a_uniform_change(turbine: Turbine) -> None:
    """Thicker walls all over stiffen as they weigh, so a light head would hardly notice."""
    design = _design(turbine)
    slopes = natural_frequencies(design)
    by_thickness = slopes.by_thickness.sum(axis=2)
    by_diameter = slopes.by_diameter.sum(axis=2)
    assert np.all(by_thickness[:, 0] > 0.0)
    assert np.all(by_thickness[:, 0] < 0.5 + 0.1)  # 1/2 for a massless tower, and its weight
    # EI goes with d^3 and mass with d, walls as they are
    assert np.all(np.abs(by_diameter - by_thickness - 1.0) < 0.05)


@pytest.mark.parametrize(("plane", "mode"), [(0, 0), (0, 1), (1, 0), (1, 1)])
def test_curvature_is_the_difference_of_slopes(turbine: Turbine, plane: int, mode: int) -> None:
    design = _design(turbine, seed=1)
    found = frequency_curvature(design, natural_frequencies(design), plane, mode)
    step = 1e-3
    rows = [
        (
            _by_both(natural_frequencies(_moved(design, step * unit)))[plane, mode]
            - _by_both(natural_frequencies(_moved(design, -step * unit)))[plane, mode]
        )
        / (2.0 * step)
        for unit in np.eye(21)
    ]
    # sections' own terms of (t / d)^2, some 1e-4, are left out
    assert np.allclose(found, rows, atol=1e-4)
    assert np.max(np.abs(found)) > 0.1


def test_logarithm_of_the_first_frequency_is_concave(turbine: Turbine) -> None:
    for seed in range(5):
        design = _design(turbine, seed=seed)
        values = np.linalg.eigvalsh(frequency_curvature(design, natural_frequencies(design), 0, 0))
        assert values.max() < 1e-4


def test_tower_that_buckles(turbine: Turbine) -> None:
    design = TowerDesign(
        hub_height=110.0,
        diameter=np.full(11, 1.0),
        thickness=np.full(10, 0.01),
        reference=turbine,
    )
    with pytest.raises(InputError, match="not stable"):
        natural_frequencies(design)
