"""Kinds of values in a case: how one is read, checked and shown.

A value has two forms.  In files and on the command line it is plain: text, a number in the unit
that the key names (``pitch_rate_deg``), true or false.  Inside it is SI and radians.  Every
complaint is one line, ``field: got X, expected Y``.
"""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NoReturn

import numpy as np

from pitchopt.design.problem import LoadWeights
from pitchopt.errors import InputError
from pitchopt.turbines.fields import brief

__all__ = ["Choice", "Count", "Flag", "Kind", "Number", "PathName", "Text", "Weights"]


def scalar(text: str) -> Any:
    """Text of the command line as the plain value that a case file would hold."""
    for convert in (int, float):
        try:
            return convert(text)
        except ValueError:
            continue
    return {"true": True, "yes": True, "false": False, "no": False}.get(text.lower(), text)


class Kind(ABC):
    """What a value may be."""

    @abstractmethod
    def allowed(self) -> str:
        """What is allowed, in words."""

    @abstractmethod
    def read(self, name: str, value: Any) -> Any:
        """Inner value of a plain one."""

    def check(self, name: str, value: Any) -> Any:
        """The inner value itself, if it is allowed."""
        return self.read(name, value)

    def show(self, value: Any) -> Any:
        """Plain value of an inner one."""
        return value

    def parse(self, name: str, text: str) -> Any:
        """Inner value of text from the command line."""
        return self.read(name, scalar(text.strip()))

    def fail(self, name: str, value: object) -> NoReturn:
        """Raise the error of this kind."""
        raise InputError(f"{name}: got {brief(value)}, expected {self.allowed()}")


@dataclass(frozen=True, kw_only=True)
class Number(Kind):
    """A finite number.

    Parameters
    ----------
    unit : str
        Unit of the plain value.
    factor : float
        Inner value over plain value.
    above, at_least, at_most : float, optional
        Bounds on the plain value.
    word : str, optional
        Plain text that stands for None.
    """

    unit: str = ""
    factor: float = 1.0
    above: float | None = None
    at_least: float | None = None
    at_most: float | None = None
    word: str | None = None

    def allowed(self) -> str:
        """What is allowed, in words."""
        bounds = [
            f"{label} {bound:g}"
            for label, bound in (
                ("above", self.above),
                ("of at least", self.at_least),
                ("of at most", self.at_most),
            )
            if bound is not None
        ]
        unit = f" [{self.unit}]" if self.unit else ""
        word = f" or {self.word!r}" if self.word else ""
        return " ".join(("a finite number", " and ".join(bounds))).rstrip() + unit + word

    def read(self, name: str, value: Any) -> float | None:
        """Inner value of a plain one."""
        if value == self.word is not None:
            return None
        if not self._fits(value):
            self.fail(name, value)
        return float(value) * self.factor

    def check(self, name: str, value: Any) -> float | None:
        """The inner value itself, if it is allowed."""
        if value is None and self.word is not None:
            return None
        number = isinstance(value, (int, float, np.integer, np.floating))
        if not number or not self._fits(self.show(value)):
            self.fail(name, self.show(value) if number else value)
        return float(value)

    def show(self, value: Any) -> Any:
        """Plain value of an inner one, free of the rounding of the conversion."""
        if value is None:
            return self.word
        return float(f"{value / self.factor:.14g}")

    def _fits(self, value: Any) -> bool:
        if isinstance(value, (bool, np.bool_)):
            return False
        if not isinstance(value, (int, float, np.integer, np.floating)):
            return False
        try:
            number = float(value)
        except OverflowError:
            return False
        return (
            math.isfinite(number)
            and (self.above is None or number > self.above)
            and (self.at_least is None or number >= self.at_least)
            and (self.at_most is None or number <= self.at_most)
        )


@dataclass(frozen=True, kw_only=True)
class Count(Kind):
    """A whole number; `word` stands for None."""

    at_least: int = 1
    at_most: int
    word: str | None = None

    def allowed(self) -> str:
        """What is allowed, in words."""
        word = f" or {self.word!r}" if self.word else ""
        return f"a whole number from {self.at_least} to {self.at_most}{word}"

    def read(self, name: str, value: Any) -> int | None:
        """Inner value of a plain one."""
        if value == self.word is not None:
            return None
        whole = isinstance(value, (int, np.integer)) and not isinstance(value, bool)
        if not whole or not self.at_least <= value <= self.at_most:
            self.fail(name, value)
        return int(value)

    def check(self, name: str, value: Any) -> int | None:
        """The inner value itself, if it is allowed."""
        return None if value is None and self.word is not None else self.read(name, value)

    def show(self, value: Any) -> Any:
        """Plain value of an inner one."""
        return self.word if value is None else value


@dataclass(frozen=True)
class Flag(Kind):
    """True or false."""

    def allowed(self) -> str:
        """What is allowed, in words."""
        return "true or false"

    def read(self, name: str, value: Any) -> bool:
        """Inner value of a plain one."""
        if not isinstance(value, (bool, np.bool_)):
            self.fail(name, value)
        return bool(value)


@dataclass(frozen=True)
class Choice(Kind):
    """One of some words."""

    words: tuple[str, ...]

    def allowed(self) -> str:
        """What is allowed, in words."""
        return "one of " + ", ".join(self.words)

    def read(self, name: str, value: Any) -> str:
        """Inner value of a plain one."""
        if not isinstance(value, str) or value not in self.words:
            self.fail(name, value)
        return value

    def parse(self, name: str, text: str) -> str:
        """Inner value of text from the command line."""
        return self.read(name, text.strip())


@dataclass(frozen=True, kw_only=True)
class Text(Kind):
    """One line of text; empty text stands for None if `optional`."""

    optional: bool = False

    def allowed(self) -> str:
        """What is allowed, in words."""
        return "one line of text" + (" or ''" if self.optional else "")

    def read(self, name: str, value: Any) -> str | None:
        """Inner value of a plain one."""
        if value == "" and self.optional:
            return None
        if not isinstance(value, str) or not value.strip() or not value.isprintable():
            self.fail(name, value)
        return value

    def check(self, name: str, value: Any) -> str | None:
        """The inner value itself, if it is allowed."""
        return None if value is None and self.optional else self.read(name, value)

    def show(self, value: Any) -> Any:
        """Plain value of an inner one."""
        return "" if value is None else value

    def parse(self, name: str, text: str) -> str | None:
        """Inner value of text from the command line."""
        return self.read(name, text)


@dataclass(frozen=True)
class PathName(Kind):
    """Path of a file; empty text stands for None."""

    def allowed(self) -> str:
        """What is allowed, in words."""
        return "the path of a file or ''"

    def read(self, name: str, value: Any) -> Path | None:
        """Inner value of a plain one."""
        if value == "":
            return None
        if not isinstance(value, (str, Path)) or not str(value).isprintable():
            self.fail(name, value)
        return Path(value)

    def check(self, name: str, value: Any) -> Path | None:
        """The inner value itself, if it is allowed."""
        return None if value is None else self.read(name, value)

    def show(self, value: Any) -> Any:
        """Plain value of an inner one."""
        return "" if value is None else str(value)

    def parse(self, name: str, text: str) -> Path | None:
        """Inner value of text from the command line."""
        return self.read(name, text)


@dataclass(frozen=True)
class Weights(Kind):
    """Weights of the loads: a named set, or the weights themselves.

    The inner value is the name of a set or a `LoadWeights`.  Loads that an own set does not
    name weigh nothing.
    """

    NAMES = ("unit", "tower-base")
    LOADS = ("torque", "tilt", "yaw", "thrust", "blade")

    def allowed(self) -> str:
        """What is allowed, in words."""
        return (
            "unit, tower-base or weights such as torque=1,tilt=1,yaw=1,thrust=90,blade=0, none "
            "negative and one above 0"
        )

    def read(self, name: str, value: Any) -> str | LoadWeights:
        """Inner value of a plain one."""
        if isinstance(value, LoadWeights):
            return value
        if isinstance(value, str) and value in self.NAMES:
            return value
        if not isinstance(value, Mapping) or not value or set(value) - set(self.LOADS):
            self.fail(name, dict(value) if isinstance(value, Mapping) else value)
        kind = Number(at_least=0.0)
        numbers = {load: kind.read(f"{name}.{load}", value.get(load, 0.0)) for load in self.LOADS}
        if not any(numbers.values()):
            self.fail(name, dict(value))
        torque, tilt, yaw, thrust, blade = (numbers[load] or 0.0 for load in self.LOADS)
        return LoadWeights(torque=torque, tilt=tilt, yaw=yaw, thrust=thrust, blade=blade)

    def show(self, value: Any) -> Any:
        """Plain value of an inner one."""
        if isinstance(value, LoadWeights):
            return {load: float(getattr(value, load)) for load in self.LOADS}
        return value

    def parse(self, name: str, text: str) -> str | LoadWeights:
        """Inner value of text from the command line, ``torque=1,tilt=1``."""
        if "=" not in text:
            return self.read(name, text.strip())
        pairs = [part.split("=", 1) for part in text.split(",")]
        keys = [pair[0].strip() for pair in pairs]
        if any(len(pair) != 2 for pair in pairs) or len(set(keys)) != len(keys):
            self.fail(name, text)
        return self.read(name, {pair[0].strip(): scalar(pair[1].strip()) for pair in pairs})
