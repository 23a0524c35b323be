"""Formulas as pictures in the page (inline SVG), drawn by matplotlib while the site is built.

No script, no font and no network in the browser, and the same look everywhere.  The formula's
source is the picture's label for screen readers.  What matplotlib cannot draw is a warning, which
ends a build with warnings as errors.
"""

from __future__ import annotations

import html
import re
from functools import cache
from typing import Any

import matplotlib as mpl
import numpy as np
from docutils import nodes
from matplotlib.mathtext import MathTextParser
from matplotlib.path import Path
from matplotlib.textpath import TextPath
from sphinx.application import Sphinx
from sphinx.util import logging

__all__ = ["plain", "setup", "svg"]

LOGGER = logging.getLogger(__name__)

SIZE = 100.0  # units an em
SCALE = 1.12  # of the formulas' font to the text's

_ARGUMENT = r"\s*(\\[a-zA-Z]+|[^\\{}\s])"
_SCRIPT = r"(?:\{(?:[^{}]|\{[^{}]*\})*\}|[^\\{}\s])"
# LaTeX that matplotlib writes otherwise
_PLAIN = (
    (re.compile(r"\s+"), " "),
    (re.compile(r"\\[bB]igg?l\s*"), r"\\left"),
    (re.compile(r"\\[bB]igg?r\s*"), r"\\right"),
    (re.compile(r"\\[bB]igg?\s*(?=[(\[|)\]\\])"), ""),
    (re.compile(r"\\(?:text|display)style(?![a-zA-Z])"), ""),
    (re.compile(r"\\tfrac(?![a-zA-Z])"), r"\\frac"),
    (re.compile(r"\\le(?![a-zA-Z])"), r"\\leq "),
    (re.compile(r"\\ge(?![a-zA-Z])"), r"\\geq "),
    (re.compile(r"\\[lr]Vert(?![a-zA-Z])"), r"\\Vert "),
    (re.compile(r"\\[lr]vert(?![a-zA-Z])"), r"\\vert "),
    (re.compile(r"\\lfloor(?![a-zA-Z])"), r"\\lfloor "),
    (re.compile(r"\\top(?![a-zA-Z])"), r"\\mathrm{T}"),
    (re.compile(rf"\\(d?frac){_ARGUMENT}{_ARGUMENT}"), r"\\\1{\2}{\3}"),
    (re.compile(rf"\\(sqrt|mathrm|mathbf|underline|overline){_ARGUMENT}"), r"\\\1{\2}"),
    (re.compile(rf"(\\sum(?:[_^]{_SCRIPT})*)"), r"\1\\,"),
    (re.compile(r"\\bmod(?![a-zA-Z])"), r"\\;\\mathrm{mod}\\;"),
    (re.compile("'(?!')"), r"^{\\prime}"),
    (re.compile("°"), r"^\\circ"),
    (re.compile(r"\\\$"), r"\\$"),
)


def plain(text: str) -> str:
    """A formula in the commands that matplotlib draws."""
    for pattern, replacement in _PLAIN:
        text = pattern.sub(replacement, text)
    return text.strip()


def _outline(path: Path) -> str:
    """The ``d`` of an SVG path, y downwards."""
    parts = []
    for vertices, code in path.iter_segments(simplify=False, curves=True):
        points = " ".join(f"{x:.1f} {-y:.1f}" for x, y in np.reshape(vertices, (-1, 2)))
        letter = {Path.MOVETO: "M", Path.LINETO: "L", Path.CURVE3: "Q", Path.CURVE4: "C"}.get(code)
        parts.append(f"{letter}{points}" if letter else "Z")
    return "".join(parts)


@cache
def svg(text: str) -> str:
    """One line of a formula as an ``<svg>`` element that sits on the line of the text."""
    code = f"${plain(text)}$"
    with mpl.rc_context({"mathtext.fontset": "stix", "svg.fonttype": "path"}):
        from matplotlib.font_manager import FontProperties

        prop = FontProperties(size=SIZE)
        path = TextPath((0.0, 0.0), code, prop=prop)
        width, height, depth, *_ = MathTextParser("path").parse(code, 72, prop)
    height, depth = max(height, 0.7 * SIZE), max(depth, 0.0)
    pad = 0.04 * SIZE
    box = (-pad, -(height + pad), width + 2 * pad, height + depth + 2 * pad)
    em = SCALE / SIZE
    return (
        f'<svg class="formula" role="img" aria-label="{html.escape(text, quote=True)}" '
        f'viewBox="{box[0]:.1f} {box[1]:.1f} {box[2]:.1f} {box[3]:.1f}" '
        f'style="width:{em * box[2]:.3f}em;height:{em * box[3]:.3f}em;'
        f'vertical-align:{-em * (depth + pad):.3f}em">'
        f'<path d="{_outline(path)}"/></svg>'
    )


def _drawn(visitor: Any, node: nodes.Element, text: str) -> str:
    try:
        return svg(text)
    except (ValueError, RuntimeError) as error:
        message = str(error).strip().splitlines()[-1]
        LOGGER.warning("formula %r: %s", text, message, location=node, type="formulas")
        return f"<code>{visitor.encode(text)}</code>"


def visit_inline(visitor: Any, node: nodes.Element) -> None:
    """A formula in a line."""
    visitor.body.append(_drawn(visitor, node, node.astext()))
    raise nodes.SkipNode


def visit_block(visitor: Any, node: nodes.Element) -> None:
    r"""A formula on lines of its own, which ``\\`` ends."""
    for line in re.split(r"\\\\(?:\[[^\]]*\])?\s", node.astext()):
        large = re.sub(r"\\frac(?![a-zA-Z])", r"\\dfrac", line)
        visitor.body.append(f'<div class="formula">{_drawn(visitor, node, large)}</div>')
    raise nodes.SkipNode


def setup(app: Sphinx) -> dict[str, Any]:
    """Register the renderer under the name ``svg``."""
    app.add_html_math_renderer("svg", (visit_inline, None), (visit_block, None))
    return {"parallel_read_safe": True, "parallel_write_safe": True}
