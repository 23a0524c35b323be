"""Learning on the static rotor: the plant for `ilc` and what a run is compared with."""

from __future__ import annotations

from pitchopt.studies.learning.plant import BladeDifference, StaticPlant
from pitchopt.studies.learning.references import Reference, SetpointSchedule, reference
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
    "Reference",
    "SetpointSchedule",
    "StaticPlant",
    "WindDrift",
    "WindRamp",
    "WindSchedule",
    "WindStep",
    "WindTasks",
    "reference",
]
