"""Time series: OpenFAST's binary output bit by bit, CSV, NPZ, and what is refused."""

from __future__ import annotations

import struct

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from pitchopt.errors import InputError
from pitchopt.exports import (
    TimeSeries,
    outb_bytes,
    read_outb,
    read_series_csv,
    read_series_npz,
    series_csv,
    series_npz,
)

NAMES = ("GenPwr", "LSShftTwst", "TwHt10MLxt")  # 10 characters are the most that fit
UNITS = ("kW", "deg", "kN-m")


@pytest.fixture
def series() -> TimeSeries:
    time = 10.0 + 0.05 * np.arange(400)
    values = np.column_stack(
        [5000.0 + 200.0 * np.sin(time), np.full(400, 0.25), -4e4 + 3.0 * np.cos(7.0 * time)]
    )
    return TimeSeries(time=time, channels=NAMES, units=UNITS, values=values)


def half_level(values):
    """Half a level of each channel; the levels of a narrow channel are those of its size."""
    size = np.abs(values).max(axis=0)
    spread = np.maximum(np.ptp(values, axis=0), 0.005 * size)
    return 0.5 * spread / 65533 + 1e-12 * size


def test_binary_comes_back_within_half_a_level(series, tmp_path):
    path = tmp_path / "a.outb"
    path.write_bytes(outb_bytes(series, description="a run"))
    found = read_outb(path)
    assert (found.channels, found.units) == (NAMES, UNITS)
    np.testing.assert_allclose(found.time, series.time, rtol=1e-14)
    assert np.all(np.abs(found.values - series.values) <= 1.001 * half_level(series.values))


def test_binary_layout(series):
    """Decoded by hand, as the reader of OpenFAST's toolbox does."""
    data = outb_bytes(series, description="a run")
    kind, count, rows, first, interval = struct.unpack_from("<h2i2d", data)
    assert (kind, count, rows, first) == (2, 3, 400, 10.0)
    assert interval == pytest.approx(0.05, rel=1e-12)
    at = struct.calcsize("<h2i2d")
    slope = np.frombuffer(data, "<f4", 3, at)
    offset = np.frombuffer(data, "<f4", 3, at + 12)
    (said,) = struct.unpack_from("<i", data, at + 24)
    at += 28
    assert data[at : at + said] == b"a run"
    at += said
    assert data[at : at + 40] == b"Time      GenPwr    LSShftTwstTwHt10MLxt"
    assert data[at + 40 : at + 80] == b"(s)       (kW)      (deg)     (kN-m)    "
    counts = np.frombuffer(data, "<i2", 1200, at + 80).reshape(400, 3)
    assert len(data) == at + 80 + 2400
    assert counts[:, 0].min() == -32767 and counts[:, 0].max() == 32766
    values = (counts.astype(float) - offset) / slope
    assert np.all(np.abs(values - series.values) <= 1.001 * half_level(series.values))


def test_long_names_make_another_identifier(series, tmp_path):
    long = TimeSeries(
        time=series.time,
        channels=("AB1N001Alpha", *NAMES[1:]),
        units=("kN-m/(rad/s)", *UNITS[1:]),
        values=series.values,
    )
    data = outb_bytes(long)
    assert struct.unpack_from("<hh", data) == (4, 14)
    path = tmp_path / "long.outb"
    path.write_bytes(data)
    found = read_outb(path)
    assert found.channels == long.channels
    assert np.all(np.abs(found.values - long.values) <= 1.001 * half_level(long.values))


def test_reads_the_identifier_without_packing(tmp_path):
    values = np.array([[1.5, -2.25], [3.0, 1e9]])
    text = "".join(t.ljust(10) for t in ("Time", "Wind1VelX", "GenPwr", "(s)", "(m/s)", "(kW)"))
    data = struct.pack("<h2i2d", 3, 2, 2, 0.0, 0.5) + struct.pack("<i", 0)
    (tmp_path / "a.outb").write_bytes(data + text.encode() + values.astype("<f8").tobytes())
    found = read_outb(tmp_path / "a.outb")
    assert (found.channels, found.units) == (("Wind1VelX", "GenPwr"), ("m/s", "kW"))
    assert np.array_equal(found.values, values)
    assert found.time.tolist() == [0.0, 0.5]


@given(arrays(np.float64, (7, 2), elements=st.floats(-1e7, 1e7, allow_subnormal=False, width=32)))
def test_any_values_come_back(tmp_path_factory, values):
    small = np.abs(values) < 1e-20  # below what slopes in single precision can tell
    values = np.where(small, 0.0, values)
    one = TimeSeries(time=np.arange(7.0), channels=("a", "b"), units=("-", "m"), values=values)
    path = tmp_path_factory.mktemp("any") / "a.outb"
    path.write_bytes(outb_bytes(one))
    found = read_outb(path)
    assert np.all(np.abs(found.values - values) <= 1.001 * half_level(values) + 1e-300)
    assert found.units == ("-", "m")


def test_uneven_time_is_refused(series):
    uneven = TimeSeries(
        time=series.time + 0.01 * (series.time > 15.0),
        channels=NAMES,
        units=UNITS,
        values=series.values,
    )
    with pytest.raises(InputError, match="evenly spaced"):
        outb_bytes(uneven)


@pytest.mark.parametrize(
    ("damage", "match"),
    [
        (lambda data: data[:-1], "bytes, expected"),
        (lambda data: data + b"\0", "bytes, expected"),
        (lambda data: b"\1\0" + data[2:], "identifier 1"),
        (lambda data: data[:9], "no whole .outb file"),
        (lambda data: data[:0], "no whole .outb file"),
        (lambda data: data[:2] + b"\0\0\0\0" + data[6:], "0 channels"),
        (lambda data: data[:26] + b"\0\0\0\0" + data[30:], "slopes"),
    ],
)
def test_damaged_binary(series, tmp_path, damage, match):
    path = tmp_path / "bad.outb"
    path.write_bytes(damage(outb_bytes(series)))
    with pytest.raises(InputError, match=match):
        read_outb(path)
    with pytest.raises(InputError, match="cannot read"):
        read_outb(tmp_path / "absent.outb")


def test_csv_and_npz(series, tmp_path):
    text = series_csv(series)
    lines = text.splitlines()
    assert lines[0] == "Time,GenPwr,LSShftTwst,TwHt10MLxt"
    assert lines[1] == "(s),(kW),(deg),(kN-m)"
    assert len(lines) == 402
    (tmp_path / "a.csv").write_text(text)
    (tmp_path / "a.npz").write_bytes(series_npz(series))
    for found in (read_series_csv(tmp_path / "a.csv"), read_series_npz(tmp_path / "a.npz")):
        assert (found.channels, found.units) == (NAMES, UNITS)
        np.testing.assert_allclose(found.values, series.values, rtol=1e-8)
        np.testing.assert_allclose(found.time, series.time, rtol=1e-8)
    assert np.array_equal(read_series_npz(tmp_path / "a.npz").values, series.values)


@pytest.mark.parametrize(
    "text",
    [
        "a,b\n1,2\n3,4\n",
        "Time,a\n(s),(m)\n",
        "Time,a\n(s),(m)\n1,x\n",
        "Time,a\n(s),(m)\n1,2,3\n",
        "Time,a\n(s),(m)\n2,1\n1,1\n",
    ],
)
def test_bad_csv(tmp_path, text):
    (tmp_path / "bad.csv").write_text(text)
    with pytest.raises(InputError, match="series file"):
        read_series_csv(tmp_path / "bad.csv")


def test_bad_npz(tmp_path):
    (tmp_path / "bad.npz").write_bytes(b"no archive")
    with pytest.raises(InputError, match="no series of pitchopt"):
        read_series_npz(tmp_path / "bad.npz")


@pytest.mark.parametrize(
    ("changes", "match"),
    [
        ({"values": np.zeros((3, 1))}, "expected \\(3, 2\\)"),
        ({"units": ("m",)}, "1 units"),
        ({"channels": ("a", "a")}, "different names"),
        ({"values": np.full((3, 2), np.nan)}, "NaN"),
        ({"time": np.zeros(3)}, "ascend"),
        ({"time": np.zeros(0)}, "non-empty"),
    ],
)
def test_bad_series(changes, match):
    good = {"time": np.arange(3.0), "channels": ("a", "b"), "units": ("m", "m"),
            "values": np.zeros((3, 2))}  # fmt: skip
    with pytest.raises(InputError, match=match):
        TimeSeries(**{**good, **changes})


def test_unknown_channel(series):
    assert series["GenPwr"][0] == series.values[0, 0]
    with pytest.raises(InputError, match="GenPwr"):
        series["Genpwr"]
