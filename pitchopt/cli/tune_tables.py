"""What ``pitchopt tune`` prints for people: in kW, kN m, rpm and degrees."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

import click

from pitchopt.cli.tables import number, text_table

__all__ = ["print_tuning"]

_DEG = 180.0 / math.pi
_RPM = 30.0 / math.pi
_UNITS: dict[str, tuple[str, float]] = {
    # first word of a parameter or a measure: unit, factor from SI
    "omega": ("rad/s", 1.0),
    "gain": ("deg/(s MN m)", 1e6 * _DEG),
    "offset": ("deg", _DEG),
    "pitch": ("deg", _DEG),
    "power": ("kW", 1e-3),
    "tower": ("kN m", 1e-3),
    "blade": ("kN m", 1e-3),
    "flapwise": ("kN m", 1e-3),
    "generator": ("rpm", _RPM),
}
_COSTS = {
    "torque-gain": ("kW", 1e-3),
    "speed-regulator": ("kN m", 1e-3),
    "individual-pitch": ("kN m", 1e-3),
}
_LABELS = {
    "tower_load": "tower DEL",
    "blade_load": "blade DEL",
    "generator_speed": "gen. speed",
    "flapwise_moment": "flapwise max",
    "tower_moment": "tower max",
}
_PLAIN = ("", 1.0)


def print_tuning(document: Mapping[str, Any]) -> None:
    """One study, or the table of several."""
    studies = document.get("studies", [document])
    for study in studies:
        _print_study(study)
    if "comparison" in document:
        click.echo(_comparison(document["comparison"]) + "\n")


def _unit(name: str) -> tuple[str, float]:
    if name == "pitch_rate":
        return "deg/s", _DEG
    return _UNITS.get(name.partition("_")[0], _PLAIN)


def _print_study(study: Mapping[str, Any]) -> None:
    problem = study["settings"]["problem"]
    plant = problem["plant"]
    speeds = ", ".join(f"{u:g}" for u in problem["wind_speeds"])
    seeds = len(problem["seeds"])
    click.echo(
        f"{study['turbine']}: {study['problem']} by {study['method']}, {speeds} m/s, turbulence "
        f"{plant['turbulence']}, {seeds} seed{'s' * (seeds != 1)}, {plant['duration']:g} s after "
        f"{plant['skip']:g} s\n"
    )
    click.echo(_points(study) + "\n")
    if "family" in study:
        click.echo(_family(study) + "\n")
    failed = sum(e["status"] != "ok" for e in study["evaluations"])
    click.echo(
        f"cost {_change(study['gain'])} after {len(study['evaluations'])} evaluations"
        + (f" ({failed} failed)" if failed else "")
        + f", {study['simulations']} simulations, {study['seconds']:.1f} s"
    )
    if "fresh_gain" in study:
        click.echo(f"in winds that the tuner did not see: {_change(study['fresh_gain'])}")
    if "soft_speed" in problem:
        click.echo(_speed_line(study["best"]["measures"]["generator_speed"], problem))
    if "agreement" in study:
        click.echo(_agreement_line(study))
    click.echo()


def _points(study: Mapping[str, Any]) -> str:
    """Start and best with what they are made of and lead to."""
    start, best = study["start"], study["best"]
    names = [*study["parameters"], *start["measures"]]
    units = [_unit(name) for name in names]
    at = len(study["parameters"])
    units.insert(at, _COSTS.get(study["problem"], _PLAIN))
    measures = [_LABELS.get(name, name.replace("_", " ")) for name in start["measures"]]
    labels = [*study["parameters"], *measures]
    labels.insert(at, "cost")
    rows = [["", *labels], ["", *(unit for unit, _ in units)]]
    for label, point in (("start", start), ("best", best)):
        values = [*point["x"], point["cost"], *point["measures"].values()]
        rows.append([label, *(_cell(v, u) for v, u in zip(values, units, strict=True))])
    return text_table(rows, header=2)


def _family(study: Mapping[str, Any]) -> str:
    """Tables of each kappa, and what they change against the table to begin with."""
    family = study["family"]
    speeds = family[0]["wind_speed"][1:-1]
    head = [
        ["", *(f"{speed:.4g} m/s" for speed in speeds), "tower", "blade", "power"],
        ["", *("deg" for _ in speeds), "%", "%", "%"],
    ]
    initial = [number(pitch, "deg") for pitch in family[0]["initial_pitch_deg"][1:-1]]
    rows = [["to begin with", *initial, *(number(0.0, "%") for _ in range(3))]]
    for result in family:
        change = result["change_from_initial"]
        rows.append(
            [
                f"kappa {result['kappa']:g}",
                *(number(pitch, "deg") for pitch in result["pitch_deg"][1:-1]),
                *(number(100.0 * change[name], "%") for name in ("tower", "blade", "power")),
            ]
        )
    paper = ["paper, 13 MW, 0.01", *("" for _ in speeds), "-10.90", "-8.50", "-0.03"]
    return text_table([*head, *rows, paper], header=2)


def _speed_line(speed: float, problem: Mapping[str, Any]) -> str:
    soft, hard = problem["soft_speed"], problem["hard_speed"]
    over = speed / soft - 1.0
    return (
        f"largest generator speed, mean of the runs, {_RPM * speed:.0f} rpm, "
        f"{abs(100.0 * over):.1f} % {'over' if over > 0.0 else 'below'} the soft limit of "
        f"{_RPM * soft:.0f} rpm "
        f"(hard limit {_RPM * hard:.0f} rpm)"
    )


def _agreement_line(study: Mapping[str, Any]) -> str:
    found = study["agreement"]
    unit, factor = _COSTS.get(study["problem"], _PLAIN)
    at = ", ".join(
        f"{name} {_cell(x, _unit(name))} {_unit(name)[0]}".rstrip()
        for name, x in zip(study["parameters"], found["x"], strict=True)
    )
    if found["gap"] is None:
        return f"kriging has its minimum at {at}, which cannot be simulated"
    gap, tolerance = factor * found["gap"], factor * found["tolerance"]
    return (
        f"kriging has its minimum at {at}, which costs {abs(gap):.3g} {unit} "
        f"{'less' if gap > 0.0 else 'more'} than the best: "
        f"{'agrees' if found['agrees'] else 'does not agree'} "
        f"(up to {tolerance:.3g} {unit} less does)"
    )


def _comparison(rows: Sequence[Mapping[str, Any]]) -> str:
    fresh = any("fresh_gain" in row for row in rows)
    head = ["problem", "method", "evaluations", "simulations", "lower by %"]
    table = [[*head, *(["fresh winds %"] if fresh else []), "seconds", "  best (units as above)"]]
    for row in rows:
        best = zip(row["best_x"], row["parameters"], strict=True)
        table.append(
            [
                row["problem"],
                row["method"],
                str(row["evaluations"]),
                str(row["simulations"]),
                number(100.0 * row["gain"], "%"),
                *([number(100.0 * row["fresh_gain"], "%")] if fresh else []),
                f"{row['seconds']:.1f}",
                " ".join(_cell(x, _unit(name)) for x, name in best),
            ]
        )
    return text_table(table, left=2)


def _change(gain: float) -> str:
    return f"{number(abs(100.0 * gain), '%')} % {'lower' if gain >= 0.0 else 'higher'}"


def _cell(value: float | None, unit: tuple[str, float]) -> str:
    return number(None if value is None else unit[1] * value, unit[0])
