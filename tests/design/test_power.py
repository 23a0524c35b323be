"""The largest mean torque against a linear program over all segments, and brute force."""

from __future__ import annotations

from itertools import product

import numpy as np
import pytest
from design_factories import drawn_case, random_curves, rotor_curves, wide_limits
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray
from scipy import optimize, sparse

from pitchopt.design import DesignProblem, Objective, PitchLimits, Status, solve_local
from pitchopt.design.power import maximise_torque
from pitchopt.design.scp import LocalSolution

FloatArray = NDArray[np.float64]
NOTHING = Objective(torque=1.0, rms=(0.0, 0.0, 0.0, 0.0, 0.0))


def linear_program(problem: DesignProblem) -> float:
    """Pitch is the lower limit plus what is used of each segment; torque the sum of slopes.

    Slopes fall along a row, so that segments fill in order.  Rate terms, rate limits, frozen
    mean and harmonics are linear in the pitch.
    """
    curves = problem.curves
    n, k = curves.beta.shape
    width = np.diff(curves.beta, axis=1)
    pitch = sparse.csr_matrix(
        (np.ones(n * (k - 1)), (np.repeat(np.arange(n), k - 1), np.arange(n * (k - 1)))),
        shape=(n, n * (k - 1)),
    )
    half = 0.5 / curves.spacing
    c0 = curves.rates[0] * half
    folded = (np.roll(c0, 1) - np.roll(c0, -1)) / curves.positions
    gain = curves.slopes[0].ravel() / curves.positions + pitch.T @ folded
    eye = sparse.identity(n, format="csr")
    change = (eye[np.roll(np.arange(n), -1)] - eye) @ pitch
    start = np.roll(curves.lower, -1) - curves.lower
    a_ub = sparse.vstack([change, -change])
    b_ub = np.concatenate([problem.step - start, problem.step + start])
    rows, rhs = [], []
    if curves.mean_pitch is not None:
        rows.append(sparse.csr_matrix(np.full((1, n), 1.0 / n)) @ pitch)
        rhs.append(np.array([curves.mean_pitch - curves.lower.mean()]))
    if problem.basis is not None:
        u = np.linalg.svd(problem.basis)[0][:, problem.basis.shape[1] :]
        rows.append(sparse.csr_matrix(u.T) @ pitch)
        rhs.append(-u.T @ curves.lower)
    out = optimize.linprog(
        -gain,
        A_ub=a_ub,
        b_ub=b_ub,
        A_eq=sparse.vstack(rows) if rows else None,
        b_eq=np.concatenate(rhs) if rhs else None,
        bounds=np.stack([np.zeros(width.size), width.ravel()], axis=1),
        method="highs",
    )
    assert out.status == 0, out.message
    first = curves.torque[:, 0].sum() / curves.positions + float(folded @ curves.lower)
    return float(first - out.fun)


def solved(problem: DesignProblem) -> LocalSolution:
    low, high = problem.constant_range
    return maximise_torque(problem, np.full(problem.curves.stations, 0.5 * (low + high)))


class TestLinearProgram:
    @given(seed=st.integers(0, 5000))
    @settings(max_examples=60)
    def test_random_concave_curves(self, seed: int) -> None:
        case = drawn_case(seed, concave=True, constrained=False)
        problem, want = case.problem, linear_program(case.problem)
        out = solved(problem)
        assert out.status is Status.EXACT, case.name
        assert out.loads.mean[0] == pytest.approx(want, rel=2e-7), case.name
        assert out.value == pytest.approx(out.loads.mean[0], rel=1e-12)
        outside, over = problem.limits.violation(problem.curves, out.profile)
        assert outside <= 1e-9
        assert over <= 1e-7

    @pytest.mark.parametrize("knots", [40, 200])
    @pytest.mark.parametrize("rate", [0.01, 1.0])
    def test_many_segments(self, knots: int, rate: float) -> None:
        """Far more segments than lines: the selection has to move."""
        problem = DesignProblem(curves=rotor_curves(knots=knots), limits=wide_limits(rate))
        out = solved(problem)
        assert out.status is Status.EXACT
        assert out.value == pytest.approx(linear_program(problem), rel=1e-8)

    @pytest.mark.parametrize("where", [0.0, 0.3, 1.0])
    def test_the_start_does_not_matter(self, where: float) -> None:
        problem = DesignProblem(curves=rotor_curves(knots=80), limits=wide_limits(0.1))
        curves = problem.curves
        out = maximise_torque(problem, curves.lower + where * (curves.upper - curves.lower))
        assert out.value == pytest.approx(linear_program(problem), rel=1e-8)

    def test_history_rises(self) -> None:
        problem = DesignProblem(curves=rotor_curves(knots=200), limits=wide_limits())
        assert np.all(np.diff(solved(problem).history) >= 0)


class TestBruteForce:
    @pytest.mark.parametrize("blades", [1, 2, 3])
    @pytest.mark.parametrize("positions", [1, 2])
    @pytest.mark.parametrize("seed", range(3))
    def test_tiny_rotors(self, blades: int, positions: int, seed: int) -> None:
        """Without a rate limit every station stands on a breakpoint; all are tried."""
        rng = np.random.default_rng(seed)
        curves = random_curves(rng, blades=blades, positions=positions, knots=4, rates=True)
        problem = DesignProblem(curves=curves, limits=wide_limits(1e3))
        rows = np.arange(curves.stations)
        best = max(
            float(curves.evaluate(curves.beta[rows, np.array(pick)]).mean[0])
            for pick in product(range(4), repeat=curves.stations)
        )
        assert solved(problem).value == pytest.approx(best, rel=1e-8)

    def test_two_stations_with_a_rate_limit(self) -> None:
        """A fine grid over both pitches, neighbours twice over."""
        curves = random_curves(np.random.default_rng(5), blades=1, positions=2, knots=5)
        problem = DesignProblem(
            curves=curves, limits=PitchLimits(rotor_speed=1.0, pitch_rate=0.05 / np.pi)
        )
        assert problem.step == pytest.approx(0.05)
        a = np.linspace(curves.lower.max(), curves.upper.min(), 2001)
        torque = [np.interp(a, curves.beta[n], curves.torque[n]) for n in range(2)]
        reach = round(0.05 / (a[1] - a[0]))
        best = (
            max(
                float(
                    np.max(
                        torque[0][max(-s, 0) : 2001 - max(s, 0)]
                        + torque[1][max(s, 0) :][: 2001 - abs(s)]
                    )
                )
                for s in range(-reach, reach + 1)
            )
            / 2
        )
        assert solved(problem).value == pytest.approx(best, abs=2e-3)
        assert solved(problem).value >= best - 1e-3


class TestOtherWays:
    @pytest.mark.parametrize("rate", [0.0, 1e-13])
    def test_constant_pitch_only(self, rate: float) -> None:
        curves = rotor_curves(knots=40)
        problem = DesignProblem(curves=curves, limits=wide_limits(rate))
        out = solved(problem)
        pitch = np.linspace(-0.1, 0.25, 3001)
        best = float(curves.evaluate_constant(pitch)[0][:, 0].mean(axis=1).max())
        assert out.status is Status.EXACT
        assert np.ptp(out.profile) == 0
        assert best * (1 - 1e-6) <= out.value
        at = int(np.argmin(np.abs(curves.beta[0] - out.profile[0])))
        assert curves.beta[0, at] == pytest.approx(out.profile[0], abs=1e-12)

    def test_a_cap_is_kept(self) -> None:
        problem = DesignProblem(curves=rotor_curves(), limits=wide_limits())
        free = solved(problem)
        cap = 0.8 * free.loads.blade_rms
        out = maximise_torque(problem, free.profile, blade_cap=cap)
        assert out.loads.blade_rms <= cap * (1 + 1e-6)
        assert out.status is Status.CONVERGED
        assert out.value < free.value

    def test_not_concave_is_not_called_exact(self) -> None:
        seen = 0
        for seed in range(30):
            case = drawn_case(seed, concave=False, smooth=False, constrained=False)
            if case.problem.curves.concave:
                continue
            seen += 1
            assert solved(case.problem).status is Status.CONVERGED
        assert seen > 10

    def test_best_value_is_not_below_a_local_solve(self) -> None:
        problem = DesignProblem(curves=rotor_curves(knots=60), limits=wide_limits(0.1))
        local = solve_local(problem, NOTHING, np.zeros(24))
        assert solved(problem).value >= local.value - 1e-9 * local.value

    @pytest.mark.parametrize("factor", [0.0, -1.0])
    def test_no_torque_and_negative_torque(self, factor: float) -> None:
        curves = rotor_curves(positions=2)
        flat = type(curves)(
            blades=3,
            azimuth=curves.azimuth,
            beta=curves.beta,
            torque=factor * np.abs(curves.torque.max()) + 0.0 * curves.torque,
            bending=curves.bending,
            thrust=curves.thrust,
        )
        out = solved(DesignProblem(curves=flat, limits=wide_limits()))
        assert out.status.ok
        assert out.value == pytest.approx(3 * factor * np.abs(curves.torque.max()))
