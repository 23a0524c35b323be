"""A soft-soft tower, and what a controller that damps it would save: estimated and sized anew.

The lightest tower for its own fatigue loads, its multipliers, and from them the mass that weights
on the tower-top velocity in the regulator would save.  One of the weights is sized anew.  With so
few winds the numbers show how it is done; `pitchopt tower` has the whole study.

    python 29_tower.py [FOLDER] [--quick]
"""

import argparse
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

from pitchopt.plotting import png
from pitchopt.plotting.tower import plot_mass_change, plot_multipliers, plot_tower_walls
from pitchopt.studies.tower import LoadSets, LoadSettings, TowerLimits, Towers, mass_estimates
from pitchopt.turbines import load_turbine


def main(argv=None):
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("folder", nargs="?", default="example-output", type=Path)
    parser.add_argument("--quick", action="store_true", help="two winds of a minute")
    args = parser.parse_args(argv)

    turbine = load_turbine("iea-3.4-130")
    winds = {"wind_speeds": (7.0, 11.0, 15.0, 19.0), "duration": 300.0, "box_points": 9}
    if args.quick:
        winds = {"wind_speeds": (9.0, 15.0), "duration": 60.0, "box_points": 5}
    sets = LoadSets(turbine, LoadSettings(seeds=(1,), axes=4, **winds))
    towers = Towers(
        sets, TowerLimits(frequency_margin=None), threshold=0.01 if args.quick else 0.005
    )

    tower = towers.at(turbine.rotor.hub_height, 0.0)
    print(f"c = 0: {tower.mass / 1e3:.1f} t after {len(tower.rounds)} sets of simulations")
    for turn in tower.rounds:
        print(f"  {turn.mass / 1e3:.1f} t, sizes changed by up to {100 * turn.change:.2f} %")
    for name, values in tower.sizing.relative_multipliers().items():
        if values.sum() > 1e-3:
            print(f"  {name.replace('_', ' ')}: 1 % of the limit is {values.sum():.3f} % of mass")

    changes = mass_estimates(towers, tower, [0.0, 0.03, 0.1, 0.2], step=0.03)
    again = towers.at(turbine.rotor.hub_height, 0.2)
    print("estimated from one tower: c, mean damage, first-order, high-order [% of mass]")
    for k, weight in enumerate(changes.weights):
        row = (changes.first_order[k], changes.high_order[k])
        print(
            f"  {weight:4.2f} {100 * changes.damage_change[k].mean():+7.2f} "
            + " ".join(f"{100 * value / tower.mass:+7.3f}" for value in row)
        )
    print(f"sized anew for c = 0.2: {100 * (again.mass / tower.mass - 1):+.3f} %")
    for part in changes.estimates[-1].assumptions:
        print(f"  {part.name}: {part.verdict}; {part.message}")
    print(f"{len(towers.used)} sets of {tower.load_set.simulations} simulations")

    figure = Figure(figsize=(13.0, 4.0), layout="constrained")
    left, middle, right = figure.subplots(1, 3)
    plot_tower_walls({"c = 0": tower.design, "c = 0.2": again.design}, ax=left)
    plot_multipliers({"c = 0": tower.sizing.relative_multipliers().fatigue}, ax=middle)
    middle.set_xlabel("station of fatigue, base first")
    plot_mass_change(
        changes.weights, changes.first_order, changes.high_order, mass=tower.mass, ax=right
    )
    saved = 100.0 * (again.mass / tower.mass - 1.0)
    right.plot([0.2], [saved], "k*", ms=11, label="sized anew")
    right.set_ylim(top=max(0.0, np.max(right.get_ylim())))
    right.legend(frameon=False)
    args.folder.mkdir(parents=True, exist_ok=True)
    path = args.folder / "29_tower.png"
    path.write_bytes(png(figure, dpi=110))
    print(path)


if __name__ == "__main__":
    main()
