"""Every tuner by its name: repeats, is taken up bit by bit, bears failures, reaches minima."""

from __future__ import annotations

import json
from importlib.util import find_spec

import numpy as np
import pytest
from driving import drive, same

from pitchopt.errors import ComputationError, InputError
from pitchopt.tuning import Outcome, Parameter, Polar, Space
from pitchopt.tuning.known_functions import branin, hartmann
from pitchopt.tuning.methods import METHODS, make_tuner, method_options

BUILT = [
    name
    for name in METHODS
    if (name != "bayes" or find_spec("pitchopt.tuning.bayesian"))
    and (name != "cma-es" or find_spec("cma"))
]
SPACE = Space(
    [
        Parameter(name="gain", low=-1.0, high=2.0),
        Parameter(name="rate", low=1e-3, high=10.0, scale="log"),
        Parameter(name="offset", low=-np.pi, high=np.pi, periodic=True),
    ],
    polar=[Polar(radius="gain", angle="offset")],
)


def rough(x):
    """Least at (0.4, 1, 3), with a part that fails and one that is forbidden."""
    cost = (x[0] - 0.4) ** 2 + np.log10(x[1]) ** 2 + 1.0 - np.cos(x[2] - 3.0)
    return np.nan if x[0] > 1.2 else Outcome(cost=cost, constraints=(0.1 - x[0],))


@pytest.mark.parametrize("name", BUILT)
@pytest.mark.parametrize("parallel", [1, 3])
def test_a_study_that_is_taken_up_goes_on_bit_by_bit(name, parallel):
    count, stops = (18, (13,)) if name == "bayes" else (40, (1, 13, 31))  # it takes its time

    def fresh(seed=3):
        return make_tuner(name, SPACE, evaluations=40, seed=seed)

    whole = drive(fresh(), rough, count, parallel=parallel)
    for taken in stops:
        again = drive(fresh(), rough, count, parallel=parallel, journal=whole[:taken])
        assert same(whole, again)
    if name not in ("grid", "nelder-mead", "cobyla"):  # their first searches know no chance
        assert not same(whole, drive(fresh(seed=4), rough, count, parallel=parallel))


@pytest.mark.slow
@pytest.mark.parametrize("name", BUILT)
def test_failures_and_constraints_are_ordinary_results(name):
    tuner = make_tuner(name, SPACE, start=[1.1, 0.1, 0.5], evaluations=60, seed=1)
    drive(tuner, rough, 60)
    best = tuner.best()
    assert best.evaluation.feasible
    assert best.cost < tuner.evaluations[0].cost


@pytest.mark.parametrize("name", BUILT)
def test_a_cost_that_is_always_nan_is_no_crash(name):
    tuner = make_tuner(name, SPACE, evaluations=30)
    asked = drive(tuner, lambda _: np.nan, 30, parallel=2)
    for candidate in asked:
        assert np.array_equal(SPACE.point(candidate.x), candidate.x)
    with pytest.raises(ComputationError):
        tuner.best()


@pytest.mark.parametrize("name", BUILT)
def test_points_that_others_evaluated_are_no_crash(name):
    tuner = make_tuner(name, SPACE, evaluations=30)
    for candidate in tuner.ask(2):
        tuner.tell([0.4, 1.0, 3.0], -7.0, constraints=[-0.3])
        tuner.tell(candidate, rough(candidate.x))
    drive(tuner, rough, 20)
    if name != "bayes":  # whose best is a posterior mean
        assert tuner.best().evaluation.cost == -7.0


@pytest.mark.parametrize("name", BUILT)
def test_settings_are_plain_data_that_rebuild_the_tuner(name):
    tuner = make_tuner(name, SPACE, start=[0.0, 1.0, 0.0], evaluations=40, seed=2)
    settings = tuner.settings()
    assert json.loads(json.dumps(settings)) == settings
    assert settings.get("name", name) == tuner.name == name
    if name == "bayes":
        return  # its settings say more than its arguments
    given = {key: value for key, value in settings.items() if key not in ("name", "seed")}
    again = type(tuner)(SPACE, seed=2, **given)
    assert again.settings() == settings | {"start": pytest.approx(settings["start"], rel=1e-12)}


@pytest.mark.parametrize("name", BUILT)
def test_it_begins_at_a_start_that_is_given(name):
    tuner = make_tuner(name, SPACE, start=[0.5, 0.1, 1.0], evaluations=40)
    assert tuner.ask(1)[0].x == pytest.approx([0.5, 0.1, 1.0], rel=1e-12)


# Largest gap to the minimum of the median over nine seeds, in shares of the gap at the middle: on
# Branin with 60 evaluations and on Hartmann 4 with 120; behind it what was measured.
REACHED = {
    "zoo": (0.015, 0.06),  # 0.006, 0.025
    "bayes": (1e-4, 1e-3),  # 8e-7, 9e-8, of one seed
    "grid": (0.1, 0.6),  # 0.076, 0.559: nothing is random
    "random": (0.05, 0.35),  # 0.024, 0.221
    "lhs": (0.04, 0.35),  # 0.015, 0.247
    "sobol": (0.03, 0.35),  # 0.010, 0.229
    "spsa": (0.003, 0.03),  # 0.0005, 0.006
    "nelder-mead": (0.001, 0.13),  # 0.0000, 0.116: the second best minimum
    "cobyla": (0.001, 0.13),  # 0.0001, 0.116: the same
    "cma-es": (0.03, 0.2),  # 0.011, 0.118
}


@pytest.mark.slow
@pytest.mark.parametrize("name", BUILT)
@pytest.mark.parametrize(("place", "evaluations"), [(0, 60), (1, 120)])
def test_it_reaches_its_part_of_the_gap(name, place, evaluations):
    function = (branin(), hartmann(4))[place]
    count = 9 if name not in ("grid", "nelder-mead", "cobyla", "bayes") else 1
    gaps = []
    for seed in range(count):
        tuner = make_tuner(name, function.space, evaluations=evaluations, seed=seed)
        drive(tuner, function, evaluations)
        gaps.append(function(tuner.best().x) - function.minimum)
    whole = function(function.space.from_unit(np.full(len(function.space), 0.5)))
    assert np.median(gaps) / (whole - function.minimum) < REACHED[name][place]


# --- layout and input ---


@pytest.mark.parametrize("name", BUILT)
@pytest.mark.parametrize("evaluations", [10, 57])
@pytest.mark.parametrize("start", [None, [0.5, 0.1, 1.0]])
def test_it_is_laid_out_for_the_evaluations(name, evaluations, start):
    tuner = make_tuner(name, SPACE, evaluations=evaluations, start=start)
    asked = drive(tuner, lambda x: float(np.sum(x**2)), evaluations)
    assert len(asked) >= evaluations - 1  # pairs leave one over


def test_options_of_the_caller_come_first():
    tuner = make_tuner("grid", SPACE, evaluations=500, options={"points": 2})
    assert len(drive(tuner, lambda _: 1.0, 500)) == 8
    tuner = make_tuner("zoo", SPACE, evaluations=500, options={"stages": 2, "samples": 5})
    assert tuner.settings()["stages"] == 2
    assert tuner.settings()["samples"] == 5
    tuner = make_tuner("spsa", SPACE, evaluations=100, options={"calibration": 7})
    assert tuner.settings()["iterations"] == 42


@pytest.mark.parametrize(
    ("name", "hint"),
    [("zooo", "did you mean zoo?"), ("Nelder_Mead", "did you mean nelder-mead?"), ("x", "cma-es$")],
)
def test_a_wrong_name_is_answered_with_the_right_one(name, hint):
    with pytest.raises(InputError, match=f"method: got '{name}'.*{hint.replace('?', '.')}"):
        make_tuner(name, SPACE, evaluations=10)


@pytest.mark.parametrize(
    ("name", "options", "message"),
    [
        ("zoo", {"raduis": 0.1}, "option of zoo: got 'raduis'.*did you mean radius"),
        ("grid", {"seed": 1}, "option of grid: got 'seed', expected one of points, rounds"),
        ("random", {"points": 1}, "option of random: got 'points', it has none"),
        ("zoo", {"samples": "few"}, "samples"),
        ("spsa", {"calibration": 0}, "calibration"),
        ("lhs", {"samples": -3}, "samples"),
        ("cobyla", {"size": "big"}, "size"),
    ],
)
def test_a_wrong_option_is_named(name, options, message):
    with pytest.raises(InputError, match=message):
        make_tuner(name, SPACE, evaluations=10, options=options)


def test_a_wrong_number_of_evaluations_is_named():
    with pytest.raises(InputError, match="evaluations"):
        make_tuner("zoo", SPACE, evaluations=0)


def test_options_by_name():
    assert method_options("grid") == ("points", "rounds")
    assert method_options("random") == ()
