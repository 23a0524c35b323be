"""Parts of self-contained pages: escaped, well formed, readable back."""

from __future__ import annotations

import base64
import re
from html.parser import HTMLParser

from hypothesis import given
from hypothesis import strategies as st

from pitchopt.exports.html import (
    html_list,
    html_page,
    html_paragraph,
    html_picture,
    html_section,
    html_table,
)

TEXT = st.text(st.characters(exclude_categories=("Cc", "Cs")), max_size=30)


class _Reader(HTMLParser):
    """Cells of tables, row by row, with their tags."""

    def __init__(self) -> None:
        super().__init__()
        self.rows: list[list[str]] = []
        self.tags: list[str] = []
        self.inside = False

    def handle_starttag(self, tag, attrs):
        if tag == "tr":
            self.rows.append([])
        if tag in ("td", "th"):
            self.inside = True
            self.tags.append(tag)
            self.rows[-1].append("")

    def handle_endtag(self, tag):
        if tag in ("td", "th"):
            self.inside = False

    def handle_data(self, data):
        if self.inside:
            self.rows[-1][-1] += data


@given(st.lists(st.lists(TEXT, min_size=3, max_size=3), min_size=2, max_size=4))
def test_a_table_reads_back_whatever_its_text(rows):
    reader = _Reader()
    reader.feed(html_table(rows))
    assert reader.rows == rows
    assert reader.tags == ["th"] * 3 + ["td"] * 3 * (len(rows) - 1)


@given(TEXT)
def test_no_text_becomes_markup(text):
    for part in (html_paragraph(text), html_list([text]), html_section(text)):
        inner = re.sub(r"^<\w+>\s*(<li>)?|(</li>)?\s*</\w+>$", "", part)
        assert "<" not in inner
        assert ">" not in inner


def test_a_picture_is_in_the_page_itself():
    svg = b'<svg xmlns="http://www.w3.org/2000/svg"></svg>'
    part = html_picture(svg, 'a "quoted" <caption>')
    data = re.search(r'src="data:image/svg\+xml;base64,([^"]+)"', part)
    assert data is not None
    assert base64.b64decode(data.group(1)) == svg
    assert 'alt="a &quot;quoted&quot; &lt;caption&gt;"' in part


def test_a_page_forbids_all_that_is_not_in_it():
    page = html_page("a & b", [html_paragraph("text")])
    assert page.startswith("<!DOCTYPE html>")
    assert "<title>a &amp; b</title>" in page
    assert "default-src 'none'" in page
