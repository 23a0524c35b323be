"""``pitchopt robust``: one pitch profile for several winds."""

from __future__ import annotations

import time
from typing import Any

import click

from pitchopt.cli.options import (
    build_case,
    case_options,
    json_option,
    output_options,
    search_options,
)
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
Files: robust.json, robust.csv, robust.npz, and profiles.png, regrets.png."""


@click.command("robust", epilog=_EPILOG)
@click.option("--winds", metavar="LIST|FILE.csv", required=True, help="Wind speeds, or a table.")
@click.option(
    "--shears", type=Option("list", numbers), metavar="LIST",
    help="Shear exponents: every pair of speed and exponent is a wind.",
)  # fmt: skip
@price_option
@click.option(
    "--goal", type=click.Choice(["mean", "regret"]), default="mean", show_default=True,
    help="Largest weighted mean of the objectives, or least largest regret against each wind's "
    "own optimum.",
)  # fmt: skip
@click.option(
    "--wind-weights", type=Option("list", numbers), metavar="LIST",
    help="Weights of the winds.  [default: equal]",
)  # fmt: skip
@case_options
@search_options
@click.option("--no-plots", is_flag=True, help="Leave out the pictures.")
@output_options
@json_option
def command(**options: Any) -> int:
    """One pitch profile for several winds.

    It keeps the strictest limits of all winds.
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
