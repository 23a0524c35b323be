"""Tuning problems on the dynamic turbine: the plant, costs, and studies that compare tuners."""

from __future__ import annotations

from pitchopt.studies.tuning.document import (
    comparison_document,
    evaluations_csv,
    tuned_document,
)
from pitchopt.studies.tuning.plant import (
    MEASURES,
    PlantRun,
    TuningPlant,
    failure_of,
    mean_measures,
)
from pitchopt.studies.tuning.problem import TuningProblem, plain
from pitchopt.studies.tuning.speed_regulator import SpeedRegulator, suggested_start
from pitchopt.studies.tuning.task import PROBLEMS, Task, TaskResult, make_task
from pitchopt.studies.tuning.torque_gain import TorqueGain
from pitchopt.studies.tuning.tune import Tuned, tune

__all__ = [
    "MEASURES",
    "PROBLEMS",
    "PlantRun",
    "SpeedRegulator",
    "Task",
    "TaskResult",
    "TorqueGain",
    "Tuned",
    "TuningPlant",
    "TuningProblem",
    "comparison_document",
    "evaluations_csv",
    "failure_of",
    "make_task",
    "mean_measures",
    "plain",
    "suggested_start",
    "tune",
    "tuned_document",
]
