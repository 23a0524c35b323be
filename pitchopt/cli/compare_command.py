"""``pitchopt compare``: all methods on one turbine in the same winds, side by side."""

from __future__ import annotations

import math
import os
import shlex
import sys
import time
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from pitchopt.cli.completing import COMPARED, TURBULENCE
from pitchopt.cli.help import COMPUTATION, OUTPUT, Command, section
from pitchopt.cli.options import (
    box_cache,
    build_case,
    cache_options,
    result_options,
    turbine_case_options,
)
from pitchopt.cli.values import Given, Option, between, whole, words
from pitchopt.errors import InputError

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from pitchopt.studies.comparison import Comparison, ComparisonSettings

__all__ = ["command"]

DEFAULT_CASE = "nrel-5mw"
DEFAULT_WIND_SPEED = 15.0
REPORT = "report.html"
_QUICK: dict[str, Any] = {
    "seeds": 2,
    "tuning_seeds": 1,
    "evaluations": 12,
    "rotations": 5,
    "averaged": 5,
    "duration": 100.0,
    "skip": 30.0,
}

_EPILOG = """\b
Examples:
  pitchopt compare --quick --report
  pitchopt compare --out compared --report
  pitchopt compare --turbulence none,0.01,0.02,0.05,C,B --methods feed-forward,learned
  pitchopt compare --case iea-15-240 --wind-speed 14 --evaluations 40 --json

\b
Methods, all added to the turbine's baseline controller:
  collective        nothing added; what the others are judged by
  feed-forward      convex profile for the steady wind, with lead for the actuators
  learned           profile learned from hub loads alone, in the wind itself
  ipc-handbook      individual pitch at 1P and 2P, by the handbook's rules
  ipc-grid          its gains and offsets tuned on a grid (81 points and the handbook's)
  ipc-zoo           the same by the zeroth-order tuner
  ipc-bayes         the same by the Bayesian tuner
  feed-forward+ipc  the profile from 2P on, and individual pitch tuned on top of it

\b
Every method has the same turbine, actuators and winds. Tuners have the same start, seeds,
evaluations and cost, the fatigue of the blade roots out of plane. All are judged in
seeds that none has met. Changes are those of the collective controller's loads seed by
seed, with the 95 % confidence interval of their mean.

\b
Files: comparison.json, comparison.csv, changes.png, intensity.png, turns.png, a folder
controllers with files for pitchopt simulate --controller, and with --report a page that
needs no network.
The same command with the same --out goes on where tuning was stopped; other settings
need another --out.

\b
See also: pitchopt tune, pitchopt learn, pitchopt design, pitchopt simulate."""


def _options(function: Any) -> Any:
    """What is compared, and with how much effort."""
    function = section(
        COMPUTATION,
        click.option(
            "--seed", type=Option("n", whole(0, 2**31)), metavar="N", default="0",
            show_default=True, help="Of tuners and of the design's random starts.",
        ),
        click.option(
            "--workers", type=Option("n", whole(1, 1024)), metavar="N",
            help="Threads; results do not depend on them.  [default: one a processor]",
        ),
    )(function)  # fmt: skip
    function = section(
        "Turbine and simulations",
        click.option(
            "--pitch-lag", type=Option("s", between(0, 10, "s")), metavar="S",
            help="Time constant of the pitch actuators.  [default: 0.4]",
        ),
        click.option(
            "--pitch-below-deg", type=Option("deg", between(0, 45, "deg")), metavar="DEG",
            help="How far they reach below the turbine's own range, for all methods alike.  "
            "[default: 10]",
        ),
        click.option(
            "--duration", type=Option("s", between(10, 1e5, "s")), metavar="S",
            help="Time of each simulation that counts.  [default: 600]",
        ),
        click.option(
            "--skip", type=Option("s", between(0, 1e5, "s")), metavar="S",
            help="Start-up before that, left out; in steady wind ten times as long.  [default: 60]",
        ),
    )(function)  # fmt: skip
    return section(
        "What is compared",
        click.option(
            "--turbulence",
            type=Option("names", words, names=("none", *TURBULENCE), several=True),
            metavar="A,B,...", default="none,C,B", show_default=True,
            help="Winds: none, classes of IEC 61400-1, intensities such as 0.05.",
        ),
        click.option(
            "--methods", type=Option("names", words, names=COMPARED, several=True),
            metavar="A,B,...", help="See below.  [default: all]",
        ),
        click.option(
            "--seeds", type=Option("n", whole(1, 1000)), metavar="N",
            help="Boxes of turbulence that methods are judged in.  [default: 12]",
        ),
        click.option(
            "--tuning-seeds", type=Option("n", whole(1, 1000)), metavar="N",
            help="Other boxes, that tuners have.  [default: 3]",
        ),
        click.option(
            "--evaluations", type=Option("n", whole(2, 1_000_000)), metavar="N",
            help="Of each tuner, at most.  [default: 82]",
        ),
        click.option(
            "--rotations", type=Option("n", whole(1, 100_000)), metavar="N",
            help="That the learner learns for.  [default: 20]",
        ),
        click.option(
            "--averaged", type=Option("n", whole(1, 10_000)), metavar="N",
            help="Turns over which it averages loads in turbulence.  [default: 20]",
        ),
        click.option(
            "--quick", is_flag=True,
            help="Two seeds of 100 s, 12 evaluations and short learning where not given: to see "
            "what comes out, not to conclude from.",
        ),
    )(function)  # fmt: skip


_REPORT = click.option(
    "--report",
    metavar="FILE",
    is_flag=False,
    flag_value=REPORT,
    help=f"Write an HTML page as well: {REPORT} in the folder of --out, or this file.",
)


@click.command("compare", cls=Command, epilog=_EPILOG)
@turbine_case_options(DEFAULT_CASE)
@_options
@cache_options
@section(OUTPUT, _REPORT)
@result_options
def command(**options: Any) -> int:
    """All methods on one turbine, one table.

    Compares the collective controller with a designed profile, a learned one, tuned individual
    pitch control, and both together, in a steady sheared wind and in turbulence: power, RMS and
    damage-equivalent loads, pitch travel, what each took and what it had to know.  Says in which
    turbulence a profile planned for the steady wind stops paying.
    """
    began = time.perf_counter()
    for library in ("OPENBLAS", "OMP", "MKL"):  # so that points do not depend on the processors
        os.environ.setdefault(f"{library}_NUM_THREADS", "1")
    from pitchopt.cli import output
    from pitchopt.cli.compare_tables import print_comparison
    from pitchopt.cli.progress import Progress
    from pitchopt.studies.comparison import compare, comparison_document

    settings = _settings(options)
    if options["case"] is None:
        options["case"] = DEFAULT_CASE
        options["wind_speed"] = options["wind_speed"] or Given(DEFAULT_WIND_SPEED)
    case = build_case(options)
    as_json = options["as_json"]
    folder = output.out_folder(options["out"], "compare", case.name, as_json=as_json)
    page = _page(options["report"], folder)
    with Progress(compiled="the time loop") as progress:
        result = compare(
            case,
            settings,
            workers=options["workers"] or os.cpu_count() or 1,
            cache=box_cache(options),
            journals=None if folder is None else folder / "journals",
            progress=progress,
        )
    document = comparison_document(result)
    figures = _figures(result, document) if folder is not None or page is not None else {}
    if page is not None:
        _write(page, document, figures)
    output.deliver(
        document,
        "comparison.json",
        folder=folder,
        files=lambda: _files(result, document, {} if options["no_plots"] else figures),
        began=began,
        as_json=as_json,
        show=print_comparison,
    )
    if page is not None and not as_json:
        click.echo(f"report: {page}")
    asked = [entry for entry in result.entries if entry.method != "collective"]
    return 1 if asked and not any(entry.runs for entry in asked) else 0


def _settings(options: dict[str, Any]) -> ComparisonSettings:
    from pitchopt.studies.comparison import ComparisonSettings

    names = (
        *("methods", "seeds", "tuning_seeds", "evaluations", "rotations", "averaged"),
        *("duration", "skip", "pitch_lag"),
    )
    given = {name: options[name] for name in names if options[name] is not None}
    if options["pitch_below_deg"] is not None:
        given["pitch_below"] = math.radians(options["pitch_below_deg"])
    quick = _QUICK if options["quick"] else {}
    return ComparisonSettings(
        **{**quick, **given}, turbulence=options["turbulence"], seed=options["seed"]
    )


def _page(report: str | None, folder: Path | None) -> Path | None:
    """Where the report goes, seen before the computation; None for none."""
    from pitchopt.exports import check_folder

    if report is None:
        return None
    page = Path(report)
    if report == REPORT and folder is not None:
        page = folder / REPORT
    if page.is_dir() or page.suffix.lower() not in (".html", ".htm"):
        raise InputError(f"--report: got {report!r}, expected a file ending in .html")
    check_folder(page.parent, "--report")
    return page


def _figures(result: Comparison, document: dict[str, Any]) -> dict[str, Figure]:
    from pitchopt.plotting import method_figures

    return method_figures(document, result.excerpts)


def _files(
    result: Comparison, document: dict[str, Any], figures: dict[str, Figure]
) -> dict[str, bytes | str]:
    from pitchopt.plotting import png
    from pitchopt.studies.comparison import comparison_csv, controller_files

    return {
        "comparison.csv": comparison_csv(document),
        **{f"controllers/{name}": text for name, text in controller_files(result).items()},
        **{f"{name}.png": png(figure) for name, figure in figures.items()},
    }


def _write(page: Path, document: dict[str, Any], figures: dict[str, Figure]) -> None:
    from pitchopt.exports import write_whole
    from pitchopt.studies.comparison.report import comparison_report

    line = shlex.join(["pitchopt", *sys.argv[1:]]) if len(sys.argv) > 1 else ""
    write_whole(page, comparison_report(document, figures, command=line))
