"""StaticRotor: curves, limits, rates and invariances in all three modes."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from pitchopt.aero import BladeCurves, Polar, Rotor, StaticRotor
from pitchopt.aero.steady import UniformInflow
from pitchopt.errors import InputError
from pitchopt.turbines import load_turbine
from windfield import StaticField

OMEGA = 12.1 * np.pi / 30.0
MEAN = float(np.deg2rad(10.45))

Maker = Callable[..., StaticField]


def random_profile(curves: BladeCurves, seed: int = 0) -> np.ndarray:
    rng = np.random.default_rng(seed)
    return np.asarray(curves.lower + (curves.upper - curves.lower) * rng.random(curves.stations))


@pytest.fixture(scope="module")
def frozen(nrel: Rotor, wind: Maker) -> StaticRotor:
    return StaticRotor(
        rotor=nrel, wind=wind(15.0, tower=True), rotor_speed=OMEGA, induction="frozen"
    )


@pytest.fixture(scope="module")
def frozen_curves(frozen: StaticRotor) -> BladeCurves:
    return frozen.curves(24, mean_pitch=MEAN)


@pytest.fixture(scope="module")
def balanced(nrel: Rotor, wind: Maker) -> StaticRotor:
    return StaticRotor(
        rotor=nrel, wind=wind(15.0, tower=True), rotor_speed=OMEGA, induction="equilibrium"
    )


class TestNone:
    @pytest.mark.parametrize("elements", [1, 2, 9])
    def test_curves_are_exact(self, paper: Callable[..., StaticRotor], elements: int) -> None:
        model = paper(elements)
        curves = model.curves(24)
        assert curves.stations == 72
        assert curves.mean_pitch is None
        for seed in range(3):
            pitch = random_profile(curves, seed)
            direct = model.blade_loads(curves.azimuth, pitch)
            got = curves.contributions(pitch)
            for row, load in ((0, direct.torque), (3, direct.thrust), (4, direct.bending)):
                np.testing.assert_allclose(got[row], load, atol=1e-9 * np.abs(load).max())

    def test_concave_torque(self, paper: Callable[..., StaticRotor]) -> None:
        assert paper(2).curves(24).concave

    def test_breakpoints_are_the_knots(self, paper: Callable[..., StaticRotor]) -> None:
        model = paper(2)
        curves = model.curves(8)
        low, high = model.pitch_limits(curves.azimuth)
        np.testing.assert_allclose(curves.lower, low, atol=1e-12)
        np.testing.assert_allclose(curves.upper, high, atol=1e-12)
        # images of all knots of both elements
        fits = model.section_fits()
        for n, psi in enumerate(curves.azimuth):
            height = 80.0 + np.array([16.0, 32.0]) * np.cos(psi)
            y = -np.array([16.0, 32.0]) * np.sin(psi)
            free = model.wind.velocity(np.full(2, -5.5), y, height)
            lateral = free[:, 1] * np.cos(psi)
            phi = np.arctan2(free[:, 0], 2.0 * np.array([16.0, 32.0]) + lateral)
            for e, fit in enumerate(fits):
                assert fit is not None
                images = phi[e] - model.rotor.blade.twist[e] - fit.alpha
                inside = images[(images > low[n] + 1e-7) & (images < high[n] - 1e-7)]
                distance = np.abs(curves.beta[n][None, :] - inside[:, None]).min(axis=1)
                assert distance.max() < 1.1e-8

    def test_no_element_stalls(self, paper: Callable[..., StaticRotor], outboard: Polar) -> None:
        model = paper(3)
        curves = model.curves(8)
        stall = outboard.stall_angle()
        touched = 0
        for pitch in (curves.lower, curves.upper):
            spare = []
            for e in range(3):
                radius = 8.0 + 32.0 * (e + 0.5) / 3
                place = np.full(curves.stations, -5.5)
                psi = curves.azimuth
                free = model.wind.velocity(
                    place, -radius * np.sin(psi), 80.0 + radius * np.cos(psi)
                )
                phi = np.arctan2(free[:, 0], 2.0 * radius + free[:, 1] * np.cos(psi))
                spare.append(phi - model.rotor.blade.twist[e] - pitch)
            alpha = np.array(spare)
            assert alpha.max() <= stall + 1e-9
            assert alpha.min() >= np.deg2rad(-5.0) - 1e-9
            edge = np.minimum(stall - alpha, alpha - np.deg2rad(-5.0)).min(axis=0)
            touched += int(np.sum(np.abs(edge) < 1e-9))
        assert touched == 2 * curves.stations

    def test_loads_by_hand(self, paper_rotor: Callable[[int], Rotor]) -> None:
        """One element, uniform wind: the formulas of the blade element."""
        rotor = paper_rotor(1)
        model = StaticRotor(
            rotor=rotor,
            wind=UniformInflow(15.0),
            rotor_speed=2.0,
            alpha_limits=(-0.08, 0.2),
            segments=30,
        )
        pitch, radius = 0.05, 24.0
        phi = np.arctan2(15.0, 2.0 * radius)
        fit = model.section_fits()[0]
        assert fit is not None
        cl, cd, _ = fit.coefficients(phi - rotor.blade.twist[0] - pitch)
        force = 0.5 * 1.225 * (15.0**2 + (2.0 * radius) ** 2) * 0.96 * 32.0
        loads = model.blade_loads(0.3, pitch)
        normal = force * (cl * np.cos(phi) + cd * np.sin(phi))
        driving = force * (cl * np.sin(phi) - cd * np.cos(phi))
        assert loads.thrust == pytest.approx(normal)
        assert loads.bending == pytest.approx(normal * radius)
        assert loads.torque == pytest.approx(driving * radius)

    def test_rates_and_radial_off(self, paper: Callable[..., StaticRotor]) -> None:
        curves = paper(2).curves(8)
        assert not curves.rates.any()
        assert curves.radial is not None
        assert not curves.radial.any()

    def test_empty_range_is_an_error(self, paper: Callable[..., StaticRotor]) -> None:
        model = paper(2)
        narrow = StaticRotor(
            rotor=model.rotor,
            wind=model.wind,
            rotor_speed=2.0,
            pitch_range=(0.4, 0.6),
            alpha_limits=(-0.05, None),
        )
        with pytest.raises(InputError, match="no pitch is left"):
            narrow.curves(24)

    def test_cylinder_needs_limits(self, nrel: Rotor) -> None:
        model = StaticRotor(rotor=nrel, wind=UniformInflow(10.0), rotor_speed=1.0)
        with pytest.raises(InputError, match="attached"):
            model.curves(4)

    @settings(max_examples=10)
    @given(st.floats(0.0, 2 * np.pi), st.floats(-0.05, 0.15))
    def test_uniform_wind_has_no_azimuth(
        self, paper: Callable[..., StaticRotor], psi: float, pitch: float
    ) -> None:
        model = paper(2)
        even = StaticRotor(rotor=model.rotor, wind=UniformInflow(15.0), rotor_speed=2.0)
        first = np.array(even.blade_loads(0.0, pitch))
        np.testing.assert_allclose(np.array(even.blade_loads(psi, pitch)), first, rtol=1e-12)

    @settings(max_examples=10)
    @given(st.floats(0.5, 2.0))
    def test_speeds_scale(self, paper: Callable[..., StaticRotor], factor: float) -> None:
        """Wind and rotor speed times k: loads times k squared; density: loads in proportion."""
        rotor = paper(2).rotor
        psi, pitch = np.linspace(0.0, 5.0, 6), 0.03
        one = StaticRotor(rotor=rotor, wind=UniformInflow(15.0), rotor_speed=2.0)
        two = StaticRotor(
            rotor=rotor,
            wind=UniformInflow(15.0 * factor),
            rotor_speed=2.0 * factor,
            air_density=1.225 / factor,
        )
        np.testing.assert_allclose(
            np.array(two.blade_loads(psi, pitch)),
            factor * np.array(one.blade_loads(psi, pitch)),
            rtol=1e-10,
        )


class TestFrozen:
    def test_curves_are_exact(self, frozen: StaticRotor, frozen_curves: BladeCurves) -> None:
        for seed in range(3):
            pitch = random_profile(frozen_curves, seed)
            direct = frozen.blade_loads(frozen_curves.azimuth, pitch, mean_pitch=MEAN)
            got = frozen_curves.contributions(pitch)
            for row, load in ((0, direct.torque), (3, direct.thrust), (4, direct.bending)):
                np.testing.assert_allclose(got[row], load, atol=1e-9 * np.abs(load).max())

    def test_concave_and_contains_the_mean(self, frozen_curves: BladeCurves) -> None:
        assert frozen_curves.concave
        assert frozen_curves.mean_pitch == MEAN
        assert frozen_curves.lower.max() < MEAN < frozen_curves.upper.min()

    @pytest.mark.parametrize(
        ("speed", "rpm", "pitch_deg"), [(8.0, 9.2, 0.0), (12.0, 12.1, 3.8), (18.0, 12.1, 14.9)]
    )
    def test_equals_equilibrium_at_the_mean(
        self, nrel: Rotor, wind: Maker, speed: float, rpm: float, pitch_deg: float
    ) -> None:
        mean = float(np.deg2rad(pitch_deg))
        common: dict[str, Any] = {
            "rotor": nrel,
            "wind": wind(speed, tower=True),
            "rotor_speed": rpm * np.pi / 30.0,
        }
        curves = StaticRotor(induction="frozen", **common).curves(12, mean_pitch=mean)
        truth = StaticRotor(induction="equilibrium", **common).blade_loads(curves.azimuth, mean)
        got = curves.contributions(np.full(curves.stations, mean))
        np.testing.assert_allclose(got[0], truth.torque, rtol=1e-8)
        np.testing.assert_allclose(got[3], truth.thrust, rtol=1e-8)
        np.testing.assert_allclose(got[4], truth.bending, rtol=1e-8)

    def test_errors_are_small_and_reported(self, frozen: StaticRotor) -> None:
        errors = frozen.frozen_errors(24, MEAN)
        assert errors.fit.max() < 0.03
        assert errors.projection.max() < 2e-3
        assert errors.fit.min() > 0.0
        assert errors.projection.min() > 0.0

    def test_sections(self, frozen: StaticRotor) -> None:
        """Cylinders, the stalled root and the fully blocked tip are linear, the rest fitted."""
        fitted = [fit is not None for fit in frozen.section_fits(24, MEAN)]
        assert fitted == [False] * 4 + [True] * 14 + [False]

    def test_blocked_tip_does_not_limit_pitch(self, wind: Maker) -> None:
        """The tip node of a 15 MW rotor has no inflow angle; its own would cost five degrees."""
        turbine = load_turbine("iea-15-240")
        model = StaticRotor(
            rotor=turbine.rotor,
            wind=wind(15.0),
            rotor_speed=7.56 * np.pi / 30.0,
            induction="frozen",
            pitch_range=(-0.1, 0.9),
        )
        mean = float(np.deg2rad(11.5))
        assert model.section_fits(8, mean)[-1] is None
        assert model.section_fits(8, mean)[-2] is not None
        low, high = model.pitch_limits(np.linspace(0.0, 6.0, 12), mean)
        assert low.max() < mean - np.deg2rad(5.0)
        assert high.min() > mean + np.deg2rad(5.0)

    def test_stall_share(self, nrel: Rotor, wind: Maker) -> None:
        """All attached sections restrict pitch at share 0, none beyond the tip."""
        widths = []
        for share in (0.0, 0.3, 1.1):
            model = StaticRotor(
                rotor=nrel,
                wind=wind(15.0),
                rotor_speed=OMEGA,
                induction="frozen",
                pitch_range=(-0.2, 0.6),
                stall_share=share,
            )
            low, high = model.pitch_limits(np.linspace(0.0, 6.0, 12), MEAN)
            widths.append(float((high - low).min()))
        assert widths[0] <= widths[1] < widths[2]
        assert widths[2] == pytest.approx(0.8)

    def test_rates_are_derivatives(self, frozen: StaticRotor, frozen_curves: BladeCurves) -> None:
        psi = frozen_curves.azimuth
        step = 0.01
        up = np.array(frozen.blade_loads(psi, MEAN, step, mean_pitch=MEAN))
        down = np.array(frozen.blade_loads(psi, MEAN, -step, mean_pitch=MEAN))
        slope = (up - down) / (2 * step) * OMEGA
        assert frozen_curves.thrust_rate is not None
        np.testing.assert_allclose(frozen_curves.rates[0], slope[0], rtol=0.02)
        np.testing.assert_allclose(frozen_curves.thrust_rate, slope[3], rtol=0.02)
        # sections behind the pitch axis move downwind at positive pitch rate: about 10 kN s/rad
        assert 5e3 < np.abs(frozen_curves.thrust_rate / OMEGA).mean() < 2e4

    @pytest.mark.parametrize(("mean", "word"), [(None, "mean_pitch"), (3.0, "mean_pitch")])
    def test_needs_a_mean_pitch(self, frozen: StaticRotor, mean: float | None, word: str) -> None:
        with pytest.raises(InputError, match=word):
            frozen.curves(4, mean_pitch=mean)
        with pytest.raises(InputError, match=word):
            frozen.blade_loads(0.0, 0.1, mean_pitch=mean)


class TestEquilibrium:
    def test_sampling_error(self, balanced: StaticRotor) -> None:
        curves = balanced.curves(8, mean_pitch=MEAN)
        assert curves.beta.shape[1] >= 121
        assert curves.mean_pitch is None
        pitch = random_profile(curves)
        direct = balanced.blade_loads(curves.azimuth, pitch, mean_pitch=MEAN)
        got = curves.contributions(pitch)
        for row, load in ((0, direct.torque), (3, direct.thrust), (4, direct.bending)):
            assert np.abs(got[row] - load).max() < 1e-3 * np.ptp(curves.loads[row])

    def test_pitch_interval(self, balanced: StaticRotor) -> None:
        """Without a mean pitch the actuator's range, with one the attached part of it."""
        whole = balanced.curves(2)
        assert whole.lower.tolist() == [balanced.pitch_range[0]] * 6
        part = balanced.curves(2, mean_pitch=MEAN)
        assert np.all(part.lower > whole.lower)
        assert np.all(part.upper < whole.upper)

    def test_energy(self, nrel: Rotor) -> None:
        """Power is what the wind loses: torque omega below thrust times the wind speed."""
        model = StaticRotor(
            rotor=nrel, wind=UniformInflow(9.0), rotor_speed=1.1, induction="equilibrium"
        )
        loads = model.blade_loads(np.linspace(0.0, 6.0, 12), 0.0)
        assert np.all(loads.torque * 1.1 < loads.thrust * 9.0)
        assert np.all(loads.torque > 0.0)

    def test_tilt_and_yaw_are_one_rotation(self, nrel: Rotor) -> None:
        """A quarter turn: yawing a rotor without tilt is tilting it, seen at psi + 90 deg."""
        angle = 0.12
        flat: dict[str, Any] = {"blade": nrel.blade, "hub_radius": 1.5, "hub_height": 90.0}
        tilted = StaticRotor(
            rotor=Rotor(tilt=angle, **flat),
            wind=UniformInflow(11.0),
            rotor_speed=OMEGA,
            induction="equilibrium",
        )
        yawed = StaticRotor(
            rotor=Rotor(**flat),
            wind=UniformInflow(11.0),
            rotor_speed=OMEGA,
            yaw=angle,
            induction="equilibrium",
        )
        psi = np.linspace(0.0, 6.0, 13)
        # tilt sends the wind across the disc towards blade-up, positive yaw towards psi = 90 deg
        np.testing.assert_allclose(
            np.array(yawed.blade_loads(psi + np.pi / 2, 0.05)),
            np.array(tilted.blade_loads(psi, 0.05)),
            rtol=1e-9,
        )

    @settings(max_examples=8)
    @given(st.floats(0.0, 2 * np.pi), st.floats(0.02, 0.2))
    def test_azimuth_shift(self, nrel: Rotor, psi: float, pitch: float) -> None:
        rotor = Rotor(blade=nrel.blade, hub_radius=1.5, cone=0.04, hub_height=90.0)
        model = StaticRotor(
            rotor=rotor, wind=UniformInflow(12.0), rotor_speed=OMEGA, induction="equilibrium"
        )
        np.testing.assert_allclose(
            np.array(model.blade_loads(psi, pitch)),
            np.array(model.blade_loads(0.0, pitch)),
            rtol=1e-9,
        )

    def test_length_units(self, nrel: Rotor) -> None:
        """Doubling all lengths at equal tip-speed ratio: forces times 4, moments times 8."""
        blade = nrel.blade
        prebend, sweep = blade.offsets
        double = type(blade)(
            span=2 * blade.span,
            chord=2 * blade.chord,
            twist=blade.twist,
            polars=blade.polars,
            prebend=2 * prebend,
            sweep=2 * sweep,
        )
        results = []
        for scale, one in ((1.0, blade), (2.0, double)):
            rotor = Rotor(
                blade=one, hub_radius=1.5 * scale, tilt=0.09, cone=0.04, hub_height=90.0 * scale
            )
            model = StaticRotor(
                rotor=rotor,
                wind=UniformInflow(12.0),
                rotor_speed=OMEGA / scale,
                induction="equilibrium",
            )
            results.append(np.array(model.blade_loads(np.linspace(0.0, 6.0, 7), 0.07)))
        np.testing.assert_allclose(results[1][:3], 8 * results[0][:3], rtol=1e-9)
        np.testing.assert_allclose(results[1][3], 4 * results[0][3], rtol=1e-9)


class TestMirror:
    def test_mirrored_shear(self, paper: Callable[..., StaticRotor]) -> None:
        """Without swirl of the loads a mirrored wind gives mirrored loads at mirrored azimuth."""
        rotor = paper(2).rotor
        psi = 2 * np.pi * np.arange(24) / 24
        loads = {}
        for sign in (1.0, -1.0):
            field = StaticField(speed=15.0, hub_height=80.0, horizontal_shear=sign * 3e-3)
            model = StaticRotor(rotor=rotor, wind=field, rotor_speed=2.0)
            loads[sign] = model.blade_loads(sign * psi, 0.02)
        yaw = {k: (v.bending * np.sin(k * psi)).sum() for k, v in loads.items()}
        tilt = {k: (v.bending * np.cos(k * psi)).sum() for k, v in loads.items()}
        assert yaw[1.0] == pytest.approx(-yaw[-1.0])
        assert abs(yaw[1.0]) > 1e4
        assert tilt[1.0] == pytest.approx(tilt[-1.0])
        np.testing.assert_allclose(loads[1.0].torque, loads[-1.0].torque, rtol=1e-12)


class TestInput:
    @pytest.mark.parametrize(
        ("change", "word"),
        [
            ({"rotor_speed": 0.0}, "rotor_speed"),
            ({"air_density": -1.0}, "air_density"),
            ({"yaw": np.nan}, "yaw"),
            ({"induction": "magic"}, "induction"),
            ({"pitch_range": (0.2, 0.1)}, "pitch_range"),
            ({"alpha_limits": (0.2, 0.1)}, "alpha_limits"),
            ({"segments": 0}, "segments"),
            ({"samples": 1}, "samples"),
            ({"stall_share": -0.1}, "stall_share"),
        ],
    )
    def test_bad_settings(
        self, paper: Callable[..., StaticRotor], change: dict[str, Any], word: str
    ) -> None:
        model = paper(2)
        values: dict[str, Any] = {"rotor": model.rotor, "wind": model.wind, "rotor_speed": 2.0}
        with pytest.raises(InputError, match=word):
            StaticRotor(**{**values, **change})

    @pytest.mark.parametrize("positions", [0, -3, 1.5, True])
    def test_bad_positions(self, paper: Callable[..., StaticRotor], positions: Any) -> None:
        with pytest.raises(InputError, match="positions"):
            paper(2).curves(positions)
