"""Functions with known minimisers, to measure tuners by; exact or with noise.

Forrester, Sobester, Keane, Engineering design via surrogate modelling (2008), appendix A, which is
figure 2 of Mulders et al.; Branin and Hartmann 3 and 6 as in Dixon and Szego, Towards global
optimisation 2 (1978); Hartmann 4 as scaled by Picheny, Wagner, Ginsbourger, Struct. Multidisc.
Optim. 48 (2013) 607-626; Ackley (1987); Rosenbrock (1960).  Minimisers of Forrester and Hartmann
are stationary points to rounding; the others are exact.

Noise is a function of the seed, the point and the number of the replicate, never of the order of
calls: a study that is taken up again sees the noise it would have seen.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike

from pitchopt.checks import FloatArray, finite_array, finite_number, whole_number
from pitchopt.errors import InputError
from pitchopt.tuning.evaluations import Outcome
from pitchopt.tuning.space import Parameter, Space

__all__ = [
    "KnownFunction",
    "NoisyFunction",
    "ackley",
    "branin",
    "forrester",
    "hartmann",
    "rosenbrock",
]


@dataclass(frozen=True, kw_only=True)
class KnownFunction:
    """Function of a point, with where it is least.

    Attributes
    ----------
    name : str
    space : Space
    minimum : float
    minimisers : (k, d) ndarray
        All of them in the space.
    formula : callable
        (..., d) -> (...), without checks.
    """

    name: str
    space: Space
    minimum: float
    minimisers: FloatArray
    formula: Callable[[FloatArray], FloatArray] = field(repr=False)

    def __call__(self, x: ArrayLike) -> float:
        """Value at a point (d,) of the space."""
        return float(self.formula(self.space.point(x)))

    def noisy(self, std: float, *, seed: int = 0, replicates: int = 1) -> NoisyFunction:
        """The function with normal noise of standard deviation `std` on each replicate."""
        return NoisyFunction(function=self, std=std, seed=seed, replicates=replicates)


@dataclass(frozen=True, kw_only=True)
class NoisyFunction:
    """A known function that is seen through noise.

    Parameters
    ----------
    function : KnownFunction
    std : float
        Of the noise of a replicate.
    seed : int
    replicates : int
        Evaluations of a point that are averaged.  From two on the variance of their mean is
        estimated from them; the noise of a single one is left for the tuner to find.
    """

    function: KnownFunction
    std: float
    seed: int = 0
    replicates: int = 1

    def __post_init__(self) -> None:
        finite_number("std", self.std, at_least=0.0)
        whole_number("seed", self.seed, at_least=0)
        whole_number("replicates", self.replicates, at_least=1)

    @property
    def space(self) -> Space:
        """Space of the function."""
        return self.function.space

    def __call__(self, x: ArrayLike) -> Outcome:
        """Mean over the replicates at a point (d,) of the space."""
        point = self.function.space.point(x) + 0.0  # one zero, whatever its sign
        words = np.frombuffer(point.tobytes(), dtype=np.uint32).tolist()
        exact = float(self.function.formula(point))
        values = tuple(
            exact + self.std * float(np.random.default_rng([self.seed, number, *words]).normal())
            for number in range(self.replicates)
        )
        variance = float(np.var(values, ddof=1)) / self.replicates if self.replicates > 1 else None
        return Outcome(cost=float(np.mean(values)), variance=variance, replicates=values)


def forrester() -> KnownFunction:
    """(6 x - 2)^2 sin(12 x - 4) on [0, 1]."""
    return KnownFunction(
        name="forrester",
        space=_box(1, 0.0, 1.0),
        minimum=-6.0207400557670825,
        minimisers=finite_array("minimisers", [[0.7572487578418559]], shape=(1, 1)),
        formula=_forrester,
    )


def branin() -> KnownFunction:
    """Branin's function on [-5, 10] x [0, 15], with three minimisers of the value 5 / (4 pi)."""
    first = np.pi * np.array([-1.0, 1.0, 3.0])
    second = _BRANIN_B * first**2 - _BRANIN_C * first + 6.0
    return KnownFunction(
        name="branin",
        space=Space([Parameter(name="x1", low=-5, high=10), Parameter(name="x2", low=0, high=15)]),
        minimum=1.25 / np.pi,
        minimisers=finite_array("minimisers", np.stack([first, second], axis=1), shape=(3, 2)),
        formula=_branin,
    )


def hartmann(dimensions: int) -> KnownFunction:
    """Hartmann's function of 3, 4 or 6 parameters on the unit cube.

    Raises
    ------
    InputError
        If there is none of so many parameters.
    """
    if dimensions not in _HARTMANN:
        raise InputError(f"dimensions: got {dimensions!r}, expected 3, 4 or 6")
    minimum, minimiser, formula = _HARTMANN[dimensions]
    return KnownFunction(
        name=f"hartmann{dimensions}",
        space=_box(dimensions, 0.0, 1.0),
        minimum=minimum,
        minimisers=finite_array("minimisers", [minimiser], shape=(1, dimensions)),
        formula=formula,
    )


def ackley(dimensions: int = 2) -> KnownFunction:
    """Ackley's function on [-5, 10]^d, least at zero, where it has a kink."""
    count = whole_number("dimensions", dimensions, at_least=1)
    return KnownFunction(
        name=f"ackley{count}",
        space=_box(count, -5.0, 10.0),
        minimum=0.0,
        minimisers=finite_array("minimisers", np.zeros((1, count)), shape=(1, count)),
        formula=_ackley,
    )


def rosenbrock(dimensions: int = 2) -> KnownFunction:
    """Rosenbrock's valley on [-2.048, 2.048]^d, least at ones."""
    count = whole_number("dimensions", dimensions, at_least=2)
    return KnownFunction(
        name=f"rosenbrock{count}",
        space=_box(count, -2.048, 2.048),
        minimum=0.0,
        minimisers=finite_array("minimisers", np.ones((1, count)), shape=(1, count)),
        formula=_rosenbrock,
    )


def _box(dimensions: int, low: float, high: float) -> Space:
    return Space(
        Parameter(name=f"x{place}", low=low, high=high) for place in range(1, dimensions + 1)
    )


def _forrester(x: FloatArray) -> FloatArray:
    return np.asarray((6.0 * x[..., 0] - 2.0) ** 2 * np.sin(12.0 * x[..., 0] - 4.0))


_BRANIN_B, _BRANIN_C = 5.1 / (4.0 * np.pi**2), 5.0 / np.pi


def _branin(x: FloatArray) -> FloatArray:
    first, second = x[..., 0], x[..., 1]
    valley = second - _BRANIN_B * first**2 + _BRANIN_C * first - 6.0
    return np.asarray(valley**2 + 10.0 * (1.0 - 0.125 / np.pi) * np.cos(first) + 10.0)


def _ackley(x: FloatArray) -> FloatArray:
    spread = np.sqrt(np.mean(x**2, axis=-1))
    waves = np.mean(np.cos(2.0 * np.pi * x), axis=-1)
    return np.asarray(20.0 - 20.0 * np.exp(-0.2 * spread) + np.e - np.exp(waves))


def _rosenbrock(x: FloatArray) -> FloatArray:
    steps = 100.0 * (x[..., 1:] - x[..., :-1] ** 2) ** 2 + (1.0 - x[..., :-1]) ** 2
    return np.asarray(np.sum(steps, axis=-1))


_WEIGHTS = np.array([1.0, 1.2, 3.0, 3.2])
_RATES_3 = np.array([[3.0, 10, 30], [0.1, 10, 35], [3.0, 10, 30], [0.1, 10, 35]])
_CENTRES_3 = 1e-4 * np.array(
    [[3689, 1170, 2673], [4699, 4387, 7470], [1091, 8732, 5547], [381, 5743, 8828]]
)
_RATES_6 = np.array(
    [
        [10, 3, 17, 3.5, 1.7, 8],
        [0.05, 10, 17, 0.1, 8, 14],
        [3, 3.5, 1.7, 10, 17, 8],
        [17, 8, 0.05, 10, 0.1, 14],
    ]
)
_CENTRES_6 = 1e-4 * np.array(
    [
        [1312, 1696, 5569, 124, 8283, 5886],
        [2329, 4135, 8307, 3736, 1004, 9991],
        [2348, 1451, 3522, 2883, 3047, 6650],
        [4047, 8828, 8732, 5743, 1091, 381],
    ]
)


def _wells(x: FloatArray, rates: FloatArray, centres: FloatArray) -> FloatArray:
    distance = np.sum(rates * (x[..., None, :] - centres) ** 2, axis=-1)
    return np.asarray(-np.sum(_WEIGHTS * np.exp(-distance), axis=-1))


def _hartmann3(x: FloatArray) -> FloatArray:
    return _wells(x, _RATES_3, _CENTRES_3)


def _hartmann4(x: FloatArray) -> FloatArray:
    return (1.1 + _wells(x, _RATES_6[:, :4], _CENTRES_6[:, :4])) / 0.839


def _hartmann6(x: FloatArray) -> FloatArray:
    return _wells(x, _RATES_6, _CENTRES_6)


_HARTMANN = {
    3: (
        -3.862779787332663,
        [0.11458887665506896, 0.5556488946169301, 0.8525469846866774],
        _hartmann3,
    ),
    4: (
        -3.134494141222399,
        [0.1873952729734667, 0.19415152930244078, 0.5579177800625691, 0.26477962417039713],
        _hartmann4,
    ),
    6: (
        -3.322368011415515,
        [
            0.20168951100670543,
            0.15001069182345797,
            0.47687397422189703,
            0.2753324304940561,
            0.31165161660011326,
            0.6573005340656204,
        ],
        _hartmann6,
    ),
}
