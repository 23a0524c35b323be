"""Fatigue: rainflow counting, damage-equivalent loads, Miner damage, sums over wind speeds."""

from __future__ import annotations

from pitchopt.fatigue.counting import Cycles, Residue, rainflow
from pitchopt.fatigue.damage import SNCurve, miner_damage
from pitchopt.fatigue.equivalent import damage_equivalent_load, equivalent_load
from pitchopt.fatigue.lifetime import (
    bin_edges,
    combine_damage,
    combine_loads,
    weibull_weights,
)
from pitchopt.fatigue.spectrum import range_spectra

__all__ = [
    "Cycles",
    "Residue",
    "SNCurve",
    "bin_edges",
    "combine_damage",
    "combine_loads",
    "damage_equivalent_load",
    "equivalent_load",
    "miner_damage",
    "rainflow",
    "range_spectra",
    "weibull_weights",
]
