"""Simulated runs as plain data: the JSON document and the table of ``pitchopt simulate``.

Channels have OpenFAST's units (kN-m, deg, rpm), said with each of them; equivalent loads are of
1 Hz, ``wohler`` is the slope that they are taken with.  What does not exist is null, never NaN.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict
from typing import Any

from pitchopt.exports.records import records_csv
from pitchopt.sim import Channel, ChannelStatistics
from pitchopt.studies.simulation.result import Lifetime, SimulationResult

__all__ = ["simulation_document", "statistics_csv"]


def simulation_document(result: SimulationResult, turbine: Mapping[str, Any]) -> dict[str, Any]:
    """Everything about a study but the series.

    Parameters
    ----------
    result : SimulationResult
    turbine : mapping
        Settings of the turbine's model, which are added to those of the study.
    """
    lifetime = result.lifetime()
    settings = {
        **result.settings.plain(),
        "wind_speeds": sorted({run.wind_speed for run in result.runs}),
        "seeds": list(dict.fromkeys(run.seed for run in result.runs if run.seed is not None)),
        "shear": result.settings.exponent,
        "weibull_mean": None if lifetime is None else lifetime.mean_wind_speed,
        "channels": [channel.name for channel in result.channels],
        "controller": result.controller,
        "step": result.step,
        "interval": result.interval,
        **turbine,
    }
    return {
        "turbine": result.turbine,
        "settings": settings,
        "channels": {
            channel.name: {"unit": channel.unit, "meaning": channel.meaning}
            for channel in result.channels
        },
        "runs": [
            {
                "wind_speed": run.wind_speed,
                "turbulence": run.turbulence,
                "seed": run.seed,
                "status": run.status,
                "message": run.message,
                "diverged_at": run.diverged_at,
                "seconds": run.seconds,
                "step_error": run.step_error,
                "evaluations": run.evaluations,
                "statistics": _statistics(run.statistics, result.channels),
            }
            for run in result.runs
        ],
        "summary": [
            {
                "wind_speed": speed.wind_speed,
                "runs": speed.runs,
                "diverged": speed.diverged,
                "statistics": _statistics(speed.statistics, result.channels),
            }
            for speed in result.summary()
        ],
        "lifetime": None if lifetime is None else _lifetime(lifetime, result.channels),
        "seconds": result.seconds,
    }


def statistics_csv(document: Mapping[str, Any]) -> str:
    """Statistics of a document, a row for each run and channel."""
    keys = ("wind_speed", "turbulence", "seed", "status")
    return records_csv(
        [
            {**{key: run[key] for key in keys}, "channel": name, **values}
            for run in document["runs"]
            for name, values in (run["statistics"] or {}).items()
        ]
    )


def _statistics(
    found: Mapping[str, ChannelStatistics] | None, channels: tuple[Channel, ...]
) -> dict[str, Any] | None:
    if found is None:
        return None
    return {channel.name: _record(found[channel.name], channel) for channel in channels}


def _record(found: ChannelStatistics, channel: Channel) -> dict[str, Any]:
    values = asdict(found)
    slope = values.pop("slope")
    names = {"least": "min", "largest": "max", "equivalent_load": "del"}
    return {
        "unit": channel.unit,
        **{
            names.get(key, key): None if value is None else channel.factor * value
            for key, value in values.items()
        },
        "wohler": slope,
    }


def _lifetime(found: Lifetime, channels: tuple[Channel, ...]) -> dict[str, Any]:
    return {
        "weibull_mean": found.mean_wind_speed,
        "weights": found.weights,
        "share_of_time": found.share,
        "channels": {
            channel.name: {
                "unit": channel.unit,
                "mean": channel.factor * found.means[channel.name],
                "del": (
                    channel.factor * found.equivalent_loads[channel.name]
                    if channel.name in found.equivalent_loads
                    else None
                ),
            }
            for channel in channels
        },
    }
