"""The architecture page says what the contracts and the imports are."""

from __future__ import annotations

import ast
import re
import tomllib
from functools import cache
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
PAGE = (ROOT / "docs" / "architecture.md").read_text(encoding="utf-8")


def test_contracts_of_the_table_are_those_of_the_linter():
    settings = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
    contracts = {c["id"] for c in settings["tool"]["importlinter"]["contracts"]}
    rows = re.findall(r"^\| (`[^|]+) \|", PAGE[PAGE.index("| contract |") :], flags=re.MULTILINE)
    assert {name for row in rows for name in re.findall(r"`([a-z-]+)`", row)} == contracts


@cache
def parts():
    found = ["windfield", "ilc"]
    for path in sorted((ROOT / "pitchopt").iterdir()):
        if path.name.startswith("_"):
            continue
        if path.is_dir() and (path / "__init__.py").is_file():
            found.append(path.name)
        elif path.suffix == ".py":
            found.append(path.stem)
    return found


@cache
def imports():
    """Which part imports which, anywhere in its modules, type checkers' imports included."""
    arrows = set()
    for root in ("pitchopt", "windfield", "ilc"):
        for path in (ROOT / root).rglob("*.py"):
            words = path.relative_to(ROOT).with_suffix("").parts
            if root == "pitchopt" and (len(words) == 2 and words[1].startswith("_")):
                continue  # public names, which load on first use
            own = words[1] if root == "pitchopt" else root
            for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
                names = []
                if isinstance(node, ast.ImportFrom) and node.module and not node.level:
                    names = [node.module]
                    if node.module == "pitchopt":
                        names = [f"pitchopt.{alias.name}" for alias in node.names]
                elif isinstance(node, ast.Import):
                    names = [alias.name for alias in node.names]
                for name in names:
                    target = name.split(".")
                    if target[0] == "pitchopt" and len(target) > 1 and target[1] in parts():
                        arrows.add((own, target[1]))
                    elif target[0] in ("windfield", "ilc"):
                        arrows.add((own, target[0]))
    return {(a, b) for a, b in arrows if a != b}


def drawn():
    """Arrows of the page's table `imports`."""
    block = PAGE[PAGE.index("| part | imports |") :].split("\n\n")[0]
    arrows = set()
    for row in block.splitlines()[2:]:
        part, targets = (re.findall(r"`(\w+)`", cell) for cell in row.strip("|").split("|")[:2])
        arrows |= {(a, b) for a in part for b in targets}
    return arrows


def test_arrows_of_the_page_are_the_imports():
    assert sorted(imports() - drawn()) == [], "imports that the page lacks"
    assert sorted(drawn() - imports()) == [], "arrows of the page that nothing takes"


def test_every_part_is_on_the_page():
    for part in parts():
        assert f"`{part}`" in PAGE, part
