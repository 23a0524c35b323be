"""Damage-equivalent loads: closed forms, the definition, reference data."""

from __future__ import annotations

import csv
import gzip
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import rainflow as package
from hypothesis import given
from hypothesis import strategies as st
from scipy.interpolate import CubicSpline

from pitchopt import InputError
from pitchopt.fatigue import Cycles, damage_equivalent_load, equivalent_load, rainflow

NOISE = np.random.default_rng(11).standard_normal(3000).cumsum()


@pytest.mark.parametrize("slope", [1.0, 3.0, 4.0, 10.0, 12.5])
@pytest.mark.parametrize("frequency", [0.25, 1.0, 3.0])
def test_sine(slope: float, frequency: float) -> None:
    # 20 s from a valley to a valley; the peaks are on samples
    t = np.arange(0, 20 * 60 + 1) / 60
    signal = 5.0 - 3.5 * np.cos(2 * np.pi * frequency * t)
    wanted = 7.0 * frequency ** (1.0 / slope)
    for residue in ("half", "repeat"):
        got = damage_equivalent_load(signal, slope, duration=20.0, residue=residue)  # type: ignore[arg-type]
        assert got == pytest.approx(wanted, rel=1e-12)
    by_rate = damage_equivalent_load(signal, slope, sample_rate=60.0, frequency=2.0)
    assert by_rate == pytest.approx(wanted * 0.5 ** (1.0 / slope), rel=1e-12)


def test_two_sines_one_after_the_other() -> None:
    t = np.arange(0, 10 * 60 + 1) / 60
    big, small = 2.0 * np.cos(2 * np.pi * t), 0.5 * np.cos(2 * np.pi * t)
    # ten cycles of 4; down from 2 to -0.5 half a cycle; then 19 halves of 1 up to the last peak
    total = 10 * 4.0**4 + 0.5 * 2.5**4 + 9.5
    got = damage_equivalent_load(np.concatenate([big, small]), 4.0, duration=20.0)
    assert got == pytest.approx((total / 20.0) ** 0.25, rel=1e-12)


@pytest.mark.parametrize("slope", [3.0, 4.0, 10.0])
def test_definition_with_the_package(slope: float) -> None:
    total = sum(count * span**slope for span, count in package.count_cycles(NOISE))
    got = damage_equivalent_load(NOISE, slope, duration=600.0)
    assert got == pytest.approx((total / 600.0) ** (1.0 / slope), rel=1e-12)


@given(st.floats(0.01, 1e9), st.floats(-1e3, 1e3), st.floats(1.0, 14.0))
def test_scaling_and_shift(factor: float, shift: float, slope: float) -> None:
    base = damage_equivalent_load(NOISE, slope, duration=600.0)
    got = damage_equivalent_load(factor * (NOISE + shift), slope, duration=600.0)
    assert got == pytest.approx(factor * base, rel=1e-9)


@given(st.floats(1.0, 14.0), st.floats(0.1, 10.0), st.floats(1.0, 1e4))
def test_frequency_and_duration(slope: float, frequency: float, duration: float) -> None:
    base = damage_equivalent_load(NOISE, slope, duration=1.0)
    got = damage_equivalent_load(NOISE, slope, duration=duration, frequency=frequency)
    assert got == pytest.approx(base * (frequency * duration) ** (-1.0 / slope), rel=1e-9)


def test_large_loads_and_slopes_do_not_overflow() -> None:
    base = damage_equivalent_load(NOISE, 40.0, duration=600.0)
    got = damage_equivalent_load(1e30 * NOISE, 40.0, duration=600.0)
    assert got == pytest.approx(1e30 * base, rel=1e-12)


def test_constant_signals_have_none() -> None:
    assert damage_equivalent_load(np.full(100, 7.0), 4.0, duration=600.0) == 0.0


def test_counted_once_for_several_slopes() -> None:
    cycles = rainflow(NOISE)
    for slope in (4.0, 10.0):
        assert equivalent_load(cycles, slope, duration=600.0) == damage_equivalent_load(
            NOISE, slope, duration=600.0
        )


def test_repeating_residue_raises_the_load() -> None:
    half = damage_equivalent_load(NOISE, 4.0, duration=600.0)
    closed = damage_equivalent_load(NOISE, 4.0, duration=600.0, residue="repeat")
    assert half < closed <= half * 2.0**0.25 * (1 + 1e-12)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"slope": 0.0}, "slope: got 0"),
        ({"slope": -4.0}, "slope: got -4"),
        ({"slope": np.nan}, "slope: got nan"),
        ({"duration": 0.0}, "duration: got 0"),
        ({"duration": None}, "duration, sample_rate: got None and None"),
        ({"sample_rate": 20.0}, "duration, sample_rate: got 600.0 and 20.0"),
        ({"duration": None, "sample_rate": -1.0}, "sample_rate: got -1"),
        ({"frequency": 0.0}, "frequency: got 0"),
        ({"signal": [1.0]}, "signal: got 1 sample"),
        ({"signal": [1.0, np.nan]}, "signal: got 1 NaN"),
    ],
)
def test_bad_input(changes: dict[str, Any], message: str) -> None:
    settings: dict[str, Any] = {"signal": NOISE, "slope": 4.0, "duration": 600.0}
    with pytest.raises(InputError, match=message):
        damage_equivalent_load(**(settings | changes))


def test_cycles_made_by_hand() -> None:
    cycles = Cycles(ranges=np.array([2.0, 4.0]), means=np.zeros(2), counts=np.array([3.0, 0.5]))
    got = equivalent_load(cycles, 3.0, duration=10.0, frequency=0.5)
    assert got == pytest.approx(((3 * 8 + 0.5 * 64) / 5) ** (1 / 3))


# --- OpenFAST's time series ---

CHANNELS = {"TwrBsMyt": 4.0, "RootMyc1": 10.0, "RootMxc1": 10.0, "TwrBsMxt": 4.0}


@pytest.mark.parametrize("model", ["qs", "dbemt"])
@pytest.mark.parametrize("speed", [8, 12, 18])
def test_loads_of_the_reference(shared_reference: Path, model: str, speed: int) -> None:
    with (shared_reference / "b3_turbulent_del.csv").open() as stream:
        rows = [r for r in csv.DictReader(stream) if r["model"] == model]
    wanted = {}
    for r in rows:
        key = int(r["wind_speed"]), int(r["seed"]), r["channel"], float(r["wohler_m"])
        wanted[key] = float(r["DEL_1Hz"])
    ratios = []
    fine = np.linspace(60.0, 660.0, 600 * 20 + 1)
    for seed in (1, 2, 3):
        path = shared_reference / f"b3_ts_{model}_U{speed:02d}_s{seed}.csv.gz"
        with gzip.open(path, "rt") as text:
            names = text.readline().strip().split(",")
            data = dict(zip(names, np.loadtxt(text, delimiter=",").T, strict=True))
        for channel, slope in CHANNELS.items():
            # stored at 5 Hz, counted by the reference at 20 Hz
            signal = CubicSpline(data["Time"], data[channel])(fine)
            got = damage_equivalent_load(signal, slope, duration=600.0)
            ratios.append(got / wanted[speed, seed, channel, slope])
            if (model, speed, seed, channel) == ("qs", 12, 1, "TwrBsMyt"):
                # its README: sampling at 5 Hz lowers the loads of this run by 0.7 %
                coarse = data[channel][data["Time"] >= 60.0]
                lowered = damage_equivalent_load(coarse, slope, duration=600.0)
                assert lowered / wanted[speed, seed, channel, slope] == pytest.approx(
                    0.993, abs=1e-3
                )
    # what lies above 2.5 Hz is lost: least in fore-aft bending of the tower
    assert all(0.985 < ratio < 1.005 for ratio in ratios), ratios
    assert all(abs(ratio - 1.0) < 0.003 for ratio in ratios[::4]), ratios
