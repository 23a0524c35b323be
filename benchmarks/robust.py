"""One profile for 1 to 24 winds: seconds, and how they grow with the number of winds.

Case biegel2011 with m = 72 positions and 2 elements a blade, mu = 10; winds are speeds from 13.5
to 16.5 m/s with shear exponents from 0.05 to 0.35, equally weighted.
For each number of winds: each wind's own optimum, the joint design of the weighted mean, its
bound, and the design of least largest regret.  The exponents are least-squares slopes of
log(seconds) over log(winds), from three winds on.

    python benchmarks/robust.py [--quick] [--out FILE.json]
"""

from __future__ import annotations

import sys
import time
from typing import Any

import _harness

AIM = {12: 20.0}
MU = 10.0
SPEEDS = (15.0, 14.0, 16.0, 13.5, 16.5, 14.5)
SHEARS = (0.2, 0.1, 0.3, 0.05, 0.35)


def tasks_of(count: int, positions: int) -> list[Any]:
    from pitchopt.cases import load_case

    case = load_case("biegel2011").with_values({"limits.positions": positions, "aero.elements": 2})
    pairs = [(v, shear) for shear in SHEARS for v in SPEEDS][:count]
    return [
        case.with_values({"wind.speed": v, "wind.shear_exponent": shear}).task()
        for v, shear in sorted(pairs, key=lambda pair: (pair[1], pair[0]))
    ]


class Clock:
    """Seconds and processor seconds up to each step that the design reports."""

    def __init__(self) -> None:
        self.began = (time.perf_counter(), time.process_time())
        self.marks: list[tuple[str, float, float]] = []

    def __call__(self, done: int, total: int, label: str) -> None:
        """One step done."""
        del done, total
        self.marks.append((label, *self.now()))

    def now(self) -> tuple[float, float]:
        """Seconds and processor seconds since the start."""
        return time.perf_counter() - self.began[0], time.process_time() - self.began[1]

    def until(self, label: str) -> float:
        """Processor seconds when the last step of a name was done."""
        return max((cpu for name, _, cpu in self.marks if name == label), default=0.0)


def one(report: _harness.Report, count: int, positions: int) -> dict[str, float]:
    """Figures for one number of winds."""
    from pitchopt.design import robust

    tasks = tasks_of(count, positions)
    names = [f"wind {k + 1}" for k in range(count)]
    clock = Clock()
    found = robust(tasks, mu=MU, labels=names, seed=_harness.SEED, progress=clock)
    own, joint = clock.until(names[-1]), clock.until("joint design")
    bound = clock.until("bound")
    second = Clock()
    least = robust(tasks, mu=MU, goal="regret", certify=False, seed=_harness.SEED, progress=second)
    regret_wall, regret_cpu = second.now()
    wall = next(seconds for label, seconds, _ in clock.marks if label == "bound")
    row = {
        "winds": float(count),
        "cpu_seconds": joint,
        "cpu_seconds_own_optima": own,
        "cpu_seconds_joint": joint - own,
        "cpu_seconds_bound": bound - joint,
        "cpu_seconds_regret": regret_cpu,
    }
    report.add(
        "design",
        case="biegel2011",
        mu=MU,
        positions=positions,
        stations=int(found.azimuth.size),
        seconds_aim=AIM.get(count),
        seconds_with_bound=wall,
        seconds_regret=regret_wall,
        subproblems=found.iterations,
        gap_percent=None if found.gap is None else 100 * found.gap,
        largest_regret_of_mean=found.largest_regret,
        largest_regret=least.largest_regret,
        status=str(found.status.value),
        status_regret=str(least.status.value),
        **row,
    )
    return row


def main(argv: list[str] | None = None) -> int:
    args = _harness.options(__doc__, argv)
    report = _harness.Report("robust", quick=args.quick, out=args.out)
    counts, positions = ([1, 3, 4], 4) if args.quick else ([1, 3, 6, 12, 24], 72)
    rows = [one(report, count, positions) for count in counts]
    several = [row for row in rows if row["winds"] >= 3]
    winds = [row["winds"] for row in several]
    exponents = {
        f"exponent_{part}": _harness.exponent(winds, [max(row[name], 1e-9) for row in several])
        for part, name in (
            ("design", "cpu_seconds"),
            ("own_optima", "cpu_seconds_own_optima"),
            ("joint", "cpu_seconds_joint"),
            ("bound", "cpu_seconds_bound"),
            ("regret", "cpu_seconds_regret"),
        )
    }
    report.add("exponent", case="biegel2011", mu=MU, positions=positions, winds=winds, **exponents)
    report.close()
    return 0


if __name__ == "__main__":
    sys.exit(main())
