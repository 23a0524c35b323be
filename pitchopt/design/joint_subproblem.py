"""The convex subproblem of a joint problem: blocks of several profiles and winds in one program.

    maximise   sum_w p_w value_w - rho . slack            or   - r - rho . slack
    subject to value_w >= V*_w - r                              (largest regret only)
               |beta_n^(s+1) - beta_n^(s)| <= C,  and the rows of every block,

with value_w the model of :mod:`pitchopt.design.blocks`.  The multipliers of the regret rows sum
to one and weigh the winds as p_w does.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from pitchopt.design.blocks import CurveBlock, ProfileBlock, bend
from pitchopt.design.cones import ConeProgram
from pitchopt.design.joint import JointMultipliers, JointProblem
from pitchopt.design.linear import LinearModel

__all__ = ["JointSolution", "solve_joint_subproblem"]

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.intp]


@dataclass(frozen=True, kw_only=True, eq=False)
class JointSolution:
    """Profiles (S N,), model value [N m], multipliers and the solver's own word on them."""

    profile: FloatArray
    value: float
    multipliers: JointMultipliers
    solved: bool
    solve_seconds: float


def solve_joint_subproblem(
    joint: JointProblem,
    point: FloatArray,
    *,
    low: FloatArray,
    high: FloatArray,
    penalty: tuple[float, float],
    on_cells: bool = False,
    tight: bool = False,
    chord: float = 0.0,
    multipliers: JointMultipliers | None = None,
) -> JointSolution:
    """Solve around ``point`` inside the box.

    Parameters
    ----------
    joint : JointProblem
    point, low, high : array (S N,)
        Profiles and their box [rad]; the box is cut at the pitch limits.
    penalty : (float, float)
        Exact-penalty weights of the torque limits [-] and of the blade caps [-].
    on_cells : bool
        The box is a cell: every wind stays on one segment, where torque is affine too.
    tight, chord : bool, float
        As in :meth:`pitchopt.design.direct.Subproblem.solve`.
    multipliers : JointMultipliers, optional
        With a chord: the curvature of the loads, weighted by these, enters the objective where
        it is convex.  So does that of torque where several winds share a profile, in place of
        the segments of each, which would be most of the rows.
    """
    low = np.maximum(low, np.concatenate([p.curves.lower for p in joint.leaders]))
    high = np.minimum(high, np.concatenate([p.curves.upper for p in joint.leaders]))
    radius = max(float(np.max(np.maximum(high - point, point - low))), 1e-9)
    at, lows, highs = joint.split(point), joint.split(low), joint.split(high)
    program = ConeProgram()
    profiles = [
        ProfileBlock(program, problem, at[s], lows[s], highs[s], radius)
        for s, problem in enumerate(joint.leaders)
    ]
    blocks: list[CurveBlock] = []
    bends = np.zeros(joint.count * joint.stations)
    for w, (problem, s) in enumerate(zip(joint.problems, joint.profile_of, strict=True)):
        segments = problem.curves.segment(0.5 * (lows[s] + highs[s])) if on_cells else None
        model = LinearModel(problem, at[s], segments, lows[s], highs[s], chord, radius)
        bent = model.curvature is not None and multipliers is not None
        curved = bent and len(joint.followers(s)) > 1
        block = CurveBlock(
            program, profiles[s], model, joint.objectives[w], tight=tight, curved=curved
        )
        if bent and multipliers is not None:
            own, price = multipliers.winds[w], 0.0
            if curved:
                price = float(multipliers.shares[w]) * joint.objectives[w].torque
                price += own.torque_min - own.torque_max
            joint.split(bends)[s] += bend(model, own, price)
        blocks.append(block)
    if np.any(bends):
        program.quadratic = bends * radius**2
    for s, profile in enumerate(profiles):
        if any(joint.objectives[w].travel > 0 for w in joint.followers(s)):
            profile.add_travel(program)
    constant, regret = _goal(program, joint, blocks)
    for profile in profiles:
        profile.constrain(program)
    links = _links(program, joint, profiles)
    for block in blocks:
        block.constrain(program, penalty)
    solution = program.solve(reduced=tight)
    x = solution.x if solution.solved else np.zeros(program.width)
    z = solution.z if solution.solved else np.zeros(program.height)
    shares = joint.weights
    if shares is None:
        assert regret is not None
        shares = np.maximum(z[regret[0]], 0.0) / regret[1]
    v = np.zeros((joint.count - 1, joint.stations))
    for s, rows, near, sign in links:
        v[s, near] += sign * z[rows] / radius
    return JointSolution(
        profile=np.concatenate([profile.profile(x) for profile in profiles]),
        value=constant - program.value(x) if solution.solved else -np.inf,
        multipliers=JointMultipliers(
            shares=shares,
            winds=tuple(block.multipliers(z) for block in blocks),
            rate=np.stack([profile.rate(z) for profile in profiles]),
            link=v,
            basis=np.stack([profile.basis(z) * np.ones(joint.stations) for profile in profiles]),
        ),
        solved=solution.solved,
        solve_seconds=solution.seconds,
    )


def _goal(
    program: ConeProgram, joint: JointProblem, blocks: list[CurveBlock]
) -> tuple[float, tuple[slice, float] | None]:
    """Costs of the joint objective; its constant, and the regret rows with their unit."""
    if joint.weights is not None:
        for share, block in zip(joint.weights, blocks, strict=True):
            for columns, values in block.costs:
                program.add_cost(columns, share * values)
        return float(joint.weights @ [block.constant for block in blocks]), None
    assert joint.targets is not None
    unit = max(block.unit for block in blocks)
    r = program.variables("regret", 1, cost=unit).start
    gaps = np.array([t - b.constant for t, b in zip(joint.targets, blocks, strict=True)])
    base = float(gaps.max())
    entries = [
        (np.full(columns.size, w), columns, values / unit)
        for w, block in enumerate(blocks)
        for columns, values in block.costs
    ]
    winds = np.arange(len(blocks))
    rows = program.nonneg(
        (base - gaps) / unit, *entries, (winds, np.full(winds.size, r), -np.ones(winds.size))
    )
    return -base, (rows, unit)


def _links(
    program: ConeProgram, joint: JointProblem, profiles: list[ProfileBlock]
) -> list[tuple[int, slice, IntArray, float]]:
    """Rows of the change between neighbouring profiles, those out of reach left out."""
    links: list[tuple[int, slice, IntArray, float]] = []
    if np.isinf(joint.change):
        return links
    for s, (one, two) in enumerate(pairwise(profiles)):
        gap = (two.point - one.point) / one.radius
        for sign in (1.0, -1.0):
            room = joint.change / one.radius - sign * gap
            near = np.flatnonzero(room < 2.0)
            k = np.arange(near.size)
            rows = program.nonneg(
                room[near], (k, two.pitch + near, sign), (k, one.pitch + near, -sign)
            )
            links.append((s, rows, near, sign))
    return links
