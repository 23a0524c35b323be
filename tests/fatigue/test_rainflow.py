"""Rainflow counting: the standard's examples, an independent package, invariances."""

from __future__ import annotations

from collections import defaultdict
from typing import Any

import numpy as np
import pytest
import rainflow as package
from hypothesis import given
from hypothesis import strategies as st

from pitchopt import InputError
from pitchopt.fatigue import Cycles, rainflow

# ASTM E1049-85, figure 6 and the cycle counts that go with it
STANDARD = [-2.0, 1.0, -3.0, 5.0, -1.0, 3.0, -4.0, 4.0, -2.0]
SIGNALS = st.lists(st.integers(-6, 6).map(float), min_size=2, max_size=60)


def table(cycles: Cycles) -> dict[float, float]:
    counts: dict[float, float] = defaultdict(float)
    for span, count in zip(cycles.ranges.tolist(), cycles.counts.tolist(), strict=True):
        counts[span] += count
    return dict(counts)


def as_rows(cycles: Cycles) -> list[tuple[float, float, float]]:
    columns = (cycles.ranges.tolist(), cycles.means.tolist(), cycles.counts.tolist())
    return sorted(zip(*columns, strict=True))


def of_the_package(signal: Any) -> list[tuple[float, float, float]]:
    # it has a range of zero where all samples are equal, and nothing at all for two samples
    return sorted((s, m, n) for s, m, n, _, _ in package.extract_cycles(signal) if s > 0.0)


def test_example_of_the_standard() -> None:
    cycles = rainflow(STANDARD)
    assert table(cycles) == {3.0: 0.5, 4.0: 1.5, 6.0: 0.5, 8.0: 1.0, 9.0: 0.5}
    # in the order of the standard: A-B, B-C, E-F, C-D, D-G, G-H, H-I
    np.testing.assert_array_equal(cycles.ranges, [3, 4, 4, 8, 9, 8, 6])
    np.testing.assert_array_equal(cycles.means, [-0.5, -1.0, 1.0, 1.0, 0.5, 0.0, 1.0])
    np.testing.assert_array_equal(cycles.counts, [0.5, 0.5, 1.0, 0.5, 0.5, 0.5, 0.5])


def test_repeating_history_of_the_standard() -> None:
    # section 5.4.5, figure 7: the same history as one period, begun at its largest value D
    cycles = rainflow(STANDARD, residue="repeat")
    assert table(cycles) == {3.0: 1.0, 4.0: 1.0, 7.0: 1.0, 9.0: 1.0}


@pytest.mark.parametrize("seed", range(20))
def test_against_the_package_on_random_signals(seed: int) -> None:
    rng = np.random.default_rng(seed)
    noise = rng.standard_normal(2000)
    for signal in (noise, noise.cumsum(), np.round(noise.cumsum()), np.repeat(np.round(noise), 3)):
        assert as_rows(rainflow(signal)) == of_the_package(signal)


@given(SIGNALS.filter(lambda signal: len(signal) > 2))
def test_against_the_package_on_short_signals(signal: list[float]) -> None:
    assert as_rows(rainflow(signal)) == of_the_package(signal)


@given(SIGNALS)
def test_counted_ranges_are_the_path(signal: list[float]) -> None:
    # whatever is paired with what, up and down add up to the way that the signal goes
    way = float(np.abs(np.diff(signal)).sum())
    cycles = rainflow(signal)
    assert 2.0 * float(cycles.counts @ cycles.ranges) == way
    assert cycles.ranges.max(initial=0.0) == np.ptp(signal)
    closed = rainflow(signal, residue="repeat")
    assert 2.0 * float(closed.ranges.sum()) == way + abs(signal[-1] - signal[0])
    assert (closed.counts == 1.0).all() and closed.ranges.max(initial=0.0) == np.ptp(signal)


@given(SIGNALS, st.integers(0, 59))
def test_a_period_may_begin_anywhere(signal: list[float], shift: int) -> None:
    turned = np.roll(signal, shift)
    assert table(rainflow(turned, residue="repeat")) == table(rainflow(signal, residue="repeat"))


@given(SIGNALS)
def test_closed_cycles_are_those_of_many_periods(signal: list[float]) -> None:
    # the package on three periods less two: the residue of a long history is counted away
    counts: dict[float, float] = defaultdict(float)
    for periods, sign in ((3, 1.0), (2, -1.0)):
        for span, _, count in of_the_package(signal * periods):
            counts[span] += sign * count
    assert {s: n for s, n in counts.items() if n} == table(rainflow(signal, residue="repeat"))


@given(SIGNALS)
def test_mirrored_and_repeated_samples(signal: list[float]) -> None:
    assert table(rainflow(-np.array(signal))) == table(rainflow(signal))
    assert as_rows(rainflow(np.repeat(signal, 3))) == as_rows(rainflow(signal))
    finer = np.interp(np.arange(2 * len(signal) - 1) / 2, np.arange(len(signal)), signal)
    assert as_rows(rainflow(finer)) == as_rows(rainflow(signal))


@pytest.mark.parametrize("residue", ["half", "repeat"])
def test_constant_signals_have_no_cycles(residue: Any) -> None:
    cycles = rainflow(np.full(10, 3.0), residue=residue)
    assert cycles.ranges.shape == cycles.means.shape == cycles.counts.shape == (0,)


def test_two_samples() -> None:
    assert as_rows(rainflow([1.0, 4.0])) == [(3.0, 2.5, 0.5)]
    assert as_rows(rainflow([1.0, 4.0], residue="repeat")) == [(3.0, 2.5, 1.0)]


def test_results_are_read_only() -> None:
    cycles = rainflow(STANDARD)
    assert not any(a.flags.writeable for a in (cycles.ranges, cycles.means, cycles.counts))


@pytest.mark.parametrize(
    ("signal", "message"),
    [
        ([1.0, np.nan, 2.0], "signal: got 1 NaN or infinite"),
        ([1.0, np.inf], "signal: got 1 NaN or infinite"),
        ([1.0], "signal: got 1 sample, expected at least 2"),
        ([], "signal: got shape"),
        ([[1.0, 2.0]], "signal: got shape"),
        (["a", "b"], "signal: expected numbers"),
    ],
)
def test_bad_signals(signal: Any, message: str) -> None:
    with pytest.raises(InputError, match=message):
        rainflow(signal)


def test_other_bad_input() -> None:
    with pytest.raises(InputError, match="residue: got 'full'"):
        rainflow(STANDARD, residue="full")  # type: ignore[arg-type]
    with pytest.raises(InputError, match="means: got shape"):
        Cycles(ranges=np.ones(2), means=np.ones(3), counts=np.ones(2))
    with pytest.raises(InputError, match=r"ranges: got 0\.0"):
        Cycles(ranges=np.zeros(2), means=np.ones(2), counts=np.ones(2))
