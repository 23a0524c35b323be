"""Searches against grids, settings by the guidelines, and the sequence of tunings."""

from __future__ import annotations

import matplotlib as mpl
import numpy as np
import pytest

from pitchopt.control import MinimumPitchTable
from pitchopt.errors import ComputationError, InputError
from pitchopt.plotting.tuning_comparison import (
    comparison_figure,
    plot_costs_by_simulations,
    plot_found_minima,
)
from pitchopt.studies.tuning import (
    SpeedRegulator,
    agreement,
    compare_with_grids,
    newton_scaling,
    tune_by_guidelines,
    tune_in_sequence,
)
from pitchopt.studies.tuning.grid_comparison import QUADRANTS
from pitchopt.tuning import Evaluation, Parameter, Space, ZerothOrder

mpl.use("Agg")

BOWL = Space([Parameter(name="a", low=0.0, high=2.0), Parameter(name="b", low=-1.0, high=1.0)])
LOWEST = np.array([0.8, 0.2])


def bowl(x):
    return 3.0 + 4.0 * (x[0] - LOWEST[0]) ** 2 + (x[1] - LOWEST[1]) ** 2


def evaluated(points, cost=bowl):
    return [Evaluation(index=i, x=x, cost=cost(x)) for i, x in enumerate(points)]


@pytest.fixture(scope="module")
def grid():
    return [np.array([a, b]) for a in np.linspace(0, 2, 5) for b in np.linspace(-1, 1, 5)]


@pytest.fixture(scope="module")
def problem(small):
    return SpeedRegulator(small)


@pytest.fixture(scope="module")
def comparison(problem):
    return compare_with_grids(problem, grids=(2, 3), searches=((3, 1), (4, 1)), repeats=2, seed=3)


def test_scaling_is_the_inverse_of_second_derivatives(grid):
    # 8 and 2 in parameters, both over ranges of 2
    assert newton_scaling(BOWL, evaluated(grid)) == pytest.approx([0.25, 1.0], rel=0.1)


def test_scaling_of_a_saddle_keeps_within_bounds(grid):
    saddle = evaluated(grid, lambda x: (x[0] - 0.8) ** 2 - 0.05 * x[1] ** 2)
    found = newton_scaling(BOWL, saddle)
    assert found.max() == 1.0 and found.min() >= 0.05


def test_kriging_needs_two_points():
    failed = Evaluation(index=0, x=LOWEST, status="failed")
    with pytest.raises(ComputationError, match="1 of 2"):
        newton_scaling(BOWL, [failed, *evaluated([LOWEST])])


def test_minimum_of_tuner_and_kriging_agree_where_they_are_the_same(grid):
    *known, start, best = evaluated([*grid, np.array([2.0, -1.0]), LOWEST])
    found = agreement(BOWL, [*known, best], best, start, bowl)
    assert found.kriging == pytest.approx(LOWEST, abs=0.02)
    assert found.gap == pytest.approx(0.0, abs=1e-3)
    assert found.distance < 0.05 and found.agrees


def test_a_tuner_that_stopped_early_does_not_agree(grid):
    *known, start, early = evaluated([*grid, np.array([2.0, -1.0]), np.array([1.9, -0.9])])
    found = agreement(BOWL, [*known, early], early, start, bowl)
    assert found.gap == pytest.approx(early.cost - bowl(LOWEST), rel=0.02)
    assert found.tolerance == pytest.approx(0.05 * (start.cost - early.cost), rel=0.02)
    assert not found.agrees


def test_a_minimum_that_cannot_be_simulated_is_no_better(grid):
    *known, start, early = evaluated([*grid, np.array([2.0, -1.0]), np.array([1.9, -0.9])])
    found = agreement(BOWL, [*known, early], early, start, lambda _: float("nan"))
    assert found.gap == -np.inf and found.agrees


def test_every_search_is_in_the_table(comparison, problem):
    assert len(comparison.searches) == 2 + len(QUADRANTS) * 2 * 2
    assert comparison.methods == ("grid 2", "grid 3", "zoo J = 3, 1 stages", "zoo J = 4, 1 stages")
    rows = comparison.summaries()
    assert [row.searches for row in rows] == [1, 1, 8, 8]
    assert [row.simulations for row in rows[:2]] == [4, 9]
    costs = [s.cost for s in comparison.searches if s.method == rows[2].method]
    assert rows[2].cost == pytest.approx(np.mean(costs), rel=1e-12)
    assert rows[2].deviation == pytest.approx(np.std(costs, ddof=1), rel=1e-12)
    assert comparison.table().count("\n") == 4


def test_starts_lie_in_their_quadrants(comparison, problem):
    middle = 0.5 * (problem.space.lower + problem.space.upper)
    for search in comparison.searches[2:]:
        right, upper = search.start > middle
        assert search.quadrant == f"{'upper' if upper else 'lower'} {'right' if right else 'left'}"
        if search.quadrant == "lower right":
            assert search.start.tolist() == problem.start.tolist()
            assert search.cost <= 1.0


def test_costs_are_over_that_of_the_suggested_point(comparison, problem):
    assert comparison.costs.shape == (3, 3)
    for i, zeta in enumerate(comparison.axes[1]):
        for j, omega in enumerate(comparison.axes[0]):
            cost = problem([omega, zeta]).cost / problem.reference.cost
            assert comparison.costs[i, j] == pytest.approx(cost, nan_ok=True, rel=1e-12)
    finest = next(s for s in comparison.searches if s.method == "grid 3")
    assert finest.cost == pytest.approx(np.nanmin(comparison.costs), rel=1e-12)


def test_no_point_is_simulated_twice(small, monkeypatch):
    seen = []
    inner = SpeedRegulator._runs

    def noted(self, x):
        seen.append(tuple(x))
        return inner(self, x)

    monkeypatch.setattr(SpeedRegulator, "_runs", noted)
    calls = []
    found = compare_with_grids(
        SpeedRegulator(small), grids=(2,), searches=((3, 1), (3, 2)), repeats=1,
        progress=lambda *call: calls.append(call),
    )  # fmt: skip
    assert len(seen) == len(set(seen)) == found.simulations
    assert sum(s.simulations for s in found.searches) > found.simulations
    assert calls[-1][:2] == (9, 9)


def test_bad_comparisons(problem, gain):
    with pytest.raises(InputError, match="two"):
        compare_with_grids(gain)
    with pytest.raises(InputError, match="grids"):
        compare_with_grids(problem, grids=())
    with pytest.raises(InputError, match="repeats"):
        compare_with_grids(problem, repeats=0)


def test_pictures_show_all_searches(comparison):
    ax = plot_costs_by_simulations(comparison)
    assert sum(line.get_xdata().size for line in ax.lines) == len(comparison.searches)
    ax = plot_found_minima(comparison, "upper left")
    markers = [line for line in ax.lines if str(line.get_label()).startswith("zoo")]
    assert sum(line.get_xdata().size for line in markers) == 4
    figure = comparison_figure(comparison)
    assert [a.get_title() for a in figure.axes[:5]] == [*(f"start {q}" for q in QUADRANTS), "grids"]
    mpl.pyplot.close("all")


def test_first_step_follows_the_guideline(gain):
    found = tune_by_guidelines(gain, stages=1)
    record = found.tuner.records[0]
    first = next(e for e in found.evaluations if e.origin == "step 1.1")
    # of length one in unit coordinates, so as far as the bounds less the radius allow
    assert record.gradient[0] < 0.0
    assert gain.space.to_unit(first.x) == pytest.approx([1.0 - found.tuner.radius[0]])
    assert found.scaling.tolist() == [1.0]
    assert found.cost <= record.cost
    assert found.simulations == 3 * (len(found.evaluations) + 1)


def test_guidelines_scale_two_parameters_by_a_grid_first(problem):
    found = tune_by_guidelines(problem, preliminary=3, stages=2)
    origins = [e.origin for e in found.evaluations]
    assert len([o for o in origins if o.startswith("grid")]) == 9
    assert found.scaling.max() == 1.0
    assert isinstance(found.tuner, ZerothOrder)
    assert found.tuner.scaling.tolist() == found.scaling.tolist()
    assert found.cost <= problem.reference.cost
    assert found.agreement.tuner.tolist() == found.x.tolist()


def test_sequence_hands_each_controller_on(small):
    table = MinimumPitchTable(wind_speed=[5.0, 12.0, 25.0], pitch=[0.0, 0.01, 0.0])
    given, names = [], []

    def minimum_pitch(controller):
        given.append(controller)
        return table

    found = tune_in_sequence(
        small, minimum_pitch=minimum_pitch, torque={"wind_speeds": (8.0,)},
        settings={"stages": 1, "preliminary": 2}, progress=names.append,
    )  # fmt: skip
    assert names == [
        "torque gain", "speed regulator", "minimum pitch", "torque gain again",
        "speed regulator again",
    ]  # fmt: skip
    torque, regulator, torque_again, regulator_again = found.steps
    assert given[0] is regulator.controller and given[0].estimator is not None
    assert regulator.controller.torque.factor == torque.tuning.x[0]
    assert torque_again.tuning.problem.start.tolist() == torque.tuning.x.tolist()
    assert torque_again.tuning.problem.base.minimum_pitch is table
    assert torque_again.controller.pitch == regulator.controller.pitch
    assert found.controller is regulator_again.controller
    assert found.controller.torque.factor == torque_again.tuning.x[0]
    assert found.changes()["torque gain"] == pytest.approx(
        (torque_again.tuning.x - torque.tuning.x) / 1.4
    )
    assert found.simulations == sum(s.tuning.simulations for s in found.steps)


def test_sequence_without_a_table_ends_after_two_steps(small):
    found = tune_in_sequence(
        small,
        pitch_table=False,
        torque={"wind_speeds": (8.0,)},
        settings={"stages": 1, "preliminary": 2},
    )
    assert [s.name for s in found.steps] == ["torque gain", "speed regulator"]
    assert found.changes() == {} and found.minimum_pitch is None
