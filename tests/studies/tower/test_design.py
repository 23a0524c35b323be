"""Tower designs: sections, masses, the tower they make, joints."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from pitchopt.errors import InputError
from pitchopt.studies.tower.design import TowerDesign, station_joints
from pitchopt.turbines import Turbine


def _design(turbine: Turbine, **change: object) -> TowerDesign:
    values: dict[str, object] = {
        "hub_height": 110.0,
        "diameter": np.linspace(5.9, 2.98, 11),
        "thickness": np.linspace(0.05, 0.02, 10),
        "reference": turbine,
    }
    return TowerDesign(**{**values, **change})  # type: ignore[arg-type]


def test_mass_is_that_of_rings_of_metal(turbine: Turbine) -> None:
    design = _design(turbine)
    part = design.length / 10
    # outer cone less inner cone, by the prismoid of a truncated cone
    volume = 0.0
    for e in range(10):
        outer = design.diameter[e : e + 2] + design.thickness[e]
        inner = design.diameter[e : e + 2] - design.thickness[e]
        volume += sum(
            sign * np.pi / 12.0 * part * (a[0] ** 2 + a[0] * a[1] + a[1] ** 2)
            for sign, a in ((1.0, outer), (-1.0, inner))
        )
    assert design.mass == pytest.approx(8500.0 * volume, rel=1e-12)
    assert design.mass == pytest.approx(design.element_masses.sum())


def test_tower_for_the_turbine_has_the_same_mass_and_ends(turbine: Turbine) -> None:
    design = _design(turbine, hub_height=125.0)
    tower = design.turbine.tower
    assert tower.mass == pytest.approx(design.mass, rel=1e-5)
    assert design.turbine.rotor.hub_height == 125.0
    assert tower.top == pytest.approx(125.0 - (110.0 - turbine.tower.top))
    assert tower.base == turbine.tower.base
    assert tower.thickness is not None
    # at the base, the top and in the middle of an element
    middle = np.interp(design.length * 0.05 + tower.base, tower.height, tower.diameter)
    assert middle == pytest.approx(design.diameter[:2].mean() + design.thickness[0])
    assert tower.diameter[-1] == design.diameter[-1] + design.thickness[-1]
    assert tower.drag_coefficient is not None
    assert np.all(tower.drag_coefficient == 0.5)


@given(st.integers(2, 40), st.integers(1, 40))
def test_joints_are_stations_in_their_elements(stations: int, elements: int) -> None:
    joints = station_joints(stations, elements)
    height = (joints.element + joints.share) / elements
    assert np.allclose(height, joints.station / (stations - 1), atol=1e-12)
    assert set(joints.station) == set(range(stations))
    assert np.all((joints.share >= 0.0) & (joints.share <= 1.0))
    inner = [s for s in range(1, stations - 1) if s * elements % (stations - 1) == 0]
    assert joints.station.size == stations + len(inner)


def test_nineteen_stations_on_ten_elements_have_twenty_joints() -> None:
    joints = station_joints(19, 10)
    assert joints.station.size == 20
    assert list(joints.element[joints.station == 9]) == [4, 5]
    assert list(joints.share[joints.station == 9]) == [1.0, 0.0]


def test_change_is_the_largest_of_all(turbine: Turbine) -> None:
    design = _design(turbine)
    wall = design.thickness.copy()
    wall[3] *= 0.9
    assert _design(turbine, thickness=wall).change_from(design) == pytest.approx(0.1)
    assert design.change_from(design) == 0.0


@pytest.mark.parametrize(
    ("change", "match"),
    [
        ({"thickness": np.full(9, 0.02)}, "diameter"),
        ({"thickness": np.full(10, -0.02)}, "positive"),
        ({"thickness": np.full(10, 1.6)}, "half the diameter"),
        ({"hub_height": 1.0}, "hub_height"),
        ({"diameter": np.full(11, np.nan)}, "diameter"),
    ],
)
def test_bad_designs(turbine: Turbine, change: dict[str, object], match: str) -> None:
    with pytest.raises(InputError, match=match):
        _design(turbine, **change)


def test_tower_without_material(turbine: Turbine) -> None:
    bare = dataclasses.replace(turbine, tower=dataclasses.replace(turbine.tower, density=None))
    with pytest.raises(InputError, match="density"):
        _design(bare)
