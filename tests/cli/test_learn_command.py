"""``pitchopt learn``: document, files, tables, right and wrong input of every option."""

from __future__ import annotations

import csv
import json
import re

import numpy as np
import pytest

from pitchopt.cases import load_case
from pitchopt.exports import read_profile_csv

SMALL = ("learn", "--positions", "6", "--segments", "10")
QUICK = (*SMALL, "--rotations", "4")


@pytest.fixture
def document(run):
    """Run with --json; the document."""

    def call(*args: object) -> dict:
        done = run(*QUICK, *args, "--json")
        assert done.status == 0, done.err
        return json.loads(done.out)

    return call


def test_schema_of_the_document(run, tmp_path, monkeypatch):
    monkeypatch.setattr("pitchopt.cli.progress.DELAY", 1e6)  # no bar on a slow machine either
    done = run(*SMALL, "--rotations", "21", "--wind-step", "10:+2", "--json")
    assert done.status == 0, done.err
    assert done.err == ""
    assert list(tmp_path.iterdir()) == []
    found = json.loads(done.out)
    assert list(found) == [
        "case", "settings", "learner", "experiment", "rotations", "baseline", "baseline_after",
        "start", "design", "design_after", "cut_at_20", "ratio_to_design",
        "ratio_to_design_rotation", "ratio_to_design_from_start", "recovery_rotations", "passages",
        "learned", "events",
        "setpoint_after", "seconds",
    ]  # fmt: skip
    assert (found["case"], found["learner"]) == ("biegel2011", "adaptive")
    assert found["settings"]["limits"]["positions"] == 6
    assert found["settings"]["learning"]["wind"] == {
        "kind": "step", "speed": 15.0, "change": 2.0, "rotation": 10,
    }  # fmt: skip
    assert set(found["experiment"]) == {"rotations", "passages", "rms_sum", "largest_move_deg"}
    assert [row["rotation"] for row in found["rotations"]] == list(range(1, 22))
    for row in found["rotations"]:
        assert set(row) == {
            "rotation", "passage", "rms_sum", "rms", "rms_weighted", "rms_weighted_rotation",
            "rms_measured_weighted", "mean_torque", "setpoint", "wind_speed", "ratio_to_design",
            "ratio_to_design_rotation",
        }  # fmt: skip
        assert set(row["rms"]) == {"torque", "tilt", "yaw", "thrust"}
    assert [row["wind_speed"] for row in found["rotations"]] == [15.0] * 10 + [17.0] * 11
    shared = {
        "mean_torque", "rms", "rms_sum", "rms_weighted", "blade_rms", "mean_tilt", "mean_yaw",
        "pitch_travel_deg", "outside",
    }  # fmt: skip
    for name in ("baseline", "baseline_after", "start", "design", "design_after", "learned"):
        assert shared <= set(found[name]), name
    assert "pitch_deg" in found["baseline"] and "pitch_deg" in found["start"]
    assert "setpoint" in found["design"]
    assert len(found["learned"]["pitch_deg"]) == len(found["learned"]["azimuth_deg"]) == 18
    assert 0 < found["cut_at_20"] < 1
    assert 1 <= found["recovery_rotations"] <= 11
    assert found["setpoint_after"] == found["rotations"][-1]["setpoint"]
    assert set(found["ratio_to_design"]) == {"at_10", "at_20"}
    assert found["seconds"] > 0


def test_tables_and_files_of_the_papers_learner(run, tmp_path):
    done = run(*QUICK, "--learner", "paper", "--wind-step", "2:+2", "--out", "here")
    assert done.status == 0, done.err
    for text in (
        "paper learner, +2 m/s after rotation 2",
        "best constant pitch", "design after the change", "rotation 3 ", "experiment: 3 rotations",
        "set-point in the new wind", "7 % below the largest there", "RMS of a blade's bending",
        "pitch travel a revolution", "after the step: ", "7 files in here/",
    ):  # fmt: skip
        assert text in done.out, text
    assert "1.10e3" not in done.out  # not the paper's positions
    folder = tmp_path / "here"
    names = sorted(path.name for path in folder.iterdir())
    assert names == [
        "contraction.png", "learning.csv", "learning.json", "learning.png", "profile.csv",
        "profiles.npz", "profiles.png",
    ]  # fmt: skip
    found = json.loads((folder / "learning.json").read_text())
    with (folder / "learning.csv").open() as stream:
        rows = list(csv.DictReader(stream))
    assert [int(row["rotation"]) for row in rows] == [1, 2, 3, 4]
    for row, own in zip(rows, found["rotations"], strict=True):
        assert float(row["rms_sum"]) == own["rms_sum"]
        assert float(row["rms_tilt"]) == own["rms"]["tilt"]
    psi, pitch = read_profile_csv(folder / "profile.csv")
    np.testing.assert_allclose(np.rad2deg(pitch), found["learned"]["pitch_deg"], atol=1e-12)
    np.testing.assert_allclose(np.rad2deg(psi), found["learned"]["azimuth_deg"], atol=1e-12)
    exported = run("export", "here/profiles.npz", "--point", "learned", "--format", "csv")
    assert exported.status == 0, exported.err
    assert (tmp_path / "profile.csv").read_text() == (folder / "profile.csv").read_text()
    for path in folder.glob("*.png"):
        assert path.read_bytes().startswith(b"\x89PNG")


def test_files_with_a_profile_for_each_blade(run, tmp_path):
    done = run(
        *QUICK, "--separate", "--blade-chord", "1.02", "--blade-pitch-offset-deg", "0.3",
        "--no-plots",
    )  # fmt: skip
    assert done.status == 0, done.err
    assert "one profile for each blade" in done.out
    assert "blade 1: pitch +0.3 deg, chord x 1.02" in done.out
    folder = tmp_path / "learn-biegel2011"
    names = sorted(path.name for path in folder.iterdir())
    assert names == [
        "learning.csv", "learning.json", "profile_b1.csv", "profile_b2.csv", "profile_b3.csv",
    ]  # fmt: skip
    found = json.loads((folder / "learning.json").read_text())
    for blade, pitch in enumerate(found["learned"]["pitch_deg"], start=1):
        own = read_profile_csv(folder / f"profile_b{blade}.csv")[1]
        np.testing.assert_allclose(np.rad2deg(own), pitch, atol=1e-12)


def test_the_papers_figures_beside_ours(run):
    done = run("learn", "--rotations", "20", "--no-plots", "--learner", "paper")
    assert done.status == 0, done.err
    for text in ("2.94e4", "2.80e3", "1.10e3", "mean torque off the set-point"):
        assert text in done.out
    assert re.search(r"RMS cut against the best constant pitch \[%\] +91 +9\d\.\d", done.out)


def test_profiles_are_described_in_the_wind_of_the_end(run, tmp_path):
    done = run(*QUICK, "--wind-step", "2:+2", "--no-plots", "--out", "here")
    assert done.status == 0, done.err
    found = json.loads((tmp_path / "here" / "learning.json").read_text())
    line = next(text for text in done.out.splitlines() if text.startswith("RMS of a blade's"))
    for label, name in (("design", "design_after"), ("best constant pitch", "baseline_after")):
        shown = float(re.search(rf"{label} ([\d.]+) kN m", line)[1])
        assert shown == pytest.approx(1e-3 * found[name]["blade_rms"], rel=1e-3)
    own = json.loads(run(*QUICK, "--wind-speed", "17", "--json").out)
    for name in ("pitch_deg", "mean_torque", "rms_sum", "blade_rms"):
        assert found["baseline_after"][name] == pytest.approx(own["baseline"][name], rel=1e-12)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("wind", "shown"),
    [
        (("--wind-step", "20:+2"), True),
        (("--wind-step", "19:+2"), False),  # rotation 20 and the design would be of two winds
        (("--wind-ramp", "20-22:+2"), True),
        (("--wind-ramp", "18-30:+2"), False),
        (("--wind-drift", "0.1"), False),
    ],
)
def test_the_papers_figures_are_those_of_one_wind(run, wind, shown):
    done = run("learn", "--rotations", "20", "--no-plots", "--learner", "paper", *wind)
    assert done.status == 0, done.err
    assert ("Beside the paper" in done.out) is shown


def test_sensor_options_arrive(document):
    plain = document()["settings"]["learning"]
    assert plain["noise"] == plain["quantisation"] == plain["dropout"] == plain["delay"] == 0
    found = document(
        "--noise", "2%", "--noise-of", "mean", "--quantisation", "0.01", "--delay", "2",
        "--dropout", "5 %", "--seed", "9", "--amplitude-deg", "0.4", "--start-pitch-deg", "-1",
    )  # fmt: skip
    told = found["settings"]["learning"]
    expected = {
        "noise": 0.02, "quantisation": 0.01, "delay": 2, "dropout": 0.05,
        "seed": 9, "amplitude_deg": 0.4, "start_pitch_deg": -1.0,
    }  # fmt: skip
    assert told["noise_of"] == "mean"
    assert {name: told[name] for name in expected} == pytest.approx(expected)
    assert found["start"]["pitch_deg"] == pytest.approx(-1.0)
    assert found["experiment"]["largest_move_deg"] == pytest.approx(0.4)
    last = found["rotations"][-1]
    assert last["rms_measured_weighted"] > 1.2 * last["rms_weighted"]  # noise of the mean is large
    assert document("--noise", "0", "--dropout", "0%")["settings"]["learning"] == plain


def test_the_seed_makes_the_noise(document):
    first, again, other = (
        document("--noise", "0.02", "--seed", seed)["rotations"] for seed in (1, 1, 2)
    )
    assert first == again != other


def test_setpoint_options(document):
    found = document("--max-power-loss", "3%", "--learner", "paper")
    least = document("--learner", "paper")
    ratio = found["rotations"][0]["setpoint"] / least["rotations"][0]["setpoint"]
    assert ratio == pytest.approx(0.97 / 0.93)
    held = document("--mean-torque", "1.3e6", "--wind-step", "2:+1.5", "--learner", "paper")
    assert {row["setpoint"] for row in held["rotations"]} == {1.3e6}
    assert [row["wind_speed"] for row in held["rotations"]] == [15.0, 15.0, 16.5, 16.5]


def test_rated_torque_with_induction(run):
    done = run(
        *QUICK, "--case", "nrel-5mw", "--elements", "8", "--wind-speed", "15",
        "--mean-torque", "rated", "--learner", "paper", "--json",
    )  # fmt: skip
    assert done.status == 0, done.err
    found = json.loads(done.out)
    assert found["design"]["setpoint"] == load_case("nrel-5mw").turbine_data.rated_torque
    assert found["settings"]["objective"]["blade_cap"] == "none"


def test_options_of_the_papers_learner(document):
    found = document(
        "--learner", "paper", "--learning-rate", "0.7", "--damping", "0.01", "--smoothing", "0.9"
    )
    told = found["settings"]["learning"]
    assert (told["learning_rate"], told["damping"], told["smoothing"]) == (0.7, 0.01, 0.9)
    slow = document("--learner", "paper")
    assert found["rotations"][0]["rms_sum"] < slow["rotations"][0]["rms_sum"]


def test_ramp_and_drift(document):
    ramp = document("--wind-ramp", "1-3:-0.4", "--learner", "paper")
    assert ramp["settings"]["learning"]["wind"]["change"] == -0.4
    assert ramp["rotations"][0]["wind_speed"] == 15.0
    assert ramp["rotations"][-1]["wind_speed"] == pytest.approx(14.6)
    assert ramp["rotations"][1]["ratio_to_design"] is None
    assert ramp["recovery_rotations"] is None
    assert ramp["design"]["at_mean_wind"] is False
    found = document("--wind-drift", "0.1", "--learner", "paper")
    assert found["design"]["at_mean_wind"] is True
    drift = found["settings"]["learning"]["wind"]
    assert (drift["kind"], drift["std"], drift["rotations_correlation"]) == ("drift", 0.1, 20.0)
    slow = document("--wind-drift", "0.1:40", "--seed", "3", "--learner", "paper")
    wind = slow["settings"]["learning"]["wind"]
    assert (wind["rotations_correlation"], wind["seed"]) == (40.0, 3)


def test_a_run_goes_on_from_its_checkpoint(run, tmp_path):
    options = (*SMALL, "--noise", "0.02", "--checkpoint", "run.npz", "--json")
    assert run(*options, "--rotations", "2").status == 0
    assert [path.name for path in tmp_path.iterdir()] == ["run.npz"]
    resumed = run(*options, "--rotations", "5")
    whole = run(*SMALL, "--noise", "0.02", "--json", "--rotations", "5")
    assert resumed.status == whole.status == 0, resumed.err
    first, second = json.loads(resumed.out), json.loads(whole.out)
    del first["seconds"], second["seconds"]
    assert first == second
    shorter = run(*options, "--rotations", "3")
    assert shorter.status == 2
    assert "rotations: got 3, but run.npz has made 5" in shorter.err


@pytest.mark.parametrize("content", [b"", b"nothing", b"PK\x03\x04"])
def test_files_that_are_no_checkpoint_are_left_alone(run, tmp_path, content):
    (tmp_path / "run.npz").write_bytes(content)
    done = run(*QUICK, "--checkpoint", "run.npz", "--json")
    assert done.status == 2
    assert done.out == ""
    assert "run.npz" in done.err and len(done.err.splitlines()) == 1
    assert (tmp_path / "run.npz").read_bytes() == content


def test_a_torque_out_of_reach_is_bad_input(run):
    done = run(*QUICK, "--mean-torque", "1.7e6", "--json")
    assert done.status == 2
    assert done.out == ""
    assert len(done.err.splitlines()) == 1
    assert "at 15 m/s: mean torque: got 1.7e+06" in done.err


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (("--learner", "best"), r"'best' is not one of 'adaptive', 'paper'"),
        (("--rotations", "0"), r"--rotations: got '0', expected a whole number from 1"),
        (("--rotations", "2.5"), r"--rotations: got '2\.5'"),
        (("--max-power-loss", "0"), r"--max-power-loss: got '0', expected a share"),
        (("--max-power-loss", "120%"), r"--max-power-loss: got '120%'"),
        (("--mean-torque", "x"), r"--mean-torque: got 'x'"),
        (("--mean-torque", "rated"), r"--mean-torque: got 'rated'.*not known"),
        (
            ("--mean-torque", "1e6", "--max-power-loss", "2%"),
            r"--mean-torque: got it together with --max-power-loss",
        ),
        (("--start-pitch-deg", "nan"), r"--start-pitch-deg: got 'nan', expected a number from"),
        (("--start-pitch-deg", "-40"), r"start pitch: got -40 deg, expected -10 to 45 deg"),
        (("--amplitude-deg", "0"), r"--amplitude-deg: got '0'"),
        (("--learning-rate", "0"), r"--learning-rate: got '0'"),
        (("--learning-rate", "0.3"), r"learning_rate: got 0\.3 with the adaptive learner"),
        (("--damping", "0.1"), r"damping: got 0\.1 with the adaptive learner"),
        (("--damping", "-1"), r"--damping: got '-1'"),
        (("--smoothing", "0.5"), r"smoothing: got 0\.5 with the adaptive learner"),
        (("--smoothing", "2"), r"--smoothing: got '2'"),
        (("--noise", "-1%"), r"--noise: got '-1%', expected a share of 0 or more"),
        (("--noise", "nan"), r"--noise: got 'nan'"),
        (("--noise-of", "peak"), r"'peak' is not one of"),
        (("--quantisation", "1"), r"--quantisation: got '1'"),
        (("--delay", "-1"), r"--delay: got '-1'"),
        (("--delay", "5"), r"delay: got 5 samples, expected at most the 4 of a passage"),
        (("--dropout", "few"), r"--dropout: got 'few'"),
        (("--wind-step", "22"), r"--wind-step: got '22', expected ROTATION:CHANGE"),
        (("--wind-step", "2.5:1"), r"--wind-step: got '2\.5:1'"),
        (("--wind-step", "-1:1"), r"--wind-step: got '-1:1'"),
        (("--wind-step", "2:inf"), r"--wind-step: got '2:inf'"),
        (("--wind-step", "2:-15"), r"wind change: got -15 m/s"),
        (("--wind-ramp", "20:2"), r"--wind-ramp: got '20:2', expected FIRST-LAST:CHANGE"),
        (("--wind-ramp", "30-20:2"), r"--wind-ramp: got '30-20:2'"),
        (("--wind-ramp", "1-2:x"), r"--wind-ramp: got '1-2:x'"),
        (("--wind-drift", "0"), r"--wind-drift: got '0', expected STD or STD:ROTATIONS"),
        (("--wind-drift", "0.5:"), r"--wind-drift: got '0\.5:'"),
        (("--wind-drift", "9"), r"wind drift std: got 9"),
        (
            ("--wind-step", "2:1", "--wind-drift", "0.5"),
            r"--wind-drift: got it together with --wind-step",
        ),
        (("--blade-pitch-offset-deg", "x"), r"--blade-pitch-offset-deg: got 'x'"),
        (("--blade-chord", "0"), r"--blade-chord: got '0'"),
        (("--seed", "-1"), r"--seed: got '-1'"),
        (("--checkpoint", "none/run.npz"), r"checkpoint: there is no directory none"),
        (("--blade-cap", "1"), r"--blade-cap: got 1, expected none"),
        (("--travel-penalty", "5"), r"travel penalty: got"),
        (("--weights", "torque=1,blade=1"), r"weights\.blade: got 1, expected 0"),
        (("--learner", "paper", "--harmonics", "2"), r"harmonics: got 2 with the paper's"),
        (("--pitch-rate-deg", "0"), r"limits\.pitch_rate_deg: got 0, expected a rate"),
        (("--case", "none"), r"case: got 'none'"),
        (("surplus",), r"surplus"),
    ],
    ids=lambda value: " ".join(value)[:40],
)
def test_bad_input_is_one_line(run, tmp_path, options, message):
    done = run("learn", "--positions", "4", "--segments", "10", "--rotations", "2", *options)
    assert done.status == 2, done
    assert done.out == ""
    assert len(done.err.splitlines()) == 1, done.err
    assert re.search(message, done.err), done.err
    assert list(tmp_path.iterdir()) == []


# ---- the dynamic turbine -------------------------------------------------------------------

TURBINE = (
    *("learn", "--plant", "dynamic", "--case", "nrel-5mw", "--wind-speed", "9"),
    *("--positions", "8", "--rotations", "4"),
)


@pytest.mark.slow
def test_dynamic_turbine(run, tmp_path):
    done = run(*TURBINE, "--structure", "rigid", "--out", "out")
    assert done.status == 0, done.err
    assert "rigid structure, rotor held, steady wind" in done.out
    assert "profiles held in the steady wind" in done.out
    assert sorted(path.name for path in (tmp_path / "out").iterdir()) == [
        "learning.csv", "learning.json", "learning.png", "profile.csv",
    ]  # fmt: skip
    found = json.loads((tmp_path / "out" / "learning.json").read_text())
    assert (found["plant"], found["judged_on_seeds"]) == ("dynamic", [])
    assert found["settings"]["turbine"] == {
        "turbulence": "none", "structure": "rigid", "rotor": "held", "pitch_lag": 0.0,
        "averaged": 0, "longest_step": 0.025,
    }  # fmt: skip
    rows = list(csv.DictReader((tmp_path / "out" / "learning.csv").read_text().splitlines()))
    assert [float(row["left"]) for row in rows] == [row["left"] for row in found["rotations"]]
    assert found["rotations"][3]["left"] < 0.4
    _, pitch = read_profile_csv(tmp_path / "out" / "profile.csv")[:2]
    np.testing.assert_allclose(np.rad2deg(pitch), found["learned"]["pitch_deg"], atol=1e-6)


@pytest.mark.parametrize(
    ("arguments", "text"),
    [
        (("learn", "--turbulence", "B"), "--turbulence: got 'B' with --plant static"),
        (("learn", "--averaged", "2"), "--averaged: got 2 with --plant static"),
        ((*TURBINE, "--wind-step", "3:+1"), "--wind-step: got .* with --plant dynamic"),
        ((*TURBINE, "--blade-chord", "1.1"), "--blade-chord: got 1.1 with --plant dynamic"),
        ((*TURBINE, "--rotor", "controlled"), "rotor: got 'controlled' at 9 m/s"),
        (("learn", "--plant", "dynamic"), "turbine 'biegel2011': blade structure, hub"),
    ],
)
def test_wrong_options_of_the_dynamic_turbine(run, tmp_path, arguments, text):
    done = run(*arguments)
    assert done.status != 0
    assert re.search(text, done.err), done.err
    assert done.err.count("\n") == 1
    assert not any(path.suffix for path in tmp_path.rglob("*.json"))
