"""``pitchopt simulate``: document, files, tables, right and wrong input."""

from __future__ import annotations

import csv
import json
import math
import struct

import numpy as np
import pytest

from pitchopt.cli.values import seeds
from pitchopt.exports import read_outb, read_series_csv, read_series_npz
from windfield import PowerLaw, StaticField, TurbulentField, kaimal_box, write_bts

QUICK = ("simulate", "--step", "0.05", "--duration", "8", "--skip", "2", "--box-points", "4")
RUNAWAY = "[torque]\nfactor = 0.01\n[pitch]\nproportional = 0\nintegral = 1e-9\n"


@pytest.fixture
def document(run):
    """Run with --json; the document."""

    def call(*args: object) -> dict:
        done = run(*QUICK, *args, "--json")
        assert done.status == 0, done.err
        return json.loads(done.out)

    return call


def numbers_of(value):
    """All numbers in a document."""
    if isinstance(value, dict):
        value = list(value.values())
    if isinstance(value, list):
        return [number for item in value for number in numbers_of(item)]
    return [value] if isinstance(value, float) else []


@pytest.mark.slow
def test_schema_of_the_document(run, tmp_path):
    assert run(*QUICK, "--turbulence", "none", "--json").status == 0  # compiles, and may say so
    done = run(*QUICK, "--wind-speed", "8,14", "--seeds", "2", "--json")
    assert done.status == 0, done.err
    assert done.err == ""
    assert list(tmp_path.iterdir()) == []
    found = json.loads(done.out)
    assert list(found) == [
        "turbine", "settings", "channels", "runs", "summary", "lifetime", "seconds",
    ]  # fmt: skip
    assert found["turbine"] == "nrel-5mw"
    told = found["settings"]
    expected = {
        "wind_speeds": [8.0, 14.0], "turbulence": "B", "seeds": [1, 2], "duration": 8.0,
        "skip": 2.0, "controller": "baseline", "step": 0.05, "inflow": "dynamic",
        "box_points": 4, "tower_shadow": True, "shear": 0.2, "weibull_mean": 10.0, "pitch_lag": 0.0,
    }  # fmt: skip
    assert {name: told[name] for name in expected} == expected
    assert "shaft-torsion" not in told["freedoms"] and "blade-flap" in told["freedoms"]
    assert list(found["channels"]) == told["channels"]
    assert found["channels"]["TwrBsMyt"]["unit"] == "kN-m"
    assert "fore-aft" in found["channels"]["TwrBsMyt"]["meaning"]
    assert [(run["wind_speed"], run["seed"]) for run in found["runs"]] == [
        (8, 1), (8, 2), (14, 1), (14, 2),
    ]  # fmt: skip
    for one in found["runs"]:
        assert set(one) == {
            "wind_speed", "turbulence", "seed", "status", "message", "diverged_at", "seconds",
            "step_error", "evaluations", "statistics",
        }  # fmt: skip
        assert (one["status"], one["diverged_at"]) == ("finished", None)
        assert one["turbulence"] == "Kaimal, class B"
        assert 0 < one["step_error"] < 0.5
        assert list(one["statistics"]) == told["channels"]
    load = found["runs"][0]["statistics"]["RootMyc1"]
    assert list(load) == ["unit", "mean", "std", "min", "max", "del", "wohler"]
    assert (load["unit"], load["wohler"]) == ("kN-m", 10.0)
    assert load["min"] < load["mean"] < load["max"] and load["del"] > 0
    speed = found["runs"][0]["statistics"]["RotSpeed"]
    assert (speed["unit"], speed["del"], speed["wohler"]) == ("rpm", None, None)
    assert 7.0 < speed["mean"] < 12.5
    for at, summary in zip((8.0, 14.0), found["summary"], strict=True):
        parts = [one["statistics"] for one in found["runs"] if one["wind_speed"] == at]
        assert (summary["wind_speed"], summary["runs"], summary["diverged"]) == (at, 2, 0)
        tower = summary["statistics"]["TwrBsMyt"]
        dels = [part["TwrBsMyt"]["del"] for part in parts]
        assert tower["del"] == pytest.approx((np.mean(np.array(dels) ** 4)) ** 0.25)
        assert tower["max"] == max(part["TwrBsMyt"]["max"] for part in parts)
        assert tower["mean"] == pytest.approx(np.mean([p["TwrBsMyt"]["mean"] for p in parts]))
    lifetime = found["lifetime"]
    assert lifetime["weibull_mean"] == 10.0
    assert sum(lifetime["weights"]) == pytest.approx(1.0)
    assert 0 < lifetime["share_of_time"] < 1
    assert lifetime["channels"]["GenPwr"]["del"] is None
    assert lifetime["channels"]["TwrBsMyt"]["del"] > 0
    assert all(map(math.isfinite, numbers_of(found)))


def test_files_and_tables(run, tmp_path):
    done = run(
        *QUICK, "--wind-speed", "12", "--seeds", "3:4", "--format", "csv,npz", "--format", "outb",
        "--channels", "GenPwr,RotSpeed,TwrBsMyt,RootMyc1", "--out", "here",
    )  # fmt: skip
    assert done.status == 0, done.err
    for text in (
        "nrel-5mw: Kaimal, class B, 2 seeds, controller baseline, 8 s after 2 s, step 0.05 s",
        "Statistics at 12 m/s, all seeds together", "finished", "momentum balances",
        "9 files in here/",
    ):  # fmt: skip
        assert text in done.out, text
    folder = tmp_path / "here"
    assert sorted(path.name for path in folder.iterdir()) == [
        "overview.png", "simulation.json", "statistics.csv", "u12_s3.csv", "u12_s3.npz",
        "u12_s3.outb", "u12_s4.csv", "u12_s4.npz", "u12_s4.outb",
    ]  # fmt: skip
    assert (folder / "overview.png").read_bytes().startswith(b"\x89PNG")
    found = json.loads((folder / "simulation.json").read_text())
    text = read_series_csv(folder / "u12_s3.csv")
    exact = read_series_npz(folder / "u12_s3.npz")
    packed = read_outb(folder / "u12_s3.outb")
    for series in (text, exact, packed):
        assert series.channels == ("GenPwr", "RotSpeed", "TwrBsMyt", "RootMyc1")
        assert series.units == ("kW", "rpm", "kN-m", "kN-m")
        assert series.time[-1] == pytest.approx(10.0)
    np.testing.assert_allclose(text.values, exact.values, rtol=1e-8, atol=1e-8)
    np.testing.assert_allclose(packed.values, exact.values, rtol=1e-3, atol=2.0)
    late = exact["TwrBsMyt"][exact.time >= 2.0 - 1e-9]
    told = found["runs"][0]["statistics"]["TwrBsMyt"]
    assert told["mean"] == pytest.approx(late.mean()) and told["max"] == pytest.approx(late.max())
    with (folder / "statistics.csv").open() as stream:
        rows = list(csv.DictReader(stream))
    assert len(rows) == 8
    assert (rows[2]["seed"], rows[2]["channel"]) == ("3", "TwrBsMyt")
    assert float(rows[2]["del"]) == told["del"]


def test_default_folder_and_steady_wind(run, tmp_path):
    done = run(*QUICK, "--turbulence", "none", "--wind-speed", "9", "--no-plots")
    assert done.status == 0, done.err
    folder = tmp_path / "simulate-nrel-5mw"
    names = sorted(path.name for path in folder.iterdir())
    assert names == ["simulation.json", "statistics.csv", "u9.csv"]
    assert "nrel-5mw: none" not in done.out and "steady wind" in done.out


def test_options_arrive(document):
    plain = document("--turbulence", "none", "--wind-speed", "15")
    changed = document(
        "--turbulence", "none", "--wind-speed", "15", "--shear", "0", "--no-tower-shadow",
        "--inflow", "quasi-steady", "--freedoms", "rotor-speed", "--pitch-lag", "0.3",
        "--controller", "tuned", "--channels", "all", "--interval", "0.1",
    )  # fmt: skip
    told = changed["settings"]
    assert (told["shear"], told["tower_shadow"], told["inflow"]) == (0.0, False, "quasi-steady")
    assert (told["freedoms"], told["pitch_lag"]) == (["rotor-speed"], 0.3)
    assert told["interval"] == 0.1
    assert document("--turbulence", "none", "--interval", "0.12")["settings"]["interval"] == 0.1
    assert len(changed["channels"]) > 80
    still = changed["runs"][0]["statistics"]
    assert still["TTDspFA"]["std"] == 0.0 and still["OoPDefl1"]["std"] == 0.0
    assert plain["runs"][0]["statistics"]["TTDspFA"]["std"] > 0.0
    # neither shear nor tower: the moment varies with the weight of the blades alone
    assert still["RootMyc1"]["std"] < 0.3 * plain["runs"][0]["statistics"]["RootMyc1"]["std"]
    assert document("--turbulence", "none", "--freedoms", "none")["settings"]["freedoms"] == []


@pytest.mark.parametrize(("text", "expected"), [("2", (1, 2)), ("4:6", (4, 5, 6)), ("9,3", (9, 3))])
def test_seeds(text, expected):
    assert seeds("--seeds", text) == expected


def test_turbulence_by_class_and_intensity(document):
    stds = [
        document("--turbulence", kind, "--channels", "Wind1VelX")["runs"][0]["statistics"][
            "Wind1VelX"
        ]["std"]
        for kind in ("C", "A+", "0.01")
    ]
    # sigma_1 = I_ref (0.75 U + 5.6): 0.12 and 0.18, the same seed
    assert stds[1] / stds[0] == pytest.approx(0.18 / 0.12, rel=1e-4)
    assert stds[2] / stds[0] == pytest.approx(0.01 * 12 / (0.12 * (0.75 * 12 + 5.6)), rel=1e-4)


def test_cache(run, tmp_path):
    done = run(*QUICK, "--seeds", "2", "--cache", "boxes", "--json")
    assert done.status == 0
    boxes = list((tmp_path / "boxes").iterdir())
    assert len(boxes) == 2
    again = run(*QUICK, "--seeds", "2", "--cache", "boxes", "--json")
    none = run(*QUICK, "--seeds", "2", "--no-cache", "--json")
    found = [json.loads(out)["summary"] for out in (done.out, again.out, none.out)]
    assert found[0] == found[1] == found[2]
    assert len(list((tmp_path / "boxes").iterdir())) == 2


def test_another_turbine_and_controller(document):
    found = document("--turbine", "iea-3.4-130", "--controller", "ipc", "--wind-speed", "16")
    assert found["turbine"] == "iea-3.4-130"
    pitch = found["runs"][0]["statistics"]
    assert abs(pitch["BldPitch1"]["mean"] - pitch["BldPitch2"]["mean"]) > 0.01
    together = document("--turbine", "iea-3.4-130", "--wind-speed", "16")["runs"][0]["statistics"]
    assert together["BldPitch1"] == together["BldPitch2"]


def test_run_that_diverges(run, tmp_path):
    (tmp_path / "runaway.toml").write_text(RUNAWAY)
    options = (
        "--wind-speed", "11", "--turbulence", "0.5", "--seeds", "2", "--duration", "60", "--skip",
        "20", "--box-points", "13", "--controller", "runaway.toml", "--step", "0.05",
    )  # fmt: skip
    done = run("simulate", *options, "--json")
    assert done.status == 1
    found = json.loads(done.out)  # refuses nothing but has no NaN:
    assert "NaN" not in done.out and "Infinity" not in done.out
    for one in found["runs"]:
        assert one["status"] == "diverged"
        assert 10.0 < one["diverged_at"] < 80.0
        assert "diverged at" in one["message"]
    assert any(one["statistics"] is None for one in found["runs"])
    assert found["summary"][0]["statistics"] is None
    assert found["summary"][0]["diverged"] == 2
    lines = done.err.strip().splitlines()
    assert len(lines) == 2 and all("11 m/s, seed" in line for line in lines)
    told = run("simulate", *options, "--out", "here")
    assert told.status == 1
    assert told.out.count("diverged at") == 2
    assert (tmp_path / "here" / "overview.png").is_file()


def test_designed_profile_as_a_feedforward(run, tmp_path):
    """A profile designed on the static rotor takes tilt and yaw variation off the moving one."""
    designed = run(
        "design", "--case", "nrel-5mw", "--wind-speed", "16", "--mean-torque", "rated",
        "--positions", "12", "--starts", "1", "--no-certify", "--no-plots", "--out", "designed",
    )  # fmt: skip
    assert designed.status == 0, designed.err
    feed = '[feedforward]\nprofile = "designed/{}"\nharmonics = 3\n'
    found = []
    for name in (None, "profiles.npz", "profile.csv"):
        (tmp_path / "own.toml").write_text('base = "tuned"' if name is None else feed.format(name))
        done = run(
            "simulate", "--wind-speed", "16", "--turbulence", "none", "--step", "0.05", "--skip",
            "60", "--duration", "20", "--channels", "YawBrMyp,YawBrMzp,GenPwr", "--controller",
            "own.toml", "--json",
        )  # fmt: skip
        assert done.status == 0, done.err
        found.append(json.loads(done.out)["runs"][0]["statistics"])
    plain, played, text = found
    for load in ("YawBrMyp", "YawBrMzp"):
        assert played[load]["std"] < 0.4 * plain[load]["std"]
        assert text[load]["std"] == pytest.approx(played[load]["std"], rel=1e-6)
    assert played["GenPwr"]["mean"] == pytest.approx(plain["GenPwr"]["mean"], rel=1e-3)


def bts(path, *, width=140.0, duration=20.0):
    box = kaimal_box(12.0, duration, 0.5, hub_height=90.0, width=width, points=(4, 4), seed=1)
    mean = StaticField(speed=12.0, hub_height=90.0, vertical=PowerLaw(exponent=0.2))
    write_bts(path, TurbulentField(mean=mean, box=box))


def test_turbsim_file(document, tmp_path):
    bts(tmp_path / "wind.bts")
    found = document("--turbulence", "wind.bts")
    (one,) = found["runs"]
    assert (one["wind_speed"], one["seed"], one["turbulence"]) == (12.0, None, "TurbSim, wind.bts")
    told = found["settings"]
    assert (told["shear"], told["seeds"], told["wind_speeds"]) == (None, [], [12.0])


@pytest.mark.parametrize(
    ("args", "message"),
    [
        (("--turbulence", "D"), "turbulence: got 'D', expected one of A+, A, B, C, none"),
        (("--turbulence", "7"), "turbulence: got 7, expected an intensity"),
        (("--turbulence", "absent.bts"), "absent.bts: cannot be read"),
        (("--turbulence", "damaged.bts"), "damaged.bts: got"),
        (("--turbulence", "text.bts"), "text.bts: got"),
        (("--turbulence", "small.bts"), "wind: "),
        (("--turbulence", "good.bts", "--duration", "60"), "repeats after 20 s"),
        (("--turbulence", "good.bts", "--wind-speed", "9"), "the file's own 12 m/s"),
        (("--turbulence", "absent_u.bin"), "box_shape: got none"),
        (
            ("--turbulence", "absent_u.bin", "--box-shape", "8,8,8", "--box-spacing", "1,2,3"),
            "absent_u.bin: cannot be read",
        ),
        (("--box-shape", "8,8"), "--box-shape: got '8,8'"),
        (("--box-spacing", "0,1,2"), "--box-spacing: got '0,1,2'"),
        (("--wind-speed", "2"), "cut-in at 3 m/s"),
        (("--wind-speed", "8,26"), "cut-out at 25 m/s"),
        (("--wind-speed", "x"), "--wind-speed: got 'x'"),
        (("--wind-speed", "8", "--wind-speed", "8"), "wind_speeds: got 8, 8"),
        (("--duration", "0"), "--duration: got '0'"),
        (("--duration", "nan"), "--duration: got 'nan'"),
        (("--duration", "0.01"), "duration: got 0.01"),
        (("--skip", "-1"), "--skip: got '-1'"),
        (("--seeds", "0"), "--seeds: got '0'"),
        (("--seeds", "5:3"), "--seeds: got '5:3'"),
        (("--seeds", "1,x"), "--seeds: got '1,x'"),
        (("--seeds", "1,1"), "seeds: got (1, 1)"),
        (("--seeds", "2", "--turbulence", "none"), "the wind is given"),
        (("--channels", "GenPower"), "did you mean 'GenPwr'"),
        (("--channels", "a,,b"), "--channels: got 'a,,b'"),
        (("--controller", "baselin"), "did you mean 'baseline'"),
        (("--controller", "absent.toml"), "absent.toml: no such file"),
        (("--controller", "typo.toml"), "typo.toml: pitch.frequncy: unknown key"),
        (("--turbine", "nrel"), "turbine: got 'nrel'"),
        (("--turbine", "biegel2011"), "generator inertia is not known (windIO files"),
        (("--freedoms", "flap"), "freedoms: got 'flap'"),
        (("--format", "xls"), "--format: got 'xls'"),
        (("--inflow", "none"), "--inflow"),
        (("--step", "0.5"), "--step: got '0.5'"),
        (("--box-points", "51"), "--box-points: got '51', expected a whole number from 2 to 50"),
        (("--cache", "text.bts"), "text.bts: cannot be made or is not a folder"),
        (("--cache", "a", "--no-cache"), "--no-cache: got it together with --cache"),
        (("--out", "text.bts"), "--out: got 'text.bts'"),
        (("--weibull-mean", "0"), "--weibull-mean: got '0'"),
    ],
)
def test_bad_input(run, tmp_path, args, message):
    bts(tmp_path / "good.bts")
    bts(tmp_path / "small.bts", width=100.0)
    whole = (tmp_path / "good.bts").read_bytes()
    (tmp_path / "damaged.bts").write_bytes(whole[:-7])
    (tmp_path / "text.bts").write_bytes(struct.pack("<h", 999) + whole[2:])
    (tmp_path / "typo.toml").write_text("[pitch]\nfrequncy = 1\n")
    done = run(*QUICK, *args, "--json")
    assert done.status == 2
    assert done.out == ""
    assert message in done.err
    assert done.err.count("\n") == 1


def test_help_names_the_parts_of_a_controller_file(run):
    from pitchopt.studies.simulation.controller_file import _SECTIONS

    text = run("simulate", "--help").out
    for section, keys in _SECTIONS.items():
        assert f"[{section}]" in text
        for key in keys:
            assert key in text, key
