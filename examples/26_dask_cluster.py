"""A study on a Dask cluster, which may lose a worker and still ends with the table of a plain run.

The speed regulator of the NREL 5 MW by Bayesian optimisation, four candidates side by side: first
in threads of this process, then on two worker processes of this machine or on a scheduler that is
running, whose workers have pitchopt installed.  The journal keeps every evaluation, so that the
study goes on where it was if this process is stopped.  What the tuner is asked depends on the
number of candidates side by side alone, so both tables are the same to the last bit.

    python 26_dask_cluster.py [FOLDER] [--scheduler ADDRESS] [--lose-a-worker] [--quick]

Needs the extra dask: pip install 'pitchopt[dask]'
"""

import argparse
import logging
import os
import signal
import tempfile
import warnings
from contextlib import ExitStack
from pathlib import Path

from pitchopt.exports import write_files
from pitchopt.studies.tuning import (
    SpeedRegulator,
    TuningPlant,
    evaluations_csv,
    tune,
    tuned_document,
)

WORKERS = 2
PARALLEL = 4


def connected(stack, address):
    """Client of a scheduler, or of a cluster of this machine."""
    from distributed import Client, LocalCluster

    if address is None:
        folder = stack.enter_context(tempfile.TemporaryDirectory(ignore_cleanup_errors=True))
        cluster = LocalCluster(
            n_workers=WORKERS,
            threads_per_worker=1,
            processes=True,
            dashboard_address=None,
            local_directory=folder,
            silence_logs=logging.CRITICAL,
        )
        address = stack.enter_context(cluster)
    client = stack.enter_context(Client(address))
    client.wait_for_workers(1)
    return client


def table(tuned):
    """What of a study has to be the same wherever it was made."""
    return [
        (e.index, e.x.tolist(), e.status, repr(e.cost), repr(e.variance), dict(e.measures))
        for e in tuned.result.evaluations
    ]


def main(argv=None):
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("folder", nargs="?", default="example-output", type=Path)
    parser.add_argument("--scheduler", metavar="ADDRESS", help="such as tcp://10.0.0.1:8786")
    parser.add_argument("--lose-a-worker", action="store_true", help="kill one midway")
    parser.add_argument("--quick", action="store_true", help="coarser and shorter")
    args = parser.parse_args(argv)
    if args.scheduler and args.lose_a_worker:
        parser.error("--lose-a-worker kills a worker of this machine's own cluster; leave it out")
    try:
        import distributed  # noqa: F401
    except ImportError:
        parser.exit(1, "Dask is not installed: pip install 'pitchopt[dask]'\n")

    coarse = {"duration": 60.0, "skip": 20.0, "box_points": 5, "box_interval": 0.25}
    plant = TuningPlant("nrel-5mw", workers=1, **(coarse if args.quick else {}))
    settings = {"evaluations": 12 if args.quick else 40, "parallel": PARALLEL}
    args.folder.mkdir(parents=True, exist_ok=True)
    lost = []
    plain = tune(SpeedRegulator(plant), "bayes", **settings)
    print(f"threads of this process: {len(table(plain))} evaluations in {plain.seconds:.1f} s")
    with ExitStack() as stack:
        stack.enter_context(warnings.catch_warnings())
        if args.lose_a_worker:
            warnings.simplefilter("ignore")  # of its death
        client = connected(stack, args.scheduler)

        def midway(evaluation):
            if args.lose_a_worker and evaluation.index == settings["evaluations"] // 2:
                lost.append(next(iter(client.run(os.getpid).values())))
                os.kill(lost[0], signal.SIGKILL)

        tuned = tune(
            SpeedRegulator(plant),
            "bayes",
            executor=client.get_executor(),
            journal=args.folder / "26_study.sqlite",
            on_result=midway,
            **settings,
        )
        workers = len(client.scheduler_info()["workers"])
    print(
        f"cluster of {workers}: {tuned.result.evaluated} evaluations in {tuned.seconds:.1f} s, "
        f"{len(table(tuned)) - tuned.result.evaluated} known from the journal"
        + (f", worker {lost[0]} killed midway" if lost else "")
    )
    x = tuned.best.x
    print(
        f"best: omega {x[0]:.3f} rad/s, zeta {x[1]:.2f}, cost {100 * tuned.gain:.1f} % lower than "
        "at the start"
    )
    same = table(tuned) == table(plain)
    print("both tables are the same" if same else "the tables differ")
    files = {"26_evaluations.csv": evaluations_csv(tuned_document(tuned))}
    for path in write_files(args.folder, files):
        print(path)
    return 0 if same else 1


if __name__ == "__main__":
    raise SystemExit(main())
