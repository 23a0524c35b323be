"""CSV files that hold the wind speed on a regular grid over the rotor disc.

A comma-separated text file, one header line, one row per grid point, in any order of rows and
columns; blank lines and lines that start with ``#`` are skipped. Two layouts:

    y,z,speed                    Cartesian, hub-centred [m], y left looking downwind, z up
    radius,azimuth_deg,speed     polar, [m] and degrees, azimuth 0 up, growing clockwise seen
                                 from upwind: y = -radius sin, z = radius cos

Speeds in m/s, not negative. Every combination of the two coordinates occurs exactly once. An
azimuth of 360 may repeat azimuth 0 with the same speed.
"""

from __future__ import annotations

import csv
import io
import os
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from windfield._checks import FloatArray
from windfield._files import write_whole
from windfield.errors import WindFieldError

__all__ = ["CARTESIAN", "MAX_BYTES", "POLAR", "DiscTable", "read_disc_csv", "write_disc_csv"]

MAX_BYTES = 16 * 2**20
CARTESIAN = ("y", "z", "speed")
POLAR = ("radius", "azimuth_deg", "speed")
EXPECTED = f"'{','.join(CARTESIAN)}' or '{','.join(POLAR)}'"


@dataclass(frozen=True, eq=False)
class DiscTable:
    """Content of a file: column names, the two grid axes as written, speed (n0, n1) [m/s]."""

    columns: tuple[str, str, str]
    first: FloatArray
    second: FloatArray
    speed: FloatArray


def read_disc_csv(path: str | os.PathLike[str]) -> DiscTable:
    """Read a gridded disc profile.

    Raises
    ------
    WindFieldError
        If the file is missing, empty, binary or larger than 16 MiB, has another header, a row
        that is not three finite numbers, a negative speed, or does not form a full grid.
    """
    name = str(Path(path))
    lines = _text(Path(path), name).splitlines()
    numbered = [
        (k, line) for k, line in enumerate(lines, 1) if line.strip() and line.lstrip()[0] != "#"
    ]
    if not numbered:
        raise WindFieldError(f"{name}: file is empty; must have a header {EXPECTED} and rows")
    header = [cell.strip().lower() for cell in numbered[0][1].split(",")]
    for columns in (CARTESIAN, POLAR):
        if sorted(header) == sorted(columns):
            break
    else:
        raise WindFieldError(
            f"{name}: got header '{numbered[0][1].strip()[:80]}'; must be {EXPECTED}"
        )
    rows = np.array([_row(name, k, line) for k, line in numbered[1:]], dtype=np.float64)
    if not rows.size:
        raise WindFieldError(f"{name}: got a header without rows; must have a row per grid point")
    data = rows[:, [header.index(column) for column in columns]]
    lowest = data[:, 2].min()
    if lowest < 0.0:
        raise WindFieldError(f"{name}: got speed {lowest:g}; must be >= 0 [m/s]")
    return _grid(name, columns, data)


def write_disc_csv(
    path: str | os.PathLike[str],
    columns: tuple[str, str, str],
    first: FloatArray,
    second: FloatArray,
    speed: FloatArray,
) -> None:
    """Write a gridded disc profile with full precision; whole or not at all.

    Raises
    ------
    WindFieldError
        If the file cannot be written there.
    """
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(columns)
    for i, a in enumerate(first.tolist()):
        for b, value in zip(second.tolist(), speed[i].tolist(), strict=True):
            writer.writerow((repr(a), repr(b), repr(value)))
    write_whole(Path(path), lambda stream: stream.write(text.getvalue().encode("utf-8")))


def _text(path: Path, name: str) -> str:
    try:
        if not path.is_file():
            kind = "a folder or device" if path.exists() else "no such file"
            raise WindFieldError(f"{name}: got {kind}; must be a CSV file")
        size = path.stat().st_size
        if size > MAX_BYTES:
            raise WindFieldError(
                f"{name}: got a file of {size / 2**20:.1f} MiB; must be at most "
                f"{MAX_BYTES // 2**20} MiB"
            )
        raw = path.read_bytes()
    except OSError as error:
        raise WindFieldError(f"{name}: cannot be read ({error.strerror})") from error
    try:
        text = raw.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        raise WindFieldError(f"{name}: got a binary file; must be a CSV text file") from error
    if "\0" in text:
        raise WindFieldError(f"{name}: got a binary file; must be a CSV text file")
    return text


def _row(name: str, line_number: int, line: str) -> tuple[float, ...]:
    cells = line.split(",")
    try:
        values = tuple(float(cell) for cell in cells)
    except ValueError:
        values = ()
    if len(values) != 3 or not np.isfinite(values).all():
        raise WindFieldError(
            f"{name}, line {line_number}: got '{line.strip()[:80]}'; must be three finite "
            "numbers with commas between"
        )
    return values


def _grid(name: str, columns: tuple[str, str, str], data: FloatArray) -> DiscTable:
    first, i = np.unique(data[:, 0], return_inverse=True)
    second, j = np.unique(data[:, 1], return_inverse=True)
    # counted per occupied cell: a file without a grid would make a table of rows squared
    cells, counts = np.unique(i * second.size + j, return_counts=True)
    label = f"{columns[0]}, {columns[1]}"
    if counts.max() > 1:
        a, b = divmod(int(cells[np.argmax(counts)]), second.size)
        raise WindFieldError(
            f"{name}: got ({label}) = ({first[a]:g}, {second[b]:g}) {counts.max()} times; must "
            "be there once"
        )
    total = first.size * second.size
    if cells.size != total:
        # occupied cells are sorted, so the first gap is where index and cell part
        gaps = np.flatnonzero(cells != np.arange(cells.size))
        a, b = divmod(int(gaps[0]) if gaps.size else cells.size, second.size)
        raise WindFieldError(
            f"{name}: got {cells.size} of the {total} points of a {first.size} x {second.size} "
            f"grid, ({label}) = ({first[a]:g}, {second[b]:g}) is missing; must be a full grid"
        )
    speed = np.empty(total)
    speed[i * second.size + j] = data[:, 2]
    return DiscTable(columns, first, second, speed.reshape(first.size, second.size))
