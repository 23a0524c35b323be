"""Sensitivity of a pitch design as plain data: records, units for people, CSV.

Changes are of the optimal value in N m, larger is better.  ``step_shown`` and ``value_shown`` are
in the unit named beside them, everything else is in SI.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from pitchopt.exports.records import records_csv
from pitchopt.studies.sensitivity.design import (
    DesignCurve,
    DesignRow,
    DesignSensitivity,
    where,
)
from pitchopt.studies.sensitivity.design_point import UNITS

__all__ = ["curve_records", "held_text", "sensitivity_csv", "sensitivity_record"]


def held_text(result: DesignSensitivity) -> str:
    """What stays as it is when a parameter changes."""
    point, held = result.point, []
    if np.isfinite(point.objective.torque_min):
        held.append(f"a mean torque of {1e-3 * point.objective.torque_min:.5g} kN m")
    if np.isfinite(point.objective.blade_cap):
        held.append(f"a blade RMS of at most {1e-3 * point.objective.blade_cap:.4g} kN m")
    if point.task.frozen and point.pitch is not None:
        held.append(f"the mean pitch of {np.degrees(point.pitch):.2f} deg with its wake")
    return ", ".join(held)


def sensitivity_record(result: DesignSensitivity) -> dict[str, Any]:
    """Everything about the estimates of a design."""
    point, kkt = result.point, result.point.stationary
    return {
        "objective": "mean torque - mu x weighted RMS" if point.by_torque else "- weighted RMS",
        "unit": "N m",
        "value": kkt.value,
        "largest_torque": point.largest_torque,
        "price": point.price,
        "held": held_text(result),
        "resolution": result.resolution,
        "stationarity": {"residual": kkt.worst, "gain": kkt.gain},
        "rows": [_row(result, row) for row in result.rows],
        "skipped": [{"parameter": name, "message": why} for name, why in result.skipped],
    }


def _row(result: DesignSensitivity, row: DesignRow) -> dict[str, Any]:
    point, estimate = result.point, row.estimate
    name, unit, factor = UNITS[row.parameter]
    price = 1.0 if point.by_torque else point.price
    torque = point.largest_torque
    record: dict[str, Any] = {
        "parameter": row.parameter,
        "label": name,
        "unit": unit,
        "value_shown": factor * row.value,
        "step_shown": factor * row.step,
        "value": row.value,
        "step": row.step,
        "slope": row.first / row.step,
        "first_order": row.first,
        "high_order": row.high,
        "share_of_torque": None if price is None else price * row.high / torque,
        "share_of_rms": None if point.by_torque else row.high / result.scale,
        "resolved": None,
        "error_first_order": None,
        "error_high_order": None,
        "relative_error_first_order": None,
        "relative_error_high_order": None,
        "carried_by": [
            {
                "name": group.name,
                "multiplier": group.multiplier,
                "first_order": group.first,
                "high_order": group.high,
                "azimuth_deg": []
                if group.share is None
                else np.degrees(where(group.share, point.design.azimuth)).tolist(),
            }
            for group in row.groups
        ],
        "assumptions": {
            a.name: {"verdict": a.verdict, "measure": a.measure, "message": a.message}
            for a in estimate.assumptions
        },
        "message": row.message,
    }
    if row.truth is not None and row.errors is not None:
        truth, (first, high) = row.truth, row.errors
        zero = abs(truth.change) <= result.resolution
        record |= {
            "resolved": truth.change,
            "error_first_order": first,
            "error_high_order": high,
            "relative_error_first_order": None if zero else first / abs(truth.change),
            "relative_error_high_order": None if zero else high / abs(truth.change),
            "resolved_near": truth.near,
            "other_optimum": truth.other,
            "missed_before": truth.missed,
            "moved_deg": float(np.degrees(truth.moved)),
            "start": truth.start,
            "status": truth.status.value,
        }
    return record


def sensitivity_csv(record: Mapping[str, Any]) -> str:
    """Table of the rows of a record, one line each."""
    rows = []
    for row in record["rows"]:
        flat = {k: v for k, v in row.items() if k not in ("carried_by", "assumptions", "message")}
        flat["carried_by"] = "; ".join(group["name"] for group in row["carried_by"])
        flat |= {
            name.lower().replace(" ", "_"): found["verdict"]
            for name, found in row["assumptions"].items()
        }
        rows.append(flat)
    return records_csv(rows)


def curve_records(curves: Sequence[DesignCurve]) -> list[dict[str, Any]]:
    """Curves over a range of their parameters, one record for each change."""
    records = []
    for curve in curves:
        _, unit, factor = UNITS[curve.parameter]
        records += [
            {
                "parameter": curve.parameter,
                "unit": unit,
                "step_shown": factor * float(dc),
                "step": float(dc),
                "first_order": float(curve.first_order[k]),
                "high_order": float(curve.high_order[k]),
                "resolved": float(curve.truth[k]),
                "other_optimum": bool(curve.other[k]),
            }
            for k, dc in enumerate(curve.dc)
        ]
    return records
