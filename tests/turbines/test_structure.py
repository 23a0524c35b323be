"""Parts of a turbine: formulas against closed forms, and refusals."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from pitchopt.errors import InputError
from pitchopt.turbines import (
    BladeSections,
    BladeStructure,
    Drivetrain,
    Hub,
    Nacelle,
    Tower,
    Turbine,
    load_turbine,
)

TOWER: dict[str, Any] = {"height": [0.0, 50.0, 100.0], "diameter": [4.0, 4.0, 4.0]}
BEAM: dict[str, Any] = {
    "span": np.linspace(0.0, 60.0, 2001),
    "mass_per_length": np.full(2001, 200.0),
    "flap_stiffness": np.full(2001, 1e9),
    "edge_stiffness": np.full(2001, 2e9),
    "structural_twist": np.zeros(2001),
}


def turbine_with(**changes: Any) -> Turbine:
    """The NREL 5 MW with some fields changed."""
    base = load_turbine("nrel-5mw")
    fields = {k: getattr(base, k) for k in Turbine.__dataclass_fields__}
    return Turbine(**(fields | changes))


def test_tower_of_a_thin_tube() -> None:
    tower = Tower(
        **TOWER,
        thickness=[0.02] * 3,
        density=8500.0,
        youngs_modulus=210e9,
        outfitting_factor=1.1,
    )
    area = np.pi * (4.0 - 0.02) * 0.02
    assert tower.mass == pytest.approx(area * 100.0 * 8500.0 * 1.1)
    assert tower.bending_stiffness is not None
    # Thin ring: I = area D_mean^2 / 8, to the square of the ratio of wall to diameter.
    assert tower.bending_stiffness == pytest.approx(210e9 * area * 3.98**2 / 8.0, rel=1e-4)
    assert tower.base == 0.0
    assert tower.top == 100.0
    assert tower.radius == pytest.approx(2.0)


def test_tower_without_a_wall_has_no_mass() -> None:
    tower = Tower(**TOWER)
    assert tower.mass is None
    assert tower.mass_per_length is None
    assert tower.bending_stiffness is None


def test_given_mass_wins_over_the_computed_one() -> None:
    tower = Tower(**TOWER, thickness=[0.02] * 3, density=8500.0, mass_per_length=[1.0, 1.0, 1.0])
    assert tower.mass == pytest.approx(100.0)


def test_moments_of_a_uniform_blade() -> None:
    blade = BladeStructure(**BEAM)
    assert blade.mass == pytest.approx(200.0 * 60.0)
    assert blade.moment(1) == pytest.approx(200.0 * 60.0**2 / 2.0)
    assert blade.moment(2) == pytest.approx(200.0 * 60.0**3 / 3.0, rel=1e-6)
    assert blade.moment(2, offset=2.0) == pytest.approx(200.0 * (62.0**3 - 2.0**3) / 3.0, rel=1e-6)


@pytest.mark.parametrize(
    ("changes", "what"),
    [
        ({"height": [0.0, 50.0, 50.0]}, r"tower\.height: expected at least 2 strictly increasing"),
        ({"diameter": [4.0, -4.0, 4.0]}, r"tower\.diameter: got -4"),
        ({"diameter": [4.0, 4.0]}, r"tower\.diameter: got shape \(2,\), expected \(3,\)"),
        ({"thickness": [3.0] * 3}, r"tower\.thickness: more than half"),
        ({"density": -1.0}, r"tower\.density: got -1"),
        ({"youngs_modulus": np.nan}, r"tower\.youngs_modulus: got nan"),
        ({"poisson_ratio": 0.9}, r"tower\.poisson_ratio: got 0\.9"),
        ({"damping_ratio": -0.1}, r"tower\.damping_ratio: got -0\.1"),
    ],
)
def test_tower_refuses(changes: dict[str, Any], what: str) -> None:
    with pytest.raises(InputError, match=what):
        Tower(**(TOWER | changes))


@pytest.mark.parametrize(
    ("changes", "what"),
    [
        ({"mass_per_length": np.zeros(2001)}, r"blade_structure\.mass_per_length: got 0"),
        ({"span": np.zeros(2001)}, r"blade_structure\.span: expected at least 2"),
        ({"span": np.linspace(-1.0, 60.0, 2001)}, r"blade_structure\.span: got -1"),
        ({"structural_twist": np.full(2001, np.inf)}, r"blade_structure\.structural_twist: got"),
        ({"damping_ratio": 2.0}, r"blade_structure\.damping_ratio: got 2"),
    ],
)
def test_blade_structure_refuses(changes: dict[str, Any], what: str) -> None:
    with pytest.raises(InputError, match=what):
        BladeStructure(**(BEAM | changes))


def test_small_parts_refuse() -> None:
    with pytest.raises(InputError, match=r"hub\.mass: got -1"):
        Hub(mass=-1.0, inertia=0.0)
    with pytest.raises(InputError, match=r"nacelle\.centre: got shape"):
        Nacelle(mass=1.0, centre=np.zeros(2))
    with pytest.raises(InputError, match=r"drivetrain\.efficiency: got 1\.2"):
        Drivetrain(efficiency=1.2)
    with pytest.raises(InputError, match=r"drivetrain\.efficiency: got 0"):
        Drivetrain(efficiency=0.0)
    with pytest.raises(InputError, match=r"drivetrain\.gear_ratio: got 0"):
        Drivetrain(gear_ratio=0.0)
    with pytest.raises(InputError, match=r"blade\.relative_thickness: got -1"):
        BladeSections(span=np.array([0.0, 1.0]), relative_thickness=np.array([1.0, -1.0]))


@pytest.mark.parametrize(
    ("changes", "what"),
    [
        ({"rotor": None}, r"turbine\.rotor: got NoneType"),
        ({"rated_power": -5e6}, r"turbine\.rated_power: got -5"),
        ({"air_density": -1.225}, r"turbine\.air_density: got -1\.225"),
        ({"pitch_range": (0.5, 0.1)}, r"turbine\.pitch_range: lower limit 0\.5 is above"),
        ({"pitch_range": 0.5}, r"turbine\.pitch_range: got 0\.5, expected a lower"),
        ({"pitch_rate": -0.1}, r"turbine\.pitch_rate: got -0\.1"),
        ({"min_rotor_speed": 2.0}, r"turbine\.min_rotor_speed: got 2, more than rated_rotor"),
        ({"cut_in_wind_speed": 12.0}, r"turbine\.cut_in_wind_speed: got 12, more than rated_wind"),
        ({"alpha_limits": (0.2, 0.1)}, r"turbine\.alpha_limits: lower limit 0\.2 is not below"),
        ({"alpha_limits": 3}, r"turbine\.alpha_limits: got 3"),
        ({"tower": Tower(height=[0.0, 99.0], diameter=[4.0, 4.0])}, r"turbine\.tower\.height: top"),
        ({"fine_pitch": np.nan}, r"turbine\.fine_pitch: got nan"),
    ],
)
def test_turbine_refuses(changes: dict[str, Any], what: str) -> None:
    with pytest.raises(InputError, match=what):
        turbine_with(**changes)


def test_constant_pitch_turbine_is_legal() -> None:
    turbine = turbine_with(pitch_rate=0.0, pitch_range=(0.1, 0.1))
    assert turbine.pitch_rate == 0.0
    assert turbine.pitch_range == (0.1, 0.1)


def test_inertia_needs_blade_and_hub() -> None:
    assert turbine_with(hub=None).rotor_inertia is None
    assert turbine_with(blade_structure=None).rotor_inertia is None
