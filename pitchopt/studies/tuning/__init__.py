"""Tuning problems on the dynamic turbine: the plant, costs, and studies that compare tuners."""

from __future__ import annotations

from pitchopt.studies.tuning.plant import (
    MEASURES,
    PlantRun,
    TuningPlant,
    failure_of,
    mean_measures,
)
from pitchopt.studies.tuning.problem import TuningProblem, plain
from pitchopt.studies.tuning.speed_regulator import SpeedRegulator, suggested_start
from pitchopt.studies.tuning.torque_gain import TorqueGain

__all__ = [
    "MEASURES",
    "PlantRun",
    "SpeedRegulator",
    "TorqueGain",
    "TuningPlant",
    "TuningProblem",
    "failure_of",
    "mean_measures",
    "plain",
    "suggested_start",
]
