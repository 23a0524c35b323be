"""What every benchmark shares: one thread, options, where it ran, one JSON line a measurement.

Import it before numpy: linear algebra is held to one thread, so that ratios of times compare
algorithms and not how many cores happened to be free.
"""

from __future__ import annotations

import argparse
import json
import math
import os
import platform
import statistics
from collections.abc import Sequence
from importlib import metadata
from pathlib import Path
from typing import Any

__all__ = ["SEED", "Report", "exponent", "finished", "options", "problem_of", "rounded"]

for _name in ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ[_name] = "1"

SEED = 0
PACKAGES = ("numpy", "scipy", "clarabel", "cvxpy", "casadi")


def options(docstring: str, argv: list[str] | None = None, *, hidden: bool = False) -> Any:
    """Read ``--quick`` and ``--out FILE.json``; with ``hidden`` also ``--one M,N,REPEATS,MU``."""
    given = parser(docstring)
    if hidden:
        given.add_argument("--one", help=argparse.SUPPRESS)
    return given.parse_args(argv)


def parser(docstring: str) -> argparse.ArgumentParser:
    """Options that every benchmark has; the first line says what it is."""
    common = argparse.ArgumentParser(description=docstring.splitlines()[0])
    common.add_argument("--quick", action="store_true", help="tiny sizes, to see that it runs")
    common.add_argument("--out", type=Path, metavar="FILE.json", help="write the lines there too")
    return common


def environment() -> dict[str, Any]:
    """Versions, processor and cores; nothing that names a machine or a folder."""
    versions: dict[str, str | None] = {"python": platform.python_version()}
    for name in PACKAGES:
        try:
            versions[name] = metadata.version(name)
        except metadata.PackageNotFoundError:
            versions[name] = None
    return {"versions": versions, "cpu": _cpu(), "cores": os.cpu_count(), "threads": 1}


def _cpu() -> str:
    try:
        lines = Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines()
    except OSError:
        return platform.processor() or platform.machine()
    names = [line.partition(":")[2].strip() for line in lines if line.startswith("model name")]
    return names[0] if names else platform.machine()


def rounded(value: Any, digits: int = 7) -> Any:
    """Numbers to so many significant digits, inside lists and dictionaries as well."""
    if isinstance(value, dict):
        return {key: rounded(item, digits) for key, item in value.items()}
    if isinstance(value, (list, tuple)):
        return [rounded(item, digits) for item in value]
    value = value.item() if hasattr(value, "item") else value  # numpy's own scalars
    if isinstance(value, float):
        number = float(f"{value:.{digits}g}")
        return number if math.isfinite(number) else None
    return value


class Report:
    """Prints every measurement as one JSON line and keeps the lines for a file."""

    def __init__(
        self, benchmark: str, *, quick: bool, out: Path | None, kept: Sequence[str] = ()
    ) -> None:
        self._head = {"benchmark": benchmark, "quick": quick, "seed": SEED}
        self._environment = environment()
        self._out = out
        self._lines = list(kept)  # of an earlier run that this one goes on from

    def add(self, measurement: str, **figures: Any) -> None:
        """One measurement."""
        record = {
            **self._head,
            "measurement": measurement,
            **rounded(figures),
            "environment": self._environment,
        }
        line = json.dumps(record, allow_nan=False)
        print(line, flush=True)
        self._lines.append(line)

    def close(self) -> None:
        """Write the file asked for, whole or not at all."""
        if self._out is None:
            return
        self._out.parent.mkdir(parents=True, exist_ok=True)
        part = self._out.with_name(self._out.name + ".part")
        part.write_text("\n".join(self._lines) + "\n", encoding="utf-8")
        part.replace(self._out)


def finished(out: Path | None, measurement: str | None = None) -> list[str]:
    """Lines of an earlier run's file, of one kind or all, to go on from; none without a file."""
    if out is None or not out.is_file():
        return []
    lines = out.read_text(encoding="utf-8").splitlines()
    return [line for line in lines if measurement in (None, json.loads(line)["measurement"])]


def problem_of(positions: int, elements: int, case: str = "biegel2011") -> tuple[Any, Any]:
    """Task and design problem of a case with m positions and n elements a blade."""
    from pitchopt.cases import load_case

    values = {"limits.positions": positions, "aero.elements": elements}
    task = load_case(case).with_values(values).task()
    return task, task.problem()


def exponent(sizes: list[float], values: list[float]) -> float:
    """Slope of log(value) over log(size), least squares."""
    x, y = [math.log(size) for size in sizes], [math.log(value) for value in values]
    return statistics.linear_regression(x, y).slope
