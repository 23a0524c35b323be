"""Files that are written whole or not at all."""

from __future__ import annotations

import uuid
from collections.abc import Callable
from pathlib import Path
from typing import BinaryIO

from windfield.errors import WindFieldError

__all__ = ["write_whole"]


def write_whole(target: Path, write: Callable[[BinaryIO], object]) -> None:
    """Write a file under a temporary name in the same folder, then rename it.

    Raises
    ------
    WindFieldError
        If `target` names no file, or it cannot be written there.
    """
    if not target.name:
        raise WindFieldError(f"path: got '{target}'; must name a file")
    temporary = target.with_name(f".{target.name}.{uuid.uuid4().hex}.tmp")
    try:
        try:
            with temporary.open("xb") as stream:
                write(stream)
            temporary.replace(target)
        finally:
            temporary.unlink(missing_ok=True)
    except OSError as error:
        raise WindFieldError(
            f"{target}: cannot be written ({error.strerror}); choose a file in a folder that "
            "exists and may be written to"
        ) from error
