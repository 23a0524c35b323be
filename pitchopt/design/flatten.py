"""Profiles that flatten torque, tilt and yaw exactly: starts that no constant pitch reaches.

With three blades, each rotor position has three pitch angles and three equations,

    torque(k) = T,   tilt(k) = M_tilt,   yaw(k) = M_yaw,

for any wanted means (T, M_tilt, M_yaw).  Newton's method marches over the positions for a whole
grid of means at once, each position starting from its neighbour's solution; pitch is kept
inside its limits on the way.  What is left is the variation of thrust, the rate limit, and
means that cannot be met; the true objective of the repaired profiles judges which to use.
"""

from __future__ import annotations

from itertools import product

import numpy as np
from numpy.typing import NDArray

from pitchopt.design.problem import DesignProblem

__all__ = ["flattened"]

FloatArray = NDArray[np.float64]

_LOSSES = (0.003, 0.01, 0.02, 0.03, 0.045, 0.065, 0.09)
_SHARES = (-0.12, -0.07, -0.03, 0.0, 0.03, 0.07, 0.12)  # of torque, added to constant pitch's mean
_STEPS = 6


def flattened(problem: DesignProblem, pitch: float) -> FloatArray:
    """Repaired profiles that flatten torque, tilt and yaw for a grid of means.

    Parameters
    ----------
    problem : DesignProblem
        With three blades.
    pitch : float
        The constant pitch of largest torque [rad]: means are counted from its loads.  Torque can
        be given up towards feather or towards stall, and both sides are tried.

    Returns
    -------
    ndarray (G, N)
        Empty for another number of blades or for a frozen wake, whose mean pitch is fixed.
    """
    curves = problem.curves
    if curves.blades != 3 or curves.mean_pitch is not None or problem.constant_only:
        return np.empty((0, curves.stations))
    mean = curves.evaluate(np.full(curves.stations, pitch)).mean
    torque = mean[0]
    targets = np.array(
        [
            (torque * (1 - loss), mean[1] + torque * tilt, mean[2] + torque * yaw)
            for loss, tilt, yaw in product(_LOSSES, _SHARES, _SHARES)
        ]
    )
    low, high = problem.constant_range
    sides = [_march(problem, targets, end, pitch) for end in (low, high) if end != pitch]
    return np.stack([problem.repaired(profile) for profile in np.concatenate(sides)])


def _march(problem: DesignProblem, targets: FloatArray, end: float, pitch: float) -> FloatArray:
    """Profiles (G, N) from constant pitches between the best one and one end of the range."""
    curves, m = problem.curves, problem.curves.positions
    grid = np.linspace(pitch, end, 60)
    torque = np.minimum.accumulate(curves.evaluate_constant(grid)[0][:, 0].mean(axis=1))
    beta = np.interp(-targets[:, 0], -torque, grid)[:, None] * np.ones(3)
    profiles = np.empty((targets.shape[0], curves.stations))
    for k in [*range(m), *range(m)]:  # the second turn starts every position from a solution
        stations = k + m * np.arange(3)
        if k == 0:  # a passage later each blade stands where the next one stood
            beta = beta[:, [2, 0, 1]]
        beta = _newton(problem, stations, beta, targets)
        profiles[:, stations] = beta
    return profiles


def _newton(
    problem: DesignProblem, stations: NDArray[np.intp], beta: FloatArray, targets: FloatArray
) -> FloatArray:
    """Damped Newton steps on one rotor position for all targets, pitch (G, 3)."""
    curves = problem.curves
    low, high = curves.lower[stations], curves.upper[stations]
    reach = np.radians(2.0)
    last = curves.beta.shape[1] - 2
    beta = np.clip(beta, low, high)
    for _ in range(_STEPS):
        jacobian = np.empty((beta.shape[0], 3, 3))
        residual = -targets.copy()
        for b, n in enumerate(stations):
            knots = curves.beta[n]
            j = np.clip(np.searchsorted(knots, beta[:, b], side="right") - 1, 0, last)
            slope = curves.slopes[:3, n, j]
            jacobian[:, :, b] = slope.T
            residual += (curves.loads[:3, n, j] + slope * (beta[:, b] - knots[j])).T
        scale = np.abs(jacobian).max(axis=(1, 2), keepdims=True) + 1e-300
        normal = np.swapaxes(jacobian, 1, 2) @ jacobian / scale**2 + 1e-6 * np.eye(3)
        gradient = np.swapaxes(jacobian, 1, 2) @ residual[:, :, None] / scale**2
        step = np.linalg.solve(normal, gradient)[:, :, 0]
        beta = np.clip(beta - np.clip(step, -reach, reach), low, high)
    return np.asarray(beta)
