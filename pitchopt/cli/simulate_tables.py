"""What ``pitchopt simulate`` prints for people."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import click

from pitchopt.cli.tables import number, text_table

__all__ = ["print_simulation"]

_MOST_RUNS = 12
_KEYS = (
    # heading, channel, statistic
    ("power", "GenPwr", "mean"),
    ("rotor", "RotSpeed", "mean"),
    ("pitch", "BldPitch1", "mean"),
    ("thrust", "RotThrust", "mean"),
    ("tower base", "TwrBsMyt", "mean"),
    ("tower base", "TwrBsMyt", "del"),
    ("blade root", "RootMyc1", "mean"),
    ("blade root", "RootMyc1", "del"),
)


def print_simulation(document: Mapping[str, Any]) -> None:
    """What was run, the runs, and the statistics."""
    settings, runs = document["settings"], document["runs"]
    seeds = len({run["seed"] for run in runs})
    kind = runs[0]["turbulence"]
    wind = "steady wind" if kind == "none" else kind
    many = f", {seeds} seeds" if seeds > 1 else ""
    click.echo(
        f"{document['turbine']}: {wind}{many}, controller "
        f"{settings['controller']}, {settings['duration']:g} s after {settings['skip']:g} s, "
        f"step {settings['step']:g} s, {settings['inflow']} inflow\n"
    )
    speeds = document["summary"]
    if len(runs) <= _MOST_RUNS or any(run["status"] == "diverged" for run in runs):
        click.echo(_overview(runs, "seed") + "\n")
    if len(speeds) > 1:
        click.echo("All seeds of a wind speed together\n")
        click.echo(_overview(speeds, "runs") + "\n")
        if document["lifetime"] is not None:
            click.echo(_lifetime(document["lifetime"]) + "\n")
    elif speeds[0]["statistics"] is not None:
        together = "" if len(runs) == 1 else ", all seeds together"
        click.echo(f"Statistics at {speeds[0]['wind_speed']:g} m/s{together}\n")
        click.echo(_statistics(speeds[0]["statistics"]) + "\n")
    largest = max(run["step_error"] for run in runs)
    balances = max(run["evaluations"] for run in runs)
    click.echo(
        f"time loop {sum(run['seconds'] for run in runs):.2f} s; step check {largest:.2g} of the "
        f"largest rate, {balances:.2f} momentum balances an element and step"
    )


def _overview(rows: list[Mapping[str, Any]], column: str) -> str:
    """Key figures of runs or of wind speeds, those of channels that there are."""
    known: Mapping[str, Any] = next((row["statistics"] for row in rows if row["statistics"]), {})
    keys = [key for key in _KEYS if key[1] in known]
    table = [
        ["wind", column, *(heading for heading, _, _ in keys), "status"],
        ["m/s", "", *("DEL" if kind == "del" else kind for _, _, kind in keys), ""],
        ["", "", *(known[channel]["unit"] for _, channel, _ in keys), ""],
    ]
    for row in rows:
        found = row["statistics"] or {}
        cells = [
            number(found[channel][kind] if found else None, known[channel]["unit"])
            for _, channel, kind in keys
        ]
        first = row[column]
        table.append(
            [
                f"{row['wind_speed']:g}",
                "-" if first is None else str(first),
                *cells,
                _status(row),
            ]
        )
    return text_table(table, header=3)


def _status(row: Mapping[str, Any]) -> str:
    if "status" not in row:
        return "all finished" if not row["diverged"] else f"{row['diverged']} diverged"
    if row["diverged_at"] is None:
        return str(row["status"])
    return f"diverged at {row['diverged_at']:.4g} s"


def _statistics(found: Mapping[str, Mapping[str, Any]]) -> str:
    table = [["channel", "unit", "mean", "std", "min", "max", "DEL", "slope"]]
    for name, values in found.items():
        slope = values["wohler"]
        table.append(
            [
                name,
                values["unit"],
                *(number(values[key]) for key in ("mean", "std", "min", "max", "del")),
                "-" if slope is None else f"{slope:g}",
            ]
        )
    return text_table(table, left=2)


def _lifetime(found: Mapping[str, Any]) -> str:
    rows = [["channel", "unit", "mean", "DEL"]]
    for name, values in found["channels"].items():
        if values["del"] is not None or name == "GenPwr":
            rows.append([name, values["unit"], number(values["mean"]), number(values["del"])])
    return (
        f"Over these wind speeds, Rayleigh with a mean of {found['weibull_mean']:g} m/s "
        f"({100 * found['share_of_time']:.0f} % of all time)\n\n" + text_table(rows, left=2)
    )
