"""``pitchopt turbines``: what the catalogue holds."""

from __future__ import annotations

from typing import Any

import click

from pitchopt.cli.completing import turbines
from pitchopt.cli.help import Command
from pitchopt.cli.options import json_option
from pitchopt.cli.values import Option
from pitchopt.errors import InputError

__all__ = ["command"]

_EPILOG = """\b
Examples:
  pitchopt turbines
  pitchopt turbines iea-15-240
  pitchopt turbines my-windio-turbine.yaml
  pitchopt turbines --template nrel-5mw > my-case.toml
  pitchopt turbines --template my-windio-turbine.yaml > my-case.toml"""

_KEY = Option("key", names=turbines, endings=(".yaml", ".yml", ".json"))


@click.command("turbines", cls=Command, epilog=_EPILOG)
@click.argument("turbine", required=False, type=_KEY, metavar="[KEY|FILE.yaml]")
@click.option(
    "--template",
    type=_KEY,
    metavar="KEY|FILE.yaml",
    help="Print a case file for this turbine or windIO file, every value explained.",
)
@json_option
def command(turbine: str | None, template: str | None, as_json: bool) -> int:
    """The reference turbines, and case files to start from.

    Without arguments a table of all turbines; with a key or a windIO v2 file everything about that
    one, which also checks the file: a mistake is named by its key. A template is the case file of a
    turbine, for --case of the other commands.
    """
    from pitchopt.turbines import load_turbine, names, summary

    if template is not None:
        if turbine is not None or as_json:
            raise InputError("--template: got it with another turbine or --json, expected it alone")
        from pitchopt.cases import Case, builtin_names, case_toml, load_case

        load_turbine(template)  # complain about an unknown key or a bad file here
        known = template in builtin_names()
        case = load_case(template) if known else Case(name="my-case", turbine=template)
        click.echo(case_toml(case), nl=False)
        return 0
    keys = names() if turbine is None else (turbine,)
    records = [{"key": key, **summary(load_turbine(key))} for key in keys]
    if as_json:
        from pitchopt.exports import document_text

        click.echo(document_text({"turbines": records}), nl=False)
    elif turbine is None:
        click.echo(_table(records))
    else:
        click.echo(_details(turbine))
    return 0


def _table(records: list[dict[str, Any]]) -> str:
    from pitchopt.cli.tables import text_table

    columns = (
        ("rotor", "m", "rotor_diameter", 1.0, ".1f"),
        ("hub", "m", "hub_height", 1.0, ".1f"),
        ("blades", "", "blades", 1.0, ".0f"),
        ("power", "MW", "rated_power", 1e-6, ".2f"),
        ("speed", "rpm", "rated_rotor_speed_rpm", 1.0, ".2f"),
        ("wind", "m/s", "rated_wind_speed", 1.0, ".1f"),
    )
    rows = [["turbine", *(c[0] for c in columns)], ["", *(c[1] for c in columns)]]
    for record in records:
        cells = [
            "-" if record[key] is None else f"{factor * record[key]:{form}}"
            for _, _, key, factor, form in columns
        ]
        rows.append([record["key"], *cells])
    lines = text_table(rows, header=2).splitlines()
    sources = [" ".join(str(record["source"]).split()) for record in records]
    texts = ["source", "", "", *(s if len(s) <= 72 else s[:69] + "..." for s in sources)]
    width = max(map(len, lines))
    return "\n".join(
        f"{line.ljust(width)}   {text}".rstrip() for line, text in zip(lines, texts, strict=True)
    )


def _details(key: str) -> str:
    import numpy as np

    from pitchopt.turbines import load_turbine

    turbine = load_turbine(key)
    rotor, tower = turbine.rotor, turbine.tower
    deg = np.rad2deg
    rpm = 30.0 / np.pi

    def number(value: float | None, unit: str, factor: float = 1.0) -> str:
        return "not known" if value is None else f"{factor * value:.5g} {unit}".rstrip()

    rows = [
        ("name", turbine.name),
        ("source", turbine.source),
        ("description", turbine.description or "-"),
        ("rotor radius", number(rotor.radius, "m")),
        ("hub radius", number(rotor.hub_radius, "m")),
        ("hub height", number(rotor.hub_height, "m")),
        ("blades", f"{rotor.blades}, {rotor.blade.span.size} sections"),
        ("tilt, cone", f"{deg(rotor.tilt):.3g} deg, {deg(rotor.cone):.3g} deg"),
        ("overhang", number(rotor.overhang, "m")),
        ("rated power", number(turbine.rated_power, "MW", 1e-6)),
        ("rated torque", number(turbine.rated_torque, "kN m", 1e-3)),
        ("rated wind speed", number(turbine.rated_wind_speed, "m/s")),
        (
            "rotor speed",
            f"{turbine.min_rotor_speed * rpm:.4g} to {turbine.rated_rotor_speed * rpm:.4g} rpm",
        ),
        ("optimal tip-speed ratio", number(turbine.optimal_tip_speed_ratio, "")),
        (
            "pitch",
            " to ".join(f"{deg(end):.4g}" for end in turbine.pitch_range)
            + f" deg, {deg(turbine.pitch_rate):.4g} deg/s",
        ),
        ("air density", number(turbine.air_density, "kg/m^3")),
        (
            "tower",
            " to ".join(f"{h:.4g}" for h in (tower.base, tower.top))
            + " m, diameter "
            + " to ".join(f"{d:.4g} m" for d in (tower.diameter[0], tower.diameter[-1])),
        ),
        *((f"note on {part}", text) for part, text in turbine.notes.items()),
    ]
    width = max(len(name) for name, _ in rows)
    return "\n".join(f"{name:<{width}}  {' '.join(text.split())}" for name, text in rows)
