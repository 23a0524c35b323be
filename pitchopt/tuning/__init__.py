"""Tuners of a black box that ask and are told, and studies that survive being killed."""

from __future__ import annotations

from pitchopt.tuning.evaluations import Best, Candidate, Evaluation, Outcome
from pitchopt.tuning.space import Parameter, Polar, Space
from pitchopt.tuning.tuner import StagedTuner, Tuner
from pitchopt.tuning.zeroth_order import StageRecord, ZerothOrder, settling

__all__ = [
    "Best",
    "Candidate",
    "Evaluation",
    "Outcome",
    "Parameter",
    "Polar",
    "Space",
    "StageRecord",
    "StagedTuner",
    "Tuner",
    "ZerothOrder",
    "settling",
]
