"""Torque gain and speed regulator: costs, references, variance, documents, failures, journals."""

from __future__ import annotations

import json
import math
import pickle

import numpy as np
import pytest

from pitchopt.errors import ComputationError, InputError
from pitchopt.studies.tuning import SpeedRegulator, TorqueGain, TuningPlant, plain
from pitchopt.studies.tuning.torque_gain import weibull_density
from pitchopt.tuning import ZerothOrder, run_study
from pitchopt.tuning.grid import Grid
from pitchopt.tuning.methods import METHODS, make_tuner


def test_weibull_density_is_that_of_scipy_and_holds_all_winds():
    from scipy.stats import weibull_min

    speeds = np.linspace(0.5, 40.0, 400)
    ours = np.array([weibull_density(u) for u in speeds])
    assert ours == pytest.approx(weibull_min.pdf(speeds, 2.17, scale=10.3), rel=1e-12)


def test_torque_cost_is_minus_the_weighted_power(gain):
    outcome = gain([0.9])
    weights = np.array([weibull_density(u) for u in (6.0, 8.0, 10.0)])
    powers = np.array([outcome.measures[f"power_{u}"] for u in (6, 8, 10)])
    assert outcome.cost == pytest.approx(-(weights @ powers) / weights.sum(), rel=1e-12)
    assert outcome.measures["power"] == pytest.approx(powers.mean(), rel=1e-12)
    assert outcome.variance is None and len(outcome.replicates) == 1


def test_torque_factor_multiplies_the_published_gain(gain):
    law = gain.controller(np.array([0.8])).torque
    assert law.optimal_gain == pytest.approx(0.8 * 2.332287)
    assert gain.simulations == 3


def test_one_wind_speed_alone_is_its_own_mean(small):
    alone = TorqueGain(small, wind_speeds=(8.0,))
    outcome = alone([0.9])
    assert outcome.cost == pytest.approx(-outcome.measures["power"], rel=1e-12)


def test_regulator_follows_from_frequency_and_damping(regulator):
    plant = regulator.plant
    found = regulator.controller(np.array([0.2, 1.5]))
    start = regulator.controller(regulator.start)
    assert not found.torque.constant_power
    ratio = found.pitch.proportional / start.pitch.proportional
    assert ratio == pytest.approx(0.2 * 1.5 / (0.6 * 0.7), rel=1e-3)
    assert found.pitch.integral / start.pitch.integral == pytest.approx((0.2 / 0.6) ** 2, rel=1e-3)
    assert plant.turbine.name == "nrel-5mw"


def test_start_is_the_handbook_s_scaled_by_rotor_speed():
    slow = SpeedRegulator(TuningPlant("iea-15-240"))
    fast = SpeedRegulator(TuningPlant("nrel-5mw"))
    assert fast.start == pytest.approx([0.6, 0.7], rel=1e-3)
    ratio = slow.plant.turbine.rated_rotor_speed / fast.plant.turbine.rated_rotor_speed
    assert slow.start == pytest.approx([0.6 * ratio, 0.7], rel=1e-3)


@pytest.mark.parametrize(("turbine", "speed"), [("nrel-5mw", 12.0), ("iea-3.4-130", 10.0)])
def test_wind_speed_is_the_first_above_rated(turbine, speed):
    problem = SpeedRegulator(TuningPlant(turbine))
    rated = problem.plant.turbine.rated_wind_speed
    assert problem.wind_speeds == (speed,)
    assert rated < speed <= rated + 1.0


def test_barrier_is_quadratic_and_a_twelfth_of_the_load_at_the_hard_limit(regulator):
    load = regulator.reference.measures["tower_load"]
    rpm = math.pi / 30.0
    assert regulator.soft_speed == pytest.approx(1300.0 * rpm, rel=1e-3)
    assert regulator.hard_speed == pytest.approx(1400.0 * rpm, rel=1e-3)
    assert regulator.barrier(regulator.soft_speed) == 0.0
    assert regulator.barrier(0.5 * regulator.soft_speed) == 0.0
    assert regulator.barrier(regulator.hard_speed) == pytest.approx(load / 12.0, rel=1e-12)
    half = 0.5 * (regulator.soft_speed + regulator.hard_speed)
    assert regulator.barrier(half) == pytest.approx(load / 48.0, rel=1e-9)


def test_cost_beyond_the_soft_limit_is_load_and_barrier(small):
    regulator = SpeedRegulator(small, seeds=(2,))
    outcome = regulator([0.05, 0.3])
    speed = outcome.measures["generator_speed"]
    assert speed > regulator.soft_speed
    expected = outcome.measures["tower_load"] + regulator.barrier(speed)
    assert outcome.cost == pytest.approx(expected, rel=1e-12)
    assert outcome.cost > outcome.measures["tower_load"]


def test_flapwise_moment_as_load(small):
    problem = SpeedRegulator(small, load="flapwise_moment")
    reference = problem.reference
    assert reference.cost == pytest.approx(reference.measures["flapwise_moment"], rel=1e-12)


def test_the_start_is_simulated_once(small):
    problem = SpeedRegulator(small)
    before = small.simulations
    first = problem([0.3, 1.0])
    assert small.simulations == before + 2
    assert problem(problem.start) is problem.reference
    assert small.simulations == before + 2
    assert problem.simulations_in([[0.3, 1.0]]) == 2
    assert problem.simulations_in([[0.3, 1.0], problem.start]) == 2
    assert problem([0.3, 1.0]).cost == first.cost


def test_variance_leaves_out_what_seeds_have_in_common(two_seeds):
    reference, other = two_seeds.reference, two_seeds([0.2, 1.5])
    assert reference.variance is None
    assert reference.cost == pytest.approx(np.mean(reference.replicates), rel=1e-14)
    difference = np.array(other.replicates) - np.array(reference.replicates)
    assert other.variance == pytest.approx(np.var(difference, ddof=1) / 4.0, rel=1e-12)


def test_a_loop_that_diverges_is_a_failed_evaluation(small):
    calm = SpeedRegulator(small)
    outcome = calm([1.0, 3.0])
    assert math.isnan(outcome.cost)
    assert "12 m/s, seed 1" in outcome.message and "diverged" in outcome.message
    result = run_study(calm, Grid(calm.space, points=2, start=calm.start), evaluations=5)
    failed = [e for e in result.evaluations if e.status == "failed"]
    assert [tuple(e.x) for e in failed][-1] == (1.0, 3.0)
    assert failed[-1].message == outcome.message
    assert np.isfinite(result.best.cost)


def test_a_start_that_diverges_names_itself(small):
    problem = SpeedRegulator(small, start=(1.0, 3.0))
    with pytest.raises(ComputationError, match=r"the start \[1\. 3\.\] cannot be judged"):
        problem([0.6, 0.7])


def test_travelling_keeps_the_reference_and_the_cost(small):
    problem = SpeedRegulator(small)
    other = pickle.loads(pickle.dumps(problem))  # noqa: S301  our own bytes
    assert other._reference is not None
    assert other.plant.simulations == 0
    assert other([0.3, 1.0]).cost == problem([0.3, 1.0]).cost
    assert other.plant.simulations == 1


def test_a_plant_that_comes_again_finds_its_winds(small, monkeypatch):
    problem = SpeedRegulator(small)
    data = pickle.dumps(problem)
    first = pickle.loads(data)([0.3, 1.0])  # noqa: S301  our own bytes
    monkeypatch.setattr(
        "pitchopt.studies.simulation.winds.kaimal_box",
        lambda *_, **__: pytest.fail("the box was made again"),
    )
    assert pickle.loads(data)([0.3, 1.0]) == first  # noqa: S301  our own bytes


@pytest.mark.parametrize("fixture", ["gain", "regulator"])
def test_document_is_plain_and_tells_problems_apart(fixture, request, small):
    problem = request.getfixturevalue(fixture)
    document = json.loads(json.dumps(problem.document()))
    assert document == problem.document()
    assert document["problem"] == problem.name
    other = type(problem)(small, seeds=(7,))
    assert other.document() != document
    tuned = type(problem)(small, base=problem.controller(problem.start))
    json.dumps(tuned.document(), allow_nan=False)
    assert tuned.document() != document


def test_plain_leaves_out_what_is_private_and_names_infinity(small):
    found = plain(small.operation.baseline())
    assert "_run" not in found
    assert found["torque"]["gain"] == 2.332287
    assert plain({"a": (np.float64(1.0), math.inf)}) == {"a": [1.0, "inf"]}


@pytest.mark.parametrize("fixture", ["gain", "regulator"])
def test_every_tuner_can_be_made_for_it(fixture, request):
    problem = request.getfixturevalue(fixture)
    for method in METHODS:
        if method == "cma-es":
            pytest.importorskip("cma")
        tuner = make_tuner(
            method, problem.space, start=problem.start, evaluations=20,
            options=problem.tuner_options(method),
        )  # fmt: skip
        assert tuner.ask(1)


def test_settings_of_the_paper(gain, regulator):
    torque = ZerothOrder(gain.space, start=gain.start, **gain.tuner_options("zoo"))
    assert (torque.samples, torque.stages, torque.step, torque.steps) == (2, 7, 10.0, 3)
    assert (torque.shrinkage, torque.threshold) == (0.5, 0.05)
    assert torque.radius.tolist() == [0.05]
    pitch = ZerothOrder(regulator.space, start=regulator.start, **regulator.tuner_options("zoo"))
    assert (pitch.samples, pitch.stages, pitch.step, pitch.steps) == (3, 7, 3.0, 3)
    assert pitch.scaling.tolist() == [0.25, 1.0]
    assert pitch.step_over == "tower_load"
    assert regulator.space.lower.tolist() == [0.01, 0.1]
    assert regulator.space.upper.tolist() == [1.0, 3.0]


@pytest.mark.parametrize(
    ("change", "word"),
    [
        ({"seeds": ()}, "seeds"),
        ({"seeds": (1, 1)}, "seeds"),
        ({"wind_speeds": (12.0, 12.0)}, "wind_speeds"),
        ({"start": (0.6, 7.0)}, "zeta"),
        ({"load": "thrust"}, "load"),
        ({"plant": "nrel-5mw"}, "plant"),
    ],
)
def test_bad_input(small, change, word):
    with pytest.raises(InputError, match=word):
        SpeedRegulator(**({"plant": small} | change))


def test_a_point_outside_is_refused(gain):
    with pytest.raises(InputError, match="k_fact"):
        gain([2.0])


@pytest.mark.slow
def test_best_torque_factor_is_near_one_and_lower_in_region_two_alone():
    plant = TuningPlant(turbulence="A")
    factors = np.array([0.5, 0.7, 0.8, 0.9, 1.0, 1.1, 1.3, 1.5])
    three = TorqueGain(plant, seeds=(1, 2, 3))
    alone = TorqueGain(plant, wind_speeds=(8.0,), seeds=(1, 2, 3))
    best = factors[np.argmin([three([k]).cost for k in factors])]
    lower = factors[np.argmin([alone([k]).cost for k in factors])]
    assert 0.85 <= best <= 1.05
    assert lower <= best and lower < 0.95


@pytest.mark.slow
@pytest.mark.parametrize("turbulence", ["A", "B", "C"])
def test_regulator_of_the_paper(turbulence):
    problem = SpeedRegulator(TuningPlant(turbulence=turbulence))
    tuner = ZerothOrder(problem.space, start=problem.start, **problem.tuner_options("zoo"))
    best = run_study(problem, tuner, evaluations=100).best
    assert best.x[0] < 0.25 and best.x[1] > 0.9
    assert 0.7 < best.cost / problem.reference.cost < 0.85
    assert best.evaluation.measures["generator_speed"] < 1.01 * problem.hard_speed
