"""Built-in cases, and cases in TOML files: read strictly, written with explanations.

A file names a turbine (or a table of curves) and overrides defaults by section:

    turbine = "nrel-5mw"

    [wind]
    speed = 9.0

Unknown keys are errors that name the nearest known one.  Paths are relative to the file.
"""

from __future__ import annotations

import difflib
import json
import os
import tomllib
from pathlib import Path
from typing import Any

import numpy as np

from pitchopt.cases.case import Case
from pitchopt.cases.kinds import PathName, Text
from pitchopt.cases.settings import (
    SCHEMA,
    SECTIONS,
    AeroSettings,
    LimitSettings,
    ObjectiveSettings,
    WindSettings,
)
from pitchopt.errors import InputError
from pitchopt.turbines.fields import brief
from pitchopt.turbines.files import read_text

__all__ = [
    "MAX_BYTES",
    "builtin_names",
    "case_from_table",
    "case_toml",
    "load_case",
    "only_known",
    "read_toml",
]

MAX_BYTES = 1_000_000
_TOP = ("name", "turbine", "curves")
_YAML = (".yaml", ".yml")


def builtin_names() -> tuple[str, ...]:
    """Names of the built-in cases: one for every turbine of the catalogue."""
    from pitchopt.turbines import names

    return names()


def builtin_case(name: str) -> Case:
    """A built-in case.

    ``biegel2011`` has the settings of B. Biegel et al., Wind Turbine Pitch Optimization, 2011,
    section V: no induction, unit weights, no cap on the blade load, 15 m/s with cubic shear
    0.2, horizontal shear 5e-4 (the paper counts y to the other side), tower shadow without its
    lateral part, m = 24, d = 40, 10 deg/s.  Every other case has the defaults of the sections.
    """
    if name != "biegel2011":
        return Case(name=name, turbine=name)
    return Case(
        name=name,
        turbine=name,
        wind=WindSettings(
            speed=15.0,
            shear="cubic",
            shear_exponent=0.2,
            horizontal_shear=-5e-4,
            tower_lateral=False,
        ),
        aero=AeroSettings(
            induction="none",
            segments=40,
            pitch_rate_terms=False,
            radial_moment=False,
            skew=False,
        ),
        limits=LimitSettings(positions=24, pitch_rate=float(np.deg2rad(10.0))),
        objective=ObjectiveSettings(weights="unit", blade_cap=None),
    )


def load_case(name_or_path: str | os.PathLike[str]) -> Case:
    """A built-in case by name, or a case file.

    Parameters
    ----------
    name_or_path : str or path
        One of `builtin_names`, or a file ending in ``.toml``.

    Raises
    ------
    InputError
        On an unknown name, naming all of them and the nearest, and on anything wrong in a file.
    """
    text = os.fspath(name_or_path)
    names = builtin_names()
    if text in names:
        return builtin_case(text)
    path = Path(text)
    if path.suffix.lower() == ".toml":
        return _read(path)
    hint = ""
    if path.suffix.lower() in _YAML:
        hint = f"; for a windIO turbine write turbine = {brief(text)} into a case file"
    else:
        near = difflib.get_close_matches(text.lower(), names, n=1, cutoff=0.4)
        hint = f"; did you mean {near[0]!r}?" if near else ""
    raise InputError(
        f"case: got {brief(text)}, expected one of {', '.join(names)} or a file ending in "
        f".toml{hint}"
    )


def _read(path: Path) -> Case:
    table = read_toml(path, "case")
    try:
        return case_from_table(table, folder=path.parent, name=path.stem)
    except InputError as error:
        raise InputError(f"{path}: {error}") from error


def read_toml(path: Path, field: str) -> dict[str, Any]:
    """Content of a TOML file that a user handed in.

    Parameters
    ----------
    path : Path
    field : str
        What the file is, for errors.

    Raises
    ------
    InputError
        If the file is missing, too large, no text or no TOML.
    """
    try:
        text = read_text(path, limit=MAX_BYTES)
    except InputError as error:
        raise InputError(f"{field}: {error}") from error
    try:
        return tomllib.loads(text)
    except (tomllib.TOMLDecodeError, RecursionError, ValueError) as error:
        what = " ".join(str(error).split())[:160] or type(error).__name__
        raise InputError(f"{field}: {path}: not valid TOML ({what})") from error


def case_from_table(
    table: dict[str, Any], *, folder: Path | None = None, name: str = "case"
) -> Case:
    """Case of the plain data that a case file holds.

    Parameters
    ----------
    table : dict
        Content of the file. ``turbine`` may be the name of a built-in case's turbine; the case
        then starts from that built-in case.
    folder : path, optional
        Where relative paths start.
    name : str
        Name of the case if the table has none.
    """
    known = (*_TOP, *SECTIONS)
    only_known(table, known, "")
    turbine = Text(optional=True).read("turbine", table.get("turbine", ""))
    builtin = turbine in builtin_names()
    if turbine is not None and not builtin:
        turbine = _turbine(turbine, folder)
    curves = PathName().read("curves", table.get("curves", ""))
    if curves is not None and folder is not None:
        curves = folder / curves
    title = Text().read("name", table.get("name", name))
    base = builtin_case(turbine) if builtin and turbine is not None else None
    values: dict[str, Any] = {}
    for section in SECTIONS:
        content = table.get(section, {})
        if not isinstance(content, dict):
            raise InputError(f"{section}: got {brief(content)}, expected a section [{section}]")
        entries = {entry.key: entry for entry in SCHEMA if entry.section == section}
        only_known(content, tuple(entries), section)
        for key, raw in content.items():
            entry = entries[key]
            value = entry.kind.read(entry.name, raw)
            if isinstance(entry.kind, PathName) and value is not None and folder is not None:
                value = folder / value
            values[f"{section}.{entry.attribute}"] = value
    if base is None:
        base = Case(name=title or name, turbine=turbine, curves=curves)
    return base.with_values({"name": title, "curves": curves, **values})


def _turbine(text: str, folder: Path | None) -> str:
    """Key or path of a turbine that is no built-in case's; an error if it is neither."""
    from pitchopt.turbines import load_turbine

    if Path(text).suffix.lower() not in (*_YAML, ".json"):
        load_turbine(text)  # an unknown key is best told here, where the file's name is known
        return text
    path = text if folder is None else str(folder / text)
    if not Path(path).exists():
        raise InputError(f"turbine: {path}: no such file")
    return path


def only_known(content: dict[str, Any], known: tuple[str, ...], section: str) -> None:
    """Refuse keys of a section that are not known, naming the nearest."""
    for key in content:
        if key not in known:
            near = difflib.get_close_matches(str(key), known, n=1, cutoff=0.5)
            hint = f"; did you mean {near[0]!r}?" if near else ""
            dotted = f"{section}.{key}" if section else str(key)
            raise InputError(
                f"{brief(dotted)[1:-1]}: unknown key, expected one of {', '.join(known)}{hint}"
            )


def case_toml(case: Case) -> str:
    """Text of a case file that holds every value of a case, with one line of explanation each."""
    plain = case.plain()
    lines = [
        "# Case of pitchopt. What is left out keeps its default.",
        f"name = {_toml(plain['name'])}",
    ]
    if case.turbine is not None:
        lines.append(
            f"turbine = {_toml(plain['turbine'])}  # catalogue key, or windIO file (.yaml) "
            "relative to this file"
        )
    if case.curves is not None:
        lines.append(f"curves = {_toml(plain['curves'])}  # BladeCurves, in place of the rotor")
    section = ""
    for entry in SCHEMA:
        if entry.section != section:
            section = entry.section
            lines += ["", f"[{section}]"]
        lines.append(f"{entry.key} = {_toml(plain[section][entry.key])}  # {entry.doc}")
    return "\n".join(lines) + "\n"


def _toml(value: Any) -> str:
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, dict):
        return "{ " + ", ".join(f"{key} = {_toml(item)}" for key, item in value.items()) + " }"
    if isinstance(value, (int, float)):
        return repr(value)
    return json.dumps(str(value), ensure_ascii=False)
