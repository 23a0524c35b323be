"""Constant pitch: the best one, the Pareto set, and the one that gives a wanted torque."""

from __future__ import annotations

import time
from typing import Literal

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import brentq, minimize_scalar

from pitchopt.aero.curves import RotorLoads
from pitchopt.design.results import Design, Status
from pitchopt.design.task import DesignTask
from pitchopt.errors import InfeasibleError

__all__ = ["Side", "best_constant", "constant_for_torque", "constant_set", "pitch_for_torque"]

FloatArray = NDArray[np.float64]
Side = Literal["feather", "stall"]
"""Which way from the best constant pitch: to higher or to lower pitch."""

_GRID = 61


def constant_set(
    task: DesignTask, count: int = _GRID
) -> tuple[FloatArray, FloatArray, FloatArray, NDArray[np.bool_]]:
    """Constant pitches over the whole range with mean torque and weighted RMS.

    Returns
    -------
    pitch, torque, rms : ndarray (count,)
        [rad], [N m], [N m].
    pareto : bool ndarray (count,)
        True where no other constant pitch has more torque and less RMS.
    """
    pitch = np.linspace(*task.mean_range, count)
    loads = [task.constant_loads(float(p)) for p in pitch]
    torque = np.array([load.mean[0] for load in loads])
    rms = np.array([task.weights.weighted(load) for load in loads])
    better = (torque[None, :] >= torque[:, None]) & (rms[None, :] <= rms[:, None])
    strictly = (torque[None, :] > torque[:, None]) | (rms[None, :] < rms[:, None])
    return pitch, torque, rms, np.asarray(~np.any(better & strictly, axis=1))


def best_constant(task: DesignTask) -> Design:
    """The constant pitch of largest mean torque."""
    began = time.perf_counter()
    low, high = task.mean_range
    grid = np.linspace(low, high, 41)
    torque = [float(task.constant_loads(float(p)).mean[0]) for p in grid]
    best = int(np.argmax(torque))
    a, b = float(grid[max(best - 1, 0)]), float(grid[min(best + 1, grid.size - 1)])
    pitch = float(grid[best])
    if b > a:
        found = minimize_scalar(
            lambda p: -float(task.constant_loads(float(p)).mean[0]),
            bounds=(a, b),
            method="bounded",
            options={"xatol": 1e-9 if not task.frozen else 1e-5},
        )
        if -float(found.fun) > torque[best]:
            pitch = float(found.x)
    return _constant_design(task, pitch, None, time.perf_counter() - began)


def constant_for_torque(
    task: DesignTask, torque: float, *, best: Design | None = None, side: Side = "feather"
) -> Design:
    """The constant pitch, towards feather or stall, that gives a mean torque.

    Parameters
    ----------
    task : DesignTask
    torque : float
        [N m].
    best : Design, optional
        The best constant pitch, if it is known.
    side : {"feather", "stall"}
        On which side of the best constant pitch.

    Raises
    ------
    InfeasibleError
        If no constant pitch within the limits gives that torque.
    """
    began = time.perf_counter()
    pitch = pitch_for_torque(task, torque, best=best or best_constant(task), side=side)
    return _constant_design(task, pitch, torque, time.perf_counter() - began)


def pitch_for_torque(task: DesignTask, torque: float, *, best: Design, side: Side) -> float:
    """The angle [rad] of :func:`constant_for_torque`."""
    start, top = float(best.profile[0]), best.mean_torque
    if torque > top:
        raise InfeasibleError(
            f"mean torque: got {torque:.6g} N m, the largest at constant pitch is {top:.6g} N m"
        )

    def gap(pitch: float) -> float:
        return float(task.constant_loads(pitch).mean[0]) - torque

    # torque falls from the best pitch to both sides; the first crossing is the one wanted
    grid = np.linspace(start, task.mean_range[1 if side == "feather" else 0], 91)
    gaps = np.array([gap(float(p)) for p in grid])
    below = np.flatnonzero(gaps <= 0)
    if below.size == 0:
        raise InfeasibleError(
            f"mean torque: got {torque:.6g} N m, constant pitch "
            f"{'up' if side == 'feather' else 'down'} to "
            f"{np.degrees(grid[-1]):.2f} deg goes down to {gaps.min() + torque:.6g} N m"
        )
    k = int(below[0])
    return start if k == 0 else float(brentq(gap, grid[k - 1], grid[k], xtol=1e-12))


def _constant_design(
    task: DesignTask, pitch: float, target: float | None, seconds: float
) -> Design:
    mean = pitch if task.frozen else None
    task = task.operating_at(pitch)
    curves = task.problem(mean).curves
    profile = np.full(curves.stations, pitch)
    loads: RotorLoads = curves.evaluate(profile)
    between = task.between(profile, mean)
    return Design(
        kind="constant",
        mu=0.0,
        target=target,
        azimuth=curves.azimuth,
        profile=profile,
        loads=loads,
        between=between,
        rms_weighted=task.weights.weighted(loads),
        rms_weighted_between=None if between is None else task.weights.weighted(between),
        objective=float(loads.mean[0]),
        upper_bound=None,
        gap=None,
        rms_lower_bound=None,
        certificate=None,
        mean_pitch=mean,
        status=Status.CONVERGED,
        message="best constant pitch" if target is None else "constant pitch at the torque",
        start="search over constant pitch",
        iterations=0,
        seconds=seconds,
    )
