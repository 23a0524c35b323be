"""A learning run on the dynamic turbine, and what it is compared with on the same wind.

    learn_on_turbine(case, settings, turbine)  ->  start, lag, set-point  ->  ilc.run  ->  result

What a run starts from and is compared with:

- start: the constant pitch that the static model has for the set-point; with a controller that of
  steady operation.  The set-point is the mean torque of the turbine with it in the steady wind;
- constant: the start pitch held on a twin of the plant, over the same passages in the same wind;
- design: the model-based profile of the static rotor at the same mean torque, told to the turbine
  earlier by the half station that the plant is late and by the lag of the actuators, atan(omega
  tau).  The structure asks for no lead: it answers the loads of wind and pitch alike, and what
  cancels before it cancels behind it.

Loads over rotations r = 1 ... R of a held profile are told in two figures,

    total     mean over r of RMS over the samples of rotation r,
    periodic  RMS over the positions of the mean over r and the passages of it.

Turbulence is in the first alone but for what has not averaged out after R rotations; a profile that
is held can only change the second.
"""

from __future__ import annotations

import math
import os
import time
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from ilc import (
    LOADS,
    ActuatorLimits,
    Layout,
    Learner,
    LearningError,
    Record,
    load_state,
    run,
)
from pitchopt.cases import Case
from pitchopt.checks import FloatArray, whole_number
from pitchopt.design.task import Progress
from pitchopt.errors import InputError
from pitchopt.studies.learning.dynamic_plant import DynamicPlant
from pitchopt.studies.learning.learners import check_learnable, learner_of, sensors_of
from pitchopt.studies.learning.references import Reference, reference
from pitchopt.studies.learning.settings import LearningSettings
from pitchopt.studies.learning.tasks import WindTasks
from pitchopt.studies.learning.turbine_setup import (
    TurbineSettings,
    TurbineSetup,
    steady_wind,
    structural_turbine,
)

__all__ = ["HeldLoads", "TurbineLearning", "learn_on_turbine", "turned_profile"]

_FRESH = 10_000  # from the seed of the run to the first of those it is judged on
_REFERENCE_STEPS = 50  # of the progress


@dataclass(frozen=True, kw_only=True, eq=False)
class HeldLoads:
    """Loads of a profile that is held.

    Attributes
    ----------
    profile : ndarray (N,) or (B, N)
        [rad].
    total : ndarray (4,)
        Mean over the rotations of the RMS in each [N m, N].
    periodic : ndarray (4,)
        RMS of the mean over the rotations [N m, N].
    mean : ndarray (4,)
        Means [N m, N].
    """

    profile: FloatArray
    total: FloatArray
    periodic: FloatArray
    mean: FloatArray

    @classmethod
    def of(cls, profile: ArrayLike, runs: list[FloatArray]) -> HeldLoads:
        """From the loads (R, B, 4, m) of one or more winds."""
        loads = np.concatenate(runs)
        return cls(
            profile=np.array(profile, dtype=np.float64),
            total=rotation_rms(loads).mean(axis=0),
            periodic=np.asarray(loads.mean(axis=(0, 1)).std(axis=1)),
            mean=np.asarray(loads.mean(axis=(0, 1, 3))),
        )


@dataclass(frozen=True, kw_only=True, eq=False)
class TurbineLearning:
    """A learning run on the dynamic turbine.

    Attributes
    ----------
    case : Case
    learning : LearningSettings
    setup : TurbineSetup
    record : Record
        What happened.  One of its rotations is B passages of the plant, `turns` of the turbine.
    constant_rms : ndarray (n, 4)
        RMS over the positions in each passage of the record with the start pitch held [N m, N].
    setpoint : float
        [N m].
    reference : Reference
        Of the static rotor at that wind.
    start, learned, design : HeldLoads
        Held after a warm-up in the steady wind or, with turbulence, in the turbulence of seeds
        that the learner has not met.
    judged_on : tuple of int
        These seeds; empty in the steady wind.
    seconds : float
    """

    case: Case
    learning: LearningSettings
    setup: TurbineSetup
    record: Record
    constant_rms: FloatArray
    setpoint: float
    reference: Reference
    start: HeldLoads
    learned: HeldLoads
    design: HeldLoads
    judged_on: tuple[int, ...]
    seconds: float

    @property
    def azimuth(self) -> FloatArray:
        """Azimuth of the stations [rad], (N,)."""
        return self.reference.design.azimuth

    @property
    def turns(self) -> int:
        """Rotations of the turbine in one of the record."""
        return 1 + self.case.blades * self.setup.settings.averaged

    def left(self, first: int, last: int | None = None) -> float | None:
        """Weighted RMS of rotations of the record over that of the constant pitch in the same.

        Both are means over the passages of the rotations `first` to `last`, of the RMS over the
        positions; None beyond the run.
        """
        last = first if last is None else last
        if last > self.record.rotations:
            return None
        blades, before = self.case.blades, len(self.record.experiment)
        rows = slice((before + first - 1) * blades, (before + last) * blades)
        mine, constant = self.record.passages.rms[rows], self.constant_rms[rows]
        return float((mine @ self._weights).mean() / (constant @ self._weights).mean())

    @property
    def _weights(self) -> FloatArray:
        return self.case.weights.array[:4]

    def share(self, held: HeldLoads, kind: str) -> float:
        """Weighted RMS of `kind`, ``total`` or ``periodic``, over that of the start pitch."""
        mine, start = (getattr(one, kind) @ self._weights for one in (held, self.start))
        return float(mine / start)

    def document(self, settings: Mapping[str, Any]) -> dict[str, Any]:
        """Everything as plain data, angles in degrees.

        Parameters
        ----------
        settings : mapping
            Of the case; those of learning and turbine are added to it.
        """
        record, lag = self.record, self.setup.lag
        blades = self.case.blades
        passages = {
            name: (rms @ self._weights).reshape(-1, blades).mean(axis=1)[len(record.experiment) :]
            for name, rms in (("learned", record.passages.rms), ("constant", self.constant_rms))
        }
        return {
            "case": self.case.name,
            "plant": "dynamic",
            "settings": {
                **settings,
                "learning": self.learning.plain(),
                "turbine": self.setup.plain(),
            },
            "learner": self.learning.learner,
            "lag": {"angle_deg": float(np.rad2deg(lag.angle)), "samples": lag.samples},
            "experiment": {"rotations": len(record.experiment)},
            "turbine_rotations_in_one": self.turns,
            "setpoint": self.setpoint,
            "rotations": [
                {
                    "rotation": int(record.learning.rotation[row]),
                    "rms_weighted": float(passages["learned"][row]),
                    "constant_rms_weighted": float(passages["constant"][row]),
                    "left": self.left(row + 1),
                    "mean_torque": float(record.learning.mean_torque[row]),
                    "mean_pitch_deg": float(np.rad2deg(record.learning.profile[row].mean())),
                }
                for row in range(record.rotations)
            ],
            "left": {
                "at_10": self.left(10),
                "at_20": self.left(20),
                "from_11_to_20": self.left(11, 20),
            },
            "judged_on_seeds": list(self.judged_on),
            **{
                name: {
                    **{
                        kind: dict(zip(LOADS, map(float, getattr(held, kind)), strict=True))
                        for kind in ("total", "periodic", "mean")
                    },
                    "left_total": self.share(held, "total"),
                    "left_periodic": self.share(held, "periodic"),
                    "pitch_deg": np.rad2deg(held.profile),
                }
                for name, held in (
                    ("start", self.start),
                    ("learned", self.learned),
                    ("design", self.design),
                )
            },
            "azimuth_deg": np.rad2deg(self.azimuth),
            "events": [{"passage": passage, "text": text} for passage, text in record.events],
            "seconds": self.seconds,
        }


def learn_on_turbine(
    case: Case,
    learning: LearningSettings | None = None,
    turbine: TurbineSettings | None = None,
    *,
    known: Reference | None = None,
    judged: int = 60,
    seeds: int = 2,
    checkpoint: str | os.PathLike[str] | None = None,
    progress: Progress | None = None,
) -> TurbineLearning:
    """Let a learner find a profile on the dynamic turbine of a case.

    Parameters
    ----------
    case : Case
    learning : LearningSettings, optional
        Its wind and blade that differs are those of the static rotor and have to be absent; its
        seed is that of sensors and turbulence.
    turbine : TurbineSettings, optional
    known : Reference, optional
        Model-based figures of the case, if they have been made before.
    judged : int
        Rotations over which profiles are held and compared.
    seeds : int
        Turbulence boxes in which they are.
    checkpoint : path, optional
        File that is written after each rotation, and from which the run goes on if it exists.
    progress : callable, optional

    Returns
    -------
    TurbineLearning

    Raises
    ------
    InputError
        If case and settings do not fit each other, or the checkpoint is another run's.
    InfeasibleError
        If no profile gives the set-point.
    ComputationError
        If the turbine diverges.
    """
    began = time.perf_counter()
    learning = LearningSettings() if learning is None else learning
    turbine = TurbineSettings() if turbine is None else turbine
    whole_number("judged", judged, at_least=1)
    whole_number("seeds", seeds, at_least=1)
    _check(case, learning)
    try:
        if checkpoint is not None and Path(checkpoint).exists():
            load_state(checkpoint)
        study = _Study(case, learning, turbine, known, progress)
        record, constant = study.run(checkpoint)
    except LearningError as error:
        raise InputError(str(error)) from error
    boxes = tuple(learning.seed + _FRESH + k for k in range(seeds))
    if turbine.turbulence == "none":
        boxes = ()

    def held(profile: FloatArray) -> HeldLoads:
        plants = [study.setup.plant(seed) for seed in boxes] or [study.setup.plant()]
        return HeldLoads.of(profile, [plant.held(profile, judged) for plant in plants])

    setup, ref = study.setup, study.reference
    late = math.pi / setup.stations + math.atan(setup.rotor_speed * turbine.pitch_lag)
    design = turned_profile(ref.design.profile, late)
    if turbine.rotor == "controlled":
        design = design + (setup.start.pitch - design.mean())
    return TurbineLearning(
        case=case,
        learning=learning,
        setup=setup,
        record=record,
        constant_rms=constant,
        setpoint=setup.mean_torque,
        reference=ref,
        start=held(np.full(setup.stations, setup.start.pitch)),
        learned=held(record.learning.profile[-1]),
        design=held(design),
        judged_on=boxes,
        seconds=time.perf_counter() - began,
    )


class _Study:
    """One run."""

    def __init__(
        self,
        case: Case,
        learning: LearningSettings,
        turbine: TurbineSettings,
        known: Reference | None,
        progress: Progress | None,
    ) -> None:
        self.case, self.learning, self.turbine = case, learning, turbine
        self._progress = progress
        self._total = _REFERENCE_STEPS + learning.rotations
        self.reference, self.setup = self._prepared(known)
        layout = Layout(
            blades=case.blades, positions=case.positions, separate=bool(learning.separate)
        )
        self.layout = layout
        limits = case.pitch_limits
        self.limits = ActuatorLimits.from_rate(
            lower=limits.lower,
            upper=limits.upper,
            pitch_rate=limits.pitch_rate,
            rotor_speed=self.setup.rotor_speed,
            stations=layout.stations,
        )

    def _prepared(self, known: Reference | None) -> tuple[Reference, TurbineSetup]:
        """Model-based figures, and the turbine at the constant pitch to start from."""
        case, learning = self.case, self.learning

        def told(done: int, total: int, _: str) -> None:
            if self._progress is not None:
                part = min(_REFERENCE_STEPS * done // max(total, 1), _REFERENCE_STEPS)
                self._progress(part, self._total, "reference")

        setup = TurbineSetup(case, self.turbine, learning.start_pitch or 0.0)
        if self.turbine.rotor == "held":
            ref = known or reference(
                WindTasks(case=case),
                max_power_loss=learning.max_power_loss,
                mean_torque=learning.mean_torque,
                progress=told,
            )
            if learning.start_pitch is None:
                setup = TurbineSetup(case, self.turbine, ref.start_pitch)
            return ref, setup
        room = np.deg2rad(0.5) if learning.amplitude is None else learning.amplitude
        if setup.start.pitch - room < case.pitch_limits.lower:
            low, least = np.rad2deg([setup.start.pitch, case.pitch_limits.lower])
            raise InputError(
                f"rotor: got 'controlled' at {case.wind.speed:g} m/s, where the controller has "
                f"the pitch at {low:.3g} deg and the actuators' range begins at {least:.3g} deg, "
                "expected a wind above rated, or a rotor that is held"
            )
        held = case.with_values({"operation.rotor_speed": setup.rotor_speed})
        return known or reference(
            WindTasks(case=held), mean_torque=setup.mean_torque, progress=told
        ), setup

    def _learner(self) -> Learner:
        settings, setup = self.learning, self.setup
        delay = settings.delay + setup.lag.samples
        if delay > self.layout.positions:
            raise InputError(
                f"delay: got {settings.delay} samples beside a lag of {setup.lag.samples}, "
                f"expected together at most the {self.layout.positions} of a passage"
            )
        return learner_of(
            self.case,
            settings,
            layout=self.layout,
            limits=self.limits,
            start=setup.start.pitch,
            setpoint=setup.mean_torque,
            lag=setup.lag.samples,
        )

    def _plant(self) -> DynamicPlant:
        return self.setup.plant(self.learning.seed, averaged=self.turbine.averaged)

    def run(self, checkpoint: str | os.PathLike[str] | None) -> tuple[Record, FloatArray]:
        """The record, and the RMS of the constant pitch in the same passages."""

        def told(done: int, total: int, _: str) -> None:
            if self._progress is not None:
                self._progress(_REFERENCE_STEPS + done, _REFERENCE_STEPS + total, "learning")

        learner = self._learner()
        steady = self.setup.plant().warm_loads[-1]
        rotation = steady.transpose(1, 0, 2).reshape(4, -1)
        record = run(
            self._plant(),
            learner,
            rotations=self.learning.rotations,
            sensors=sensors_of(self.learning, rotation),
            checkpoint=checkpoint,
            context={
                "case": self.case.settings(),
                "turbine": self.setup.plain(),
                "seed": self.learning.seed,
            },
            callback=told,
        )
        twin = self._plant()
        constant = np.full(self.layout.stations, self.setup.start.pitch)
        return record, np.array(
            [twin.passage(constant, j).std(axis=1) for j in range(len(record.passages))]
        )


def rotation_rms(loads: FloatArray) -> FloatArray:
    """RMS (R, 4) over all samples of each rotation of loads (R, B, 4, m)."""
    return np.asarray(loads.transpose(0, 2, 1, 3).reshape(len(loads), 4, -1).std(axis=2))


def turned_profile(profile: FloatArray, angle: float) -> FloatArray:
    """Profile (N,) that does at every azimuth what the given one does `angle` [rad] later.

    Through its harmonics, of which that of half the sampling is dropped.
    """
    parts = np.fft.rfft(profile)
    if profile.size % 2 == 0:
        parts[-1] = 0.0
    turned = parts * np.exp(1j * np.arange(parts.size) * angle)
    return np.asarray(np.fft.irfft(turned, n=profile.size))


def _check(case: Case, learning: LearningSettings) -> None:
    """Refuse what the static rotor alone can do, and what no learner does."""
    structural_turbine(case)
    steady_wind(case)
    for name in ("wind", "difference"):
        if getattr(learning, name) is not None:
            raise InputError(
                f"{name}: got {type(getattr(learning, name)).__name__} on the dynamic turbine, "
                "expected none: changing winds and different blades are those of the static plant"
            )
    check_learnable(case, learning)
