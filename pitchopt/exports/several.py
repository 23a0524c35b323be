"""Designs for several winds as plain data: JSON document, schedule table, arrays.

    regret   own optimum of a wind less what the profile gives in it [N m]
    cut      1 - weighted RMS / weighted RMS of this wind's best constant pitch

Angles are in degrees in JSON and CSV, in radians in the NPZ.
"""

from __future__ import annotations

import csv
import io
import json
import os
import zipfile
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pitchopt.aero.curves import LOADS
from pitchopt.checks import finite_array, whole_number
from pitchopt.design.several_results import Several, WindResult
from pitchopt.errors import InputError
from pitchopt.exports.files import read_text

__all__ = [
    "SeveralProfiles",
    "read_schedule_csv",
    "read_several_npz",
    "schedule_csv",
    "several_document",
    "several_npz",
]

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


@dataclass(frozen=True, kw_only=True, eq=False)
class SeveralProfiles:
    """Profiles for several winds, as `robust.npz` and `schedule.npz` hold them.

    Parameters
    ----------
    azimuth : array (N,)
        Stations [rad].
    profiles : array (S, N)
        Pitch [rad]; one row for all winds, or one for each.
    labels : sequence of str (W,)
        Of the winds.
    rotor_speeds : array (W,)
        [rad/s].
    blades : int
    settings : mapping
        Case and options; plain JSON data.
    """

    azimuth: FloatArray
    profiles: FloatArray
    labels: tuple[str, ...]
    rotor_speeds: FloatArray
    blades: int
    settings: Mapping[str, Any] = field(default_factory=dict)

    def __post_init__(self) -> None:
        azimuth = finite_array("azimuth", self.azimuth)
        winds, stations = len(self.labels), azimuth.size
        rows = np.shape(self.profiles)[0] if np.ndim(self.profiles) == 2 else 0
        if rows not in (1, winds):
            raise InputError(f"profiles: got {rows} rows for {winds} winds, expected 1 or {winds}")
        profiles = finite_array("profiles", self.profiles, shape=(rows, stations))
        speeds = finite_array("rotor_speeds", self.rotor_speeds, shape=(winds,))
        if np.any(speeds <= 0.0):
            raise InputError(f"rotor_speeds: got {speeds.min():g} rad/s, expected more than 0")
        whole_number("blades", self.blades, at_least=1)
        for name, value in (("azimuth", azimuth), ("profiles", profiles), ("rotor_speeds", speeds)):
            object.__setattr__(self, name, value)
        object.__setattr__(self, "labels", tuple(map(str, self.labels)))

    def wind(self, point: str | int | None) -> int:
        """Number of a wind by its label or its number from 0; None for the only one there is.

        One profile for all winds needs none either if they share a rotor speed.

        Raises
        ------
        InputError
            Naming the winds, if there is no such one.
        """
        if point is None:
            alike = np.ptp(self.rotor_speeds) <= 1e-9 * self.rotor_speeds[0]
            if self.profiles.shape[0] == 1 and alike:
                return 0
            what = "profile" if self.profiles.shape[0] > 1 else "rotor speed"
            raise InputError(
                f"point: got nothing, expected the wind whose {what} it is: one of "
                + ", ".join(self.labels)
            )
        text = str(point).strip()
        if text in self.labels:
            return self.labels.index(text)
        if text.isdigit() and int(text) < len(self.labels):
            return int(text)
        raise InputError(
            f"point: got {text!r}, expected a number from 0 to {len(self.labels) - 1} or one of "
            f"{', '.join(self.labels)}"
        )

    def profile(self, wind: int) -> FloatArray:
        """Pitch in a wind (N,) [rad]."""
        return np.asarray(self.profiles[wind if self.profiles.shape[0] > 1 else 0])


def several_npz(
    result: Several,
    *,
    rotor_speeds: Sequence[float],
    blades: int,
    settings: Mapping[str, Any] | None = None,
) -> bytes:
    """Content of an NPZ file: azimuth, profiles, own_profiles [rad], loads and values by wind.

    Parameters
    ----------
    result : Several
    rotor_speeds : sequence of float (W,)
        Of the winds [rad/s].
    blades : int
    settings : mapping, optional
        Plain JSON data.
    """
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
        rotor_speeds=np.array(rotor_speeds, dtype=np.float64),
        blades=blades,
        settings=np.array(json.dumps(dict(settings or {}), allow_nan=False)),
    )
    return buffer.getvalue()


def read_several_npz(path: str | os.PathLike[str]) -> SeveralProfiles:
    """Profiles of a file of :func:`several_npz`.

    Raises
    ------
    InputError
        If the file is missing or something else.
    """
    shown = os.fspath(path)
    try:
        with Path(path).open("rb") as stream, np.load(stream, allow_pickle=False) as data:
            names = ("azimuth", "profiles", "labels", "rotor_speeds", "blades", "settings")
            missing = [name for name in names if name not in data.files]
            if missing:
                raise InputError(
                    f"holds no {', '.join(missing)}, expected a file of this version's pitchopt "
                    "robust or schedule; run the command again"
                )
            held = {name: data[name] for name in names}
        return SeveralProfiles(
            azimuth=held["azimuth"],
            profiles=held["profiles"],
            labels=tuple(held["labels"].tolist()),
            rotor_speeds=held["rotor_speeds"],
            blades=int(held["blades"]),
            settings=json.loads(str(held["settings"])),
        )
    except InputError as error:
        raise InputError(f"profiles file: {shown!r}: {error}") from error
    except (OSError, ValueError, TypeError, EOFError, zipfile.BadZipFile) as error:
        raise InputError(
            f"profiles file: {shown!r} is not an .npz of pitchopt robust or schedule ({error})"
        ) from error
