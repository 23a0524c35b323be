"""A run that tests kill: ``python run_in_process.py CHECKPOINT separate|common``.

It prints a line after each rotation.
"""

from __future__ import annotations

import sys
import time
from typing import Any

from ilc_factories import SCALE, AffinePlant, make_learner

from ilc import FixedLearner, Record, Sensors, run

ROTATIONS = 40


def parts(separate: bool, kind: Any = FixedLearner, **changes: Any) -> dict[str, Any]:
    """Plant, learner, sensors and set-point of the run, all fresh."""
    plant = AffinePlant.random(4, positions=4, separate=separate)
    sensors = Sensors.with_share(
        0.02, SCALE, quantisation=10.0, delay=2, dropout=0.05, passage_dropout=0.05, seed=3
    )
    return {
        "plant": plant,
        "learner": make_learner(plant, kind, delay=2),
        "sensors": sensors,
        "setpoint": lambda rotation: float(SCALE[0]) * (1.0 if rotation < 6 else 0.99),
        "rotations": ROTATIONS,
    } | changes


def whole(separate: bool, kind: Any = FixedLearner, **changes: Any) -> Record:
    """The run without a break."""
    return run(**parts(separate, kind, **changes))


def main() -> None:
    """Run slowly enough to be killed at any moment, between the writing of files and within it."""

    def report(done: int, total: int, text: str) -> None:
        print(done, flush=True)  # noqa: T201
        time.sleep(0.005)

    run(**parts(sys.argv[2] == "separate"), checkpoint=sys.argv[1], callback=report)


if __name__ == "__main__":
    main()
