"""What a user waits for: the 20-point trade-off curve, the command from a cold start, the import.

The curve: pitchopt.design.tradeoff on case biegel2011 as it is, 20 prices, five starts at five
anchors, a hull certificate at every point, the designs for 3 % and 7 % torque lost.  The
command: ``python -m pitchopt tradeoff --case biegel2011 --out FOLDER`` in a process of its own,
imports, tables and plots included.  The import: the median time of ``python -c "import
pitchopt"`` less that of ``python -c pass``, in turns.

    python benchmarks/curve.py [--quick] [--out FILE.json]
"""

from __future__ import annotations

import subprocess
import sys
import tempfile
import time
from pathlib import Path

import _harness
import numpy as np

AIMS = {"curve": 10.0, "command": 15.0, "import": 0.6}
QUICK = {"limits.positions": 4, "aero.elements": 1, "aero.segments": 10}
QUICK_OPTIONS = [
    "--points",
    "3",
    "--positions",
    "4",
    "--segments",
    "10",
    "--starts",
    "1",
    "--no-plots",
]


def curve(report: _harness.Report, quick: bool) -> None:
    from pitchopt.cases import load_case
    from pitchopt.design import tradeoff

    case = load_case("biegel2011")
    points = 3 if quick else 20
    if quick:
        case = case.with_values(QUICK)
    began, cpu_began = time.perf_counter(), time.process_time()
    task = case.task()
    result = tradeoff(task, points=points, seed=_harness.SEED)
    seconds, cpu_seconds = time.perf_counter() - began, time.process_time() - cpu_began
    gaps = [point.gap for point in result.points if point.gap is not None]
    report.add(
        "curve",
        case="biegel2011",
        positions=task.positions,
        seconds_aim=AIMS["curve"],
        seconds=seconds,
        cpu_seconds=cpu_seconds,
        points=len(result.points),
        certified=len(gaps),
        gap_largest_percent=100 * max(gaps),
        gap_median_percent=100 * float(np.median(gaps)),
        gap_percent_at_losses={
            f"{100 * point.target:g} %": 100 * point.gap
            for point in result.points
            if point.kind == "max_power_loss"
        },
        converged=sum(point.status.ok for point in result.points),
        subproblems=sum(point.iterations for point in result.points),
        seconds_of_points=sum(point.seconds for point in result.points),
    )


def command(report: _harness.Report, quick: bool) -> None:
    with tempfile.TemporaryDirectory() as folder:
        arguments = ["tradeoff", "--case", "biegel2011", "--out", str(Path(folder) / "out")]
        if quick:
            arguments += QUICK_OPTIONS
        began = time.perf_counter()
        done = subprocess.run(
            [sys.executable, "-m", "pitchopt", *arguments],
            check=False,
            capture_output=True,
            text=True,
        )
        seconds = time.perf_counter() - began
        written = len(list((Path(folder) / "out").rglob("*.*")))
    if done.returncode:
        raise SystemExit(f"command ended with status {done.returncode}: {done.stderr[-500:]}")
    report.add(
        "command",
        command="python -m pitchopt " + " ".join(arguments[:3]),
        seconds_aim=AIMS["command"],
        seconds=seconds,
        files=written,
    )


def imports(report: _harness.Report, repeats: int) -> None:
    times: dict[str, list[float]] = {
        "pass": [],
        "import pitchopt": [],
        "import pitchopt.design": [],
    }
    for _ in range(repeats):
        for code, seconds in times.items():
            began = time.perf_counter()
            subprocess.run([sys.executable, "-c", code], check=True)
            seconds.append(time.perf_counter() - began)
    bare = float(np.median(times["pass"]))
    report.add(
        "import",
        seconds_aim=AIMS["import"],
        seconds=float(np.median(times["import pitchopt"])) - bare,
        seconds_with_design=float(np.median(times["import pitchopt.design"])) - bare,
        bare_python_seconds=bare,
        repeats=repeats,
    )


def main(argv: list[str] | None = None) -> int:
    args = _harness.options(__doc__, argv)
    report = _harness.Report("curve", quick=args.quick, out=args.out)
    imports(report, 1 if args.quick else 9)
    curve(report, args.quick)
    command(report, args.quick)
    report.close()
    return 0


if __name__ == "__main__":
    sys.exit(main())
