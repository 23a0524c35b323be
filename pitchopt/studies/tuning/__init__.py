"""Tuning problems on the dynamic turbine: the plant, costs, and studies that compare tuners."""

from __future__ import annotations

from pitchopt.studies.tuning.grid_comparison import GridComparison, compare_with_grids
from pitchopt.studies.tuning.guidelines import (
    Agreement,
    GuidedTuning,
    agreement,
    newton_scaling,
    tune_by_guidelines,
)
from pitchopt.studies.tuning.plant import (
    MEASURES,
    PlantRun,
    TuningPlant,
    failure_of,
    mean_measures,
)
from pitchopt.studies.tuning.problem import TuningProblem, plain
from pitchopt.studies.tuning.sequence import SequenceResult, SequenceStep, tune_in_sequence
from pitchopt.studies.tuning.speed_regulator import (
    SpeedRegulator,
    suggested_start,
    suggested_wind_speed,
)
from pitchopt.studies.tuning.torque_gain import TorqueGain

__all__ = [
    "MEASURES",
    "Agreement",
    "GridComparison",
    "GuidedTuning",
    "PlantRun",
    "SequenceResult",
    "SequenceStep",
    "SpeedRegulator",
    "TorqueGain",
    "TuningPlant",
    "TuningProblem",
    "agreement",
    "compare_with_grids",
    "failure_of",
    "mean_measures",
    "newton_scaling",
    "plain",
    "suggested_start",
    "suggested_wind_speed",
    "tune_by_guidelines",
    "tune_in_sequence",
]
