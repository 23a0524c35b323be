"""Iterative learning of pitch profiles from measured loads, with no model of turbine or wind.

The package stands alone: that it cannot import a model is the proof that it learns from loads.
"""

from __future__ import annotations

from ilc.adaptive import AdaptiveLearner
from ilc.errors import LearningError, StateError
from ilc.fixed import FixedLearner
from ilc.layout import Layout
from ilc.learner import Learner
from ilc.limits import ActuatorLimits
from ilc.plant import LOADS, Plant, StatefulPlant
from ilc.record import Record
from ilc.run import run
from ilc.sensors import Sensors
from ilc.storage import load_state, save_state

__all__ = [
    "LOADS",
    "ActuatorLimits",
    "AdaptiveLearner",
    "FixedLearner",
    "Layout",
    "Learner",
    "LearningError",
    "Plant",
    "Record",
    "Sensors",
    "StateError",
    "StatefulPlant",
    "load_state",
    "run",
    "save_state",
]
