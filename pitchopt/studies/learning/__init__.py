"""Learning on the static rotor and on the dynamic turbine: plants, runs, what to compare with."""

from __future__ import annotations

from pitchopt.studies.learning.document import (
    learned_profiles,
    learning_csv,
    learning_document,
)
from pitchopt.studies.learning.dynamic_plant import DynamicPlant
from pitchopt.studies.learning.figures import ProfileFigures
from pitchopt.studies.learning.loop import Loop
from pitchopt.studies.learning.plant import BladeDifference, StaticPlant
from pitchopt.studies.learning.references import Reference, SetpointSchedule, reference
from pitchopt.studies.learning.result import LearningResult, Stretch
from pitchopt.studies.learning.settings import LearningSettings
from pitchopt.studies.learning.study import learn
from pitchopt.studies.learning.tasks import WindTasks
from pitchopt.studies.learning.turbine_setup import Lag, TurbineSettings, TurbineSetup
from pitchopt.studies.learning.turbine_study import HeldLoads, TurbineLearning, learn_on_turbine
from pitchopt.studies.learning.wind import (
    ConstantWind,
    WindDrift,
    WindRamp,
    WindSchedule,
    WindStep,
)

__all__ = [
    "BladeDifference",
    "ConstantWind",
    "DynamicPlant",
    "HeldLoads",
    "Lag",
    "LearningResult",
    "LearningSettings",
    "Loop",
    "ProfileFigures",
    "Reference",
    "SetpointSchedule",
    "StaticPlant",
    "Stretch",
    "TurbineLearning",
    "TurbineSettings",
    "TurbineSetup",
    "WindDrift",
    "WindRamp",
    "WindSchedule",
    "WindStep",
    "WindTasks",
    "learn",
    "learn_on_turbine",
    "learned_profiles",
    "learning_csv",
    "learning_document",
    "reference",
]
