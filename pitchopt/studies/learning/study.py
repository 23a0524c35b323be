"""A learning run on the static rotor: plant, learner, sensors and designs to compare with.

    learn(case, settings)  ->  references  ->  plant, learner, sensors  ->  ilc.run  ->  result

The learner is told the loads, the set-point, the range and the rate of the actuators, and how far
the measurements lag; nothing else of turbine or wind.
"""

from __future__ import annotations

import math
import os
import time
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np

from ilc import ActuatorLimits, Layout, Learner, LearningError, Record, load_state, run
from pitchopt.cases import Case
from pitchopt.checks import FloatArray
from pitchopt.design import Status
from pitchopt.design.task import Progress
from pitchopt.errors import InfeasibleError, InputError
from pitchopt.studies.learning.figures import ProfileFigures, judged
from pitchopt.studies.learning.learners import check_learnable, learner_of, sensors_of
from pitchopt.studies.learning.loop import loop_of
from pitchopt.studies.learning.plant import StaticPlant
from pitchopt.studies.learning.references import Reference, SetpointSchedule, reference
from pitchopt.studies.learning.result import LearningResult, Stretch
from pitchopt.studies.learning.settings import LearningSettings
from pitchopt.studies.learning.tasks import WindTasks
from pitchopt.studies.learning.wind import (
    DRIFT_CUT,
    ConstantWind,
    WindDrift,
    WindRamp,
    WindStep,
)

__all__ = ["learn"]

_REFERENCE_STEPS = 500  # of the progress; a reference takes as long as some hundred rotations


def learn(
    case: Case,
    settings: LearningSettings | None = None,
    *,
    checkpoint: str | os.PathLike[str] | None = None,
    progress: Progress | None = None,
) -> LearningResult:
    """Let a learner find the profile of a case, and compare it with the design.

    The loads that are weighed are those of the rotor: a cap on the blade load in the case is left
    out, of the designs as well.

    Parameters
    ----------
    case : Case
        Its wind is that of the start.
    settings : LearningSettings, optional
        The defaults without.
    checkpoint : path, optional
        File that is written after each rotation, and from which the run goes on if it exists.
    progress : callable, optional
        Told how far references and run are.

    Returns
    -------
    LearningResult

    Raises
    ------
    InputError
        If case and settings do not fit each other, or the checkpoint is another run's.
    InfeasibleError
        If no profile gives the set-point.
    """
    study = _Study(case, LearningSettings() if settings is None else settings, progress)
    try:
        if checkpoint is not None and Path(checkpoint).exists():
            load_state(checkpoint)  # so that a file that is none is refused at once
        return study.result(checkpoint)
    except LearningError as error:
        raise InputError(str(error)) from error


@dataclass(frozen=True, kw_only=True, eq=False)
class _Run:
    """What was put together, and the record of what happened."""

    plant: StaticPlant
    learner: Learner
    record: Record


class _Study:
    """One run."""

    def __init__(
        self, case: Case, settings: LearningSettings, progress: Progress | None = None
    ) -> None:
        self.case, self.settings, self._progress = case, settings, progress
        self.wind = settings.wind or ConstantWind(speed=case.wind.speed)
        self._check()
        self.tasks = WindTasks(case=case)
        self.setpoints = SetpointSchedule(
            tasks=self.tasks,
            wind=self.wind,
            max_power_loss=settings.max_power_loss,
            mean_torque=settings.mean_torque,
        )
        self.layout = Layout(
            blades=case.blades, positions=case.positions, separate=bool(settings.separate)
        )

    def _check(self) -> None:
        """Refuse what a learner cannot do."""
        case = self.case
        if self.wind.speed != case.wind.speed:
            raise InputError(
                f"wind: got one that starts with {self.wind.speed:g} m/s, expected the case's "
                f"{case.wind.speed:g} m/s"
            )
        check_learnable(case, self.settings)

    # ---- what the run is compared with ---------------------------------------------------

    @cached_property
    def _changed(self) -> float | None:
        """Wind speed that a step or ramp leads to, if it begins within the run [m/s]."""
        wind, last = self.wind, self.settings.rotations
        begins = {WindStep: "rotation", WindRamp: "first"}.get(type(wind))
        if begins is None or getattr(wind, begins) >= last:
            return None
        assert isinstance(wind, (WindStep, WindRamp))
        if not wind.change:
            return None
        return wind.speed + wind.change

    @cached_property
    def _steps(self) -> int:
        """Progress until the run begins."""
        return _REFERENCE_STEPS * (1 if self._changed is None else 2)

    def _told(self, before: int, rotations: int) -> Progress | None:
        """Progress of one reference, as a part of the whole."""
        tell = self._progress
        if tell is None:
            return None

        def told(done: int, total: int, _: str) -> None:
            part = _REFERENCE_STEPS * done // max(total, 1)
            tell(before + min(part, _REFERENCE_STEPS), self._steps + rotations, "reference")

        return told

    def _reference(self, speed: float, before: int, rotations: int) -> Reference:
        try:
            found = reference(
                self.tasks,
                speed,
                max_power_loss=self.settings.max_power_loss,
                mean_torque=self.settings.mean_torque,
                progress=self._told(before, rotations),
            )
        except InfeasibleError as error:
            raise InfeasibleError(f"at {speed:g} m/s: {error}") from error
        if found.design.status is Status.INFEASIBLE:
            raise InfeasibleError(
                f"at {speed:g} m/s: no profile found with {found.setpoint:.6g} N m, expected "
                "a lower torque or a larger loss"
            )
        return found

    def _operating(self, first: Reference, after: Reference | None) -> float | dict[float, float]:
        """Pitch at which the plant's wake is frozen or its curves sampled, over wind speed."""
        if after is None:
            return first.operating_pitch
        ends = (first.operating_pitch, after.operating_pitch)
        if self.wind.levels is not None:
            return dict(zip(self.wind.levels, ends, strict=True))
        assert isinstance(self.wind, WindRamp)
        steps = self.wind.change / self.tasks.spacing
        grid = np.arange(min(0, math.floor(steps)), max(0, math.ceil(steps)) + 1)
        pitches = np.interp(grid / steps, (0.0, 1.0), ends)
        return {
            self.wind.speed + self.tasks.spacing * int(k): float(pitch)
            for k, pitch in zip(grid, pitches, strict=True)
        }

    # ---- the run -------------------------------------------------------------------------

    @cached_property
    def _limits(self) -> ActuatorLimits:
        """Range of the actuators, and their rate at the highest rotor speed."""
        wind, limits = self.wind, self.case.pitch_limits
        speeds = [wind.speed]
        if isinstance(wind, (WindStep, WindRamp)):
            speeds.append(wind.speed + wind.change)
        if isinstance(wind, WindDrift):
            speeds.append(wind.speed + DRIFT_CUT * wind.std)
        return ActuatorLimits.from_rate(
            lower=limits.lower,
            upper=limits.upper,
            pitch_rate=limits.pitch_rate,
            rotor_speed=max(
                self.case.with_values({"wind.speed": speed}).rotor_speed for speed in speeds
            ),
            stations=self.layout.stations,
        )

    def _learner(self, start: float) -> Learner:
        return learner_of(
            self.case,
            self.settings,
            layout=self.layout,
            limits=self._limits,
            start=start,
            setpoint=self.setpoints.at(0),
        )

    def _start(self, first: Reference) -> float:
        start = self.settings.start_pitch
        if start is None:
            return first.start_pitch
        low, high = self._limits.lower, self._limits.upper
        if not low <= start <= high:
            got, least, most = np.rad2deg([start, low, high])
            raise InputError(
                f"start pitch: got {got:g} deg, expected {least:g} to {most:g} deg, the range of "
                "the actuators"
            )
        return start

    def _context(self, operating: float | Mapping[float, float]) -> dict[str, Any]:
        """Plant and set-point as plain data: a checkpoint is gone on from only with the same."""
        plain = self.settings.plain()
        return {
            "case": self.case.settings(),
            "operating_pitch": list(operating.items())
            if isinstance(operating, Mapping)
            else operating,
            **{
                name: plain[name]
                for name in ("wind", "different_blade", "max_power_loss", "mean_torque")
            },
        }

    def _made(
        self,
        start: float,
        operating: float | dict[float, float],
        checkpoint: str | os.PathLike[str] | None,
    ) -> _Run:
        learner = self._learner(start)
        plant = StaticPlant(
            tasks=self.tasks,
            wind=self.wind,
            offset=learner.experiment_passages,
            difference=self.settings.difference,
            operating_pitch=operating,
        )
        tell = self._progress

        def told(done: int, total: int, _: str) -> None:
            if tell is not None:
                tell(self._steps + done, self._steps + total, "learning")

        record = run(
            plant,
            learner,
            rotations=self.settings.rotations,
            setpoint=self.setpoints.at,
            sensors=sensors_of(
                self.settings, plant.rotation(np.full(self.layout.stations, start), 0)
            ),
            checkpoint=checkpoint,
            context=self._context(operating),
            callback=told,
        )
        return _Run(plant=plant, learner=learner, record=record)

    # ---- the result ----------------------------------------------------------------------

    def result(self, checkpoint: str | os.PathLike[str] | None) -> LearningResult:
        """References, run and figures."""
        began = time.perf_counter()
        practice = self._learner(self._limits.lower).experiment_passages // self.layout.blades
        rotations = practice + self.settings.rotations
        first = self._reference(self.wind.speed, 0, rotations)
        after = None
        if self._changed is not None:
            after = self._reference(self._changed, _REFERENCE_STEPS, rotations)
        start = self._start(first)
        done = self._made(start, self._operating(first, after), checkpoint)
        learning = done.record.learning
        weights = self.case.weights.array[:4]
        last = int(learning.last_passage[-1])
        constant_start = np.full(self.layout.stations, start)
        return LearningResult(
            case=self.case,
            settings=self.settings,
            record=done.record,
            winds=np.array([done.plant.wind_speed(int(n)) for n in learning.last_passage]),
            stretches=self._stretches(first, after),
            reference=first,
            reference_after=after,
            baseline=self._constant(first),
            baseline_after=None if after is None else self._constant(after),
            start=judged(done.plant, constant_start, self.layout.blades - 1, weights),
            design=self._design(first),
            design_after=None if after is None else self._design(after),
            learned=judged(done.plant, learning.profile[-1], last, weights),
            loop=loop_of(done.plant, done.learner, done.record, first.design.azimuth),
            seconds=time.perf_counter() - began,
        )

    def _held(self, profile: FloatArray, speed: float, operating: float) -> ProfileFigures:
        """Figures of a profile in a wind that stays, in the last passage of a rotation."""
        plant = StaticPlant(
            tasks=self.tasks,
            wind=ConstantWind(speed=speed),
            difference=self.settings.difference,
            operating_pitch=operating,
        )
        return judged(plant, profile, self.layout.blades - 1, self.case.weights.array[:4])

    def _constant(self, ref: Reference) -> ProfileFigures:
        """The best constant pitch, its wake or curves around itself."""
        pitch = ref.best.profile
        return self._held(pitch, ref.wind_speed, float(pitch[0]))

    def _design(self, ref: Reference) -> ProfileFigures:
        """The design on the curves of the run's plant."""
        return self._held(ref.design.profile, ref.wind_speed, ref.operating_pitch)

    def _stretches(self, first: Reference, after: Reference | None) -> tuple[Stretch, ...]:
        """The rotations over which the wind stays, and what belongs to it."""
        end, wind = self.settings.rotations, self.wind
        spans: list[tuple[int, int, Reference]] = [(1, end, first)]
        if after is not None and isinstance(wind, WindStep):
            spans = [(1, wind.rotation, first), (wind.rotation + 1, end, after)]
        if after is not None and isinstance(wind, WindRamp):
            spans = [(1, math.floor(wind.first), first), (math.ceil(wind.last) + 1, end, after)]
        return tuple(
            Stretch(
                first=begins,
                last=ends,
                reference=ref,
                design=self._design(ref),
                constant=self._constant(ref),
                mean_wind=isinstance(wind, WindDrift),
            )
            for begins, ends, ref in spans
            if begins <= ends
        )
