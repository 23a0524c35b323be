"""The HTML report: whole, closed to the network, and drawn by a browser."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
from html.parser import HTMLParser

import numpy as np
import pytest

from pitchopt.plotting import method_figures
from pitchopt.studies.comparison import comparison_document
from pitchopt.studies.comparison.report import comparison_report

BROWSERS = ("chromium", "chromium-browser", "google-chrome", "google-chrome-stable")


@pytest.fixture(scope="module")
def page(result):
    document = comparison_document(result)
    command = 'pitchopt compare --out "a <b>" --report'
    return comparison_report(document, method_figures(document, result.excerpts), command=command)


class _Links(HTMLParser):
    """All that a page could load, and its tags."""

    def __init__(self) -> None:
        super().__init__()
        self.links: list[str] = []
        self.tags: list[str] = []
        self.open: list[str] = []

    def handle_starttag(self, tag, attrs):
        self.tags.append(tag)
        if tag not in ("meta", "link", "img"):
            self.open.append(tag)
        self.links += [value for key, value in attrs if key in ("src", "href", "srcset")]

    def handle_endtag(self, tag):
        assert self.open.pop() == tag


def test_everything_is_in_the_page(page):
    found = _Links()
    found.feed(page)
    assert found.open == []
    assert all(link.startswith("data:") for link in found.links)
    assert "script" not in found.tags
    assert found.tags.count("img") == 3
    assert not re.search(r"url\(|@import|http-equiv=.refresh", page)
    assert "default-src 'none'" in page


def test_text_is_escaped(page):
    assert "a &lt;b&gt;" in page
    assert "<b>" not in page


def test_it_says_what_was_found(page):
    for words in (
        "Where the feed-forward profile pays",
        "Where the learned profile pays",
        "What each had to know",
        "What each took",
        "What the tuners chose",
        "Turbulence of class C, intensity 13.5 %, 15 m/s",
        "seeds that no method has met: 2",
        "Fewer than 6 are too few to conclude from",
        "The static model (",
    ):
        assert words in page


@pytest.mark.slow
def test_a_browser_without_network_draws_it(page, tmp_path):
    browser = next((path for name in BROWSERS if (path := shutil.which(name))), None)
    if browser is None:
        pytest.skip(f"no browser: none of {', '.join(BROWSERS)} on PATH")
    from matplotlib.image import imread

    target, picture = tmp_path / "report.html", tmp_path / "report.png"
    target.write_text(page, encoding="utf-8")
    arguments = [
        browser, "--headless", "--no-sandbox", "--disable-gpu", "--no-first-run",
        "--disable-background-networking", "--disable-component-update", "--disable-sync",
        "--host-resolver-rules=MAP * ~NOTFOUND", "--enable-logging=stderr", "--v=0",
        f"--user-data-dir={tmp_path / 'profile'}", "--window-size=1200,4000",
    ]  # fmt: skip
    environment = {**os.environ, "HOME": str(tmp_path)}
    done = subprocess.run(
        [*arguments, f"--screenshot={picture}", target.as_uri()],
        capture_output=True, text=True, timeout=120, env=environment, check=False,
    )  # fmt: skip
    assert picture.is_file(), done.stderr[-2000:]
    assert "CONSOLE" not in done.stderr, done.stderr[-2000:]  # nothing refused, nothing missing
    drawn = imread(picture)[..., :3]
    assert drawn.shape[:2] == (4000, 1200)
    # bars of the pictures in their colours, which the text has not
    for colour in ((0x00, 0x72, 0xB2), (0x00, 0x9E, 0x73)):
        near = np.abs(drawn - np.array(colour) / 255.0).max(axis=2) < 0.02
        assert near.sum() > 200
