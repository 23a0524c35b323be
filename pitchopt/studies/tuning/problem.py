"""What a tuning problem is: a space, a start, a plant, and a cost of each point.

A point becomes a controller, the controller runs in the same winds as every other (wind speeds
crossed with seeds), and each seed gives one cost.  The cost of the point is their mean; what is
known of its variance is that of the differences to the start's, halved and over the number of
seeds (`pitchopt.tuning.variance_of_mean`), since what seeds have in common moves no minimum.

Costs may refer to the start, as the paper's barrier does to its load; so the start is evaluated
first, when its numbers are needed, and once: a tuner that asks for it is given the same outcome.
"""

from __future__ import annotations

import copy
import math
import threading
from abc import ABC, abstractmethod
from collections.abc import Iterable, Mapping, Sequence
from functools import cached_property
from typing import TYPE_CHECKING, Any, ClassVar, TypeVar

import numpy as np
from numpy.typing import ArrayLike

import pitchopt
from pitchopt.checks import FloatArray, finite_array, whole_number
from pitchopt.control import TurbineController
from pitchopt.errors import ComputationError, InputError
from pitchopt.studies.tuning.plain import plain
from pitchopt.studies.tuning.plant import PlantRun, TuningPlant, failure_of, mean_measures
from pitchopt.tuning import Outcome, Space, variance_of_mean

if TYPE_CHECKING:
    from typing import Self

__all__ = ["TuningProblem", "plain", "start_within"]

N = TypeVar("N", int, float)


class TuningProblem(ABC):
    """Base of the problems.

    Parameters
    ----------
    plant : TuningPlant
    space : Space
    start : (d,) array_like
        z^1: where tuners begin, and what costs and variances refer to.
    wind_speeds : sequence of float
        Mean speeds at the hub [m/s].
    seeds : sequence of int
        Common to all points.
    base : TurbineController, optional
        Controller that points change; the turbine's baseline without.

    Raises
    ------
    InputError
        If there is no wind speed or no seed, one stands twice, or the start lies outside.
    """

    name: ClassVar[str]
    """As the commands call it."""
    shown: tuple[str, ...] = ()
    """Measures that pictures draw beside the cost."""

    def __init__(
        self,
        plant: TuningPlant,
        space: Space,
        start: ArrayLike,
        *,
        wind_speeds: Sequence[float],
        seeds: Sequence[int],
        base: TurbineController | None = None,
    ) -> None:
        self.plant = plant
        self.space = space
        self.start = start_within(space, start)
        self.wind_speeds = _each_once(
            "wind_speeds", finite_array("wind_speeds", wind_speeds).tolist()
        )
        self.seeds = _each_once("seeds", [whole_number("seeds", s, at_least=0) for s in seeds])
        self._base = base
        self._lock = threading.Lock()
        self._reference: Outcome | None = None

    def __getstate__(self) -> dict[str, Any]:
        self.reference  # noqa: B018  (evaluated once, here, and not by each process it goes to)
        return {name: value for name, value in self.__dict__.items() if name != "_lock"}

    def __copy__(self) -> Self:
        """Copy that has evaluated nothing yet."""
        other = object.__new__(type(self))
        other.__dict__.update(self.__dict__)
        other._lock = threading.Lock()
        other._reference = None
        return other

    def __setstate__(self, state: dict[str, Any]) -> None:
        self.__dict__.update(state)
        self._lock = threading.Lock()

    @cached_property
    def base(self) -> TurbineController:
        """Controller that points change."""
        return self.plant.operation.baseline() if self._base is None else self._base

    def with_seeds(self, seeds: Sequence[int]) -> Self:
        """The same problem in other winds."""
        other = copy.copy(self)
        other.seeds = _each_once("seeds", [whole_number("seeds", s, at_least=0) for s in seeds])
        return other

    def bounded(
        self, bounds: Mapping[str, tuple[float, float]], *, start: ArrayLike | None = None
    ) -> Self:
        """The same problem with other bounds of parameters by name, in SI units.

        Parameters
        ----------
        bounds : mapping
            Low and high bound.
        start : (d,) array_like, optional
            z^1, for bounds that leave the present one outside.

        Raises
        ------
        InputError
            If there is no such parameter or it is periodic, bounds have no width, or the start
            lies outside.
        """
        other = copy.copy(self)
        other.space = self.space.bounded(bounds)
        for parameter in self.space.parameters:
            if parameter.periodic and parameter.name in bounds:
                raise InputError(
                    f"bounds: got {parameter.name}, which comes back by turns, expected none for it"
                )
        other.start = start_within(other.space, self.start if start is None else start)
        return other

    @property
    def simulations(self) -> int:
        """Runs of one evaluation."""
        return len(self.wind_speeds) * len(self.seeds)

    def simulations_in(self, points: Iterable[ArrayLike]) -> int:
        """Runs of a study that evaluated these points; those of the start are made once for all."""
        starts = [self._is_start(np.asarray(x, dtype=np.float64)) for x in points]
        once = any(starts) or self._reference is not None
        return (starts.count(False) + once) * self.simulations

    @property
    def reference(self) -> Outcome:
        """Outcome of the start.

        Raises
        ------
        ComputationError
            If its runs diverge.
        """
        with self._lock:
            if self._reference is None:
                runs = self._runs(self.start)
                failure = failure_of(runs)
                if failure is not None:
                    raise ComputationError(
                        f"the start {np.array2string(self.start)} cannot be judged: {failure}"
                    )
                self._refer(runs)
                self._reference = self._outcome(runs, None)
            return self._reference

    def __call__(self, x: ArrayLike) -> Outcome:
        """Cost of a point; NaN with a message where a run diverges.

        Raises
        ------
        InputError
            If the point lies outside of the space.
        ComputationError
            If the start, which costs refer to, cannot be judged.
        """
        point = self.space.point(x)
        reference = self.reference
        if self._is_start(point):
            return reference
        runs = self._runs(point)
        failure = failure_of(runs)
        if failure is not None:
            return Outcome(cost=math.nan, message=failure)
        return self._outcome(runs, reference)

    def _is_start(self, x: FloatArray) -> bool:
        return bool(np.array_equal(x, self.start))

    def runs(self, x: ArrayLike) -> list[PlantRun]:
        """Runs of a point, for time series: seeds within wind speeds."""
        return self._runs(self.space.point(x))

    def check_winds(self) -> None:
        """See without a run that the winds can be used.

        Raises
        ------
        InputError
            If not.
        """
        self.plant.check(self._cases())

    def _cases(self) -> list[tuple[float, int]]:
        return [(speed, seed) for speed in self.wind_speeds for seed in self.seeds]

    def _runs(self, x: FloatArray) -> list[PlantRun]:
        return self.plant.run(self.controller(x), self._cases())

    def _outcome(self, runs: Sequence[PlantRun], reference: Outcome | None) -> Outcome:
        by_seed = [[run for run in runs if run.seed == seed] for seed in self.seeds]
        costs = [self.cost_of(part) for part in by_seed]
        return Outcome(
            cost=float(np.mean(costs)),
            variance=variance_of_mean(costs, costs if reference is None else reference.replicates),
            measures=self.measures_of(runs),
            replicates=tuple(costs),
        )

    @abstractmethod
    def controller(self, x: FloatArray) -> TurbineController:
        """Controller of a point."""

    @abstractmethod
    def cost_of(self, runs: Sequence[PlantRun]) -> float:
        """Cost of the runs of one seed, one for each wind speed."""

    def measures_of(self, runs: Sequence[PlantRun]) -> dict[str, float]:
        """What tables and pictures show of all runs of a point."""
        return mean_measures(runs)

    def _refer(self, runs: Sequence[PlantRun]) -> None:  # noqa: B027  most costs need none
        """Take from the runs of the start what costs refer to."""

    def document(self) -> dict[str, object]:
        """Plain data that names the problem with all that its results depend on."""
        return {
            "problem": self.name,
            "version": pitchopt.__version__,
            "space": self.space.document(),
            "start": self.start.tolist(),
            "wind_speeds": list(self.wind_speeds),
            "seeds": list(self.seeds),
            "base": "baseline" if self._base is None else plain(self._base),
            "plant": self.plant.document(),
        }

    def tuner_options(self, method: str) -> dict[str, Any]:
        """Options of a tuner by its name, as `pitchopt.tuning.make_tuner` takes them.

        The paper's for ``zoo``; none where the tuner's own serve.  With a ``start`` where a tuner
        had better begin elsewhere than at the start that costs refer to.  In common winds a point
        costs the same whenever it is evaluated, so the Bayesian tuner takes no variance as noise.
        """
        return {"noise": "fitted"} if method == "bayes" else {}


def start_within(space: Space, start: ArrayLike) -> FloatArray:
    """A start as a point of a space (d,).

    Raises
    ------
    InputError
        If it has another length, is not finite or lies outside.
    """
    try:
        return space.point(start)
    except InputError as error:
        raise InputError(f"start: {str(error).removeprefix('x: ')}") from error


def _each_once(field: str, values: Sequence[N]) -> tuple[N, ...]:
    if not values or len(set(values)) < len(values):
        raise InputError(f"{field}: got {tuple(values)}, expected at least one, each once")
    return tuple(values)
