"""Safe reading of the files a user hands in: text, JSON and YAML, never a Python object.

A file is refused before it is parsed if it is missing, a directory, empty, too large or binary.
YAML is scanned once for what could hurt before anything is built from it: explicit tags, merge
keys (nested ones grow exponentially), nesting beyond `MAX_DEPTH` (libyaml's composer is
recursive) and repeated keys (of which PyYAML would keep the last in silence).
"""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

from pitchopt.errors import InputError

__all__ = ["MAX_BYTES", "MAX_DEPTH", "load_json", "load_yaml", "read_text"]

MAX_BYTES = 10_000_000  # the largest public windIO turbine has 0.8 MB
MAX_DEPTH = 64  # windIO turbines nest 12 levels deep


def read_text(path: str | Path, *, limit: int = MAX_BYTES) -> str:
    """Text of a file, or an `InputError` that names the file and what is wrong with it."""
    file = Path(path)
    try:
        if file.is_dir():
            raise InputError(f"{file}: is a directory, expected a file")
        if not file.exists():
            raise InputError(f"{file}: no such file")
        size = file.stat().st_size
        if size > limit:
            raise InputError(f"{file}: {size} bytes, at most {limit} are read")
        data = file.read_bytes()
    except OSError as error:
        raise InputError(f"{file}: cannot be read ({error.strerror or error})") from error
    except ValueError as error:
        if isinstance(error, InputError):
            raise
        raise InputError(f"{str(path)!r}: not a file name ({error})") from error
    if not data.strip():
        raise InputError(f"{file}: the file is empty")
    if b"\0" in data:
        raise InputError(f"{file}: binary file, expected UTF-8 text")
    try:
        return data.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        raise InputError(
            f"{file}: not UTF-8 text (byte {error.start}: 0x{data[error.start]:02x})"
        ) from error


def load_json(path: str | Path) -> Any:
    """Content of a JSON file."""
    text = read_text(path)
    try:
        return json.loads(text)
    except json.JSONDecodeError as error:
        raise InputError(
            f"{path}: not valid JSON at line {error.lineno}, column {error.colno} ({error.msg})"
        ) from error
    except (RecursionError, ValueError) as error:
        raise InputError(f"{path}: not valid JSON ({type(error).__name__})") from error


def load_yaml(path: str | Path) -> Any:
    """Content of a YAML file: mappings, lists, strings, numbers, nothing else."""
    import yaml  # here, not above: only windIO files need it

    text = read_text(path)
    loader: Any = getattr(yaml, "CSafeLoader", yaml.SafeLoader)
    try:
        _scan(text, path, yaml, loader)
        return yaml.load(text, Loader=loader)  # noqa: S506  a safe loader, with or without libyaml
    except yaml.MarkedYAMLError as error:
        mark = error.problem_mark
        where = f" at line {mark.line + 1}, column {mark.column + 1}" if mark else ""
        what = " ".join(str(error.problem or error.context or "unreadable").split())[:120]
        if "nesting depth" in what:  # newer libyaml has a limit of its own, beyond ours
            raise InputError(f"{path}: nested more than {MAX_DEPTH} levels deep{where}") from error
        raise InputError(f"{path}: not valid YAML{where} ({what})") from error
    except yaml.YAMLError as error:
        what = " ".join(str(error).split())[:120]
        raise InputError(f"{path}: not valid YAML ({what})") from error
    except (ValueError, RecursionError, TypeError, KeyError) as error:
        if isinstance(error, InputError):
            raise
        what = " ".join(str(error).split())[:120]
        raise InputError(f"{path}: not valid YAML ({type(error).__name__}: {what})") from error


def _scan(text: str, path: str | Path, yaml: Any, loader: Any) -> None:
    """Refuse YAML that would be dangerous or misleading to build, by its events alone."""
    stack: list[set[str] | None] = []  # keys of each open mapping, None for a list
    awaiting: list[bool] = []  # whether the next node of that collection is a key
    for event in yaml.parse(text, Loader=loader):
        if isinstance(event, yaml.CollectionEndEvent):
            stack.pop()
            awaiting.pop()
            continue
        if not isinstance(event, yaml.NodeEvent):
            continue
        line = event.start_mark.line + 1
        tag = getattr(event, "tag", None)
        if tag is not None and not str(tag).startswith("tag:yaml.org,2002:"):
            raise InputError(f"{path}: line {line}: explicit tag {str(tag)[:60]!r} is not allowed")
        if tag is not None and "python" in str(tag):
            raise InputError(f"{path}: line {line}: explicit tag {str(tag)[:60]!r} is not allowed")
        if stack and stack[-1] is not None:
            keys = stack[-1]
            if awaiting[-1] and isinstance(event, yaml.ScalarEvent):
                key = event.value
                if key == "<<":
                    raise InputError(f"{path}: line {line}: merge keys (<<) are not allowed")
                if key in keys:
                    raise InputError(f"{path}: line {line}: key {key[:60]!r} stands there twice")
                keys.add(key)
            awaiting[-1] = not awaiting[-1]
        if isinstance(event, yaml.CollectionStartEvent):
            mapping = isinstance(event, yaml.MappingStartEvent)
            stack.append(set() if mapping else None)
            awaiting.append(mapping)
            if len(stack) > MAX_DEPTH:
                raise InputError(f"{path}: line {line}: nested more than {MAX_DEPTH} levels deep")
