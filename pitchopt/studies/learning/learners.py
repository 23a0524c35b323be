"""Learner and sensors of a learning run, whatever plant it runs on."""

from __future__ import annotations

from typing import Any

from ilc import ActuatorLimits, AdaptiveLearner, FixedLearner, Layout, Learner, Sensors
from pitchopt.cases import Case
from pitchopt.checks import FloatArray
from pitchopt.errors import InputError
from pitchopt.studies.learning.settings import LearningSettings

__all__ = ["check_learnable", "learner_of", "sensors_of"]


def check_learnable(case: Case, settings: LearningSettings) -> None:
    """Refuse a case whose objective or limits no learner can serve.

    Raises
    ------
    InputError
        Saying which of them.
    """
    objective = case.objective
    if objective.harmonics is not None and settings.learner == "paper":
        raise InputError(
            f"harmonics: got {objective.harmonics} with the paper's learner, expected none: "
            "it cannot restrict profiles"
        )
    if not case.pitch_limits.pitch_rate:
        raise InputError(
            "limits.pitch_rate_deg: got 0, expected a rate above 0: a learner moves the pitch"
        )
    if objective.travel:
        raise InputError(
            f"travel penalty: got {objective.travel:g} N m/rad, expected 0: a learner puts no "
            "price on travel"
        )
    if case.weights.blade:
        raise InputError(
            f"weights.blade: got {case.weights.blade:g}, expected 0: a learner measures no "
            "blade load"
        )


def learner_of(
    case: Case,
    settings: LearningSettings,
    *,
    layout: Layout,
    limits: ActuatorLimits,
    start: float,
    setpoint: float,
    lag: int = 0,
) -> Learner:
    """A fresh learner.

    Parameters
    ----------
    case : Case
    settings : LearningSettings
    layout, limits, start, setpoint
        As learners take them.
    lag : int
        Samples by which the plant answers late, beside the delay of the sensors.
    """
    common: dict[str, Any] = {
        "layout": layout,
        "limits": limits,
        "start": start,
        "setpoint": setpoint,
        "weights": case.weights.array[:4],
        "delay": settings.delay + lag,
    }
    own = ["amplitude"]
    if settings.learner == "paper":
        own += ["learning_rate", "damping", "smoothing"]
    for name in own:
        if getattr(settings, name) is not None:
            common[name] = getattr(settings, name)
    if settings.learner == "paper":
        return FixedLearner(**common)
    return AdaptiveLearner(harmonics=case.objective.harmonics, **common)


def sensors_of(settings: LearningSettings, loads: FloatArray) -> Sensors:
    """Fresh sensors, whose noise and steps are shares of loads (4, N) over a rotation."""
    rms = loads.std(axis=1)
    return Sensors.with_share(
        settings.noise,
        rms if settings.noise_of == "rms" else loads.mean(axis=1),
        quantisation=settings.quantisation * rms,
        delay=settings.delay,
        dropout=settings.dropout,
        seed=settings.seed,
    )
