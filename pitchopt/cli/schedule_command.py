"""``pitchopt schedule``: a table of pitch profiles over wind speed."""

from __future__ import annotations

import math
import time
from typing import Any

import click

from pitchopt.cli.help import Command, section
from pitchopt.cli.options import build_case, case_options, result_options, search_options
from pitchopt.cli.values import Option, numbers
from pitchopt.cli.winds import finish, price_option, read_winds, shared_settings
from pitchopt.errors import InputError

__all__ = ["command"]

_EPILOG = """\b
Examples:
  pitchopt schedule --case biegel2011 --wind-speeds 13,14,15,16 --max-change-deg 1 --mu 10
  pitchopt schedule --case nrel-5mw --wind-speeds 6,8,10 --max-change-deg 2 --mu 3 --out table

\b
schedule.csv has one column of azimuth and one column of pitch for each wind speed.

\b
Files: schedule.json, schedule.csv, schedule.npz, and profiles.png, regrets.png.

\b
See also: robust (one profile for all winds), design (one wind)."""


@click.command("schedule", cls=Command, epilog=_EPILOG)
@section(
    "Winds and goal",
    click.option(
        "--wind-speeds", type=Option("list", endings=(".csv",)), metavar="M/S,...|FILE.csv",
        required=True, help="Wind speeds in the order of the table, or a table as in robust.",
    ),
    click.option(
        "--max-change-deg", type=Option("deg", numbers), metavar="DEG",
        help="Largest change of pitch between neighbouring columns at any azimuth; 0 makes one "
        "profile for all.  [default: no limit]",
    ),
    price_option,
)  # fmt: skip
@case_options
@search_options
@result_options
def command(**options: Any) -> int:
    """A pitch profile for each wind speed, as a controller stores them.

    All are found together, with a bounded change from each to the next. Prints what each wind
    speed gives up for it, and a proven bound on what any such table could reach.
    """
    began = time.perf_counter()
    from pitchopt.cli import output
    from pitchopt.cli.progress import Progress

    case = build_case(options)
    winds = read_winds(case, "--wind-speeds", options["wind_speeds"])
    change = options["max_change_deg"]
    if change is not None and len(change) != 1:
        raise InputError(f"--max-change-deg: got {len(change)} numbers, expected one")
    folder = output.out_folder(options["out"], "schedule", case.name, as_json=options["as_json"])
    from pitchopt.design import schedule

    with Progress() as progress:
        result = schedule(
            [one.task() for one in winds.cases],
            mu=options["mu"],
            change=math.inf if change is None else math.radians(change[0]),
            weights=winds.weights,
            labels=winds.labels,
            starts=options["starts"],
            certify=not options["no_certify"],
            seed=options["seed"],
            progress=progress,
        )
    settings = shared_settings(winds, {**result.settings, "certify": not options["no_certify"]})
    return finish(case, settings, result, options, "schedule", folder, time.perf_counter() - began)
