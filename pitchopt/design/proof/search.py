"""Branch and bound: how near a profile is to the global optimum, proven.

The regions of :mod:`pitchopt.design.proof.region` are split and bounded, the one with the largest
bound first.  The bound of a region falls with the square of its pitch intervals, and these
shrink as the means of the loads are confined: with torque, tilt and yaw known, three blades have
few pitches left.  Splitting the pitch itself is what makes the search converge.

All regions of a round are chosen before any is worked on, a fixed number in each round, so that
the tree is the same for any number of workers.  The search can be stopped at any time; what is
proven then is the largest bound of the regions that are left.
"""

from __future__ import annotations

import heapq
import time
from collections.abc import Callable
from concurrent.futures import Executor
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from pitchopt.checks import finite_number, whole_number
from pitchopt.design.multipliers import Multipliers
from pitchopt.design.problem import DesignProblem, Objective
from pitchopt.design.proof.node import Node, bounded, packed, split
from pitchopt.design.proof.record import Proof, TreeRecorder, replayed
from pitchopt.design.proof.region import Frame
from pitchopt.design.scp import ScpSettings, solve_local

__all__ = ["FIRST_GAP", "ProofSettings", "ProvenBound", "prove", "prove_in_stages"]

FloatArray = NDArray[np.float64]
GapProgress = Callable[[float, int, int], None]

FIRST_GAP = 0.01
_ROUND = 16  # regions in one round
_LOCAL_EVERY = 128  # of the regions split, one starts a local solve


@dataclass(frozen=True, kw_only=True)
class ProofSettings:
    """When the search ends.

    Attributes
    ----------
    gap : float
        Bound minus objective, as a share of ``scale``, that is good enough.
    seconds : float
        Time limit; the round that is under way is finished.
    regions : int
        At most so many regions.
    executor : concurrent.futures.Executor, optional
        Works on the regions of a round; the tree does not depend on it.
    workers : int
        Into how many parts a round is divided for the executor.
    """

    gap: float = 1e-3
    seconds: float = 300.0
    regions: int = 1_000_000
    executor: Executor | None = None
    workers: int = 1

    def __post_init__(self) -> None:
        finite_number("gap", self.gap, above=0)
        finite_number("seconds", self.seconds, at_least=0)
        whole_number("regions", self.regions, at_least=1)
        whole_number("workers", self.workers, at_least=1)


@dataclass(frozen=True, kw_only=True, eq=False)
class ProvenBound:
    """What the search proved.

    Attributes
    ----------
    upper_bound : float
        On the objective of every feasible profile [N m].
    gap : float
        (bound - objective of the best profile) / scale.
    profile : ndarray (N,)
        The best profile known at the end.
    value : float
        Its objective [N m].
    improved : bool
        True when it is better than the one that came in.
    ended : str
        ``gap reached``, ``time limit``, ``region limit``, ``interrupted``, ``better profile`` or
        ``nothing left to split``.
    regions, open_regions : int
    seconds : float
    history : tuple of (float, int, float)
        Seconds, regions and gap after every round.
    proof : Proof
    """

    upper_bound: float
    gap: float
    profile: FloatArray
    value: float
    improved: bool
    ended: str
    regions: int
    open_regions: int
    seconds: float
    proof: Proof
    history: tuple[tuple[float, int, float], ...] = field(default=())


@dataclass(frozen=True, kw_only=True, eq=False)
class _Parts:
    """What became of one region: its two parts, and a local solution that started in it."""

    nodes: list[Node]
    profile: FloatArray | None


def _worked(frame: Frame, node: Node, cut: float, local: bool) -> _Parts:
    """Split a region and bound its parts; runs in a worker."""
    nodes = [bounded(frame, part) for part in split(frame, node, cut)]
    profile = None
    if local and node.profile is not None:
        solution = solve_local(
            frame.problem,
            frame.given,
            node.profile,
            settings=ScpSettings(radius=float(np.radians(1.0)), max_steps=12, max_cells=20),
        )
        if solution.status.ok or solution.status.value == "iteration limit":
            profile = solution.profile
    return _Parts(nodes=nodes, profile=profile)


def _many(frame: Frame, work: list[tuple[Node, float, bool]]) -> list[_Parts]:
    return [_worked(frame, *one) for one in work]


def prove(
    problem: DesignProblem,
    objective: Objective,
    profile: FloatArray,
    *,
    scale: float,
    multipliers: Multipliers | None = None,
    settings: ProofSettings | None = None,
    resume: Proof | None = None,
    enough: float = np.inf,
    progress: GapProgress | None = None,
) -> ProvenBound:
    """Bound the objective of every feasible profile by branch and bound.

    An interrupt from the keyboard ends the search with what is proven by then.

    Parameters
    ----------
    problem, objective
        The design problem; harmonics are left out (the bound of the wider problem).
    profile : array (N,)
        The best profile known.
    scale : float
        What gaps are counted in [N m], usually the largest mean torque.
    multipliers : Multipliers, optional
        Those of the hull relaxation.
    settings : ProofSettings, optional
    resume : Proof, optional
        The tree of an earlier search on the same problem and objective, to go on from.
    enough : float
        End as soon as a profile is found that is better than the first by this much [N m].
    progress : callable, optional
        Called with the gap, the regions so far and the regions open.

    Raises
    ------
    InputError
        If the tree to go on from is about another problem.
    """
    began = time.perf_counter()
    scale = finite_number("scale", scale, above=0)
    settings = settings or ProofSettings()
    frame = Frame(problem, objective)
    state = _State(frame, profile, scale, settings)
    first = state.value
    if resume is None:
        root = Node(region=frame.first(), bound=np.inf, branch=None, cut=state.cut)
        if multipliers is not None:
            root.multipliers = packed(frame, multipliers)
        state.add(bounded(frame, root, rounds=4), -1)
    else:
        for node, parent, is_leaf in replayed(frame, resume):
            state.add(node, parent, is_open=is_leaf)
    history = [state.mark(began)]
    ended = state.ended(began)
    while ended is None:
        work = state.round()
        try:
            results = _spread(frame, work, state)
        except KeyboardInterrupt:
            state.put_back(work)
            ended = "interrupted"
            break
        for parts, (number, node) in zip(results, work, strict=True):
            state.take(parts, number, node)
        history.append(state.mark(began))
        if progress is not None:
            progress(history[-1][2], history[-1][1], len(state.heap))
        ended = state.ended(began)
        if ended is None and state.value - first >= enough:
            ended = "better profile"
    bound = state.bound()
    return ProvenBound(
        upper_bound=bound,
        gap=(bound - state.value) / scale,
        profile=state.profile,
        value=state.value,
        improved=state.improved,
        ended=ended,
        regions=state.count,
        open_regions=len(state.heap) + len(state.narrow),
        seconds=time.perf_counter() - began,
        history=tuple(history),
        proof=state.recorder.proof(bound),
    )


def prove_in_stages(
    problem: DesignProblem,
    objective: Objective,
    profile: FloatArray,
    *,
    scale: float,
    settings: ProofSettings,
    multipliers: Multipliers | None = None,
    enough: float = np.inf,
    resume: Proof | None = None,
    progress: GapProgress | None = None,
) -> ProvenBound:
    """As :func:`prove`, but on the way to a small gap a proof of 0.9 % comes first.

    A search prunes with its own gap, and one for a small gap has little to show for most of its
    time.  What comes back is the smaller bound of the two, and the better profile.  A tree to go
    on from that was pruned with a larger gap than is wanted now cannot lead there; it is left,
    and the search begins anew.
    """
    value = problem.value(profile, objective)
    if resume is not None and np.any(resume.cut > value + settings.gap * scale):
        resume = None
    targets = [settings.gap]
    if resume is None and settings.gap < 0.5 * FIRST_GAP:
        targets.insert(0, 0.9 * FIRST_GAP)
    began = time.perf_counter()
    best: ProvenBound | None = None
    for stage, gap in enumerate(targets):
        left = max(settings.seconds - (time.perf_counter() - began), 0.0)
        found = prove(
            problem,
            objective,
            profile if best is None else best.profile,
            scale=scale,
            multipliers=multipliers,
            settings=replace(settings, gap=gap, seconds=left),
            resume=resume,
            enough=enough if stage == 0 else np.inf,
            progress=progress,
        )
        if best is None or found.upper_bound < best.upper_bound:
            best = replace(found, improved=found.value > value)
        else:
            best = replace(
                best,
                profile=found.profile,
                value=found.value,
                gap=(best.upper_bound - found.value) / scale,
                improved=found.value > value,
                ended=found.ended,
            )
        if found.ended != "gap reached":
            break
    assert best is not None
    return replace(best, seconds=time.perf_counter() - began)


def _spread(frame: Frame, work: list[tuple[int, Node]], state: _State) -> list[_Parts]:
    """The parts of every region of a round, in the order of the round."""
    jobs = [
        (node, state.cut, (state.split_count + i) % _LOCAL_EVERY == 0)
        for i, (_, node) in enumerate(work)
    ]
    state.split_count += len(jobs)
    executor, workers = state.settings.executor, state.settings.workers
    if executor is None:
        return _many(frame, jobs)
    shares = [jobs[w::workers] for w in range(min(workers, len(jobs)))]
    futures = [executor.submit(_many, frame, share) for share in shares]
    out: list[_Parts] = [_Parts(nodes=[], profile=None)] * len(jobs)
    for w, future in enumerate(futures):
        out[w::workers] = future.result()
    return out


class _State:
    """Open regions, the best profile and the record of one search."""

    def __init__(
        self, frame: Frame, profile: FloatArray, scale: float, settings: ProofSettings
    ) -> None:
        self.frame, self.scale, self.settings = frame, scale, settings
        self.recorder = TreeRecorder(frame)
        self.profile = np.array(profile, dtype=np.float64)
        self.value = frame.problem.value(self.profile, frame.given)
        self.improved = False
        self.heap: list[tuple[float, float, int, Node]] = []
        self.narrow: list[float] = []  # bounds of regions that can't be split
        self.lost = -np.inf  # bound on all that was cut off
        self.count = self.split_count = 0

    @property
    def cut(self) -> float:
        """Objective below which profiles may be lost."""
        return self.value + 0.999 * self.settings.gap * self.scale

    def add(self, node: Node, parent: int, *, is_open: bool = True) -> None:
        """Record a bounded node and keep it if something is left of it."""
        number = self.recorder.add(node, parent)
        self.count += 1
        self.lost = max(self.lost, node.lost)
        if node.region is not None and is_open:
            heapq.heappush(self.heap, (-node.bound, node.region.size, number, node))

    def round(self) -> list[tuple[int, Node]]:
        """The regions to split next: largest bound first, of equal bounds the smallest region."""
        chosen: list[tuple[int, Node]] = []
        while self.heap and len(chosen) < _ROUND:
            _, _, number, node = heapq.heappop(self.heap)
            chosen.append((number, node))
        return chosen

    def put_back(self, work: list[tuple[int, Node]]) -> None:
        """Keep regions that were chosen and not worked on."""
        for number, node in work:
            assert node.region is not None
            heapq.heappush(self.heap, (-node.bound, node.region.size, number, node))

    def take(self, parts: _Parts, number: int, parent: Node) -> None:
        """Keep what became of a region."""
        if not parts.nodes:
            self.narrow.append(parent.bound)
        for node in parts.nodes:
            self.add(node, number)
        if parts.profile is not None:
            problem, objective = self.frame.problem, self.frame.given
            torque, blade = problem.excess(problem.curves.evaluate(parts.profile), objective)
            value = problem.value(parts.profile, objective)
            kept = torque <= 1e-9 * self.scale and (
                np.isinf(objective.blade_cap) or blade <= 1e-9 * objective.blade_cap
            )
            if kept and value > self.value + 1e-9 * self.scale:
                self.profile, self.value, self.improved = parts.profile, value, True

    def bound(self) -> float:
        """What is proven now."""
        open_bounds = [-self.heap[0][0]] if self.heap else []
        return float(max([self.lost, self.value, *open_bounds, *self.narrow]))

    def mark(self, began: float) -> tuple[float, int, float]:
        """Seconds, regions and gap so far."""
        gap = (self.bound() - self.value) / self.scale
        return time.perf_counter() - began, self.count, gap

    def ended(self, began: float) -> str | None:
        """Why the search ends now, or None."""
        if self.bound() - self.value <= self.settings.gap * self.scale:
            return "gap reached"
        if not self.heap:
            return "nothing left to split"
        if time.perf_counter() - began >= self.settings.seconds:
            return "time limit"
        if self.count >= self.settings.regions:
            return "region limit"
        return None
