"""What a pitch design would gain from changed limits, prices or winds: options, work, files."""

from __future__ import annotations

import math
import time
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import click

from pitchopt.cli.design_command import Solved, solve
from pitchopt.cli.help import section
from pitchopt.cli.options import build_case
from pitchopt.cli.values import Option, whole
from pitchopt.errors import ComputationError, InputError, PitchoptError

if TYPE_CHECKING:
    from pitchopt.studies.sensitivity import DesignPoint

__all__ = ["brief_sensitivity", "run_design", "step_options"]

DEFAULT_LOSS = 0.03
_GOALS = ("mu", "max_power_loss", "mean_torque")
_STEPS: Mapping[str, tuple[str, str, tuple[str, ...]]] = {
    # option: unit, help, parameters
    "rate_step": ("deg/s", "Change of the pitch rate.  [default: 1 deg/s]", ("rate",)),
    "range_step": (
        "deg",
        "How much wider the pitch range is, at either end; negative: narrower.  [default: 1 deg]",
        ("lower", "upper"),
    ),
    "mu_step": ("", "Change of mu, a number or a share such as -10%.  [default: -10%]", ("mu",)),
    "loss_step": ("%", "Change of the allowed loss of torque.  [default: 0.5%]", ("loss",)),
    "torque_step": (
        "N m",
        "Change of the mean torque that is held, a number [N m] or a share.  [default: 0.5%]",
        ("torque",),
    ),
    "shear_step": ("", "Change of the shear exponent.  [default: 0.02]", ("shear",)),
}
_METAVARS = {"deg/s": "DEG/S", "deg": "DEG", "%": "SHARE", "N m": "NM|SHARE"}


def step_options(function: Any) -> Any:
    """Steps of the parameters, and how many of them are drawn."""
    made = [
        click.option(
            "--" + key.replace("_", "-"), type=Option("x", _step(unit)),
            metavar=_METAVARS.get(unit, "X"), help=text,
        )
        for key, (unit, text, _) in _STEPS.items()
    ]  # fmt: skip
    drawn = click.option(
        "--steps", type=Option("n", whole(1, 100)), metavar="N",
        help="Solve the design again for N steps to either side as well, and draw them.",
    )  # fmt: skip
    return section("Changes", *made, drawn)(function)


def _step(unit: str) -> Any:
    """Parser of a change: ``1``, ``1deg/s``, ``-10%``; the number and whether it is a share."""

    def parse(name: str, text: str) -> tuple[float, bool]:
        body = text.strip()
        share = body.endswith("%") and unit in ("", "%", "N m")
        for ending in ("%",) if share else (unit, unit.replace(" ", "")):
            body = body.removesuffix(ending).strip() if ending else body
        try:
            value = float(body)
        except ValueError:
            value = math.nan
        if not math.isfinite(value) or value == 0.0:
            raise InputError(
                f"{name}: got {text!r}, expected a number other than 0"
                + (f" [{unit}]" if unit else "")
            )
        return (value / 100.0, True) if share else (value, False)

    return parse


def _steps(point: DesignPoint, options: Mapping[str, Any]) -> dict[str, float]:
    """Steps that were given, by parameter in SI and radians."""
    found = {}
    for key, (unit, _, names) in _STEPS.items():
        if options[key] is None:
            continue
        value, share = options[key]
        for name in names:
            if len(names) == 1 or name in point.parameters:
                point.require(name)
            else:
                continue
            step = math.radians(value) if unit.startswith("deg") else value
            if share and name in ("mu", "torque"):
                step *= point.value(name)
            found[name] = -step if name == "lower" else step
        if not any(name in found for name in names):
            point.require(names[0])
    return found


def brief_sensitivity(solved: Solved) -> dict[str, Any]:
    """Estimates of a design that was just found, from its multipliers alone.

    Without rows and with a message where there are none.
    """
    from pitchopt.studies.sensitivity import DesignPoint, design_sensitivity, sensitivity_record

    try:
        return sensitivity_record(design_sensitivity(_point(solved, DesignPoint)))
    except PitchoptError as error:
        return {"rows": [], "message": " ".join(str(error).split())}


def _point(solved: Solved, kind: type[DesignPoint]) -> DesignPoint:
    from pitchopt.design import Compared

    found = Compared(design=solved.design, constant=solved.constant, power_max=solved.power_max)
    return kind(case=solved.case, task=solved.task, found=found)


def run_design(options: dict[str, Any]) -> int:
    """The work of ``pitchopt sensitivity --problem design``."""
    began = time.perf_counter()
    from pitchopt.cli import output
    from pitchopt.cli.progress import Progress
    from pitchopt.exports import design_document
    from pitchopt.studies.sensitivity import (
        DesignPoint,
        curve_records,
        design_curve,
        design_sensitivity,
        sensitivity_csv,
        sensitivity_record,
    )

    case = build_case(options)
    if all(options[name] is None for name in _GOALS):
        options["max_power_loss"] = DEFAULT_LOSS
    _check_goal(options)
    folder = output.out_folder(options["out"], "sensitivity", case.name, as_json=options["as_json"])
    solved = solve(case, options)
    if not solved.design.status.ok:
        raise ComputationError(
            f"design: {solved.design.status.value}: {' '.join(solved.design.message.split())}; no "
            "multipliers to estimate from"
        )
    point = _point(solved, DesignPoint)
    steps = _steps(point, options)
    search = {"starts": options["starts"], "seed": options["seed"]}
    with Progress() as progress:
        result = design_sensitivity(point, steps, truth=True, progress=progress, **search)
    curves = []
    if options["steps"] is not None:
        for row in result.rows:
            with Progress() as progress:
                curve = design_curve(
                    point, row.parameter, row.step, options["steps"],
                    progress=progress, **search,
                )  # fmt: skip
            curves.append(curve)
    solved.settings["sensitivity"] = {
        "steps": {row.parameter: row.step for row in result.rows},
        "drawn": options["steps"],
    }
    record = sensitivity_record(result)
    drawn = curve_records(curves)
    document = design_document(
        case.name,
        solved.settings,
        solved.design,
        constant=solved.constant,
        power_max=solved.power_max,
        seconds=0.0,
        model=case.model_report(solved.task.model, solved.constant),
        hub_height=case.hub_height,
    )
    document |= {"problem": "design", "sensitivity": record, "curves": drawn}

    def files() -> dict[str, bytes | str]:
        from pitchopt.exports.records import records_csv

        made: dict[str, bytes | str] = {"sensitivity.csv": sensitivity_csv(record)}
        if drawn:
            made["curves.csv"] = records_csv(drawn)
        if not options["no_plots"]:
            from pitchopt.plotting import png, sensitivity_figure

            title = f"{case.name}, {document['design']['label']}"
            made["sensitivity.png"] = png(sensitivity_figure(record, title=title))
            if drawn:
                made["curves.png"] = png(sensitivity_figure(record, drawn, title=title))
        return made

    output.deliver(
        document, "sensitivity.json", folder=folder, files=files, began=began,
        as_json=options["as_json"], show=lambda shown: _print(solved, shown),
    )  # fmt: skip
    return 0


def _check_goal(options: Mapping[str, Any]) -> None:
    """Steps of goals that the design has not, before anything is solved."""
    for key, goal in zip(("mu_step", "loss_step", "torque_step"), _GOALS, strict=True):
        if options[key] is not None and options[goal] is None:
            flag, wanted = ("--" + name.replace("_", "-") for name in (key, goal))
            raise InputError(f"{flag}: got a step without {wanted}, expected both or neither")


def _print(solved: Solved, document: Mapping[str, Any]) -> None:
    from pitchopt.cli.output import case_line
    from pitchopt.cli.sensitivity_tables import sensitivity_lines

    design = document["design"]
    click.echo(case_line(solved.case, solved.settings) + "\n")
    click.echo(
        f"design {design['label']}: mean torque {1e-3 * design['mean_torque']:.5g} kN m, "
        f"weighted RMS {1e-3 * design['rms_weighted']:.4g} kN m, {design['status']}\n"
    )
    for line in sensitivity_lines(document["sensitivity"]):
        click.echo(line)
    click.echo("")
