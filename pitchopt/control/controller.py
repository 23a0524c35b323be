"""The turbine's controller, composed of its parts.

It runs the compiled kernel that the time loop runs, so that both give the same numbers to the
last bit.  Order of the operations, start and treatment of bad measurements:
`pitchopt.control.kernels`.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np

from pitchopt.checks import FloatArray, finite_number
from pitchopt.control.estimator import WindEstimator
from pitchopt.control.feedforward import PitchProfile
from pitchopt.control.individual import IndividualPitch
from pitchopt.control.lqr import LinearQuadratic
from pitchopt.control.minimum_pitch import MinimumPitchTable
from pitchopt.control.parameters import (
    HELD,
    MEMORY_SIZE,
    NO_ESTIMATOR,
    NO_FEEDFORWARD,
    NO_INDIVIDUAL,
    NO_LINEAR_QUADRATIC,
    NO_MINIMUM,
    NO_PITCH,
    WIND,
    ControlParameters,
)
from pitchopt.control.pitch import PitchRange, PitchRegulator
from pitchopt.control.signals import COMMANDS, MEASURED
from pitchopt.control.torque import TorqueLaw
from pitchopt.errors import InputError

__all__ = ["TurbineController", "nrel_5mw_baseline"]


class _Run:
    """What a run in progress remembers."""

    def __init__(self) -> None:
        self.parameters: ControlParameters | None = None
        self.memory = np.zeros(MEMORY_SIZE)


@dataclass(frozen=True, kw_only=True, eq=False)
class TurbineController:
    """Torque law, pitch regulator and what else the turbine has.

    Parameters
    ----------
    torque : TorqueLaw
        With a linear quadratic regulator only its largest torque and rate count.
    pitch : PitchRegulator or LinearQuadratic
        The latter commands pitch and torque, and needs an estimator.
    pitch_range : PitchRange
        Of all pitch commands.
    speed_corner : float
        Corner of the first-order low pass of the generator speed [rad/s].
    estimator : WindEstimator, optional
        Of the wind speed.
    minimum_pitch : MinimumPitchTable, optional
        Raises the lowest collective pitch; needs an estimator.
    individual : IndividualPitch, optional
    feedforward : PitchProfile, optional
        Needs an estimator if it is scheduled over the wind speed.

    Raises
    ------
    InputError
        If a part is of another kind, the estimator that one needs is missing, or the gain
        schedule changes sign within the range of pitch.

    Notes
    -----
    The parameters never change; `start` and `command` keep the memory of one run, so two runs at
    a time need two controllers.  The time loop keeps memories of its own.
    """

    torque: TorqueLaw
    pitch: PitchRegulator | LinearQuadratic
    pitch_range: PitchRange
    speed_corner: float
    estimator: WindEstimator | None = None
    minimum_pitch: MinimumPitchTable | None = None
    individual: IndividualPitch | None = None
    feedforward: PitchProfile | None = None
    _run: _Run = field(default_factory=_Run, init=False, repr=False)

    def __post_init__(self) -> None:
        for name, kinds in _PARTS.items():
            part = getattr(self, name)
            if not isinstance(part, kinds):
                names = " or ".join(
                    "None" if kind is type(None) else kind.__name__ for kind in kinds
                )
                raise InputError(f"{name}: got {type(part).__name__}, expected {names}")
        finite_number("speed_corner", self.speed_corner, above=0.0)
        if self.estimator is None:
            for name, needs in (
                ("pitch", isinstance(self.pitch, LinearQuadratic)),
                ("minimum_pitch", self.minimum_pitch is not None),
                ("feedforward", self.feedforward is not None and self.feedforward.over_wind),
            ):
                if needs:
                    raise InputError(
                        f"{name}: scheduled over the wind speed without an estimator, expected "
                        "a WindEstimator as estimator"
                    )
        if isinstance(self.pitch, PitchRegulator):
            self.pitch.parameters(self.pitch_range)

    @property
    def memory_size(self) -> int:
        """Length of the memory that the kernels need."""
        return MEMORY_SIZE + (0 if self.individual is None else 2 * self.individual.gain.size)

    def parameters(self, step: float) -> ControlParameters:
        """Numbers for `pitchopt.control.kernels.update`, called every `step` seconds."""
        step = finite_number("step", step, above=0.0)
        pitch, linear_quadratic = NO_PITCH, NO_LINEAR_QUADRATIC
        if isinstance(self.pitch, PitchRegulator):
            pitch = self.pitch.parameters(self.pitch_range)
        else:
            linear_quadratic = self.pitch.parameters(step)
        return ControlParameters(
            step=step,
            keep=math.exp(-self.speed_corner * step),
            torque=self.torque.parameters(),
            range=self.pitch_range.parameters(),
            pitch=pitch,
            linear_quadratic=linear_quadratic,
            estimator=NO_ESTIMATOR if self.estimator is None else self.estimator.parameters(),
            minimum=NO_MINIMUM if self.minimum_pitch is None else self.minimum_pitch.parameters(),
            individual=NO_INDIVIDUAL if self.individual is None else self.individual.parameters(),
            feedforward=(
                NO_FEEDFORWARD if self.feedforward is None else self.feedforward.parameters()
            ),
        )

    def start(self, step: float, measured: FloatArray) -> None:
        """Prepare for a run from what is measured (MEASURED,) at its first instant.

        Raises
        ------
        InputError
            If the step is not positive or a measurement is not finite.
        """
        from pitchopt.control import kernels

        vector = _measurements(measured)
        if not np.all(np.isfinite(vector)):
            raise InputError(
                f"measured: got {np.sum(~np.isfinite(vector))} NaN or infinite values at the "
                "first instant, expected finite ones"
            )
        self._run.parameters = self.parameters(step)
        self._run.memory = np.zeros(self.memory_size)
        kernels.start(self._run.parameters, self._run.memory, vector)

    def command(self, measured: FloatArray) -> FloatArray:
        """Commands (COMMANDS,) for what is measured (MEASURED,) now.

        A measurement that is not finite holds the last command; `held_calls` counts these.

        Raises
        ------
        InputError
            Before `start`, or if the vector has another length.
        """
        from pitchopt.control import kernels

        if self._run.parameters is None:
            raise InputError("command: called before start, expected start(step, measured) first")
        out = np.empty(COMMANDS)
        kernels.update(self._run.parameters, self._run.memory, _measurements(measured), out)
        return out

    @property
    def wind_speed(self) -> float:
        """Estimated wind speed [m/s] of this run; 0 without an estimator."""
        return float(self._run.memory[WIND])

    @property
    def held_calls(self) -> int:
        """Calls of this run that were answered with the last command."""
        return int(self._run.memory[HELD])


_PARTS: dict[str, tuple[type, ...]] = {
    "torque": (TorqueLaw,),
    "pitch": (PitchRegulator, LinearQuadratic),
    "pitch_range": (PitchRange,),
    "estimator": (WindEstimator, type(None)),
    "minimum_pitch": (MinimumPitchTable, type(None)),
    "individual": (IndividualPitch, type(None)),
    "feedforward": (PitchProfile, type(None)),
}


def _measurements(measured: FloatArray) -> FloatArray:
    vector = np.array(measured, dtype=np.float64)
    if vector.shape != (MEASURED,):
        raise InputError(f"measured: got shape {vector.shape}, expected ({MEASURED},)")
    return vector


def nrel_5mw_baseline() -> TurbineController:
    """Baseline controller of the NREL 5 MW turbine, land-based.

    Numbers of NREL/TP-500-38060, section 7, and of the controller that belongs to it.
    """
    return TurbineController(
        torque=TorqueLaw(
            gain=2.332287,
            rated_power=5296610.0,
            rated_speed=121.6805,
            largest_torque=47402.91,
            largest_rate=15000.0,
            cut_in_speed=70.16224,
            region2_speed=91.21091,
            slip=0.1,
            constant_power=True,
            region3_pitch=math.radians(1.0),
        ),
        pitch=PitchRegulator(
            proportional=0.01882681,
            integral=0.008068634,
            reference_speed=122.9096,
            linear=1.0 / 0.1099965,
        ),
        pitch_range=PitchRange(lowest=0.0, highest=math.radians(90.0), rate=math.radians(8.0)),
        speed_corner=1.570796,
    )
