"""What ``pitchopt tower`` prints for people."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import click

from pitchopt.cli.tables import text_table

__all__ = ["print_tower"]


def print_tower(document: Mapping[str, Any]) -> None:
    """Reference towers, masses over the weight, the paper's tables beside ours."""
    for name, part in document["configurations"].items():
        click.echo(_reference(name, part) + "\n")
        click.echo(_masses(part) + "\n")
        click.echo(_broken(part) + "\n")
        click.echo("\n".join([_settled(part), *_at_bounds(part)]) + "\n")
    click.echo(_tables(document["tables"]) + "\n")


def _reference(name: str, part: Mapping[str, Any]) -> str:
    tower = part["reference"]
    sums = {key: float(sum(values)) for key, values in tower["multipliers"].items()}
    largest = sorted((key for key in sums if sums[key] > 1e-3), key=lambda key: -sums[key])
    carried = ", ".join(f"{key.replace('_', ' ')} {sums[key]:.3f}" for key in largest)
    first = float(min(row[0] for row in tower["frequencies_hz"]))
    return (
        f"{name} tower, hub {tower['hub_height']:g} m, c = 0: {tower['mass'] / 1e3:.1f} t, first "
        f"frequency {first:.4f} Hz, {tower['cost']:.3f} $/MWh\n"
        f"multipliers over mass: {carried}"
    )


def _masses(part: Mapping[str, Any]) -> str:
    found, mass = part["estimates"], part["reference"]["mass"]
    kinds = {"first_order": "first-order", "high_order": "high-order"}
    if found["with_response"] is not None:
        kinds["with_response"] = "with response"
    rows = [["c [s2/m2]", "mean damage [%]", *(f"{word} [%]" for word in kinds.values()),
             "sized anew [%]", *(f"error {word}" for word in kinds.values())]]  # fmt: skip
    for k, weight in enumerate(found["weights"]):
        true = 100.0 * found["true"][k] / mass
        shares = [100.0 * found[key][k] / mass for key in kinds]
        rows.append(
            [
                f"{weight:g}",
                f"{100.0 * found['mean_damage_change'][k]:+.2f}",
                *(f"{share:+.3f}" for share in shares),
                f"{true:+.3f}",
                *(f"{share - true:+.3f}" for share in shares),
            ]
        )
    rho = found["load_response"]
    note = "" if rho is None else f"; response of the loads to the tower {rho:.2f}"
    return f"change of the optimal mass{note}\n" + text_table(rows)


def _broken(part: Mapping[str, Any]) -> str:
    """Assumptions at the largest weight."""
    last = part["estimates"]["details"][-1]
    lines = [f"  {a['name']}: {a['verdict']}; {a['message']}" for a in last["assumptions"]]
    return f"assumptions at c = {last['weight']:g}\n" + "\n".join(lines)


def _settled(part: Mapping[str, Any]) -> str:
    """What did not converge."""
    lines = [
        f"  tower at a hub height of {tower['hub_height']:g} m with c = {tower['weight']:g}: sizes "
        f"still change by {100.0 * tower['change']:.2g} % with its loads"
        for tower in part["unsettled"]
    ] + [
        f"  search of the lowest cost {words}: stopped after {len(part[key]['costs'])} towers"
        for key, words in (("without", "at c = 0"), ("codesign", "over height and c"))
        if not part[key]["converged"]
    ]
    if not lines:
        return "all towers and searches converged"
    return "not converged\n" + "\n".join(lines)


def _at_bounds(part: Mapping[str, Any]) -> list[str]:
    """Lowest costs that a wider range might lower."""
    studied = part["maps"]["high_order"]
    heights, weight = studied["heights"], studied["weights"][-1]
    lines = []
    for key, words in (("without", "at c = 0"), ("codesign", "over height and c")):
        tower = part[key]["tower"]
        ends = [
            f"{end} hub height"
            for end, height in (("least", heights[0]), ("largest", heights[-1]))
            if abs(tower["hub_height"] / height - 1.0) < 1e-6
        ]
        if key == "codesign" and tower["weight"] >= (1.0 - 1e-6) * weight:
            ends.append("largest c")
        if ends:
            lines.append(f"lowest cost {words}: at the {' and the '.join(ends)} studied")
    return lines


def _tables(rows: list[Mapping[str, Any]]) -> str:
    table = [["table", "configuration", "quantity", "unit", "paper", "ours"]]
    for row in rows:
        share = row["unit"] == "-" and "change" in row["quantity"]
        factor, unit = (100.0, "%") if share else (1.0, row["unit"])
        cells = [
            "" if value is None else f"{factor * value:.3f}"
            for value in (row["paper"], row["ours"])
        ]
        table.append([row["table"], row["configuration"], row["quantity"], unit, *cells])
    return "the paper's tables\n" + text_table(table, left=4)
