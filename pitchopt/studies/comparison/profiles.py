"""Profiles of the comparison, designed on the model or learned from loads, as they are played.

Designed.  Least weighted RMS at the mean torque of steady operation, on the static rotor in the
steady wind, every limit and cap of the case kept.  It is played as it is: wind and pitch load the
same blades, whose structure answers both alike, so that what cancels before the structure cancels
behind it.  The actuators' lag is taken out harmonic by harmonic (`pitchopt.control.PitchProfile`).
That makes commands

    c(psi) = beta + tau d beta/dt

which follow the corners of a profile faster than actuators may: so many harmonics are kept, from
the first on, as leave the rate of the commands within the actuators'.

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
_WARM_UP = 40  # rotations in steady wind, after which the mean torque is taken
_LAG_ROTATIONS = 72  # warm-up and both cyclic pitches of the measurement of the lag
_FINE = 8  # points of a command between two stations
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
    predicted : dict of str to float
        Share of the constant pitch's RMS that the static model cuts, by load; empty if learned.
    spent : Spent
    """

    azimuth: FloatArray
    deviation: FloatArray
    feedforward: PitchProfile
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
    settings = ground.settings
    setup = ground.setup("none", lag=settings.pitch_lag)
    found = compared(
        ground.case.task(), mean_torque=setup.mean_torque, certify=False, seed=settings.seed
    )
    design = found.design
    if not design.status.ok:
        raise InputError(f"design: {design.status.value}: {design.message}")
    deviation = np.asarray(design.profile - design.profile.mean())
    return PlayedProfile(
        azimuth=design.azimuth,
        deviation=deviation,
        feedforward=_within_rate(ground, deviation),
        predicted=_predicted(found),
        spent=Spent(
            seconds=time.perf_counter() - began,
            rotations=float(_WARM_UP),
            turbine_time=_WARM_UP * 2.0 * math.pi / ground.rotor_speed,
        ),
    )


def _within_rate(ground: Ground, deviation: FloatArray) -> PitchProfile:
    """The profile with as many harmonics as the rate of the commands allows."""
    lag, omega = ground.settings.pitch_lag, ground.rotor_speed
    limit = ground.case.pitch_limits.pitch_rate
    psi = 2.0 * np.pi * np.arange(_FINE * deviation.size) / (_FINE * deviation.size)
    for count in range(deviation.size // 2, 0, -1):
        profile = PitchProfile.from_samples(deviation, harmonics=count, time_constant=lag)
        orders = np.arange(1, count + 1)
        parts = (profile.cosine - 1j * profile.sine) * 1j * orders * omega
        parts = parts * (1.0 + 1j * orders * omega * lag)
        rate = (parts * np.exp(1j * np.outer(psi, orders))).real.sum(axis=1)
        if np.abs(rate).max() <= limit:
            return profile
    raise InputError(
        f"pitch_lag: got {lag:g} s, with which even the first harmonic of the design asks for "
        f"commands faster than {math.degrees(limit):g} deg/s, expected a shorter lag"
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
