"""Pages made at each build, in ``docs/generated``: the API, the commands, and files of the root.

API: one page for each public package, with its docstring, a table of its public names (``__all__``)
and their documentation.  A name that several packages offer is documented once, in the first of
`homes`; the others link there.  Commands: what ``--help`` prints.  Root: NOMENCLATURE.md,
CHANGELOG.md and others, with their links turned to the site's pages.
"""

from __future__ import annotations

import ast
import importlib
import inspect
import os
import pkgutil
import re
import sys
from collections.abc import Iterator
from pathlib import Path
from types import ModuleType
from typing import Any

__all__ = [
    "REPOSITORY_PAGES",
    "api_pages",
    "command_pages",
    "homes",
    "packages",
    "repository_links",
    "setup",
    "write_pages",
]

ROOT = Path(__file__).resolve().parents[2]
DOCS = ROOT / "docs"
GENERATED = "generated"
PUBLIC = ("pitchopt", "windfield", "ilc")
MODULES = ("pitchopt.checks", "pitchopt.errors")  # public modules that are no packages

# files outside of docs/ that the site shows, and their pages
REPOSITORY_PAGES = {
    "NOMENCLATURE.md": "nomenclature",
    "CHANGELOG.md": "changelog",
    "CONTRIBUTING.md": "contributing",
    "examples/README.md": "examples",
    "benchmarks/README.md": "benchmarks",
}

_LINK = re.compile(r"(?<!!)\[([^\]\n]*)\]\(([^)\s]+)\)")


# --- the API -----------------------------------------------------------------------------------
def packages() -> list[str]:
    """Public packages and modules, a package before what is in it."""
    found = []
    for root in PUBLIC:
        module = importlib.import_module(root)
        found.append(root)
        found += [
            info.name
            for info in pkgutil.walk_packages(module.__path__, f"{root}.")
            if info.ispkg and not any(part.startswith("_") for part in info.name.split("."))
        ]
    return sorted([*found, *MODULES], key=lambda name: (PUBLIC.index(name.split(".")[0]), name))


def public_names(module: ModuleType) -> list[str]:
    """What a module offers."""
    return [name for name in getattr(module, "__all__", []) if not name.startswith("__")]


def homes() -> dict[tuple[str, str], str]:
    """Where each public name is documented: {(package, name): package that documents it}.

    An object belongs to the public package whose name begins its own module's name at the greatest
    length, so that `pitchopt.Design` is documented with `pitchopt.design`.
    """
    offered = {name: importlib.import_module(name) for name in packages()}
    result = {}
    for package, module in offered.items():
        for name in public_names(module):
            value = getattr(module, name)
            where = getattr(value, "__module__", None) or package
            holders = [
                other
                for other, candidate in offered.items()
                if name in public_names(candidate) and getattr(candidate, name) is value
            ]
            result[package, name] = max(
                holders, key=lambda other: (_common(other, where), -len(other))
            )
    return result


def _common(package: str, module: str) -> int:
    """How many parts of the names agree; nothing where the package is no ancestor."""
    own, parts = package.split("."), module.split(".")
    return len(own) if parts[: len(own)] == own else 0


def _title(text: str, line: str) -> list[str]:
    return [text, line * len(text), ""]


def _kind(value: object) -> str:
    if inspect.isclass(value):
        return "exception" if issubclass(value, BaseException) else "class"
    return "function" if inspect.isroutine(value) else "data"


def _short(value: object) -> str:
    text = " ".join(repr(value).split())
    return text if len(text) <= 160 else f"{text[:150]} ..."


def _documentation(package: str, name: str, value: object) -> Iterator[str]:
    kind = _kind(value)
    if kind == "data":  # autodoc would show the docstring of its type
        yield f".. py:data:: {name}"
        yield f"   :value: {_short(value)}"
        yield ""
        return
    yield f".. auto{kind}:: {package}.{name}"
    if kind in {"class", "exception"}:
        yield "   :members:"
    if kind == "exception":
        yield "   :show-inheritance:"
    yield ""


def api_pages() -> dict[str, str]:
    """Pages of the API by file name."""
    owners = homes()
    pages = {}
    for package in packages():
        module = importlib.import_module(package)
        names = sorted(public_names(module), key=str.lower)
        own = [name for name in names if owners[package, name] == package]
        others = [name for name in names if owners[package, name] != package]
        lines = _title(package, "=")
        lines += [f".. py:module:: {package}", ""]
        lines += [inspect.cleandoc(module.__doc__ or ""), ""]
        if own:
            lines += [".. autosummary::", "   :nosignatures:", ""]
            documented = [name for name in own if _kind(getattr(module, name)) != "data"]
            lines += [f"   {name}" for name in documented] + [""]
        if others:
            lines += _title("Documented elsewhere", "-")
            lines += [f"* :py:obj:`{owners[package, name]}.{name}`" for name in others] + [""]
        for heading, kinds in (
            ("Classes", {"class"}),
            ("Exceptions", {"exception"}),
            ("Functions", {"function"}),
            ("Constants", {"data"}),
        ):
            chosen = [name for name in own if _kind(getattr(module, name)) in kinds]
            if chosen:
                lines += _title(heading, "-")
                for name in chosen:
                    lines += _documentation(package, name, getattr(module, name))
        pages[f"api/{package}.rst"] = "\n".join(lines)
    toctree = [*_title("API", "="), "From the docstrings of the three packages.", ""]
    toctree += [".. toctree::", "   :maxdepth: 1", ""]
    toctree += [f"   {package}" for package in packages()] + [""]
    pages["api/index.rst"] = "\n".join(toctree)
    return pages


def import_for_annotations() -> None:
    """Carry out the imports that modules keep for type checkers, so that annotations resolve.

    Without it ``Polar`` in a signature is a word, and two packages have a class of that name.
    """
    for name, module in list(sys.modules.items()):
        if (
            name.split(".")[0] not in PUBLIC
            or name in PUBLIC
            or not getattr(module, "__file__", "")
        ):
            continue
        tree = ast.parse(Path(str(module.__file__)).read_text(encoding="utf-8"))
        for block in tree.body:
            if not (isinstance(block, ast.If) and ast.unparse(block.test) == "TYPE_CHECKING"):
                continue
            for line in block.body:
                if isinstance(line, ast.ImportFrom) and line.module and not line.level:
                    source = importlib.import_module(line.module)
                    for alias in line.names:
                        if hasattr(source, alias.name):
                            vars(module).setdefault(
                                alias.asname or alias.name, getattr(source, alias.name)
                            )


# --- the commands ------------------------------------------------------------------------------
def _helps() -> Iterator[tuple[str, str, str]]:
    """Name, short help and ``--help`` of the program and of each command."""
    import click

    from pitchopt.cli.main import program

    settings = {"terminal_width": 92, "max_content_width": 92}
    with click.Context(program, info_name="pitchopt", **settings) as context:
        yield "pitchopt", "The program.", program.get_help(context)
        for name in program.list_commands(context):
            command = program.get_command(context, name)
            if command is None:
                continue
            with click.Context(command, info_name=name, parent=context, **settings) as inner:
                yield f"pitchopt {name}", command.get_short_help_str(200), command.get_help(inner)


def command_pages() -> dict[str, str]:
    """Pages of the commands by file name."""
    pages, order = {}, []
    for name, _short, text in _helps():
        stem = name.replace(" ", "-")
        order.append(stem)
        body = [*_title(name, "="), ".. code-block:: text", ""]
        body += [f"   {line}".rstrip() for line in text.splitlines()]
        pages[f"commands/{stem}.rst"] = "\n".join([*body, ""])
    index = [*_title("Commands", "="), "What each command's ``--help`` prints.", ""]
    index += [".. toctree::", "   :maxdepth: 1", ""] + [f"   {stem}" for stem in order] + [""]
    pages["commands/index.rst"] = "\n".join(index)
    return pages


# --- case files --------------------------------------------------------------------------------
def case_page() -> str:
    """Every key of a case file, from the schema that reads it."""
    from pitchopt.cases import case_toml, load_case
    from pitchopt.cases.settings import SCHEMA

    lines = ["# Case files", ""]
    lines += [
        "A case is a TOML file with a `name`, a `turbine` (key of the catalogue, or a windIO file",
        "relative to the case) and these sections. What is left out keeps its default, which",
        "`pitchopt turbines --template KEY` prints for a turbine. Unknown keys are refused, with",
        "the nearest known one named.",
        "",
    ]
    section = ""
    for entry in SCHEMA:
        if entry.section != section:
            section = entry.section
            lines += ["", f"## {section}", "", "| key | may be | meaning |", "|---|---|---|"]
        allowed, meaning = (text.replace("|", "\\|") for text in (entry.kind.allowed(), entry.doc))
        lines.append(f"| `{entry.key}` | {allowed} | {meaning} |")
    lines += ["", "## The template of a reference turbine", "", "```toml"]
    lines += [case_toml(load_case("nrel-5mw")).rstrip(), "```", ""]
    lines += ["## The case of the paper", "", "```toml"]
    lines += [case_toml(load_case("biegel2011")).rstrip(), "```", ""]
    return "\n".join(lines)


def notebook_list() -> str:
    """Notebooks that are in the repository, by the first heading of each."""
    lines = []
    for path in sorted((ROOT / "notebooks").glob("[0-9]*.py")):
        heading = re.search(r"^# # (.+)$", path.read_text(encoding="utf-8"), flags=re.MULTILINE)
        lines.append(f"- `notebooks/{path.name}`: {heading[1] if heading else path.stem}")
    return "\n".join(lines) + "\n"


# --- files of the root -------------------------------------------------------------------------
def repository_links(text: str, source: Path, page: Path) -> str:
    """Links of a file of the repository, turned to where the site has what they name.

    ``source`` is the file that the text is written in, ``page`` the page that shows it.  Files
    that the site does not show become code: the site is read without the repository, too.
    """

    def turned(match: re.Match[str]) -> str:
        label, target = match.groups()
        path, _, anchor = target.partition("#")
        if "://" in target or target.startswith(("mailto:", "#", "/")) or not path:
            return match.group(0)
        named = (source.parent / path).resolve()
        if not named.exists() or not named.is_relative_to(ROOT):
            return match.group(0)  # Sphinx warns of it
        inside = named.relative_to(ROOT).as_posix()
        if inside in REPOSITORY_PAGES:
            named = DOCS / GENERATED / f"{REPOSITORY_PAGES[inside]}.md"
        elif not named.is_relative_to(DOCS):
            return (
                f"`{inside}`" if label in {inside, path, f"`{path}`"} else f"{label} (`{inside}`)"
            )
        link = Path(os.path.relpath(named, page.parent)).as_posix()
        return f"[{label}]({link}{'#' + anchor if anchor else ''})"

    return _LINK.sub(turned, text)


def repository_pages() -> dict[str, str]:
    """Files outside of ``docs/`` as pages of the site."""
    pages = {}
    for name, page in REPOSITORY_PAGES.items():
        target = f"{page}.md"
        text = (ROOT / name).read_text(encoding="utf-8")
        pages[target] = repository_links(text, ROOT / name, DOCS / GENERATED / target)
    return pages


# --- Sphinx ------------------------------------------------------------------------------------
def write_pages(folder: Path) -> None:
    """Write all pages that have changed, and remove those that are no more."""
    pages = {
        **api_pages(),
        **command_pages(),
        **repository_pages(),
        "case-file.md": case_page(),
        "notebook-list.md": notebook_list(),
    }
    for name, text in pages.items():
        path = folder / name
        path.parent.mkdir(parents=True, exist_ok=True)
        if not path.is_file() or path.read_text(encoding="utf-8") != text:
            path.write_text(text, encoding="utf-8")
    for path in folder.rglob("*.*"):
        if path.relative_to(folder).as_posix() not in pages:
            path.unlink()


def _before(app: Any) -> None:
    importlib.import_module("matplotlib.figure")
    write_pages(Path(app.srcdir) / GENERATED)
    import_for_annotations()


def _read(app: Any, name: str, source: list[str]) -> None:
    page = Path(app.env.doc2path(name))
    if page.suffix == ".md" and GENERATED not in page.parts:
        source[0] = repository_links(source[0], page, page)
        # patterns of a table of contents that match no page yet
        source[0] = "".join(
            line
            for line in source[0].splitlines(keepends=True)
            if not re.fullmatch(r"[a-z]+\*\n", line) or list(page.parent.glob(f"{line.strip()}.md"))
        )


def setup(app: Any) -> dict[str, Any]:
    """Write the pages before Sphinx looks for them; turn links of committed ones when read."""
    app.connect("builder-inited", _before)
    app.connect("source-read", _read)
    # signatures have type aliases by their names alone, as the modules write them
    aliases = importlib.import_module("sphinx.util.inspect").TypeAliasForwardRef
    aliases.__repr__ = lambda self: self.name
    return {"parallel_read_safe": True, "parallel_write_safe": True}
