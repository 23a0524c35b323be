"""Restoration: a step of the linear model brought back to the loads that the model promised.

At high prices an optimum holds torque, tilt and yaw flat.  Their RMS has a kink there, so a
profile may only move along the curved set of flat ones, and a linear step leaves it by the
curvature of the loads: the step costs more than it gains and the trust region collapses
(the Maratos effect).  Gauss-Newton steps on the curves undo that without another cone program,

    minimise  sum_k sum_l lambda_l / J_l (load_lk(beta + d) - promised_lk)^2
            + sum_n lambda_b / (B J_blade) (bending_n(beta + d) - promised_n)^2 + small |d|^2,

the weights being those of the objective's second-order expansion in the loads.  Each rotor
position couples the pitch of its B blades only; neighbours at the rate limit are held together
by stiff springs, pitch at the end of its range by stiff ground, which leaves a banded system.
Reference: J. Nocedal, S. Wright, Numerical Optimization, section 15.6 (second-order correction).
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import solveh_banded

from pitchopt.design.problem import DesignProblem, Objective

__all__ = ["restored"]

FloatArray = NDArray[np.float64]

_STEPS = 4
_DAMPING = 1e-4  # relative to the largest weighted slope squared
_STIFF = 1e3
_FLAT = 1e-4 * np.radians(1.0)  # pitch whose change of load counts as flat [rad]


def restored(
    problem: DesignProblem,
    objective: Objective,
    point: FloatArray,
    profile: FloatArray,
    *,
    cap_price: float = 0.0,
) -> FloatArray:
    """A profile near ``profile`` whose loads are those of the linear model around ``point``.

    Parameters
    ----------
    problem, objective
        As in :func:`pitchopt.design.scp.solve_local`.
    point : array (N,)
        Where the segments of the model were taken [rad], inside the range.
    profile : array (N,)
        Step of the model [rad].
    cap_price : float
        Multiplier of the blade cap [-]: what bending weighs beyond its own lambda.

    Returns
    -------
    ndarray (N,)
        Inside the range; the rate limit, a fixed mean or harmonics may need a repair.
    """
    curves = problem.curves
    blades, m = curves.blades, curves.positions
    # one station has no variation, harmonics leave no freedom at a single position
    if problem.basis is not None or curves.stations == 1:
        return profile
    rows, j = np.arange(curves.stations), curves.segment(point)
    slopes = curves.slopes[:, rows, j]
    promised = curves.loads[:, rows, j] + slopes * (profile - curves.beta[rows, j])
    rates = curves.rates * curves.profile_rate(profile)
    rotor = _rotor(promised[:4] + rates[:4], blades)
    bending = promised[4] + rates[4]

    price = objective.lambdas
    price[4] = (price[4] + cap_price) / blades
    spread = np.append(rotor.std(axis=1), bending.std())
    floor = _FLAT * np.sqrt(np.mean(slopes**2, axis=1))
    weight = np.sqrt(price / np.maximum(np.maximum(spread, floor), 1e-300))
    largest = float(np.max(np.abs(slopes) * weight[:, None]))
    if not largest > 0:
        return profile
    weight /= largest

    tied = np.abs(np.roll(profile, -1) - profile) >= problem.step * (1 - 1e-4)
    margin = 1e-6 * (curves.upper - curves.lower)
    held = (profile <= curves.lower + margin) | (profile >= curves.upper - margin)
    out = np.clip(profile, curves.lower, curves.upper)
    for _ in range(_STEPS):
        j = curves.segment(out)
        jacobian = curves.slopes[:, rows, j] * weight[:, None]
        loads = curves.evaluate(out)
        miss = (loads.rotor - rotor) * weight[:4, None]
        miss_blade = (loads.bending - bending) * weight[4]
        gradient = (jacobian[:4] * np.tile(miss, (1, blades))).sum(axis=0)
        gradient += jacobian[4] * miss_blade
        matrix = _banded(jacobian, blades, m, tied, held)
        right = np.stack([-gradient, np.ones_like(gradient)], axis=1)[_order(blades, m)]
        solved = np.empty_like(right)
        solved[_order(blades, m)] = solveh_banded(matrix, right, lower=True)
        move = solved[:, 0]
        if curves.mean_pitch is not None:  # the step of least cost that keeps the mean
            move = move - solved[:, 1] * (move.sum() / solved[:, 1].sum())
        out = np.clip(out + move, curves.lower, curves.upper)
    return np.asarray(out)


def _rotor(station: FloatArray, blades: int) -> FloatArray:
    """Loads of the stations (4, N) summed over the blades, (4, m)."""
    return np.asarray(station.reshape(4, blades, -1).sum(axis=1))


def _order(blades: int, m: int) -> NDArray[np.intp]:
    """Stations sorted by rotor position, then blade."""
    return np.arange(blades * m).reshape(blades, m).T.ravel()


def _banded(
    jacobian: FloatArray,
    blades: int,
    m: int,
    tied: NDArray[np.bool_],
    held: NDArray[np.bool_],
) -> FloatArray:
    """Lower band of the normal equations in position order, shape (B + 1, N).

    A tie across the end of a blade passage would leave the band; the repair deals with it.
    """
    order = _order(blades, m)
    a = jacobian[:4].reshape(4, blades, m)
    band = np.zeros((blades + 1, blades * m))
    for offset in range(blades):
        product = np.einsum("qbk,qbk->kb", a[:, : blades - offset], a[:, offset:])
        band[offset].reshape(m, blades)[:, : blades - offset] = product
    ties = (_STIFF * tied)[order]
    ties[-blades:] = 0.0
    band[0] += (jacobian[4] ** 2 + _DAMPING + _STIFF * held)[order] + ties
    band[0, blades:] += ties[:-blades]
    band[blades] -= ties
    return band
