"""The normal form: weights, objectives, restrictions, repair; and what a task refuses."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from design_factories import (
    OMEGA,
    SmoothModel,
    drawn_case,
    random_profile,
    rotor_curves,
    slow_value,
    wide_limits,
)
from hypothesis import given, settings
from hypothesis import strategies as st

from pitchopt.design import CurvesModel, DesignProblem, DesignTask, LoadWeights, Objective
from pitchopt.errors import InputError

UNIT = (1.0, 1.0, 1.0, 1.0, 1.0)


class TestValue:
    @given(seed=st.integers(0, 5000))
    @settings(max_examples=50)
    def test_equals_the_slow_sums(self, seed: int) -> None:
        case = drawn_case(seed)
        want = slow_value(case.problem.curves, case.profile, case.objective)
        assert case.problem.value(case.profile, case.objective) == pytest.approx(
            want, rel=1e-9, abs=1e-9 * case.size
        )

    def test_weights_in_order(self) -> None:
        problem = DesignProblem(curves=rotor_curves(), limits=wide_limits())
        profile = random_profile(np.random.default_rng(1), problem)
        loads = problem.curves.evaluate(profile)
        weights = LoadWeights(torque=1.0, tilt=2.0, yaw=3.0, thrust=4.0, blade=5.0)
        want = float(np.dot([1, 2, 3, 4], loads.rms) + 5 * loads.blade_rms)
        assert weights.weighted(loads) == pytest.approx(want)
        value = problem.value(profile, Objective.tradeoff(0.5, weights))
        assert value == pytest.approx(loads.mean[0] - 0.5 * want)
        least = problem.value(profile, Objective.least_rms(weights, travel=10.0))
        assert least == pytest.approx(-want - 10.0 * problem.travel(profile))

    def test_named_sets(self) -> None:
        assert LoadWeights.unit().array.tolist() == [1, 1, 1, 1, 0]
        tower = LoadWeights.tower_base(90.0)
        assert tower.array.tolist() == [1, 1, 1, 90, 0]
        assert (LoadWeights.unit().name, tower.name) == ("unit", "tower-base")

    def test_excess(self) -> None:
        problem = DesignProblem(curves=rotor_curves(), limits=wide_limits())
        loads = problem.curves.evaluate(np.zeros(24))
        torque, blade = float(loads.mean[0]), loads.blade_rms
        over = Objective(torque=1.0, rms=UNIT, torque_max=torque - 5, blade_cap=blade / 2)
        assert problem.excess(loads, over) == (pytest.approx(5), pytest.approx(blade / 2))
        under = Objective(torque=1.0, rms=UNIT, torque_min=torque + 7)
        assert problem.excess(loads, under) == (pytest.approx(7), 0.0)
        kept = Objective(torque=1.0, rms=UNIT, torque_min=torque - 1, torque_max=torque + 1)
        assert problem.excess(loads, kept) == (0.0, 0.0)


class TestRestrictions:
    @given(seed=st.integers(0, 2000), order=st.integers(0, 4))
    @settings(max_examples=40)
    def test_repair_with_mean_and_harmonics(self, seed: int, order: int) -> None:
        rng = np.random.default_rng(seed)
        mean = 0.05 if rng.random() < 0.5 else None
        curves = rotor_curves(positions=4, mean_pitch=mean)
        problem = DesignProblem(curves=curves, limits=wide_limits(0.3), harmonics=order)
        beta = problem.repaired(rng.normal(0.05, 0.1, 12))
        out, over = problem.limits.violation(problem.curves, beta)
        assert out <= 1e-12
        assert over <= 1e-9
        if mean is not None:
            assert beta.mean() == pytest.approx(mean, abs=1e-13)
        basis = problem.basis
        assert basis is not None
        rest = beta - basis @ np.linalg.lstsq(basis, beta, rcond=None)[0]
        assert np.abs(rest).max() < 1e-13
        np.testing.assert_allclose(problem.repaired(beta), beta, rtol=0, atol=1e-12)

    def test_basis_stops_below_the_grid_frequency(self) -> None:
        curves = rotor_curves(positions=2)
        basis = DesignProblem(curves=curves, limits=wide_limits(), harmonics=9).basis
        assert basis is not None
        assert basis.shape == (6, 5)
        assert np.linalg.matrix_rank(basis) == 5

    @pytest.mark.parametrize(
        ("rate", "order", "expected"),
        [(0.0, None, True), (0.1, 0, True), (0.1, 1, False), (0.1, None, False)],
    )
    def test_constant_only(self, rate: float, order: int | None, expected: bool) -> None:
        problem = DesignProblem(curves=rotor_curves(), limits=wide_limits(rate), harmonics=order)
        assert problem.constant_only is expected

    def test_constant_range(self) -> None:
        problem = DesignProblem(curves=rotor_curves(), limits=wide_limits())
        assert problem.constant_range == pytest.approx((-0.1, 0.25), abs=1e-14)
        frozen = DesignProblem(curves=rotor_curves(mean_pitch=0.03), limits=wide_limits())
        assert frozen.constant_range == (0.03, 0.03)

    def test_other_curves(self) -> None:
        problem = DesignProblem(curves=rotor_curves(), limits=wide_limits(), harmonics=2)
        other = problem.with_curves(rotor_curves(positions=4))
        assert other.harmonics == 2
        assert other.curves.stations == 12


def _task(**change: Any) -> DesignTask:
    good: dict[str, Any] = {"model": SmoothModel(), "positions": 2, "limits": wide_limits()}
    return DesignTask(**(good | change))


def _problem(**change: Any) -> DesignProblem:
    good: dict[str, Any] = {"curves": rotor_curves(positions=2), "limits": wide_limits()}
    return DesignProblem(**(good | change))


def _objective(**change: Any) -> Objective:
    return Objective(**({"torque": 1.0, "rms": UNIT} | change))


class TestRefusals:
    @pytest.mark.parametrize(
        ("make", "change", "message"),
        [
            (LoadWeights, {"torque": -1.0}, "weights.torque: got -1"),
            (LoadWeights, {"thrust": np.nan}, "weights.thrust: got nan"),
            (LoadWeights, {"blade": np.inf}, "weights.blade: got inf"),
            (_objective, {"torque": -1.0}, "torque gain: got -1"),
            (_objective, {"torque": np.nan}, "torque gain: got nan"),
            (_objective, {"rms": (1.0, 1.0, 1.0, 1.0, -1.0)}, "rms weights"),
            (_objective, {"rms": (1.0, np.nan, 1.0, 1.0, 1.0)}, "rms weights"),
            (_objective, {"travel": -1.0}, "travel penalty: got -1"),
            (_objective, {"travel": np.inf}, "travel penalty: got inf"),
            (_objective, {"torque_min": np.nan}, "mean torque: got NaN"),
            (_objective, {"torque_min": 2.0, "torque_max": 1.0}, "mean torque: lower limit 2"),
            (_objective, {"blade_cap": 0.0}, "blade cap: got 0"),
            (_objective, {"blade_cap": np.nan}, "blade cap: got nan"),
            (_problem, {"harmonics": -1}, "harmonics: got -1"),
            (_problem, {"harmonics": 1.5}, "harmonics: got 1.5"),
            (_problem, {"harmonics": True}, "harmonics: got True"),
            (_problem, {"curves": rotor_curves(mean_pitch=0.3)}, "mean_pitch: frozen at 17.189"),
            (_task, {"positions": 0}, "positions: got 0"),
            (_task, {"positions": 1.5}, "positions: got 1.5"),
            (_task, {"positions": True}, "positions: got True"),
            (_task, {"positions": np.nan}, "positions: got nan"),
            (_task, {"between_positions": 0}, "between_positions: got 0"),
            (_task, {"blade_cap": 0.0}, "blade_cap: got 0"),
            (_task, {"blade_cap": np.inf}, "blade_cap: got inf"),
            (_task, {"travel": -1.0}, "travel: got -1"),
            (_task, {"travel": np.nan}, "travel: got nan"),
        ],
    )
    def test_one_clear_error(
        self, make: Callable[..., Any], change: dict[str, Any], message: str
    ) -> None:
        with pytest.raises(InputError, match=message):
            make(**change)

    def test_regression_four_weights_are_refused(self) -> None:
        with pytest.raises(InputError, match="rms weights"):
            _objective(rms=(1.0, 1.0, 1.0, 1.0))

    @pytest.mark.parametrize(
        ("make", "change"),
        [
            (LoadWeights, {"torque": "a"}),
            (LoadWeights, {"tilt": None}),
            (_problem, {"harmonics": "a"}),
            (_problem, {"harmonics": np.nan}),
            (_task, {"positions": "a"}),
            (_task, {"blade_cap": "a"}),
            (_task, {"travel": "a"}),
        ],
    )
    def test_regression_other_types_raise_the_own_error(
        self, make: Callable[..., Any], change: dict[str, Any]
    ) -> None:
        with pytest.raises(InputError, match=next(iter(change))):
            make(**change)

    @pytest.mark.parametrize("mu", [-1.0, np.nan, np.inf])
    def test_prices(self, mu: float) -> None:
        with pytest.raises(InputError, match="mu: got"):
            Objective.tradeoff(mu, LoadWeights.unit())

    @pytest.mark.parametrize("height", [0.0, -1.0, np.nan])
    def test_hub_heights(self, height: float) -> None:
        with pytest.raises(InputError, match="hub_height: got"):
            LoadWeights.tower_base(height)


class TestTask:
    def test_table_of_curves(self) -> None:
        table = rotor_curves(positions=4)
        model = CurvesModel(table=table)
        assert model.curves(4) is table
        with pytest.raises(InputError, match="positions: got 5, the table of curves has 4"):
            model.curves(5)
        task = _task(model=model, positions=4)
        assert not task.frozen
        assert task.between(np.zeros(12), None) is None
        assert task.problem() is task.problem()

    def test_between_of_a_constant_is_the_model_itself(self) -> None:
        task = _task(positions=4, between_positions=40)
        fine = task.between(np.full(12, 0.03), None)
        assert fine is not None
        assert fine.rotor.shape == (4, 40)
        dense = _task(model=SmoothModel(knots=1401), positions=40).problem().curves
        want = dense.evaluate(np.full(120, 0.03))
        np.testing.assert_allclose(fine.rotor, want.rotor, rtol=2e-6, atol=1.0)

    def test_between_of_a_wave(self) -> None:
        """A profile is interpolated linearly between the stations, across the wrap too."""
        task = _task(positions=4, between_positions=8)
        wave = 0.05 * np.cos(2 * np.pi * np.arange(12) / 12)
        fine = task.between(wave, None)
        assert fine is not None
        beta = np.empty(24)
        beta[::2], beta[1::2] = wave, 0.5 * (wave + np.roll(wave, -1))
        psi = 2 * np.pi * np.arange(24) / 24
        bending = SmoothModel().blade_loads(psi, beta).bending
        np.testing.assert_allclose(fine.bending, bending, rtol=1e-12)

    def test_a_frozen_wake_needs_its_mean(self) -> None:
        task = _task(model=SmoothModel(induction="frozen"))
        with pytest.raises(InputError, match="mean_pitch: needed for a frozen wake"):
            task.problem()

    def test_speed_of_the_rotor(self) -> None:
        assert _task().problem().step == pytest.approx(np.radians(10.0) * (2 * np.pi / 6) / OMEGA)
