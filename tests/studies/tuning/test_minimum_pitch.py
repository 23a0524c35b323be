"""Minimum pitch: the cost of one breakpoint, the steps of algorithm 1, and a short tuning."""

from __future__ import annotations

import math
from types import SimpleNamespace

import numpy as np
import pytest

from pitchopt.control import MinimumPitchTable
from pitchopt.errors import ComputationError, InputError
from pitchopt.studies.tuning import (
    MinimumPitch,
    TableRuns,
    TuningPlant,
    initial_table,
    minimum_pitch_base,
    tune_minimum_pitch,
    tuned_by,
)
from pitchopt.studies.tuning.minimum_pitch_table import Peaks

DEG = math.pi / 180.0
PAPER = MinimumPitchTable(
    wind_speed=[5.0, 14.0, 18.0, 24.0, 50.0], pitch=DEG * np.array([0.0, 0.0, 9.0, 19.0, 90.0])
)


@pytest.fixture(scope="module")
def plant():
    return TuningPlant(duration=60.0, skip=20.0, box_points=7, box_interval=0.25, workers=1)


@pytest.fixture(scope="module")
def base(plant):
    return minimum_pitch_base(plant)


@pytest.fixture(scope="module")
def problem(plant, base):
    return MinimumPitch(plant, PAPER, 1, seed=2, kappa=0.2, base=base)


def test_the_paper_s_table(plant):
    table = initial_table(plant)
    np.testing.assert_array_equal(table.wind_speed, PAPER.wind_speed)
    np.testing.assert_allclose(table.pitch, PAPER.pitch, atol=1e-15)


def test_the_table_scales_with_the_turbine():
    plant = TuningPlant("iea-15-240", duration=20.0, skip=0.0, workers=1)
    table, turbine = initial_table(plant), plant.turbine
    ratio = turbine.rated_wind_speed / 11.4
    np.testing.assert_allclose(table.wind_speed[:4], ratio * PAPER.wind_speed[:4])
    assert np.all(np.diff(table.pitch[1:]) > 0.0)
    steady = np.interp(
        table.wind_speed[2:4], plant.operation.curve.wind_speed, plant.operation.curve.pitch
    )
    np.testing.assert_allclose(table.pitch[2:4] / steady, [9.0 / 14.92, 19.0 / 22.35])


def test_the_paper_s_middle_pitch_is_a_share_of_steady_operation(plant):
    curve = plant.operation.curve
    steady = np.interp([18.0, 24.0], curve.wind_speed, curve.pitch) / DEG
    np.testing.assert_allclose(steady, [14.92, 22.35], atol=0.75)


def test_cost_of_a_breakpoint(problem):
    assert problem.reference.cost == 1.0
    found = problem([4.0 * DEG])
    start = problem.reference.measures
    load = found.measures["flapwise_moment"] / start["flapwise_moment"]
    power = start["power"] / found.measures["power"]
    assert found.cost == pytest.approx(0.2 * load + 0.8 * power, rel=1e-12)
    assert load < 0.99
    assert power > 1.0
    run = problem.runs([4.0 * DEG])[0]
    assert (run.wind_speed, run.seed) == (14.0, 2)


def test_only_the_breakpoint_s_pitch_changes(problem):
    table = problem.controller([4.0 * DEG]).minimum_pitch
    np.testing.assert_allclose(table.pitch / DEG, [0.0, 4.0, 9.0, 19.0, 90.0])
    np.testing.assert_array_equal(PAPER.pitch[1], 0.0)


@pytest.mark.parametrize(
    ("place", "lower", "bounds", "first", "radius"),
    [
        (1, None, (0.0, 9.0), 0.5, 0.5),  # at the lower bound
        (2, None, (0.0, 19.0), 9.0, 0.5),  # inside
        (2, 8.8, (8.8, 19.0), 9.3, 0.5),  # half a degree above a bound found before
        (2, 9.0, (9.0, 19.0), 9.5, 0.5),
    ],
)
def test_bounds_and_first_point(plant, base, place, lower, bounds, first, radius):
    lower = None if lower is None else lower * DEG
    problem = MinimumPitch(plant, PAPER, place, seed=1, lower=lower, base=base)
    np.testing.assert_allclose(
        [problem.space.lower[0] / DEG, problem.space.upper[0] / DEG], bounds, atol=1e-12
    )
    assert problem.first[0] / DEG == pytest.approx(first)
    assert problem.radius / DEG == pytest.approx(radius)
    assert problem.tuner_options("zoo")["start"] == problem.first


def test_the_step_is_the_paper_s_in_degrees(problem):
    options = problem.tuner_options("zoo")
    slope = 1e-3  # of the cost per degree
    assert options["step"] * slope / DEG == pytest.approx(1500.0 * slope * DEG)
    assert (options["samples"], options["stages"], options["steps"]) == (2, 4, 3)


def test_narrow_bounds_narrow_the_samples(plant, base):
    table = MinimumPitchTable(
        wind_speed=PAPER.wind_speed, pitch=DEG * np.array([0.0, 8.2, 9.0, 19.0, 90.0])
    )
    problem = MinimumPitch(plant, table, 1, seed=1, lower=8.2 * DEG, base=base)
    assert problem.radius / DEG == pytest.approx(0.2)
    assert problem.first[0] / DEG == pytest.approx(8.4)


class Told(TableRuns):
    """Loads by wind speed, pitch there [deg] and seed, without simulations."""

    def __init__(self, plant, base, seeds, loads):
        super().__init__(plant, base, seeds)
        self.loads, self.asked = loads, []

    def peaks(self, table, wind_speed):
        pitch = 0.0 if table is None else float(table.lowest(wind_speed)) / DEG
        self.asked.append((wind_speed, round(pitch, 6)))
        return [Peaks(self.loads(wind_speed, pitch, seed), 1.0, 1.0) for seed in self.seeds]


def found_at(pitches, problems, cost=0.5):
    """Studies that find these pitches [deg], one after the other."""
    left = iter(pitches)

    def run(problem, label):
        problems.append((label, problem))
        return SimpleNamespace(
            best=SimpleNamespace(x=np.array([next(left) * DEG]), cost=cost), evaluations=()
        )

    return run


@pytest.mark.parametrize(
    ("loads", "compared", "tuned"),
    [
        ({14.0: 10.0, 18.0: 9.0, 24.0: 8.0}, "initial", [14.0]),
        ({14.0: 10.0, 18.0: 11.0, 24.0: 10.5}, "initial", [14.0, 18.0]),
        ({14.0: 10.0, 18.0: 9.0, 24.0: 8.0}, "tuned", [14.0, 18.0]),  # 14 m/s: 8.5 left
    ],
)
def test_breakpoints_with_less_load_than_another_are_skipped(plant, base, loads, compared, tuned):
    def load(speed, pitch, seed):
        return loads[speed] - (1.5 if speed == 14.0 and pitch > 0.0 else 0.0) - 0.1 * seed

    problems = []
    result = tune_minimum_pitch(
        plant,
        table=PAPER,
        base=base,
        seeds=(0, 1),
        compared=compared,
        run=found_at([2.0, 10.0], problems),
        runs=Told(plant, base, (0, 1), load),
    )
    assert [b.wind_speed for b in result.breakpoints if b.rounds] == tuned
    assert [problem.wind_speeds[0] for _, problem in problems] == tuned
    expected = [0.0, 2.0, 10.0 if 18.0 in tuned else 9.0, 19.0, 90.0]
    np.testing.assert_allclose(result.table.pitch / DEG, expected)
    # a later breakpoint is bounded by the one that was tuned before
    if 18.0 in tuned:
        assert problems[1][1].space.lower[0] / DEG == pytest.approx(2.0)


def test_a_new_worst_seed_is_tuned_next_from_the_pitch_that_was_found(plant, base):
    def load(speed, pitch, seed):
        if speed != 14.0:
            return 1.0
        return 10.0 - pitch if seed == 1 else 9.0 - 0.1 * pitch

    problems = []
    result = tune_minimum_pitch(
        plant,
        table=PAPER,
        base=base,
        seeds=(1, 2),
        run=found_at([2.0, 3.0], problems),
        runs=Told(plant, base, (1, 2), load),
    )
    assert [label for label, _ in problems] == ["14 m/s, round 1", "14 m/s, round 2"]
    assert [problem.seeds for _, problem in problems] == [(1,), (2,)]
    second = problems[1][1]
    assert second.space.lower[0] / DEG == pytest.approx(2.0)
    assert second.start[0] / DEG == pytest.approx(2.0)
    assert second.first[0] / DEG == pytest.approx(2.5)
    point = result.breakpoints[0]
    assert [r.pitch / DEG for r in point.rounds] == pytest.approx([2.0, 3.0])
    assert point.remaining == pytest.approx(8.7)


@pytest.mark.parametrize(("repeats", "rounds"), [(3, 4), (0, 1)])
def test_repeats_end(plant, base, repeats, rounds):
    def load(speed, pitch, seed):  # the worst seed changes with every degree
        return 10.0 + (seed == round(pitch) % 2) if speed == 14.0 else 1.0

    problems = []
    tune_minimum_pitch(
        plant,
        table=PAPER,
        base=base,
        seeds=(0, 1),
        repeats=repeats,
        run=found_at([1.0, 2.0, 3.0, 4.0, 5.0], problems),
        runs=Told(plant, base, (0, 1), load),
    )
    assert len(problems) == rounds


def test_a_table_that_costs_least_stays(plant, base):
    result = tune_minimum_pitch(
        plant,
        table=PAPER,
        base=base,
        seeds=(1,),
        run=found_at([3.0], [], cost=1.0),
        runs=Told(plant, base, (1,), lambda speed, *_: 20.0 - speed),
    )
    np.testing.assert_array_equal(result.table.pitch, PAPER.pitch)


def test_a_heavy_load_raises_the_pitch_and_lowers_the_peak(plant, base):
    before = plant.simulations
    result = tune_minimum_pitch(plant, base=base, kappa=0.3, seeds=(1, 2))
    assert result.simulations == plant.simulations - before > 0
    point = result.breakpoints[0]
    assert point.rounds
    assert result.table.pitch[1] > 2.0 * DEG
    assert point.remaining < 0.99 * point.loads.max()
    assert result.with_table.change(result.with_initial)["power"] < 0.0
    shape = (3, 2)
    assert result.without.blade.shape == result.without.tower.shape == shape
    # any other tuner finds its way through the same steps
    other = tune_minimum_pitch(
        plant, base=base, kappa=0.3, seeds=(1, 2), run=tuned_by("grid", evaluations=8)
    )
    assert other.table.pitch[1] > 2.0 * DEG
    # runs that are known are not made again
    runs = TableRuns(plant, base, (1, 2))
    runs.peaks(result.table, 14.0)
    known = plant.simulations
    assert runs.peaks(result.table, 14.0) is runs.peaks(result.table, 14.0)
    assert plant.simulations == known


def test_a_run_that_diverges_is_said(plant, base):
    class Diverging(TuningPlant):
        def run(self, controller, cases):
            found = super().run(controller, cases)
            for run in found:
                object.__setattr__(run.simulation, "status", "diverged")
            return found

    bad = Diverging(duration=4.0, skip=0.0, box_points=5, box_interval=0.25, workers=1)
    with pytest.raises(ComputationError, match="14 m/s, seed 1"):
        tune_minimum_pitch(bad, table=PAPER, base=base, seeds=(1,))


@pytest.mark.parametrize(
    ("call", "word"),
    [
        (lambda p, b: MinimumPitch(p, PAPER, 0, seed=1, base=b), "place"),
        (lambda p, b: MinimumPitch(p, PAPER, 4, seed=1, base=b), "place: got 4"),
        (lambda p, _: MinimumPitch(p, PAPER, 1, seed=1, base=p.operation.controller()), "estimat"),
        (lambda p, b: MinimumPitch(p, PAPER, 1, seed=1, kappa=1.5, base=b), "kappa"),
        (lambda p, b: MinimumPitch(p, PAPER, 1, seed=1, lower=0.5, base=b), "minimum_pitch"),
        (lambda p, b: tune_minimum_pitch(p, base=b, kappa=-1.0), "kappa"),
        (lambda p, b: tune_minimum_pitch(p, base=b, seeds=(1, 1)), "seeds"),
        (lambda p, b: tune_minimum_pitch(p, base=b, compared="other"), "compared"),
        (
            lambda p, b: tune_minimum_pitch(
                p, base=b, table=MinimumPitchTable(wind_speed=[5.0, 9.0, 20.0], pitch=[0, 0.2, 0.1])
            ),
            "descend",
        ),
    ],
)
def test_bad_input(plant, base, call, word):
    with pytest.raises(InputError, match=word):
        call(plant, base)
