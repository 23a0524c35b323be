"""Learning on the static rotor: the plant for `ilc`, runs on it, designs to compare with."""

from __future__ import annotations

from pitchopt.studies.learning.document import (
    learned_profiles,
    learning_csv,
    learning_document,
)
from pitchopt.studies.learning.figures import ProfileFigures
from pitchopt.studies.learning.loop import Loop
from pitchopt.studies.learning.plant import BladeDifference, StaticPlant
from pitchopt.studies.learning.references import Reference, SetpointSchedule, reference
from pitchopt.studies.learning.result import LearningResult, Stretch
from pitchopt.studies.learning.settings import LearningSettings
from pitchopt.studies.learning.study import learn
from pitchopt.studies.learning.tasks import WindTasks
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
    "LearningResult",
    "LearningSettings",
    "Loop",
    "ProfileFigures",
    "Reference",
    "SetpointSchedule",
    "StaticPlant",
    "Stretch",
    "WindDrift",
    "WindRamp",
    "WindSchedule",
    "WindStep",
    "WindTasks",
    "learn",
    "learned_profiles",
    "learning_csv",
    "learning_document",
    "reference",
]
