"""Several winds on the command line, and what the commands for them share.

A list of speeds, a list of speeds and one of shears (every pair of them), or a CSV file with one
wind a row, whose columns are keys of the sections ``wind`` and ``operation`` of a case file, and
``label`` and ``weight`` besides.
"""

from __future__ import annotations

import csv
import io
import math
from dataclasses import dataclass
from itertools import product
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from pitchopt.cli.values import Option, numbers
from pitchopt.errors import InputError

if TYPE_CHECKING:
    from pitchopt.cases import Case
    from pitchopt.design.several_results import Several

__all__ = ["Winds", "finish", "price_option", "read_winds", "shared_settings"]

_MOST_WINDS = 1000


@dataclass(frozen=True, kw_only=True)
class Winds:
    """Cases that differ in their wind, what they are called, and their weights."""

    cases: tuple[Case, ...]
    labels: tuple[str, ...]
    weights: tuple[float, ...] | None


price_option = click.option(
    "--mu", type=Option("x", numbers), metavar="X", required=True,
    help="Price: mean torque given for one unit of weighted RMS; one number, or one for each wind.",
)  # fmt: skip


def read_winds(
    case: Case, option: str, text: str, shears: tuple[float, ...] | None = None
) -> Winds:
    """Winds of an option's text.

    Raises
    ------
    InputError
        If it is neither a list of speeds above 0 nor a table, or the case has no wind model.
    """
    if case.table is not None:
        raise InputError(f"{option}: got {text!r} with a table of curves, expected a rotor model")
    if text.lower().endswith(".csv"):
        if shears is not None:
            raise InputError("--shears: got numbers with a CSV file of winds, expected a column")
        return _table(case, option, text)
    speeds = numbers(option, text)
    if not all(0 < speed <= 100 for speed in speeds):
        raise InputError(
            f"{option}: got {text!r}, expected wind speeds above 0 and at most 100 m/s, such as "
            "6,8,10, or a .csv file"
        )
    values: list[dict[str, Any]] = [{"wind.speed": speed} for speed in speeds]
    labels = [f"{speed:g} m/s" for speed in speeds]
    if shears is not None:
        more = {"wind.shear": "power"} if case.wind.shear == "none" else {}
        pairs = list(product(speeds, shears))
        values = [{"wind.speed": v, "wind.shear_exponent": shear, **more} for v, shear in pairs]
        labels = [f"{v:g} m/s, shear {shear:g}" for v, shear in pairs]
    return Winds(
        cases=tuple(case.with_values(value) for value in values),
        labels=tuple(labels),
        weights=None,
    )


def _table(case: Case, option: str, text: str) -> Winds:
    from pitchopt.cases.settings import SCHEMA
    from pitchopt.exports.files import read_text

    rows = list(csv.DictReader(io.StringIO(read_text(text, option))))
    known = {entry.key: entry for entry in SCHEMA if entry.section in ("wind", "operation")}
    if not 0 < len(rows) <= _MOST_WINDS:
        raise InputError(f"{option}: {text} has {len(rows)} winds, expected 1 to {_MOST_WINDS}")
    cases, labels, weights = [], [], []
    for number, row in enumerate(rows, start=1):
        values: dict[str, Any] = {}
        words = []
        for key, cell in row.items():
            where = f"{option}: {text}, wind {number}, {key}"
            if key in ("label", "weight"):
                continue
            if key not in known or cell is None:
                raise InputError(
                    f"{where}: got {cell!r}, expected columns out of label, weight, "
                    + ", ".join(known)
                )
            entry = known[key]
            values[f"{entry.section}.{entry.attribute}"] = entry.kind.parse(where, cell.strip())
            words.append(f"{key} {cell.strip()}")
        cases.append(case.with_values(values))
        labels.append((row.get("label") or ", ".join(words)).strip())
        weights.append(
            numbers(f"{option}: {text}, wind {number}, weight", row["weight"] or "")[0]
            if "weight" in row
            else 1.0
        )
    return Winds(
        cases=tuple(cases),
        labels=tuple(labels),
        weights=tuple(weights) if "weight" in rows[0] else None,
    )


def shared_settings(winds: Winds, search: dict[str, Any]) -> dict[str, Any]:
    """Settings of the first wind's case, the winds, and how it was searched."""
    settings = winds.cases[0].settings()
    settings["winds"] = [
        {"label": label, **case.settings()["wind"], **case.settings()["operation"]}
        for label, case in zip(winds.labels, winds.cases, strict=True)
    ]
    settings["search"] = search
    return settings


def finish(
    case: Case, settings: dict[str, Any], result: Several, options: dict[str, Any], command: str,
    folder: Path | None, seconds: float,
) -> int:  # fmt: skip
    """Write the files, print the table or the document; the exit status."""
    from pitchopt.cli import output
    from pitchopt.exports import document_text, schedule_csv, several_document, several_npz

    document = several_document(case.name, settings, result, seconds)
    files: dict[str, bytes | str] = {}
    if folder is not None:
        files = {
            f"{command}.json": document_text(document),
            f"{command}.csv": schedule_csv(result),
            f"{command}.npz": several_npz(
                result,
                rotor_speeds=[wind["rotor_speed_rpm"] * math.pi / 30 for wind in settings["winds"]],
                blades=case.blades,
                settings={"case": case.name, **settings},
            ),
        }
        if not options["no_plots"]:
            from pitchopt.plotting import png, several_figures

            profiles, regrets = several_figures(result, title=case.name)
            files |= {"profiles.png": png(profiles), "regrets.png": png(regrets)}
    written = output.save(folder, files)
    if options["as_json"]:
        click.echo(document_text(document), nl=False)
    else:
        _print(case, settings, document)
        output.closing(folder, written, seconds)
    if not result.status.ok:
        text = " ".join(result.message.split())
        click.echo(f"pitchopt: {command}: {result.status.value}: {text}", err=True)
    return 0 if result.status.ok else 1


def _print(case: Case, settings: dict[str, Any], document: dict[str, Any]) -> None:
    from pitchopt.cli.output import case_line
    from pitchopt.cli.tables import number, text_table

    click.echo(case_line(case, settings).splitlines()[1] + "\n")
    table = [
        ["", "", "constant", "mean", "RMS", "", "", "own", ""],
        ["wind", "weight", "pitch", "torque", "weighted", "RMS cut", "objective", "optimum",
         "regret"],
        ["", "", "deg", "kN m", "kN m", "%", "kN m", "kN m", "kN m"],
    ]  # fmt: skip
    for wind in document["winds"]:
        cut = wind["cut"]
        table.append(
            [
                wind["label"],
                f"{wind['weight']:.3f}",
                number(wind["constant_pitch_deg"], "deg"),
                number(1e-3 * wind["mean_torque"]),
                number(1e-3 * wind["rms_weighted"]),
                number(None if cut is None else 100 * cut, "%"),
                number(1e-3 * wind["objective"]),
                number(1e-3 * wind["own_objective"]),
                number(1e-3 * wind["regret"]),
            ]
        )
    click.echo(text_table(table, header=3) + "\n")
    what = "least largest regret" if document["goal"] == "regret" else "weighted objective"
    sign = -1.0 if document["goal"] == "regret" else 1.0
    line = f"{what} {number(1e-3 * sign * document['objective'])} kN m, {document['status']}"
    if document["upper_bound"] is not None:
        bound = max(sign * document["upper_bound"], 0.0 if sign < 0 else -float("inf"))
        side = "at least" if sign < 0 else "at most"
        line += f"; proven: {side} {number(1e-3 * bound)} kN m for any profile"
        line += "s" if document["goal"] == "schedule" else ""
    click.echo(line)
    if document["goal"] == "schedule":
        click.echo(
            f"largest change between neighbours {number(document['largest_change_deg'], 'deg')} deg"
        )
    click.echo("")
