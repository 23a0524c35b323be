"""``pitchopt simulate``: a dynamic turbine in steady or turbulent wind."""

from __future__ import annotations

import math
import os
import time
from typing import TYPE_CHECKING, Any

import click

from pitchopt.cli.completing import CONTROLLERS, TURBULENCE
from pitchopt.cli.help import COMPUTATION, OUTPUT, Command, section
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
    numbers,
    positive,
    seeds,
    shape,
    spacing,
    whole,
    words,
)
from pitchopt.errors import InputError

if TYPE_CHECKING:
    from pitchopt.sim import DynamicTurbine
    from pitchopt.studies.simulation import SimulationResult, SimulationSettings

__all__ = ["command"]

FORMATS = ("csv", "npz", "outb")
DEFAULT_TURBINE = "nrel-5mw"

_EPILOG = """\b
Examples:
  pitchopt simulate --wind-speed 12 --turbulence B --seeds 6
  pitchopt simulate --wind-speed 4,8,12,16,20,24 --seeds 6 --out campaign
  pitchopt simulate --turbulence none --wind-speed 9 --duration 120 --controller tuned
  pitchopt simulate --turbine iea-15-240 --controller ipc --channels GenPwr,RootMyc1 --json
  pitchopt simulate --turbulence my-wind.bts --format outb
  pitchopt simulate --turbulence box_u.bin --box-shape 4096,32,32 --box-spacing 2,5,5
  pitchopt simulate --controller my-controller.toml --pitch-lag 0.3

\b
Files: simulation.json, statistics.csv (a row for each run and channel), overview.png,
and one file a run and format, such as u12_s1.csv. Names and units of channels are
OpenFAST's. Equivalent loads are of 1 Hz, with slope 10 for blade roots and 4 elsewhere.

\b
A controller file has a base (baseline, tuned or lqr) and sections that change it:
  base = "tuned"
  [torque]         factor, constant_power
  [pitch]          frequency, damping; or proportional, integral, linear, quadratic,
                   reference_rpm
  [lqr]            tower_velocity
  [minimum_pitch]  wind_speed = [8, 11, 14], pitch_deg = [0, 3, 0]
  [individual]     gain, harmonics, offset_deg, amplitude_deg, fade_from_deg,
                   fade_to_deg, fade_time
  [feedforward]    profile (a file of pitchopt design or tradeoff), point, harmonics;
                   or cosine_deg, sine_deg; time_constant, amplitude, wind_speed, scale

\b
The first run on a machine compiles the time loop, which takes about a minute. A run
that diverges has its status and time in tables and JSON, and the exit status is 1.

\b
See also: tune (find a controller's gains), learn --plant dynamic, turbines."""


_TURBULENCE = (*TURBULENCE, "none")
_FREEDOMS = (
    *("rotor-speed", "tower-fore-aft", "tower-side-side", "blade-flap", "blade-edge"),
    *("shaft-torsion", "none"),
)


def _wind_options(function: Any) -> Any:
    """Wind and length of the runs."""
    function = section(
        "Boxes of turbulence",
        click.option(
            "--box-points", type=Option("n", whole(2, 50)), metavar="N", default="13",
            show_default=True, help="Grid points of a generated (Kaimal) box across and upward, at "
            "most 50; its time grows steeply.",
        ),
        click.option(
            "--box-shape", type=Option("n", shape), metavar="NX,NY,NZ",
            help="Points of a HAWC2 box.",
        ),
        click.option(
            "--box-spacing", type=Option("m", spacing), metavar="DX,DY,DZ",
            help="Their distances [m].",
        ),
    )(function)  # fmt: skip
    return section(
        "Wind and time",
        click.option(
            "--wind-speed", "wind_speeds", type=Option("m/s", numbers), metavar="M/S,...",
            multiple=True, help="Mean wind speed at the hub, several as 8,12,16.  "
            "[default: 12, or that of the .bts file]",
        ),
        click.option(
            "--turbulence", type=Option("kind", names=_TURBULENCE, endings=(".bts", ".bin")),
            metavar="A+|A|B|C|none|FILE", default="B", show_default=True,
            help="Class of IEC 61400-1, an intensity such as 0.14, steady wind, a TurbSim file "
            "(.bts) or a HAWC2 box (FILE_u.bin).",
        ),
        click.option(
            "--seeds", type=Option("seeds", seeds), metavar="N|A:B|A,B,...",
            help="Seeds of the turbulence: 1 to N, A to B, or these.  [default: 1]",
        ),
        click.option(
            "--duration", type=Option("s", positive(1e5, "s")), metavar="S", default="600",
            show_default=True, help="Time that statistics are taken over.",
        ),
        click.option(
            "--skip", type=Option("s", between(0, 1e5, "s")), metavar="S", default="60",
            show_default=True, help="Start-up before that, simulated and left out.",
        ),
        click.option(
            "--shear", type=Option("x", between(-1, 1, "-")), metavar="X",
            help="Exponent of the vertical shear.  [default: 0.2, or the .bts file's own]",
        ),
        click.option("--no-tower-shadow", is_flag=True, help="Leave out the tower's shadow."),
        click.option(
            "--weibull-mean", type=Option("m/s", positive(50, "m/s")), metavar="M/S",
            help="Mean wind speed of the site, for sums over several wind speeds.  [default: "
            "that of the turbine's class]",
        ),
    )(function)  # fmt: skip


def _turbine_options(function: Any) -> Any:
    """Turbine, controller and model."""
    function = section(
        COMPUTATION,
        click.option(
            "--step", type=Option("s", positive(0.2, "s")), metavar="S", default="0.025",
            show_default=True, help="Step of the time loop.",
        ),
        click.option(
            "--workers", type=Option("n", whole(1, 1024)), metavar="N",
            help="Threads.  [default: one a processor]",
        ),
    )(function)  # fmt: skip
    inflow, pitch_lag, inertia = model_options(pitch_lag="0", own_lag="0")
    return section(
        "Turbine and controller",
        turbine_option(DEFAULT_TURBINE),
        click.option(
            "--controller", type=Option("name", names=CONTROLLERS, endings=(".toml",)),
            metavar="NAME|FILE.toml", default="baseline", show_default=True,
            help="baseline (published for the NREL 5 MW, tuned for others), tuned, lqr (linear "
            "quadratic, above rated), ipc (baseline and individual pitch), or a file, see below.",
        ),
        inflow,
        click.option(
            "--freedoms", type=Option("names", words, names=_FREEDOMS, several=True),
            metavar="A,B,...",
            help="Degrees of freedom that move: rotor-speed, tower-fore-aft, tower-side-side, "
            "blade-flap, blade-edge, shaft-torsion, or none.  [default: all but the last]",
        ),
        pitch_lag,
        click.option(
            "--torque-lag", type=Option("s", between(0, 10, "s")), metavar="S", default="0",
            show_default=True, help="Time constant of the generator torque.",
        ),
        click.option(
            "--yaw-deg", type=Option("deg", between(-60, 60, "deg")), metavar="DEG",
            default="0", show_default=True, help="Nacelle yaw, positive to the left.",
        ),
        inertia,
    )(function)  # fmt: skip


@click.command("simulate", cls=Command, epilog=_EPILOG)
@_wind_options
@_turbine_options
@cache_options
@section(
    OUTPUT,
    click.option(
        "--channels",
        type=Option("names", words),
        metavar="A,B,...",
        help="Channels of tables and files, or all.  [default: speeds, power, pitch, main loads]",
    ),
    click.option(
        "--format",
        "formats",
        type=Option("names", words, names=FORMATS, several=True),
        metavar="csv|npz|outb",
        multiple=True,
        default=("csv",),
        help="Of the time series, several as csv,outb.  [default: csv]",
    ),
    click.option(
        "--interval",
        type=Option("s", positive(10, "s")),
        metavar="S",
        default="0.05",
        show_default=True,
        help="Between two instants of the time series.",
    ),
)
@result_options
def command(**options: Any) -> int:
    """The moving turbine in steady wind or turbulence.

    Runs a turbine whose blades, tower and rotor speed move, under a controller, and prints means,
    extremes and damage-equivalent loads (the constant cycle that tires a material as much) over all
    runs of a wind speed.
    """
    began = time.perf_counter()
    from pitchopt.cli import output
    from pitchopt.cli.progress import Progress
    from pitchopt.cli.simulate_tables import print_simulation
    from pitchopt.sim import Operation
    from pitchopt.studies.simulation import (
        load_controller,
        run_simulations,
        simulation_document,
    )

    formats = tuple(dict.fromkeys(word for group in options["formats"] for word in group))
    for word in formats:
        if word not in FORMATS:
            raise InputError(f"--format: got {word!r}, expected one of {', '.join(FORMATS)}")
    settings = _settings(options)
    dynamic = _dynamic(options)
    as_json = options["as_json"]
    folder = output.out_folder(options["out"], "simulate", dynamic.turbine.name, as_json=as_json)
    cache = box_cache(options)
    operation = Operation(dynamic)
    with Progress(compiled="the time loop") as progress:
        controller = load_controller(options["controller"], operation)
        result = run_simulations(
            dynamic,
            controller,
            settings,
            name=options["controller"],
            operation=operation,
            cache=cache,
            workers=options["workers"] or os.cpu_count() or 1,
            progress=progress,
        )
    document = simulation_document(
        result,
        {
            "inflow": dynamic.inflow,
            "freedoms": list(dynamic.freedoms),
            "pitch_lag": options["pitch_lag"],
            "torque_lag": options["torque_lag"],
            "yaw_deg": options["yaw_deg"],
            "generator_inertia": dynamic.generator_inertia,
        },
    )
    output.deliver(
        document,
        "simulation.json",
        folder=folder,
        files=lambda: _files(result, document, formats, plots=not options["no_plots"]),
        began=began,
        as_json=as_json,
        show=print_simulation,
    )
    for run in result.runs:
        if run.status == "diverged":
            seed = "" if run.seed is None else f", seed {run.seed}"
            click.echo(f"pitchopt: {run.wind_speed:g} m/s{seed}: {run.message}", err=True)
    return 1 if result.diverged else 0


def _settings(options: dict[str, Any]) -> SimulationSettings:
    from pitchopt.studies.simulation import SimulationSettings

    speeds = sorted(speed for group in options["wind_speeds"] for speed in group)
    names = (
        *("turbulence", "seeds", "duration", "skip", "interval", "shear", "box_points"),
        *("box_shape", "box_spacing", "channels", "weibull_mean"),
    )
    return SimulationSettings(
        wind_speeds=tuple(speeds) or None,
        tower_shadow=not options["no_tower_shadow"],
        **{name: options[name] for name in names},
    )


def _dynamic(options: dict[str, Any]) -> DynamicTurbine:
    from pitchopt.control import GeneratorLag, PitchActuator
    from pitchopt.sim import DynamicTurbine
    from pitchopt.turbines import load_turbine

    turbine = load_turbine(options["turbine"])
    given: dict[str, Any] = {
        "generator_lag": GeneratorLag(time_constant=options["torque_lag"]),
        "generator_inertia": options["generator_inertia"],
        "yaw": math.radians(options["yaw_deg"]),
    }
    if options["freedoms"] is not None:
        given["freedoms"] = () if options["freedoms"] == ("none",) else options["freedoms"]
    if options["pitch_lag"] > 0.0:
        low, high = turbine.pitch_range
        given["actuator"] = PitchActuator(
            lowest=low, highest=high, rate=turbine.pitch_rate, time_constant=options["pitch_lag"]
        )
    return DynamicTurbine(turbine=turbine, inflow=options["inflow"], step=options["step"], **given)


def _files(
    result: SimulationResult,
    document: dict[str, Any],
    formats: tuple[str, ...],
    *,
    plots: bool,
) -> dict[str, bytes | str]:
    from pitchopt.exports import outb_bytes, series_csv, series_npz
    from pitchopt.studies.simulation import statistics_csv

    files: dict[str, bytes | str] = {"statistics.csv": statistics_csv(document)}
    for run in result.runs:
        stem = f"u{run.wind_speed:g}" + ("" if run.seed is None else f"_s{run.seed}")
        if "csv" in formats:
            files[f"{stem}.csv"] = series_csv(run.series)
        if "npz" in formats:
            files[f"{stem}.npz"] = series_npz(run.series)
        if "outb" in formats and run.series.time.size > 1:
            text = f"pitchopt: {result.turbine}, {run.turbulence}, {run.wind_speed:g} m/s"
            files[f"{stem}.outb"] = outb_bytes(
                run.series, description=text.encode("ascii", errors="replace").decode("ascii")
            )
    if plots:
        from pitchopt.plotting import png, simulation_figure

        files["overview.png"] = png(simulation_figure(result, title=_title(result)))
    return files


def _title(result: SimulationResult) -> str:
    kind = result.runs[0].turbulence
    wind = "steady wind" if kind == "none" else kind
    return f"{result.turbine}, {wind}, controller {result.controller}"
