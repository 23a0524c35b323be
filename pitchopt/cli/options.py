"""Options that commands share, and the case that they describe."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

import click

from pitchopt.cli.completing import turbines
from pitchopt.cli.help import COMPUTATION, OUTPUT, SEARCH, section
from pitchopt.cli.values import (
    FOLDER,
    Given,
    Option,
    as_share,
    between,
    case_value,
    positive,
    whole,
)
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
    "model_options",
    "result_options",
    "search_options",
    "turbine_case_options",
    "turbine_option",
]

F = TypeVar("F", bound=Callable[..., Any])

DEFAULT_CASE = "biegel2011"

_CASE_OPTIONS: tuple[tuple[str, str, str, str], ...] = (
    ("--wind-speed", "wind.speed", "M/S", "Wind speed at the hub."),
    ("--shear", "wind.shear_exponent", "X", "Exponent of the vertical shear, such as 0.2."),
    ("--rotor-speed-rpm", "operation.rotor_speed", "RPM|auto", "Rotor speed."),
    (
        "--induction",
        "aero.induction",
        "none|frozen|equilibrium",
        (
            "How the rotor slows the wind down: not at all, as it does at the mean pitch, or anew "
            "for every azimuth and pitch."
        ),
    ),
    ("--elements", "aero.elements", "N|auto", "Blade elements."),
    ("--segments", "aero.segments", "N", "Segments of the piecewise-linear lift and drag."),
    (
        "--positions",
        "limits.positions",
        "N",
        (
            "Rotor positions in one blade passage; a profile has one pitch for each, times the "
            "number of blades."
        ),
    ),
    ("--pitch-min-deg", "limits.pitch_min", "DEG|auto", "Lower end of the pitch range."),
    ("--pitch-max-deg", "limits.pitch_max", "DEG|auto", "Upper end of the pitch range."),
    (
        "--pitch-rate-deg",
        "limits.pitch_rate",
        "DEG/S|auto",
        "Largest pitch rate; 0 leaves constant pitch only.",
    ),
    (
        "--weights",
        "objective.weights",
        "SET",
        (
            "unit, tower-base (thrust times hub height), or an own set such as "
            "torque=1,tilt=1,yaw=1,thrust=90,blade=0; loads not named weigh nothing."
        ),
    ),
    (
        "--blade-cap",
        "objective.blade_cap",
        "X|none",
        "Largest RMS of a blade's bending, relative to constant pitch.",
    ),
    (
        "--harmonics",
        "objective.harmonics",
        "N|none",
        "Restrict profiles to 1 ... N cycles a turn (1P ... NP).",
    ),
    (
        "--travel-penalty",
        "objective.travel",
        "X",
        "Price of pitch travel [N m of mean torque for 1 deg a turn].",
    ),
)
_CASE_SECTIONS = {
    "Case (what is left out is the case's own)": ("wind", "operation"),
    "Rotor model": ("aero",),
    "Pitch limits": ("limits",),
    "Loads that count": ("objective",),
}
_NAMES = {
    "aero.induction": ("none", "frozen", "equilibrium"),
    "objective.weights": ("unit", "tower-base"),
}
_NEEDS_ROTOR = ("shear", "induction", "elements", "segments")
_CURVES = (".npz", ".csv")


def case_options(function: F) -> F:
    """Options that choose and change a case, or a table of curves."""
    curves = click.option(
        "--curves", type=Option("file", endings=_CURVES), metavar="FILE",
        help="Design on this table of blade loads over azimuth and pitch (.npz or .csv), from any "
        "aerodynamic code, instead of the rotor model.",
    )  # fmt: skip
    return _case_options(function, DEFAULT_CASE, curves)


def turbine_case_options(default: str) -> Callable[[F], F]:
    """Options that choose and change a case with a turbine."""
    return lambda function: _case_options(function, default)


def _case_options(function: F, default: str, *more: Callable[[Any], Any]) -> F:
    first = [
        click.option(
            "--case", type=Option("case", names=turbines, endings=(".toml",)),
            metavar="NAME|FILE.toml",
            help="Turbine with wind, limits and weights: a built-in case (pitchopt turbines lists "
            f"them) or a case file (pitchopt turbines --template).  [default: {default}]",
        ),
        *more,
    ]  # fmt: skip
    for title, parts in reversed(_CASE_SECTIONS.items()):
        options = [
            click.option(
                flag, type=Option(metavar, case_value(field), names=_NAMES.get(field, ())),
                metavar=metavar, help=text,
            )
            for flag, field, metavar, text in _CASE_OPTIONS
            if field.partition(".")[0] in parts
        ]  # fmt: skip
        function = section(title, *(first if "wind" in parts else ()), *options)(function)
    return function


_JSON = click.option(
    "--json", "as_json", is_flag=True,
    help="Print one JSON document and nothing else.",
)  # fmt: skip
_OUT = click.option(
    "--out", type=FOLDER, metavar="DIR",
    help="Folder for the files.  [default: COMMAND-CASE in the current folder; with --json no "
    "files unless this is given]",
)  # fmt: skip


def json_option(function: F) -> F:
    """One JSON document on standard output and nothing else there."""
    return section(OUTPUT, _JSON)(function)


def result_options(function: F) -> F:
    """Pictures or none, where files go, and how the result is printed."""
    plots = click.option("--no-plots", is_flag=True, help="Leave out the pictures.")
    return section(OUTPUT, plots, _OUT, _JSON)(function)


def search_options(function: F) -> F:
    """How hard to search."""
    return section(
        SEARCH,
        click.option(
            "--starts", type=Option("N", whole(1, 1000)), default=5, show_default=True,
            metavar="N", help="Profiles that a local search starts from.",
        ),
        click.option(
            "--seed", type=Option("N", whole(0, 2**63 - 1)), default=0, show_default=True,
            metavar="N", help="Seed of the random starts, beyond the first seven.",
        ),
        click.option(
            "--no-certify", is_flag=True,
            help="Leave out the proven bounds on what any profile could reach.",
        ),
    )(function)  # fmt: skip


def certify_options(function: F) -> F:
    """How far to prove what is found."""
    return section(
        SEARCH,
        click.option(
            "--certify", type=click.Choice(["fast", "deep"]), default="fast", show_default=True,
            help="Bound from one convex relaxation, or close the gap by branch and bound as well "
            "(minutes).",
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
    )(function)  # fmt: skip


def turbine_option(default: str) -> Callable[[F], F]:
    """The turbine of a simulation."""
    return click.option(
        "--turbine", type=Option("key", names=turbines, endings=(".yaml", ".yml", ".json")),
        metavar="KEY|FILE.yaml", default=default, show_default=True,
        help="Of the catalogue (pitchopt turbines), or a windIO file.",
    )  # fmt: skip


def model_options(*, pitch_lag: str, own_lag: str | None = None) -> list[Callable[[F], F]]:
    """Inflow, lag of the pitch actuators and inertia of the generator of a simulation.

    Parameters
    ----------
    pitch_lag : str
        Default of the lag in the words of the help.
    own_lag : str, optional
        The default itself; None leaves it to the command.
    """
    return [
        click.option(
            "--inflow", type=click.Choice(["dynamic", "quasi-steady"]), default="dynamic",
            show_default=True, help="Induction that lags behind, or balance at every instant.",
        ),
        click.option(
            "--pitch-lag", type=Option("s", between(0, 10, "s")), metavar="S", default=own_lag,
            help=f"Time constant of the pitch actuators.  [default: {pitch_lag}]",
        ),
        click.option(
            "--generator-inertia", type=Option("kg m2", between(0, 1e9, "kg m^2")),
            metavar="KGM2",
            help="Of the generator about the high-speed shaft [kg m2]; windIO files hold none.",
        ),
    ]  # fmt: skip


def build_case(options: dict[str, Any]) -> Case:
    """The case that the options describe; takes its own options out of `options`."""
    from pitchopt.cases import Case, ObjectiveSettings, load_case

    name, curves = options.pop("case"), options.pop("curves", None)
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
    return section(
        COMPUTATION,
        click.option(
            "--cache", type=FOLDER, metavar="DIR",
            help="Folder in which boxes of turbulence are kept for the next run.  [default: "
            "windfield in the user's cache folder]",
        ),
        click.option("--no-cache", is_flag=True, help="Keep no boxes."),
    )(function)  # fmt: skip


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
