"""Record: what happened in a run, on both clocks.

A passage is a turn by 2 pi / B; B passages are one rotation.  Passages are numbered from 0 at the
start of the experiment; rotations are 1, 2, ... R after the experiment, and 0, -1, ... backwards
within it, so that rotation r ends with passage `last_passage` of its row.

The weighted AC load of samples y is the sum over the loads of weight x RMS(y - mean y).  That of
the last passage of a rotation, `ac_load`, belongs to the one profile in use there; that of all
samples of the rotation, `ac_load_rotation`, includes what changed from passage to passage.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass, fields
from types import MappingProxyType
from typing import Any, ClassVar, Self

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ilc._checks import FloatArray, IntArray, count, number
from ilc.errors import LearningError, StateError
from ilc.storage import part

__all__ = ["PassageRecord", "Record", "RotationRecord"]


class _Columns:
    """Arrays with one row for each passage or rotation, made read-only copies."""

    _types: ClassVar[Mapping[str, type]] = MappingProxyType({})
    """Types of the columns that are not of floats."""

    def __post_init__(self) -> None:
        lengths = set()
        for name in self.columns():
            column: ArrayLike = getattr(self, name)
            array: np.ndarray = np.array(column, dtype=self._types.get(name, np.float64))
            array.flags.writeable = False
            object.__setattr__(self, name, array)
            lengths.add(array.shape[:1])
        if len(lengths) != 1 or not max(lengths):
            raise LearningError(f"{type(self).__name__}: expected columns of equal length")

    @classmethod
    def columns(cls) -> list[str]:
        """Names of the columns."""
        return [field.name for field in fields(cls)]  # type: ignore[arg-type]

    def __len__(self) -> int:
        return len(getattr(self, self.columns()[0]))

    def state(self) -> dict[str, np.ndarray]:
        """The columns by name."""
        return {name: getattr(self, name) for name in self.columns()}

    @classmethod
    def from_state(cls, state: Mapping[str, ArrayLike]) -> Self:
        """The columns from what :meth:`state` gave."""
        return cls(**{name: state[name] for name in cls.columns()})


@dataclass(frozen=True, kw_only=True, eq=False)
class PassageRecord(_Columns):
    """One row for each passage, of the experiment and after.

    Attributes
    ----------
    number : ndarray (n,)
        Passages made before, since the start.
    experiment : ndarray (n,) of bool
        Whether it belongs to the experiment.
    mean, rms : ndarray (n, 4)
        Mean and RMS deviation of each exact load over the passage [N m, N].
    measured_mean, measured_rms : ndarray (n, 4)
        The same of the measured loads; NaN where nothing was measured.
    """

    number: IntArray
    experiment: NDArray[np.bool_]
    mean: FloatArray
    rms: FloatArray
    measured_mean: FloatArray
    measured_rms: FloatArray

    _types = MappingProxyType({"number": np.intp, "experiment": np.bool_})


@dataclass(frozen=True, kw_only=True, eq=False)
class RotationRecord(_Columns):
    """One row for each whole rotation.

    Attributes
    ----------
    rotation : ndarray (R,)
        1, 2, ... after the experiment; 0, -1, ... backwards within it.
    last_passage : ndarray (R,)
        Number of the passage with which it ends.
    ac_load : ndarray (R,)
        Weighted AC load of the exact loads of the last passage.
    ac_load_rotation : ndarray (R,)
        The same of all B m samples of the rotation.
    ac_load_measured : ndarray (R,)
        Weighted AC load of the measured loads of the last passage; NaN if a load that has a weight
        was measured at less than half of the samples.
    mean_torque : ndarray (R,)
        Mean of the exact torque over the rotation [N m].
    mean_torque_last : ndarray (R,)
        The same over the last passage [N m].
    setpoint : ndarray (R,)
        Mean torque asked for during the rotation [N m].
    profile : ndarray (R, N) or (R, B, N)
        Pitch in the last passage [rad]; `ac_load` belongs to it.
    missing : ndarray (R,)
        Share of the rotation's samples that were not measured.
    """

    rotation: IntArray
    last_passage: IntArray
    ac_load: FloatArray
    ac_load_rotation: FloatArray
    ac_load_measured: FloatArray
    mean_torque: FloatArray
    mean_torque_last: FloatArray
    setpoint: FloatArray
    profile: FloatArray
    missing: FloatArray

    _types = MappingProxyType({"rotation": np.intp, "last_passage": np.intp})


@dataclass(frozen=True, kw_only=True, eq=False)
class Record:
    """A run of a learner on a plant.

    Attributes
    ----------
    passages : PassageRecord
        Every passage.
    experiment : RotationRecord
        The rotations of the experiment.
    learning : RotationRecord
        The rotations after it, 1 to R.
    events : tuple of (int, str)
        What the learner said, with the passage at which it did.
    settings : mapping
        Settings of learner, sensors and plant, as plain data.
    """

    passages: PassageRecord
    experiment: RotationRecord
    learning: RotationRecord
    events: tuple[tuple[int, str], ...]
    settings: Mapping[str, Any]

    def __post_init__(self) -> None:
        events = tuple((int(passage), str(text)) for passage, text in self.events)
        object.__setattr__(self, "events", events)
        object.__setattr__(self, "settings", MappingProxyType(dict(self.settings)))

    @property
    def rotations(self) -> int:
        """R, learning rotations made."""
        return len(self.learning)

    def ratio(self, rotation: int, reference: float) -> float:
        """AC load of a rotation over a reference, such as that of another design.

        Parameters
        ----------
        rotation : int
            1 to R.
        reference : float
            Weighted AC load, above 0.
        """
        if count("rotation", rotation, at_least=1) > self.rotations:
            raise LearningError(
                f"rotation: got {rotation}, expected at most the {self.rotations} of the record"
            )
        return float(self.learning.ac_load[rotation - 1] / number("reference", reference, above=0))

    def cut_at(self, rotation: int, baseline: float) -> float:
        """Share of a baseline's AC load that is gone at a rotation, 0.9 for 90 %.

        Parameters
        ----------
        rotation : int
            1 to R.
        baseline : float
            Weighted AC load, above 0, such as that of the starting pitch.
        """
        return 1.0 - self.ratio(rotation, number("baseline", baseline, above=0))

    def state(self) -> dict[str, np.ndarray]:
        """Everything as arrays for one NPZ file; :meth:`from_state` makes the record of them."""
        groups = {
            "passages": self.passages,
            "experiment": self.experiment,
            "learning": self.learning,
        }
        columns = {
            f"{group}.{name}": value
            for group, record in groups.items()
            for name, value in record.state().items()
        }
        return columns | {
            "events": np.array(json.dumps(self.events)),
            "settings": np.array(json.dumps(dict(self.settings))),
        }

    @classmethod
    def from_state(cls, state: Mapping[str, np.ndarray]) -> Record:
        """The record from what :meth:`state` gave.

        Raises
        ------
        StateError
            If something is missing or damaged.
        """
        try:
            return cls(
                passages=PassageRecord.from_state(part(state, "passages.")),
                experiment=RotationRecord.from_state(part(state, "experiment.")),
                learning=RotationRecord.from_state(part(state, "learning.")),
                events=tuple(json.loads(str(state["events"]))),
                settings=json.loads(str(state["settings"])),
            )
        except (KeyError, ValueError, TypeError) as error:
            raise StateError(f"record: damaged or not a record's state ({error})") from error
