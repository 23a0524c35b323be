"""Turbines: catalogue of reference turbines, reader of windIO v2 files, the `Turbine` itself."""

from pitchopt.turbines.catalogue import biegel_blade, load_turbine, names, summary
from pitchopt.turbines.model import Turbine
from pitchopt.turbines.structure import (
    BladeSections,
    BladeStructure,
    Drivetrain,
    Hub,
    Nacelle,
    Tower,
)
from pitchopt.turbines.windio import read_windio

__all__ = [
    "BladeSections",
    "BladeStructure",
    "Drivetrain",
    "Hub",
    "Nacelle",
    "Tower",
    "Turbine",
    "biegel_blade",
    "load_turbine",
    "names",
    "read_windio",
    "summary",
]
