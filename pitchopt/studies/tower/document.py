"""The tower study as plain data: JSON document and CSV tables, the paper's figures beside ours.

Masses in kg, energies in GWh, costs in $/MWh, heights in m; changes are shares.
"""

from __future__ import annotations

import dataclasses
from typing import Any

import numpy as np

from pitchopt.exports.records import records_csv
from pitchopt.sensitivity import Estimate
from pitchopt.studies.tower.cost import JOULES_PER_MWH
from pitchopt.studies.tower.estimates import CostMap
from pitchopt.studies.tower.frozen_loads import OptimalTower
from pitchopt.studies.tower.published import MEAN_DAMAGE_CHANGE, PUBLISHED, TURBINE
from pitchopt.studies.tower.results import CoDesign, ConfigurationResult, Effort
from pitchopt.studies.tower.study import TowerStudy

__all__ = ["comparison_rows", "tower_csv", "tower_document"]

_GWH = JOULES_PER_MWH * 1e3


def tower_document(study: TowerStudy) -> dict[str, Any]:
    """Everything about a study."""
    settings = study.settings
    return {
        "problem": "tower",
        "turbine": study.turbine,
        "settings": {
            "loads": dataclasses.asdict(settings.loads),
            "limits": dataclasses.asdict(settings.limits),
            "weights": settings.weights,
            "height_factors": settings.height_factors,
            "step": settings.step,
            "threshold": settings.threshold,
            "follow_height": settings.follow_height,
        },
        "reference_height": study.reference_height,
        "configurations": {name: _configuration(part) for name, part in study.results.items()},
        "tables": comparison_rows(study),
        "sets_simulated": study.sets_simulated,
        "seconds": study.seconds,
    }


def comparison_rows(study: TowerStudy) -> list[dict[str, Any]]:
    """Tables 1 to 3 of the paper and figures of its text: quantity, unit, paper, ours.

    The paper's are left out for turbines other than its own.
    """
    rows: list[dict[str, Any]] = []
    for name, part in study.results.items():
        published: dict[str, float] = {}
        if study.turbine == TURBINE:
            published = {**PUBLISHED[name], "damage": MEAN_DAMAGE_CHANGE}
        changes = part.cost_change
        without, with_ = part.without, part.with_codesign

        def add(table: str, key: str, words: str, unit: str, ours: float, *, name: str = name,
                published: Any = published) -> None:  # fmt: skip
            rows.append(
                {
                    "table": table,
                    "configuration": name,
                    "quantity": words,
                    "unit": unit,
                    "paper": published.get(key),
                    "ours": float(ours),
                }
            )

        for kind, key in (
            ("co-design", "cost_change_codesign"),
            ("first-order", "cost_change_first_order"),
            ("high-order", "cost_change_high_order"),
            ("with response", "cost_change_with_response"),
        ):
            if kind not in changes:
                continue
            add("1", key, f"change of cost, {kind}", "-", changes[kind])
        for label, found, tail in (("without", without, ""), ("co-design", with_, "_codesign")):
            tower = found.tower
            add("2", f"height{tail}", f"hub height, {label}", "m", tower.hub_height)
            if tail:
                add("2", "weight_codesign", f"weight c, {label}", "s2/m2", tower.tower_velocity)
            add("2", f"mass{tail}", f"tower mass, {label}", "t", tower.mass / 1e3)
            add("2", f"energy{tail}", f"energy, {label}", "GWh", found.energy / _GWH)
            add("2", f"cost{tail}", f"cost of energy, {label}", "$/MWh", found.cost)
        share = part.estimate_effort.seconds / max(part.codesign_effort.seconds, 1e-9)
        add("3", "sets_estimate", "sets, high-order estimate", "-", part.estimate_effort.sets)
        add("3", "sets_codesign", "sets, co-design", "-", part.codesign_effort.sets)
        add("3", "iterations_codesign", "iterations, co-design", "-",
            part.codesign_effort.iterations)  # fmt: skip
        add("3", "time_estimate", "time of the estimate over co-design's", "-", share)
        multiplier = part.reference.sizing.relative_multipliers().frequency
        if multiplier.size:
            add("text", "frequency_multiplier", "multiplier of the first frequency", "-",
                float(multiplier[0]))  # fmt: skip
        add("text", "reference", "mass at the reference height, c = 0", "t",
            part.reference.mass / 1e3)  # fmt: skip
        change = part.estimates.damage_change[-1].mean()
        add("text", "damage", "change of mean damage at the largest c", "-", change)
    return rows


def tower_csv(study: TowerStudy) -> str:
    """The rows of `comparison_rows` as CSV."""
    return records_csv(comparison_rows(study))


def _configuration(part: ConfigurationResult) -> dict[str, Any]:
    estimates = part.estimates
    return {
        "reference": {
            **_tower(part.reference),
            "cost": part.reference_cost,
            "energy_gwh": part.reference_energy / _GWH,
        },
        "estimates": {
            "weights": estimates.weights,
            "damage": estimates.damage,
            "mean_damage_change": estimates.damage_change.mean(axis=1),
            "first_order": estimates.first_order,
            "high_order": estimates.high_order,
            "load_response": estimates.load_response,
            "with_response": estimates.with_response,
            "true": part.true_change,
            "details": [_estimate(e) for e in estimates.estimates],
        },
        "truth": [_tower(tower) for tower in part.truth],
        "maps": {
            **{
                kind.replace(" ", "_").replace("-", "_"): _map(found)
                for kind, found in part.estimated_maps.items()
            },
            "true": None if part.true_map is None else _map(part.true_map),
        },
        "cost_change": part.cost_change,
        "unsettled": [
            {"hub_height": t.hub_height, "weight": t.tower_velocity, "change": t.rounds[-1].change}
            for t in part.unsettled
        ],
        "without": _codesign(part.without),
        "codesign": _codesign(part.with_codesign),
        "effort": {
            "estimate": _effort(part.estimate_effort),
            "without": _effort(part.without_effort),
            "codesign": _effort(part.codesign_effort),
        },
    }


def _tower(tower: OptimalTower) -> dict[str, Any]:
    sizing = tower.sizing
    return {
        "hub_height": tower.hub_height,
        "weight": tower.tower_velocity,
        "mass": tower.mass,
        "diameter": tower.design.diameter,
        "thickness": tower.design.thickness,
        "frequencies_hz": sizing.frequencies.value,
        "multipliers": dict(sizing.relative_multipliers().items()),
        "constraints": dict(sizing.constraints.items()),
        "rounds": [
            {"simulated_mass": r.simulated_mass, "mass": r.mass, "change": r.change}
            for r in tower.rounds
        ],
        "converged": tower.converged,
        "mean_power": tower.load_set.power,
        "largest_rotor_speed": tower.load_set.largest_speed,
    }


def _estimate(found: Estimate) -> dict[str, Any]:
    return {
        "weight": float(np.ravel(found.dc)[0]),
        "first_order": found.first_order,
        "high_order": found.high_order,
        "attained": found.attained,
        "largest": [
            {"name": c.name, "multiplier": c.multiplier, "high_order": c.high_order}
            for c in found.largest(5)
        ],
        "assumptions": [
            {"name": a.name, "verdict": a.verdict, "measure": a.measure, "message": a.message}
            for a in found.assumptions
        ],
    }


def _map(costs: CostMap) -> dict[str, Any]:
    height, weight, lowest = costs.lowest()
    return {
        "heights": costs.heights,
        "weights": costs.weights,
        "mass": costs.mass,
        "energy_gwh": costs.energy / _GWH,
        "cost": costs.cost,
        "lowest": {"hub_height": height, "weight": weight, "cost": lowest},
    }


def _codesign(found: CoDesign) -> dict[str, Any]:
    return {
        "tower": _tower(found.tower),
        "energy_gwh": found.energy / _GWH,
        "cost": found.cost,
        "points": found.search.points,
        "costs": found.search.values,
        "converged": found.search.converged,
    }


def _effort(effort: Effort) -> dict[str, Any]:
    return {"sets": effort.sets, "seconds": effort.seconds, "iterations": effort.iterations}
