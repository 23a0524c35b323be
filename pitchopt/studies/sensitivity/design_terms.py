"""What each constraint of a design adds to the estimate of a parameter's worth.

At the design the Lagrangian of the design problem (maximise; multipliers 0 or more) is

    L = a T - mu J + ... + sum_i lambda_i (limit_i(c) - g_i(beta*, c)),

and the change of its value with beta* and the multipliers frozen is the estimate of what a change
of c does to the optimal value.  First order takes the derivative at c, high order the values at
c + dc (paper 004, equations (8) and (9)).  Per parameter:

    rate    sum_n (rate_up_n + rate_down_n) dD, D the largest step between stations, and what
            tightened ends move
    lower, upper   sum_n upper_n d high_n - lower_n d low_n; ends where stall limits hold do not move
    mu      -dmu x weighted RMS, the envelope of a function that is convex in mu
    loss, torque   multiplier of the torque limit x its change
    shear   g d torque - sum_l y_l . d load_l on the lines that the profile stands on
            (:mod:`pitchopt.studies.sensitivity.design_lines`), and the ends of stall limits

RMS values are kept as cones s_l >= || load_l || / sqrt(m), with y_l the multiplier of the vector:
where a design holds a load flat its RMS has no gradient, yet y_l is there.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from pitchopt.checks import FloatArray
from pitchopt.design.limits import lipschitz_lower, lipschitz_upper
from pitchopt.studies.sensitivity.design_lines import FrozenLines

if TYPE_CHECKING:
    from pitchopt.studies.sensitivity.design_point import Changed, DesignPoint

__all__ = ["Term", "Terms", "terms"]

_SMALL = 2.0**-8  # of a step, for the derivative


@dataclass(frozen=True, kw_only=True, eq=False)
class Term:
    """What one kind of constraint adds.

    Attributes
    ----------
    name : str
    first, high : float
        First-order and high-order change of the optimal value [N m].
    multiplier : float
        Sum of the multipliers; what it is per, the unit says.
    unit : str
    share : ndarray (N,) or None
        What each station adds to ``high``; None where stations have no part.
    """

    name: str
    first: float
    high: float
    multiplier: float
    unit: str
    share: FloatArray | None = None


@dataclass(frozen=True, kw_only=True, eq=False)
class Terms:
    """All of them for one parameter and step, largest first."""

    parts: tuple[Term, ...]

    @property
    def first(self) -> float:
        """First-order estimate of the change of the optimal value [N m]."""
        return sum((part.first for part in self.parts), 0.0)

    @property
    def high(self) -> float:
        """High-order estimate of it [N m]."""
        return sum((part.high for part in self.parts), 0.0)


def terms(point: DesignPoint, name: str, step: float) -> Terms:
    """Terms of a parameter's estimate.

    Parameters
    ----------
    point : DesignPoint
    name : str
        One of :data:`pitchopt.studies.sensitivity.design_point.PARAMETERS`.
    step : float
        Change of the parameter, in SI and radians.

    Raises
    ------
    InputError
        If the design lacks the parameter or the step leads outside what it allows.
    """
    changed = point.changed(name, step)
    if name == "mu":
        rms = point.task.weights.weighted(point.design.loads)
        parts = [_linear("price of the RMS", -step * rms, -rms, "N m")]
    elif name in ("loss", "torque"):
        parts = [_floor(point, changed)]
    elif name == "rate":
        parts = _rate(point, changed, step)
    elif name in ("lower", "upper"):
        parts = _ends(point, name, step)
    else:
        parts = _shear(point, step)
    parts.sort(key=lambda part: -abs(part.high))
    return Terms(parts=tuple(parts))


def _linear(
    name: str, change: float, multiplier: float, unit: str, share: FloatArray | None = None
) -> Term:
    return Term(
        name=name, first=change, high=change, multiplier=multiplier, unit=unit, share=share
    )


def _floor(point: DesignPoint, changed: Changed) -> Term:
    mult = point.stationary.multipliers
    price = mult.torque_min - mult.torque_max
    change = changed.objective.torque_min - point.objective.torque_min
    return _linear("mean torque", -price * change, price, "-")


def _rate(point: DesignPoint, changed: Changed, step: float) -> list[Term]:
    kkt, stations = point.stationary, point.problem.curves.stations
    per = changed.task.limits.step(stations) - point.task.limits.step(stations)
    price = kkt.rate_up + kkt.rate_down
    parts = [
        _linear(
            "pitch rate", float(price.sum()) * per, float(price.sum()) * per / step, "N m s/rad",
            price * per,
        )
    ]  # fmt: skip
    # the ends of the range that are tightened to what the rate can follow move with it
    if np.any(kkt.lower) or np.any(kkt.upper):
        low, high = point.raw_ends(point.held)
        before = point.task.limits.step(stations)

        def ends(t: float) -> tuple[FloatArray, FloatArray]:
            reach = before + t * per
            return lipschitz_lower(low, reach), lipschitz_upper(high, reach)

        parts += [part for part in _moved(point, ends, step, "range kept by the rate") if part.high]
    return parts


def _ends(point: DesignPoint, name: str, step: float) -> list[Term]:
    kkt = point.stationary
    if not np.any(kkt.lower if name == "lower" else kkt.upper):
        unit = "N m/rad"
        return [_linear("pitch range", 0.0, 0.0, unit, np.zeros(kkt.theta.size))]

    def ends(t: float) -> tuple[FloatArray, FloatArray]:
        return point.ends(point.changed(name, t * step).task)

    return _moved(point, ends, step, "pitch range")


def _moved(
    point: DesignPoint, ends: Callable[[float], tuple[FloatArray, FloatArray]], step: float, name: str
) -> list[Term]:
    """Terms of the ends of the range, for ends as a function of the share of the step."""
    kkt = point.stationary
    low0, high0 = ends(0.0)

    def change(t: float) -> tuple[FloatArray, FloatArray]:
        low, high = ends(t)
        return -kkt.lower * (low - low0), kkt.upper * (high - high0)

    parts = []
    near, far = change(_SMALL), change(1.0)
    for side, first, high in zip(("lower", "upper"), near, far, strict=True):
        if np.any(first) or np.any(high):
            total = float(first.sum()) / _SMALL
            parts.append(
                Term(
                    name=f"{name}, {side} end",
                    first=total,
                    high=float(high.sum()),
                    multiplier=total / step,
                    unit="N m/rad",
                    share=high,
                )
            )
    return parts or [_linear(name, 0.0, 0.0, "N m/rad", np.zeros(kkt.theta.size))]


_LOADS = ("RMS of torque", "RMS of tilt", "RMS of yaw", "RMS of thrust", "RMS of a blade")


def _shear(point: DesignPoint, step: float) -> list[Term]:
    kkt, curves = point.stationary, point.problem.curves
    rotor = point.rotor_of(point.held)
    lines = FrozenLines(
        curves=curves, profile=point.design.profile, point=kkt, pitch=point.pitch, rotor=rotor
    )
    base = lines.loads(rotor)

    def change(t: float) -> FloatArray:
        loads = lines.loads(point.rotor_of(point.changed("shear", t * step).task))
        return np.asarray(loads - base)

    # central where the other side is allowed
    far = change(1.0)
    slope = (change(_SMALL) - change(-_SMALL)) / (2 * _SMALL)
    y, share = kkt.prices, kkt.torque_price / curves.positions
    parts = [
        Term(
            name="mean torque",
            first=share * float(slope[0].sum()),
            high=share * float(far[0].sum()),
            multiplier=kkt.torque_price,
            unit="-",
            share=share * far[0],
        )
    ]
    for k, name in enumerate(_LOADS):
        if np.any(y[k]):
            rows = curves.positions if k < 4 else curves.stations
            parts.append(
                Term(
                    name=name,
                    first=-float(y[k] @ slope[k]),
                    high=-float(y[k] @ far[k]),
                    multiplier=float(np.linalg.norm(y[k][:rows]) * np.sqrt(rows)),
                    unit="m" if k == 3 else "-",
                    share=-y[k] * far[k],
                )
            )
    if np.any(kkt.lower) or np.any(kkt.upper):
        parts += [
            part
            for part in _moved(
                point, lambda t: point.ends(point.changed("shear", t * step).task), step, "stall limits"
            )
            if part.high or part.first
        ]
    return parts
