"""Minimum of a smooth function of one or two variables in a box, in few evaluations.

Each evaluation is a sized tower, so the search keeps a quadratic model of all that it has seen: a
weighted least-squares fit (weights fall with the squared distance from the best point), minimised
on a grid of 201 points a variable within a trust region and the box.  A step that gains less than
a tenth of what the model promised shrinks the region to half; the search ends when the model
promises less than a tolerance twice in a row, or the region is small.  Of two variables, each has
to have been moved alone from the best point before: a model of points on a diagonal knows little
across it.  What is found is a local minimum as far as these points tell.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from pitchopt.checks import FloatArray, finite_array, finite_number, whole_number
from pitchopt.errors import InputError

__all__ = ["OuterMinimum", "minimise_in_box"]

_SMALLEST_REGION = 0.01  # half-width over the box's
_NEAR = 0.25  # distance at which a point's weight has halved, over the box's half-width
_BESIDE = 0.25  # move of one variable that tests the best point, over the box's half-width
_SAME = 0.05  # and how far the other may be off, or a move fall short


@dataclass(frozen=True, kw_only=True, eq=False)
class OuterMinimum:
    """Where the search ended.

    Attributes
    ----------
    x : ndarray (n,)
    value : float
    points, values : ndarray (E, n), (E,)
        All evaluations in their order.
    iterations : int
        Quadratic models.
    converged : bool
    """

    x: FloatArray
    value: float
    points: FloatArray
    values: FloatArray
    iterations: int
    converged: bool


def minimise_in_box(
    function: Callable[[FloatArray], float],
    start: ArrayLike,
    low: ArrayLike,
    high: ArrayLike,
    *,
    first_steps: ArrayLike,
    tolerance: float = 1e-5,
    evaluations: int = 20,
) -> OuterMinimum:
    """Minimise a function of (n,) variables.

    Parameters
    ----------
    function : callable
        x (n,) -> value.
    start, low, high : array_like (n,)
        Within the box.
    first_steps : array_like (n,)
        Steps of the first design about the start, turned inward at the box; half of the box where
        they are longer.
    tolerance : float
        On the gain a model promises, over the value at the start.
    evaluations : int
        At most, those of the first design included.

    Raises
    ------
    InputError
        If shapes do not fit, the start is outside, a step is not positive, or there are more than
        two variables.
    """
    x0 = finite_array("start", start)
    lower = finite_array("low", low, shape=x0.shape)
    upper = finite_array("high", high, shape=x0.shape)
    steps = finite_array("first_steps", first_steps, shape=x0.shape)
    if x0.size > 2:
        raise InputError(f"start: got {x0.size} variables, expected one or two")
    if np.any(lower >= upper) or np.any(x0 < lower) or np.any(x0 > upper):
        raise InputError(
            f"start: got {x0.tolist()}, expected it between {lower.tolist()} and {upper.tolist()}"
        )
    finite_number("tolerance", tolerance, above=0.0)
    most = whole_number("evaluations", evaluations, at_least=2 * x0.size + 2)
    if steps.min() <= 0.0:
        raise InputError(f"first_steps: got {steps.tolist()}, expected positive numbers")
    half = 0.5 * (upper - lower)
    points = _first_points(x0, lower, upper, np.minimum(steps, half))
    values = [function(point) for point in points]
    region, calm, iterations, converged = 0.5, 0, 0, False
    while len(values) < most:
        iterations += 1
        best = int(np.argmin(values))
        x, model = _model(np.array(points), np.array(values), points[best], half)
        target, promise = _lowest(model, x, np.maximum(lower, x - region * half),
                                  np.minimum(upper, x + region * half), half)  # fmt: skip
        calm = calm + 1 if promise < tolerance * abs(values[0]) else 0
        seen = min(float(np.max(np.abs(target - p) / half)) for p in points)
        if calm == 2 or (calm and seen < _SMALLEST_REGION) or region < _SMALLEST_REGION:
            beside = _untried(np.array(points) / half, best, lower / half, upper / half)
            if beside is None:
                converged = True
                break
            points.append(np.clip(beside * half, lower, upper))
            values.append(function(points[-1]))
            calm, region = 1, max(region, _BESIDE)
            continue
        if seen < _SMALLEST_REGION:
            region *= 0.5
            continue
        points.append(target)
        values.append(function(target))
        if values[best] - values[-1] < 0.1 * promise:
            region *= 0.5
    best = int(np.argmin(values))
    return OuterMinimum(
        x=points[best],
        value=float(values[best]),
        points=np.array(points),
        values=np.array(values),
        iterations=iterations,
        converged=converged,
    )


def _first_points(
    start: FloatArray, low: FloatArray, high: FloatArray, steps: FloatArray
) -> list[FloatArray]:
    """The start, a step along each variable and one back or as far again, and the diagonal."""
    points = [start]
    inward = []
    for i, step in enumerate(steps):
        ahead = step if start[i] + step <= high[i] else -step
        other = -ahead if low[i] <= start[i] - ahead <= high[i] else 0.5 * ahead
        inward.append(ahead)
        for move in (ahead, other):
            point = start.copy()
            point[i] = np.clip(point[i] + move, low[i], high[i])
            points.append(point)
    for i, j in itertools.combinations(range(start.size), 2):
        point = start.copy()
        point[i], point[j] = point[i] + inward[i], point[j] + inward[j]
        points.append(np.clip(point, low, high))
    return points


def _untried(points: FloatArray, best: int, low: FloatArray, high: FloatArray) -> FloatArray | None:
    """The best of the points with one of two variables moved, where no point is like it, or None.

    All in units of the box's half-width.  The move goes where there is more room.
    """
    centre = points[best]
    if centre.size == 1:
        return None
    away = np.abs(points - centre)
    for i in range(centre.size):
        others = np.delete(away, i, axis=1)
        moved = (away[:, i] >= _SAME) & (away[:, i] <= 1.5 * _BESIDE)
        if np.any(moved & np.all(others <= _SAME, axis=1)):
            continue
        point = centre.copy()
        point[i] += _BESIDE if high[i] - centre[i] >= centre[i] - low[i] else -_BESIDE
        return np.asarray(point)
    return None


def _terms(u: FloatArray) -> FloatArray:
    """1, u_i, u_i^2 / 2, u_i u_j of points (E, n)."""
    n = u.shape[1]
    columns = [np.ones(len(u)), *u.T, *(0.5 * u**2).T]
    columns += [u[:, i] * u[:, j] for i, j in itertools.combinations(range(n), 2)]
    return np.stack(columns, axis=1)


def _model(
    points: FloatArray, values: FloatArray, centre: FloatArray, half: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Centre and coefficients of the quadratic about it, in units of the box's half-width."""
    u = (points - centre) / half
    weight = 1.0 / (1.0 + np.sum(u**2, axis=1) / _NEAR**2)
    scaled = weight[:, None] * _terms(u)
    coefficients = np.linalg.lstsq(scaled, weight * (values - values.min()), rcond=None)[0]
    return centre, np.asarray(coefficients)


def _lowest(
    model: FloatArray, centre: FloatArray, low: FloatArray, high: FloatArray, half: FloatArray
) -> tuple[FloatArray, float]:
    """Minimum of the model in a box, on a grid of 201 points a variable, and what it promises."""
    axes = [np.linspace(a, b, 201) for a, b in zip(low, high, strict=True)]
    grid = np.stack([g.ravel() for g in np.meshgrid(*axes, indexing="ij")], axis=1)
    found = _terms((grid - centre) / half) @ model
    here = float(model[0])
    k = int(np.argmin(found))
    return grid[k], here - float(found[k])
