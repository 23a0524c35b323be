"""How one run of sequential convex programming grows with stations and with elements.

One solve_local from the best constant pitch at mu = 10, case biegel2011: the number of rotor
positions m = 24, 60, 120, 360 (N = 3 m stations) with 2 elements a blade, and n = 2, 10, 50
elements (about n times as many segments in each curve) with m = 60.  Each size runs in a process
of its own, so that the peak of memory is its own; the time is the least of a few runs.  The
exponents are least-squares slopes of log(time) over log(N) or log(n): of the whole run, which
also holds how many subproblems it takes, and of one subproblem.

    python benchmarks/growth.py [--quick] [--out FILE.json]
"""

from __future__ import annotations

import json
import resource
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

import _harness

AIM = 1.2
MU = 10.0


def one(size: tuple[int, int], repeats: int) -> dict[str, Any]:
    """Figures of one size, in the present process."""
    from pitchopt.design import Objective, constant, solve_local

    began = time.perf_counter()
    task, problem = _harness.problem_of(*size)
    curves_seconds = time.perf_counter() - began
    objective = Objective.tradeoff(MU, task.weights)
    start = constant(task).profile
    small_task, small = _harness.problem_of(4, 2)
    solve_local(small, objective, constant(small_task).profile)  # imports and caches
    before = _peak()
    runs = [solve_local(problem, objective, start) for _ in range(repeats)]
    best = min(runs, key=lambda run: run.seconds)
    return {
        "positions": size[0],
        "elements": size[1],
        "stations": problem.curves.stations,
        "breakpoints": problem.curves.beta.shape[1],
        "seconds": best.seconds,
        "solver_seconds": best.solver_seconds,
        "subproblems": best.iterations,
        "seconds_per_subproblem": best.seconds / best.iterations,
        "status": str(best.status.value),
        "runs": repeats,
        "curves_seconds": curves_seconds,
        "peak_memory_mb": _peak(),
        "peak_memory_of_run_mb": _peak() - before,
    }


def _peak() -> float:
    """Largest resident memory so far [MB]."""
    size = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    return size / 1e6 if sys.platform == "darwin" else size / 1e3


def measure(
    report: _harness.Report, label: str, sizes: list[tuple[int, int]], along: str, repeats: int
) -> None:
    rows = []
    for m, n in sizes:
        command = [sys.executable, str(Path(__file__).resolve()), "--one", f"{m},{n},{repeats}"]
        done = subprocess.run(command, check=True, capture_output=True, text=True)
        rows.append(json.loads(done.stdout))
        report.add(f"run, {label}", case="biegel2011", mu=MU, **rows[-1])
    over = [float(row[along]) for row in rows]
    report.add(
        f"exponent, {label}",
        case="biegel2011",
        mu=MU,
        along=along,
        sizes=over,
        aim=AIM if along == "stations" else None,
        exponent_run=_harness.exponent(over, [row["seconds"] for row in rows]),
        exponent_subproblem=_harness.exponent(
            over, [row["seconds_per_subproblem"] for row in rows]
        ),
        exponent_subproblems=_harness.exponent(over, [float(row["subproblems"]) for row in rows]),
    )


def main(argv: list[str] | None = None) -> int:
    args = _harness.options(__doc__, argv, hidden=True)
    if args.one:
        m, n, repeats = (int(part) for part in args.one.split(","))
        print(json.dumps(one((m, n), repeats)))
        return 0
    report = _harness.Report("growth", quick=args.quick, out=args.out)
    if args.quick:
        measure(report, "positions", [(4, 2), (8, 2)], "stations", 1)
    else:
        measure(report, "positions", [(m, 2) for m in (24, 60, 120, 360)], "stations", 3)
        measure(report, "elements", [(60, n) for n in (2, 10, 50)], "elements", 3)
    report.close()
    return 0


if __name__ == "__main__":
    sys.exit(main())
