"""What ``pitchopt learn`` prints for people."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import click

from pitchopt.cli.output import case_line
from pitchopt.cli.tables import number, text_table

if TYPE_CHECKING:
    from pitchopt.cases import Case

__all__ = ["print_learning"]

_PAPER_CASE, _PAPER_LOSS, _PAPER_ROTATION = "biegel2011", 0.07, 20
_SHOWN = (1, 2, 3, 5, 10, 20)
_WINDS = {
    "constant": "constant wind",
    "step": "{change:+g} m/s after rotation {rotation}",
    "ramp": "{change:+g} m/s from rotation {first:g} to {last:g}",
    "drift": "wind drifts by {std:g} m/s over {rotations_correlation:g} rotations",
}


def print_learning(case: Case, document: Mapping[str, Any]) -> None:
    """The table of rotations, and what follows from it."""
    settings = document["settings"]
    learning = settings["learning"]
    click.echo(case_line(case, settings))
    click.echo(f"{document['learner']} learner{_conditions(learning)}\n")
    shown = {"weighted": case.weights.name != "unit", "windy": case.table is None}
    click.echo(_table(document, **shown) + "\n")
    for line in _lines(document, learning):
        click.echo(line)
    if _like_the_paper(case, learning):
        click.echo("\nBeside the paper (sum of the four RMS values in N m and N)\n")
        click.echo(_paper(document))
    click.echo("")


def _like_the_paper(case: Case, learning: Mapping[str, Any]) -> bool:
    """True for the paper's rotor and set-point, in one wind up to the rotation of its figures."""
    from pitchopt.cases import builtin_names, load_case

    wind, loss = learning["wind"] or {}, learning["max_power_loss"]
    changes = wind.get("rotation", wind.get("first", _PAPER_ROTATION))
    return (
        _PAPER_CASE in builtin_names()
        and case == load_case(_PAPER_CASE)
        and loss is not None
        and math.isclose(loss, _PAPER_LOSS)
        and learning["different_blade"] is None
        and wind.get("kind") != "drift"
        and changes >= _PAPER_ROTATION
    )


def _conditions(learning: Mapping[str, Any]) -> str:
    """Sensors, wind and the blade that differs, in words."""
    parts = []
    if learning["separate"]:
        parts.append("one profile for each blade")
    if learning["noise"]:
        of = "RMS" if learning["noise_of"] == "rms" else "mean"
        parts.append(f"noise {100 * learning['noise']:g} % of each load's {of}")
    if learning["quantisation"]:
        parts.append(f"quantised to {100 * learning['quantisation']:g} % of the RMS")
    if learning["delay"]:
        parts.append(f"{learning['delay']} samples late")
    if learning["dropout"]:
        parts.append(f"{100 * learning['dropout']:g} % of the samples lost")
    wind = learning["wind"]
    if wind is not None:
        parts.append(_WINDS[wind["kind"]].format(**wind))
    blade = learning["different_blade"]
    if blade is not None:
        parts.append(
            f"blade {blade['blade']}: pitch {blade['pitch_offset_deg']:+g} deg, chord x "
            f"{blade['chord']:g}"
        )
    return "".join(f", {part}" for part in parts)


def _chosen(document: Mapping[str, Any]) -> list[int]:
    """Rotations that the table shows."""
    last = len(document["rotations"])
    wind = document["settings"]["learning"]["wind"] or {}
    change = [wind[name] for name in ("rotation", "first", "last") if name in wind]
    near = [int(at) + after for at in change for after in (0, 1, 2, 3, 5, 10)]
    return sorted({n for n in (*_SHOWN, *near, last) if 1 <= n <= last})


def _table(document: Mapping[str, Any], *, weighted: bool, windy: bool) -> str:
    """References and rotations; a table of curves has no wind speed to show."""
    baseline = document["baseline"]
    kind = "weighted" if weighted else "sum"
    rows = [
        ["", "RMS", "RMS", "mean", "set-", "", "to design,", "to design,"],
        ["", kind, "cut", "torque", "point", "wind", "last passage", "whole rotation"],
        ["", "kN m", "%", "kN m", "kN m", "m/s", "-", "-"],
    ]
    key = "rms_weighted" if weighted else "rms_sum"

    def row(label: str, record: Mapping[str, Any], *ratios: float | None) -> list[str]:
        setpoint = record.get("setpoint")
        wind = record.get("wind_speed") if windy else None
        cut = 1.0 - record[key] / baseline[key] if baseline[key] > 0 else None
        return [
            label,
            number(1e-3 * record[key]),
            number(None if cut is None else 100 * cut, "%"),
            number(1e-3 * record["mean_torque"]),
            "-" if setpoint is None else number(1e-3 * setpoint),
            "-" if wind is None else f"{wind:.2f}",
            *("-" if ratio is None else f"{ratio:.2f}" for ratio in (*ratios, None, None)[:2]),
        ]

    rows.append(row("best constant pitch", baseline))
    rows.append(row("start", document["start"]))
    rows.append(row("design", document["design"], 1.0, 1.0))
    if document["design_after"] is not None:
        rows.append(row("design after the change", document["design_after"], 1.0, 1.0))
    for chosen in _chosen(document):
        rotation = document["rotations"][chosen - 1]
        ratios = rotation["ratio_to_design"], rotation["ratio_to_design_rotation"]
        rows.append(row(f"rotation {chosen}", rotation, *ratios))
    return text_table(rows, header=3)


def _lines(document: Mapping[str, Any], learning: Mapping[str, Any]) -> list[str]:
    """What is to be said besides the table."""
    experiment = document["experiment"]
    move = number(experiment["largest_move_deg"], "deg")
    out = [f"experiment: {experiment['rotations']} rotations, pitch moved by up to {move} deg"]
    if document["cut_at_20"] is not None:
        out.append(
            "cut of the plain sum of RMS after 20 rotations, against the best constant pitch: "
            f"{number(100 * document['cut_at_20'], '%')} %"
        )
    for at in ("at_10", "at_20"):
        ratio = document["ratio_to_design"][at]
        whole = document["ratio_to_design_rotation"][at]
        early = document["ratio_to_design_from_start"][at]
        if ratio is not None:
            counted = "" if early is None else f", {early:.3f} with the experiment counted"
            out.append(
                f"RMS over the design's after {at[3:]} rotations: {ratio:.3f} in the last passage, "
                f"{whole:.3f} over the whole rotation{counted}"
            )
    out += [
        f"{name.replace('_', ' ')}: {document[name]['status']}, so a better one may exist and "
        "ratios flatter"
        for name in ("design", "design_after")
        if document[name] is not None and document[name]["status"] not in ("exact", "converged")
    ]
    wind = learning["wind"]
    if wind is not None and wind["kind"] == "step" and document["design_after"] is not None:
        recovery = document["recovery_rotations"]
        took = "not recovered" if recovery is None else f"recovered in {recovery} rotations"
        out.append(f"after the step: {took} to within 1.3 of the new design")
    if wind is not None and wind["kind"] == "drift":
        out.append("the design is that for the mean wind")
    if document["setpoint_after"] is not None:
        out.append(
            f"set-point in the new wind: {number(1e-3 * document['setpoint_after'])} kN m, "
            + (
                "the same torque"
                if learning["max_power_loss"] is None
                else f"{100 * learning['max_power_loss']:g} % below the largest there"
            )
        )
    last = document["design_after"] or document["design"]
    constant = document["baseline_after"] or document["baseline"]
    rows = (
        ("learned", document["learned"]),
        ("design", last),
        ("best constant pitch", constant),
    )
    out.append(
        "RMS of a blade's bending: "
        + ", ".join(f"{name} {number(1e-3 * record['blade_rms'])} kN m" for name, record in rows)
    )
    out.append(
        "pitch travel a revolution: "
        + ", ".join(
            f"{name} {number(record['pitch_travel_deg'], 'deg')} deg" for name, record in rows
        )
    )
    if document["learned"]["outside"]:
        out.append(
            f"learned profile: {document['learned']['outside']} samples of a passage beyond what "
            "design admits"
        )
    return out + [f"rotation {event['rotation']}: {event['text']}" for event in document["events"]]


def _paper(document: Mapping[str, Any]) -> str:
    """The paper's figures (section VI.E, figure 8) beside ours."""
    rotations, design = document["rotations"], document["design"]
    late = rotations[_PAPER_ROTATION - 1] if len(rotations) >= _PAPER_ROTATION else None
    rows = [["", "paper", "here"]]

    def add(label: str, paper: str, value: float | None, form: str) -> None:
        ours = "-" if value is None else f"{value:{form}}".replace("e+0", "e")
        rows.append([label, paper, ours])

    add("sum of RMS at the start", "2.94e4", document["start"]["rms_sum"], ".2e")
    add("after 20 rotations", "2.80e3", None if late is None else late["rms_sum"], ".2e")
    add(
        "RMS cut against the best constant pitch [%]", "91",
        None if document["cut_at_20"] is None else 100 * document["cut_at_20"], ".1f",
    )  # fmt: skip
    off = None if late is None else 100 * abs(late["mean_torque"] / late["setpoint"] - 1)
    add("mean torque off the set-point [%]", "below 1", off, ".2g")
    add("sum of RMS of the design", "1.10e3", design["rms_sum"], ".2e")
    ratio = None if late is None else late["rms_sum"] / design["rms_sum"]
    add("learned over designed", "2.5", ratio, ".2f")
    return text_table(rows)
