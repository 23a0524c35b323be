"""Runs: what the record says, and going on from a checkpoint to the same record bit for bit."""

from __future__ import annotations

import itertools
import os
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from ilc_factories import SCALE, WEIGHTS, AffinePlant, make_learner
from run_in_process import ROTATIONS, parts, whole

from ilc import (
    ActuatorLimits,
    Learner,
    LearningError,
    Plant,
    Record,
    Sensors,
    StateError,
    StatefulPlant,
    load_state,
    run,
    save_state,
)

SCRIPT = Path(__file__).with_name("run_in_process.py")


class StopError(Exception):
    """Ends a run from its callback or plant."""


class Recorder:
    """A plant that notes the profiles it gets and the loads it gives."""

    def __init__(self, plant: AffinePlant, stop_at: int | None = None) -> None:
        self.plant, self.stop_at = plant, stop_at
        self.blades, self.positions = plant.blades, plant.positions
        self.profiles: list[np.ndarray] = []
        self.loads: list[np.ndarray] = []

    def passage(self, profile: np.ndarray, number: int) -> np.ndarray:
        assert number == len(self.profiles) or self.stop_at is not None
        if number == self.stop_at:
            raise StopError
        self.profiles.append(profile)
        self.loads.append(self.plant.passage(profile, number))
        return self.loads[-1]


def assert_same(one: Record, other: Record) -> None:
    a, b = one.state(), other.state()
    assert a.keys() == b.keys()
    for name in a:
        assert a[name].dtype == b[name].dtype
        np.testing.assert_array_equal(a[name], b[name], err_msg=name)


def test_plants_keep_the_protocol() -> None:
    assert isinstance(AffinePlant.random(0), Plant)


@pytest.mark.parametrize("separate", [False, True])
def test_record_says_what_happened(learner_type: type[Learner], separate: bool) -> None:
    plant = Recorder(AffinePlant.random(1, positions=4, separate=separate))
    learner = make_learner(plant.plant, learner_type)
    asked = []

    def setpoint(rotation: int) -> float:
        asked.append(rotation)
        return float(SCALE[0]) * (1 + 0.01 * rotation)

    told: list[tuple[int, int, str]] = []
    record = run(
        plant,
        learner,
        rotations=4,
        setpoint=setpoint,
        sensors=Sensors(dropout=0.1, seed=1),
        callback=lambda *given: told.append(given),
    )
    practice = learner.experiment_passages // 3
    assert record.rotations == 4
    assert len(record.experiment) == practice
    assert len(plant.profiles) == len(record.passages) == learner.passages == 3 * (practice + 4)
    assert asked == [0] * practice + [0, 1, 2, 3]
    assert [done for done, _, _ in told] == list(range(1, practice + 5))
    assert {total for _, total, _ in told} == {practice + 4}
    assert told[0][2].startswith("experiment: AC load ")
    assert told[-1][2].startswith("rotation 4: AC load ")

    np.testing.assert_array_equal(record.passages.number, np.arange(learner.passages))
    np.testing.assert_array_equal(
        record.passages.experiment, np.arange(learner.passages) < learner.experiment_passages
    )
    loads = np.array(plant.loads)
    np.testing.assert_allclose(record.passages.mean, loads.mean(axis=2), rtol=1e-12)
    np.testing.assert_allclose(record.passages.rms, loads.std(axis=2), rtol=1e-12)

    np.testing.assert_array_equal(record.experiment.rotation, np.arange(1 - practice, 1))
    np.testing.assert_array_equal(record.learning.rotation, [1, 2, 3, 4])
    for group, first in ((record.experiment, 0), (record.learning, practice)):
        for row in range(len(group)):
            last = 3 * (first + row) + 2
            assert group.last_passage[row] == last
            turn = np.concatenate(plant.loads[last - 2 : last + 1], axis=1)
            np.testing.assert_array_equal(group.profile[row], plant.profiles[last])
            np.testing.assert_allclose(group.ac_load[row], WEIGHTS @ loads[last].std(axis=1))
            np.testing.assert_allclose(group.ac_load_rotation[row], WEIGHTS @ turn.std(axis=1))
            np.testing.assert_allclose(group.mean_torque[row], turn[0].mean())
            np.testing.assert_allclose(group.mean_torque_last[row], loads[last, 0].mean())
    np.testing.assert_allclose(
        record.learning.setpoint, SCALE[0] * np.array([1.0, 1.01, 1.02, 1.03])
    )


def test_measured_figures_are_those_that_the_learner_was_told() -> None:
    sensors, same = (Sensors(noise=1e3, dropout=0.2, seed=2) for _ in range(2))
    plant = Recorder(AffinePlant.random(2, positions=6))
    record = run(plant, make_learner(plant.plant), rotations=2, sensors=sensors)
    measured = np.array([same.read(loads) for loads in plant.loads])
    np.testing.assert_allclose(record.passages.measured_mean, np.nanmean(measured, axis=2))
    np.testing.assert_allclose(record.passages.measured_rms, np.nanstd(measured, axis=2))
    last = record.learning.last_passage
    np.testing.assert_allclose(
        record.learning.ac_load_measured, np.nanstd(measured[last], axis=2) @ WEIGHTS
    )
    missing = np.isnan(measured).reshape(-1, 3 * 4 * 6).mean(axis=1)
    np.testing.assert_allclose(record.learning.missing, missing[-2:], atol=1e-15)
    assert missing[-2:].min() > 0


def test_passages_without_a_measurement_are_nan_and_exact_figures_stay() -> None:
    plant = AffinePlant.random(2, positions=4)
    learner = make_learner(plant)
    lost = {learner.experiment_passages + 2}

    class Gap(Sensors):
        def read(self, exact: Any) -> Any:
            out = super().read(exact)
            return np.full_like(out, np.nan) if learner.passages in lost else out

    record = run(plant, learner, rotations=1, sensors=Gap())
    assert np.isnan(record.passages.measured_mean[-1]).all()
    assert np.isnan(record.learning.ac_load_measured[0])
    np.testing.assert_allclose(record.learning.missing, [1 / 3])
    assert np.isfinite(record.learning.ac_load).all()
    assert (learner.experiment_passages + 2, "too few samples: profile kept") in record.events


def test_record_is_read_only_and_goes_through_a_file(tmp_path: Path) -> None:
    record = whole(True, rotations=2)
    with pytest.raises(ValueError, match="read-only"):
        record.learning.ac_load[0] = 1.0
    with pytest.raises(TypeError):
        record.settings["learner"] = {}  # type: ignore[index]
    save_state(tmp_path / "record.npz", record.state())
    again = Record.from_state(load_state(tmp_path / "record.npz"))
    assert_same(record, again)
    assert again.settings == record.settings
    assert again.settings["sensors"]["delay"] == 2
    state = record.state()
    for damaged in (
        {name: value for name, value in state.items() if name != "learning.ac_load"},
        {**state, "learning.ac_load": state["learning.ac_load"][:1]},
        {**state, "events": np.array("[1]")},
    ):
        with pytest.raises(StateError, match="record"):
            Record.from_state(damaged)


def test_cut_and_ratio() -> None:
    record = whole(False, rotations=3)
    load = record.learning.ac_load[1]
    assert record.ratio(2, 2.0) == load / 2.0
    assert record.cut_at(2, 4 * load) == 0.75
    for rotation in (0, 4, 1.5):
        with pytest.raises(LearningError, match="rotation"):
            record.ratio(rotation, 1.0)  # type: ignore[arg-type]
    with pytest.raises(LearningError, match="reference"):
        record.ratio(1, 0.0)
    with pytest.raises(LearningError, match="baseline"):
        record.cut_at(1, -1.0)


def test_no_rotation_is_the_experiment_alone() -> None:
    record = whole(False, rotations=0)
    assert record.rotations == 0
    assert record.learning.profile.shape == (0, 12)
    assert len(record.experiment) * 3 == len(record.passages) > 0


@pytest.mark.slow
@pytest.mark.parametrize("separate", [False, True])
@pytest.mark.parametrize("every", [1, 4])
def test_resumed_at_any_passage_gives_the_same_record(
    learner_type: type[Learner], separate: bool, every: int, tmp_path: Path
) -> None:
    unbroken = whole(separate, learner_type, rotations=8)
    path = tmp_path / "run.npz"
    passages = len(unbroken.passages)
    for stop in (*range(0, passages, 7), passages - 1):
        path.unlink(missing_ok=True)
        plant = parts(separate)["plant"]
        with pytest.raises(StopError):
            run(
                **parts(separate, learner_type, plant=Recorder(plant, stop), rotations=8),
                checkpoint=path,
                every=every,
            )
        assert path.exists() == (stop >= 3 * every)
        second = Recorder(plant)
        second.stop_at = -1
        record = run(
            **parts(separate, learner_type, plant=second, rotations=8),
            checkpoint=path,
            every=every,
        )
        assert_same(record, unbroken)
        assert len(second.profiles) == passages - stop // 3 // every * every * 3


@pytest.mark.slow
@pytest.mark.parametrize("separate", ["common", "separate"])
def test_killed_runs_go_on_to_the_same_record(separate: str, tmp_path: Path) -> None:
    path = tmp_path / "run.npz"
    environment = os.environ | {
        "PYTHONPATH": os.pathsep.join([str(SCRIPT.parent), *filter(None, sys.path)])
    }
    delays = np.random.default_rng(1).uniform(0.0, 0.02, size=4)
    unbroken = whole(separate == "separate")
    reached = []
    for wait, lines in zip(delays, (1, 2, 3, 3), strict=True):
        with subprocess.Popen(
            [sys.executable, str(SCRIPT), str(path), separate],
            stdout=subprocess.PIPE,
            text=True,
            env=environment,
        ) as process:
            assert process.stdout is not None
            reached.extend(int(process.stdout.readline()) for _ in range(lines))
            time.sleep(wait)
            process.kill()
    practice = len(unbroken.experiment)
    assert reached == sorted(set(reached))  # each went on where the one before was killed
    assert reached[0] < practice < reached[-1] < practice + ROTATIONS
    assert len(load_state(path)["record.learning.rotation"]) >= reached[-1] - practice > 0
    assert_same(run(**parts(separate == "separate"), checkpoint=path), unbroken)


def test_finished_checkpoint_goes_on_to_more_rotations(tmp_path: Path) -> None:
    path = tmp_path / "run.npz"
    run(**parts(False, rotations=5), checkpoint=path)
    assert_same(run(**parts(False, rotations=9), checkpoint=path), whole(False, rotations=9))
    before = path.read_bytes()
    assert_same(run(**parts(False, rotations=9), checkpoint=path), whole(False, rotations=9))
    with pytest.raises(LearningError, match=r"got 8, but .* has made 9"):
        run(**parts(False, rotations=8), checkpoint=path)
    assert path.read_bytes() == before


def test_end_is_saved_whatever_the_interval(tmp_path: Path) -> None:
    path = tmp_path / "run.npz"
    record = run(**parts(False, rotations=2), checkpoint=path, every=100)

    idle = Recorder(parts(False)["plant"], stop_at=-1)
    assert_same(run(**parts(False, rotations=2, plant=idle), checkpoint=path), record)
    assert not idle.profiles


@pytest.mark.parametrize("gap", [np.nan, np.inf, -np.inf])
def test_loads_that_the_plant_does_not_give_are_missing(gap: float) -> None:
    class Blind(Recorder):
        def passage(self, profile: np.ndarray, number: int) -> np.ndarray:
            loads = super().passage(profile, number)
            loads[1, 2] = gap
            return loads

    plant = Blind(AffinePlant.random(2, positions=6))
    record = run(plant, make_learner(plant.plant), rotations=1)
    np.testing.assert_allclose(record.learning.missing, 1 / 24)
    kept = np.delete(plant.loads[-1], 2, axis=1)[1]
    assert record.passages.mean[-1, 1] == pytest.approx(kept.mean())
    assert record.passages.rms[-1, 1] == pytest.approx(kept.std())
    assert np.isfinite(record.learning.ac_load).all()


def test_checkpoint_of_other_settings_is_refused_and_left(tmp_path: Path) -> None:
    path = tmp_path / "run.npz"
    run(**parts(False, rotations=1), checkpoint=path)
    before = path.read_bytes()
    plant = parts(False)["plant"]
    finer = AffinePlant.random(4, positions=5)
    others: list[tuple[str, dict[str, Any]]] = [
        ("learner", {"learner": make_learner(plant, delay=2, learning_rate=0.4)}),
        ("start", {"learner": make_learner(plant, delay=2, start=0.01)}),
        ("setpoint", {"learner": make_learner(plant, delay=2, setpoint=1e6)}),
        ("sensors", {"sensors": Sensors(seed=3)}),
        ("sensors", {"sensors": None}),
        ("learner", {"plant": finer, "learner": make_learner(finer, delay=2)}),
    ]
    for what, changes in others:
        with pytest.raises(StateError, match=f"other settings.*{what}"):
            run(**parts(False, **changes), checkpoint=path)
        assert path.read_bytes() == before


@pytest.mark.parametrize("content", ["text", "empty", "learner", "array", "cut", "flipped"])
def test_files_that_are_no_checkpoint_are_refused_and_left(content: str, tmp_path: Path) -> None:
    path = tmp_path / "precious.npz"
    if content == "text":
        path.write_text("results of a long night\n")
    elif content == "empty":
        path.touch()
    elif content == "learner":
        save_state(path, parts(False)["learner"].state())
    elif content == "array":
        with path.open("wb") as stream:
            np.save(stream, np.zeros(3))
    else:
        run(**parts(False, rotations=1), checkpoint=path)
        whole_file = path.read_bytes()
        middle = len(whole_file) // 2
        flipped = bytes(value ^ 0xFF for value in whole_file[middle : middle + 2000])
        rest = whole_file[middle + 2000 :] if content == "flipped" else b""
        path.write_bytes(whole_file[:middle] + (flipped if rest else b"") + rest)
    before = path.read_bytes()
    with pytest.raises(StateError, match="precious"):
        run(**parts(False), checkpoint=path)
    assert path.read_bytes() == before
    assert [entry.name for entry in tmp_path.iterdir()] == ["precious.npz"]


def test_checkpoint_whose_parts_disagree_is_refused(tmp_path: Path) -> None:
    path, other = tmp_path / "run.npz", tmp_path / "other.npz"
    run(**parts(False, rotations=1), checkpoint=path)
    run(**parts(False, rotations=2), checkpoint=other)
    mixed = {
        name: value if name.startswith("record.") else load_state(other)[name]
        for name, value in load_state(path).items()
    }
    save_state(path, mixed)
    with pytest.raises(StateError, match="damaged"):
        run(**parts(False), checkpoint=path)


def test_bad_input_is_named(tmp_path: Path) -> None:
    with pytest.raises(LearningError, match="rotations"):
        run(**parts(False, rotations=-1))
    with pytest.raises(LearningError, match="every"):
        run(**parts(False), every=0)
    with pytest.raises(LearningError, match=r"no directory .*absent"):
        run(**parts(False), checkpoint=tmp_path / "absent" / "run.npz")
    with pytest.raises(LearningError, match=r"3 blades and 5 positions.*3 and 4"):
        run(**parts(False, plant=AffinePlant.random(0, positions=5)))
    used = parts(False)["learner"]
    used.tell(np.zeros((4, 4)))
    with pytest.raises(LearningError, match="fresh"):
        run(**parts(False, learner=used))

    class Short(Recorder):
        def passage(self, profile: np.ndarray, number: int) -> np.ndarray:
            return super().passage(profile, number)[:, 1:]

    with pytest.raises(LearningError, match=r"plant.passage: got shape \(4, 3\)"):
        run(**parts(False, plant=Short(parts(False)["plant"])))


def test_profiles_of_a_run_keep_the_limits(learner_type: type[Learner]) -> None:
    limits = ActuatorLimits(lower=-0.02, upper=0.03, step=0.004)
    plant = Recorder(AffinePlant.random(5, positions=8))
    layout = plant.plant.layout
    learner = make_learner(plant.plant, learner_type, limits=limits)
    run(plant, learner, rotations=10, sensors=Sensors.with_share(0.1, SCALE, seed=1))
    profiles = [*plant.profiles, learner.profile]
    worst = max(
        limits.violation(layout, new, old, number + 1)
        for number, (old, new) in enumerate(itertools.pairwise(profiles))
    )
    assert worst <= 1e-12
    assert worst > -1e-9  # they do bind


# ---- plants with a state ---------------------------------------------------------------------


class Sluggish(AffinePlant):
    """A plant whose loads come to what the profile asks for by and by."""

    def __init__(self, plant: AffinePlant) -> None:
        super().__init__(plant.layout, plant.offset, plant.jacobian)
        self.before: np.ndarray = np.zeros((4, plant.positions))

    def passage(self, profile: np.ndarray, number: int) -> np.ndarray:
        self.before = 0.8 * super().passage(profile, number) + 0.2 * self.before
        return self.before

    def state(self) -> dict[str, np.ndarray]:
        return {"before": self.before.copy()}

    def restore(self, state: Any) -> None:
        if "before" not in state or np.shape(state["before"]) != self.before.shape:
            raise ValueError("no such loads")
        self.before = np.array(state["before"])


def test_checkpoints_carry_the_state_of_a_plant(
    learner_type: type[Learner], tmp_path: Path
) -> None:
    def fresh() -> tuple[Sluggish, Learner]:
        plant = Sluggish(AffinePlant.random(3, positions=4))
        assert isinstance(plant, StatefulPlant)
        return plant, make_learner(plant, learner_type)

    whole = run(*fresh(), rotations=7)
    path = tmp_path / "run.npz"
    run(*fresh(), rotations=3, checkpoint=path)
    assert_same(run(*fresh(), rotations=7, checkpoint=path), whole)
    # the state matters: without it the run goes on otherwise
    path.unlink()
    run(*fresh(), rotations=3, checkpoint=path)
    saved = {name: array for name, array in load_state(path).items() if name != "plant.before"}
    save_state(path, saved)
    plant, learner = fresh()
    with pytest.raises(StateError, match=r"not a state of this plant \(no such loads\)"):
        run(plant, learner, rotations=7, checkpoint=path)


def test_plants_without_a_state_leave_none_in_checkpoints(tmp_path: Path) -> None:
    plant = AffinePlant.random(3, positions=4)
    assert not isinstance(plant, StatefulPlant)
    run(plant, make_learner(plant), rotations=1, checkpoint=tmp_path / "run.npz")
    assert not [name for name in load_state(tmp_path / "run.npz") if name.startswith("plant.")]
