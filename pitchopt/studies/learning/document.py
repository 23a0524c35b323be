"""A learning run as plain data: the JSON document and the CSV table of ``pitchopt learn``.

Loads are in N m and N, angles in degrees.  What does not exist is null, never NaN.  Two clocks:
`rotation` and `passage` (a B-th of a rotation, the learner's iteration), both counted from the end
of the experiment.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from ilc import LOADS
from pitchopt.errors import InputError
from pitchopt.exports.profiles import ProfileSet, profile_set
from pitchopt.exports.records import records_csv
from pitchopt.studies.learning.figures import ProfileFigures
from pitchopt.studies.learning.references import Reference
from pitchopt.studies.learning.result import LearningResult

__all__ = ["learned_profiles", "learning_csv", "learning_document"]

_EARLY, _LATE = 10, 20  # rotations at which runs are compared


def learning_document(result: LearningResult, settings: Mapping[str, Any]) -> dict[str, Any]:
    """Everything about a run.

    Parameters
    ----------
    result : LearningResult
    settings : mapping
        Of the case, as plain data; those of the learning are added to it.
    """
    learned = {
        **_held(result.learned),
        "azimuth_deg": np.rad2deg(result.azimuth),
        "pitch_deg": np.rad2deg(result.learned.profile),
    }
    drifts = any(stretch.mean_wind for stretch in result.stretches)
    after, ref_after = result.design_after, result.reference_after
    constant_after = result.baseline_after
    return {
        "case": result.case.name,
        "settings": {**settings, "learning": result.settings.plain()},
        "learner": result.settings.learner,
        "experiment": {
            "rotations": result.practice,
            "passages": result.practice * result.case.blades,
            "rms_sum": result.experiment_rms.sum(axis=1),
            "largest_move_deg": float(np.rad2deg(result.largest_move)),
        },
        "rotations": [_rotation(result, row) for row in range(result.record.rotations)],
        "baseline": _constant(result.baseline),
        "baseline_after": None if constant_after is None else _constant(constant_after),
        "start": _constant(result.start),
        "design": _design(result.design, result.reference, mean_wind=drifts),
        "design_after": None
        if after is None or ref_after is None
        else _design(after, ref_after, mean_wind=False),
        "cut_at_20": result.cut(_LATE),
        "ratio_to_design": _at(result.ratio),
        "ratio_to_design_rotation": _at(result.ratio_rotation),
        "ratio_to_design_from_start": _at(result.ratio_from_start),
        "recovery_rotations": result.recovery_rotations,
        "passages": _passages(result),
        "learned": learned,
        "events": [
            {"passage": passage, "rotation": rotation, "text": text}
            for passage, rotation, text in result.events
        ],
        "setpoint_after": result.setpoint_after,
        "seconds": result.seconds,
    }


def learning_csv(document: Mapping[str, Any]) -> str:
    """The rotations of a document as a table, one row each."""
    return records_csv(document["rotations"])


def learned_profiles(result: LearningResult, settings: Mapping[str, Any]) -> ProfileSet:
    """The learned profile beside the references of the last wind, as ``pitchopt export`` takes it.

    Raises
    ------
    InputError
        If each blade has a profile of its own.
    """
    learned = result.learned
    if learned.profile.ndim != 1:
        raise InputError("profiles: got one for each blade, expected one for all")
    ref = result.reference_after or result.reference
    known = profile_set(
        ref.best,
        ref.power_max,
        [ref.design],
        blades=result.case.blades,
        rotor_speed=result.rotor_speed,
        settings={"case": result.case.name, **settings},
    )
    return replace(
        known,
        profiles=np.vstack([known.profiles, learned.profile]),
        labels=(*known.labels, "learned"),
        mu=np.append(known.mu, np.nan),
        target=np.append(known.target, np.nan),
        rotor=np.concatenate([known.rotor, learned.loads[None]]),
        bending=np.concatenate([known.bending, learned.bending[:1]]),
    )


def _at(ratio: Any) -> dict[str, float | None]:
    return {"at_10": ratio(_EARLY), "at_20": ratio(_LATE)}


def _rotation(result: LearningResult, row: int) -> dict[str, Any]:
    """One rotation; its RMS values are those of the last passage."""
    learning, rms = result.record.learning, result.rms[row]
    return {
        "rotation": int(learning.rotation[row]),
        "passage": int(learning.rotation[row]) * result.case.blades,
        "rms_sum": float(rms.sum()),
        "rms": dict(zip(LOADS, map(float, rms), strict=True)),
        "rms_weighted": float(learning.ac_load[row]),
        "rms_weighted_rotation": float(learning.ac_load_rotation[row]),
        "rms_measured_weighted": float(learning.ac_load_measured[row]),
        "mean_torque": float(learning.mean_torque[row]),
        "setpoint": float(learning.setpoint[row]),
        "wind_speed": float(result.winds[row]),
        "ratio_to_design": result.ratio(int(learning.rotation[row])),
        "ratio_to_design_rotation": result.ratio_rotation(int(learning.rotation[row])),
    }


def _passages(result: LearningResult) -> dict[str, list[float]]:
    """The other clock: sum of RMS and mean torque of every passage after the experiment."""
    passages = result.record.passages
    after = ~passages.experiment
    return {
        "rms_sum": passages.rms[after].sum(axis=1).tolist(),
        "mean_torque": passages.mean[after, 0].tolist(),
    }


def _held(figures: ProfileFigures) -> dict[str, Any]:
    torque, tilt, yaw, thrust = (float(value) for value in figures.mean)
    return {
        "mean_torque": torque,
        "rms": figures.rms,
        "rms_sum": figures.rms_sum,
        "rms_weighted": figures.rms_weighted,
        "rms_weighted_rotation": figures.rms_weighted_rotation,
        "blade_rms": figures.blade_rms,
        "mean_tilt": tilt,
        "mean_yaw": yaw,
        "mean_thrust": thrust,
        "mean_pitch_deg": float(np.rad2deg(figures.mean_pitch)),
        "pitch_travel_deg": float(np.rad2deg(figures.pitch_travel)),
        "outside": figures.outside,
    }


def _constant(figures: ProfileFigures) -> dict[str, Any]:
    return {"pitch_deg": float(np.rad2deg(figures.mean_pitch)), **_held(figures)}


def _design(figures: ProfileFigures, ref: Reference, *, mean_wind: bool) -> dict[str, Any]:
    return {
        "wind_speed": ref.wind_speed,
        "at_mean_wind": mean_wind,
        "setpoint": ref.setpoint,
        **_held(figures),
        "status": ref.design.status.value,
        "message": ref.design.message,
    }
