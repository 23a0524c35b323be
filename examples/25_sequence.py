"""Controllers tuned one after the other: torque gain, speed regulator, lowest pitch, and again.

Section 3.4 of Zalkind et al. on the NREL 5 MW, with the settings that their guidelines give: the
gain of the torque law, the speed regulator with it, the table of lowest pitch with both, then gain
and regulator once more with the table in place.  Each tuning closes with a check that its minimum
is as good as that of kriging through all its evaluations, which is simulated for that.
After the regulator found here the table to begin with stays, for kappa of 0.01, 0.03 and 0.1.

    python 25_sequence.py [FOLDER] [--quick]
"""

import argparse
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

from pitchopt.exports import write_files
from pitchopt.plotting import pitch_tables_figure, plot_design_space, plot_posterior, png
from pitchopt.studies.tuning import TuningPlant, tune_in_sequence, tune_minimum_pitch


def print_steps(result):
    """A row for each tuning: what was found, what it gained, whether kriging agrees."""
    print(
        f"{'step':<23}{'from':>14}{'to':>14}{'cost':>10}{'simulations':>13}"
        f"{'kriging at':>14}{'gap':>9}{'allowed':>10}  agree"
    )
    for step in result.steps:
        tuning, check = step.tuning, step.tuning.agreement
        start = tuning.problem.reference.cost
        row = [
            " ".join(f"{v:.3f}" for v in x) for x in (tuning.problem.start, tuning.x, check.kriging)
        ]
        print(
            f"{step.name:<23}{row[0]:>14}{row[1]:>14}"
            f"{100.0 * (tuning.cost - start) / abs(start):>+8.2f}%{tuning.simulations:>13}"
            f"{row[2]:>14}{100.0 * check.gap / abs(start):>8.2f}%"
            f"{100.0 * check.tolerance / abs(start):>8.2f}%  {'yes' if check.agrees else 'no'}"
        )


def checks_figure(result):
    """Kriging of each tuning's costs, with the tuner's minimum and kriging's."""
    figure = Figure(figsize=(11.0, 8.4), layout="constrained")
    for ax, step in zip(figure.subplots(2, 2).flat, result.steps, strict=True):
        check = step.tuning.agreement
        if len(step.tuning.problem.space) == 1:
            plot_posterior(check.process, label="cost [W]", ax=ax)
            ax.axvline(check.tuner[0], color="black", linestyle="--", linewidth=1.0)
            ax.axvline(check.kriging[0], color="black", linestyle=":", linewidth=1.0)
        else:
            plot_design_space(check.process, label="cost [N m]", ax=ax)
            for x, marker in ((check.tuner, "*"), (check.kriging, "X")):
                ax.plot(*x, marker, color="white", markeredgecolor="black", markersize=12, zorder=4)
        ax.set_title(step.name)
    return figure


def main(argv=None):
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("folder", nargs="?", default="example-output", type=Path)
    parser.add_argument("--quick", action="store_true", help="coarser, shorter, fewer stages")
    args = parser.parse_args(argv)

    coarse = {"duration": 40.0, "skip": 20.0, "box_points": 5, "box_interval": 0.25}
    plant = TuningPlant("nrel-5mw", **(coarse if args.quick else {}))
    seeds = (1, 2) if args.quick else tuple(range(1, 7))
    lowest = []

    def minimum_pitch(controller):
        lowest.append(tune_minimum_pitch(plant, base=controller, seeds=seeds))
        return lowest[0].table

    result = tune_in_sequence(
        plant,
        minimum_pitch=minimum_pitch,
        settings={"stages": 1, "preliminary": 2} if args.quick else None,
    )
    print_steps(result)
    (found,) = lowest
    change = found.with_table.change(found.with_initial)
    print(
        "lowest pitch, against the table to begin with: "
        + ", ".join(f"{name} {100.0 * share:+.2f} %" for name, share in change.items())
        + f"; {found.simulations} simulations"
    )
    for speed, pitch in zip(found.table.wind_speed[1:-1], found.table.pitch[1:-1], strict=True):
        print(f"  {speed:5.2f} m/s  {np.degrees(pitch):6.2f} deg")
    for name, moved in result.changes().items():
        shares = ", ".join(f"{100.0 * share:+.1f} %" for share in moved)
        print(f"{name}, tuned again with the table: moved by {shares} of its range")
    args.folder.mkdir(parents=True, exist_ok=True)
    tables = {"to begin with": found.initial, "tuned": found.table}
    files = {
        "25_checks.png": png(checks_figure(result)),
        "25_lowest_pitch.png": png(pitch_tables_figure(tables, title=plant.turbine.name)),
    }
    for path in write_files(args.folder, files):
        print(path)


if __name__ == "__main__":
    main()
