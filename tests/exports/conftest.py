"""What the tests of this folder share: a small trade-off; ROSCO's law, library and parser."""

from __future__ import annotations

import importlib.util
import re
import sys
from pathlib import Path
from types import ModuleType

import pytest

from pitchopt.cases import load_case
from pitchopt.design import tradeoff

BENCHMARKS = Path(__file__).resolve().parents[2] / "benchmarks"


def _module(name: str) -> ModuleType:
    """A script of the folder of benchmarks, as a module."""
    if str(BENCHMARKS) not in sys.path:
        sys.path.append(str(BENCHMARKS))
    known = sys.modules.get(name)
    if known is not None and getattr(known, "__file__", "").startswith(str(BENCHMARKS)):
        return known
    spec = importlib.util.spec_from_file_location(name, BENCHMARKS / f"{name}.py")
    found = importlib.util.module_from_spec(spec)
    sys.modules[name] = found
    spec.loader.exec_module(found)
    return found


def _parsed(text: str, name: str, count: int) -> list[str] | None:
    """Values of a parameter as ROSCO finds them: the first line whose word after them is the name.

    Words are separated by blanks, tabs, commas, semicolons, quotes and exclamation marks.
    """
    for line in text.splitlines():
        words = [word for word in re.split(r"[\s,;'\"!]+", line) if word]
        if len(words) > count and words[count].upper() == name.upper():
            return words[:count]
    return None


@pytest.fixture(scope="session")
def parsed():
    """Finder of a parameter's values, as ROSCO's."""
    return _parsed


@pytest.fixture(scope="session")
def law():
    """`benchmarks/_rosco.py`: ROSCO's law in numpy, and its library."""
    return _module("_rosco")


@pytest.fixture(scope="session")
def bench(law):
    """`benchmarks/rosco.py`: signals and our kernel."""
    return _module("rosco")


@pytest.fixture(scope="session")
def small_case():
    return load_case("biegel2011").with_values({"limits.positions": 6, "aero.segments": 10})


@pytest.fixture(scope="session")
def small_tradeoff(small_case):
    return tradeoff(small_case.task(), mu=[1.0, 10.0], starts=2)
