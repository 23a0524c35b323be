"""OpenFAST's binary output (.outb): time series packed into 16-bit counts.

Little-endian,

    int16    identifier: 2, or 4 followed by an int16, the length of names and units
    int32    number of channels without the time, number of instants
    float64  first instant, interval [s]
    float32  slope of each channel, then offset of each channel
    int32    length of the description, which follows as text
    text     names, the time's first, then units in parentheses; 10 characters each, or as many as
             identifier 4 says, padded with blanks
    int16    counts, instant by instant,  value = (count - offset) / slope

Values are rounded to one of 65534 levels between the least and the largest of their channel, so
they come back within half a level.  Names and units of more than 10 characters make an
identifier 4.  Identifier 3, which holds float64 in place of slopes, offsets and counts, is read
as well; identifier 1, whose time is packed like a channel, is not.

Reference: the reader of B. J. Jonkman (ReadFASTbinary, NREL) describes the format; OpenFAST's
library writes it (WrBinFAST).
"""

from __future__ import annotations

import os
import struct
from pathlib import Path

import numpy as np

from pitchopt.errors import InputError
from pitchopt.exports.series import TimeSeries

__all__ = ["outb_bytes", "read_outb"]

_PLAIN, _UNPACKED, _LONG = 2, 3, 4
_LENGTH = 10
_LOWEST, _LEVELS = -32767, 65533  # of int16, with one to spare for rounding at either end
_NARROWEST = 0.005  # range of the counts over the largest value: offsets are single precision
_UNEVEN = 1e-6  # of an interval


def outb_bytes(series: TimeSeries, *, description: str = "") -> bytes:
    """Content of an .outb file.

    Parameters
    ----------
    series : TimeSeries
        With at least two instants, evenly spaced.
    description : str
        ASCII.

    Raises
    ------
    InputError
        If instants are not even, or a text is not ASCII.
    """
    steps = np.diff(series.time)
    if steps.size == 0 or np.ptp(steps) > _UNEVEN * steps.mean():
        raise InputError(
            f"time: got {series.time.size} instants, expected two or more, evenly spaced, in an "
            ".outb file"
        )
    interval = float(series.time[-1] - series.time[0]) / steps.size
    texts = ["Time", *series.channels, *(f"({unit})" for unit in ("s", *series.units))]
    for text in (*texts, description):
        if not text.isascii():
            raise InputError(f"channels: got {text!r}, expected ASCII in an .outb file")
    length = max(_LENGTH, *map(len, texts))
    head = struct.pack("<h", _PLAIN) if length == _LENGTH else struct.pack("<hh", _LONG, length)
    low, high = series.values.min(axis=0), series.values.max(axis=0)
    spread = np.maximum(high - low, _NARROWEST * np.maximum(np.abs(low), np.abs(high)))
    slope = (_LEVELS / np.where(spread > 0.0, spread, _LEVELS)).astype("<f4")
    offset = (_LOWEST - slope.astype(np.float64) * low).astype("<f4")
    counts = np.rint(series.values * slope.astype(np.float64) + offset.astype(np.float64))
    said = description.encode("ascii")
    return b"".join(
        (
            head,
            struct.pack("<2i2d", len(series.channels), series.time.size, series.time[0], interval),
            slope.tobytes(),
            offset.tobytes(),
            struct.pack("<i", len(said)),
            said,
            *(text.ljust(length).encode("ascii") for text in texts),
            counts.astype("<i2").tobytes(),
        )
    )


def read_outb(path: str | os.PathLike[str]) -> TimeSeries:
    """Read an .outb file of OpenFAST or of `outb_bytes`.

    Raises
    ------
    InputError
        If the file is missing, of another format, or shorter or longer than its header tells.
    """
    shown = os.fspath(path)
    try:
        data = Path(path).read_bytes()
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or str(error)
        raise InputError(f"series file: cannot read {shown!r} ({reason})") from error
    try:
        return _decoded(data)
    except InputError as error:
        raise InputError(f"series file: {shown!r}: {error}") from error
    except (struct.error, ValueError) as error:
        raise InputError(f"series file: {shown!r} is no whole .outb file ({error})") from error


def _decoded(data: bytes) -> TimeSeries:
    (kind,) = struct.unpack_from("<h", data)
    if kind not in (_PLAIN, _UNPACKED, _LONG):
        raise InputError(f"got identifier {kind}, expected 2, 3 or 4 of OpenFAST's binary output")
    at, length = 2, _LENGTH
    if kind == _LONG:
        (length,) = struct.unpack_from("<h", data, at)
        at += 2
    count, rows, first, interval = struct.unpack_from("<2i2d", data, at)
    at += struct.calcsize("<2i2d")
    if min(count, rows, length) < 1:
        raise InputError(f"got {count} channels of {rows} instants, names of {length} characters")
    packed = kind != _UNPACKED
    slope, offset = np.ones(count), np.zeros(count)
    if packed:
        slope, offset = (
            np.frombuffer(data, "<f4", count, at + 4 * k * count).astype(np.float64) for k in (0, 1)
        )
        at += 8 * count
        if not (np.isfinite(slope).all() and np.isfinite(offset).all() and slope.all()):
            raise InputError("got slopes or offsets that are zero or not finite")
    (said,) = struct.unpack_from("<i", data, at)
    at += 4 + max(said, 0)
    expected = at + 2 * (count + 1) * length + count * rows * (2 if packed else 8)
    if len(data) != expected:
        raise InputError(f"got {len(data)} bytes, expected {expected} as its header tells")
    texts = [
        data[at + k * length : at + (k + 1) * length].decode("ascii", errors="replace").strip()
        for k in range(2 * (count + 1))
    ]
    at += 2 * (count + 1) * length
    values = np.frombuffer(data, "<i2" if packed else "<f8", count * rows, at)
    return TimeSeries(
        time=first + interval * np.arange(rows),
        channels=tuple(texts[1 : count + 1]),
        units=tuple(text.strip("()") for text in texts[count + 2 :]),
        values=(values.reshape(rows, count) - offset) / slope,
    )
