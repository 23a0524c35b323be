"""The commands for several winds: tables, JSON, files, bad input."""

from __future__ import annotations

import json

import numpy as np
import pytest

from pitchopt.exports import read_schedule_csv

ROBUST = ("robust", "--winds", "14,16", "--mu", "10")
SCHEDULE = ("schedule", "--wind-speeds", "14,15,16", "--max-change-deg", "0.2", "--mu", "10")


def test_robust_prints_a_table_and_writes_its_files(run, small, tmp_path):
    done = run(*ROBUST, *small, "--out", "here")
    assert done.status == 0, done.err
    for text in ("14 m/s", "16 m/s", "regret", "weighted objective", "proven: at most"):
        assert text in done.out
    names = sorted(path.name for path in (tmp_path / "here").iterdir())
    assert names == ["profiles.png", "regrets.png", "robust.csv", "robust.json", "robust.npz"]
    document = json.loads((tmp_path / "here" / "robust.json").read_text())
    psi, profiles, labels = read_schedule_csv(tmp_path / "here" / "robust.csv")
    assert labels == ("all winds",)
    np.testing.assert_allclose(np.rad2deg(profiles), document["pitch_deg"], rtol=1e-12)
    with np.load(tmp_path / "here" / "robust.npz") as data:
        np.testing.assert_allclose(data["profiles"], profiles, rtol=1e-12)
        np.testing.assert_allclose(data["azimuth"], psi, atol=1e-12)
        assert data["rotor_loads"].shape == (2, 4, 6)


def test_regret_in_json_only(run, small, tmp_path):
    done = run(*ROBUST, *small, "--shears", "0,0.2", "--goal", "regret", "--json")
    assert done.status == 0, done.err
    document = json.loads(done.out)
    assert list(tmp_path.iterdir()) == []
    assert [wind["label"] for wind in document["winds"]] == [
        "14 m/s, shear 0", "14 m/s, shear 0.2", "16 m/s, shear 0", "16 m/s, shear 0.2",
    ]  # fmt: skip
    assert document["largest_regret"] == pytest.approx(-document["objective"], rel=1e-9)
    assert document["upper_bound"] >= document["objective"]
    assert sum(wind["weight"] for wind in document["winds"]) == pytest.approx(1.0)
    assert document["settings"]["winds"][1]["shear_exponent"] == 0.2


def test_schedule_writes_a_table_for_a_controller(run, small, tmp_path):
    done = run(*SCHEDULE, *small, "--out", "here", "--no-plots")
    assert done.status == 0, done.err
    assert "largest change between neighbours" in done.out
    names = sorted(path.name for path in (tmp_path / "here").iterdir())
    assert names == ["schedule.csv", "schedule.json", "schedule.npz"]
    _, profiles, labels = read_schedule_csv(tmp_path / "here" / "schedule.csv")
    assert labels == ("14 m/s", "15 m/s", "16 m/s")
    assert profiles.shape == (3, 18)
    assert np.abs(np.diff(profiles, axis=0)).max() <= np.deg2rad(0.2) + 1e-12
    document = json.loads((tmp_path / "here" / "schedule.json").read_text())
    assert document["max_change_deg"] == pytest.approx(0.2)


def test_winds_of_a_table(run, small, tmp_path):
    (tmp_path / "winds.csv").write_text(
        "label,weight,speed,shear_exponent,direction_deg\nlow,3,14,0.1,0\nhigh,1,16,0.3,10\n"
    )
    done = run("robust", "--winds", "winds.csv", "--mu", "10", *small, "--json", "--no-certify")
    assert done.status == 0, done.err
    document = json.loads(done.out)
    assert [wind["label"] for wind in document["winds"]] == ["low", "high"]
    assert [wind["weight"] for wind in document["winds"]] == pytest.approx([0.75, 0.25])
    assert document["settings"]["winds"][1]["direction_deg"] == pytest.approx(10.0)
    assert document["upper_bound"] is None


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (("robust", "--mu", "1"), "Missing option '--winds'"),
        (("robust", "--winds", "14"), "Missing option '--mu'"),
        (("robust", "--winds", "a,b", "--mu", "1"), "--winds: got 'a,b'"),
        (("robust", "--winds", "14,0", "--mu", "1"), "--winds: got '14,0', expected wind speeds"),
        (("robust", "--winds", "none.csv", "--mu", "1"), "none.csv"),
        (("robust", "--winds", "14,16", "--mu", "1,2,3"), "mu: got 3 numbers, expected one, or 2"),
        ((*ROBUST, "--wind-weights", "0,0"), "not all 0"),
        ((*ROBUST, "--wind-weights", "1"), "weights: got 1, expected 2"),
        ((*ROBUST, "--induction", "frozen", "--case", "nrel-5mw"), "frozen wake"),
        ((*ROBUST, "--goal", "regret", "--wind-weights", "1,1"), "weights: got some with the goal"),
        (("schedule", "--wind-speeds", "14", "--mu", "1", "--max-change-deg", "-1"), "-1"),
        (("schedule", "--wind-speeds", "14", "--mu", "1", "--max-change-deg", "1,2"), "got 2"),
        ((*SCHEDULE, "--harmonics", "2"), "harmonics: a schedule"),
    ],
)  # fmt: skip
def test_bad_input_is_one_line(run, tmp_path, arguments, words):
    done = run(*arguments, "--positions", "4")
    assert done.status == 2, done
    assert done.out == ""
    assert len(done.err.splitlines()) == 1, done.err
    assert words in done.err
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("speed,colour\n14,red\n", "colour: got 'red', expected columns out of label"),
        ("speed\nfast\n", "speed: got 'fast'"),
        ("speed\n", "has 0 winds"),
        ("speed,weight\n14,x\n", "weight: got 'x'"),
    ],
)
def test_bad_tables_of_winds(run, tmp_path, text, words):
    (tmp_path / "winds.csv").write_text(text)
    done = run("robust", "--winds", "winds.csv", "--mu", "1")
    assert done.status == 2, done
    assert len(done.err.splitlines()) == 1
    assert words in done.err
