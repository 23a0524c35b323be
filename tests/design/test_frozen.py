"""The search over the mean pitch, on a made-up wake with a known optimum.

Around a mean b the model's torque of one blade is

    T0(b) + (g(b) + e cos psi) (beta - b) - c (beta - b)^2,    T0(b) = A - q (b - b*)^2.

With mean(beta) = b the best profile is b + e cos psi / (2 c) and its mean torque per blade
T0(b) + e^2 / (4 c), so the best mean is b*.  A wake frozen anew at each optimum of the frozen
curves moves the mean by g(b) / (2 c) and ends where g vanishes, somewhere else.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import pytest
from design_factories import Blade, wide_limits
from numpy.typing import ArrayLike, NDArray

from pitchopt.aero.curves import BladeCurves
from pitchopt.design import (
    DesignTask,
    LoadWeights,
    Objective,
    PitchLimits,
    Status,
    constant,
    design,
    power_max,
    tradeoff,
)
from pitchopt.design.power import maximise_torque
from pitchopt.design.search import climb
from pitchopt.errors import InputError

FloatArray = NDArray[np.float64]

TOP, CURVE, BEST = 1e5, 2e7, 0.06
BEND, WAVE = 1e7, 4e5
WRONG = -0.02


@dataclass(frozen=True)
class FrozenModel:
    """The wake above; pitch from -0.15 to 0.25 rad."""

    knots: int = 801
    induction: str = "frozen"
    pitch_range: tuple[float, float] = (-0.15, 0.25)

    def blade_loads(
        self,
        azimuth: ArrayLike,
        pitch: ArrayLike,
        pitch_rate: float = 0.0,
        mean_pitch: float | None = None,
    ) -> Blade:
        del pitch_rate
        assert mean_pitch is not None
        psi, beta = np.broadcast_arrays(
            np.asarray(azimuth, dtype=float), np.asarray(pitch, dtype=float)
        )
        away = beta - mean_pitch
        gain = -4e6 * (mean_pitch - WRONG)
        torque = (
            TOP
            - CURVE * (mean_pitch - BEST) ** 2
            + (gain + WAVE * np.cos(psi)) * away
            - BEND * away**2
        )
        bending = 3e5 * (1 + 0.1 * np.cos(psi)) - 2e6 * away
        return Blade(
            torque=torque,
            bending=bending,
            thrust=2e4 - 1e5 * away,
            radial=np.zeros(beta.shape),
        )

    def curves(self, positions: int, mean_pitch: float | None = None) -> BladeCurves:
        assert mean_pitch is not None
        n = 3 * positions
        psi = 2 * np.pi * np.arange(n) / n
        beta = np.tile(np.linspace(*self.pitch_range, self.knots), (n, 1))
        loads = self.blade_loads(psi[:, None], beta, mean_pitch=mean_pitch)
        return BladeCurves(
            blades=3,
            azimuth=psi,
            beta=beta,
            torque=loads.torque,
            bending=loads.bending,
            thrust=loads.thrust,
            mean_pitch=mean_pitch,
        )


TASK = DesignTask(model=FrozenModel(), positions=4, limits=wide_limits(1.0), between_positions=12)
OPTIMUM = 3 * (TOP + WAVE**2 / (4 * BEND) / 2)  # mean of cos^2 is a half


class TestSearch:
    def test_constant_pitch(self) -> None:
        point = constant(TASK)
        assert point.mean_pitch == pytest.approx(BEST, abs=1e-4)
        assert point.mean_torque == pytest.approx(3 * TOP, rel=1e-6)

    def test_power_maximum_is_the_known_one(self) -> None:
        point = power_max(TASK)
        assert point.status is Status.EXACT
        assert point.mean_pitch == pytest.approx(BEST, abs=np.radians(0.05))
        assert point.mean_torque == pytest.approx(OPTIMUM, rel=1e-5)
        psi = 2 * np.pi * np.arange(12) / 12
        want = BEST + WAVE * np.cos(psi) / (2 * BEND)
        np.testing.assert_allclose(point.profile, want, atol=2e-3)
        assert point.profile.mean() == pytest.approx(point.mean_pitch, abs=1e-9)

    def test_freezing_anew_goes_astray(self) -> None:
        """The known error of the naive fixed point, on the same curves with the mean free."""
        mean = BEST
        for _ in range(60):
            problem = TASK.problem(mean)
            free = replace(problem.curves, mean_pitch=None)
            out = maximise_torque(problem.with_curves(free), np.full(12, mean))
            mean = float(out.profile.mean())
        assert mean == pytest.approx(WRONG, abs=2e-3)
        ends = maximise_torque(TASK.problem(mean), np.full(12, mean)).loads.mean[0]
        assert ends < 0.75 * OPTIMUM
        assert ends < power_max(TASK).mean_torque

    def test_price_of_nothing_is_the_power_maximum(self) -> None:
        point = design(TASK, mu=0.0, starts=2)
        assert point.mean_torque == pytest.approx(OPTIMUM, rel=1e-4)
        assert point.mean_pitch == pytest.approx(BEST, abs=np.radians(0.1))
        assert point.upper_bound is not None
        assert point.upper_bound >= point.objective - 1e-9 * OPTIMUM

    def test_loss_is_met(self) -> None:
        point = design(TASK, max_power_loss=0.05, starts=2)
        assert point.status is Status.CONVERGED
        assert point.mean_torque >= 0.95 * power_max(TASK).mean_torque * (1 - 2e-6)

    def test_no_mean_on_a_grid_is_better(self) -> None:
        """The outer optimum against inner solves over a grid of means."""
        task = replace(TASK, weights=LoadWeights(torque=1, tilt=0.02, yaw=0.02, thrust=1))
        point = design(task, mu=1.0, starts=2, certify=False)
        for mean in np.linspace(0.02, 0.1, 9):
            problem = task.problem(float(mean))
            shifted = problem.repaired(point.profile - point.profile.mean() + mean)
            value = problem.value_of(
                problem.curves.evaluate(shifted), 0.0, Objective.tradeoff(1.0, task.weights)
            )
            assert value <= point.objective + 1e-6 * OPTIMUM

    def test_curve(self) -> None:
        out = tradeoff(TASK, mu=[0.0, 0.5], losses=[0.03], starts=2, anchors=1)
        assert all(p.status is Status.CONVERGED for p in out.points)
        assert all(p.mean_pitch is not None for p in out.points)
        means = [p.profile.mean() - (p.mean_pitch or 0) for p in out.points]
        np.testing.assert_allclose(means, 0.0, atol=1e-9)
        again = tradeoff(TASK, mu=[0.0, 0.5], losses=[0.03], starts=2, anchors=1)
        np.testing.assert_array_equal(out.points[0].profile, again.points[0].profile)

    def test_regression_constant_pitch_only(self) -> None:
        task = replace(TASK, limits=wide_limits(0.0))
        point = design(task, mu=1.0)
        assert point.mean_pitch == pytest.approx(BEST, abs=0.02)
        assert np.ptp(point.profile) < 1e-12


class TestMeanRange:
    def test_narrowed_by_the_limits(self) -> None:
        limits = PitchLimits(rotor_speed=2.0, pitch_rate=1.0, lower=-0.05, upper=0.5)
        low, high = replace(TASK, limits=limits).mean_range
        assert low == pytest.approx(-0.05, abs=1e-3)
        assert high == pytest.approx(0.25, abs=1e-3)

    def test_nothing_left(self) -> None:
        limits = PitchLimits(rotor_speed=2.0, pitch_rate=1.0, lower=0.4, upper=0.5)
        with pytest.raises(InputError, match="pitch limits"):
            _ = replace(TASK, limits=limits).mean_range


class TestClimb:
    @pytest.mark.parametrize("top", [-0.3, 0.0, 0.11, 0.4])
    @pytest.mark.parametrize("centre", [-0.2, 0.1, 0.39])
    def test_smooth(self, top: float, centre: float) -> None:
        found = climb(lambda x: -((x - top) ** 2), centre, -0.4, 0.4)
        assert found == pytest.approx(top, abs=np.radians(0.03))

    def test_kinked(self) -> None:
        found = climb(lambda x: -abs(x - 0.123), 0.0, -0.4, 0.4)
        assert found == pytest.approx(0.123, abs=np.radians(0.03))

    def test_returns_the_best_seen_on_rough_ground(self) -> None:
        seen: dict[float, float] = {}

        def rough(x: float) -> float:
            seen[x] = -((x - 0.05) ** 2) + 1e-4 * np.sin(900 * x)
            return seen[x]

        found = climb(rough, 0.2, -0.4, 0.4)
        assert seen[found] == max(seen.values())
        assert len(seen) < 60

    def test_stays_inside(self) -> None:
        asked: list[float] = []
        climb(lambda x: asked.append(x) or x, 0.0, -0.01, 0.02)
        assert -0.01 <= min(asked) <= max(asked) == 0.02

    def test_a_range_of_nothing(self) -> None:
        assert climb(lambda _: pytest.fail("asked for a value"), 0.1, 0.1, 0.1) == 0.1
