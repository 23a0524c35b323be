"""Controllers tuned one after the other: Zalkind et al., section 3.4.

The gain of the torque law first, then the speed regulator with that gain, then the table of
lowest pitch with both, and at the end gain and regulator again with the table in place, from where
they stand.  The authors saw little change in that last round; `SequenceResult.changes` tells it.

Source: Zalkind, Dall'Anese, Pao, Automatic controller tuning using a zeroth-order optimization
algorithm, Wind Energy Science 5 (2020), section 3.4; settings by its section 4, `guidelines`.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

from pitchopt.checks import FloatArray
from pitchopt.control import MinimumPitchTable, TurbineController
from pitchopt.studies.tuning.guidelines import GuidedTuning, tune_by_guidelines
from pitchopt.studies.tuning.minimum_pitch import minimum_pitch_base, with_table
from pitchopt.studies.tuning.minimum_pitch_table import tune_minimum_pitch
from pitchopt.studies.tuning.plant import TuningPlant
from pitchopt.studies.tuning.speed_regulator import SpeedRegulator
from pitchopt.studies.tuning.torque_gain import TorqueGain

__all__ = ["SequenceResult", "SequenceStep", "tune_in_sequence"]

TORQUE, REGULATOR = "torque gain", "speed regulator"
AGAIN = " again"


@dataclass(frozen=True, kw_only=True)
class SequenceStep:
    """One tuning.

    Attributes
    ----------
    name : str
    tuning : GuidedTuning
    controller : TurbineController
        With what was found.
    """

    name: str
    tuning: GuidedTuning
    controller: TurbineController


@dataclass(frozen=True, kw_only=True)
class SequenceResult:
    """Steps in their order.

    Attributes
    ----------
    steps : tuple of SequenceStep
        Those of the zeroth-order tuner.
    minimum_pitch : MinimumPitchTable or None
        Found between the first two and the last two.
    controller : TurbineController
        With all that was found.
    """

    steps: tuple[SequenceStep, ...]
    minimum_pitch: MinimumPitchTable | None
    controller: TurbineController

    @property
    def simulations(self) -> int:
        """Of the steps, those for the table of lowest pitch not among them."""
        return sum(step.tuning.simulations for step in self.steps)

    def changes(self) -> dict[str, FloatArray]:
        """How far each tuning moved when it was made again, over the ranges of its parameters."""
        found = {step.name: step.tuning for step in self.steps}
        return {
            name: (found[name + AGAIN].x - tuning.x)
            / (tuning.problem.space.upper - tuning.problem.space.lower)
            for name, tuning in found.items()
            if name + AGAIN in found
        }


def tune_in_sequence(
    plant: TuningPlant,
    *,
    minimum_pitch: Callable[[TurbineController], MinimumPitchTable] | None = None,
    pitch_table: bool = True,
    torque: Mapping[str, Any] | None = None,
    regulator: Mapping[str, Any] | None = None,
    settings: Mapping[str, Any] | None = None,
    progress: Callable[[str], None] | None = None,
) -> SequenceResult:
    """Tune torque gain, speed regulator and lowest pitch, and the first two again.

    Parameters
    ----------
    plant : TuningPlant
    minimum_pitch : callable, optional
        Finds the table of lowest pitch for a controller that has a wind estimator;
        `tune_minimum_pitch` without.
    pitch_table : bool
        Whether there is to be a table; without one the sequence ends after the second step.
    torque, regulator : mapping, optional
        Arguments of `TorqueGain` and `SpeedRegulator`, such as wind speeds, seeds and start.
    settings : mapping, optional
        Arguments of `tune_by_guidelines`.
    progress : callable, optional
        Called with the name of each step before it.

    Raises
    ------
    InputError
        If an argument does not fit.
    ComputationError
        If evaluations fail throughout.
    """
    kinds = {TORQUE: (TorqueGain, torque), REGULATOR: (SpeedRegulator, regulator)}
    # the table needs an estimator, which changes nothing without it
    estimator = minimum_pitch_base(plant).estimator
    controller = dataclasses.replace(plant.operation.baseline(), estimator=estimator)
    steps: list[SequenceStep] = []
    at: dict[str, FloatArray] = {}

    def tell(name: str) -> None:
        if progress is not None:
            progress(name)

    def step(name: str, suffix: str = "") -> None:
        nonlocal controller
        tell(name + suffix)
        kind, options = kinds[name]
        given: dict[str, Any] = {**(options or {}), "base": controller}
        if name in at:
            given["start"] = at[name][0] if name == TORQUE else at[name]
        tuning = tune_by_guidelines(kind(plant, **given), **(settings or {}))
        at[name] = tuning.x
        controller = tuning.problem.controller(tuning.x)
        steps.append(SequenceStep(name=name + suffix, tuning=tuning, controller=controller))

    step(TORQUE)
    step(REGULATOR)
    if not pitch_table:
        return SequenceResult(steps=tuple(steps), minimum_pitch=None, controller=controller)
    tell("minimum pitch")
    if minimum_pitch is None:
        table = tune_minimum_pitch(plant, base=controller).table
    else:
        table = minimum_pitch(controller)
    controller = with_table(controller, table)
    step(TORQUE, AGAIN)
    step(REGULATOR, AGAIN)
    return SequenceResult(steps=tuple(steps), minimum_pitch=table, controller=controller)
