"""Figures 2 to 5 of the tower study as PNG files."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import partial
from typing import TYPE_CHECKING

import numpy as np

from pitchopt.studies.tower.estimates import CostMap
from pitchopt.studies.tower.results import ConfigurationResult
from pitchopt.studies.tower.study import TowerStudy

if TYPE_CHECKING:
    from matplotlib.figure import Figure

__all__ = ["tower_pictures"]

_GEOMETRY = {
    "largest_diameter": "largest\ndiameter",
    "top_diameter": "top\ndiameter",
    "widening": "no\nwidening",
    "taper": "taper",
    "wall_step": "wall\nstep",
    "slenderness": "D / t",
    "least_wall": "least\nwall",
    "largest_wall": "largest\nwall",
    "frequency": "frequency",
}


def tower_pictures(study: TowerStudy) -> Mapping[str, Callable[[], bytes]]:
    """Pictures by the names of their files, drawn when they are asked for."""
    return {
        f"{name}.png": partial(_png, draw, study)
        for name, draw in (
            ("damage", _damage),
            ("designs", _designs),
            ("mass", _mass),
            ("cost", _cost),
        )
    }


def _png(draw: Callable[[TowerStudy], Figure], study: TowerStudy) -> bytes:
    from pitchopt.plotting import png

    return png(draw(study))


def _figure(width: float, height: float) -> Figure:
    from matplotlib.figure import Figure

    return Figure(figsize=(width, height), layout="constrained")


def _damage(study: TowerStudy) -> Figure:
    from pitchopt.plotting.tower import plot_damage_over_weight

    figure = _figure(5.4 * len(study.results), 4.0)
    panels = figure.subplots(1, len(study.results), squeeze=False, sharey=True)[0]
    for ax, (name, part) in zip(panels, study.results.items(), strict=True):
        plot_damage_over_weight(part.estimates.weights, part.estimates.damage_change, ax=ax)
        ax.set_title(f"{name} tower")
    return figure


def _designs(study: TowerStudy) -> Figure:
    from pitchopt.plotting.tower import (
        plot_multipliers,
        plot_tower_diameters,
        plot_tower_walls,
    )

    figure = _figure(11.0, 7.6)
    (a, b), (c, d) = figure.subplots(2, 2)
    towers = {name: part.reference.design for name, part in study.results.items()}
    plot_tower_diameters(towers, ax=a)
    plot_tower_walls(towers, ax=b)
    relative = {
        name: dict(part.reference.sizing.relative_multipliers().items())
        for name, part in study.results.items()
    }
    sums = {
        name: np.array([groups[key].sum() for key in _GEOMETRY])
        for name, groups in relative.items()
    }
    plot_multipliers(sums, labels=list(_GEOMETRY.values()), ax=c)
    plot_multipliers({name: groups["fatigue"] for name, groups in relative.items()}, ax=d)
    a.set_title("diameter of the wall's middle")
    b.set_title("wall")
    c.set_title("geometry and frequency, summed over places")
    d.set_title("fatigue")
    d.set_xlabel("station, base first")
    return figure


def _mass(study: TowerStudy) -> Figure:
    from pitchopt.plotting.tower import plot_mass_change

    figure = _figure(5.4 * len(study.results), 4.0)
    panels = figure.subplots(1, len(study.results), squeeze=False, sharey=True)[0]
    for ax, (name, part) in zip(panels, study.results.items(), strict=True):
        estimates = part.estimates
        plot_mass_change(
            estimates.weights,
            estimates.first_order,
            estimates.high_order,
            part.true_change,
            estimates.with_response,
            mass=part.reference.mass,
            ax=ax,
        )
        ax.set_title(f"{name} tower")
    return figure


def _cost(study: TowerStudy) -> Figure:
    from pitchopt.plotting.tower import plot_cost_map

    def maps(part: ConfigurationResult) -> dict[str, CostMap]:
        found = dict(part.estimated_maps)
        return found if part.true_map is None else {**found, "sized anew": part.true_map}

    columns = max(len(maps(part)) for part in study.results.values())
    figure = _figure(5.0 * columns, 4.0 * len(study.results))
    rows = figure.subplots(len(study.results), columns, squeeze=False)
    for row, (name, part) in zip(rows, study.results.items(), strict=True):
        shown = maps(part)
        for ax in row[len(shown) :]:
            ax.set_axis_off()
        for ax, (kind, costs) in zip(row, shown.items(), strict=False):
            plot_cost_map(
                costs,
                reference_height=study.reference_height,
                reference_cost=part.without.cost,
                ax=ax,
            )
            ax.set_title(f"{name}, {kind}")
    return figure
