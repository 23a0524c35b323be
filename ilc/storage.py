"""Saved states: one NPZ file of arrays, written whole or not at all, read without pickle."""

from __future__ import annotations

import glob
import io
import json
import math
import os
import time
import uuid
import zipfile
import zlib
from collections.abc import Mapping
from contextlib import suppress
from pathlib import Path
from typing import Any

import numpy as np

from ilc.errors import StateError

__all__ = ["check_settings", "load_state", "part", "save_state"]

_STALE = 3600.0  # [s]


def save_state(path: str | os.PathLike[str], state: Mapping[str, np.ndarray]) -> Path:
    """Write arrays to a file; a file of that name is replaced only when all is written.

    What a killed process left half written of the same file is removed when it is an hour old.
    """
    target = Path(path)
    buffer = io.BytesIO()
    np.savez_compressed(buffer, allow_pickle=False, **state)
    temporary = target.with_name(f".{target.name}.{uuid.uuid4().hex[:12]}.part")
    try:
        with temporary.open("xb") as stream:
            stream.write(buffer.getvalue())
        temporary.replace(target)
    except BaseException:
        temporary.unlink(missing_ok=True)
        raise
    _sweep(target)
    return target


def _sweep(target: Path) -> None:
    """Remove old halves of the file; younger ones may be another process's."""
    for left in target.parent.glob(f".{glob.escape(target.name)}.*.part"):
        with suppress(OSError):
            if time.time() - left.stat().st_mtime > _STALE:
                left.unlink()


def load_state(path: str | os.PathLike[str]) -> dict[str, np.ndarray]:
    """Read what :func:`save_state` wrote.

    Raises
    ------
    StateError
        If the file is missing or not such a file.
    """
    try:
        with Path(path).open("rb") as stream:
            if not zipfile.is_zipfile(stream):
                raise ValueError("not an NPZ file, or cut short")
            stream.seek(0)
            data = np.load(stream, allow_pickle=False)
            return {name: data[name] for name in data.files}
    except (
        *(OSError, EOFError, ValueError, NotImplementedError),
        *(zipfile.BadZipFile, zlib.error),
    ) as error:
        raise StateError(f"{path}: cannot be read as a saved state ({error})") from error


def part(state: Mapping[str, np.ndarray], prefix: str) -> dict[str, np.ndarray]:
    """The arrays whose names begin with a prefix, without it."""
    return {
        name.removeprefix(prefix): np.asarray(value)
        for name, value in state.items()
        if name.startswith(prefix)
    }


def check_settings(name: str, saved: np.ndarray, mine: Mapping[str, Any]) -> None:
    """Refuse a state that was made with other settings.

    Numbers that were computed may differ in their last digits from one processor to another.

    Parameters
    ----------
    name : str
        Whose settings they are, for the message.
    saved : ndarray ()
        The settings as JSON text.
    mine : mapping
        The settings that the state should go with.

    Raises
    ------
    StateError
        If they differ, or `saved` is no settings.
    """
    try:
        theirs = dict(json.loads(str(saved)))
    except (ValueError, TypeError) as error:
        raise StateError(f"{name}: damaged settings ({error})") from error
    ours = json.loads(json.dumps(dict(mine)))
    other = sorted(key for key in {**ours, **theirs} if not _same(ours.get(key), theirs.get(key)))
    if other:
        raise StateError(f"{name}: state made with other settings ({', '.join(other)})")


def _same(one: object, other: object) -> bool:
    """Whether two pieces of plain data are the same, numbers to ten digits."""
    if isinstance(one, dict) and isinstance(other, dict):
        return one.keys() == other.keys() and all(_same(one[key], other[key]) for key in one)
    if isinstance(one, list) and isinstance(other, list):
        return len(one) == len(other) and all(map(_same, one, other))
    if isinstance(one, float) and isinstance(other, (float, int)):
        return math.isclose(one, other, rel_tol=1e-10, abs_tol=1e-14)
    return one == other
