"""Profiles of designs for several winds: round trip of their file, choice of a wind."""

from __future__ import annotations

import numpy as np
import pytest

from pitchopt.design import robust
from pitchopt.errors import InputError
from pitchopt.exports import SeveralProfiles, read_several_npz, several_npz


@pytest.fixture(scope="module")
def result(small_case):
    winds = [small_case.with_values({"wind.speed": speed}) for speed in (13.0, 15.0)]
    return robust(
        [wind.task() for wind in winds], mu=10.0, labels=("13 m/s", "15 m/s"), starts=1,
        certify=False,
    )  # fmt: skip


def held(**change):
    given = {
        "azimuth": [0.0, 2.0, 4.0], "profiles": np.arange(6.0).reshape(2, 3) / 10,
        "labels": ("a", "7"), "rotor_speeds": [1.0, 1.2], "blades": 3,
    }  # fmt: skip
    return SeveralProfiles(**{**given, **change})


def test_round_trip(result, tmp_path):
    file = tmp_path / "robust.npz"
    file.write_bytes(several_npz(result, rotor_speeds=[1.9, 2.0], blades=3, settings={"case": "x"}))
    back = read_several_npz(file)
    assert back.azimuth == pytest.approx(result.azimuth)
    assert back.profiles == pytest.approx(result.profiles)
    assert back.labels == ("13 m/s", "15 m/s")
    assert back.rotor_speeds.tolist() == [1.9, 2.0]
    assert (back.blades, back.settings) == (3, {"case": "x"})
    assert back.profile(1) == pytest.approx(result.profiles[0])
    with pytest.raises(
        InputError, match=r"^point: got nothing, expected the wind whose rotor speed"
    ):
        back.wind(None)


def test_a_wind_by_label_and_by_number():
    several = held()
    assert [several.wind(point) for point in ("a", "7", 0, "1")] == [0, 1, 0, 1]
    assert several.profile(1).tolist() == [0.3, 0.4, 0.5]
    with pytest.raises(InputError, match=r"^point: got nothing, expected the wind whose profile"):
        several.wind(None)
    for point in ("b", "2", "-1"):
        with pytest.raises(InputError, match=rf"^point: got '{point}', expected .* one of a, 7"):
            several.wind(point)
    assert held(profiles=[[0.1, 0.2, 0.3]], rotor_speeds=[1.0, 1.0]).wind(None) == 0


@pytest.mark.parametrize(
    ("change", "field"),
    [
        ({"profiles": np.zeros((3, 3))}, "profiles"),
        ({"profiles": np.zeros((2, 4))}, "profiles"),
        ({"profiles": np.zeros(3)}, "profiles"),
        ({"rotor_speeds": [1.0]}, "rotor_speeds"),
        ({"rotor_speeds": [1.0, 0.0]}, "rotor_speeds"),
        ({"blades": 0}, "blades"),
        ({"azimuth": [0.0, np.nan, 1.0]}, "azimuth"),
    ],
)
def test_bad_content(change, field):
    with pytest.raises(InputError, match=f"^{field}"):
        held(**change)


def test_other_files(tmp_path, result):
    file = tmp_path / "x.npz"
    with pytest.raises(InputError, match=r"is not an \.npz of pitchopt robust or schedule"):
        read_several_npz(file)
    file.write_bytes(b"PK")
    with pytest.raises(InputError, match=r"is not an \.npz"):
        read_several_npz(file)
    np.savez(file, azimuth=result.azimuth, profiles=result.profiles)
    with pytest.raises(InputError, match=r"holds no labels, .* run the command again"):
        read_several_npz(file)
