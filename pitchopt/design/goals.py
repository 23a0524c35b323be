"""The designs that users ask for: one profile, or the curve between torque and load variation.

The curve is made of points that maximise mean torque - mu x weighted RMS for a grid of mu, and
of the designs of least RMS for a given loss of torque (:mod:`pitchopt.design.points` finds
them).  The knee is the point farthest below the chord between the ends of the curve, with both
axes scaled to the unit interval.
"""

from __future__ import annotations

import time
from collections.abc import Sequence
from contextlib import suppress
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from pitchopt.checks import FloatArray, finite_array, finite_number, whole_number
from pitchopt.design.constant_pitch import (
    best_constant,
    constant_for_torque,
    constant_set,
    pitch_for_torque,
)
from pitchopt.design.judged import finished
from pitchopt.design.points import TORQUE_ALONE, PointFinder
from pitchopt.design.power import maximise_torque
from pitchopt.design.problem import Objective
from pitchopt.design.proof import Certificate, ProofSettings
from pitchopt.design.relaxation import relax
from pitchopt.design.results import Compared, Design, LocalSolution, Tradeoff
from pitchopt.design.search import Found, climb
from pitchopt.design.task import DesignTask, Progress
from pitchopt.errors import InfeasibleError, InputError

__all__ = ["compared", "constant", "default_mu", "design", "power_max", "tradeoff"]

_LOSSES = (0.03, 0.07)


def default_mu(reference: Design, count: int = 20) -> FloatArray:
    """Prices of RMS that span a trade-off curve, evenly spaced in their logarithm.

    Parameters
    ----------
    reference : Design
        The best constant pitch.  Its mean torque over its weighted RMS sets the scale: at the
        lowest price the RMS of constant pitch costs 0.25 % of torque, at the highest nine
        times torque.
    count : int
    """
    count = whole_number("points", count, at_least=1)
    torque = abs(reference.mean_torque) or 1.0
    scale = torque / max(reference.rms_weighted, 1e-6 * torque)
    return np.geomspace(2.5e-3, 9.0, count) * scale


def constant(task: DesignTask) -> Design:
    """The constant pitch of largest mean torque."""
    return best_constant(task)


def power_max(task: DesignTask, *, reference: Design | None = None) -> Design:
    """The profile of largest mean torque, the cap on blade load not counted.

    Exact where torque is concave in pitch; with a frozen wake exact for each mean pitch, and
    the outer search over the mean is local.  Elsewhere the better of two local optima, from the
    best constant pitch and from the relaxation; ``upper_bound`` says how good it is.
    """
    began = time.perf_counter()
    start = reference or best_constant(task)
    if not task.frozen:
        task = task.operating_at(float(start.profile.mean()))
        solution = maximise_torque(task.problem(), start.profile)
        mean = None
    else:
        known: dict[float, LocalSolution] = {}

        def value(pitch: float) -> float:
            problem = task.problem(pitch)
            known[pitch] = maximise_torque(problem, np.full(problem.curves.stations, pitch))
            return known[pitch].value

        mean = climb(value, float(start.profile.mean()), *task.mean_range)
        solution = known[mean]
    found = Found(
        solution=solution, start=start.message, mean_pitch=mean, iterations=solution.iterations
    )
    if solution.loads.mean[0] <= 0:
        raise InputError(
            f"mean torque: the largest that any profile gives is {solution.loads.mean[0]:.4g} N m, "
            "expected more than 0; check wind speed, rotor speed and pitch range"
        )
    relaxed = relax(task.problem(mean), TORQUE_ALONE, profile=solution.profile)
    return finished(
        task, TORQUE_ALONE, found, "power_max", 0.0, None, began, relaxed, solution.value
    )


def design(task: DesignTask, **options: Any) -> Design:
    """One pitch profile; goals and options as in :func:`compared`."""
    return compared(task, **options).design


def compared(
    task: DesignTask,
    *,
    mu: float | None = None,
    max_power_loss: float | None = None,
    mean_torque: float | None = None,
    starts: int = 5,
    certify: bool | ProofSettings = True,
    resume: Certificate | None = None,
    seed: int = 0,
    progress: Progress | None = None,
) -> Compared:
    """One pitch profile, with the constant pitch and the power maximum that it is judged by.

    Exactly one of the three goals is given.

    Parameters
    ----------
    task : DesignTask
    mu : float
        Price of the weighted RMS against mean torque [-].
    max_power_loss : float
        Least weighted RMS for at most this share of the largest mean torque lost.
    mean_torque : float
        Least weighted RMS at this mean torque, held from both sides [N m].
    starts : int
        Profiles that the local solve starts from.
    certify : bool or ProofSettings
        Bound the result by the hull relaxation; with settings, then close the gap by branch and
        bound as far as they say.  A better profile that is found on the way replaces the result.
    resume : Certificate, optional
        Of an earlier branch and bound for the same design, to go on from its tree.
    seed : int
        Seed of the random starts, beyond the first seven.
    progress : callable, optional

    Raises
    ------
    InputError
        If not exactly one goal is given, or it is out of range.
    InfeasibleError
        If no profile gives the mean torque asked for.
    """
    goals = {"mu": mu, "max_power_loss": max_power_loss, "mean_torque": mean_torque}
    given = [name for name, value in goals.items() if value is not None]
    if len(given) != 1:
        raise InputError(
            f"goal: got {' and '.join(given) or 'none'}, expected exactly one of "
            "mu, max_power_loss, mean_torque"
        )
    starts = whole_number("starts", starts, at_least=1)
    seed = whole_number("seed", seed, at_least=0)
    if max_power_loss is not None:
        max_power_loss = _share("max_power_loss", max_power_loss)
    if mean_torque is not None:
        mean_torque = finite_number("mean_torque", mean_torque)
    if mu is not None:
        Objective.tradeoff(mu, task.weights)
    if progress is not None:
        progress(1, 3, "constant pitch")
    best = best_constant(task)
    power = power_max(task, reference=best)
    reference, stalled = best, None
    if mean_torque is not None:
        if mean_torque > power.mean_torque * (1 + 1e-9):
            raise InfeasibleError(
                f"mean torque: got {mean_torque:.6g} N m, the largest of any profile is "
                f"{power.mean_torque:.6g} N m"
            )
        if mean_torque <= best.mean_torque:
            reference = constant_for_torque(task, mean_torque, best=best)
            with suppress(InfeasibleError):  # torque may stay above it down to the lowest pitch
                stalled = pitch_for_torque(task, mean_torque, best=best, side="stall")
    finder = PointFinder(
        task,
        reference,
        power,
        starts,
        certify,
        seed,
        progress,
        total=3,
        resume=resume,
        best=best,
    )
    finder.tick("power maximum")
    if mu is not None:
        found = finder.point(mu)
    elif max_power_loss is not None:
        found = finder.loss_point(max_power_loss)
    else:
        assert mean_torque is not None
        found = finder.torque_point(mean_torque, stalled)
    return Compared(design=found, constant=reference, power_max=power)


def tradeoff(
    task: DesignTask,
    *,
    mu: ArrayLike | None = None,
    points: int = 20,
    losses: Sequence[float] = _LOSSES,
    starts: int = 5,
    anchors: int = 5,
    certify: bool | ProofSettings = True,
    seed: int = 0,
    progress: Progress | None = None,
) -> Tradeoff:
    """Power maximum, best constant pitch and the trade-off curve between torque and RMS.

    Parameters
    ----------
    task : DesignTask
    mu : array, optional
        Prices of the weighted RMS [-].
    points : int
        Number of prices when none are given; they scale with the case (:func:`default_mu`).
    losses : sequence of float
        Shares of mean torque lost at which the design of least RMS is added.
    starts, anchors : int
        Starts at each anchor value of mu, and the number of anchors.
    certify : bool or ProofSettings
        Bound every point by the hull relaxation; with settings, then by branch and bound, the
        time limit counted for each point.
    seed : int
        Seed of the random starts, beyond the first seven.
    progress : callable, optional
        Called with steps done, steps in all and a label.
    """
    began = time.perf_counter()
    prices = None if mu is None else np.sort(finite_array("mu", np.atleast_1d(mu)))
    for price in () if prices is None else prices[[0, -1]]:
        Objective.tradeoff(float(price), task.weights)
    targets = [_share("losses", loss) for loss in np.atleast_1d(np.asarray(losses, dtype=object))]
    starts = whole_number("starts", starts, at_least=1)
    anchors = whole_number("anchors", anchors, at_least=1)
    points = whole_number("points", points, at_least=1)
    seed = whole_number("seed", seed, at_least=0)
    count = points if prices is None else int(prices.size)
    total = 2 * count + len(targets) + 2
    if progress is not None:
        progress(1, total, "constant pitch")
    reference = best_constant(task)
    pitch, torque, rms, pareto = constant_set(task)
    power = power_max(task, reference=reference)
    if prices is None:
        prices = default_mu(reference, count)
    finder = PointFinder(task, reference, power, starts, certify, seed, progress, total=total)
    finder.tick("power maximum")
    found = finder.curve([float(p) for p in prices], targets, anchors)
    found.sort(key=lambda point: (-point.mean_torque, point.kind != "mu", point.mu))
    power = finder.power
    return Tradeoff(
        constant=reference,
        power_max=power,
        points=tuple(found),
        knee=_knee(power, found),
        constant_pitch=pitch,
        constant_torque=torque,
        constant_rms=rms,
        constant_pareto=pareto,
        settings={
            "positions": task.positions,
            "weights": dict(
                zip(("torque", "tilt", "yaw", "thrust", "blade"), task.weights.array, strict=True)
            ),
            "blade_cap": task.blade_cap,
            "harmonics": task.harmonics,
            "travel": task.travel,
            "starts": starts,
            "anchors": anchors,
            "seed": seed,
        },
        seconds=time.perf_counter() - began,
    )


def _share(name: str, value: object) -> float:
    share = finite_number(name, value, above=0)
    if share >= 1:
        raise InputError(f"{name}: got {value!r}, expected a share between 0 and 1")
    return share


def _knee(power: Design, points: Sequence[Design]) -> int:
    """Index of the point farthest below the chord, both axes scaled to [0, 1]."""
    torque = np.array([power.mean_torque, *(p.mean_torque for p in points)])
    rms = np.array([power.rms_weighted, *(p.rms_weighted for p in points)])
    x = (torque.max() - torque) / max(float(np.ptp(torque)), 1e-300)
    y = (rms - rms.min()) / max(float(np.ptp(rms)), 1e-300)
    return int(np.argmin((x + y)[1:]))
