"""Grid search, with rounds that zoom on the best point.

The first round has evenly spaced points on the scale of each parameter: both ends of a plain one,
one of the two equal ends of a periodic one.  A later round fills the cells next to the best point
u so far, [u - h, u + h] with spacing h, by as many inner points: u - h + 2 h i / (n + 1) for
i = 1..n.  So the ends of the cells, which are known, do not come again, and h becomes
2 h / (n + 1).
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence
from typing import ClassVar

import numpy as np
from numpy.typing import ArrayLike

from pitchopt.checks import FloatArray, whole_number
from pitchopt.errors import InputError
from pitchopt.tuning.space import Space
from pitchopt.tuning.tuner import Proposal, StagedTuner, Stages

__all__ = ["Grid"]

_MOST = 100_000  # points of one round


class Grid(StagedTuner):
    """Grid search.

    Parameters
    ----------
    space : Space
    points : int or (d,) sequence of int
        For each parameter; one that has a single point stays in its middle.
    rounds : int
        Rounds of refinement after the first grid.
    start : (d,) array_like, optional
        Evaluated first, in the units of the space.
    seed : int
        Without effect, as nothing is random.
    """

    name: ClassVar[str] = "grid"

    def __init__(
        self,
        space: Space,
        *,
        points: int | Sequence[int] = 6,
        rounds: int = 0,
        start: ArrayLike | None = None,
        seed: int = 0,
    ) -> None:
        super().__init__(space, seed=seed)
        given = points if isinstance(points, Sequence) else [points] * len(space)
        self.points = tuple(whole_number("points", count, at_least=1) for count in given)
        if len(self.points) != len(space):
            raise InputError(
                f"points: got {len(self.points)} numbers for {len(space)} parameters, expected "
                "one for each or one for all"
            )
        if math.prod(self.points) > _MOST:
            raise InputError(
                f"points: got {math.prod(self.points)} in all, expected at most {_MOST}"
            )
        self.rounds = whole_number("rounds", rounds, at_least=0)
        self.start = None if start is None else space.point(start)

    def settings(self) -> dict[str, object]:
        """Plain data that names the tuner."""
        return {
            "name": self.name,
            "seed": self.seed,
            "points": list(self.points),
            "rounds": self.rounds,
            "start": None if self.start is None else self.start.tolist(),
        }

    def _stages(self) -> Stages:
        axes = [
            np.array([0.5]) if count == 1 else np.linspace(0.0, 1.0, count, endpoint=not periodic)
            for count, periodic in zip(self.points, self.space.periodic, strict=True)
        ]
        spacing = np.array([1.0 if u.size == 1 else u[1] - u[0] for u in axes])
        first = [] if self.start is None else [Proposal(x=self.start, origin="start")]
        yield first + self._crossed(axes, 0)
        for number in range(1, self.rounds + 1):
            merits = self.merits(self.evaluations)
            best = self.space.to_unit(self.evaluations[int(np.argmin(merits))].x)
            low, high = best - spacing, best + spacing
            low = np.where(self.space.periodic, low, np.maximum(low, 0.0))
            high = np.where(self.space.periodic, high, np.minimum(high, 1.0))
            counts = np.array(self.points)
            axes = [
                u if u.size == 1 else np.linspace(begin, end, u.size + 2)[1:-1]
                for u, begin, end in zip(axes, low, high, strict=True)
            ]
            spacing = np.where(counts == 1, spacing, (high - low) / (counts + 1))
            yield self._crossed(axes, number)

    def _crossed(self, axes: Sequence[FloatArray], number: int) -> list[Proposal]:
        """Points of a round that are not known yet."""
        points = [e.x for e in self.evaluations]
        if self.start is not None and number == 0:
            points.append(self.start)
        known = self.space.to_unit(points) if points else None
        proposals = []
        for place, u in enumerate(itertools.product(*axes)):
            if known is not None:
                apart = np.abs(known - np.array(u))
                apart = np.where(self.space.periodic, np.abs(apart - np.round(apart)), apart)
                if np.any(np.all(apart <= 1e-9, axis=1)):
                    continue
            proposals.append(Proposal(x=self.space.from_unit(u), origin=f"grid {number}.{place}"))
        return proposals
