"""Learning runs on the static rotor: figures from the record, references, checkpoints, input."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from pitchopt.cases import Case, load_case
from pitchopt.errors import InfeasibleError, InputError
from pitchopt.exports.records import plain
from pitchopt.studies.learning import (
    BladeDifference,
    ConstantWind,
    LearningResult,
    LearningSettings,
    SetpointSchedule,
    StaticPlant,
    WindDrift,
    WindRamp,
    WindStep,
    WindTasks,
    learn,
    learning_document,
    reference,
)

STEP = WindStep(speed=15.0, change=2.0, rotation=12)
BLADES = 3


@pytest.fixture(scope="module")
def case() -> Case:
    return load_case("biegel2011").with_values({"limits.positions": 12, "aero.segments": 10})


@pytest.fixture(scope="module")
def stepped(case: Case) -> LearningResult:
    return learn(case, LearningSettings(rotations=24, wind=STEP, noise=0.01, seed=3))


@pytest.fixture(scope="module")
def fixed(case: Case) -> LearningResult:
    return learn(case, LearningSettings(rotations=12, learner="paper"))


@pytest.fixture(scope="module")
def document(stepped: LearningResult, case: Case) -> dict:
    return plain(learning_document(stepped, case.settings()))


def plant_of(result: LearningResult, *, difference: BladeDifference | None = None) -> StaticPlant:
    return StaticPlant(
        tasks=WindTasks(case=result.case),
        wind=result.settings.wind,
        offset=result.practice * BLADES,
        difference=difference,
    )


# ---- figures -----------------------------------------------------------------------------


def test_rotations_by_hand_from_profiles_and_plant(stepped, document):
    plant, record = plant_of(stepped), stepped.record
    weights = stepped.case.weights.array[:4]
    assert [row["rotation"] for row in document["rotations"]] == list(range(1, 25))
    for row, profile, last in zip(
        document["rotations"], record.learning.profile, record.learning.last_passage, strict=True
    ):
        loads = plant.passage(profile, int(last))
        rms = loads.std(axis=1)
        assert row["passage"] == last + 1 - stepped.practice * BLADES == BLADES * row["rotation"]
        assert list(row["rms"]) == ["torque", "tilt", "yaw", "thrust"]
        np.testing.assert_allclose(list(row["rms"].values()), rms, rtol=1e-12)
        assert row["rms_sum"] == pytest.approx(rms.sum(), rel=1e-12)
        assert row["rms_weighted"] == pytest.approx(weights @ rms, rel=1e-12)
        assert row["wind_speed"] == plant.wind_speed(int(last))
    settled = document["rotations"][11]
    assert settled["rms_measured_weighted"] > settled["rms_weighted"]  # noise adds to it


def test_setpoint_is_the_same_share_in_each_wind(stepped, document):
    tasks = WindTasks(case=stepped.case)
    for speed, rows in (
        (15.0, document["rotations"][:12]),
        (17.0, document["rotations"][12:]),
    ):
        wanted = 0.93 * tasks.power_max(speed).mean_torque
        assert {row["wind_speed"] for row in rows} == {speed}
        np.testing.assert_allclose([row["setpoint"] for row in rows], wanted, rtol=1e-12)
    assert document["setpoint_after"] == document["rotations"][-1]["setpoint"]
    assert document["design"]["setpoint"] == document["rotations"][0]["setpoint"]


def test_references_are_those_of_the_model(stepped, document):
    tasks = WindTasks(case=stepped.case)
    for name, speed in (("design", 15.0), ("design_after", 17.0)):
        own = reference(tasks, speed, max_power_loss=0.07)
        found = document[name]
        assert found["rms_weighted"] == pytest.approx(own.design.rms_weighted, rel=1e-9)
        assert found["mean_torque"] == pytest.approx(own.setpoint, rel=1e-6)
        assert found["blade_rms"] == pytest.approx(own.design.loads.blade_rms, rel=1e-9)
        assert found["pitch_travel_deg"] == pytest.approx(np.rad2deg(own.design.pitch_travel))
        assert found["mean_tilt"] == pytest.approx(own.design.loads.mean[1], rel=1e-9)
        assert found["status"] == "converged"
        assert found["outside"] == 0
    best = tasks.best(15.0)
    assert document["baseline"]["pitch_deg"] == pytest.approx(np.rad2deg(best.profile[0]))
    assert document["baseline"]["rms_sum"] == pytest.approx(best.rms_sum, rel=1e-12)
    start = reference(tasks, 15.0, max_power_loss=0.07).constant
    assert document["start"]["pitch_deg"] == pytest.approx(np.rad2deg(start.profile[0]))
    assert document["start"]["mean_torque"] == pytest.approx(document["design"]["setpoint"])


def test_ratios_and_cut_by_hand(stepped, document):
    rows, design = document["rotations"], document["design"]["rms_weighted"]
    after = document["design_after"]["rms_weighted"]
    assert stepped.practice == 3
    found = document["ratio_to_design"]
    assert found["at_10"] == pytest.approx(rows[9]["rms_weighted"] / design)
    assert found["at_20"] == pytest.approx(rows[19]["rms_weighted"] / after)
    shifted = document["ratio_to_design_from_start"]
    assert shifted["at_10"] == pytest.approx(rows[6]["rms_weighted"] / design)
    assert shifted["at_20"] == pytest.approx(rows[16]["rms_weighted"] / after)
    assert [row["ratio_to_design"] for row in rows[11:13]] == pytest.approx(
        [rows[11]["rms_weighted"] / design, rows[12]["rms_weighted"] / after]
    )
    assert document["cut_at_20"] == pytest.approx(
        1 - rows[19]["rms_sum"] / document["baseline_after"]["rms_sum"]
    )
    whole = document["ratio_to_design_rotation"]
    assert whole["at_10"] == pytest.approx(rows[9]["rms_weighted_rotation"] / design)
    passages = document["passages"]["rms_sum"]
    assert len(passages) == 3 * len(rows)
    assert passages[2::3] == pytest.approx([row["rms_sum"] for row in rows])
    experiment = document["experiment"]
    assert (experiment["rotations"], experiment["passages"]) == (3, 9)
    assert len(experiment["rms_sum"]) == 3
    assert experiment["largest_move_deg"] == pytest.approx(0.5, rel=1e-6)
    first = stepped.record.experiment.ac_load[0] / design
    assert stepped.ratio_from_start(1) == pytest.approx(first)
    assert stepped.ratio_from_start(0) is None


@pytest.mark.parametrize(
    ("loads", "recovery"),
    [
        ([9.0, 9.0, 9.0, 2.61, 2.59, 9.0], 2),  # first below 1.3 x 2, growing again afterwards
        ([9.0, 9.0, 9.0, 2.59, 2.59, 2.59], 1),
        ([1.0, 1.0, 1.0, 9.0, 9.0, 2.61], None),  # good before the step does not count
    ],
)
def test_recovery_counts_rotations_after_the_step(stepped, loads, recovery):
    """Loads written by hand; a step after rotation 3, to a design of 2."""
    learning = stepped.record.learning
    columns = {name: value[:6] for name, value in learning.state().items()}
    record = replace(
        stepped.record, learning=type(learning).from_state({**columns, "ac_load": loads})
    )
    weights = np.array([2.0, 0.0, 0.0, 0.0])
    design = replace(stepped.design, weights=weights, loads=np.array([[-1.0, 1.0]] * 4))
    stretches = tuple(
        replace(stretch, first=first, last=last, design=design)
        for stretch, first, last in zip(stepped.stretches, (1, 4), (3, 6), strict=True)
    )
    settings = replace(stepped.settings, rotations=6, wind=replace(STEP, rotation=3))
    result = replace(stepped, record=record, stretches=stretches, settings=settings)
    assert result.recovery_rotations == recovery


@pytest.mark.parametrize("left", [0.0, 1e-7])
def test_no_ratio_to_a_design_that_leaves_only_rounding(stepped, left):
    design = replace(stepped.design, loads=left * np.array([[-1.0, 1.0]] * 4))
    stretches = tuple(replace(stretch, design=design) for stretch in stepped.stretches)
    result = replace(stepped, design=design, stretches=stretches)
    ratios = [result.ratio(1), result.ratio(20), result.ratio_from_start(1)]
    assert ratios == [None, None, None]
    assert result.ratio_from_start(20) is None
    assert result.recovery_rotations is None


def test_no_recovery_without_a_step(fixed):
    assert fixed.recovery_rotations is None
    assert fixed.setpoint_after is None
    found = plain(learning_document(fixed, fixed.case.settings()))
    assert found["design_after"] is None
    assert found["cut_at_20"] is None  # 12 rotations only
    assert found["ratio_to_design"]["at_20"] is None
    assert found["ratio_to_design"]["at_10"] is not None


def test_learned_profile_is_the_last_one(stepped, document):
    learned = document["learned"]
    assert learned["rms_weighted"] == document["rotations"][-1]["rms_weighted"]
    np.testing.assert_allclose(
        learned["pitch_deg"], np.rad2deg(stepped.record.learning.profile[-1])
    )
    pitch = np.array(learned["pitch_deg"])
    assert learned["pitch_travel_deg"] == pytest.approx(np.abs(np.roll(pitch, 1) - pitch).sum())
    curves = WindTasks(case=stepped.case).curves(17.0)
    loads = curves.evaluate(np.deg2rad(pitch))
    assert learned["blade_rms"] == pytest.approx(loads.blade_rms, rel=1e-9)
    assert learned["rms_weighted_rotation"] == pytest.approx(learned["rms_weighted"], rel=1e-9)


def test_the_adaptive_learner_comes_near_the_design(stepped):
    """On exact loads, with 1 % of noise in what it measures, in both winds."""
    assert stepped.ratio(10) < 2
    assert stepped.ratio(24) < 2


def test_events_carry_both_clocks(stepped):
    passages = stepped.practice * BLADES
    events = tuple((passages + clock, "said") for clock in (-1, 0, 2, 3))
    result = replace(stepped, record=replace(stepped.record, events=events))
    assert result.events == ((0, 0, "said"), (1, 1, "said"), (3, 1, "said"), (4, 2, "said"))


# ---- the paper's learner -----------------------------------------------------------------


def test_contraction_with_both_jacobians(fixed):
    """By the estimated slopes the factor is 1 - kappa; the plant's own are near."""
    np.testing.assert_allclose(fixed.loop.estimated, 0.7, atol=1e-9)
    assert np.all(fixed.loop.true < 1)
    assert np.abs(fixed.loop.true - 0.7).max() > 1e-3
    assert np.abs(fixed.loop.true - 0.7).max() < 0.15
    assert fixed.loop.azimuth.shape == fixed.loop.true.shape == (12,)


def test_the_plants_own_jacobian_is_that_of_its_curves(fixed):
    curves = WindTasks(case=fixed.case).curves(15.0)
    profile = fixed.record.learning.profile[-1]
    rows = np.arange(curves.stations)
    slopes = curves.slopes[:4, rows, curves.segment(profile)].reshape(4, BLADES, 12)
    own = fixed.loop.true_jacobian
    np.testing.assert_allclose(own, slopes.transpose(2, 0, 1), rtol=1e-6, atol=1e-3)
    # the experiment averages over some degrees of pitch
    apart = np.abs(fixed.loop.estimated_jacobian - own).max(axis=(0, 2))
    assert np.all(apart > 1e-3 * np.abs(own).max(axis=(0, 2)))
    assert np.all(apart < 0.3 * np.abs(own).max(axis=(0, 2)))


@pytest.mark.parametrize("separate", [False, True])
def test_the_jacobian_with_a_profile_for_each_blade(case, separate):
    """One blade moved by hand at the tracked positions."""
    settings = LearningSettings(
        rotations=2, learner="paper", separate=separate,
        difference=BladeDifference(blade=2, chord=1.05),
    )  # fmt: skip
    result = learn(case, settings)
    plant = plant_of(result, difference=settings.difference)
    last = np.broadcast_to(result.learned.profile, (BLADES, 36))
    start = (result.practice + 1) * BLADES
    passages = BLADES if separate else 1
    assert result.loop.true_jacobian.shape == (12 * passages, 4, BLADES)
    for blade in range(BLADES):
        moved = last.copy()
        moved[blade] += 1e-6
        change = np.hstack(
            [plant.passage(moved, start + n) - plant.passage(last, start + n)
             for n in range(passages)]
        )  # fmt: skip
        found = result.loop.true_jacobian[:, :, blade].T
        np.testing.assert_allclose(change / 1e-6, found, rtol=1e-4, atol=50.0)


# ---- winds -------------------------------------------------------------------------------


def spans(result: LearningResult) -> list[tuple[int, int, float, bool]]:
    return [(s.first, s.last, s.reference.wind_speed, s.mean_wind) for s in result.stretches]


def test_stretches_of_every_wind(case, stepped, fixed):
    assert spans(fixed) == [(1, 12, 15.0, False)]
    assert spans(stepped) == [(1, 12, 15.0, False), (13, 24, 17.0, False)]
    ramp = WindRamp(speed=15.0, change=0.4, first=4, last=6)
    ramped = learn(case, LearningSettings(rotations=8, wind=ramp, learner="paper"))
    assert spans(ramped) == [(1, 4, 15.0, False), (7, 8, pytest.approx(15.4), False)]
    assert ramped.ratio(4) is not None and ramped.ratio(7) is not None
    assert ramped.ratio(5) is ramped.ratio(6) is None
    assert ramped.winds[3] == 15.0 and ramped.winds[6] == pytest.approx(15.4)
    assert 15.0 < ramped.winds[4] < ramped.winds[5] <= 15.4
    assert ramped.recovery_rotations is None
    drift = WindDrift(speed=15.0, std=0.1, rotations_correlation=5.0)
    drifted = learn(case, LearningSettings(rotations=3, wind=drift, learner="paper"))
    assert spans(drifted) == [(1, 3, 15.0, True)]
    assert drifted.reference_after is None
    assert len(set(drifted.winds)) == 3


def test_setpoint_follows_a_ramp(case):
    ramp = WindRamp(speed=15.0, change=0.4, first=1, last=3)
    result = learn(case, LearningSettings(rotations=4, wind=ramp, learner="paper"))
    schedule = SetpointSchedule(tasks=WindTasks(case=case), wind=ramp, max_power_loss=0.07)
    wanted = [schedule.at(rotation) for rotation in range(4)]
    np.testing.assert_allclose(result.record.learning.setpoint, wanted, rtol=1e-12)
    assert wanted[0] == wanted[1] < wanted[2] < wanted[3]


@pytest.mark.parametrize("rotation", [5, 9])
def test_a_step_beyond_the_run_changes_nothing(case, rotation):
    calm = learn(case, LearningSettings(rotations=5, learner="paper"))
    wind = replace(STEP, rotation=rotation)
    result = learn(case, LearningSettings(rotations=5, learner="paper", wind=wind))
    assert result.reference_after is result.design_after is result.setpoint_after is None
    assert spans(result) == spans(calm)
    np.testing.assert_array_equal(result.record.learning.profile, calm.record.learning.profile)


def test_a_change_by_nothing_is_none(case):
    for wind in (replace(STEP, change=0.0), WindRamp(speed=15.0, change=0.0, first=4, last=8)):
        result = learn(case, LearningSettings(rotations=14, learner="paper", wind=wind))
        assert spans(result) == [(1, 14, 15.0, False)]
        assert result.reference_after is None


def test_a_step_at_once_leaves_the_new_wind_alone(case):
    wind = replace(STEP, rotation=0)
    result = learn(case, LearningSettings(rotations=3, learner="paper", wind=wind))
    assert spans(result) == [(1, 3, 17.0, False)]
    assert result.reference.wind_speed == 15.0
    assert set(result.winds) == {17.0}


def test_a_torque_that_is_held_stays(case):
    settings = LearningSettings(rotations=4, mean_torque=1.3e6, wind=replace(STEP, rotation=2))
    result = learn(case, settings)
    assert set(result.record.learning.setpoint) == {1.3e6}
    assert result.setpoint_after == 1.3e6


# ---- sensors, limits, blades --------------------------------------------------------------


def sensors_of(result: LearningResult) -> dict:
    return result.record.settings["sensors"]


def test_sensors_are_shares_of_the_loads_at_the_start(case):
    common = {"rotations": 1, "learner": "paper", "start_pitch": 0.0, "seed": 7}
    loads = WindTasks(case=case).curves(15.0).evaluate(np.zeros(36))
    by_rms = learn(case, LearningSettings(noise=0.02, quantisation=0.01, delay=2, **common))
    np.testing.assert_allclose(sensors_of(by_rms)["noise"], 0.02 * loads.rms, rtol=1e-12)
    np.testing.assert_allclose(sensors_of(by_rms)["quantisation"], 0.01 * loads.rms, rtol=1e-12)
    assert sensors_of(by_rms)["delay"] == by_rms.record.settings["learner"]["delay"] == 2
    assert sensors_of(by_rms)["seed"] == 7
    by_mean = learn(case, LearningSettings(noise=0.02, noise_of="mean", dropout=0.1, **common))
    np.testing.assert_allclose(sensors_of(by_mean)["noise"], 0.02 * np.abs(loads.mean), rtol=1e-12)
    assert sensors_of(by_mean)["dropout"] == 0.1
    assert np.any(by_mean.record.learning.missing > 0)
    assert by_rms.start.mean_pitch == 0.0


def test_the_learner_knows_the_actuators_and_no_stall(case):
    result = learn(case, LearningSettings(rotations=1, learner="paper"))
    told, limits = result.record.settings["learner"], case.pitch_limits
    assert (told["lower"], told["upper"]) == (limits.lower, limits.upper)
    assert told["step"] == pytest.approx(limits.step(36), rel=1e-12)


def test_every_profile_keeps_the_actuators_limits(stepped):
    limits = stepped.case.pitch_limits
    for profile in (*stepped.record.experiment.profile, *stepped.record.learning.profile):
        assert limits.lower <= profile.min() and profile.max() <= limits.upper
        assert np.abs(np.roll(profile, -1) - profile).max() <= limits.step(36) * (1 + 1e-9)


def test_the_rate_is_that_of_the_fastest_rotor():
    """Below rated the rotor turns faster in more wind."""
    from pitchopt.studies.learning.study import _Study

    case = load_case("nrel-5mw").with_values({"wind.speed": 8.0, "limits.positions": 6})
    winds = (
        (None, 8.0),
        (WindStep(speed=8.0, change=2.0, rotation=1), 10.0),
        (WindStep(speed=8.0, change=-2.0, rotation=1), 8.0),
        (WindRamp(speed=8.0, change=1.0, first=1, last=2), 9.0),
        (WindDrift(speed=8.0, std=0.5, rotations_correlation=5.0), 9.5),
    )
    for wind, fastest in winds:
        limits = _Study(case, LearningSettings(wind=wind))._limits
        own = case.with_values({"wind.speed": fastest}).pitch_limits
        assert limits.step == pytest.approx(own.step(18), rel=1e-12), wind


@pytest.mark.slow
def test_separate_profiles_even_out_a_different_blade(case):
    difference = BladeDifference(pitch_offset=0.01)
    common = {"rotations": 15, "difference": difference}
    alike = learn(case, LearningSettings(**common))
    apart = learn(case, LearningSettings(separate=True, **common))
    assert apart.learned.profile.shape == (3, 36)
    assert apart.learned.rms_weighted_rotation < 0.2 * alike.learned.rms_weighted_rotation
    assert apart.design.rms_weighted > 3 * apart.learned.rms_weighted  # it knows no difference
    plant = plant_of(apart, difference=difference)
    own = apart.learned.profile
    curves = WindTasks(case=case).curves(15.0)
    moved = own + np.array([[0.01], [0.0], [0.0]])
    expected = np.array([curves.evaluate(row).bending for row in moved])
    np.testing.assert_allclose(plant.bending(own, 0), expected, rtol=1e-12)
    assert apart.learned.blade_rms == pytest.approx(expected.std(axis=1).max())
    turn = np.hstack([plant.passage(own, n) for n in range(4, 4 + BLADES)])
    np.testing.assert_array_equal(plant.rotation(own, 4), turn)


def test_a_rotation_has_one_wind(case):
    """That of its first passage, even if the wind changes within."""
    wind = WindRamp(speed=15.0, change=2.0, first=0, last=2)
    plant = StaticPlant(tasks=WindTasks(case=case), wind=wind)
    profile = 0.01 * np.cos(2 * np.pi * np.arange(36) / 36)
    found = plant.rotation(profile, 2).reshape(4, BLADES, 12)
    for part in range(BLADES):
        np.testing.assert_allclose(found[:, part], plant.passage(profile, 2), rtol=1e-12)


def test_harmonics_bind_learner_and_design(case):
    smooth = case.with_values({"objective.harmonics": 2})
    result = learn(smooth, LearningSettings(rotations=4))
    for profile in (result.learned.profile, result.design.profile):
        high = np.abs(np.fft.rfft(profile)[3:])
        assert high.max() < 1e-6 * np.abs(np.fft.rfft(profile)).max()


# ---- going on, progress -------------------------------------------------------------------


@pytest.mark.slow
@pytest.mark.parametrize("learner", ["adaptive", "paper"])
def test_a_checkpoint_leads_to_the_same_document(case, tmp_path, learner):
    settings = LearningSettings(
        rotations=9, learner=learner, wind=replace(STEP, rotation=5), noise=0.02, dropout=0.05,
        delay=2,
    )  # fmt: skip
    path = tmp_path / "run.npz"

    class KilledError(Exception):
        pass

    def kill(done: int, total: int, label: str) -> None:
        if label == "learning" and done == total - 4:
            raise KilledError

    with pytest.raises(KilledError):
        learn(case, settings, checkpoint=path, progress=kill)
    assert path.exists()
    resumed = plain(learning_document(learn(case, settings, checkpoint=path), {}))
    whole = plain(learning_document(learn(case, settings), {}))
    assert resumed.pop("seconds") > 0 and whole.pop("seconds") > 0
    assert resumed == whole


@pytest.fixture(scope="module")
def two_rotations(case, tmp_path_factory) -> bytes:
    """A checkpoint after two rotations."""
    path = tmp_path_factory.mktemp("checkpoint") / "run.npz"
    learn(case, LearningSettings(rotations=2, wind=STEP), checkpoint=path)
    return path.read_bytes()


@pytest.mark.parametrize(
    "changed",
    [
        {"wind": replace(STEP, change=1.0)},
        {"difference": BladeDifference(chord=1.01)},
        {"noise": 0.01},
        {"max_power_loss": 0.06},
        {"learner": "paper"},
    ],
    ids=lambda value: next(iter(value)),
)
def test_a_checkpoint_of_another_run_is_refused(case, two_rotations, tmp_path, changed):
    settings = LearningSettings(rotations=13, wind=STEP)
    path = tmp_path / "run.npz"
    path.write_bytes(two_rotations)
    with pytest.raises(InputError, match="other settings"):
        learn(case, replace(settings, **changed), checkpoint=path)
    assert path.read_bytes() == two_rotations


def test_a_file_that_is_no_checkpoint_is_refused_at_once(case, tmp_path):
    path = tmp_path / "run.npz"
    path.write_bytes(b"something else")
    told = []
    with pytest.raises(InputError, match=r"run\.npz"):
        learn(case, checkpoint=path, progress=lambda *args: told.append(args))
    assert told == []
    assert path.read_bytes() == b"something else"


def test_progress_never_goes_back(case):
    told = []
    settings = LearningSettings(rotations=3, wind=replace(STEP, rotation=2), learner="paper")
    learn(case, settings, progress=lambda *args: told.append(args))
    done = [now for now, _, _ in told]
    assert done == sorted(done)
    assert {total for _, total, _ in told} == {done[-1]}
    assert {label for _, _, label in told} == {"reference", "learning"}


# ---- bad input -----------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("given", "words"),
    [
        ({"learner": "other"}, "learner: got 'other', expected adaptive or paper"),
        ({"rotations": 0}, "rotations: got 0"),
        ({"rotations": 2.5}, "rotations: got 2.5"),
        ({"max_power_loss": 1.5}, "max_power_loss: got 1.5"),
        ({"max_power_loss": 0.1, "mean_torque": 1e6}, "set-point: got both"),
        ({"mean_torque": math.nan}, "mean_torque: got nan"),
        ({"start_pitch": math.inf}, "start_pitch: got inf"),
        ({"amplitude": 0.0}, "amplitude: got 0"),
        ({"noise": -0.1}, "noise: got -0.1"),
        ({"noise_of": "peak"}, "noise_of: got 'peak', expected rms or mean"),
        ({"quantisation": -1}, "quantisation: got -1"),
        ({"delay": -1}, "delay: got -1"),
        ({"dropout": 1.1}, "dropout: got 1.1"),
        ({"seed": -1}, "seed: got -1"),
        ({"wind": "step"}, "wind: got str, expected ConstantWind"),
        ({"difference": 1.03}, "difference: got float, expected BladeDifference"),
        ({"separate": "yes"}, "separate: got 'yes'"),
        ({"learning_rate": 0.3}, "learning_rate: got 0.3 with the adaptive learner"),
        ({"damping": 0.1}, "damping: got 0.1 with the adaptive learner"),
        ({"smoothing": 0.1}, "smoothing: got 0.1 with the adaptive learner"),
        ({"learner": "paper", "learning_rate": 1.1}, "learning_rate: got 1.1"),
        ({"learner": "paper", "damping": -1.0}, "damping: got -1"),
        ({"learner": "paper", "smoothing": 0.0}, "smoothing: got 0"),
    ],
    ids=lambda value: str(value)[:40],
)
def test_bad_settings(given, words):
    with pytest.raises(InputError) as error:
        LearningSettings(**given)
    assert words in str(error.value)


@pytest.mark.parametrize(
    ("values", "given", "words"),
    [
        ({"objective.harmonics": 2}, {"learner": "paper"}, "harmonics: got 2 with the paper's"),
        ({"objective.harmonics": 0}, {}, "harmonics: got 0"),
        ({"objective.travel": 1.0}, {}, "travel penalty: got 1 N m/rad, expected 0"),
        ({}, {"wind": ConstantWind(speed=14.0)}, "starts with 14 m/s, expected the case's 15"),
        ({}, {"delay": 13}, "delay: got 13 samples, expected at most the 12"),
        ({}, {"start_pitch": 1.0}, "start pitch: got 57.2958 deg, expected -10 to 45 deg"),
        ({}, {"difference": BladeDifference(blade=4)}, "different blade: got 4"),
        ({"limits.pitch_rate": 0.0}, {}, "limits.pitch_rate_deg: got 0, expected a rate above 0"),
        ({"limits.pitch_rate": 1e-9}, {}, "did not answer the pitch"),
    ],
    ids=lambda value: str(value)[:40],
)
def test_case_and_settings_that_do_not_fit(case, values, given, words):
    with pytest.raises(InputError) as error:
        learn(case.with_values(values), LearningSettings(rotations=1, **given))
    assert words in str(error.value)


def test_a_weight_on_the_blade_cannot_be_learned(case):
    from pitchopt.design import LoadWeights

    with pytest.raises(InputError, match=r"weights\.blade: got 1"):
        learn(case.with_values({"objective.weights": LoadWeights(blade=1.0)}))


def test_a_torque_that_no_profile_gives(case):
    with pytest.raises(InfeasibleError):
        learn(case, LearningSettings(rotations=1, mean_torque=1.6e6))
