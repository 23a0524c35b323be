"""Dynamic turbine: structure, aerodynamics and control marched through time."""

from __future__ import annotations

from pitchopt.sim.channels import Channel
from pitchopt.sim.frequencies import Mode, natural_modes
from pitchopt.sim.operation import Operation
from pitchopt.sim.run import TurbineRun
from pitchopt.sim.simulate import Simulation, Start, simulate, simulate_many
from pitchopt.sim.statistics import ChannelStatistics, average, statistics
from pitchopt.sim.structure import BladeModel, TowerModel
from pitchopt.sim.turbine import FREEDOMS, DynamicTurbine

__all__ = [
    "FREEDOMS",
    "BladeModel",
    "Channel",
    "ChannelStatistics",
    "DynamicTurbine",
    "Mode",
    "Operation",
    "Simulation",
    "Start",
    "TowerModel",
    "TurbineRun",
    "average",
    "natural_modes",
    "simulate",
    "simulate_many",
    "statistics",
]
