"""What ``pitchopt tune`` prints for people."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import click

from pitchopt.cli.tables import text_table

__all__ = ["print_tuning"]

_SHOWN = 12


def print_tuning(document: Mapping[str, Any]) -> None:
    """One study, or the table of several."""
    studies = document.get("studies", [document])
    for study in studies:
        _print_study(study)
    if "comparison" in document:
        click.echo(_comparison(document["comparison"]) + "\n")


def _print_study(study: Mapping[str, Any]) -> None:
    problem = study["settings"]["problem"]
    plant = problem["plant"]
    speeds = ", ".join(f"{u:g}" for u in problem["wind_speeds"])
    click.echo(
        f"{study['turbine']}: {study['problem']} by {study['method']}, {speeds} m/s, turbulence "
        f"{plant['turbulence']}, {len(problem['seeds'])} seeds, {plant['duration']:g} s after "
        f"{plant['skip']:g} s\n"
    )
    start, best = study["start"], study["best"]
    rows = [["", *study["parameters"], "cost", *start["measures"]]]
    for label, point in (("start", start), ("best", best)):
        values = [*point["x"], point["cost"], *point["measures"].values()]
        rows.append([label, *(_short(v) for v in values)])
    click.echo(text_table(rows) + "\n")
    failed = sum(e["status"] != "ok" for e in study["evaluations"])
    click.echo(
        f"cost {100 * study['gain']:.2f} % lower after {len(study['evaluations'])} evaluations"
        + (f" ({failed} failed)" if failed else "")
        + f", {study['simulations']} simulations, {study['seconds']:.1f} s"
    )
    if "fresh_gain" in study:
        click.echo(f"in winds that the tuner did not see: {100 * study['fresh_gain']:.2f} % lower")
    for line in study.get("remarks", ()):
        click.echo(line)
    click.echo()


def _comparison(rows: Sequence[Mapping[str, Any]]) -> str:
    fresh = any("fresh_gain" in row for row in rows)
    head = ["problem", "method", "evaluations", "simulations", "lower by %"]
    table = [[*head, *(["fresh winds %"] if fresh else []), "best x", "seconds"]]
    table += [
        [
            row["problem"],
            row["method"],
            str(row["evaluations"]),
            str(row["simulations"]),
            f"{100 * row['gain']:.2f}",
            *([f"{100 * row['fresh_gain']:.2f}"] if fresh else []),
            " ".join(_short(x) for x in row["best_x"]),
            f"{row['seconds']:.1f}",
        ]
        for row in rows
    ]
    return text_table(table, left=2)


def _short(value: float | None) -> str:
    return "-" if value is None else f"{value:.4g}"
