"""``pitchopt export``: a profile or a controller for other programs."""

from __future__ import annotations

from typing import Any

import click

from pitchopt.cli.completing import CONTROLLERS
from pitchopt.cli.design_command import goal_options
from pitchopt.cli.help import Command, section
from pitchopt.cli.options import _CASE_OPTIONS, case_options, json_option, search_options
from pitchopt.cli.values import FOLDER, Option, between, numbers, positive, whole
from pitchopt.errors import InputError

__all__ = ["command"]

FORMATS = ("csv", "harmonics", "aerodyn", "rosco", "discon")
_PROFILES = ("csv", "harmonics", "aerodyn", "rosco")
_LED = ("csv", "harmonics", "rosco")

_USED_BY = {
    "step_deg": ("aerodyn", "rosco"),
    "time_step": ("aerodyn", "rosco"),
    "revolutions": ("aerodyn", "rosco"),
    "interpolation": ("aerodyn", "rosco"),
    "initial_azimuth_deg": ("rosco",),
    "keep_harmonics": _LED,
    "actuator_lag": _LED,
    "actuator_frequency": _LED,
    "actuator_damping": _LED,
    "phase_only": _LED,
    "beyond_limits": _LED,
    "discon": ("rosco", "discon"),
    "wind_ramp": ("discon",),
    "only_1p": ("discon",),
    "filter_gain": ("discon",),
    "turbine": ("discon",),
    "pitch_lag": ("discon",),
    "point": _PROFILES,
}

_EPILOG = """\b
Examples:
  pitchopt export demo/profiles.npz --point knee --format csv
  pitchopt export demo/profiles.npz --point loss=3% --format harmonics --out tables
  pitchopt export demo/profiles.npz --point 4 --format aerodyn --revolutions 10
  pitchopt export --case nrel-5mw --wind-speed 15 --mean-torque rated --format aerodyn
  pitchopt export robust/robust.npz --format csv
  pitchopt export table/schedule.npz --point "8 m/s" --format harmonics
  pitchopt export above-rated/profiles.npz --format rosco --actuator-lag 0.3
      --keep-harmonics 4 --discon DISCON.IN
  pitchopt export my-controller.toml --format discon --discon DISCON.IN
  pitchopt export ipc-7/tuning.json --format discon --only-1p

\b
What each format is for, and its files:
csv        a spreadsheet, a lookup table of a controller. profile.csv: azimuth_deg,
           pitch_deg, pitch_rate_deg_s (central difference)
harmonics  a report, a controller that adds sines. harmonics.csv: mean and cos, sin,
           amplitude, phase of every nP [deg];
           pitch = mean + sum of amplitude cos(n azimuth - phase)
aerodyn    a replay without controller. pitch_b1.csv ... for the AeroDyn driver:
           time [s], pitch [rad], rate [rad/s], acceleration [rad/s^2], blade b at
           azimuth + 360 (b-1)/B deg; driver_motion.txt: the lines of the driver's
           input file that use them
rosco      a replay in OpenFAST with ROSCO 2.9 or 2.10 at constant rotor speed.
           pitch_open_loop.dat: time [s], pitch of three blades [rad];
           discon_open_loop.txt: the lines of DISCON.IN that switch it on, and what
           ElastoDyn and ServoDyn need; with --discon a whole DISCON_open_loop.IN
discon     individual pitch control of ROSCO. discon_ipc.txt: its lines of DISCON.IN
           for a controller file, for ipc (see simulate --help), or for tuning.json of
           tune --problem individual-pitch; with --discon a whole DISCON_ipc.IN.
           ROSCO regulates 1P alone; what it has not is refused or named

\b
The rate in the motion files belongs to the interpolation. linear: the slope of
the straight line, at a station the mean of the slopes on both sides, which is
what the design itself uses; acceleration 0. fourier: derivatives of the Fourier
series through the stations, which may leave range and rate between stations.

\b
An actuator that lags moves late and too little. --actuator-lag writes the command
that makes the blade follow the profile, and refuses one beyond range or rate. The
AeroDyn driver prescribes the motion itself, so it needs none; a controller of
pitchopt simulate has its own.

docs/exports.md says more."""


@click.command("export", cls=Command, epilog=_EPILOG)
@click.argument(
    "source",
    required=False,
    type=Option("file", names=CONTROLLERS, endings=(".npz", ".toml", ".json")),
    metavar="[PROFILES.npz|CONTROLLER]",
)
@section(
    "What is written",
    click.option(
        "--format",
        "form",
        type=Option("format", names=FORMATS),
        metavar="|".join(FORMATS),
        help="What to write.  [required]",
    ),
    click.option(
        "--point",
        metavar="NAME",
        help="Profile of the file: INDEX, knee, loss=3%, power_max, constant or a label; in a "
        "file of "
        "robust or schedule the wind's number from 0 or label.  [default: the knee, or the only "
        "one]",
    ),
    click.option(
        "--out",
        type=FOLDER,
        metavar="DIR",
        default=".",
        show_default=True,
        help="Folder for the files.",
    ),
)
@section(
    "Rows of aerodyn and rosco",
    click.option(
        "--step-deg",
        type=Option("deg", positive(180.0, "deg")),
        metavar="DEG",
        help="aerodyn, rosco: azimuth from row to row.  [default: the profile's stations; 24 "
        "rows a "
        "period of the highest harmonic for a series]",
    ),
    click.option(
        "--time-step",
        type=Option("s", positive(60.0, "s")),
        metavar="S",
        help="aerodyn, rosco: time from row to row, in place of --step-deg.",
    ),
    click.option(
        "--revolutions",
        type=Option("n", whole(1, 100000)),
        metavar="N",
        help="aerodyn, rosco: revolutions covered; the last row is held afterwards.  [default: "
        "4, 60]",
    ),
    click.option(
        "--interpolation",
        type=Option("kind", names=("linear", "fourier")),
        metavar="linear|fourier",
        help="aerodyn, rosco: how the profile continues between its stations.  [default: linear]",
    ),
    click.option(
        "--initial-azimuth-deg",
        type=Option("deg", between(-360.0, 360.0, "deg")),
        metavar="DEG",
        help="rosco: azimuth of blade 1 at time 0, 0 is up.  [default: 0]",
    ),
)
@section(
    "Lead for actuators (csv, harmonics, rosco)",
    click.option(
        "--keep-harmonics",
        type=Option("n", whole(1, 10000)),
        metavar="N",
        help="csv, harmonics, rosco: keep 1P to nP.  [default: all]",
    ),
    click.option(
        "--actuator-lag",
        type=Option("s", positive(10.0, "s")),
        metavar="S",
        help="csv, harmonics, rosco: lead an actuator of first order with this time constant.",
    ),
    click.option(
        "--actuator-frequency",
        type=Option("rad/s", positive(1000.0, "rad/s")),
        metavar="RAD/S",
        help="... or one of second order, with --actuator-damping.",
    ),
    click.option(
        "--actuator-damping",
        type=Option("x", positive(10.0, "")),
        metavar="X",
        help="Damping ratio of an actuator of second order.",
    ),
    click.option("--phase-only", is_flag=True, help="Lead in phase, leave amplitudes as they are."),
    click.option(
        "--beyond-limits", is_flag=True, help="Write commands beyond range or rate, with a warning."
    ),
)
@section(
    "ROSCO's DISCON.IN",
    click.option(
        "--discon",
        metavar="DISCON.IN",
        help="rosco, discon: write a copy of this file with the lines changed.",
    ),
    click.option(
        "--wind-ramp",
        type=Option("list", numbers),
        metavar="LOW,HIGH",
        help="discon: wind speeds between which the gains fade in.  [default: always full]",
    ),
    click.option(
        "--only-1p", is_flag=True, help="discon: write 1P of a controller that has 2P too."
    ),
    click.option(
        "--filter-gain",
        type=Option("x", positive(10.0, "")),
        metavar="X",
        help="discon: share of 1P moments that ROSCO's band pass lets through.  [default: 0.5, as "
        "ROSCO 2.9 and 2.10.6 do; 1 for a version that corrects it]",
    ),
    click.option(
        "--turbine",
        metavar="KEY|FILE",
        help="discon: turbine of a controller's name or file.  [default: nrel-5mw]",
    ),
    click.option(
        "--pitch-lag",
        type=Option("s", between(0.0, 10.0, "s")),
        metavar="S",
        help="discon: time constant of the actuators, for the offset of ipc.  [default: 0]",
    ),
)
@goal_options
@case_options
@search_options
@json_option
def command(**options: Any) -> int:  # fmt: skip
    """A profile or a controller for other programs.

    Takes a profile from profiles.npz of tradeoff, design or learn, from robust.npz or
    schedule.npz, or solves a design itself with the options of the design command; or takes
    individual pitch control from a controller.
    """
    from pitchopt.cli.export_files import controller_files, profile_files, tell
    from pitchopt.cli.export_sources import controller_of_file, profile_of_design, profile_of_file
    from pitchopt.cli.output import save
    from pitchopt.exports import check_folder

    form, path = options["form"], options["source"]
    _check(form, options)
    folder = check_folder(options["out"], "--out")
    if form == "discon":
        individual, label, others = controller_of_file(
            path, turbine=options["turbine"] or "nrel-5mw", pitch_lag=options["pitch_lag"] or 0.0
        )
        exported = controller_files(individual, options, others)
    else:
        source = (
            profile_of_design(options) if path is None else profile_of_file(path, options["point"])
        )
        label = source.label
        exported = profile_files(form, source, options)
    written = save(folder, exported.files)
    if options["as_json"]:
        from pitchopt.exports import document_text

        document = {"format": form, "profile": label, "files": written, "notes": exported.notes}
        click.echo(document_text(document), nl=False)
    else:
        click.echo(f"{label}: " + ", ".join(written))
        tell(exported.notes)
    return 0


def _flag(name: str) -> str:
    return "--" + name.replace("_", "-")


def _check(form: str | None, options: dict[str, Any]) -> None:
    """Refuse what does not go together before anything is read or computed."""
    if form not in FORMATS:
        raise InputError(f"--format: got {form!r}, expected one of {', '.join(FORMATS)}")
    if options["interpolation"] not in (None, "linear", "fourier"):
        raise InputError(
            f"--interpolation: got {options['interpolation']!r}, expected one of linear, fourier"
        )
    for name, forms in _USED_BY.items():
        given = options[name] not in (None, False)
        if given and form == "aerodyn" and forms == _LED:
            raise InputError(
                f"{_flag(name)}: given with --format aerodyn, whose driver prescribes the motion "
                "itself: no actuator lags there; expected one of " + ", ".join(forms)
            )
        if given and form not in forms:
            raise InputError(
                f"{_flag(name)}: given with --format {form}, expected one of {', '.join(forms)}"
            )
    goals = ("case", "curves", "mu", "max_power_loss", "mean_torque")
    fields = [flag[2:].replace("-", "_") for flag, *_ in _CASE_OPTIONS]
    path = options["source"]
    ramp = options["wind_ramp"]
    if ramp is not None and len(ramp) != 2:
        raise InputError(f"--wind-ramp: got {len(ramp)} speeds, expected two, such as 9,11")
    if ramp is not None and ramp[0] >= ramp[1]:
        raise InputError(
            f"--wind-ramp: got {ramp[0]:g} to {ramp[1]:g} m/s, expected ascending speeds"
        )
    if form == "discon" and path is None:
        raise InputError(
            "controller: got nothing, expected a controller file (.toml), tuning.json, or ipc"
        )
    if path is None and options["point"] is not None:
        raise InputError(f"--point: got {options['point']!r} without a file, expected PROFILES.npz")
    for name in (*goals, *fields) if path is not None else ():
        if options[name] is not None:
            what = "controller" if form == "discon" else "profiles"
            raise InputError(
                f"{_flag(name)}: given together with a {what} file, expected one of the two: the "
                "file holds what is finished"
            )
