"""The comparison as plain data: JSON document, CSV table, controller files."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping
from dataclasses import asdict
from typing import Any

import numpy as np

from pitchopt.exports.records import records_csv
from pitchopt.studies.comparison.measures import LOADS
from pitchopt.studies.comparison.methods import KNOWLEDGE, Prepared
from pitchopt.studies.comparison.result import Comparison, Entry
from pitchopt.studies.comparison.verdict import WORTH, added, sentences, verdicts
from pitchopt.studies.simulation.controller_text import controller_text

__all__ = ["comparison_csv", "comparison_document", "controller_files"]

PLANNED = ("feed-forward", "learned")
"""Methods that play a fixed profile, whose worth in turbulence the verdict is about."""


def comparison_document(result: Comparison) -> dict[str, Any]:
    """Everything but time series; SI units, angles in degrees with ``_deg`` in the name."""
    ground = result.ground
    dynamic = ground.operation.dynamic
    return {
        "case": ground.case.name,
        "turbine": dynamic.turbine.name,
        "wind_speed": ground.wind_speed,
        "rotor_speed_rpm": ground.rotor_speed * 30.0 / math.pi,
        "settings": {
            **ground.case.settings(),
            "comparison": result.settings.plain(),
            "step": dynamic.step,
            "tuning_seeds": {wind: list(ground.tuning_seeds(wind)) for wind in result.winds},
            "judged_seeds": {
                wind: [run.seed for run in result.entry("collective", wind).runs]
                for wind in result.winds
            },
        },
        "winds": [{"wind": wind, "intensity": result.intensity(wind)} for wind in result.winds],
        "knowledge": {method: asdict(KNOWLEDGE[method]) for method in result.settings.methods},
        "entries": [_record(result, entry) for entry in result.entries],
        "verdict": {
            "worth": WORTH,
            "added_to_individual_pitch": added(result),
            **{
                method: {
                    "sentences": sentences(result, method),
                    "loads": {
                        one.load: {"effects": one.effects, "stops_at": one.stops_at}
                        for one in verdicts(result, method)
                    },
                }
                for method in PLANNED
                if method in result.settings.methods
            },
        },
        "seconds": result.seconds,
    }


def _record(result: Comparison, entry: Entry) -> dict[str, Any]:
    record: dict[str, Any] = {
        "method": entry.method,
        "wind": entry.wind,
        "status": entry.status,
        "message": entry.message,
    }
    prepared = entry.prepared
    if prepared is not None:
        record["spent"] = asdict(prepared.spent)
        record["point"] = prepared.point
        record["tuning_cost"] = prepared.tuning_cost
        record["start_cost"] = prepared.start_cost
        if prepared.profile is not None:
            profile = prepared.profile
            record["profile"] = {
                "wake": profile.wake,
                "harmonics": int(profile.feedforward.cosine.size),
                "predicted_cut": profile.predicted,
                "azimuth_deg": np.rad2deg(profile.azimuth),
                "deviation_deg": np.rad2deg(profile.deviation),
                "whole_deg": np.rad2deg(profile.whole),
            }
    if not entry.runs:
        return record
    cuts = {kind: result.cuts(entry.method, entry.wind, kind) for kind in ("rms", "del")}
    record |= {
        "mean_power": entry.mean("power"),
        "power_std": entry.mean("power_std"),
        "generator_speed_std": entry.mean("generator_speed_std"),
        **{kind: {load: entry.load(kind, load) for load in LOADS} for kind in ("rms", "del")},
        **{
            f"{kind}_cut": {
                load: {"mean": one.mean, "half_width": one.half_width}
                for load, one in cuts[kind].items()
            }
            for kind in ("rms", "del")
        },
        "pitch_travel_deg": math.degrees(entry.mean("travel")),
        "rate_use": entry.mean("rate_use"),
        "rate_peak": max(run.rate_peak for run in entry.runs),
        "runs": [asdict(run) for run in entry.runs],
    }
    return record


def comparison_csv(document: Mapping[str, Any]) -> str:
    """One row for each method and wind."""
    rows = []
    for record in document["entries"]:
        spent = record.get("spent") or {}
        row = {
            "wind": record["wind"],
            "method": record["method"],
            "status": record["status"],
            "mean_power_w": record.get("mean_power"),
        }
        for kind in ("rms", "del"):
            for load in LOADS:
                row[f"{load}_{kind}_nm"] = record.get(kind, {}).get(load)
                found = record.get(f"{kind}_cut", {}).get(load, {})
                row[f"{load}_{kind}_cut"] = found.get("mean")
                row[f"{load}_{kind}_cut_half_width"] = found.get("half_width")
        row |= {
            "pitch_travel_deg": record.get("pitch_travel_deg"),
            "rate_use": record.get("rate_use"),
            "rate_peak": record.get("rate_peak"),
            **{
                key: spent.get(key)
                for key in ("evaluations", "simulations", "rotations", "turbine_time", "seconds")
            },
        }
        rows.append(row)
    return records_csv(rows)


def controller_files(result: Comparison) -> dict[str, str]:
    """Controllers as files that ``pitchopt simulate --controller`` reads, by name of file."""
    files = {}
    for entry in result.entries:
        if entry.prepared is not None and entry.method != "collective":
            wind = re.sub("[^A-Za-z0-9.]", "_", entry.wind)
            name = f"{entry.method.replace('+', '-')}-{wind}.toml"
            files[name] = _controller(result, entry, entry.prepared)
    return files


def _controller(result: Comparison, entry: Entry, prepared: Prepared) -> str:
    ground, lag = result.ground, result.settings.pitch_lag
    low = math.degrees(ground.case.pitch_range[0])
    where = f"{ground.case.name}, {ground.wind_speed:g} m/s, wind {entry.wind!r}"
    return controller_text(
        prepared.controller,
        comment=(
            f"{where}: {entry.method}",
            f"with pitch actuators of {lag:g} s that reach down to {low:g} deg",
        ),
    )
