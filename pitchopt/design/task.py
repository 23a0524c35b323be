"""What is to be designed: a model of the rotor, limits, weights and restrictions.

A model answers two questions: the BladeCurves at so many rotor positions, and the loads of one
blade at any azimuth and pitch (for judging a profile between the stations).  With a frozen wake
both depend on the mean pitch at which the wake was frozen.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Protocol, runtime_checkable

import numpy as np
from numpy.typing import ArrayLike, NDArray

from pitchopt.aero.curves import BladeCurves, RotorLoads
from pitchopt.checks import finite_number, whole_number
from pitchopt.design.limits import PitchLimits
from pitchopt.design.problem import DesignProblem, LoadWeights
from pitchopt.errors import InputError

__all__ = ["BladeLoadsLike", "CurvesModel", "DesignTask", "PitchModel", "Progress"]

FloatArray = NDArray[np.float64]
Progress = Callable[[int, int, str], None]
"""Called with steps done, steps in all, and what is being done."""


class BladeLoadsLike(Protocol):
    """Loads of one blade at some azimuths."""

    @property
    def torque(self) -> FloatArray:
        """Moment about the shaft [N m]."""
        ...

    @property
    def bending(self) -> FloatArray:
        """Moment that pushes the tip downwind [N m]."""
        ...

    @property
    def radial(self) -> FloatArray:
        """Moment about the blade's own axis [N m]."""
        ...

    @property
    def thrust(self) -> FloatArray:
        """Force along the shaft [N]."""
        ...


@runtime_checkable
class PitchModel(Protocol):
    """A rotor in its wind, as design sees it."""

    @property
    def induction(self) -> str:
        """``none``, ``frozen`` (curves need a mean pitch) or ``equilibrium``."""
        ...

    def curves(self, positions: int, mean_pitch: float | None = None) -> BladeCurves:
        """Curves at ``positions`` rotor positions, with the wake frozen at ``mean_pitch``."""
        ...

    def blade_loads(
        self,
        azimuth: ArrayLike,
        pitch: ArrayLike,
        pitch_rate: ArrayLike = 0.0,
        mean_pitch: float | None = None,
    ) -> BladeLoadsLike:
        """Loads of one blade at azimuths and pitches."""
        ...


@dataclass(frozen=True, kw_only=True, eq=False)
class CurvesModel:
    """Curves that some other aerodynamic code made; nothing is known between the stations."""

    table: BladeCurves
    induction: str = field(default="table")

    def curves(
        self,
        positions: int,
        mean_pitch: float | None = None,  # noqa: ARG002  part of the protocol
    ) -> BladeCurves:
        """The table itself; the mean pitch is the table's own.

        Raises
        ------
        InputError
            If another number of positions is asked for than the table has.
        """
        if positions != self.table.positions:
            raise InputError(
                f"positions: got {positions}, the table of curves has {self.table.positions}"
            )
        return self.table


@dataclass(frozen=True, kw_only=True, eq=False)
class DesignTask:
    """One design task.

    Parameters
    ----------
    model : PitchModel or CurvesModel
    positions : int
        Rotor positions m in one blade passage.
    limits : PitchLimits
    weights : LoadWeights
        Weights of the RMS values; the paper's (1, 1, 1, 1) by default.
    blade_cap : float, optional
        Largest J_blade relative to that of the constant pitch compared with.
    harmonics : int, optional
        Restrict profiles to harmonics up to this multiple of the rotor frequency.
    travel : float
        Penalty on pitch travel [N m/rad].
    between_positions : int
        Rotor positions at which profiles are judged between the stations.
    operating_pitch : float, optional
        With ``equilibrium`` induction, the pitch around which curves are sampled densely and
        pitch-rate terms and stall limits are taken [rad]; the best constant pitch by default.

    Raises
    ------
    InputError
        If a number is outside what is allowed.
    """

    model: PitchModel | CurvesModel
    positions: int
    limits: PitchLimits
    weights: LoadWeights = field(default_factory=LoadWeights.unit)
    blade_cap: float | None = None
    harmonics: int | None = None
    travel: float = 0.0
    between_positions: int = 960
    operating_pitch: float | None = None

    def __post_init__(self) -> None:
        for name in ("positions", "between_positions"):
            whole_number(name, getattr(self, name), at_least=1)
        if self.blade_cap is not None:
            finite_number("blade_cap", self.blade_cap, above=0)
        if self.harmonics is not None:
            whole_number("harmonics", self.harmonics, at_least=0)
        finite_number("travel", self.travel, at_least=0)
        if self.operating_pitch is not None:
            finite_number("operating_pitch", self.operating_pitch)

    @property
    def frozen(self) -> bool:
        """True when the curves depend on the mean pitch at which the wake is frozen."""
        return self.model.induction == "frozen"

    @property
    def balanced(self) -> bool:
        """True when each azimuth and pitch has a momentum balance of its own."""
        return self.model.induction == "equilibrium"

    def operating_at(self, pitch: float) -> DesignTask:
        """The task with curves around another pitch; itself where that makes no difference."""
        if not self.balanced or self.operating_pitch == pitch:
            return self
        other = replace(self, operating_pitch=float(pitch))
        # the range and the problems by pitch are the same for all operating pitches
        other.__dict__.update(mean_range=self.mean_range, _problems=self._problems)
        return other

    @cached_property
    def _operating(self) -> float | None:
        if not self.balanced or self.operating_pitch is not None:
            return self.operating_pitch
        grid = np.linspace(*self.mean_range, 41)
        torque = [float(self.constant_loads(float(p)).mean[0]) for p in grid]
        return float(grid[int(np.argmax(torque))])

    @cached_property
    def _problems(self) -> dict[float, DesignProblem]:
        return {}

    def problem(self, mean_pitch: float | None = None) -> DesignProblem:
        """The design problem on the curves of this mean pitch, made once for each.

        Raises
        ------
        InputError
            If the wake is frozen and no mean pitch is given, or the limits admit none.
        """
        if self.frozen and mean_pitch is None:
            raise InputError("mean_pitch: needed for a frozen wake, got None")
        at = mean_pitch if self.frozen else self._operating
        key = 0.0 if at is None else float(at)
        if key not in self._problems:
            if len(self._problems) >= 64:
                self._problems.pop(next(iter(self._problems)))
            self._problems[key] = DesignProblem(
                curves=self.model.curves(self.positions, at),
                limits=self.limits,
                harmonics=self.harmonics,
            )
        return self._problems[key]

    @cached_property
    def mean_range(self) -> tuple[float, float]:
        """Constant pitches that the limits leave [rad].

        With induction the stall limits move with the mean pitch: the range is where no outboard
        section stalls at any azimuth.
        """
        if not self.frozen and not self.balanced:
            return self.problem().constant_range
        low, high = self.limits.lower, self.limits.upper
        attached = getattr(self.model, "attached_pitch", None)
        if attached is None:
            return _admitted(self, low, high)
        first, last = attached(min(self.positions, 24))
        if max(low, first) >= min(high, last):
            raise InputError(
                f"pitch limits: the range {np.degrees(low):g} to {np.degrees(high):g} deg leaves "
                f"no constant pitch without stall ({np.degrees(first):.2f} to "
                f"{np.degrees(last):.2f} deg)"
            )
        return max(low, first), min(high, last)

    def constant_loads(self, pitch: float) -> RotorLoads:
        """Loads of one constant pitch at the stations, the wake in equilibrium with it."""
        if not self.frozen and not self.balanced:
            problem = self.problem()
            return problem.curves.evaluate(np.full(problem.curves.stations, pitch))
        blades = _blade_count(self)
        psi = 2 * np.pi * np.arange(blades * self.positions) / (blades * self.positions)
        return self._reduced(psi, np.full(psi.size, pitch), np.zeros(psi.size), pitch)

    def between(self, profile: FloatArray, mean_pitch: float | None) -> RotorLoads | None:
        """Loads of the linearly interpolated profile at ``between_positions`` positions.

        Evaluated with the model itself, pitch rate included.  None for a table of curves
        without a rotor.
        """
        if isinstance(self.model, CurvesModel):
            return None
        curves = self.problem(mean_pitch).curves
        count = curves.blades * self.between_positions
        psi = curves.azimuth[0] + 2 * np.pi * np.arange(count) / count
        beta = np.interp(psi, curves.azimuth, profile, period=2 * np.pi)
        tiny = 1e-6
        ahead = np.interp(psi + tiny, curves.azimuth, profile, period=2 * np.pi)
        behind = np.interp(psi - tiny, curves.azimuth, profile, period=2 * np.pi)
        rate = (ahead - behind) / (2 * tiny) * self.limits.rotor_speed
        return self._reduced(psi, beta, rate, mean_pitch if self.frozen else self._operating)

    def _reduced(
        self, psi: FloatArray, beta: FloatArray, rate: FloatArray, mean_pitch: float | None
    ) -> RotorLoads:
        """Rotor loads from the model's blade loads at evenly spaced azimuths."""
        assert not isinstance(self.model, CurvesModel)
        loads = self.model.blade_loads(psi, beta, pitch_rate=rate, mean_pitch=mean_pitch)
        torque, bending, radial, thrust = loads.torque, loads.bending, loads.radial, loads.thrust
        c, s = np.cos(psi), np.sin(psi)
        station = np.stack([torque, bending * c - radial * s, bending * s + radial * c, thrust])
        blades = _blade_count(self)
        rotor = station.reshape(4, blades, psi.size // blades).sum(axis=1)
        return RotorLoads(rotor=np.asarray(rotor), bending=np.asarray(bending))


def _blade_count(task: DesignTask) -> int:
    if isinstance(task.model, CurvesModel):
        return task.model.table.blades
    rotor = getattr(task.model, "rotor", None)
    if rotor is not None:
        return int(rotor.blades)
    return task.model.curves(1, 0.0 if task.frozen else None).blades


def _admitted(task: DesignTask, low: float, high: float) -> tuple[float, float]:
    """Narrow a range of mean pitch to where a frozen problem can be posed."""

    def works(pitch: float) -> bool:
        try:
            task.problem(pitch)
        except InputError:
            return False
        return True

    grid = np.linspace(low, high, 41)
    good = [p for p in grid if works(float(p))]
    if not good:
        raise InputError(
            "pitch limits: no mean pitch between "
            f"{np.degrees(low):.2f} and {np.degrees(high):.2f} deg keeps range and stall limits"
        )
    ends = []
    for inside, outside in ((good[0], low), (good[-1], high)):
        a, b = float(inside), float(outside)
        if works(b):
            ends.append(b)
            continue
        b = float(inside) + np.sign(outside - inside) * (grid[1] - grid[0])
        while abs(b - a) > np.radians(0.05):
            middle = 0.5 * (a + b)
            a, b = (middle, b) if works(middle) else (a, middle)
        ends.append(a)
    return ends[0], ends[1]
