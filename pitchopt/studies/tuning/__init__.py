"""Tuning problems on the dynamic turbine: the plant, costs, and studies that compare tuners."""

from __future__ import annotations

from pitchopt.studies.tuning.decoupling import (
    Decoupling,
    FixedFrameResponse,
    fixed_frame_response,
    measure_decoupling,
    sampled_offset,
)
from pitchopt.studies.tuning.document import (
    comparison_document,
    evaluations_csv,
    tuned_document,
)
from pitchopt.studies.tuning.individual_pitch import IndividualPitchGains, individual_pitch_plant
from pitchopt.studies.tuning.minimum_pitch import (
    MinimumPitch,
    initial_table,
    minimum_pitch_base,
    with_table,
)
from pitchopt.studies.tuning.minimum_pitch_table import (
    BreakpointTuning,
    MinimumPitchResult,
    PeakLoads,
    TableRuns,
    tune_minimum_pitch,
    tuned_by,
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
    "BreakpointTuning",
    "Decoupling",
    "FixedFrameResponse",
    "IndividualPitchGains",
    "MinimumPitch",
    "MinimumPitchResult",
    "PeakLoads",
    "PlantRun",
    "SpeedRegulator",
    "TableRuns",
    "Task",
    "TaskResult",
    "TorqueGain",
    "Tuned",
    "TuningPlant",
    "TuningProblem",
    "comparison_document",
    "evaluations_csv",
    "failure_of",
    "fixed_frame_response",
    "individual_pitch_plant",
    "initial_table",
    "make_task",
    "mean_measures",
    "measure_decoupling",
    "minimum_pitch_base",
    "plain",
    "sampled_offset",
    "suggested_start",
    "tune",
    "tune_minimum_pitch",
    "tuned_by",
    "tuned_document",
    "with_table",
]
