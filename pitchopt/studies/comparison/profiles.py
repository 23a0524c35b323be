"""Profiles of the comparison, designed on the model or learned from loads, as they are played.

Designed.  Least weighted RMS on the static rotor in the steady wind, at the mean torque that the
same model has with the constant pitch of steady operation, every limit and cap of the case kept.
A wake that lags is neither frozen nor in balance at every azimuth, so both are designed for, each
is played on the model of the turbine in the steady wind, and the one that leaves less weighted RMS
there is kept; a case without induction has one design.

It is played without lead for the structure: wind and pitch load the same blades, whose structure
answers both alike, so that tilt, yaw and thrust that cancel before it cancel behind it.  (Torque
does not: the rotor's inertia takes up its variation already.)  The actuators' lag is taken out
harmonic by harmonic (`pitchopt.control.PitchProfile`).  That makes commands

    c(psi) = beta + tau d beta/dt

which follow the corners of a profile faster than the controller lets commands move: so many
harmonics are kept, from the first on, as leave them within that rate.

Learned.  `ilc` on the turbine, from torque, tilt, yaw and thrust at the hub.  What it learns are
commands, so nothing is to be taken out; its plant plays a profile half a station late, and so does
the controller.  In turbulence each profile is held for some rotations, whose loads are averaged,
the first perturbations are larger, and profiles have three harmonics.  The lag that it is told
and the mean torque that it holds come from a steady wind.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

import ilc
from pitchopt.aero.curves import LOADS, RotorLoads
from pitchopt.checks import FloatArray
from pitchopt.control import PitchProfile
from pitchopt.design import compared
from pitchopt.errors import ComputationError, InputError, PitchoptError
from pitchopt.sim import statistics
from pitchopt.studies.comparison.ground import Ground
from pitchopt.studies.comparison.spent import Spent
from pitchopt.studies.learning import LearningSettings
from pitchopt.studies.learning.learners import check_learnable, learner_of
from pitchopt.studies.learning.turbine_study import turned_profile
from pitchopt.studies.simulation.controllers import with_feedforward
from pitchopt.studies.tuning.plant import failure_of

Progress = Callable[[int, int, str], None]

__all__ = ["PlayedProfile", "designed_profile", "learned_profile"]

_AMPLITUDE = math.radians(1.5)  # of the learner's experiment in turbulence
_HARMONICS = 3  # of profiles learned there
_LAG_ROTATIONS = 72  # warm-up and both cyclic pitches of the measurement of the lag
_WEIGHED = ("RotTorq", "LSSTipMys", "LSSTipMzs", "RotThrust")  # in the order of weights
_FINE = 8  # points of a command between two stations
_TUNING_SEED = 1


@dataclass(frozen=True, kw_only=True, eq=False)
class PlayedProfile:
    """A profile and what it took.

    Attributes
    ----------
    azimuth, deviation : ndarray (N,)
        Pitch of a blade less its mean, as it shall move with the harmonics that are kept
        (designed), or as it is told (learned) [rad].
    whole : ndarray (N,)
        The same with all harmonics of the design or of what was learned [rad].
    feedforward : PitchProfile
        As the controller plays it.
    wake : str
        Of the static model that it was designed on; empty if learned.
    predicted : dict of str to float
        Share of the constant pitch's RMS that this model cuts with `deviation`, judged between the
        stations, by load; empty if learned.
    spent : Spent
    """

    azimuth: FloatArray
    deviation: FloatArray
    whole: FloatArray
    feedforward: PitchProfile
    wake: str
    predicted: dict[str, float]
    spent: Spent


def designed_profile(ground: Ground, progress: Progress | None = None) -> PlayedProfile:
    """The convex design for the steady wind.

    Raises
    ------
    ComputationError
        If no design ended well.
    """
    began = time.perf_counter()
    wakes = ("none",) if ground.case.aero.induction == "none" else ("equilibrium", "frozen")
    found: list[tuple[float, PlayedProfile]] = []
    failures = []
    for place, wake in enumerate(wakes):

        def part(done: int, total: int, label: str, place: int = place) -> None:
            if progress is not None:
                progress(place * total + done, len(wakes) * total, label)

        try:
            profile = _designed(ground, wake, part)
            found.append((_left(ground, profile), profile))
        except PitchoptError as error:
            failures.append(f"{wake} wake: {error}")
    if not found:
        raise ComputationError("; ".join(failures))
    best = min(found, key=lambda one: one[0])[1]
    run = ground.run_length("none")
    return replace(
        best,
        spent=Spent(
            seconds=time.perf_counter() - began,
            simulations=len(found),
            rotations=len(found) * run * ground.rotor_speed / (2.0 * math.pi),
            turbine_time=len(found) * run,
        ),
    )


def _designed(ground: Ground, wake: str, progress: Progress) -> PlayedProfile:
    """The design with one kind of wake."""
    task = ground.case.with_values({"aero.induction": wake}).task()
    constant = task.constant_loads(ground.start.pitch)
    design = compared(
        task,
        mean_torque=float(constant.mean[0]),
        certify=False,
        seed=ground.settings.seed,
        progress=progress,
    ).design
    if not design.status.ok:
        raise ComputationError(f"design: {design.status.value}: {design.message}")
    mean = float(design.profile.mean())
    deviation = np.asarray(design.profile - mean)
    feedforward = _within_rate(ground, deviation)
    kept = PitchProfile.from_samples(deviation, harmonics=feedforward.cosine.size)
    played = kept.deviation(design.azimuth)
    loads = [task.between(mean + one, design.mean_pitch) for one in (np.zeros(played.size), played)]
    return PlayedProfile(
        azimuth=design.azimuth,
        deviation=played,
        whole=deviation,
        feedforward=feedforward,
        wake=wake,
        predicted=_cuts(*loads),
        spent=Spent(),
    )


def _left(ground: Ground, profile: PlayedProfile) -> float:
    """Weighted RMS on the model of the turbine in the steady wind [N m]."""
    controller = with_feedforward(ground.base, profile.feedforward, ground.operation)
    runs = ground.judge(controller, "none")
    failure = failure_of(runs)
    if failure is not None:
        raise ComputationError(failure)
    found = statistics(runs[0].simulation, skip=runs[0].skip, names=_WEIGHED)
    rms = np.array([found[name].std for name in _WEIGHED])
    return float(ground.case.weights.array[:4] @ rms)


def _within_rate(ground: Ground, deviation: FloatArray) -> PitchProfile:
    """The profile with as many harmonics as the rate of the commands allows."""
    lag, omega, limit = ground.settings.pitch_lag, ground.rotor_speed, ground.rate
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
        whole=deviation,
        feedforward=PitchProfile.from_samples(turned),
        wake="",
        predicted={},
        spent=Spent(
            seconds=time.perf_counter() - began,
            evaluations=len(record.passages),
            rotations=total * setup.rotor_speed / (2.0 * math.pi),
            turbine_time=total,
        ),
    )


def _cuts(constant: RotorLoads | None, played: RotorLoads | None) -> dict[str, float]:
    """Shares of the constant pitch's RMS, by load."""
    if constant is None or played is None:
        return {}
    return {
        name: float(1.0 - mine / other)
        for name, mine, other in zip(LOADS, played.rms, constant.rms, strict=False)
        if other > 0.0
    }
