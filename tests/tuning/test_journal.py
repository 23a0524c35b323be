"""Journals: what they give back, what they refuse, and runs that are killed."""

import csv
import json
import math
import os
import sqlite3
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from killed_study import EVALUATIONS, build, noisy_bowl
from random_walk import SPACE, RandomWalk, bowl
from test_study import same

from pitchopt.errors import InputError
from pitchopt.tuning import Candidate, Evaluation, Journal, Outcome, run_study
from pitchopt.tuning.methods import METHODS as TUNERS

SCRIPT = Path(__file__).with_name("killed_study.py")
SETTINGS = {"space": SPACE.document(), "problem": {"name": "bowl", "speed": 8.0}}


def written(path, **settings):
    run_study(
        lambda x: Outcome(cost=bowl(x), measures={"first": x[0]}),
        RandomWalk(),
        evaluations=5,
        journal=path,
        **settings,
    )
    return path


def test_floats_come_back_to_the_last_bit(tmp_path):
    rng = np.random.default_rng(3)
    evaluations = [
        Evaluation(
            index=k,
            x=SPACE.from_unit(rng.random(2)),
            cost=float(rng.normal() * 10.0 ** rng.integers(-300, 300)),
            variance=None if k % 2 else float(rng.random()),
            constraints=(float(rng.normal()), -math.inf),
            measures={"mean power": float(rng.random()), "peak": math.nan},
            replicates=tuple(rng.random(3)),
            seconds=0.25,
            origin=f"stage {k}",
            note={"lengths": rng.random(2).tolist(), "kind": "x"},
        )
        for k in range(20)
    ]
    with Journal(tmp_path / "j", SETTINGS) as journal:
        for e in evaluations:
            journal.ask(Candidate(index=e.index, x=e.x, origin=e.origin, note=e.note))
            journal.tell(e)
    with Journal(tmp_path / "j") as journal:
        assert journal.settings == json.loads(json.dumps(SETTINGS))
        back = journal.evaluations()
    for old, new in zip(evaluations, back, strict=True):
        assert np.array_equal(old.x, new.x)
        assert (old.cost, old.variance, old.constraints, old.replicates) == (
            new.cost,
            new.variance,
            new.constraints,
            new.replicates,
        )
        assert old.note == new.note
        assert math.isnan(new.measures["peak"])
        assert new.measures["mean power"] == old.measures["mean power"]


def test_every_evaluation_is_on_disk_before_the_next_is_asked(tmp_path):
    """What another connection reads while the function runs."""
    path = tmp_path / "j"

    def function(x):
        with Journal(path) as journal:
            candidates, results = len(journal.candidates()), len(journal.evaluations())
        assert results == candidates - 1
        return bowl(x)

    result = run_study(function, RandomWalk(), evaluations=8, journal=path)
    assert [e.status for e in result.evaluations] == ["ok"] * 8


def test_log_is_written_ahead(tmp_path):
    path = written(tmp_path / "j")
    with sqlite3.connect(path) as database:
        assert database.execute("pragma journal_mode").fetchone() == ("wal",)
    database.close()


def test_a_result_is_written_once(tmp_path):
    with Journal(tmp_path / "j", SETTINGS) as journal:
        x = SPACE.from_unit([0.2, 0.3])
        journal.ask(Candidate(index=0, x=x))
        journal.tell(Evaluation(index=0, x=x, cost=1.0))
        journal.tell(Evaluation(index=0, x=x, cost=2.0))
        assert [e.cost for e in journal.evaluations()] == [1.0]
        with pytest.raises(InputError, match="as candidate 0, and the study asks for"):
            journal.ask(Candidate(index=0, x=x + 0.1))


def test_claims_of_the_dead_fall_to_the_living(tmp_path):
    path = tmp_path / "j"
    with Journal(path, SETTINGS) as first, Journal(path, SETTINGS) as second:
        for k in range(3):
            first.ask(Candidate(index=k, x=SPACE.from_unit([0.1 * k, 0.5])))
        assert first.claim(0)
        assert first.claim(0)  # its own still
        assert not second.claim(0)
        first.release()
        assert second.claim(0)
        assert second.claim(1)
        gone = subprocess.Popen([sys.executable, "-c", ""])
        gone.wait()
        with sqlite3.connect(path) as database:
            database.execute("update claims set process=? where number=1", (gone.pid,))
        database.close()
        assert first.claim(1)
        with sqlite3.connect(path) as database:  # a living process that has the number of a dead
            database.execute(
                "insert into claims values (2, ?, 'before', 'someone')", (os.getppid(),)
            )
        database.close()
        assert first.claim(2)
        first.tell(Evaluation(index=2, x=SPACE.from_unit([0.2, 0.5]), cost=0.0))
        assert not second.claim(2)


def test_table_and_csv(tmp_path):
    path = written(tmp_path / "j")
    with Journal(path) as journal:
        names, rows = journal.table()
        journal.write_csv(tmp_path / "study.csv")
    assert names == [
        *("number", "origin", "a", "b", "status", "cost", "variance", "first", "seconds"),
        "message",
    ]
    assert [row[0] for row in rows] == list(range(5))
    with (tmp_path / "study.csv").open(newline="") as file:
        read = list(csv.reader(file))
    assert read[0] == names
    assert [float(row[5]) for row in read[1:]] == [row[5] for row in rows]
    assert {row[6] for row in read[1:]} == {""}


@pytest.mark.parametrize(
    ("change", "text"),
    [
        ({"tuner": RandomWalk(seed=1)}, "tuner.seed is 0, here 1"),
        ({"tuner": RandomWalk(batch=4)}, "tuner.batch is 3, here 4"),
        ({"problem": {"name": "other"}}, 'problem.name is "bowl", here "other"'),
        ({"problem": {"name": "bowl", "version": 2}}, "problem.version is null, here 2"),
        ({"parallel": 2}, "parallel is 1, here 2"),
    ],
)
def test_journal_of_another_study_is_refused(change, text, tmp_path):
    path = written(tmp_path / "j", problem={"name": "bowl"})
    before = path.read_bytes()
    settings = {"tuner": RandomWalk(), "problem": {"name": "bowl"}} | change
    with pytest.raises(InputError, match="of another study") as caught:
        run_study(bowl, evaluations=6, journal=path, **settings)
    assert text in str(caught.value)
    assert path.read_bytes() == before


def test_another_format_is_refused(tmp_path):
    path = written(tmp_path / "j")
    with sqlite3.connect(path) as database:
        database.execute("pragma user_version=99")
    database.close()
    with pytest.raises(InputError, match="has format 99, expected 1"):
        run_study(bowl, RandomWalk(), evaluations=6, journal=path)


def replaced(_):
    return b"no database at all" * 20


def stump(data):
    return data[:50]


def cut(data):
    return data[: len(data) // 2]


def scribbled(data):
    return data[:200] + b"\xa5" * (len(data) - 200)


@pytest.mark.parametrize("damage", [replaced, cut, scribbled, stump])
@pytest.mark.parametrize("settings", [None, SETTINGS])
def test_damaged_file_is_refused_and_left_alone(damage, settings, tmp_path):
    path = written(tmp_path / "j")
    path.write_bytes(damage(path.read_bytes()))
    before = path.read_bytes()
    with pytest.raises(InputError, match="journal: "), Journal(path, settings) as journal:
        journal.table()
    assert path.read_bytes() == before


def test_database_of_another_program_is_refused_and_left_alone(tmp_path):
    path = tmp_path / "other.sqlite"
    with sqlite3.connect(path) as database:
        database.execute("create table precious (data text)")
    database.close()
    before = path.read_bytes()
    for settings in (None, SETTINGS):
        with pytest.raises(InputError, match="no journal of a study"):
            Journal(path, settings)
    with sqlite3.connect(path) as database:
        assert database.execute("select name from sqlite_master").fetchall() == [("precious",)]
    database.close()
    assert len(path.read_bytes()) == len(before)


def test_read_only_file_is_refused_for_writing_and_read(tmp_path):
    path = written(tmp_path / "j")
    path.chmod(0o444)
    with pytest.raises(InputError, match="is read-only"):
        run_study(bowl, RandomWalk(), evaluations=6, journal=path)
    with Journal(path) as journal:
        assert len(journal.table()[1]) == 5


def test_paths_that_cannot_be(tmp_path):
    with pytest.raises(InputError, match="there is no folder"):
        run_study(bowl, RandomWalk(), evaluations=1, journal=tmp_path / "none" / "j")
    with pytest.raises(InputError, match="journal"):
        run_study(bowl, RandomWalk(), evaluations=1, journal=tmp_path)
    with pytest.raises(InputError, match="there is no file"):
        Journal(tmp_path / "none")
    assert list(tmp_path.iterdir()) == []


def test_full_disk_is_one_error_and_loses_nothing(tmp_path, monkeypatch):
    path = tmp_path / "study.sqlite"
    connect = sqlite3.connect

    def limited(*args, **options):
        database = connect(*args, **options)
        database.execute("pragma max_page_count=12")
        return database

    def wide(x):
        return Outcome(cost=bowl(x), measures={f"m{k}": np.pi * k for k in range(60)})

    whole = run_study(wide, RandomWalk(seed=1), evaluations=30)
    told = []
    with monkeypatch.context() as patch:
        patch.setattr(sqlite3, "connect", limited)
        with pytest.raises(InputError, match="database or disk is full"):
            run_study(wide, RandomWalk(seed=1), evaluations=30, journal=path, on_result=told.append)
    assert 3 < len(told) < 30
    with Journal(path) as journal:
        same(journal.evaluations(), told)
    result = run_study(wide, RandomWalk(seed=1), evaluations=30, journal=path)
    assert result.evaluated == 30 - len(told)
    same(result.evaluations, whole.evaluations)


@pytest.mark.parametrize("statement", ["begin", "insert into candidates", "insert or", "commit"])
def test_interrupt_inside_a_transaction_leaves_the_journal_whole(statement, tmp_path, monkeypatch):
    path = tmp_path / "study.sqlite"
    connect, seen = sqlite3.connect, []

    class Interrupted(sqlite3.Connection):
        def execute(self, query, *values):
            done = super().execute(query, *values)
            if query.startswith(statement):
                seen.append(query)
                if len(seen) == 9:
                    raise KeyboardInterrupt
            return done

    with monkeypatch.context() as patch:
        patch.setattr(sqlite3, "connect", lambda *a, **k: connect(*a, factory=Interrupted, **k))
        with pytest.raises(KeyboardInterrupt):
            run_study(bowl, RandomWalk(seed=1), evaluations=20, journal=path)
    whole = run_study(bowl, RandomWalk(seed=1), evaluations=20)
    result = run_study(bowl, RandomWalk(seed=1), evaluations=20, journal=path)
    assert 0 < result.evaluated < 20
    same(result.evaluations, whole.evaluations)


METHODS = ("random-walk", *TUNERS)
KILLS = 50


@pytest.fixture(scope="module")
def killed(tmp_path_factory):
    """Folder with the journals of killed studies, and how far each was at its kills."""
    if not hasattr(os, "fork"):
        pytest.skip("needs fork and SIGKILL")
    folder = tmp_path_factory.mktemp("killed")
    environment = os.environ | {
        "PYTHONPATH": os.pathsep.join([str(SCRIPT.parent), *filter(None, sys.path)])
    }
    kills = -(-KILLS // len(METHODS))
    script = [sys.executable, str(SCRIPT), str(folder), ",".join(METHODS), str(kills), "7"]
    done = subprocess.run(script, capture_output=True, text=True, check=True, env=environment)
    return folder, kills, json.loads(done.stdout)


@pytest.mark.slow
@pytest.mark.parametrize("method", METHODS)
def test_killed_study_goes_on_as_if_unbroken(method, killed):
    folder, kills, every = killed
    path, reached = folder / f"{method}.sqlite", every[method]
    assert len(reached) == kills
    assert reached == sorted(reached)  # nothing that was written is lost
    assert len(set(reached)) > min(3, kills // 4)
    whole = run_study(noisy_bowl, build(method), evaluations=EVALUATIONS, parallel=2)
    result = run_study(noisy_bowl, build(method), evaluations=EVALUATIONS, parallel=2, journal=path)
    same(result.evaluations, whole.evaluations)
    with Journal(path) as journal:
        same(journal.evaluations(), whole.evaluations)
