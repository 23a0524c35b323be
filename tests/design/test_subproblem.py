"""The convex subproblem: the direct path against the cvxpy program, and its KKT conditions.

The conditions are checked through the dual function at the multipliers, written here on its
own: it is never below the value (dual feasibility), and meets it only when stationarity and
complementarity hold.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from design_factories import drawn_case, random_profile, rotor_curves, wide_limits
from numpy.typing import NDArray

from pitchopt.design import ConvexSubproblem, DesignProblem, Objective
from pitchopt.design.direct import LinearModel, Subproblem, SubproblemSolution, torque_lines
from pitchopt.errors import ComputationError, InputError

FloatArray = NDArray[np.float64]

PENALTY = (50.0, 500.0)
BOX = 0.03


def _objective(**change: Any) -> Objective:
    return Objective(**({"torque": 1.0, "rms": (2.0, 1.0, 3.0, 9.0, 0.0)} | change))


def _case(kind: str) -> tuple[DesignProblem, Objective, FloatArray]:
    """Problem, objective and point of one of the normal forms."""
    extra = {"mean_pitch": 0.02} if "frozen" in kind else {}
    rates = 0.02 if "rates" in kind else 0.0
    curves = rotor_curves(positions=6, knots=9, rates=rates, **extra)
    problem = DesignProblem(
        curves=curves,
        limits=wide_limits(0.12 if "rate limit" in kind else 1.0),
        harmonics=2 if "harmonics" in kind else None,
    )
    point = problem.repaired(0.02 + 0.01 * np.cos(problem.curves.azimuth + 0.4))
    loads = problem.curves.evaluate(point)
    torque = float(loads.mean[0])
    change: dict[str, Any] = {}
    if "least" in kind:
        change |= {"torque": 0.0}
    if "travel" in kind:
        change |= {"travel": 0.1 * 1e5}
    if "minimum" in kind:
        change |= {"torque_min": 1.001 * torque}
    if "maximum" in kind:
        change |= {"torque_max": 0.999 * torque}
    if "both" in kind:
        change |= {"torque_min": torque, "torque_max": torque}
    if "cap" in kind:
        change |= {"blade_cap": 0.9 * loads.blade_rms}
    if "blade weight" in kind:
        change |= {"rms": (2.0, 1.0, 3.0, 9.0, 0.7)}
    if "torque only" in kind:
        change |= {"rms": (0.0, 0.0, 0.0, 0.0, 0.0)}
    return problem, _objective(**change), point


KINDS = [
    "trade-off",
    "trade-off, rate limit",
    "trade-off, rates",
    "trade-off, blade weight",
    "trade-off, travel",
    "trade-off, travel, rate limit",
    "trade-off, cap",
    "trade-off, frozen",
    "trade-off, frozen, rates, travel, cap",
    "least, minimum",
    "least, maximum",
    "least, both",
    "least, both, cap, rates",
    "least, minimum, travel, frozen",
    "trade-off, torque only",
    "trade-off, torque only, rate limit",
]


def _dual_value(
    problem: DesignProblem,
    objective: Objective,
    point: FloatArray,
    solution: SubproblemSolution,
    low: FloatArray,
    high: FloatArray,
) -> float:
    """max over the box of the Lagrangian of the subproblem around ``point``."""
    curves, mult = problem.curves, solution.multipliers
    n, m, b = curves.stations, curves.positions, curves.blades
    rows = np.arange(n)
    j = curves.segment(point)
    slope = curves.slopes[:, rows, j]
    y = np.concatenate([np.tile(mult.loads, (1, b)), mult.blade[None]])
    following, previous = np.roll(rows, -1), np.roll(rows, 1)
    half = 0.5 / curves.spacing
    # sum_i weight_i rate_i (b_{i+1} - b_{i-1}) half, gathered per b_n; torque in row 0
    weights = np.concatenate([np.full((1, n), 1.0 / m), y])
    rates = np.concatenate([curves.rates[:1], curves.rates])
    shares = weights * rates * half
    folded = shares[:, previous] - shares[:, following]
    at_point = curves.evaluate(point)
    static = curves.contributions(point)[0]
    torque0 = float(at_point.mean[0])
    up = objective.torque + mult.torque_min
    linear = up * folded[0] - folded[1:].sum(axis=0) - np.sum(y * slope, axis=0)
    linear -= mult.torque_max * (slope[0] / m + folded[0])
    linear += mult.rate - mult.rate[previous] - mult.mean / n
    total = up * torque0 - mult.torque_max * torque0
    total -= float(np.sum(mult.loads * at_point.rotor)) + float(mult.blade @ at_point.bending)
    total += float(np.sum((mult.rate - mult.rate[previous]) * point))  # changes count in full
    total += problem.step * float(np.sum(np.maximum(np.abs(mult.rate) - objective.travel, 0)))
    if curves.mean_pitch is not None:
        total += mult.mean * (curves.mean_pitch - point.mean())
    if mult.torque_min:
        total -= mult.torque_min * objective.torque_min
    if mult.torque_max:
        total += mult.torque_max * objective.torque_max
    if mult.cap:
        total += mult.cap * objective.blade_cap
    for i in range(n):
        knots = curves.beta[i][(curves.beta[i] > low[i]) & (curves.beta[i] < high[i])]
        pitch = np.concatenate([[low[i]], knots, [high[i]]])
        torque = np.interp(pitch, curves.beta[i], curves.torque[i]) - static[i]
        total += float(np.max(up / m * torque + linear[i] * (pitch - point[i])))
    return total


def _solved(kind: str, path: str) -> tuple[Any, ...]:
    problem, objective, point = _case(kind)
    low = np.maximum(point - BOX, problem.curves.lower)
    high = np.minimum(point + BOX, problem.curves.upper)
    solver: Any = Subproblem(problem)
    if path == "cvxpy":
        solver = ConvexSubproblem(problem, objective)
    out = solver.solve(point, objective, low=low, high=high, penalty=PENALTY)
    assert out.solved
    return problem, objective, point, low, high, out


class TestTwoPaths:
    @pytest.mark.parametrize("kind", [*KINDS, "trade-off, harmonics", "least, both, harmonics"])
    def test_same_value_and_profile(self, kind: str) -> None:
        problem, _, point, low, high, one = _solved(kind, "direct")
        two = _solved(kind, "cvxpy")[-1]
        scale = float(problem.curves.evaluate(point).mean[0])
        assert abs(one.value - two.value) <= 1e-7 * scale
        # profiles are compared by what they are worth to the other path
        for out in (one, two):
            assert np.all(out.profile >= low - 1e-7)
            assert np.all(out.profile <= high + 1e-7)
            step = np.abs(np.roll(out.profile, -1) - out.profile).max()
            assert step <= problem.step + 1e-7
        assert np.abs(one.profile - two.profile).max() < 2e-3

    def test_non_concave_torque(self) -> None:
        hits = 0
        for seed in range(40):
            case = drawn_case(seed, concave=False, smooth=False, constrained=False, harmonics=False)
            if case.problem.curves.concave:
                continue
            hits += 1
            low, high = case.profile - 0.1, case.profile + 0.1
            one = Subproblem(case.problem).solve(case.profile, case.objective, low=low, high=high)
            two = ConvexSubproblem(case.problem, case.objective).solve(
                case.profile, case.objective, low=low, high=high
            )
            scale = 2.0 * (1 + max(case.objective.rms))
            assert abs(one.value - two.value) <= 1e-6 * scale, case.name
            if hits == 8:
                break
        assert hits == 8

    def test_segments_fix_the_slopes(self) -> None:
        problem, objective, point = _case("trade-off")
        j = problem.curves.segment(point)
        rows = np.arange(18)
        low, high = problem.curves.beta[rows, j], problem.curves.beta[rows, j + 1]
        one = Subproblem(problem).solve(point, objective, low=low, high=high, segments=j)
        two = ConvexSubproblem(problem, objective).solve(
            point, objective, low=low, high=high, segments=j
        )
        assert one.value == pytest.approx(two.value, rel=1e-7)
        # inside the cell the model is the problem itself
        profile = np.clip(one.profile, low, high)
        assert problem.value(profile, objective) == pytest.approx(one.value, rel=1e-6)

    def test_the_fallback_scaling_agrees(self) -> None:
        problem, objective, point = _case("least, both, cap, rates")
        box = {"low": point - BOX, "high": point + BOX, "penalty": PENALTY}
        solver = Subproblem(problem)
        one = solver.solve(point, objective, **box)
        two = solver.solve(point, objective, tight=True, **box)
        assert two.value == pytest.approx(one.value, rel=1e-4)

    def test_a_program_knows_its_objective(self) -> None:
        problem, objective, point = _case("trade-off")
        program = ConvexSubproblem(problem, objective)
        with pytest.raises(InputError, match="differs from the one"):
            program.solve(point, _objective(torque=2.0), low=point - 1, high=point + 1)

    def test_dpp(self) -> None:
        problem, objective, _ = _case("trade-off, frozen, rates, travel, cap")
        assert ConvexSubproblem(problem, objective).program.is_dcp(dpp=True)

    def test_more_lines_than_room(self) -> None:
        """A program with few rows keeps an upper bound on the model."""
        problem, objective, point = _case("trade-off")
        box = {"low": point - 0.2, "high": point + 0.2}
        full = ConvexSubproblem(problem, objective).solve(point, objective, **box)
        few = ConvexSubproblem(problem, objective, lines=3).solve(point, objective, **box)
        assert few.value >= full.value - 1e-6 * abs(full.value)


class TestConditions:
    @pytest.mark.parametrize("kind", KINDS)
    @pytest.mark.parametrize("path", ["direct", "cvxpy"])
    def test_kkt(self, kind: str, path: str) -> None:
        problem, objective, point, low, high, out = _solved(kind, path)
        curves, mult = problem.curves, out.multipliers
        n, m = curves.stations, curves.positions
        scale = abs(float(curves.evaluate(point).mean[0]))
        # dual feasibility
        norms = np.linalg.norm(mult.loads, axis=1) * np.sqrt(m)
        assert np.all(norms <= objective.lambdas[:4] + 1e-5)
        np.testing.assert_allclose(mult.loads.sum(axis=1), 0.0, atol=1e-9)
        blade = float(np.linalg.norm(mult.blade)) * np.sqrt(n)
        assert blade <= objective.lambdas[4] + mult.cap + 1e-5
        assert min(mult.torque_min, mult.torque_max, mult.cap) >= -1e-9
        assert max(mult.torque_min, mult.torque_max) <= PENALTY[0] * (1 + 1e-6)
        assert mult.cap <= PENALTY[1] * (1 + 1e-6)
        # complementarity of the rate limit and the penalty on travel
        change = np.roll(out.profile, -1) - out.profile
        heavy = np.abs(mult.rate) > objective.travel + 1e-5 * scale
        assert np.all(np.abs(np.abs(change[heavy]) - problem.step) < 1e-4)
        assert np.all(np.sign(change[heavy]) == np.sign(mult.rate[heavy]))
        if objective.travel:
            moving = np.abs(change) > 1e-4
            free = moving & ~heavy
            want = objective.travel * np.sign(change[free])
            np.testing.assert_allclose(mult.rate[free], want, atol=1e-4 * scale)
        # strong duality at these multipliers: everything else at once
        slack = _dual_value(problem, objective, point, out, low, high) - out.value
        assert slack >= -1e-6 * scale
        assert slack <= 1e-5 * scale

    def test_dual_value_is_above_any_feasible_point(self) -> None:
        """The check above can fail: wrong multipliers open the gap."""
        problem, objective, point, low, high, out = _solved("trade-off", "direct")
        wrong = out.multipliers.loads.copy()
        wrong[1] = -wrong[1]
        worse = type(out.multipliers)(
            loads=wrong, blade=out.multipliers.blade, rate=out.multipliers.rate
        )
        other = type(out)(**(vars(out) | {"multipliers": worse}))
        gap = _dual_value(problem, objective, point, other, low, high) - out.value
        assert gap > 1e-4 * abs(out.value)

    @pytest.mark.parametrize("kind", ["least, minimum", "least, maximum", "trade-off, cap"])
    def test_priced_limits_are_met(self, kind: str) -> None:
        problem, objective, point, *_, out = _solved(kind, "direct")
        model = LinearModel(problem, point, None, point - BOX, point + BOX)
        gradient = model.slopes[0] / problem.curves.positions + model.torque_rate
        torque = model.torque + float(gradient @ (out.profile - point))
        if "maximum" in kind:
            assert torque <= objective.torque_max * (1 + 1e-6)
            assert out.multipliers.torque_max > 0
        if "minimum" in kind:
            assert problem.curves.evaluate(out.profile).mean[0] >= objective.torque_min * (1 - 1e-6)
            assert out.multipliers.torque_min > 0
        if "cap" in kind:
            bending = model.blade[4] + model.slopes[4] * (out.profile - point)
            assert bending.std() <= objective.blade_cap * (1 + 1e-5)
            assert out.multipliers.cap > 0


class TestTorqueLines:
    @pytest.mark.parametrize("knots", [3, 9, 160])
    def test_lines_bound_concave_torque(self, knots: int) -> None:
        problem = DesignProblem(curves=rotor_curves(positions=2, knots=knots), limits=wide_limits())
        curves = problem.curves
        rng = np.random.default_rng(knots)
        point = random_profile(rng, problem)
        low, high = point - 0.08, point + 0.08
        station, value, slope = torque_lines(curves, point, curves.segment(point), low, high)
        for _ in range(20):
            beta = np.clip(rng.uniform(low, high), curves.lower, curves.upper)
            model = np.full(6, np.inf)
            np.minimum.at(model, station, value + slope * (beta - point)[station])
            true = curves.contributions(beta)[0]
            assert np.all(model >= true - 1e-9 * np.abs(true))
            if knots <= 9:
                np.testing.assert_allclose(model, true, rtol=1e-9)

    def test_lines_are_exact_beside_the_point_without_concavity(self) -> None:
        for seed in range(20):
            case = drawn_case(seed, concave=False, smooth=False, harmonics=False)
            curves, point = case.problem.curves, case.profile
            j = curves.segment(point)
            station, value, _ = torque_lines(curves, point, j, curves.lower, curves.upper)
            model = np.full(curves.stations, np.inf)
            np.minimum.at(model, station, value)
            np.testing.assert_allclose(model, curves.contributions(point)[0], rtol=1e-9)


class TestUserConstraints:
    def test_a_constraint_is_kept(self) -> None:
        problem, objective, point = _case("trade-off")
        program = ConvexSubproblem(problem, objective, constraints=lambda beta: [beta[3] == 0.03])
        out = program.solve(point, objective, low=point - BOX, high=point + BOX)
        assert out.profile[3] == pytest.approx(0.03, abs=1e-8)

    def test_refuses_what_is_not_convex(self) -> None:
        problem, objective, _ = _case("trade-off")
        with pytest.raises(InputError, match="constraints: not convex"):
            ConvexSubproblem(problem, objective, constraints=lambda beta: [beta[0] ** 2 >= 1.0])

    @pytest.mark.parametrize("kind", ["trade-off", "trade-off, frozen", "trade-off, harmonics"])
    def test_projection(self, kind: str) -> None:
        problem, objective, point = _case(kind)
        program = ConvexSubproblem(
            problem, objective, constraints=lambda beta: [beta[0] <= beta[9] - 0.01]
        )
        profile = program.project(point)
        assert profile[0] <= profile[9] - 0.01 + 1e-7
        out, over = problem.limits.violation(problem.curves, profile)
        assert out <= 1e-6
        assert over <= 1e-4
        if problem.basis is not None:
            rest = profile - problem.basis @ np.linalg.lstsq(problem.basis, profile)[0]
            assert np.abs(rest).max() < 1e-6
        if problem.curves.mean_pitch is not None:
            assert profile.mean() == pytest.approx(0.02, abs=1e-7)

    def test_projection_of_what_is_feasible_stays(self) -> None:
        problem, objective, point = _case("trade-off")
        program = ConvexSubproblem(problem, objective)
        np.testing.assert_allclose(program.project(point), point, atol=1e-6)

    def test_no_profile_at_all(self) -> None:
        problem, objective, point = _case("trade-off")
        program = ConvexSubproblem(problem, objective, constraints=lambda beta: [beta[0] >= 9.0])
        with pytest.raises(ComputationError, match="no profile satisfies"):
            program.project(point)
