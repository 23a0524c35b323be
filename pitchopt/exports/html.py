"""Self-contained HTML pages: tables, pictures and text in one file, with no need of a network.

Pictures are in the page as data URIs, style is in its head, there are no scripts.  All text is
escaped; a content security policy in the page itself forbids loading anything from elsewhere.
"""

from __future__ import annotations

import base64
import html
from collections.abc import Sequence

__all__ = ["html_list", "html_page", "html_paragraph", "html_picture", "html_section", "html_table"]

_STYLE = """
:root { color-scheme: light; }
body { font: 15px/1.5 system-ui, sans-serif; color: #1a1a1a; background: #fff;
       max-width: 1080px; margin: 2rem auto; padding: 0 1rem; }
h1 { font-size: 1.7rem; margin: 0 0 .3rem; } h2 { font-size: 1.2rem; margin: 2rem 0 .5rem; }
h3 { font-size: 1rem; margin: 1.2rem 0 .3rem; }
.scroll { overflow-x: auto; }
table { border-collapse: collapse; font-size: 13px; margin: .3rem 0 1rem; }
th, td { padding: .25rem .6rem; border-bottom: 1px solid #ddd; text-align: right; }
th { border-bottom: 1px solid #888; font-weight: 600; white-space: nowrap; }
td.text, th.text { text-align: left; }
tbody tr:hover { background: #f3f6fa; }
img { max-width: 100%; height: auto; }
figure { margin: 1rem 0; } figcaption { color: #555; font-size: 13px; }
code, pre { font: 13px/1.4 ui-monospace, monospace; background: #f4f4f4; }
pre { padding: .6rem .8rem; overflow-x: auto; } code { padding: .1rem .3rem; }
li { margin: .2rem 0; }
@media print { body { max-width: none; } .scroll { overflow: visible; } }
"""
_POLICY = "default-src 'none'; img-src data:; style-src 'unsafe-inline'"


def html_page(title: str, body: Sequence[str]) -> str:
    """A whole page.

    Parameters
    ----------
    title : str
    body : sequence of str
        Parts that the other functions made.
    """
    return (
        '<!DOCTYPE html>\n<html lang="en">\n<head>\n<meta charset="utf-8">\n'
        f'<meta http-equiv="Content-Security-Policy" content="{_POLICY}">\n'
        '<meta name="viewport" content="width=device-width, initial-scale=1">\n'
        f'<link rel="icon" href="data:,">\n<title>{html.escape(title)}</title>\n'
        f"<style>{_STYLE}</style>\n</head>\n<body>\n<h1>{html.escape(title)}</h1>\n"
        + "\n".join(body)
        + "\n</body>\n</html>\n"
    )


def html_section(title: str, *, level: int = 2) -> str:
    """Heading of a part."""
    return f"<h{level}>{html.escape(title)}</h{level}>"


def html_paragraph(text: str, *, code: bool = False) -> str:
    """Text; as it stands for code."""
    tag = "pre" if code else "p"
    return f"<{tag}>{html.escape(text)}</{tag}>"


def html_list(items: Sequence[str]) -> str:
    """Bullets."""
    return "<ul>\n" + "\n".join(f"<li>{html.escape(item)}</li>" for item in items) + "\n</ul>"


def html_table(rows: Sequence[Sequence[str]], *, header: int = 1, left: int = 1) -> str:
    """Table.

    Parameters
    ----------
    rows : sequence of sequences of str
        All of the same length.
    header : int
        Rows of headings at the top.
    left : int
        Columns of text at the left; the others are numbers.
    """

    def line(row: Sequence[str], tag: str) -> str:
        cells = (
            f"<{tag}{' class=' + chr(34) + 'text' + chr(34) if place < left else ''}>"
            f"{html.escape(cell)}</{tag}>"
            for place, cell in enumerate(row)
        )
        return f"<tr>{''.join(cells)}</tr>"

    head = "\n".join(line(row, "th") for row in rows[:header])
    body = "\n".join(line(row, "td") for row in rows[header:])
    return (
        f'<div class="scroll"><table>\n<thead>\n{head}\n</thead>\n<tbody>\n{body}\n</tbody>\n'
        "</table></div>"
    )


def html_picture(svg: bytes, caption: str) -> str:
    """A picture (SVG) with what it shows, which is its text for those who cannot see it as well."""
    data = base64.b64encode(svg).decode("ascii")
    text = html.escape(caption, quote=True)
    return (
        f'<figure><img src="data:image/svg+xml;base64,{data}" alt="{text}">'
        f"<figcaption>{text}</figcaption></figure>"
    )
