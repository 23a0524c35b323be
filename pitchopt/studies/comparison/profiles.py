"""Profiles of the comparison, designed on the model or learned from loads, as they are played.

Designed.  Least weighted RMS at the mean torque of steady operation, on the static rotor in the
steady wind, every limit and cap of the case kept.  The structure answers loads late: the profile
is played earlier by the azimuth phi by which tilt and yaw of the model follow cyclic pitch with
actuators that do not lag, without the half station that the measurement has in it.  The
actuators' own lag is taken out harmonic by harmonic (`pitchopt.control.PitchProfile`).

Learned.  `ilc` on the turbine, from torque, tilt, yaw and thrust at the hub.  What it learns are
commands, so nothing is to be taken out; its plant plays a profile half a station late, and so does
the controller.  In turbulence each profile is held for some rotations, whose loads are averaged,
the first perturbations are larger, and profiles have three harmonics.  The lag that it is told
and the mean torque that it holds come from a steady wind.
"""

from __future__ import annotations

import math
import time
from dataclasses import dataclass

import numpy as np

import ilc
from pitchopt.checks import FloatArray
from pitchopt.control import PitchProfile
from pitchopt.design import compared
from pitchopt.design.results import Compared
from pitchopt.errors import InputError
from pitchopt.studies.comparison.ground import Ground
from pitchopt.studies.comparison.spent import Spent
from pitchopt.studies.learning import LearningSettings
from pitchopt.studies.learning.learners import check_learnable, learner_of
from pitchopt.studies.learning.turbine_study import turned_profile

__all__ = ["PlayedProfile", "designed_profile", "learned_profile"]

_AMPLITUDE = math.radians(1.5)  # of the learner's experiment in turbulence
_HARMONICS = 3  # of profiles learned there
_LAG_ROTATIONS = 72  # warm-up and both cyclic pitches of the measurement of the lag
_TUNING_SEED = 1


@dataclass(frozen=True, kw_only=True, eq=False)
class PlayedProfile:
    """A profile and what it took.

    Attributes
    ----------
    azimuth, deviation : ndarray (N,)
        Pitch of a blade less its mean as it shall move (designed), or as it is told (learned)
        [rad].
    feedforward : PitchProfile
        As the controller plays it.
    lead : float
        Azimuth that a design is turned by [rad]; 0 for a learned one.
    predicted : dict of str to float
        Share of the constant pitch's RMS that the static model cuts, by load; empty if learned.
    spent : Spent
    """

    azimuth: FloatArray
    deviation: FloatArray
    feedforward: PitchProfile
    lead: float
    predicted: dict[str, float]
    spent: Spent


def designed_profile(ground: Ground) -> PlayedProfile:
    """The convex design for the steady wind.

    Raises
    ------
    InfeasibleError
        If no profile has the mean torque of steady operation.
    InputError
        If the design did not end well.
    """
    began = time.perf_counter()
    setup = ground.setup("none", lag=0.0)
    found = compared(
        ground.case.task(), mean_torque=setup.mean_torque, certify=False, seed=ground.settings.seed
    )
    design = found.design
    if not design.status.ok:
        raise InputError(f"design: {design.status.value}: {design.message}")
    half = math.pi / setup.stations
    lead = setup.lag.angle - half
    deviation = np.asarray(design.profile - design.profile.mean())
    return PlayedProfile(
        azimuth=design.azimuth,
        deviation=deviation,
        feedforward=PitchProfile.from_samples(
            turned_profile(deviation, lead), time_constant=ground.settings.pitch_lag
        ),
        lead=lead,
        predicted=_predicted(found),
        spent=Spent(
            seconds=time.perf_counter() - began,
            rotations=float(_LAG_ROTATIONS),
            turbine_time=_LAG_ROTATIONS * 2.0 * math.pi / ground.rotor_speed,
        ),
    )


def learned_profile(ground: Ground, wind: str) -> PlayedProfile:
    """The profile that `ilc` ends with in a wind.

    Raises
    ------
    InputError
        If the case has what no learner can serve.
    ComputationError
        If the turbine diverges.
    """
    began = time.perf_counter()
    settings = ground.settings
    turbulent = wind != "none"
    averaged = settings.averaged if turbulent else 0
    setup = ground.setup(
        wind,
        lag=settings.pitch_lag,
        averaged=averaged,
        harmonics=_HARMONICS if turbulent else None,
    )
    case = setup.case
    learning = LearningSettings(
        rotations=settings.rotations, amplitude=_AMPLITUDE if turbulent else None
    )
    check_learnable(case, learning)
    layout = ilc.Layout(blades=case.blades, positions=case.positions)
    limits = case.pitch_limits
    learner = learner_of(
        case,
        learning,
        layout=layout,
        limits=ilc.ActuatorLimits.from_rate(
            lower=limits.lower,
            upper=limits.upper,
            pitch_rate=limits.pitch_rate,
            rotor_speed=setup.rotor_speed,
            stations=layout.stations,
        ),
        start=setup.start.pitch,
        setpoint=setup.mean_torque,
        lag=setup.lag.samples,
    )
    plant = setup.plant(_TUNING_SEED, averaged=averaged)
    record = ilc.run(plant, learner, rotations=settings.rotations)
    profile = record.learning.profile[-1]
    deviation = np.asarray(profile - profile.mean())
    stations = layout.stations
    turned = turned_profile(deviation, -math.pi / stations)
    lag_time = _LAG_ROTATIONS * 2.0 * math.pi / setup.rotor_speed
    total = plant.time + lag_time
    return PlayedProfile(
        azimuth=2.0 * np.pi * np.arange(stations) / stations,
        deviation=deviation,
        feedforward=PitchProfile.from_samples(turned),
        lead=0.0,
        predicted={},
        spent=Spent(
            seconds=time.perf_counter() - began,
            evaluations=len(record.passages),
            rotations=total * setup.rotor_speed / (2.0 * math.pi),
            turbine_time=total,
        ),
    )


def _predicted(found: Compared) -> dict[str, float]:
    constant, design = found.constant.rms, found.design.rms
    return {name: 1.0 - design[name] / value for name, value in constant.items() if value > 0.0}
