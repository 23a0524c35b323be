"""A table of lowest pitch against peak loads, tuned one wind speed after the other.

Algorithm 1 of Zalkind et al. with their settings on the NREL 5 MW and on the IEA 15 MW, for three
weights of the load (kappa), beside the paper's changes; the pitches that were tried, and the gust
of the worst seed with and without the tuned table (figures 7 and 8).

    python 23_minimum_pitch.py [FOLDER] [--quick]
"""

import argparse
from pathlib import Path

import numpy as np

from pitchopt.exports import write_files
from pitchopt.plotting import (
    PitchSamples,
    minimum_pitch_figure,
    pitch_tables_figure,
    png,
)
from pitchopt.studies.tuning import (
    TableRuns,
    TuningPlant,
    minimum_pitch_base,
    tune_minimum_pitch,
)

PAPER = {"tower": -0.109, "blade": -0.085, "power": -0.0003}


def percent(change):
    return ", ".join(f"{name} {100 * share:+.2f} %" for name, share in change.items())


def samples_of(tuning):
    """What the first round tried, over the pitch to begin with."""
    problem, study = tuning.problem, tuning.study
    start = problem.reference.measures
    good = [e for e in study.evaluations if e.status == "ok"]
    return PitchSamples(
        pitch=np.array([e.x[0] for e in good]),
        cost=np.array([e.cost for e in good]),
        load=np.array([e.measures["flapwise_moment"] for e in good]) / start["flapwise_moment"],
        power=np.array([e.measures["power"] for e in good]) / start["power"],
    )


def main(argv=None):
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("folder", nargs="?", default="example-output", type=Path)
    parser.add_argument("--quick", action="store_true", help="shorter, one turbine and weight")
    args = parser.parse_args(argv)

    coarse = {"duration": 40.0, "skip": 20.0, "box_points": 7} if args.quick else {}
    files = {}
    print(f"paper: {percent(PAPER)}")
    for turbine in ("nrel-5mw",) if args.quick else ("nrel-5mw", "iea-15-240"):
        plant = TuningPlant(turbine, **coarse)
        seeds = (1, 2) if args.quick else tuple(range(1, 7))
        runs = TableRuns(plant, minimum_pitch_base(plant), seeds)
        tables = {}
        for kappa in (0.03,) if args.quick else (0.01, 0.03, 0.1):
            result = tune_minimum_pitch(plant, kappa=kappa, seeds=seeds, runs=runs)
            tables["to begin with"] = result.initial
            tables[f"kappa {kappa:g}"] = result.table
            print(
                f"{turbine}, kappa {kappa:g}: "
                f"{percent(result.with_table.change(result.with_initial))} against the table to "
                f"begin with, {percent(result.with_table.change(result.without))} against none; "
                f"{result.simulations} simulations"
            )
        files[f"23_{turbine}_tables.png"] = png(pitch_tables_figure(tables, title=turbine))
        tuned = next(point for point in result.breakpoints if point.rounds)
        first = tuned.rounds[0]
        gust = {
            "to begin with": first.problem.runs(first.problem.start)[0].simulation,
            "tuned": first.problem.runs([first.pitch])[0].simulation,
        }
        title = f"{turbine}, {tuned.wind_speed:g} m/s, kappa {kappa:g}"
        files[f"23_{turbine}_breakpoint.png"] = png(
            minimum_pitch_figure(samples_of(first), gust, title=title)
        )
    args.folder.mkdir(parents=True, exist_ok=True)
    for path in write_files(args.folder, files):
        print(path)


if __name__ == "__main__":
    main()
