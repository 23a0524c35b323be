"""Spectra of load ranges against rainflow counted one signal at a time."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from pitchopt.errors import InputError
from pitchopt.fatigue import SNCurve, miner_damage, rainflow, range_spectra


def one_by_one(signals, first, width, bins):
    out = np.zeros((len(signals), bins))
    for row, signal in zip(out, signals, strict=True):
        found = rainflow(signal)
        place = np.rint((np.log(found.ranges) - np.log(first)) / width)
        np.add.at(row, np.clip(place, 0, bins - 1).astype(int), found.counts)
    return out


def test_counts_of_each_signal():
    rng = np.random.default_rng(3)
    signals = np.cumsum(rng.normal(size=(5, 4000)), axis=1) * np.geomspace(1.0, 1e4, 5)[:, None]
    found = range_spectra(signals, first=1e-2, width=0.01, bins=2000)
    np.testing.assert_allclose(found, one_by_one(signals, 1e-2, 0.01, 2000), rtol=0, atol=1e-12)
    total = [rainflow(signal).counts.sum() for signal in signals]
    np.testing.assert_allclose(found.sum(axis=1), total)


@settings(max_examples=40, deadline=None)
@given(arrays(np.float64, (2, 30), elements=st.integers(-9, 9).map(float)))
def test_ranges_beyond_the_ends_go_to_the_end_bins(signals):
    found = range_spectra(signals, first=2.0, width=0.3, bins=4)
    np.testing.assert_allclose(found, one_by_one(signals, 2.0, 0.3, 4))


def test_sine_of_known_range():
    time = np.linspace(0.0, 10.0, 2001)
    signal = 50.0 * np.sin(2.0 * np.pi * time)[None]
    found = range_spectra(signal, first=1.0, width=0.01, bins=1000)[0]
    assert found.sum() == pytest.approx(10.5)  # 9.5 of the whole range, two halves of half of it
    places = np.flatnonzero(found)
    np.testing.assert_allclose(np.exp(0.01 * places), [50.0, 100.0], rtol=0.006)
    np.testing.assert_allclose(found[places], [1.0, 9.5])


def test_damage_of_bins():
    signal = np.random.default_rng(0).normal(size=(1, 50_000))
    curve = SNCurve(slope=4.0, reference_range=1.0, reference_cycles=1e6)
    found = range_spectra(signal, first=1e-3, width=0.01, bins=1200)[0]
    centres = 1e-3 * np.exp(0.01 * np.arange(1200))
    damage = float(np.sum(found / curve.life(centres)))
    assert damage == pytest.approx(miner_damage(rainflow(signal[0]), curve), rel=2e-3)


def test_constant_signal_has_no_cycles():
    assert not range_spectra(np.ones((2, 9)), first=1.0, width=0.1, bins=5).any()


@pytest.mark.parametrize(
    ("signals", "options", "match"),
    [
        (np.zeros(9), {}, "signals: got shape"),
        (np.zeros((2, 1)), {}, "signals: got shape"),
        (np.zeros((0, 9)), {}, "signals: got shape"),
        (np.full((1, 3), np.nan), {}, "NaN"),
        (np.zeros((1, 3)), {"first": 0.0}, "first"),
        (np.zeros((1, 3)), {"width": -0.1}, "width"),
        (np.zeros((1, 3)), {"bins": 0}, "bins"),
    ],
)
def test_bad_input(signals, options, match):
    with pytest.raises(InputError, match=match):
        range_spectra(signals, **({"first": 1.0, "width": 0.1, "bins": 5} | options))
