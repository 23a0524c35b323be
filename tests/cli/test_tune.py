"""``pitchopt tune``: document, files, tables, journals, right and wrong input."""

from __future__ import annotations

import csv
import json
import os
import re
import signal
import sqlite3
import subprocess
import sys
import time
import tomllib

import pytest

from pitchopt.tuning import Journal
from pitchopt.tuning.methods import METHODS

SHORT = ("--duration", "20", "--skip", "10", "--seeds", "1", "--workers", "1")
TORQUE = ("tune", "--problem", "torque-gain", "--wind-speed", "8", *SHORT)


@pytest.fixture
def document(run):
    """Run with --json; the document."""

    def call(*args: object) -> dict:
        done = run(*args, "--json")
        assert done.status == 0, done.err
        assert done.err == ""
        return json.loads(done.out)

    return call


def timeless(value):
    """A document without its clock."""
    if isinstance(value, dict):
        return {key: timeless(item) for key, item in value.items() if key != "seconds"}
    return [timeless(item) for item in value] if isinstance(value, list) else value


def refused(done, word, status=2):
    """One line on standard error, nothing on standard output."""
    assert done.status == status, done.err
    assert done.out == ""
    assert re.fullmatch(r"pitchopt[^\n]*\n", done.err), done.err
    assert "Traceback" not in done.err
    assert word in done.err


def test_schema_of_the_document(document, tmp_path):
    found = document(*TORQUE, "--evaluations", "6")
    assert list(tmp_path.iterdir()) == []
    assert list(found) == [
        "problem", "turbine", "method", "parameters", "settings", "start", "best", "gain",
        "evaluations", "simulations", "seconds", "agreement",
    ]  # fmt: skip
    assert found["parameters"] == ["k_fact"]
    assert found["start"]["x"] == [0.6]
    costs = [e["cost"] for e in found["evaluations"]]
    assert found["best"]["cost"] == min(costs)
    assert found["start"]["cost"] == costs[0]
    assert found["gain"] == pytest.approx(min(costs) / costs[0] - 1.0)  # minus a power
    assert [e["number"] for e in found["evaluations"]] == list(range(len(costs)))
    assert all(e["seconds"] > 0.001 for e in found["evaluations"])  # the start's run too
    assert found["simulations"] == len(costs)  # one wind speed, one seed
    assert sum(e["seconds"] for e in found["evaluations"]) < found["seconds"]
    assert set(found["agreement"]) == {"agrees", "x", "gap", "tolerance", "distance"}
    assert 0.3 <= found["agreement"]["x"][0] <= 1.7


@pytest.mark.parametrize("method", METHODS)
def test_every_method(document, method):
    if method == "cma-es":
        pytest.importorskip("cma")
    found = document(*TORQUE, "--method", method, "--evaluations", "5")
    assert found["method"] == method
    assert 1 <= len(found["evaluations"]) <= 5
    apart = not any(e["x"] == [0.6] for e in found["evaluations"])
    assert found["simulations"] == len(found["evaluations"]) + apart
    assert found["best"]["cost"] <= found["start"]["cost"]
    assert ("agreement" in found) is (method in ("zoo", "bayes"))


@pytest.mark.parametrize(
    ("problem", "size"), [("speed-regulator", 2), ("individual-pitch", 4), ("minimum-pitch", 3)]
)
def test_every_problem(document, problem, size):
    found = document(
        "tune", "--problem", problem, *SHORT, "--method", "sobol", "--evaluations", "3"
    )
    assert found["problem"] == problem
    assert len(found["parameters"]) == size
    assert all(len(e["x"]) == size for e in found["evaluations"])
    assert all(len(found[name]["x"]) == size for name in ("start", "best"))
    assert all({"x", "cost", "seconds"} <= set(e) for e in found["evaluations"])
    assert found["simulations"] >= len(found["evaluations"])


def test_tables_and_files(run, tmp_path):
    done = run(*TORQUE, "--evaluations", "4", "--check-seeds", "1", "--out", "here")
    assert done.status == 0, done.err
    for text in (
        "nrel-5mw: torque-gain by zoo, 8 m/s, turbulence A, 1 seed, 20 s after 10 s",
        "tower DEL", "rpm", "k_fact", " lower after 4 evaluations, 4 simulations",
        "in winds that the tuner did not see: ", "kriging has its minimum at k_fact", "in here/",
    ):  # fmt: skip
        assert text in done.out, text
    folder = tmp_path / "here"
    assert sorted(path.name for path in folder.iterdir()) == [
        "design-space.png", "evaluations.csv", "progress.png", "torque-gain-zoo.sqlite",
        "tuning.json",
    ]  # fmt: skip
    found = json.loads((folder / "tuning.json").read_text())
    with (folder / "evaluations.csv").open() as stream:
        rows = list(csv.DictReader(stream))
    assert [float(row["k_fact"]) for row in rows] == [e["x"][0] for e in found["evaluations"]]
    assert [float(row["cost"]) for row in rows] == [e["cost"] for e in found["evaluations"]]
    shown = float(re.search(r"^start +\S+ +(\S+)", done.out, re.MULTILINE)[1])
    assert shown == pytest.approx(1e-3 * found["start"]["cost"], rel=1e-3)  # kW
    for path in folder.glob("*.png"):
        assert path.read_bytes().startswith(b"\x89PNG")


def test_speed_of_the_regulator_beside_its_limits(run, tmp_path):
    args = ("tune", "--problem", "speed-regulator", *SHORT, "--evaluations", "2", "--no-plots")
    done = run(*args, "--out", "here")
    assert done.status == 0, done.err
    found = json.loads((tmp_path / "here" / "tuning.json").read_text())
    speed = (
        found["best"]["measures"]["generator_speed"] / found["settings"]["problem"]["soft_speed"]
    )
    line = re.search(
        r"([\d.]+) % (over|below) the soft limit of 1300 rpm \(hard limit 1400", done.out
    )
    assert float(line[1]) == pytest.approx(abs(100.0 * (speed - 1.0)), abs=0.05)
    assert line[2] == ("over" if speed > 1.0 else "below")


def test_family_of_minimum_pitch_tables_is_in_degrees(run, tmp_path):
    args = ("tune", "--problem", "minimum-pitch", *SHORT, "--method", "grid", "--evaluations", "3")
    args = (*args, "--kappa", "0.01,0.9", "--out", "here")
    done = run(*args)
    assert done.status == 0, done.err
    assert re.search(r"to begin with +0\.00 +9\.00 +19\.00 +0\.00 +0\.00 +0\.00", done.out)
    assert re.search(r"kappa 0\.01 ", done.out)
    assert re.search(r"paper, 13 MW, 0.01 +-10.90 +-8.50 +-0.03", done.out)
    found = json.loads((tmp_path / "here" / "tuning.json").read_text())
    assert [result["kappa"] for result in found["family"]] == [0.01, 0.9]
    change = found["family"][1]["change_from_initial"]
    row = re.search(r"^kappa 0\.9 +(.*)$", done.out, re.MULTILINE)[1].split()
    shown = [
        *found["family"][1]["pitch_deg"][1:-1],
        *(100 * change[n] for n in ("tower", "blade", "power")),
    ]
    assert [float(cell) for cell in row] == pytest.approx(shown, abs=0.005)
    again = run(*args)  # from the journals
    assert again.status == 0, again.err
    after = json.loads((tmp_path / "here" / "tuning.json").read_text())
    assert timeless(after) == timeless(found)


def test_several_problems_and_methods_make_one_table(run, tmp_path):
    done = run(
        "tune", "--problem", "torque-gain,speed-regulator", "--method", "zoo,grid", *SHORT,
        "--evaluations", "3", "--no-plots", "--out", "here",
    )  # fmt: skip
    assert done.status == 0, done.err
    found = json.loads((tmp_path / "here" / "tuning.json").read_text())
    assert len(found["studies"]) == 4
    assert found["simulations"] == sum(study["simulations"] for study in found["studies"])
    rows = found["comparison"]
    assert [row["problem"] for row in rows] == ["torque-gain"] * 2 + ["speed-regulator"] * 2
    assert rows[0]["gain"] >= rows[1]["gain"]
    assert rows[2]["gain"] >= rows[3]["gain"]
    for problem in ("torque-gain", "speed-regulator"):
        for method in ("zoo", "grid"):
            assert re.search(rf"^{problem} +{method} +\d", done.out, re.MULTILINE)
            for name in (f"{problem}-{method}.sqlite", f"{problem}-{method}-evaluations.csv"):
                assert (tmp_path / "here" / name).is_file()


def test_workers_and_repeats_change_nothing(document):
    args = (*TORQUE, "--method", "bayes", "--evaluations", "6", "--parallel", "2", "--seeds", "2")
    first = timeless(document(*args))
    assert timeless(document(*args, "--workers", "2")) == first
    assert timeless(document(*args, "--seed", "5")) != first


def test_finished_study_comes_from_its_journal(document, tmp_path, monkeypatch):
    args = (*TORQUE, "--method", "bayes", "--evaluations", "5", "--journal", "study.sqlite")
    first = document(*args)
    told = Journal(tmp_path / "study.sqlite").evaluations()
    assert [e.cost for e in told] == [e["cost"] for e in first["evaluations"]]
    with monkeypatch.context() as patch:
        patch.setattr(Journal, "ask", lambda *_: pytest.fail("asked again"))
        again = document(*args)
    assert timeless(again) == timeless(first)
    assert again["evaluations"] == first["evaluations"]  # with the seconds that they took
    more = document(*args[:-3], "8", *args[-2:])
    assert more["evaluations"][:5] == first["evaluations"]
    assert len(more["evaluations"]) == 8


@pytest.mark.slow
@pytest.mark.parametrize("how", [signal.SIGKILL, signal.SIGINT])
def test_stopped_study_goes_on_to_the_same_table(document, tmp_path, boxes, project_root, how):
    args = (*TORQUE, "--method", "bayes", "--evaluations", "10")
    whole = document(*args)
    command = [sys.executable, "-m", "pitchopt", *args, "--journal", "study.sqlite", "--json"]
    path = tmp_path / "study.sqlite"
    environment = {**os.environ, "PYTHONPATH": str(project_root), "XDG_CACHE_HOME": str(boxes)}
    process = subprocess.Popen(
        command, cwd=tmp_path, env=environment, stdout=subprocess.PIPE, stderr=subprocess.PIPE
    )
    limit = time.monotonic() + 60.0
    while time.monotonic() < limit and process.poll() is None:
        if path.exists() and _results(path) >= 2:
            process.send_signal(how)
            break
        time.sleep(0.005)
    out, err = process.communicate(timeout=60.0)
    if process.returncode != 0:  # else it was done before the signal came
        assert out == b""
        assert process.returncode == (-signal.SIGKILL if how == signal.SIGKILL else 130)
        assert b"Traceback" not in err
    assert timeless(document(*args, "--journal", path)) == timeless(whole)


def _results(path):
    """Results that a journal holds so far."""
    database = sqlite3.connect(path)
    try:
        return database.execute("select count(*) from results").fetchone()[0]
    except sqlite3.OperationalError:
        return 0
    finally:
        database.close()


def test_wrong_journals_are_left_as_they_are(run, tmp_path):
    args = (*TORQUE, "--evaluations", "2", "--json")
    good = tmp_path / "good.sqlite"
    assert run(*args, "--journal", good).status == 0
    content = good.read_bytes()
    other = tmp_path / "other.sqlite"
    other.write_bytes(content)
    with sqlite3.connect(other) as database:
        database.execute("pragma user_version=7")
    database.close()
    broken, foreign, closed = (tmp_path / f"{name}.sqlite" for name in ("b", "f", "c"))
    broken.write_bytes(content[:3000])
    foreign.write_bytes(b"no journal " * 500)
    closed.write_bytes(content)
    closed.chmod(0o444)
    before = {path: path.read_bytes() for path in tmp_path.iterdir()}
    refused(run(*args, "--journal", good, "--seed", "1"), "tuner.seed is 0, here 1")
    refused(run(*args, "--journal", good, "--turbulence", "C"), "another study")
    refused(run(*args, "--journal", good, "--parallel", "2"), "parallel is 1, here 2")
    refused(run(*args, "--journal", other), "format 7")
    refused(run(*args, "--journal", broken), "damaged")
    refused(run(*args, "--journal", foreign), "no journal")
    refused(run(*args, "--journal", closed), "read-only")
    refused(run(*args, "--journal", "absent/study.sqlite"), "no folder absent")
    refused(run(*args, "--journal", "absent/"), "expected a folder that is there")
    refused(run(*args, "--method", "zoo,random", "--journal", good), "for several studies")
    assert {path: path.read_bytes() for path in before} == before


def test_journal_in_a_folder(run, tmp_path):
    (tmp_path / "kept").mkdir()
    assert run(*TORQUE, "--evaluations", "2", "--json", "--journal", "kept").status == 0
    assert [path.name for path in (tmp_path / "kept").iterdir()] == ["torque-gain-zoo.sqlite"]


@pytest.mark.parametrize(
    ("args", "word"),
    [
        (("--problem", "torque-gian"), "did you mean torque-gain?"),
        (("--problem", ","), "--problem"),
        (("--method", "zoo,bayess"), "did you mean bayes?"),
        (("--turbine", "nrel5mw"), "did you mean 'nrel-5mw'?"),
        (("--turbine", "absent.yaml"), "no such file"),
        (("--option", "stage=3"), "stage"),
        (("--option", "stages=0"), "stages: got 0"),
        (("--option", "stages=many"), "stages: got 'many'"),
        (("--option", "stages"), "NAME=VALUE"),
        (("--option", "stages=2", "--option", "stages=3"), "got stages twice"),
        (("--method", "zoo,grid", "--option", "stages=2"), "option of grid"),
        (("--bounds", "k_fact=1:1"), "bounds of k_fact"),
        (("--bounds", "k_fact=1.2:0.5"), "bounds of k_fact"),
        (("--bounds", "k_fact=0.7:1.2"), "start: got k_fact = 0.6"),
        (("--bounds", "k=0.7:1.2"), "expected one of k_fact"),
        (("--bounds", "k_fact=nan:1.2"), "NAME=LOW:HIGH"),
        (("--bounds", "k_fact=0.5:1", "--bounds", "k_fact=0.5:2"), "twice"),
        (("--start", "0.6,0.7"), "start: got shape (2,)"),
        (("--start", "5"), "start: got k_fact = 5"),
        (("--start", "nan"), "--start"),
        (("--parallel", "0"), "--parallel"),
        (("--workers", "0"), "--workers"),
        (("--evaluations", "0"), "--evaluations"),
        (("--check-seeds", "0"), "--check-seeds"),
        (("--timeout", "0"), "--timeout"),
        (("--seeds", "0"), "--seeds"),
        (("--wind-speed", "100"), "cut-out at 25 m/s"),
        (("--wind-speed", "0"), "wind_speeds"),
        (("--wind-speed", "nan"), "--wind-speed"),
        (("--turbulence", "D"), "turbulence: got 'D'"),
        (("--duration", "nan"), "--duration"),
        (("--load", "tower"), "speed-regulator alone"),
        (("--kappa", "0.1"), "minimum-pitch alone"),
        (("--out", "file"), "file is a file"),
    ],
)
def test_bad_input(run, tmp_path, args, word):
    (tmp_path / "file").write_text("kept")
    base = ("tune", *SHORT, *(() if "--problem" in args else ("--problem", "torque-gain")))
    refused(run(*base, *args), word)
    assert [path.name for path in tmp_path.iterdir()] == ["file"]
    assert (tmp_path / "file").read_text() == "kept"


@pytest.mark.parametrize(
    ("args", "word"),
    [
        (("minimum-pitch", "--kappa", "2"), "kappa: got 2.0"),
        (("minimum-pitch", "--kappa", "0.1,0.1"), "each once"),
        (("minimum-pitch", "--start", "0.1"), "start: got (0.1,) for minimum-pitch"),
        (("minimum-pitch", "--option", "stages=0"), "stages: got 0"),
        (("speed-regulator", "--start", "0.6"), "start: got shape (1,)"),
        (("individual-pitch", "--start", "1,0,0,0"), "start: got gain_1p = 1"),
        (("individual-pitch", "--bounds", "offset_1p=-1:1"), "comes back by turns"),
        (("torque-gain,minimum-pitch", "--start", "0.6"), "for minimum-pitch"),
    ],
)
def test_bad_input_of_a_problem(run, tmp_path, args, word):
    refused(run("tune", *SHORT, "--problem", *args), word)
    assert list(tmp_path.iterdir()) == []


def test_start_goes_with_the_bounds(document):
    found = document(*TORQUE, "--bounds", "k_fact=0.1:0.3", "--start", "0.2", "--evaluations", "3")
    assert found["start"]["x"] == [0.2]
    assert all(0.1 <= e["x"][0] <= 0.3 for e in found["evaluations"])


def test_every_evaluation_failing(run):
    args = ("tune", "--problem", "speed-regulator", *SHORT, "--duration", "60", "--json")
    args = (*args, "--bounds", "omega=0.7:1.0", "--start", "0.95,2.8", "--evaluations", "3")
    done = run(*args)
    refused(done, "cannot be judged", status=1)
    refused(run(*TORQUE, "--json", "--timeout", "1e-4", "--evaluations", "2"), "took longer", 1)


def test_a_tuned_individual_pitch_is_written_for_simulate_and_export(run, tmp_path):
    arguments = (
        *("tune", "--problem", "individual-pitch", "--method", "zoo", "--evaluations", 2),
        *("--wind-speed", 15, *SHORT, "--no-plots", "--out", "ipc"),
    )
    assert run(*arguments).status == 0
    best = json.loads((tmp_path / "ipc" / "tuning.json").read_text())["best"]["x"]
    text = tomllib.loads((tmp_path / "ipc" / "controller.toml").read_text())["individual"]
    assert text["gain"] == pytest.approx(best[0::2])
    assert text["offset_deg"] == pytest.approx([57.29577951308232 * x for x in best[1::2]])
    played = run(
        *("simulate", "--controller", "ipc/controller.toml", "--wind-speed", 15, "--pitch-lag"),
        *(0.4, "--turbulence", "none", "--duration", 10, "--skip", 5, "--json"),
    )
    assert played.status == 0, played.err
    done = run(
        *("export", "ipc/controller.toml", "--format", "discon", "--only-1p", "--out", "rosco")
    )
    assert done.status == 0, done.err
