"""Designs for several winds: shared profile, largest regret, schedule."""

from __future__ import annotations

from itertools import pairwise
from typing import Any

import numpy as np
import pytest
from design_factories import SmoothModel, analytic, random_curves, rotor_curves, wide_limits
from numpy.typing import NDArray

from pitchopt.aero.curves import BladeCurves
from pitchopt.design import (
    CurvesModel,
    DesignTask,
    LoadWeights,
    PitchLimits,
    Status,
    design,
    relax,
    robust,
    schedule,
)
from pitchopt.design.scp import solve_local
from pitchopt.errors import InputError

FloatArray = NDArray[np.float64]

MU = 8.0
SIZE = 1e5


def windy(speed: float, *, positions: int = 6, knots: int = 17) -> BladeCurves:
    """The made-up blade with all loads of the wind scaled: its optimum moves with the speed."""
    n = 3 * positions
    psi = 2 * np.pi * np.arange(n) / n
    beta = np.tile(np.linspace(-0.1, 0.25, knots), (n, 1)) + 0.02 * (speed - 1.0)
    loads = analytic(psi[:, None], beta - 0.1 * (speed - 1.0), SIZE)
    loads["torque"] = loads["torque"] * speed**2
    loads["bending"] = loads["bending"] * speed
    return BladeCurves(blades=3, azimuth=psi, beta=beta, **loads)


def task(speed: float = 1.0, **change: Any) -> DesignTask:
    good: dict[str, Any] = {
        "model": CurvesModel(table=windy(speed)),
        "positions": 6,
        "limits": wide_limits(0.5),
    }
    return DesignTask(**(good | change))


def speeds(*values: float, **change: Any) -> list[DesignTask]:
    return [task(value, **change) for value in values]


class TestOneProfile:
    def test_equal_winds_give_the_design_of_one(self) -> None:
        alone = design(task(), mu=MU)
        for goal in ("mean", "regret"):
            found = robust([task()] * 3, mu=MU, goal=goal)
            assert found.status is Status.CONVERGED
            assert found.winds[0].objective == pytest.approx(alone.objective, rel=1e-7)
            np.testing.assert_allclose(found.profile, alone.profile, atol=1e-4)
            assert found.largest_regret == pytest.approx(0.0, abs=1e-6 * alone.objective)

    def test_a_wind_without_weight_only_brings_its_limits(self) -> None:
        one, two = speeds(1.0, 1.2)
        found = robust([one, two], mu=MU, weights=(1.0, 0.0))
        narrow = PitchLimits(
            rotor_speed=2.0,
            pitch_rate=0.5,
            lower=max(windy(1.0).lower.max(), windy(1.2).lower.max()),
            upper=min(windy(1.0).upper.min(), windy(1.2).upper.min()),
        )
        alone = design(task(1.0, limits=narrow), mu=MU)
        assert found.winds[0].objective == pytest.approx(alone.objective, rel=1e-7)
        assert found.objective == pytest.approx(alone.objective, rel=1e-7)

    def test_weights_move_the_profile(self) -> None:
        tasks = speeds(1.0, 1.2)
        first = [
            robust(tasks, mu=MU, weights=(p, 1.0 - p)).winds[0].regret
            for p in (0.05, 0.3, 0.7, 0.95)
        ]
        assert all(b < a for a, b in pairwise(first))

    def test_scale_of_weights_does_not_matter(self) -> None:
        tasks = speeds(1.0, 1.2)
        one = robust(tasks, mu=MU, weights=(1.0, 3.0))
        two = robust(tasks, mu=MU, weights=(2e6, 6e6))
        np.testing.assert_array_equal(one.profile, two.profile)

    def test_regret_beats_the_weighted_design_and_every_optimum(self) -> None:
        tasks = speeds(0.9, 1.0, 1.2)
        found = robust(tasks, mu=MU, goal="regret")
        mean = robust(tasks, mu=MU)
        assert found.status is Status.CONVERGED
        assert found.objective == pytest.approx(-found.largest_regret, rel=1e-9)
        assert found.largest_regret < mean.largest_regret
        own = np.array([wind.own_objective for wind in found.winds])
        for wind in found.winds:
            values = [
                one.problem().value(one.problem().repaired(wind.own_profile), objective)
                for one, objective in zip(tasks, objectives(tasks), strict=True)
            ]
            assert found.largest_regret <= max(own - values) + 1e-6 * abs(own[0])
        # the extremes bind and share the multipliers of the regret
        weights = np.array([wind.weight for wind in found.winds])
        assert weights.sum() == pytest.approx(1.0, abs=1e-6)
        binding = np.array([wind.regret for wind in found.winds]) > 0.999 * found.largest_regret
        assert weights[~binding].max(initial=0.0) < 1e-4
        assert binding.sum() >= 2

    def test_units(self) -> None:
        base = robust(speeds(1.0, 1.2), mu=MU)
        bigger = []
        for speed in (1.0, 1.2):
            c = windy(speed)
            more = {
                name: 1e4 * getattr(c, name) for name in ("torque", "bending", "thrust", "radial")
            }
            table = BladeCurves(blades=3, azimuth=c.azimuth, beta=c.beta, **more)
            bigger.append(task(model=CurvesModel(table=table)))
        other = robust(bigger, mu=MU)
        assert other.objective == pytest.approx(1e4 * base.objective, rel=1e-6)
        assert other.upper_bound == pytest.approx(1e4 * base.upper_bound, rel=1e-3)

    def test_the_strictest_limits_hold(self) -> None:
        slow = PitchLimits(rotor_speed=2.0, pitch_rate=0.02, lower=-0.05)
        fast = PitchLimits(rotor_speed=1.0, pitch_rate=0.5, upper=0.06)
        found = robust([task(1.0, limits=slow), task(1.2, limits=fast)], mu=MU)
        step = np.abs(np.roll(found.profile, -1) - found.profile).max()
        assert step <= slow.step(18) * (1 + 1e-9)
        assert step > 0.5 * slow.step(18)
        assert found.profile.min() >= -0.05 - 1e-12
        assert found.profile.max() <= 0.06 + 1e-12

    def test_the_cap_of_every_wind_is_kept(self) -> None:
        free = robust(speeds(1.0, 1.2), mu=MU)
        shares = [w.loads.blade_rms / w.constant.loads.blade_rms for w in free.winds]
        cap = 0.9 * max(shares)
        found = robust(speeds(1.0, 1.2, blade_cap=cap), mu=MU)
        assert found.status is Status.CONVERGED, found.message
        for wind in found.winds:
            limit = cap * wind.constant.loads.blade_rms
            assert wind.loads.blade_rms <= limit * (1 + 2e-6)
        assert found.objective < free.objective
        assert found.upper_bound >= found.objective

    def test_travel_and_harmonics(self) -> None:
        tasks = speeds(1.0, 1.2)
        free = robust(tasks, mu=MU)
        dear = robust(speeds(1.0, 1.2, travel=2e5), mu=MU)
        assert travel(dear.profile) < 0.9 * travel(free.profile)
        assert dear.upper_bound >= dear.objective
        smooth = robust(speeds(1.0, 1.2, harmonics=1), mu=MU)
        series = np.abs(np.fft.rfft(smooth.profile))
        assert series[2:].max() < 1e-9
        assert smooth.objective <= free.objective + 1e-6 * free.objective

    def test_constant_pitch_only(self) -> None:
        limits = PitchLimits(rotor_speed=2.0, pitch_rate=0.0)
        found = robust(speeds(1.0, 1.2, limits=limits), mu=MU)
        assert np.ptp(found.profile) == 0.0
        grid = np.linspace(found.profile[0] - 0.02, found.profile[0] + 0.02, 41)
        tasks = speeds(1.0, 1.2, limits=limits)
        values = [
            np.mean(
                [
                    one.problem().value(np.full(18, pitch), objective)
                    for one, objective in zip(tasks, objectives(tasks), strict=True)
                ]
            )
            for pitch in grid
        ]
        assert found.objective >= max(values) - 1e-6 * abs(max(values))

    @pytest.mark.parametrize("goal", ["mean", "regret"])
    def test_bound_of_constant_pitch_only(self, goal: str) -> None:
        limits = PitchLimits(rotor_speed=2.0, pitch_rate=0.0)
        found = robust(speeds(1.0, 1.2, limits=limits), mu=MU, goal=goal)
        assert found.status is Status.CONVERGED
        assert found.gap is not None and found.gap >= 0
        if goal == "mean":
            tasks = speeds(1.0, 1.2, limits=limits)
            own = [
                relax(one.problem(), objective)
                for one, objective in zip(tasks, objectives(tasks), strict=True)
            ]
            each = np.mean([one.upper_bound for one in own if one is not None])
            assert found.upper_bound <= each * (1 + 1e-3)
        with pytest.raises(InputError, match="pitch_rate: a limit of zero"):
            schedule(speeds(1.0, 1.2, limits=limits), mu=MU, change=0.1)

    def test_model_with_loads_between_stations(self) -> None:
        one = DesignTask(model=SmoothModel(), positions=6, limits=wide_limits(0.5))
        found = robust([one, one], mu=MU, certify=False)
        assert found.upper_bound is None and found.gap is None and found.certificate is None
        assert found.objective == pytest.approx(design(one, mu=MU).objective, rel=1e-7)


class TestSchedule:
    def test_no_limit_gives_each_its_own_optimum(self) -> None:
        tasks = speeds(0.9, 1.0, 1.2)
        found = schedule(tasks, mu=MU, change=np.inf)
        for one, wind, profile in zip(tasks, found.winds, found.profiles, strict=True):
            alone = design(one, mu=MU, starts=3)  # as many as the schedule takes
            assert wind.objective == pytest.approx(alone.objective, rel=1e-6)
            assert wind.regret == pytest.approx(0.0, abs=1e-6 * alone.objective)
            (goal,) = objectives([one])
            beyond = solve_local(one.problem(), goal, profile)
            assert beyond.value == pytest.approx(wind.objective, rel=1e-6)

    def test_zero_gives_the_weighted_design(self) -> None:
        tasks = speeds(0.9, 1.0, 1.2)
        found = schedule(tasks, mu=MU, change=0.0, weights=(1, 2, 1))
        shared = robust(tasks, mu=MU, weights=(1, 2, 1))
        assert found.profiles.shape == (3, 18)
        assert found.largest_change == 0.0
        np.testing.assert_array_equal(found.profiles[1], shared.profile)
        assert found.objective == shared.objective

    @pytest.mark.slow
    def test_between_one_profile_and_each_its_own(self) -> None:
        tasks = speeds(0.9, 1.0, 1.2)
        shared = robust(tasks, mu=MU).objective
        values = []
        for change in (1e-3, 5e-3, 0.05):
            found = schedule(tasks, mu=MU, change=change)
            assert found.status is Status.CONVERGED, found.message
            assert found.largest_change <= change + 1e-12
            assert found.upper_bound >= found.objective
            own = np.mean([wind.own_objective for wind in found.winds])
            assert shared < found.objective <= own * (1 + 1e-12)
            values.append(found.objective)
        assert values[0] < values[1] < values[2]

    def test_limits_of_each_profile(self) -> None:
        limits = [
            PitchLimits(rotor_speed=2.0, pitch_rate=rate, upper=upper)
            for rate, upper in ((0.03, 0.02), (0.5, 0.04), (0.1, 0.2))
        ]
        tasks = [task(v, limits=one) for v, one in zip((0.9, 1.0, 1.2), limits, strict=True)]
        found = schedule(tasks, mu=MU, change=0.01)
        assert np.abs(np.diff(found.profiles, axis=0)).max() <= 0.01 + 1e-12
        for profile, one, limit in zip(found.profiles, tasks, limits, strict=True):
            outside, over = limit.violation(one.problem().curves, profile)
            assert outside <= 1e-12
            assert over <= 1e-9

    def test_one_wind(self) -> None:
        found = schedule([task()], mu=MU, change=0.01)
        assert found.profiles.shape == (1, 18)
        assert found.objective == pytest.approx(design(task(), mu=MU).objective, rel=1e-7)

    def test_a_price_for_each_wind(self) -> None:
        tasks = speeds(1.0, 1.0)
        found = schedule(tasks, mu=(1.0, 20.0), change=np.inf)
        assert found.winds[0].rms_weighted > found.winds[1].rms_weighted
        assert found.winds[0].mean_torque > found.winds[1].mean_torque


class TestBadInput:
    @pytest.mark.parametrize(
        ("change", "words"),
        [
            ({"mu": -1.0}, "mu: got -1"),
            ({"mu": np.nan}, "mu: got 1 NaN"),
            ({"mu": (1.0, 2.0, 3.0)}, "mu: got 3 numbers, expected one, or 2"),
            ({"weights": (1.0,)}, "weights: got 1, expected 2"),
            ({"weights": (-1.0, 2.0)}, r"weights: got \[-1.0, 2.0\], expected numbers of 0"),
            ({"weights": (0.0, 0.0)}, "not all 0"),
            ({"weights": (np.inf, 1.0)}, "weights: got 1 NaN or infinite"),
            ({"goal": "worst"}, "goal: got 'worst', expected mean or regret"),
            ({"goal": "regret", "weights": (1.0, 1.0)}, "weights: got some with the goal regret"),
            ({"labels": ("a",)}, "labels: got 1, expected 2"),
            ({"starts": 0}, "starts: got 0"),
            ({"tasks": []}, "winds: got none"),
        ],
    )
    def test_robust(self, change: dict[str, Any], words: str) -> None:
        options: dict[str, Any] = {"tasks": speeds(1.0, 1.2), "mu": MU} | change
        with pytest.raises(InputError, match=words):
            robust(options.pop("tasks"), **options)

    @pytest.mark.parametrize("change", [-0.1, np.nan, -np.inf, "wide"])
    def test_change(self, change: Any) -> None:
        with pytest.raises(InputError, match="change: got"):
            schedule(speeds(1.0, 1.2), mu=MU, change=change)

    def test_winds_that_do_not_fit(self) -> None:
        other = task(model=CurvesModel(table=windy(1.0, positions=8)), positions=8)
        with pytest.raises(InputError, match="number 1 has 3 blades and 8 positions"):
            robust([task(), other], mu=MU)
        c = windy(1.0)
        loads = {name: getattr(c, name) for name in ("torque", "bending", "thrust", "radial")}
        moved = BladeCurves(blades=3, azimuth=c.azimuth + 0.1, beta=c.beta, **loads)
        with pytest.raises(InputError, match="stations of number 1 stand elsewhere"):
            robust([task(), task(model=CurvesModel(table=moved))], mu=MU)
        with pytest.raises(InputError, match="harmonics: got 2 for wind 1, expected None"):
            robust([task(), task(harmonics=2)], mu=MU)
        with pytest.raises(InputError, match="harmonics: a schedule"):
            schedule([task(harmonics=2), task(harmonics=2)], mu=MU, change=0.1)

    def test_frozen_wake(self) -> None:
        model = CurvesModel(table=rotor_curves(positions=6, mean_pitch=0.05), induction="frozen")
        with pytest.raises(InputError, match="number 1 has a frozen wake"):
            robust([task(), task(model=model)], mu=MU)

    def test_no_common_pitch(self) -> None:
        low = PitchLimits(rotor_speed=2.0, pitch_rate=0.5, upper=0.0)
        high = PitchLimits(rotor_speed=2.0, pitch_rate=0.5, lower=0.1)
        tasks = [task(1.0, limits=low), task(1.0, limits=high)]
        with pytest.raises(InputError, match="no pitch keeps those of all winds at station"):
            robust(tasks, mu=MU)
        with pytest.raises(InputError, match="pitch limits"):
            schedule(tasks, mu=MU, change=0.05)
        found = schedule(tasks, mu=MU, change=0.15)
        assert found.largest_change <= 0.15 + 1e-12
        with pytest.raises(InputError, match="profile: this schedule has 2"):
            _ = found.profile


def test_same_seed_same_result() -> None:
    rng = np.random.default_rng(3)
    tasks = [
        DesignTask(
            model=CurvesModel(table=random_table(rng)),
            positions=4,
            limits=wide_limits(0.3),
            weights=LoadWeights.unit(),
        )
        for _ in range(2)
    ]
    one, two = (robust(tasks, mu=0.5, starts=7, seed=4) for _ in range(2))
    np.testing.assert_array_equal(one.profile, two.profile)
    assert one.upper_bound == two.upper_bound


def random_table(rng: np.random.Generator) -> BladeCurves:
    table = random_curves(rng, concave=True)
    psi = 2 * np.pi * np.arange(12) / 12
    loads = {name: getattr(table, name) for name in ("torque", "bending", "thrust", "radial")}
    return BladeCurves(blades=3, azimuth=psi, beta=table.beta, **loads)


def objectives(tasks: list[DesignTask]) -> list[Any]:
    from pitchopt.design import Objective

    return [Objective.tradeoff(MU, one.weights) for one in tasks]


def travel(profile: FloatArray) -> float:
    return float(np.abs(np.diff(profile, append=profile[0])).sum())
