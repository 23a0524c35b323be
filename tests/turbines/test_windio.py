"""windIO v2 reader: what arrives, in which signs, and that every mistake is named by its key."""

from __future__ import annotations

import copy
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from pitchopt.errors import InputError
from pitchopt.turbines import Turbine, load_turbine, read_windio

SAMPLE = Path(__file__).parent / "data" / "nrel5mw_small.yaml"
DEG = np.pi / 180.0
CONTENT: dict[str, Any] = yaml.safe_load(SAMPLE.read_text())


def at(data: Any, path: str) -> tuple[Any, Any]:
    """Container and last key of a dotted path, list indices as numbers."""
    *parents, last = [int(key) if key.isdigit() else key for key in path.split(".")]
    for key in parents:
        data = data[key]
    return data, last


def written(folder: Path, path: str, value: Any = ..., **others: Any) -> Path:
    """The sample with the value at `path` replaced, or removed where it is `...`."""
    data = copy.deepcopy(CONTENT)
    changes = {path: value} | {k.replace("__", "."): v for k, v in others.items()}
    for key, new in changes.items():
        owner, last = at(data, key)
        if new is ...:
            del owner[last]
        else:
            owner[last] = new
    file = folder / "changed.yaml"
    file.write_text(yaml.dump(data, Dumper=getattr(yaml, "CSafeDumper", yaml.SafeDumper)))
    return file


@pytest.fixture(scope="module")
def turbine() -> Turbine:
    return read_windio(SAMPLE)


def test_headline_figures(turbine: Turbine) -> None:
    assert turbine.name == "5MW"
    assert turbine.rated_power == 5e6
    assert turbine.rotor.radius == pytest.approx(63.0)
    assert turbine.rotor.hub_height == 90.0
    assert turbine.rotor.tilt == pytest.approx(5.0 * DEG, rel=1e-3)
    assert turbine.rotor.cone == pytest.approx(2.5 * DEG, rel=1e-3)
    assert turbine.iec_class == "IB"
    assert turbine.pitch_range == pytest.approx((0.0, 90.0 * DEG), abs=1e-3)
    assert turbine.rated_rotor_speed == pytest.approx(12.1 * np.pi / 30.0, rel=1e-5)
    assert turbine.drivetrain.gear_ratio == 97.0
    assert turbine.drivetrain.efficiency == pytest.approx(0.944)
    assert turbine.nacelle is not None
    assert turbine.nacelle.mass == 240e3
    assert turbine.nacelle.yaw_inertia == 2607890.0


def test_overhang_is_turned_from_horizontal_to_along_the_shaft(turbine: Turbine) -> None:
    assert turbine.rotor.overhang == pytest.approx(5.0191, abs=1e-3)  # OpenFAST's


@pytest.mark.parametrize("nodes", [12, 30, 80])
def test_chord_and_twist_at_the_nodes(nodes: int) -> None:
    blade = read_windio(SAMPLE, nodes=nodes).rotor.blade
    parts = CONTENT["components"]["blade"]
    z, shape = parts["reference_axis"]["z"], parts["outer_shape"]
    assert blade.span.size == nodes
    assert blade.span[[0, -1]] == pytest.approx([0.0, 61.5])
    grid = np.interp(blade.span, z["values"], z["grid"])
    chord = np.interp(grid, shape["chord"]["grid"], shape["chord"]["values"])
    twist = np.interp(grid, shape["twist"]["grid"], shape["twist"]["values"])
    assert blade.chord == pytest.approx(chord, rel=1e-6)
    assert blade.twist == pytest.approx(twist * DEG, abs=1e-7)


def test_own_grid_reproduces_aerodyns_centres() -> None:
    ours = read_windio(SAMPLE, nodes=None).rotor.blade
    aerodyn = load_turbine("nrel-5mw").rotor.blade
    assert ours.span == pytest.approx(aerodyn.span, abs=2e-3)
    assert ours.chord == pytest.approx(aerodyn.chord, rel=1e-6)
    # Towards the cylinders AeroDyn's file fades the offset out; outside of 14 m they agree.
    for mine, theirs in zip(ours.offsets, aerodyn.offsets, strict=True):
        assert mine[5:] == pytest.approx(theirs[5:], abs=2e-3)


def test_offsets_follow_the_file(tmp_path: Path) -> None:
    prebend = {"grid": [0.0, 1.0], "values": [0.0, -3.0]}
    sweep = {"grid": [0.0, 1.0], "values": [0.0, 1.5]}
    base = read_windio(SAMPLE).rotor.blade
    axis = "components.blade.reference_axis"
    file = written(tmp_path, f"{axis}.x", prebend, components__blade__reference_axis__y=sweep)
    bent = read_windio(file).rotor.blade
    along = base.span / base.span[-1]
    assert bent.offsets[0] - base.offsets[0] == pytest.approx(-3.0 * along, abs=1e-4)
    assert bent.offsets[1] - base.offsets[1] == pytest.approx(1.5 * along, abs=1e-4)


def test_polars_are_blended_in_relative_thickness(tmp_path: Path) -> None:
    # DU25 has 25 %, DU21 21 % thickness: 24 % is a quarter of the way.
    value = {"grid": [0.0, 1.0], "values": [0.24, 0.24]}
    file = written(tmp_path, "components.blade.outer_shape.rthick", value)
    polar = read_windio(file).rotor.blade.polars[10]
    tables = {a["name"]: a["polars"][0]["re_sets"][0] for a in CONTENT["airfoils"]}
    angles = np.array([-5.0, 0.0, 4.0, 10.5])
    thick, thin = (
        np.interp(angles, tables[n]["cl"]["grid"], tables[n]["cl"]["values"])
        for n in ("DU25_A17", "DU21_A17")
    )
    cl = polar.coefficients(angles * DEG)[0]
    assert cl == pytest.approx(0.75 * thick + 0.25 * thin, abs=1e-6)


def test_polars_follow_the_span_without_thickness(tmp_path: Path) -> None:
    file = written(tmp_path, "components.blade.outer_shape.rthick")
    blade = read_windio(file).rotor.blade
    assert blade.polars[0].name == "Cylinder1"
    assert blade.polars[-1].name == "NACA64_A17"
    assert blade.polars[-2].lifting


def test_equally_thick_airfoils_change_where_the_file_says() -> None:
    blade = read_windio(SAMPLE, nodes=None).rotor.blade
    assert [p.name for p in blade.polars[:2]] == ["Cylinder1", "Cylinder2"]


def test_structure(turbine: Turbine) -> None:
    structure, tower = turbine.blade_structure, turbine.tower
    assert structure is not None
    beam = CONTENT["components"]["blade"]["structure"]["elastic_properties"]
    assert structure.flap_stiffness == pytest.approx(beam["stiffness_matrix"]["K55"], rel=1e-6)
    assert structure.edge_stiffness == pytest.approx(beam["stiffness_matrix"]["K44"], rel=1e-6)
    assert structure.mass == pytest.approx(16_845.0, rel=1e-3)  # without the factor 1.04536
    assert tower.top == pytest.approx(87.6)
    assert tower.mass == pytest.approx(347_460.0, rel=0.01)


def test_stiffness_is_about_the_tension_centre(tmp_path: Path) -> None:
    # A section shifted by y = -c from the axis: K34 = K33 c adds K33 c^2 to K44.
    path = "components.blade.structure.elastic_properties.stiffness_matrix"
    owner, last = at(copy.deepcopy(CONTENT), path)
    beam = owner[last]
    k33, k44 = np.array(beam["K33"]), np.array(beam["K44"])
    beam = beam | {"K34": (0.1 * k33).tolist(), "K44": (k44 + 0.01 * k33).tolist()}
    structure = read_windio(written(tmp_path, path, beam)).blade_structure
    assert structure is not None
    assert structure.edge_stiffness == pytest.approx(k44, rel=1e-5)


def test_numbers_that_yaml_leaves_as_text_count(tmp_path: Path) -> None:
    file = tmp_path / "text.yaml"
    file.write_text(SAMPLE.read_text().replace("rated_power: 5000000.0", "rated_power: 5e6"))
    assert read_windio(file).rated_power == 5e6


def test_optional_parts_may_be_absent(tmp_path: Path) -> None:
    bare = written(
        tmp_path,
        "components.blade.structure",
        components__tower__structure=...,
        components__drivetrain__elastic_properties=...,
        components__drivetrain__generator=...,
        components__drivetrain__gearbox=...,
        control__optimal_tsr=...,
        comments=...,
    )
    turbine = read_windio(bare)
    assert turbine.blade_structure is None
    assert turbine.nacelle is None
    assert turbine.tower.mass is None
    assert turbine.rated_torque is None
    assert turbine.optimal_tip_speed_ratio is None


SHAPE = "components.blade.outer_shape"
NAN, INF = float("nan"), float("inf")
MISTAKES = [
    ("windIO_version", "1.0", "got '1.0'"),
    ("windIO_version", ..., "windIO_version: the key is missing"),
    ("components.hub.diameter", -3.0, "components.hub.diameter: got -3.0"),
    ("components.hub.diameter", NAN, "components.hub.diameter: got nan"),
    ("components.hub.diameter", None, "components.hub.diameter: got None"),
    ("components.hub.diameter", True, "components.hub.diameter: got True"),
    ("components.hub.diameter", "wide", "components.hub.diameter: got 'wide'"),
    ("components.hub.diameter", [3.0], "components.hub.diameter: got [3.0]"),
    ("components.hub", ..., "components.hub: the key is missing"),
    ("components.hub", 3, "components.hub: got 3, expected a mapping"),
    ("components", [], "components: got []"),
    ("assembly.hub_height", INF, "assembly.hub_height: got inf"),
    ("assembly.hub_height", 80.0, "assembly.hub_height: got 80 m, expected at least the tower"),
    ("assembly.rotor_diameter", 200.0, "assembly.rotor_diameter: got 200 m, but hub and blade"),
    (
        "assembly.rated_power",
        0,
        "assembly.rated_power: got 0, expected a finite number at least 1000 and",
    ),
    ("assembly.number_of_blades", 2.5, "assembly.number_of_blades: got 2.5, expected a whole"),
    (
        "assembly.rotor_orientation",
        "Downwind",
        "rotor_orientation: got 'Downwind', expected an upwind",
    ),
    ("assembly.cut_in_wind_speed", 30.0, "assembly.cut_in_wind_speed: got 30, expected less than"),
    ("control.min_pitch_limit", 95.0, "control.min_pitch_limit: got 95.0"),
    ("control.max_pitch_limit", -5.0, "control.min_pitch_limit: got 0, expected at most max_pi"),
    ("control.min_rotor_speed", 13.0, "control.min_rotor_speed: got 13, expected at most rated"),
    ("control.max_rotor_speed", 10.0, "control.max_rotor_speed: got 10, expected at least rated"),
    ("control.max_pitch_rate", -1.0, "control.max_pitch_rate: got -1.0"),
    ("control", ..., "control: the key is missing"),
    (f"{SHAPE}.chord.values.3", -1.0, f"{SHAPE}.chord.values[3]: got -1.0"),
    (f"{SHAPE}.chord.values.3", NAN, f"{SHAPE}.chord.values[3]: got nan"),
    (f"{SHAPE}.chord.values", [1.0, 2.0], f"{SHAPE}.chord.values: got 2 values, expected 19"),
    (f"{SHAPE}.chord.grid.3", 0.01, f"{SHAPE}.chord.grid[3]: got 0.01 after"),
    (f"{SHAPE}.chord.grid.18", 0.99, f"{SHAPE}.chord.grid: runs from 0 to 0.99"),
    (f"{SHAPE}.twist.values.0", 1e9, f"{SHAPE}.twist.values[0]: got"),
    (f"{SHAPE}.twist", ..., f"{SHAPE}.twist: the key is missing"),
    (f"{SHAPE}.airfoils", [], f"{SHAPE}.airfoils: got []"),
    (f"{SHAPE}.airfoils.2.name", "DU99", f"{SHAPE}.airfoils[2].name: got 'DU99', expected one of"),
    (f"{SHAPE}.airfoils.2.weight", [0.5], f"{SHAPE}.airfoils[2].weight: weights sum to 0.5"),
    (f"{SHAPE}.airfoils.2.configuration", ["x"], "airfoils[0].polars: no configuration 'x'"),
    (f"{SHAPE}.airfoils.2.spanwise_position", 0.9, f"{SHAPE}.airfoils[3].spanwise_position"),
    (f"{SHAPE}.section_offset_y.values", "x", f"{SHAPE}.section_offset_y.values: got 'x'"),
    (
        "components.blade.reference_axis.z.values.5",
        0.0,
        "reference_axis.z.values[5]: got 0 after 0.6, expected more",
    ),
    ("airfoils.0.aerodynamic_center", 1.5, "airfoils[0].aerodynamic_center: got 1.5"),
    ("airfoils.0.polars.0.re_sets.0.cl.grid.4", 170.0, "airfoils[0].polars[0].re_sets[0].cl.grid["),
    ("airfoils.0.polars.0.re_sets.0.cd.values", [1.0], "re_sets[0].cd.values: got 1 values"),
    ("airfoils.0.polars", [], "airfoils[0].polars: got []"),
    ("components.drivetrain.outer_shape.overhang", -5.0, "drivetrain.outer_shape.overhang: got -5"),
    ("components.drivetrain.gearbox.gear_ratio", 0.0, "drivetrain.gearbox.gear_ratio: got 0.0"),
    ("components.drivetrain.elastic_properties.mass", -1, "elastic_properties.mass: got -1"),
    (
        "components.drivetrain.elastic_properties.inertia",
        [1.0],
        "inertia: got 1 values, expected 6",
    ),
    ("components.tower.outer_shape.outer_diameter.values.2", 0.0, "outer_diameter.values[2]: got"),
    ("components.tower.structure.layers.0.material", "wood", "layers[0].material: got 'wood'"),
    ("materials.0.rho", -8500.0, "materials[0].rho: got -8500.0"),
    ("materials", ..., "materials: the key is missing"),
    (
        "components.blade.structure.elastic_properties.inertia_matrix.mass.7",
        -1.0,
        "components.blade.structure.elastic_properties.inertia_matrix.mass[7]: got -1.0",
    ),
    (
        "components.blade.structure.elastic_properties.stiffness_matrix.K55",
        ...,
        "components.blade.structure.elastic_properties.stiffness_matrix.K55: the key is missing",
    ),
]


@pytest.mark.parametrize(("path", "value", "what"), MISTAKES)
def test_every_mistake_is_named(tmp_path: Path, path: str, value: Any, what: str) -> None:
    file = written(tmp_path, path, value)
    with pytest.raises(InputError) as caught:
        read_windio(file)
    message = str(caught.value)
    assert message.startswith(f"{file}: ")
    assert what in message, message
    assert "\n" not in message


def test_version_one_is_recognised(tmp_path: Path) -> None:
    file = tmp_path / "old.yaml"
    file.write_text("name: old\ncomponents:\n  blade:\n    outer_shape_bem: {chord: 1}\n")
    with pytest.raises(InputError, match="looks like version 1"):
        read_windio(file)


def test_integer_of_thousands_of_digits(tmp_path: Path) -> None:
    file = tmp_path / "long.yaml"
    file.write_text(SAMPLE.read_text().replace("hub_height: 90.0", "hub_height: 0x" + "f" * 9999))
    with pytest.raises(InputError, match=r"assembly\.hub_height: got an unprintable int"):
        read_windio(file)


@pytest.mark.parametrize("nodes", [1, 0, 2.5, True])
def test_node_counts_that_make_no_blade(nodes: Any) -> None:
    with pytest.raises(InputError, match="nodes: got"):
        read_windio(SAMPLE, nodes=nodes)


def leaves(data: Any, path: str = "") -> list[str]:
    """Dotted paths of all mappings' and lists' members, few of each long list."""
    found = []
    items = data.items() if isinstance(data, dict) else enumerate(data)
    for key, value in items:
        if isinstance(data, list) and key > 1:
            break
        here = f"{path}.{key}" if path else str(key)
        found.append(here)
        if isinstance(value, dict | list):
            found += leaves(value, here)
    return found


ODD = st.one_of(
    st.sampled_from([None, NAN, INF, -INF, True, "", "text", [], {}, [[]], {"a": 1}, 10**400]),
    st.floats(allow_nan=True, allow_infinity=True),
    st.integers(),
    st.lists(st.floats(allow_nan=True), max_size=4),
)


@pytest.mark.slow
@settings(max_examples=80, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(path=st.sampled_from(leaves(CONTENT)), value=ODD)
def test_any_odd_value_is_read_or_refused(tmp_path: Path, path: str, value: Any) -> None:
    file = written(tmp_path, path, value)
    try:
        turbine = read_windio(file)
    except InputError as error:
        message = str(error)
        assert message.startswith(f"{file}: ")
        assert "\n" not in message
        assert len(message) < 500
    else:
        assert np.all(np.isfinite(turbine.rotor.blade.chord))
        assert turbine.rotor.radius > 0.0


@settings(max_examples=60, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(
    cut=st.integers(min_value=1, max_value=SAMPLE.stat().st_size),
    insert=st.binary(max_size=6),
    drop=st.integers(min_value=0, max_value=40),
)
def test_any_damaged_file_is_read_or_refused(
    tmp_path: Path, cut: int, insert: bytes, drop: int
) -> None:
    data = SAMPLE.read_bytes()
    file = tmp_path / "damaged.yaml"
    file.write_bytes(data[:cut] + insert + data[cut + drop :])
    try:
        turbine = read_windio(file)
    except InputError as error:
        message = str(error)
        assert message.startswith(f"{file}: ")
        assert "\n" not in message
    else:
        assert turbine.rotor.radius > 0.0
