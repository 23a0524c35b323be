"""Lines of ROSCO's parameter file ``DISCON.IN``: read, written, changed in place.

ROSCO finds a parameter by its name: a line is the value (or so many values as the parameter has),
the name, and anything after it; what stands between them is separated by blanks, tabs, commas,
semicolons, quotes or ``!``.  The first line that fits counts.  A comment whose second word is the
name of a parameter would be taken for it, so comments written here begin each line with ``!`` and
keep names of parameters out of their first words.

Source: ``rosco/controller/src/ROSCO_Helpers.f90`` of ROSCO 2.10.6 (FindLine, GetWords,
ParseInput, ParseAry); names and units from its ``ReadSetParameters.f90`` and the example files.
"""

from __future__ import annotations

import os
import re
from collections.abc import Sequence
from dataclasses import dataclass

from pitchopt.checks import FloatArray, finite_array
from pitchopt.errors import InputError
from pitchopt.exports.files import read_text

__all__ = [
    "DisconLine",
    "changed_discon",
    "discon_numbers",
    "discon_text",
    "discon_value",
    "read_discon",
]

VERSIONS = "2.9 and 2.10"
_SEPARATORS = re.compile(r"[\s,;'\"!]+")
_LINE = re.compile(r"^\s*(?P<value>[^!]*?)\s*!\s*(?P<name>\w+)")
_WIDTH = 28


@dataclass(frozen=True, kw_only=True)
class DisconLine:
    """One parameter: its name, its value as the file has it, and what it is."""

    name: str
    value: str
    comment: str = ""

    def __str__(self) -> str:
        tail = f" - {self.comment}" if self.comment else ""
        return f"{self.value:<{_WIDTH}}! {self.name}{tail}"


def discon_text(title: str, notes: Sequence[str], lines: Sequence[DisconLine]) -> str:
    """A part of a file: title, notes as comments, parameters."""
    head = [f"!------- {title} {'-' * max(66 - len(title), 3)}"]
    return "\n".join((*head, *(f"! | {note}" for note in notes), *map(str, lines))) + "\n"


def read_discon(path: str | os.PathLike[str]) -> str:
    """Text of a ``DISCON.IN``.

    Raises
    ------
    InputError
        If the file is missing, not text, or has no line of the form ``value ! name``.
    """
    text = read_text(path, "DISCON file")
    found = (_LINE.match(line) for line in text.splitlines())
    if not any(match is not None and match["value"] for match in found):
        raise InputError(
            f"DISCON file: {os.fspath(path)!r} has no line of the form 'value ! name', expected a "
            "parameter file of ROSCO"
        )
    return text


def _places(text: str, name: str) -> list[int]:
    """Numbers of the lines that hold a parameter."""
    found = []
    for place, line in enumerate(text.splitlines()):
        match = _LINE.match(line)
        if match and match["name"].lower() == name.lower() and match["value"]:
            found.append(place)
    return found


def discon_value(text: str, name: str) -> str | None:
    """Value of a parameter as the file has it, without quotes; None if it is not there."""
    places = _places(text, name)
    if not places:
        return None
    match = _LINE.match(text.splitlines()[places[0]])
    return "" if match is None else match["value"].strip().strip("'\"")


def discon_numbers(text: str, name: str, count: int) -> FloatArray | None:
    """Numbers (count,) of a parameter; None if it is not there.

    Raises
    ------
    InputError
        If there are not so many, or something else than numbers.
    """
    value = discon_value(text, name)
    if value is None:
        return None
    words = [word for word in _SEPARATORS.split(value) if word]
    try:
        numbers = [float(word.lower().replace("d", "e")) for word in words]
    except ValueError as error:
        raise InputError(f"{name}: got {value!r}, expected {count} numbers") from error
    if len(numbers) < count:
        raise InputError(f"{name}: got {value!r}, expected {count} numbers")
    return finite_array(name, numbers[:count])


def changed_discon(text: str, lines: Sequence[DisconLine]) -> str:
    """The file with other values of some parameters, and all else as it was.

    Raises
    ------
    InputError
        Naming the parameters that the file does not have, or has twice.
    """
    rows = text.splitlines()
    missing = [line.name for line in lines if not _places(text, line.name)]
    if missing:
        raise InputError(
            f"DISCON file: has no {', '.join(missing)}, expected a file for ROSCO {VERSIONS}"
        )
    for line in lines:
        places = _places(text, line.name)
        if len(places) > 1:
            numbers = ", ".join(str(place + 1) for place in places)
            raise InputError(f"DISCON file: has {line.name} in lines {numbers}, expected it once")
        old = rows[places[0]]
        rows[places[0]] = f"{line.value:<{_WIDTH}}{old[old.index('!') :]}"
    return "\n".join(rows) + "\n"
