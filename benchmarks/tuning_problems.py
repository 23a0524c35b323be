"""The four tuning problems by every tuner, with equal numbers of evaluations, in winds not seen.

Every tuner begins where the problem proposes and has at most 25 evaluations a parameter (24 at each
breakpoint of the minimum pitch); one that has converged before may end there, and a grid has as
many points as fit.  `gain` is what the cost fell by over its value at the start in the winds of the
tuning; `fresh_gain` the same in as many other winds as `check_seeds` says, which no tuner saw and
which are the same for all.  One seed of each tuner: differences of a percent or so between tuners
may come out otherwise with another.

The minimum pitch has kappa = 0.03, since 0.01 buys nothing on this turbine.  Studies that the file
has already are not repeated; with ``--journals FOLDER`` each evaluation is kept too, and a run
that was stopped goes on from there.

    python benchmarks/tuning_problems.py [--quick] [--out FILE.json] [--journals FOLDER]
"""

from __future__ import annotations

import json
import sys
from importlib import util
from pathlib import Path
from typing import Any

import _harness

METHODS = ("zoo", "bayes", "grid", "sobol", "spsa", "nelder-mead", "cobyla", "cma-es")
EVALUATIONS = {
    "torque-gain": 25,
    "speed-regulator": 50,
    "minimum-pitch": 24,
    "individual-pitch": 100,
}
CHECK_SEEDS = 6
KAPPA = 0.03
QUICK = {"duration": 30.0, "skip": 10.0, "box_points": 5, "box_interval": 0.25, "seeds": (1,)}


def study(task: Any, method: str, evaluations: int, journals: Path | None, check: int) -> Any:
    """Figures of one tuner on one problem."""
    options = {"stages": evaluations} if method == "zoo" else {}  # more than it has evaluations for
    tuned = task.tune(
        method,
        evaluations=evaluations,
        seed=_harness.SEED,
        options=options,
        journal=None if journals is None else journals / f"{task.name}-{method}.sqlite",
    )
    document = tuned.document(check_seeds=check)
    failed = [e for e in document["evaluations"] if e["status"] != "ok"]
    return {
        "problem": task.name,
        "method": method,
        "turbine": document["turbine"],
        "check_seeds": check,
        "parameters": document["parameters"],
        "start_cost": document["start"]["cost"],
        "best_cost": document["best"]["cost"],
        "best_x": document["best"]["x"],
        "gain": document["gain"],
        "fresh_gain": document["fresh_gain"],
        "evaluations_allowed": evaluations,
        "evaluations": len(document["evaluations"]),
        "evaluations_failed": len(failed),
        "simulations": document["simulations"],
        "evaluation_seconds": sum(e["seconds"] for e in document["evaluations"]),
    }


def table(studies: list[Any]) -> str:
    """The studies in columns, best in fresh winds first."""
    rows = [f"{'problem':<18}{'method':<13}{'evaluations':>12}{'gain %':>9}{'fresh %':>9}  best"]
    for one in studies:
        point = " ".join(f"{x:.4g}" for x in one["best_x"])
        rows.append(
            f"{one['problem']:<18}{one['method']:<13}{one['evaluations']:>12}"
            f"{100 * one['gain']:>9.2f}{100 * one['fresh_gain']:>9.2f}  {point}"
        )
    return "\n".join(rows)


def main(argv: list[str] | None = None) -> int:
    parser = _harness.parser(__doc__)
    parser.add_argument("--journals", type=Path, metavar="FOLDER", help="keep studies there")
    args = parser.parse_args(argv)
    if args.journals is not None:
        args.journals.mkdir(parents=True, exist_ok=True)

    from pitchopt.studies.tuning import make_task

    kept = _harness.finished(args.out, "study")
    report = _harness.Report("tuning_problems", quick=args.quick, out=args.out, kept=kept)
    known = {(line["problem"], line["method"]): line for line in map(json.loads, kept)}
    methods = ("zoo", "sobol") if args.quick else METHODS
    if "cma-es" in methods and util.find_spec("cma") is None:
        methods = tuple(method for method in methods if method != "cma-es")
        report.add("skipped", reason="cma is missing: pip install 'pitchopt[cma]'")
    everything = []
    for name, count in EVALUATIONS.items():
        settings = QUICK if args.quick else {}
        if name == "minimum-pitch":
            settings = settings | {"kappa": (KAPPA,)}
        task = make_task(name, **settings)
        count, check = (4, 1) if args.quick else (count, CHECK_SEEDS)
        studies = []
        for method in methods:
            if (found := known.get((name, method))) is None:
                found = study(task, method, count, args.journals, check)
                report.add("study", **found)
                report.close()
            studies.append(found)
        studies.sort(key=lambda one: -one["fresh_gain"])
        everything += studies
        report.add(
            "problem",
            problem=name,
            check_seeds=check,
            order=[one["method"] for one in studies],
            fresh_gains=[one["fresh_gain"] for one in studies],
            gains=[one["gain"] for one in studies],
        )
    report.close()
    print(table(everything), file=sys.stderr)
    return 0


if __name__ == "__main__":
    sys.exit(main())
