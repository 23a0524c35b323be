"""``pitchopt export``: a profile for other programs."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import click

from pitchopt.cli.design_command import goal_options
from pitchopt.cli.help import Command
from pitchopt.cli.options import (
    _CASE_OPTIONS,
    build_case,
    case_options,
    json_option,
    search_options,
)
from pitchopt.cli.values import Option, positive, whole
from pitchopt.errors import InputError

if TYPE_CHECKING:
    from pathlib import Path

    from pitchopt.exports import ProfileSet

__all__ = ["command"]

FORMATS = ("csv", "harmonics", "aerodyn")

_EPILOG = """\b
Examples:
  pitchopt export demo/profiles.npz --point knee --format csv
  pitchopt export demo/profiles.npz --point loss=3% --format harmonics --out tables
  pitchopt export demo/profiles.npz --point 4 --format aerodyn --revolutions 10
  pitchopt export --case nrel-5mw --wind-speed 15 --mean-torque rated --format aerodyn

\b
csv        profile.csv: azimuth_deg, pitch_deg, pitch_rate_deg_s (central difference)
harmonics  harmonics.csv: mean and cos, sin, amplitude, phase of every nP [deg];
           pitch = mean + sum of amplitude cos(n azimuth - phase)
aerodyn    pitch_b1.csv ... for the AeroDyn driver: time [s], pitch [rad], rate
           [rad/s], acceleration [rad/s^2], blade b at azimuth + 360 (b-1)/B deg;
           driver_motion.txt: the lines of the driver's input file that use them

\b
The rate in the motion files belongs to the interpolation. linear: the slope of
the straight line, at a station the mean of the slopes on both sides, which is
what the design itself uses; acceleration 0. fourier: derivatives of the Fourier
series through the stations, which may leave range and rate between stations."""


@click.command("export", cls=Command, epilog=_EPILOG)
@click.argument("profiles", required=False, metavar="[PROFILES.npz]")
@click.option("--format", "form", metavar="|".join(FORMATS), help="What to write.  [required]")
@click.option(
    "--point",
    metavar="NAME",
    help="Profile of the file: INDEX, knee, loss=3%, power_max, constant or a label.  [default: "
    "the knee, or the only design]",
)
@click.option("--out", metavar="DIR", default=".", show_default=True, help="Folder for the files.")
@click.option(
    "--step-deg",
    type=Option("deg", positive(180.0, "deg")),
    default=None,
    metavar="DEG",
    help="aerodyn: azimuth from row to row.  [default: the profile's stations]",
)
@click.option(
    "--revolutions",
    type=Option("n", whole(1, 100000)),
    default=4,
    show_default=True,
    help="aerodyn: revolutions covered.",
)
@click.option(
    "--interpolation",
    metavar="linear|fourier",
    default="linear",
    show_default=True,
    help="aerodyn: how the profile continues between its stations.",
)
@goal_options
@case_options
@search_options
@json_option
def command(**options: Any) -> int:
    """A profile for other programs.

    Takes a profile from the profiles.npz that tradeoff or design wrote, or solves a design
    itself with the options of the design command.
    """
    from pitchopt.cli.output import save
    from pitchopt.exports import check_folder

    form, path = options["form"], options["profiles"]
    if form not in FORMATS:
        raise InputError(f"--format: got {form!r}, expected one of {', '.join(FORMATS)}")
    if options["interpolation"] not in ("linear", "fourier"):
        raise InputError(
            f"--interpolation: got {options['interpolation']!r}, expected one of linear, fourier"
        )
    folder = check_folder(options["out"], "--out")
    if path is None:
        if options["point"] is not None:
            raise InputError(
                f"--point: got {options['point']!r} without a file, expected PROFILES.npz"
            )
        source, row = _solved(options), 2
    else:
        source, row = _loaded(path, options)
    files = _contents(form, source, row, options)
    written = save(folder, files)
    label = source.labels[row]
    if options["as_json"]:
        from pitchopt.exports import document_text

        document = {"format": form, "profile": label, "files": written}
        click.echo(document_text(document), nl=False)
    else:
        click.echo(f"{label}: " + ", ".join(written))
    return 0


def _loaded(path: str | Path, options: dict[str, Any]) -> tuple[ProfileSet, int]:
    """Profiles of a file and the row asked for."""
    from pitchopt.exports import ProfileSet

    names = [flag[2:].replace("-", "_") for flag, *_ in _CASE_OPTIONS]
    for name in ("case", "curves", "mu", "max_power_loss", "mean_torque", *names):
        if options[name] is not None:
            flag = "--" + name.replace("_", "-")
            raise InputError(
                f"{flag}: given together with a profiles file, expected one of the two: the file "
                "holds finished profiles"
            )
    source = ProfileSet.load(path)
    point = options["point"]
    if point is None:
        if source.knee is not None:
            point = "knee"
        elif source.points == 1:
            point = "0"
        else:
            raise InputError(
                f"--point: got nothing, expected an index or one of {', '.join(source.labels)}"
            )
    return source, source.row(point)


def _solved(options: dict[str, Any]) -> ProfileSet:
    from pitchopt.cli.design_command import solve
    from pitchopt.errors import ComputationError
    from pitchopt.exports import profile_set

    case = build_case(options)
    solved = solve(case, options)
    if not solved.design.status.ok:
        raise ComputationError(f"{solved.design.status.value}: {solved.design.message}")
    return profile_set(
        solved.constant,
        solved.power_max,
        [solved.design],
        blades=case.blades,
        rotor_speed=case.rotor_speed,
        settings=solved.settings,
    )


def _contents(
    form: str, source: ProfileSet, row: int, options: dict[str, Any]
) -> dict[str, bytes | str]:
    """Names and contents of the files."""
    import numpy as np

    from pitchopt.exports import (
        blade_motion,
        harmonics,
        harmonics_csv,
        motion_files,
        profile_csv,
    )
    from pitchopt.exports.aerodyn import driver_block

    profile, speed = source.profiles[row], source.rotor_speed
    if form == "csv":
        return {"profile.csv": profile_csv(source.azimuth, profile, rotor_speed=speed)}
    if form == "harmonics":
        return {"harmonics.csv": harmonics_csv(harmonics(source.azimuth, profile))}
    motion = blade_motion(
        source.azimuth,
        profile,
        rotor_speed=speed,
        blades=source.blades,
        step=None if options["step_deg"] is None else float(np.deg2rad(options["step_deg"])),
        revolutions=options["revolutions"],
        interpolation=options["interpolation"],
    )
    files = motion_files(motion)
    return {**files, "driver_motion.txt": driver_block(tuple(files), speed)}
