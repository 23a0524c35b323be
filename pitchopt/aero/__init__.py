"""Aerodynamics: polars and their fits, blade, induction, rotor, steady operation, BladeCurves."""

from pitchopt.aero.blade import Blade
from pitchopt.aero.curves import LOADS, BladeCurves, RotorLoads
from pitchopt.aero.fits import PolarFit, fit_polar
from pitchopt.aero.frozen_errors import FrozenErrors
from pitchopt.aero.induction import Momentum
from pitchopt.aero.loads import BladeLoads
from pitchopt.aero.polars import Polar, blend
from pitchopt.aero.rotor import Rotor
from pitchopt.aero.static_rotor import StaticRotor
from pitchopt.aero.steady import (
    OperatingPoints,
    Surfaces,
    UniformInflow,
    mean_loads,
    operating_points,
    performance,
)

__all__ = [
    "LOADS",
    "Blade",
    "BladeCurves",
    "BladeLoads",
    "FrozenErrors",
    "Momentum",
    "OperatingPoints",
    "Polar",
    "PolarFit",
    "Rotor",
    "RotorLoads",
    "StaticRotor",
    "Surfaces",
    "UniformInflow",
    "blend",
    "fit_polar",
    "mean_loads",
    "operating_points",
    "performance",
]
