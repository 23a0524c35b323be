"""The walk of a local solve: a trust region, then the exact finish on segments.

Two phases, both monotone in the true merit of the BladeCurves,

    merit = value - rho_T (excess of the torque limits) - rho_b (excess of the blade cap).

1. Trust region: solve a convex subproblem in a box around the profile, with the curvature of
   the loads where it is convex; where the step gains much less than promised, bring it back to
   the promised loads; judge it by the ratio of true to promised gain, grow or shrink the box.
2. Cells: with every station confined to the segment it stands on, all loads are affine and the
   subproblem *is* the problem, so one solve gives the cell's exact optimum.  A station that
   ends on the edge of its segment is moved to the neighbouring one when the multipliers say
   that the neighbour's slopes gain.  Cells share the edge, so the merit never falls; when no
   move gains, the profile is a local optimum of the piecewise-linear problem.

Phase 1 alone stalls on the kinks of the loads, where no single slope describes both sides.
What is walked on, one problem (:mod:`pitchopt.design.scp`) or several winds at once
(:mod:`pitchopt.design.joint_scp`), brings its subproblem, cells and merit.
Reference for phase 1: paper 003, section IV.B.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Generic, Protocol, TypeVar

import numpy as np
from numpy.typing import NDArray

from pitchopt.design.results import Status

__all__ = ["PENALTY_START", "Answer", "Merit", "ScpSettings", "Walk"]

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.intp]

PENALTY_START = 10.0
_PENALTY_MAX = 1e7
_CHORD = 0.2  # of the trust region, over which curvature is taken
_LAST_RADIUS = 3e-4  # [rad], of the steps without curvature that end phase 1
_WELL_OFF = 2e-5  # share of torque gained by cells that shows a stall of phase 1
_POOR = 0.75  # share of the promised gain below which a step is brought back to its loads
_SLOW = 25  # cells that together gain less than ten times the finishing gain end the walk


@dataclass(frozen=True, kw_only=True)
class ScpSettings:
    """Numbers that steer the local solve.

    Attributes
    ----------
    radius : float
        First half-width of the trust region [rad].
    least_radius : float
        Half-width below which phase 1 hands over [rad].
    tolerance : float
        Promised gain, as a share of the torque scale, at which phase 1 hands over.
    finish : float
        Gain, as a share of the torque scale, below which phase 2 ends (ten times that over 25
        cells together).
    max_steps, max_cells : int
        Limits on the subproblems of the two phases.
    coarse : bool
        Start on fewer rotor positions where there are many.
    """

    radius: float = np.radians(3.0)
    least_radius: float = 1e-6
    tolerance: float = 5e-7
    finish: float = 1e-8
    max_steps: int = 40
    max_cells: int = 250
    coarse: bool = True

    def rough(self) -> ScpSettings:
        """Good enough to tell starts apart; the best of them is finished in full."""
        return replace(self, tolerance=5e-4, max_steps=15, max_cells=0)

    def finishing(self) -> ScpSettings:
        """From the end of a rough solve."""
        return replace(self, radius=min(self.radius, float(np.radians(0.5))))


class Answer(Protocol):
    """What a subproblem returns, as far as the walk looks at it."""

    @property
    def profile(self) -> FloatArray:
        """Pitch of all stations [rad]."""
        ...

    @property
    def value(self) -> float:
        """Value that the model promises [N m]."""
        ...

    @property
    def solved(self) -> bool:
        """False when every fallback failed."""
        ...


class Merit(Protocol):
    """True merit of profiles, with the exact-penalty weights of the moment."""

    penalty: tuple[float, float]
    scale: float

    def __call__(self, profile: FloatArray) -> float:
        """Value less the penalties [N m]."""
        ...

    def broken(self, profile: FloatArray, share: float) -> tuple[bool, bool]:
        """Whether torque limits and blade cap are missed by more than a share of their size."""
        ...

    def missed(self, profile: FloatArray) -> str:
        """By how much they are missed, for a message."""
        ...


A = TypeVar("A", bound=Answer)


class Walk(ABC, Generic[A]):
    """The two phases, for whatever has a merit, a repair, cells and a subproblem.

    Attributes
    ----------
    edges : ndarray (N, K)
        Edges of the cells of every station, in rising order; all loads are affine between
        neighbours.
    last : int or int ndarray (N,)
        Index of the last cell.
    """

    def __init__(
        self,
        start: FloatArray,
        *,
        merit: Merit,
        repaired: Callable[[FloatArray], FloatArray],
        edges: FloatArray,
        last: int | IntArray,
        settings: ScpSettings,
        should_stop: Callable[[], bool] | None,
    ) -> None:
        self.merit, self.repaired, self.settings = merit, repaired, settings
        self.edges, self.last_cell = edges, last
        self.should_stop = should_stop
        self.profile = repaired(start)
        self.best = merit(self.profile)
        self.scale = merit.scale
        self.history = [self.best]
        self.last: A | None = None
        self.curved = True  # whether the model has the curvature of the loads
        self.stalled = False  # whether the trust region shrank to nothing on kinks
        self.solves, self.solver_seconds, self.failures = 0, 0.0, 0
        self.kept = self.profile if self.feasible() else None  # the last feasible profile

    @abstractmethod
    def solve(self, low: FloatArray, high: FloatArray, segments: IntArray | None = None) -> A:
        """One subproblem around the profile, in a box or on one cell."""

    @abstractmethod
    def cell(self, profile: FloatArray) -> IntArray:
        """Cell that holds each station's pitch, shape (N,)."""

    @abstractmethod
    def reduced_slope(self, out: A, segment: IntArray) -> FloatArray:
        """Slope of the Lagrangian in each station's pitch on the given cells [N m/rad]."""

    def brought_back(self, out: A, candidate: FloatArray) -> FloatArray:
        """A step brought back to the loads that its model promised; itself where none can be."""
        del out
        return candidate

    def stopped(self) -> bool:
        """True when the caller wants the run to end."""
        return self.should_stop is not None and self.should_stop()

    def chord(self, low: FloatArray, high: FloatArray, segments: IntArray | None) -> float:
        """Half-width over which the model takes curvature [rad]; zero for none."""
        if segments is not None or not self.curved:
            return 0.0
        return max(_CHORD * float(np.max(high - low)) / 2, 1e-4)

    def accept(self, profile: FloatArray, merit: float) -> None:
        """Move to a profile."""
        self.profile, self.best = profile, merit
        self.history.append(merit)
        if self.feasible():
            self.kept = profile

    # ---- phase 1 ---------------------------------------------------------------------------

    def trust_region(self) -> bool:
        """Move to where the linear loads promise nothing more; False when steps ran out."""
        radius, self.curved, self.stalled = self.settings.radius, True, False
        for _ in range(self.settings.max_steps):
            if self.stopped():
                return False
            out = self.solve(self.profile - radius, self.profile + radius)
            if not out.solved:
                radius /= 4
                if radius < 1e-7:
                    return False
                continue
            candidate = self.repaired(out.profile)
            merit = self.merit(candidate)
            promised = out.value - self.best
            moved = float(np.max(np.abs(candidate - self.profile)))
            if promised <= self.settings.tolerance * self.scale:
                if merit > self.best:
                    self.accept(candidate, merit)
                if not self.curved:
                    self.stalled = radius < 0.1 * _LAST_RADIUS
                    return True
                # curvature over a chord hides gains on the segments themselves
                self.curved = False
                radius = min(radius, max(moved, _LAST_RADIUS))
                continue
            if merit - self.best < _POOR * promised:
                candidate, merit = self._restored(out, candidate, merit)
            ratio = (merit - self.best) / promised
            moved = float(np.max(np.abs(candidate - self.profile)))
            if ratio > 0.05:
                self.accept(candidate, merit)
            if ratio < 0.25:
                radius = 0.35 * min(radius, max(moved, 0.1 * radius))
                if radius < self.settings.least_radius:
                    self.stalled = True
                    return True
            elif ratio > 0.75 and moved > 0.8 * radius:
                radius *= 2.0
        return False

    def _restored(self, out: A, candidate: FloatArray, merit: float) -> tuple[FloatArray, float]:
        """The better of a candidate and its step brought back to the loads promised."""
        other = self.repaired(self.brought_back(out, candidate))
        value = self.merit(other)
        return (other, value) if value > merit else (candidate, merit)

    # ---- phase 2 ---------------------------------------------------------------------------

    def cells(self) -> bool:
        """Walk over segment cells to a local optimum; False when cells ran out."""
        rows = np.arange(self.profile.size)
        segment = self.cell(self.profile)
        threshold = self.settings.finish * self.scale
        trail: list[float] = []
        waiting: list[tuple[IntArray, FloatArray, IntArray]] = []
        for count in range(self.settings.max_cells):
            if self.stopped():
                return False
            low, high = self.edges[rows, segment], self.edges[rows, segment + 1]
            out = self.solve(low, high, segments=segment)
            if not out.solved:
                return False
            candidate = self.repaired(out.profile)
            merit = self.merit(candidate)
            gain = merit - self.best
            if gain > 0:
                self.accept(candidate, merit)
            trail.append(self.best)
            if len(trail) > _SLOW and trail[-1] - trail[-1 - _SLOW] < 10 * threshold:
                return True
            if gain <= threshold and count > 0:
                # the last set of moves gained nothing together: try its strongest half
                if not waiting:
                    return True
                old, strength, move = waiting.pop()
                keep = np.flatnonzero(move)
                if keep.size <= 1:
                    return True
                strongest = keep[np.argsort(-strength[keep])[: keep.size // 2]]
                half = np.zeros_like(move)
                half[strongest] = move[strongest]
                waiting.append((old, strength, half))
                segment = old + half
                continue
            move, strength = self._moves(out, segment, low, high)
            if not np.any(move):
                return True
            waiting = [(segment, strength, move)]
            segment = segment + move
        return False

    def _moves(
        self,
        out: A,
        segment: IntArray,
        low: FloatArray,
        high: FloatArray,
    ) -> tuple[IntArray, FloatArray]:
        """Stations on the edge of their segment whose neighbour's slopes gain."""
        last = self.last_cell
        edge = 1e-3 * (high - low) + 1e-10  # wider than the solver's accuracy
        up = (out.profile > high - edge) & (segment < last)
        down = (out.profile < low + edge) & (segment > 0)
        slope_up = self.reduced_slope(out, np.minimum(segment + 1, last))
        slope_down = -self.reduced_slope(out, np.maximum(segment - 1, 0))
        floor = 1e-6 * float(np.max(np.abs(self.reduced_slope(out, segment))))
        floor = max(floor, 1e-9 * self.scale)
        up &= slope_up > floor
        down &= slope_down > floor
        move = up.astype(np.intp) - (down & ~up).astype(np.intp)
        return move, np.where(up, slope_up, np.where(down, slope_down, 0.0))

    # ---- constraints with a penalty --------------------------------------------------------

    def raise_penalty(self) -> bool:
        """Make the penalties of violated constraints dearer; False when they are kept."""
        bad_torque, bad_blade = self.merit.broken(self.profile, 1e-7)
        if not bad_torque and not bad_blade:
            return False
        first, second = self.merit.penalty
        if max(first if bad_torque else 0.0, second if bad_blade else 0.0) >= _PENALTY_MAX:
            return False
        self.merit.penalty = (
            first * 10 if bad_torque else first,
            second * 10 if bad_blade else second,
        )
        self.best = self.merit(self.profile)
        if self.kept is not None and self.merit(self.kept) > self.best:
            self.accept(self.kept, self.merit(self.kept))
        return True

    def feasible(self) -> bool:
        """True when the profile keeps torque limits and blade cap."""
        return not any(self.merit.broken(self.profile, 1e-6))

    # ---- both together ---------------------------------------------------------------------

    def walk(self) -> tuple[Status, str]:
        """Both phases until no limit is broken; how it ended, in a word and a sentence."""
        settled = False
        for _ in range(10):
            self.trust_region()
            before = self.best
            settled = self.cells()
            if self.stalled and self.best - before > _WELL_OFF * self.scale:
                continue  # off the kinks that phase 1 stalled on
            if not self.raise_penalty():
                break
        lost = self.kept is not None and not self.feasible()
        if lost and self.kept is not None:
            self.profile = self.kept
        if self.failures and not settled:
            return Status.SOLVER_FAILED, "cone solver failed in every fallback"
        if not self.feasible():
            return Status.INFEASIBLE, self.merit.missed(self.profile)
        if not settled or lost:
            return Status.ITERATION_LIMIT, f"stopped after {self.solves} subproblems"
        return Status.CONVERGED, "no segment next to the profile gains more"
