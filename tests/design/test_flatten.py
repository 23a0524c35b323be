"""Flattened profiles: exactness, what is refused, and what the refinement is worth."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from design_factories import SmoothModel, random_profile, rotor_curves, wide_limits
from hypothesis import given
from hypothesis import strategies as st

from pitchopt.design import DesignProblem, DesignTask, LoadWeights, Objective, constant
from pitchopt.design.flatten import KEPT, FlatProfiles, families, flatten, loads_of
from pitchopt.design.search import graded, rank

TASK = DesignTask(model=SmoothModel(), positions=8, limits=wide_limits(1.0))
PROBLEM = TASK.problem()
PITCH = float(constant(TASK).profile[0])
WEIGHTS = LoadWeights.unit()


def numbers(loss: float, tilt: float = 0.0, yaw: float = 0.0) -> np.ndarray:
    return np.array([[loss, tilt, yaw]])


class TestFlatten:
    @pytest.mark.parametrize("backwards", [False, True])
    @pytest.mark.parametrize("which", range(4))
    def test_kept_loads_have_the_wanted_values(self, which: int, backwards: bool) -> None:
        family = families(PROBLEM, PITCH)[which]
        grid = np.array([(0.02, 0.0, 0.0), (0.04, 0.01, -0.02), (0.06, -0.02, 0.01)])
        targets, first = family.targets(grid)
        profiles, met = flatten(
            PROBLEM, family.kept, targets, first, backwards=backwards, tolerance=1e-9
        )
        assert met.size
        for profile, target in zip(profiles, targets[met], strict=True):
            rotor = PROBLEM.curves.evaluate(profile).rotor[list(family.kept)]
            size = np.abs(PROBLEM.curves.torque).max()
            np.testing.assert_allclose(rotor, target[:, None] * np.ones(8), atol=1e-7 * size)
            assert np.all(profile >= PROBLEM.curves.lower)
            assert np.all(profile <= PROBLEM.curves.upper)

    @pytest.mark.parametrize("kept", KEPT)
    def test_effects_of_the_pitch_rate_are_counted(self, kept: tuple[int, int, int]) -> None:
        problem = DesignProblem(curves=rotor_curves(rates=0.05), limits=wide_limits(1.0))
        assert np.any(problem.curves.rates)
        (family,) = [
            f for f in families(problem, PITCH) if f.kept == kept and f.pitch[-1] > f.pitch[0]
        ]
        targets, first = family.targets(numbers(0.05))
        spread = []
        for turns in (2, 3, 12):
            profiles, _ = flatten(problem, kept, targets, first, turns=turns)
            loads = problem.curves.evaluate(profiles[0])
            spread.append(float(loads.rms[list(kept)].max()))
        assert spread[1] < 0.5 * spread[0]
        assert spread[2] < 1e-6 * spread[0]

    def test_what_cannot_be_met_is_dropped(self) -> None:
        family = families(PROBLEM, PITCH)[0]
        grid = np.array([(0.05, 0.0, 0.0), (0.05, 50.0, 0.0)])
        _, met = flatten(PROBLEM, family.kept, *family.targets(grid))
        np.testing.assert_array_equal(met, [0])

    def test_two_blades_in_the_least_squares_sense(self) -> None:
        """Marching lowers the variation that constant pitch leaves, and drops nothing."""
        problem = DesignProblem(curves=rotor_curves(blades=2), limits=wide_limits(1.0))
        family = families(problem, PITCH)[-1]
        targets, first = family.targets(numbers(0.05))
        (profile,), met = flatten(problem, family.kept, targets, first)
        assert met.size == 1

        def missed(beta: np.ndarray) -> float:
            rotor = problem.curves.evaluate(beta).rotor[list(family.kept)]
            unit = np.abs(problem.curves.slopes[list(family.kept)]).max(axis=(1, 2))
            return float(np.sum(((rotor - targets.T) / unit[:, None]) ** 2))

        assert missed(profile) < 0.7 * missed(np.full(problem.curves.stations, first[0]))

    def test_families_count_from_the_best_constant_pitch(self) -> None:
        found = families(PROBLEM, PITCH)
        assert {family.kept for family in found} == set(KEPT)
        assert {bool(family.pitch[-1] > PITCH) for family in found} == {True, False}
        for family in found:
            targets, first = family.targets(numbers(0.03))
            loads = PROBLEM.curves.evaluate(np.full(24, first[0]))
            np.testing.assert_allclose(targets[0], loads.mean[list(family.kept)], rtol=1e-2)


class TestFlatProfiles:
    @given(seed=st.integers(0, 10**6))
    def test_loads_of_many_are_those_of_each(self, seed: int) -> None:
        rng = np.random.default_rng(seed)
        problem = DesignProblem(
            curves=rotor_curves(blades=int(rng.integers(1, 4)), rates=float(rng.integers(2))),
            limits=wide_limits(1.0),
        )
        profiles = np.stack([random_profile(rng, problem) for _ in range(3)])
        torque, rms = loads_of(problem, profiles)
        for i, profile in enumerate(profiles):
            loads = problem.curves.evaluate(profile)
            assert torque[i] == pytest.approx(loads.mean[0], rel=1e-12)
            np.testing.assert_allclose(rms[:4, i], loads.rms, rtol=1e-9, atol=1e-6)
            assert rms[4, i] == pytest.approx(loads.blade_rms, rel=1e-9, abs=1e-6)

    @pytest.mark.parametrize(
        "limits", [{}, {"torque_min": 1.1e6}, {"torque_max": 9e5}, {"blade_cap": 5e4}]
    )
    def test_many_are_ranked_as_each_is(self, limits: dict[str, float]) -> None:
        objective = Objective.tradeoff(3.0, WEIGHTS, travel=10.0, **limits)
        flat = FlatProfiles(PROBLEM, PITCH)
        ranks = flat.pool.ranks(objective)
        for i in range(0, ranks.size, 40):
            profile = flat.pool.profiles[i]
            loads = PROBLEM.curves.evaluate(profile)
            value = PROBLEM.value_of(loads, PROBLEM.travel(profile), objective)
            assert ranks[i] == pytest.approx(rank(objective, loads, value), rel=1e-9)
        assert graded(objective, 1.0, 1e6, 1.0).shape == ()

    def test_refinement_gains_and_is_done_once(self) -> None:
        objective = Objective.tradeoff(50.0, WEIGHTS)
        flat = FlatProfiles(PROBLEM, PITCH)
        before = float(flat.pool.ranks(objective).max())
        flat.refine([objective])
        size, after = flat.pool.torque.size, float(flat.pool.ranks(objective).max())
        assert after > before
        flat.refine([objective])
        assert flat.pool.torque.size == size
        value = PROBLEM.value(flat.best(objective).profile, objective)
        assert value == pytest.approx(after, rel=1e-12)

    def test_starts_are_feasible_and_apart(self) -> None:
        tight = DesignProblem(curves=rotor_curves(), limits=wide_limits(0.3))
        flat = FlatProfiles(tight, PITCH)
        starts = flat.starts(Objective.tradeoff(20.0, WEIGHTS), 3)
        assert [start.label for start in starts] == ["flattened 1", "flattened 2", "flattened 3"]
        for i, start in enumerate(starts):
            assert max(tight.limits.violation(tight.curves, start.profile)) <= 1e-9
            for other in starts[:i]:
                assert np.abs(start.profile - other.profile).max() > np.radians(0.5)

    def test_a_loss_has_profiles_of_its_very_torque(self) -> None:
        torque = 0.955 * families(PROBLEM, PITCH)[0].means[0, 0]
        objective = Objective.least_rms(WEIGHTS, torque_min=torque)
        best = FlatProfiles(PROBLEM, PITCH).best(objective)
        assert PROBLEM.curves.evaluate(best.profile).mean[0] == pytest.approx(torque, rel=1e-6)

    def test_constant_pitch_where_nothing_else_is_better(self) -> None:
        objective = Objective.tradeoff(1.0, WEIGHTS, travel=1e9)
        best = FlatProfiles(PROBLEM, PITCH).best(objective)
        assert best.label.startswith("constant")
        assert np.ptp(best.profile) == 0

    @pytest.mark.parametrize("positions", [41, 72])
    def test_large_problems_are_searched_at_fewer_positions(self, positions: int) -> None:
        """And the profiles are flat at all positions all the same."""
        problem = replace(TASK, positions=positions).problem()
        flat = FlatProfiles(problem, PITCH)
        assert flat.pool.profiles.shape[1] == 3 * 40
        torque = 0.955 * constant(replace(TASK, positions=positions)).mean_torque
        objective = Objective.least_rms(WEIGHTS, torque_min=torque)
        best = flat.best(objective)
        assert best.label == "flattened 1"
        loads = problem.curves.evaluate(best.profile)
        assert loads.rms[:3].max() < 1e-6 * loads.rms[3]
        assert loads.mean[0] == pytest.approx(torque, rel=1e-5)
        few = float(flat.pool.ranks(objective).max())
        assert problem.value(best.profile, objective) == pytest.approx(few, rel=0.2)
        still = flat.best(Objective.tradeoff(1.0, WEIGHTS, travel=1e9))
        assert still.profile.shape == (3 * positions,) and np.ptp(still.profile) == 0

    @pytest.mark.parametrize(
        "change", [{"model": SmoothModel(blades=1)}, {"limits": wide_limits(0.0)}, {"harmonics": 0}]
    )
    def test_no_starts_where_none_can_be(self, change: dict[str, object]) -> None:
        problem = replace(TASK, **change).problem()  # type: ignore[arg-type]
        flat = FlatProfiles(problem, PITCH)
        objective = Objective.tradeoff(5.0, WEIGHTS)
        assert flat.starts(objective) == []
        assert np.ptp(flat.best(objective).profile) == 0
