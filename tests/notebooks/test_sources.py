"""The texts of the notebooks: header, cells, exercises, solutions, public names, nothing hidden."""

from __future__ import annotations

import ast
import importlib
import re
from itertools import pairwise
from pathlib import Path

import pytest
import yaml

ROOT = Path(__file__).resolve().parents[2] / "notebooks"
NOTEBOOKS = sorted(ROOT.glob("[0-9]*.py"))
SOLUTIONS = sorted((ROOT / "solutions").glob("[0-9]*.py"))
TEXTS = [*NOTEBOOKS, *SOLUTIONS]
OURS = {"pitchopt", "windfield", "ilc"}
OTHERS = {"numpy", "scipy", "cvxpy", "matplotlib", "ipywidgets", "IPython"}
STANDARD = {
    "collections",
    "concurrent",
    "dataclasses",
    "itertools",
    "functools",
    "math",
    "pathlib",
    "tempfile",
    "time",
}
HEADER = {
    "jupyter": {
        "jupytext": {"text_representation": {"extension": ".py", "format_name": "percent"}},
        "kernelspec": {"display_name": "Python 3", "language": "python", "name": "python3"},
    }
}
FORMATS = {
    "notebooks": "build//ipynb,py:percent",
    "solutions": "build/solutions//ipynb,solutions//py:percent",
}


def name(path):
    return path.relative_to(ROOT).as_posix()


every_text = pytest.mark.parametrize("path", TEXTS, ids=name)
every_notebook = pytest.mark.parametrize("path", NOTEBOOKS, ids=name)


def header_and_body(path):
    """The header as data, and the text after it."""
    lines = path.read_text(encoding="utf-8").splitlines()
    assert lines[0] == "# ---"
    end = lines.index("# ---", 1)
    return yaml.safe_load("\n".join(line[2:] for line in lines[1:end])), lines[end + 1 :]


def cells(path):
    """Kind and text of each cell; markdown without its comment signs."""
    found = []
    for line in header_and_body(path)[1]:
        if line.startswith("# %%"):
            assert line in {"# %%", "# %% [markdown]"}, f"a cell may carry nothing else: {line}"
            found.append(("markdown" if line.endswith("]") else "code", []))
        elif found:
            found[-1][1].append(line)
        else:
            assert not line.strip(), f"outside any cell: {line}"
    out = []
    for kind, lines in found:
        if kind == "markdown":
            assert all(line.startswith("#") for line in lines if line.strip())
            lines = [line[2:] for line in lines]
        out.append((kind, "\n".join(lines).strip()))
    return out


def markdown(path):
    return "\n\n".join(text for kind, text in cells(path) if kind == "markdown")


def exercises(path, pattern):
    return [int(number) for number in re.findall(pattern, markdown(path), re.MULTILINE)]


def test_eight_notebooks_each_with_solutions():
    assert [path.name[0] for path in NOTEBOOKS] == [str(n) for n in range(1, len(NOTEBOOKS) + 1)]
    assert [path.name for path in NOTEBOOKS] == [path.name for path in SOLUTIONS]
    listed = re.findall(r"\((\d_\w+\.py)\)", (ROOT / "README.md").read_text(encoding="utf-8"))
    assert [path.name for path in NOTEBOOKS] == listed[: len(NOTEBOOKS)]


@every_text
def test_header_pairs_the_text_and_holds_nothing_else(path):
    found, _ = header_and_body(path)
    formats = found["jupyter"]["jupytext"].pop("formats")
    assert found == HEADER
    assert formats == FORMATS[path.parent.name]


@every_text
def test_cells_are_plain_python_and_none_is_empty(path):
    found = cells(path)
    assert found[0][0] == "markdown"
    for kind, text in found:
        assert text, "an empty cell"
        if kind == "code":
            assert not re.search(r"^\s*[%!?]|\?$|get_ipython|\bexec\(|\beval\(", text, re.MULTILINE)
            compile(text, path.name, "exec")  # each cell by itself
    assert len({text for _, text in found}) == len(found), "the same cell twice"


@every_text
def test_only_public_names_are_imported(path):
    for _, text in (cell for cell in cells(path) if cell[0] == "code"):
        for node in ast.walk(ast.parse(text)):
            if isinstance(node, ast.Import):
                for alias in node.names:
                    check_module(alias.name)
            elif isinstance(node, ast.ImportFrom):
                assert node.level == 0
                check_module(node.module)
                if node.module.split(".")[0] in OURS:
                    home = importlib.import_module(node.module)
                    for alias in node.names:
                        assert alias.name in home.__all__, f"{node.module}.{alias.name}"
            elif isinstance(node, ast.Attribute):
                private = node.attr.startswith("_") and not node.attr.startswith("__")
                assert not private, f"a private name: {node.attr}"


def check_module(module):
    root = module.split(".")[0]
    assert root in OURS | OTHERS | STANDARD, f"{module} does not come with the notebooks' extra"
    if root in OURS:
        home = importlib.import_module(module)
        assert hasattr(home, "__all__"), f"{module} is not public"
        assert home.__file__.endswith("__init__.py"), f"{module} is a module inside a package"


@every_text
def test_imports_stand_in_the_first_code_cell(path):
    code = [ast.parse(text) for kind, text in cells(path) if kind == "code"]
    for tree in code[1:]:
        assert not any(isinstance(n, ast.Import | ast.ImportFrom) for n in ast.walk(tree))


@every_notebook
def test_parts_of_a_notebook(path):
    found = cells(path)
    titles = [line for line in markdown(path).splitlines() if re.match(r"#{1,2} ", line)]
    assert re.fullmatch(rf"# {path.name[0]}\. .+", titles[0])
    assert sum(line.startswith("# ") for line in titles) == 1
    assert titles[1] == "## What you will learn"
    assert titles[-1] == "## Exercises"
    numbered = titles[2:-1]
    assert [line.split()[1] for line in numbered] == [f"{n}." for n in range(1, len(numbered) + 1)]
    code = "\n".join(text for kind, text in found if kind == "code")
    assert "plt.show()" in code
    assert re.search(r"^assert ", code, re.MULTILINE), "claims are checked where they are made"


@every_notebook
def test_exercises_have_solutions(path):
    asked = exercises(path, r"^\*\*Exercise (\d) \(")
    answered = exercises(ROOT / "solutions" / path.name, r"^## Exercise (\d)$")
    assert 3 <= len(asked) <= 5
    assert asked == list(range(1, len(asked) + 1)) == answered
    title = markdown(path).splitlines()[0].removeprefix("# ")
    assert markdown(ROOT / "solutions" / path.name).startswith(f"# Solutions to {title}")


@every_notebook
def test_every_slider_has_its_picture_drawn_before(path):
    code = [text for kind, text in cells(path) if kind == "code"]
    sliders = 0
    for before, text in pairwise(code):
        for drawn in re.findall(r"^_ = interact\(\s*(\w+),", text, re.MULTILINE):
            sliders += 1
            assert re.search(rf"^{drawn}\(\);?$", before, re.MULTILINE), f"{drawn} stands nowhere"
    assert 1 <= sliders <= 3


@every_text
def test_figures_are_shown_and_no_settings_change(path):
    for kind, text in cells(path):
        if kind == "code" and re.search(r"plt\.(subplots|figure)\(", text):
            assert "plt.show()" in text
        assert "rcParams" not in text
        assert "filterwarnings" not in text
        assert "savefig" not in text


def test_no_built_notebook_lies_beside_the_texts():
    stray = [p for p in ROOT.rglob("*.ipynb") if "build" not in p.relative_to(ROOT).parts]
    assert not [p for p in stray if ".ipynb_checkpoints" not in p.parts]
