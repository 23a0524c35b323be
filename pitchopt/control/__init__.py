"""Controllers: generator torque, collective and individual pitch. Numbers and matrices only."""

from pitchopt.control.actuator import GeneratorLag, PitchActuator
from pitchopt.control.controller import TurbineController, nrel_5mw_baseline
from pitchopt.control.estimator import WindEstimator
from pitchopt.control.feedforward import PitchProfile
from pitchopt.control.individual import IndividualPitch, decoupling_offset
from pitchopt.control.lqr import LinearQuadratic, OperatingDerivatives, QuadraticWeights
from pitchopt.control.minimum_pitch import MinimumPitchTable
from pitchopt.control.multiblade import from_fixed_frame, to_fixed_frame
from pitchopt.control.pitch import PitchRange, PitchRegulator, fit_sensitivity
from pitchopt.control.signals import Controller
from pitchopt.control.torque import TorqueLaw

__all__ = [
    "Controller",
    "GeneratorLag",
    "IndividualPitch",
    "LinearQuadratic",
    "MinimumPitchTable",
    "OperatingDerivatives",
    "PitchActuator",
    "PitchProfile",
    "PitchRange",
    "PitchRegulator",
    "QuadraticWeights",
    "TorqueLaw",
    "TurbineController",
    "WindEstimator",
    "decoupling_offset",
    "fit_sensitivity",
    "from_fixed_frame",
    "nrel_5mw_baseline",
    "to_fixed_frame",
]
