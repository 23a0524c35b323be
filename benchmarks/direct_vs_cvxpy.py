"""The same convex subproblem: cone data handed to Clarabel directly, and cvxpy's re-solve.

Equal work: points and boxes are recorded along real runs of solve_local (both phases), without
the curvature that the direct path adds and cvxpy's program does not have; then each is solved
again by both paths, cvxpy's program built once and only its parameters changed (the time of the
first solve, which compiles it, is apart).  cvxpy's program is timed as one writes it at first,
with the mean of each load written out, and as the package has it, with the mean as a variable,
which keeps the rows sparse.  Both end in Clarabel.  The medians of time, and how far values and
profiles differ.  For the direct path also where its time goes: Clarabel's own report of its
solve against the whole call.

    python benchmarks/direct_vs_cvxpy.py [--quick] [--out FILE.json]
"""

from __future__ import annotations

import sys
import time
from typing import Any

import _harness
import numpy as np

AIM = 10.0


def recorded(problem: Any, objective: Any, start: np.ndarray) -> tuple[list[Any], Any]:
    """Points, boxes and the rest of every subproblem of one run, and the run's result."""
    from pitchopt.design import solve_local
    from pitchopt.design.direct import Subproblem

    calls: list[Any] = []

    class Recorder(Subproblem):
        def solve(self, point: np.ndarray, objective: Any, **keywords: Any) -> Any:
            alike = {k: v for k, v in keywords.items() if k not in ("chord", "multipliers")}
            calls.append((point, alike))
            return super().solve(point, objective, **keywords)

    run = solve_local(problem, objective, start, subproblem=Recorder(problem))
    return calls, run


def timed(solver: Any, call: Any, objective: Any, repeats: int) -> tuple[Any, float, float]:
    """Answer, least seconds of the call, and Clarabel's seconds in that call."""
    best = (np.inf, 0.0)
    for _ in range(repeats):
        began = time.perf_counter()
        out = solver.solve(call[0], objective, **call[1])
        best = min(best, (time.perf_counter() - began, out.solve_seconds))
    return out, *best


def measure(
    report: _harness.Report,
    size: tuple[int, int],
    mu: float,
    most: int,
    repeats: int,
    *,
    sparse: bool,
) -> None:
    from pitchopt.design import ConvexSubproblem, Objective, constant
    from pitchopt.design.direct import Subproblem

    task, problem = _harness.problem_of(*size)
    objective = Objective.tradeoff(mu, task.weights)
    calls, run = recorded(problem, objective, constant(task).profile)
    if len(calls) > most:
        calls = [calls[i] for i in np.linspace(0, len(calls) - 1, most).astype(int)]
    direct = Subproblem(problem)
    began = time.perf_counter()
    convex = ConvexSubproblem(problem, objective, sparse=sparse)
    first = convex.solve(calls[0][0], objective, **calls[0][1])
    build = time.perf_counter() - began

    rows = []
    for call in calls:
        a, seconds_a, solver_a = timed(direct, call, objective, repeats)
        b, seconds_b, solver_b = timed(convex, call, objective, repeats)
        if a.solved and b.solved:
            gap = abs(a.value - b.value)
            apart = float(np.max(np.abs(a.profile - b.profile)))
        else:
            gap = apart = np.nan
        cell = call[1].get("segments") is not None
        rows.append(
            (seconds_a, solver_a, seconds_b, solver_b, gap, apart, a.solved, b.solved, cell)
        )
    t = np.array(rows, dtype=float)
    both = t[:, 6].astype(bool) & t[:, 7].astype(bool)
    cells = t[:, 8].astype(bool)
    scale = abs(float(run.loads.mean[0]))

    def ratio(mask: np.ndarray) -> float | None:
        return float(np.median(t[mask, 2] / t[mask, 0])) if mask.any() else None

    report.add(
        "subproblem",
        case="biegel2011",
        positions=size[0],
        elements=size[1],
        stations=problem.curves.stations,
        mu=mu,
        cvxpy_formulation="mean as a variable" if sparse else "mean written out",
        ratio_aim=AIM,
        ratio=ratio(np.ones(len(t), dtype=bool)),
        ratio_trust_region=ratio(~cells),
        ratio_cells=ratio(cells),
        subproblems=len(t),
        solved_by_direct=int(t[:, 6].sum()),
        solved_by_cvxpy=int(t[:, 7].sum()),
        cvxpy_first_solved=bool(first.solved),
        direct_seconds_median=float(np.median(t[:, 0])),
        cvxpy_seconds_median=float(np.median(t[:, 2])),
        cvxpy_build_seconds=build,
        value_difference_largest=float(np.max(t[both, 4])) / scale,
        value_difference_median=float(np.median(t[both, 4])) / scale,
        profile_difference_largest_rad=float(np.max(t[both, 5])),
        profile_difference_median_rad=float(np.median(t[both, 5])),
        direct_solver_share=float(t[:, 1].sum() / t[:, 0].sum()),
        direct_assembly_share=1 - float(t[:, 1].sum() / t[:, 0].sum()),
        direct_solver_share_trust_region=_share(t, ~cells),
        direct_solver_share_cells=_share(t, cells),
        cvxpy_solver_share=float(t[:, 3].sum() / t[:, 2].sum()),
        run_solver_share=run.solver_seconds / run.seconds,
    )


def _share(t: np.ndarray, mask: np.ndarray) -> float | None:
    return float(t[mask, 1].sum() / t[mask, 0].sum()) if mask.any() else None


def main(argv: list[str] | None = None) -> int:
    args = _harness.options(__doc__, argv)
    report = _harness.Report("direct_vs_cvxpy", quick=args.quick, out=args.out)
    if args.quick:
        measure(report, (6, 2), 10.0, 4, 1, sparse=True)
    else:
        for sparse in (False, True):
            measure(report, (24, 2), 10.0, 60, 3, sparse=sparse)
            measure(report, (60, 20), 10.0, 12, 2, sparse=sparse)
    report.close()
    return 0


if __name__ == "__main__":
    sys.exit(main())
