"""Cases: what to design, built in or from TOML files, with strict checks and explanations."""

from __future__ import annotations

from pitchopt.cases.case import Case
from pitchopt.cases.files import builtin_names, case_from_table, case_toml, load_case
from pitchopt.cases.settings import (
    AeroSettings,
    LimitSettings,
    ObjectiveSettings,
    OperationSettings,
    WindSettings,
)

__all__ = [
    "AeroSettings",
    "Case",
    "LimitSettings",
    "ObjectiveSettings",
    "OperationSettings",
    "WindSettings",
    "builtin_names",
    "case_from_table",
    "case_toml",
    "load_case",
]
