"""CMA-ES of the package ``cma``: an evolution strategy that adapts its covariance.

It works in unit coordinates, where a periodic parameter has no bounds, and compares costs by rank.
When a search has stopped, the next starts from a random point with twice as many points in a
generation (IPOP).

Hansen, The CMA Evolution Strategy: a tutorial, arXiv:1604.00772 (2016); Auger, Hansen, A restart
CMA evolution strategy with increasing population size, IEEE CEC (2005) 1769-1776.
"""

from __future__ import annotations

import itertools
import warnings
from collections.abc import Generator, Iterator
from contextlib import contextmanager
from typing import Any, ClassVar

import numpy as np
from numpy.typing import ArrayLike

from pitchopt.checks import finite_number, whole_number
from pitchopt.errors import InputError
from pitchopt.tuning.evaluations import Evaluation
from pitchopt.tuning.space import Space
from pitchopt.tuning.tuner import Proposal, StagedTuner, Stages

__all__ = ["CmaEs"]


class CmaEs(StagedTuner):
    """CMA-ES with restarts.

    Parameters
    ----------
    space : Space
    start : (d,) array_like, optional
        Mean of the first generation, in the units of the space; the middle by default.  It is
        evaluated first where it is given.
    size : float
        First standard deviation, in unit coordinates.
    population : int, optional
        Points of a generation in the first search; 4 + 3 ln d by default.
    tolerance : float
        Size of a generation, in unit coordinates, at which a search has converged.
    seed : int

    Raises
    ------
    InputError
        If the package ``cma`` is not installed.

    Notes
    -----
    A generation may be evaluated in parallel.  Failed points and those that break constraints
    are ranked by their `merit`; a search whose whole generation failed before anything else was
    known starts anew elsewhere.
    """

    name: ClassVar[str] = "cma-es"

    def __init__(
        self,
        space: Space,
        *,
        start: ArrayLike | None = None,
        size: float = 0.25,
        population: int | None = None,
        tolerance: float = 1e-5,
        seed: int = 0,
    ) -> None:
        super().__init__(space, seed=seed)
        self.size = finite_number("size", size, above=0.0, at_most=1.0)
        usual = 4 + int(3.0 * np.log(len(space)))
        self.population = whole_number(
            "population", usual if population is None else population, at_least=3
        )
        self.tolerance = finite_number("tolerance", tolerance, above=0.0)
        self.start = None if start is None else space.point(start)
        _cma()

    def settings(self) -> dict[str, object]:
        """Plain data that names the tuner."""
        return {
            "name": self.name,
            "seed": self.seed,
            "start": None if self.start is None else self.start.tolist(),
            "size": self.size,
            "population": self.population,
            "tolerance": self.tolerance,
        }

    def _stages(self) -> Stages:
        if self.start is not None:
            yield [Proposal(x=self.start, origin="start")]
        for search in itertools.count():
            yield from self._searched(search)

    def _searched(self, search: int) -> Generator[list[Proposal], list[Evaluation], None]:
        size = len(self.space)
        rng = np.random.default_rng([self.seed, search])
        mean = rng.random(size)
        if search == 0:
            mean = np.full(size, 0.5) if self.start is None else self.space.to_unit(self.start)
        free = self.space.periodic
        if size == 1:  # the package needs two: the second is not used
            mean, free = np.append(mean, 0.0), np.append(free, True)
        with _quiet():
            strategy = _cma().CMAEvolutionStrategy(
                mean,
                self.size,
                {
                    "bounds": [
                        [None if turns else 0.0 for turns in free],
                        [None if turns else 1.0 for turns in free],
                    ],
                    "popsize": self.population * 2**search,
                    "randn": lambda *shape: rng.standard_normal(shape),
                    "seed": np.nan,  # leaves the random numbers of NumPy alone
                    "tolx": self.tolerance,
                    "verbose": -9,
                    "verb_log": 0,
                },
            )
        for generation in itertools.count():
            with _quiet():
                if strategy.stop():
                    return
                points = strategy.ask()
            label = f"generation {search}.{generation}"
            told = yield [Proposal(x=self.space.from_unit(u[:size]), origin=label) for u in points]
            merits = self.merits(told)
            if not np.all(np.isfinite(merits)):
                return
            with _quiet():
                strategy.tell(points, merits.tolist())


def _cma() -> Any:
    try:
        with _quiet():
            import cma
    except ImportError as error:
        raise InputError(
            "cma-es: the package cma is not installed; pip install 'pitchopt[cma]'"
        ) from error
    return cma


@contextmanager
def _quiet() -> Iterator[None]:
    """Keep back warnings of the package, on such as a single parameter or equal costs."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        yield
