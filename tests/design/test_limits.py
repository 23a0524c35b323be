"""Actuator limits: the tightened intervals, the repair, the rate across the wrap."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from design_factories import OMEGA, random_curves, rotor_curves, wide_limits
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from pitchopt.design.limits import PitchLimits, lipschitz_lower, lipschitz_upper
from pitchopt.errors import InputError

FloatArray = NDArray[np.float64]


def brute_lower(bound: FloatArray, step: float) -> FloatArray:
    """max over j of bound_j minus step times the shorter way round from j to i."""
    n = bound.size
    away = np.abs(np.arange(n)[:, None] - np.arange(n))
    return np.asarray((bound[None, :] - step * np.minimum(away, n - away)).max(axis=1))


bounds = st.lists(st.floats(-1, 1, allow_subnormal=False), min_size=1, max_size=12).map(np.array)


class TestLipschitz:
    @given(bound=bounds, step=st.sampled_from([1e-6, 0.01, 0.1, 0.7, 5.0]))
    @settings(max_examples=100)
    def test_lower_by_brute_force(self, bound: FloatArray, step: float) -> None:
        want = brute_lower(bound, step)
        np.testing.assert_allclose(lipschitz_lower(bound, step), want, atol=1e-13)

    @given(bound=bounds, step=st.sampled_from([1e-6, 0.01, 0.1, 0.7, 5.0]))
    @settings(max_examples=100)
    def test_upper_by_brute_force(self, bound: FloatArray, step: float) -> None:
        want = -brute_lower(-bound, step)
        np.testing.assert_allclose(lipschitz_upper(bound, step), want, atol=1e-13)

    @given(bound=bounds, step=st.floats(1e-6, 3))
    @settings(max_examples=60)
    def test_keeps_the_rate_and_is_idempotent(self, bound: FloatArray, step: float) -> None:
        out = lipschitz_lower(bound, step)
        assert np.all(out >= bound - 1e-13)
        assert np.abs(np.roll(out, -1) - out).max() <= step + 1e-13
        np.testing.assert_allclose(lipschitz_lower(out, step), out, atol=1e-13)

    def test_no_step_leaves_the_extreme(self) -> None:
        np.testing.assert_array_equal(lipschitz_lower(np.array([0.1, 0.4, -1.0]), 0.0), 0.4)
        np.testing.assert_array_equal(lipschitz_upper(np.array([0.1, 0.4, -1.0]), 0.0), -1.0)

    def test_one_spike_seen_across_the_wrap(self) -> None:
        bound = np.array([1.0, 0.0, 0.0, 0.0, 0.0, 0.0])
        np.testing.assert_allclose(lipschitz_lower(bound, 0.3), [1.0, 0.7, 0.4, 0.1, 0.4, 0.7])


class TestRepair:
    @given(
        seed=st.integers(0, 10_000),
        rate=st.sampled_from([0.0, 1e-4, 0.05, 0.3, 2.0]),
        reach=st.floats(0, 1),
    )
    @settings(max_examples=100)
    def test_feasible_and_idempotent(self, seed: int, rate: float, reach: float) -> None:
        rng = np.random.default_rng(seed)
        limits = PitchLimits(rotor_speed=OMEGA, pitch_rate=rate, lower=-0.05, upper=0.15)
        raw = random_curves(rng, positions=int(rng.integers(1, 6)), blades=int(rng.integers(1, 4)))
        if raw.lower.max() >= raw.upper.min():
            return
        curves = limits.applied(raw)
        profile = limits.repaired(curves, rng.normal(0.0, reach, curves.stations))
        out, over = limits.violation(curves, profile)
        assert out <= 1e-12
        assert over <= 1e-12 * curves.stations * OMEGA
        np.testing.assert_allclose(limits.repaired(curves, profile), profile, rtol=0, atol=1e-12)

    @given(seed=st.integers(0, 1000))
    @settings(max_examples=40)
    def test_moves_no_farther_than_the_violation(self, seed: int) -> None:
        rng = np.random.default_rng(seed)
        limits = wide_limits(0.4)
        curves = limits.applied(rotor_curves(positions=4))
        good = limits.repaired(curves, rng.uniform(curves.lower, curves.upper))
        noise = rng.uniform(-1e-6, 1e-6, curves.stations)
        moved = np.abs(limits.repaired(curves, good + noise) - good).max()
        assert moved <= 2 * np.abs(noise).max() + 1e-15

    def test_regression_a_rate_without_end_is_no_limit(self) -> None:
        limits = wide_limits(1e12)
        curves = limits.applied(rotor_curves(positions=24))
        np.testing.assert_allclose(curves.lower, -0.1, rtol=0, atol=1e-12)
        profile = np.random.default_rng(2).uniform(-0.1, 0.25, curves.stations)
        repaired = limits.repaired(curves, profile)
        np.testing.assert_allclose(repaired, profile, rtol=0, atol=1e-12)

    def test_wrap_counts(self) -> None:
        limits = wide_limits(0.1)
        curves = limits.applied(rotor_curves(positions=4))
        ramp = np.linspace(0.0, 0.1, 12)  # fine between neighbours but for the last step
        step = limits.step(12)
        assert np.abs(np.diff(ramp)).max() < step < ramp[-1] - ramp[0]
        assert limits.violation(curves, ramp)[1] > 0
        assert limits.violation(curves, limits.repaired(curves, ramp))[1] <= 1e-12

    def test_applied_ends_keep_the_rate(self) -> None:
        rng = np.random.default_rng(3)
        limits = wide_limits(0.05)
        curves = limits.applied(random_curves(rng, positions=5))
        for end in (curves.lower, curves.upper):
            assert np.abs(np.roll(end, -1) - end).max() <= limits.step(15) + 1e-14

    def test_applied_loses_no_feasible_profile(self) -> None:
        rng = np.random.default_rng(4)
        n = 6
        curves = random_curves(rng, positions=2, knots=3)
        low = curves.lower + rng.uniform(0, 0.05, n)
        high = curves.upper - rng.uniform(0, 0.05, n)
        ragged = curves.with_limits(low, high)
        limits = wide_limits(0.05)
        cut, step = limits.applied(ragged), limits.step(n)
        kept = 0
        for _ in range(3000):
            profile = rng.uniform(low.min(), high.max()) + np.cumsum(rng.uniform(-step, step, n))
            inside = np.all(profile >= ragged.lower) and np.all(profile <= ragged.upper)
            if inside and abs(profile[0] - profile[-1]) <= step:
                kept += 1
                assert np.all(profile >= cut.lower - 1e-14)
                assert np.all(profile <= cut.upper + 1e-14)
        assert kept > 20

    def test_one_station_has_no_rate(self) -> None:
        limits = wide_limits(0.0)
        curves = limits.applied(rotor_curves(blades=1, positions=1))
        assert limits.violation(curves, np.array([0.1])) == (pytest.approx(-0.15), 0.0)


class TestRefusals:
    @pytest.mark.parametrize(
        ("change", "message"),
        [
            ({"rotor_speed": 0.0}, "rotor_speed: got 0"),
            ({"rotor_speed": -1.0}, "rotor_speed: got -1"),
            ({"rotor_speed": np.nan}, "rotor_speed: got nan"),
            ({"rotor_speed": "2"}, "rotor_speed: got '2'"),
            ({"rotor_speed": True}, "rotor_speed: got True"),
            ({"pitch_rate": -0.1}, "pitch_rate: got -0.1"),
            ({"pitch_rate": np.inf}, "pitch_rate: got inf"),
            ({"pitch_rate": None}, "pitch_rate: got None"),
            ({"lower": 0.2, "upper": 0.1}, "pitch range: lower limit"),
            ({"lower": 0.1, "upper": 0.1}, "pitch range: lower limit"),
            ({"lower": np.nan}, "lower: got nan"),
            ({"upper": [1.0]}, "upper: got"),
        ],
    )
    def test_numbers(self, change: dict[str, Any], message: str) -> None:
        good = {"rotor_speed": 2.0, "pitch_rate": 0.1, "lower": -0.1, "upper": 0.3}
        with pytest.raises(InputError, match=message):
            PitchLimits(**(good | change))

    @pytest.mark.parametrize(("low", "high"), [(0.25, 0.5), (-1.0, -0.1), (1.0, 2.0)])
    def test_no_constant_pitch_left(self, low: float, high: float) -> None:
        limits = PitchLimits(rotor_speed=2.0, pitch_rate=1.0, lower=low, upper=high)
        with pytest.raises(InputError, match="no constant pitch satisfies the range"):
            limits.applied(rotor_curves())

    def test_stall_limits_that_cross(self) -> None:
        curves = rotor_curves(positions=2)
        low = np.array([-0.1, 0.11, -0.1, -0.1, -0.1, -0.1])
        high = np.array([0.25, 0.25, 0.25, 0.10, 0.25, 0.25])
        ragged = curves.with_limits(low, high)
        with pytest.raises(InputError, match=r"lower limit up to 6\.303 deg"):
            wide_limits().applied(ragged)

    def test_step_in_radians(self) -> None:
        limits = PitchLimits(rotor_speed=2.0, pitch_rate=0.5)
        assert limits.step(10) == pytest.approx(0.5 * (2 * np.pi / 10) / 2.0)
