"""A proof that can be checked without the program that found it.

The tree of regions is stored as it was searched: for each region its parent, the split that it
came from, the steps that made it smaller, and the multipliers of each.  The check starts from
the curves and limits alone, carries the steps out again, and takes as bound the largest of what
is left: the bounds of the regions that were not split, and the cut, below which profiles were
lost on purpose.  No number that a solver found optimal enters.
"""

from __future__ import annotations

import hashlib
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pitchopt.design.problem import DesignProblem, Objective
from pitchopt.design.proof.node import Branch, Node, Step, done, row_width
from pitchopt.design.proof.region import Frame
from pitchopt.errors import InputError

__all__ = ["Proof", "TreeRecorder", "check_proof", "problem_digest", "replayed"]

FloatArray = NDArray[np.float64]

_TIGHTEN = -1  # in place of a row of multipliers


@dataclass(frozen=True, kw_only=True, eq=False)
class Proof:
    """The stored tree of a branch and bound.

    Attributes
    ----------
    digest : str
        Of the curves, limits and objective that it is about.
    upper_bound : float
        On the objective of every feasible profile [N m].
    parent : int array (R,)
        Row of each region's parent, -1 for the first; parents come before their parts.
    load, station : int array (R,)
        What was split: a mean (0 to 3) or the pitch of a station, -1 for the other.
    value : ndarray (R,)
        Where it was split.
    above : bool array (R,)
    cut : ndarray (R,)
        The cut that the steps used [N m].
    first_step : int array (R + 1,)
        The steps of region r are ``first_step[r]`` to ``first_step[r + 1] - 1``.
    row, passes, slices : int array (S,)
        For each step the row of its multipliers, or -1 and the numbers of the tightening.
    multipliers : float32 array (P, W)
        Packed multipliers.
    """

    digest: str
    upper_bound: float
    parent: NDArray[np.int64]
    load: NDArray[np.int64]
    station: NDArray[np.int64]
    value: FloatArray
    above: NDArray[np.bool_]
    cut: FloatArray
    first_step: NDArray[np.int64]
    row: NDArray[np.int64]
    passes: NDArray[np.int64]
    slices: NDArray[np.int64]
    multipliers: NDArray[np.float32]

    @property
    def regions(self) -> int:
        """Number of regions in the tree."""
        return int(self.parent.size)


class TreeRecorder:
    """Collects nodes in the order in which they are made."""

    def __init__(self, frame: Frame) -> None:
        self._frame = frame
        self._nodes: list[tuple[int, Branch | None, float]] = []
        self._first = [0]
        self._steps: list[tuple[int, int, int]] = []
        self._rows: list[NDArray[np.float32]] = []

    def add(self, node: Node, parent: int) -> int:
        """Record a node; its row."""
        self._nodes.append((parent, node.branch, node.cut))
        for step in node.steps:
            if step.multipliers is None:
                self._steps.append((_TIGHTEN, step.passes, step.slices))
            else:
                self._steps.append((len(self._rows), 0, 0))
                self._rows.append(step.multipliers)
        self._first.append(len(self._steps))
        return len(self._nodes) - 1

    def proof(self, upper_bound: float) -> Proof:
        """The stored form of what was added."""
        branches = [
            branch or Branch(load=-1, station=-1, value=0.0, above=False)
            for _, branch, _ in self._nodes
        ]
        steps = np.array(self._steps, dtype=np.int64).reshape(-1, 3)
        width = row_width(self._frame)
        return Proof(
            digest=problem_digest(self._frame.problem, self._frame.given),
            upper_bound=upper_bound,
            parent=np.array([parent for parent, _, _ in self._nodes], dtype=np.int64),
            load=np.array([b.load for b in branches], dtype=np.int64),
            station=np.array([b.station for b in branches], dtype=np.int64),
            value=np.array([b.value for b in branches]),
            above=np.array([b.above for b in branches]),
            cut=np.array([cut for _, _, cut in self._nodes]),
            first_step=np.array(self._first, dtype=np.int64),
            row=steps[:, 0],
            passes=steps[:, 1],
            slices=steps[:, 2],
            multipliers=(
                np.stack(self._rows) if self._rows else np.empty((0, width), dtype=np.float32)
            ),
        )


def problem_digest(problem: DesignProblem, objective: Objective) -> str:
    """SHA-256 of everything that a proof depends on."""
    curves, limits = problem.curves, problem.limits
    sha = hashlib.sha256()
    for array in (curves.azimuth, curves.beta, curves.loads, curves.rates):
        sha.update(np.ascontiguousarray(array, dtype="<f8").tobytes())
    mean = np.nan if curves.mean_pitch is None else curves.mean_pitch
    numbers = [
        curves.blades,
        mean,
        limits.pitch_rate,
        limits.rotor_speed,
        objective.torque,
        *objective.rms,
        objective.travel,
        objective.torque_min,
        objective.torque_max,
        objective.blade_cap,
    ]
    sha.update(np.array(numbers, dtype="<f8").tobytes())
    return sha.hexdigest()


def check_proof(proof: Proof, problem: DesignProblem, objective: Objective) -> float:
    """Carry the steps of a proof out again; the bound that they prove [N m].

    Parameters
    ----------
    proof : Proof
    problem : DesignProblem
        Curves and limits that the proof is about.
    objective : Objective

    Returns
    -------
    float
        Upper bound on the objective of every feasible profile, from this run alone.

    Raises
    ------
    InputError
        If the proof is about another problem, or its tree does not cover the design space.
    """
    worst = -np.inf
    for node, _, is_leaf in replayed(Frame(problem, objective), proof):
        worst = max(worst, node.lost)
        if is_leaf and node.region is not None:
            worst = max(worst, node.bound)
    return float(worst)


def replayed(frame: Frame, proof: Proof) -> Iterator[tuple[Node, int, bool]]:
    """The nodes of a stored tree, each with its parent's row and whether it has no parts.

    Raises
    ------
    InputError
        If the proof is about another problem, or its tree does not cover the design space.
    """
    if problem_digest(frame.problem, frame.given) != proof.digest:
        raise InputError(
            "proof: made for other curves, limits or prices than those it is checked against"
        )
    _checked(frame, proof)
    children = _children(proof)
    open_nodes: dict[int, Node] = {}
    for r in range(proof.regions):
        parent = int(proof.parent[r])
        if parent < 0:
            node = Node(region=frame.first(), bound=np.inf, branch=None, cut=float(proof.cut[r]))
        else:
            above = open_nodes[parent]
            branch = _branch(proof, r)
            node = Node(
                region=None if above.region is None else branch.taken(above.region),
                bound=above.bound,
                branch=branch,
                cut=float(proof.cut[r]),
                multipliers=above.multipliers,
                solved_size=above.solved_size,
            )
        for s in range(proof.first_step[r], proof.first_step[r + 1]):
            if node.region is None:
                break
            step = _step(proof, s)
            done(frame, node, step)
            if step.multipliers is not None and node.region is not None:
                node.multipliers, node.solved_size = step.multipliers, node.region.size
        if children[r]:
            open_nodes[r] = node
        yield node, parent, not children[r]
        if parent >= 0 and r == children[parent][-1]:
            del open_nodes[parent]


_MOST_PASSES, _MOST_SLICES = 100, 1024


def _checked(frame: Frame, proof: Proof) -> None:
    """Refuse arrays that are no tree, whatever a file holds."""
    count, steps = proof.parent.size, proof.row.size
    whole = {
        "parent": (proof.parent, count),
        "load": (proof.load, count),
        "station": (proof.station, count),
        "first_step": (proof.first_step, count + 1),
        "row": (proof.row, steps),
        "passes": (proof.passes, steps),
        "slices": (proof.slices, steps),
    }
    for name, (numbers, size) in whole.items():
        if numbers.shape != (size,) or numbers.dtype.kind not in "iu":
            raise InputError(f"proof: {name} must be {size} whole numbers")
    for name, array in (("value", proof.value), ("cut", proof.cut)):
        if array.shape != (count,) or array.dtype.kind != "f" or not np.all(np.isfinite(array)):
            raise InputError(f"proof: {name} must be {count} finite numbers")
    if proof.above.shape != (count,) or proof.above.dtype.kind != "b":
        raise InputError(f"proof: above must be {count} truth values")
    rows = proof.multipliers
    if rows.ndim != 2 or rows.dtype != np.float32 or rows.shape[1] != row_width(frame):
        raise InputError(f"proof: multipliers must be rows of {row_width(frame)} numbers")
    if not np.all(np.isfinite(rows)):
        raise InputError("proof: multipliers must be finite")
    first = proof.first_step
    if first[0] != 0 or first[-1] != steps or np.any(np.diff(first) < 0):
        raise InputError("proof: first_step must rise from 0 to the number of steps")
    tightening = proof.row == _TIGHTEN
    if np.any(proof.row < _TIGHTEN) or np.any(proof.row >= rows.shape[0]):
        raise InputError("proof: a step names multipliers that are not there")
    limits = ((proof.passes, _MOST_PASSES), (proof.slices, _MOST_SLICES))
    if any(np.any((n[tightening] < 1) | (n[tightening] > most)) for n, most in limits):
        raise InputError("proof: passes or slices of a step are out of range")
    load, station = proof.load[1:], proof.station[1:]
    by_load = (load >= 0) & (load < 4) & (station == -1)
    by_station = (load == -1) & (station >= 0) & (station < frame.stations)
    if not np.all(by_load | by_station):
        raise InputError("proof: a split names neither a load nor a station")


def _children(proof: Proof) -> list[list[int]]:
    """Parts of each region, after checking that two parts cover it."""
    count = proof.regions
    if count == 0 or proof.parent[0] != -1 or np.any(proof.parent[1:] < 0):
        raise InputError("proof: the tree must have one first region")
    if np.any(proof.parent[1:] >= np.arange(1, count)):
        raise InputError("proof: parents must come before their parts")
    children: list[list[int]] = [[] for _ in range(count)]
    for r in range(1, count):
        children[int(proof.parent[r])].append(r)
    for parts in children:
        if not parts:
            continue
        branches = [_branch(proof, r) for r in parts]
        ok = len(parts) == 2 and {b.above for b in branches} == {False, True}
        if ok:
            a, b = branches
            ok = (a.load, a.station, a.value) == (b.load, b.station, b.value)
        if not ok:
            raise InputError("proof: the parts of a region do not cover it")
    return children


def _branch(proof: Proof, r: int) -> Branch:
    return Branch(
        load=int(proof.load[r]),
        station=int(proof.station[r]),
        value=float(proof.value[r]),
        above=bool(proof.above[r]),
    )


def _step(proof: Proof, s: int) -> Step:
    row = int(proof.row[s])
    if row == _TIGHTEN:
        return Step(passes=int(proof.passes[s]), slices=int(proof.slices[s]))
    return Step(multipliers=proof.multipliers[row])
