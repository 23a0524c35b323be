"""Saved states: one NPZ file of arrays, written whole or not at all, read without pickle."""

from __future__ import annotations

import io
import os
import uuid
import zipfile
from collections.abc import Mapping
from pathlib import Path

import numpy as np

from ilc.errors import StateError

__all__ = ["load_state", "save_state"]


def save_state(path: str | os.PathLike[str], state: Mapping[str, np.ndarray]) -> Path:
    """Write arrays to a file; a file of that name is replaced only when all is written."""
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
    return target


def load_state(path: str | os.PathLike[str]) -> dict[str, np.ndarray]:
    """Read what :func:`save_state` wrote.

    Raises
    ------
    StateError
        If the file is missing or not such a file.
    """
    try:
        with np.load(path, allow_pickle=False) as data:
            return {name: data[name] for name in data.files}
    except (OSError, ValueError, EOFError, zipfile.BadZipFile) as error:
        raise StateError(f"{path}: cannot be read as a saved state ({error})") from error
