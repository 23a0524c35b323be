"""A study: a tuner, a function, an executor, and a journal that keeps all of it.

Results are told to the tuner one by one in the order of candidates, and after each as many
candidates are asked for as bring the number of untold ones back to `parallel`.  What the tuner is
asked, and when, so depends on `parallel` alone: not on how long evaluations take, who makes them
or how often the study was killed.
"""

from __future__ import annotations

import itertools
import sys
import threading
import time
from collections.abc import Callable, Iterator, Mapping
from concurrent.futures import (
    FIRST_COMPLETED,
    BrokenExecutor,
    CancelledError,
    Executor,
    Future,
    wait,
)
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from os import PathLike
from typing import Any, NamedTuple

from pitchopt.checks import FloatArray, finite_number, whole_number
from pitchopt.errors import ComputationError, InputError
from pitchopt.tuning.evaluations import (
    Best,
    Candidate,
    Evaluation,
    EvaluationStatus,
    Outcome,
    evaluation_of,
)
from pitchopt.tuning.journal import Journal
from pitchopt.tuning.tuner import Tuner

__all__ = ["StudyResult", "run_study"]

Objective = Callable[[FloatArray], float | Outcome]
Progress = Callable[[int, int, str], None]

HOPELESS = 10
"""Evaluations of which one at least must be no failure."""
_ATTEMPTS = 3  # to evaluate a candidate whose workers die
_POLL = 0.05  # between looks at what other processes wrote, and at the clock [s]


@dataclass(frozen=True, kw_only=True)
class StudyResult:
    """What a study found.

    Attributes
    ----------
    tuner : Tuner
        As it is at the end; it can be asked on.
    evaluations : tuple of Evaluation
        In the order of candidates.
    best : Best
    seconds : float
        Wall time of this run; a study that was taken up counts from there.
    evaluated : int
        Evaluations that this run made itself; the others came from the journal.
    """

    tuner: Tuner
    evaluations: tuple[Evaluation, ...]
    best: Best
    seconds: float
    evaluated: int


def run_study(
    function: Objective,
    tuner: Tuner,
    *,
    evaluations: int,
    parallel: int = 1,
    executor: Executor | Callable[[], Executor] | None = None,
    journal: str | PathLike[str] | None = None,
    problem: Mapping[str, object] | None = None,
    timeout: float | None = None,
    on_result: Callable[[Evaluation], bool | None] | None = None,
    progress: bool | Progress = False,
) -> StudyResult:
    """Run a tuner on a function.

    Parameters
    ----------
    function : callable
        Takes a point (d,) and returns its cost or an `Outcome`.  What it raises is a failed
        evaluation.  An executor of processes needs one that pickles.
    tuner : Tuner
        Fresh: it has not been asked yet.
    evaluations : int
        Most evaluations, all told; a tuner may want fewer.
    parallel : int
        Candidates that are evaluated side by side.  Part of what the study is: a tuner that is
        asked ahead of results asks for other points.
    executor : Executor or callable, optional
        Any of `concurrent.futures`, such as a process pool, or Dask's ``client.get_executor()``.
        One that breaks when a worker dies (a process pool) is made anew where a callable is given.
        This thread by default.
    journal : path, optional
        File that the study is kept in and taken up from.
    problem : mapping, optional
        Plain data that names the function with all that its results depend on.
    timeout : float, optional
        Longest time of one evaluation from when it is handed to the executor [s]; after it the
        candidate counts as failed and its late result is not used.
    on_result : callable, optional
        Called with each evaluation when the tuner is told of it; ends the study by returning True.
    progress : bool or callable
        A bar on standard error, or a function of evaluations done, evaluations in all and a label.

    Raises
    ------
    InputError
        If the tuner is not fresh, or the journal is of another study, damaged or not writable.
    ComputationError
        If the first ten evaluations or all of them fail, or no evaluation is feasible in the end.
    """
    if tuner.evaluations or tuner.pending:
        raise InputError("tuner: got one that was asked or told before, expected a fresh one")
    count = whole_number("evaluations", evaluations, at_least=1)
    parallel = whole_number("parallel", parallel, at_least=1)
    if timeout is not None:
        timeout = finite_number("timeout", timeout, above=0.0)
    settings = {
        "space": tuner.space.document(),
        "tuner": {"name": tuner.name, "seed": tuner.seed, **tuner.settings()},
        "parallel": parallel,
        "problem": dict(problem or {}),
    }
    began = time.perf_counter()
    book = None if journal is None else Journal(journal, settings)
    crew = _Crew(function, executor, timeout)
    try:
        study = _Study(tuner, crew, book, count=count, parallel=parallel)
        with _shown(progress, tuner.name) as show:
            show(0, count, tuner.name)
            for evaluation in iter(study.step, None):
                show(len(tuner.evaluations), count, tuner.name)
                if on_result is not None and on_result(evaluation):
                    break
        best = tuner.best()
    finally:
        crew.close()
        if book is not None:
            with book, suppress(InputError):  # which would hide what ended the study
                book.release()
    return StudyResult(
        tuner=tuner,
        evaluations=tuner.evaluations,
        best=best,
        seconds=time.perf_counter() - began,
        evaluated=study.evaluated,
    )


class _Study:
    """The order of asking, evaluating and telling."""

    def __init__(
        self, tuner: Tuner, crew: _Crew, journal: Journal | None, *, count: int, parallel: int
    ) -> None:
        self.tuner = tuner
        self.evaluated = 0
        self._crew = crew
        self._journal = journal
        self._count = count
        self._parallel = parallel
        self._untold: list[Candidate] = []
        self._results: dict[int, Evaluation] = {}
        self._asked = 0
        self._failed = 0

    def step(self) -> Evaluation | None:
        """Next evaluation in the order of candidates, or None at the end."""
        self._ask()
        if not self._untold:
            return None
        first = self._untold[0]
        while (evaluation := self._known(first)) is None:
            self._start()
            self._collect()
        self._untold.pop(0)
        self._results.pop(first.index, None)
        told = self.tuner.tell(first, evaluation)
        self._failed += told.status != "ok"
        done = len(self.tuner.evaluations)
        if self._failed == done and done in (HOPELESS, self._count):
            raise ComputationError(
                f"all of the first {done} evaluations failed; the last: {told.message}"
            )
        return told

    def _ask(self) -> None:
        while len(self._untold) < self._parallel and self._asked < self._count:
            known = None if self._journal is None else self._journal.candidate(self._asked)
            candidate = self._next() if known is None else self.tuner.adopt(known)
            if candidate is None:
                return
            if known is None and self._journal is not None:
                self._journal.ask(candidate)
            self._asked += 1
            self._untold.append(candidate)

    def _next(self) -> Candidate | None:
        return next(iter(self.tuner.ask(1)), None)

    def _known(self, candidate: Candidate) -> Evaluation | None:
        found = self._results.get(candidate.index)
        if found is None and self._journal is not None:
            found = self._journal.result(candidate.index)
        return found

    def _start(self) -> None:
        for candidate in self._untold:
            if not self._crew.idle(candidate) or self._known(candidate) is not None:
                continue
            if self._journal is None or self._journal.claim(candidate.index):
                self._crew.start(candidate)
                if self._crew.serial:
                    return

    def _collect(self) -> None:
        for evaluation in self._crew.finished():
            self.evaluated += 1
            self._results[evaluation.index] = evaluation
            if self._journal is not None:
                self._journal.tell(evaluation)


class _Running(NamedTuple):
    candidate: Candidate
    began: float
    executor: Executor


class _Crew:
    """Evaluations under way in an executor, or in this thread."""

    def __init__(
        self,
        function: Objective,
        executor: Executor | Callable[[], Executor] | None,
        timeout: float | None,
    ) -> None:
        self._function = function
        self._timeout = timeout
        self._make = None if executor is None or isinstance(executor, Executor) else executor
        self._executor = executor if isinstance(executor, Executor) else None
        if executor is None and timeout is not None:
            self._executor = _Threads()
        self._running: dict[Future[Evaluation], _Running] = {}
        self._inline: list[Candidate] = []
        self._attempts: dict[int, int] = {}

    @property
    def serial(self) -> bool:
        """Whether evaluations are made in this thread."""
        return self._executor is None and self._make is None

    def idle(self, candidate: Candidate) -> bool:
        """Whether nobody here works on a candidate."""
        return all(run.candidate.index != candidate.index for run in self._running.values())

    def start(self, candidate: Candidate) -> None:
        if self.serial:
            self._inline.append(candidate)
            return
        if self._executor is None and self._make is not None:
            self._executor = self._make()
        assert self._executor is not None
        try:
            future = self._executor.submit(_evaluate, self._function, candidate)
        except BrokenExecutor as error:
            self._renew(self._executor, error)
            return
        self._running[future] = _Running(candidate, time.monotonic(), self._executor)

    def finished(self) -> list[Evaluation]:
        """What has come in since; waits a little where nothing has."""
        if self._inline:
            return [_evaluate(self._function, self._inline.pop())]
        if not self._running:
            time.sleep(_POLL)
            return []
        done, _ = wait(self._running, timeout=_POLL, return_when=FIRST_COMPLETED)
        found = []
        for future in sorted(done, key=lambda f: self._running[f].candidate.index):
            run = self._running.pop(future)
            try:
                found.append(future.result())
            except (BrokenExecutor, CancelledError) as error:
                found += self._lost(run, error)
            except Exception as error:  # noqa: BLE001  what an executor says of one evaluation
                found.append(_failed(run.candidate, f"{type(error).__name__}: {error}"))
        return found + self._overdue()

    def _overdue(self) -> list[Evaluation]:
        if self._timeout is None:
            return []
        now = time.monotonic()
        found = []
        for future in [f for f, run in self._running.items() if now - run.began > self._timeout]:
            run = self._running.pop(future)
            future.cancel()
            text = f"took longer than {self._timeout:g} s"
            found.append(_failed(run.candidate, text, now - run.began, status="timeout"))
        return found

    def _lost(self, run: _Running, error: BaseException) -> list[Evaluation]:
        """A worker died over a candidate, or over another one beside it."""
        candidate = run.candidate
        attempts = self._attempts[candidate.index] = self._attempts.get(candidate.index, 0) + 1
        if attempts >= _ATTEMPTS:
            return [_failed(candidate, f"its worker died {attempts} times: {error}")]
        if isinstance(error, BrokenExecutor):
            self._renew(run.executor, error)
        return []

    def _renew(self, broken: Executor, error: BaseException) -> None:
        if broken is not self._executor:
            return  # done already, when another of its evaluations came back
        if self._make is None:
            raise ComputationError(
                f"the executor broke ({error}); give a callable that makes one to go on with "
                "another, or start the study again from its journal"
            ) from error
        broken.shutdown(wait=False, cancel_futures=True)
        self._executor = None

    def close(self) -> None:
        """Drop what is still running; an executor that was made here is shut down."""
        for future in self._running:
            future.cancel()
        if self._executor is not None and (
            self._make is not None or isinstance(self._executor, _Threads)
        ):
            self._executor.shutdown(wait=False, cancel_futures=True)


class _Threads(Executor):
    """A thread for each evaluation, so that one that never ends holds up nothing."""

    _numbers = itertools.count()

    def submit(self, fn: Callable[..., Any], /, *args: Any, **kwargs: Any) -> Future[Any]:
        future: Future[Any] = Future()

        def work() -> None:
            if not future.set_running_or_notify_cancel():
                return
            try:
                future.set_result(fn(*args, **kwargs))
            except BaseException as error:  # noqa: BLE001  handed over, as executors do
                future.set_exception(error)

        name = f"evaluation-{next(self._numbers)}"
        threading.Thread(target=work, name=name, daemon=True).start()
        return future


def _evaluate(function: Objective, candidate: Candidate) -> Evaluation:
    began = time.perf_counter()
    try:
        outcome = function(candidate.x)
        if not isinstance(outcome, Outcome):
            outcome = Outcome(cost=outcome)
    except Exception as error:  # noqa: BLE001  whatever it is, this point failed
        return _failed(candidate, f"{type(error).__name__}: {error}", time.perf_counter() - began)
    return evaluation_of(candidate, outcome, seconds=time.perf_counter() - began)


def _failed(
    candidate: Candidate,
    message: str,
    seconds: float = 0.0,
    status: EvaluationStatus = "failed",
) -> Evaluation:
    return Evaluation(
        index=candidate.index,
        x=candidate.x,
        status=status,
        message=message,
        seconds=seconds,
        origin=candidate.origin,
        note=candidate.note,
    )


@contextmanager
def _shown(progress: bool | Progress, label: str) -> Iterator[Progress]:
    """The progress that was asked for, as a function."""
    if callable(progress):
        yield progress
        return
    from tqdm import tqdm

    with tqdm(file=sys.stderr, unit="evaluation", desc=label, disable=not progress) as bar:

        def show(done: int, total: int, _: str) -> None:
            bar.total = total
            bar.update(done - bar.n)

        yield show
