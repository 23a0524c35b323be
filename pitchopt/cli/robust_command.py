"""``pitchopt robust``: one pitch profile for several winds."""

from __future__ import annotations

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
  pitchopt robust --case biegel2011 --winds 13,15,17 --mu 10
  pitchopt robust --case biegel2011 --winds 13,15,17 --shears 0,0.2 --mu 10 --goal regret
  pitchopt robust --case iea-15-240 --winds winds.csv --mu 5 --out robust --json

\b
A CSV file of winds has one row a wind; its columns are keys of the sections wind
and operation of a case file (speed, shear_exponent, direction_deg, yaw_deg, ...),
and label and weight.

\b
Files: robust.json, robust.csv, robust.npz, and profiles.png, regrets.png.

\b
See also: schedule (a profile for each wind speed), design (one wind)."""


@click.command("robust", cls=Command, epilog=_EPILOG)
@section(
    "Winds and goal",
    click.option(
        "--winds", type=Option("list", endings=(".csv",)), metavar="M/S,...|FILE.csv",
        required=True, help="Wind speeds at the hub, or a table of winds.",
    ),
    click.option(
        "--shears", type=Option("list", numbers), metavar="X,...",
        help="Shear exponents: every pair of speed and exponent is a wind.",
    ),
    price_option,
    click.option(
        "--goal", type=click.Choice(["mean", "regret"]), default="mean", show_default=True,
        help="Largest weighted mean of the objectives (mean torque less mu times RMS), or least "
        "largest regret: what the profile lacks of a wind's own best one.",
    ),
    click.option(
        "--wind-weights", type=Option("list", numbers), metavar="X,...",
        help="Weights of the winds.  [default: equal]",
    ),
)  # fmt: skip
@case_options
@search_options
@result_options
def command(**options: Any) -> int:
    """One pitch profile for several winds.

    It keeps the strictest limits of all winds. Prints, for each wind, what it reaches there beside
    that wind's own best profile, and a proven bound on what any one profile could reach.
    """
    began = time.perf_counter()
    from pitchopt.cli import output
    from pitchopt.cli.progress import Progress

    case = build_case(options)
    winds = read_winds(case, "--winds", options["winds"], options["shears"])
    weights = options["wind_weights"]
    if weights is not None and winds.weights is not None:
        raise InputError("--wind-weights: got some besides the column weight, expected one of them")
    weights = winds.weights if weights is None else weights
    folder = output.out_folder(options["out"], "robust", case.name, as_json=options["as_json"])
    from pitchopt.design import robust

    with Progress() as progress:
        result = robust(
            [one.task() for one in winds.cases],
            mu=options["mu"],
            goal=options["goal"],
            weights=weights,
            labels=winds.labels,
            starts=options["starts"],
            certify=not options["no_certify"],
            seed=options["seed"],
            progress=progress,
        )
    settings = shared_settings(winds, {**result.settings, "certify": not options["no_certify"]})
    return finish(case, settings, result, options, "robust", folder, time.perf_counter() - began)
