"""Post-optimum estimates beside solving again: what they cost and how far they are off.

Convex programs in cvxpy, all random and feasible by construction: quadratic programs whose
constraints move with a parameter, of growing size.  Both sides start from the solved problem; ours
is `PostOptimum.from_cvxpy` once and an estimate for each of ten changes, with all assumptions
judged (without the feasibility question, which no change here raises) and with none; the other is
`problem.solve` with the changed parameter, warm, DPP, by the same solver.

Towers: one full set of simulations (72 runs of 600 s), with the turbulence boxes made and with
boxes at hand; one sizing, and the same problem by scipy's SLSQP with the same rows and gradients.

    python benchmarks/sensitivity.py [--quick] [--out FILE.json]
"""

from __future__ import annotations

import time
from typing import Any

import _harness
import numpy as np

SET_SECONDS = 15.0
CHANGES = 10


def random_program(variables: int, rows: int, rng: np.random.Generator) -> tuple[Any, Any]:
    """A strictly convex program with a point that stays inside, and its parameter."""
    import cvxpy as cp

    x = cp.Variable(variables)
    c = cp.Parameter(value=0.0)
    a = rng.normal(size=(rows, variables)) / np.sqrt(variables)
    inside = rng.normal(size=variables)
    room = 0.1 + rng.random(rows)  # more than any change here takes
    move = rng.normal(size=rows)
    cost = rng.normal(size=variables)
    objective = 0.05 * cp.sum_squares(x) + cost @ x + c * np.abs(cost[0])
    return cp.Problem(cp.Minimize(objective), [a @ x <= a @ inside + room + c * move]), c


def programs(report: _harness.Report, *, quick: bool) -> None:
    from pitchopt.sensitivity import PostOptimum

    for variables, rows in (
        ((20, 40),) if quick else ((20, 40), (100, 200), (200, 1000), (200, 2000))
    ):
        rng = np.random.default_rng(_harness.SEED)
        problem, parameter = random_program(variables, rows, rng)
        problem.solve(solver="CLARABEL")
        value = float(problem.value)
        changes = np.linspace(0.002, 0.02, CHANGES)
        began = time.perf_counter()
        optimum = PostOptimum.from_cvxpy(problem, parameter)
        made = time.perf_counter() - began
        found = optimum.estimates(changes, check_feasible=False)
        ours = time.perf_counter() - began
        began = time.perf_counter()
        truth = []
        for change in changes:
            parameter.value = change
            problem.solve(solver="CLARABEL")
            truth.append(float(problem.value) - value)
        theirs = time.perf_counter() - began
        parameter.value = 0.0
        problem.solve(solver="CLARABEL")
        began = time.perf_counter()
        PostOptimum.from_cvxpy(problem, parameter).estimates(changes, judge=False)
        plain = time.perf_counter() - began
        scale = np.max(np.abs(truth))
        report.add(
            "convex program",
            variables=variables,
            rows=rows,
            changes=CHANGES,
            seconds_making=made,
            seconds_estimates=ours,
            seconds_estimates_not_judged=plain,
            seconds_solving_again=theirs,
            ratio=theirs / ours,
            ratio_not_judged=theirs / plain,
            error_first_order=float(
                np.max(np.abs([e.first_order - t for e, t in zip(found, truth, strict=True)]))
                / scale
            ),
            error_high_order=float(
                np.max(np.abs([e.high_order - t for e, t in zip(found, truth, strict=True)]))
                / scale
            ),
            broken=sorted({a.name for e in found for a in e.broken}),
        )


def towers(report: _harness.Report, *, quick: bool) -> None:
    from pitchopt.studies.tower import (
        LoadSets,
        LoadSettings,
        TowerDesign,
        TowerLimits,
        scaled_start,
        size_tower,
    )
    from pitchopt.turbines import load_turbine

    turbine = load_turbine("iea-3.4-130")
    small = LoadSettings(wind_speeds=(9.0, 13.0), seeds=(1,), duration=60.0, axes=2, box_points=7)
    design = scaled_start(turbine, turbine.rotor.hub_height)
    LoadSets(turbine, small).run(design, 0.0)  # compiles
    sets = LoadSets(turbine, small if quick else None)
    times = []
    for weight in (0.0, 0.1) if quick else (0.0, 0.1, 0.2, 0.3):
        began = time.perf_counter()
        found = sets.run(design, weight)
        times.append(time.perf_counter() - began)
    report.add(
        "set of simulations",
        simulations=found.simulations,
        duration=sets.settings.duration,
        seconds_with_boxes_made=times[0],
        seconds=min(times[1:]),
        seconds_aim=SET_SECONDS,
        workers=sets.workers,
    )
    loads = sets.run(design, 0.0).loads
    for name, margin in (("standard", 0.15), ("soft-soft", None)):
        limits = TowerLimits(frequency_margin=margin)
        size_tower(design.hub_height, loads, limits, turbine, start=design)
        began = time.perf_counter()
        sizing = size_tower(design.hub_height, loads, limits, turbine, start=design)
        ours = time.perf_counter() - began
        began = time.perf_counter()
        other, result = _slsqp(design, loads, limits, TowerDesign)
        theirs = time.perf_counter() - began
        report.add(
            "sizing",
            configuration=name,
            mass=sizing.mass,
            seconds=ours,
            steps=sizing.iterations,
            slsqp_mass=other.mass,
            slsqp_seconds=theirs,
            slsqp_steps=int(result.nit),
            slsqp_message=str(result.message),
            slsqp_largest_violation=float(result.violation),
            ratio=theirs / ours,
            mass_difference=other.mass / sizing.mass - 1.0,
        )


def _slsqp(design: Any, loads: Any, limits: Any, kind: Any) -> tuple[Any, Any]:
    """The same rows in the same logarithms, by scipy."""
    from scipy.optimize import minimize

    from pitchopt.studies.tower.constraints import constraint_rows

    nodes = design.elements + 1
    start = np.log(np.concatenate([design.diameter, design.thickness]))
    kept: dict[bytes, Any] = {}

    def at(x: Any) -> Any:
        size = np.exp(np.clip(x, start - 2.0, start + 1.0))
        return kind(
            hub_height=design.hub_height,
            diameter=size[:nodes],
            thickness=np.minimum(size[nodes:], 0.4 * size[1:nodes]),
            reference=design.reference,
        )

    def rows(x: Any) -> Any:
        key = x.tobytes()
        if key not in kept:
            kept.clear()
            kept[key] = constraint_rows(at(x), loads, limits)
        return kept[key]

    def objective(x: Any) -> tuple[float, Any]:
        tower = at(x)
        part = tower.element_masses
        share = tower.diameter[:-1] / (tower.diameter[:-1] + tower.diameter[1:])
        slope = np.zeros(x.size)
        slope[: nodes - 1] += part * share
        slope[1:nodes] += part * (1.0 - share)
        slope[nodes:] = part
        return float(np.log(tower.mass)), slope / tower.mass

    result = minimize(
        objective,
        start,
        jac=True,
        method="SLSQP",
        constraints={
            "type": "ineq",
            "fun": lambda x: -rows(x).log,
            "jac": lambda x: -rows(x).jacobian,
        },
        options={"maxiter": 200, "ftol": 1e-9},
    )
    result.violation = max(float(rows(result.x).log.max()), 0.0)
    return at(result.x), result


def main() -> None:
    """Run it."""
    asked = _harness.options(__doc__ or "")
    report = _harness.Report("sensitivity", quick=asked.quick, out=asked.out)
    programs(report, quick=asked.quick)
    towers(report, quick=asked.quick)
    report.close()


if __name__ == "__main__":
    main()
