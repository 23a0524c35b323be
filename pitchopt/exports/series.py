"""Time series of named channels: CSV and NPZ, and what the other formats start from.

A CSV file has a line of names, a line of units in parentheses and one line for each instant, as
OpenFAST's text output has; an NPZ file holds ``time``, ``values``, ``channels`` and ``units``.
Units are those that stand beside the names: OpenFAST's, kN-m, deg, rpm.
"""

from __future__ import annotations

import csv
import io
import os
import zipfile
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from pitchopt.checks import FloatArray
from pitchopt.errors import InputError
from pitchopt.exports.files import read_text

if TYPE_CHECKING:
    from pitchopt.sim import Simulation

__all__ = [
    "TimeSeries",
    "read_series_csv",
    "read_series_npz",
    "series_csv",
    "series_npz",
    "series_of",
]

_DIGITS = 9  # more than the time loop repeats from one machine to the next


@dataclass(frozen=True, kw_only=True, eq=False)
class TimeSeries:
    """Channels over time.

    Parameters
    ----------
    time : array_like (R,)
        Ascending [s].
    channels, units : sequence of str (C,)
        Names, different from each other, and units.
    values : array_like (R, C)

    Raises
    ------
    InputError
        If shapes disagree, a name appears twice, time does not ascend or a number is not finite.
    """

    time: FloatArray
    channels: tuple[str, ...]
    units: tuple[str, ...]
    values: FloatArray

    def __post_init__(self) -> None:
        for name in ("channels", "units"):
            object.__setattr__(self, name, tuple(str(text) for text in getattr(self, name)))
        for name in ("time", "values"):
            array = np.array(getattr(self, name), dtype=np.float64)
            array.setflags(write=False)
            object.__setattr__(self, name, array)
        count = len(self.channels)
        if self.time.ndim != 1 or self.time.size == 0:
            raise InputError(f"time: got shape {self.time.shape}, expected a non-empty vector")
        if self.values.shape != (self.time.size, count) or len(self.units) != count:
            raise InputError(
                f"values: got shape {self.values.shape} and {len(self.units)} units, expected "
                f"{(self.time.size, count)} for {self.time.size} instants of {count} channels"
            )
        if len(set(self.channels)) != count:
            raise InputError(f"channels: got {', '.join(self.channels)}, expected different names")
        if not (np.isfinite(self.time).all() and np.isfinite(self.values).all()):
            raise InputError("values: got NaN or infinite ones, expected finite numbers")
        if np.any(np.diff(self.time) <= 0.0):
            raise InputError("time: expected ascending instants, got some that do not ascend")

    def __getitem__(self, name: str) -> FloatArray:
        """One channel (R,)."""
        if name not in self.channels:
            raise InputError(f"channel: got {name!r}, expected one of {', '.join(self.channels)}")
        return self.values[:, self.channels.index(name)]


def series_of(simulation: Simulation, channels: Sequence[str]) -> TimeSeries:
    """Channels of a simulated run, in OpenFAST's units.

    Raises
    ------
    InputError
        If the run has no channel of a name.
    """
    return TimeSeries(
        time=simulation.time,
        channels=tuple(channels),
        units=tuple(simulation.channels[simulation.place(name)].unit for name in channels),
        values=simulation.table(channels),
    )


def series_csv(series: TimeSeries) -> str:
    """Text of a CSV file: names, units, then an instant a line."""
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(("Time", *series.channels))
    writer.writerow(f"({unit})" for unit in ("s", *series.units))
    np.savetxt(
        text, np.column_stack([series.time, series.values]), fmt=f"%.{_DIGITS}g", delimiter=","
    )
    return text.getvalue()


def read_series_csv(path: str | os.PathLike[str]) -> TimeSeries:
    """Read a file that `series_csv` wrote.

    Raises
    ------
    InputError
        If the file is missing, or something else.
    """
    lines = read_text(path, "series file").splitlines()
    if len(lines) < 3 or not lines[0].startswith("Time,"):
        raise InputError(
            f"series file: {os.fspath(path)!r} has {len(lines)} lines, the first {lines[0][:30]!r};"
            " expected Time and other channels, their units, and numbers"
        )
    names, units = lines[0].split(","), lines[1].split(",")
    try:
        table = np.loadtxt(lines[2:], delimiter=",", ndmin=2)
        if table.shape[1] != len(names):
            raise InputError(f"values: got {table.shape[1]} columns of {len(names)} names")
        return TimeSeries(
            time=table[:, 0],
            channels=tuple(names[1:]),
            units=tuple(unit.strip("()") for unit in units[1:]),
            values=table[:, 1:],
        )
    except ValueError as error:
        raise InputError(f"series file: {os.fspath(path)!r}: {error}") from error


def series_npz(series: TimeSeries) -> bytes:
    """Content of an NPZ file with ``time``, ``values``, ``channels``, ``units``."""
    buffer = io.BytesIO()
    np.savez_compressed(
        buffer,
        time=series.time,
        values=series.values,
        channels=np.array(series.channels),
        units=np.array(series.units),
    )
    return buffer.getvalue()


def read_series_npz(path: str | os.PathLike[str]) -> TimeSeries:
    """Read a file that `series_npz` wrote.

    Raises
    ------
    InputError
        If the file is missing, or something else.
    """
    shown = os.fspath(path)
    try:
        with Path(path).open("rb") as stream, np.load(stream, allow_pickle=False) as data:
            return TimeSeries(
                time=data["time"],
                channels=tuple(map(str, data["channels"].tolist())),
                units=tuple(map(str, data["units"].tolist())),
                values=data["values"],
            )
    except InputError as error:
        raise InputError(f"series file: {shown!r}: {error}") from error
    except (OSError, ValueError, KeyError, TypeError, EOFError, zipfile.BadZipFile) as error:
        raise InputError(f"series file: {shown!r} is no series of pitchopt ({error})") from error
