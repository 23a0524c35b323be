"""Studies: what is told when, failures, executors, resuming, and two processes on one journal."""

import math
import multiprocessing
import os
import threading
import time
from concurrent.futures import ProcessPoolExecutor, ThreadPoolExecutor
from functools import partial

import numpy as np
import pytest
from random_walk import RandomWalk, bowl

from pitchopt.errors import ComputationError, InputError
from pitchopt.tuning import Journal, Outcome, run_study


def points(result):
    return np.array([e.x for e in result.evaluations])


def same(first, second):
    for one, other in zip(first, second, strict=True):
        assert np.array_equal(one.x, other.x)
        assert (one.index, one.status, one.origin) == (other.index, other.status, other.origin)
        assert one.cost == other.cost or (math.isnan(one.cost) and math.isnan(other.cost))
        assert one.variance == other.variance
        assert one.measures == other.measures
        assert one.replicates == other.replicates
        assert one.message == other.message


def jittery(x):
    """Takes longer for some points than for others, so that results come in out of order."""
    time.sleep(0.003 * (1.0 + math.sin(1e3 * x[0])))
    return bowl(x)


@pytest.mark.parametrize("parallel", [1, 2, 5])
def test_order_of_results_does_not_matter(parallel):
    plain = run_study(bowl, RandomWalk(), evaluations=30, parallel=parallel)
    assert [e.index for e in plain.evaluations] == list(range(30))
    for workers in (1, 3):
        with ThreadPoolExecutor(workers) as executor:
            found = run_study(
                jittery, RandomWalk(), evaluations=30, parallel=parallel, executor=executor
            )
        assert np.array_equal(points(found), points(plain))


def test_asking_ahead_never_exceeds_parallel():
    running, most = [0], [0]
    lock = threading.Lock()

    def count(x):
        with lock:
            running[0] += 1
            most[0] = max(most[0], running[0])
        time.sleep(0.005)
        with lock:
            running[0] -= 1
        return bowl(x)

    with ThreadPoolExecutor(8) as executor:
        run_study(count, RandomWalk(batch=6), evaluations=18, parallel=3, executor=executor)
    assert most[0] == 3


def test_failures_are_results():
    def function(x):
        if x[0] < 0.4:
            raise ZeroDivisionError("no torque")
        return math.nan if x[1] < 0.4 else bowl(x)

    result = run_study(function, RandomWalk(), evaluations=40)
    kinds = {(e.status, e.message) for e in result.evaluations}
    assert kinds == {
        ("ok", ""),
        ("failed", "ZeroDivisionError: no torque"),
        ("failed", "the cost or a constraint is nan"),
    }
    assert result.best.x[0] >= 0.4
    assert result.best.cost == min(e.cost for e in result.evaluations if e.status == "ok")


def test_timeout_is_a_failure_and_holds_up_nothing():
    def function(x):
        if x[0] > 0.55:
            time.sleep(1.0)
        return bowl(x)

    began = time.perf_counter()
    result = run_study(function, RandomWalk(), evaluations=9, parallel=3, timeout=0.1)
    late = [e for e in result.evaluations if e.status == "timeout"]
    assert late
    assert all(e.x[0] > 0.55 and "longer than 0.1 s" in e.message for e in late)
    assert time.perf_counter() - began < 0.9 * len(late) + 0.8


@pytest.mark.parametrize("cost", [math.nan, math.inf])
def test_cost_that_is_never_a_number_ends_the_study(cost):
    with pytest.raises(ComputationError, match=r"all of the first 10 evaluations failed"):
        run_study(lambda _: cost, RandomWalk(), evaluations=50)
    with pytest.raises(ComputationError, match=r"all of the first 4 evaluations failed"):
        run_study(lambda _: cost, RandomWalk(), evaluations=4)


def test_never_feasible_is_said_at_the_end():
    with pytest.raises(ComputationError, match="none of 12 evaluations is feasible"):
        run_study(
            lambda x: Outcome(cost=1.0, constraints=(x[1] + 1.0,)), RandomWalk(), evaluations=12
        )


def test_what_is_no_number_is_a_failure():
    result = run_study(lambda x: bowl(x) if x[0] > 0.5 else "much", RandomWalk(), evaluations=12)
    failed = [e for e in result.evaluations if e.status == "failed"]
    assert failed and all("expected a cost" in e.message for e in failed)


def test_callback_sees_all_and_may_end_the_study():
    seen = []
    result = run_study(
        bowl, RandomWalk(), evaluations=30, on_result=lambda e: seen.append(e) or len(seen) == 7
    )
    assert len(seen) == len(result.evaluations) == 7


def test_progress_is_reported(capsys):
    steps = []
    run_study(bowl, RandomWalk(), evaluations=3, progress=lambda *step: steps.append(step))
    assert steps == [(n, 3, "random-walk") for n in range(4)]
    run_study(bowl, RandomWalk(), evaluations=3, progress=True)
    captured = capsys.readouterr()
    assert "3/3" in captured.err and not captured.out


def test_used_tuner_is_refused():
    tuner = RandomWalk()
    tuner.ask()
    with pytest.raises(InputError, match="expected a fresh one"):
        run_study(bowl, tuner, evaluations=3)


@pytest.mark.parametrize(
    ("name", "value"), [("evaluations", 0), ("parallel", 0), ("timeout", 0.0), ("timeout", "soon")]
)
def test_bad_settings_are_named(name, value):
    with pytest.raises(InputError, match=name):
        run_study(bowl, RandomWalk(), **({"evaluations": 3} | {name: value}))


def test_study_goes_on_where_it_stopped(tmp_path):
    path = tmp_path / "study.sqlite"
    counted = []

    def function(x):
        counted.append(x)
        return Outcome(cost=bowl(x), variance=1e-3, measures={"a": x[0]}, replicates=(x[0], x[1]))

    whole = run_study(function, RandomWalk(), evaluations=25, parallel=2)
    counted.clear()
    for count in (4, 4, 11, 25, 25):
        result = run_study(function, RandomWalk(), evaluations=count, parallel=2, journal=path)
        same(result.evaluations, whole.evaluations[:count])
    assert len(counted) == 25
    assert result.evaluated == 0


def test_exception_in_a_callback_loses_nothing(tmp_path):
    path = tmp_path / "study.sqlite"

    def stop(evaluation):
        if evaluation.index == 5:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        run_study(bowl, RandomWalk(), evaluations=9, journal=path, on_result=stop)
    with Journal(path) as journal:
        assert len(journal.evaluations()) == 6
    result = run_study(bowl, RandomWalk(), evaluations=9, journal=path)
    assert result.evaluated == 3


def die_once(flag, x):
    """Kills its own process the first time that a point beyond 0.5 comes."""
    if x[0] > 0.5:
        try:
            os.close(os.open(flag, os.O_CREAT | os.O_EXCL))
        except FileExistsError:
            return bowl(x)
        os._exit(1)
    return bowl(x)


def pool(workers=2):
    return ProcessPoolExecutor(workers, mp_context=multiprocessing.get_context("spawn"))


def test_worker_that_dies_is_replaced(tmp_path):
    plain = run_study(bowl, RandomWalk(), evaluations=8, parallel=2)
    function = partial(die_once, str(tmp_path / "died"))
    result = run_study(function, RandomWalk(), evaluations=8, parallel=2, executor=pool)
    same(result.evaluations, plain.evaluations)
    assert (tmp_path / "died").exists()


def test_broken_executor_that_cannot_be_replaced_is_an_error(tmp_path):
    path = tmp_path / "study.sqlite"
    function = partial(die_once, str(tmp_path / "died"))
    settings = {"evaluations": 8, "parallel": 2, "journal": path}
    with pool() as executor, pytest.raises(ComputationError, match="start the study again"):
        run_study(function, RandomWalk(), executor=executor, **settings)
    plain = run_study(bowl, RandomWalk(), evaluations=8, parallel=2)
    same(run_study(function, RandomWalk(), **settings).evaluations, plain.evaluations)


def slow(x):
    time.sleep(0.02)
    return bowl(x)


def take_part(path, queue):
    result = run_study(slow, RandomWalk(), evaluations=40, parallel=4, journal=path)
    queue.put((result.evaluated, points(result)))


def test_two_processes_work_on_one_study(tmp_path):
    path = tmp_path / "study.sqlite"
    plain = run_study(bowl, RandomWalk(), evaluations=40, parallel=4)
    context = multiprocessing.get_context("spawn")
    queue = context.Queue()
    workers = [context.Process(target=take_part, args=(path, queue)) for _ in range(2)]
    for worker in workers:
        worker.start()
    found = [queue.get(timeout=120) for _ in workers]
    for worker in workers:
        worker.join()
    shares = [evaluated for evaluated, _ in found]
    assert sum(shares) == 40  # nothing was evaluated twice
    for _, x in found:
        assert np.array_equal(x, points(plain))


def test_threads_share_a_study(tmp_path):
    path = tmp_path / "study.sqlite"
    with ThreadPoolExecutor(2) as executor:
        runs = [
            executor.submit(run_study, slow, RandomWalk(), evaluations=30, parallel=4, journal=path)
            for _ in range(2)
        ]
        shares = [run.result().evaluated for run in runs]
    assert sum(shares) == 30
    assert min(shares) > 3
