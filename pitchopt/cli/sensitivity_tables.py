"""Tables of what changed parameters would buy a pitch design."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from pitchopt.cli.tables import text_table

__all__ = ["sensitivity_lines"]

_LIMITS = (
    "pitch rate",
    "lower end of pitch",
    "upper end of pitch",
    "lower stall limit",
    "upper stall limit",
)
_CARRIERS = 2
_RUNS = 2
_ROUGH = 1e-3


def sensitivity_lines(record: Mapping[str, Any]) -> list[str]:
    """The table of a record, with what its figures mean, line by line.

    Parameters
    ----------
    record : mapping
        As :func:`pitchopt.studies.sensitivity.sensitivity_record` makes it.
    """
    rows = record["rows"]
    if not rows:
        return [f"sensitivity: {record.get('message') or 'no parameter can be changed'}"]
    resolved = any(row["resolved"] is not None for row in rows)
    by_torque = record["objective"].startswith("mean")
    what = "mean torque - mu x RMS" if by_torque else "weighted RMS cut"
    lines = [
        f"what a change would buy ({what}, more is better; "
        + ("estimates beside the design solved again):" if resolved else "from the multipliers):")
    ]
    head = [
        ["", "", "", "first", "high", *(["", "error of", "error of"] if resolved else []), "of"],
        [
            "parameter", "now", "change", "order", "order",
            *(["re-solved", "first", "high"] if resolved else []),
            "torque" if by_torque or record["price"] is not None else "RMS",
            "carried by",
        ],
        ["", "", "", "kN m", "kN m", *(["kN m", "%", "%"] if resolved else []), "%", ""],
    ]  # fmt: skip
    head[0].append("")
    if resolved:
        for row, text in zip(head, ("", "assumptions", ""), strict=True):
            row.append(text)
    table = [*head, *(_cells(record, row, resolved=resolved) for row in rows)]
    lines += _aligned(table).splitlines()
    lines += _remarks(record)
    return lines


def _aligned(table: Sequence[Sequence[str]]) -> str:
    """Numbers to the right, texts at both ends to the left."""
    texts = [len(table[1]) - 1] if table[1][-1] == "carried by" else range(len(table[1]))[-2:]
    width = {c: max(len(row[c]) for row in table) for c in texts}
    padded = [
        [cell.ljust(width[c]) if c in width else cell for c, cell in enumerate(row)]
        for row in table
    ]
    return text_table(padded, header=3)


def _cells(record: Mapping[str, Any], row: Mapping[str, Any], *, resolved: bool) -> list[str]:
    unit = "" if row["unit"] == "-" else f" {row['unit']}"
    least = record["resolution"]
    share = row["share_of_torque"]
    share = row["share_of_rms"] if share is None else share
    cells = [
        row["label"],
        f"{row['value_shown']:.5g}{unit}",
        f"{row['step_shown']:+.4g}{unit}",
        _change(row["first_order"], least),
        _change(row["high_order"], least),
    ]
    if resolved:
        cells += [
            _change(row["resolved"], least),
            _percent(row["relative_error_first_order"]),
            _percent(row["relative_error_high_order"]),
        ]
    cells += [_percent(share, 4), _carriers(row, least)]
    if resolved:
        cells.append(_verdicts(row["assumptions"]))
    return cells


def _change(value: float | None, least: float) -> str:
    """A change in kN m with four digits; 0 for what a solver leaves, ``-`` for none."""
    if value is None:
        return "-"
    return "0" if abs(value) <= least else f"{1e-3 * value:+.4g}"


def _percent(share: float | None, digits: int = 3) -> str:
    if share is None:
        return "-"
    return "0" if abs(share) < 5e-8 else f"{100 * share:+.{digits}g}"


def _carriers(row: Mapping[str, Any], least: float) -> str:
    found = [
        group
        for group in row["carried_by"]
        if max(abs(group["high_order"]), abs(group["first_order"])) > least
    ]
    if not found:
        return "no active limit"
    texts = []
    for group in found[:_CARRIERS]:
        text = group["name"]
        if text in _LIMITS and group["azimuth_deg"]:
            runs = group["azimuth_deg"]
            places = [f"{a:.0f}" if a == b else f"{a:.0f} to {b:.0f}" for a, b in runs[:_RUNS]]
            text += f" at {', '.join(places)} deg" + (", ..." if len(runs) > _RUNS else "")
        if len(found) > 1:
            text += f" {1e-3 * group['high_order']:+.3g}"
        texts.append(text)
    return "; ".join(texts) + ("; ..." if len(found) > _CARRIERS else "")


def _verdicts(assumptions: Mapping[str, Mapping[str, Any]]) -> str:
    judged = {name: a["verdict"] for name, a in assumptions.items() if name != "stationarity"}
    if all(verdict == "not judged" for verdict in judged.values()):
        return "not judged"
    broken = [name.split(" ", 1)[1] for name, verdict in judged.items() if verdict == "broken"]
    return "hold" if not broken else f"{', '.join(broken)} broken"


def _remarks(record: Mapping[str, Any]) -> list[str]:
    lines = []
    torque = record["largest_torque"]
    if not record["objective"].startswith("mean") and record["price"] is not None:
        lines.append(
            f"'of torque' is what the cut is worth: {record['price']:.4g} N m of torque for a N m "
            f"of RMS, as a share of the largest torque, {1e-3 * torque:.5g} kN m"
        )
    elif record["objective"].startswith("mean"):
        lines.append(f"'of torque' is a share of the largest torque, {1e-3 * torque:.5g} kN m")
    if record["held"]:
        lines.append(f"held as it is: {record['held']}")
    for row in record["rows"]:
        if row.get("other_optimum"):
            near = row["resolved_near"]
            text = "no profile near the design keeps the limits" if near is None else (
                f"near the design {1e-3 * near:+.4g} kN m"
            )  # fmt: skip
            lines.append(
                f"{row['label']}: the best optimum is another one, up to "
                f"{row['moved_deg']:.2f} deg away (from {row['start']}); {text}"
            )
        if row.get("other_optimum") and row["missed_before"] > record["resolution"]:
            lines.append(
                f"{row['label']}: from there the present design gains "
                f"{1e-3 * row['missed_before']:.4g} kN m without the change, which is taken off"
            )
    residual = record["stationarity"]["residual"]
    if residual > _ROUGH:
        lines.append(
            f"the design misses stationarity by {100 * residual:.2g} % of the largest term of its "
            "conditions: estimates are no better than that"
        )
    lines += [f"{item['parameter']}: left out, {item['message']}" for item in record["skipped"]]
    if any(row["resolved"] is not None for row in record["rows"]):
        lines.append("re-solved values are the best of local solves, not proven optima")
    return lines
