"""Fourier series of profiles."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from pitchopt.errors import InputError
from pitchopt.exports import blade_motion, harmonics, harmonics_csv, read_harmonics_csv
from pitchopt.exports.rosco_open_loop import open_loop


def turn(count: int, first: float = 0.0) -> np.ndarray:
    return first + 2 * np.pi * np.arange(count) / count


def test_known_series():
    psi = turn(24)
    beta = 0.2 + 0.05 * np.cos(psi - 0.7) + 0.01 * np.cos(3 * psi + 1.1)
    series = harmonics(psi, beta)
    assert series.mean == pytest.approx(0.2)
    assert series.amplitude[[1, 2, 3]] == pytest.approx([0.05, 0.0, 0.01], abs=1e-14)
    assert series.phase[[1, 3]] == pytest.approx([0.7, -1.1])


@given(
    st.lists(st.floats(-1.0, 1.0), min_size=1, max_size=40),
    st.floats(-3.0, 3.0),
)
def test_series_goes_through_all_stations(values, first):
    psi = turn(len(values), first)
    assert harmonics(psi, values)(psi) == pytest.approx(np.array(values), abs=1e-12)


@given(st.integers(5, 30), st.floats(-6.0, 6.0))
def test_shift_of_azimuth_shifts_phases_only(count, shift):
    psi = turn(count)
    beta = np.sin(psi) + 0.3 * np.cos(2 * psi + 0.4)
    plain, moved = harmonics(psi, beta), harmonics(psi + shift, beta)
    assert moved.amplitude[:3] == pytest.approx(plain.amplitude[:3], abs=1e-12)
    assert moved(psi + shift) == pytest.approx(plain(psi), abs=1e-11)


@pytest.mark.parametrize("derivative", [1, 2])
def test_derivatives_against_differences(derivative):
    psi = turn(15)
    series = harmonics(psi, np.random.default_rng(1).normal(size=15))
    at, h = np.linspace(0, 7, 23), 1e-5
    below = series(at - h, derivative - 1)
    above = series(at + h, derivative - 1)
    assert series(at, derivative) == pytest.approx((above - below) / (2 * h), abs=1e-7)


def test_table_round_trip(tmp_path):
    psi = turn(18, 0.3)
    beta = np.random.default_rng(2).normal(size=18)
    file = tmp_path / "harmonics.csv"
    file.write_text(harmonics_csv(harmonics(psi, beta)))
    assert file.read_text().startswith("harmonic,cos_deg,sin_deg,amplitude_deg,phase_deg\n0,")
    assert read_harmonics_csv(file)(psi) == pytest.approx(beta, abs=1e-13)


@pytest.mark.parametrize(
    "text",
    [
        "harmonic,cos_deg\n0,1\n",
        "harmonic,cos_deg,sin_deg\n1,1,0\n",
        "harmonic,cos_deg,sin_deg\n0,a,0\n",
    ],
)
def test_bad_tables(tmp_path, text):
    file = tmp_path / "harmonics.csv"
    file.write_text(text)
    with pytest.raises(InputError, match="harmonics file"):
        read_harmonics_csv(file)


def test_bad_profile():
    with pytest.raises(InputError, match=r"profile: got shape \(3,\), expected \(4,\)"):
        harmonics(turn(4), [1.0, 2.0, 3.0])


@pytest.mark.parametrize(
    "azimuth",
    [
        np.degrees(np.linspace(0.0, 2.0 * np.pi, 24, endpoint=False)),
        np.linspace(0.0, 2.0 * np.pi, 24),
        np.linspace(0.0, np.pi, 24, endpoint=False),
        np.linspace(0.0, 2.0 * np.pi, 24, endpoint=False)[::-1],
    ],
    ids=["degrees", "the end repeated", "half a turn", "backward"],
)
def test_stations_that_are_not_even_over_a_turn_are_refused(azimuth):
    profile = np.cos(np.arange(24))
    for use in (
        lambda: harmonics(azimuth, profile),
        lambda: blade_motion(azimuth, profile, rotor_speed=1.0, blades=3),
        lambda: open_loop(azimuth, profile, rotor_speed=1.0),
    ):
        with pytest.raises(InputError, match="azimuth"):
            use()
