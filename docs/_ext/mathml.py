"""Formulas as MathML, made while the site is built: no script, no font, no network in the browser.

The translation is docutils' own (``docutils.utils.math``).  A formula that it does not know is a
warning, which ends a build with warnings as errors.
"""

from __future__ import annotations

import re
from typing import Any

from docutils import nodes
from docutils.utils.math import MathError, latex2mathml, wrap_math_code
from sphinx.application import Sphinx
from sphinx.util import logging

__all__ = ["setup"]

LOGGER = logging.getLogger(__name__)

# commands that docutils does not know, in words that it does
_PLAIN = (
    (re.compile(r"\\[bB]igg?[lrm]?(?![a-zA-Z])"), ""),
    (re.compile(r"\\(text|display)style(?![a-zA-Z])"), ""),
    (re.compile(r"\\([dt])frac(?![a-zA-Z])"), r"\\frac"),
    (re.compile(r"\\lVert(?![a-zA-Z])|\\rVert(?![a-zA-Z])"), r"\\Vert "),
    (re.compile(r"\\lvert(?![a-zA-Z])|\\rvert(?![a-zA-Z])"), r"\\vert "),
    (re.compile(r"\\dots[bcmio]?(?![a-zA-Z])"), r"\\ldots "),
    (re.compile("°"), r"^{\\circ}"),
    # \frac12 and \tfrac12
    (re.compile(r"\\frac\s*([0-9a-zA-Z])\s*([0-9a-zA-Z])"), r"\\frac{\1}{\2}"),
)


def plain(text: str) -> str:
    """A formula in the commands that docutils translates."""
    for pattern, replacement in _PLAIN:
        text = pattern.sub(replacement, text)
    return text


def mathml(text: str, *, block: bool) -> str:
    """A formula as a ``<math>`` element."""
    code = plain(text)
    if block and r"\\" in code and r"\begin" not in code:  # lines: the environment align*
        code = wrap_math_code(code, as_block=True)
    return latex2mathml.tex2mathml(code, as_block=block)


def _visit(visitor: Any, node: nodes.Element, *, block: bool) -> None:
    text = node.astext()
    try:
        result = mathml(text, block=block)
    except (MathError, SyntaxError, ValueError) as error:
        LOGGER.warning("formula %r: %s", text, error, location=node, type="mathml")
        result = f"<code>{visitor.encode(text)}</code>"
    visitor.body.append(f'<div class="math">{result}</div>' if block else result)
    raise nodes.SkipNode


def visit_inline(visitor: Any, node: nodes.Element) -> None:
    """A formula in a line."""
    _visit(visitor, node, block=False)


def visit_block(visitor: Any, node: nodes.Element) -> None:
    """A formula on lines of its own."""
    _visit(visitor, node, block=True)


def setup(app: Sphinx) -> dict[str, Any]:
    """Register the renderer under the name ``mathml``."""
    app.add_html_math_renderer("mathml", (visit_inline, None), (visit_block, None))
    return {"parallel_read_safe": True, "parallel_write_safe": True}
