"""The same study on a Dask cluster that loses a worker midway."""

import logging
import time
import warnings

import pytest
from random_walk import RandomWalk, bowl
from test_study import same

from pitchopt.tuning import run_study

distributed = pytest.importorskip("distributed", reason="needs the dask extra")


def slow(x):
    time.sleep(0.02)
    return bowl(x)


def test_cluster_that_loses_a_worker_gives_the_same_table(tmp_path):
    plain = run_study(bowl, RandomWalk(), evaluations=30, parallel=4)
    lost = []
    with (
        warnings.catch_warnings(),
        distributed.LocalCluster(
            n_workers=2,
            threads_per_worker=1,
            processes=True,
            dashboard_address=None,
            local_directory=str(tmp_path),
            silence_logs=logging.CRITICAL,
        ) as cluster,
        distributed.Client(cluster) as client,
    ):
        warnings.simplefilter("ignore")  # of the worker's death
        client.wait_for_workers(2)

        def lose(evaluation):
            if evaluation.index == 10:
                (worker, *_) = cluster.workers.values()
                lost.append(worker.process.process.pid)
                worker.process.process.kill()

        result = run_study(
            slow,
            RandomWalk(),
            evaluations=30,
            parallel=4,
            executor=client.get_executor(),
            journal=tmp_path / "study.sqlite",
            on_result=lose,
        )
    assert len(lost) == 1
    same(result.evaluations, plain.evaluations)
