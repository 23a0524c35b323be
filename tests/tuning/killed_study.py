"""Runs of studies that are killed again and again.

``python killed_study.py FOLDER METHOD,METHOD KILLS SEED`` kills KILLS runs of each method with
SIGKILL at random moments, each a process of its own that goes on where the last one was stopped,
and prints as JSON how many evaluations stood in the method's journal at each kill.  Runs are
forked, so that a kill costs milliseconds and not the import of everything.
"""

from __future__ import annotations

import json
import os
import signal
import sys
import time

import numpy as np
from random_walk import SPACE, RandomWalk, bowl

from pitchopt.tuning import Journal, Outcome, Tuner, run_study

EVALUATIONS = 24


def build(method: str) -> Tuner:
    """Tuner of a method, fresh."""
    if method == RandomWalk.name:
        return RandomWalk(seed=5)
    from pitchopt.tuning.methods import make_tuner

    return make_tuner(
        method, SPACE, start=np.array([1.5, 0.1]), evaluations=EVALUATIONS, seed=5, options={}
    )


def noisy_bowl(x: np.ndarray) -> Outcome:
    """Bowl with a failure here and there, a variance and a measure, slow enough to be killed in."""
    time.sleep(0.002)
    ripple = float(np.sin(1e4 * x[0]))
    cost = float("nan") if ripple > 0.97 else bowl(x) + 0.01 * ripple
    return Outcome(cost=cost, variance=1e-4, measures={"ripple": ripple})


def study(path: str, method: str, pipe: int) -> None:
    """Run or go on with the study; the pipe gets a byte at each result."""
    run_study(
        noisy_bowl,
        build(method),
        evaluations=EVALUATIONS,
        parallel=2,
        journal=path,
        on_result=lambda _: os.write(pipe, b".") != 1,
    )


def forked(path: str, method: str) -> tuple[int, int]:
    """Process that runs the study, and the pipe to read from."""
    read, write = os.pipe()
    child = os.fork()
    if child == 0:
        study(path, method, write)
        os._exit(0)
    os.close(write)
    return child, read


def killed(path: str, method: str, kills: int, rng: np.random.Generator) -> list[int]:
    """Kill runs at random moments: while files are opened, or after the first result."""
    began = time.perf_counter()
    child, read = forked(f"{path}.timing", method)
    os.waitpid(child, 0)
    whole = time.perf_counter() - began
    os.close(read)
    reached = []
    for kill in range(kills):
        child, read = forked(path, method)
        if kill % 4 == 0:
            time.sleep(rng.uniform(0.0, 0.005))
        else:
            os.read(read, 1)
            time.sleep(rng.uniform(0.0, 2.0 * whole / kills))
        os.kill(child, signal.SIGKILL)
        os.waitpid(child, 0)
        os.close(read)
        try:
            with Journal(path) as journal:
                reached.append(len(journal.evaluations()))
        except ValueError:
            reached.append(0)  # killed before there was a file
    return reached


def main() -> None:
    """Kill the studies of all methods, one after the other."""
    folder, methods, kills, seed = sys.argv[1], sys.argv[2], int(sys.argv[3]), int(sys.argv[4])
    reached = {
        method: killed(f"{folder}/{method}.sqlite", method, kills, np.random.default_rng(seed))
        for method in methods.split(",")
    }
    sys.stdout.write(json.dumps(reached))


if __name__ == "__main__":
    main()
