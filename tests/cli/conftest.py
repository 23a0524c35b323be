"""Running the program inside the test process."""

from __future__ import annotations

from dataclasses import dataclass

import pytest

from pitchopt.cli import main

SMALL = ("--case", "biegel2011", "--positions", "6", "--segments", "10", "--starts", "1")


@dataclass(frozen=True)
class Outcome:
    """What a run left: exit status, standard output, standard error."""

    status: int
    out: str
    err: str


@pytest.fixture(scope="session")
def boxes(tmp_path_factory):
    """Folder of the Kaimal boxes of all tests of commands."""
    return tmp_path_factory.mktemp("boxes")


@pytest.fixture(autouse=True)
def own_cache(boxes, monkeypatch):
    """No box of the tests in the user's cache folder; no bar on a slow machine."""
    monkeypatch.setenv("XDG_CACHE_HOME", str(boxes))
    monkeypatch.setattr("pitchopt.cli.progress.DELAY", 1e6)


@pytest.fixture
def run(capsys, tmp_path, monkeypatch):
    """Run the program in an empty folder, which is `tmp_path`."""
    monkeypatch.chdir(tmp_path)

    def call(*args: object) -> Outcome:
        capsys.readouterr()
        status = main([str(arg) for arg in args])
        done = capsys.readouterr()
        return Outcome(status, done.out, done.err)

    return call


@pytest.fixture(scope="session")
def small():
    """Options of a case that solves in a fraction of a second."""
    return SMALL


@pytest.fixture(scope="session")
def finished(tmp_path_factory):
    """Folder with the files of a small trade-off."""
    folder = tmp_path_factory.mktemp("finished")
    arguments = ["tradeoff", *SMALL, "--mu", "1,10", "--no-plots", "--out", str(folder)]
    assert main(arguments) == 0
    return folder
