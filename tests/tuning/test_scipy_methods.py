"""Nelder-Mead and COBYLA inside out: the same points as SciPy's own, and threads that end."""

from __future__ import annotations

import gc
import itertools
import threading

import numpy as np
import pytest
import scipy
from driving import drive
from scipy.optimize import minimize

from pitchopt.errors import InputError
from pitchopt.tuning import Outcome, Parameter, Space
from pitchopt.tuning.known_functions import rosenbrock
from pitchopt.tuning.scipy_methods import Cobyla, NelderMead, inverted

BOTH = [NelderMead, Cobyla]
UNIT = Space([Parameter(name="a", low=0.0, high=1.0), Parameter(name="b", low=0.0, high=1.0)])


def valley(x):
    return float(10.0 * (x[1] - x[0] ** 2) ** 2 + (0.3 - x[0]) ** 2)


def searching():
    return [thread for thread in threading.enumerate() if thread.name == "pitchopt-search"]


@pytest.fixture(autouse=True)
def _no_thread_of_an_earlier_test():
    gc.collect()
    assert not searching()


# --- inversion ---


def counted(function):
    for u in range(3):
        cost, _ = function(np.array([float(u)]))
        assert cost == 10.0 * u


def test_a_search_is_a_generator_of_its_points():
    search = inverted(counted)
    assert next(search) == [0.0]
    assert search.send((0.0, np.zeros(0))) == [1.0]
    assert search.send((10.0, np.zeros(0))) == [2.0]
    with pytest.raises(StopIteration):
        search.send((20.0, np.zeros(0)))
    assert not searching()


def test_an_error_of_the_search_comes_out_here():
    search = inverted(counted)
    next(search)
    with pytest.raises(AssertionError):
        search.send((5.0, np.zeros(0)))
    assert not searching()


def test_the_thread_ends_when_its_search_is_closed():
    search = inverted(counted)
    next(search)
    assert len(searching()) == 1
    search.close()
    assert not searching()


@pytest.mark.parametrize("kind", BOTH)
def test_the_thread_ends_when_its_tuner_is_dropped(kind):
    tuner = kind(UNIT)
    drive(tuner, valley, 10)
    assert len(searching()) == 1
    del tuner
    gc.collect()
    assert not searching()


# --- the methods ---


def test_nelder_mead_asks_for_the_points_of_scipy():
    start = np.array([0.6, 0.9])
    simplex = np.array([start, [0.8, 0.9], [0.6, 0.7]])
    seen = []

    def watched(u):
        seen.append(u.copy())
        return valley(u)

    options = {"initial_simplex": simplex, "xatol": 1e-4, "fatol": np.inf}
    minimize(watched, start, method="Nelder-Mead", bounds=[(0, 1)] * 2, options=options)
    asked = [candidate.x for candidate in drive(NelderMead(UNIT, start=start), valley, len(seen))]
    unique = list(dict.fromkeys(tuple(u) for u in seen))  # none is evaluated twice
    assert np.array_equal(asked[: len(unique)], unique)


def test_cobyla_asks_for_the_points_of_scipy():
    start = np.array([0.6, 0.7])
    seen = []

    def watched(u):
        seen.append(u.copy())
        return valley(u)

    options = {"rhobeg": 0.2, "tol": 1e-4, "catol": 0.0}
    minimize(watched, start, method="COBYLA", bounds=[(0, 1)] * 2, options=options)
    unique = list(dict.fromkeys(tuple(np.clip(u, 0.0, 1.0)) for u in seen))
    tuner = Cobyla(UNIT, start=start)
    asked = [candidate.x for candidate in drive(tuner, valley, len(unique))]
    assert np.allclose(asked, unique, rtol=0.0, atol=1e-15)


@pytest.mark.parametrize("kind", BOTH)
def test_it_converges_and_begins_anew_elsewhere(kind):
    tuner = kind(UNIT, tolerance=1e-3)
    asked = drive(tuner, valley, 400)
    assert len(asked) == 400
    assert tuner.best().x == pytest.approx([0.3, 0.09], abs=0.02)
    starts = [candidate.x for candidate in asked if candidate.origin.startswith("start")]
    assert len(starts) >= 3
    assert not any(np.array_equal(a, b) for a, b in itertools.pairwise(starts))
    other = drive(kind(UNIT, tolerance=1e-3, seed=1), valley, 400)
    late = [candidate.x for candidate in other if candidate.origin.startswith("start")]
    assert np.array_equal(starts[0], late[0])
    assert not np.array_equal(starts[1], late[1])


@pytest.mark.parametrize("kind", BOTH)
def test_four_parameters(kind):
    function = rosenbrock(4)
    tuner = kind(function.space, start=np.full(4, -1.0), tolerance=1e-6)
    drive(tuner, function, 600)
    assert tuner.best().cost < 1e-2 * function(np.full(4, -1.0))


@pytest.mark.parametrize("kind", BOTH)
def test_a_constrained_minimum(kind):
    # least x + y with x y >= 0.25 is 1 at (0.5, 0.5), where the constraint is active
    def function(x):
        return Outcome(cost=float(x[0] + x[1]), constraints=(float(0.25 - x[0] * x[1]),))

    tuner = kind(UNIT, start=[0.9, 0.2])
    drive(tuner, function, 150)
    best = tuner.best()
    assert best.evaluation.feasible
    assert best.cost == pytest.approx(1.0, abs=0.01)


def test_cobyla_follows_an_active_constraint_closely():
    def function(x):
        return Outcome(cost=float(x[0] + x[1]), constraints=(float(0.25 - x[0] * x[1]),))

    tuner = Cobyla(UNIT, start=[0.2, 0.2])
    drive(tuner, function, 60)
    assert tuner.best().x == pytest.approx([0.5, 0.5], abs=0.02)


@pytest.mark.parametrize("kind", BOTH)
def test_it_starts_where_something_works(kind):
    # all fails at the start and elsewhere but in a corner
    tuner = kind(UNIT, start=[0.1, 0.1])
    drive(tuner, lambda x: valley(x) if x[0] + x[1] > 0.8 else np.nan, 150)
    assert tuner.evaluations[0].status == "failed"
    assert tuner.best().cost < 0.1


def test_nelder_mead_begins_anew_at_the_first_feasible_point():
    def function(x):
        return Outcome(cost=100.0 + x[0], constraints=(0.5 - x[0],))

    tuner = NelderMead(UNIT, start=[0.1, 0.5])
    drive(tuner, function, 80)
    first = next(place for place, e in enumerate(tuner.evaluations) if e.feasible)
    assert tuner.evaluations[first].origin == "search 1"
    gain = tuner.evaluations[first + 1].x - tuner.evaluations[first].x
    assert np.linalg.norm(gain) == pytest.approx(0.2)  # a simplex as at the beginning
    assert tuner.best().cost == pytest.approx(100.5, abs=1e-2)


@pytest.mark.parametrize("kind", BOTH)
def test_a_periodic_parameter_has_no_ends(kind):
    space = Space([Parameter(name="p", low=0.0, high=360.0, periodic=True)])
    tuner = kind(space, start=[20.0], size=0.05)
    drive(tuner, lambda x: -float(np.cos(np.radians(x[0] - 340.0))), 40)
    starts = [e for e in tuner.evaluations if e.origin.startswith("start")]
    last = starts[1].index if len(starts) > 1 else 40
    best = min(tuner.evaluations[:last], key=lambda e: e.cost)
    assert best.x == pytest.approx([340.0], abs=1.0)


@pytest.mark.parametrize("kind", BOTH)
@pytest.mark.parametrize(
    ("settings", "message"),
    [
        ({"size": 0.0}, "size"),
        ({"size": 0.7}, "size"),
        ({"tolerance": 0.0}, "tolerance"),
        ({"tolerance": 0.3}, "less than the size"),
        ({"start": [2.0, 0.0]}, "a = 2"),
    ],
)
def test_bad_settings_are_named(kind, settings, message):
    with pytest.raises(InputError, match=message):
        kind(UNIT, **settings)


def test_an_old_scipy_is_refused(monkeypatch):
    monkeypatch.setattr(scipy, "__version__", "1.15.3")
    with pytest.raises(InputError, match=r"expected 1\.16"):
        Cobyla(UNIT)
