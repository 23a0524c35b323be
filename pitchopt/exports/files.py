"""Files written whole or not at all: to a temporary name in the same folder, then renamed."""

from __future__ import annotations

import os
import uuid
from collections.abc import Mapping
from pathlib import Path

from pitchopt.errors import InputError

__all__ = ["check_folder", "read_text", "write_files", "write_whole"]

MAX_TEXT_BYTES = 64 << 20


def _temporary(target: Path) -> Path:
    return target.with_name(f".{target.name}.{uuid.uuid4().hex[:12]}.part")


def write_files(folder: str | os.PathLike[str], contents: Mapping[str, bytes | str]) -> list[Path]:
    """Write files into a folder; if one of them cannot be written, none appears.

    Parameters
    ----------
    folder : path
        Made if it does not exist.
    contents : mapping of str to bytes or str
        File names, with a folder before them or not, and what they hold; text is written as
        UTF-8.

    Returns
    -------
    list of Path
        The files, in the order of `contents`. Files of the same name are replaced, nothing
        else in the folder is touched.

    Raises
    ------
    OSError
        If the folder cannot be made or a file cannot be written.
    """
    root = Path(folder)
    root.mkdir(parents=True, exist_ok=True)
    pending: list[tuple[Path, Path]] = []
    try:
        for name, content in contents.items():
            target = root / name
            target.parent.mkdir(parents=True, exist_ok=True)
            temporary = _temporary(target)
            pending.append((temporary, target))
            data = content.encode("utf-8") if isinstance(content, str) else content
            with temporary.open("xb") as stream:
                stream.write(data)
        for temporary, target in pending:
            temporary.replace(target)
    except BaseException:
        for temporary, _ in pending:
            temporary.unlink(missing_ok=True)
        raise
    return [target for _, target in pending]


def write_whole(path: str | os.PathLike[str], content: bytes | str) -> Path:
    """Write one file whole or not at all; see :func:`write_files`."""
    target = Path(path)
    return write_files(target.parent, {target.name: content})[0]


def check_folder(path: str | os.PathLike[str], field: str = "out") -> Path:
    """Find out, before a long computation, whether files can be written to a folder.

    Nothing is left behind: a folder that does not exist yet is not made, but its nearest
    existing parent must admit files.

    Raises
    ------
    InputError
        If the path is not a folder or files cannot be written there.
    """
    folder = Path(path)
    try:
        place = folder
        if "\0" in str(folder):
            raise ValueError("zero byte in the name")
        while not place.exists():
            place = place.parent
        if not place.is_dir():
            raise InputError(f"{field}: got {str(folder)!r}, expected a folder; {place} is a file")
        probe = _temporary(place / "probe")
        with probe.open("xb"):
            pass
        probe.unlink()
    except (OSError, ValueError) as error:
        if isinstance(error, InputError):
            raise
        reason = getattr(error, "strerror", None) or str(error)
        raise InputError(
            f"{field}: cannot write to {str(folder)!r} ({reason}), expected a folder that admits "
            "files"
        ) from error
    return folder


def read_text(path: str | os.PathLike[str], field: str, *, max_bytes: int = MAX_TEXT_BYTES) -> str:
    """Text of a file that a user handed in.

    Raises
    ------
    InputError
        If the file is missing, not a file, empty, larger than `max_bytes` or not UTF-8 text.
    """
    source = Path(path)
    shown = str(source)
    try:
        if not source.is_file():
            kind = "a folder" if source.is_dir() else "no such file"
            raise InputError(f"{field}: got {shown!r} ({kind}), expected a text file")
        size = source.stat().st_size
        if size > max_bytes:
            raise InputError(f"{field}: {shown!r} holds {size} bytes, expected at most {max_bytes}")
        data = source.read_bytes()
    except (OSError, ValueError) as error:
        if isinstance(error, InputError):
            raise
        reason = getattr(error, "strerror", None) or str(error)
        raise InputError(f"{field}: cannot read {shown!r} ({reason})") from error
    if not data.strip():
        raise InputError(f"{field}: {shown!r} is empty, expected a text file")
    try:
        text = data.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        raise InputError(
            f"{field}: {shown!r} is binary (byte {error.start} is not UTF-8), expected text"
        ) from error
    if "\0" in text:
        raise InputError(f"{field}: {shown!r} is binary (holds zero bytes), expected text")
    return text
