"""Sets of pitch profiles: the content of ``profiles.npz``, and one profile as a CSV table.

Profiles share their azimuth stations.  Row 0 is the best constant pitch, row 1 the power
maximum, the rows after them are the points of a trade-off curve in its order, or one design.
Angles are in radians in the NPZ and in degrees in the CSV; loads in N m and N; pitch is positive
towards feather; azimuth 0 is the blade up, growing clockwise seen from upwind.
"""

from __future__ import annotations

import csv
import io
import json
import os
import re
import zipfile
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from pitchopt.design.results import Design, Tradeoff
from pitchopt.errors import InputError
from pitchopt.exports.files import read_text, write_whole

__all__ = ["ProfileSet", "label_of", "profile_csv", "profile_set", "read_profile_csv"]

FloatArray = NDArray[np.float64]

MAX_BYTES = 1 << 30
_REFERENCES = ("constant", "power_max")
_LOSS = re.compile(r"loss\s*=\s*(.+)")


def label_of(design: Design) -> str:
    """Name of a design in tables and files: ``mu=3.16``, ``loss=3%``, ``torque=1.2e+06``."""
    if design.kind == "mu":
        return f"mu={design.mu:.4g}"
    if design.kind == "max_power_loss" and design.target is not None:
        return f"loss={100 * design.target:.4g}%"
    if design.kind == "mean_torque" and design.target is not None:
        return f"torque={design.target:.6g}"
    return design.kind


@dataclass(frozen=True, kw_only=True, eq=False)
class ProfileSet:
    """Profiles over the same stations, with their loads.

    Parameters
    ----------
    azimuth : array (N,)
        Stations [rad].
    profiles : array (P, N)
        Pitch [rad].
    labels : sequence of str (P,)
        ``constant``, ``power_max``, then one per point.
    mu, target : array (P,)
        Price of RMS, and the loss or torque asked for; NaN where there is none.
    rotor : array (P, 4, m)
        Torque, tilt, yaw [N m] and thrust [N] over the positions.
    bending : array (P, N)
        Bending moment of one blade over the turn [N m].
    blades : int
        Number of blades.
    rotor_speed : float
        [rad/s].
    knee : int or None
        Index of the knee among the points (not counting the two references).
    settings : mapping
        Case and options that the profiles were made with; plain JSON data.
    """

    azimuth: FloatArray
    profiles: FloatArray
    labels: tuple[str, ...]
    mu: FloatArray
    target: FloatArray
    rotor: FloatArray
    bending: FloatArray
    blades: int
    rotor_speed: float
    knee: int | None = None
    settings: Mapping[str, Any] = field(default_factory=dict)

    def __post_init__(self) -> None:
        for name in ("azimuth", "profiles", "mu", "target", "rotor", "bending"):
            value = np.array(getattr(self, name), dtype=np.float64)
            value.setflags(write=False)
            object.__setattr__(self, name, value)
        object.__setattr__(self, "labels", tuple(str(label) for label in self.labels))
        stations, rows = self.azimuth.size, len(self.labels)
        if isinstance(self.blades, bool) or self.blades < 1 or stations % self.blades:
            raise InputError(
                f"blades: got {self.blades}, expected a divisor of the {stations} stations"
            )
        expected: dict[str, tuple[int, ...]] = {
            "azimuth": (stations,),
            "profiles": (rows, stations),
            "mu": (rows,),
            "target": (rows,),
            "rotor": (rows, 4, stations // self.blades),
            "bending": (rows, stations),
        }
        for name, shape in expected.items():
            if getattr(self, name).shape != shape:
                raise InputError(f"{name}: got shape {getattr(self, name).shape}, expected {shape}")
        for name in ("azimuth", "profiles", "rotor", "bending"):
            if not np.all(np.isfinite(getattr(self, name))):
                raise InputError(f"{name}: holds NaN or infinite values")
        if not np.isfinite(self.rotor_speed) or self.rotor_speed <= 0:
            raise InputError(f"rotor_speed: got {self.rotor_speed} rad/s, expected more than 0")
        if self.labels[:2] != _REFERENCES:
            raise InputError(f"labels: got {self.labels[:2]}, expected to begin with {_REFERENCES}")

    @property
    def points(self) -> int:
        """Number of points besides the two references."""
        return len(self.labels) - 2

    def row(self, point: str | int) -> int:
        """Row of a profile by name.

        Parameters
        ----------
        point : str or int
            Index of a point from 0, ``knee``, ``constant``, ``power_max``, ``loss=3%`` (also
            ``loss=0.03``) or a label as in the table.

        Raises
        ------
        InputError
            If there is no such profile.
        """
        text = str(point).strip()
        if re.fullmatch(r"[+-]?\d+", text):
            index = int(text)
            if not 0 <= index < self.points:
                raise InputError(f"point: got {index}, expected 0 to {self.points - 1}")
            return index + 2
        if text == "knee":
            if self.knee is None:
                raise InputError("point: these profiles have no knee; they hold " + self._held())
            return self.knee + 2
        if text in self.labels:
            return self.labels.index(text)
        loss = _LOSS.fullmatch(text)
        if loss:
            share = _share(loss.group(1))
            for row, (label, target) in enumerate(zip(self.labels, self.target, strict=True)):
                if label.startswith("loss=") and share is not None and abs(target - share) < 1e-9:
                    return row
        raise InputError(f"point: got {text!r}, expected an index or one of {self._held()}")

    def _held(self) -> str:
        knee = () if self.knee is None else ("knee",)
        return ", ".join((*knee, *self.labels))

    def to_bytes(self) -> bytes:
        """Content of the NPZ file."""
        buffer = io.BytesIO()
        np.savez_compressed(
            buffer,
            azimuth=self.azimuth,
            profiles=self.profiles,
            labels=np.array(self.labels),
            mu=self.mu,
            target=self.target,
            rotor_loads=self.rotor,
            bending=self.bending,
            blades=self.blades,
            rotor_speed=self.rotor_speed,
            knee=-1 if self.knee is None else self.knee,
            settings=np.array(json.dumps(self.settings, allow_nan=False)),
        )
        return buffer.getvalue()

    def save(self, path: str | os.PathLike[str]) -> Path:
        """Write the NPZ file whole or not at all."""
        return write_whole(path, self.to_bytes())

    @classmethod
    def load(cls, path: str | os.PathLike[str]) -> ProfileSet:
        """Read a file that :meth:`save` wrote.

        Raises
        ------
        InputError
            If the file is missing, empty, huge or something else.
        """
        source = Path(path)
        shown = str(source)
        try:
            size = source.stat().st_size if source.is_file() else None
        except (OSError, ValueError):
            size = None
        if size is None:
            raise InputError(f"profiles file: got {shown!r} (no such file), expected profiles.npz")
        if not 0 < size <= MAX_BYTES:
            raise InputError(f"profiles file: {shown!r} is empty or huge ({size} bytes)")
        try:
            with source.open("rb") as stream, np.load(stream, allow_pickle=False) as data:
                held = {name: data[name] for name in data.files}
            knee = int(held["knee"])
            return cls(
                azimuth=held["azimuth"],
                profiles=held["profiles"],
                labels=tuple(map(str, held["labels"].tolist())),
                mu=held["mu"],
                target=held["target"],
                rotor=held["rotor_loads"],
                bending=held["bending"],
                blades=int(held["blades"]),
                rotor_speed=float(held["rotor_speed"]),
                knee=None if knee < 0 else knee,
                settings=json.loads(str(held["settings"])),
            )
        except InputError as error:
            raise InputError(f"profiles file: {shown!r}: {error}") from error
        except (OSError, ValueError, KeyError, TypeError, EOFError, zipfile.BadZipFile) as error:
            what = "not an .npz file" if "pickle" in str(error) else error  # numpy's advice is bad
            raise InputError(
                f"profiles file: {shown!r} is not a profiles.npz of pitchopt ({what})"
            ) from error


def _share(text: str) -> float | None:
    percent = text.strip().endswith("%")
    try:
        value = float(text.strip().rstrip("%"))
    except ValueError:
        return None
    return value / 100 if percent else value


def profile_set(
    constant: Design,
    power_max: Design,
    points: Sequence[Design],
    *,
    blades: int,
    rotor_speed: float,
    knee: int | None = None,
    settings: Mapping[str, Any] | None = None,
) -> ProfileSet:
    """Profiles of a computation; see :class:`ProfileSet`."""
    designs = (constant, power_max, *points)
    return ProfileSet(
        azimuth=constant.azimuth,
        profiles=np.stack([d.profile for d in designs]),
        labels=(*_REFERENCES, *(label_of(d) for d in points)),
        mu=np.array([np.nan, np.nan, *(d.mu for d in points)]),
        target=np.array([np.nan if d.target is None else d.target for d in designs]),
        rotor=np.stack([d.loads.rotor for d in designs]),
        bending=np.stack([d.loads.bending for d in designs]),
        blades=blades,
        rotor_speed=rotor_speed,
        knee=knee,
        settings=dict(settings or {}),
    )


def tradeoff_profiles(
    result: Tradeoff, *, blades: int, rotor_speed: float, settings: Mapping[str, Any] | None = None
) -> ProfileSet:
    """Profiles of a trade-off curve."""
    return profile_set(
        result.constant,
        result.power_max,
        result.points,
        blades=blades,
        rotor_speed=rotor_speed,
        knee=result.knee,
        settings=settings,
    )


def profile_csv(azimuth: ArrayLike, profile: ArrayLike, *, rotor_speed: float) -> str:
    """One profile as a table: azimuth_deg, pitch_deg, pitch_rate_deg_s.

    The rate is the central difference at the station; between stations the profile is a
    straight line.
    """
    psi = np.asarray(azimuth, dtype=np.float64)
    beta = np.asarray(profile, dtype=np.float64)
    if psi.ndim != 1 or psi.size == 0 or beta.shape != psi.shape:
        raise InputError(f"profile: got shape {beta.shape}, expected {psi.shape} as azimuth has")
    spacing = 2 * np.pi / psi.size
    rate = rotor_speed * (np.roll(beta, -1) - np.roll(beta, 1)) / (2 * spacing)
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(("azimuth_deg", "pitch_deg", "pitch_rate_deg_s"))
    for row in zip(*map(np.rad2deg, (psi, beta, rate)), strict=True):
        writer.writerow([repr(float(value)) for value in row])
    return text.getvalue()


def read_profile_csv(path: str | os.PathLike[str]) -> tuple[FloatArray, FloatArray]:
    """Azimuth and pitch [rad] of a table that :func:`profile_csv` made, each (N,)."""
    rows = list(csv.DictReader(io.StringIO(read_text(path, "profile file"))))
    try:
        azimuth = np.deg2rad([float(row["azimuth_deg"]) for row in rows])
        pitch = np.deg2rad([float(row["pitch_deg"]) for row in rows])
    except (KeyError, TypeError, ValueError) as error:
        raise InputError(
            f"profile file: {path} needs the columns azimuth_deg and pitch_deg with numbers"
        ) from error
    if azimuth.size == 0 or not (np.isfinite(azimuth).all() and np.isfinite(pitch).all()):
        raise InputError(f"profile file: {path} needs finite numbers and at least one row")
    return azimuth, pitch
