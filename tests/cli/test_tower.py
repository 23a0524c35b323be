"""``pitchopt tower``: document, files, tables, sets taken up again, right and wrong input."""

from __future__ import annotations

import contextlib
import csv
import io
import json
import math
import re
import shutil

import pytest

from pitchopt.cli import main
from pitchopt.cli.tower_command import _Shown
from pitchopt.studies.tower import TowerStudySettings

TINY = (
    "tower", "--quick", "--wind-speeds", "9,13", "--seeds", "1", "--duration", "60",
    "--configuration", "soft-soft", "--heights", "0.9,1,1.1", "--workers", "1",
)  # fmt: skip


@pytest.fixture(scope="module")
def boxes(tmp_path_factory):
    return tmp_path_factory.mktemp("boxes")


@pytest.fixture(autouse=True)
def own_cache(boxes, monkeypatch):
    """No box of the tests in the user's cache folder; no bar on a slow machine."""
    monkeypatch.setenv("XDG_CACHE_HOME", str(boxes))
    monkeypatch.setattr("pitchopt.cli.progress.DELAY", 1e6)


@pytest.fixture(scope="module")
def first(tmp_path_factory, boxes):
    """Folder of a study, and what it wrote on standard output and error."""
    folder = tmp_path_factory.mktemp("tower") / "here"
    out, err = io.StringIO(), io.StringIO()
    with (
        pytest.MonkeyPatch.context() as patch,
        contextlib.redirect_stdout(out),
        contextlib.redirect_stderr(err),
    ):
        patch.setenv("XDG_CACHE_HOME", str(boxes))
        patch.setattr("pitchopt.cli.progress.DELAY", 1e6)
        assert main([*TINY, "--out", str(folder), "--json"]) == 0
    return folder, out.getvalue(), err.getvalue()


@pytest.fixture(scope="module")
def document(first):
    return json.loads(first[1], parse_constant=lambda word: pytest.fail(word))


@pytest.fixture
def nothing_runs(monkeypatch):
    monkeypatch.setattr(
        "pitchopt.studies.tower.load_sets.simulate_many",
        lambda *_, **__: pytest.fail("simulated again"),
    )


def timeless(value):
    """A document without clocks and counts of what was simulated."""
    if isinstance(value, dict):
        if str(value.get("quantity", "")).startswith("time of"):
            return None
        skipped = ("seconds", "sets_simulated")
        return {key: timeless(item) for key, item in value.items() if key not in skipped}
    return [timeless(item) for item in value] if isinstance(value, list) else value


def test_json_is_alone_on_standard_output(first, document):
    folder, _, err = first
    assert err == ""
    assert json.loads((folder / "tower.json").read_text()) == document


def test_files(first, document):
    folder = first[0]
    assert sorted(path.name for path in folder.iterdir()) == [
        "cost.png", "damage.png", "designs.png", "mass.png", "sets", "tower.csv", "tower.json",
    ]  # fmt: skip
    sets = list((folder / "sets").iterdir())
    assert all(path.name.endswith(".set.npz") for path in sets)
    assert len(sets) == document["sets_simulated"] > 10
    for path in folder.glob("*.png"):
        assert path.read_bytes().startswith(b"\x89PNG")
    with (folder / "tower.csv").open() as stream:
        rows = list(csv.DictReader(stream))
    assert [float(row["ours"]) for row in rows] == [row["ours"] for row in document["tables"]]


def test_document(document):
    assert document["problem"] == "tower"
    assert document["settings"]["loads"]["wind_speeds"] == [9.0, 13.0]
    assert document["settings"]["loads"]["duration"] == 60.0
    assert document["settings"]["weights"] == [0.0, 0.03, 0.3]
    assert document["settings"]["step"] == 0.03
    assert document["settings"]["threshold"] == 0.01
    (part,) = document["configurations"].values()
    assert part["maps"]["true"] is None
    estimates = part["estimates"]
    change = estimates["mean_damage_change"]
    # the regulator damps the tower, and what a softer load saves
    assert 0.0 == change[0] > change[1] > change[2] > -0.6
    for key in ("first_order", "high_order", "true"):
        assert estimates[key][0] == 0.0
        assert all(value < 0.0 for value in estimates[key][1:])
    assert estimates["first_order"][1] == pytest.approx(estimates["high_order"][1])
    assert estimates["first_order"][2] == pytest.approx(10.0 * estimates["first_order"][1])
    assert abs(estimates["high_order"][2]) < abs(estimates["first_order"][2])
    assert 2e5 < part["reference"]["mass"] < 5e5
    assert part["codesign"]["cost"] <= part["without"]["cost"]
    assert document["seconds"] > 0.0
    assert all(math.isfinite(row["ours"]) for row in document["tables"])


def test_study_is_taken_up_and_shown(first, document, run, nothing_runs):
    folder = first[0]
    done = run(*TINY, "--out", folder)
    assert done.status == 0, done.err
    again = json.loads((folder / "tower.json").read_text())
    assert again["sets_simulated"] == 0
    assert timeless(again) == timeless(document)
    part = document["configurations"]["soft-soft"]
    reference, estimates = part["reference"], part["estimates"]
    assert f"soft-soft tower, hub 110 m, c = 0: {reference['mass'] / 1e3:.1f} t" in done.out
    row = re.search(r"^0\.3 +(.*)$", done.out, re.MULTILINE)[1].split()
    first_order, high, true = (
        100.0 * estimates[key][2] / reference["mass"] for key in ("first_order", "high_order", "true")
    )
    expected = [100.0 * estimates["mean_damage_change"][2], first_order, high, true,
                first_order - true, high - true]  # fmt: skip
    assert [float(cell) for cell in row] == pytest.approx(expected, abs=0.0051)
    assert re.search(r"^2 +soft-soft +tower mass, without +t +311\.330 +\d+\.\d+$", done.out, re.M)
    assert re.search(r"^1 +soft-soft +change of cost, high-order +% +-0\.45 +-\d", done.out, re.M)
    assert re.search(r"assumptions at c = 0\.3\n  A1 linearity: (holds|broken); ", done.out)
    assert re.search(r"^6 files in .*here/, [\d.]+ s$", done.out, re.MULTILINE)


def test_sets_of_another_folder_and_no_files(first, document, run, tmp_path, nothing_runs):
    done = run(*TINY, "--sets", first[0] / "sets", "--json")
    assert done.status == 0, done.err
    assert done.err == ""
    assert timeless(json.loads(done.out)) == timeless(document)
    assert list(tmp_path.iterdir()) == []


def test_damaged_set_alone_is_simulated(first, document, run, tmp_path):
    sets = tmp_path / "sets"
    shutil.copytree(first[0] / "sets", sets)
    one = sorted(sets.iterdir())[3]
    data = one.read_bytes()
    one.write_bytes(data[: len(data) // 2])
    done = run(*TINY, "--sets", sets, "--json")
    assert done.status == 0, done.err
    found = json.loads(done.out)
    assert found["sets_simulated"] == 1
    assert timeless(found) == timeless(document)
    assert one.stat().st_size == pytest.approx(len(data), rel=0.01)


@pytest.mark.parametrize("true_map", [True, False])
def test_progress_counts_every_phase(true_map):
    """Seven a configuration, or six without the true map, as the study's own tests have them."""
    labels = []
    shown = _Shown(lambda _, __, label: labels.append(label), TowerStudySettings(true_map=true_map))
    each = 7 if true_map else 6
    for name in ("standard", "soft-soft"):
        for _ in range(each):
            shown.phase(name, "any")
            shown.run(1, 2)
    assert labels[0] == f"1/{2 * each} standard"
    assert labels[-1] == f"{2 * each}/{2 * each} soft-soft"


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (("--turbine", "nowhere"), "turbine"),
        (("--turbine", "biegel2011"), "walls of its tower are not known"),
        (("--weights", "0.1,0.2,0.3"), "weights"),
        (("--weights", "0"), "weights"),
        (("--weights", "0,0.1"), "weights"),
        (("--weights", "0,0.2,0.1"), "weights"),
        (("--weights", "0,-0.1,0.2"), "--weights"),
        (("--weights", "0,a,1"), "--weights"),
        (("--heights", "0.9,1.1,1.2"), "height_factors"),
        (("--heights", "1"), "height_factors"),
        (("--heights", "0.9,1,-1.1"), "--heights"),
        (("--heights", "0.5,1,1.1"), "at least 60 m"),
        (("--threshold", "0"), "--threshold"),
        (("--threshold", "0.5"), "--threshold"),
        (("--threshold", "-1"), "--threshold"),
        (("--configuration", "soft"), "--configuration"),
        (("--wind-speeds", "9"), "at least 2 increasing speeds"),
        (("--wind-speeds", "9,7"), "increasing speeds"),
        (("--seeds", "0"), "--seeds"),
        (("--duration", "40"), "duration"),
        (("--turbulence", "none"), "turbulence"),
        (("--turbulence", "Q"), "turbulence"),
        (("--turbulence", "1.5"), "turbulence"),
        (("--mean-wind-speed", "0"), "--mean-wind-speed"),
        (("--lifetime", "-1"), "--lifetime"),
        (("--workers", "0"), "--workers"),
        (("--frequency-margin", "1"), "--frequency-margin"),
        (("--largest-diameter", "2"), "top_diameter"),
        (("--slenderness", "3"), "slenderness"),
        (("--sets", "/dev/null"), "cannot be made or is not a folder"),
        (("--out", "/dev/null"), "--out"),
    ],
)
def test_bad_input(run, tmp_path, nothing_runs, options, words):
    done = run("tower", "--quick", "--json", *options)
    assert done.status == 2, done.err
    assert done.out == ""
    assert re.fullmatch(r"pitchopt[^\n]*\n", done.err), done.err
    assert words in done.err
    assert list(tmp_path.iterdir()) == []


def test_tower_that_cannot_be_made(run, first):
    """No tower of this slenderness carries the loads: one line, no traceback."""
    done = run(*TINY, "--sets", first[0] / "sets", "--json", "--largest-diameter", "3.1")
    assert done.status not in (0, 2)
    assert done.out == ""
    assert re.fullmatch(r"pitchopt[^\n]*\n", done.err), done.err
    assert "no soft-soft tower at a hub height of 110 m with c = 0" in done.err


def test_help(run):
    done = run("tower", "--help")
    assert done.status == 0
    for text in ("--configuration", "--weights", "--heights", "--threshold", "--sets", "--quick"):
        assert text in done.out
