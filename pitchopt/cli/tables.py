"""Tables for people: aligned text, units in the header, nothing that is not a number as one."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

__all__ = [
    "PAPER_ROWS",
    "design_table",
    "number",
    "paper_table",
    "reference_row",
    "text_table",
]

_COLUMNS: tuple[tuple[str, str, str, str, float], ...] = (
    # group, name, unit, key, factor
    ("mean", "torque", "kN m", "mean_torque", 1e-3),
    ("RMS of", "torque", "kN m", "rms.torque", 1e-3),
    ("RMS of", "tilt", "kN m", "rms.tilt", 1e-3),
    ("RMS of", "yaw", "kN m", "rms.yaw", 1e-3),
    ("RMS of", "thrust", "kN", "rms.thrust", 1e-3),
    ("RMS cut", "stations", "%", "cut", 1e2),
    ("RMS cut", "between", "%", "cut_between", 1e2),
    ("torque", "lost", "%", "loss", 1e2),
    ("blade", "RMS", "kN m", "blade_rms", 1e-3),
    ("constant", "tilt", "kN m", "mean_tilt", 1e-3),
    ("constant", "yaw", "kN m", "mean_yaw", 1e-3),
    ("pitch", "mean", "deg", "mean_pitch_deg", 1.0),
    ("pitch", "travel", "deg", "pitch_travel_deg", 1.0),
    ("bound", "gap", "%", "gap", 1e2),
)
_DECIMALS = {"%": 2, "deg": 2}


def number(value: float | None, unit: str = "") -> str:
    """Four significant digits, or two decimals for per cent and degrees; ``-`` for none."""
    if value is None:
        return "-"
    if unit in _DECIMALS:
        text = f"{value:.{_DECIMALS[unit]}f}"
    elif abs(value) >= 1e4 or value == 0:
        text = f"{value:.0f}"
    elif abs(value) < 1e-2:
        text = f"{value:.4f}"
    else:
        text = f"{value:#.4g}".rstrip(".")
    return text.removeprefix("-") if text.strip("-0.") == "" else text


def _pick(record: Mapping[str, Any], key: str) -> float | None:
    value: Any = record
    for part in key.split("."):
        value = value.get(part) if isinstance(value, Mapping) else None
    return None if value is None else float(value)


def text_table(rows: Sequence[Sequence[str]], *, left: int = 1, header: int = 1) -> str:
    """Rows of text in aligned columns, the first `left` of them to the left."""
    widths = [max(len(row[c]) for row in rows) for c in range(len(rows[0]))]
    lines = []
    for number_, row in enumerate(rows):
        cells = [
            cell.ljust(width) if c < left else cell.rjust(width)
            for c, (cell, width) in enumerate(zip(row, widths, strict=True))
        ]
        lines.append("  ".join(cells).rstrip())
        if number_ == header - 1:
            lines.append("-" * (sum(widths) + 2 * (len(widths) - 1)))
    return "\n".join(lines)


def design_table(rows: Sequence[tuple[str, Mapping[str, Any], str]]) -> str:
    """Table of designs.

    Parameters
    ----------
    rows : sequence of (label, record, remark)
        Records as :func:`pitchopt.exports.design_record` makes them.
    """
    groups = [column[0] for column in _COLUMNS]
    shown = [g if i == 0 or groups[i - 1] != g else "" for i, g in enumerate(groups)]
    table = [
        ["", *shown, "", ""],
        ["design", *(column[1] for column in _COLUMNS), "status", ""],
        ["", *(column[2] for column in _COLUMNS), "", ""],
    ]
    for label, record, remark in rows:
        cells = []
        for _, _, unit, key, factor in _COLUMNS:
            value = _pick(record, key)
            cells.append(number(None if value is None else factor * value, unit))
        table.append([label, *cells, str(record.get("status", "")), remark])
    return text_table(table, header=3)


def reference_row(constant: Mapping[str, Any], power_max: Mapping[str, Any]) -> dict[str, Any]:
    """Record of the constant pitch as a row of the table that it is the reference of."""
    judged = constant["rms_weighted_between"] is not None
    return {
        **constant,
        "cut": 0.0,
        "cut_between": 0.0 if judged else None,
        "loss": 1.0 - constant["mean_torque"] / power_max["mean_torque"],
    }


PAPER_ROWS: tuple[tuple[str, str, str, str, str], ...] = (
    # design, quantity, paper, key of ours, unit
    ("best constant pitch", "mean torque [N m]", "1.41e6", "constant.mean_torque", "e"),
    ("", "sum of RMS", "3.2e4", "constant.rms_sum", "e"),
    ("power maximum", "mean torque [N m]", "1.42e6", "power_max.mean_torque", "e"),
    ("", "sum of RMS", "1.28e4", "power_max.rms_sum", "e"),
    ("", "torque gained [%]", "0.7", "gain", "%"),
    ("", "RMS cut [%]", "60", "power_max.cut", "%"),
    ("7 % torque lost", "mean torque [N m]", "1.33e6", "loss7.mean_torque", "e"),
    ("", "sum of RMS", "1.10e3", "loss7.rms_sum", "e"),
    ("", "RMS cut [%]", "96", "loss7.cut", "%"),
    ("", "RMS cut between stations [%]", "-", "loss7.cut_between", "%"),
    ("3 % torque lost", "RMS cut [%]", "-", "loss3.cut", "%"),
    ("", "RMS cut between stations [%]", "-", "loss3.cut_between", "%"),
)


def paper_table(document: Mapping[str, Any]) -> str:
    """The paper's figures beside ours, for the case that has the paper's settings."""
    best = document["constant"]["mean_torque"]
    losses = {p.get("loss_target"): p for p in document["points"]}
    source = {
        **document,
        "gain": document["power_max"]["mean_torque"] / best - 1.0,
        "loss3": losses.get(0.03, {}),
        "loss7": losses.get(0.07, {}),
    }
    rows = [["", "", "paper", "here"]]
    for design, quantity, paper, key, form in PAPER_ROWS:
        value = _pick(source, key)
        if value is None:
            ours = "-"
        else:
            ours = f"{100 * value:.2f}" if form == "%" else f"{value:.3e}".replace("e+0", "e")
        rows.append([design, quantity, paper, ours])
    return text_table(rows, left=2)
