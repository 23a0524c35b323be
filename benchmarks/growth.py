"""How a local solve and its bound grow with stations and with elements.

One solve_local from the best constant pitch at mu = 10 and the hull relaxation from its end, case
biegel2011: the number of rotor positions m = 24, 60, 120, 360 (N = 3 m stations) with 2 elements
a blade, n = 2, 10, 50 elements (about n times as many segments in each curve) with m = 60, and
both at their largest at every price from 0.3 to 1000.  Each size runs in a process of its own,
so that the peak of memory is its own; times are processor time, the least of a few runs.  The
exponents are least-squares slopes of log(time) over log(N) or log(n): of the whole run, which
also holds how many subproblems it takes, of one subproblem, and of the relaxation.  From m = 120
on some of the subproblems are those of fewer positions.

    python benchmarks/growth.py [--quick] [--out FILE.json]
"""

from __future__ import annotations

import json
import resource
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import _harness

AIM = 1.2
MU = 10.0
PRICES = (0.3, 3.0, 10.0, 30.0, 100.0, 1000.0)
LARGEST = {"point_seconds_aim": 3.0, "bound_seconds_aim": 10.0, "peak_memory_mb_aim": 1000.0}


def one(size: tuple[int, int], repeats: int, mu: float) -> dict[str, Any]:
    """Figures of one size, in the present process."""
    from pitchopt.design import Objective, constant, solve_local
    from pitchopt.design.relaxation import relax

    curves_seconds, (task, problem) = _timed(lambda: _harness.problem_of(*size))
    objective = Objective.tradeoff(mu, task.weights)
    start = constant(task).profile
    small_task, small = _harness.problem_of(4, 2)
    solve_local(small, objective, constant(small_task).profile)  # imports and caches
    before = _peak()
    runs = [_timed(lambda: solve_local(problem, objective, start)) for _ in range(repeats)]
    seconds, best = min(runs, key=lambda run: run[0])
    after = _peak()
    bounds = [
        _timed(lambda: relax(problem, objective, profile=best.profile)) for _ in range(repeats)
    ]
    bound_seconds, relaxed = min(bounds, key=lambda run: run[0])
    return {
        "positions": size[0],
        "elements": size[1],
        "stations": problem.curves.stations,
        "breakpoints": problem.curves.beta.shape[1],
        "seconds": seconds,
        "wall_seconds": best.seconds,
        "solver_seconds": best.solver_seconds,
        "subproblems": best.iterations,
        "seconds_per_subproblem": seconds / best.iterations,
        "status": str(best.status.value),
        "objective": best.value,
        "bound_seconds": bound_seconds,
        "bound_rounds": relaxed.rounds,
        "gap_percent": 100 * (relaxed.upper_bound - best.value) / problem.torque_scale,
        "runs": repeats,
        "curves_seconds": curves_seconds,
        "peak_memory_mb": _peak(),
        "peak_memory_of_run_mb": after - before,
        "peak_memory_of_bound_mb": _peak() - after,
    }


def _timed(work: Callable[[], Any]) -> tuple[float, Any]:
    """Processor time of a call [s], and what it returns."""
    began = time.process_time()
    result = work()
    return time.process_time() - began, result


def _peak() -> float:
    """Largest resident memory so far [MB]."""
    size = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    return size / 1e6 if sys.platform == "darwin" else size / 1e3


def measure(
    report: _harness.Report, label: str, sizes: list[tuple[int, int]], along: str, repeats: int
) -> None:
    rows = []
    for size in sizes:
        rows.append(_apart(size, repeats, MU))
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
        exponent_bound=_harness.exponent(over, [row["bound_seconds"] for row in rows]),
    )


def _apart(size: tuple[int, int], repeats: int, mu: float) -> dict[str, Any]:
    """Figures of one size from a process of its own."""
    option = f"{size[0]},{size[1]},{repeats},{mu:g}"
    command = [sys.executable, str(Path(__file__).resolve()), "--one", option]
    done = subprocess.run(command, check=True, capture_output=True, text=True)
    figures: dict[str, Any] = json.loads(done.stdout)
    return figures


def main(argv: list[str] | None = None) -> int:
    args = _harness.options(__doc__, argv, hidden=True)
    if args.one:
        m, n, repeats, mu = args.one.split(",")
        print(json.dumps(one((int(m), int(n)), int(repeats), float(mu))))
        return 0
    report = _harness.Report("growth", quick=args.quick, out=args.out)
    if args.quick:
        measure(report, "positions", [(4, 2), (8, 2)], "stations", 1)
        report.add("largest", case="biegel2011", mu=MU, **LARGEST, **_apart((8, 3), 1, MU))
    else:
        measure(report, "positions", [(m, 2) for m in (24, 60, 120, 360)], "stations", 3)
        measure(report, "elements", [(60, n) for n in (2, 10, 50)], "elements", 3)
        for mu in PRICES:
            report.add("largest", case="biegel2011", mu=mu, **LARGEST, **_apart((360, 50), 1, mu))
    report.close()
    return 0


if __name__ == "__main__":
    sys.exit(main())
