"""What ``pitchopt compare`` prints for people."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import click

from pitchopt.cli.tables import text_table
from pitchopt.studies.comparison.document import PLANNED
from pitchopt.studies.comparison.tables import (
    change_rows,
    effort_rows,
    few_seeds,
    knowledge_rows,
    load_rows,
    point_rows,
    promise,
    wind_title,
)

__all__ = ["print_comparison"]


def print_comparison(document: Mapping[str, Any]) -> None:
    """Winds with their tables, efforts, knowledge, and the verdict last."""
    settings = document["settings"]["comparison"]
    click.echo(
        f"{document['turbine']}, {document['wind_speed']:g} m/s, {document['rotor_speed_rpm']:.2f} "
        f"rpm, free rotor, actuators of {settings['pitch_lag']:g} s, {settings['duration']:g} s "
        f"after {settings['skip']:g} s\n"
    )
    for one in document["winds"]:
        wind = one["wind"]
        click.echo(f"{wind_title(document, wind)}\n")
        click.echo("change of damage-equivalent loads")
        click.echo(text_table(change_rows(document, wind), header=2) + "\n")
        click.echo("change of RMS")
        click.echo(text_table(change_rows(document, wind, "rms"), header=2) + "\n")
        click.echo("loads")
        click.echo(text_table(load_rows(document, wind), header=2) + "\n")
    for record in document["entries"]:
        if record["message"]:
            click.echo(
                f"{record['method']} in {record['wind']}: {record['status']}: {record['message']}\n"
            )
    click.echo("What each took\n")
    click.echo(text_table(effort_rows(document), left=2) + "\n")
    points = point_rows(document)
    if len(points) > 2:
        click.echo("What the tuners chose\n")
        click.echo(text_table(points, left=2, header=2) + "\n")
    click.echo("What each had to know\n")
    heads, *rows = knowledge_rows(document)
    for row in rows:
        click.echo(row[0])
        for head, text in zip(heads[1:], row[1:], strict=True):
            click.echo(f"  {head:<17}  {text}")
    click.echo("")
    for method in PLANNED:
        found = document["verdict"].get(method)
        if found is not None and found["sentences"]:
            click.echo(f"Where the {method} profile pays (damage-equivalent loads)")
            for line in found["sentences"]:
                click.echo(f"  {line}")
            click.echo("")
    added = document["verdict"]["added_to_individual_pitch"]
    if added:
        click.echo("What the profile adds to individual pitch (feed-forward+ipc against ipc-bayes)")
        for line in added:
            click.echo(f"  {line}")
        click.echo("")
    if promise(document):
        click.echo(promise(document))
    if few_seeds(document):
        click.echo(few_seeds(document))
    click.echo("")
