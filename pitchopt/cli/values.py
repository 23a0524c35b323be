"""Types of option values: every bad one ends in one line that names the option.

Imports of the rest of pitchopt wait until a value is there, so that ``--help`` is quick.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import click

from pitchopt.errors import InputError

if TYPE_CHECKING:
    from click.shell_completion import CompletionItem

    from pitchopt.cli.completing import Names

__all__ = [
    "FOLDER",
    "Given",
    "Option",
    "as_share",
    "as_share_or_none",
    "between",
    "case_value",
    "numbers",
    "positive",
    "seeds",
    "shape",
    "spacing",
    "torque",
    "whole",
    "wind_drift",
    "wind_ramp",
    "wind_step",
    "words",
]

DRIFT_ROTATIONS = 20.0
MOST_SEEDS = 10_000

Parser = Callable[[str, str], Any]
"""From the option's name and the text that it was given to the value, or an `InputError`."""


@dataclass(frozen=True)
class Given:
    """A value that the user gave, as against one that was left out."""

    value: Any


class Option(click.ParamType[Any]):
    """Values that a parser makes of text, or the text itself.

    Parameters
    ----------
    metavar : str
        What stands for a value in the help.
    parser : callable, optional
    names, endings, several
        What a shell may complete, as in :func:`pitchopt.cli.completing.completed`.
    """

    def __init__(
        self,
        metavar: str,
        parser: Parser | None = None,
        *,
        names: Names = (),
        endings: Sequence[str] = (),
        several: bool = False,
    ) -> None:
        self.name = metavar
        self.parser = parser
        self.names = names
        self.endings = endings
        self.several = several

    def convert(
        self,
        value: Any,
        param: click.Parameter | None,
        ctx: click.Context | None,  # noqa: ARG002  part of click's interface
    ) -> Any:
        """The value; defaults of other types than text stand for themselves."""
        if self.parser is None or not isinstance(value, str):
            return value
        names = [] if param is None else param.opts
        name = next((n for n in names if n.startswith("--")), names[0] if names else "value")
        return self.parser(name, value)

    def shell_complete(
        self,
        ctx: click.Context,  # noqa: ARG002  part of click's interface
        param: click.Parameter,  # noqa: ARG002  part of click's interface
        incomplete: str,
    ) -> list[CompletionItem]:
        """Names and files that go on from what was typed."""
        from pitchopt.cli.completing import completed

        return completed(incomplete, self.names, self.endings, several=self.several)


FOLDER = Option("folder", endings=("/",))
"""Type of an option that takes a folder."""


def _number(text: str) -> float:
    try:
        return float(text)
    except ValueError:
        return math.nan


def case_value(field: str) -> Parser:
    """Parser of a value of the case, by the schema of :mod:`pitchopt.cases`."""

    def parse(name: str, text: str) -> Given:
        from pitchopt.cases.settings import SCHEMA

        section, _, attribute = field.partition(".")
        (kind,) = (e.kind for e in SCHEMA if (e.section, e.attribute) == (section, attribute))
        return Given(kind.parse(name, text))

    return parse


def as_share(name: str, text: str) -> float:
    """Share between 0 and 1 of ``2%``, ``2 %`` or ``0.02``."""
    share = _share(text)
    if not 0.0 < share < 1.0:
        raise InputError(
            f"{name}: got {text!r}, expected a share above 0 and below 100 %, such as 2% or 0.02"
        )
    return share


def as_share_or_none(name: str, text: str) -> float:
    """The same, 0 included."""
    share = _share(text)
    if not 0.0 <= share < 1.0:
        raise InputError(
            f"{name}: got {text!r}, expected a share of 0 or more and below 100 %, such as 2% or "
            "0.02"
        )
    return share


def _share(text: str) -> float:
    body = text.strip()
    percent = body.endswith("%")
    return _number(body.removesuffix("%").strip()) / (100.0 if percent else 1.0)


def numbers(name: str, text: str) -> tuple[float, ...]:
    """Numbers of 0 or more, separated by commas."""
    values = tuple(map(_number, text.split(",")))
    if not all(math.isfinite(value) and value >= 0 for value in values):
        raise InputError(
            f"{name}: got {text!r}, expected finite numbers of 0 or more, such as 1,3,10"
        )
    return values


def signed_numbers(name: str, text: str) -> tuple[float, ...]:
    """Finite numbers of either sign, separated by commas."""
    values = tuple(map(_number, text.split(",")))
    if not all(map(math.isfinite, values)):
        raise InputError(f"{name}: got {text!r}, expected finite numbers, such as 0.6,0.7")
    return values


def bounds(name: str, text: str) -> tuple[str, tuple[float, float]]:
    """Name and bounds of ``k_fact=0.5:1.5``."""
    parameter, _, ends = text.partition("=")
    low, _, high = ends.partition(":")
    values = _number(low), _number(high)
    if not (parameter.strip() and all(map(math.isfinite, values))):
        raise InputError(f"{name}: got {text!r}, expected NAME=LOW:HIGH, such as k_fact=0.5:1.5")
    return parameter.strip(), values


def tuner_option(name: str, text: str) -> tuple[str, object]:
    """Name and value of ``stages=12``: a whole number, a number, several numbers, or a word."""
    option, equals, value = (part.strip() for part in text.partition("="))
    if not (option and equals and value):
        raise InputError(f"{name}: got {text!r}, expected NAME=VALUE, such as stages=12")
    numbers = [_number(part) for part in value.split(",")]
    if not all(map(math.isfinite, numbers)):
        return option, value
    plain = [int(part) if part.strip().isdecimal() else _number(part) for part in value.split(",")]
    return option, plain[0] if len(plain) == 1 else tuple(plain)


def torque(name: str, text: str) -> float | str:
    """A mean torque [N m], or the word ``rated``."""
    if text.strip() == "rated":
        return "rated"
    value = _number(text)
    if not (math.isfinite(value) and value > 0):
        raise InputError(f"{name}: got {text!r}, expected a finite number above 0 [N m] or 'rated'")
    return value


def whole(low: int, high: int) -> Parser:
    """Parser of whole numbers between limits."""

    def parse(name: str, text: str) -> int:
        try:
            value = int(text)
        except ValueError:
            value = low - 1
        if not low <= value <= high:
            raise InputError(f"{name}: got {text!r}, expected a whole number from {low} to {high}")
        return value

    return parse


def between(low: float, high: float, unit: str) -> Parser:
    """Parser of numbers from `low` to `high`, both included."""

    def parse(name: str, text: str) -> float:
        value = _number(text)
        if not low <= value <= high:
            raise InputError(
                f"{name}: got {text!r}, expected a number from {low:g} to {high:g} [{unit}]"
            )
        return value

    return parse


def wind_step(name: str, text: str) -> tuple[int, float]:
    """Rotation and change of wind speed [m/s] of ``22:+2``."""
    when, _, change = text.partition(":")
    if not (when.strip().isdecimal() and math.isfinite(_number(change))):
        raise InputError(
            f"{name}: got {text!r}, expected ROTATION:CHANGE, such as 22:+2 for 2 m/s more after "
            "22 rotations"
        )
    return int(when), _number(change)


def wind_ramp(name: str, text: str) -> tuple[int, int, float]:
    """First and last rotation and change of wind speed [m/s] of ``20-30:+2``."""
    when, _, change = text.partition(":")
    first, _, last = (part.strip() for part in when.partition("-"))
    if not (
        first.isdecimal()
        and last.isdecimal()
        and int(first) < int(last)
        and math.isfinite(_number(change))
    ):
        raise InputError(
            f"{name}: got {text!r}, expected FIRST-LAST:CHANGE, such as 20-30:+2 for 2 m/s more "
            "from rotation 20 to 30"
        )
    return int(first), int(last), _number(change)


def wind_drift(name: str, text: str) -> tuple[float, float]:
    """Standard deviation [m/s] and correlation in rotations of ``0.5`` or ``0.5:20``."""
    std, colon, rotations = text.partition(":")
    values = _number(std), _number(rotations) if colon else DRIFT_ROTATIONS
    if not all(math.isfinite(value) and value > 0 for value in values):
        raise InputError(
            f"{name}: got {text!r}, expected STD or STD:ROTATIONS, both above 0, such as 0.5:20"
        )
    return values


def positive(high: float, unit: str) -> Parser:
    """Parser of numbers above 0 and at most `high`."""

    def parse(name: str, text: str) -> float:
        value = _number(text)
        if not 0.0 < value <= high:
            raise InputError(
                f"{name}: got {text!r}, expected a number above 0 and at most {high:g} [{unit}]"
            )
        return value

    return parse


def words(name: str, text: str) -> tuple[str, ...]:
    """Words separated by commas."""
    found = tuple(part.strip() for part in text.split(","))
    if not all(found):
        raise InputError(f"{name}: got {text!r}, expected words separated by commas")
    return found


def seeds(name: str, text: str) -> tuple[int, ...]:
    """Seeds of ``6`` (1 to 6), ``3:8`` or ``1,5,9``."""
    body = text.strip()
    parts = body.split(":") if ":" in body else body.split(",")
    if not all(part.strip().isdecimal() and len(part.strip()) < 19 for part in parts):
        raise _bad_seeds(name, text)
    values = [int(part) for part in parts]
    if ":" in body:
        if len(values) != 2 or not 0 <= values[1] - values[0] < MOST_SEEDS:
            raise _bad_seeds(name, text)
        return tuple(range(values[0], values[1] + 1))
    if len(values) > 1:
        return tuple(values)
    if not 1 <= values[0] <= MOST_SEEDS:
        raise _bad_seeds(name, text)
    return tuple(range(1, values[0] + 1))


def _bad_seeds(name: str, text: str) -> InputError:
    return InputError(
        f"{name}: got {text!r}, expected their number such as 6 for seeds 1 to 6 (at most "
        f"{MOST_SEEDS}), a range such as 3:8, or seeds such as 1,5,9"
    )


def shape(name: str, text: str) -> tuple[int, ...]:
    """Three numbers of points of ``4096,32,32``."""
    parts = [part.strip() for part in text.split(",")]
    if len(parts) != 3 or not all(part.isdecimal() and 2 <= int(part) < 10**7 for part in parts):
        raise InputError(
            f"{name}: got {text!r}, expected three whole numbers of at least 2, such as 4096,32,32"
        )
    return tuple(map(int, parts))


def spacing(name: str, text: str) -> tuple[float, ...]:
    """Three distances [m] of ``2,5,5``."""
    values = tuple(map(_number, text.split(",")))
    if len(values) != 3 or not all(math.isfinite(value) and value > 0 for value in values):
        raise InputError(f"{name}: got {text!r}, expected three numbers above 0 [m], such as 2,5,5")
    return values
