"""The package as a user installs and imports it."""

from __future__ import annotations

import importlib.metadata
import json
import pkgutil
import subprocess
import sys
import tomllib
from importlib import import_module
from pathlib import Path

import pytest

import ilc
import pitchopt
import windfield

HEAVY = ("casadi", "clarabel", "cvxpy", "matplotlib", "numba", "scipy.optimize", "yaml")


def loaded_after(statement: str) -> set[str]:
    """Names of the modules that a fresh interpreter holds after `statement`."""
    code = f"{statement}\nimport json, sys\nprint(json.dumps(sorted(sys.modules)))"
    done = subprocess.run([sys.executable, "-c", code], check=True, capture_output=True, text=True)
    return set(json.loads(done.stdout))


def public_modules() -> list[str]:
    names = ["ilc", "pitchopt", "windfield"]
    for package in (ilc, pitchopt, windfield):
        found = pkgutil.walk_packages(package.__path__, package.__name__ + ".")
        names.extend(module.name for module in found if "._" not in module.name)
    return names


@pytest.mark.parametrize("package", ["ilc", "pitchopt", "windfield"])
def test_import_loads_nothing_heavy(package):
    loaded = loaded_after(f"import {package}")
    assert package in loaded
    assert not loaded.intersection(HEAVY)


def test_version_is_that_of_the_installed_package():
    try:
        installed = importlib.metadata.version("pitchopt")
    except importlib.metadata.PackageNotFoundError:
        pytest.skip("pitchopt is imported from the checkout and not installed")
    assert pitchopt.__version__ == installed


def test_change_log_names_the_version(project_root: Path):
    text = (project_root / "CHANGELOG.md").read_text(encoding="utf-8")
    assert f"## [{pitchopt.__version__}]" in text


@pytest.mark.parametrize("name", pitchopt.__all__)
def test_every_public_name_is_there(name):
    assert getattr(pitchopt, name) is not None


def test_unknown_name_is_an_attribute_error():
    with pytest.raises(AttributeError, match=r"pitchopt.*no_such_name"):
        pitchopt.no_such_name  # noqa: B018  (the access is what is tested)


def test_dir_lists_the_public_names():
    assert set(pitchopt.__all__) <= set(dir(pitchopt))


@pytest.mark.parametrize("name", public_modules())
def test_public_module_has_a_docstring_and_its_names(name):
    module = import_module(name)
    assert (module.__doc__ or "").strip(), f"{name} has no docstring"
    absent = [public for public in getattr(module, "__all__", []) if not hasattr(module, public)]
    assert not absent, f"{name}.__all__ names what is not there: {absent}"


def test_packages_are_marked_as_typed():
    for package in (pitchopt, windfield):
        assert (Path(package.__file__).parent / "py.typed").is_file()


def test_wheel_holds_exactly_the_packages(project_root: Path):
    config = tomllib.loads((project_root / "pyproject.toml").read_text(encoding="utf-8"))
    packages = config["tool"]["hatch"]["build"]["targets"]["wheel"]["packages"]
    with_code = {path.parent.name for path in project_root.glob("*/__init__.py")}
    assert set(packages) == with_code - {"tests", "tools", "benchmarks", "examples"}
