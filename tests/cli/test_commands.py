"""The commands: tables, JSON, files, exit status."""

from __future__ import annotations

import csv
import json
import re
import subprocess
import sys
import tomllib
from pathlib import Path

import numpy as np
import pytest

import pitchopt.cli.main
import pitchopt.cli.progress
from pitchopt.aero.curves import BladeCurves
from pitchopt.cases import load_case
from pitchopt.cli import main
from pitchopt.cli.values import as_share
from pitchopt.errors import ComputationError, InfeasibleError, InputError
from pitchopt.exports import ProfileSet, read_harmonics_csv, read_motion_files, read_profile_csv


def names(folder: Path) -> list[str]:
    return sorted(path.name for path in folder.iterdir())


# ---- help ----------------------------------------------------------------------------------


def test_without_arguments_the_help_is_shown(run):
    done = run()
    assert done.status == 0
    for word in (
        "tradeoff",
        "design",
        "robust",
        "schedule",
        "export",
        "turbines",
        "First steps",
        "Exit status",
    ):
        assert word in done.out


@pytest.mark.parametrize(
    "command", ["tradeoff", "design", "robust", "schedule", "export", "turbines"]
)
def test_every_help_has_examples(run, command):
    done = run(command, "--help")
    assert done.status == 0
    assert f"pitchopt {command}" in done.out.split("Examples:")[1]
    assert max(map(len, done.out.splitlines())) <= 100


def test_version(run):
    assert run("--version").out.strip().endswith(pitchopt.__version__)


def test_help_loads_nothing_heavy():
    code = (
        "import sys\nfrom pitchopt.cli import main\nmain(['tradeoff', '--help'])\n"
        "heavy = {'numpy', 'scipy', 'cvxpy', 'clarabel', 'matplotlib', 'numba', 'tqdm', 'yaml'}\n"
        "print(sorted(heavy & set(sys.modules)))"
    )
    done = subprocess.run([sys.executable, "-c", code], check=True, capture_output=True, text=True)
    assert done.stdout.splitlines()[-1] == "[]"


def test_the_module_is_the_program():
    done = subprocess.run(
        [sys.executable, "-m", "pitchopt", "design", "--mu", "x"],
        capture_output=True,
        text=True,
        check=False,
    )
    assert (done.returncode, done.stdout) == (2, "")
    expected = "--mu: got 'x', expected finite numbers of 0 or more, such as 1,3,10"
    assert done.stderr == f"pitchopt: {expected}\n"


# ---- tradeoff ------------------------------------------------------------------------------


def test_tradeoff_prints_a_table_and_writes_its_files(run, small, tmp_path):
    done = run("tradeoff", *small, "--mu", "1", "--mu", "10", "--loss", "1 %", "--out", "here")
    assert done.status == 0, done.err
    for text in (
        "best constant pitch", "power maximum", "mu=1 ", "mu=10", "loss=1%", "loss=3%", "loss=7%",
        "<- knee", "kN m", "between", "lost", "travel", "gap", "converged", "8 files in here/",
    ):  # fmt: skip
        assert text in done.out, text
    assert names(tmp_path) == ["here"]
    assert names(tmp_path / "here") == [
        "certificates.npz", "loads.png", "profiles.npz", "profiles.png", "tradeoff.csv",
        "tradeoff.json",
        "tradeoff.png", "wind.png",
    ]  # fmt: skip
    rows = list(csv.DictReader((tmp_path / "here" / "tradeoff.csv").read_text().splitlines()))
    assert [row["label"] for row in rows[:2]] == ["constant", "power_max"]
    assert len(rows) == 2 + 2 + 3
    assert sum(row["knee"] == "1" for row in rows) == 1
    document = json.loads((tmp_path / "here" / "tradeoff.json").read_text())
    assert rows[2 + document["knee"]["index"]]["knee"] == "1"


def test_tradeoff_as_json_prints_one_document_and_writes_nothing(run, small, tmp_path):
    done = run("tradeoff", *small, "--mu", "3", "--json")
    assert done.status == 0
    document = json.loads(done.out)
    assert names(tmp_path) == []
    assert document["case"] == "biegel2011"
    assert document["settings"]["limits"]["positions"] == 6
    assert document["settings"]["search"]["losses"] == [0.03, 0.07]
    kinds = [point["kind"] for point in document["points"]]
    assert sorted(kinds) == ["max_power_loss", "max_power_loss", "mu"]
    by_loss = {p.get("loss_target"): p for p in document["points"]}
    assert by_loss[0.03]["loss"] <= 0.03 + 1e-6
    constant = document["constant"]
    for point in document["points"]:
        expected = 1 - point["rms_weighted"] / constant["rms_weighted"]
        assert point["cut"] == pytest.approx(expected)
        assert point["upper_bound"] >= point["objective"] - 1e-6 * constant["mean_torque"]


def test_json_and_out_together(run, small, tmp_path):
    done = run("tradeoff", *small, "--mu", "3", "--json", "--out", "x", "--no-plots")
    assert json.loads(done.out) == json.loads((tmp_path / "x" / "tradeoff.json").read_text())
    assert names(tmp_path / "x") == [
        "certificates.npz",
        "profiles.npz",
        "tradeoff.csv",
        "tradeoff.json",
    ]


def test_the_folder_has_a_default_and_keeps_what_is_there(run, small, tmp_path):
    folder = tmp_path / "tradeoff-biegel2011"
    folder.mkdir()
    (folder / "mine.txt").write_text("mine")
    done = run("tradeoff", *small, "--points", "1", "--no-plots", "--no-certify")
    assert done.status == 0
    assert "tradeoff-biegel2011/" in done.out
    assert (folder / "mine.txt").read_text() == "mine"
    document = json.loads((folder / "tradeoff.json").read_text())
    assert all(point["upper_bound"] is None for point in document["points"])


def test_the_same_seed_gives_the_same_result(run, small):
    def once() -> list[float]:
        done = run("tradeoff", *small, "--starts", "7", "--seed", "5", "--mu", "20", "--json")
        return [p["objective"] for p in json.loads(done.out)["points"]]

    assert once() == once()


def test_the_paper_stands_beside_the_built_in_case_only(run, small, monkeypatch):
    assert "paper" not in run("tradeoff", *small, "--mu", "3", "--no-plots").out


def test_the_papers_table():
    from pitchopt.cli.tables import paper_table

    point = {"rms_sum": 400.0, "cut": 0.985, "cut_between": 0.94, "mean_torque": 1.33e6}
    document = {
        "constant": {"mean_torque": 1.41e6, "rms_sum": 3.2e4},
        "power_max": {"mean_torque": 1.4241e6, "rms_sum": 7e3, "cut": 0.76},
        "points": [{**point, "loss_target": 0.07}, {**point, "loss_target": 0.03, "cut": 0.981}],
    }
    rows = [line.split() for line in paper_table(document).splitlines()]
    assert ["paper", "here"] in rows
    text = paper_table(document)
    for figure in ("1.41e6", "3.2e4", "1.42e6", "1.28e4", "0.7", "60", "1.33e6", "1.10e3", "96"):
        assert figure in text
    for ours in ("1.410e6", "3.200e4", "1.00", "76.00", "98.50", "98.10", "94.00"):
        assert ours in text


# ---- design --------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("goal", "label"),
    [
        (("--mu", "5"), "mu=5"),
        (("--max-power-loss", "2%"), "loss=2%"),
        (("--max-power-loss", "0.02"), "loss=2%"),
        (("--mean-torque", "1.3e6"), "torque=1.3e+06"),
    ],
)
def test_design(run, small, tmp_path, goal, label):
    done = run("design", *small, *goal, "--no-plots", "--out", "d")
    assert done.status == 0, done.err
    assert f"{label} " in done.out
    assert "RMS cut against the constant pitch: torque" in done.out
    assert names(tmp_path / "d") == [
        "certificates.npz",
        "design.json",
        "profile.csv",
        "profiles.npz",
    ]
    document = json.loads((tmp_path / "d" / "design.json").read_text())
    azimuth, pitch = read_profile_csv(tmp_path / "d" / "profile.csv")
    assert np.rad2deg(azimuth) == pytest.approx(document["azimuth_deg"])
    assert np.rad2deg(pitch) == pytest.approx(document["pitch_deg"])
    design = document["design"]
    if "--mean-torque" in goal:
        assert design["mean_torque"] == pytest.approx(1.3e6, rel=1e-6)
        assert document["constant"]["mean_torque"] == pytest.approx(1.3e6, rel=1e-4)
        assert design["mean_torque_target"] == 1.3e6
    elif "--max-power-loss" in goal:
        assert design["loss"] <= 0.02 + 1e-6


def test_design_draws(run, small, tmp_path):
    assert run("design", *small, "--mu", "5", "--no-certify").status == 0
    assert names(tmp_path / "design-biegel2011") == [
        "design.json", "loads.png", "profile.csv", "profiles.npz",
        "profiles.png", "wind.png",
    ]  # fmt: skip


def test_options_reach_the_design(run, small):
    done = run(
        "design", *small, "--mu", "2", "--json", "--wind-speed", "14", "--shear", "0.1",
        "--pitch-rate-deg", "6", "--pitch-min-deg", "-1", "--pitch-max-deg", "12", "--weights",
        "torque=1,thrust=80", "--blade-cap", "1.5", "--harmonics", "1", "--travel-penalty", "100",
        "--elements", "3", "--rotor-speed-rpm", "18", "--induction", "none",
    )  # fmt: skip
    assert done.status == 0, done.err
    settings = json.loads(done.out)["settings"]
    assert settings["wind"]["speed"] == 14.0
    assert settings["wind"]["shear_exponent"] == 0.1
    assert settings["limits"]["pitch_rate_deg"] == 6.0
    assert settings["limits"]["pitch_min_deg"] == -1.0
    assert settings["limits"]["pitch_max_deg"] == 12.0
    assert settings["objective"]["weights"]["thrust"] == 80.0
    assert settings["objective"]["weights"]["tilt"] == 0.0
    assert settings["objective"]["blade_cap"] == 1.5
    assert settings["objective"]["harmonics"] == 1
    assert settings["objective"]["travel_penalty"] == 100.0
    assert settings["aero"]["elements"] == 3
    assert settings["operation"]["rotor_speed_rpm"] == 18.0
    azimuth = np.deg2rad(json.loads(done.out)["azimuth_deg"])
    pitch = np.array(json.loads(done.out)["pitch_deg"])
    basis = np.stack([np.ones_like(azimuth), np.cos(azimuth), np.sin(azimuth)], axis=1)
    left = pitch - basis @ np.linalg.lstsq(basis, pitch, rcond=None)[0]
    assert np.abs(left).max() < 1e-9


@pytest.fixture
def table(tmp_path):
    curves = load_case("biegel2011").with_values({"aero.segments": 10}).model().curves(6)
    return curves.save(tmp_path / "c.npz")


def test_design_on_curves_of_another_code(run, small, table):
    same = run("design", *small, "--mu", "5", "--json")
    args = ["--curves", table, "--rotor-speed-rpm", "19.09859", "--pitch-rate-deg", "10"]
    own = run(
        "design", *args, "--weights", "unit", "--blade-cap", "none", "--mu", "5", "--starts", "1",
        "--json",
    )  # fmt: skip
    assert own.status == 0, own.err
    one, other = (json.loads(done.out)["design"] for done in (same, own))
    assert other["objective"] == pytest.approx(one["objective"], rel=1e-6)
    assert other["rms_sum_between"] is None
    assert other["cut_between"] is None


def test_curves_with_the_limits_of_a_case(run, small, table, tmp_path):
    done = run(
        "tradeoff", "--case", "biegel2011", "--curves", table, "--mu", "5", "--starts", "1",
        "--out", "o",
    )  # fmt: skip
    assert done.status == 0, done.err
    assert "curves" in done.out
    assert "wind.png" not in names(tmp_path / "o")


# ---- turbines ------------------------------------------------------------------------------


def test_turbines(run):
    done = run("turbines")
    assert done.status == 0
    for key in pitchopt.cases.builtin_names():
        assert f"{key} " in done.out
    assert "rpm" in done.out
    document = json.loads(run("turbines", "--json").out)
    assert [t["key"] for t in document["turbines"]] == list(pitchopt.cases.builtin_names())
    assert document["turbines"][1]["hub_height"] == 90.0


def test_one_turbine(run, project_root):
    assert "pitch" in run("turbines", "nrel-5mw").out
    own = run("turbines", project_root / "examples" / "data" / "example-1.5MW-77.yaml")
    assert own.status == 0
    assert "38.5 m" in own.out


def test_templates_are_case_files(run, small, tmp_path):
    done = run("turbines", "--template", "biegel2011")
    assert tomllib.loads(done.out)["turbine"] == "biegel2011"
    (tmp_path / "mine.toml").write_text(done.out.replace("positions = 24", "positions = 4"))
    solved = run("tradeoff", "--case", "mine.toml", "--mu", "3", "--starts", "1", "--json")
    assert solved.status == 0
    assert json.loads(solved.out)["settings"]["limits"]["positions"] == 4


# ---- export --------------------------------------------------------------------------------


def test_export_csv(run, finished, tmp_path):
    done = run("export", finished / "profiles.npz", "--format", "csv", "--point", "loss=3%")
    assert done.status == 0
    assert done.out == "loss=3%: profile.csv\n"
    profiles = ProfileSet.load(finished / "profiles.npz")
    _, pitch = read_profile_csv(tmp_path / "profile.csv")
    assert pitch == pytest.approx(profiles.profiles[profiles.row("loss=3%")])


@pytest.mark.parametrize("point", ["0", "power_max", "constant", None])
def test_export_harmonics(run, finished, tmp_path, point):
    chosen = () if point is None else ("--point", point)
    done = run("export", finished / "profiles.npz", "--format", "harmonics", *chosen, "--out", "h")
    assert done.status == 0
    profiles = ProfileSet.load(finished / "profiles.npz")
    series = read_harmonics_csv(tmp_path / "h" / "harmonics.csv")
    expected = profiles.profiles[profiles.row(point or "knee")]
    assert series(profiles.azimuth) == pytest.approx(expected)


@pytest.mark.parametrize("interpolation", ["linear", "fourier"])
def test_export_aerodyn(run, finished, tmp_path, interpolation):
    done = run(
        "export", finished / "profiles.npz", "--format", "aerodyn", "--step-deg", "2.5",
        "--revolutions", "2", "--interpolation", interpolation, "--json",
    )  # fmt: skip
    files = json.loads(done.out)["files"]
    assert [Path(f).name for f in files] == [
        "pitch_b1.csv", "pitch_b2.csv", "pitch_b3.csv", "driver_motion.txt",
    ]  # fmt: skip
    motion = read_motion_files([tmp_path / f"pitch_b{b}.csv" for b in (1, 2, 3)])
    assert motion.time.size == 2 * 144 + 1
    profiles = ProfileSet.load(finished / "profiles.npz")
    profile = profiles.profiles[profiles.row("knee")]
    every = round(np.deg2rad(20.0) / np.deg2rad(2.5))
    assert motion.pitch[0, :144:every] == pytest.approx(profile)


def test_export_solves_a_design_itself(run, small, tmp_path):
    done = run("export", *small, "--max-power-loss", "3%", "--format", "csv", "--no-certify")
    assert done.status == 0, done.err
    assert names(tmp_path) == ["profile.csv"]


def test_export_of_a_design_needs_no_point(run, small):
    assert run("design", *small, "--mu", "3", "--no-plots", "--out", "d").status == 0
    done = run("export", "d/profiles.npz", "--format", "csv")
    assert done.out == "mu=3: profile.csv\n"


def test_unknown_points_name_those_that_are_there(run, finished):
    done = run("export", finished / "profiles.npz", "--format", "csv", "--point", "best")
    assert done.status == 2
    assert "knee, constant, power_max, mu=1" in done.err


# ---- failures ------------------------------------------------------------------------------


def test_a_torque_out_of_reach_is_bad_input(run, small, tmp_path):
    done = run("design", *small, "--mean-torque", "1e9")
    assert done.status == 2
    assert "1e+09" in done.err
    assert len(done.err.splitlines()) == 1
    assert names(tmp_path) == []


@pytest.mark.parametrize(
    ("error", "status", "text"),
    [
        (InputError("x: got 1"), 2, "x: got 1"),
        (InfeasibleError("nothing\nfits"), 2, "nothing fits"),
        (ComputationError("solver"), 1, "solver"),
        (KeyboardInterrupt(), 130, "interrupted"),
        (MemoryError("much"), 1, "MemoryError: much"),
        (OSError(28, "No space left on device"), 1, "No space left"),
        (ZeroDivisionError("oops"), 1, "ZeroDivisionError: oops"),
    ],
)
def test_status_of_errors(run, small, tmp_path, monkeypatch, error, status, text):
    def fail(*args, **kwargs):
        raise error

    monkeypatch.setattr("pitchopt.design.tradeoff", fail)
    done = run("tradeoff", *small)
    assert done.status == status
    assert text in done.err
    assert len(done.err.strip().splitlines()) == 1  # click ends the line of a ^C first
    assert done.out == ""
    assert names(tmp_path) == []


def test_a_traceback_can_be_asked_for(small, tmp_path, monkeypatch):
    def fail(*args, **kwargs):
        raise ZeroDivisionError

    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("PITCHOPT_TRACEBACK", "1")
    monkeypatch.setattr("pitchopt.design.tradeoff", fail)
    with pytest.raises(ZeroDivisionError):
        main(["tradeoff", *small])


def test_a_design_without_answer_is_written_and_told(run, small, tmp_path, monkeypatch):
    import pitchopt.design
    from pitchopt.design import Status

    real = pitchopt.design.compared

    def unfinished(*args, **kwargs):
        found = real(*args, **kwargs)
        object.__setattr__(found.design, "status", Status.SOLVER_FAILED)
        return found

    monkeypatch.setattr(pitchopt.design, "compared", unfinished)
    done = run("design", *small, "--mu", "1", "--no-plots", "--out", "d")
    assert done.status == 1
    assert "design: solver failed" in done.err
    assert json.loads((tmp_path / "d" / "design.json").read_text())["design"]["status"] == (
        "solver failed"
    )
    again = run("export", *small, "--mu", "1", "--format", "csv")
    assert again.status == 1
    assert not (tmp_path / "profile.csv").exists()


def test_a_closed_pipe_is_no_error_message(finished):
    command = f"{sys.executable} -m pitchopt turbines --json | true"
    done = subprocess.run(["bash", "-c", command], capture_output=True, text=True, check=True)
    assert done.stderr == ""


# ---- progress ------------------------------------------------------------------------------


def test_progress_goes_to_standard_error(run, small, monkeypatch):
    monkeypatch.setattr(pitchopt.cli.progress, "DELAY", 0.0)
    monkeypatch.setattr(pitchopt.cli.progress, "INTERVAL", 0.0)
    done = run("tradeoff", *small, "--mu", "1,2", "--json")
    json.loads(done.out)
    assert "power maximum" in done.err
    assert re.search(r"\|[█▏▎▍▌▋▊▉# ]+\| \d/8", done.err)


def test_short_work_shows_no_bar(run, small):
    assert run("tradeoff", *small, "--mu", "1", "--json").err == ""


# ---- values --------------------------------------------------------------------------------


@pytest.mark.parametrize("text", ["2%", "2 %", " 2% ", "0.02", "2e-2"])
def test_shares(text):
    assert as_share("x", text) == pytest.approx(0.02)


@pytest.mark.parametrize("text", ["", "%", "2", "0", "0%", "-1%", "100%", "1", "nan", "inf%"])
def test_bad_shares(text):
    with pytest.raises(InputError, match=r"^x: got .*2% or 0\.02"):
        as_share("x", text)


def test_curves_saved_as_csv_serve_as_well(run, tmp_path):
    azimuth = 2 * np.pi * np.arange(9) / 9
    beta = np.tile(np.deg2rad([-4.0, 0.0, 2.0, 6.0]), (9, 1))
    load = 1e6 * (1 + 0.1 * np.cos(azimuth)[:, None]) * (1 - beta**2)
    curves = BladeCurves(
        blades=3, azimuth=azimuth, beta=beta, torque=load, bending=load, thrust=load
    )
    curves.save(tmp_path / "c.csv")
    done = run(
        "design", "--curves", "c.csv", "--rotor-speed-rpm", "12", "--mu", "1", "--no-plots",
        "--starts", "1", "--json",
    )  # fmt: skip
    assert done.status == 0, done.err


# ---- proofs --------------------------------------------------------------------------------


def test_deep_certificate_and_its_check(run, small, tmp_path):
    deep = ("--certify", "deep", "--certify-gap", "2%", "--certify-seconds", "60", "--workers", "1")
    done = run("design", *small, "--mu", "20", *deep, "--out", "d")
    assert done.status == 0, done.err
    design = json.loads((tmp_path / "d" / "design.json").read_text())["design"]
    assert design["bound_method"] in ("branch and bound", "hull relaxation")
    assert -1e-9 <= design["gap"] <= 0.02
    checked = run("check", "d/certificates.npz", "--json")
    assert checked.status == 0, checked.err
    (row,) = json.loads(checked.out)["certificates"]
    assert row["label"] == "mu=20" and row["holds"] is True
    assert row["upper_bound"] == design["upper_bound"]
    assert row["upper_bound_checked"] == pytest.approx(design["upper_bound"], rel=1e-9)
    table = run("check", "d/certificates.npz")
    assert table.status == 0 and "computed again" in table.out and "yes" in table.out


def test_proof_goes_on(run, small, tmp_path):
    deep = ("--certify", "deep", "--certify-gap", "0.01%", "--workers", "1", "--no-plots")
    first = run("design", *small, "--mu", "30", *deep, "--certify-seconds", "0.2", "--out", "a")
    assert first.status == 0, first.err
    one = json.loads((tmp_path / "a" / "design.json").read_text())["design"]
    again = run(
        "design", *small, "--mu", "30", *deep, "--certify-seconds", "2", "--out", "b",
        "--resume", "a/certificates.npz",
    )  # fmt: skip
    assert again.status == 0, again.err
    two = json.loads((tmp_path / "b" / "design.json").read_text())["design"]
    assert two["proof_regions"] > one["proof_regions"]
    assert two["upper_bound"] <= one["upper_bound"]


@pytest.mark.slow
def test_tradeoff_with_deep_certificates(run, small, tmp_path):
    done = run(
        "tradeoff", *small, "--mu", "20", "--certify", "deep", "--certify-gap", "2%",
        "--certify-seconds", "5", "--workers", "2", "--json", "--out", "t",
    )  # fmt: skip
    assert done.status == 0, done.err
    points = json.loads(done.out)["points"]
    assert all(point["gap"] >= -1e-9 for point in points)
    assert run("check", "t/certificates.npz").status == 0
    assert "certificates.npz" in names(tmp_path / "t")


@pytest.mark.parametrize(
    ("wrong", "said"),
    [
        (("--certify", "full"), "--certify"),
        (("--certify", "deep", "--no-certify"), "--no-certify"),
        (("--resume", "x.npz"), "--resume"),
        (("--certify", "deep", "--resume", "x.npz"), "x.npz"),
        (("--certify-gap", "0"), "--certify-gap"),
        (("--certify-seconds", "-1"), "--certify-seconds"),
        (("--workers", "0"), "--workers"),
    ],
)
def test_bad_proof_options(run, small, wrong, said):
    done = run("design", *small, "--mu", "5", *wrong)
    assert done.status == 2
    assert said in done.err and done.err.count("\n") == 1
    assert done.out == ""


def test_check_refuses_what_is_no_certificate(run, small, tmp_path):
    (tmp_path / "x.npz").write_bytes(b"nothing")
    for wrong in (("x.npz",), ("none.npz",)):
        done = run("check", *wrong)
        assert done.status == 2 and "certificates" in done.err and done.err.count("\n") == 1


def test_check_says_when_a_bound_does_not_come_out(run, small, tmp_path):
    assert run("design", *small, "--mu", "20", "--no-plots", "--out", "d").status == 0
    path = tmp_path / "d" / "certificates.npz"
    with np.load(path) as stored:
        data = {name: stored[name] for name in stored.files}
    data["0/upper_bound"] = data["0/upper_bound"] * 0.9
    np.savez(path, **data)
    done = run("check", "d/certificates.npz")
    assert done.status == 1 and "NO" in done.out and "mu=20" in done.err
