"""Zeroth-order tuning of the speed regulator against grids (figure 6 of Zalkind et al.).

The NREL 5 MW in class A: grids of 6, 8 and 10 points each way, and the zeroth-order tuner with
several numbers of samples and stages from four starts, three times each with other directions.
The picture shows where each ends and what it takes; the table has means over all searches, and the
second one for each start those of the tuner.  Costs are over that of the suggested point.

    python 24_grid_comparison.py [FOLDER] [--quick]
"""

import argparse
from pathlib import Path

from pitchopt.exports import write_files
from pitchopt.plotting import png
from pitchopt.plotting.tuning_comparison import comparison_figure
from pitchopt.studies.tuning import QUADRANTS, SpeedRegulator, TuningPlant, compare_with_grids


def main(argv=None):
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("folder", nargs="?", default="example-output", type=Path)
    parser.add_argument("--quick", action="store_true", help="coarser, shorter, fewer searches")
    args = parser.parse_args(argv)

    coarse = {"duration": 60.0, "skip": 20.0, "box_points": 5, "box_interval": 0.25}
    few = {"grids": (3, 4), "searches": ((3, 1), (4, 1)), "repeats": 1}
    problem = SpeedRegulator(
        TuningPlant("nrel-5mw", turbulence="A", **(coarse if args.quick else {}))
    )
    comparison = compare_with_grids(problem, **(few if args.quick else {}))
    print(comparison.table())
    print(f"{comparison.simulations} simulations in all, points in common made once\n")
    print(f"{'mean cost by start':<22}" + "".join(f"{name:>13}" for name in QUADRANTS))
    by_start = {name: comparison.summaries(name) for name in QUADRANTS}
    for rows in zip(*by_start.values(), strict=True):
        print(f"{rows[0].method:<22}" + "".join(f"{row.cost:>13.3f}" for row in rows))
    args.folder.mkdir(parents=True, exist_ok=True)
    files = {"24_comparison.png": png(comparison_figure(comparison))}
    for path in write_files(args.folder, files):
        print(path)


if __name__ == "__main__":
    main()
