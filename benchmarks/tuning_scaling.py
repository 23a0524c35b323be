"""Evaluations a second against workers, and where asking becomes the limit; in simulated time.

Real tuners are asked and told; only the evaluations are not made: each takes the time of six
simulations of 660 s on one core, drawn around its mean, on a clock that jumps.  The study's rule is
the real one: as many untold candidates as workers, results told in the order of candidates.  To
the clock go the measured seconds of every `ask`, `tell` and write to the journal.

    python benchmarks/tuning_scaling.py [--quick] [--out FILE.json]
"""

from __future__ import annotations

import heapq
import sys
import tempfile
import time
from collections import deque
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

    def measured(self, work: Any) -> Any:
        """Do real work and add its time."""
        began = time.perf_counter()
        found = work()
        took = time.perf_counter() - began
        self.now += took
        self.asking += took
        return found


def run(method: str, workers: int, evaluations: int) -> dict[str, float]:
    """One study with a number of workers."""
    from pitchopt.tuning import Evaluation, Journal
    from pitchopt.tuning.known_functions import hartmann4
    from pitchopt.tuning.methods import make_tuner

    function = hartmann4()
    tuner = make_tuner(
        method, function.space, start=None, evaluations=evaluations, seed=0, options={}
    )
    rng = np.random.default_rng(1)
    clock = Clock()
    untold: deque[tuple[Any, float, float]] = deque()
    free = [0.0] * workers
    asked = 0
    with tempfile.TemporaryDirectory() as folder:
        journal = Journal(Path(folder) / "study", {"space": function.space.document()})
        while True:
            while len(untold) < workers and asked < evaluations:
                candidates = clock.measured(lambda: tuner.ask(1))
                if not candidates:
                    break
                (candidate,) = candidates
                clock.measured(lambda: journal.ask(candidate))  # noqa: B023  called at once
                seconds = EVALUATION * (1.0 + SPREAD * float(rng.standard_normal()))
                end = max(clock.now, heapq.heappop(free)) + seconds
                heapq.heappush(free, end)
                untold.append((candidate, end, seconds))
                asked += 1
            if not untold:
                break
            candidate, end, seconds = untold.popleft()
            clock.now = max(clock.now, end)
            found = Evaluation(
                index=candidate.index, x=candidate.x, cost=function(candidate.x), seconds=seconds
            )
            clock.measured(lambda: journal.tell(found))  # noqa: B023
            clock.measured(lambda: tuner.tell(candidate, found))  # noqa: B023
        journal.close()
    return {
        "evaluations": asked,
        "simulated_seconds": clock.now,
        "evaluations_per_second": asked / clock.now,
        "speedup": asked * EVALUATION / clock.now,
        "share_asking": clock.asking / clock.now,
        "ask_milliseconds": 1e3 * clock.asking / asked,
    }


def main(argv: list[str] | None = None) -> int:
    args = _harness.options(__doc__, argv)
    report = _harness.Report("tuning_scaling", quick=args.quick, out=args.out)
    evaluations = 12 if args.quick else EVALUATIONS
    for method in METHODS:
        for workers in (1, 4) if args.quick else WORKERS:
            figures = run(method, workers, evaluations)
            report.add(method, workers=workers, evaluation_seconds=EVALUATION, **figures)
    report.close()
    return 0


if __name__ == "__main__":
    sys.exit(main())
