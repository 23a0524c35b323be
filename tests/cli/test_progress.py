"""What stands on standard error while a command works."""

from __future__ import annotations

import time

import pytest
from numba.core import event

from pitchopt.cli import progress
from pitchopt.cli.progress import Progress

LINE = "pitchopt: compiling the time loop (once)\n"


def compile_for(seconds: float) -> None:
    """What numba reports of a function that it compiles and another inside it."""
    with event.trigger_event("numba:compile"), event.trigger_event("numba:compile"):
        time.sleep(seconds)


@pytest.fixture(autouse=True)
def impatient(monkeypatch):
    monkeypatch.setattr(progress, "DELAY", 0.2)


def test_long_compiling_is_said_once(capsys):
    with Progress(compiled="the time loop"):
        compile_for(0.12)
        assert capsys.readouterr().err == ""
        compile_for(0.3)  # 0.2 s in all are over in the middle of it
        compile_for(0.3)
    done = capsys.readouterr()
    assert (done.out, done.err) == ("", LINE)


def test_nothing_is_said_where_nothing_compiles_for_long(capsys):
    with Progress(compiled="the time loop"):
        compile_for(0.02)
        time.sleep(0.3)
    with Progress():
        compile_for(0.3)
    compile_for(0.3)  # the listener has gone with its context
    assert capsys.readouterr() == ("", "")
