"""One node of the branch and bound: making a region smaller, bounding it, splitting it.

Every change of a region is one :class:`Step`, and :func:`done` is the only code that carries
steps out, so that a stored list of steps replays to the same region.  Where multipliers come
from plays no part in it: a cone solver proposes them, rounded to single precision, and only what
:func:`pitchopt.design.proof.region.dual_step` makes of them counts.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from pitchopt.design.multipliers import Multipliers
from pitchopt.design.proof.region import Frame, Region, dual_step, tightened
from pitchopt.design.relaxation import HullSolution, solve_hull

__all__ = ["Branch", "Node", "Step", "bounded", "done", "packed", "row_width", "split", "unpacked"]

FloatArray = NDArray[np.float64]
Single = NDArray[np.float32]

_COLUMNS = 3  # breakpoints inside an interval that enter the relaxation
_TOLERANCE = 1e-5  # of the cone solver: multipliers need no more
_SHRUNK = 0.8  # a region is bounded anew when its size has fallen by this much
_AGAIN = 0.8  # and once more when the bound has made it smaller still
_NARROW = 1e-9  # [rad]; intervals that are not split any more


@dataclass(frozen=True, kw_only=True, eq=False)
class Step:
    """One change of a region: a dual step at ``multipliers``, or tightening when None."""

    multipliers: Single | None = None
    passes: int = 0
    slices: int = 0


@dataclass(frozen=True, kw_only=True)
class Branch:
    """How a region came out of its parent's.

    Attributes
    ----------
    load : int
        Mean of torque, tilt, yaw or thrust that was split (0 to 3), or -1.
    station : int
        Station whose pitch was split, or -1.
    value : float
        Where [N m], [N] or [rad].
    above : bool
        The upper part.
    """

    load: int
    station: int
    value: float
    above: bool

    def taken(self, region: Region) -> Region | None:
        """That part of a region; None when it has none there."""
        part = self._part(region)
        return None if part.empty else part

    def _part(self, region: Region) -> Region:
        if self.load >= 0:
            means = region.means.copy()
            if self.above:
                means[self.load, 0] = max(means[self.load, 0], self.value)
            else:
                means[self.load, 1] = min(means[self.load, 1], self.value)
            return replace(region, means=means)
        lower, upper = region.lower.copy(), region.upper.copy()
        if self.above:
            lower[self.station] = max(lower[self.station], self.value)
        else:
            upper[self.station] = min(upper[self.station], self.value)
        return replace(region, lower=lower, upper=upper)


@dataclass(kw_only=True, eq=False)
class Node:
    """A region with its bound and how it was reached.

    Attributes
    ----------
    region : Region or None
        None when nothing in it is worth the cut.
    bound : float
        Upper bound on the objective in the region [N m].
    branch : Branch or None
        None for the root.
    steps : list of Step
        What was done to the region after the branch.
    cut : float
        The cut that the steps used [N m].
    lost : float
        Upper bound on the objective of what the steps cut off [N m].
    multipliers : float32 array or None
        The best so far, for regions inside this one.
    profile : ndarray (N,) or None
        Pitch that the last relaxation implies [rad].
    solved_size : float
        Size of the region at the last relaxation.
    """

    region: Region | None
    bound: float
    branch: Branch | None
    cut: float
    steps: list[Step] = field(default_factory=list)
    lost: float = -np.inf
    multipliers: Single | None = None
    profile: FloatArray | None = None
    solved_size: float = np.inf


def packed(frame: Frame, mult: Multipliers) -> Single:
    """Multipliers as one row of single precision: loads, rate, box, cap, mean, blade."""
    parts = [mult.loads.ravel(), mult.rate, mult.box, np.array([mult.cap, mult.mean])]
    if _has_blade(frame):
        parts.append(mult.blade)
    row: FloatArray = np.nan_to_num(np.concatenate(parts))
    most = float(np.finfo(np.float32).max)
    return np.asarray(np.clip(row, -most, most), dtype=np.float32)


def unpacked(frame: Frame, row: Single) -> Multipliers:
    """The multipliers of a row that :func:`packed` made."""
    values = row.astype(np.float64)
    n, m = frame.stations, frame.positions
    rest = values[4 * m + n :]
    return Multipliers(
        loads=values[: 4 * m].reshape(4, m),
        rate=values[4 * m : 4 * m + n],
        blade=rest[6:] if _has_blade(frame) else np.zeros(n),
        box=rest[:4],
        cap=float(rest[4]),
        mean=float(rest[5]),
    )


def row_width(frame: Frame) -> int:
    """Numbers in a packed row."""
    return 4 * frame.positions + frame.stations * (1 + _has_blade(frame)) + 6


def _has_blade(frame: Frame) -> bool:
    return bool(frame.lambdas[4] > 0 or np.isfinite(frame.objective.blade_cap))


def done(frame: Frame, node: Node, step: Step) -> bool:
    """Carry out a step on a node and record it; False when nothing is left of the region."""
    assert node.region is not None
    if step.multipliers is None:
        node.region = tightened(
            frame, node.region, node.cut, passes=step.passes, slices=step.slices
        )
    else:
        mult = unpacked(frame, step.multipliers)
        found, node.region = dual_step(frame, node.region, mult, node.cut)
        node.bound = min(node.bound, found)
    node.lost = max(node.lost, min(node.cut, node.bound))
    node.steps.append(step)
    return node.region is not None


def bounded(
    frame: Frame, node: Node, *, rounds: int = 2, passes: int = 6, slices: int = 16
) -> Node:
    """Tighten a node's region, bound it, and tighten it with what the bound says.

    The relaxation is solved only where the region has become much smaller than at the last
    solution, because its bound falls with the square of the widths.
    """
    narrow = Step(passes=passes, slices=slices)
    if node.region is None or not done(frame, node, narrow):
        return node
    assert node.region is not None
    if node.multipliers is not None and not done(frame, node, Step(multipliers=node.multipliers)):
        return node
    if node.region.size > _SHRUNK * node.solved_size:
        return node
    for _ in range(rounds):
        before = node.region.size
        best = node.bound
        row = _relaxed(frame, node)
        if row is None:
            break
        if not done(frame, node, Step(multipliers=row)):
            return node
        if node.bound < best or node.multipliers is None:
            node.multipliers = row
        if not done(frame, node, narrow):
            return node
        if node.region.size > _AGAIN * before:
            break
    node.solved_size = node.region.size
    return node


def _relaxed(frame: Frame, node: Node) -> Single | None:
    """Multipliers from the hull relaxation of a node; None when the solver failed."""
    region = node.region
    assert region is not None
    station, pitch, loads = _columns(frame, region)
    solved = solve_hull(
        frame.problem,
        frame.objective,
        station,
        pitch,
        loads,
        region.means,
        tolerance=_TOLERANCE,
    )
    if solved is None:
        return None
    if solved.infeasible:
        return _along_ray(frame, node, solved)
    node.profile = np.clip(solved.profile, region.lower, region.upper)
    return packed(frame, solved.multipliers)


def _along_ray(frame: Frame, node: Node, solved: HullSolution) -> Single | None:
    """Multipliers far enough along a ray of infeasibility to bring the bound below the cut."""
    assert node.region is not None
    base = (
        Multipliers.zero(frame.stations, frame.positions)
        if node.multipliers is None
        else unpacked(frame, node.multipliers)
    )
    ray = solved.multipliers
    for length in 10.0 ** np.arange(-2, 9):
        moved = replace(
            base,
            rate=base.rate + length * ray.rate,
            box=base.box + length * ray.box,
            cap=base.cap + length * ray.cap,
            mean=base.mean + length * ray.mean,
            blade=base.blade + length * ray.blade,
        )
        row = packed(frame, moved)
        if dual_step(frame, node.region, unpacked(frame, row), node.cut)[1] is None:
            return row
    return None


def _columns(frame: Frame, region: Region) -> tuple[NDArray[np.intp], FloatArray, FloatArray]:
    """Ends of the intervals and some breakpoints inside them, station by station."""
    beta, curves = frame.beta, frame.problem.curves
    lower, upper = region.lower[:, None], region.upper[:, None]
    inside = (beta > lower + _NARROW) & (beta < upper - _NARROW)
    rank, count = np.cumsum(inside, axis=1), inside.sum(axis=1, keepdims=True)
    share = np.maximum(count, 1)
    thin = (rank * _COLUMNS) // share != ((rank - 1) * _COLUMNS) // share
    inner, j = np.nonzero(inside & ((count <= _COLUMNS) | thin))
    stations = np.arange(frame.stations)
    wide = np.flatnonzero(region.widths > _NARROW)
    station = np.concatenate([stations, inner, wide])
    pitch = np.concatenate([region.lower, beta[inner, j], region.upper[wide]])
    loads = np.concatenate(
        [
            curves.contributions(region.lower),
            frame.loads[:, inner, j],
            curves.contributions(region.upper)[:, wide],
        ],
        axis=1,
    )
    order = np.argsort(station, kind="stable")
    return station[order], pitch[order], loads[:, order]


def split(frame: Frame, node: Node, cut: float) -> list[Node]:
    """The two parts of a node, by the split that leaves the least behind; empty if too narrow.

    Tried are the means of the four loads, the pitch of the station whose curve is farthest below
    its hull at the relaxed optimum, and the widest interval.
    """
    best: tuple[float, Branch] | None = None
    assert node.region is not None
    for branch in _candidates(frame, node):
        left = 0.0
        for above in (False, True):
            small = replace(branch, above=above).taken(node.region)
            if small is not None:
                small = tightened(frame, small, cut, passes=1, slices=16)
            left += 0.0 if small is None else small.size
        if best is None or left < best[0]:
            best = left, branch
    if best is None:
        return []
    return [
        Node(
            region=replace(best[1], above=above).taken(node.region),
            bound=node.bound,
            branch=replace(best[1], above=above),
            cut=cut,
            multipliers=node.multipliers,
            profile=node.profile,
            solved_size=node.solved_size,
        )
        for above in (False, True)
    ]


def _candidates(frame: Frame, node: Node) -> list[Branch]:
    region = node.region
    assert region is not None
    spans = region.means[:, 1] - region.means[:, 0]
    floor = 1e-9 * np.abs(region.means).max(axis=1) + frame.pads
    out = [
        Branch(load=q, station=-1, value=float(region.means[q].mean()), above=False)
        for q in np.flatnonzero(spans > floor).tolist()
    ]
    widths = region.widths
    chosen = [int(np.argmax(widths))]
    if node.multipliers is not None and node.profile is not None:
        from pitchopt.design.proof import kernels

        coefficients = frame.coefficients(frame.prepared(unpacked(frame, node.multipliers)))
        lower, upper = region.lower, region.upper
        maxima = kernels.linear_maxima(frame.beta, frame.loads, coefficients, lower, upper)
        at = np.clip(node.profile, lower, upper)
        values = kernels.linear_maxima(frame.beta, frame.loads, coefficients, at, at)
        chosen.insert(0, int(np.argmax(np.where(widths > _NARROW, maxima - values, -1.0))))
    for n in dict.fromkeys(chosen):
        if widths[n] > 10 * _NARROW:
            middle = float(0.5 * (region.lower[n] + region.upper[n]))
            out.append(Branch(load=-1, station=n, value=middle, above=False))
    return out
