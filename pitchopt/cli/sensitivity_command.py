"""``pitchopt sensitivity``: what a changed parameter would do to an optimum, beside the truth."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import click

from pitchopt.cli.design_command import goal_options
from pitchopt.cli.help import Command, section
from pitchopt.cli.options import case_options, result_options, search_options
from pitchopt.cli.sensitivity_design import run_design, step_options
from pitchopt.cli.sensitivity_quadratic import run_quadratic

__all__ = ["command"]

_EPILOG = """\b
Examples:
  pitchopt sensitivity --case biegel2011 --mu 3
  pitchopt sensitivity --case nrel-5mw --wind-speed 15 --mu 3 --rate-step 2deg/s
  pitchopt sensitivity --max-power-loss 3% --shear-step -0.05 --out what-if
  pitchopt sensitivity --case nrel-5mw --wind-speed 9 --steps 4 --out range --json
  pitchopt sensitivity --problem quadratic --out programs

\b
Files: sensitivity.json, sensitivity.csv, sensitivity.png, and with --steps
curves.csv, curves.png.

\b
Estimates come from the multipliers of the last convex subproblem: first order
from derivatives, high order from constraints evaluated again, the profile held.
"re-solved" is the best of local solves of the changed design.

\b
See also: design, which prints the estimates alone; docs/sensitivity.md."""

_PROBLEMS: Mapping[str, Callable[[dict[str, Any]], int]] = {
    "design": run_design,
    "quadratic": run_quadratic,
}


@click.command("sensitivity", cls=Command, epilog=_EPILOG)
@section(
    "Problem",
    click.option(
        "--problem",
        type=click.Choice(list(_PROBLEMS)),
        default="design",
        show_default=True,
        help="What was optimised: a pitch design, or the small quadratic programs of the paper, "
        "which take --out, --json and --no-plots alone.",
    ),
)
@goal_options
@step_options
@case_options
@search_options
@result_options
def command(**options: Any) -> int:
    """What one more degree a second, a wider range, a lower price or another shear would buy.

    Solves one design, estimates from its multipliers (the prices of its limits) what each change
    would gain, and prints that beside the design solved again. Without a goal the design is that of
    least weighted RMS for 3 % of torque lost.
    """
    return _PROBLEMS[options.pop("problem")](options)
