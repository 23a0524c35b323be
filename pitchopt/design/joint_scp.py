"""The local solve of a joint problem: the walk of :mod:`pitchopt.design.walk` over all winds.

The merit is the joint objective on the true curves of every wind, less penalties on broken
limits.  A cell of the second phase is an interval between neighbouring breakpoints of *all*
winds of a station: every wind stays on one segment of its own there, and the subproblem is the
joint problem itself.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pitchopt.aero.curves import RotorLoads
from pitchopt.design.coarse import interpolated, stride
from pitchopt.design.joint import JointMultipliers, JointProblem
from pitchopt.design.joint_subproblem import JointSolution, solve_joint_subproblem
from pitchopt.design.restoration import restored
from pitchopt.design.results import Status
from pitchopt.design.scp import reduced_slope
from pitchopt.design.search import Start
from pitchopt.design.uniform import best_uniform
from pitchopt.design.walk import PENALTY_START, ScpSettings, Walk

__all__ = ["JointLocal", "best_joint", "joint_rank", "solve_joint"]

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.intp]

_FEWEST = 24  # positions that tell starts apart
_AGAIN = 2  # how many of them are told apart once more on the curves themselves
_LEAST_RADIUS = float(np.radians(0.02))  # smaller steps are taken faster on cells
_FINISH = 3e-7  # share of torque that a set of cells must gain for the walk to go on
_NEAR = 2e-2  # share of torque by which one may trail the best and still be among them


@dataclass(frozen=True, kw_only=True, eq=False)
class JointLocal:
    """A local optimum of a joint problem: profiles (S N,), loads and values of every wind."""

    profile: FloatArray
    loads: list[RotorLoads]
    values: FloatArray
    multipliers: JointMultipliers | None
    status: Status
    message: str
    start: str
    iterations: int
    seconds: float
    history: tuple[float, ...]


class _JointMerit:
    """True merit of profiles for all winds, with the exact-penalty weights of the moment."""

    def __init__(self, joint: JointProblem, start: FloatArray) -> None:
        self.joint = joint
        self.torques = np.array([abs(float(load.mean[0])) for load in joint.loads(start)])
        self.torques = np.maximum(self.torques, 1e-300)
        self.caps = np.array([objective.blade_cap for objective in joint.objectives])
        if joint.weights is not None:
            self.scale = float(joint.weights @ self.torques) or 1e-300
        else:
            self.scale = float(self.torques.max())
        price = max(1.0, *(max(objective.rms) for objective in joint.objectives))
        share = 1.0 if joint.weights is None else max(1.0, float(joint.weights.max()))
        self.penalty = (PENALTY_START * share, PENALTY_START * share * price)

    def __call__(self, profile: FloatArray) -> float:
        loads = self.joint.loads(profile)
        torque, blade = self.joint.excess(loads).sum(axis=0)
        value = self.joint.total(self.joint.values(profile, loads))
        return float(value - self.penalty[0] * torque - self.penalty[1] * blade)

    def broken(self, profile: FloatArray, share: float) -> tuple[bool, bool]:
        torque, blade = self.joint.excess(self.joint.loads(profile)).T
        return bool(np.any(torque > share * self.torques)), bool(np.any(blade > share * self.caps))

    def missed(self, profile: FloatArray) -> str:
        torque, blade = self.joint.excess(self.joint.loads(profile)).max(axis=0)
        return f"torque limit missed by {torque:.4g} N m, blade cap by {blade:.4g} N m"


class _JointRun(Walk[JointSolution]):
    """The local solve of a joint problem."""

    def __init__(
        self,
        joint: JointProblem,
        start: FloatArray,
        settings: ScpSettings,
        should_stop: Callable[[], bool] | None,
    ) -> None:
        edges, last = joint.edges
        super().__init__(
            start,
            merit=_JointMerit(joint, joint.repaired(start)),
            repaired=joint.repaired,
            edges=edges,
            last=last,
            settings=settings,
            should_stop=should_stop,
        )
        self.joint = joint

    def cell(self, profile: FloatArray) -> IntArray:
        """Cell between the breakpoints of all winds that holds each station's pitch."""
        below = np.sum(self.edges <= profile[:, None], axis=1) - 1
        return np.asarray(np.clip(below, 0, self.last_cell))

    def solve(
        self, low: FloatArray, high: FloatArray, segments: IntArray | None = None
    ) -> JointSolution:
        """One subproblem; a failure is tried again with the other scaling."""
        point = np.clip(self.profile, low, high)
        chord = self.chord(low, high, segments)
        for tight in (False, True):
            self.solves += 1
            out = solve_joint_subproblem(
                self.joint,
                point,
                low=low,
                high=high,
                penalty=self.merit.penalty,
                on_cells=segments is not None,
                tight=tight,
                chord=chord,
                multipliers=self._multipliers() if chord > 0 else None,
            )
            self.solver_seconds += out.solve_seconds
            if out.solved:
                self.last = out
                return out
        self.failures += 1
        return out

    def brought_back(self, out: JointSolution, candidate: FloatArray) -> FloatArray:
        """Profiles of a single wind brought back to the loads that their model promised."""
        joint = self.joint
        before, after = joint.split(self.profile), np.array(joint.split(candidate))
        winds = np.asarray(joint.profile_of)
        for w, s in enumerate(joint.profile_of):
            if np.count_nonzero(winds == s) == 1:
                problem = joint.problems[w]
                point = np.clip(before[s], problem.curves.lower, problem.curves.upper)
                price = out.multipliers.winds[w].cap
                after[s] = restored(problem, joint.objectives[w], point, after[s], cap_price=price)
        return after.ravel()

    def _multipliers(self) -> JointMultipliers:
        """Those of the last subproblem; at first equal shares of the winds and nothing else."""
        return self.joint.no_multipliers if self.last is None else self.last.multipliers

    def reduced_slope(self, out: JointSolution, segment: IntArray) -> FloatArray:
        """Slope of the Lagrangian of all winds in each station's pitch [N m/rad]."""
        joint, mult = self.joint, out.multipliers
        rows = np.arange(segment.size)
        middle = joint.split(0.5 * (self.edges[rows, segment] + self.edges[rows, segment + 1]))
        slope = mult.rate - np.roll(mult.rate, 1, axis=1) - mult.basis
        slope[:-1] += mult.link
        slope[1:] -= mult.link
        for w, s in enumerate(joint.profile_of):
            curves, objective = joint.problems[w].curves, joint.objectives[w]
            slope[s] += reduced_slope(
                curves,
                float(mult.shares[w]) * objective.torque,
                mult.winds[w],
                curves.segment(middle[s]),
            )
        return slope.ravel()


def solve_joint(
    joint: JointProblem,
    start: Start,
    *,
    settings: ScpSettings | None = None,
    should_stop: Callable[[], bool] | None = None,
) -> JointLocal:
    """Local optimum of a joint problem from one start.

    Parameters
    ----------
    joint : JointProblem
    start : Start
        First profiles, shape (S N,) [rad]; moved to the nearest feasible ones.
    settings : ScpSettings, optional
    should_stop : callable, optional
        Asked before every subproblem; True ends the run with what it has.
    """
    began = time.perf_counter()
    if joint.constant_only:
        return _solve_uniform(joint, start)
    settings = settings or ScpSettings(least_radius=_LEAST_RADIUS)
    run = _JointRun(joint, start.profile, settings, should_stop)
    status, message = run.walk()
    loads = joint.loads(run.profile)
    return JointLocal(
        profile=run.profile,
        loads=loads,
        values=joint.values(run.profile, loads),
        multipliers=None if run.last is None else run.last.multipliers,
        status=status,
        message=message,
        start=start.label,
        iterations=run.solves,
        seconds=time.perf_counter() - began,
        history=tuple(run.history),
    )


def _solve_uniform(joint: JointProblem, start: Start) -> JointLocal:
    """The best constant pitch of one profile, where the limits leave nothing else."""
    began = time.perf_counter()

    def score(pitch: float) -> float:
        return joint_rank(joint, np.full(joint.stations, pitch))

    pitch, tried = best_uniform(joint.problems, joint.objectives, score)
    profile = np.full(joint.stations, pitch)
    loads = joint.loads(profile)
    merit = _JointMerit(joint, profile)
    status, message = Status.CONVERGED, "limits leave constant pitch only"
    if any(merit.broken(profile, 1e-6)):
        status, message = Status.INFEASIBLE, f"{message}; {merit.missed(profile)}"
    return JointLocal(
        profile=profile,
        loads=loads,
        values=joint.values(profile, loads),
        multipliers=None,
        status=status,
        message=message,
        start=start.label,
        iterations=tried,
        seconds=time.perf_counter() - began,
        history=(merit(profile),),
    )


def best_joint(
    joint: JointProblem, starts: Sequence[Start], *, settings: ScpSettings | None = None
) -> JointLocal:
    """Best of the local solutions from several starts.

    They are told apart by rough solves on smoothed curves, at fewer rotor positions where there
    are many, and the best few once more by rough solves on the curves themselves; the best of
    those is finished.  With many winds the cells are narrow and many of them gain next to
    nothing, so that the walk over them ends sooner than that of one wind.
    """
    full = settings or ScpSettings(least_radius=_LEAST_RADIUS, finish=_FINISH)
    if joint.constant_only:
        return solve_joint(joint, starts[0])
    step = stride(joint.problems[0].curves.positions, _FEWEST)
    screened = (joint.thinned(step) if step > 1 else joint).softened
    rough = []
    for start in starts:
        few = joint.split(start.profile)[:, ::step].ravel()
        found = solve_joint(screened, Start(label=start.label, profile=few), settings=full.rough())
        profile = joint.repaired(interpolated(screened.split(found.profile), step).ravel())
        rough.append((joint_rank(joint, profile), Start(label=start.label, profile=profile)))
    rough.sort(key=lambda one: -one[0])
    near = rough[0][0] - _NEAR * _JointMerit(joint, rough[0][1].profile).scale
    again = full.finishing().rough()
    ends = [
        solve_joint(joint, start, settings=again) for rank, start in rough[:_AGAIN] if rank >= near
    ]
    best = max(ends, key=lambda found: joint_rank(joint, found.profile))
    return solve_joint(
        joint, Start(label=best.start, profile=best.profile), settings=full.finishing()
    )


def joint_rank(joint: JointProblem, profile: FloatArray) -> float:
    """Value to compare profiles by; broken limits weigh more than any value."""
    merit = _JointMerit(joint, profile)
    value = joint.total(joint.values(profile))
    torque, blade = joint.excess(joint.loads(profile)).T
    with np.errstate(invalid="ignore"):
        broken = float(np.sum(torque / merit.torques) + np.sum(blade / merit.caps))
    price = merit.penalty[1] / PENALTY_START
    return value - (1e3 * merit.scale * price * broken if broken > 2e-6 else 0.0)
