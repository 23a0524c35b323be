"""BladeCurves: construction, exact interpolation, loads, limits and files."""

from __future__ import annotations

import signal
from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from pitchopt.aero.curves import LOADS, BladeCurves
from pitchopt.errors import InputError

FloatArray = NDArray[np.float64]

CURVES = ("torque", "bending", "thrust", "radial")
RATES = ("torque_rate", "bending_rate", "thrust_rate", "radial_rate")


def made(
    *,
    seed: int = 0,
    blades: int = 3,
    positions: int = 2,
    knots: int = 4,
    rates: bool = True,
    **extra: Any,
) -> BladeCurves:
    rng = np.random.default_rng(seed)
    n = blades * positions
    beta = np.cumsum(rng.uniform(1e-3, 0.2, (n, knots)), axis=1) - 0.3
    fields: dict[str, Any] = {name: rng.normal(0, 1e4, (n, knots)) for name in CURVES}
    if rates:
        fields |= {name: rng.normal(0, 1e3, n) for name in RATES}
    psi = rng.uniform(0, 6.0) + 2 * np.pi * np.arange(n) / n
    return BladeCurves(blades=blades, azimuth=psi, beta=beta, **(fields | extra))


def inside(curves: BladeCurves, seed: int) -> FloatArray:
    return np.asarray(np.random.default_rng(seed).uniform(curves.lower, curves.upper))


def slow(curves: BladeCurves, beta: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Rotor loads and bending as sums over blades, one station after the other."""
    n, m = curves.stations, curves.positions
    rotor, bending = np.zeros((4, m)), np.zeros(n)
    for k in range(m):
        for b in range(curves.blades):
            i = k + b * m
            rate = (beta[(i + 1) % n] - beta[(i - 1) % n]) / (4 * np.pi / n)
            torque, bend, thrust, radial = (
                np.interp(beta[i], curves.beta[i], getattr(curves, name)[i])
                + rate * getattr(curves, name + "_rate")[i]
                for name in CURVES
            )
            psi = curves.azimuth[i]
            rotor[:, k] += (
                torque,
                bend * np.cos(psi) - radial * np.sin(psi),
                bend * np.sin(psi) + radial * np.cos(psi),
                thrust,
            )
            bending[i] = bend
    return rotor, bending


class TestConstruction:
    GOOD = made()

    @pytest.mark.parametrize(
        ("change", "message"),
        [
            ({"blades": 0}, "blades: got 0"),
            ({"blades": 2.5}, "blades: got 2.5"),
            ({"blades": True}, "blades: got True"),
            ({"blades": 4}, "azimuth: got shape"),
            ({"azimuth": np.zeros((2, 3))}, "azimuth: got shape"),
            ({"azimuth": np.zeros(0)}, "azimuth: got shape"),
            ({"azimuth": np.zeros(6)}, "evenly spaced"),
            ({"azimuth": -2 * np.pi * np.arange(6) / 6}, "evenly spaced"),
            ({"azimuth": np.arange(5) * 2 * np.pi / 5}, "azimuth: got shape"),
            ({"azimuth": [np.nan] * 6}, "azimuth: got 6 NaN"),
            ({"azimuth": ["a"] * 6}, "azimuth: expected numbers"),
            ({"beta": GOOD.beta[:, :1]}, "beta: got shape"),
            ({"beta": GOOD.beta[0]}, "beta: got shape"),
            ({"beta": GOOD.beta[:4]}, "beta: got shape"),
            ({"beta": GOOD.beta[:, ::-1]}, "breakpoints must increase"),
            ({"beta": np.full((6, 4), np.inf)}, "beta: got 24 NaN or infinite"),
            ({"torque": GOOD.torque[:, :2]}, "torque: got shape"),
            ({"bending": np.full((6, 4), np.nan)}, "bending: got 24 NaN"),
            ({"thrust": GOOD.thrust.T}, "thrust: got shape"),
            ({"radial": np.zeros(6)}, "radial: got shape"),
            ({"radial": [["x"] * 4] * 6}, "radial: expected numbers"),
            ({"torque_rate": np.zeros((6, 4))}, "torque_rate: got shape"),
            ({"bending_rate": np.zeros(5)}, "bending_rate: got shape"),
            ({"thrust_rate": [np.inf] * 6}, "thrust_rate: got 6 NaN or infinite"),
            ({"radial_rate": 1.0}, "radial_rate: got shape"),
            ({"mean_pitch": np.nan}, "mean_pitch: got nan"),
        ],
    )
    def test_refuses(self, change: dict[str, Any], message: str) -> None:
        with pytest.raises(InputError, match=message):
            replace(self.GOOD, **change)

    @pytest.mark.parametrize(
        "change",
        [{"blades": "x"}, {"blades": None}, {"blades": np.nan}, {"mean_pitch": "x"}],
        ids=str,
    )
    def test_regression_other_types_raise_the_own_error(self, change: dict[str, Any]) -> None:
        with pytest.raises(InputError, match=next(iter(change))):
            replace(self.GOOD, **change)

    def test_equal_breakpoints_name_their_row(self) -> None:
        beta = np.array(self.GOOD.beta)
        beta[3, 2] = beta[3, 1]
        with pytest.raises(InputError, match="row 3 has a step of 0"):
            replace(self.GOOD, beta=beta)

    def test_arrays_are_copied_and_read_only(self) -> None:
        torque = np.array(self.GOOD.torque)
        curves = replace(self.GOOD, torque=torque)
        before = curves.torque[0, 0]
        torque[0, 0] += 1.0
        assert curves.torque[0, 0] == before
        for name in ("azimuth", "beta", *CURVES, *RATES, "loads", "slopes", "rates"):
            assert not getattr(curves, name).flags.writeable

    def test_what_is_left_out_is_zero(self) -> None:
        g = self.GOOD
        curves = BladeCurves(
            blades=3,
            azimuth=g.azimuth,
            beta=g.beta,
            torque=g.torque,
            bending=g.bending,
            thrust=g.thrust,
        )
        assert not np.any(curves.radial)
        assert not np.any(curves.rates)

    def test_sizes(self) -> None:
        curves = made(blades=2, positions=5, knots=3)
        assert (curves.stations, curves.positions) == (10, 5)
        assert curves.spacing == pytest.approx(2 * np.pi / 10)


class TestInterpolation:
    @given(seed=st.integers(0, 999), knots=st.integers(2, 9), blades=st.integers(1, 3))
    @settings(max_examples=40)
    def test_equals_numpy_row_by_row(self, seed: int, knots: int, blades: int) -> None:
        curves = made(seed=seed, knots=knots, blades=blades, rates=False)
        profile = inside(curves, seed)
        got = curves.contributions(profile)
        for n in range(curves.stations):
            for load in range(5):
                want = np.interp(profile[n], curves.beta[n], curves.loads[load, n])
                assert got[load, n] == pytest.approx(want, rel=1e-11, abs=1e-8)

    @given(seed=st.integers(0, 999))
    @settings(max_examples=30)
    def test_breakpoints_are_met_exactly(self, seed: int) -> None:
        curves = made(seed=seed, rates=False, knots=7)
        rows = np.arange(curves.stations)
        for k in range(7):
            np.testing.assert_allclose(
                curves.contributions(curves.beta[:, k]), curves.loads[:, rows, k], rtol=1e-12
            )

    def test_segments_near_the_ends(self) -> None:
        curves = made(knots=5)
        assert not np.any(curves.segment(curves.lower))
        np.testing.assert_array_equal(curves.segment(curves.upper), 3)
        np.testing.assert_array_equal(curves.segment(np.nextafter(curves.upper, -9)), 3)
        np.testing.assert_array_equal(curves.segment(np.full(6, -9.0)), 0)
        np.testing.assert_array_equal(curves.segment(np.full(6, 9.0)), 3)

    def test_close_breakpoints_stay_exact(self) -> None:
        """Breakpoints 1e-9 rad apart at either end: the values on both sides are right."""
        beta = np.tile([0.0, 1e-9, 0.1, 0.2 - 1e-9, 0.2], (6, 1))
        torque = np.tile([1.0, 2.0, 3.0, 1.0, 5.0], (6, 1))
        flat = np.zeros((6, 5))
        psi = 2 * np.pi * np.arange(6) / 6
        curves = BladeCurves(
            blades=3, azimuth=psi, beta=beta, torque=torque, bending=flat, thrust=flat
        )
        for pitch, want in ((0.0, 1.0), (1e-9, 2.0), (0.1, 3.0), (0.15, 2.0), (0.2, 5.0)):
            got = curves.contributions(np.full(6, pitch))[0]
            np.testing.assert_allclose(got, want, rtol=0, atol=2e-6)

    def test_goes_on_straight_outside(self) -> None:
        curves = made(rates=False)
        for end, step in ((curves.lower, -0.01), (curves.upper, 0.01)):
            j = curves.segment(end)
            slope = curves.slopes[:, np.arange(6), j]
            change = curves.contributions(end + step) - curves.contributions(end)
            np.testing.assert_allclose(change, slope * step, rtol=1e-9, atol=1e-7)


class TestLoads:
    @given(
        seed=st.integers(0, 999),
        blades=st.integers(1, 4),
        positions=st.integers(1, 5),
        rates=st.booleans(),
    )
    @settings(max_examples=60)
    def test_equals_the_slow_sums(
        self, seed: int, blades: int, positions: int, rates: bool
    ) -> None:
        curves = made(seed=seed, blades=blades, positions=positions, rates=rates)
        profile = inside(curves, seed + 1)
        got = curves.evaluate(profile)
        rotor, bending = slow(curves, profile)
        scale = np.abs(rotor).max() + 1e4
        np.testing.assert_allclose(got.rotor, rotor, rtol=0, atol=1e-11 * scale)
        np.testing.assert_allclose(got.bending, bending, rtol=0, atol=1e-11 * scale)
        deviation = rotor - rotor.mean(axis=1, keepdims=True)
        want = np.sqrt((deviation**2).mean(axis=1))
        np.testing.assert_allclose(got.rms, want, rtol=0, atol=1e-10 * scale)
        np.testing.assert_allclose(got.mean, rotor.mean(axis=1), rtol=0, atol=1e-11 * scale)
        spread = np.sqrt(np.mean((bending - bending.mean()) ** 2))
        assert got.blade_rms == pytest.approx(spread, abs=1e-10 * scale)

    def test_rates_from_finite_sums(self) -> None:
        """A profile of one harmonic on flat curves: only the rate terms speak."""
        n, amplitude = 36, 0.02
        psi = 2 * np.pi * np.arange(n) / n
        flat, share = np.zeros((n, 2)), np.full(n, 100.0)
        curves = BladeCurves(
            blades=3,
            azimuth=psi,
            beta=np.tile([-1.0, 1.0], (n, 1)),
            torque=flat,
            bending=flat,
            thrust=flat,
            bending_rate=share,
        )
        loads = curves.evaluate(amplitude * np.sin(psi))
        # central differences of sin psi: cos psi times sin(h)/h
        step = 2 * np.pi / n
        slope = amplitude * np.sin(step) / step
        np.testing.assert_allclose(loads.bending, 100 * slope * np.cos(psi), atol=1e-12)
        np.testing.assert_allclose(loads.rotor[1], 150 * slope, rtol=1e-12)  # sum of cos^2
        np.testing.assert_allclose(loads.rotor[2], 0.0, atol=1e-12)

    def test_rate_is_zero_for_constant_pitch(self) -> None:
        curves = made()
        assert not np.any(curves.profile_rate(np.full(6, 0.3)))
        assert not np.any(made(blades=1, positions=1).profile_rate(np.array([0.3])))

    def test_constant_pitches_in_one_call(self) -> None:
        curves = made()
        rotor, bending = curves.evaluate_constant([0.0, 0.1])
        assert rotor.shape == (2, 4, 2)
        assert bending.shape == (2, 6)
        np.testing.assert_array_equal(rotor[1], curves.evaluate(np.full(6, 0.1)).rotor)

    @given(seed=st.integers(0, 99), shift=st.integers(-4, 9))
    @settings(max_examples=20)
    def test_stations_renumbered_change_nothing(self, seed: int, shift: int) -> None:
        """The first station may stand anywhere: RMS and means are those of the same rotor."""
        curves = made(seed=seed, positions=4)
        rolled: dict[str, Any] = {
            name: np.roll(getattr(curves, name), -shift, axis=0)
            for name in ("beta", *CURVES, *RATES)
        }
        step = 2 * np.pi / curves.stations
        other = replace(curves, azimuth=curves.azimuth + shift * step, **rolled)
        profile = inside(curves, seed)
        a, b = curves.evaluate(profile), other.evaluate(np.roll(profile, -shift))
        np.testing.assert_allclose(b.rms, a.rms, rtol=1e-10)
        np.testing.assert_allclose(b.mean, a.mean, rtol=1e-9, atol=1e-8)
        assert b.blade_rms == pytest.approx(a.blade_rms, rel=1e-10)

    @given(seed=st.integers(0, 99))
    @settings(max_examples=20)
    def test_mirrored_rotor(self, seed: int) -> None:
        """Stations at -psi with the radial moment and the rates reversed: yaw changes sign."""
        n = 12
        curves = made(seed=seed, positions=4)
        curves = replace(curves, azimuth=2 * np.pi * np.arange(n) / n)
        flip = -np.arange(n) % n
        fields: dict[str, Any] = {name: getattr(curves, name)[flip] for name in ("beta", *CURVES)}
        fields |= {name: -getattr(curves, name)[flip] for name in RATES}
        fields["radial"] = -fields["radial"]
        fields["radial_rate"] = -fields["radial_rate"]
        mirrored = replace(curves, **fields)
        profile = inside(curves, seed)
        a, b = curves.evaluate(profile), mirrored.evaluate(profile[flip])
        np.testing.assert_allclose(b.rms, a.rms, rtol=1e-9)
        sign = np.array([1.0, 1.0, -1.0, 1.0])
        np.testing.assert_allclose(b.mean, a.mean * sign, rtol=1e-9, atol=1e-7)
        assert b.blade_rms == pytest.approx(a.blade_rms, rel=1e-10)

    @given(seed=st.integers(0, 99), factor=st.sampled_from([1e-6, 1e-3, 1e3, 1e6]))
    @settings(max_examples=20)
    def test_loads_scale_with_their_unit(self, seed: int, factor: float) -> None:
        curves = made(seed=seed)
        fields: dict[str, Any] = {
            name: factor * np.asarray(getattr(curves, name)) for name in CURVES + RATES
        }
        profile = inside(curves, seed)
        a, b = curves.evaluate(profile), replace(curves, **fields).evaluate(profile)
        np.testing.assert_allclose(b.rms, factor * a.rms, rtol=1e-10)
        assert replace(curves, **fields).concavity_error == pytest.approx(curves.concavity_error)

    def test_order_of_loads(self) -> None:
        assert LOADS == ("torque", "tilt", "yaw", "thrust")

    @pytest.mark.parametrize("shape", [(5,), (6, 1), ()])
    def test_refuses_profiles_of_another_shape(self, shape: tuple[int, ...]) -> None:
        with pytest.raises(InputError, match="profile: got shape"):
            made().evaluate(np.zeros(shape))


class TestConcavity:
    def test_known_slopes(self) -> None:
        flat = np.zeros((3, 4))
        psi = 2 * np.pi * np.arange(3) / 3
        beta = np.tile([0.0, 1.0, 2.0, 3.0], (3, 1))

        def error(torque: list[float]) -> BladeCurves:
            return BladeCurves(
                blades=3,
                azimuth=psi,
                beta=beta,
                torque=np.tile(torque, (3, 1)),
                bending=flat,
                thrust=flat,
            )

        assert error([0.0, 3.0, 4.0, 4.0]).concavity_error == 0.0
        assert error([0.0, 3.0, 4.0, 4.0]).concave
        bent = error([0.0, 2.0, 3.0, 5.0])  # slopes 2, 1, 2
        assert bent.concavity_error == pytest.approx(0.5)
        assert not bent.concave
        assert error([0.0, 0.0, 0.0, 0.0]).concave

    def test_one_segment_is_concave(self) -> None:
        assert made(knots=2).concavity_error == 0.0


class TestLimits:
    @given(seed=st.integers(0, 999), share=st.tuples(st.floats(0, 0.45), st.floats(0.55, 1)))
    @settings(max_examples=40)
    def test_narrower_curves_are_the_same_curves(
        self, seed: int, share: tuple[float, float]
    ) -> None:
        curves = made(seed=seed, knots=6)
        width = curves.upper - curves.lower
        low, high = curves.lower + share[0] * width, curves.lower + share[1] * width
        cut = curves.with_limits(low, high)
        np.testing.assert_array_equal(cut.lower, np.maximum(low, curves.lower))
        np.testing.assert_array_equal(cut.upper, np.minimum(high, curves.upper))
        for where in np.linspace(0, 1, 9):
            profile = cut.lower + where * (cut.upper - cut.lower)
            a, b = curves.evaluate(profile), cut.evaluate(profile)
            np.testing.assert_allclose(b.rotor, a.rotor, rtol=1e-9, atol=1e-6)
            np.testing.assert_allclose(b.bending, a.bending, rtol=1e-9, atol=1e-6)

    def test_wider_limits_change_nothing(self) -> None:
        curves = made()
        assert curves.with_limits(-9.0, 9.0) is curves

    def test_rows_of_different_length_are_padded(self) -> None:
        curves = made(knots=8)
        low = np.array(curves.beta[:, 0])
        low[2] = 0.5 * (curves.beta[2, 5] + curves.beta[2, 6])
        cut = curves.with_limits(low, 9.0)
        assert cut.beta.shape == curves.beta.shape
        assert np.all(np.diff(cut.beta, axis=1) > 0)
        pitch = np.linspace(cut.lower[2], cut.upper[2], 50)
        np.testing.assert_allclose(
            np.interp(pitch, cut.beta[2], cut.torque[2]),
            np.interp(pitch, curves.beta[2], curves.torque[2]),
            rtol=1e-10,
        )

    def test_a_limit_on_a_breakpoint_does_not_double_it(self) -> None:
        curves = made(knots=5)
        cut = curves.with_limits(curves.beta[:, 1] - 1e-12, curves.beta[:, 3] + 1e-12)
        assert np.all(np.diff(cut.beta, axis=1) > 1e-9)

    @pytest.mark.parametrize(("low", "high"), [(1.0, 0.9), (0.0, 0.0), (5.0, 6.0), (-9.0, -8.0)])
    def test_refuses_empty_intervals(self, low: float, high: float) -> None:
        with pytest.raises(InputError, match="no pitch is left at azimuth"):
            made().with_limits(low, high)

    def test_keeps_what_is_no_curve(self) -> None:
        curves = made(mean_pitch=0.05)
        cut = curves.with_limits(curves.lower + 0.01, curves.upper - 0.01)
        assert cut.mean_pitch == 0.05
        np.testing.assert_array_equal(cut.rates, curves.rates)


def same(a: BladeCurves, b: BladeCurves) -> bool:
    names = ("azimuth", "beta", *CURVES, *RATES)
    arrays = all(np.array_equal(getattr(a, name), getattr(b, name)) for name in names)
    return arrays and a.blades == b.blades and a.mean_pitch == b.mean_pitch


class TestThinned:
    @pytest.mark.parametrize("blades", [1, 2, 3])
    def test_divisors_keep_every_so_many_stations(self, blades: int) -> None:
        curves = made(blades=blades, positions=6)
        few = curves.thinned(3)
        assert (few.blades, few.positions) == (blades, 3)
        for name in ("azimuth", "beta", *CURVES, *RATES):
            np.testing.assert_allclose(getattr(few, name), getattr(curves, name)[::2], rtol=1e-14)

    def test_other_numbers_take_the_nearest_station(self) -> None:
        curves = made(positions=7)
        few = curves.thinned(5)
        for i, azimuth in enumerate(few.azimuth):
            away = np.abs(np.angle(np.exp(1j * (curves.azimuth - azimuth))))
            np.testing.assert_array_equal(few.torque[i], curves.torque[np.argmin(away)])
            assert away.min() <= 0.5 * curves.spacing * (1 + 1e-9)

    @pytest.mark.parametrize("positions", [0, 3])
    def test_refuses_other_numbers(self, positions: int) -> None:
        with pytest.raises(InputError, match=f"positions: got {positions}"):
            made(positions=2).thinned(positions)


class TestFiles:
    @pytest.mark.parametrize("suffix", [".npz", ".csv"])
    @pytest.mark.parametrize("mean", [None, 0.1 / 3, np.float64(0.1 / 3)])
    def test_round_trip_is_bit_equal(self, tmp_path: Path, suffix: str, mean: float | None) -> None:
        curves = made(mean_pitch=mean, blades=2)
        path = curves.save(tmp_path / f"curves{suffix}")
        assert same(BladeCurves.load(path), curves)
        assert [p.name for p in tmp_path.iterdir()] == [path.name]

    @pytest.mark.parametrize("suffix", [".npz", ".csv"])
    def test_overwrites(self, tmp_path: Path, suffix: str) -> None:
        path = tmp_path / f"curves{suffix}"
        made(seed=1).save(path)
        made(seed=2).save(str(path))
        assert same(BladeCurves.load(str(path)), made(seed=2))

    def test_refuses_other_suffixes(self, tmp_path: Path) -> None:
        with pytest.raises(InputError, match=r"path: got 'a\.txt'"):
            made().save(tmp_path / "a.txt")
        (tmp_path / "a.txt").write_text("x")
        with pytest.raises(InputError, match=r"curves file: got 'a\.txt'"):
            BladeCurves.load(tmp_path / "a.txt")

    def test_refuses_a_folder_that_is_not_there(self, tmp_path: Path) -> None:
        with pytest.raises(InputError, match="cannot write"):
            made().save(tmp_path / "absent" / "a.npz")

    @pytest.mark.parametrize("suffix", [".npz", ".csv"])
    @pytest.mark.parametrize("what", ["missing", "empty", "folder", "binary", "truncated", "huge"])
    def test_refuses_broken_files(self, tmp_path: Path, suffix: str, what: str) -> None:
        path = tmp_path / f"a{suffix}"
        if what == "empty":
            path.touch()
        elif what == "folder":
            path.mkdir()
        elif what == "binary":
            path.write_bytes(bytes(range(256)) * 40)
        elif what == "truncated":
            payload = made().save(path).read_bytes()
            path.write_bytes(payload[: len(payload) // 3])
        elif what == "huge":
            with path.open("wb") as stream:
                stream.truncate((1 << 30) + 1)  # sparse
        with pytest.raises(InputError):
            BladeCurves.load(path)

    def test_text_in_an_npz_name(self, tmp_path: Path) -> None:
        path = made().save(tmp_path / "a.csv").rename(tmp_path / "a.npz")
        with pytest.raises(InputError, match="not a readable NPZ"):
            BladeCurves.load(path)

    def test_pickled_content_is_refused(self, tmp_path: Path) -> None:
        path = tmp_path / "a.npz"
        np.savez(path, blades=np.array([{"a": 1}], dtype=object))
        with pytest.raises(InputError, match="not a readable NPZ"):
            BladeCurves.load(path)

    @pytest.mark.parametrize("name", ["blades", "azimuth", "beta", "torque", "bending", "thrust"])
    def test_npz_names_what_is_missing(self, tmp_path: Path, name: str) -> None:
        content = self.content()
        del content[name]
        np.savez(tmp_path / "a.npz", **content)
        with pytest.raises(InputError, match=f"lacks {name}"):
            BladeCurves.load(tmp_path / "a.npz")

    @staticmethod
    def content() -> dict[str, Any]:
        curves = made()
        names = ("azimuth", "beta", "torque", "bending", "thrust")
        return {"blades": 3} | {name: getattr(curves, name) for name in names}

    @pytest.mark.parametrize(
        ("change", "message"),
        [
            ({"blades": [3, 3]}, "blades: got shape"),
            ({"mean_pitch": [0.1, 0.2]}, "mean_pitch: got shape"),
            ({"torque": np.full((6, 4), np.nan)}, "torque: got 24 NaN"),
            ({"torque": np.full((6, 4), "x")}, "torque: .*expected numbers"),
        ],
    )
    def test_npz_content_is_checked(
        self, tmp_path: Path, change: dict[str, Any], message: str
    ) -> None:
        np.savez(tmp_path / "a.npz", **(self.content() | change))
        with pytest.raises(InputError, match=message):
            BladeCurves.load(tmp_path / "a.npz")

    @pytest.mark.parametrize("change", [{"blades": "x"}, {"mean_pitch": "x"}], ids=str)
    def test_regression_npz_text_for_a_number(self, tmp_path: Path, change: dict[str, Any]) -> None:
        np.savez(tmp_path / "a.npz", **(self.content() | change))
        with pytest.raises(InputError, match=next(iter(change))):
            BladeCurves.load(tmp_path / "a.npz")

    def test_npz_without_the_optional_arrays(self, tmp_path: Path) -> None:
        np.savez(tmp_path / "a.npz", **self.content())
        assert not np.any(BladeCurves.load(tmp_path / "a.npz").rates)


@pytest.fixture
def alarm() -> Iterator[Callable[[], None]]:
    """Ends a reader that goes on for ever."""
    if not hasattr(signal, "SIGALRM"):
        pytest.skip("no alarm signal on this system")

    def late(number: int, frame: object) -> None:
        raise TimeoutError("the reader hangs")

    before = signal.signal(signal.SIGALRM, late)
    yield lambda: signal.alarm(2) and None
    signal.alarm(0)
    signal.signal(signal.SIGALRM, before)


class TestCsv:
    @staticmethod
    def lines(tmp_path: Path) -> list[str]:
        return made().save(tmp_path / "good.csv").read_text().splitlines()

    @staticmethod
    def load(tmp_path: Path, lines: list[str]) -> BladeCurves:
        path = tmp_path / "a.csv"
        path.write_text("\n".join(lines) + "\n")
        return BladeCurves.load(path)

    def test_rows_of_different_length_keep_the_curve(self, tmp_path: Path) -> None:
        lines = self.lines(tmp_path)
        gone = [line for line in lines if not line.startswith("2,")]
        gone += [line for line in lines if line.startswith("2,")][::3]  # two of four rows
        got, full = self.load(tmp_path, gone), made()
        assert got.beta.shape == full.beta.shape
        for name in CURVES:
            assert np.array_equal(getattr(got, name)[:2], getattr(full, name)[:2])
        middle = got.contributions(0.5 * (full.lower + full.upper))[0, 2]
        assert middle == pytest.approx(0.5 * (full.torque[2, 0] + full.torque[2, -1]))

    def test_columns_may_be_left_out_and_reordered(self, tmp_path: Path) -> None:
        lines = [",".join(line.split(",")[5::-1]) for line in self.lines(tmp_path)[1:]]
        got, full = self.load(tmp_path, ["# blades=3", *lines]), made()
        assert np.array_equal(got.bending, full.bending)
        assert not np.any(got.radial)

    def test_regression_stations_count_from_their_number(
        self, tmp_path: Path, alarm: Callable[[], None]
    ) -> None:
        """A station number of 1e18 once made the reader count up to it."""
        lines = self.lines(tmp_path)
        lines[-1] = "1000000000000000000" + lines[-1][1:]
        alarm()
        with pytest.raises(InputError, match="station"):
            self.load(tmp_path, lines)

    def test_regression_a_field_beyond_the_csv_limit(self, tmp_path: Path) -> None:
        lines = self.lines(tmp_path)
        lines[-1] += "1" * 200_000
        with pytest.raises(InputError):
            self.load(tmp_path, lines)

    @pytest.mark.parametrize(
        ("edit", "message"),
        [
            (lambda rows: rows[1:], "lacks the line '# blades=3'"),
            (lambda rows: rows[:1] + rows[2:], "lacks the columns"),
            (lambda rows: [rows[0], rows[1].replace("torque,", "moment,"), *rows[2:]], "torque"),
            (lambda rows: rows[:2], "lacks the columns"),
            (lambda rows: ["# blades=x", *rows[1:]], "something else than numbers"),
            (lambda rows: ["# blades=3 mean_pitch=x", *rows[1:]], "something else than numbers"),
            (lambda rows: ["# blades=3 mean_pitch=inf", *rows[1:]], "mean_pitch: got inf"),
            (lambda rows: ["# blades=0", *rows[1:]], "blades: got 0"),
            (lambda rows: [*rows[:-1], rows[-1].rsplit(",", 4)[0]], "something else than numbers"),
            (lambda rows: [*rows[:-1], rows[-1] + "e999"], "NaN or infinite"),
            (lambda rows: [*rows[:-1], rows[-1].replace("5,", "x,", 1)], "else than numbers"),
            (lambda rows: [*rows[:-1], rows[-1].replace("5,", "-1,", 1)], "station"),
            (lambda rows: [*rows[:-1], rows[-1].replace("5,", "7,", 1)], "every station"),
            (lambda rows: [*rows[:-2], rows[-1], rows[-2]], "breakpoints of station 5"),
            (lambda rows: [*rows, rows[-1]], "breakpoints of station 5"),
            (lambda rows: rows[:-4], "azimuth"),
        ],
    )
    def test_refuses(
        self, tmp_path: Path, edit: Callable[[list[str]], list[str]], message: str
    ) -> None:
        with pytest.raises(InputError, match=message):
            self.load(tmp_path, edit(self.lines(tmp_path)))
