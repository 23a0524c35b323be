"""Known functions are least where they say, and their noise depends on nothing but the point."""

from __future__ import annotations

import pickle

import numpy as np
import pytest
from scipy.optimize import minimize

from pitchopt.errors import InputError
from pitchopt.tuning.known_functions import ackley, branin, forrester, hartmann, rosenbrock

ALL = [
    forrester(),
    branin(),
    hartmann(3),
    hartmann(4),
    hartmann(6),
    ackley(3),
    rosenbrock(4),
]
SMOOTH = [function for function in ALL if not function.name.startswith("ackley")]
PUBLISHED = {
    "forrester": -6.020740,
    "branin": 0.397887,
    "hartmann3": -3.86278,
    "hartmann4": -3.134494,
    "hartmann6": -3.322368,
    "ackley3": 0.0,
    "rosenbrock4": 0.0,
}


def named(function):
    return function.name


def gradient(function, x, step):
    width = function.space.upper - function.space.lower
    return np.array(
        [(function(x + move) - function(x - move)) / (2 * step) for move in step * np.diag(width)]
    )


@pytest.mark.parametrize("function", ALL, ids=named)
def test_published_minimum_at_every_minimiser(function):
    assert function.minimum == pytest.approx(PUBLISHED[function.name], abs=2e-6)
    for minimiser in function.minimisers:
        assert function(minimiser) == pytest.approx(function.minimum, abs=1e-12)


@pytest.mark.parametrize("function", SMOOTH, ids=named)
def test_gradient_vanishes_at_the_minimiser(function):
    for minimiser in function.minimisers:
        slope = np.abs(gradient(function, minimiser, 1e-5)).max()
        away = function.space.from_unit(0.9 * function.space.to_unit(minimiser) + 0.05)
        assert slope < 1e-5 * max(np.abs(gradient(function, away, 1e-5)).max(), 1.0)


@pytest.mark.parametrize("function", ALL, ids=named)
def test_nothing_lies_below_the_minimum(function):
    space = function.space
    values = function.formula(space.from_unit(np.random.default_rng(1).random((20000, len(space)))))
    assert values.min() > function.minimum
    bounds = list(zip(space.lower, space.upper, strict=True))
    for start in np.random.default_rng(2).random((8, len(space))):
        found = minimize(function.formula, space.from_unit(start), bounds=bounds)
        assert found.fun > function.minimum - 1e-9


def test_forrester_at_hand():
    assert forrester()(1 / 3 * np.ones(1)) == pytest.approx(0.0)
    assert forrester()([0.0]) == pytest.approx(4 * np.sin(-4))


def test_noise_depends_on_seed_point_and_replicate_alone():
    noisy = branin().noisy(0.5, seed=3, replicates=3)
    first, other = noisy([1.0, 2.0]), noisy([1.0, 2.0 + 1e-12])
    assert pickle.loads(pickle.dumps(noisy))([1.0, 2.0]) == first  # noqa: S301  our own bytes
    assert len(set(first.replicates) | set(other.replicates)) == 6
    assert first.variance == pytest.approx(np.var(first.replicates, ddof=1) / 3)
    assert branin().noisy(0.5, seed=4, replicates=3)([1.0, 2.0]).cost != first.cost
    assert branin().noisy(0.5)([1.0, 2.0]).variance is None
    assert branin().noisy(0.5)([0.0, 2.0]).cost == branin().noisy(0.5)([-0.0, 2.0]).cost


def test_noise_has_the_spread_it_says():
    outcome = hartmann(3).noisy(0.2, replicates=4000)([0.2, 0.4, 0.6])
    residual = np.array(outcome.replicates) - hartmann(3)([0.2, 0.4, 0.6])
    assert abs(residual.mean()) < 4 * 0.2 / np.sqrt(4000)
    assert residual.std() == pytest.approx(0.2, rel=0.05)
    assert np.sqrt(outcome.variance) == pytest.approx(0.2 / np.sqrt(4000), rel=0.05)


def test_bad_input_is_named():
    with pytest.raises(InputError, match="dimensions: got 5, expected 3, 4 or 6"):
        hartmann(5)
    with pytest.raises(InputError, match="std: got -1"):
        branin().noisy(-1.0)
    with pytest.raises(InputError, match="x: got x1 = 11"):
        branin()([11.0, 0.0])
