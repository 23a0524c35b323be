"""A real problem gives the same table in this process and in others.

That a cluster which loses a worker gives it as well is shown in tests/tuning and by an example.
"""

from __future__ import annotations

import multiprocessing
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


@pytest.mark.slow
def test_processes_give_the_table_of_a_plain_run(small):
    tuned = tuned_on(small)
    assert len({tuple(e.x) for e in tuned.result.evaluations}) == EVALUATIONS
    good = [e for e in tuned.result.evaluations if e.status == "ok"]
    assert len(good) > EVALUATIONS // 2 and all(len(e.replicates) == 2 for e in good)
    context = multiprocessing.get_context("spawn")
    with ProcessPoolExecutor(2, mp_context=context) as executor:
        assert table(tuned_on(small, executor=executor)) == table(tuned)
