"""A windIO file with a mistake in it: the program says in one line which key, and what of it.

Every mutation is one that a hand makes: a key left out or misspelt, a list too short, a number in
the wrong unit, a name that nothing has.
"""

from __future__ import annotations

import copy
from pathlib import Path

import pytest
import yaml

CHORD = "components.blade.outer_shape.chord"
AXIS = "components.blade.reference_axis"
POLAR = "airfoils[3].polars[0].re_sets[0]"


def steps(path: str) -> list[str | int]:
    """Keys and indices of a path such as ``airfoils[0].name``."""
    words = path.replace("[", ".[").split(".")
    return [int(word[1:-1]) if word.startswith("[") else word for word in words]


class Change:
    """What is done to the plain data of a file."""

    def __init__(self, path: str, value: object = None, *, kind: str = "set") -> None:
        self.path, self.value, self.kind = path, value, kind

    def __call__(self, data: object) -> None:
        *parents, last = steps(self.path)
        for key in parents:
            data = data[key]
        if self.kind == "set":
            data[last] = self.value
        elif self.kind == "drop":
            del data[last]
        elif self.kind == "rename":
            data[self.value] = data.pop(last)
        elif self.kind == "scale":
            old = data[last]
            scaled = [self.value * v for v in old] if isinstance(old, list) else self.value * old
            data[last] = scaled
        elif self.kind == "swap":
            data[last][1], data[last][2] = data[last][2], data[last][1]
        else:
            data[last] = data[last][:-1]


def dumped(data: object) -> str:
    return yaml.dump(data, Dumper=getattr(yaml, "CSafeDumper", yaml.SafeDumper))


def drop(path: str) -> Change:
    return Change(path, kind="drop")


def rename(path: str, name: str) -> Change:
    return Change(path, name, kind="rename")


def scale(path: str, factor: float) -> Change:
    return Change(path, factor, kind="scale")


MISTAKES = [
    # missing
    (drop(CHORD), [f"{CHORD}: the key is missing, there are"]),
    (drop("components.hub.diameter"), ["components.hub.diameter: the key is missing"]),
    (drop("control"), ["control: the key is missing"]),
    (drop(f"{POLAR}.cd"), [f"{POLAR}.cd: the key is missing"]),
    (drop("windIO_version"), ["windIO_version: the key is missing"]),
    (drop("airfoils"), ["airfoils: the key is missing"]),
    # misspelt
    (rename(CHORD, "chrod"), [f"{CHORD}: the key is missing; did you mean it by 'chrod'?"]),
    (
        rename("components.hub.cone_angle", "cone_angel"),
        ["components.hub.cone_angle: the key is missing; did you mean it by 'cone_angel'?"],
    ),
    (
        rename("control.rated_rotor_speed", "rated_rotorspeed"),
        ["control.rated_rotor_speed: the key is missing; did you mean it by 'rated_rotorspeed'?"],
    ),
    (rename(f"{CHORD}.values", "value"), [f"{CHORD}.values: the key is missing", "'value'"]),
    # an optional entry that would be left out in silence
    (
        rename("control.optimal_tsr", "optimal_trs"),
        ["control.optimal_trs: unknown key; did you mean 'optimal_tsr'?"],
    ),
    (
        rename("components.tower.structure", "structur"),
        ["components.tower.structur: unknown key; did you mean 'structure'?"],
    ),
    (
        rename("components.drivetrain.gearbox", "gear_box"),
        ["components.drivetrain.gear_box: unknown key; did you mean 'gearbox'?"],
    ),
    # wrong type
    (Change(f"{CHORD}.values", 3.0), [f"{CHORD}.values: got 3.0, expected a list of numbers"]),
    (Change(f"{CHORD}.values[3]", "wide"), [f"{CHORD}.values[3]: got 'wide'", "above 0", "[m]"]),
    (Change("components.hub", [1]), ["components.hub: got [1], expected a mapping of keys"]),
    (Change("assembly.number_of_blades", 2.5), ["assembly.number_of_blades: got 2.5, expected a"]),
    (Change("airfoils", {}), ["airfoils: got {}, expected a list with at least one entry"]),
    # numbers that are none, or in another unit
    (Change(f"{CHORD}.values[3]", float("nan")), [f"{CHORD}.values[3]: got nan, expected a fini"]),
    (Change(f"{AXIS}.x.values[0]", float("inf")), [f"{AXIS}.x.values[0]: got inf", "[m]"]),
    (scale(f"{CHORD}.values", 1e3), [f"{CHORD}.values[0]: got ", "at most 100 [m]"]),
    (scale("components.hub.diameter", 1e3), ["components.hub.diameter: got 3000", "100 [m]"]),
    (scale("assembly.rated_power", 1e-6), ["assembly.rated_power: got 5.0, expected", "[W]"]),
    (scale("assembly.hub_height", 1e3), ["assembly.hub_height: got 90000", "at most 1000 [m]"]),
    (Change("components.hub.cone_angle", 86.5), ["components.hub.cone_angle: got 86.5", "[deg]"]),
    (Change("control.max_pitch_limit", 1.5e3), ["control.max_pitch_limit: got 1500.0", "[deg]"]),
    (
        scale("components.blade.outer_shape.twist.values", 57.3),
        ["outer_shape.twist.values[", "deg"],
    ),
    (scale(f"{AXIS}.z.values", 0.5), ["assembly.rotor_diameter: got", "hub and blade make"]),
    # lengths and order
    (Change(f"{CHORD}.values", kind="cut"), [f"{CHORD}.values: got", "values, expected"]),
    (Change(f"{POLAR}.cl.values", kind="cut"), [f"{POLAR}.cl.values: got", "values, expected"]),
    (Change(f"{CHORD}.grid", kind="swap"), [f"{CHORD}.grid[2]: got", "expected more"]),
    (Change(f"{AXIS}.z.values", kind="swap"), [f"{AXIS}.z.values[2]: got", "expected more"]),
    (Change(f"{POLAR}.cl.grid", kind="swap"), [f"{POLAR}.cl.grid[2]: got", "expected more"]),
    (
        Change(f"{CHORD}.grid[0]", 0.01),
        [f"{CHORD}.grid: runs from 0.01 to 1, expected from 0 to 1"],
    ),
    # names that nothing has
    (
        Change("components.blade.outer_shape.airfoils[1].name", "Cylinder_2"),
        ["outer_shape.airfoils[1].name: got 'Cylinder_2', expected", "did you mean 'Cylinder2'?"],
    ),
    (
        Change("components.tower.structure.layers[0].material", "stel"),
        ["structure.layers[0].material: got 'stel', expected one of", "did you mean 'steel'?"],
    ),
]


@pytest.fixture(scope="module")
def good(project_root) -> tuple[str, dict]:
    """Text and plain data of a file without mistakes."""
    text = (project_root / "tests" / "turbines" / "data" / "nrel5mw_small.yaml").read_text()
    return text, yaml.safe_load(text)


@pytest.fixture
def told(run, tmp_path):
    """The one line that the program says about a windIO file and a case for it."""
    (tmp_path / "case.toml").write_text('turbine = "t.yaml"\n[limits]\npositions = 4\n')

    def call(text: str) -> str:
        Path("t.yaml").write_text(text)
        done = run("tradeoff", "--case", "case.toml")
        assert done.status == 2
        assert done.out == ""
        assert len(done.err.splitlines()) == 1
        assert done.err.startswith("pitchopt: ")
        assert sorted(path.name for path in Path.cwd().iterdir()) == ["case.toml", "t.yaml"]
        return done.err

    return call


@pytest.mark.parametrize(("change", "parts"), MISTAKES, ids=lambda v: getattr(v, "path", None))
def test_a_mistake_is_named_by_its_key(told, good, change, parts):
    data = copy.deepcopy(good[1])
    change(data)
    line = told(dumped(data))
    assert "t.yaml: " in line
    for part in parts:
        assert part in line, line


@pytest.mark.parametrize(
    ("old", "new", "part"),
    [
        ("hub_height: 80.0", "hub_height: [80.0", "not valid YAML at line"),
        (
            "hub_height: 80.0",
            "hub_height: 80.0\n  hub_height: 81.0",
            "key 'hub_height' stands there",
        ),
        ("hub_height: 80.0", "\thub_height: 80.0", "not valid YAML at line"),
        ("hub_height: 80.0", "hub_height: !!python/object:os.x 3", "explicit tag"),
    ],
)
def test_a_slip_of_syntax_is_named_by_its_line(told, project_root, old, new, part):
    text = (project_root / "examples" / "data" / "example-1.5MW-77.yaml").read_text()
    assert text.count(old) == 1
    line = told(text.replace(old, new))
    assert "t.yaml: " in line and part in line
    number = 1 + text[: text.index(old)].count("\n")
    assert any(f"line {near}" in line for near in range(number, number + 3)), line


@pytest.mark.parametrize(
    ("text", "part"),
    [
        ('turbine = "none.yaml"\n', "none.yaml: no such file"),
        ('turbine = "nrel5mw"\n', "did you mean 'nrel-5mw'?"),
        ('turbin = "t.yaml"\n', "turbin: unknown key, expected one of name, turbine"),
        (
            'turbine = "t.yaml"\n[wind]\nsped = 3\n',
            "wind.sped: unknown key",
        ),
        (
            'turbine = "t.yaml"\n[limit]\npositions = 3\n',
            "limit: unknown key",
        ),
        (
            'turbine = "t.yaml"\n[limits]\npositions = "3"\n',
            "limits.positions: got '3', expected a whole",
        ),
        (
            'turbine = "t.yaml"\n[wind]\nspeed = 300\n',
            "wind.speed: got 300, expected a finite number",
        ),
        ('turbine = "t.yaml"\n[wind\n', "not valid TOML"),
    ],
)
def test_a_mistake_in_the_case_file_is_named_by_its_key(run, tmp_path, good, text, part):
    (tmp_path / "t.yaml").write_text(good[0])
    (tmp_path / "my.toml").write_text(text)
    done = run("tradeoff", "--case", "my.toml")
    assert done.status == 2
    assert len(done.err.splitlines()) == 1
    assert "my.toml: " in done.err and part in done.err


def test_the_file_itself_is_fine(run, tmp_path, good):
    (tmp_path / "t.yaml").write_text(dumped(good[1]))
    assert run("turbines", "t.yaml").status == 0
