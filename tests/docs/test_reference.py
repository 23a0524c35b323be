"""Every public name is in the reference, once; commands and case keys are complete."""

from __future__ import annotations

import importlib
import re
import types

from pitchopt.cases.settings import SCHEMA
from pitchopt.cli.main import program


def test_every_public_name_is_documented_once(generated_pages):
    pages = generated_pages.api_pages()
    directive = re.compile(
        r"^\.\. (?:auto(?:class|exception|function)|py:data):: (\S+)", re.MULTILINE
    )
    documented = {}
    for page, text in pages.items():
        package = page.removeprefix("api/").removesuffix(".rst")
        for full in directive.findall(text):
            name = full.removeprefix(f"{package}.")
            assert (package, name) not in documented
            documented[package, name] = True
    owners = generated_pages.homes()
    for (package, name), home in owners.items():
        assert (home, name) in documented, f"{package}.{name}"
        assert name in pages[f"api/{package}.rst"], f"{package}.{name}"


def test_names_of_all_packages_are_looked_at(generated_pages):
    packages = generated_pages.packages()
    assert {"pitchopt", "windfield", "ilc", "pitchopt.design.proof", "pitchopt.errors"} <= set(
        packages
    )
    owners = generated_pages.homes()
    for package in packages:
        for name in getattr(importlib.import_module(package), "__all__", ()):
            assert name.startswith("__") or (package, name) in owners


def test_a_name_is_documented_where_its_module_is(generated_pages):
    owners = generated_pages.homes()
    assert owners["pitchopt", "Design"] == "pitchopt.design"
    assert owners["pitchopt.design", "Certificate"] == "pitchopt.design.proof"


def test_public_objects_have_docstrings(generated_pages):
    for (package, name), home in generated_pages.homes().items():
        value = getattr(importlib.import_module(home), name)
        if isinstance(value, (type, types.FunctionType)):
            assert value.__doc__, f"{package}.{name}"


def test_every_command_has_a_page(generated_pages):
    pages = generated_pages.command_pages()
    for name in program.list_commands(None):
        assert "--help" in pages[f"commands/pitchopt-{name}.rst"], name


def test_every_key_of_a_case_is_in_the_reference(generated_pages):
    page = generated_pages.case_page()
    for entry in SCHEMA:
        assert f"| `{entry.key}` |" in page, entry.name
