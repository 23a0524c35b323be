"""Results as plain data: the JSON documents and the CSV table of the commands.

Angles are in degrees here and say so in their name; loads are in N m and N.  A number that does
not exist is null in JSON and an empty cell in CSV, never NaN.

    loss          1 - mean torque / mean torque of the power maximum
    cut           1 - weighted RMS / weighted RMS of the best constant pitch
    cut_between   the same, judged between the stations as well
"""

from __future__ import annotations

import csv
import io
import json
import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from pitchopt.aero.curves import LOADS, RotorLoads
from pitchopt.design.results import Design, Tradeoff
from pitchopt.exports.profiles import label_of

__all__ = [
    "constant_record",
    "design_document",
    "design_record",
    "document_text",
    "records_csv",
    "tradeoff_csv",
    "tradeoff_document",
]


def plain(value: Any) -> Any:
    """Data of Python's own types that JSON can hold; what is not finite becomes None."""
    if isinstance(value, Mapping):
        return {str(key): plain(item) for key, item in value.items()}
    if isinstance(value, (list, tuple)):
        return [plain(item) for item in value]
    if isinstance(value, np.ndarray):
        return plain(value.tolist())
    if isinstance(value, np.generic):
        return plain(value.item())
    if isinstance(value, float):
        return value if math.isfinite(value) else None
    if value is None or isinstance(value, (bool, int, str)):
        return value
    return str(value)


def document_text(document: Mapping[str, Any]) -> str:
    """JSON text of a document, one line break at the end."""
    return json.dumps(plain(document), indent=1, allow_nan=False) + "\n"


def _by_load(loads: RotorLoads) -> dict[str, float]:
    return dict(zip(LOADS, map(float, loads.rms), strict=True))


def _loads_record(design: Design, hub_height: float | None) -> dict[str, Any]:
    torque, tilt, yaw, thrust = (float(v) for v in design.loads.mean)
    base = None
    if hub_height is not None:
        base = float(np.std(hub_height * design.loads.rotor[3] + design.loads.rotor[1]))
    return {
        "mean_torque": torque,
        "mean_tilt": tilt,
        "mean_yaw": yaw,
        "mean_thrust": thrust,
        "rms": design.rms,
        "rms_sum": design.rms_sum,
        "rms_between": None if design.between is None else _by_load(design.between),
        "rms_sum_between": design.rms_sum_between,
        "rms_weighted": design.rms_weighted,
        "rms_weighted_between": design.rms_weighted_between,
        "blade_rms": design.loads.blade_rms,
        "tower_base_rms": base,
        "mean_pitch_deg": float(np.rad2deg(design.profile.mean())),
        "pitch_travel_deg": float(np.rad2deg(design.pitch_travel)),
    }


def _shares(design: Design, constant: Design, power_max: Design) -> dict[str, float | None]:
    def cut(value: float | None, reference: float | None) -> float | None:
        return None if value is None or not reference else 1.0 - value / reference

    best = power_max.mean_torque
    return {
        "loss": 1.0 - design.mean_torque / best if best else None,
        "cut": cut(design.rms_weighted, constant.rms_weighted),
        "cut_between": cut(design.rms_weighted_between, constant.rms_weighted_between),
    }


def constant_record(design: Design, *, hub_height: float | None = None) -> dict[str, Any]:
    """The best constant pitch."""
    return {
        "pitch_deg": float(np.rad2deg(design.profile.mean())),
        **_loads_record(design, hub_height),
        "status": design.status.value,
        "message": design.message,
    }


def design_record(
    design: Design, *, constant: Design, power_max: Design, hub_height: float | None = None
) -> dict[str, Any]:
    """One design; cuts are against `constant`, losses against `power_max`.

    With a hub height [m] the RMS of the tower-base moment, hub height x thrust + tilt, is added.
    """
    record: dict[str, Any] = {
        "label": label_of(design),
        "kind": design.kind,
        "mu": design.mu,
        "target": design.target,
        **_loads_record(design, hub_height),
        **_shares(design, constant, power_max),
        "objective": design.objective,
        "upper_bound": design.upper_bound,
        "gap": design.gap,
        "rms_lower_bound": design.rms_lower_bound,
        "bound_method": None if design.certificate is None else design.certificate.method,
        "bound_leaves_out": None if design.certificate is None else design.certificate.left_out,
        "proof_regions": _regions(design),
        "proof_ended": design.proof_ended,
        "frozen_mean_pitch_deg": None
        if design.mean_pitch is None
        else float(np.rad2deg(design.mean_pitch)),
        "status": design.status.value,
        "message": design.message,
        "start": design.start,
        "iterations": design.iterations,
        "seconds": design.seconds,
    }
    if design.kind == "max_power_loss":
        record["loss_target"] = design.target
    if design.kind == "mean_torque":
        record["mean_torque_target"] = design.target
    return record


def _regions(design: Design) -> int | None:
    """Regions in the tree that proves the bound, where there is one."""
    if design.certificate is None or design.certificate.proof is None:
        return None
    return design.certificate.proof.regions


def tradeoff_document(
    case: str,
    settings: Mapping[str, Any],
    result: Tradeoff,
    seconds: float,
    *,
    model: Mapping[str, Any] | None = None,
    hub_height: float | None = None,
) -> dict[str, Any]:
    """Everything about a trade-off curve but the profiles themselves.

    `model` holds what is known of the aerodynamic model's own errors and coefficients.
    """
    ends: dict[str, Any] = {
        "constant": result.constant,
        "power_max": result.power_max,
        "hub_height": hub_height,
    }
    pareto = result.constant_pareto
    return {
        "case": case,
        "settings": dict(settings),
        "model": dict(model or {}),
        "constant": constant_record(result.constant, hub_height=hub_height),
        "power_max": design_record(result.power_max, **ends),
        "points": [design_record(point, **ends) for point in result.points],
        "knee": {"index": result.knee},
        "constant_pareto": {
            "pitch_deg": np.rad2deg(result.constant_pitch[pareto]),
            "mean_torque": result.constant_torque[pareto],
            "rms_weighted": result.constant_rms[pareto],
        },
        "seconds": seconds,
    }


def design_document(
    case: str,
    settings: Mapping[str, Any],
    design: Design,
    *,
    constant: Design,
    power_max: Design,
    seconds: float,
    model: Mapping[str, Any] | None = None,
    hub_height: float | None = None,
) -> dict[str, Any]:
    """Everything about one design, its profile included."""
    ends: dict[str, Any] = {
        "constant": constant,
        "power_max": power_max,
        "hub_height": hub_height,
    }
    return {
        "case": case,
        "settings": dict(settings),
        "model": dict(model or {}),
        "constant": constant_record(constant, hub_height=hub_height),
        "power_max": design_record(power_max, **ends),
        "design": design_record(design, **ends),
        "azimuth_deg": np.rad2deg(design.azimuth),
        "pitch_deg": np.rad2deg(design.profile),
        "seconds": seconds,
    }


def tradeoff_csv(records: Sequence[Mapping[str, Any]], knee: int | None) -> str:
    """Table of records: one row each, the RMS values as columns of their own.

    Parameters
    ----------
    records : sequence of mappings
        As :func:`design_record` makes them; the references first.
    knee : int or None
        Row that is marked in the column ``knee``.
    """
    left_out = ("target", "message")
    return records_csv(
        [
            {key: value for key, value in record.items() if key not in left_out}
            | {"knee": int(number == knee)}
            for number, record in enumerate(records)
        ]
    )


def records_csv(records: Sequence[Mapping[str, Any]]) -> str:
    """Table of records: one row each, what a mapping holds as columns of their own."""
    flat = []
    for record in records:
        row: dict[str, Any] = {}
        for key, value in plain(record).items():
            if isinstance(value, dict):
                row.update({f"{key}_{name}": item for name, item in value.items()})
            else:
                row[key] = value
        flat.append(row)
    columns = list(dict.fromkeys(key for row in flat for key in row))
    text = io.StringIO()
    writer = csv.DictWriter(text, columns, restval="", lineterminator="\n")
    writer.writeheader()
    writer.writerows(flat)
    return text.getvalue()
