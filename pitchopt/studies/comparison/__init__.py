"""One comparison: feed-forward design, learned profile and tuned individual pitch side by side."""

from __future__ import annotations

from pitchopt.studies.comparison.document import (
    comparison_csv,
    comparison_document,
    controller_files,
)
from pitchopt.studies.comparison.measures import LOADS, Cut, RunMeasures
from pitchopt.studies.comparison.methods import KNOWLEDGE, Knowledge
from pitchopt.studies.comparison.report import comparison_report
from pitchopt.studies.comparison.result import Comparison, Entry
from pitchopt.studies.comparison.settings import METHODS, ComparisonSettings
from pitchopt.studies.comparison.spent import Spent
from pitchopt.studies.comparison.study import compare
from pitchopt.studies.comparison.verdict import LoadVerdict, sentences, verdicts

__all__ = [
    "KNOWLEDGE",
    "LOADS",
    "METHODS",
    "Comparison",
    "ComparisonSettings",
    "Cut",
    "Entry",
    "Knowledge",
    "LoadVerdict",
    "RunMeasures",
    "Spent",
    "compare",
    "comparison_csv",
    "comparison_document",
    "comparison_report",
    "controller_files",
    "sentences",
    "verdicts",
]
