"""CMA-ES: repeats, restarts, silence, and what is said when its package is missing."""

from __future__ import annotations

import builtins
import warnings

import numpy as np
import pytest
from driving import drive, same

from pitchopt.errors import InputError
from pitchopt.tuning import Outcome, Parameter, Space
from pitchopt.tuning.cma_es import CmaEs
from pitchopt.tuning.known_functions import rosenbrock

pytest.importorskip("cma")
BOX = Space([Parameter(name=f"z{i}", low=-2.0, high=3.0) for i in range(3)])


def bowl(x):
    return float(np.sum(np.arange(1, len(x) + 1) * (x - 0.7) ** 2))


def test_it_finds_the_bottom_of_a_valley():
    function = rosenbrock(3)
    tuner = CmaEs(function.space, seed=1)
    drive(tuner, function, 800)
    assert tuner.best().cost < 1e-3


def test_it_has_random_numbers_of_its_own():
    np.random.seed(1)  # noqa: NPY002  the numbers that it must not touch
    before = np.random.get_state()[1].copy()  # noqa: NPY002
    first = drive(CmaEs(BOX, seed=5), bowl, 120)
    assert np.array_equal(np.random.get_state()[1], before)  # noqa: NPY002
    np.random.seed(2)  # noqa: NPY002
    assert same(first, drive(CmaEs(BOX, seed=5), bowl, 120))
    assert not same(first, drive(CmaEs(BOX, seed=6), bowl, 120))


def test_a_generation_comes_at_once_and_grows_with_restarts():
    tuner = CmaEs(BOX, tolerance=0.05)
    sizes = {}
    while len(tuner.evaluations) < 1500:
        generation = tuner.ask(1000)
        search = generation[0].origin.split()[1].split(".")[0]
        assert sizes.setdefault(search, len(generation)) == len(generation)
        for candidate in generation:
            tuner.tell(candidate, bowl(candidate.x))
    assert list(sizes.values())[:3] == [7, 14, 28]  # 4 + 3 ln 3


def test_it_says_nothing(capfd):
    space = Space([Parameter(name="z", low=-2.0, high=3.0)])
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        drive(CmaEs(space), bowl, 100)
        drive(CmaEs(BOX), lambda _: 1.0, 300)  # equal costs
    assert capfd.readouterr() == ("", "")


def test_one_parameter():
    space = Space([Parameter(name="z", low=-2.0, high=3.0)])
    tuner = CmaEs(space)
    drive(tuner, bowl, 60)
    assert tuner.best().x == pytest.approx([0.7], abs=0.02)


def test_a_periodic_parameter_has_no_ends():
    space = Space(
        [
            Parameter(name="p", low=0.0, high=360.0, periodic=True),
            Parameter(name="z", low=-2.0, high=3.0),
        ]
    )
    tuner = CmaEs(space, start=[20.0, 0.0], size=0.1)
    drive(tuner, lambda x: float(x[1] ** 2 - np.cos(np.radians(x[0] - 330.0))), 150)
    assert tuner.best().x[0] == pytest.approx(330.0, abs=5.0)
    assert tuner.evaluations[-1].origin.startswith("generation 0")  # without a restart


def test_failures_and_constraints():
    def function(x):
        if x[0] > 1.5:
            return np.nan
        return Outcome(cost=bowl(x), constraints=(float(1.0 - x[0]),))

    tuner = CmaEs(BOX, start=[1.4, 2.0, 2.0], seed=2)
    drive(tuner, function, 300)
    best = tuner.best()
    assert best.evaluation.feasible
    assert best.x == pytest.approx([1.0, 0.7, 0.7], abs=0.1)
    lost = CmaEs(BOX)
    asked = drive(lost, lambda _: np.nan, 100)
    assert len(asked) == 100
    assert all(np.all((BOX.lower <= c.x) & (c.x <= BOX.upper)) for c in asked)


def test_a_missing_package_is_named(monkeypatch):
    plain = builtins.__import__

    def without(name, *rest, **more):
        if name == "cma":
            raise ImportError(name)
        return plain(name, *rest, **more)

    monkeypatch.setattr(builtins, "__import__", without)
    with pytest.raises(InputError, match=r"pip install 'pitchopt\[cma\]'"):
        CmaEs(BOX)


@pytest.mark.parametrize(
    ("settings", "message"),
    [
        ({"size": 0.0}, "size"),
        ({"population": 2}, "population"),
        ({"tolerance": -1.0}, "tolerance"),
        ({"start": [9.0, 0.0, 0.0]}, "z0 = 9"),
    ],
)
def test_bad_settings_are_named(settings, message):
    with pytest.raises(InputError, match=message):
        CmaEs(BOX, **settings)
