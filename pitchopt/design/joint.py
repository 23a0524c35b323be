"""Several winds at once: the joint problem and what it says of profiles.

With one normal form V_w (:mod:`pitchopt.design.problem`) for every wind w, whose blades follow
profile s(w),

    maximise   sum_w p_w V_w(beta_s(w))            or    - max_w (V*_w - V_w(beta_s(w)))
    subject to the limits of every wind,  |beta_n^(s+1) - beta_n^(s)| <= C  at every station n.

One shared profile (robust) is the case of a single s, with the strictest limits of all winds; a
schedule has a profile for every wind and a bounded change C between neighbours.  All limits on
pitch are differences of two angles, so the largest set of intervals that keeps them is found by
shortest paths over stations and profiles, and a profile is repaired by envelopes as in
:mod:`pitchopt.design.limits`.  Profiles stand in one vector, one after the other, shape (S N,).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Self

import numpy as np
from numpy.typing import NDArray

from pitchopt.aero.curves import RotorLoads
from pitchopt.design.limits import PitchLimits, lipschitz_lower
from pitchopt.design.multipliers import Multipliers
from pitchopt.design.problem import DesignProblem, Objective
from pitchopt.errors import InputError

__all__ = ["JointMultipliers", "JointProblem"]

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.intp]

_MERGED = 1e-9  # [rad]; breakpoints of different winds closer than this bound one cell


@dataclass(frozen=True, kw_only=True, eq=False)
class JointMultipliers:
    """Multipliers of a joint problem.

    Attributes
    ----------
    shares : ndarray (W,)
        Weight p_w of every wind, or the multiplier of its regret; the latter sum to one.
    winds : tuple of Multipliers
        Those of each wind's loads and limits, shares counted in; its ``rate`` is not used.
    rate : ndarray (S, N)
        w_n of the change from station n to n + 1 of each profile [N m/rad].
    link : ndarray (S - 1, N)
        Of the change from each profile to the next [N m/rad].
    basis : ndarray (S, N)
        Of the restriction to harmonics [N m/rad]; bounds leave them out.
    """

    shares: FloatArray
    winds: tuple[Multipliers, ...]
    rate: FloatArray
    link: FloatArray
    basis: FloatArray


@dataclass(frozen=True, kw_only=True, eq=False)
class JointProblem:
    """Winds with their curves and objectives, and the profiles that they share.

    Made by :meth:`of`, which narrows every wind to the limits that hold for all of them.

    Attributes
    ----------
    problems : tuple of DesignProblem
    objectives : tuple of Objective
    profile_of : tuple of int
        Which profile each wind's blades follow, 0 to S - 1.
    weights : ndarray (W,) or None
        p_w; None to minimise the largest regret.
    targets : ndarray (W,) or None
        V*_w [N m], for the largest regret.
    change : float
        C [rad]; infinite for profiles that are free of each other.
    """

    problems: tuple[DesignProblem, ...]
    objectives: tuple[Objective, ...]
    profile_of: tuple[int, ...]
    weights: FloatArray | None
    targets: FloatArray | None
    change: float

    @classmethod
    def of(
        cls,
        problems: Sequence[DesignProblem],
        objectives: Sequence[Objective],
        *,
        profile_of: Sequence[int] | None = None,
        weights: FloatArray | None = None,
        targets: FloatArray | None = None,
        change: float = np.inf,
    ) -> Self:
        """The joint problem of winds, each narrowed to the limits of all.

        Parameters
        ----------
        profile_of : sequence of int, optional
            All winds share one profile by default.
        weights, targets : array (W,), optional
            Exactly one of them.

        Raises
        ------
        InputError
            If the winds do not share their stations or restriction to harmonics, a wake is
            frozen, or no profiles keep all limits.
        """
        problems, objectives = tuple(problems), tuple(objectives)
        owner = tuple(profile_of) if profile_of is not None else (0,) * len(problems)
        _check(problems, owner)
        if (weights is None) == (targets is None):
            raise InputError("goal: expected either weights or own optima to count regret from")
        groups = [
            [p for p, o in zip(problems, owner, strict=True) if o == s]
            for s in range(max(owner) + 1)
        ]
        if len(groups) > 1 and any(p.constant_only for p in problems):
            raise InputError(
                "pitch_rate: a limit of zero leaves each wind of a schedule one constant pitch, "
                "expected more than 0"
            )
        low = np.stack([np.max([p.curves.lower for p in group], axis=0) for group in groups])
        high = np.stack([np.min([p.curves.upper for p in group], axis=0) for group in groups])
        steps = np.array([min(p.step for p in group) for group in groups])
        low, high = _envelope(low, steps, change), -_envelope(-high, steps, change)
        if np.any(low >= high):
            where = divmod(int(np.argmax(low - high)), low.shape[1])
            raise InputError(
                f"pitch limits: no pitch keeps those of all winds at station {where[1]}"
                + (f" of profile {where[0]}" if len(groups) > 1 else "")
                + f" (from {np.degrees(low[where]):.3f} to {np.degrees(high[where]):.3f} deg)"
            )
        limits = [_strictest(group) for group in groups]
        narrowed = tuple(
            replace(p, curves=p.curves.with_limits(low[s], high[s]), limits=limits[s])
            for p, s in zip(problems, owner, strict=True)
        )
        return cls(
            problems=narrowed,
            objectives=objectives,
            profile_of=owner,
            weights=weights,
            targets=targets,
            change=float(change),
        )

    # ---- sizes -----------------------------------------------------------------------------

    @property
    def count(self) -> int:
        """S, the number of profiles."""
        return max(self.profile_of) + 1

    @property
    def stations(self) -> int:
        """N, the stations of each profile."""
        return self.problems[0].curves.stations

    def followers(self, profile: int) -> list[int]:
        """Winds whose blades follow a profile."""
        return [w for w, s in enumerate(self.profile_of) if s == profile]

    @cached_property
    def leaders(self) -> tuple[DesignProblem, ...]:
        """One problem for each profile, whose limits and restrictions are the profile's."""
        return tuple(self.problems[self.followers(s)[0]] for s in range(self.count))

    def thinned(self, step: int) -> JointProblem:
        """The joint problem at every ``step``-th rotor position."""
        count = self.problems[0].curves.positions // step
        return replace(
            self, problems=tuple(p.with_curves(p.curves.thinned(count)) for p in self.problems)
        )

    @cached_property
    def softened(self) -> JointProblem:
        """The joint problem on smoothed curves, to tell starts apart by."""
        return replace(self, problems=tuple(problem.softened for problem in self.problems))

    @cached_property
    def no_multipliers(self) -> JointMultipliers:
        """The winds' shares, equal ones for the largest regret, and no other multipliers."""
        count, n = len(self.problems), self.stations
        shares = np.full(count, 1.0 / count) if self.weights is None else self.weights
        nothing = Multipliers.zero(n, self.problems[0].curves.positions)
        return JointMultipliers(
            shares=shares,
            winds=(nothing,) * count,
            rate=np.zeros((self.count, n)),
            link=np.zeros((self.count - 1, n)),
            basis=np.zeros((self.count, n)),
        )

    @property
    def constant_only(self) -> bool:
        """True when rate or harmonics leave constant pitch only."""
        return any(problem.constant_only for problem in self.problems)

    # ---- values ----------------------------------------------------------------------------

    def split(self, beta: FloatArray) -> FloatArray:
        """Profiles, shape (S, N)."""
        return beta.reshape(self.count, self.stations)

    def loads(self, beta: FloatArray) -> list[RotorLoads]:
        """Loads of every wind."""
        rows = self.split(beta)
        return [
            problem.curves.evaluate(rows[s])
            for problem, s in zip(self.problems, self.profile_of, strict=True)
        ]

    def values(self, beta: FloatArray, loads: Sequence[RotorLoads] | None = None) -> FloatArray:
        """V_w of every wind, constraints not counted, shape (W,) [N m]."""
        loads = self.loads(beta) if loads is None else loads
        travel = [self.leaders[0].travel(row) for row in self.split(beta)]
        return np.array(
            [
                problem.value_of(load, travel[s], objective)
                for problem, load, objective, s in zip(
                    self.problems, loads, self.objectives, self.profile_of, strict=True
                )
            ]
        )

    def total(self, values: FloatArray) -> float:
        """The joint objective of values of all winds [N m]."""
        if self.weights is not None:
            return float(self.weights @ values)
        assert self.targets is not None
        return -float(np.max(self.targets - values))

    def excess(self, loads: Sequence[RotorLoads]) -> FloatArray:
        """Violation of each wind's torque limits and blade cap, shape (W, 2) [N m]."""
        return np.array(
            [
                problem.excess(load, objective)
                for problem, load, objective in zip(
                    self.problems, loads, self.objectives, strict=True
                )
            ]
        )

    # ---- limits ----------------------------------------------------------------------------

    @cached_property
    def steps(self) -> FloatArray:
        """D of every profile, shape (S,) [rad]."""
        return np.array([problem.step for problem in self.leaders])

    def repaired(self, beta: FloatArray) -> FloatArray:
        """Profiles that keep range, rate and change, moved by no more than their violation."""
        if self.count == 1:
            return self.problems[0].repaired(beta)
        rows = self.split(beta)
        middle = 0.5 * (
            _envelope(rows, self.steps, self.change) - _envelope(-rows, self.steps, self.change)
        )
        low = np.stack([problem.curves.lower for problem in self.leaders])
        high = np.stack([problem.curves.upper for problem in self.leaders])
        return np.asarray(np.clip(middle, low, high).ravel())

    # ---- cells -----------------------------------------------------------------------------

    @cached_property
    def edges(self) -> tuple[FloatArray, IntArray]:
        """Edges of the cells, (S N, K) in rising order and padded, and the last cell (S N,).

        On a cell every wind stands on one segment of its own.
        """
        return self.breakpoints(_MERGED)

    def breakpoints(self, apart: float) -> tuple[FloatArray, IntArray]:
        """Breakpoints of all winds of each station, those closer than ``apart`` left out.

        Returns
        -------
        grid : ndarray (S N, K)
            Rising, padded by infinity [rad].
        last : ndarray (S N,)
            Index of the last cell.
        """
        parts = []
        for s in range(self.count):
            rows = [self.problems[w].curves.beta for w in self.followers(s)]
            grid = np.sort(np.concatenate(rows, axis=1), axis=1)
            upper = grid[:, -1].copy()
            grid[:, 1:][np.diff(grid, axis=1) <= apart] = np.inf
            grid.sort(axis=1)
            number = np.isfinite(grid).sum(axis=1)
            grid[np.arange(grid.shape[0]), number - 1] = upper
            parts.append(grid)
        width = max(part.shape[1] for part in parts)
        grid = np.full((self.count * self.stations, width), np.inf)
        for s, part in enumerate(parts):
            grid[s * self.stations : (s + 1) * self.stations, : part.shape[1]] = part
        number = np.isfinite(grid).sum(axis=1)
        return grid[:, : number.max()], np.asarray(number - 2)


def _check(problems: Sequence[DesignProblem], owner: Sequence[int]) -> None:
    if not problems:
        raise InputError("winds: got none, expected at least one")
    first = problems[0].curves
    for number, problem in enumerate(problems):
        curves = problem.curves
        if curves.mean_pitch is not None:
            raise InputError(
                f"winds: number {number} has a frozen wake, expected induction none or "
                "equilibrium: each frozen wake holds for one mean pitch only"
            )
        if (curves.blades, curves.stations) != (first.blades, first.stations):
            raise InputError(
                f"winds: number {number} has {curves.blades} blades and {curves.positions} "
                f"positions, expected {first.blades} and {first.positions} as number 0 has"
            )
        if not np.allclose(curves.azimuth, first.azimuth, rtol=0.0, atol=1e-9):
            raise InputError(f"winds: stations of number {number} stand elsewhere than those of 0")
        if problem.harmonics != problems[0].harmonics:
            raise InputError(
                f"harmonics: got {problem.harmonics} for wind {number}, expected "
                f"{problems[0].harmonics} as wind 0 has"
            )
    if len(set(owner)) > 1 and problems[0].harmonics is not None:
        raise InputError(
            "harmonics: a schedule is held within its change from profile to profile at every "
            "station, which is not combined with a restriction to harmonics"
        )


def _strictest(problems: Sequence[DesignProblem]) -> PitchLimits:
    """Limits with the smallest step between stations and the narrowest range."""
    every = [problem.limits for problem in problems]
    least = min(every, key=lambda limits: limits.step(1))
    return replace(
        least,
        lower=max(limits.lower for limits in every),
        upper=min(limits.upper for limits in every),
    )


def _envelope(bound: FloatArray, steps: FloatArray, change: float) -> FloatArray:
    """Smallest profiles above ``bound`` that keep the rates and the change between profiles."""
    out = np.array(bound, dtype=np.float64)
    for _ in range(4):  # along the profiles to the slowest rate, along it, and back, is all
        before = out.copy()
        for s, step in enumerate(steps):
            out[s] = lipschitz_lower(out[s], float(step))
        for s in range(1, out.shape[0]):
            out[s] = np.maximum(out[s], out[s - 1] - change)
        for s in range(out.shape[0] - 1, 0, -1):
            out[s - 1] = np.maximum(out[s - 1], out[s] - change)
        if np.all(out - before <= 1e-14):
            break
    return out
