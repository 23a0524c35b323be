"""One tuner on one tuning problem."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping
from concurrent.futures import Executor, ThreadPoolExecutor
from contextlib import AbstractContextManager, nullcontext
from dataclasses import dataclass
from os import PathLike

from numpy.typing import ArrayLike

from pitchopt.studies.tuning.problem import TuningProblem, start_within
from pitchopt.tuning import Evaluation, StudyResult, Tuner, ZerothOrder, run_study
from pitchopt.tuning.methods import make_tuner

__all__ = ["BUDGET", "Tuned", "tune", "tuner_for"]

BUDGET = 25
"""Evaluations for each parameter, unless a number is given or the tuner has its own."""

Progress = Callable[[int, int, str], None]


@dataclass(frozen=True, kw_only=True)
class Tuned:
    """What a tuner made of a problem.

    Attributes
    ----------
    problem : TuningProblem
    method : str
        Name of the tuner.
    start : Evaluation
        Of the start of the problem.
    result : StudyResult
    simulations : int
        Of the whole study, those of earlier runs that its journal kept included.
    seconds : float
        Wall time of this run.
    """

    problem: TuningProblem
    method: str
    start: Evaluation
    result: StudyResult
    simulations: int
    seconds: float

    @property
    def best(self) -> Evaluation:
        """Evaluation of the best point."""
        return self.result.best.evaluation

    @property
    def gain(self) -> float:
        """What the cost fell by, over the absolute value at the start."""
        return (self.start.cost - self.best.cost) / abs(self.start.cost)


def tuner_for(
    problem: TuningProblem,
    method: str,
    *,
    start: ArrayLike | None = None,
    evaluations: int | None = None,
    seed: int = 0,
    options: Mapping[str, object] | None = None,
) -> tuple[Tuner, int]:
    """Tuner of a problem, whose winds are checked, and the most evaluations; see `tune`."""
    problem.check_winds()
    proposed = problem.tuner_options(method)
    first = proposed.pop("start", problem.start)
    limit = BUDGET * len(problem.space) if evaluations is None else evaluations
    tuner = make_tuner(
        method,
        problem.space,
        start=start_within(problem.space, first if start is None else start),
        evaluations=limit,
        seed=seed,
        options=proposed | dict(options or {}),
    )
    if evaluations is None and isinstance(tuner, ZerothOrder):
        limit = tuner.most_evaluations
    return tuner, limit


def tune(
    problem: TuningProblem,
    method: str,
    *,
    start: ArrayLike | None = None,
    evaluations: int | None = None,
    seed: int = 0,
    options: Mapping[str, object] | None = None,
    parallel: int = 1,
    executor: Executor | Callable[[], Executor] | None = None,
    journal: str | PathLike[str] | None = None,
    timeout: float | None = None,
    on_result: Callable[[Evaluation], bool | None] | None = None,
    progress: bool | Progress = False,
) -> Tuned:
    """Tune a problem with a method by name.

    Parameters
    ----------
    problem : TuningProblem
    method : str
        One of `pitchopt.tuning.methods.METHODS`.
    start : (d,) array_like, optional
        Where the tuner begins; that of the problem's proposal or of the problem without.
    evaluations : int, optional
        At most so many.  Without, the zeroth-order tuner has its stages to the end, and others
        have `BUDGET` times the number of parameters.
    seed : int
        Of the tuner.
    options : mapping, optional
        Of the tuner, before those that the problem proposes.
    parallel : int
        Candidates side by side; in threads where there is no executor.
    executor, journal, timeout, on_result, progress
        See `run_study`.

    Raises
    ------
    InputError, ComputationError
        See `run_study`; also if there is no such method or option, or the start cannot be judged.
    """
    began = time.perf_counter()
    tuner, limit = tuner_for(
        problem, method, start=start, evaluations=evaluations, seed=seed, options=options
    )
    threads: AbstractContextManager[Executor | Callable[[], Executor] | None] = (
        ThreadPoolExecutor(parallel) if executor is None and parallel > 1 else nullcontext(executor)
    )
    with threads as crew:
        result = run_study(
            problem,
            tuner,
            evaluations=limit,
            parallel=parallel,
            executor=crew,
            journal=journal,
            problem=problem.document(),
            timeout=timeout,
            on_result=on_result,
            progress=progress,
        )
    reference = problem.reference
    reference_point = Evaluation(
        index=-1,
        x=problem.start,
        cost=reference.cost,
        variance=reference.variance,
        measures=reference.measures,
        replicates=reference.replicates,
        origin="start",
    )
    return Tuned(
        problem=problem,
        method=method,
        start=reference_point,
        result=result,
        simulations=problem.simulations_in([e.x for e in result.evaluations]),
        seconds=time.perf_counter() - began,
    )
