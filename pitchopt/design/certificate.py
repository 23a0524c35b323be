"""Upper bounds that trust no solver: the Lagrangian of the design problem at given multipliers.

For the normal form of :mod:`pitchopt.design.problem`, take any

    y_l over positions with zero mean and norm at most lambda_l / sqrt(m),
    y_b over stations with zero mean and norm at most (lambda_b + eta) / sqrt(N),
    w cyclic over stations, nu_min, nu_max, eta >= 0, zeta free.

Because lambda J = max of y . load over such y, and each constraint with its multiplier can
only raise the value of a feasible profile,

    UB = sum_n max over beta in [lower_n, upper_n] of
             [ a' torque_n / m - sum_l y_l,k(n) load_ln - y_bn bending_n + c_n beta_n ]
         + D sum_n max(|w_n| - kappa, 0) - nu_min torque_min + nu_max torque_max
         + eta blade_cap + zeta (beta_mean if frozen else 0),
    a' = a + nu_min - nu_max,

bounds the objective of every feasible profile.  c_n collects w_{n} - w_{n-1}, the pitch-rate
terms of the neighbours and -zeta / N.  Each bracket is piecewise linear in one angle, so its
maximum stands on a breakpoint and the evaluation is exact but for rounding, which is covered by
moving the result outward.  With a frozen wake the bound holds for profiles of that mean pitch.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from pitchopt.design.multipliers import Multipliers
from pitchopt.design.problem import DesignProblem, Objective

__all__ = [
    "constant_terms",
    "lagrangian_bound",
    "linear_terms",
    "projected",
    "rounding",
    "station_values",
    "station_weights",
]

FloatArray = NDArray[np.float64]

_ROUNDING = 64.0 * np.finfo(np.float64).eps


def projected(problem: DesignProblem, objective: Objective, mult: Multipliers) -> Multipliers:
    """The nearest simple multipliers that satisfy the conditions of the bound."""
    n, m = problem.curves.stations, problem.curves.positions
    lam = objective.lambdas
    shrink = 1.0 - 1e-12
    loads = mult.loads - mult.loads.mean(axis=1, keepdims=True)
    norm = np.linalg.norm(loads, axis=1)
    allowed = lam[:4] / np.sqrt(m) * shrink
    loads = loads * np.where(norm > allowed, allowed / np.maximum(norm, 1e-300), 1.0)[:, None]
    finite_cap = np.isfinite(objective.blade_cap)
    cap = max(mult.cap, 0.0) if finite_cap else 0.0
    blade = mult.blade - mult.blade.mean()
    blade_norm = float(np.linalg.norm(blade))
    blade_allowed = (lam[4] + cap) / np.sqrt(n) * shrink
    if blade_norm > blade_allowed:
        blade = blade * (blade_allowed / blade_norm) if blade_norm > 0 else blade
    return Multipliers(
        loads=loads,
        blade=blade,
        rate=np.array(mult.rate, dtype=np.float64),
        torque_min=max(mult.torque_min, 0.0) if np.isfinite(objective.torque_min) else 0.0,
        torque_max=max(mult.torque_max, 0.0) if np.isfinite(objective.torque_max) else 0.0,
        cap=cap,
        mean=mult.mean if problem.curves.mean_pitch is not None else 0.0,
    )


def linear_terms(problem: DesignProblem, objective: Objective, mult: Multipliers) -> FloatArray:
    """c_n: what rate limits, pitch-rate terms and the mean add per radian of pitch, (N,)."""
    curves = problem.curves
    c = mult.rate - np.roll(mult.rate, 1)
    if np.any(curves.rates):
        gain = objective.torque + mult.torque_min - mult.torque_max
        per_rate = gain * curves.rates[0] / curves.positions - np.sum(
            station_weights(problem, mult) * curves.rates, axis=0
        )
        # dbeta/dpsi at n is (beta_{n+1} - beta_{n-1}) / (2 spacing)
        c = c + (np.roll(per_rate, 1) - np.roll(per_rate, -1)) / (2 * curves.spacing)
    if curves.mean_pitch is not None:
        c = c - mult.mean / curves.stations
    return np.asarray(c)


def station_weights(problem: DesignProblem, mult: Multipliers) -> FloatArray:
    """What multiplies each of the five loads at every station, shape (5, N)."""
    loads = mult.loads + mult.box[:, None] / problem.curves.positions
    return np.concatenate([np.tile(loads, (1, problem.curves.blades)), mult.blade[None]])


def station_values(problem: DesignProblem, objective: Objective, mult: Multipliers) -> FloatArray:
    """The bracket of the bound at every breakpoint, shape (N, K)."""
    curves = problem.curves
    weight = -station_weights(problem, mult)
    weight[0] += (objective.torque + mult.torque_min - mult.torque_max) / curves.positions
    used = np.flatnonzero(weight.any(axis=1))
    values = linear_terms(problem, objective, mult)[:, None] * curves.beta
    product = np.empty_like(values)
    for q in used:  # in place: temporaries of this size cost more than the sums
        values += np.multiply(weight[q][:, None], curves.loads[q], out=product)
    return np.asarray(values)


def constant_terms(problem: DesignProblem, objective: Objective, mult: Multipliers) -> FloatArray:
    """The terms of the bound that no breakpoint enters."""
    terms = [problem.step * float(np.sum(np.maximum(np.abs(mult.rate) - objective.travel, 0.0)))]
    if mult.torque_min > 0:
        terms.append(-mult.torque_min * objective.torque_min)
    if mult.torque_max > 0:
        terms.append(mult.torque_max * objective.torque_max)
    if mult.cap > 0:
        terms.append(mult.cap * objective.blade_cap)
    if problem.curves.mean_pitch is not None:
        terms.append(mult.mean * problem.curves.mean_pitch)
    return np.array(terms)


@np.errstate(over="ignore", invalid="ignore")  # what is not finite proves nothing
def lagrangian_bound(
    problem: DesignProblem, objective: Objective, mult: Multipliers
) -> tuple[float, FloatArray]:
    """Upper bound on the objective of every feasible profile, and the brackets behind it.

    Parameters
    ----------
    problem : DesignProblem
    objective : Objective
    mult : Multipliers
        Any numbers at all; they are projected first, so that the result is always a bound.

    Returns
    -------
    bound : float
        Rounded outward [N m].
    values : ndarray (N, K)
        The bracket at every breakpoint, for pricing.
    """
    if not mult.finite:
        zero = Multipliers.zero(problem.curves.stations, problem.curves.positions)
        return np.inf, station_values(problem, objective, zero)
    mult = projected(problem, objective, mult)
    values = station_values(problem, objective, mult)
    constants = constant_terms(problem, objective, mult)
    bound = float(np.sum(values.max(axis=1)) + np.sum(constants))
    bound += rounding(problem, objective, mult, constants)
    return bound if np.isfinite(bound) else np.inf, values


def rounding(
    problem: DesignProblem, objective: Objective, mult: Multipliers, constants: FloatArray
) -> float:
    """By how much the sums of the bound may be off [N m].

    Counted from the magnitudes of all terms before any of them cancel.
    """
    curves = problem.curves
    n, m = curves.stations, curves.positions
    reach = np.maximum(np.abs(curves.lower), np.abs(curves.upper))
    weights = np.empty((5, n))
    weights[:4] = np.tile(np.abs(mult.loads) + np.abs(mult.box)[:, None] / m, (1, curves.blades))
    weights[4] = np.abs(mult.blade)
    weights[0] += (abs(objective.torque) + mult.torque_min + mult.torque_max) / m
    around = np.roll(reach, 1) + np.roll(reach, -1)
    largest = problem.largest_loads + np.abs(curves.rates) * around / (2 * curves.spacing)
    pitch = np.abs(mult.rate) + np.abs(np.roll(mult.rate, 1)) + abs(mult.mean) / n
    size = float(np.sum(weights * largest) + np.sum(pitch * reach) + np.sum(np.abs(constants)))
    return float(_ROUNDING * np.sqrt(n) * size)
