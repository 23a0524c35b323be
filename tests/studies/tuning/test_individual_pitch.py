"""Cost of individual pitch: what it is, its symmetries, and that it acts below rated too."""

from __future__ import annotations

import dataclasses
import math

import numpy as np
import pytest

from pitchopt.errors import InputError
from pitchopt.fatigue import bin_edges, combine_loads, weibull_weights
from pitchopt.studies.tuning import (
    IndividualPitchGains,
    fixed_frame_response,
    individual_pitch_plant,
)
from pitchopt.tuning import run_study, variance_of_mean
from pitchopt.tuning.methods import make_tuner

SEEDS = (1, 2, 3)


@pytest.fixture(scope="module")
def plant():
    return individual_pitch_plant(
        duration=60.0, skip=20.0, box_points=7, box_interval=0.25, workers=1
    )


@pytest.fixture(scope="module")
def problem(plant):
    return IndividualPitchGains(plant, wind_speeds=(15.0,), seeds=SEEDS)


def test_the_start_is_the_controller_without_individual_pitch(plant, problem):
    runs = plant.run(plant.operation.baseline(), [(15.0, seed) for seed in SEEDS])
    loads = [run.measures["blade_load"] for run in runs]
    np.testing.assert_allclose(problem.reference.replicates, loads, rtol=1e-12)
    assert problem.reference.cost == pytest.approx(np.mean(loads), rel=1e-12)
    assert plant.pitch_lag == 0.4


def test_the_handbook_takes_off_load_for_more_pitch_travel(problem):
    off, found = problem.reference, problem(problem.handbook)
    assert 0.6 < found.cost / off.cost < 0.95
    assert found.measures["pitch_rate"] > 2.0 * off.measures["pitch_rate"]
    assert found.measures["power"] == pytest.approx(off.measures["power"], rel=0.01)
    assert found.variance == variance_of_mean(found.replicates, off.replicates)
    assert found.variance < np.var(found.replicates, ddof=1) / len(SEEDS)


@pytest.mark.parametrize("order", [1, 2])
def test_half_a_period_of_the_offset_turns_the_sign(problem, order):
    x = problem.handbook.copy()
    right, place = problem(x), 2 * order - 1
    x[place] += math.pi / order
    assert problem(x).cost > 1.05 * problem.reference.cost > right.cost
    x[place] += math.pi / order
    assert problem(x).cost == pytest.approx(right.cost, rel=1e-6)


def test_offsets_of_gain_zero_are_one_controller(problem):
    found = problem([0.0, 1.0, 0.0, -0.7])
    assert found.cost == pytest.approx(problem.reference.cost, rel=1e-12)
    space = problem.space
    features = space.features(space.to_unit([[0.0, 1.0, 0.0, -0.7], [0.0, 0.0, 0.0, 0.0]]))
    np.testing.assert_allclose(features[0], features[1], atol=1e-15)


def test_it_acts_below_rated_wind_speed_and_below_the_fine_pitch(plant):
    problem = IndividualPitchGains(plant, wind_speeds=(7.0,), seeds=(1, 2))
    found = problem(problem.handbook)
    assert found.cost < 0.99 * problem.reference.cost
    series = problem.runs(problem.handbook)[0].simulation["BldPitch1"]
    assert series.min() < plant.operation.fine_pitch - math.radians(0.1)


def test_the_largest_gain_makes_loops_as_fast_as_the_rotor_turns(plant, problem):
    played = fixed_frame_response(
        plant.dynamic, 15.0, offset=problem.handbook[1], operation=plant.operation
    )
    # the actuators and the flexible blade let through 60 to 100 % of what the wake at rest gives
    bandwidth = problem.space.upper[0] * np.linalg.norm(played.matrix[:, 0])
    assert 0.6 < bandwidth / plant.operation.start(15.0).rotor_speed < 1.0
    fastest = [problem.space.upper[0], problem.handbook[1], 0.0, 0.0]
    assert problem(fastest).cost < problem.reference.cost  # not far from its limit, but stable


def test_the_largest_gain_suits_each_wind_speed(plant):
    gains = [
        IndividualPitchGains(plant, wind_speeds=speeds, seeds=(1,)).space.upper[0]
        for speeds in ((7.0,), (15.0,), (7.0, 15.0))
    ]
    assert gains[0] > 1.2 * gains[1]  # pitch takes off less load below rated
    assert gains[2] == gains[1]


def test_several_wind_speeds_are_summed_in_damage(plant):
    speeds = (9.0, 15.0)
    both = IndividualPitchGains(plant, wind_speeds=speeds, seeds=(1, 2), weibull_mean=8.5)
    parts = [IndividualPitchGains(plant, wind_speeds=(u,), seeds=(1, 2)) for u in speeds]
    weights = weibull_weights(bin_edges(speeds), mean=8.5, normalised=True)
    loads = np.array([part.reference.replicates for part in parts]).T
    np.testing.assert_allclose(
        both.reference.replicates, combine_loads(loads, weights, 10.0), rtol=1e-12
    )
    assert both.document()["weibull_mean"] == 8.5
    assert parts[0].document()["weibull_mean"] is None


def test_a_run_that_diverges_is_a_failed_evaluation(problem, monkeypatch):
    problem.reference  # noqa: B018  (before runs diverge)
    run = type(problem.plant).run

    def diverging(plant, controller, cases):
        found = run(plant, controller, cases)
        bad = dataclasses.replace(found[1].simulation, status="diverged", message="diverged at 3 s")
        return [found[0], dataclasses.replace(found[1], simulation=bad), *found[2:]]

    monkeypatch.setattr(type(problem.plant), "run", diverging)
    found = problem(problem.handbook)
    assert math.isnan(found.cost)
    assert found.message == "15 m/s, seed 2: diverged at 3 s"


@pytest.mark.parametrize(
    ("options", "word"),
    [
        ({"wind_speeds": (15.0, 9.0)}, "ascending"),
        ({"seeds": ()}, "seeds"),
        ({"weibull_mean": -1.0}, "weibull_mean"),
    ],
)
def test_bad_input(plant, options, word):
    with pytest.raises(InputError, match=word):
        IndividualPitchGains(plant, **options)


@pytest.mark.slow
def test_a_bayesian_study_beats_the_handbook(plant):
    problem = IndividualPitchGains(plant, wind_speeds=(15.0,), seeds=SEEDS)
    tuner = make_tuner("bayes", problem.space, evaluations=40)
    study = run_study(problem, tuner, evaluations=40, problem=problem.document())
    assert study.best.cost < problem(problem.handbook).cost
    assert len(study.evaluations) == 40
