"""Tables of BladeCurves: one NPZ or CSV file, written whole or not at all.

``.npz`` holds the arrays by name: ``blades``, ``azimuth`` (N,), ``beta`` (N, K), the curves
(N, K), the rates (N,) and ``mean_pitch`` if the wake was frozen.  ``.csv`` opens with a comment
line ``# blades=3`` (and ``mean_pitch=...``), then holds one row per breakpoint with the columns
``station``, ``azimuth``, ``beta`` and the curves, the rates repeated on each row of a station.
Angles in radians, moments in newton metres, forces in newtons.  ``radial`` and the rates may be
left out; so that curves made by any other code can be designed on.
"""

from __future__ import annotations

import csv
import io
import os
import tempfile
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pitchopt.errors import InputError

__all__ = ["CURVES", "RATES", "pad_row", "read_table", "write_table"]

FloatArray = NDArray[np.float64]

CURVES = ("torque", "bending", "thrust", "radial")
RATES = ("torque_rate", "bending_rate", "thrust_rate", "radial_rate")

_NEEDED = ("azimuth", "beta", "torque", "bending", "thrust")
_MAX_BYTES = 1 << 30


def pad_row(row: FloatArray, width: int) -> FloatArray:
    """Breakpoints brought to ``width`` by halving the widest intervals."""
    while row.size < width:
        gaps = np.diff(row)
        count = min(width - row.size, max(1, int(np.sum(gaps > 0.5 * gaps.max()))))
        widest = np.argsort(-gaps, kind="stable")[:count]
        row = np.sort(np.concatenate([row, 0.5 * (row[widest] + row[widest + 1])]))
    return row


def write_table(
    target: Path,
    blades: int,
    mean_pitch: float | None,
    azimuth: FloatArray,
    beta: FloatArray,
    columns: dict[str, FloatArray],
) -> Path:
    """Write curves and rates by name; the suffix of the path says how."""
    if target.suffix == ".npz":
        payload = _npz(blades, mean_pitch, azimuth, beta, columns)
    elif target.suffix == ".csv":
        payload = _csv(blades, mean_pitch, azimuth, beta, columns)
    else:
        raise InputError(f"path: got {target.name!r}, expected a name ending in .npz or .csv")
    try:
        handle, name = tempfile.mkstemp(dir=target.parent, prefix=target.name)
    except OSError as error:
        raise InputError(f"path: cannot write {target} ({error.strerror})") from error
    try:
        with os.fdopen(handle, "wb") as stream:
            stream.write(payload)
        Path(name).replace(target)
    except BaseException:
        Path(name).unlink(missing_ok=True)
        raise
    return target


def _npz(
    blades: int,
    mean_pitch: float | None,
    azimuth: FloatArray,
    beta: FloatArray,
    columns: dict[str, FloatArray],
) -> bytes:
    arrays: dict[str, Any] = dict(columns)
    if mean_pitch is not None:
        arrays["mean_pitch"] = mean_pitch
    buffer = io.BytesIO()
    np.savez_compressed(buffer, blades=blades, azimuth=azimuth, beta=beta, **arrays)
    return buffer.getvalue()


def _csv(
    blades: int,
    mean_pitch: float | None,
    azimuth: FloatArray,
    beta: FloatArray,
    columns: dict[str, FloatArray],
) -> bytes:
    text = io.StringIO()
    mean = "" if mean_pitch is None else f" mean_pitch={float(mean_pitch)!r}"
    text.write(f"# blades={blades}{mean}\n")
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(("station", "azimuth", "beta", *columns))
    for n in range(azimuth.size):
        for k in range(beta.shape[1]):
            values = [
                repr(float(array[n] if array.ndim == 1 else array[n, k]))
                for array in columns.values()
            ]
            writer.writerow((n, repr(float(azimuth[n])), repr(float(beta[n, k])), *values))
    return text.getvalue().encode()


def read_table(source: Path) -> dict[str, Any]:
    """Arguments of BladeCurves from a table; what they mean is checked there."""
    try:
        size = source.stat().st_size
    except OSError as error:
        raise InputError(f"curves file: cannot read {source} ({error.strerror})") from error
    if not source.is_file() or size == 0 or size > _MAX_BYTES:
        raise InputError(f"curves file: {source} is empty, huge or not a file ({size} bytes)")
    if source.suffix == ".npz":
        return _read_npz(source)
    if source.suffix == ".csv":
        return _read_csv(source)
    raise InputError(f"curves file: got {source.name!r}, expected .npz or .csv")


def _read_npz(source: Path) -> dict[str, Any]:
    known = {"blades", "azimuth", "beta", "mean_pitch", *CURVES, *RATES}
    try:
        with source.open("rb") as stream, np.load(stream, allow_pickle=False) as data:
            content: dict[str, Any] = {name: data[name] for name in data.files if name in known}
    except Exception as error:
        kind = type(error).__name__
        raise InputError(f"curves file: {source} is not a readable NPZ ({kind})") from error
    missing = sorted({"blades", *_NEEDED} - content.keys())
    if missing:
        raise InputError(f"curves file: {source} lacks {', '.join(missing)}")
    for name, array in content.items():
        if array.dtype.kind not in "fiu":
            raise InputError(f"{name}: {source} holds {array.dtype}, expected numbers")
    for name in ("blades", "mean_pitch"):
        if name in content:
            if content[name].size != 1:
                raise InputError(f"{name}: got shape {content[name].shape}, expected one number")
            content[name] = content[name].item()
    return content


def _read_csv(source: Path) -> dict[str, Any]:
    try:
        lines = source.read_text(encoding="utf-8").splitlines()
    except (OSError, UnicodeDecodeError) as error:
        raise InputError(f"curves file: {source} is not text ({error})") from error
    header: dict[str, str] = {}
    while lines and lines[0].startswith("#"):
        for part in lines.pop(0)[1:].split():
            name, _, value = part.partition("=")
            header[name] = value
    try:
        rows = list(csv.DictReader(lines))
    except csv.Error as error:
        raise InputError(f"curves file: {source} is not a table ({error})") from error
    missing = [name for name in ("station", *_NEEDED) if not rows or name not in rows[0]]
    if missing or "blades" not in header:
        what = "the line '# blades=3'" if not missing else "the columns " + ", ".join(missing)
        raise InputError(f"curves file: {source} lacks {what}")
    try:
        station = np.array([int(row["station"]) for row in rows])
        columns = {
            name: np.array([float(row[name]) for row in rows])
            for name in ("azimuth", "beta", *CURVES, *RATES)
            if name in rows[0]
        }
        blades = int(header["blades"])
        mean = float(header["mean_pitch"]) if "mean_pitch" in header else None
    except (TypeError, ValueError) as error:
        raise InputError(f"curves file: {source} holds something else than numbers") from error
    for name, values in columns.items():
        if not np.all(np.isfinite(values)):
            raise InputError(f"{name}: {source} holds NaN or infinite values")
    if station.min() < 0 or station.max() >= station.size:
        raise InputError(
            f"station: {source} counts from {station.min()} to {station.max()}, expected 0 to N - 1"
        )
    groups = [np.flatnonzero(station == n) for n in range(int(station.max()) + 1)]
    if any(group.size < 2 for group in groups):
        raise InputError(f"curves file: {source} needs at least two rows for every station")
    for n, group in enumerate(groups):
        if np.any(np.diff(columns["beta"][group]) <= 0):
            raise InputError(f"beta: breakpoints of station {n} in {source} must increase")
    width = max(group.size for group in groups)
    beta = np.stack([pad_row(columns["beta"][group], width) for group in groups])
    out: dict[str, Any] = {
        "blades": blades,
        "azimuth": np.array([columns["azimuth"][group[0]] for group in groups]),
        "beta": beta,
        "mean_pitch": mean,
    }
    for name in CURVES:
        if name in columns:
            out[name] = np.stack(
                [
                    np.interp(beta[n], columns["beta"][group], columns[name][group])
                    for n, group in enumerate(groups)
                ]
            )
    for name in RATES:
        if name in columns:
            out[name] = np.array([columns[name][group[0]] for group in groups])
    return out
