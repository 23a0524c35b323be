"""``pitchopt tower``: document, files, tables, sets taken up again, right and wrong input."""

from __future__ import annotations

import csv
import json
import math
import re

import pytest

from pitchopt.cli.tower_command import _settings, _Shown, command
from pitchopt.studies.tower import TowerStudySettings
from pitchopt.turbines import load_turbine

TINY = (
    "tower", "--quick", "--wind-speeds", "7,13", "--seeds", "1", "--duration", "60",
    "--configuration", "soft-soft", "--heights", "0.9,1,1.1", "--workers", "1",
)  # fmt: skip


def nothing_runs(*_, **__):
    pytest.fail("simulated again")


def timeless(value):
    """A document without clocks and counts of what was simulated."""
    if isinstance(value, dict):
        if str(value.get("quantity", "")).startswith("time of"):
            return None
        skipped = ("seconds", "sets_simulated")
        return {key: timeless(item) for key, item in value.items() if key not in skipped}
    return [timeless(item) for item in value] if isinstance(value, list) else value


def finite(text):
    """Document of a text; no number that JSON does not know."""
    return json.loads(text, parse_constant=pytest.fail)


def check_files(folder, document):
    assert sorted(path.name for path in folder.iterdir()) == [
        "cost.png", "damage.png", "designs.png", "mass.png", "sets", "tower.csv", "tower.json",
    ]  # fmt: skip
    assert finite((folder / "tower.json").read_text()) == document
    sets = list((folder / "sets").iterdir())
    assert all(path.name.endswith(".set.npz") for path in sets)
    assert len(sets) == document["sets_simulated"] > 10
    for path in folder.glob("*.png"):
        assert path.read_bytes().startswith(b"\x89PNG")
    with (folder / "tower.csv").open() as stream:
        rows = list(csv.DictReader(stream))
    assert [float(row["ours"]) for row in rows] == [row["ours"] for row in document["tables"]]


def check_document(document):
    assert document["problem"] == "tower"
    assert document["settings"]["loads"]["wind_speeds"] == [7.0, 13.0]
    assert document["settings"]["loads"]["duration"] == 60.0
    assert document["settings"]["weights"] == [0.0, 0.03, 0.3]
    assert document["settings"]["step"] == 0.03
    assert document["settings"]["threshold"] == 0.01
    (part,) = document["configurations"].values()
    assert part["maps"]["true"] is None
    estimates = part["estimates"]
    change = estimates["mean_damage_change"]
    # the regulator damps the tower, and softer loads save mass
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


def check_tables(text, document):
    part = document["configurations"]["soft-soft"]
    reference, estimates = part["reference"], part["estimates"]
    assert f"soft-soft tower, hub 110 m, c = 0: {reference['mass'] / 1e3:.1f} t" in text
    row = re.search(r"^0\.3 +(.*)$", text, re.MULTILINE)[1].split()
    kinds = ["first_order", "high_order"]
    if estimates["with_response"] is not None:
        kinds.append("with_response")
    *estimated, true = (100.0 * estimates[key][2] / reference["mass"] for key in (*kinds, "true"))
    expected = [100.0 * estimates["mean_damage_change"][2], *estimated, true,
                *(share - true for share in estimated)]  # fmt: skip
    assert [float(cell) for cell in row] == pytest.approx(expected, abs=0.0051)
    for line in (
        r"^2 +soft-soft +tower mass, without +t +311\.330 +\d+\.\d+$",
        r"^1 +soft-soft +change of cost, high-order +% +-0\.450 +-\d\.\d{3}$",
    ):
        assert re.search(line, text, re.MULTILINE)
    assert re.search(r"assumptions at c = 0\.3\n  A1 linearity: (holds|broken); ", text)
    assert "\nall towers and searches converged\n" in text or "\nnot converged\n" in text
    assert re.search(r"^6 files in here/, [\d.]+ s$", text, re.MULTILINE)


@pytest.mark.slow
def test_study_and_what_takes_it_up(run, tmp_path, monkeypatch):
    """One study, made once: files, document, tables, and its sets used again."""
    done = run(*TINY, "--out", "here", "--json")
    assert done.status == 0, done.err
    assert done.err == ""
    document = finite(done.out)
    check_files(tmp_path / "here", document)
    check_document(document)

    sets = tmp_path / "here" / "sets"
    path = sorted(sets.iterdir())[3]
    data = path.read_bytes()
    path.write_bytes(data[: len(data) // 2])
    done = run(*TINY, "--sets", sets, "--json")  # the damaged set alone is simulated
    assert done.status == 0, done.err
    found = finite(done.out)
    assert found["sets_simulated"] == 1
    assert timeless(found) == timeless(document)
    assert [p.name for p in tmp_path.iterdir()] == ["here"]

    monkeypatch.setattr("pitchopt.studies.tower.load_sets.simulate_many", nothing_runs)
    done = run(*TINY, "--out", "here")
    assert done.status == 0, done.err
    again = finite((tmp_path / "here" / "tower.json").read_text())
    assert again["sets_simulated"] == 0
    assert timeless(again) == timeless(document)
    check_tables(done.out, document)

    # no tower of this diameter carries the loads: one line, no traceback
    done = run(*TINY, "--sets", sets, "--json", "--largest-diameter", "3.1")
    assert done.status not in (0, 2)
    assert done.out == ""
    assert re.fullmatch(r"pitchopt[^\n]*\n", done.err), done.err
    assert "no soft-soft tower at a hub height of 110 m with c = 0" in done.err


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
def test_bad_input(run, tmp_path, monkeypatch, options, words):
    monkeypatch.setattr("pitchopt.studies.tower.load_sets.simulate_many", nothing_runs)
    done = run("tower", "--quick", "--json", *options)
    assert done.status == 2, done.err
    assert done.out == ""
    assert re.fullmatch(r"pitchopt[^\n]*\n", done.err), done.err
    assert words in done.err
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(
    ("turbine", "given", "largest", "top"),
    [
        ("iea-3.4-130", {}, 6.0, 3.0),
        ("iea-10-198", {}, 8.3, 5.5),
        ("nrel-5mw", {"top_diameter": 3.5, "largest_diameter": 5.0}, 5.0, 3.5),
    ],
)
def test_diameters_are_those_of_the_turbine_unless_given(turbine, given, largest, top):
    names = {p.name: None for p in command.params}
    options = {**names, "quick": True, "configuration": "both", "turbulence": "A",
               "mean_wind_speed": 7.5, "lifetime": 20.0, "frequency_margin": 0.15,
               "slenderness": 200.0, "follow_height": False, **given}  # fmt: skip
    limits = _settings(options, load_turbine(turbine)).limits
    assert (limits.largest_diameter, limits.top_diameter) == (largest, top)


def test_help(run):
    done = run("tower", "--help")
    assert done.status == 0
    for text in ("--configuration", "--weights", "--heights", "--threshold", "--sets", "--quick"):
        assert text in done.out
