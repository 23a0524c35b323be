"""Branch and bound: no feasible profile above its bound, nothing good cut off, trees re-checked."""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from functools import cache
from itertools import pairwise, product
from typing import Any

import numpy as np
import pytest
from design_factories import (
    Case,
    drawn_case,
    random_curves,
    random_profile,
    rotor_curves,
    slow_value,
    wide_limits,
)
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from pitchopt.design import (
    DesignProblem,
    Multipliers,
    Objective,
    Proof,
    ProofSettings,
    check_proof,
    lagrangian_bound,
    prove,
    prove_in_stages,
    relax,
    solve_local,
)
from pitchopt.design.proof import kernels
from pitchopt.design.proof.node import packed, unpacked
from pitchopt.design.proof.region import Frame, Region, dual_step, tightened
from pitchopt.errors import InputError

FloatArray = NDArray[np.float64]

SHORT = ProofSettings(gap=1e-3, seconds=60.0, regions=24)


def feasible_profiles(case: Case, seed: int, count: int = 12) -> list[FloatArray]:
    """Random profiles that keep every limit, and a local optimum if it does."""
    problem, objective = case.problem, case.objective
    rng = np.random.default_rng(seed)
    found = [case.profile, solve_local(problem, objective, case.profile).profile]
    found += [random_profile(rng, problem) for _ in range(count)]
    return [p for p in found if max(problem.excess(problem.curves.evaluate(p), objective)) <= 0.0]


def random_multipliers(rng: np.random.Generator, case: Case) -> Multipliers:
    n, m = case.problem.curves.stations, case.problem.curves.positions
    size = 10.0 ** rng.uniform(-3, 1)
    per_pitch = size * case.size / float(np.ptp(case.problem.curves.beta))
    return Multipliers(
        loads=rng.normal(0, size, (4, m)),
        blade=rng.normal(0, size, n),
        rate=rng.normal(0, per_pitch, n) * rng.integers(2),
        cap=float(rng.normal(0, size)),
        mean=float(rng.normal(0, per_pitch)),
        box=rng.normal(0, size, 4) * rng.integers(2, size=4),
    )


class TestNothingGoodIsCutOff:
    @given(seed=st.integers(0, 10**6), degenerate=st.booleans())
    @settings(max_examples=120)
    def test_regions_keep_profiles_worth_the_cut(self, seed: int, degenerate: bool) -> None:
        """Tightening and dual steps at any multipliers keep a profile whose value is the cut."""
        case = drawn_case(seed, degenerate=degenerate)
        problem, objective = case.problem, case.objective
        rng = np.random.default_rng(seed)
        frame = Frame(problem, objective)
        for profile in feasible_profiles(case, seed, 3):
            value = slow_value(problem.curves, profile, objective)
            cut = value - 1e-12 * max(abs(value), case.size)
            loads = problem.curves.evaluate(profile)
            region: Region | None = frame.first()
            for _ in range(3):
                assert region is not None
                region = tightened(frame, region, cut, passes=2, slices=5)
                assert region is not None, case.name
                bound, region = dual_step(frame, region, random_multipliers(rng, case), cut)
                assert bound >= cut, case.name
                assert region is not None and region.contains(profile), case.name
                slack = 1e-12 * frame.largest[:4].max(axis=1) * problem.curves.blades
                assert np.all(region.means[:, 0] <= loads.mean + slack), case.name
                assert np.all(region.means[:, 1] >= loads.mean - slack), case.name
                assert np.all(region.rms >= loads.rms - slack), case.name

    @given(seed=st.integers(0, 10**6))
    @settings(max_examples=60)
    def test_rows_of_single_precision(self, seed: int) -> None:
        case = drawn_case(seed)
        frame = Frame(case.problem, case.objective)
        mult = random_multipliers(np.random.default_rng(seed), case)
        row = packed(frame, mult)
        again = unpacked(frame, row)
        np.testing.assert_allclose(again.loads, mult.loads, rtol=1e-6)
        np.testing.assert_allclose(again.rate, mult.rate, rtol=1e-6)
        np.testing.assert_array_equal(packed(frame, again), row)


class TestNeverTooLow:
    @given(seed=st.integers(0, 10**6), degenerate=st.booleans())
    @settings(max_examples=60, deadline=None)
    def test_random_problems(self, seed: int, degenerate: bool) -> None:
        case = drawn_case(seed, degenerate=degenerate, largest=(3, 4, 5))
        problem, objective = case.problem, case.objective
        known = feasible_profiles(case, seed)
        best = max(slow_value(problem.curves, p, objective) for p in known)
        start = min(known, key=lambda p: slow_value(problem.curves, p, objective))
        scale = max(abs(best), case.size)
        proven = prove(problem, objective, start, scale=scale, settings=SHORT)
        assert proven.upper_bound >= best - 1e-13 * scale, case.name
        assert proven.value >= slow_value(problem.curves, start, objective) - 1e-12 * scale
        again = check_proof(proven.proof, problem, objective)
        assert again == pytest.approx(proven.upper_bound, rel=1e-12, abs=1e-12 * scale)

    @pytest.mark.parametrize(("blades", "positions"), [(1, 2), (2, 1), (3, 1), (1, 3), (2, 2)])
    @pytest.mark.parametrize("seed", range(4))
    def test_against_every_profile_of_a_grid(self, blades: int, positions: int, seed: int) -> None:
        """The gap closes, and no profile of a grid is better than what was found."""
        rng = np.random.default_rng(1000 + 100 * seed + 10 * blades + positions)
        curves = random_curves(rng, blades=blades, positions=positions, knots=4, rates=seed == 1)
        problem = DesignProblem(curves=curves, limits=wide_limits(0.3))
        objective = Objective(torque=1.0, rms=(2.0, 1.4, 0.8, 1.6, 0.5), travel=0.1 * (seed == 2))
        n = curves.stations
        grids = [
            np.linspace(low, high, {1: 400, 2: 60, 3: 18, 4: 9}[n])
            for low, high in zip(problem.curves.lower, problem.curves.upper, strict=True)
        ]
        best = max(
            problem.value(np.array(pick), objective)
            for pick in product(*grids)
            if problem.limits.violation(problem.curves, np.array(pick))[1] <= 0
        )
        start = problem.repaired(np.zeros(n))
        proven = prove(
            problem, objective, start, scale=1.0, settings=ProofSettings(gap=1e-3, regions=20_000)
        )
        assert proven.ended == "gap reached" and proven.gap <= 1e-3
        assert best <= proven.upper_bound
        assert best <= proven.value + 1e-3

    def test_constant_pitch_only(self) -> None:
        """A rate limit of zero leaves one number; the bound meets the best constant."""
        problem = DesignProblem(curves=rotor_curves(positions=4), limits=wide_limits(0.0))
        objective = Objective(torque=1.0, rms=(3.0, 3.0, 3.0, 3.0, 0.0))
        low, high = problem.constant_range
        grid = [
            problem.value(np.full(12, pitch), objective) for pitch in np.linspace(low, high, 2001)
        ]
        start = np.full(12, 0.5 * (low + high))
        scale = problem.torque_scale
        proven = prove(
            problem, objective, start, scale=scale, settings=ProofSettings(gap=1e-4, regions=4000)
        )
        assert proven.ended == "gap reached"
        assert max(grid) <= proven.upper_bound <= max(grid) + 2e-4 * scale

    def test_flat_curves(self) -> None:
        n = 12
        psi = 2 * np.pi * np.arange(n) / n
        flat = np.full((n, 2), 7.0)
        curves = type(rotor_curves())(
            blades=3, azimuth=psi, beta=np.tile([-0.1, 0.1], (n, 1)), torque=flat, bending=flat,
            thrust=flat,
        )  # fmt: skip
        problem = DesignProblem(curves=curves, limits=wide_limits())
        objective = Objective(torque=1.0, rms=(0.0, 0.0, 0.0, 1.0, 0.0))
        proven = prove(problem, objective, np.zeros(n), scale=21.0, settings=SHORT)
        assert proven.value == pytest.approx(21.0)
        assert 21.0 <= proven.upper_bound <= 21.0 * (1 + 1e-3)


@cache
def knee_problem(positions: int = 6) -> tuple[DesignProblem, Objective, FloatArray, float]:
    """A rotor at a price where the hull is loose."""
    problem = DesignProblem(curves=rotor_curves(positions=positions), limits=wide_limits(0.15))
    objective = Objective(torque=1.0, rms=(20.0, 20.0, 20.0, 20.0, 0.0))
    start = solve_local(problem, objective, np.zeros(3 * positions)).profile
    return problem, objective, start, problem.torque_scale


class TestSearch:
    @pytest.mark.slow
    def test_closes_what_the_hull_leaves(self) -> None:
        problem, objective, start, scale = knee_problem()
        relaxed = relax(problem, objective, profile=start)
        assert relaxed is not None
        value = problem.value(start, objective)
        settings_ = ProofSettings(gap=2e-3, seconds=120.0)
        proven = prove(
            problem, objective, start, scale=scale, multipliers=relaxed.multipliers,
            settings=settings_,
        )  # fmt: skip
        assert (relaxed.upper_bound - value) / scale > 5e-3
        assert proven.ended == "gap reached" and 0 <= proven.gap <= 2e-3
        gaps = [gap for _, _, gap in proven.history]
        assert all(later <= earlier + 1e-12 for earlier, later in pairwise(gaps))

    def test_the_tree_does_not_depend_on_the_workers(self) -> None:
        problem, objective, start, scale = knee_problem()
        settings_ = ProofSettings(gap=1e-4, seconds=600.0, regions=150)
        alone = prove(problem, objective, start, scale=scale, settings=settings_)
        with ThreadPoolExecutor(3) as pool:
            shared = prove(
                problem, objective, start, scale=scale,
                settings=replace(settings_, executor=pool, workers=3),
            )  # fmt: skip
        assert alone.upper_bound == shared.upper_bound
        assert alone.ended == shared.ended == "region limit"
        np.testing.assert_array_equal(alone.proof.multipliers, shared.proof.multipliers)
        np.testing.assert_array_equal(alone.proof.value, shared.proof.value)

    @pytest.mark.slow
    def test_goes_on_from_a_stored_tree(self) -> None:
        problem, objective, start, scale = knee_problem(4)
        first = prove(
            problem, objective, start, scale=scale, settings=ProofSettings(gap=2e-3, regions=60)
        )
        assert first.ended == "region limit"
        second = prove(
            problem, objective, start, scale=scale, settings=ProofSettings(gap=2e-3),
            resume=first.proof,
        )  # fmt: skip
        assert second.ended == "gap reached" and second.regions > first.regions
        assert second.upper_bound <= first.upper_bound
        assert check_proof(second.proof, problem, objective) == pytest.approx(
            second.upper_bound, rel=1e-12
        )

    @pytest.mark.slow
    def test_a_small_gap_comes_after_a_proof_of_one_per_cent(self) -> None:
        problem, objective, start, scale = knee_problem(4)
        kept = prove_in_stages(
            problem, objective, start, scale=scale,
            settings=ProofSettings(gap=1e-6, seconds=120.0, regions=600),
        )  # fmt: skip
        assert kept.ended == "region limit"
        assert kept.gap <= 0.009  # the second search alone is not that far by then
        alone = prove(
            problem, objective, start, scale=scale, settings=ProofSettings(gap=1e-6, regions=600)
        )
        assert kept.upper_bound <= alone.upper_bound + 1e-12 * scale
        assert check_proof(kept.proof, problem, objective) == pytest.approx(
            kept.upper_bound, rel=1e-12
        )

    def test_time_limit(self) -> None:
        problem, objective, start, scale = knee_problem()
        proven = prove(
            problem, objective, start, scale=scale, settings=ProofSettings(gap=1e-9, seconds=0.0)
        )
        assert proven.ended == "time limit" and proven.regions == 1
        assert proven.upper_bound > proven.value

    def test_interrupted(self) -> None:
        problem, objective, start, scale = knee_problem()

        class Stopping(ThreadPoolExecutor):
            calls = 0

            def submit(self, *args: Any, **kwargs: Any) -> Any:
                Stopping.calls += 1
                if Stopping.calls > 2:
                    raise KeyboardInterrupt
                return super().submit(*args, **kwargs)

        with Stopping(1) as pool:
            proven = prove(
                problem, objective, start, scale=scale,
                settings=ProofSettings(gap=1e-6, executor=pool),
            )  # fmt: skip
        assert proven.ended == "interrupted"
        assert check_proof(proven.proof, problem, objective) == pytest.approx(
            proven.upper_bound, rel=1e-12
        )

    @pytest.mark.slow
    def test_takes_over_a_better_profile(self) -> None:
        problem, objective, start, scale = knee_problem(4)
        poor = np.full(12, float(problem.constant_range[0]))
        proven = prove(
            problem, objective, poor, scale=scale, settings=ProofSettings(gap=2e-3, seconds=120.0)
        )
        assert proven.improved
        assert proven.value == pytest.approx(problem.value(proven.profile, objective))
        assert proven.value >= problem.value(start, objective) - 2e-3 * scale

    @pytest.mark.parametrize(
        "wrong", [{"gap": 0.0}, {"gap": np.nan}, {"seconds": -1.0}, {"regions": 0}, {"workers": 0}]
    )
    def test_bad_settings(self, wrong: dict[str, Any]) -> None:
        with pytest.raises(InputError):
            ProofSettings(**wrong)


@cache
def knee_proof() -> tuple[DesignProblem, Objective, Proof]:
    """A proof of its smallest kind, which tests take apart copy by copy."""
    problem, objective, start, scale = knee_problem(4)
    proven = prove(
        problem, objective, start, scale=scale, settings=ProofSettings(gap=5e-3, regions=300)
    )
    return problem, objective, proven.proof


class TestCheck:
    def test_other_problems_are_refused(self) -> None:
        problem, objective, proof = knee_proof()
        other = replace(objective, torque=0.5)
        with pytest.raises(InputError, match="other curves"):
            check_proof(proof, problem, other)
        curves = replace(problem.curves, torque=problem.curves.torque * (1 + 1e-15) + 1e-9)
        with pytest.raises(InputError, match="other curves"):
            check_proof(proof, problem.with_curves(curves), objective)

    @pytest.mark.parametrize("seed", range(6))
    def test_changed_multipliers_cannot_make_it_wrong(self, seed: int) -> None:
        """Whatever stands in the rows, what comes out is still a bound."""
        problem, objective, proof = knee_proof()
        rng = np.random.default_rng(seed)
        rows = proof.multipliers * np.float32(10.0) ** rng.normal(
            0, 1, proof.multipliers.shape
        ).astype(np.float32)
        best = max(
            solve_local(problem, objective, np.full(12, pitch)).value
            for pitch in np.linspace(*problem.constant_range, 5)
        )
        bound = check_proof(replace(proof, multipliers=rows), problem, objective)
        assert bound >= best
        assert bound >= proof.upper_bound - 1e-9 * abs(proof.upper_bound)

    @pytest.mark.parametrize("more", [1e2, 1e4, 1e5, 1e9])
    def test_a_raised_cut_is_paid_for(self, more: float) -> None:
        """Regions lose more, and what they lose counts: by the cut, or by their own bound."""
        problem, objective, proof = knee_proof()
        best = solve_local(problem, objective, np.zeros(12)).value
        assert proof.upper_bound >= best
        bound = check_proof(replace(proof, cut=proof.cut + more), problem, objective)
        assert bound >= best
        assert bound >= min(proof.upper_bound, float(proof.cut.max()) + more) - 1e-3 * abs(best)

    @pytest.mark.parametrize("what", ["missing part", "two roots", "other value", "same side"])
    def test_trees_with_holes_are_refused(self, what: str) -> None:
        problem, objective, proof = knee_proof()
        assert proof.regions > 4
        last = proof.regions - 1
        parent, value, above = proof.parent.copy(), proof.value.copy(), proof.above.copy()
        if what == "missing part":
            parent[last] = -1 if parent[last] == 0 else 0
        elif what == "two roots":
            parent[last] = -1
        elif what == "other value":
            value[last] += 1.0
        else:
            above[last] = not above[last]
        broken = replace(proof, parent=parent, value=value, above=above)
        with pytest.raises(InputError, match="proof"):
            check_proof(broken, problem, objective)

    @pytest.mark.parametrize(
        ("name", "change"),
        [
            ("cut", lambda a: np.where(np.arange(a.size) == 0, np.nan, a)),
            ("cut", lambda a: np.full(a.size, -np.inf)),
            ("value", lambda a: a * np.nan),
            ("multipliers", lambda a: a * np.float32(np.nan)),
            ("multipliers", lambda a: a[:, :-1]),
            ("multipliers", lambda a: a.astype(float) * 1e300),
            ("row", lambda a: a + 10**6),
            ("row", lambda a: a - 7),
            ("slices", lambda a: a * 0),
            ("slices", lambda a: a * 0 - 3),
            ("passes", lambda a: a + 10**9),
            ("first_step", lambda a: a[::-1]),
            ("first_step", lambda a: a[:-1]),
            ("first_step", lambda a: a.astype(float)),
            ("load", lambda a: np.where(a >= 0, 7, a)),
            ("station", lambda a: a + 100),
            ("parent", lambda a: a + 1),
            ("above", lambda a: a.astype(int)),
        ],
    )
    def test_hostile_numbers_are_refused(self, name: str, change: Any) -> None:
        problem, objective, proof = knee_proof()
        with pytest.raises(InputError, match="proof"):
            check_proof(replace(proof, **{name: change(getattr(proof, name))}), problem, objective)

    def test_not_a_number_proves_nothing(self) -> None:
        """In the steps themselves, whoever calls them."""
        problem, objective, _, _ = knee_problem(4)
        frame = Frame(problem, objective)
        region = frame.first()
        zero = Multipliers.zero(12, 4)
        for wrong in (
            replace(zero, cap=np.nan),
            replace(zero, rate=np.full(12, np.inf)),
            replace(zero, box=np.full(4, np.nan)),
            replace(zero, loads=np.full((4, 4), 1e308), rate=np.full(12, 1e308)),
        ):
            bound, left = dual_step(frame, region, wrong, -1e30)
            assert left is not None and bound > -1e30
            assert lagrangian_bound(problem, objective, wrong)[0] > 0
        assert tightened(frame, region, np.nan) is region
        assert tightened(frame, region, -1e30, slices=0) is region

    def test_peaked_loads_do_not_end_in_a_singular_system(self) -> None:
        flat = np.zeros((2, 2))
        curves = type(rotor_curves())(
            blades=2,
            azimuth=np.array([0.0, np.pi]),
            beta=np.tile([-0.1, 0.3], (2, 1)),
            torque=np.tile([1.0, 3.0], (2, 1)),
            bending=flat,
            thrust=flat,
        )
        problem = DesignProblem(curves=curves, limits=wide_limits(5.0))
        frame = Frame(problem, Objective(torque=1.0, rms=(1.0, 1.0, 1.0, 1.0, 0.0)))
        means = frame.first().means.copy()
        means[0] = 4.0 - 1e-9, 4.0 + 1e-9
        left = tightened(frame, replace(frame.first(), means=means), 3.9)
        assert left is not None and left.contains(np.full(2, 0.1))


class TestKernels:
    """Against the same thing on a fine grid of pitches."""

    def frame(self, seed: int) -> tuple[Frame, FloatArray, FloatArray, np.random.Generator]:
        rng = np.random.default_rng(seed)
        problem = DesignProblem(
            curves=random_curves(rng, positions=3, knots=6), limits=wide_limits(5.0)
        )
        frame = Frame(problem, Objective(torque=1.0, rms=(1.0, 1.0, 1.0, 1.0, 0.0)))
        ends = rng.uniform(problem.curves.lower, problem.curves.upper, (2, 9))
        return frame, ends.min(axis=0), ends.max(axis=0), rng

    @pytest.mark.parametrize("seed", range(8))
    def test_ranges_and_maxima(self, seed: int) -> None:
        frame, lo, hi, rng = self.frame(seed)
        curves = frame.problem.curves
        grid = np.linspace(lo, hi, 4001)
        values = np.stack([curves.contributions(row) for row in grid])  # (P, 5, N)
        spans = kernels.ranges(frame.beta, frame.loads, lo, hi)
        step = 1e-2 * np.abs(curves.slopes).max() * (hi - lo).max() / 10
        np.testing.assert_allclose(spans[..., 0], values.min(axis=0), atol=step)
        np.testing.assert_allclose(spans[..., 1], values.max(axis=0), atol=step)
        assert np.all(spans[..., 0] <= values.min(axis=0) + 1e-13)
        assert np.all(spans[..., 1] >= values.max(axis=0) - 1e-13)
        coefficients = rng.normal(size=(6, 9))
        combined = coefficients[0] * grid + np.einsum("qn,pqn->pn", coefficients[1:], values)
        maxima = kernels.linear_maxima(frame.beta, frame.loads, coefficients, lo, hi)
        assert np.all(maxima >= combined.max(axis=0) - 1e-12)
        np.testing.assert_allclose(maxima, combined.max(axis=0), atol=20 * step)
        level = combined.min(axis=0) + 0.7 * np.ptp(combined, axis=0)
        first, last = kernels.level_hulls(frame.beta, frame.loads, coefficients, lo, hi, level)
        for n in range(9):
            kept = grid[combined[:, n] >= level[n], n]
            assert first[n] - 1e-12 <= kept.min() and kept.max() <= last[n] + 1e-12
            assert kept.min() - first[n] <= 2 * (hi[n] - lo[n]) / 4000
            assert last[n] - kept.max() <= 2 * (hi[n] - lo[n]) / 4000

    @pytest.mark.parametrize("seed", range(8))
    @pytest.mark.parametrize("slices", [1, 4, 16])
    def test_no_triple_is_lost(self, seed: int, slices: int) -> None:
        """Every profile whose loads lie in the ranges stays, in the scan and in the Newton step."""
        frame, lo, hi, rng = self.frame(seed)
        curves = frame.problem.curves
        target = rng.uniform(lo, hi)
        rotor = curves.evaluate(target).rotor
        low, high = (rotor + sign * rng.uniform(0.01, 0.3, (4, 3)) for sign in (-1, 1))
        p, q = frame.axes
        corners = [
            np.minimum(p * low[1], p * high[1]) + np.minimum(q * low[2], q * high[2]),
            np.maximum(p * low[1], p * high[1]) + np.maximum(q * low[2], q * high[2]),
        ]
        scan_lo, scan_hi, empty = kernels.triple_scan(
            frame.beta, frame.loads[0], frame.loads[3], frame.without, lo, hi, low, high,
            corners[0], corners[1], slices,
        )  # fmt: skip
        newton_lo, newton_hi = kernels.newton_pass(
            frame.beta, frame.loads[:4], lo, hi, low, high, 1e-14
        )
        assert not empty
        tries = np.concatenate(
            [target[None], target + rng.normal(0, 0.03, (4000, 9)), rng.uniform(lo, hi, (4000, 9))]
        )
        kept = 0
        for profile in tries:
            if np.any(profile < lo) or np.any(profile > hi):
                continue
            loads = curves.evaluate(profile).rotor
            inside = np.all((loads >= low) & (loads <= high), axis=0)
            for k in np.flatnonzero(inside):
                stations = k + 3 * np.arange(3)
                kept += 1
                for first, last in ((scan_lo, scan_hi), (newton_lo, newton_hi)):
                    assert np.all(profile[stations] >= first[stations] - 1e-12)
                    assert np.all(profile[stations] <= last[stations] + 1e-12)
        assert kept > 0
        if slices == 16:
            assert np.sum(scan_hi - scan_lo) < np.sum(hi - lo)


@pytest.mark.slow
class TestTheTargets:
    def test_two_degrees_a_second(self) -> None:
        """Least RMS for 3 % of torque lost at 2 deg/s: 1 % of max torque is proven."""
        from pitchopt import load_case
        from pitchopt.design import compared

        case = load_case("biegel2011").with_values({"limits.pitch_rate": np.radians(2.0)})
        found = compared(
            case.task(),
            max_power_loss=0.03,
            certify=ProofSettings(gap=0.01, seconds=240.0),
        )
        design = found.design
        assert design.proof_ended == "gap reached"
        assert design.gap is not None and design.gap <= 0.0105
        assert design.certificate is not None and design.certificate.proof is not None
        assert design.upper_bound is not None
        assert design.certificate.check() <= design.upper_bound * (1 + 1e-12)
        assert design.rms_lower_bound is not None
        assert 0.5 * design.rms_weighted < design.rms_lower_bound < design.rms_weighted
