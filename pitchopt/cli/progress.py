"""A progress bar on standard error for work over two seconds."""

from __future__ import annotations

import sys
from types import TracebackType
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from typing import Self

__all__ = ["Progress"]

DELAY = 2.0
INTERVAL = 5.0
"""Least time between two refreshes where standard error is no terminal [s]."""


class Progress:
    """Callable with steps done, steps in all and a label; a context that clears the bar.

    The bar shows itself after two seconds and never on standard output.
    """

    def __init__(self) -> None:
        self._bar: Any = None

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        if self._bar is not None:
            self._bar.close()

    def __call__(self, done: int, total: int, label: str) -> None:
        """Show that `done` of `total` steps are made."""
        if self._bar is None:
            from tqdm import tqdm

            self._bar = tqdm(
                total=total,
                delay=DELAY,
                leave=False,
                file=sys.stderr,
                unit="step",
                mininterval=0.1 if sys.stderr.isatty() else INTERVAL,
                bar_format="{desc} |{bar:30}| {n_fmt}/{total_fmt} [{elapsed}<{remaining}]",
            )
        self._bar.set_description_str(f"{label:<16.16}", refresh=False)
        self._bar.update(done - self._bar.n)
