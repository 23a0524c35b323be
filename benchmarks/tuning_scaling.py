"""Evaluations a second against workers, and where asking becomes the limit; in simulated time.

Real tuners are asked and told; only the evaluations are not made: each takes the time of six
simulations of 660 s on one core, drawn around its mean, on a clock that jumps.  The study's rule is
the real one (`pitchopt.tuning.run_study`): as many untold candidates as workers, those that are
asked for together start together, results are told in the order of candidates.  The clock advances
by the processor seconds of every `ask` and `tell`, which need one thread and no disk, and by the
wall seconds of every write to the journal.

    python benchmarks/tuning_scaling.py [--quick] [--out FILE.json] [--plot FILE.png]
"""

from __future__ import annotations

import heapq
import sys
import tempfile
import time
from collections import deque
from collections.abc import Callable
from functools import partial
from importlib import util
from pathlib import Path
from typing import Any

import _harness
import numpy as np

METHODS = ("sobol", "cma-es", "zoo", "bayes")
EVALUATION = 1.0
"""Mean seconds of one evaluation: six runs of 660 s on one core."""
SPREAD = 0.05
"""Relative standard deviation of that."""
EVALUATIONS = 256
WORKERS = (1, 2, 4, 8, 16, 32, 64, 128)


class Clock:
    """Simulated seconds; real work is added as it is measured."""

    def __init__(self) -> None:
        self.now = 0.0
        self.asking = 0.0
        self.writing = 0.0

    def thought(self, work: Callable[[], Any]) -> Any:
        """Ask or tell, and add its processor time."""
        began = time.process_time()
        found = work()
        took = time.process_time() - began
        self.now += took
        self.asking += took
        return found

    def written(self, work: Callable[[], Any]) -> None:
        """Write to the journal, and add its wall time."""
        began = time.perf_counter()
        work()
        took = time.perf_counter() - began
        self.now += took
        self.writing += took


def landscape() -> Any:
    """Function that stands for the turbine's cost: as many parameters as individual pitch has."""
    from pitchopt.tuning.known_functions import hartmann

    return hartmann(4)


def tuner_of(method: str, evaluations: int) -> Any:
    """Fresh tuner of the landscape."""
    from pitchopt.tuning.methods import make_tuner

    return make_tuner(method, landscape().space, evaluations=evaluations, seed=_harness.SEED)


def simulated(
    tuner: Any, workers: int, evaluations: int, *, mean: float = EVALUATION
) -> dict[str, float]:
    """One study with a number of workers, whose evaluations take so many seconds in the mean."""
    from pitchopt.tuning import Evaluation, Journal

    function = landscape()
    rng = np.random.default_rng(1)
    clock = Clock()
    untold: deque[tuple[Any, float, float]] = deque()
    free = [0.0] * workers
    asked = 0
    with tempfile.TemporaryDirectory() as folder:
        journal = Journal(Path(folder) / "study", {"space": function.space.document()})
        while True:
            new: list[Any] = []
            while len(untold) + len(new) < workers and asked < evaluations:
                candidates = clock.thought(lambda: tuner.ask(1))
                if not candidates:
                    break
                new += candidates
                clock.written(partial(journal.ask, candidates[0]))
                asked += 1
            for candidate in new:
                clock.written(partial(journal.claim, candidate.index))
                seconds = mean * (1.0 + SPREAD * float(rng.standard_normal()))
                end = max(clock.now, heapq.heappop(free)) + seconds
                heapq.heappush(free, end)
                untold.append((candidate, end, seconds))
            if not untold:
                break
            candidate, end, seconds = untold.popleft()
            clock.now = max(clock.now, end)
            found = Evaluation(
                index=candidate.index, x=candidate.x, cost=function(candidate.x), seconds=seconds
            )
            clock.written(partial(journal.tell, found))
            clock.thought(partial(tuner.tell, candidate, found))
        journal.close()
    return {
        "evaluations": asked,
        "simulated_seconds": clock.now,
        "evaluations_per_second": asked / clock.now,
        "speedup": asked * mean / clock.now,
        "share_asking": clock.asking / clock.now,
        "share_writing": clock.writing / clock.now,
        "ask_milliseconds": 1e3 * clock.asking / asked,
        "write_milliseconds": 1e3 * clock.writing / asked,
    }


def figure_of(lines: dict[str, list[dict[str, float]]]) -> Any:
    """Evaluations a second over workers, a line a tuner; open where asking takes half the time."""
    from matplotlib.figure import Figure

    from pitchopt.plotting.style import BLACK, BLUE, GREEN, VERMILION, light_grid

    figure = Figure(figsize=(7.0, 4.6), layout="constrained")
    ax = figure.add_subplot()
    workers = np.array([line["workers"] for line in next(iter(lines.values()))])
    ax.plot(workers, workers / EVALUATION, color="0.6", ls="--", lw=1.0, label="no wait at all")
    for colour, (method, points) in zip(
        (BLUE, GREEN, BLACK, VERMILION), lines.items(), strict=False
    ):
        pace = np.array([line["evaluations_per_second"] for line in points])
        ask = np.median([line["ask_milliseconds"] for line in points])
        ax.plot(workers, pace, color=colour, label=f"{method}, {ask:.2g} ms an evaluation")
        for half, fill in ((True, "white"), (False, colour)):
            at = np.array([(line["share_asking"] >= 0.5) is half for line in points])
            ax.plot(workers[at], pace[at], "o", color=colour, mfc=fill, ms=6)
    ax.plot([], [], "o", color="0.3", mfc="white", label="asking takes half of the time or more")
    ax.set_xscale("log", base=2)
    ax.set_yscale("log", base=2)
    for axis in (ax.xaxis, ax.yaxis):
        axis.set_major_formatter("{x:g}")
    ax.set(
        xlabel="workers",
        ylabel="evaluations per second",
        title=f"four parameters, evaluations of {EVALUATION:g} s, simulated clock",
    )
    light_grid(ax)
    ax.legend(frameon=False, fontsize="small")
    return figure


def main(argv: list[str] | None = None) -> int:
    parser = _harness.parser(__doc__)
    parser.add_argument("--plot", type=Path, metavar="FILE.png", help="draw the lines")
    args = parser.parse_args(argv)
    report = _harness.Report("tuning_scaling", quick=args.quick, out=args.out)
    methods = METHODS
    if util.find_spec("cma") is None:
        methods = tuple(method for method in methods if method != "cma-es")
        report.add("skipped", reason="cma is missing: pip install 'pitchopt[cma]'")
    evaluations = 12 if args.quick else EVALUATIONS
    lines: dict[str, list[dict[str, float]]] = {}
    for method in methods:
        for workers in (1, 4) if args.quick else WORKERS:
            tuner = tuner_of(method, evaluations)
            figures = {
                "workers": workers,
                "evaluation_seconds": EVALUATION,
                **simulated(tuner, workers, evaluations),
            }
            report.add("study", method=method, **figures)
            lines.setdefault(method, []).append(figures)
        few, many = lines[method][0], lines[method][-1]
        report.add(
            "limit",
            method=method,
            workers=many["workers"],
            efficiency=many["speedup"] / many["workers"],
            ask_limit_per_second=1e3 / many["ask_milliseconds"],
            speedup=many["evaluations_per_second"] / few["evaluations_per_second"],
        )
    report.close()
    if args.plot is not None:
        from pitchopt.plotting import png

        args.plot.write_bytes(png(figure_of(lines), dpi=100))
    return 0


if __name__ == "__main__":
    sys.exit(main())
