"""Runs of the dynamic turbine over winds and seeds: settings, controllers, statistics."""

from __future__ import annotations

from pitchopt.studies.simulation.controller_file import controller_from_table, read_controller
from pitchopt.studies.simulation.controller_text import controller_text
from pitchopt.studies.simulation.controllers import (
    CONTROLLERS,
    individual_pitch,
    load_controller,
    named_controller,
)
from pitchopt.studies.simulation.document import simulation_document, statistics_csv
from pitchopt.studies.simulation.result import Lifetime, RunResult, SimulationResult, SpeedResult
from pitchopt.studies.simulation.settings import SimulationSettings
from pitchopt.studies.simulation.study import run_simulations, selected_channels
from pitchopt.studies.simulation.winds import WindCase, wind_cases

__all__ = [
    "CONTROLLERS",
    "Lifetime",
    "RunResult",
    "SimulationResult",
    "SimulationSettings",
    "SpeedResult",
    "WindCase",
    "controller_from_table",
    "controller_text",
    "individual_pitch",
    "load_controller",
    "named_controller",
    "read_controller",
    "run_simulations",
    "selected_channels",
    "simulation_document",
    "statistics_csv",
    "wind_cases",
]
