"""Bad input ends with status 2 and one line that names field, value and what is allowed."""

from __future__ import annotations

import os
import re

import numpy as np
import pytest

from pitchopt.aero.curves import BladeCurves

GOOD = 'turbine = "biegel2011"\n[limits]\npositions = 4\n'


@pytest.fixture
def refused(run, tmp_path):
    """Run, and check that nothing but one line on standard error came of it."""

    def call(*args: object) -> str:
        before = sorted(tmp_path.rglob("*"))
        done = run(*args)
        assert done.status == 2, done
        assert done.out == ""
        assert "Traceback" not in done.err
        assert done.err.endswith("\n")
        assert len(done.err.splitlines()) == 1, done.err
        assert sorted(tmp_path.rglob("*")) == before
        return done.err

    return call


OPTIONS = [
    (("--case", "nrel5mw"), r"case: got 'nrel5mw', expected one of biegel2011, .*nrel-5mw"),
    (("--case", "none.toml"), r"case: none\.toml: no such file"),
    (("--wind-speed", "nan"), r"--wind-speed: got nan, expected a finite number above 0"),
    (("--wind-speed", "inf"), r"--wind-speed: got inf, expected a finite number"),
    (("--wind-speed", "-3"), r"--wind-speed: got -3, expected .*above 0"),
    (("--wind-speed", "fast"), r"--wind-speed: got 'fast', expected a finite number"),
    (("--rotor-speed-rpm", "0"), r"--rotor-speed-rpm: got 0, expected .*above 0 .*'auto'"),
    (("--shear", "nan"), r"--shear: got nan"),
    (("--induction", "full"), r"--induction: got 'full', expected one of none, frozen, equil"),
    (("--positions", "0"), r"--positions: got 0, expected a whole number from 1"),
    (("--positions", "2.5"), r"--positions: got 2\.5, expected a whole number"),
    (("--elements", "0"), r"--elements: got 0, expected a whole number from 1"),
    (("--segments", "0"), r"--segments: got 0, expected a whole number from 1"),
    (("--pitch-rate-deg", "-1"), r"--pitch-rate-deg: got -1, expected .*at least 0"),
    (("--pitch-rate-deg", "nan"), r"--pitch-rate-deg: got nan"),
    (
        ("--pitch-min-deg", "5", "--pitch-max-deg", "3"),
        r"pitch_min_deg, limits\.pitch_max_deg: got 5 and 3",
    ),
    (("--pitch-max-deg", "-20"), r"pitch_min_deg, limits\.pitch_max_deg: got -10 and -20"),
    (
        ("--pitch-min-deg", "40", "--pitch-max-deg", "44"),
        r"pitch.*(40|44)",
    ),
    (("--weights", "heavy"), r"--weights: got 'heavy', expected unit, tower-base"),
    (("--weights", "torque=-1"), r"--weights\.torque: got -1, expected .*at least 0"),
    (("--weights", "force=1"), r"--weights: got .*force"),
    (("--blade-cap", "0"), r"--blade-cap: got 0, expected .*above 0 or 'none'"),
    (("--harmonics", "-1"), r"--harmonics: got -1, expected a whole number from 0"),
    (("--travel-penalty", "-1"), r"--travel-penalty: got -1"),
    (("--starts", "0"), r"--starts: got '0', expected a whole number from 1"),
    (("--seed", "-1"), r"--seed: got '-1', expected a whole number from 0"),
    (("--curves", "none.npz", "--rotor-speed-rpm", "9"), r"none\.npz"),
    (("--curves", "c.npz"), r"--rotor-speed-rpm: got nothing, expected a number with --curves"),
    (("--curves", "c.npz", "--shear", "0.1"), r"--shear: got 0\.1 together with --curves"),
    (("--no-such-option",), r"[Nn]o such option.*--no-such-option.*--help"),
    (("--wind-speed",), r"--wind-speed.*requires an argument"),
    (("surplus",), r"surplus"),
]


@pytest.mark.parametrize("command", ["tradeoff", "design"])
@pytest.mark.parametrize(("options", "message"), OPTIONS, ids=lambda value: " ".join(value)[:30])
def test_bad_options(refused, command, options, message):
    goal = ("--mu", "1") if command == "design" else ()
    assert re.search(message, refused(command, *goal, *options))


@pytest.mark.parametrize(
    ("args", "message"),
    [
        (("tradeoff", "--mu", "1,x"), r"--mu: got '1,x', expected finite numbers"),
        (("tradeoff", "--mu", "-1"), r"--mu: got '-1'"),
        (("tradeoff", "--mu", "nan"), r"--mu: got 'nan'"),
        (("tradeoff", "--points", "0"), r"--points: got '0'"),
        (("tradeoff", "--points", "3", "--mu", "1"), r"--points: got a number together"),
        (("tradeoff", "--loss", "3"), r"--loss: got '3', expected a share"),
        (("tradeoff", "--loss", "-3%"), r"--loss: got '-3%'"),
        (("design",), r"goal: got none, expected exactly one of --mu"),
        (("design", "--mu", "1", "--max-power-loss", "2%"), r"goal: got --mu and --max-power"),
        (("design", "--mu", "1,2"), r"--mu: got 2 numbers, expected one"),
        (("design", "--max-power-loss", "100%"), r"--max-power-loss: got '100%'"),
        (("design", "--max-power-loss", "few"), r"--max-power-loss: got 'few'"),
        (("design", "--mean-torque", "nan"), r"--mean-torque: got 'nan'"),
        (("design", "--mean-torque", "-5"), r"--mean-torque: got '-5'"),
        (("design", "--mean-torque", "rated"), r"--mean-torque: got 'rated'.*not known"),
        (("turbines", "nrel"), r"turbine: got 'nrel', expected one of .*nrel-5mw"),
        (("turbines", "none.yaml"), r"none\.yaml: no such file"),
        (("turbines", "--template", "nrel"), r"turbine: got 'nrel'"),
        (("turbines", "nrel-5mw", "--template", "nrel-5mw"), r"--template"),
        (
            ("export",),
            r"--format: got None, expected one of csv, harmonics, aerodyn, rosco",
        ),
        (("export", "x.npz", "--format", "hdf"), r"--format: got 'hdf'"),
        (("export", "x.npz", "--format", "csv"), r"profiles file: got 'x\.npz' \(no such file\)"),
        (("export", "--format", "csv"), r"goal: got none"),
        (("export", "--format", "csv", "--point", "knee"), r"--point: got 'knee' without a file"),
        (("export", "x.npz", "--format", "csv", "--mu", "1"), r"--mu: given together with"),
        (("export", "x.npz", "--format", "aerodyn", "--step-deg", "0"), r"--step-deg: got '0'"),
        (("export", "x.npz", "--format", "aerodyn", "--step-deg", "nan"), r"--step-deg: got"),
        (("export", "x.npz", "--format", "csv", "--revolutions", "0"), r"--revolutions: got '0'"),
        (("export", "x.npz", "--format", "csv", "--interpolation", "a"), r"--interpolation: got"),
        (("optimise",), r"optimise.*--help"),
    ],
    ids=lambda value: " ".join(value)[:40],
)
def test_bad_arguments(refused, args, message):
    assert re.search(message, refused(*args))


@pytest.mark.parametrize("command", ["tradeoff", "design", "export"])
@pytest.mark.parametrize("below", ["", "deeper"])
def test_a_folder_that_cannot_be_written(refused, tmp_path, small, command, below):
    (tmp_path / "file").touch()
    extra = {"tradeoff": (), "design": ("--mu", "1"), "export": ("--mu", "1", "--format", "csv")}
    folder = os.path.join("file", below)  # noqa: PTH118  a path that pathlib would tidy
    message = refused(command, *small, *extra[command], "--out", folder)
    assert re.search(r"--out: (got|cannot write)", message)


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (b"", "case.toml.*empty"),
        (b"\x00\x01", "case.toml.*binary"),
        (b"x = [", "case.toml: not valid TOML"),
        (b"#" * 1_000_001, "case.toml.*1000001 bytes"),
        (b"turbine = 'iea-15'", "turbine: got 'iea-15'.*iea-15-240"),
        (b"turbine = 'no.yaml'", r"no\.yaml: no such file"),
        (b"turbine = 'biegel2011'\nspeed = 3", "case.toml: speed: unknown key"),
        (GOOD.encode() + b"[wind]\nspeed = nan", r"case\.toml: wind\.speed: got nan"),
        (GOOD.encode() + b"[wind]\nroughness_length = -1", r"wind\.roughness_length: got -1"),
        (GOOD.encode() + b"[operation]\nair_density = -1", r"operation\.air_density: got -1"),
        (GOOD.encode() + b"[wind]\ndisc = 'd.csv'", r"wind: .*d\.csv"),
        (
            GOOD.encode() + b"[aero]\nalpha_min_deg = 5\nalpha_max_deg = 2",
            r"alpha_min_deg, aero\.alpha_max_deg: got 5 and 2",
        ),
    ],
)
def test_bad_case_files(refused, tmp_path, content, message):
    (tmp_path / "case.toml").write_bytes(content)
    assert re.search(message, refused("tradeoff", "--case", "case.toml"))


@pytest.fixture
def windio(project_root, tmp_path):
    """A function that writes a changed windIO turbine, and a case file for it."""
    good = (project_root / "examples" / "data" / "example-1.5MW-77.yaml").read_bytes()

    def write(change) -> str:
        (tmp_path / "t.yaml").write_bytes(change(good))
        (tmp_path / "case.toml").write_text('turbine = "t.yaml"\n[limits]\npositions = 4\n')
        return "case.toml"

    return write


def narrow(text: bytes) -> bytes:
    """Polars that end at 5 degrees."""
    out, lines = [], text.splitlines()
    for line in lines:
        if b"[-180, -150" in line:
            keep = line.split(b"[")[1].rstrip(b"]").split(b", ")
            count = sum(-11 < float(v) < 6 for v in keep)
            first = next(i for i, v in enumerate(keep) if float(v) > -11)
            line = b"              grid: [" + b", ".join(keep[first : first + count]) + b"]"
            window = (first, first + count)
        elif line.strip().startswith(b"values:") and line.count(b",") > 20:
            values = line.split(b"[")[1].rstrip(b"]").split(b", ")
            line = b"              values: [" + b", ".join(values[slice(*window)]) + b"]"
        out.append(line)
    return b"\n".join(out)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda _: b"", r"t\.yaml.*empty"),
        (lambda text: b"\x00" + text, r"t\.yaml.*binary"),
        (lambda text: text[:2000], r"t\.yaml"),
        (lambda _: b"#" * 10_000_001, r"t\.yaml.*10000001 bytes"),
        (lambda text: text.replace(b"diameter: 3.0", b"diameter: -3.0"), r"hub\.diameter: got -3"),
        (lambda text: text.replace(b"hub_height: 80.0", b"hub_height: .nan"), r"hub_height: got"),
        (lambda text: text.replace(b"hub_height: 80.0", b"hub_height: .inf"), r"hub_height: got"),
        (
            lambda text: text.replace(b"min_pitch_limit: -2.0", b"min_pitch_limit: 91.0"),
            r"min_pitch_limit: got 91",
        ),
        (lambda text: text.replace(b"name: thin-18", b"name: other", 1), r"airfoils.*'other'"),
        (narrow, r"thin-18|alpha|angle"),
    ],
    ids=["empty", "binary", "cut", "huge", "radius", "nan", "inf", "limits", "airfoil", "polar"],
)
def test_bad_windio_files(refused, windio, change, message):
    if change is narrow:
        case = windio(change)
        text = refused("tradeoff", "--case", case, "--induction", "none")
    else:
        text = refused("tradeoff", "--case", windio(change))
    assert re.search(message, text), text


def test_limits_that_admit_no_constant_pitch(refused):
    text = refused("tradeoff", "--positions", "4", "--pitch-min-deg", "30")
    assert re.search(r"pitch.*30", text), text


def test_a_disc_that_does_not_cover_the_rotor(refused, tmp_path):
    rows = [f"{y},{z},10" for y in (-5, 5) for z in (-5, 5)]
    (tmp_path / "d.csv").write_text("\n".join(["y,z,speed", *rows]))
    (tmp_path / "case.toml").write_text(GOOD + "[wind]\ndisc = 'd.csv'\n")
    text = refused("tradeoff", "--case", "case.toml")
    assert re.search(r"wind: .*(y|z).*(5|16)", text), text


@pytest.mark.parametrize(
    ("name", "content"),
    [
        ("c.csv", "station,azimuth\n"),
        ("c.csv", "# blades=3\nstation,azimuth,beta,torque,bending,thrust\n0,0,x,1,1,1\n"),
        ("c.npz", "no archive"),
        ("c.txt", "text"),
    ],
)
def test_bad_tables_of_curves(refused, tmp_path, name, content):
    (tmp_path / name).write_text(content)
    assert name in refused("design", "--mu", "1", "--curves", name, "--rotor-speed-rpm", "9")


def test_curves_that_hold_nan(refused, tmp_path):
    azimuth = 2 * np.pi * np.arange(3) / 3
    beta = np.tile([0.0, 0.1], (3, 1))
    load = np.full((3, 2), np.nan)
    np.savez(
        tmp_path / "c.npz", blades=3, azimuth=azimuth, beta=beta, torque=load, bending=load,
        thrust=load,
    )  # fmt: skip
    text = refused("design", "--mu", "1", "--curves", "c.npz", "--rotor-speed-rpm", "9")
    assert re.search("torque: got 6 NaN", text)


def test_positions_belong_to_the_table(refused, tmp_path):
    azimuth = 2 * np.pi * np.arange(3) / 3
    beta = np.tile([0.0, 0.1], (3, 1))
    load = np.ones((3, 2))
    BladeCurves(blades=3, azimuth=azimuth, beta=beta, torque=load, bending=load, thrust=load).save(
        tmp_path / "c.npz"
    )
    text = refused("design", "--mu", "1", "--curves", "c.npz", "--positions", "9")
    assert "--positions: got 9 together with --curves" in text


def test_a_rate_of_zero_is_legal_and_leaves_constant_pitch(run, small):
    done = run("design", *small, "--mu", "1", "--pitch-rate-deg", "0", "--json")
    assert done.status == 0, done.err
    import json

    pitch = json.loads(done.out)["pitch_deg"]
    assert np.ptp(pitch) == pytest.approx(0.0, abs=1e-9)
