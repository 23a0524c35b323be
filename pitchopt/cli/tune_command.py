"""``pitchopt tune``: controllers tuned by simulation."""

from __future__ import annotations

import os
import time
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from pitchopt.cli.completing import METHODS, PROBLEMS, TURBULENCE
from pitchopt.cli.help import COMPUTATION, Command, section
from pitchopt.cli.options import (
    box_cache,
    cache_options,
    model_options,
    result_options,
    turbine_option,
)
from pitchopt.cli.values import (
    Option,
    between,
    bounds,
    numbers,
    positive,
    seeds,
    signed_numbers,
    tuner_option,
    whole,
    words,
)
from pitchopt.errors import InputError

if TYPE_CHECKING:
    from pitchopt.studies.tuning import Task

__all__ = ["command"]

DEFAULT_TURBINE = "nrel-5mw"

_EPILOG = """\b
Problems:
  torque-gain       factor on the torque gain below rated, for mean power
  speed-regulator   frequency and damping of the speed loop, for a load within a speed limit
  minimum-pitch     lowest pitch over wind speed, for peak loads against power
  individual-pitch  gains and azimuth offsets at 1P and 2P, for blade fatigue

\b
Methods: zoo (zeroth-order), bayes (Bayesian), grid, random, lhs (Latin hypercube), sobol,
spsa, nelder-mead, cobyla, cma-es (needs the package cma). Several problems or methods,
separated by commas, give one table of all. Their settings are given as --option, such as
--option stages=12.

\b
Examples:
  pitchopt tune --problem torque-gain
  pitchopt tune --problem speed-regulator --turbulence A --method zoo --option stages=12
  pitchopt tune --problem individual-pitch --method bayes --wind-speed 7 --out ipc-7
  pitchopt tune --problem minimum-pitch --kappa 0.003,0.01,0.03
  pitchopt tune --problem torque-gain,speed-regulator --method zoo,bayes,grid --check-seeds 6

\b
Files: tuning.json, evaluations.csv, pictures, of individual-pitch controller.toml for
pitchopt simulate and export, and the journal of each study, *.sqlite. A
study that was stopped goes on from its journal when the same command is given again.

\b
See also: simulate (run the tuned controller from a file), turbines."""


def _study_options(function: Any) -> Any:
    """What is tuned, by what."""
    return section(
        "What is tuned, by what",
        click.option(
            "--problem", "problems", type=Option("names", words, names=PROBLEMS, several=True),
            metavar="A,B,...", required=True, help="What to tune, see below.",
        ),
        click.option(
            "--method", "methods", type=Option("names", words, names=METHODS, several=True),
            metavar="A,B,...", default="zoo", show_default=True, help="Tuners, see below.",
        ),
        click.option(
            "--evaluations", type=Option("n", whole(1, 1_000_000)), metavar="N",
            help="At most so many sets of parameters are simulated.  [default: the tuner's own "
            "end, or 25 a parameter]",
        ),
        click.option(
            "--start", type=Option("x", signed_numbers), metavar="X,...",
            help="Point to begin with, in SI units.",
        ),
        click.option(
            "--bounds", "bounds", type=Option("b", bounds), metavar="NAME=LOW:HIGH",
            multiple=True, help="Of a parameter, in SI units; may be repeated.",
        ),
        click.option(
            "--option", "tuner_options", type=Option("o", tuner_option), metavar="NAME=VALUE",
            multiple=True, help="Setting of the tuner, such as samples=4; may be repeated.",
        ),
        click.option(
            "--seed", type=Option("n", whole(0, 2**31)), metavar="N", default="0",
            show_default=True, help="Of the tuner.",
        ),
        click.option(
            "--check-seeds", type=Option("n", whole(1, 1000)), metavar="N",
            help="Judge start and best again in as many winds that no tuner saw.",
        ),
        click.option(
            "--load", type=click.Choice(["tower", "blade"]),
            help="Of speed-regulator: tower-base fatigue or largest flapwise moment.  "
            "[default: tower]",
        ),
        click.option(
            "--kappa", type=Option("x", numbers), metavar="X,...",
            help="Of minimum-pitch: weight of the load; several for a family.  [default: 0.01]",
        ),
        click.option(
            "--journal", type=Option("file", endings=(".sqlite",)), metavar="FILE|DIR",
            help="Where studies are kept and taken up: a file for one, else a folder that is "
            "there; each breakpoint of minimum-pitch has a file of its own beside it.  "
            "[default: in the folder of --out; none with --json without --out]",
        ),
    )(function)  # fmt: skip


def _plant_options(function: Any) -> Any:
    """Turbine and winds of the simulations."""
    function = section(
        COMPUTATION,
        click.option(
            "--parallel", type=Option("n", whole(1, 1024)), metavar="N", default="1",
            show_default=True, help="Candidates evaluated side by side.",
        ),
        click.option(
            "--workers", type=Option("n", whole(1, 1024)), metavar="N",
            help="Threads of one evaluation.  [default: one a processor]",
        ),
        click.option(
            "--timeout", type=Option("s", positive(1e6, "s")), metavar="S",
            help="Longest time of one evaluation.  [default: none]",
        ),
    )(function)  # fmt: skip
    return section(
        "Turbine and winds of an evaluation",
        turbine_option(DEFAULT_TURBINE),
        click.option(
            "--wind-speed", "wind_speeds", type=Option("m/s", numbers), metavar="M/S,...",
            multiple=True, help="Mean wind speeds at the hub.  [default: the problem's]",
        ),
        click.option(
            "--turbulence", type=Option("kind", names=TURBULENCE), metavar="A+|A|B|C|TI",
            help="Class of IEC 61400-1 or an intensity such as 0.14.  [default: the problem's]",
        ),
        click.option(
            "--seeds", type=Option("seeds", seeds), metavar="N|A:B|A,B,...",
            help="Of the turbulence, for all candidates alike: 1 to N, A to B, or these.  "
            "[default: the problem's]",
        ),
        click.option(
            "--duration", type=Option("s", positive(1e5, "s")), metavar="S", default="600",
            show_default=True, help="Time of each simulation that counts.",
        ),
        click.option(
            "--skip", type=Option("s", between(0, 1e5, "s")), metavar="S", default="60",
            show_default=True, help="Start-up before that, left out.",
        ),
        *model_options(pitch_lag="0.4 for individual-pitch, else 0"),
    )(function)  # fmt: skip


@click.command("tune", cls=Command, epilog=_EPILOG)
@_study_options
@_plant_options
@cache_options
@result_options
def command(**options: Any) -> int:
    """Controllers tuned by simulation.

    Changes parameters of a controller, simulates the turbine in turbulence with each set and keeps
    what costs least: by the zeroth-order tuner (random directions, shrinking steps), the Bayesian
    one (a Gaussian process over the parameters) or one to compare them with. Prints start and best,
    what was spent, and with --check-seeds how they do in winds that no tuner saw.
    """
    began = time.perf_counter()
    for library in ("OPENBLAS", "OMP", "MKL"):  # so that points do not depend on the processors
        os.environ.setdefault(f"{library}_NUM_THREADS", "1")
    from pitchopt.cli import output
    from pitchopt.cli.progress import Progress
    from pitchopt.cli.tune_tables import print_tuning
    from pitchopt.studies.tuning import comparison_document, make_task

    tasks = [
        (task, method)
        for name in dict.fromkeys(options["problems"])
        for task in [make_task(name, options["turbine"], **_task_settings(options))]
        for method in dict.fromkeys(options["methods"])
    ]
    for task, method in tasks:
        task.check(method, **_tuner_settings(options))
    as_json = options["as_json"]
    name = options["turbine"] if len(tasks) > 1 else f"{tasks[0][0].name}-{options['turbine']}"
    folder = output.out_folder(options["out"], "tune", Path(name).stem, as_json=as_json)
    journals = _journals(options["journal"], folder, many=len(tasks) > 1)
    documents: list[dict[str, Any]] = []
    figures: dict[str, Callable[[], bytes]] = {}
    controllers: dict[str, str] = {}
    with Progress(compiled="the time loop") as progress:
        for place, (task, method) in enumerate(tasks, start=1):
            label = f"{place}/{len(tasks)} {method}" if len(tasks) > 1 else method

            def show(done: int, total: int, _: str, label: str = label) -> None:
                progress(done, total, label)

            start = time.perf_counter()
            done = task.tune(
                method,
                journal=journals(task, method),
                progress=show,
                **_tuner_settings(options),
            )
            found = done.document(check_seeds=options["check_seeds"])
            documents.append({**found, "seconds": time.perf_counter() - start})
            stem = f"{task.name}-{method}-" if len(tasks) > 1 else ""
            controllers.update({f"{stem}{key}": text for key, text in done.controllers().items()})
            if folder is not None and not options["no_plots"]:
                figures.update({f"{stem}{key}": make for key, make in done.figures().items()})
    document = documents[0] if len(documents) == 1 else comparison_document(documents)
    output.deliver(
        document,
        "tuning.json",
        folder=folder,
        files=lambda: _files(documents, figures) | controllers,
        began=began,
        as_json=as_json,
        show=print_tuning,
    )
    return 0


def _task_settings(options: Mapping[str, Any]) -> dict[str, Any]:
    speeds = sorted(speed for group in options["wind_speeds"] for speed in group)
    names = (
        *("turbulence", "seeds", "duration", "skip", "load", "kappa", "inflow", "pitch_lag"),
        *("generator_inertia", "start"),
    )
    return {
        **{name: options[name] for name in names},
        "wind_speeds": tuple(speeds) or None,
        "bounds": _by_name("--bounds", options["bounds"]),
        "workers": options["workers"] or os.cpu_count() or 1,
        "cache": box_cache(options),
    }


def _tuner_settings(options: Mapping[str, Any]) -> dict[str, Any]:
    return {
        "evaluations": options["evaluations"],
        "seed": options["seed"],
        "options": _by_name("--option", options["tuner_options"]),
        "parallel": options["parallel"],
        "timeout": options["timeout"],
    }


def _by_name(option: str, pairs: Sequence[tuple[str, Any]]) -> dict[str, Any]:
    names = [name for name, _ in pairs]
    for name in names:
        if names.count(name) > 1:
            raise InputError(f"{option}: got {name} twice, expected each name once")
    return dict(pairs)


def _journals(
    given: str | None, folder: Path | None, *, many: bool
) -> Callable[[Task, str], Path | None]:
    """Where the study of a task and a method is kept."""
    if given is None and folder is None:
        return lambda task, method: None  # noqa: ARG005
    if given is not None and not many and not Path(given).is_dir() and given[-1:] != os.sep:
        return lambda task, method: Path(given)  # noqa: ARG005
    place = Path(given) if given is not None else folder
    assert place is not None
    if given is not None and not place.is_dir():
        raise InputError(
            f"--journal: got {given!r}, expected a folder that is there"
            + (", for several studies" if many else "")
        )
    place.mkdir(parents=True, exist_ok=True)
    return lambda task, method: place / f"{task.name}-{method}.sqlite"


def _files(
    documents: list[dict[str, Any]], figures: Mapping[str, Callable[[], bytes]]
) -> dict[str, bytes | str]:
    from pitchopt.studies.tuning import evaluations_csv

    tables = {
        "evaluations.csv"
        if len(documents) == 1
        else f"{d['problem']}-{d['method']}-evaluations.csv": evaluations_csv(d)
        for d in documents
    }
    return {**tables, **{name: make() for name, make in figures.items()}}
