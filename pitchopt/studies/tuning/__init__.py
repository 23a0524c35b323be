"""Tuning problems on the dynamic turbine: the plant, costs, and studies that compare tuners."""

from __future__ import annotations

from pitchopt.studies.tuning.plant import (
    MEASURES,
    PlantRun,
    TuningPlant,
    failure_of,
    mean_measures,
)

__all__ = [
    "MEASURES",
    "PlantRun",
    "TuningPlant",
    "failure_of",
    "mean_measures",
]
