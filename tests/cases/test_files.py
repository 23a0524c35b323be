"""Case files: read strictly, written back, every complaint one line with the dotted key."""

from __future__ import annotations

import shutil
from pathlib import Path

import numpy as np
import pytest

from pitchopt.cases import Case, case_from_table, case_toml, load_case
from pitchopt.errors import InputError
from pitchopt.turbines import names


def write(folder: Path, text: str | bytes, name: str = "case.toml") -> Path:
    file = folder / name
    file.write_bytes(text.encode() if isinstance(text, str) else text)
    return file


@pytest.mark.parametrize("name", names())
def test_templates_read_back_as_the_case_they_show(name, tmp_path):
    assert load_case(write(tmp_path, case_toml(load_case(name)))) == load_case(name)


def test_values_of_every_kind(tmp_path):
    file = write(
        tmp_path,
        """
        name = "mine"
        turbine = "iea-15-240"
        [wind]
        speed = 9
        shear = "log"
        direction_deg = 10.0
        tower_shadow = false
        [operation]
        rotor_speed_rpm = 6.0
        [aero]
        elements = 12
        alpha_max_deg = 9.5
        [limits]
        positions = 12
        pitch_rate_deg = 0
        [objective]
        weights = { torque = 1, thrust = 150.0 }
        blade_cap = "none"
        harmonics = 3
        """,
    )
    case = load_case(file)
    assert case.name == "mine"
    assert case.wind.speed == 9.0
    assert case.wind.direction == pytest.approx(np.deg2rad(10.0))
    assert not case.wind.tower_shadow
    assert case.rotor_speed == pytest.approx(6.0 * np.pi / 30)
    assert case.aero.alpha_max == pytest.approx(np.deg2rad(9.5))
    assert case.limits.pitch_rate == 0.0
    assert case.weights.thrust == 150.0
    assert case.weights.tilt == 0.0
    assert case.objective.blade_cap is None
    assert case.objective.harmonics == 3
    assert load_case(write(tmp_path, case_toml(case))) == case


def test_what_is_left_out_is_that_of_the_turbines_own_case(tmp_path):
    case = load_case(write(tmp_path, 'turbine = "biegel2011"\n[wind]\nspeed = 12.0\n', "my.toml"))
    assert case.name == "my"
    assert case.aero == load_case("biegel2011").aero
    assert case.wind.shear == "cubic"
    assert case.wind.speed == 12.0


def test_paths_are_relative_to_the_file(tmp_path, project_root, monkeypatch):
    folder = tmp_path / "cases"
    folder.mkdir()
    shutil.copy(project_root / "examples" / "data" / "example-1.5MW-77.yaml", folder / "t.yaml")
    file = write(folder, 'turbine = "t.yaml"\ncurves = "c.npz"\n[wind]\ndisc = "d.csv"\n')
    monkeypatch.chdir(tmp_path)
    case = load_case(file)
    assert case.turbine_data.rotor.radius == pytest.approx(38.5)
    assert case.curves == folder / "c.npz"
    assert case.wind.disc == folder / "d.csv"


def test_a_windio_turbine_makes_a_task(project_root):
    file = project_root / "examples" / "data" / "example-1.5MW-77.yaml"
    case = Case(name="own", turbine=str(file))
    assert case.task().model.rotor.hub_height == 80.0
    assert case.weights.thrust == 80.0


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("turbin = 'x'", "turbin: unknown key, expected one of .*did you mean 'turbine'"),
        ("turbine = 3", "turbine: got 3, expected one line of text"),
        ("[wind]\nspeed = 8", "turbine: got nothing"),
        ("turbine = 'nrel-5mw'\nwind = 3", r"wind: got 3, expected a section \[wind\]"),
        ("turbine = 'nrel-5mw'\n[wnd]", "wnd: unknown key.*did you mean 'wind'"),
        (
            "turbine = 'nrel-5mw'\n[wind]\nsped = 8",
            r"wind\.sped: unknown key.*did you mean 'speed'",
        ),
        ("turbine = 'nrel-5mw'\n[wind]\nspeed = '8'", r"wind\.speed: got '8', expected a finite"),
        ("turbine = 'nrel-5mw'\n[wind]\nspeed = nan", r"wind\.speed: got nan"),
        ("turbine = 'nrel-5mw'\n[wind]\nspeed = -inf", r"wind\.speed: got -inf"),
        ("turbine = 'nrel-5mw'\n[wind]\nspeed = 1e999", r"wind\.speed: got inf"),
        ("turbine = 'nrel-5mw'\n[wind]\nspeed = -8", r"wind\.speed: got -8.*above 0"),
        ("turbine = 'nrel-5mw'\n[wind]\nspeed = 2024-01-01", r"wind\.speed: got datetime"),
        ("turbine = 'nrel-5mw'\n[limits]\npositions = 0", r"limits\.positions: got 0"),
        ("turbine = 'nrel-5mw'\n[limits]\npositions = 24.0", r"limits\.positions: got 24\.0"),
        ("turbine = 'nrel-5mw'\n[aero]\nelements = 0", r"aero\.elements: got 0"),
        (
            "turbine = 'nrel-5mw'\n[limits]\npitch_min_deg = 9\npitch_max_deg = 3",
            "pitch_min_deg, limits.pitch_max_deg: got 9 and 3",
        ),
        (
            "turbine = 'nrel-5mw'\n[operation]\nair_density = -1.2",
            r"operation\.air_density: got -1\.2, expected .*above 0",
        ),
        (
            "turbine = 'nrel-5mw'\n[objective.weights]\nforce = 1.0",
            r"objective\.weights: got .*force",
        ),
    ],
)
def test_bad_values_name_the_dotted_key(tmp_path, text, message):
    file = write(tmp_path, text)
    with pytest.raises(InputError, match=rf"case\.toml: .*{message}") as caught:
        load_case(file)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (b"", "empty"),
        (b"# nothing\n" + b" " * 10, "turbine: got nothing"),
        (b"\x00\x01\x02\x03", "binary"),
        (b"turbine = '\xff'", "UTF-8"),
        (b"turbine = 'nrel-5mw'\n[wind]\nspeed = ", "not valid TOML"),
        (b"turbine = 'nrel-5mw'\n[wind", "not valid TOML"),
        (b"a = " + b"[" * 5000, "not valid TOML"),
        (b"a = " + b"9" * 5000, "not valid TOML"),
        (b"# " + b"x" * 1_000_001, "1000003 bytes"),
    ],
    ids=["empty", "comment", "binary", "latin", "cut", "cut section", "deep", "digits", "huge"],
)
def test_files_that_are_no_case(tmp_path, content, message):
    with pytest.raises(InputError, match=message) as caught:
        load_case(write(tmp_path, content))
    assert "\n" not in str(caught.value)


def test_missing_files_folders_and_names(tmp_path):
    with pytest.raises(InputError, match=r"case: .*none\.toml.*no such file"):
        load_case(tmp_path / "none.toml")
    (tmp_path / "folder.toml").mkdir()
    with pytest.raises(InputError, match=r"case: .*folder\.toml"):
        load_case(tmp_path / "folder.toml")
    with pytest.raises(InputError, match=r"case: got 'nrel5mw', .*did you mean 'nrel-5mw'"):
        load_case("nrel5mw")
    with pytest.raises(InputError, match=r"turbine = 'my\.yaml' into a case file"):
        load_case("my.yaml")


def test_an_unknown_turbine_is_told_with_the_nearest(tmp_path):
    with pytest.raises(InputError, match=r"turbine: got 'iea-15', .*did you mean 'iea-15-240'"):
        load_case(write(tmp_path, "turbine = 'iea-15'"))


def test_a_table_may_come_from_python():
    case = case_from_table({"turbine": "nrel-5mw", "wind": {"speed": 7.0}}, name="py")
    assert (case.name, case.wind.speed) == ("py", 7.0)
