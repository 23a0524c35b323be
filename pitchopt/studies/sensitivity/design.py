"""What more rate, a wider range, a lower price or another shear would buy a pitch design.

    point = DesignPoint(case=case, task=task, found=compared(task, mu=3.0))
    result = design_sensitivity(point)                 estimates alone, from the multipliers
    result = design_sensitivity(point, truth=True)     beside the design solved again

A change is that of the optimal value, larger is better: of mean torque less mu x weighted RMS for a
design with a price, of minus the weighted RMS (so it is the cut of the RMS) for designs with a
limit on mean torque, where the torque that the cut is worth, at the multiplier of the limit,
stands beside.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pitchopt.checks import FloatArray
from pitchopt.design.task import Progress
from pitchopt.errors import ComputationError, InfeasibleError, InputError, PitchoptError
from pitchopt.sensitivity import Estimate
from pitchopt.studies.sensitivity.design_point import UNITS, DesignPoint
from pitchopt.studies.sensitivity.design_rows import DesignRows, Group
from pitchopt.studies.sensitivity.design_truth import Truth, resolved

__all__ = [
    "DesignCurve",
    "DesignRow",
    "DesignSensitivity",
    "design_curve",
    "design_sensitivity",
]

_SMALLEST = 1e-6  # share of a parameter, below which derivatives would be rounding
_ROUNDING = 3e-8  # share of the largest torque that local solves leave


@dataclass(frozen=True, kw_only=True, eq=False)
class DesignRow:
    """One parameter, changed by one step.

    Attributes
    ----------
    parameter : str
        One of :data:`pitchopt.studies.sensitivity.design_point.PARAMETERS`.
    value, step : float
        Present value and change, in SI and radians.
    estimate : Estimate
        First-order and high-order change of the optimal value [N m], and its assumptions.
    groups : tuple of Group
        Kinds of constraints that carry it, largest first.
    truth : Truth or None
        The design solved again; None where it was not asked for or there is none.
    message : str
        Why there is no truth, where there is none.
    """

    parameter: str
    value: float
    step: float
    estimate: Estimate
    groups: tuple[Group, ...]
    truth: Truth | None = None
    message: str = ""

    @property
    def first(self) -> float:
        """First-order estimate of the change of the optimal value [N m]."""
        return self.estimate.first_order

    @property
    def high(self) -> float:
        """High-order estimate of it [N m]."""
        return self.estimate.high_order

    @property
    def errors(self) -> tuple[float, float] | None:
        """First-order and high-order estimate less the truth [N m]; None without a truth."""
        if self.truth is None:
            return None
        return self.first - self.truth.change, self.high - self.truth.change


@dataclass(frozen=True, kw_only=True, eq=False)
class DesignSensitivity:
    """Estimates for all parameters of a design.

    Attributes
    ----------
    point : DesignPoint
    rows : tuple of DesignRow
    skipped : tuple of (str, str)
        Parameters whose default step is not allowed, and why.
    """

    point: DesignPoint
    rows: tuple[DesignRow, ...]
    skipped: tuple[tuple[str, str], ...] = ()

    @property
    def scale(self) -> float:
        """What changes are counted in: largest torque, or the weighted RMS [N m]."""
        if self.point.by_torque:
            return self.point.largest_torque
        return max(self.point.design.rms_weighted, 1e-6 * self.point.largest_torque)

    @property
    def resolution(self) -> float:
        """Changes below this are what local solves leave [N m]."""
        return (_ROUNDING if self.point.by_torque else 1e-6) * self.scale


@dataclass(frozen=True, kw_only=True, eq=False)
class DesignCurve:
    """Estimates and truth over a range of one parameter.

    Attributes
    ----------
    parameter : str
    dc : ndarray (K,)
        Changes, zero among them, in SI and radians.
    first_order, high_order, truth : ndarray (K,)
        Changes of the optimal value [N m]; NaN where the parameter allows none.
    other : bool ndarray (K,)
        Where the best optimum is another one than that which the design moves to.
    """

    parameter: str
    dc: FloatArray
    first_order: FloatArray
    high_order: FloatArray
    truth: FloatArray
    other: NDArray[np.bool_]

    @property
    def name(self) -> str:
        """The parameter."""
        return self.parameter


def design_sensitivity(
    point: DesignPoint,
    steps: Mapping[str, float] | None = None,
    *,
    truth: bool = False,
    judged: bool | None = None,
    starts: int = 5,
    seed: int = 0,
    progress: Progress | None = None,
) -> DesignSensitivity:
    """Estimate what changed parameters would do, and solve the design again if wanted.

    Parameters
    ----------
    point : DesignPoint
    steps : mapping of str to float, optional
        Changes by parameter in SI and radians, in place of the default ones.
    truth : bool
        Whether to solve the design again for every change.
    judged : bool, optional
        Whether to judge the assumptions of the estimates; as ``truth`` by default.
    starts, seed
        Of the search for the truth, as in :func:`pitchopt.design.compared`.
    progress : callable, optional

    Raises
    ------
    InputError
        If the design lacks a parameter that has a step, or the step is not allowed or leaves
        no profile.
    """
    given = dict(steps or {})
    for name, step in given.items():
        point.require(name)
        value, (words, unit, factor) = point.value(name), UNITS[name]
        if abs(step) <= _SMALLEST * max(abs(value), 1e-3):
            raise InputError(
                f"step of the {words}: got {factor * step:g}, expected a change of more than a "
                f"millionth of {factor * value:.6g}" + ("" if unit == "-" else f" {unit}")
            )
        try:
            point.changed(name, step)
        except InfeasibleError as error:
            raise InputError(str(error)) from error
    names = point.parameters
    rows, skipped = [], []
    for count, name in enumerate(names):
        if progress is not None:
            progress(count, len(names), name)
        step = given.get(name, point.default_step(name))
        try:
            rows.append(
                _row(point, name, step, truth, truth if judged is None else judged, starts, seed)
            )
        except (InputError, InfeasibleError) as error:
            if name in given:
                raise InputError(f"{UNITS[name][0]}: {error}") from error
            skipped.append((name, " ".join(str(error).split())))
    if progress is not None:
        progress(len(names), len(names), "done")
    return DesignSensitivity(point=point, rows=tuple(rows), skipped=tuple(skipped))


def _row(
    point: DesignPoint, name: str, step: float, truth: bool, judged: bool, starts: int, seed: int
) -> DesignRow:
    rows = DesignRows(point, name, step, judged=judged)
    estimate = rows.estimate()
    found = None
    if truth:
        found = resolved(point, point.changed(name, step), starts=starts, seed=seed)
    return DesignRow(
        parameter=name,
        value=point.value(name),
        step=step,
        estimate=estimate,
        groups=rows.groups(estimate),
        truth=found,
    )


def design_curve(
    point: DesignPoint,
    name: str,
    step: float,
    count: int,
    *,
    starts: int = 2,
    seed: int = 0,
    progress: Progress | None = None,
) -> DesignCurve:
    """Estimates and truth over a range of a parameter, ``count`` steps to either side.

    Every change is solved from the design, from the profile of the next smaller change and from the
    usual starts.  Changes that are not allowed or leave no profile are NaN.

    Parameters
    ----------
    point, name, step
        As in :class:`pitchopt.studies.sensitivity.design_rows.DesignRows`.
    count : int
        Steps to either side.
    starts, seed
        Of the search for the truth.
    progress : callable, optional
        Told the number of changes done.
    """
    shape = 2 * count + 1
    first, high, truth = (np.full(shape, np.nan) for _ in range(3))
    other = np.zeros(shape, dtype=bool)
    first[count] = high[count] = truth[count] = 0.0
    done = 0
    for sign in (1, -1):
        warm, rows = None, None
        for k in range(1, count + 1):
            change, at = sign * k * step, count + sign * k
            done += 1
            if progress is not None:
                progress(done, 2 * count, name)
            try:
                changed = point.changed(name, change)
                if rows is None:
                    rows = DesignRows(point, name, change, judged=False)
                estimate = rows.estimate(change)
            except PitchoptError:
                break
            first[at], high[at] = estimate.first_order, estimate.high_order
            try:
                found = resolved(point, changed, starts=starts, seed=seed, warm=warm)
            except (InfeasibleError, InputError, ComputationError):
                continue
            truth[at], other[at], warm = found.change, found.other, found.profile
    return DesignCurve(
        parameter=name,
        dc=np.asarray(step * np.arange(-count, count + 1), dtype=np.float64),
        first_order=first,
        high_order=high,
        truth=truth,
        other=other,
    )


def where(share: FloatArray, azimuth: FloatArray) -> Sequence[tuple[float, float]]:
    """Runs of azimuth [rad] in which stations carry an estimate, the heaviest first.

    Parameters
    ----------
    share : ndarray (N,)
        What stations add.
    azimuth : ndarray (N,)
        [rad].

    Returns
    -------
    sequence of (float, float)
        First and last azimuth of each run; a run over the wrap has the larger first.
    """
    size = np.abs(share)
    on = size > 0.01 * float(size.max(initial=0.0))
    if not np.any(on):
        return []
    if np.all(on):
        return [(float(azimuth[0]), float(azimuth[-1]))]
    n = share.size
    begins = np.flatnonzero(on & ~np.roll(on, 1))
    runs = []
    for begin in begins:
        length = 1
        while on[(begin + length) % n]:
            length += 1
        rows = (begin + np.arange(length)) % n
        runs.append((float(size[rows].sum()), float(azimuth[rows[0]]), float(azimuth[rows[-1]])))
    runs.sort(key=lambda run: -run[0])
    return [(first, last) for _, first, last in runs]
