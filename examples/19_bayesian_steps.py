"""Bayesian optimisation step by step (figure 2 of Mulders et al.), and a design space.

The tuner looks for the minimum of Forrester's function in 20 evaluations: posterior with its band
and samples, the acquisition under it, the next point.  Then the surface of another function of two
parameters from the evaluations of a tuner, beside its standard deviation.

    python 19_bayesian_steps.py [FOLDER] [--quick]
"""

import argparse
from pathlib import Path

from matplotlib.figure import Figure

from pitchopt.plotting import plot_acquisition, plot_design_space, plot_posterior, png
from pitchopt.tuning import Bayesian
from pitchopt.tuning.acquisition import ExpectedImprovement
from pitchopt.tuning.known_functions import branin, forrester


def steps(function, stages, evaluations):
    """Posterior and acquisition after some numbers of evaluations."""
    tuner = Bayesian(function.space, start=[[0.0], [0.5], [1.0]], initial=0)
    figure = Figure(figsize=(10.0, 6.0), layout="constrained")
    rows = figure.subplots(2, len(stages), sharex=True, height_ratios=(3, 1), squeeze=False)
    shown = iter(rows.T)
    for count in range(evaluations + 1):
        candidate = tuner.ask()[0]
        if count in stages:
            process = tuner.surrogates().cost
            least = process.moments(process.kriging.u)[0].min()
            improvement = ExpectedImprovement(process, float(least))
            upper, lower = next(shown)
            plot_posterior(process, truth=function.formula, label="f(x)", ax=upper)
            upper.axvline(candidate.x[0], color="#D55E00", linewidth=1.0, linestyle=":")
            upper.set(title=f"{count} evaluations", xlabel="", ylim=(-12, 18))
            upper.get_legend().set_visible(count == stages[0])
            plot_acquisition(
                process,
                lambda x, of=improvement, scale=process.scale: (
                    scale * of.values(function.space.to_unit(x))
                ),
                chosen=candidate.x[0],
                label="expected improvement",
                ax=lower,
            )
        if count < evaluations:
            tuner.tell(candidate, function(candidate.x))
    return figure, tuner.best()


def design_space(function, evaluations):
    """Surface and its uncertainty from the evaluations of a tuner."""
    tuner = Bayesian(function.space)
    for _ in range(evaluations):
        candidate = tuner.ask()[0]
        tuner.tell(candidate, function(candidate.x))
    process = tuner.surrogates().cost
    figure = Figure(figsize=(10.0, 4.2), layout="constrained")
    for ax, show in zip(figure.subplots(1, 2), ("mean", "std"), strict=True):
        plot_design_space(process, show=show, ax=ax)
    return figure, process.minimum()


def main(argv=None):
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("folder", nargs="?", default="example-output", type=Path)
    parser.add_argument("--quick", action="store_true", help="fewer evaluations")
    args = parser.parse_args(argv)

    args.folder.mkdir(parents=True, exist_ok=True)
    figure, best = steps(forrester(), *(((3, 5), 6) if args.quick else ((3, 7, 10, 20), 20)))
    (args.folder / "19_steps.png").write_bytes(png(figure, dpi=110))
    print(f"Forrester: {best.cost:.4f} at {best.x[0]:.4f}; least {forrester().minimum:.4f}")
    figure, lowest = design_space(branin(), 10 if args.quick else 30)
    (args.folder / "19_design_space.png").write_bytes(png(figure, dpi=110))
    print(f"Branin: least of the surface {lowest.mean:.4f}, deviation {lowest.std:.4f}")


if __name__ == "__main__":
    main()
