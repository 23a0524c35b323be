"""``pitchopt tradeoff``: the curve between mean torque and load variation."""

from __future__ import annotations

import time
from typing import TYPE_CHECKING, Any

import click

from pitchopt.cli.help import Command, section
from pitchopt.cli.options import (
    build_case,
    case_options,
    certify_options,
    result_options,
    search_options,
)
from pitchopt.cli.values import Option, as_share, numbers, whole
from pitchopt.errors import InputError

if TYPE_CHECKING:
    from pitchopt.cases import Case
    from pitchopt.design import Tradeoff

__all__ = ["command"]

ALWAYS = (0.03, 0.07)
POINTS = 20

_EPILOG = """\b
Examples:
  pitchopt tradeoff --case biegel2011 --out demo
  pitchopt tradeoff --case nrel-5mw --wind-speed 9 --positions 48 --loss 1% --loss 2%
  pitchopt tradeoff --case my-case.toml --mu 1,3,10,30 --json > curve.json
  pitchopt tradeoff --points 8 --certify deep --certify-seconds 60 --out proven
  pitchopt tradeoff --curves table.npz --rotor-speed-rpm 12.1

\b
Files: tradeoff.csv, tradeoff.json, profiles.npz (for pitchopt export), certificates.npz
(for pitchopt check), and tradeoff.png, profiles.png, loads.png, wind.png.

\b
In the table, RMS cuts are against the best constant pitch, weighted as the
objective is; "between" judges the profile, interpolated linearly, between its
stations as well. Torque is lost against the power maximum. "gap" is how far a
point's objective is from the proven bound, as a share of the largest torque
(with a frozen wake: for the point's own mean pitch).

\b
See also: design (one point of the curve), sensitivity (what would move it), export."""


@click.command("tradeoff", cls=Command, epilog=_EPILOG)
@section(
    "Points of the curve",
    click.option(
        "--points",
        type=Option("n", whole(1, 1000)),
        metavar="N",
        help=f"Number of prices, chosen for the case.  [default: {POINTS}]",
    ),
    click.option(
        "--mu",
        type=Option("x,x,...", numbers),
        multiple=True,
        metavar="X,X,...",
        help="These prices instead: mean torque given for one unit of weighted RMS.",
    ),
    click.option(
        "--loss",
        type=Option("share", as_share),
        multiple=True,
        metavar="SHARE",
        help="Add the design of least RMS for this loss of torque; 3% and 7% always stand there.",
    ),
)
@case_options
@search_options
@certify_options
@result_options
def command(**options: Any) -> int:
    """What less variation of the rotor's loads costs in mean torque.

    Pitches each blade over a turn so that torque, tilt, yaw and thrust vary less, for many prices
    of that variation. Prints one row a price, from the most power to the least variation, with the
    knee of the curve marked and how far each is from the best possible; writes tables, profiles
    and pictures.
    """
    began = time.perf_counter()
    from pitchopt.cli import output
    from pitchopt.cli.certify import certify_record, proof_settings
    from pitchopt.cli.progress import Progress
    from pitchopt.exports import tradeoff_document

    case = build_case(options)
    mu = [price for group in options["mu"] for price in group]
    if mu and options["points"] is not None:
        raise InputError("--points: got a number together with --mu, expected one of the two")
    as_json = options["as_json"]
    folder = output.out_folder(options["out"], "tradeoff", case.name, as_json=as_json)
    settings = case.settings()
    task = case.task()
    from pitchopt.design import tradeoff

    losses = sorted({*ALWAYS, *options["loss"]})
    with proof_settings(options) as certify, Progress() as progress:
        result = tradeoff(
            task,
            mu=mu or None,
            points=options["points"] or POINTS,
            losses=losses,
            starts=options["starts"],
            certify=certify,
            seed=options["seed"],
            progress=progress,
        )
    settings["search"] = {
        "mu": [point.mu for point in result.points if point.kind == "mu"],
        "losses": losses,
        "starts": options["starts"],
        **certify_record(options),
        "seed": options["seed"],
    }
    files = _files(case, settings, result, plots=not options["no_plots"]) if folder else {}
    document = tradeoff_document(
        case.name,
        settings,
        result,
        time.perf_counter() - began,
        model=case.model_report(task.model, result.constant),
        hub_height=case.hub_height,
    )
    written = output.save(folder, {**files, **_text_files(document, result)})
    if as_json:
        from pitchopt.exports import document_text

        click.echo(document_text(document), nl=False)
    else:
        _print(case, settings, document)
        output.closing(folder, written, time.perf_counter() - began)
    output.warn_about([("power maximum", result.power_max), *_labelled(result)], case)
    return 1 if output.failed(result) else 0


def _labelled(result: Tradeoff) -> list[tuple[str, Any]]:
    from pitchopt.exports.profiles import label_of

    return [(label_of(point), point) for point in result.points]


def _text_files(document: dict[str, Any], result: Tradeoff) -> dict[str, str]:
    from pitchopt.exports import document_text, tradeoff_csv

    constant = {"label": "constant", "kind": "constant", **document["constant"]}
    rows = [constant, document["power_max"], *document["points"]]
    return {
        "tradeoff.csv": tradeoff_csv(rows, result.knee + 2 if result.points else None),
        "tradeoff.json": document_text(document),
    }


def _files(
    case: Case, settings: dict[str, Any], result: Tradeoff, *, plots: bool
) -> dict[str, bytes | str]:
    from pitchopt.exports import certificates_file, tradeoff_profiles

    profiles = tradeoff_profiles(
        result,
        blades=case.blades,
        rotor_speed=case.rotor_speed,
        settings={"case": case.name, **settings},
    )
    files: dict[str, bytes | str] = {"profiles.npz": profiles.to_bytes()}
    certificates = {
        label: point.certificate for label, point in _labelled(result) if point.certificate
    }
    if certificates:
        files["certificates.npz"] = certificates_file(certificates)
    if plots:
        from pitchopt.cli.certify import better_intervals
        from pitchopt.cli.output import wind_plot
        from pitchopt.plotting import loads_figure, png, profiles_figure, tradeoff_figure

        knee = result.points[result.knee]
        shown = {"knee": knee, "power maximum": result.power_max}
        name = settings["objective"]["weights_name"]
        files |= {
            "tradeoff.png": png(tradeoff_figure(result, weights_name=name, title=case.name)),
            "profiles.png": png(
                profiles_figure(shown, intervals=better_intervals(knee), title=case.name)
            ),
            "loads.png": png(loads_figure({**shown, "constant": result.constant}, title=case.name)),
            **wind_plot(case),
        }
    return files


def _print(case: Case, settings: dict[str, Any], document: dict[str, Any]) -> None:
    from pitchopt.cases import builtin_names, load_case
    from pitchopt.cli.output import case_line, model_lines
    from pitchopt.cli.tables import design_table, paper_table, reference_row

    knee = document["knee"]["index"]
    constant = reference_row(document["constant"], document["power_max"])
    rows = [
        ("best constant pitch", constant, ""),
        ("power maximum", document["power_max"], ""),
        *(
            (point["label"], point, "<- knee" if number == knee else "")
            for number, point in enumerate(document["points"])
        ),
    ]
    click.echo(case_line(case, settings) + "\n")
    click.echo(design_table(rows) + "\n")
    for line in model_lines(document["model"]):
        click.echo(line)
    if "biegel2011" in builtin_names() and case == load_case("biegel2011"):
        click.echo("Beside the paper (sum of the four RMS values in N m and N)\n")
        click.echo(paper_table(document) + "\n")
