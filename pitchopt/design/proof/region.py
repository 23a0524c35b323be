"""Parts of the design space, and what may be cut off them without losing a good profile.

A region holds an interval of pitch for each station, an interval for the mean of each rotor load
and an upper limit for each RMS.  Two steps make it smaller.  Both keep every feasible profile
inside it whose objective is at least the ``cut``.

:func:`tightened` needs no multipliers.  With zero-sum deviations of RMS at most r, no position is
further than sqrt(m - 1) r from the mean, and sum_l lambda_l J_l <= a T - cut.  So the loads of
each position lie in known intervals, each a sum of three curves, and the scan and the interval
Newton step of :mod:`pitchopt.design.proof.kernels` narrow the pitches; rate limits, means and RMS
follow.

:func:`dual_step` evaluates the bound of :mod:`pitchopt.design.certificate` on the region,

    UB = sum_n max over beta in [lo_n, hi_n] of bracket_n(beta) + constants
         + sum_l max(g_l mean_low_l, g_l mean_high_l),

where g_l, the multipliers of the intervals of the means, join y_l as g_l / m.  A profile worth
the cut cannot lose more than UB - cut anywhere:

    bracket_n(beta_n) >= max bracket_n - (UB - cut)                        at every station,
    (lambda_l - sqrt(m) ||y_l||) J_l <= UB - cut                           for every load,
    g_l mean_l >= max(g_l mean_low_l, g_l mean_high_l) - (UB - cut).

The last two hold because both terms were replaced by their largest values in UB.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from pitchopt.design.certificate import (
    constant_terms,
    linear_terms,
    projected,
    rounding,
    station_weights,
)
from pitchopt.design.limits import lipschitz_lower, lipschitz_upper
from pitchopt.design.multipliers import Multipliers
from pitchopt.design.problem import DesignProblem, Objective

__all__ = ["Frame", "Region", "dual_step", "tightened"]

FloatArray = NDArray[np.float64]

_EPS = float(np.finfo(np.float64).eps)
_ROUNDING = 64.0 * _EPS
_PITCH_PAD = 1e-14  # [rad]; interpolated pitches are off by less
_SETTLED = 0.95  # passes end when one leaves this share of the widths


@dataclass(frozen=True, kw_only=True, eq=False)
class Region:
    """A part of the design space.

    Attributes
    ----------
    lower, upper : ndarray (N,)
        Interval of pitch at each station [rad].
    means : ndarray (4, 2)
        Lowest and highest mean of torque, tilt, yaw [N m] and thrust [N].
    rms : ndarray (4,)
        Upper limits of their RMS values; infinite where nothing is known.
    """

    lower: FloatArray
    upper: FloatArray
    means: FloatArray
    rms: FloatArray

    @property
    def widths(self) -> FloatArray:
        """Width of the pitch intervals [rad], shape (N,)."""
        return np.asarray(self.upper - self.lower)

    @property
    def empty(self) -> bool:
        """True when some interval is reversed."""
        return bool(np.any(self.lower > self.upper) or np.any(self.means[:, 0] > self.means[:, 1]))

    @property
    def size(self) -> float:
        """Sum of the squared widths [rad^2]: what the hull's gap grows with."""
        return float(np.sum(self.widths**2))

    def contains(self, profile: FloatArray) -> bool:
        """True when the pitches lie in their intervals."""
        return bool(np.all(profile >= self.lower) and np.all(profile <= self.upper))


class Frame:
    """What all regions of one problem share.

    Parameters
    ----------
    problem : DesignProblem
    objective : Objective
        Its limits on mean torque become the first region's; what remains is without them.
    """

    def __init__(self, problem: DesignProblem, objective: Objective) -> None:
        self.problem = problem
        self.given = objective
        self.objective = replace(objective, torque_min=-np.inf, torque_max=np.inf)
        curves = problem.curves
        self.beta = np.ascontiguousarray(curves.beta)
        self.loads = np.ascontiguousarray(curves.loads)
        self.stations, self.positions, self.blades = (
            curves.stations,
            curves.positions,
            curves.blades,
        )
        self.largest = np.max(np.abs(self.loads), axis=2)  # (5, N)
        self.reach = np.maximum(np.abs(curves.lower), np.abs(curves.upper))
        self.lambdas = self.objective.lambdas
        # pitch-rate terms of a station: its own coefficient times the neighbours' pitch
        neighbours = np.roll(self.reach, 1) + np.roll(self.reach, -1)
        turning = np.abs(curves.rates[:4]) * neighbours / (2 * curves.spacing)
        sizes = self.largest[:4] + turning
        self.pads = _ROUNDING * self.blades * sizes.max(axis=1)

    @cached_property
    def axes(self) -> tuple[FloatArray, FloatArray]:
        """Components of the moment about each blade's axis: -sin psi and cos psi, (3, m)."""
        psi = self.problem.curves.azimuth.reshape(self.blades, self.positions)
        return -np.sin(psi), np.cos(psi)

    @cached_property
    def without(self) -> FloatArray:
        """Moment of each station about the axis of blade l of its position, (3, N, K)."""
        out = np.empty((3, *self.beta.shape))
        for blade in range(3):
            p, q = (np.tile(part[blade], self.blades)[:, None] for part in self.axes)
            out[blade] = p * self.loads[1] + q * self.loads[2]
        return out

    def first(self) -> Region:
        """The region of all profiles that keep range, stall and torque limits."""
        from pitchopt.design.proof import kernels

        curves = self.problem.curves
        means = np.empty((4, 2))
        spans = kernels.ranges(self.beta, self.loads[:4], curves.lower, curves.upper)
        rates = _rate_ranges(self, curves.lower, curves.upper)
        means[:] = (spans + rates).sum(axis=1) / self.positions
        means += np.array([-1.0, 1.0]) * self.pads[:, None]
        means[0, 0] = max(means[0, 0], self.given.torque_min)
        means[0, 1] = min(means[0, 1], self.given.torque_max)
        return Region(
            lower=np.array(curves.lower),
            upper=np.array(curves.upper),
            means=means,
            rms=np.full(4, np.inf),
        )

    def coefficients(self, mult: Multipliers) -> FloatArray:
        """What multiplies pitch and the five loads in the brackets of the bound, (6, N)."""
        out = np.empty((6, self.stations))
        out[0] = linear_terms(self.problem, self.objective, mult)
        out[1:] = -station_weights(self.problem, mult)
        out[1] += self.objective.torque / self.positions
        return out

    def prepared(self, mult: Multipliers) -> Multipliers:
        """The multipliers made to satisfy the conditions of the bound on a region."""
        return replace(projected(self.problem, self.objective, mult), box=mult.box)


def _over(value: float, weights: FloatArray) -> FloatArray:
    """The value over each weight; infinite where that is zero."""
    return np.where(weights > 0, value / np.where(weights > 0, weights, 1.0), np.inf)


def _rate_ranges(frame: Frame, lower: FloatArray, upper: FloatArray) -> FloatArray:
    """Range of the pitch-rate terms of the four rotor loads at each station, (4, N, 2)."""
    curves = frame.problem.curves
    rates = curves.rates[:4]
    out = np.zeros((*rates.shape, 2))
    if not np.any(rates):
        return out
    most = 2 * frame.problem.step
    fall = np.maximum(np.roll(lower, -1) - np.roll(upper, 1), -most) / (2 * curves.spacing)
    rise = np.minimum(np.roll(upper, -1) - np.roll(lower, 1), most) / (2 * curves.spacing)
    out[..., 0] = np.minimum(rates * fall, rates * rise)
    out[..., 1] = np.maximum(rates * fall, rates * rise)
    return out


def _position_ranges(
    frame: Frame, region: Region, room: float
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Intervals of the static loads at each position: (4, m, 2), and spreads (4,), totals.

    ``room`` is a T_high - cut, the most that the weighted RMS values can cost.
    """
    m = frame.positions
    per_weight = spread = np.zeros(4)
    if m > 1:
        per_weight = np.sqrt(m - 1) * _over(room, frame.lambdas[:4])
        spread = np.minimum(np.sqrt(m - 1) * region.rms, per_weight)
    rates = _rate_ranges(frame, region.lower, region.upper)
    rates = rates.reshape(4, frame.blades, m, 2).sum(axis=1)
    out = np.empty((4, m, 2))
    out[..., 0] = (region.means[:, 0] - spread - frame.pads)[:, None] - rates[..., 1]
    out[..., 1] = (region.means[:, 1] + spread + frame.pads)[:, None] - rates[..., 0]
    return out, spread, per_weight


def _turned_ranges(
    frame: Frame, ranges: FloatArray, spread: FloatArray, per_weight: FloatArray
) -> FloatArray:
    """Intervals of the moment about each blade's axis at each position, (3, m, 2).

    The deviations of tilt and yaw share what the weighted RMS may cost: with weights p and q they
    add at most max(|p| s_tilt, |q| s_yaw), s the most that each could have alone.
    """
    p, q = frame.axes
    tilt, yaw = ranges[1], ranges[2]
    with np.errstate(invalid="ignore"):
        low = np.minimum(p * tilt[:, 0], p * tilt[:, 1]) + np.minimum(q * yaw[:, 0], q * yaw[:, 1])
        high = np.maximum(p * tilt[:, 0], p * tilt[:, 1]) + np.maximum(q * yaw[:, 0], q * yaw[:, 1])
    if np.all(np.isfinite(per_weight[1:3])):
        shared = np.maximum(np.abs(p) * per_weight[1], np.abs(q) * per_weight[2])
        apart = np.abs(p) * spread[1] + np.abs(q) * spread[2]
        saved = np.maximum(apart - shared, 0.0)
        low, high = low + saved, high - saved
    low, high = np.where(np.isnan(low), -np.inf, low), np.where(np.isnan(high), np.inf, high)
    return np.stack([low, high], axis=-1)


def tightened(
    frame: Frame, region: Region, cut: float, *, passes: int = 6, slices: int = 16
) -> Region | None:
    """A smaller region without multipliers, or None when no profile is worth the cut.

    Parameters
    ----------
    frame : Frame
    region : Region
    cut : float
        Objective below which profiles may be lost [N m].
    passes : int
        At most so many rounds over all positions.
    slices : int
        Slices of each interval in the scan.
    """
    from pitchopt.design.proof import kernels

    if not np.isfinite(cut) or passes < 1 or slices < 1:
        return region
    step, m = frame.problem.step, frame.positions
    lower, upper, means, rms = region.lower, region.upper, region.means, region.rms
    for _ in range(passes):
        room = frame.objective.torque * means[0, 1] - cut
        room += _ROUNDING * (abs(frame.objective.torque * means[0, 1]) + abs(cut))
        if room < 0:
            return None
        rms = np.minimum(rms, _over(room, frame.lambdas[:4]))
        before = float(np.sum(upper - lower))
        now = Region(lower=lower, upper=upper, means=means, rms=rms)
        ranges, spread, per_weight = _position_ranges(frame, now, room)
        low, high = np.ascontiguousarray(ranges[..., 0]), np.ascontiguousarray(ranges[..., 1])
        if frame.blades == 3:
            turned = _turned_ranges(frame, ranges, spread, per_weight)
            lower, upper, empty = kernels.triple_scan(
                frame.beta,
                frame.loads[0],
                frame.loads[3],
                frame.without,
                lower,
                upper,
                low,
                high,
                np.ascontiguousarray(turned[..., 0]),
                np.ascontiguousarray(turned[..., 1]),
                slices,
            )
            if empty:
                return None
        lower, upper = kernels.newton_pass(
            frame.beta, frame.loads[:4], lower, upper, low, high, _ROUNDING
        )
        lower, upper = _within(frame, region, lower, upper, step)
        if np.any(lower > upper):
            return None
        spans = kernels.ranges(frame.beta, frame.loads[:4], lower, upper)
        spans = (spans + _rate_ranges(frame, lower, upper)).sum(axis=1) / m
        means = np.stack(
            [
                np.maximum(means[:, 0], spans[:, 0] - frame.pads),
                np.minimum(means[:, 1], spans[:, 1] + frame.pads),
            ],
            axis=1,
        )
        if np.any(means[:, 0] > means[:, 1]):
            return None
        if float(np.sum(upper - lower)) > _SETTLED * before:
            break
    return Region(lower=lower, upper=upper, means=means, rms=rms)


def _within(
    frame: Frame, region: Region, lower: FloatArray, upper: FloatArray, step: float
) -> tuple[FloatArray, FloatArray]:
    """New ends moved outward by rounding, inside the old ones, and as the rate allows."""
    pad = _PITCH_PAD + _ROUNDING * frame.reach
    step = step + 4 * _PITCH_PAD
    lower = np.maximum(lower - pad, region.lower)
    upper = np.minimum(upper + pad, region.upper)
    if np.any(lower > upper):
        return lower, upper
    return lipschitz_lower(lower, step), lipschitz_upper(upper, step)


@np.errstate(over="ignore", invalid="ignore")  # what is not finite proves nothing
def dual_step(
    frame: Frame, region: Region, mult: Multipliers, cut: float
) -> tuple[float, Region | None]:
    """Upper bound on the objective inside a region, and the region that it leaves.

    Parameters
    ----------
    mult : Multipliers
        Any numbers; they are made to satisfy the conditions of the bound first.
    cut : float
        Objective below which profiles may be lost [N m].

    Returns
    -------
    bound : float
        Rounded outward [N m].
    region : Region or None
        None when the bound is below the cut, or no profile is left.
    """
    from pitchopt.design.proof import kernels

    if not mult.finite:
        return np.inf, region
    mult = frame.prepared(mult)
    coefficients = frame.coefficients(mult)
    maxima = kernels.linear_maxima(
        frame.beta, frame.loads, coefficients, region.lower, region.upper
    )
    support = np.maximum(mult.box * region.means[:, 0], mult.box * region.means[:, 1])
    constants = np.concatenate([constant_terms(frame.problem, frame.objective, mult), support])
    margin = rounding(frame.problem, frame.objective, mult, constants)
    bound = float(np.sum(maxima) + np.sum(constants)) + margin
    if not np.isfinite(bound):
        return np.inf, region
    if bound < cut:
        return bound, None
    slack = bound - cut + margin
    lower, upper = kernels.level_hulls(
        frame.beta, frame.loads, coefficients, region.lower, region.upper, maxima - slack
    )
    lower, upper = _within(frame, region, lower, upper, frame.problem.step)
    if np.any(lower > upper):
        return bound, None
    m = frame.positions
    spare = frame.lambdas[:4] - np.sqrt(m) * np.linalg.norm(mult.loads, axis=1)
    rms = _over(slack, np.where(spare > 1e-6 * frame.lambdas[:4], spare, 0.0))
    reach = _over(slack, np.abs(mult.box))
    means = np.stack(
        [
            np.where(mult.box > 0, region.means[:, 1] - reach, -np.inf) - frame.pads,
            np.where(mult.box < 0, region.means[:, 0] + reach, np.inf) + frame.pads,
        ],
        axis=1,
    )
    means = np.stack(
        [np.maximum(means[:, 0], region.means[:, 0]), np.minimum(means[:, 1], region.means[:, 1])],
        axis=1,
    )
    return bound, Region(
        lower=lower, upper=upper, means=means, rms=np.minimum(region.rms, np.maximum(rms, 0.0))
    )
