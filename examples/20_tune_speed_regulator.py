"""Speed regulator tuned by zeroth-order steps, with the design space that kriging draws.

The NREL 5 MW a little above rated wind speed in turbulence of class B: natural frequency and
damping of the regulator for the least fatigue of the tower within the limit of the generator
speed, as figures 3, 4 and 5 of Zalkind, Dall'Anese and Pao (Wind Energy Science, 2020) show it.

    python 20_tune_speed_regulator.py [FOLDER] [--quick]
"""

import argparse
from pathlib import Path

import numpy as np
from matplotlib import pyplot as plt

from pitchopt.exports import write_files
from pitchopt.plotting import plot_design_space, plot_progress, png
from pitchopt.studies.tuning import SpeedRegulator, TuningPlant
from pitchopt.tuning import GaussianProcess, ZerothOrder, run_study, settling

RPM = 30.0 / np.pi
QUANTITIES = {
    "cost": ("cost [MN m]", 1e-6),
    "tower_load": ("tower load [MN m]", 1e-6),
    "generator_speed": ("largest generator speed [rpm]", RPM),
}
AXES = {"xlabel": "natural frequency [rad/s]", "ylabel": "damping ratio [-]"}


def kriging(space, evaluations, name):
    """Of the cost or a measure in the unit that is shown."""
    factor = QUANTITIES[name][1]
    good = [e for e in evaluations if e.status == "ok"]
    values = [factor * (e.cost if name == "cost" else e.measures[name]) for e in good]
    return GaussianProcess.fit(space, [e.x for e in good], values)


def samples_figure(problem, tuner, evaluations):
    """Estimated cost with the tuner's way after the first stage and the last; costs, settling."""
    figure, axes = plt.subplots(2, 2, figsize=(11.0, 8.0), layout="constrained")
    label, factor = QUANTITIES["cost"]
    first = [e for e in evaluations if e.origin.split(".")[0] in ("start", "search 1", "step 1")]
    path = np.array([record.x for record in tuner.records] + [tuner.records[-1].next_x])
    for ax, part, way, title in (
        (axes[0, 0], first, path[:2], "first stage"),
        (axes[0, 1], evaluations, path, "all stages"),
    ):
        plot_design_space(kriging(problem.space, part, "cost"), label=label, ax=ax)
        ax.plot(*way.T, "-+", color="tab:red", markersize=11, label="z", zorder=4)
        ax.legend(fontsize="small")
        ax.set(**AXES, title=title)
    costs = [factor * e.cost for e in evaluations]
    plot_progress(costs, start=factor * problem.reference.cost, label=label, ax=axes[1, 0])
    axes[1, 1].plot(np.arange(1, len(tuner.stage_costs) + 1), settling(tuner.stage_costs), "o-")
    axes[1, 1].set(xlabel="stage", ylabel="settling function [-]")
    return figure


def design_space_figure(problem, evaluations):
    """Estimates and their standard deviations."""
    figure, axes = plt.subplots(3, 2, figsize=(10.0, 11.0), layout="constrained")
    for row, (name, (label, _)) in zip(axes, QUANTITIES.items(), strict=True):
        process = kriging(problem.space, evaluations, name)
        for ax, show in zip(row, ("mean", "std"), strict=True):
            plot_design_space(process, show=show, label=label, ax=ax).set(**AXES)
    return figure


def series_figure(problem, best, window):
    """Pitch, generator speed and tower moment before and after."""
    figure, axes = plt.subplots(3, 1, figsize=(9.0, 7.0), sharex=True, layout="constrained")
    for label, x in (("start", problem.start), ("tuned", best)):
        run = problem.runs(x)[0].simulation
        shown = (run.time >= window[0]) & (run.time <= window[1])
        for ax, (name, factor, axis) in zip(
            axes,
            (
                ("BldPitch1", 180.0 / np.pi, "pitch [deg]"),
                ("GenSpeed", RPM, "generator speed [rpm]"),
                ("TwrBsMyt", 1e-6, "tower base [MN m]"),
            ),
            strict=True,
        ):
            ax.plot(run.time[shown], factor * run[name][shown], label=f"{label} {np.round(x, 2)}")
            ax.set_ylabel(axis)
    axes[1].axhline(RPM * problem.soft_speed, color="0.5", linestyle="--", linewidth=1.0)
    axes[0].legend()
    axes[-1].set_xlabel("time [s]")
    return figure


def main(argv=None):
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("folder", nargs="?", default="example-output", type=Path)
    parser.add_argument("--quick", action="store_true", help="coarser and shorter")
    args = parser.parse_args(argv)

    quick = {"duration": 60.0, "skip": 20.0, "box_points": 5, "box_interval": 0.25}
    plant = TuningPlant("nrel-5mw", turbulence="B", **(quick if args.quick else {}))
    problem = SpeedRegulator(plant)
    options = problem.tuner_options("zoo") | ({"stages": 2} if args.quick else {})
    tuner = ZerothOrder(problem.space, start=problem.start, seed=1, **options)
    result = run_study(problem, tuner, evaluations=tuner.most_evaluations + 1)

    before, after = problem.reference, result.best.evaluation
    for label, x, found in (("start", problem.start, before), ("tuned", after.x, after)):
        print(
            f"{label}: omega {x[0]:.3f} rad/s, zeta {x[1]:.2f}, "
            f"tower load {1e-6 * found.measures['tower_load']:.2f} MN m, largest generator speed "
            f"{RPM * found.measures['generator_speed']:.0f} rpm, "
            f"power {1e-6 * found.measures['power']:.3f} MW"
        )
    simulations = problem.simulations_in(e.x for e in result.evaluations)
    print(f"cost {after.cost / before.cost:.3f} of the start's after {simulations} simulations")
    window = (20.0, 80.0) if args.quick else (200.0, 300.0)
    figures = {
        "20_samples.png": samples_figure(problem, tuner, result.evaluations),
        "20_series.png": series_figure(problem, after.x, window),
        "20_design_space.png": design_space_figure(problem, result.evaluations),
    }
    args.folder.mkdir(parents=True, exist_ok=True)
    for path in write_files(args.folder, {name: png(f) for name, f in figures.items()}):
        print(path)


if __name__ == "__main__":
    main()
