"""Tuning problems by name, with the winds and the turbine that the commands describe."""

from __future__ import annotations

import copy
from collections.abc import Callable, Mapping, Sequence
from difflib import get_close_matches
from os import PathLike
from typing import Any, Protocol

from pitchopt.errors import InputError
from pitchopt.studies.simulation import controller_text
from pitchopt.studies.tuning.document import FIRST_FRESH, agreement_record, tuned_document
from pitchopt.studies.tuning.individual_pitch import IndividualPitchGains, individual_pitch_plant
from pitchopt.studies.tuning.minimum_pitch_task import MinimumPitchTask
from pitchopt.studies.tuning.plant import TuningPlant
from pitchopt.studies.tuning.problem import TuningProblem, start_within
from pitchopt.studies.tuning.speed_regulator import Load, SpeedRegulator
from pitchopt.studies.tuning.torque_gain import TURBULENCE, TorqueGain
from pitchopt.studies.tuning.tune import Progress, Tuned, tune, tuner_for
from pitchopt.turbines import Turbine

__all__ = ["PROBLEMS", "Task", "TaskResult", "fresh_gain", "make_task"]

PROBLEMS = ("torque-gain", "speed-regulator", "minimum-pitch", "individual-pitch")
"""Names of the tuning problems."""


class TaskResult(Protocol):
    """What a method made of a task."""

    def document(self, *, check_seeds: int | None = None) -> dict[str, Any]:
        """Plain data; with what start and best are worth in so many winds that no tuner saw."""

    def figures(self) -> Mapping[str, Callable[[], bytes]]:
        """Pictures by the names of their files, made when they are asked for."""

    def controllers(self) -> Mapping[str, str]:
        """Controller files by name, where what was tuned has one."""


class Task(Protocol):
    """A tuning problem, ready for any method."""

    @property
    def name(self) -> str:
        """One of `PROBLEMS`."""

    def check(self, method: str, **settings: Any) -> None:
        """See before anything is computed that a tuner goes with these settings of `tune`."""

    def tune(
        self,
        method: str,
        *,
        journal: str | PathLike[str] | None = None,
        progress: bool | Progress = False,
        **settings: Any,
    ) -> TaskResult:
        """Tune it; `settings` as in `pitchopt.studies.tuning.tune`."""


def fresh_gain(problem: TuningProblem, best: Sequence[float], seeds: int) -> dict[str, float]:
    """Cost of start and best, and the gain, with seeds that no tuner saw."""
    fresh = problem.with_seeds(range(FIRST_FRESH, FIRST_FRESH + seeds))
    start, found = fresh.reference.cost, fresh(best).cost
    return {
        "fresh_start_cost": start,
        "fresh_best_cost": found,
        "fresh_gain": (start - found) / abs(start),
    }


class ProblemTask:
    """Task of one problem with one space.

    Parameters
    ----------
    problem : TuningProblem
    start : sequence of float, optional
        Where tuners begin, if not where the problem proposes.
    """

    def __init__(self, problem: TuningProblem, start: Sequence[float] | None = None) -> None:
        self.problem = problem
        self.start = None if start is None else start_within(problem.space, start)

    @property
    def name(self) -> str:
        """Of the problem."""
        return self.problem.name

    def check(self, method: str, **settings: Any) -> None:
        """See `Task`."""
        own = ("evaluations", "seed", "options")
        chosen = {name: settings[name] for name in own if name in settings}
        tuner_for(self.problem, method, start=self.start, **chosen)

    def tune(
        self,
        method: str,
        *,
        journal: str | PathLike[str] | None = None,
        progress: bool | Progress = False,
        **settings: Any,
    ) -> ProblemResult:
        """Tune the problem; every method finds it fresh."""
        problem = copy.copy(self.problem)
        settings = {"start": self.start, "journal": journal, "progress": progress, **settings}
        return ProblemResult(tune(problem, method, **settings))


class ProblemResult:
    """A tuned problem."""

    def __init__(self, tuned: Tuned) -> None:
        self.tuned = tuned

    def document(self, *, check_seeds: int | None = None) -> dict[str, Any]:
        """See `TaskResult`."""
        document = tuned_document(self.tuned) | agreement_record(self.tuned)
        if check_seeds is not None:
            best = self.tuned.best.x.tolist()
            document |= fresh_gain(self.tuned.problem, best, check_seeds)
        return document

    def figures(self) -> Mapping[str, Callable[[], bytes]]:
        """See `TaskResult`."""
        from pitchopt.studies.tuning.pictures import pictures

        return pictures(self.tuned)

    def controllers(self) -> Mapping[str, str]:
        """See `TaskResult`; of individual pitch, the best point as it was simulated."""
        problem, best = self.tuned.problem, self.tuned.best
        if not isinstance(problem, IndividualPitchGains):
            return {}
        speeds = ", ".join(f"{speed:g}" for speed in problem.wind_speeds)
        comment = (
            (
                f"{problem.plant.turbine.name}, {speeds} m/s: individual pitch tuned by "
                f"{self.tuned.method}"
            ),
            (
                f"with pitch actuators of {problem.plant.pitch_lag:g} s; see pitchopt simulate "
                "--pitch-lag"
            ),
        )
        return {"controller.toml": controller_text(problem.controller(best.x), comment=comment)}


def make_task(
    name: str,
    turbine: str | Turbine = "nrel-5mw",
    *,
    wind_speeds: Sequence[float] | None = None,
    seeds: Sequence[int] | None = None,
    start: Sequence[float] | None = None,
    bounds: Mapping[str, tuple[float, float]] | None = None,
    load: str | None = None,
    kappa: Sequence[float] | None = None,
    turbulence: str | None = None,
    pitch_lag: float | None = None,
    **plant: Any,
) -> Task:
    """Task of a name.

    Parameters
    ----------
    name : str
        One of `PROBLEMS`.
    turbine : str or Turbine
    wind_speeds, seeds, start, turbulence, pitch_lag : optional
        Those of the problem without.
    bounds : mapping, optional
        Low and high bound of parameters by name.
    load : {"tower", "blade"}, optional
        Of the speed regulator.
    kappa : sequence of float, optional
        Of the minimum pitch.
    **plant
        Of `TuningPlant`.

    Raises
    ------
    InputError
        If there is no such problem, or a setting does not go with it.
    """
    if name not in PROBLEMS:
        close = get_close_matches(name, PROBLEMS, n=1)
        hint = f"; did you mean {close[0]}?" if close else ""
        raise InputError(f"problem: got {name!r}, expected one of {', '.join(PROBLEMS)}{hint}")
    for field, value, owner in (
        ("load", load, "speed-regulator"),
        ("kappa", kappa, "minimum-pitch"),
    ):
        if value is not None and name != owner:
            raise InputError(f"{field}: got {value!r} for {name}, expected it for {owner} alone")
    given: dict[str, Any] = {
        key: value
        for key, value in (
            ("wind_speeds", wind_speeds),
            ("seeds", seeds),
        )
        if value is not None
    }
    plant |= {
        key: value
        for key, value in (("turbulence", turbulence), ("pitch_lag", pitch_lag))
        if value is not None
    }
    problem: TuningProblem
    if name == "minimum-pitch":
        fixed = {"wind_speeds": wind_speeds, "start": start, "bounds": bounds}
        for field, own in fixed.items():
            if own:
                raise InputError(
                    f"{field}: got {own!r} for minimum-pitch, expected none: breakpoints, first "
                    "table and bounds come from the algorithm"
                )
        chosen: dict[str, Any] = {
            k: v for k, v in (("kappa", kappa), ("seeds", seeds)) if v is not None
        }
        return MinimumPitchTask(TuningPlant(turbine, **plant), **chosen)
    if name == "individual-pitch":
        problem = IndividualPitchGains(individual_pitch_plant(turbine, **plant), **given)
    elif name == "torque-gain":
        problem = TorqueGain(TuningPlant(turbine, **{"turbulence": TURBULENCE, **plant}), **given)
    else:
        measure: Load = "flapwise_moment" if load == "blade" else "tower_load"
        problem = SpeedRegulator(TuningPlant(turbine, **plant), load=measure, **given)
    own = None if name == "individual-pitch" else start  # that costs refer to no control there
    return ProblemTask(problem.bounded(bounds or {}, start=own), start)
