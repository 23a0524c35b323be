"""The docs' own modules and the tools, loaded from their files."""

from __future__ import annotations

import importlib.util
import sys
from pathlib import Path
from types import ModuleType

import pytest

ROOT = Path(__file__).resolve().parents[2]


def load(name: str, path: Path) -> ModuleType:
    spec = importlib.util.spec_from_file_location(name, path)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    sys.modules[name] = module  # dataclasses and annotations look it up
    spec.loader.exec_module(module)
    return module


@pytest.fixture(scope="session")
def generated_pages():
    return load("docs_generated_pages", ROOT / "docs" / "_ext" / "generated_pages.py")


@pytest.fixture
def record_tables():
    return load("tools_record_tables", ROOT / "tools" / "record_tables.py")
