"""``pitchopt tower``: what designing a tower together with its controller would gain."""

from __future__ import annotations

import os
import time
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from pitchopt.cli.completing import TURBULENCE
from pitchopt.cli.help import COMPUTATION, Command, section
from pitchopt.cli.options import box_cache, cache_options, result_options, turbine_option
from pitchopt.cli.values import FOLDER, Option, between, numbers, positive, seeds, whole

if TYPE_CHECKING:
    from pitchopt.cli.progress import Progress
    from pitchopt.studies.tower import TowerStudySettings
    from pitchopt.turbines import Turbine

__all__ = ["command"]

_EPILOG = """\b
For a tower kept clear of 1P (standard) and one that is not (soft-soft): the lightest tower for
the controller's weight c = 0 and its multipliers, estimates from them of what other weights
would save, towers sized anew beside the estimates, the lowest cost of energy over hub height
at c = 0 and over hub height and c together.

\b
Examples:
  pitchopt tower --out tower
  pitchopt tower --configuration soft-soft --no-true-map
  pitchopt tower --quick --out try

\b
Files: tower.json, tower.csv, damage.png, designs.png, mass.png, cost.png, and the folder sets
with every full set of simulations. A study that was stopped goes on from its sets when the
same command is given again; whole, it takes about half an hour on two cores.

\b
--quick: wind speeds 5, 9, 13, 19 m/s, one seed of 120 s, three weights, three heights, no map
of the true cost. A check that all works; its figures mean little.

\b
See also: simulate --controller lqr, sensitivity (estimates for a pitch design)."""

_QUICK_LOADS = {
    "wind_speeds": (5.0, 9.0, 13.0, 19.0),
    "seeds": (1,),
    "duration": 120.0,
    "axes": 4,
    "box_points": 9,
}
_QUICK = {
    "weights": (0.0, 0.03, 0.3),
    "height_factors": (0.9, 1.0, 1.1),
    "threshold": 0.01,
    "true_map": False,
}


def _loads_options(function: Any) -> Any:
    """Turbine, winds and site."""
    function = section(
        COMPUTATION,
        click.option(
            "--sets", type=FOLDER, metavar="DIR",
            help="Where sets of simulations are kept and taken up.  [default: sets in the folder "
            "of --out; none with --json without --out]",
        ),
        click.option(
            "--workers", type=Option("n", whole(1, 1024)), metavar="N",
            help="Threads of a set of simulations.  [default: one a processor]",
        ),
    )(function)  # fmt: skip
    return section(
        "Turbine, winds and site",
        turbine_option("iea-3.4-130"),
        click.option(
            "--turbulence", type=Option("kind", names=TURBULENCE), metavar="A+|A|B|C|TI",
            default="A", show_default=True, help="Class of IEC 61400-1 or an intensity.",
        ),
        click.option(
            "--wind-speeds", type=Option("m/s", numbers), metavar="M/S,...",
            help="Mean wind speeds at the hub.  [default: 3 to 25 by 2]",
        ),
        click.option(
            "--seeds", type=Option("seeds", seeds), metavar="N|A:B|A,B,...",
            help="Of the turbulence at each of them.  [default: 6]",
        ),
        click.option(
            "--duration", type=Option("s", positive(1e5, "s")), metavar="S",
            help="Of each simulation, the first 30 s of it left out.  [default: 600]",
        ),
        click.option(
            "--mean-wind-speed", type=Option("m/s", positive(50, "m/s")), metavar="M/S",
            default="7.5", show_default=True, help="Of the site, at the turbine's hub height.",
        ),
        click.option(
            "--lifetime", type=Option("years", positive(200, "years")), metavar="YEARS",
            default="20", show_default=True, help="Over which the fatigue damage reaches one.",
        ),
    )(function)  # fmt: skip


def _study_options(function: Any) -> Any:
    """Limits of the tower, and what is studied."""
    function = section(
        "Limits of the tower",
        click.option(
            "--frequency-margin", type=Option("x", between(0, 0.9, "-")), metavar="X",
            default="0.15", show_default=True,
            help="Of the standard tower: natural frequencies above 1P / (1 - X).",
        ),
        click.option(
            "--largest-diameter", type=Option("m", positive(50, "m")), metavar="M",
            help="Outer diameter of the tower.  [default: 6, or the turbine's own if larger]",
        ),
        click.option(
            "--top-diameter", type=Option("m", positive(50, "m")), metavar="M",
            help="Least outer diameter at the top.  [default: the turbine's own]",
        ),
        click.option(
            "--slenderness", type=Option("x", positive(1000, "-")), metavar="X",
            default="200", show_default=True, help="Largest diameter over wall.",
        ),
    )(function)  # fmt: skip
    return section(
        "What is studied",
        click.option(
            "--configuration", type=click.Choice(["both", "standard", "soft-soft"]),
            default="both", show_default=True,
            help="Natural frequencies kept clear of the rotor's (1P), or not.",
        ),
        click.option(
            "--weights", type=Option("x", numbers), metavar="X,...",
            help="Weights c of tower-top velocity in the controller [s2/m2], ascending from 0.  "
            "[default: 0,0.03,0.1,0.2,0.3]",
        ),
        click.option(
            "--heights", type=Option("x", numbers), metavar="X,...",
            help="Hub heights over the turbine's own.  [default: 0.9,1,1.1,1.2]",
        ),
        click.option(
            "--threshold", type=Option("x", between(1e-5, 0.01, "-")), metavar="X",
            help="Change of any diameter or wall that calls for new loads, as a share.  "
            "[default: 0.0005]",
        ),
        click.option(
            "--follow-height", is_flag=True,
            help="Let the cost of foundation and installation follow the hub height.",
        ),
        click.option(
            "--no-true-map", is_flag=True, help="Size no tower at every point of the cost map.",
        ),
        click.option(
            "--quick", is_flag=True, help="Small winds and grids, see below.",
        ),
    )(function)  # fmt: skip


@click.command("tower", cls=Command, epilog=_EPILOG)
@_study_options
@_loads_options
@cache_options
@result_options
def command(**options: Any) -> int:
    """What designing a tower together with its controller would gain.

    The controller is a linear quadratic regulator that damps the tower's motion with a weight c:
    less fatigue, so less steel. Prints, beside each other, estimates from one sized tower and its
    multipliers and towers sized anew: mass, and cost of energy over hub height.
    """
    began = time.perf_counter()
    for library in ("OPENBLAS", "OMP", "MKL"):  # so that sizes do not depend on the processors
        os.environ.setdefault(f"{library}_NUM_THREADS", "1")
    from pitchopt.cli import output
    from pitchopt.cli.progress import Progress
    from pitchopt.cli.tower_tables import print_tower
    from pitchopt.studies.tower import (
        LoadSets,
        run_tower_study,
        tower_csv,
        tower_document,
        tower_pictures,
    )
    from pitchopt.turbines import load_turbine

    turbine = load_turbine(options["turbine"])
    settings = _settings(options, turbine)
    as_json = options["as_json"]
    folder = output.out_folder(options["out"], "tower", turbine.name, as_json=as_json)
    kept = options["sets"]
    place = Path(kept) if kept is not None else None if folder is None else folder / "sets"
    with Progress(compiled="the time loop") as progress:
        shown = _Shown(progress, settings)
        sets = LoadSets(
            turbine,
            settings.loads,
            folder=place,
            workers=options["workers"],
            cache=box_cache(options),
            on_run=shown.run,
        )
        study = run_tower_study(sets, settings, on_phase=shown.phase, on_round=shown.round)

    def files() -> dict[str, bytes | str]:
        made: dict[str, bytes | str] = {"tower.csv": tower_csv(study)}
        if not options["no_plots"]:
            made.update({name: draw() for name, draw in tower_pictures(study).items()})
        return made

    output.deliver(
        tower_document(study),
        "tower.json",
        folder=folder,
        files=files,
        began=began,
        as_json=as_json,
        show=print_tower,
    )
    return 0


def _settings(options: Mapping[str, Any], turbine: Turbine) -> TowerStudySettings:
    from pitchopt.studies.tower import (
        CONFIGURATIONS,
        LoadSettings,
        TowerLimits,
        TowerStudySettings,
    )

    quick = options["quick"]
    loads: dict[str, Any] = dict(_QUICK_LOADS) if quick else {}
    for name in ("wind_speeds", "seeds", "duration"):
        if options[name] is not None:
            loads[name] = options[name]
    study: dict[str, Any] = dict(_QUICK) if quick else {}
    if options["no_true_map"]:
        study["true_map"] = False
    for name, key in (
        ("weights", "weights"),
        ("heights", "height_factors"),
        ("threshold", "threshold"),
    ):
        if options[name] is not None:
            study[key] = tuple(options[name]) if key != "threshold" else options[name]
    if "weights" in study and len(study["weights"]) > 1:
        study["step"] = study["weights"][1]
    own = turbine.tower.diameter
    largest = options["largest_diameter"]
    if largest is None:
        largest = max(TowerLimits.largest_diameter, float(own.max()))
    chosen = options["configuration"]
    return TowerStudySettings(
        loads=LoadSettings(
            turbulence=options["turbulence"],
            mean_wind_speed=options["mean_wind_speed"],
            lifetime=options["lifetime"],
            **loads,
        ),
        limits=TowerLimits(
            frequency_margin=options["frequency_margin"],
            largest_diameter=largest,
            top_diameter=options["top_diameter"] or float(own[-1]),
            slenderness=options["slenderness"],
        ),
        configurations=CONFIGURATIONS if chosen == "both" else (chosen,),
        follow_height=options["follow_height"],
        **study,
    )


class _Shown:
    """Progress of a study: runs of the present set, and how many sets there were."""

    def __init__(self, progress: Progress, settings: TowerStudySettings) -> None:
        self._progress = progress
        self._label = ""
        self._phases = 0
        each = 7 if settings.true_map else 6
        self._all = each * len(settings.configurations)

    def phase(self, configuration: str, what: str) -> None:  # noqa: ARG002  the bar is narrow
        """A phase begins."""
        self._phases += 1
        self._label = f"{self._phases}/{self._all} {configuration}"

    def run(self, done: int, total: int) -> None:
        """A run of a set is done."""
        self._progress(done, total, self._label)

    def round(self, *_: Any) -> None:
        """A tower was sized."""
