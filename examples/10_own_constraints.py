"""A profile under a convex constraint of one's own: no pitching while a blade is in the upper half.

The subproblem in cvxpy takes any constraint that is convex in the profile, or in what is affine
in it; the local solver uses it in place of the direct one.
"""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

import numpy as np

from pitchopt import load_case
from pitchopt.design import ConvexSubproblem, Objective, constant, solve_local
from pitchopt.exports import profile_csv, write_files


def main(arguments: list[str] | None = None) -> int:
    """Design with and without the constraint, print both, write the profile."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("folder", nargs="?", default="example-output", type=Path)
    parser.add_argument("--quick", action="store_true", help="fewer rotor positions")
    options = parser.parse_args(arguments)

    case = load_case("biegel2011")
    if options.quick:
        case = case.with_values({"limits.positions": 8})
    task = case.task()
    problem, best = task.problem(), constant(task)
    objective = Objective.tradeoff(3.0, task.weights)
    upper = np.flatnonzero(np.cos(problem.curves.azimuth) > 0.2)
    # neighbouring stations that are both in the upper half keep the same pitch
    pairs = [(int(n), int((n + 1) % problem.curves.stations)) for n in upper]
    pairs = [pair for pair in pairs if pair[1] in set(upper.tolist())]

    def still(beta):
        return [beta[n] == beta[k] for n, k in pairs]

    program = ConvexSubproblem(problem, objective, constraints=still)
    start = program.project(best.profile)
    free = solve_local(problem, objective, start)
    held = solve_local(problem, objective, start, subproblem=program)
    for name, found in (("free", free), ("still in the upper half", held)):
        cut = 100 * (1 - found.loads.rms.sum() / best.rms_sum)
        torque = found.loads.mean[0] / best.mean_torque
        print(f"{name}: RMS cut {cut:.1f} %, mean torque x {torque:.4f}, {found.status}")
    moved = max(abs(held.profile[n] - held.profile[k]) for n, k in pairs)
    print(f"largest pitch change in the upper half: {np.degrees(moved):.1e} deg")
    table = profile_csv(problem.curves.azimuth, held.profile, rotor_speed=case.rotor_speed)
    options.folder.mkdir(parents=True, exist_ok=True)
    for path in write_files(options.folder, {"10_own_constraints.csv": table}):
        print(path)
    return 0


if __name__ == "__main__":
    sys.exit(main())
