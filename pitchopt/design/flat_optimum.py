"""An optimum found without any convex program: exact flattening, and a search over three means.

Where the price of load variation is high, a local optimum with three blades has three of its four
rotor loads exactly flat: each rotor position has three pitch angles, hence three equations.  Such a
profile is a function of the three means alone (:mod:`pitchopt.design.flatten`), on one of a few
branches, and what is left is a search over three numbers,

    maximise over (loss, tilt, yaw)   a T - lambda J - kappa V   of the flattened profile,

here a grid and a direct search with halving steps from the best few points of it.  Branches are:
torque given up towards stall or towards feather, marching with or against the rotation.
Nothing is repaired: a profile that misses a target or breaks the rate limit does not count.

The result is a feasible profile, not a bound.  It is no check where the rate limit binds or the
price is low (the optimum then is not flat), and there is none for other numbers of blades, for a
frozen wake or for profiles restricted to harmonics.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import product

import numpy as np
from numpy.typing import NDArray

from pitchopt.aero.curves import LOADS, RotorLoads
from pitchopt.design.flatten import Family, families, flatten, loads_of, ranks_of
from pitchopt.design.problem import DesignProblem, Objective
from pitchopt.design.search import valued
from pitchopt.errors import InfeasibleError, InputError

__all__ = ["FlatOptimum", "flat_optimum"]

FloatArray = NDArray[np.float64]

_LOSSES = (0.005, 0.01, 0.02, 0.03, 0.045, 0.07, 0.1, 0.15, 0.2, 0.3)
_SHARES = np.array(  # of torque, tilt and yaw added to constant pitch's mean
    [-0.3, -0.18, -0.1, -0.05, -0.02, 0.0, 0.02, 0.05, 0.1, 0.18, 0.3]
)
_EXACT = 1e-9  # [rad]
_AWAY = 0.06  # in tilt or yaw, for a point of the grid to stand for another basin
_BASINS = 6  # that are searched
_COMPASS = np.array([move for move in product((-1.0, 0.0, 1.0), repeat=3) if any(move)])
_RANDOM = 24  # moves beside those of the compass
_FIRST = np.array([0.3, 0.03, 0.03])  # first step: log loss, shares
_LEAST = 1e-5  # of the first step
_MOST_STEPS = 120


@dataclass(frozen=True, kw_only=True, eq=False)
class FlatOptimum:
    """The best flattened profile.

    Attributes
    ----------
    profile : ndarray (N,)
        Within range and rate [rad].
    loads : RotorLoads
    value : float
        Of the objective [N m].
    flat : tuple of str
        The loads that do not vary.
    branch : str
        The branch that it lies on.
    evaluations : int
        Flattened profiles that were tried.
    """

    profile: FloatArray
    loads: RotorLoads
    value: float
    flat: tuple[str, ...]
    branch: str
    evaluations: int


def flat_optimum(problem: DesignProblem, objective: Objective, pitch: float) -> FlatOptimum:
    """Best profile with three exactly flat loads.

    Parameters
    ----------
    problem : DesignProblem
        Three blades, no frozen wake, no restriction to harmonics.
    objective : Objective
    pitch : float
        The constant pitch of largest torque [rad].

    Raises
    ------
    InputError
        If the problem is not of that kind.
    InfeasibleError
        If no flattened profile is found that keeps range, rate, torque limits and blade cap.
    """
    curves = problem.curves
    wrong = [
        (curves.blades != 3, f"{curves.blades} blades", "three"),
        (curves.mean_pitch is not None, "a frozen wake", "curves that hold at every mean pitch"),
        (problem.harmonics is not None, f"{problem.harmonics} harmonics", "none prescribed"),
    ]
    for is_wrong, got, expected in wrong:
        if is_wrong:
            raise InputError(f"flattened optimum: got {got}, expected {expected}")
    branches = [
        _Branch(problem, objective, family, backwards)
        for family in families(problem, pitch)
        for backwards in (False, True)
    ]
    basins = [(value, branch, at) for branch in branches for at, value in branch.basins()]
    none = InfeasibleError(
        "flattened optimum: no profile with three flat loads was found that keeps range, rate and "
        "the limits of the objective"
    )
    if not basins:
        raise none
    basins = sorted(basins, key=lambda basin: -basin[0])[:_BASINS]
    ends = []
    for branch in branches:
        centres = [(at, value) for value, other, at in basins if other is branch]
        if centres:
            ends.append((*branch.search(centres), branch))
    _, numbers, branch = max(ends, key=lambda end: end[0])
    profile = branch.values(numbers[None, :])[1][0]
    value = valued(problem, objective, profile)
    if value < problem.value(profile, objective):
        raise none  # limits of the objective are broken, and the rank says so
    return FlatOptimum(
        profile=profile,
        loads=curves.evaluate(profile),
        value=value,
        flat=tuple(LOADS[q] for q in branch.family.kept),
        branch=str(branch),
        evaluations=sum(branch.tried for branch in branches),
    )


class _Branch:
    """Flattened profiles as a function of three numbers: loss, tilt and yaw."""

    def __init__(
        self, problem: DesignProblem, objective: Objective, family: Family, backwards: bool
    ) -> None:
        self.problem, self.objective = problem, objective
        self.family, self.backwards, self.tried = family, backwards, 0
        limit = 1.0 - objective.torque_min / family.means[0, 0]
        self.largest = float(np.clip(limit, 0.0, family.loss[-1]))

    def __str__(self) -> str:
        side = "feather" if self.family.pitch[-1] > self.family.pitch[0] else "stall"
        return f"towards {side}, {'against' if self.backwards else 'with'} the rotation"

    def values(self, numbers: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Value of each (G,), minus infinity where there is none, and the profiles (G, N)."""
        problem, curves = self.problem, self.problem.curves
        self.tried += len(numbers)
        found, which = flatten(
            problem,
            self.family.kept,
            *self.family.targets(numbers),
            turns=12,
            backwards=self.backwards,
            tolerance=_EXACT,
        )
        profiles = np.full((len(numbers), curves.stations), np.nan)
        values = np.full(len(numbers), -np.inf)
        change = np.abs(np.roll(found, -1, axis=1) - found)
        torque, rms = loads_of(problem, found)
        value = ranks_of(self.objective, torque, rms, change.sum(axis=1))
        slow = change.max(axis=1, initial=0.0) <= problem.step * (1 + 1e-9)
        profiles[which], values[which] = found, np.where(slow, value, -np.inf)
        return values, profiles

    def basins(self) -> Iterator[tuple[FloatArray, float]]:
        """The best few of a grid, apart from each other: three numbers and their value."""
        losses = [loss for loss in _LOSSES if loss < self.largest] + [self.largest]
        grid = np.array(list(product(losses, _SHARES, _SHARES)))
        values, _ = self.values(grid)
        centres: list[int] = []
        for i in np.argsort(-values, kind="stable")[: np.count_nonzero(np.isfinite(values))]:
            away = np.abs(grid[centres, 1:] - grid[i, 1:]).max(axis=1, initial=np.inf)
            if np.all(away > _AWAY):
                centres.append(int(i))
                yield grid[i], float(values[i])
            if len(centres) == _BASINS:
                break

    def search(self, centres: Sequence[tuple[FloatArray, float]]) -> tuple[float, FloatArray]:
        """Best value and its three numbers: steps that halve when none of many moves gains."""
        random = np.random.default_rng(0)
        at = np.array([numbers for numbers, _ in centres])
        best = np.array([value for _, value in centres])
        size = np.ones(len(centres))
        for _ in range(_MOST_STEPS):
            rows = np.flatnonzero(size > _LEAST)
            if not rows.size:
                break
            # values have kinks: moves along the axes alone would stop short of an optimum
            moves = np.concatenate([_COMPASS, random.uniform(-1.0, 1.0, (_RANDOM, 3))])
            step = size[rows, None, None] * _FIRST * moves
            moved = at[rows, None, :] + step
            moved[..., 0] = at[rows, None, 0] * np.exp(step[..., 0])
            moved[..., 0] = np.minimum(moved[..., 0], self.largest)
            trial = self.values(moved.reshape(-1, 3))[0].reshape(moved.shape[:2])
            top = trial.argmax(axis=1)
            highest = trial[np.arange(rows.size), top]
            gained = highest > best[rows]
            at[rows[gained]], best[rows[gained]] = moved[gained, top[gained]], highest[gained]
            size[rows[~gained]] /= 2.0
        return float(best.max()), at[int(best.argmax())]
