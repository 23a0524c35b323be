"""The static plant, its winds and blade differences, and the references of a learning run."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from ilc import Plant
from pitchopt.aero.curves import BladeCurves
from pitchopt.cases import Case, OperationSettings, load_case
from pitchopt.design import Design, constant
from pitchopt.errors import InfeasibleError, InputError
from pitchopt.studies.learning import (
    BladeDifference,
    ConstantWind,
    Reference,
    SetpointSchedule,
    StaticPlant,
    WindDrift,
    WindRamp,
    WindSchedule,
    WindStep,
    WindTasks,
    reference,
)

BLADES, POSITIONS = 3, 24
STATIONS = BLADES * POSITIONS
PSI = 2 * np.pi * np.arange(STATIONS) / STATIONS
WAVE = 0.02 + 0.01 * np.cos(PSI) + 0.004 * np.sin(3 * PSI)
OTHERS = np.array([WAVE, np.roll(WAVE, 7), 0.01 - 0.5 * WAVE])
SMALL = {"limits.positions": 6, "aero.elements": 8}
LOSS = 0.07
SPACING = 0.1  # of wind speeds without induction


@pytest.fixture(scope="module")
def tasks() -> WindTasks:
    return WindTasks(case=load_case("biegel2011"))


@pytest.fixture(scope="module")
def plant(tasks: WindTasks) -> StaticPlant:
    return StaticPlant(tasks=tasks)


@pytest.fixture(scope="module")
def rated() -> WindTasks:
    """Momentum balance at every pitch, with loads due to pitch rate."""
    return WindTasks(case=load_case("nrel-5mw").with_values({**SMALL, "wind.speed": 15.0}))


@pytest.fixture(scope="module")
def held(tasks: WindTasks) -> Reference:
    return reference(tasks, max_power_loss=LOSS)


@pytest.fixture(scope="module")
def table(tmp_path_factory: pytest.TempPathFactory, rated: WindTasks) -> Case:
    path = tmp_path_factory.mktemp("table") / "curves.npz"
    rated.curves(15.0).save(path)
    operation = OperationSettings(rotor_speed=1.2)
    return load_case("nrel-5mw").with_values(
        {
            "name": "table",
            "turbine": None,
            "curves": path,
            "operation": operation,
            "objective.weights": "unit",
        }
    )


def one_by_one(
    curves: list[BladeCurves], profiles: np.ndarray, offsets: list[float], number: int
) -> np.ndarray:
    """Rotor loads from the formula, blade by blade and sample by sample."""
    blades, positions = curves[0].blades, curves[0].positions
    out = np.zeros((4, positions))
    for b in range(blades):
        own, beta = curves[b], profiles[b]
        rate = (np.roll(beta, -1) - np.roll(beta, 1)) / (2 * own.spacing)
        for k in range(positions):
            n = ((b + number) % blades) * positions + k
            knots = own.beta[n]
            j = int(np.clip(np.searchsorted(knots, beta[n] + offsets[b]) - 1, 0, knots.size - 2))
            share = (beta[n] + offsets[b] - knots[j]) / (knots[j + 1] - knots[j])
            low, high = own.loads[:4, n, j], own.loads[:4, n, j + 1]
            out[:, k] += low + share * (high - low) + own.rates[:4, n] * rate[n]
    return out


class TestOneProfile:
    @pytest.mark.parametrize("number", [0, 1, 2, 3, 7])
    def test_loads_are_those_that_design_sees(
        self, plant: StaticPlant, tasks: WindTasks, number: int
    ) -> None:
        want = tasks.case.task().problem().curves.evaluate(WAVE).rotor
        assert np.array_equal(plant.passage(WAVE, number), want)

    def test_it_is_a_plant(self, plant: StaticPlant) -> None:
        assert isinstance(plant, Plant)
        assert (plant.blades, plant.positions) == (BLADES, POSITIONS)

    def test_equilibrium(self, rated: WindTasks) -> None:
        task = rated.case.task()
        best = constant(task)
        own = task.operating_at(float(best.profile[0])).problem().curves
        assert np.any(own.rates)
        beta = np.clip(best.profile + 0.01 * np.sin(own.azimuth), own.lower, own.upper)
        got = StaticPlant(tasks=rated).passage(beta, 4)
        assert got == pytest.approx(own.evaluate(beta).rotor, rel=1e-13)

    def test_equilibrium_through_stall(self, rated: WindTasks) -> None:
        """Beyond what design admits the plant has the loads of the momentum balance."""
        best, curves = float(rated.best(15.0).profile[0]), rated.plant_curves(15.0)
        model: Any = rated.task(15.0).model
        admitted = rated.curves(15.0)
        beta = curves.beta[:, 20]  # a sample, so that nothing is interpolated
        assert np.all(beta < admitted.lower)
        exact = model.blade_loads(curves.azimuth, beta, mean_pitch=best)
        assert curves.contributions(beta)[0] == pytest.approx(exact.torque, rel=1e-12)
        assert StaticPlant(tasks=rated).outside(beta, 0) == beta.size

    def test_operating_pitch(self, rated: WindTasks) -> None:
        """The pitch that is given counts at the speeds that it is given for."""
        pitch = float(rated.best(15.0).profile[0]) + 0.02
        own = rated.task(15.0).operating_at(pitch).problem().curves
        beta = pitch + 0.013 * np.sin(own.azimuth)
        want = own.evaluate(beta).rotor
        usual = StaticPlant(tasks=rated).passage(beta, 0)
        assert not np.array_equal(usual, want)
        for given_pitch in (pitch, {15.0: pitch}):
            other = StaticPlant(tasks=rated, operating_pitch=given_pitch)
            assert np.array_equal(other.passage(beta, 0), want)
        elsewhere = StaticPlant(tasks=rated, operating_pitch={17.0: pitch})
        assert np.array_equal(elsewhere.passage(beta, 0), usual)

    def test_frozen_wake(self, rated: WindTasks) -> None:
        case = rated.case.with_values({"aero.induction": "frozen"})
        tasks = WindTasks(case=case)
        pitch = float(tasks.best(15.0).profile[0])
        beta = pitch + 0.01 * np.cos(2 * np.pi * np.arange(18) / 18)
        for given_pitch in (None, pitch + 0.01):
            at = pitch if given_pitch is None else given_pitch
            want = case.task().problem(at).curves.evaluate(beta).rotor
            got = StaticPlant(tasks=tasks, operating_pitch=given_pitch).passage(beta, 1)
            assert np.array_equal(got, want)

    def test_outside(self, plant: StaticPlant, tasks: WindTasks) -> None:
        curves = tasks.curves(15.0)
        inside = curves.upper.copy()
        assert plant.outside(inside, 0) == 0
        inside[[3, 50]] += 1e-3
        inside[10] = curves.lower[10] - 1e-3
        assert plant.outside(inside, 0) == 3
        # the last segment goes on with its slope
        more = inside.copy()
        more[3] += 1e-3
        change = plant.passage(more, 0)[:, 3] - plant.passage(inside, 0)[:, 3]
        assert change == pytest.approx(1e-3 * curves.slopes[:4, 3, -1], rel=1e-6)


class TestProfilesOfBlades:
    @pytest.mark.parametrize("number", range(4))
    @pytest.mark.parametrize(
        "difference",
        [None, BladeDifference(blade=2, pitch_offset=0.01, chord=1.05)],
        ids=["alike", "different"],
    )
    def test_formula(
        self, tasks: WindTasks, difference: BladeDifference | None, number: int
    ) -> None:
        usual = tasks.curves(15.0)
        curves, offsets = [usual] * BLADES, [0.0] * BLADES
        if difference is not None:
            curves[1], offsets[1] = tasks.curves(15.0, chord=1.05), 0.01
            assert not np.array_equal(curves[1].torque, usual.torque)
        got = StaticPlant(tasks=tasks, difference=difference).passage(OTHERS, number)
        want = one_by_one(curves, OTHERS, offsets, number)
        assert got == pytest.approx(want, rel=1e-9, abs=1e-6)

    def test_rates_of_each_blade_by_itself(self, rated: WindTasks) -> None:
        """Pitch rate is that of a blade's own profile, across the ends of its stretch."""
        curves = rated.plant_curves(15.0)
        base = float(rated.best(15.0).profile[0])
        beta = base + np.random.default_rng(3).uniform(-0.01, 0.01, (3, 18))
        for number in range(3):
            got = StaticPlant(tasks=rated).passage(beta, number)
            want = one_by_one([curves] * 3, beta, [0.0] * 3, number)
            assert got == pytest.approx(want, rel=1e-9)

    def test_the_same_profile_for_each_is_one_for_all(self, plant: StaticPlant) -> None:
        for number in range(BLADES):
            want = plant.passage(WAVE, number)
            assert np.array_equal(plant.passage(np.tile(WAVE, (BLADES, 1)), number), want)

    def test_a_rotation_visits_every_blade_and_station_once(self, plant: StaticPlant) -> None:
        """Every pitch acts in exactly one sample of a rotation, at the place of the formula."""
        base = np.array([plant.passage(OTHERS, number) for number in range(BLADES)])
        for b in range(BLADES):
            for n in (0, 5, POSITIONS, STATIONS - 1):
                changed = OTHERS.copy()
                changed[b, n] += 0.01
                moved = np.array([plant.passage(changed, number) for number in range(BLADES)])
                number, k = np.nonzero(np.any(moved != base, axis=1))
                assert (number.tolist(), k.tolist()) == (
                    [(n // POSITIONS - b) % BLADES],
                    [n % POSITIONS],
                )

    @given(number=st.integers(0, 50), turns=st.integers(1, 4))
    @settings(max_examples=25)
    def test_periodic_in_rotations(self, plant: StaticPlant, number: int, turns: int) -> None:
        later = plant.passage(OTHERS, number + turns * BLADES)
        assert np.array_equal(plant.passage(OTHERS, number), later)

    @given(number=st.integers(0, 20), by=st.integers(1, 2))
    @settings(max_examples=25)
    def test_profiles_handed_on_to_the_next_blade(
        self, plant: StaticPlant, number: int, by: int
    ) -> None:
        """Blades are alike: giving each the next one's profile is turning by one passage less."""
        handed = np.roll(OTHERS, -by, axis=0)
        assert np.array_equal(plant.passage(handed, number + by), plant.passage(OTHERS, number))


class TestDifferentBlade:
    @pytest.mark.parametrize("profile", [WAVE, OTHERS], ids=["one", "each"])
    def test_none_is_none(self, tasks: WindTasks, plant: StaticPlant, profile: np.ndarray) -> None:
        same = StaticPlant(tasks=tasks, difference=BladeDifference(blade=3))
        for number in range(3):
            assert np.array_equal(same.passage(profile, number), plant.passage(profile, number))

    @pytest.mark.parametrize("blade", [1, 2, 3])
    def test_an_offset_is_a_shift_of_that_blades_profile(
        self, tasks: WindTasks, plant: StaticPlant, blade: int
    ) -> None:
        off = StaticPlant(tasks=tasks, difference=BladeDifference(blade=blade, pitch_offset=0.007))
        shifted = OTHERS.copy()
        shifted[blade - 1] += 0.007
        for number in range(4):
            want = plant.passage(shifted, number)
            assert off.passage(OTHERS, number) == pytest.approx(want, rel=1e-10)

    def test_chord_without_induction_scales_the_loads(self, tasks: WindTasks) -> None:
        usual, wide = tasks.curves(15.0), tasks.curves(15.0, chord=1.1)
        assert wide.loads[0] == pytest.approx(1.1 * usual.loads[0], rel=1e-9)
        plain = StaticPlant(tasks=tasks).passage(WAVE, 1)
        got = StaticPlant(tasks=tasks, difference=BladeDifference(blade=3, chord=1.1)).passage(
            WAVE, 1
        )
        section = slice(0, POSITIONS)  # blade 3 stands there in passage 1
        more = 0.1 * usual.contributions(WAVE)[:4, section]
        assert got == pytest.approx(plain + more, rel=1e-9)

    def test_chord_with_induction_meets_its_own_balance(self, rated: WindTasks) -> None:
        pitch = float(rated.best(15.0).profile[0])
        usual, wide = (
            rated.curves(15.0, operating_pitch=pitch, chord=c).contributions(np.full(18, pitch))
            for c in (1.0, 1.1)
        )
        ratio = wide[3] / usual[3]
        assert np.all(ratio > 1.0) and np.all(ratio < 1.1)

    def test_outside_is_that_of_the_blade(self, tasks: WindTasks, plant: StaticPlant) -> None:
        beta = tasks.curves(15.0).upper - 0.005
        off = StaticPlant(tasks=tasks, difference=BladeDifference(blade=1, pitch_offset=0.01))
        assert (plant.outside(beta, 2), off.outside(beta, 2)) == (0, POSITIONS)

    @pytest.mark.parametrize(
        ("values", "message"),
        [
            ({"blade": 0}, "different blade: got 0"),
            ({"blade": 1.5}, "different blade: got 1.5"),
            ({"pitch_offset": np.nan}, "pitch_offset: got nan"),
            ({"chord": 0.0}, "chord: got 0"),
        ],
    )
    def test_refused(self, values: dict[str, Any], message: str) -> None:
        with pytest.raises(InputError, match=message):
            BladeDifference(**values)

    def test_refused_blade_that_is_not_there(self, tasks: WindTasks) -> None:
        with pytest.raises(InputError, match="different blade: got 4, expected 1 to 3"):
            StaticPlant(tasks=tasks, difference=BladeDifference(blade=4))


class TestWind:
    def test_protocol(self) -> None:
        winds = [
            ConstantWind(speed=9.0),
            WindStep(speed=9.0, change=1.0, rotation=2),
            WindRamp(speed=9.0, change=1.0, first=1, last=3),
            WindDrift(speed=9.0, std=0.5, rotations_correlation=5),
        ]
        assert all(isinstance(wind, WindSchedule) for wind in winds)
        assert [wind.at(-3.0) for wind in winds] == [9.0] * 4

    def test_step(self) -> None:
        step = WindStep(speed=15.0, change=2.0, rotation=22)
        assert step.levels == (15.0, 17.0)
        assert [step.at(r) for r in (0, 21, 65 / 3, 22, 66 / 3, 100)] == [15] * 3 + [17] * 3

    def test_ramp(self) -> None:
        ramp = WindRamp(speed=15.0, change=-2.0, first=10, last=14)
        got = [ramp.at(r) for r in (0, 10, 11, 13, 14, 90)]
        assert got == pytest.approx([15, 15, 14.5, 13.5, 13, 13])

    def test_drift_is_a_function_of_rotation(self) -> None:
        early = WindDrift(speed=15.0, std=0.8, rotations_correlation=20, seed=5)
        order = [early.at(r) for r in (3, 1500, 7.5, 3)]
        late = WindDrift(speed=15.0, std=0.8, rotations_correlation=20, seed=5)
        assert [late.at(r) for r in (1500, 7.5, 3)] == [order[1], order[2], order[0]]
        assert order[3] == order[0]
        assert late.at(7.5) == pytest.approx((late.at(7) + late.at(8)) / 2)
        other = WindDrift(speed=15.0, std=0.8, rotations_correlation=20, seed=6)
        assert other.at(3) != late.at(3)

    def test_drift_statistics(self) -> None:
        wind = WindDrift(speed=15.0, std=0.8, rotations_correlation=10, seed=1)
        x = np.array([wind.at(r) for r in range(20_000)]) - 15.0
        # 20 000 rotations hold about 1000 independent samples
        assert x.std() == pytest.approx(0.8, rel=0.1)
        assert abs(x.mean()) < 0.1
        correlation = np.mean(x[:-10] * x[10:]) / x.var()
        assert correlation == pytest.approx(np.exp(-1), abs=0.1)
        assert np.abs(x).max() <= 3 * 0.8 * (1 + 1e-12)

    @pytest.mark.parametrize(
        ("make", "message"),
        [
            (lambda: ConstantWind(speed=0.0), "wind speed: got 0"),
            (lambda: WindStep(speed=5.0, change=-5.0, rotation=1), "wind change: got -5"),
            (lambda: WindStep(speed=5.0, change=1.0, rotation=-1), "wind step rotation: got -1"),
            (lambda: WindRamp(speed=5.0, change=1.0, first=4, last=4), "wind ramp last: got 4"),
            (
                lambda: WindDrift(speed=5.0, std=1.1, rotations_correlation=4),
                "wind drift std: got 1.1",
            ),
            (
                lambda: WindDrift(speed=5.0, std=0.1, rotations_correlation=0),
                "wind drift rotations_correlation: got 0",
            ),
        ],
    )
    def test_refused(self, make: Any, message: str) -> None:
        with pytest.raises(InputError, match=message):
            make()


class TestPlantInWind:
    def exact(self, tasks: WindTasks, speed: float, profile: np.ndarray) -> np.ndarray:
        case = tasks.case.with_values({"wind.speed": speed})
        return case.task().problem().curves.evaluate(profile).rotor

    def test_step_counts_from_the_offset(self, tasks: WindTasks) -> None:
        step = WindStep(speed=15.0, change=2.0, rotation=4)
        plant = StaticPlant(tasks=tasks, wind=step, offset=9)
        last = 9 + 4 * BLADES - 1
        assert [plant.wind_speed(j) for j in (0, last, last + 1)] == [15.0, 15.0, 17.0]
        for number, speed in ((last, 15.0), (last + 1, 17.0)):
            want = self.exact(tasks, speed, WAVE)
            assert np.array_equal(plant.passage(WAVE, number), want)

    def test_ramp_between_grid_speeds(self, tasks: WindTasks) -> None:
        ramp = WindRamp(speed=15.0, change=1.0, first=0, last=10)
        plant = StaticPlant(tasks=tasks, wind=ramp)
        ends = [self.exact(tasks, 15.0 + SPACING * i, WAVE) for i in range(2)]
        assert np.array_equal(plant.passage(WAVE, 0), ends[0])
        assert plant.passage(WAVE, 1) == pytest.approx((2 * ends[0] + ends[1]) / 3, rel=1e-9)
        assert plant.passage(WAVE, 3) == pytest.approx(ends[1], rel=1e-9)

    def test_interpolation_error(self, tasks: WindTasks) -> None:
        """What the docstring of the plant says of it."""
        beta = tasks.best(15.0).profile
        loads = tasks.best(15.0).loads
        middle = 15.0 + SPACING / 2
        ramp = WindRamp(speed=15.0, change=SPACING, first=0, last=2 / 3)
        plant = StaticPlant(tasks=tasks, wind=ramp)
        assert plant.wind_speed(1) == pytest.approx(middle)
        error = plant.passage(beta, 1) - self.exact(tasks, middle, beta)
        assert 0 < np.max(np.abs(error).max(axis=1) / loads.rms) < 0.025
        assert np.max(np.abs(error.mean(axis=1))[[0, 3]] / loads.mean[[0, 3]]) < 1e-4

    def test_spacing(self, tasks: WindTasks, rated: WindTasks) -> None:
        assert (tasks.spacing, rated.spacing) == (SPACING, 0.25)

    def test_ramp_with_induction(self, rated: WindTasks) -> None:
        ramp = WindRamp(speed=15.0, change=0.25, first=0, last=1)
        plant = StaticPlant(tasks=rated, wind=ramp)
        beta = rated.best(15.0).profile
        low, high = (
            StaticPlant(tasks=rated, wind=ConstantWind(speed=v)).passage(beta, 0)
            for v in (15.0, 15.25)
        )
        assert plant.passage(beta, 1) == pytest.approx((2 * low + high) / 3, rel=1e-9)

    def test_a_table_holds_for_one_wind(self, table: Case) -> None:
        tasks = WindTasks(case=table)
        plant = StaticPlant(tasks=tasks)
        beta = 0.1 + np.zeros(18)
        want = table.task().problem().curves.evaluate(beta).rotor
        assert np.array_equal(plant.passage(beta, 2), want)
        with pytest.raises(InputError, match=r"wind speed: got 10 m/s, expected 8 m/s: the table"):
            StaticPlant(tasks=tasks, wind=WindStep(speed=8.0, change=2.0, rotation=1))
        with pytest.raises(InputError, match=r"chord: got a factor of 1.1, expected 1"):
            StaticPlant(tasks=tasks, difference=BladeDifference(chord=1.1))

    def test_a_disc_file_holds_for_one_wind(self, tmp_path: Path) -> None:
        case = load_case("biegel2011").with_values({"wind.disc": tmp_path / "absent.csv"})
        with pytest.raises(InputError, match="the disc file of the case 'biegel2011' holds"):
            WindTasks(case=case).task(16.0)

    @pytest.mark.parametrize(
        ("profile", "number", "message"),
        [
            (np.zeros(STATIONS - 1), 0, r"profile: got shape \(71,\), expected \(72,\) or"),
            (np.zeros((2, STATIONS)), 0, r"profile: got shape \(2, 72\)"),
            (np.full(STATIONS, np.nan), 0, "profile: got 72 NaN"),
            (WAVE, -1, "number: got -1"),
        ],
    )
    def test_refused(
        self, plant: StaticPlant, profile: np.ndarray, number: int, message: str
    ) -> None:
        with pytest.raises(InputError, match=message):
            plant.passage(profile, number)

    def test_refused_offset(self, tasks: WindTasks) -> None:
        with pytest.raises(InputError, match="offset: got -1"):
            StaticPlant(tasks=tasks, offset=-1)


def gives(design: Design, torque: float) -> bool:
    return design.mean_torque == pytest.approx(torque, rel=1e-6)


class TestReference:
    def test_setpoint_is_a_share_of_the_largest_torque(
        self, tasks: WindTasks, held: Reference
    ) -> None:
        assert held.wind_speed == 15.0
        assert held.setpoint == (1 - LOSS) * tasks.power_max(15.0).mean_torque
        assert gives(held.constant, held.setpoint)
        assert gives(held.design, held.setpoint)
        assert held.best.mean_torque > held.setpoint

    @pytest.mark.parametrize("loss", [0.02, 0.07])
    def test_of_two_constant_pitches_the_one_on_the_side_of_the_design(
        self, tasks: WindTasks, loss: float
    ) -> None:
        found = reference(tasks, max_power_loss=loss)
        best = found.best.profile[0]
        assert (found.start_pitch < best) == (found.design.profile.mean() < best)
        assert found.start_pitch != best

    def test_towards_stall(self, held: Reference) -> None:
        assert held.start_pitch < held.best.profile[0]
        assert held.constant.rms_weighted < held.best.rms_weighted
        assert held.design.rms_weighted < 0.02 * held.constant.rms_weighted

    @pytest.mark.slow
    def test_towards_feather(self, rated: WindTasks) -> None:
        """Here stall limits leave no constant pitch of that torque towards stall."""
        found = reference(rated, max_power_loss=LOSS)
        assert gives(found.constant, found.setpoint)
        assert found.start_pitch > found.best.profile[0]

    def test_the_plant_gives_the_loads_of_the_references(self, rated: WindTasks) -> None:
        found = reference(rated, mean_torque=0.9 * rated.best(15.0).mean_torque)
        plant = StaticPlant(tasks=rated, operating_pitch={15.0: found.operating_pitch})
        got = plant.passage(found.design.profile, 1)
        assert got == pytest.approx(found.design.loads.rotor, rel=1e-12)
        start = plant.passage(np.full(18, found.start_pitch), 0)
        assert start == pytest.approx(found.start_loads, rel=1e-12)

    def test_explicit_torque(self, tasks: WindTasks) -> None:
        found = reference(tasks, 17.0, mean_torque=1.3e6)
        assert (found.wind_speed, found.setpoint) == (17.0, 1.3e6)
        assert gives(found.constant, 1.3e6)
        assert gives(found.design, 1.3e6)
        assert found.design.rms_weighted < found.constant.rms_weighted

    def test_more_than_any_constant_pitch_gives(self, tasks: WindTasks) -> None:
        best, power = tasks.best(15.0), tasks.power_max(15.0)
        want = 0.5 * (best.mean_torque + power.mean_torque)
        found = reference(tasks, mean_torque=want)
        assert found.start_pitch == best.profile[0]
        assert gives(found.design, want)

    def test_no_cap_on_what_the_plant_does_not_measure(self, rated: WindTasks) -> None:
        assert rated.case.objective.blade_cap == 1.0
        assert rated.task(15.0).blade_cap is None
        harmonic = rated.case.with_values({"objective.harmonics": 2})
        assert WindTasks(case=harmonic).task(15.0).harmonics == 2

    @pytest.mark.parametrize(
        ("goals", "message"),
        [
            ({}, "set-point: got none"),
            ({"max_power_loss": 0.1, "mean_torque": 1e6}, "set-point: got both"),
            ({"max_power_loss": 1.1}, "max_power_loss: got 1.1"),
            ({"mean_torque": np.inf}, "mean_torque: got inf"),
        ],
    )
    def test_refused(self, tasks: WindTasks, goals: dict[str, float], message: str) -> None:
        with pytest.raises(InputError, match=message):
            reference(tasks, **goals)
        with pytest.raises(InputError, match=message):
            SetpointSchedule(tasks=tasks, wind=ConstantWind(speed=15.0), **goals)

    def test_out_of_reach(self, tasks: WindTasks) -> None:
        with pytest.raises(InfeasibleError, match="mean torque: got 1e\\+09"):
            reference(tasks, mean_torque=1e9)


class TestSetpointSchedule:
    def test_step(self, tasks: WindTasks, held: Reference) -> None:
        wind = WindStep(speed=15.0, change=2.0, rotation=22)
        schedule = SetpointSchedule(tasks=tasks, wind=wind, max_power_loss=LOSS)
        assert schedule.at(-2) == schedule.at(21) == held.setpoint
        after = (1 - LOSS) * tasks.power_max(17.0).mean_torque
        assert schedule.at(22) == schedule.of_wind(17.0) == after
        assert after > held.setpoint

    def test_explicit_torque_stays(self, tasks: WindTasks) -> None:
        wind = WindRamp(speed=15.0, change=2.0, first=2, last=7)
        schedule = SetpointSchedule(tasks=tasks, wind=wind, mean_torque=1.2e6)
        assert [schedule.at(r) for r in (0, 3.3, 9)] == [1.2e6] * 3

    def test_ramp_between_grid_speeds(self, tasks: WindTasks) -> None:
        wind = WindRamp(speed=15.0, change=SPACING, first=0, last=4)
        schedule = SetpointSchedule(tasks=tasks, wind=wind, max_power_loss=LOSS)
        low, high = ((1 - LOSS) * tasks.power_max(v).mean_torque for v in (15.0, 15.0 + SPACING))
        assert schedule.at(1) == pytest.approx(0.75 * low + 0.25 * high, rel=1e-12)
        exact = (1 - LOSS) * tasks.power_max(15.0 + SPACING / 4).mean_torque
        assert schedule.at(1) == pytest.approx(exact, rel=1e-4)
