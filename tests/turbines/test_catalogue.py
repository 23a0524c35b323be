"""Catalogue of turbines: published figures, formulas, units and what a wrong key says."""

from __future__ import annotations

import subprocess
import sys

import numpy as np
import pytest

from pitchopt.errors import InputError
from pitchopt.turbines import Turbine, biegel_blade, load_turbine, names, summary

DEG = np.pi / 180.0
RPM = np.pi / 30.0


def test_names_are_the_six_keys() -> None:
    assert names() == (
        "biegel2011",
        "nrel-5mw",
        "iea-3.4-130",
        "iea-10-198",
        "iea-15-240",
        "iea-22-280",
    )


# Nominal size, power and speed: NREL/TP-500-38060 (5 MW), NREL/TP-73492 (3.4 and 10 MW),
# NREL/TP-5000-75698 (15 MW), DTU Wind E-0243 (22 MW). Masses as commonly quoted for them.
PUBLISHED = [
    # key, diameter, hub height, rated MW, rated rpm, blade t, tower t
    ("nrel-5mw", 126.0, 90.0, 5.0, 12.1, 17.740, 347.46),
    ("iea-3.4-130", 130.0, 110.0, 3.37, 11.75, 16.441, None),
    ("iea-10-198", 198.0, 119.0, 10.0, 8.68, None, None),
    ("iea-15-240", 240.0, 150.0, 15.0, 7.56, 65.25, 860.0),
    ("iea-22-280", 284.0, 170.0, 22.0, 7.06, None, None),
]


@pytest.mark.parametrize(("key", "diameter", "hub", "power", "rpm", "blade", "tower"), PUBLISHED)
def test_published_figures(
    key: str,
    diameter: float,
    hub: float,
    power: float,
    rpm: float,
    blade: float | None,
    tower: float | None,
) -> None:
    figures = summary(load_turbine(key))
    assert figures["rotor_diameter"] == pytest.approx(diameter, rel=0.01)
    assert figures["hub_height"] == pytest.approx(hub, abs=1e-9)
    assert figures["rated_power"] == pytest.approx(power * 1e6)
    assert figures["rated_rotor_speed_rpm"] == pytest.approx(rpm, rel=0.011)
    if blade is not None:
        assert figures["blade_mass"] == pytest.approx(blade * 1e3, rel=0.03)
    if tower is not None:
        assert figures["tower_mass"] == pytest.approx(tower * 1e3, rel=0.01)


@pytest.mark.parametrize(
    ("key", "blade", "tower"),
    [
        ("iea-10-198", 48_902.0, 1_104_713.0),
        ("iea-15-240", 66_997.0, 853_910.0),
        ("iea-22-280", 82_493.0, 1_574_168.0),
    ],
)
def test_regression_masses_of_the_full_source_files(key: str, blade: float, tower: float) -> None:
    # Integrals over every station of the windIO files that the data were made from.
    figures = summary(load_turbine(key))
    assert figures["blade_mass"] == pytest.approx(blade, rel=0.006)
    assert figures["tower_mass"] == pytest.approx(tower, rel=1e-4)


def test_nrel_5mw_is_aerodyns_blade() -> None:
    turbine = load_turbine("nrel-5mw")
    blade = turbine.rotor.blade
    assert blade.span.size == 19
    assert blade.span[[1, 5, 18]] == pytest.approx([1.3667, 14.35, 61.4999], abs=1e-9)
    assert blade.chord[[0, 5, 18]] == pytest.approx([3.542, 4.652, 1.419], abs=1e-9)
    assert blade.twist[[0, 5, 17]] / DEG == pytest.approx([13.308, 11.48, 0.106], abs=1e-6)
    prebend, sweep = blade.offsets
    assert prebend[5] == pytest.approx(-0.11573354, rel=1e-6)
    assert sweep[5] == pytest.approx(-0.56986665, rel=1e-6)
    expected = ["Cylinder1"] * 3 + ["Cylinder2", "DU40_A17", "DU35_A17", "DU35_A17", "DU30_A17"]
    expected += ["DU25_A17"] * 2 + ["DU21_A17"] * 2 + ["NACA64_A17"] * 7
    assert [polar.name for polar in blade.polars] == expected
    # Rows of OpenFAST's own tables (not the smoothed ones of the windIO file).
    tip = blade.polars[-1].coefficients(np.array([0.0, 9.0]) * DEG)
    assert np.array(tip) == pytest.approx(
        np.array([[0.442, 1.326], [0.0052, 0.0136], [-0.1014, -0.1160]])
    )
    middle = blade.polars[8].coefficients(10.0 * DEG)
    assert [float(c) for c in middle] == pytest.approx([1.442, 0.0262, -0.1152])


def test_nrel_5mw_structure_matches_openfast() -> None:
    turbine = load_turbine("nrel-5mw")
    structure, tower = turbine.blade_structure, turbine.tower
    assert structure is not None
    # ElastoDyn's 17 sections give these; here linear between the 49 stations.
    assert structure.mass == pytest.approx(17_537.0, rel=0.005)
    assert structure.moment(1) == pytest.approx(362_133.0, rel=0.005)
    assert structure.moment(2) == pytest.approx(11_752_352.0, rel=0.006)
    assert turbine.rotor_inertia == pytest.approx(38_677_041.0, rel=0.006)
    # Tower of NREL/TP-500-38060: whole, and the ends.
    assert tower.mass == pytest.approx(347_460.0, rel=1e-4)
    assert tower.mass_per_length is not None
    assert tower.bending_stiffness is not None
    assert tower.mass_per_length[[0, -1]] == pytest.approx([5590.87, 2536.27], rel=1e-5)
    assert tower.bending_stiffness[0] == pytest.approx(614.343e9, rel=1e-5)
    assert tower.radius[tower.height >= 85.268] == pytest.approx(1.935)
    # The baseline controller holds 5 296 610 W of mechanical power.
    assert turbine.rated_torque is not None
    power = turbine.rated_torque * turbine.rated_rotor_speed
    assert power == pytest.approx(5_296_610.0, rel=1e-5)


@pytest.mark.parametrize("key", names())
def test_every_turbine_is_complete_and_in_radians(key: str) -> None:
    turbine = load_turbine(key)
    rotor, blade = turbine.rotor, turbine.rotor.blade
    assert turbine.name == key
    assert len(turbine.source) > 20
    assert turbine.notes
    assert np.abs(blade.twist).max() < 30.0 * DEG
    assert 0.0 <= rotor.tilt < 7.0 * DEG
    assert 0.0 <= rotor.cone < 5.0 * DEG
    assert turbine.pitch_range[0] < turbine.pitch_range[1] < 91.0 * DEG
    assert 1.0 * DEG < turbine.pitch_rate < 11.0 * DEG
    for polar in blade.polars:
        assert polar.alpha[[0, -1]] == pytest.approx([-np.pi, np.pi])
        assert np.all(polar.cd > 0.0)
    assert blade.polars[-1].lifting
    # Tip speed of every one of them is between 60 and 105 m/s.
    assert 60.0 < turbine.rated_rotor_speed * rotor.radius < 105.1
    assert turbine.tower.top <= rotor.hub_height
    if key == "biegel2011":
        return
    assert turbine.hub is not None
    assert turbine.nacelle is not None
    assert turbine.nacelle.mass > turbine.hub.mass
    assert turbine.blade_structure is not None
    structure = turbine.blade_structure
    assert structure.span[-1] == pytest.approx(blade.length, rel=0.01)
    # Flap is the soft direction over most of the blade.
    outer = structure.span > 0.2 * structure.span[-1]
    assert np.mean(structure.flap_stiffness[outer] < structure.edge_stiffness[outer]) > 0.9
    assert turbine.drivetrain.efficiency is not None
    assert 0.9 < turbine.drivetrain.efficiency < 1.0
    # Power coefficient at the stated rated wind speed is one that a rotor can have.
    if turbine.rated_wind_speed is not None and turbine.rated_torque is not None:
        area = np.pi * rotor.radius**2
        power = turbine.rated_torque * turbine.rated_rotor_speed
        cp = power / (0.5 * turbine.air_density * area * turbine.rated_wind_speed**3)
        assert 0.42 < cp < 0.5


def test_iea_blades_bend_upwind_and_lead() -> None:
    for key in ("iea-3.4-130", "iea-10-198", "iea-15-240", "iea-22-280"):
        prebend, sweep = load_turbine(key).rotor.blade.offsets
        assert prebend[-1] < -2.0  # tips upwind
        assert np.all(sweep[15:-1] < 0.0)  # aerodynamic centre ahead of the pitch axis


def test_biegel_follows_its_formula() -> None:
    turbine = load_turbine("biegel2011")
    blade = turbine.rotor.blade
    radius = np.array([16.0, 32.0])
    assert blade.quadrature == "elements"
    assert turbine.rotor.hub_radius + blade.span == pytest.approx(radius)
    expected = np.arctan(15.0 / (2.0 * radius)) - np.arctan(15.0 / 80.0)
    assert blade.twist == pytest.approx(expected, abs=1e-12)
    assert turbine.rotor.radius == pytest.approx(40.0)
    assert turbine.rated_rotor_speed == pytest.approx(2.0, rel=1e-6)
    assert turbine.alpha_limits == (pytest.approx(-5.0 * DEG), None)
    assert turbine.pitch_rate == pytest.approx(10.0 * DEG)
    assert blade.chord == pytest.approx(0.957361846)
    assert turbine.tower.radius == pytest.approx(0.967352595)


@pytest.mark.parametrize("elements", [1, 2, 10, 50])
def test_biegel_blade_of_any_number_of_elements(elements: int) -> None:
    blade = biegel_blade(elements)
    edges = blade.edges
    assert edges == pytest.approx(np.linspace(0.0, 32.0, elements + 1), abs=1e-9)
    radius = 8.0 + blade.span
    twist = np.arctan(15.0 / (2.0 * radius)) - np.arctan(15.0 / 80.0)
    assert blade.twist == pytest.approx(twist, abs=1e-12)
    assert biegel_blade(elements, chord=1.5).chord == pytest.approx(1.5)


@pytest.mark.parametrize("elements", [0, -1, 2.5, True])
def test_biegel_blade_refuses(elements: object) -> None:
    with pytest.raises(InputError, match="elements: got"):
        biegel_blade(elements)


def test_biegel_blade_refuses_a_negative_chord() -> None:
    with pytest.raises(InputError, match=r"blade\.chord: got -1"):
        biegel_blade(2, chord=-1.0)


@pytest.mark.parametrize(
    ("key", "hint"),
    [
        ("nrel5mw", "did you mean 'nrel-5mw'"),
        ("IEA-15-240", "did you mean 'iea-15-240'"),
        ("biegel", "did you mean 'biegel2011'"),
    ],
)
def test_unknown_key_names_keys_and_nearest(key: str, hint: str) -> None:
    with pytest.raises(InputError) as caught:
        load_turbine(key)
    message = str(caught.value)
    assert hint in message
    assert all(name in message for name in names())
    assert "\n" not in message


def test_unknown_key_without_a_neighbour() -> None:
    with pytest.raises(InputError, match="turbine: got 'zzz'") as caught:
        load_turbine("zzz")
    assert "did you mean" not in str(caught.value)


def test_turbines_cannot_be_changed() -> None:
    turbine = load_turbine("nrel-5mw")
    assert load_turbine("nrel-5mw") is turbine
    with pytest.raises(AttributeError):
        turbine.rated_power = 1.0
    with pytest.raises(ValueError, match="read-only"):
        turbine.tower.diameter[0] = 1.0
    with pytest.raises(TypeError):
        turbine.notes["blade"] = "else"
    assert isinstance(turbine, Turbine)


def test_catalogue_needs_no_yaml() -> None:
    code = (
        "import sys, pitchopt.turbines as t; t.load_turbine('iea-22-280');"
        "sys.exit('yaml' in sys.modules or 'cvxpy' in sys.modules)"
    )
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0
