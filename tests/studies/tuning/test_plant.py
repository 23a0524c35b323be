"""Plant of the tuning problems: same winds for all, measures, failures, threads, travelling."""

from __future__ import annotations

import dataclasses
import pickle

import numpy as np
import pytest

from pitchopt.errors import InputError
from pitchopt.fatigue import damage_equivalent_load
from pitchopt.studies.tuning import MEASURES, TuningPlant, failure_of, mean_measures

CASES = [(16.0, 1), (16.0, 2), (18.0, 1)]


@pytest.fixture(scope="module")
def plant():
    return TuningPlant(duration=40.0, skip=10.0, box_points=5, box_interval=0.25, workers=1)


@pytest.fixture(scope="module")
def controller(plant):
    return plant.operation.controller(frequency=0.6, damping=0.7, constant_power=False)


@pytest.fixture(scope="module")
def runs(plant, controller):
    return plant.run(controller, CASES)


def test_measures_are_those_of_the_series_without_the_start_up(runs):
    run = runs[0]
    sim = run.simulation
    rows = sim.time >= 10.0
    assert set(run.measures) == set(MEASURES)
    assert run.measures["power"] == pytest.approx(sim["GenPwr"][rows].mean(), rel=1e-12)
    assert run.measures["generator_speed"] == sim["GenSpeed"][rows].max()
    assert run.measures["flapwise_moment"] == max(sim[f"RootMyb{k}"][rows].max() for k in (1, 2, 3))
    length = rows.sum() * sim.interval
    tower = damage_equivalent_load(sim["TwrBsMyt"][rows], 4.0, duration=length)
    assert run.measures["tower_load"] == pytest.approx(tower, rel=1e-12)
    blades = [
        damage_equivalent_load(sim[f"RootMyc{k}"][rows], 10.0, duration=length) for k in (1, 2, 3)
    ]
    assert run.measures["blade_load"] == pytest.approx(np.mean(blades), rel=1e-12)


def test_runs_come_in_the_order_of_the_cases(runs):
    assert [(run.wind_speed, run.seed) for run in runs] == CASES
    assert len({run.measures["power"] for run in runs}) == len(CASES)


def test_mean_measures(runs):
    found = mean_measures(runs)
    expected = np.mean([run.measures["tower_load"] for run in runs])
    assert found["tower_load"] == pytest.approx(expected, rel=1e-14)


def test_a_wind_is_made_once(plant, controller, runs, monkeypatch):
    before = plant.simulations
    monkeypatch.setattr(
        "pitchopt.studies.simulation.winds.kaimal_box",
        lambda *_, **__: pytest.fail("the box was made again"),
    )
    again = plant.run(controller, [(16.0, 2)])
    assert again[0].measures == runs[1].measures
    assert plant.simulations == before + 1


def test_threads_and_another_process_change_nothing(plant, controller, runs):
    other = pickle.loads(pickle.dumps(plant))  # noqa: S301  our own bytes
    assert other.simulations == 0
    other.workers = 3
    assert [r.measures for r in other.run(controller, CASES)] == [r.measures for r in runs]
    assert other.document() == plant.document()


def test_a_run_that_diverges_is_a_failure_and_no_crash(plant, controller):
    wild = dataclasses.replace(controller, pitch=dataclasses.replace(
        controller.pitch, proportional=50.0 * controller.pitch.proportional,
        integral=1e3 * controller.pitch.integral,
    ))  # fmt: skip
    found = plant.run(wild, [(16.0, 1)])
    assert found[0].simulation.status == "diverged"
    message = failure_of(found)
    assert message is not None and "16 m/s, seed 1" in message and "diverged" in message


def test_what_finished_has_no_failure(runs):
    assert failure_of(runs) is None


def test_pitch_lag_is_an_actuator_of_first_order(controller, runs):
    slow = TuningPlant(
        duration=40.0, skip=10.0, box_points=5, box_interval=0.25, workers=1, pitch_lag=0.4
    )
    assert slow.dynamic.actuator.time_constant == 0.4
    assert slow.document()["pitch_lag"] == 0.4
    assert slow.run(controller, CASES[:1])[0].measures != runs[0].measures


@pytest.mark.parametrize(
    ("change", "word"),
    [
        ({"pitch_lag": -1.0}, "pitch_lag"),
        ({"workers": 0}, "workers"),
        ({"turbine": "nrel-6mw"}, "nrel-5mw"),
        ({"duration": 0.0}, "duration"),
        ({"inflow": "frozen"}, "inflow"),
    ],
)
def test_bad_input(change, word):
    with pytest.raises(InputError, match=word):
        TuningPlant(**change)


def test_a_bad_seed_is_named(plant, controller):
    with pytest.raises(InputError, match="seed"):
        plant.run(controller, [(16.0, -1)])


def test_steady_wind_is_the_same_with_every_seed(plant, controller):
    steady = plant.in_turbulence("none")
    first, second = steady.run(controller, [(16.0, 1), (16.0, 2)])
    assert (first.seed, second.seed) == (1, 2)
    assert first.measures == second.measures
    assert steady.document()["turbulence"] == "none"


def test_other_turbulence_has_the_same_turbine_and_other_winds(plant, controller, runs):
    other = plant.in_turbulence("0.05")
    assert other.operation is plant.operation
    assert other.dynamic is plant.dynamic
    assert other.simulations == 0
    calm = other.run(controller, [CASES[0]])[0]
    assert other.simulations == 1
    assert calm.measures["tower_load"] < runs[0].measures["tower_load"]
    assert plant.settings.turbulence == "B"
    again = other.in_turbulence("B").run(controller, [CASES[0]])[0]
    assert again.measures == runs[0].measures
