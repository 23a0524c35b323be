"""
Figures 2 to 5: a tower designed together with its controller
=============================================================

Damage over the controller's weight, towers and their multipliers, estimated and true masses, and
the cost of energy over height and weight.  Drawn from the **committed record** of the full study,
``benchmarks/results/tower_study.json`` (``pitchopt tower``, half an hour); the tables beside the
paper's are in :doc:`/sensitivity`.
"""

from types import SimpleNamespace

import numpy as np
from example_figures import records
from matplotlib.figure import Figure

from pitchopt.plotting.tower import (
    plot_cost_map,
    plot_damage_over_weight,
    plot_mass_change,
    plot_multipliers,
    plot_tower_diameters,
    plot_tower_walls,
)

(study,) = records("tower_study")
configurations = study["configurations"]

# %%
# Figure 2, for both towers:

damage = Figure(figsize=(10.0, 4.0), layout="constrained")
for ax, (name, part) in zip(
    damage.subplots(1, 2, sharey=True), configurations.items(), strict=True
):
    values = np.array(part["estimates"]["damage"])
    plot_damage_over_weight(part["estimates"]["weights"], values / values[0] - 1.0, ax=ax)
    ax.set_title(f"{name} tower")

# %%
# Figure 3: designs, multipliers of frequency and geometry (summed over their places) and of
# fatigue.

towers = {
    name: SimpleNamespace(
        diameter=np.array(part["reference"]["diameter"]),
        thickness=np.array(part["reference"]["thickness"]),
        length=study["reference_height"] - 2.0,
    )
    for name, part in configurations.items()
}
kinds = [key for key in configurations["standard"]["reference"]["multipliers"] if key != "fatigue"]
groups = {name: part["reference"]["multipliers"] for name, part in configurations.items()}
designs = Figure(figsize=(11.0, 7.6), layout="constrained")
(a, b), (c, d) = designs.subplots(2, 2)
plot_tower_diameters(towers, ax=a)
plot_tower_walls(towers, ax=b)
plot_multipliers(
    {name: [sum(found[key]) for key in kinds] for name, found in groups.items()},
    labels=[key.replace("_", "\n") for key in kinds],
    ax=c,
)
plot_multipliers({name: found["fatigue"] for name, found in groups.items()}, ax=d)
d.set_xlabel("station of fatigue, base first")

# %%
# Figure 4:

masses = Figure(figsize=(10.0, 4.0), layout="constrained")
for ax, (name, part) in zip(
    masses.subplots(1, 2, sharey=True), configurations.items(), strict=True
):
    found = part["estimates"]
    plot_mass_change(
        found["weights"],
        found["first_order"],
        found["high_order"],
        found["true"],
        found["with_response"],
        mass=part["reference"]["mass"],
        ax=ax,
    )
    ax.set_title(f"{name} tower")

# %%
# Figure 5: change of the cost of energy by the first-order and the high-order estimate, and of
# towers that were sized anew at every point.

from pitchopt.studies.tower import CostMap, CostModel, Economics, LoadSettings
from pitchopt.turbines import load_turbine

GWH = 3.6e12
turbine = load_turbine(study["turbine"])
economics = Economics(
    model=CostModel(
        rated_power=turbine.rated_power,
        rotor_diameter=2.0 * turbine.rotor.radius,
        hub_height=turbine.rotor.hub_height,
    ),
    settings=LoadSettings(),
    operating_energy=GWH * configurations["standard"]["reference"]["energy_gwh"],
)
cost = Figure(figsize=(14.0, 8.0), layout="constrained")
for row, (name, part) in zip(cost.subplots(2, 3), configurations.items(), strict=True):
    for ax, kind in zip(row, ("first_order", "high_order", "true"), strict=True):
        found = part["maps"][kind]
        chart = CostMap(
            heights=np.array(found["heights"]),
            weights=np.array(found["weights"]),
            mass=np.array(found["mass"]),
            energy=GWH * np.array(found["energy_gwh"]),
            economics=economics,
        )
        off = np.abs(chart.cost / np.array(found["cost"]) - 1.0).max()
        assert off < 1e-9, "the record's costs are those of this model"
        plot_cost_map(
            chart,
            reference_height=study["reference_height"],
            reference_cost=part["without"]["cost"],
            ax=ax,
        )
        ax.set_title(f"{name}, {'sized anew' if kind == 'true' else kind.replace('_', '-')}")
