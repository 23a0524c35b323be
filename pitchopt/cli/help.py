"""How the help of a command reads: its options in named sections, the shared ones last.

A command made with ``cls=Command`` prints a section of options for each title that
:func:`section` gave them, in the order in which they come; ``--help`` stands in the last one.
"""

from __future__ import annotations

import difflib
from collections.abc import Callable, Iterable
from typing import Any, TypeVar

import click

__all__ = ["COMPUTATION", "OUTPUT", "SEARCH", "Aliased", "Command", "nearest", "section"]

F = TypeVar("F", bound=Callable[..., Any])

# Titles that several commands share; the last one ends a help.
SEARCH = "Search and proof"
COMPUTATION = "Computation"
OUTPUT = "Output"
_UNTITLED = "Options"


def section(title: str, *options: Callable[[Any], Any]) -> Callable[[F], F]:
    """Decorator that adds options to a command, under a title of its help.

    Parameters
    ----------
    title : str
    *options : decorators
        Of ``click.option``, in the order of the help.
    """

    def decorate(function: F) -> F:
        for option in reversed(options):
            function = option(function)
            made: list[Any] = function.__click_params__  # type: ignore[attr-defined]  # click's
            made[-1].section = title
        return function

    return decorate


class Command(click.Command):
    """A command whose help has its options in sections."""

    def format_options(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        """Options under the titles that `section` gave them."""
        rows: dict[str, list[tuple[str, str]]] = {}
        for parameter in self.get_params(ctx):
            record = parameter.get_help_record(ctx)
            if isinstance(parameter, click.Option) and record is not None:
                rows.setdefault(getattr(parameter, "section", _UNTITLED), []).append(record)
        # --help comes last and without a title: it stands in the section that ends the help
        if OUTPUT in rows:
            rows[OUTPUT] = rows.pop(OUTPUT) + rows[_UNTITLED][-1:]
            rows[_UNTITLED] = rows[_UNTITLED][:-1]
        for title, records in rows.items():
            if records:
                with formatter.section(title):
                    formatter.write_dl(records)


class Aliased(click.Option):
    """An option whose last name is an older one, understood but left out of the help."""

    def get_help_record(self, ctx: click.Context) -> tuple[str, str] | None:
        """The record without the older name."""
        record = super().get_help_record(ctx)
        if record is None:
            return None
        names, text = record
        return names.replace(f", {self.opts[-1]}", ""), text


def nearest(word: str, known: Iterable[str], *, cutoff: float = 0.6) -> str:
    """``; did you mean 'X'?`` for the nearest of the known words, or nothing."""
    near = difflib.get_close_matches(word, list(known), n=1, cutoff=cutoff)
    return f"; did you mean {near[0]!r}?" if near else ""
