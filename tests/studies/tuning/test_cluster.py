"""A real problem gives the same table wherever it is evaluated, and whoever is lost on the way."""

from __future__ import annotations

import logging
import multiprocessing
import os
import signal
import warnings
from concurrent.futures import ProcessPoolExecutor

import pytest

from pitchopt.studies.tuning import SpeedRegulator, tune

EVALUATIONS = 14
PARALLEL = 4


def table(tuned):
    """All of the evaluations but their times."""
    return [
        (
            e.index,
            e.x.tolist(),
            e.origin,
            e.status,
            repr(e.cost),  # NaN is no equal of itself
            repr(e.variance),
            dict(e.measures),
            tuple(e.replicates),
        )
        for e in tuned.result.evaluations
    ]


def tuned_on(plant, **settings):
    return tune(
        SpeedRegulator(plant, seeds=(1, 2)),
        "bayes",
        evaluations=EVALUATIONS,
        parallel=PARALLEL,
        **settings,
    )


@pytest.fixture(scope="module")
def plain(small):
    tuned = tuned_on(small)
    assert len({tuple(e.x) for e in tuned.result.evaluations}) == EVALUATIONS
    good = [e for e in tuned.result.evaluations if e.status == "ok"]
    assert len(good) > EVALUATIONS // 2 and all(len(e.replicates) == 2 for e in good)
    return table(tuned)


def test_processes_give_the_table_of_a_plain_run(small, plain):
    context = multiprocessing.get_context("spawn")
    with ProcessPoolExecutor(2, mp_context=context) as executor:
        assert table(tuned_on(small, executor=executor)) == plain


def test_cluster_that_loses_a_worker_gives_the_table_of_a_plain_run(small, plain, tmp_path):
    distributed = pytest.importorskip("distributed", reason="needs the dask extra")
    pids = []
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
            if evaluation.index == EVALUATIONS // 2:
                pids.extend(client.run(os.getpid).values())
                os.kill(pids[0], signal.SIGKILL)

        tuned = tuned_on(
            small,
            executor=client.get_executor(),
            journal=tmp_path / "study.sqlite",
            on_result=lose,
        )
        left = set(client.run(os.getpid).values())
    assert len(pids) == 2 and pids[0] not in left
    assert tuned.result.evaluated == EVALUATIONS
    assert table(tuned) == plain
