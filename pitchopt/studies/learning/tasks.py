"""WindTasks: the design tasks and curves of one case at several wind speeds, each made once.

Plant, set-point and references share one such object, so that they work on the same curves and
none is made twice.  A plant measures no blade load, hence the cap on it is left out; weights,
limits and harmonics follow the case.  Rotor speed follows the case too: where it leaves it open,
the turbine's schedule gives it for each wind speed.
"""

from __future__ import annotations

from contextlib import suppress
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from pitchopt.aero.curves import BladeCurves
from pitchopt.cases import Case
from pitchopt.checks import FloatArray, finite_number
from pitchopt.design import Design, DesignTask, constant, power_max
from pitchopt.errors import InputError

if TYPE_CHECKING:
    from pitchopt.aero.static_rotor import StaticRotor

__all__ = ["WindTasks"]

_SPACING = 0.1
_STALL_SAMPLES = 24
_SPACING_INDUCTION = 0.25  # curves take seconds and bend less: they are not piecewise linear


@dataclass(frozen=True, kw_only=True, eq=False)
class WindTasks:
    """What one case is at any wind speed.

    Parameters
    ----------
    case : Case
        Its wind speed is that of the start.  A table of curves, or a wind given by a disc file,
        holds for that speed alone.
    """

    case: Case

    @cached_property
    def _tasks(self) -> dict[float, DesignTask]:
        return {}

    @cached_property
    def _best(self) -> dict[float, Design]:
        return {}

    @cached_property
    def _power(self) -> dict[float, Design]:
        return {}

    @cached_property
    def _curves(self) -> dict[tuple[float, float | None, float], BladeCurves]:
        return {}

    @cached_property
    def _continued(self) -> dict[tuple[float, float | None, float], BladeCurves]:
        return {}

    @property
    def spacing(self) -> float:
        """Distance of the wind speeds between which may be interpolated [m/s]."""
        return _SPACING if self.case.aero.induction == "none" else _SPACING_INDUCTION

    def task(self, speed: float) -> DesignTask:
        """The design task at a wind speed [m/s], without cap on the blade load.

        Raises
        ------
        InputError
            If the case holds for another speed alone.
        """
        speed = finite_number("wind speed", speed, above=0)
        if speed not in self._tasks:
            case, own = self.case, self.case.wind.speed
            what = "table of curves" if case.curves is not None else "disc file"
            if speed != own and (case.curves is not None or case.wind.disc is not None):
                raise InputError(
                    f"wind speed: got {speed:g} m/s, expected {own:g} m/s: the {what} of "
                    f"the case {case.name!r} holds for one wind alone"
                )
            values = {"wind.speed": speed, "objective.blade_cap": None}
            self._tasks[speed] = case.with_values(values).task()
        return self._tasks[speed]

    def best(self, speed: float) -> Design:
        """The constant pitch of largest mean torque at a wind speed [m/s]."""
        if speed not in self._best:
            self._best[speed] = constant(self.task(speed))
        return self._best[speed]

    def power_max(self, speed: float) -> Design:
        """The profile of largest mean torque at a wind speed [m/s]."""
        if speed not in self._power:
            self._power[speed] = power_max(self.task(speed), reference=self.best(speed))
        return self._power[speed]

    def curves(
        self, speed: float, *, operating_pitch: float | None = None, chord: float = 1.0
    ) -> BladeCurves:
        """The curves that design works on.

        Parameters
        ----------
        speed : float
            Wind speed [m/s].
        operating_pitch : float, optional
            Pitch around which curves in equilibrium are sampled, or at which a wake is frozen
            [rad]; that of :meth:`best` by default.  Without induction it changes nothing.
        chord : float
            Factor on the chord of the blade, which meets an induction of its own.

        Raises
        ------
        InputError
            If the chord is scaled and the case is a table of curves, or no pitch is left.
        """
        key = (speed, operating_pitch, chord)
        if key not in self._curves:
            task = self._with_chord(self.task(speed), chord)
            pitch = operating_pitch
            if pitch is None and (task.frozen or task.balanced):
                pitch = float(self.best(speed).profile[0])
            if pitch is not None:
                task = task.operating_at(pitch)
            self._curves[key] = task.problem(pitch).curves
        return self._curves[key]

    def plant_curves(
        self, speed: float, *, operating_pitch: float | None = None, chord: float = 1.0
    ) -> BladeCurves:
        """The curves that design works on, continued over the actuators' range and a little more.

        Curves in equilibrium end where sections stall; beyond that the momentum balance goes on
        with the polars' own stall.  Other curves, and those of polars that end before the range
        does, come as they are: they go on with their last slope.  Arguments as in :meth:`curves`.
        """
        key = (speed, operating_pitch, chord)
        if key not in self._continued:
            curves = self.curves(speed, operating_pitch=operating_pitch, chord=chord)
            task = self._with_chord(self.task(speed), chord)
            if task.balanced:
                if operating_pitch is None:
                    operating_pitch = float(self.best(speed).profile[0])
                with suppress(InputError):
                    curves = _through_stall(task, curves, operating_pitch)
            self._continued[key] = curves
        return self._continued[key]

    def _with_chord(self, task: DesignTask, factor: float) -> DesignTask:
        """The task with another chord."""
        if factor == 1.0:
            return task
        factor = finite_number("chord", factor, above=0)
        if self.case.curves is not None:
            raise InputError(
                f"chord: got a factor of {factor:g}, expected 1: the chord of a table of curves "
                "cannot be changed"
            )
        model: StaticRotor = task.model  # type: ignore[assignment]
        blade = replace(model.rotor.blade, chord=factor * model.rotor.blade.chord)
        return replace(task, model=replace(model, rotor=replace(model.rotor, blade=blade)))


def _through_stall(task: DesignTask, curves: BladeCurves, operating_pitch: float) -> BladeCurves:
    """Curves with samples of the momentum balance from their ends to those of the pitch range."""
    model: StaticRotor = task.model  # type: ignore[assignment]
    reach = np.deg2rad(1.0)
    low = np.minimum(model.pitch_range[0], curves.lower - reach)
    high = np.maximum(model.pitch_range[1], curves.upper + reach)
    below = np.linspace(low, curves.lower, _STALL_SAMPLES, endpoint=False, axis=1)
    above = np.linspace(high, curves.upper, _STALL_SAMPLES, endpoint=False, axis=1)[:, ::-1]
    ends = [
        model.blade_loads(curves.azimuth[:, None], pitch, mean_pitch=operating_pitch)
        for pitch in (below, above)
    ]

    def joined(name: str) -> FloatArray:
        return np.hstack([getattr(ends[0], name), getattr(curves, name), getattr(ends[1], name)])

    return replace(
        curves,
        beta=np.hstack([below, curves.beta, above]),
        torque=joined("torque"),
        bending=joined("bending"),
        thrust=joined("thrust"),
        radial=joined("radial"),
    )
