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
    FIRST_FRESH,
    comparison_document,
    evaluation_record,
    evaluations_csv,
    tuned_document,
)
from pitchopt.studies.tuning.grid_comparison import (
    QUADRANTS,
    GridComparison,
    MethodSummary,
    Search,
    compare_with_grids,
)
from pitchopt.studies.tuning.guidelines import (
    Agreement,
    GuidedTuning,
    agreement,
    newton_scaling,
    tune_by_guidelines,
)
from pitchopt.studies.tuning.individual_pitch import IndividualPitchGains, individual_pitch_plant
from pitchopt.studies.tuning.minimum_pitch import (
    KAPPA,
    MinimumPitch,
    initial_table,
    minimum_pitch_base,
    with_table,
)
from pitchopt.studies.tuning.minimum_pitch_table import (
    BreakpointTuning,
    MinimumPitchResult,
    PeakLoads,
    Round,
    Run,
    TableRuns,
    tune_minimum_pitch,
    tuned_by,
)
from pitchopt.studies.tuning.minimum_pitch_task import MinimumPitchTask, MinimumPitchTuned
from pitchopt.studies.tuning.plain import plain
from pitchopt.studies.tuning.plant import (
    MEASURES,
    PlantRun,
    TuningPlant,
    failure_of,
    mean_measures,
    plant_or_new,
)
from pitchopt.studies.tuning.problem import TuningProblem
from pitchopt.studies.tuning.sequence import SequenceResult, SequenceStep, tune_in_sequence
from pitchopt.studies.tuning.speed_regulator import (
    HARD_SPEED,
    SOFT_SPEED,
    SpeedRegulator,
    suggested_start,
    suggested_wind_speed,
)
from pitchopt.studies.tuning.task import PROBLEMS, Task, TaskResult, fresh_gain, make_task
from pitchopt.studies.tuning.torque_gain import TorqueGain, weibull_density
from pitchopt.studies.tuning.tune import BUDGET, Tuned, tune

__all__ = [
    "BUDGET",
    "FIRST_FRESH",
    "HARD_SPEED",
    "KAPPA",
    "MEASURES",
    "PROBLEMS",
    "QUADRANTS",
    "SOFT_SPEED",
    "Agreement",
    "BreakpointTuning",
    "Decoupling",
    "FixedFrameResponse",
    "GridComparison",
    "GuidedTuning",
    "IndividualPitchGains",
    "MethodSummary",
    "MinimumPitch",
    "MinimumPitchResult",
    "MinimumPitchTask",
    "MinimumPitchTuned",
    "PeakLoads",
    "PlantRun",
    "Round",
    "Run",
    "Search",
    "SequenceResult",
    "SequenceStep",
    "SpeedRegulator",
    "TableRuns",
    "Task",
    "TaskResult",
    "TorqueGain",
    "Tuned",
    "TuningPlant",
    "TuningProblem",
    "agreement",
    "compare_with_grids",
    "comparison_document",
    "evaluation_record",
    "evaluations_csv",
    "failure_of",
    "fixed_frame_response",
    "fresh_gain",
    "individual_pitch_plant",
    "initial_table",
    "make_task",
    "mean_measures",
    "measure_decoupling",
    "minimum_pitch_base",
    "newton_scaling",
    "plain",
    "plant_or_new",
    "sampled_offset",
    "suggested_start",
    "suggested_wind_speed",
    "tune",
    "tune_by_guidelines",
    "tune_in_sequence",
    "tune_minimum_pitch",
    "tuned_by",
    "tuned_document",
    "weibull_density",
    "with_table",
]
