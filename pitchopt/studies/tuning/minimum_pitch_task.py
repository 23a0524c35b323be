"""The minimum-pitch table as a task: algorithm 1 with any method, for one kappa or a family.

The cost of a whole table is that of one breakpoint (35) with the largest flapwise moment and the
mean power over all active wind speeds and all seeds:

    C = kappa M / M_initial + (1 - kappa) P_initial / P .
"""

from __future__ import annotations

import dataclasses
import re
from collections.abc import Callable, Mapping, Sequence
from os import PathLike
from pathlib import Path
from typing import Any

import numpy as np

from pitchopt.checks import finite_number
from pitchopt.errors import InputError
from pitchopt.studies.tuning.document import FIRST_FRESH, evaluation_record
from pitchopt.studies.tuning.minimum_pitch import (
    KAPPA,
    MinimumPitch,
    initial_table,
    minimum_pitch_base,
)
from pitchopt.studies.tuning.minimum_pitch_table import (
    SEEDS,
    MinimumPitchResult,
    PeakLoads,
    Study,
    TableRuns,
    tune_minimum_pitch,
)
from pitchopt.studies.tuning.plant import TuningPlant
from pitchopt.studies.tuning.tune import Progress, tune, tuner_for

__all__ = ["MinimumPitchTask", "MinimumPitchTuned"]


class MinimumPitchTask:
    """Minimum-pitch table for one or several kappa.

    Parameters
    ----------
    plant : TuningPlant
    kappa : sequence of float
        Each once; the family has a table for each.
    seeds : sequence of int

    Raises
    ------
    InputError
        If a kappa stands twice or is outside of 0 to 1, or the turbine's rated wind speed is not
        known.
    """

    name = "minimum-pitch"

    def __init__(
        self,
        plant: TuningPlant,
        *,
        kappa: Sequence[float] = (KAPPA,),
        seeds: Sequence[int] = SEEDS,
    ) -> None:
        self.plant = plant
        self.kappa = tuple(finite_number("kappa", k, at_least=0.0, at_most=1.0) for k in kappa)
        if not self.kappa or len(set(self.kappa)) < len(self.kappa):
            raise InputError(f"kappa: got {self.kappa}, expected at least one, each once")
        self.seeds = tuple(seeds)
        self.table = initial_table(plant)

    def check(self, method: str, **settings: Any) -> None:
        """See `pitchopt.studies.tuning.Task`; by the first breakpoint."""
        own = ("evaluations", "seed", "options")
        chosen = {name: settings[name] for name in own if name in settings}
        tuner_for(MinimumPitch(self.plant, self.table, 1, seed=self.seeds[0]), method, **chosen)

    def tune(
        self,
        method: str,
        *,
        journal: str | PathLike[str] | None = None,
        progress: bool | Progress = False,
        **settings: Any,
    ) -> MinimumPitchTuned:
        """Tune the tables; a breakpoint's study is kept beside `journal`, under a name of its own.

        Parameters
        ----------
        method : str
        journal : path, optional
        progress : bool or callable
        **settings
            Of `tune`, for each breakpoint.
        """
        base = minimum_pitch_base(self.plant)
        runs = TableRuns(self.plant, base, self.seeds)
        found = []
        for kappa in self.kappa:

            def run(problem: MinimumPitch, label: str, kappa: float = kappa) -> Study:
                place = None if journal is None else _beside(Path(journal), kappa, label)
                tuned = tune(problem, method, journal=place, progress=progress, **settings)
                return tuned.result

            found.append(
                tune_minimum_pitch(
                    self.plant,
                    table=self.table,
                    kappa=kappa,
                    seeds=self.seeds,
                    base=base,
                    run=run,
                    runs=runs,
                )
            )
        rounds = [one for result in found for b in result.breakpoints for one in b.rounds]
        tuning = sum(
            one.problem.simulations_in([e.x for e in one.study.evaluations]) for one in rounds
        )
        return MinimumPitchTuned(
            task=self,
            method=method,
            family=tuple(found),
            settings=dict(settings),
            simulations=runs.simulations + tuning,
        )


def _beside(journal: Path, kappa: float, label: str) -> Path:
    words = re.sub(r"[^0-9a-z.]+", "-", label.lower()).strip("-")
    return journal.with_name(f"{journal.stem}-kappa-{kappa:g}-{words}{journal.suffix}")


@dataclasses.dataclass(frozen=True, kw_only=True, eq=False)
class MinimumPitchTuned:
    """Tuned tables, one for each kappa.

    Attributes
    ----------
    task : MinimumPitchTask
    method : str
    family : tuple of MinimumPitchResult
    settings : dict
        Of the tuner.
    simulations : int
        Of the whole family, those of earlier runs that journals kept included.
    """

    task: MinimumPitchTask
    method: str
    family: tuple[MinimumPitchResult, ...]
    settings: dict[str, Any]
    simulations: int

    def document(self, *, check_seeds: int | None = None) -> dict[str, Any]:
        """Plain data: that of the first kappa, and the family in short.

        A point is the lowest pitch [rad] at the active breakpoints.
        """
        task, first = self.task, self.family[0]
        speeds = first.table.wind_speed[1:-1]
        document: dict[str, Any] = {
            "problem": task.name,
            "turbine": task.plant.turbine.name,
            "method": self.method,
            "parameters": [f"pitch_{speed:.4g}" for speed in speeds],
            "settings": {
                "problem": {
                    "problem": task.name,
                    "kappa": first.kappa,
                    "wind_speeds": speeds.tolist(),
                    "seeds": list(task.seeds),
                    "plant": task.plant.document(),
                },
                "tuner": {k: v for k, v in self.settings.items() if v is not None},
            },
            "start": _point(first, first.initial.pitch, first.with_initial),
            "best": _point(first, first.table.pitch, first.with_table),
            "evaluations": _evaluations(first),
            "simulations": self.simulations,
        }
        document["gain"] = 1.0 - document["best"]["cost"]
        document["family"] = [_result(result) for result in self.family]
        if check_seeds is not None:
            document |= self._fresh(check_seeds)
        return document

    def _fresh(self, count: int) -> dict[str, Any]:
        first, plant = self.family[0], self.task.plant
        seeds = range(FIRST_FRESH, FIRST_FRESH + count)
        runs = TableRuns(plant, minimum_pitch_base(plant), list(seeds))
        speeds = first.table.wind_speed[1:-1].tolist()
        tuned, initial = (runs.over(t, speeds) for t in (first.table, first.initial))
        return {
            "fresh_gain": 1.0 - _cost(first.kappa, tuned, initial),
            "fresh_change": tuned.change(initial),
        }

    def controllers(self) -> Mapping[str, str]:
        """See `TaskResult`; none, a controller file takes the table as it is printed."""
        return {}

    def figures(self) -> Mapping[str, Callable[[], bytes]]:
        """Tables over wind speed."""
        from pitchopt.plotting import png
        from pitchopt.plotting.tuning_minimum_pitch import pitch_tables_figure

        tables = {
            "to begin with": self.family[0].initial,
            **{f"kappa {result.kappa:g}": result.table for result in self.family},
        }
        title = f"{self.task.plant.turbine.name}, {self.method}"
        return {"tables.png": lambda: png(pitch_tables_figure(tables, title=title))}


def _cost(kappa: float, loads: PeakLoads, initial: PeakLoads) -> float:
    change = loads.change(initial)
    return kappa * (1.0 + change["blade"]) + (1.0 - kappa) / (1.0 + change["power"])


def _point(result: MinimumPitchResult, pitch: Any, loads: PeakLoads) -> dict[str, Any]:
    return {
        "x": np.asarray(pitch)[1:-1].tolist(),
        "cost": _cost(result.kappa, loads, result.with_initial),
        "measures": {
            "flapwise_moment": float(loads.blade.max()),
            "tower_moment": float(loads.tower.max()),
            "power": float(loads.power.mean()),
        },
    }


def _evaluations(result: MinimumPitchResult) -> list[dict[str, Any]]:
    """All breakpoints' evaluations, each with the whole table that it was part of."""
    records: list[dict[str, Any]] = []
    for breakpoint_ in result.breakpoints:
        for number, one in enumerate(breakpoint_.rounds, start=1):
            for evaluation in one.study.evaluations:
                table = one.problem.table_of(evaluation.x)
                records.append(
                    {
                        **evaluation_record(evaluation),
                        "number": len(records),
                        "x": table.pitch[1:-1].tolist(),
                        "breakpoint": breakpoint_.wind_speed,
                        "round": number,
                        "wind_seed": one.problem.seeds[0],
                    }
                )
    return records


def _result(result: MinimumPitchResult) -> dict[str, Any]:
    return {
        "kappa": result.kappa,
        "wind_speed": result.table.wind_speed.tolist(),
        "pitch_deg": np.degrees(result.table.pitch).tolist(),
        "initial_pitch_deg": np.degrees(result.initial.pitch).tolist(),
        "change_from_initial": result.with_table.change(result.with_initial),
        "change_from_no_table": result.with_table.change(result.without),
        "breakpoints": [
            {
                "wind_speed": b.wind_speed,
                "tuned": bool(b.rounds),
                "rounds": len(b.rounds),
                "largest_load": float(b.loads.max()),
                "remaining_load": b.remaining,
            }
            for b in result.breakpoints
        ],
    }
