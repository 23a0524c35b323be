"""What a parameter changes of the convex subproblem around a design.

rate    D, and the ends of the range where they are tightened to what the rate can follow
lower, upper   low_n, high_n, except where stall limits hold
mu      the objective, by -dmu x weighted RMS: the envelope of a function that is convex in mu
loss, torque   torque_min (and torque_max)
shear   line, slope, rate, and low_n, high_n where stall limits hold
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from pitchopt.checks import FloatArray
from pitchopt.design.limits import lipschitz_lower, lipschitz_upper
from pitchopt.studies.sensitivity.design_lines import FrozenLines, Lines

if TYPE_CHECKING:
    from pitchopt.studies.sensitivity.design_point import DesignPoint

__all__ = ["State", "States"]


@dataclass(frozen=True, kw_only=True, eq=False)
class State:
    """What the subproblem is made of at a value of the parameter.

    Attributes
    ----------
    lines : Lines
        That the profile stands on.
    step : float
        D, the largest change of pitch between stations [rad].
    low, high : ndarray (N,)
        Ends of the range [rad].
    torque_min, torque_max : float
        [N m].
    extra : float
        What is added to the objective [N m].
    """

    lines: Lines
    step: float
    low: FloatArray
    high: FloatArray
    torque_min: float
    torque_max: float
    extra: float = 0.0


class States:
    """States of a design by the value of one parameter, each made once.

    Parameters
    ----------
    point : DesignPoint
    name : str
        Of the parameter.
    all_ends : bool
        Whether moved ends of the range count where none that moves has a multiplier.
    """

    def __init__(self, point: DesignPoint, name: str, *, all_ends: bool) -> None:
        self.point, self.name = point, name
        self.reference = point.value(name)
        kkt, problem, objective = point.stationary, point.problem, point.objective
        ends = {"lower": [kkt.lower], "upper": [kkt.upper]}.get(name, [kkt.lower, kkt.upper])
        self._ends_matter = all_ends or any(np.any(end) for end in ends)
        self._frozen = FrozenLines(
            curves=problem.curves,
            profile=point.design.profile,
            point=kkt,
            pitch=point.pitch,
            rotor=None if point.case.table is not None else point.rotor_of(point.held),
        )
        self.start = State(
            lines=self._frozen.own(),
            step=problem.step,
            low=problem.curves.lower,
            high=problem.curves.upper,
            torque_min=objective.torque_min,
            torque_max=objective.torque_max,
        )
        self._known = {self.reference: self.start}

    def at(self, c: float) -> State:
        """The state at a value of the parameter."""
        if c not in self._known:
            self._known[c] = self._made(c)
        return self._known[c]

    def lines(self, c: float) -> Lines:
        """The lines at a value of the parameter, which need nothing else of it to be allowed."""
        if c in self._known:
            return self._known[c].lines
        if self.name != "shear":
            return self.start.lines
        task = self.point.changed("shear", c - self.reference).task
        return self._frozen.of(self.point.rotor_of(task))

    def _made(self, c: float) -> State:
        point, start, change = self.point, self.start, c - self.reference
        if self.name == "mu":
            return replace(start, extra=-change * point.task.weights.weighted(point.design.loads))
        if self.name in ("loss", "torque"):
            objective = point.changed(self.name, change).objective
            return replace(start, torque_min=objective.torque_min, torque_max=objective.torque_max)
        task = point.changed(self.name, change).task
        if self.name == "rate":
            step = task.limits.step(start.low.size)
            if not self._ends_matter:
                return replace(start, step=step)
            low, high = self._raw_ends
            return replace(
                start, step=step, low=lipschitz_lower(low, step), high=lipschitz_upper(high, step)
            )
        low, high = point.ends(task) if self._ends_matter else (start.low, start.high)
        return replace(start, low=low, high=high, lines=self.lines(c))

    @cached_property
    def _raw_ends(self) -> tuple[FloatArray, FloatArray]:
        return self.point.raw_ends(self.point.held)
