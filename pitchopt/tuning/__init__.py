"""Tuners of a black box that ask and are told, and studies that survive being killed."""

from __future__ import annotations

from pitchopt.tuning.bayesian import Bayesian
from pitchopt.tuning.evaluations import Best, Candidate, Evaluation, Outcome
from pitchopt.tuning.gaussian_process import GaussianProcess, PosteriorMinimum
from pitchopt.tuning.space import Parameter, Polar, Space
from pitchopt.tuning.tuner import StagedTuner, Tuner

__all__ = [
    "Bayesian",
    "Best",
    "Candidate",
    "Evaluation",
    "GaussianProcess",
    "Outcome",
    "Parameter",
    "Polar",
    "PosteriorMinimum",
    "Space",
    "StagedTuner",
    "Tuner",
]
