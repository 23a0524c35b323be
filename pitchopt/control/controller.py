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
from pitchopt.control.parameters import HELD, MEMORY_SIZE, ControlParameters
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


@dataclass(frozen=True, kw_only=True)
class TurbineController:
    """Torque law, pitch regulator and what else the turbine has.

    Parameters
    ----------
    torque : TorqueLaw
    pitch : PitchRegulator
    pitch_range : PitchRange
        Of all pitch commands.
    speed_corner : float
        Corner of the first-order low pass of the generator speed [rad/s].

    Notes
    -----
    The parameters never change; `start` and `command` keep the memory of one run, so two runs at
    a time need two controllers.  The time loop keeps memories of its own.
    """

    torque: TorqueLaw
    pitch: PitchRegulator
    pitch_range: PitchRange
    speed_corner: float
    _run: _Run = field(default_factory=_Run, init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        for name, kind in (
            ("torque", TorqueLaw),
            ("pitch", PitchRegulator),
            ("pitch_range", PitchRange),
        ):
            if not isinstance(getattr(self, name), kind):
                raise InputError(
                    f"{name}: got {type(getattr(self, name)).__name__}, expected {kind.__name__}"
                )
        finite_number("speed_corner", self.speed_corner, above=0.0)
        self.parameters(1.0)

    @property
    def memory_size(self) -> int:
        """Length of the memory that the kernels need."""
        return MEMORY_SIZE

    def parameters(self, step: float) -> ControlParameters:
        """Numbers for `pitchopt.control.kernels.update`, called every `step` seconds."""
        step = finite_number("step", step, above=0.0)
        return ControlParameters(
            step=step,
            keep=math.exp(-self.speed_corner * step),
            torque=self.torque.parameters(),
            pitch=self.pitch.parameters(self.pitch_range),
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
    def held_calls(self) -> int:
        """Calls of this run that were answered with the last command."""
        return int(self._run.memory[HELD])


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
