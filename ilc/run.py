"""Run: turn the plant, tell the learner, keep the record; go on where a killed run stopped.

    loads = plant(profile)  ->  sensors  ->  learner  ->  profile  ->  ...

A checkpoint is written after whole rotations and replaced in one step, so that a run killed at
any moment goes on from the last one that was written, to the same record bit for bit as without
the break.  For that the plant's loads must depend on profile and passage number alone, or the
plant must be a `StatefulPlant`, whose state is kept in the checkpoint.
"""

from __future__ import annotations

import json
import os
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from ilc._checks import FloatArray, array_of, count
from ilc.errors import LearningError, StateError
from ilc.learner import Learner, State, ac_load
from ilc.plant import Plant, StatefulPlant
from ilc.record import PassageRecord, Record, RotationRecord
from ilc.sensors import Sensors
from ilc.storage import check_settings, load_state, part, save_state

__all__ = ["run"]

_FORMAT = "ilc run 1"


def run(
    plant: Plant,
    learner: Learner,
    *,
    rotations: int,
    setpoint: Callable[[int], float] | None = None,
    sensors: Sensors | None = None,
    checkpoint: str | os.PathLike[str] | None = None,
    every: int = 1,
    context: Mapping[str, Any] | None = None,
    callback: Callable[[int, int, str], object] | None = None,
) -> Record:
    """Let a learner learn on a plant.

    Parameters
    ----------
    plant : Plant or StatefulPlant
        Fresh, if it has a state.
    learner : Learner
        Fresh; it is left as the run ends, so that its profile is the one for the next passage.
    rotations : int
        Rotations of learning, after the experiment.
    setpoint : callable, optional
        Mean torque to hold [N m] as a function of the whole rotations made since the experiment,
        asked at the start of each rotation (with 0 during the experiment).  Without it the learner
        keeps its own.
    sensors : Sensors, optional
        Fresh; without them the learner is told the exact loads.
    checkpoint : path, optional
        File from which the run goes on if it exists, and to which it is saved.
    every : int
        Rotations from one saving to the next; the end is always saved.
    context : mapping, optional
        Plain data that says what plant and set-point are; kept in the record's settings, and a
        checkpoint is gone on from only with the same.
    callback : callable, optional
        Called after each rotation with the rotations made, those to make (both with the
        experiment) and a line of text.

    Returns
    -------
    Record

    Raises
    ------
    LearningError
        If learner and plant differ in blades or positions, the learner is not fresh, or the
        checkpoint has more rotations than asked for.
    StateError
        If the file is not a checkpoint, damaged, or that of a run with other settings.  It is left
        as it is.
    """
    count("rotations", rotations)
    count("every", every, at_least=1)
    layout = learner.layout
    shape = (plant.blades, plant.positions)
    if shape != (layout.blades, layout.positions):
        raise LearningError(
            f"plant: got {shape[0]} blades and {shape[1]} positions, expected the learner's "
            f"{layout.blades} and {layout.positions}"
        )
    if learner.passages:
        raise LearningError(
            f"learner: got one that has made {learner.passages} passages, expected a fresh one"
        )
    book = _Book(learner, sensors, context)
    path = None if checkpoint is None else Path(checkpoint)
    if path is not None:
        if not path.parent.is_dir():
            raise LearningError(f"checkpoint: there is no directory {path.parent}")
        if path.exists():
            book.resume(path, plant)
    practice = learner.experiment_passages // layout.blades
    total = practice + rotations
    done = learner.passages // layout.blades
    if done > total:
        raise LearningError(
            f"rotations: got {rotations}, but {path} has made {done - practice} already"
        )
    while done < total:
        if setpoint is not None:
            learner.setpoint = setpoint(max(learner.rotation, 0))
        text = book.rotation(plant)
        done += 1
        if path is not None and (done % every == 0 or done == total):
            save_state(path, book.state(plant))
        if callback is not None:
            callback(done, total, text)
    return book.record()


class _Book:
    """Makes rotations and writes them down."""

    def __init__(
        self, learner: Learner, sensors: Sensors | None, context: Mapping[str, Any] | None
    ) -> None:
        self.learner, self.sensors = learner, sensors
        self.settings = {
            "learner": learner.settings(),
            "start": learner.profile.tolist(),
            "setpoint": learner.setpoint,
            "sensors": None if sensors is None else sensors.settings(),
            "context": dict(context or {}),
        }
        self._passages: dict[str, list[Any]] = {name: [] for name in PassageRecord.columns()}
        self._rotations: dict[str, list[Any]] = {name: [] for name in RotationRecord.columns()}

    def rotation(self, plant: Plant) -> str:
        """Make one rotation; a line of text about it."""
        learner, layout = self.learner, self.learner.layout
        experiment = not learner.learning
        exact, measured = [], []
        profile = learner.profile
        for _ in range(layout.blades):
            number, profile = learner.passages, learner.profile
            given = plant.passage(profile, number)
            loads = array_of("plant.passage", given, (4, layout.positions), finite=False)
            loads[~np.isfinite(loads)] = np.nan
            told = loads if self.sensors is None else self.sensors.read(loads)
            learner.tell(told)
            exact.append(loads)
            measured.append(told)
            self._note_passage(number, experiment, loads, told)
        whole = np.concatenate(exact, axis=1)
        ac = ac_load(exact[-1], learner.weights)
        row = {
            "rotation": learner.rotation,
            "last_passage": learner.passages - 1,
            "ac_load": ac,
            "ac_load_rotation": ac_load(whole, learner.weights),
            "ac_load_measured": ac_load(measured[-1], learner.weights),
            "mean_torque": _mean_and_rms(whole)[0][0],
            "mean_torque_last": self._passages["mean"][-1][0],
            "setpoint": learner.setpoint,
            "profile": profile,
            "missing": 1.0 - np.isfinite(np.concatenate(measured, axis=1)).mean(),
        }
        for name, value in row.items():
            self._rotations[name].append(value)
        kind = "experiment" if experiment else f"rotation {learner.rotation}"
        return f"{kind}: AC load {ac:.4g}"

    def _note_passage(
        self, number: int, experiment: bool, exact: FloatArray, measured: FloatArray
    ) -> None:
        mean, rms = _mean_and_rms(exact)
        measured_mean, measured_rms = _mean_and_rms(measured)
        row = {
            "number": number,
            "experiment": experiment,
            "mean": mean,
            "rms": rms,
            "measured_mean": measured_mean,
            "measured_rms": measured_rms,
        }
        for name, value in row.items():
            self._passages[name].append(value)

    def record(self) -> Record:
        """All that was written down."""
        practice = self.learner.experiment_passages // self.learner.layout.blades
        early = {name: rows[:practice] for name, rows in self._rotations.items()}
        late: dict[str, Any] = {name: rows[practice:] for name, rows in self._rotations.items()}
        late["profile"] = np.reshape(late["profile"], (-1, *self.learner.profile.shape))
        return Record(
            passages=PassageRecord.from_state(self._passages),
            experiment=RotationRecord.from_state(early),
            learning=RotationRecord.from_state(late),
            events=tuple(self.learner.events),
            settings=self.settings,
        )

    def state(self, plant: Plant) -> State:
        """Learner, sensors, record and a plant with a state as they are."""
        parts = {"record": self.record().state(), "learner": self.learner.state()}
        if self.sensors is not None:
            parts["sensors"] = self.sensors.state()
        if isinstance(plant, StatefulPlant):
            parts["plant"] = dict(plant.state())
        arrays = {
            f"{of}.{name}": value for of, state in parts.items() for name, value in state.items()
        }
        return arrays | {
            "format": np.array(_FORMAT),
            "settings": np.array(json.dumps(self.settings)),
        }

    def resume(self, path: Path, plant: Plant) -> None:
        """Go on from a checkpoint."""
        state = load_state(path)
        if "settings" not in state or str(state.get("format")) != _FORMAT:
            raise StateError(f"{path}: not a checkpoint of a run; it was left as it is")
        check_settings(str(path), state["settings"], self.settings)
        record = Record.from_state(part(state, "record."))
        if self.sensors is not None:
            self.sensors.restore(part(state, "sensors."))
        self.learner.restore(part(state, "learner."))
        if len(record.passages) != self.learner.passages:
            raise StateError(f"{path}: damaged, record and learner are not of the same passage")
        if isinstance(plant, StatefulPlant):
            try:
                plant.restore(part(state, "plant."))
            except ValueError as error:
                raise StateError(f"{path}: not a state of this plant ({error})") from error
        for name, column in record.passages.state().items():
            self._passages[name] = list(column)
        for name in self._rotations:
            groups = (record.experiment, record.learning)
            self._rotations[name] = [row for group in groups for row in getattr(group, name)]


def _mean_and_rms(loads: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Mean and RMS deviation of each load (4, S), NaN left out; NaN where nothing is left."""
    mean, rms = np.full((2, len(loads)), np.nan)
    seen = np.isfinite(loads).any(axis=1)
    mean[seen] = np.nanmean(loads[seen], axis=1)
    rms[seen] = np.nanstd(loads[seen], axis=1)
    return mean, rms
