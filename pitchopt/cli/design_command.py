"""``pitchopt design``: one pitch profile."""

from __future__ import annotations

import time
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import click

from pitchopt.cli.help import SEARCH, Command, section
from pitchopt.cli.options import (
    build_case,
    case_options,
    certify_options,
    result_options,
    search_options,
)
from pitchopt.cli.values import Option, as_share, numbers, torque
from pitchopt.errors import InputError

if TYPE_CHECKING:
    from pitchopt.cases import Case
    from pitchopt.design import Certificate, Design, DesignTask

__all__ = ["Solved", "command", "goal_options", "rated_torque", "solve"]

_EPILOG = """\b
Examples:
  pitchopt design --case biegel2011 --max-power-loss 2%
  pitchopt design --case nrel-5mw --wind-speed 15 --mean-torque rated --out above-rated
  pitchopt design --case iea-15-240 --mu 10 --harmonics 3 --json
  pitchopt design --max-power-loss 3% --certify deep --certify-gap 1% --out proven
  pitchopt design --curves table.npz --rotor-speed-rpm 12.1 --mu 3 --weights unit

\b
Files: design.json, profile.csv, profiles.npz (for pitchopt export and the controller file of
pitchopt simulate), certificates.npz (for pitchopt check), and profiles.png, loads.png,
wind.png.

\b
With --mean-torque the profile is compared with the constant pitch of the same
torque, otherwise with the constant pitch of largest torque.

\b
See also: tradeoff (all of them), robust and schedule (several winds), export, sensitivity."""


def goal_options(function: Any) -> Any:
    """The three goals of a design."""
    return section(
        "Goal",
        click.option(
            "--max-power-loss", type=Option("share", as_share), metavar="SHARE",
            help="Least weighted RMS for at most this loss of mean torque: 2% or 0.02.",
        ),
        click.option(
            "--mean-torque", type=Option("torque", torque, names=("rated",)), metavar="NM|rated",
            help="Least weighted RMS at this mean torque [N m], as above rated wind.",
        ),
        click.option(
            "--mu", type=Option("x", numbers), metavar="X",
            help="Largest mean torque less X times the weighted RMS of the loads.",
        ),
    )(function)  # fmt: skip


@dataclass(frozen=True, kw_only=True)
class Solved:
    """A design and what it is compared with."""

    case: Case
    settings: dict[str, Any]
    task: DesignTask
    constant: Design
    power_max: Design
    design: Design


def solve(case: Case, options: dict[str, Any]) -> Solved:
    """Solve the design that the options ask for."""
    goals = {
        name: options[name]
        for name in ("mu", "max_power_loss", "mean_torque")
        if options[name] is not None
    }
    if len(goals) != 1:
        flags = " and ".join("--" + name.replace("_", "-") for name in goals) or "none"
        raise InputError(
            f"goal: got {flags}, expected exactly one of --mu, --max-power-loss, --mean-torque"
        )
    if "mu" in goals:
        if len(goals["mu"]) != 1:
            raise InputError(f"--mu: got {len(goals['mu'])} numbers, expected one")
        (goals["mu"],) = goals["mu"]
    if goals.get("mean_torque") == "rated":
        goals["mean_torque"] = rated_torque(case)
    settings = case.settings()
    task = case.task()
    from pitchopt.cli.certify import certify_record, proof_settings
    from pitchopt.cli.progress import Progress
    from pitchopt.design import compared

    with proof_settings(options) as certify, Progress() as progress:
        found = compared(
            task,
            starts=options["starts"],
            certify=certify,
            resume=_resumed(options.get("resume")),
            seed=options["seed"],
            progress=progress,
            **goals,
        )
    settings["search"] = {
        **goals,
        "starts": options["starts"],
        **certify_record(options),
        "seed": options["seed"],
    }
    return Solved(
        case=case,
        settings=settings,
        task=task,
        constant=found.constant,
        power_max=found.power_max,
        design=found.design,
    )


def _resumed(path: str | None) -> Certificate | None:
    """The certificate with a tree of regions in a file."""
    if path is None:
        return None
    from pitchopt.exports import read_certificates

    trees = [found for found in read_certificates(path).values() if found.proof is not None]
    if len(trees) != 1:
        raise InputError(
            f"--resume: {path} holds {len(trees)} branch and bound proofs, expected one"
        )
    return trees[0]


def rated_torque(case: Case) -> float:
    """Torque of the case's turbine at rated power and rotor speed [N m]."""
    turbine = case.turbine_data
    torque = None if turbine is None else turbine.rated_torque
    if torque is None:
        name = "a table of curves" if turbine is None else f"turbine {turbine.name!r}"
        raise InputError(
            f"--mean-torque: got 'rated', expected a number [N m]: the rated torque of {name} is "
            "not known"
        )
    return torque


@click.command("design", cls=Command, epilog=_EPILOG)
@goal_options
@case_options
@search_options
@certify_options
@section(
    SEARCH,
    click.option(
        "--resume",
        type=Option("file", endings=(".npz",)),
        metavar="FILE",
        help="Go on from the proof in this certificates.npz of the same design; one made for a "
        "larger gap cannot lead to a smaller one, and is made anew.",
    ),
)
@result_options
def command(**options: Any) -> int:
    """One pitch profile.

    The pitch of each blade over a turn with which the rotor's loads vary least for the torque it
    gives. Exactly one of --max-power-loss, --mean-torque and --mu says which. Prints it beside the
    best constant pitch and the power maximum, what it leaves of each load, and how far it is from
    the best possible.
    """
    began = time.perf_counter()
    from pitchopt.cli import output
    from pitchopt.exports import design_document, document_text

    case = build_case(options)
    as_json = options["as_json"]
    folder = output.out_folder(options["out"], "design", case.name, as_json=as_json)
    solved = solve(case, options)
    from pitchopt.cli.sensitivity_design import brief_sensitivity

    sensitivity = brief_sensitivity(solved)
    files = _files(solved, plots=not options["no_plots"]) if folder else {}
    document = design_document(
        case.name,
        solved.settings,
        solved.design,
        constant=solved.constant,
        power_max=solved.power_max,
        seconds=time.perf_counter() - began,
        model=case.model_report(solved.task.model, solved.constant),
        hub_height=case.hub_height,
    )
    document["sensitivity"] = sensitivity
    written = output.save(folder, {**files, "design.json": document_text(document)})
    if as_json:
        click.echo(document_text(document), nl=False)
    else:
        _print(solved, document)
        output.closing(folder, written, time.perf_counter() - began)
    output.warn_about([("design", solved.design)], case)
    return 0 if solved.design.status.ok else 1


def _files(solved: Solved, *, plots: bool) -> dict[str, bytes | str]:
    from pitchopt.exports import certificates_file, profile_csv, profile_set
    from pitchopt.exports.profiles import label_of

    case, design = solved.case, solved.design
    speed = case.rotor_speed
    profiles = profile_set(
        solved.constant,
        solved.power_max,
        [design],
        blades=case.blades,
        rotor_speed=speed,
        settings={"case": case.name, **solved.settings},
    )
    files: dict[str, bytes | str] = {
        "profile.csv": profile_csv(design.azimuth, design.profile, rotor_speed=speed),
        "profiles.npz": profiles.to_bytes(),
    }
    if design.certificate is not None:
        files["certificates.npz"] = certificates_file({label_of(design): design.certificate})
    if plots:
        from pitchopt.cli.certify import better_intervals
        from pitchopt.cli.output import wind_plot
        from pitchopt.plotting import loads_figure, png, profiles_figure

        shown = {label_of(design): design, "constant": solved.constant}
        files |= {
            "profiles.png": png(
                profiles_figure(shown, intervals=better_intervals(design), title=case.name)
            ),
            "loads.png": png(loads_figure(shown, title=case.name)),
            **wind_plot(case),
        }
    return files


def _print(solved: Solved, document: dict[str, Any]) -> None:
    from pitchopt.cli.output import case_line, model_lines
    from pitchopt.cli.sensitivity_tables import sensitivity_lines
    from pitchopt.cli.tables import design_table, number, reference_row

    record = document["design"]
    constant = reference_row(document["constant"], document["power_max"])
    name = "constant pitch" if record["kind"] == "mean_torque" else "best constant pitch"
    rows = [
        (name, constant, ""),
        ("power maximum", document["power_max"], ""),
        (record["label"], record, "<- design"),
    ]
    click.echo(case_line(solved.case, solved.settings) + "\n")
    click.echo(design_table(rows) + "\n")
    for line in model_lines(document["model"]):
        click.echo(line)
    for key, where in (("rms", ""), ("rms_between", ", between the stations")):
        before, after = document["constant"][key], record[key]
        if before is None or after is None:
            continue
        cuts = [
            f"{load} {number(100 * (1 - value / before[load]), '%')} %"
            for load, value in after.items()
            if before[load] > 0
        ]
        click.echo(f"RMS cut against the constant pitch{where}: {', '.join(cuts)}")
    if record["rms_lower_bound"] is not None and record["rms_weighted"] > 0:
        share = 100 * record["rms_lower_bound"] / record["rms_weighted"]
        click.echo(f"no profile with this torque has less than {share:.1f} % of the weighted RMS")
    click.echo("")
    for line in sensitivity_lines(document["sensitivity"]):
        click.echo(line)
    click.echo("")
