"""Boxes of turbulence kept on disk, so that the same box is made once.

One NPZ file a box, named by the SHA-256 of its settings, the format version of this module and
nothing else; it holds the velocities and the settings, as arrays, never as pickled objects. A
file is written whole or not at all. One that is damaged (the checksums of the archive do not
fit), foreign or of other settings is made again and replaced.

The folder is kept below a limit by removing the boxes that were used least recently; `clear`
removes all of them, and deleting the folder does no harm. A box that cannot be stored (disk
full) is returned all the same.
"""

from __future__ import annotations

import contextlib
import hashlib
import json
import os
import zipfile
import zlib
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from windfield._checks import as_count
from windfield._files import write_whole
from windfield.errors import WindFieldError

__all__ = ["BoxCache"]

FORMAT = 1  # to be raised whenever the same settings give other velocities
SUFFIX = ".box.npz"


class BoxCache:
    """Folder of boxes.

    Parameters
    ----------
    folder : path or None
        Made if it does not exist. None: `windfield` in the user's cache folder
        (`XDG_CACHE_HOME`, or `~/.cache`).
    limit : int
        Largest size of all boxes together [bytes]; the least recently used ones go first. The
        last one stored stays in any case.

    Raises
    ------
    WindFieldError
        If the folder cannot be made or is not one, or `limit` is not a whole number.
    """

    def __init__(
        self, folder: str | os.PathLike[str] | None = None, *, limit: int = 4 * 2**30
    ) -> None:
        self.folder = _user_folder() if folder is None else Path(folder)
        self.limit = as_count("limit", limit, at_least=0)
        try:
            self.folder.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            raise WindFieldError(
                f"{self.folder}: cannot be made or is not a folder ({error.strerror}); choose "
                "another folder for the boxes"
            ) from error

    def velocity(
        self, settings: Mapping[str, object], make: Callable[[], NDArray[np.float32]]
    ) -> NDArray[np.float32]:
        """Velocities of a box: those stored for these settings, or new ones, stored from now on.

        Parameters
        ----------
        settings : mapping
            Everything the velocities depend on: numbers, strings and sequences of them.
        make : callable
            Computes them.
        """
        text = json.dumps({"format": FORMAT, **settings}, sort_keys=True, allow_nan=False)
        path = self.folder / f"{hashlib.sha256(text.encode()).hexdigest()}{SUFFIX}"
        stored = _read(path, text)
        if stored is not None:
            with contextlib.suppress(OSError):
                os.utime(path)
            return stored
        velocity = make()
        with contextlib.suppress(WindFieldError):
            write_whole(
                path, lambda stream: np.savez(stream, velocity=velocity, settings=np.array(text))
            )
            self._shrink(keep=path)
        return velocity

    def clear(self) -> int:
        """Remove all boxes of the folder; their number."""
        boxes = list(self.folder.glob(f"*{SUFFIX}"))
        for path in boxes:
            path.unlink(missing_ok=True)
        return len(boxes)

    def _shrink(self, keep: Path) -> None:
        boxes = []
        for path in self.folder.glob(f"*{SUFFIX}"):
            with contextlib.suppress(OSError):  # another process may have removed it
                status = path.stat()
                boxes.append((path != keep, -status.st_mtime_ns, status.st_size, path))
        total = 0
        for removable, _, size, path in sorted(boxes):
            total += size
            if removable and total > self.limit:
                with contextlib.suppress(OSError):
                    path.unlink()


def _user_folder() -> Path:
    base = os.environ.get("XDG_CACHE_HOME", "")
    # the specification has relative paths ignored
    return (Path(base) if Path(base).is_absolute() else Path.home() / ".cache") / "windfield"


def _read(path: Path, text: str) -> NDArray[np.float32] | None:
    """Velocities of a file, or None if it is absent, damaged or not of these settings."""
    try:
        with path.open("rb") as stream, zipfile.ZipFile(stream) as archive:
            if str(_member(archive, "settings")) != text:
                return None
            velocity = _member(archive, "velocity")
    except (OSError, ValueError, KeyError, EOFError, zipfile.BadZipFile, zlib.error):
        return None
    return velocity if velocity.dtype == np.float32 and velocity.ndim == 4 else None


def _member(archive: zipfile.ZipFile, name: str) -> NDArray[Any]:
    with archive.open(f"{name}.npy") as stream:
        array = np.asarray(np.lib.format.read_array(stream, allow_pickle=False))
        if stream.read(1):  # reading to the end has the checksum compared
            raise ValueError("more than one array")
    return array
