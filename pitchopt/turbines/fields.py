"""Reader of nested data (JSON, YAML) whose every complaint names file and dotted key.

``Fields(data, file).child("components").child("hub").number("diameter", above=0.0)`` returns a
float or raises ``InputError: turbine.yaml: components.hub.diameter: got -3.0, expected ...``.
Numbers that YAML 1.1 leaves as text (``5e-05`` without a point) count as numbers.
"""

from __future__ import annotations

import difflib
import math
import reprlib
from collections.abc import Iterable, Iterator
from typing import Any, NoReturn

import numpy as np
from numpy.typing import NDArray

from pitchopt.errors import InputError

__all__ = ["Fields", "brief", "one_of"]

FloatArray = NDArray[np.float64]

_SHORT = reprlib.Repr()
_SHORT.maxlevel = 2
_SHORT.maxlist = _SHORT.maxdict = _SHORT.maxtuple = 3
_SHORT.maxstring = _SHORT.maxother = 40


_SHOWN = 8  # keys of a mapping that an error lists


def brief(value: object) -> str:
    """Short one-line text of any value, safe for huge, nested or recursive ones."""
    try:
        return _SHORT.repr(value)[:120]
    except ValueError:  # integers of thousands of digits have no decimal text
        return f"an unprintable {type(value).__name__}"


def one_of(name: str, known: Iterable[str]) -> str:
    """What to say of a name that is not among the known ones, with the nearest of them."""
    names = sorted(known)
    near = difflib.get_close_matches(name[:80], names, n=1)
    hint = f"; did you mean {near[0]!r}?" if near else ""
    return f"got {brief(name)}, expected one of {', '.join(names)}"[:400] + hint


def _bounds(
    above: float | None, at_least: float | None, at_most: float | None, unit: str = ""
) -> str:
    parts = [
        f"{word} {bound:g}"
        for word, bound in (("above", above), ("at least", at_least), ("at most", at_most))
        if bound is not None
    ]
    text = "a finite number" + (" " + " and ".join(parts) if parts else "")
    return f"{text} [{unit}]" if unit else text


def _as_number(value: object) -> float | None:
    """`value` as a float, None if it is not a number at all."""
    if isinstance(value, bool) or not isinstance(value, int | float | str):
        return None
    try:
        return float(value)
    except (ValueError, OverflowError):
        return None


class Fields:
    """One mapping of a file, with the file's name and the dotted path that led to it.

    Parameters
    ----------
    data : object
        What stands at `path`; anything but a mapping is an error.
    file : str
        Name for messages.
    path : str
        Dotted path, empty for the whole file.
    known : frozenset of str, optional
        All keys of the format.  With them a key that is not among them and nearly that of an
        optional entry is an error, not an entry left out in silence.

    Raises
    ------
    InputError
        If `data` is not a mapping.
    """

    def __init__(
        self, data: object, file: str, path: str = "", known: frozenset[str] = frozenset()
    ) -> None:
        if not isinstance(data, dict):
            where = f"{path}: " if path else ""
            raise InputError(f"{file}: {where}got {brief(data)}, expected a mapping of keys")
        self.data: dict[Any, Any] = data
        self.file = file
        self.path = path
        self.known = known

    def name(self, key: str) -> str:
        """Dotted path of `key`."""
        return f"{self.path}.{key}" if self.path else key

    def fail(self, key: str, message: str) -> NoReturn:
        """Raise the error of this file about `key`."""
        raise InputError(f"{self.file}: {self.name(key)}: {message}")

    def has(self, key: str) -> bool:
        """Whether `key` is there with a value; an error if one stands there that is nearly it."""
        if key not in self.data and self.known:
            near = self._nearest(key, 0.8)
            if near is not None:
                self.fail(near, f"unknown key; did you mean {key!r}?")
        return self.data.get(key) is not None

    def value(self, key: str) -> Any:
        """Whatever stands at `key`, which must be there."""
        if key not in self.data:
            near = self._nearest(key, 0.6)
            there = f"; did you mean it by {near!r}?" if near is not None else self._there()
            self.fail(key, f"the key is missing{there}")
        return self.data[key]

    def _nearest(self, key: str, cutoff: float) -> str | None:
        """A key that stands there, is not known, and is nearly `key`."""
        other = [name for name in self.data if isinstance(name, str) and name not in self.known]
        near = difflib.get_close_matches(key, [name[:80] for name in other], n=1, cutoff=cutoff)
        return near[0] if near else None

    def _there(self) -> str:
        """What keys stand there, in words."""
        names = [brief(name)[1:-1] if isinstance(name, str) else brief(name) for name in self.data]
        shown = ", ".join(names[:_SHOWN]) + (", ..." if len(names) > _SHOWN else "")
        return f", there are {shown}" if names else ", the mapping is empty"

    def child(self, key: str) -> Fields:
        """The mapping at `key`."""
        return Fields(self.value(key), self.file, self.name(key), self.known)

    def optional(self, key: str) -> Fields | None:
        """The mapping at `key`, None if there is none."""
        return self.child(key) if self.has(key) else None

    def children(self, key: str) -> Iterator[Fields]:
        """The mappings of the list at `key`, which must not be empty."""
        items = self.value(key)
        if not isinstance(items, list) or not items:
            self.fail(key, f"got {brief(items)}, expected a list with at least one entry")
        for i, item in enumerate(items):
            yield Fields(item, self.file, f"{self.name(key)}[{i}]", self.known)

    def text(self, key: str, default: str | None = None) -> str:
        """Text or number at `key` as text."""
        if default is not None and not self.has(key):
            return default
        value = self.value(key)
        if isinstance(value, bool) or not isinstance(value, str | int | float):
            self.fail(key, f"got {brief(value)}, expected text")
        return str(value)

    def texts(self, key: str) -> list[str]:
        """List of texts at `key`."""
        value = self.value(key)
        if not isinstance(value, list) or not all(isinstance(item, str) for item in value):
            self.fail(key, f"got {brief(value)}, expected a list of texts")
        return list(value)

    def number(
        self,
        key: str,
        *,
        above: float | None = None,
        at_least: float | None = None,
        at_most: float | None = None,
        unit: str = "",
    ) -> float:
        """Finite number at `key` within the bounds, whose unit stands in the message."""
        value = self.value(key)
        number = _as_number(value)
        if (
            number is None
            or not math.isfinite(number)
            or (above is not None and number <= above)
            or (at_least is not None and number < at_least)
            or (at_most is not None and number > at_most)
        ):
            expected = _bounds(above, at_least, at_most, unit)
            self.fail(key, f"got {brief(value)}, expected {expected}")
        return number

    def maybe_number(
        self,
        key: str,
        *,
        above: float | None = None,
        at_least: float | None = None,
        at_most: float | None = None,
        unit: str = "",
    ) -> float | None:
        """As `number`, None if the key is absent."""
        if not self.has(key):
            return None
        return self.number(key, above=above, at_least=at_least, at_most=at_most, unit=unit)

    def integer(self, key: str, *, at_least: int) -> int:
        """Whole number at `key`."""
        number = self.number(key)
        if number != int(number) or number < at_least:
            self.fail(key, f"got {brief(self.data[key])}, expected a whole number >= {at_least}")
        return int(number)

    def array(
        self,
        key: str,
        *,
        size: int | None = None,
        above: float | None = None,
        at_least: float | None = None,
        at_most: float | None = None,
        increasing: bool = False,
        unit: str = "",
    ) -> FloatArray:
        """Vector of finite numbers at `key`.

        Parameters
        ----------
        key : str
            Key of the list.
        size : int, optional
            Length that is required.
        above, at_least, at_most : float, optional
            Bounds on every entry.
        increasing : bool
            Whether every entry must exceed the one before.
        unit : str
            Unit, for the message.

        Returns
        -------
        ndarray (n,)
        """
        value = self.value(key)
        if not isinstance(value, list) or not value:
            self.fail(key, f"got {brief(value)}, expected a list of numbers")
        if size is not None and len(value) != size:
            self.fail(key, f"got {len(value)} values, expected {size}")
        numbers = [_as_number(item) for item in value]
        array = np.array([np.nan if x is None else x for x in numbers], dtype=np.float64)
        bad = ~np.isfinite(array)
        if above is not None:
            bad |= array <= above
        if at_least is not None:
            bad |= array < at_least
        if at_most is not None:
            bad |= array > at_most
        if np.any(bad):
            i = int(np.argmax(bad))
            self.fail(
                f"{key}[{i}]",
                f"got {brief(value[i])}, expected {_bounds(above, at_least, at_most, unit)}",
            )
        if increasing and np.any(np.diff(array) <= 0.0):
            self.fail_order(key, array)
        return array

    def fail_order(self, key: str, array: FloatArray) -> NoReturn:
        """Raise the error about the first entry that does not exceed the one before."""
        i = int(np.argmax(np.diff(array) <= 0.0)) + 1
        self.fail(f"{key}[{i}]", f"got {array[i]:g} after {array[i - 1]:g}, expected more")

    def maybe_array(
        self, key: str, *, size: int | None = None, at_least: float | None = None
    ) -> FloatArray | None:
        """As `array`, None if the key is absent."""
        return self.array(key, size=size, at_least=at_least) if self.has(key) else None
