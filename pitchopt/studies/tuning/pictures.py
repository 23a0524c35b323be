"""Pictures of a tuned problem: its design space by kriging, or what was tried, and the progress.

With one or two parameters the cost and each measure that it is made of are drawn over the design
space with kriging's deviation, as the zeroth-order paper does; gains and offsets in their planes.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from functools import partial
from typing import TYPE_CHECKING

import numpy as np

from pitchopt.studies.tuning.individual_pitch import IndividualPitchGains
from pitchopt.studies.tuning.tune import Tuned
from pitchopt.tuning import Evaluation, GaussianProcess, Space

if TYPE_CHECKING:
    from matplotlib.figure import Figure

__all__ = ["pictures"]


def pictures(tuned: Tuned) -> Mapping[str, Callable[[], bytes]]:
    """Pictures by the names of their files, drawn when they are asked for."""
    title = f"{tuned.problem.plant.turbine.name}, {tuned.problem.name} by {tuned.method}"
    good = [e for e in tuned.result.evaluations if e.status == "ok"]
    found: dict[str, Callable[[], bytes]] = {}
    if isinstance(tuned.problem, IndividualPitchGains):
        found["gains.png"] = partial(_gains, tuned, title)
    elif len(tuned.problem.space) <= 2 and len({tuple(e.x) for e in good}) > 2:
        found["design-space.png"] = partial(_design_space, tuned, good, title)
    found["progress.png"] = partial(_progress, tuned, title)
    return found


def _png(figure: Figure) -> bytes:
    from pitchopt.plotting import png

    return png(figure)


def _kriging(space: Space, good: Sequence[Evaluation], values: Sequence[float]) -> GaussianProcess:
    """Of a cost or a measure over the points that did not fail, each once."""
    at = {tuple(e.x): value for e, value in zip(good, values, strict=True)}
    return GaussianProcess.fit(space, np.array(list(at)), np.array(list(at.values())))


def _design_space(tuned: Tuned, good: Sequence[Evaluation], title: str) -> bytes:
    """Cost and measures in rows; with two parameters mean and deviation in columns."""
    from matplotlib.figure import Figure

    from pitchopt.plotting.tuning import plot_design_space, plot_posterior

    space = tuned.problem.space
    outputs = {"cost": [e.cost for e in good]}
    for name in tuned.problem.shown:
        outputs[name] = [e.measures[name] for e in good]
    columns = len(space)
    size = (5.0 * columns, 3.4 * len(outputs))
    figure = Figure(figsize=size, layout="constrained")
    grid = figure.subplots(len(outputs), columns, squeeze=False)
    for row, (name, values) in zip(grid, outputs.items(), strict=True):
        process = _kriging(space, good, values)
        if columns == 1:
            plot_posterior(process, label=name, ax=row[0])
        else:
            plot_design_space(process, label=name, ax=row[0])
            plot_design_space(process, show="std", label=name, ax=row[1])
            row[0].plot(*tuned.start.x, "s", color="w", mec="k", ms=7)
            row[0].plot(*tuned.best.x, "*", color="w", mec="k", ms=12)
    figure.suptitle(title)
    return _png(figure)


def _gains(tuned: Tuned, title: str) -> bytes:
    from pitchopt.plotting.tuning_individual import gain_samples, individual_pitch_figure

    samples = gain_samples(tuned.result.evaluations, highest=tuned.start.cost)
    return _png(individual_pitch_figure({title: samples}))


def _progress(tuned: Tuned, title: str) -> bytes:
    """Each cost and the least so far, over evaluations."""
    from matplotlib.figure import Figure

    from pitchopt.plotting.tuning import plot_progress

    figure = Figure(figsize=(6.4, 4.0), layout="constrained")
    costs = np.array([e.cost for e in tuned.result.evaluations])
    ax = plot_progress(costs, start=tuned.start.cost, ax=figure.add_subplot())
    ax.set_title(title)
    return _png(figure)
