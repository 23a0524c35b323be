"""S-N curves, Miner damage, wind speeds of a lifetime."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.stats import weibull_min

from pitchopt import InputError
from pitchopt.fatigue import (
    Cycles,
    SNCurve,
    bin_edges,
    combine_damage,
    combine_loads,
    equivalent_load,
    miner_damage,
    rainflow,
    weibull_weights,
)

# EN 1993-1-9, detail category 71 MPa at 2e6 cycles: slope 3 to 5e6 cycles, then 5, cut off at 1e8
STEEL = SNCurve(
    slope=3.0, reference_range=71e6, second_slope=5.0, knee_cycles=5e6, endurance_cycles=1e8
)


def test_detail_category_of_the_eurocode() -> None:
    # its table: constant amplitude limit 0.737, cut-off limit 0.549 of the one before
    knee = 71e6 * (2 / 5) ** (1 / 3)
    assert knee / 71e6 == pytest.approx(0.737, abs=5e-4)
    cut = knee * (5 / 100) ** (1 / 5)
    assert cut / knee == pytest.approx(0.549, abs=5e-4)
    np.testing.assert_allclose(STEEL.life([142e6, 71e6, knee, cut]), [2.5e5, 2e6, 5e6, 1e8])
    assert np.isinf(STEEL.life([cut * (1 - 1e-9), 0.0])).all()
    assert STEEL.life(knee / 1.2) == pytest.approx(5e6 * 1.2**5)


def test_one_slope_has_no_end() -> None:
    curve = SNCurve(slope=4.0, reference_range=10.0, reference_cycles=1.0)  # ultimate range 10
    np.testing.assert_allclose(curve.life([10.0, 1.0, 0.1]), [1.0, 1e4, 1e8])
    assert curve.life(0.0) == np.inf


def test_miners_sum() -> None:
    cycles = Cycles(
        ranges=np.array([142e6, 71e6, 1e6]), means=np.zeros(3), counts=np.array([1e4, 0.5, 1e9])
    )
    assert miner_damage(cycles, STEEL) == pytest.approx(1e4 / 2.5e5 + 0.5 / 2e6, rel=1e-12)
    halved = Cycles(ranges=cycles.ranges / 2, means=cycles.means, counts=cycles.counts)
    assert miner_damage(halved, STEEL, scale=2.0) == pytest.approx(miner_damage(cycles, STEEL))
    assert miner_damage(rainflow([1.0, 1.0]), STEEL) == 0.0


@given(st.floats(1.0, 14.0), st.floats(0.1, 100.0))
def test_equivalent_load_does_the_same_damage(slope: float, scale: float) -> None:
    signal = np.random.default_rng(1).standard_normal(500).cumsum()
    curve = SNCurve(slope=slope, reference_range=20.0, reference_cycles=1e5)
    load = equivalent_load(rainflow(signal), slope, duration=50.0, frequency=2.0)
    same = Cycles(ranges=np.array([load]), means=np.zeros(1), counts=np.array([100.0]))
    assert miner_damage(rainflow(signal), curve, scale=scale) == pytest.approx(
        miner_damage(same, curve, scale=scale), rel=1e-9
    )


def test_thickness() -> None:
    # DNV-RP-C203: log N = log a - m log(S (t / t_0)^k)
    thick = STEEL.for_thickness(0.05)
    np.testing.assert_allclose(thick.life(80e6), STEEL.life(80e6 * 2**0.2))
    assert STEEL.for_thickness(0.02) == STEEL
    assert STEEL.for_thickness(0.05, reference=0.1) == STEEL


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"slope": 0.0}, "slope: got 0"),
        ({"reference_range": -1.0}, "reference_range: got -1"),
        ({"reference_cycles": np.nan}, "reference_cycles: got nan"),
        ({"second_slope": 5.0}, "second_slope, knee_cycles: got 5.0 and None"),
        ({"knee_cycles": 5e6}, "expected both or none"),
        ({"second_slope": -5.0, "knee_cycles": 5e6}, "second_slope: got -5"),
        ({"second_slope": 5.0, "knee_cycles": 5e6, "endurance_cycles": 1e6}, "at least knee"),
    ],
)
def test_bad_curves(changes: dict[str, Any], message: str) -> None:
    settings: dict[str, Any] = {"slope": 3.0, "reference_range": 71e6}
    with pytest.raises(InputError, match=message):
        SNCurve(**(settings | changes))


def test_bad_ranges_and_scales() -> None:
    for value in (-1.0, np.nan):
        with pytest.raises(InputError, match="ranges: got"):
            STEEL.life([1.0, value])
    with pytest.raises(InputError, match="scale: got 0"):
        miner_damage(rainflow([0.0, 1.0]), STEEL, scale=0.0)
    with pytest.raises(InputError, match="thickness: got 0"):
        STEEL.for_thickness(0.0)


# --- wind speeds ---


def test_edges_of_bins() -> None:
    np.testing.assert_allclose(bin_edges([4.0, 6.0, 10.0]), [3.0, 5.0, 8.0, 12.0])
    np.testing.assert_allclose(bin_edges([0.5, 2.5]), [0.0, 1.5, 3.5])


@pytest.mark.parametrize("shape", [1.0, 2.0, 2.17])
def test_weights_are_scipys(shape: float) -> None:
    edges = np.arange(3.0, 27.0, 2.0)
    wanted = np.diff(weibull_min.cdf(edges, shape, scale=10.3))
    got = weibull_weights(edges, shape=shape, scale=10.3)
    np.testing.assert_allclose(got, wanted, rtol=1e-12)
    np.testing.assert_allclose(
        weibull_weights(edges, shape=shape, scale=10.3, normalised=True), wanted / wanted.sum()
    )
    mean = float(weibull_min.mean(shape, scale=10.3))
    np.testing.assert_allclose(weibull_weights(edges, shape=shape, mean=mean), wanted, rtol=1e-12)


def test_rayleigh_of_the_standard() -> None:
    # IEC 61400-1: P(V) = 1 - exp(-pi (V / (2 V_ave))^2)
    edges = np.array([0.0, 8.5, 60.0])
    share = 1.0 - math.exp(-math.pi / 4.0)
    np.testing.assert_allclose(weibull_weights(edges, mean=8.5), [share, 1.0 - share], atol=1e-12)


@pytest.mark.parametrize(
    ("edges", "changes", "message"),
    [
        ([3.0], {}, "edges: got"),
        ([3.0, 3.0], {}, "edges: got"),
        ([-1.0, 3.0], {}, "edges: got"),
        ([3.0, np.nan], {}, "edges: got 1 NaN"),
        ([3.0, 5.0], {"shape": 0.0}, "shape: got 0"),
        ([3.0, 5.0], {"mean": 8.0}, "scale, mean: got 10.0 and 8.0"),
        ([3.0, 5.0], {"scale": None}, "scale, mean: got None and None"),
        ([3.0, 5.0], {"scale": -1.0}, "scale: got -1"),
        ([3.0, 5.0], {"scale": None, "mean": 0.0}, "mean: got 0"),
        ([5000.0, 6000.0], {"normalised": True}, "edges: got 5000.0 to 6000.0"),
    ],
)
def test_bad_weights(edges: list[float], changes: dict[str, Any], message: str) -> None:
    with pytest.raises(InputError, match=message):
        weibull_weights(edges, **({"scale": 10.0} | changes))


@pytest.mark.parametrize("speeds", [[3.0], [4.0, 4.0], [-1.0, 2.0]])
def test_bad_speeds(speeds: list[float]) -> None:
    with pytest.raises(InputError, match="speeds: got"):
        bin_edges(speeds)


def test_combined_loads() -> None:
    loads = np.array([[1.0, 2.0, 3.0], [0.0, 0.0, 0.0]])
    got = combine_loads(loads, [0.2, 0.3, 0.4], 4.0)
    assert got[0] == pytest.approx((0.2 + 0.3 * 16 + 0.4 * 81) ** 0.25)
    assert got[1] == 0.0
    # seeds: the load of one long series
    assert combine_loads([2.0, 4.0], None, 3.0) == pytest.approx(((8 + 64) / 2) ** (1 / 3))
    # large loads and slopes do not overflow
    assert combine_loads([1e40, 1e40], None, 12.0) == pytest.approx(1e40)


def test_combined_loads_of_signals_one_after_the_other() -> None:
    # half the time each: the cycles of both in twice the time
    first = rainflow(np.random.default_rng(1).standard_normal(300))
    second = rainflow(2.0 * np.random.default_rng(2).standard_normal(300))
    both = Cycles(
        ranges=np.concatenate([first.ranges, second.ranges]),
        means=np.concatenate([first.means, second.means]),
        counts=np.concatenate([first.counts, second.counts]),
    )
    loads = [equivalent_load(c, 5.0, duration=30.0) for c in (first, second)]
    together = equivalent_load(both, 5.0, duration=60.0)
    assert combine_loads(loads, None, 5.0) == pytest.approx(together, rel=1e-12)


def test_combined_damage() -> None:
    got = combine_damage([1e-6, 2e-6], [0.25, 0.5], duration=600.0, lifetime=20 * 365.25 * 86400)
    assert got == pytest.approx(1.25e-6 * 20 * 365.25 * 144)
    assert combine_damage([[1.0, 3.0]], None, duration=1.0, lifetime=2.0)[0] == pytest.approx(4.0)


@pytest.mark.parametrize(
    ("loads", "weights", "slope", "message"),
    [
        (3.0, None, 4.0, "loads: got shape"),
        ([], None, 4.0, "loads: got shape"),
        ([1.0, -2.0], None, 4.0, "loads: got -2"),
        ([1.0, np.nan], None, 4.0, "loads: got 1 NaN"),
        ([1.0, 2.0], [1.0], 4.0, "weights: got shape"),
        ([1.0, 2.0], [1.0, -1.0], 4.0, "weights: got -1"),
        ([1.0, 2.0], None, 0.0, "slope: got 0"),
    ],
)
def test_bad_combinations(loads: Any, weights: Any, slope: float, message: str) -> None:
    with pytest.raises(InputError, match=message):
        combine_loads(loads, weights, slope)


def test_bad_lifetimes() -> None:
    for changes in ({"duration": 0.0}, {"lifetime": -1.0}):
        settings = {"duration": 1.0, "lifetime": 1.0} | changes
        with pytest.raises(InputError, match=next(iter(changes))):
            combine_damage([1.0], None, **settings)
