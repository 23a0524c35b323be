"""The builder: it pairs by the header, runs from top to bottom and lets nothing pass in silence."""

from __future__ import annotations

import importlib.util
import os
import subprocess
import sys
from pathlib import Path

import pytest

for name in ("jupytext", "nbclient", "ipykernel", "ipywidgets"):
    pytest.importorskip(name, reason="comes with the extra notebooks")

SCRIPT = Path(__file__).resolve().parents[2] / "tools" / "notebooks.py"
HEADER = """# ---
# jupyter:
#   jupytext:
#     formats: build//ipynb,py:percent
#     text_representation:
#       extension: .py
#       format_name: percent
#   kernelspec:
#     display_name: Python 3
#     language: python
#     name: python3
# ---

"""
GOOD = """# %%
import os
import sys

import matplotlib.pyplot as plt
from ipywidgets import interact

print(sys.executable, os.listdir())

# %%
def draw(a=1.0):
    plt.subplots()[1].plot([0, a])
    plt.show()

draw()

# %%
_ = interact(draw, a=(0.0, 2.0))
"""
# file name -> cells, and what the builder must say of them
BAD = {
    "2_error": ("# %%\n1 / 0\n", "ZeroDivisionError"),
    "3_assertion": ("# %%\nassert 2 < 1, 'not so'\n", "not so"),
    "4_warning": ("# %%\nimport warnings\nwarnings.warn('look here')\n", "look here"),
    "5_file": ("# %%\nopen('left.txt', 'w').close()\n", "left files behind: left.txt"),
    "6_slider": (
        "# %%\nfrom ipywidgets import interact\n\n# %%\ninteract(lambda b: [][b], b=(0, 4, 1));\n",
        "IndexError",
    ),
    "7_killed": ("# %%\nimport os\nos.kill(os.getpid(), 9)\n", "kernel died"),
    "8_tag": ('# %% tags=["raises-exception"]\n{}["key"]\n', "KeyError"),
}


@pytest.fixture(scope="module")
def builder():
    spec = importlib.util.spec_from_file_location("notebook_builder", SCRIPT)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def build(folder, *options):
    """The script in a process of its own; the plotting backend here must not reach the kernel."""
    command = [sys.executable, str(SCRIPT), str(folder), *options]
    environment = {**os.environ, "MPLBACKEND": "Agg", "PYTHONWARNINGS": "ignore"}
    return subprocess.run(command, capture_output=True, text=True, env=environment, check=False)


@pytest.fixture(scope="module")
def built(tmp_path_factory):
    folder = tmp_path_factory.mktemp("texts")
    (folder / "1_good.py").write_text(HEADER + GOOD, encoding="utf-8")
    for stem, (cells, _) in BAD.items():
        (folder / f"{stem}.py").write_text(HEADER + cells, encoding="utf-8")
    return folder, build(folder, "--jobs", "2", "--pictures", str(folder / "pictures"))


def test_pairs_are_where_the_headers_say(builder):
    for path in builder.sources():
        name = path.relative_to(builder.ROOT).with_suffix(".ipynb")
        assert builder.pair(path) == builder.ROOT / "build" / name


def test_a_text_without_a_pair_is_refused(tmp_path, builder):
    path = tmp_path / "1_sample.py"
    path.write_text(HEADER.replace("build//ipynb,", ""), encoding="utf-8")
    with pytest.raises(builder.NotebookError, match=r"expected one \.ipynb"):
        builder.pair(path)


def test_outputs_pictures_and_sliders_are_kept(built):
    import nbformat

    folder, _ = built
    notebook = nbformat.read(folder / "build" / "1_good.ipynb", as_version=4)
    nbformat.validate(notebook)
    assert [cell.execution_count for cell in notebook.cells] == [1, 2, 3]
    # this interpreter and no registered kernel, in an empty folder
    assert notebook.cells[0].outputs[0]["text"] == f"{sys.executable} []\n"
    pictures = sorted((folder / "pictures").iterdir())
    assert len(pictures) == 2  # the cell's own and the slider's
    assert all(p.read_bytes().startswith(b"\x89PNG") for p in pictures)


def test_status_and_list_say_what_passed(built):
    _, done = built
    assert done.returncode == 1
    lines = done.stdout.splitlines()
    assert [line.split()[-1] for line in lines[:-1]] == ["1_good.py", *(f"{s}.py" for s in BAD)]
    assert ["FAILED" in line for line in lines[:-1]] == [False] + [True] * len(BAD)
    assert lines[-1] == "1 of 8 notebooks ran from top to bottom"


@pytest.mark.parametrize("stem", BAD)
def test_nothing_passes_in_silence(built, stem):
    _, done = built
    said = done.stderr[done.stderr.index(f"{stem}.py: ") :]
    after = [f"{other}.py: " for other in BAD if other != stem and f"{other}.py: " in said]
    for other in after:
        said = said.partition(other)[0]
    assert BAD[stem][1] in said


def test_time_is_limited_for_the_whole_notebook(tmp_path):
    cells = "# %%\nimport time\n" + "\n# %%\ntime.sleep(0.5)\n" * 30
    (tmp_path / "1_long.py").write_text(HEADER + cells, encoding="utf-8")
    done = build(tmp_path, "--limit", "2")
    assert done.returncode == 1
    assert "not done after 2 s" in done.stderr


def test_nothing_to_run_is_an_error(tmp_path):
    done = build(tmp_path)
    assert done.returncode == 1
    assert "no notebooks" in done.stderr
