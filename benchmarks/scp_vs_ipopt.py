"""One trade-off point: sequential convex programming against CasADi with IPOPT.

Equal work: case biegel2011, the same starts for both, the best profile kept, the time of all
starts together, the two sides timed one right after the other.
IPOPT solves a twice differentiable cubic
B-spline interpolant of the same curves with the exact sparse Hessian, MUMPS and tol 1e-6; its
building time is counted apart.  Both profiles are scored on the piecewise-linear curves; IPOPT's
as it comes and after the repair that every profile of ours goes through.

IPOPT is given three formulations of the same problem (see _smooth_peer.py) and a line is
printed for each.  ``direct`` writes the RMS into the objective, as one would at first, and is
the one that always converges; ``lifted`` makes loads and RMS variables, which gives a nearly
diagonal Hessian, and is the fastest wherever it converges: the peer to judge by.  The summary
names the fastest in total for each case.  A run that meets its time limit makes the ratio a
lower bound.  The starts' own cost (best constant pitch, power maximum) is on neither side.

Ours tells the starts apart by rough solves on smoothed curves and finishes the best two on the
curves themselves; the smoothing is counted.  ``objective_lead_percent`` is (ours - IPOPT's) /
max torque on the piecewise-linear curves, ``objective_lead_on_own_curves_percent`` the same with
IPOPT's profile scored on its own smooth curves: the difference is what the interpolant costs.

    python benchmarks/scp_vs_ipopt.py [--quick] [--out FILE.json]
"""

from __future__ import annotations

import sys
import time
from typing import Any

import _harness
import numpy as np

AIMS = {(24, 2): 30.0, (60, 20): 300.0}
OBJECTIVE_AIM = -0.1  # per cent of max torque
TIME_LIMIT = 120.0  # s of IPOPT a run


def starts_of(task: Any, count: int) -> tuple[list[tuple[str, np.ndarray]], float]:
    """Labelled first profiles and the largest mean torque [N m]."""
    from pitchopt.design import constant, power_max

    best = constant(task)
    power = power_max(task, reference=best)
    stations = best.profile.size
    starts = [("best constant", best.profile)]
    starts += [(f"{a:g} deg", np.full(stations, np.deg2rad(a))) for a in (-1.5, 3.0, 6.0)]
    starts.append(("power maximum", power.profile))
    return starts[:count], power.mean_torque


class _Clock:
    """Wall and processor time since it was made; the second is steadier on a busy machine."""

    def __init__(self) -> None:
        self._began = time.perf_counter(), time.process_time()

    def read(self) -> tuple[float, float]:
        return time.perf_counter() - self._began[0], time.process_time() - self._began[1]


def run_scp(problem: Any, objective: Any, starts: list[tuple[str, np.ndarray]]) -> dict[str, Any]:
    """All starts through best_local: what the package does for the best of several starts."""
    from pitchopt.design.search import Start, best_local

    problem.__dict__.pop("softened", None)  # the smoothed curves are part of the work
    clock = _Clock()
    found = best_local(
        problem, objective, [Start(label=name, profile=profile) for name, profile in starts]
    )
    seconds, cpu = clock.read()
    return {
        "seconds": seconds,
        "cpu_seconds": cpu,
        "subproblems": found.iterations,
        "status": str(found.solution.status.value),
        "objective": found.solution.value,
        "start": found.start,
        "violation": problem.limits.violation(problem.curves, found.solution.profile),
    }


def run_ipopt(
    peer: Any, problem: Any, objective: Any, mu: float, starts: list[tuple[str, np.ndarray]]
) -> dict[str, Any]:
    """All starts through IPOPT; the profile that is best once repaired."""
    clock = _Clock()
    runs = [peer.solve(mu, start) for _, start in starts]
    seconds, cpu = clock.read()
    values = [problem.value(problem.repaired(run.profile), objective) for run in runs]
    k = int(np.argmax(values))
    return {
        "seconds": seconds,
        "cpu_seconds": cpu,
        "median": float(np.median([run.seconds for run in runs])),
        "iterations": sum(run.iterations for run in runs),
        "statuses": [run.status for run in runs],
        "objective_on_smooth": runs[k].objective,
        "objective_as_is": problem.value(runs[k].profile, objective),
        "objective": values[k],
        "start": starts[k][0],
        "violation": problem.limits.violation(problem.curves, runs[k].profile),
    }


def measure(
    report: _harness.Report,
    size: tuple[int, int],
    prices: tuple[float, ...],
    count: int,
    limit: float,
    formulations: tuple[str, ...],
) -> None:
    from _smooth_peer import SmoothPeer

    from pitchopt.design import Objective

    task, problem = _harness.problem_of(*size)
    starts, max_torque = starts_of(task, count)
    weights = task.weights.array
    peers = {
        name: SmoothPeer(problem, weights, formulation=name, max_cpu_time=limit)
        for name in formulations
    }
    run_scp(problem, Objective.tradeoff(prices[0], task.weights), starts[:1])  # imports, caches
    totals: dict[str, list[dict[str, Any]]] = {name: [] for name in formulations}
    for mu in prices:
        objective = Objective.tradeoff(mu, task.weights)
        for name, peer in peers.items():
            ours = run_scp(problem, objective, starts)
            theirs = run_ipopt(peer, problem, objective, mu, starts)
            timed_out = sum("Time" in status for status in theirs["statuses"])
            figures = {
                "formulation": name,
                "mu": mu,
                "ratio": theirs["seconds"] / ours["seconds"],
                "ratio_is_lower_bound": timed_out > 0,
                "ratio_cpu": theirs["cpu_seconds"] / ours["cpu_seconds"],
                "objective_lead_percent": 100
                * (ours["objective"] - theirs["objective"])
                / max_torque,
                "objective_lead_on_own_curves_percent": 100
                * (ours["objective"] - theirs["objective_on_smooth"])
                / max_torque,
                "ipopt_runs_solved": sum(s == "Solve_Succeeded" for s in theirs["statuses"]),
            }
            totals[name].append({**figures, "ours": ours["seconds"], "theirs": theirs["seconds"]})
            report.add(
                "trade-off point",
                case="biegel2011",
                positions=size[0],
                elements=size[1],
                stations=problem.curves.stations,
                starts=[label for label, _ in starts],
                **figures,
                max_torque=max_torque,
                ipopt_build_seconds=peer.build_seconds,
                scp=_named(ours),
                ipopt=_named(theirs),
            )
    fastest = min(totals, key=lambda name: sum(row["theirs"] for row in totals[name]))
    report.add(
        "summary",
        case="biegel2011",
        positions=size[0],
        elements=size[1],
        ratio_aim=AIMS.get(size),
        objective_aim_percent=OBJECTIVE_AIM,
        fastest_formulation=fastest,
        formulations={
            name: {
                "ratio": sum(r["theirs"] for r in rows) / sum(r["ours"] for r in rows),
                "ratio_least": min(r["ratio"] for r in rows),
                "ratio_largest": max(r["ratio"] for r in rows),
                "ratio_is_lower_bound": any(r["ratio_is_lower_bound"] for r in rows),
                "objective_lead_percent_least": min(r["objective_lead_percent"] for r in rows),
                "objective_lead_percent_largest": max(r["objective_lead_percent"] for r in rows),
                "ipopt_runs_solved": sum(r["ipopt_runs_solved"] for r in rows),
                "runs": len(rows) * len(starts),
            }
            for name, rows in totals.items()
        },
    )


def _named(run: dict[str, Any]) -> dict[str, Any]:
    """The run with its two violations named; negative ones are room left."""
    out = dict(run)
    out["range_violation_rad"], out["rate_violation_rad_per_s"] = out.pop("violation")
    return out


def main(argv: list[str] | None = None) -> int:
    args = _harness.options(__doc__, argv)
    report = _harness.Report("scp_vs_ipopt", quick=args.quick, out=args.out)
    try:
        import casadi  # noqa: F401
    except ImportError:
        report.add("skipped", reason="casadi is not installed; it comes with the extra 'bench'")
        report.close()
        return 0
    from _smooth_peer import FORMULATIONS

    if args.quick:
        measure(report, (6, 2), (3.0,), 2, 2.0, ("lifted",))
    else:
        measure(report, (24, 2), (3.0, 10.0, 30.0, 100.0), 5, TIME_LIMIT, FORMULATIONS)
        measure(report, (60, 20), (3.0, 10.0, 30.0, 100.0), 2, TIME_LIMIT, FORMULATIONS)
    report.close()
    return 0


if __name__ == "__main__":
    sys.exit(main())
