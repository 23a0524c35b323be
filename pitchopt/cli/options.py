"""Options that commands share, and the case that they describe."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

import click

from pitchopt.cli.values import Given, Option, as_share, case_value, positive, whole
from pitchopt.errors import InputError

if TYPE_CHECKING:
    from pitchopt.cases import Case
    from windfield import BoxCache

__all__ = [
    "box_cache",
    "build_case",
    "cache_options",
    "case_options",
    "certify_options",
    "json_option",
    "output_options",
    "search_options",
]

F = TypeVar("F", bound=Callable[..., Any])

DEFAULT_CASE = "biegel2011"

_CASE_OPTIONS: tuple[tuple[str, str, str, str], ...] = (
    ("--wind-speed", "wind.speed", "m/s", "Wind speed at the hub."),
    ("--shear", "wind.shear_exponent", "x", "Exponent of the vertical shear."),
    ("--rotor-speed-rpm", "operation.rotor_speed", "rpm|auto", "Rotor speed."),
    ("--induction", "aero.induction", "mode", "none, frozen or equilibrium."),
    ("--elements", "aero.elements", "n|auto", "Blade elements."),
    ("--segments", "aero.segments", "d", "Segments of the piecewise-linear polars."),
    ("--positions", "limits.positions", "m", "Rotor positions in one blade passage."),
    ("--pitch-min-deg", "limits.pitch_min", "deg|auto", "Lower end of the pitch range."),
    ("--pitch-max-deg", "limits.pitch_max", "deg|auto", "Upper end of the pitch range."),
    (
        "--pitch-rate-deg",
        "limits.pitch_rate",
        "deg/s|auto",
        "Largest pitch rate; 0 leaves constant pitch only.",
    ),
    (
        "--weights",
        "objective.weights",
        "set",
        (
            "unit, tower-base (thrust times hub height), or an own set such as "
            "torque=1,tilt=1,yaw=1,thrust=90,blade=0; loads not named weigh nothing."
        ),
    ),
    (
        "--blade-cap",
        "objective.blade_cap",
        "x|none",
        "Largest RMS of a blade's bending, relative to constant pitch.",
    ),
    ("--harmonics", "objective.harmonics", "n|none", "Restrict profiles to 1P ... nP."),
    ("--travel-penalty", "objective.travel", "x", "Price of pitch travel [N m/deg a revolution]."),
)
_NEEDS_ROTOR = ("shear", "induction", "elements", "segments")


def _stacked(function: F, options: list[Callable[[F], F]]) -> F:
    for option in reversed(options):
        function = option(function)
    return function


def case_options(function: F) -> F:
    """Options that choose and change a case."""
    options: list[Callable[[F], F]] = [
        click.option(
            "--case",
            metavar="NAME|FILE.toml",
            help=f"Built-in case or case file.  [default: {DEFAULT_CASE}]",
        ),
        click.option(
            "--curves",
            metavar="FILE",
            help="Design on this table of BladeCurves (.npz or .csv) from any aerodynamic code "
            "instead of the rotor model.",
        ),
        *(
            click.option(
                flag, type=Option(metavar, case_value(field)), metavar=metavar.upper(), help=text
            )
            for flag, field, metavar, text in _CASE_OPTIONS
        ),
    ]
    return _stacked(function, options)


def json_option(function: F) -> F:
    """One JSON document on standard output and nothing else there."""
    return click.option(
        "--json", "as_json", is_flag=True, help="Print one JSON document instead of tables."
    )(function)


def output_options(function: F) -> F:
    """Where files go."""
    return click.option(
        "--out",
        metavar="DIR",
        help="Folder for the files.  [default: COMMAND-CASE in the current folder; with --json "
        "no files unless this is given]",
    )(function)


def search_options(function: F) -> F:
    """How hard to search."""
    options: list[Callable[[F], F]] = [
        click.option(
            "--starts", type=Option("n", whole(1, 1000)), default=5, show_default=True,
            help="Profiles that a local search starts from.",
        ),
        click.option("--no-certify", is_flag=True, help="Leave out the proven bounds."),
        click.option(
            "--seed", type=Option("n", whole(0, 2**63 - 1)), default=0, show_default=True,
            help="Seed of the random starts, beyond the first seven.",
        ),
    ]  # fmt: skip
    return _stacked(function, options)


def certify_options(function: F) -> F:
    """How far to prove what is found."""
    options: list[Callable[[F], F]] = [
        click.option(
            "--certify", type=click.Choice(["fast", "deep"]), default="fast", show_default=True,
            help="Bound by the hull relaxation, or close the gap by branch and bound as well.",
        ),
        click.option(
            "--certify-gap", type=Option("share", as_share), metavar="SHARE", default="0.1%",
            show_default=True,
            help="Gap at which the branch and bound ends, as a share of the largest mean torque "
            "(with --mean-torque of the weighted RMS).",
        ),
        click.option(
            "--certify-seconds", type=Option("s", positive(1e7, "s")), metavar="S", default="300",
            show_default=True, help="Time limit of the branch and bound of one profile.",
        ),
        click.option(
            "--workers", type=Option("n", whole(1, 1024)), metavar="N",
            help="Processes of the branch and bound.  [default: one a processor]",
        ),
    ]  # fmt: skip
    return _stacked(function, options)


def build_case(options: dict[str, Any]) -> Case:
    """The case that the options describe; takes its own options out of `options`."""
    from pitchopt.cases import Case, ObjectiveSettings, load_case

    name, curves = options.pop("case"), options.pop("curves")
    given: dict[str, Any] = {}
    values: dict[str, Any] = {}
    for flag, field, _, _ in _CASE_OPTIONS:
        key = flag[2:].replace("-", "_")
        value = options.pop(key)
        if isinstance(value, Given):
            given[key] = value.value
            values[field] = value.value
    if curves is not None:
        clash = [key for key in (*_NEEDS_ROTOR, "positions") if key in given]
        if clash:
            raise InputError(
                f"--{clash[0]}: got {given[clash[0]]!r} together with --curves, expected one of "
                "the two: a table of curves has its rotor, wind and positions in it"
            )
        if name is None and "wind_speed" in given:
            raise InputError(
                f"--wind-speed: got {given['wind_speed']!r} together with --curves and without "
                "--case, expected --rotor-speed-rpm"
            )
    if name is not None or curves is None:
        case = load_case(DEFAULT_CASE if name is None else name)
        if curves is not None:
            values["curves"] = Path(curves)
    else:
        case = Case(
            name=Path(curves).stem or "curves",
            curves=Path(curves),
            objective=ObjectiveSettings(weights="unit"),
        )
        if "rotor_speed_rpm" not in given:
            raise InputError(
                "--rotor-speed-rpm: got nothing, expected a number with --curves and without --case"
            )
    if "shear" in given:
        if case.wind.disc is not None or case.wind.shear == "log":
            what = "a log law" if case.wind.disc is None else "a disc file"
            raise InputError(
                f"--shear: got {given['shear']!r}, expected no exponent: the case has {what}"
            )
        if case.wind.shear == "none":
            values["wind.shear"] = "power"
    return case.with_values(values)


def cache_options(function: F) -> F:
    """Where Kaimal boxes are kept."""
    return _stacked(
        function,
        [
            click.option(
                "--cache",
                metavar="DIR",
                help="Folder in which Kaimal boxes are kept.  [default: windfield in the user's "
                "cache folder]",
            ),
            click.option("--no-cache", is_flag=True, help="Keep no boxes."),
        ],
    )


def box_cache(options: Mapping[str, Any]) -> BoxCache | None:
    """Cache of the options of `cache_options`; None for none.

    Raises
    ------
    InputError
        If both are given.
    """
    from windfield import BoxCache

    if options["no_cache"]:
        if options["cache"] is not None:
            raise InputError("--no-cache: got it together with --cache, expected one of them")
        return None
    return BoxCache(options["cache"])
