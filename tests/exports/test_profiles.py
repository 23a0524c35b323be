"""Profiles in NPZ and CSV files, records of designs."""

from __future__ import annotations

import csv
import io
import json

import numpy as np
import pytest

from pitchopt.errors import InputError
from pitchopt.exports import (
    ProfileSet,
    document_text,
    profile_csv,
    read_profile_csv,
    tradeoff_csv,
    tradeoff_document,
    tradeoff_profiles,
)


@pytest.fixture(scope="session")
def profiles(small_case, small_tradeoff):
    return tradeoff_profiles(
        small_tradeoff, blades=3, rotor_speed=small_case.rotor_speed, settings=small_case.settings()
    )


def test_npz_round_trip(profiles, tmp_path):
    back = ProfileSet.load(profiles.save(tmp_path / "profiles.npz"))
    for name in ("azimuth", "profiles", "mu", "target", "rotor", "bending"):
        np.testing.assert_array_equal(getattr(back, name), getattr(profiles, name))
    assert back.labels == profiles.labels
    assert (back.blades, back.rotor_speed, back.knee) == (3, profiles.rotor_speed, profiles.knee)
    assert back.settings == json.loads(json.dumps(profiles.settings))


def test_rows_are_those_of_the_designs(profiles, small_tradeoff):
    assert profiles.labels[:2] == ("constant", "power_max")
    assert np.ptp(profiles.profiles[0]) == 0.0
    for row, point in enumerate(small_tradeoff.points, start=2):
        np.testing.assert_array_equal(profiles.profiles[row], point.profile)


def test_points_by_name(profiles, small_tradeoff):
    assert profiles.row("constant") == 0
    assert profiles.row("power_max") == 1
    assert profiles.row(0) == profiles.row("0") == 2
    assert profiles.row("knee") == small_tradeoff.knee + 2
    three = profiles.row("loss=3%")
    assert small_tradeoff.points[three - 2].target == 0.03
    assert profiles.row("loss=0.03") == profiles.row("loss = 3 %") == three
    assert profiles.labels[profiles.row("mu=10")] == "mu=10"


@pytest.mark.parametrize("name", ["99", "-1", "best", "loss=4%", "loss=x"])
def test_unknown_points(profiles, name):
    with pytest.raises(InputError, match=r"^point: got"):
        profiles.row(name)


@pytest.mark.parametrize("content", [b"", b"PK\x03\x04 truncated", b"\x93NUMPY", b"text"])
def test_files_that_are_no_profiles(tmp_path, content):
    file = tmp_path / "profiles.npz"
    file.write_bytes(content)
    with pytest.raises(InputError, match="profiles file"):
        ProfileSet.load(file)


def test_truncated_and_foreign_npz(profiles, tmp_path):
    file = tmp_path / "profiles.npz"
    file.write_bytes(profiles.to_bytes()[:-200])
    with pytest.raises(InputError, match="profiles file"):
        ProfileSet.load(file)
    np.savez(file, azimuth=np.zeros(3))
    with pytest.raises(InputError, match="profiles file"):
        ProfileSet.load(file)
    with pytest.raises(InputError, match="no such file"):
        ProfileSet.load(tmp_path / "none.npz")


def test_no_pickles_are_read(tmp_path):
    file = tmp_path / "profiles.npz"
    np.savez(file, azimuth=np.array([{"a": 1}], dtype=object))
    with pytest.raises(InputError, match="profiles file"):
        ProfileSet.load(file)


def test_csv_round_trip(tmp_path):
    psi = 2 * np.pi * np.arange(9) / 9
    beta = np.random.default_rng(4).normal(size=9)
    file = tmp_path / "profile.csv"
    file.write_text(profile_csv(psi, beta, rotor_speed=2.0))
    azimuth, pitch = read_profile_csv(file)
    np.testing.assert_allclose(azimuth, psi, rtol=1e-14)
    np.testing.assert_allclose(pitch, beta, rtol=1e-14)
    rate = [float(row["pitch_rate_deg_s"]) for row in csv.DictReader(io.StringIO(file.read_text()))]
    expected = 2.0 * (np.roll(beta, -1) - np.roll(beta, 1)) / (4 * np.pi / 9)
    np.testing.assert_allclose(np.deg2rad(rate), expected, rtol=1e-12)


@pytest.mark.parametrize(
    "text", ["azimuth_deg\n1\n", "azimuth_deg,pitch_deg\n", "azimuth_deg,pitch_deg\n0,nan\n"]
)
def test_bad_profile_tables(tmp_path, text):
    file = tmp_path / "profile.csv"
    file.write_text(text)
    with pytest.raises(InputError, match="profile file"):
        read_profile_csv(file)


def test_document_holds_what_the_design_contract_asks(small_case, small_tradeoff):
    text = document_text(
        tradeoff_document(small_case.name, small_case.settings(), small_tradeoff, 1.5)
    )
    assert "NaN" not in text
    assert "Infinity" not in text
    document = json.loads(text)
    assert {"case", "settings", "constant", "power_max", "points", "knee", "seconds"} <= set(
        document
    )
    constant = document["constant"]
    assert {"pitch_deg", "mean_torque", "rms", "rms_sum", "blade_rms"} <= set(constant)
    assert list(constant["rms"]) == ["torque", "tilt", "yaw", "thrust"]
    assert constant["rms_sum"] == pytest.approx(sum(constant["rms"].values()))
    point_keys = {
        "kind", "mu", "mean_torque", "rms", "rms_sum", "rms_sum_between", "blade_rms", "mean_tilt",
        "mean_yaw", "pitch_travel_deg", "objective", "upper_bound", "gap", "status", "start",
        "iterations", "seconds", "rms_weighted", "rms_weighted_between", "loss", "mean_pitch_deg",
        "cut",
    }  # fmt: skip
    for point in document["points"]:
        assert point_keys <= set(point)
        assert sum(point["rms_between"].values()) == pytest.approx(point["rms_sum_between"])
    losses = [p for p in document["points"] if p["kind"] == "max_power_loss"]
    assert sorted(p["loss_target"] for p in losses) == [0.03, 0.07]
    assert all(p["rms_lower_bound"] is not None for p in losses)
    assert document["power_max"]["loss"] == 0.0
    assert 0 <= document["knee"]["index"] < len(document["points"])


def test_numbers_that_are_not_finite_become_null():
    assert json.loads(document_text({"a": float("nan"), "b": [np.inf], "c": np.float64(1)})) == {
        "a": None,
        "b": [None],
        "c": 1.0,
    }


def test_csv_of_a_tradeoff(small_case, small_tradeoff):
    document = tradeoff_document(small_case.name, {}, small_tradeoff, 1.0)
    rows = [document["power_max"], *document["points"]]
    table = list(csv.DictReader(io.StringIO(tradeoff_csv(rows, small_tradeoff.knee + 1))))
    assert len(table) == len(rows)
    assert [row["knee"] for row in table].index("1") == small_tradeoff.knee + 1
    for row, record in zip(table, rows, strict=True):
        assert float(row["rms_tilt"]) == record["rms"]["tilt"]
        assert row["status"] == record["status"]
        assert "nan" not in row.values()
