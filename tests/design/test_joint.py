"""The joint problem: subproblem, local solve, repair and bound on random winds."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from design_factories import OMEGA, random_curves, random_profile
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from pitchopt.aero.curves import BladeCurves
from pitchopt.design import (
    DesignProblem,
    Objective,
    PitchLimits,
    ScpSettings,
    Status,
    relax,
    solve_local,
)
from pitchopt.design.direct import Subproblem
from pitchopt.design.joint import JointMultipliers, JointProblem
from pitchopt.design.joint_bound import joint_bound, joint_lagrangian
from pitchopt.design.joint_scp import solve_joint
from pitchopt.design.joint_subproblem import solve_joint_subproblem
from pitchopt.design.multipliers import Multipliers
from pitchopt.design.search import Start
from pitchopt.errors import InputError

FloatArray = NDArray[np.float64]
Rng = np.random.Generator


def turned(curves: BladeCurves) -> BladeCurves:
    """Random curves with the first station at the azimuth that all share."""
    n = curves.stations
    names = ("torque", "bending", "thrust", "radial")
    rates = [f"{name}_rate" for name in names]
    fields = {name: getattr(curves, name) for name in (*names, *rates)}
    psi = 2 * np.pi * np.arange(n) / n
    return BladeCurves(blades=curves.blades, azimuth=psi, beta=curves.beta, **fields)


def drawn(seed: int, *, limits: bool = True) -> tuple[JointProblem, Rng]:
    """A random joint problem of any kind; the same for the same seed."""
    rng = np.random.default_rng(seed)
    winds = int(rng.integers(1, 5))
    blades, positions = int(rng.integers(1, 4)), int(rng.integers(1, 5))
    size = float(10.0 ** rng.choice([-2, 0, 5]))
    concave = bool(rng.random() < 0.6)
    problems, objectives = [], []
    for _ in range(winds):
        curves = random_curves(
            rng,
            blades=blades,
            positions=positions,
            knots=int(rng.integers(2, 6)),
            concave=concave,
            rates=bool(rng.random() < 0.5),
            size=size,
        )
        rate = 0.4 * 10.0 ** rng.uniform(-1.5, 1.0)
        problem = DesignProblem(
            curves=turned(curves), limits=PitchLimits(rotor_speed=OMEGA, pitch_rate=rate)
        )
        problems.append(problem)
        numbers = 10.0 ** rng.uniform(-2, 1, 5) * (rng.random(5) < 0.6)
        loads = problem.curves.evaluate(np.full(problem.curves.stations, 0.05))
        more: dict[str, float] = {}
        kind = rng.random()
        if limits and kind < 0.2:
            more["blade_cap"] = float(loads.blade_rms * 1.2 + 1e-3 * size)
        elif limits and kind < 0.4:
            more["torque_min"] = float(loads.mean[0]) - 0.1 * size
        elif limits and kind < 0.5:
            more["torque_max"] = float(loads.mean[0]) + 0.1 * size
        a, b, c, d, e = map(float, numbers)
        objectives.append(
            Objective(
                torque=float(rng.random() < 0.8),
                rms=(a, b, c, d, e),
                travel=size * float(rng.random() < 0.3),
                **more,
            )
        )
    goal: dict[str, Any] = {}
    if rng.random() < 0.5:
        goal["weights"] = rng.dirichlet(np.ones(winds)) * (rng.random(winds) < 0.8)
    else:
        goal["targets"] = size * rng.normal(2.0, 0.5, winds)
    if rng.random() < 0.5:
        goal["profile_of"] = range(winds)
        goal["change"] = float(rng.choice([0.3, 0.03, 1e-4, np.inf]))
    return JointProblem.of(problems, objectives, **goal), rng


def feasible(joint: JointProblem, rng: Rng) -> FloatArray:
    """Random feasible profiles."""
    rows = [random_profile(rng, joint.leaders[0])] * joint.count
    if rng.random() < 0.7:
        rows = [random_profile(rng, leader) for leader in joint.leaders]
    return joint.repaired(np.concatenate(rows))


def keeps(joint: JointProblem, beta: FloatArray) -> None:
    rows = joint.split(beta)
    for row, leader in zip(rows, joint.leaders, strict=True):
        assert np.all(row >= leader.curves.lower - 1e-12)
        assert np.all(row <= leader.curves.upper + 1e-12)
        assert np.abs(np.roll(row, -1) - row).max() <= leader.step + 1e-12
    if joint.count > 1:
        assert np.abs(np.diff(rows, axis=0)).max() <= joint.change + 1e-12


def within(joint: JointProblem, beta: FloatArray) -> bool:
    """Torque limits and caps of all winds are kept."""
    return bool(np.all(joint.excess(joint.loads(beta)) == 0.0))


def random_multipliers(joint: JointProblem, rng: Rng) -> JointMultipliers:
    """Multipliers without any sense."""
    n, m = joint.stations, joint.problems[0].curves.positions
    scale = joint.problems[0].torque_scale

    def noise(*shape: int) -> FloatArray:
        return np.asarray(10.0 ** rng.uniform(-3, 0) * rng.normal(size=shape))

    winds = tuple(
        Multipliers(
            loads=noise(4, m),
            blade=noise(n),
            rate=noise(n),
            torque_min=float(noise(1)[0]),
            torque_max=float(noise(1)[0]),
            cap=float(noise(1)[0]),
        )
        for _ in joint.problems
    )
    return JointMultipliers(
        shares=noise(len(joint.problems)),
        winds=winds,
        rate=scale * noise(joint.count, n),
        link=scale * noise(joint.count - 1, n) * np.isfinite(joint.change),
        basis=noise(joint.count, n),
    )


class TestBound:
    @settings(max_examples=120, deadline=None)
    @given(seed=st.integers(0, 2**32 - 1))
    def test_random_multipliers_never_bound_below_a_feasible_profile(self, seed: int) -> None:
        joint, rng = drawn(seed)
        bound, _, _ = joint_lagrangian(joint, random_multipliers(joint, rng))
        for _ in range(8):
            beta = feasible(joint, rng)
            keeps(joint, beta)
            if within(joint, beta):
                assert joint.total(joint.values(beta)) <= bound

    @settings(max_examples=60, deadline=None)
    @given(seed=st.integers(0, 2**32 - 1))
    def test_good_multipliers_never_bound_below_a_local_optimum(self, seed: int) -> None:
        joint, rng = drawn(seed)
        found = solve_joint(joint, Start(label="", profile=feasible(joint, rng)))
        bound = joint_bound(joint, found.profile, multipliers=found.multipliers)
        value = joint.total(found.values)
        if within(joint, found.profile):
            assert bound.upper_bound >= value
        if found.multipliers is not None:
            assert bound.upper_bound <= joint_lagrangian(joint, found.multipliers)[0]

    @pytest.mark.parametrize("seed", range(12))
    def test_convex_problems_are_closed(self, seed: int) -> None:
        """One segment a station: the hull relaxation is the problem itself."""
        rng = np.random.default_rng(seed)
        problems = [
            DesignProblem(
                curves=turned(random_curves(rng, knots=2, rates=True)),
                limits=PitchLimits(rotor_speed=OMEGA, pitch_rate=0.2),
            )
            for _ in range(3)
        ]
        objectives = [
            Objective(torque=1.0, rms=(1.0, 0.5, 0.2, 0.3, float(seed % 2))) for _ in problems
        ]
        goals: list[dict[str, Any]] = [
            {"weights": np.array([0.2, 0.5, 0.3])},
            {"targets": np.array([2.0, 2.2, 2.1])},
            {"weights": np.ones(3) / 3, "profile_of": range(3), "change": 0.05},
        ]
        for goal in goals:
            joint = JointProblem.of(problems, objectives, **goal)
            start = joint.repaired(np.zeros(joint.count * joint.stations))
            found = solve_joint(joint, Start(label="", profile=start))
            assert found.status is Status.CONVERGED
            bound = joint_bound(joint, found.profile)
            value = joint.total(found.values)
            assert value <= bound.upper_bound <= value + 2e-5 * problems[0].torque_scale

    @pytest.mark.parametrize("seed", range(6))
    def test_one_wind_has_the_bound_of_its_own(self, seed: int) -> None:
        rng = np.random.default_rng(seed)
        problem = DesignProblem(
            curves=turned(random_curves(rng)),
            limits=PitchLimits(rotor_speed=OMEGA, pitch_rate=0.2),
        )
        objective = Objective(torque=1.0, rms=(1.0, 1.0, 1.0, 1.0, 0.0))
        single = relax(problem, objective)
        joint = JointProblem.of([problem], [objective], weights=np.ones(1))
        bound = joint_bound(joint, np.zeros(12), tolerance=1e-6)
        assert single is not None
        assert bound.upper_bound == pytest.approx(
            single.upper_bound, abs=2e-5 * problem.torque_scale
        )

    @pytest.mark.parametrize("seed", range(6))
    def test_not_above_the_sum_of_the_winds_own_bounds(self, seed: int) -> None:
        rng = np.random.default_rng(seed)
        problems = [
            DesignProblem(
                curves=turned(random_curves(rng)),
                limits=PitchLimits(rotor_speed=OMEGA, pitch_rate=0.2),
            )
            for _ in range(3)
        ]
        objective = Objective(torque=1.0, rms=(1.0, 1.0, 1.0, 1.0, 0.0))
        joint = JointProblem.of(problems, [objective] * 3, weights=np.ones(3) / 3)
        bound = joint_bound(joint, np.zeros(12), tolerance=1e-6)
        own = [relax(problem, objective) for problem in problems]
        total = np.mean([one.upper_bound for one in own if one is not None])
        assert bound.upper_bound <= total + 1e-5 * problems[0].torque_scale


class TestLocalSolve:
    @pytest.mark.parametrize("seed", range(30))
    def test_local_optimum(self, seed: int) -> None:
        joint, rng = drawn(seed)
        start = feasible(joint, rng)
        found = solve_joint(joint, Start(label="here", profile=start))
        assert found.status is Status.CONVERGED, found.message
        assert found.start == "here"
        keeps(joint, found.profile)
        excess = joint.excess(found.loads)
        torque = np.array([abs(float(load.mean[0])) for load in found.loads])
        scale = max(abs(joint.total(found.values)), float(torque.max()))
        assert np.all(excess[:, 0] <= 2e-6 * np.maximum(torque, 1e-3 * scale))
        if within(joint, start):
            assert joint.total(found.values) >= joint.total(joint.values(start)) - 1e-6 * scale
        gain = best_nudge(joint, found.profile, rng)
        assert gain <= 2e-7 * scale

    @pytest.mark.parametrize("seed", range(8))
    def test_one_wind_is_the_single_problem(self, seed: int) -> None:
        rng = np.random.default_rng(seed)
        problem = DesignProblem(
            curves=turned(random_curves(rng, rates=True)),
            limits=PitchLimits(rotor_speed=OMEGA, pitch_rate=0.2),
        )
        objective = Objective(torque=1.0, rms=(1.0, 0.4, 0.2, 0.6, 0.3), travel=0.1)
        start = random_profile(rng, problem)
        single = solve_local(problem, objective, start)
        joint = JointProblem.of([problem], [objective], weights=np.ones(1))
        found = solve_joint(joint, Start(label="", profile=start), settings=ScpSettings())
        assert found.values[0] == pytest.approx(single.value, abs=1e-9)
        np.testing.assert_allclose(found.profile, single.profile, atol=1e-9)

    @pytest.mark.parametrize("level", [0.0, 1e5])
    @pytest.mark.parametrize("limit", [{"torque_min": -1e3}, {"torque_max": 2e6}])
    @pytest.mark.parametrize("goal", ["weights", "targets"])
    def test_torque_that_pitch_does_not_change(
        self, level: float, limit: dict[str, float], goal: str
    ) -> None:
        """A wind of constant torque leaves the least loads, and limits it keeps change nothing."""
        rng = np.random.default_rng(4)
        curves = turned(random_curves(rng))
        still = replace(curves, torque=np.full_like(curves.torque, level))
        limits = PitchLimits(rotor_speed=OMEGA, pitch_rate=0.2)
        problem = DesignProblem(curves=still, limits=limits)
        start = Start(label="", profile=random_profile(rng, problem))
        rms = (1.0, 0.4, 0.2, 0.6, 0.3)
        found = [
            solve_joint(
                JointProblem.of([problem], [objective], **{goal: np.ones(1)}),  # type: ignore[arg-type]
                start,
            )
            for objective in (
                Objective(torque=1.0, rms=rms),
                Objective(torque=1.0, rms=rms, **limit),
            )
        ]
        for one in found:
            assert one.status is Status.CONVERGED, one.message
            assert one.loads[0].mean[0] == pytest.approx(3 * level, abs=1e-6)
        scale = max(3 * level, float(np.abs(curves.bending).max()))
        assert found[1].values[0] == pytest.approx(found[0].values[0], abs=1e-6 * scale)


class TestSubproblem:
    def test_one_wind_is_the_single_subproblem(self) -> None:
        rng = np.random.default_rng(5)
        problem = DesignProblem(
            curves=turned(random_curves(rng, rates=True)),
            limits=PitchLimits(rotor_speed=OMEGA, pitch_rate=0.2),
        )
        objective = Objective(torque=1.0, rms=(1.0, 0.4, 0.2, 0.6, 0.3), travel=0.1)
        point = random_profile(rng, problem)
        single = Subproblem(problem).solve(point, objective, low=point - 0.05, high=point + 0.05)
        joint = JointProblem.of([problem], [objective], weights=np.ones(1))
        box: dict[str, Any] = {"low": point - 0.05, "high": point + 0.05, "penalty": (1.0, 1.0)}
        same = solve_joint_subproblem(joint, point, **box)
        np.testing.assert_array_equal(same.profile, single.profile)
        assert same.value == single.value
        regret = JointProblem.of([problem], [objective], targets=np.array([7.0]))
        other = solve_joint_subproblem(regret, point, **box)
        assert other.value == pytest.approx(single.value - 7.0, abs=1e-7)
        assert other.multipliers.shares[0] == pytest.approx(1.0, abs=1e-7)

    @pytest.mark.parametrize("seed", range(20))
    def test_multipliers_are_stationary(self, seed: int) -> None:
        """On a cell the dual value equals the primal one."""
        joint, rng = drawn(seed, limits=False)
        point = feasible(joint, rng)
        edges, last = joint.edges
        rows = np.arange(point.size)
        cell = np.clip(np.sum(edges <= point[:, None], axis=1) - 1, 0, last)
        low, high = edges[rows, cell], edges[rows, cell + 1]
        out = solve_joint_subproblem(
            joint, np.clip(point, low, high), low=low, high=high, penalty=(1.0, 1.0), on_cells=True
        )
        if not out.solved:  # a rate limit may leave the cell without an inside
            pytest.skip("the cell holds a single profile")
        narrow = (
            JointProblem.of(
                [
                    DesignProblem(
                        curves=problem.curves.with_limits(
                            joint.split(low)[s], joint.split(high)[s]
                        ),
                        limits=problem.limits,
                    )
                    for problem, s in zip(joint.problems, joint.profile_of, strict=True)
                ],
                joint.objectives,
                profile_of=joint.profile_of,
                weights=joint.weights,
                targets=joint.targets,
                change=joint.change,
            )
            if _constant_fits(joint, low, high)
            else None
        )
        if narrow is None:
            return
        bound, _, _ = joint_lagrangian(narrow, out.multipliers)
        scale = joint.problems[0].torque_scale
        assert bound == pytest.approx(out.value, abs=1e-5 * scale)


class TestRepair:
    @settings(max_examples=100, deadline=None)
    @given(seed=st.integers(0, 2**32 - 1))
    def test_keeps_everything_and_moves_no_feasible_profile(self, seed: int) -> None:
        joint, rng = drawn(seed)
        wild = rng.normal(0.0, 1.0, joint.count * joint.stations)
        beta = joint.repaired(wild)
        keeps(joint, beta)
        np.testing.assert_allclose(joint.repaired(beta), beta, atol=1e-12)

    def test_apart(self) -> None:
        rng = np.random.default_rng(0)
        curves = turned(random_curves(rng))
        problems = [
            DesignProblem(
                curves=curves, limits=PitchLimits(rotor_speed=2.0, pitch_rate=0.1, **ends)
            )
            for ends in ({"upper": -0.02}, {"lower": 0.1})
        ]
        objective = Objective(torque=1.0, rms=(1.0, 0.0, 0.0, 0.0, 0.0))
        with pytest.raises(InputError, match="no pitch keeps those of all winds"):
            JointProblem.of(
                problems, [objective] * 2, profile_of=range(2), weights=np.ones(2), change=0.05
            )
        with pytest.raises(InputError, match="goal: expected either"):
            JointProblem.of(problems[:1], [objective])


def _constant_fits(joint: JointProblem, low: FloatArray, high: FloatArray) -> bool:
    """A cell can be posed as a problem of its own only where a constant profile fits."""
    lows, highs = joint.split(low), joint.split(high)
    return bool(np.all(lows.max(axis=1) + 1e-6 < highs.min(axis=1)))


def best_nudge(joint: JointProblem, beta: FloatArray, rng: Rng, *, tries: int = 80) -> float:
    """Largest gain of small feasible moves that stay inside the cells next to the profiles."""
    edges, last = joint.edges
    rows = np.arange(beta.size)
    cell = np.clip(np.sum(edges <= beta[:, None], axis=1) - 1, 0, last)
    low, high = edges[rows, cell], edges[rows, cell + 1]
    room = np.minimum(beta - low, high - beta)
    free = room[room > 1e-5]
    width = float(np.min(high - low))
    largest = min(1e-3, 0.3 * width, 0.9 * float(free.min()) if free.size else np.inf)
    value = joint.total(joint.values(beta))
    allowed = np.maximum(joint.excess(joint.loads(beta)), 1e-12)
    gain = -np.inf
    directions = [*np.eye(beta.size), *-np.eye(beta.size)]
    directions += [rng.normal(size=beta.size) for _ in range(tries)]
    for direction in directions:
        step = min(largest, 10.0 ** rng.uniform(-5, -3))
        moved = joint.repaired(beta + step * direction / np.abs(direction).max())
        if np.all(joint.excess(joint.loads(moved)) <= allowed):
            gain = max(gain, joint.total(joint.values(moved)) - value)
    return gain
