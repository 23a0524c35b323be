"""Tables of the docs are those of the committed records, machine named."""

from __future__ import annotations

import json
import re
import shutil
from pathlib import Path

import pytest

DOCS = Path(__file__).resolve().parents[2] / "docs"


@pytest.mark.parametrize("name", ["performance.md", "validation.md", "tuning.md"])
def test_tables_are_those_of_the_records(record_tables, name):
    text = (DOCS / name).read_text(encoding="utf-8")
    assert record_tables.names_in(text), "a page without tables"
    assert record_tables.written(text) == text, "run: python tools/record_tables.py"


def test_every_table_stands_on_a_page(record_tables):
    shown = [
        n
        for page in record_tables.PAGES
        for n in record_tables.names_in((DOCS / page).read_text("utf-8"))
    ]
    assert sorted(shown) == sorted(record_tables.TABLES)


def test_another_record_makes_another_table(record_tables, tmp_path, monkeypatch):
    shutil.copytree(record_tables.RESULTS, tmp_path / "results")
    monkeypatch.setattr(record_tables, "RESULTS", tmp_path / "results")
    before = record_tables.table("proof")
    path = tmp_path / "results" / "proof.json"
    records = [json.loads(line) for line in path.read_text(encoding="utf-8").splitlines()]
    records[0]["gap_percent"] = 4.321
    records[0]["environment"]["cpu"] = "Another"
    path.write_text("\n".join(map(json.dumps, records)), encoding="utf-8")
    after = record_tables.table("proof")
    assert "4.32 %" in after
    assert "4.32 %" not in before
    assert "Another" in after


def test_a_record_without_a_machine_says_so(record_tables):
    assert record_tables.machine([{"measurement": "x"}]) == "Machine not recorded"


def test_every_table_names_its_machine_or_says_that_the_record_does_not(record_tables):
    for name in record_tables.TABLES:
        last = record_tables.table(name).splitlines()[-1]
        words = "Machine not recorded" if name == "tower-study" else ".+ cores, 1 thread"
        assert re.search(rf"Record: `benchmarks/results/\w+\.json`\. {words}", last), name


@pytest.mark.parametrize(
    ("value", "count", "text"),
    [
        (0.0, 2, "0"),
        (0.00987, 2, "0.0099"),
        (0.041, 2, "0.041"),
        (0.41, 2, "0.41"),
        (9.965, 2, "10.0"),
        (23.26, 2, "23"),
        (292.4, 2, "292"),
        (18009.0, 2, "18,009"),
        (590.29, 4, "590.3"),
        (1e-6, 2, "1.0e-6"),
        (2.5e6, 2, "2.5e6"),
    ],
)
def test_numbers_in_words(record_tables, value, count, text):
    assert record_tables.digits(value, count) == text
