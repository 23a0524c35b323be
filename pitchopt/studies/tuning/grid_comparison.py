"""Zeroth-order tuning of the speed regulator against grids: figure 6 of Zalkind et al.

Grids of 6, 8 and 10 points each way over the bounds, and the zeroth-order tuner with several
numbers of samples and stages from four starts, one in each quadrant of the bounds, three times
each with other directions.  The start in the lower right quadrant is the suggested one, z^sug; the
others are drawn at random, again where a run diverges there.  Costs are those of the problem,
whose barrier refers to z^sug, over the cost of z^sug.

A point that several searches ask for is simulated once, but counts in each of them, as it would
have to be simulated if that search were made alone.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from pitchopt.checks import FloatArray, whole_number
from pitchopt.errors import InputError
from pitchopt.studies.tuning.problem import TuningProblem
from pitchopt.tuning import Outcome, Tuner, ZerothOrder, run_study
from pitchopt.tuning.grid import Grid

__all__ = ["QUADRANTS", "GridComparison", "MethodSummary", "Search", "compare_with_grids"]

QUADRANTS = ("upper left", "upper right", "lower left", "lower right")
GRIDS = (6, 8, 10)
SEARCHES = ((3, 7), (4, 7), (10, 7), (3, 12))
_DRAWS = 100  # of a start before a quadrant counts as empty

Progress = Callable[[int, int, str], None]


@dataclass(frozen=True, kw_only=True)
class Search:
    """One search.

    Attributes
    ----------
    method : str
        Such as ``grid 10`` or ``zoo J = 3, 7 stages``.
    quadrant : str
        Where it began; empty for a grid.
    start, x : (2,) ndarray
        First and best point; of a grid the first is its first corner.
    cost : float
        Least, over that of the suggested point.
    simulations : int
    """

    method: str
    quadrant: str
    start: FloatArray
    x: FloatArray
    cost: float
    simulations: int


@dataclass(frozen=True, kw_only=True)
class MethodSummary:
    """Searches of one method together.

    Attributes
    ----------
    method : str
    searches : int
    cost, deviation : float
        Mean and standard deviation of normalised costs; the latter is NaN for one search.
    least : float
    simulations : float
        Mean.
    """

    method: str
    searches: int
    cost: float
    deviation: float
    least: float
    simulations: float


@dataclass(frozen=True, kw_only=True)
class GridComparison:
    """What came out.

    Attributes
    ----------
    searches : tuple of Search
        Grids first.
    axes : tuple of (n,) ndarray
        Values of the two parameters on the finest grid.
    costs : (n, n) ndarray
        Normalised costs there, rows over the second parameter; NaN where a run diverged.
    names : tuple of str
        Of the parameters.
    suggested : (2,) ndarray
    simulations : int
        That were made in all.
    """

    searches: tuple[Search, ...]
    axes: tuple[FloatArray, FloatArray]
    costs: FloatArray
    names: tuple[str, ...]
    suggested: FloatArray
    simulations: int

    @property
    def methods(self) -> tuple[str, ...]:
        """Each once, in order."""
        return tuple(dict.fromkeys(search.method for search in self.searches))

    def summaries(self, quadrant: str | None = None) -> list[MethodSummary]:
        """One for each method; of the searches from one quadrant only, if it is given."""
        found = []
        for method in self.methods:
            part = [
                search
                for search in self.searches
                if search.method == method and quadrant in (None, search.quadrant)
            ]
            if not part:
                continue
            costs = np.array([search.cost for search in part])
            found.append(
                MethodSummary(
                    method=method,
                    searches=len(part),
                    cost=float(costs.mean()),
                    deviation=float(costs.std(ddof=1)) if costs.size > 1 else math.nan,
                    least=float(costs.min()),
                    simulations=float(np.mean([search.simulations for search in part])),
                )
            )
        return found

    def table(self) -> str:
        """Summaries as text."""
        rows = [
            f"{'method':<22}{'searches':>9}{'cost':>8}{'std':>8}{'least':>8}{'simulations':>13}"
        ]
        for s in self.summaries():
            std = "" if math.isnan(s.deviation) else f"{s.deviation:.3f}"
            rows.append(
                f"{s.method:<22}{s.searches:>9}{s.cost:>8.3f}{std:>8}{s.least:>8.3f}"
                f"{s.simulations:>13.1f}"
            )
        return "\n".join(rows)


class _Once:
    """A problem that simulates no point twice."""

    def __init__(self, problem: TuningProblem, report: Callable[[], None]) -> None:
        self._problem = problem
        self._report = report
        self._known: dict[bytes, Outcome] = {}

    @property
    def points(self) -> list[FloatArray]:
        """That were evaluated."""
        return [np.frombuffer(key) for key in self._known]

    def __call__(self, x: FloatArray) -> Outcome:
        key = np.asarray(x, dtype=np.float64).tobytes()
        if key not in self._known:
            self._known[key] = self._problem(x)
            self._report()
        return self._known[key]


def compare_with_grids(
    problem: TuningProblem,
    *,
    grids: Sequence[int] = GRIDS,
    searches: Sequence[tuple[int, int]] = SEARCHES,
    repeats: int = 3,
    seed: int = 0,
    progress: Progress | None = None,
) -> GridComparison:
    """Run all searches on a problem of two parameters.

    Parameters
    ----------
    problem : TuningProblem
        Such as `SpeedRegulator`, whose start is the suggested point.
    grids : sequence of int
        Points each way.
    searches : sequence of (int, int)
        Samples and stages of the zeroth-order tuner; its other settings are the problem's.
    repeats : int
        Of each search from each start.
    seed : int
        Of starts and directions.
    progress : callable, optional
        Called with searches done, searches in all and what is done; after each simulation too.

    Raises
    ------
    InputError
        If the problem has not two parameters, or no start in a quadrant can be judged.
    """
    if len(problem.space) != 2:
        raise InputError(f"problem: got {len(problem.space)} parameters, expected two")
    repeats = whole_number("repeats", repeats, at_least=1)
    if not grids:
        raise InputError("grids: got none, expected at least one")
    total = len(grids) + len(QUADRANTS) * len(searches) * repeats
    found: list[Search] = []

    def report() -> None:
        if progress is not None:
            progress(len(found), total, "search")

    once = _Once(problem, report)
    base = problem.reference.cost
    tables: dict[int, FloatArray] = {}

    def search(tuner: Tuner, method: str, quadrant: str, most: int) -> None:
        result = run_study(once, tuner, evaluations=most)
        found.append(
            Search(
                method=method,
                quadrant=quadrant,
                start=result.evaluations[0].x,
                x=result.best.x,
                cost=result.best.cost / base,
                simulations=len(result.evaluations) * problem.simulations,
            )
        )
        if isinstance(tuner, Grid):
            costs = np.array([e.cost for e in result.evaluations]) / base
            tables[tuner.points[0]] = costs.reshape(tuner.points).T
        report()

    for count in grids:
        search(Grid(problem.space, points=count), f"grid {count}", "", count**2)
    starts = _starts(problem, once, seed)
    options = problem.tuner_options("zoo")
    for samples, stages in searches:
        for place, (quadrant, start) in enumerate(starts.items()):
            for repeat in range(repeats):
                settings = options | {"samples": samples, "stages": stages}
                number = seed + place * repeats + repeat
                tuner = ZerothOrder(problem.space, start=start, seed=number, **settings)
                method = f"zoo J = {samples}, {stages} stages"
                search(tuner, method, quadrant, tuner.most_evaluations + 1)
    finest = max(grids)
    low, high = problem.space.lower, problem.space.upper
    axes = (np.linspace(low[0], high[0], finest), np.linspace(low[1], high[1], finest))
    return GridComparison(
        searches=tuple(found),
        axes=axes,
        costs=tables[finest],
        names=problem.space.names,
        suggested=problem.start,
        simulations=problem.simulations_in(once.points),
    )


def _starts(problem: TuningProblem, once: _Once, seed: int) -> dict[str, FloatArray]:
    """One start a quadrant, the suggested one in the lower right."""
    rng = np.random.default_rng([seed, len(QUADRANTS)])
    middle = 0.5 * (problem.space.lower + problem.space.upper)
    starts = {}
    for quadrant in QUADRANTS:
        right, upper = "right" in quadrant, "upper" in quadrant
        own = problem.start > middle
        if quadrant == "lower right" and own[0] and not own[1]:
            starts[quadrant] = problem.start
            continue
        low = np.where([right, upper], middle, problem.space.lower)
        high = np.where([right, upper], problem.space.upper, middle)
        for _ in range(_DRAWS):
            x = problem.space.point(rng.uniform(low, high))
            if math.isfinite(once(x).cost):
                starts[quadrant] = x
                break
        else:
            raise InputError(
                f"problem: got {_DRAWS} starts in the {quadrant} quadrant that cannot be judged, "
                "expected one that can"
            )
    return starts
