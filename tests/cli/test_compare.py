"""``pitchopt compare``: document, tables, files, report, right and wrong input."""

from __future__ import annotations

import csv
import json
import tomllib

import pytest

from pitchopt.studies.comparison import LOADS

SHORT = (
    *("compare", "--turbulence", "none,C", "--methods", "learned,ipc-zoo", "--evaluations", 2),
    *("--seeds", 2, "--tuning-seeds", 1, "--duration", 20, "--skip", 10, "--rotations", 2),
    *("--averaged", 1, "--positions", 6, "--workers", 2),
)


@pytest.fixture(scope="module")
def boxes(tmp_path_factory):
    return tmp_path_factory.mktemp("boxes")


@pytest.fixture(autouse=True)
def own_cache(boxes, monkeypatch):
    """No box of the tests in the user's cache folder; no bar on a slow machine."""
    monkeypatch.setenv("XDG_CACHE_HOME", str(boxes))
    monkeypatch.setattr("pitchopt.cli.progress.DELAY", 1e6)


def test_tables_files_and_report(run, tmp_path):
    done = run(*SHORT, "--out", "out", "--report")
    assert done.status == 0, done.err
    assert done.err == ""
    for words in (
        "Steady wind, 15 m/s",
        "Turbulence of class C, intensity 13.5 %, 15 m/s, seeds that no method has met: 2",
        "What each took",
        "What each had to know",
        "Where the learned profile pays",
        "report: out/report.html",
    ):
        assert words in done.out
    out = tmp_path / "out"
    document = json.loads((out / "comparison.json").read_text())
    assert [w["wind"] for w in document["winds"]] == ["none", "C"]
    assert len(document["entries"]) == 6
    with (out / "comparison.csv").open(newline="") as stream:
        rows = list(csv.DictReader(stream))
    assert [(row["wind"], row["method"]) for row in rows] == [
        (wind, method) for wind in ("none", "C") for method in ("collective", "learned", "ipc-zoo")
    ]
    for row, record in zip(rows, document["entries"], strict=True):
        for load in LOADS:
            assert float(row[f"{load}_del_nm"]) == pytest.approx(record["del"][load], rel=1e-6)
    names = {path.name for path in (out / "controllers").iterdir()}
    assert names == {f"{m}-{w}.toml" for m in ("learned", "ipc-zoo") for w in ("none", "C")}
    assert (out / "report.html").read_text().startswith("<!DOCTYPE html>")
    for name in ("changes", "intensity", "turns"):
        assert (out / f"{name}.png").read_bytes()[:4] == b"\x89PNG"
    assert (out / "journals" / "ipc-zoo-C.sqlite").is_file()

    text = (out / "controllers" / "ipc-zoo-C.toml").read_text()
    gain = tomllib.loads(text)["individual"]["gain"]
    point = next(e["point"] for e in document["entries"] if e["wind"] == "C" and e.get("point"))
    assert gain == pytest.approx([point["gain_1p"], point["gain_2p"]])

    replayed = run(
        *("simulate", "--controller", out / "controllers" / "learned-C.toml", "--turbulence"),
        *("none", "--wind-speed", 15, "--duration", 10, "--skip", 10, "--pitch-lag", 0.4, "--json"),
    )
    assert replayed.status == 0, replayed.err


def test_json_alone_writes_nothing(run, tmp_path):
    done = run(*SHORT, "--json", "--turbulence", "none", "--methods", "learned")
    assert done.status == 0
    assert done.err == ""
    document = json.loads(done.out)
    assert [e["method"] for e in document["entries"]] == ["collective", "learned"]
    assert list(tmp_path.iterdir()) == []


def test_other_settings_are_not_mixed_with_an_earlier_study(run, tmp_path):
    one = ("--turbulence", "none", "--methods", "ipc-zoo", "--out", "out")
    assert run(*SHORT, *one).status == 0
    before = {path: path.read_bytes() for path in sorted((tmp_path / "out").glob("*.*"))}
    done = run(*SHORT, *one, "--pitch-rate-deg", 4)
    assert done.status == 2
    assert done.out == ""
    assert "is of another study" in done.err
    assert {path: path.read_bytes() for path in sorted((tmp_path / "out").glob("*.*"))} == before


def test_nothing_judged_ends_with_status_one(run):
    done = run(
        *SHORT, "--turbulence", "none", "--methods", "learned", "--travel-penalty", 1, "--json"
    )
    assert done.status == 1
    entry = json.loads(done.out)["entries"][1]
    assert (entry["status"], "travel" in entry["message"]) == ("failed", True)


def test_a_report_can_go_elsewhere(run, tmp_path):
    done = run(
        *SHORT, "--turbulence", "none", "--methods", "collective", "--json", "--report", "my.html"
    )
    assert done.status == 0, done.err
    assert [path.name for path in tmp_path.iterdir()] == ["my.html"]


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (("--methods", "ipc-bayse"), "did you mean 'ipc-bayes'"),
        (("--turbulence", "D"), "turbulence: got 'D'"),
        (("--case", "biegel2011"), "structure"),
        (("--case", "nrel-5wm"), "nrel-5mw"),
        (("--report", "report.pdf"), "--report: got 'report.pdf'"),
        (("--seeds", "0"), "--seeds"),
        (("--wind-speed", "60"), "60 m/s"),
        (("--curves", "no.csv"), "--curves"),
        (("--rotor-speed-rpm", "12"), "operation.rotor_speed_rpm: got 12"),
        (("--evaluations", "1"), "--evaluations"),
        (("--no-cache", "--cache", "x"), "--no-cache"),
        (("--pitch-rate-deg", "0"), "limits.pitch_rate_deg: got 0"),
    ],
)
def test_bad_input_is_one_line(run, tmp_path, arguments, words):
    done = run("compare", *arguments)
    assert done.status == 2
    assert done.out == ""
    assert len(done.err.strip().splitlines()) == 1
    assert words in done.err
    assert list(tmp_path.iterdir()) == []
