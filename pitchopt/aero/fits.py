"""Best concave fit of lift and convex fit of drag, piecewise linear on uniform knots.

For d segments between two angle-of-attack limits the values v at the d + 1 knots solve

    minimise  max |A v - c|    subject to  second differences of v <= 0  (>= 0 for drag),

where A evaluates the fit at the union of knots and table rows.  Polar and fit are both linear
between those points, so the maximum over them is the largest error over the whole interval:
the reported error is exact, not sampled.  Among all fits within `SLACK` of that least largest
error the one with the least mean error (integral of |error|) is taken.  It is a fit from both
sides, not an envelope, so it does not inflate lift.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property, lru_cache
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from pitchopt.aero.polars import Polar
from pitchopt.checks import FloatArray, finite_array, finite_number
from pitchopt.errors import ComputationError, InputError

__all__ = ["SLACK", "PolarFit", "fit_polar"]

SLACK = 0.05
"""Share by which the largest error may exceed its least value to lower the mean error."""


@dataclass(frozen=True, kw_only=True, eq=False)
class PolarFit:
    """Concave Cl, convex Cd and straight Cm on d + 1 uniform knots.

    The moment coefficient adds to the torque of a coned rotor with either sign, so only a
    straight line (least squares) keeps the torque concave.

    Attributes
    ----------
    name : str
        Airfoil.
    alpha : ndarray (d + 1,)
        Knots [rad]; first and last are the limits of the fit.
    cl, cd, cm : ndarray (d + 1,)
        Values at the knots [-].  Cl is concave, Cd convex.
    cl_error, cd_error, cm_error : float
        Largest deviation from the table over the whole interval [-].
    cl_mean_error, cd_mean_error : float
        Mean absolute deviation over the interval [-].
    """

    name: str = ""
    alpha: FloatArray
    cl: FloatArray
    cd: FloatArray
    cm: FloatArray
    cl_error: float
    cd_error: float
    cm_error: float = 0.0
    cl_mean_error: float = 0.0
    cd_mean_error: float = 0.0

    def __post_init__(self) -> None:
        alpha = finite_array("fit.alpha", self.alpha)
        if alpha.size < 2 or np.any(np.diff(alpha) <= 0.0):
            raise InputError("fit.alpha: expected at least 2 strictly increasing knots")
        if not np.allclose(np.diff(alpha, 2), 0.0, atol=1e-9):
            raise InputError("fit.alpha: knots must be evenly spaced")
        object.__setattr__(self, "alpha", alpha)
        for key in ("cl", "cd", "cm"):
            array = finite_array(f"fit.{key}", getattr(self, key), shape=alpha.shape)
            object.__setattr__(self, key, array)

    @property
    def limits(self) -> tuple[float, float]:
        """Angle-of-attack limits [rad]."""
        return float(self.alpha[0]), float(self.alpha[-1])

    @cached_property
    def pieces(self) -> FloatArray:
        """Slopes of Cl, Cd, Cm on the d segments, (3, d) [1/rad]."""
        return np.asarray(np.diff([self.cl, self.cd, self.cm], axis=1) / np.diff(self.alpha))

    def coefficients(self, alpha: ArrayLike) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Cl, Cd, Cm of the fit at angles of any shape [rad].

        Outside the limits the end segments are continued.
        """
        x = np.asarray(alpha, dtype=np.float64)
        step = (self.alpha[-1] - self.alpha[0]) / (self.alpha.size - 1)
        index = ((x - self.alpha[0]) / step).astype(np.intp)
        index = np.clip(index, 0, self.alpha.size - 2)
        rest = x - self.alpha[index]
        cl, cd, cm = (
            values[index] + slopes[index] * rest
            for values, slopes in zip((self.cl, self.cd, self.cm), self.pieces, strict=True)
        )
        return cl, cd, cm


def fit_polar(polar: Polar, alpha_limits: tuple[float, float], segments: int = 40) -> PolarFit:
    """Fit a polar between two angles of attack.

    Parameters
    ----------
    polar : Polar
        Table to fit.
    alpha_limits : (float, float)
        Lower and upper angle of attack [rad].
    segments : int
        Number of linear pieces d, at least 1.

    Returns
    -------
    PolarFit

    Raises
    ------
    InputError
        If the limits cross or the polar does not cover them.
    """
    low = finite_number("alpha_limits[0]", alpha_limits[0])
    high = finite_number("alpha_limits[1]", alpha_limits[1])
    if not low < high:
        raise InputError(f"alpha_limits: got {low} and {high} rad, the first must be the smaller")
    if isinstance(segments, bool) or int(segments) != segments or segments < 1:
        raise InputError(f"segments: got {segments!r}, expected a whole number of at least 1")
    if low < polar.alpha[0] - 1e-12 or high > polar.alpha[-1] + 1e-12:
        first, last = np.rad2deg(polar.alpha[[0, -1]])
        raise InputError(
            f"alpha_limits: polar {polar.name!r} covers {first:.2f} to {last:.2f} degrees, not the "
            f"{np.rad2deg(low):.2f} to {np.rad2deg(high):.2f} degrees asked for"
        )
    return _fit_cached(polar, low, high, int(segments))


@lru_cache(maxsize=512)
def _fit_cached(polar: Polar, low: float, high: float, segments: int) -> PolarFit:
    knots = np.linspace(low, high, segments + 1)
    rows = polar.alpha[(polar.alpha > low) & (polar.alpha < high)]
    points = np.union1d(knots, rows)
    matrix = _interpolation_matrix(points, knots)
    cl_table, cd_table, cm_table = polar.coefficients(points)
    cl = _shape_fit(matrix, points, cl_table, concave=True)
    cd = _shape_fit(matrix, points, cd_table, concave=False)
    line = np.polynomial.Polynomial.fit(points, cm_table, 1, w=np.sqrt(_trapezoid(points)))
    cm = np.asarray(line(knots))
    cl_dev, cd_dev = np.abs(matrix @ cl - cl_table), np.abs(matrix @ cd - cd_table)
    weight = _trapezoid(points) / (high - low)
    return PolarFit(
        name=polar.name,
        alpha=knots,
        cl=cl,
        cd=cd,
        cm=cm,
        cl_error=float(cl_dev.max()),
        cd_error=float(cd_dev.max()),
        cm_error=float(np.abs(matrix @ cm - cm_table).max()),
        cl_mean_error=float(weight @ cl_dev),
        cd_mean_error=float(weight @ cd_dev),
    )


def _interpolation_matrix(points: FloatArray, knots: FloatArray) -> FloatArray:
    """Rows that evaluate a piecewise-linear function on `knots` at `points`, (P, d + 1)."""
    index = np.clip(np.searchsorted(knots, points, side="right") - 1, 0, knots.size - 2)
    share = (points - knots[index]) / (knots[index + 1] - knots[index])
    matrix = np.zeros((points.size, knots.size))
    row = np.arange(points.size)
    matrix[row, index] = 1.0 - share
    matrix[row, index + 1] = share
    return matrix


def _trapezoid(points: FloatArray) -> FloatArray:
    weight = np.zeros(points.size)
    gaps = np.diff(points)
    weight[:-1] += gaps / 2
    weight[1:] += gaps / 2
    return weight


def _shape_fit(
    matrix: FloatArray, points: FloatArray, table: FloatArray, *, concave: bool
) -> FloatArray:
    """Knot values (d + 1,) of the fit, found for a concave function (convex by reflection)."""
    import scipy.optimize  # heavy imports, only needed here
    import scipy.sparse

    linprog: Any = scipy.optimize.linprog
    sparse: Any = scipy.sparse
    sign = 1.0 if concave else -1.0
    target = sign * table
    samples, unknowns = matrix.shape
    # unknowns are the first value, the first increment and the decreases of the increments,
    # all of the latter >= 0: concavity is a bound and holds without solver tolerance
    position = np.arange(unknowns, dtype=np.float64)
    basis = np.zeros((unknowns, unknowns))
    basis[:, 0] = 1.0
    basis[:, 1] = position
    for k in range(2, unknowns):
        basis[:, k] = -np.maximum(position - (k - 1), 0.0)
    reduced = sparse.csr_array(matrix @ basis)
    shape_bounds = [(None, None)] * min(2, unknowns) + [(0.0, None)] * max(0, unknowns - 2)
    ones = sparse.csr_array(np.ones((samples, 1)))
    cost = np.zeros(unknowns + 1)
    cost[-1] = 1.0
    largest = linprog(
        cost,
        A_ub=sparse.vstack(
            [sparse.hstack([reduced, -ones]), sparse.hstack([-reduced, -ones])]
        ).tocsc(),
        b_ub=np.concatenate([target, -target]),
        bounds=[*shape_bounds, (0.0, None)],
        method="highs",
    )
    if largest.status != 0:
        raise ComputationError(f"polar fit: the linear program failed: {largest.message}")
    cap = (1.0 + SLACK) * float(largest.x[-1]) + 1e-9
    identity = sparse.eye_array(samples)
    mean = linprog(
        np.concatenate([np.zeros(unknowns), _trapezoid(points)]),
        A_ub=sparse.vstack(
            [sparse.hstack([reduced, -identity]), sparse.hstack([-reduced, -identity])]
        ).tocsc(),
        b_ub=np.concatenate([target, -target]),
        bounds=[*shape_bounds, *([(0.0, cap)] * samples)],
        method="highs",
    )
    solution = mean.x[:unknowns] if mean.status == 0 else largest.x[:unknowns]
    solution[2:] = np.maximum(solution[2:], 0.0)
    return np.asarray(sign * (basis @ solution))
