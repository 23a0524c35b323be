"""Tuners of a black box that ask and are told, and studies that survive being killed."""

from __future__ import annotations

from pitchopt.tuning.bayesian import Bayesian
from pitchopt.tuning.evaluations import Best, Candidate, Evaluation, Outcome
from pitchopt.tuning.gaussian_process import GaussianProcess, PosteriorMinimum
from pitchopt.tuning.journal import Journal
from pitchopt.tuning.replicates import variance_of_mean
from pitchopt.tuning.space import Parameter, Polar, Space
from pitchopt.tuning.study import StudyResult, run_study
from pitchopt.tuning.tuner import StagedTuner, Tuner
from pitchopt.tuning.zeroth_order import StageRecord, ZerothOrder, settling

__all__ = [
    "Bayesian",
    "Best",
    "Candidate",
    "Evaluation",
    "GaussianProcess",
    "Journal",
    "Outcome",
    "Parameter",
    "Polar",
    "PosteriorMinimum",
    "Space",
    "StageRecord",
    "StagedTuner",
    "StudyResult",
    "Tuner",
    "ZerothOrder",
    "run_study",
    "settling",
    "variance_of_mean",
]
