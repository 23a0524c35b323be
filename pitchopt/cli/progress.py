"""A progress bar on standard error for work over two seconds, and a line while code compiles."""

from __future__ import annotations

import sys
import threading
import time
from collections.abc import Callable
from types import TracebackType
from typing import TYPE_CHECKING, Any

import click

if TYPE_CHECKING:
    from typing import Self

__all__ = ["Progress"]

DELAY = 2.0
INTERVAL = 5.0
"""Least time between two refreshes where standard error is no terminal [s]."""
_COMPILE = "numba:compile"


class Progress:
    """Callable with steps done, steps in all and a label; a context that clears the bar.

    The bar shows itself after two seconds and never on standard output.

    Parameters
    ----------
    compiled : str, optional
        What the context may have to compile, such as ``the time loop``.  Once that has taken two
        seconds, one line says so.
    """

    def __init__(self, compiled: str | None = None) -> None:
        self._bar: Any = None
        self._compiled = compiled
        self._listener: Any = None

    def __enter__(self) -> Self:
        if self._compiled is not None:
            self._listener = _listen(lambda: self._say(f"compiling {self._compiled} (once)"))
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        if self._listener is not None:
            from numba.core import event

            event.unregister(_COMPILE, self._listener)  # type: ignore[no-untyped-call]
        if self._bar is not None:
            self._bar.close()

    def _say(self, text: str) -> None:
        line = f"pitchopt: {text}"
        if sys.stderr.isatty():
            from tqdm import tqdm

            tqdm.write(line, file=sys.stderr)  # above the bar
        else:
            click.echo(line, err=True)

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
        self._bar.total = total  # of one study after another
        self._bar.update(done - self._bar.n)


def _listen(say: Callable[[], None]) -> Any:
    """Registered listener that calls `say` once, when compiling has taken `DELAY` seconds in all.

    What comes from the cache of compiled code does not count.
    """
    from numba.core import event

    class Listener(event.Listener):
        """Clock that runs while something compiles; numba compiles one function at a time."""

        def __init__(self) -> None:
            self.depth = 0
            self.left = DELAY
            self.began = 0.0
            self.timer: threading.Timer | None = None

        def on_start(self, event: object) -> None:  # noqa: ARG002  part of numba's interface
            self.depth += 1
            if self.depth == 1 and self.left > 0.0:
                self.began = time.perf_counter()
                self.timer = threading.Timer(self.left, say)
                self.timer.daemon = True
                self.timer.start()

        def on_end(self, event: object) -> None:  # noqa: ARG002  part of numba's interface
            self.depth -= 1
            if self.depth == 0 and self.timer is not None:
                self.timer.cancel()
                self.timer = None
                self.left -= time.perf_counter() - self.began

    listener = Listener()
    event.register(_COMPILE, listener)  # type: ignore[no-untyped-call]
    return listener
