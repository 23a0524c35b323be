"""Pages: each in a table of contents, links that lead somewhere, code that runs as shown."""

from __future__ import annotations

import fnmatch
import json
import re
import shlex
import tomllib
from pathlib import Path

import click
import pytest

from pitchopt.cli.main import main, program
from pitchopt.errors import InputError

ROOT = Path(__file__).resolve().parents[2]
DOCS = ROOT / "docs"
PAGES = sorted(
    path
    for path in DOCS.rglob("*.md")
    if not {"_build", "generated", "auto_gallery"} & set(path.relative_to(DOCS).parts)
)
OTHERS = [
    ROOT / name
    for name in (
        "README.md",
        "CONTRIBUTING.md",
        "CHANGELOG.md",
        "NOMENCLATURE.md",
        "examples/README.md",
        "benchmarks/README.md",
    )
]
LINK = re.compile(r"!?\[[^\]\n]*\]\(([^)\s]+)\)")
FENCE = re.compile(r"^```(\w*)\n(.*?)^```", flags=re.MULTILINE | re.DOTALL)
TOCTREE = re.compile(r"^```\{toctree\}\n(.*?)^```", flags=re.MULTILINE | re.DOTALL)


def ids(path):
    return path.relative_to(ROOT).as_posix()


def prose(text):
    """Without blocks of code, in which brackets are not links."""
    return re.sub(r"^```.*?^```", "", text, flags=re.MULTILINE | re.DOTALL)


def toctree_entries():
    entries = []
    for page in PAGES:
        for block in TOCTREE.findall(page.read_text(encoding="utf-8")):
            entries += [
                (page.parent / line.strip()).relative_to(DOCS).as_posix()
                for line in block.splitlines()
                if line.strip() and not line.startswith(":")
            ]
    return entries


@pytest.fixture(scope="module")
def made(generated_pages):
    """Names of all pages that a build makes."""
    pages = {
        **generated_pages.api_pages(),
        **generated_pages.command_pages(),
        **generated_pages.repository_pages(),
        "case-file.md": "",
        "notebook-list.md": "",
    }
    return {f"generated/{name}" for name in pages}


def gallery_pages():
    scripts = (DOCS / "gallery").rglob("plot_*.py")
    names = {f"auto_gallery/{p.relative_to(DOCS / 'gallery').with_suffix('.rst')}" for p in scripts}
    return names | {"auto_gallery/index.rst"}


def test_every_page_is_in_a_table_of_contents():
    entries = toctree_entries()
    for page in PAGES:
        name = page.relative_to(DOCS).with_suffix("").as_posix()
        assert name == "index" or any(fnmatch.fnmatch(name, entry) for entry in entries), name


def test_tables_of_contents_name_pages_that_are_there(made):
    there = {page.relative_to(DOCS).as_posix() for page in PAGES} | made | gallery_pages()
    for entry in toctree_entries():
        assert "*" in entry or {f"{entry}.md", f"{entry}.rst"} & there, entry


@pytest.mark.parametrize("page", [*PAGES, *OTHERS], ids=ids)
def test_relative_links_lead_to_files(page, made):
    for target in LINK.findall(prose(page.read_text(encoding="utf-8"))):
        path = target.partition("#")[0]
        if "://" in target or target.startswith("mailto:") or not path:
            continue
        found = (page.parent / path).resolve()
        assert found.is_relative_to(ROOT), target
        inside = found.relative_to(DOCS).as_posix() if found.is_relative_to(DOCS) else ""
        assert found.exists() or inside in made or inside in gallery_pages(), target


def test_a_link_to_nowhere_would_be_found():
    (target,) = LINK.findall("see [there](no-such-page.md)")
    assert not (DOCS / target).exists()


def test_links_of_the_repository_are_turned_to_pages(generated_pages):
    page = DOCS / "howto" / "any.md"
    text = "[a](../../NOMENCLATURE.md#x), [b](../../examples/05_own_turbine.py), [c](../theory.md)"
    assert generated_pages.repository_links(text, page, page) == (
        "[a](../generated/nomenclature.md#x), b (`examples/05_own_turbine.py`), [c](../theory.md)"
    )


def commands():
    found = []
    for page in [*PAGES, *OTHERS]:
        for language, block in FENCE.findall(page.read_text(encoding="utf-8")):
            if language not in ("", "console", "sh", "bash"):
                continue
            joined = block.replace("\\\n", " ")
            for line in joined.splitlines():
                text = line.strip().removeprefix("$ ")
                if re.match(r"pitchopt [a-z]", text) and (language == "" or line.startswith("$ ")):
                    found.append(pytest.param(text, id=f"{page.stem}: {text[9:60]}"))
    return found


@pytest.mark.parametrize("text", commands())
def test_commands_shown_are_understood(text):
    words = shlex.split(text.partition(" > ")[0], comments=True)
    with click.Context(program, info_name="pitchopt") as context:
        command = program.get_command(context, words[1])
        assert command is not None, words[1]
        with command.make_context(words[1], words[2:], parent=context):
            pass


def test_a_wrong_option_is_not_understood():
    with (
        click.Context(program, info_name="pitchopt") as context,
        pytest.raises((click.ClickException, InputError)),
    ):
        program.get_command(context, "design").make_context("design", ["--no-such", "1"])


RUN = [
    page
    for page in PAGES
    if page.parent.name == "howto" or page.stem in ("tutorial", "json", "dynamics")
]


@pytest.mark.parametrize("page", RUN, ids=ids)
def test_python_shown_runs(page, tmp_path, monkeypatch):
    blocks = [b for language, b in FENCE.findall(page.read_text("utf-8")) if language == "python"]
    if not blocks:
        return  # nothing is shown
    (tmp_path / "examples").symlink_to(ROOT / "examples")
    monkeypatch.chdir(tmp_path)
    names = {"__name__": "shown"}
    for block in blocks:
        exec(compile(block, str(page), "exec"), names)  # noqa: S102  the page's own code


@pytest.mark.parametrize("page", RUN, ids=ids)
def test_toml_shown_is_toml(page):
    for language, block in FENCE.findall(page.read_text(encoding="utf-8")):
        if language == "toml":
            tomllib.loads(block)


@pytest.mark.parametrize(
    "words",
    [
        "tradeoff --positions 6 --segments 10 --points 2 --starts 1 --no-certify --json",
        "design --positions 6 --segments 10 --mu 3 --starts 1 --json",
        "turbines --json",
    ],
    ids=lambda words: words.split()[0],
)
def test_keys_of_documents_are_described(words, capsys):
    assert main(words.split()) == 0
    document = json.loads(capsys.readouterr().out)
    described = set(re.findall(r"`(\w+)`", (DOCS / "json.md").read_text(encoding="utf-8")))
    assert set(document) <= described
    for part in (document.get("design"), *document.get("points", [])):
        assert set(part or {}) <= described


def test_gallery_and_list_of_figures_agree():
    listed = set(
        re.findall(r"auto_gallery/\S+?plot_\w+\.rst", (DOCS / "figures.md").read_text("utf-8"))
    )
    assert listed == gallery_pages() - {"auto_gallery/index.rst"}
