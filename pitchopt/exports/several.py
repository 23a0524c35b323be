"""Designs for several winds as plain data: JSON document, schedule table, arrays.

    regret   own optimum of a wind less what the profile gives in it [N m]
    cut      1 - weighted RMS / weighted RMS of this wind's best constant pitch

Angles are in degrees in JSON and CSV, in radians in the NPZ.
"""

from __future__ import annotations

import csv
import io
from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pitchopt.aero.curves import LOADS
from pitchopt.design.several_results import Several, WindResult
from pitchopt.errors import InputError
from pitchopt.exports.files import read_text

__all__ = ["read_schedule_csv", "schedule_csv", "several_document", "several_npz"]

FloatArray = NDArray[np.float64]

_AZIMUTH = "azimuth_deg"


def _wind_record(wind: WindResult) -> dict[str, Any]:
    return {
        "label": wind.label,
        "weight": wind.weight,
        "constant_pitch_deg": float(np.rad2deg(wind.constant.profile.mean())),
        "constant_mean_torque": wind.constant.mean_torque,
        "constant_rms_weighted": wind.constant.rms_weighted,
        "mean_torque": wind.mean_torque,
        "rms": dict(zip(LOADS, map(float, wind.loads.rms), strict=True)),
        "rms_weighted": wind.rms_weighted,
        "blade_rms": wind.loads.blade_rms,
        "cut": wind.cut,
        "objective": wind.objective,
        "own_objective": wind.own_objective,
        "regret": wind.regret,
    }


def several_document(
    case: str, settings: Mapping[str, Any], result: Several, seconds: float
) -> dict[str, Any]:
    """Everything about a design for several winds, its profiles included."""
    return {
        "case": case,
        "settings": dict(settings),
        "goal": result.goal,
        "objective": result.objective,
        "upper_bound": result.upper_bound,
        "gap": result.gap,
        "largest_regret": result.largest_regret,
        "max_change_deg": None if np.isinf(result.change) else float(np.rad2deg(result.change)),
        "largest_change_deg": float(np.rad2deg(result.largest_change)),
        "status": result.status.value,
        "message": result.message,
        "start": result.start,
        "iterations": result.iterations,
        "winds": [_wind_record(wind) for wind in result.winds],
        "azimuth_deg": np.rad2deg(result.azimuth),
        "pitch_deg": np.rad2deg(result.profiles),
        "seconds": seconds,
    }


def schedule_csv(result: Several) -> str:
    """Table of a controller: azimuth_deg, then one column of pitch [deg] for each wind.

    One profile for several winds has one column, ``pitch_deg all winds``.
    """
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    labels = [wind.label for wind in result.winds]
    if result.profiles.shape[0] < len(labels):
        labels = ["all winds"]
    writer.writerow([_AZIMUTH, *(f"pitch_deg {label}" for label in labels)])
    for row in np.rad2deg(np.column_stack([result.azimuth, result.profiles.T])):
        writer.writerow([repr(float(value)) for value in row])
    return text.getvalue()


def read_schedule_csv(path: Any) -> tuple[FloatArray, FloatArray, tuple[str, ...]]:
    """Azimuth (N,), profiles (S, N) [rad] and labels of a table of :func:`schedule_csv`.

    Raises
    ------
    InputError
        If the file is not such a table.
    """
    rows = list(csv.reader(io.StringIO(read_text(path, "schedule file"))))
    head = "pitch_deg "
    try:
        names = rows[0]
        table = np.deg2rad(np.array(rows[1:], dtype=np.float64))
        good = names[0] == _AZIMUTH and all(name.startswith(head) for name in names[1:])
        good = good and table.shape[0] > 0 and table.shape[1] == len(names) > 1
    except (IndexError, ValueError) as error:
        raise InputError(f"schedule file: {path} is not a table of numbers ({error})") from error
    if not good or not np.all(np.isfinite(table)):
        raise InputError(
            f"schedule file: {path} needs the columns {_AZIMUTH} and 'pitch_deg LABEL', finite "
            "numbers and at least one row"
        )
    return table[:, 0], table[:, 1:].T, tuple(name.removeprefix(head) for name in names[1:])


def several_npz(result: Several) -> bytes:
    """Content of an NPZ file: azimuth, profiles, own_profiles [rad], loads and values by wind."""
    buffer = io.BytesIO()
    np.savez_compressed(
        buffer,
        azimuth=result.azimuth,
        profiles=result.profiles,
        own_profiles=np.stack([wind.own_profile for wind in result.winds]),
        labels=np.array([wind.label for wind in result.winds]),
        weights=np.array([wind.weight for wind in result.winds]),
        rotor_loads=np.stack([wind.loads.rotor for wind in result.winds]),
        bending=np.stack([wind.loads.bending for wind in result.winds]),
        objective=np.array([wind.objective for wind in result.winds]),
        own_objective=np.array([wind.own_objective for wind in result.winds]),
    )
    return buffer.getvalue()
