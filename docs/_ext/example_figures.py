"""What gallery scripts use: the numbered examples as modules, committed records, figures on pages.

The scripts of ``docs/gallery`` draw with `pitchopt.plotting` and with the functions of
``examples/``; nothing is drawn twice.
"""

from __future__ import annotations

import importlib.util
import json
from functools import cache
from pathlib import Path
from types import ModuleType
from typing import Any

from matplotlib.figure import Figure

__all__ = ["FigureScraper", "example", "records"]

ROOT = Path(__file__).resolve().parents[2]


def example(name: str) -> ModuleType:
    """An example as a module, such as ``example("19_bayesian_steps")``."""
    path = ROOT / "examples" / f"{name}.py"
    spec = importlib.util.spec_from_file_location(f"example_{name}", path)
    if spec is None or spec.loader is None:
        raise FileNotFoundError(path)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


@cache
def _text(name: str) -> str:
    return (ROOT / "benchmarks" / "results" / f"{name}.json").read_text(encoding="utf-8")


def records(name: str) -> list[dict[str, Any]]:
    """Lines of a committed record of ``benchmarks/results``; a study's document is one line."""
    text = _text(name)
    try:
        return [json.loads(text)]
    except json.JSONDecodeError:
        return [json.loads(line) for line in text.splitlines() if line.strip()]


class FigureScraper:
    """Puts matplotlib figures that a gallery block made on its page.

    Ours are `Figure` objects that pyplot knows nothing of, so Sphinx-Gallery's own scraper does
    not see them.  A figure is shown after the block in which it was made, under whatever name.
    """

    def __repr__(self) -> str:
        """The same in every build, so that nothing is built again for it."""
        return "FigureScraper()"

    def __call__(
        self, _block: Any, block_vars: dict[str, Any], gallery_conf: dict[str, Any]
    ) -> str:
        """Save new figures and return the lines that show them."""
        from sphinx_gallery.scrapers import figure_rst

        variables = block_vars["example_globals"]
        shown: list[int] = variables.setdefault("__shown_figures__", [])
        paths = []
        for value in list(variables.values()):
            if isinstance(value, Figure) and id(value) not in shown:
                shown.append(id(value))
                path = next(block_vars["image_path_iterator"])
                value.savefig(path, format="png", dpi=110)
                paths.append(path)
        return figure_rst(paths, gallery_conf["src_dir"])
