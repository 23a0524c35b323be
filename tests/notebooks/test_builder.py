"""The builder: it pairs by the header, runs from top to bottom and lets nothing pass in silence."""

from __future__ import annotations

import importlib.util
import sys
from pathlib import Path

import pytest

pytest.importorskip("jupytext", reason="comes with the extra notebooks")
pytest.importorskip("nbclient", reason="comes with the extra notebooks")
pytest.importorskip("ipykernel", reason="comes with the extra notebooks")
pytest.importorskip("ipywidgets", reason="comes with the extra notebooks")

ROOT = Path(__file__).resolve().parents[2]
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


def load():
    spec = importlib.util.spec_from_file_location("notebook_builder", ROOT / "tools/notebooks.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


builder = load()


def text(folder, *code, header=HEADER):
    path = folder / "1_sample.py"
    path.write_text(header + "".join(f"# %%\n{cell}\n\n" for cell in code), encoding="utf-8")
    return path


def test_pairs_are_where_the_headers_say():
    for path in builder.sources():
        parts = path.relative_to(builder.ROOT).with_suffix(".ipynb")
        assert builder.pair(path) == builder.ROOT / "build" / parts


def test_a_text_without_a_pair_is_refused(tmp_path):
    path = text(tmp_path, "1 + 1", header=HEADER.replace("build//ipynb,py:percent", "py:percent"))
    with pytest.raises(builder.Failure, match=r"expected one \.ipynb"):
        builder.pair(path)


def test_outputs_pictures_and_sliders_are_kept(tmp_path):
    path = text(
        tmp_path,
        "import sys\nimport matplotlib.pyplot as plt\nfrom ipywidgets import interact\nsys.executable",
        "def draw(a=1.0):\n    plt.subplots()[1].plot([0, a])\n    plt.show()\n\ndraw()",
        "interact(draw, a=(0.0, 2.0));",
    )
    target, seconds = builder.run(path)
    assert target == tmp_path / "build" / "1_sample.ipynb"
    assert 0 < seconds < 60
    import nbformat

    notebook = nbformat.read(target, as_version=4)
    nbformat.validate(notebook)
    first = notebook.cells[0].outputs[0]
    assert first["data"]["text/plain"].strip("'") == sys.executable  # no other kernel than this
    assert [cell.execution_count for cell in notebook.cells] == [1, 2, 3]
    pictures = builder.save_pictures(target, tmp_path / "pictures")
    assert len(pictures) == 2  # the cell's own and the slider's
    assert all(p.read_bytes().startswith(b"\x89PNG") for p in pictures)


@pytest.mark.parametrize(
    ("code", "said"),
    [
        ("1 / 0", "ZeroDivisionError"),
        ("assert 2 < 1, 'not so'", "not so"),
        ("import warnings\nwarnings.warn('look here')", "look here"),
        ("open('left.txt', 'w').close()", "left.txt"),
        (
            "from ipywidgets import interact\n\ndef f(a):\n    return 1 / 0\n\ninteract(f, a=(0, 1));",
            "ZeroDivisionError",
        ),
        ("import os\nos.kill(os.getpid(), 9)", "kernel died"),
    ],
    ids=["error", "assertion", "warning", "file", "slider", "killed"],
)
def test_nothing_passes_in_silence(tmp_path, code, said):
    with pytest.raises(builder.Failure, match=said):
        builder.run(text(tmp_path, code))


def test_no_tag_excuses_an_error(tmp_path):
    path = tmp_path / "1_sample.py"
    path.write_text(HEADER + '# %% tags=["raises-exception"]\n1 / 0\n', encoding="utf-8")
    with pytest.raises(builder.Failure, match="ZeroDivisionError"):
        builder.run(path)


def test_time_is_limited_for_the_whole_notebook(tmp_path):
    path = text(tmp_path, "import time", *["time.sleep(1.0)"] * 30)
    with pytest.raises(builder.Failure, match=r"not done after 4 s|allowed are 4 s"):
        builder.run(path, limit=4.0)


def test_status_says_whether_all_passed(tmp_path, monkeypatch, capsys):
    monkeypatch.setattr(builder, "sources", lambda: [text(tmp_path, "1 / 0")])
    monkeypatch.setattr(builder, "ROOT", tmp_path)
    assert builder.main(["--limit", "60"]) == 1
    said = capsys.readouterr()
    assert "FAILED  1_sample.py" in said.out
    assert "ZeroDivisionError" in said.err
    assert builder.main(["--only", "7"]) == 1
