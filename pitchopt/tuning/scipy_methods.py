"""Nelder-Mead and COBYLA of SciPy, turned inside out into ask and tell.

``scipy.optimize.minimize`` calls a function; here that function hands its point over and waits for
the reply, in a thread that runs only while this side waits, so that nothing depends on timing.  The
thread ends when the search does, or when its generator is closed or collected.

Nelder, Mead, Computer Journal 7 (1965) 308-313, with the bounds of SciPy; Powell, A direct search
optimization method that models the objective and constraint functions by linear interpolation
(1994).  Both work in unit coordinates, where a periodic parameter has no bounds.  When a search has
converged, the next starts from the next point of a scrambled Sobol sequence.
"""

from __future__ import annotations

import itertools
import queue
import threading
from abc import abstractmethod
from collections.abc import Callable, Generator
from contextlib import closing
from functools import partial
from typing import Any, ClassVar

import numpy as np
import scipy
from numpy.typing import ArrayLike

from pitchopt.checks import FloatArray, finite_number
from pitchopt.errors import InputError
from pitchopt.tuning.evaluations import Evaluation
from pitchopt.tuning.space import Space
from pitchopt.tuning.tuner import Proposal, StagedTuner, Stages, behind

__all__ = ["Cobyla", "NelderMead", "inverted"]

Reply = tuple[float, FloatArray]
"""Cost and constraints, at most zero where they hold."""
Search = Generator[FloatArray, Reply, None]
_UNLIMITED = 10**9  # evaluations: who asks sets the limit


class _StopSearch(BaseException):
    """Ends a search that nobody waits for; no subclass of Exception, so that nothing catches it."""


def inverted(search: Callable[[Callable[[FloatArray], Reply]], object]) -> Search:
    """Generator of the points at which `search` calls its function; send it the replies.

    Parameters
    ----------
    search : callable
        Takes the function to call.  It must not hold on to whoever holds the generator, which
        could then not be collected.
    """
    points: queue.SimpleQueue[FloatArray | BaseException | None] = queue.SimpleQueue()
    replies: queue.SimpleQueue[Reply | None] = queue.SimpleQueue()

    def function(u: FloatArray) -> Reply:
        points.put(np.array(u, dtype=np.float64))
        reply = replies.get()
        if reply is None:
            raise _StopSearch
        return reply

    def run() -> None:
        try:
            search(function)
        except _StopSearch:
            return
        except BaseException as error:  # noqa: BLE001  raised again on the other side
            points.put(error)
        else:
            points.put(None)

    thread = threading.Thread(target=run, name="pitchopt-search", daemon=True)
    thread.start()
    try:
        while (point := points.get()) is not None:
            if isinstance(point, BaseException):
                raise point
            replies.put((yield point))
    finally:
        replies.put(None)
        if thread is not threading.current_thread():  # which may be the one that collects
            thread.join()


class _ThroughScipy(StagedTuner):
    """Searches one after the other."""

    def __init__(
        self,
        space: Space,
        *,
        start: ArrayLike | None = None,
        size: float = 0.2,
        tolerance: float = 1e-4,
        seed: int = 0,
    ) -> None:
        super().__init__(space, seed=seed)
        self.size = finite_number("size", size, above=0.0, at_most=0.5)
        self.tolerance = finite_number("tolerance", tolerance, above=0.0)
        if self.tolerance >= self.size:
            raise InputError(
                f"tolerance: got {self.tolerance:g}, expected less than the size, {self.size:g}"
            )
        middle = space.from_unit(np.full(len(space), 0.5))
        self.start = space.point(middle if start is None else start)

    def settings(self) -> dict[str, object]:
        """Plain data that names the tuner."""
        return {
            "name": self.name,
            "seed": self.seed,
            "start": self.start.tolist(),
            "size": self.size,
            "tolerance": self.tolerance,
        }

    @abstractmethod
    def _search(self, u: FloatArray) -> Search:
        """Search from a point in unit coordinates that was evaluated and did not fail."""

    @abstractmethod
    def _reply(self, evaluation: Evaluation) -> Reply:
        """What the search hears of its point."""

    def _bounds(self) -> tuple[FloatArray, FloatArray]:
        periodic = self.space.periodic
        return np.where(periodic, -np.inf, 0.0), np.where(periodic, np.inf, 1.0)

    @property
    def _feasible(self) -> bool:
        return any(e.feasible for e in self.evaluations)

    def _stages(self) -> Stages:
        from scipy.stats import qmc

        later = qmc.Sobol(len(self.space), rng=np.random.default_rng(self.seed))
        u = self.space.to_unit(self.start)
        for number in itertools.count(1):
            origin = "start" if number == 1 else f"start {number}"
            here: Evaluation | None = yield from self._evaluated(u, origin)
            while here and here.status == "ok":
                here = yield from self._searched(self.space.to_unit(here.x), number)
            u = np.asarray(later.random(1)[0])

    def _searched(
        self, u: FloatArray, number: int
    ) -> Generator[list[Proposal], list[Evaluation], Evaluation | None]:
        """Run one search; the point to start anew from if its replies no longer stand."""
        feasible = self._feasible
        with closing(self._search(u)) as search:
            try:
                point = next(search)
                while True:
                    evaluation = yield from self._evaluated(point, f"search {number}")
                    if self._stale(feasible):
                        return evaluation
                    point = search.send(self._reply(evaluation))
            except StopIteration:
                return None

    def _stale(self, feasible: bool) -> bool:  # noqa: ARG002  for those whose replies grow old
        """Whether replies given while something, or nothing, was feasible are now misleading."""
        return False

    def _evaluated(
        self, u: FloatArray, origin: str
    ) -> Generator[list[Proposal], list[Evaluation], Evaluation]:
        """Evaluation of a point, asked for unless it is known."""
        x = self.space.point(self.space.from_unit(u))
        for known in self.evaluations:
            if np.array_equal(known.x, x):
                return known
        (evaluation,) = yield [Proposal(x=x, origin=origin)]
        return evaluation


class NelderMead(_ThroughScipy):
    """Nelder-Mead simplex.

    Parameters
    ----------
    space : Space
    start : (d,) array_like, optional
        In the units of the space; the middle by default.
    size : float
        Edge of the first simplex, in unit coordinates.
    tolerance : float
        Size of the simplex at which a search has converged, in unit coordinates.
    seed : int
        Of where later searches start.

    Notes
    -----
    It compares costs by `merit`: of failed points and of those that break constraints as well.  A
    search that began before anything feasible was known starts anew at the first feasible point.
    """

    name: ClassVar[str] = "nelder-mead"

    def _search(self, u: FloatArray) -> Search:
        low, high = self._bounds()
        signs = np.where(u + self.size <= high, 1.0, -1.0)
        simplex = np.vstack([u, u + self.size * np.diag(signs)])
        return inverted(
            partial(_nelder_mead, simplex=simplex, bounds=(low, high), tolerance=self.tolerance)
        )

    def _reply(self, evaluation: Evaluation) -> Reply:
        return self.merit(evaluation), np.zeros(0)

    def _stale(self, feasible: bool) -> bool:
        return not feasible and self._feasible


class Cobyla(_ThroughScipy):
    """COBYLA: linear models of cost and constraints in a trust region.

    Parameters
    ----------
    space : Space
    start : (d,) array_like, optional
        In the units of the space; the middle by default.
    size : float
        First radius of the trust region, in unit coordinates.
    tolerance : float
        Radius at which a search has converged, in unit coordinates.
    seed : int
        Of where later searches start.

    Raises
    ------
    InputError
        With a SciPy before 1.16, whose COBYLA cannot run twice at the same time.

    Notes
    -----
    Constraints are its own: it sees the cost of points that break them.  A failed point costs more
    than any known one by the range of costs, and breaks constraints like the worst.
    """

    name: ClassVar[str] = "cobyla"

    def __init__(
        self,
        space: Space,
        *,
        start: ArrayLike | None = None,
        size: float = 0.2,
        tolerance: float = 1e-4,
        seed: int = 0,
    ) -> None:
        super().__init__(space, start=start, size=size, tolerance=tolerance, seed=seed)
        version = scipy.__version__
        if tuple(int(part) for part in version.split(".")[:2]) < (1, 16):
            raise InputError(f"cobyla: got SciPy {version}, expected 1.16 or newer")

    def _search(self, u: FloatArray) -> Search:
        count = max(len(e.constraints) for e in self.evaluations)
        return inverted(
            partial(
                _cobyla,
                u=u,
                bounds=self._bounds(),
                constrained=count > 0,
                size=self.size,
                tolerance=self.tolerance,
            )
        )

    def _reply(self, evaluation: Evaluation) -> Reply:
        if evaluation.status == "ok":
            return evaluation.cost, np.array(evaluation.constraints)
        known = [e for e in self.evaluations if e.status == "ok"]
        constraints = np.max([e.constraints for e in known], axis=0)
        return behind([e.cost for e in known]), constraints


def _nelder_mead(
    function: Callable[[FloatArray], Reply],
    *,
    simplex: FloatArray,
    bounds: tuple[FloatArray, FloatArray],
    tolerance: float,
) -> None:
    from scipy.optimize import Bounds, minimize

    options: Any = {
        "initial_simplex": simplex,
        "xatol": tolerance,
        "fatol": np.inf,
        "maxiter": _UNLIMITED,
        "maxfev": _UNLIMITED,
        "adaptive": simplex.shape[1] > 2,
    }
    cost: Any = lambda u: function(u)[0]  # noqa: E731
    minimize(
        cost,
        simplex[0],
        method="Nelder-Mead",
        bounds=Bounds(*bounds),
        options=options,
    )


def _cobyla(
    function: Callable[[FloatArray], Reply],
    *,
    u: FloatArray,
    bounds: tuple[FloatArray, FloatArray],
    constrained: bool,
    size: float,
    tolerance: float,
) -> None:
    from scipy.optimize import Bounds, NonlinearConstraint, minimize

    last: dict[bytes, Reply] = {}
    mirrored = u + size > bounds[1]  # its first simplex goes up from where it starts

    def turned(v: FloatArray) -> FloatArray:
        return np.where(mirrored, 1.0 - v, v)

    def at(v: FloatArray) -> Reply:
        key = v.tobytes()
        if key not in last:
            last.clear()
            last[key] = function(turned(v))
        return last[key]

    options: Any = {"rhobeg": size, "tol": tolerance, "maxiter": _UNLIMITED, "catol": 0.0}
    constraint = NonlinearConstraint(lambda v: at(v)[1], -np.inf, 0.0)
    cost: Any = lambda v: at(v)[0]  # noqa: E731
    minimize(
        cost,
        turned(u),
        method="COBYLA",
        bounds=Bounds(*bounds),
        constraints=[constraint] if constrained else [],
        options=options,
    )
