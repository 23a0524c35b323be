"""Gain of the torque law tuned for the most energy, in three winds and at 8 m/s alone.

The NREL 5 MW in turbulence of class A: estimated cost and its uncertainty after the first stage
and after the last, the settling function, and what the generator does in each wind, as figures 1
and 2 of Zalkind, Dall'Anese and Pao (Wind Energy Science, 2020) show it.

    python 21_torque_gain.py [FOLDER] [--quick]
"""

import argparse
from pathlib import Path

import numpy as np
from matplotlib import pyplot as plt

from pitchopt.exports import write_files
from pitchopt.plotting import plot_posterior, png
from pitchopt.studies.tuning import TorqueGain, TuningPlant
from pitchopt.tuning import GaussianProcess, ZerothOrder, run_study, settling

RPM = 30.0 / np.pi


def estimate(ax, problem, evaluations, title):
    """Samples and kriging with its band, relative to k_fact = 1."""
    unit = abs(problem([1.0]).cost)
    process = GaussianProcess.fit(
        problem.space, [e.x for e in evaluations], [e.cost / unit for e in evaluations]
    )
    plot_posterior(process, label="cost over power at one [-]", ax=ax)
    ax.set(xlabel="factor on the gain [-]", title=title)


def tuning_figure(problem, tuner, evaluations):
    figure, axes = plt.subplots(1, 3, figsize=(14.0, 4.2), layout="constrained")
    first = [e for e in evaluations if e.origin.split(".")[0] in ("start", "search 1", "step 1")]
    estimate(axes[0], problem, first, "first stage")
    estimate(axes[1], problem, evaluations, "all stages")
    axes[2].plot(np.arange(1, len(tuner.stage_costs) + 1), settling(tuner.stage_costs), "o-")
    axes[2].set(xlabel="stage", ylabel="settling function [-]")
    return figure


def winds_figure(problem, x):
    """Generator torque over speed in each wind."""
    runs = problem.runs(x)
    figure, axes = plt.subplots(
        1, len(runs), figsize=(4.4 * len(runs), 3.8), sharey=True, layout="constrained"
    )
    for ax, run in zip(np.atleast_1d(axes), runs, strict=True):
        late = run.simulation.time >= run.skip
        speed, torque = run.simulation["GenSpeed"][late], run.simulation["GenTq"][late]
        ax.plot(RPM * speed, 1e-3 * torque, ".", markersize=1.5)
        ax.set(
            xlabel="generator speed [rpm]",
            title=f"{run.wind_speed:g} m/s, {1e-3 * run.measures['power']:.0f} kW",
        )
    np.atleast_1d(axes)[0].set_ylabel("generator torque [kN m]")
    return figure


def main(argv=None):
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("folder", nargs="?", default="example-output", type=Path)
    parser.add_argument("--quick", action="store_true", help="coarser and shorter")
    args = parser.parse_args(argv)

    quick = {"duration": 60.0, "skip": 20.0, "box_points": 5, "box_interval": 0.25}
    plant = TuningPlant("nrel-5mw", turbulence="A", **(quick if args.quick else {}))
    problems = {
        "three_winds": TorqueGain(plant),
        "8_alone": TorqueGain(plant, wind_speeds=(8.0,)),
    }
    figures = {}
    for name, problem in problems.items():
        options = problem.tuner_options("zoo") | ({"stages": 2} if args.quick else {})
        tuner = ZerothOrder(problem.space, start=problem.start, **options)
        result = run_study(problem, tuner, evaluations=tuner.most_evaluations + 1)
        gain = result.best.cost / problem([1.0]).cost - 1.0
        print(
            f"{name}: factor {result.best.x[0]:.3f}, {100.0 * gain:+.2f} % of power over a factor "
            f"of one, {problem.simulations_in(e.x for e in result.evaluations)} simulations"
        )
        figures[f"21_{name}.png"] = tuning_figure(problem, tuner, result.evaluations)
        if len(problem.wind_speeds) > 1:
            figures["21_torque.png"] = winds_figure(problem, result.best.x)
    args.folder.mkdir(parents=True, exist_ok=True)
    for path in write_files(args.folder, {name: png(f) for name, f in figures.items()}):
        print(path)


if __name__ == "__main__":
    main()
