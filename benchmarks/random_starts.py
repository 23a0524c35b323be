"""Whether random starts find better profiles than the default curve: nine cases, every point.

For each case the default curve (fewer prices than the command's 20, with the designs for 3 % and
7 % torque lost); then at each of its points 50 seeded random starts of four kinds: constant
pitches, waves of harmonics 1 to 6 of small to large amplitude, rough noise and profiles that
jump between the limits, each repaired to the limits.  All of them go through a rough solve on
smoothed curves, and the best ten, told apart on the curves themselves, through the full local
solve; with ``--full`` every start goes through the full solve instead.

A gain is in the point's own objective, as a share of the largest mean torque; for the designs of
a given loss it is mu times the RMS saved, with the mu of that point.  Designs of a given loss and
the point of the highest price are compared with the optimum by exact flattening as well, which
uses no convex program.

    python benchmarks/random_starts.py [--quick] [--out FILE.json] [--cases NAME ...]
                                       [--points P] [--starts S] [--full]

The file is written as cases end; a run with the same ``--out`` leaves out the cases in it.
"""

from __future__ import annotations

import argparse
import json
import sys
import time
from collections.abc import Iterator
from typing import Any

import _harness
import numpy as np

AIM = 0.2  # [% of the largest mean torque]
DEG = np.pi / 180.0
FINISHED = 10
QUICK = {"limits.positions": 4, "aero.elements": 1, "aero.segments": 10}
HEAVY = {"limits.positions": 18}  # the reference turbines; their default is 36
CASES: dict[str, tuple[str, dict[str, Any]]] = {
    "biegel2011, 15 m/s": ("biegel2011", {}),
    "biegel2011, 12 m/s, strong shear": (
        "biegel2011",
        {"wind.speed": 12.0, "wind.shear_exponent": 0.35, "wind.horizontal_shear": 0.0},
    ),
    "biegel2011, 18 m/s, from the side": (
        "biegel2011",
        {"wind.speed": 18.0, "wind.direction": 8 * DEG, "wind.horizontal_shear": -1e-3},
    ),
    **{
        f"{turbine}, {label}": (turbine, {**HEAVY, **values})
        for turbine in ("nrel-5mw", "iea-15-240")
        for label, values in {
            "8 m/s": {"wind.speed": 8.0},
            "11 m/s, from the side": {
                "wind.speed": 11.0,
                "wind.shear_exponent": 0.1,
                "wind.direction": 8 * DEG,
                "wind.horizontal_shear": 5e-4,
            },
            "15 m/s, strong shear": {"wind.speed": 15.0, "wind.shear_exponent": 0.3},
        }.items()
    },
}


def random_profiles(
    problem: Any, count: int, rng: np.random.Generator
) -> Iterator[tuple[str, Any]]:
    """Feasible random profiles, the four kinds in turn."""
    curves = problem.curves
    n, (low, high) = curves.stations, problem.constant_range
    psi = curves.azimuth
    for i in range(count):
        offset = rng.uniform(low, high)
        kind = ("constant", "wave", "noise", "vertex")[i % 4]
        if kind == "constant":
            profile = np.full(n, offset)
        elif kind == "wave":
            size = rng.uniform(0.3, 8.0) * DEG
            orders = np.arange(1, 7)[:, None]
            phase = rng.uniform(0, 2 * np.pi, (6, 1))
            weights = rng.normal(size=(6, 1)) / orders ** rng.uniform(0.0, 1.5)
            profile = offset + size * np.sum(weights * np.cos(orders * psi - phase), axis=0)
        elif kind == "noise":
            profile = offset + rng.uniform(1.0, 10.0) * DEG * rng.normal(size=n)
        else:
            length = int(rng.integers(1, max(2, n // 3)))
            up = np.repeat(rng.random(n // length + 1) < 0.5, length)[:n]
            profile = np.where(up, curves.upper, curves.lower)
        yield kind, problem.repaired(profile)


class Judge:
    """Random starts at one point after the other of a case."""

    def __init__(self, task: Any, result: Any, *, starts: int, full: bool) -> None:
        from pitchopt.design.direct import Subproblem

        self.task = task.operating_at(float(result.constant.profile.mean()))
        self.result, self.starts, self.full = result, starts, full
        self.problem = self.task.problem()
        self.subproblem = Subproblem(self.problem)
        self.screen = Subproblem(self.problem.softened)

    def objective(self, point: Any) -> Any:
        """What a point of the curve maximises."""
        from pitchopt.design import Objective

        share = self.task.blade_cap
        limits: dict[str, float] = {"travel": self.task.travel}
        if share is not None:
            limits["blade_cap"] = share * self.result.constant.loads.blade_rms
        if point.kind == "mu":
            return Objective.tradeoff(point.mu, self.task.weights, **limits)
        torque = (1.0 - point.target) * self.result.power_max.mean_torque
        return Objective.least_rms(self.task.weights, torque_min=torque, **limits)

    def point(self, point: Any, seed: int) -> dict[str, Any]:
        """The largest gain of the random starts over one point of the curve."""
        from pitchopt.design import solve_local
        from pitchopt.design.scp import ScpSettings
        from pitchopt.design.search import valued

        began, objective = time.process_time(), self.objective(point)
        settings = ScpSettings()
        firsts = list(random_profiles(self.problem, self.starts, np.random.default_rng(seed)))
        if not self.full:
            ends = [
                solve_local(
                    self.problem.softened,
                    objective,
                    profile,
                    settings=settings.rough(),
                    subproblem=self.screen,
                ).profile
                for _, profile in firsts
            ]
            firsts = [
                (kind, self.problem.repaired(end))
                for (kind, _), end in zip(firsts, ends, strict=True)
            ]
            firsts.sort(key=lambda one: -valued(self.problem, objective, one[1]))
            firsts, settings = firsts[:FINISHED], settings.finishing()
        best, kind, profile = -np.inf, "", firsts[0][1]
        for name, first in firsts:
            solution = solve_local(
                self.problem, objective, first, settings=settings, subproblem=self.subproblem
            )
            value = valued(self.problem, objective, solution.profile)
            if value > best:
                best, kind, profile = value, name, solution.profile
        loads = self.problem.curves.evaluate(profile)
        return {
            "kind": point.kind,
            "mu": point.mu,
            "target": point.target,
            "status": str(point.status.value),
            "start": point.start,
            "torque_lost_percent": 100 * self.result.loss(point),
            "rms_weighted": point.rms_weighted,
            "gain_percent": self.percent(point, best),
            "random_kind": kind,
            "random_torque_lost_percent": self.lost(loads),
            "random_rms_weighted": self.task.weights.weighted(loads),
            "starts": self.starts,
            "finished": len(firsts),
            "cpu_seconds": time.process_time() - began,
        }

    def lost(self, loads: Any) -> float:
        """Torque lost against the power maximum [%]."""
        return 100 * (1 - float(loads.mean[0]) / self.result.power_max.mean_torque)

    def percent(self, point: Any, value: float) -> float:
        """By how much a value of the point's objective is above the point's [% of torque]."""
        from pitchopt.design.search import valued

        price = 1.0 if point.kind == "mu" else point.mu
        own = valued(self.problem, self.objective(point), point.profile)
        return 100 * price * (value - own) / self.result.power_max.mean_torque

    def flattened(self, point: Any) -> dict[str, Any]:
        """The optimum by exact flattening beside one point."""
        from pitchopt.design import flat_optimum
        from pitchopt.errors import InfeasibleError

        began = time.process_time()
        pitch = float(self.result.constant.profile.mean())
        figures: dict[str, Any] = {"kind": point.kind, "mu": point.mu, "target": point.target}
        try:
            flat = flat_optimum(self.problem, self.objective(point), pitch)
        except InfeasibleError as error:
            return {**figures, "applies": False, "reason": str(error)}
        return {
            **figures,
            "applies": True,
            "flat": flat.flat,
            "branch": flat.branch,
            "gain_percent": self.percent(point, flat.value),
            "torque_lost_percent": self.lost(flat.loads),
            "rms_weighted": point.rms_weighted,
            "flat_rms_weighted": self.task.weights.weighted(flat.loads),
            "evaluations": flat.evaluations,
            "cpu_seconds": time.process_time() - began,
        }


def run_case(report: _harness.Report, name: str, args: argparse.Namespace) -> None:
    from pitchopt.cases import load_case
    from pitchopt.design import tradeoff

    key, values = CASES[name]
    began = time.process_time()
    case = load_case(key).with_values({**values, **(QUICK if args.quick else {})})
    task = case.task()
    result = tradeoff(task, points=args.points, seed=_harness.SEED)
    seconds = time.process_time() - began
    judge = Judge(task, result, starts=args.starts, full=args.full)
    gains: list[float] = []
    for i, point in enumerate(result.points):
        line = judge.point(point, _harness.SEED + i)
        report.add("point", case=name, **line)
        gains.append(line["gain_percent"])
    steep = max((point for point in result.points if point.kind == "mu"), key=lambda p: p.mu)
    for point in result.points:
        if point is steep or point.kind != "mu":
            report.add("flattened optimum", case=name, **judge.flattened(point))
    finite = [gain for gain in gains if np.isfinite(gain)]
    report.add(
        "case",
        case=name,
        positions=task.positions,
        aim_percent=AIM,
        gain_largest_percent=max(finite),
        gains_above_aim=sum(gain > AIM for gain in finite),
        points=len(gains),
        points_without_price=len(gains) - len(finite),
        starts_each=args.starts,
        finished_each=args.starts if args.full else min(FINISHED, args.starts),
        screened_on_smoothed_curves=not args.full,
        curve_cpu_seconds=seconds,
        cpu_seconds=time.process_time() - began,
    )


def main(argv: list[str] | None = None) -> int:
    parser = _harness.parser(__doc__)
    parser.add_argument("--cases", nargs="+", default=list(CASES), choices=list(CASES))
    parser.add_argument("--points", type=int, default=6, help="prices on a curve")
    parser.add_argument("--starts", type=int, default=50, help="random starts at a point")
    parser.add_argument("--full", action="store_true", help="finish every start in full")
    args = parser.parse_args(argv)
    if args.quick:
        args.points, args.starts = 2, 4
        args.cases = args.cases[:1]
    kept = _harness.finished(args.out)
    report = _harness.Report("random_starts", quick=args.quick, out=args.out, kept=kept)
    done = {json.loads(line)["case"] for line in kept}
    for name in args.cases:
        if name not in done:
            run_case(report, name, args)
            report.close()
    return 0


if __name__ == "__main__":
    sys.exit(main())
