"""``pitchopt learn --plant dynamic``: its options, its run, its files and what it prints."""

from __future__ import annotations

import time
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import click

from pitchopt.cli.completing import TURBULENCE
from pitchopt.cli.help import Aliased, section
from pitchopt.cli.output import case_line
from pitchopt.cli.tables import number, text_table
from pitchopt.cli.values import Option, between, whole
from pitchopt.errors import InputError

if TYPE_CHECKING:
    from pitchopt.cases import Case
    from pitchopt.studies.learning import LearningSettings, TurbineLearning

__all__ = ["chosen_plant", "learn_turbine", "turbine_options"]

_ONLY_STATIC = (*("wind_step", "wind_ramp", "wind_drift", "blade_pitch_offset_deg", "blade_chord"),)
_DEFAULTS: dict[str, Any] = {
    "turbulence": "none",
    "structure": "flexible",
    "rotor": "held",
    "pitch_lag": 0.0,
    "averaged": 0,
}
_SHOWN = (1, 2, 3, 5, 10, 20)


def turbine_options(function: Any) -> Any:
    """What the learner runs on, and what of the dynamic turbine moves."""
    return section(
        "Plant (all but the first: of the dynamic turbine)",
        click.option(
            "--plant", type=click.Choice(["static", "dynamic"]), default="static",
            show_default=True,
            help="The rotor in equilibrium, or the turbine with structure, wake and "
            "controller in motion.",
        ),
        click.option(
            "--turbulence", type=click.Choice(["none", *TURBULENCE]),
            help="Class of IEC 61400-1 on top of the wind.  [default: none]",
        ),
        click.option(
            "--structure", type=click.Choice(["flexible", "rigid"]),
            help="Whether blades and tower bend.  [default: flexible]",
        ),
        click.option(
            "--rotor", type=click.Choice(["held", "controlled"]),
            help="Rotor speed held, or free with the baseline controller.  [default: held]",
        ),
        click.option(
            "--pitch-lag", "--actuator-time", "pitch_lag", cls=Aliased,
            type=Option("s", between(0.0, 10.0, "s")), metavar="S",
            help="Time constant of the pitch actuators.  [default: 0]",
        ),
        click.option(
            "--averaged", type=Option("n", whole(0, 10_000)), metavar="N",
            help="Rotations over which the loads of a profile are averaged.  [default: 0, one "
            "passage]",
        ),
    )(function)  # fmt: skip


def chosen_plant(options: Mapping[str, Any]) -> str:
    """The plant, after a look at options that belong to the other one.

    Raises
    ------
    InputError
        Naming the first that does.
    """
    plant = str(options["plant"])
    others = tuple(_DEFAULTS) if plant == "static" else _ONLY_STATIC
    needed = "dynamic" if plant == "static" else "static"
    for name in others:
        if options[name] is not None:
            raise InputError(
                f"--{name.replace('_', '-')}: got {options[name]!r} with --plant {plant}, expected "
                f"it with --plant {needed} alone"
            )
    return plant


def learn_turbine(case: Case, settings: LearningSettings, options: dict[str, Any]) -> int:
    """Learn on the dynamic turbine, write files, print; the exit status."""
    began = time.perf_counter()
    from pitchopt.cli import output
    from pitchopt.cli.progress import Progress
    from pitchopt.studies.learning import TurbineSettings, learn_on_turbine

    chosen = {
        name: default if options[name] is None else options[name]
        for name, default in _DEFAULTS.items()
    }
    as_json = options["as_json"]
    folder = output.out_folder(options["out"], "learn", case.name, as_json=as_json)
    with Progress(compiled="the time loop") as progress:
        result = learn_on_turbine(
            case,
            settings,
            TurbineSettings(**chosen),
            checkpoint=options["checkpoint"],
            progress=progress,
        )
    document = result.document(case.settings())
    output.deliver(
        document,
        "learning.json",
        folder=folder,
        files=lambda: _files(result, document, plots=not options["no_plots"]),
        began=began,
        as_json=as_json,
        show=lambda found: _print(case, found),
    )
    output.warn_about([("design", result.reference.design)], case)
    return 0


def _files(
    result: TurbineLearning, document: dict[str, Any], *, plots: bool
) -> dict[str, bytes | str]:
    from pitchopt.exports import profile_csv
    from pitchopt.exports.records import records_csv

    files: dict[str, bytes | str] = {"learning.csv": records_csv(document["rotations"])}
    speed, profile = result.setup.rotor_speed, result.learned.profile
    if profile.ndim == 1:
        files["profile.csv"] = profile_csv(result.azimuth, profile, rotor_speed=speed)
    else:
        for blade, own in enumerate(profile, start=1):
            files[f"profile_b{blade}.csv"] = profile_csv(result.azimuth, own, rotor_speed=speed)
    if plots:
        from pitchopt.plotting import png, turbine_learning_figure

        title = f"{result.case.name}, dynamic turbine, {result.learning.learner} learner"
        files["learning.png"] = png(turbine_learning_figure(result, title=title))
    return files


def _print(case: Case, document: Mapping[str, Any]) -> None:
    """What people read."""
    settings = document["settings"]
    turbine, lag = settings["turbine"], document["lag"]
    click.echo(case_line(case, settings))
    wind = (
        "steady wind"
        if turbine["turbulence"] == "none"
        else f"turbulence of class {turbine['turbulence']}, seed {settings['learning']['seed']}"
    )
    click.echo(
        f"{document['learner']} learner on the dynamic turbine, {turbine['structure']} structure, "
        f"rotor {turbine['rotor']}, {wind}\n"
        f"loads answer the pitch {number(lag['angle_deg'], 'deg')} deg of azimuth late: "
        f"{lag['samples']} samples\n"
    )
    rows = [
        ["rotation", "RMS", "constant's", "left", "mean torque", "mean pitch"],
        ["", "kN m", "kN m", "%", "kN m", "deg"],
    ]
    count = len(document["rotations"])
    for at in sorted({n for n in (*_SHOWN, count) if n <= count}):
        row = document["rotations"][at - 1]
        rows.append(
            [
                str(at),
                number(1e-3 * row["rms_weighted"]),
                number(1e-3 * row["constant_rms_weighted"]),
                number(100 * row["left"], "%"),
                number(1e-3 * row["mean_torque"]),
                number(row["mean_pitch_deg"], "deg"),
            ]
        )
    click.echo(text_table(rows, header=2) + "\n")
    turns = document["turbine_rotations_in_one"]
    if turns > 1:
        click.echo(f"one of these rotations is {turns} of the turbine, loads averaged")
    seeds = document["judged_on_seeds"]
    where = f"seeds {', '.join(map(str, seeds))}" if seeds else "the steady wind"
    click.echo(f"profiles held in {where}, weighted RMS left of the constant pitch's:")
    for name in ("learned", "design"):
        one = document[name]
        click.echo(
            f"  {name}: {number(100 * one['left_total'], '%')} % in all, "
            f"{number(100 * one['left_periodic'], '%')} % of what repeats with the rotor, mean "
            f"torque {number(1e-3 * one['mean']['torque'])} kN m of "
            f"{number(1e-3 * document['setpoint'])}"
        )
    for event in document["events"]:
        click.echo(f"passage {event['passage']}: {event['text']}")
    click.echo("")
