"""The public designs: one profile, the curve, its order, its knee, its honesty."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from design_factories import SmoothModel, rotor_curves, wide_limits

from pitchopt.cases import load_case
from pitchopt.design import (
    CurvesModel,
    Design,
    DesignTask,
    LoadWeights,
    Objective,
    Status,
    Tradeoff,
    compared,
    constant,
    default_mu,
    design,
    power_max,
    tradeoff,
)
from pitchopt.design.constant_pitch import constant_for_torque, constant_set
from pitchopt.errors import InfeasibleError, InputError

TASK = DesignTask(model=SmoothModel(), positions=6, limits=wide_limits(), between_positions=48)
SMALL = replace(TASK, positions=3)
MU = np.geomspace(0.3, 300.0, 10)


@pytest.fixture(scope="module")
def curve() -> Tradeoff:
    return tradeoff(TASK, mu=MU)


@pytest.fixture(scope="module")
def best() -> Design:
    return power_max(TASK)


def price_points(curve: Tradeoff) -> list[Design]:
    return [point for point in curve.points if point.kind == "mu"]


class TestCurve:
    def test_what_stands_there(self, curve: Tradeoff) -> None:
        assert [p.mu for p in price_points(curve)] == pytest.approx(list(MU))
        losses = [p for p in curve.points if p.kind == "max_power_loss"]
        assert sorted(p.target or 0 for p in losses) == [0.03, 0.07]
        assert [p.mu for p in curve.points] == sorted(p.mu for p in curve.points)
        assert curve.power_max.kind == "power_max"
        assert curve.power_max.status is Status.EXACT
        assert all(p.status is Status.CONVERGED for p in curve.points)

    def test_monotone_in_the_price(self, curve: Tradeoff) -> None:
        points = price_points(curve)
        torque = np.array([p.mean_torque for p in points])
        rms = np.array([p.rms_weighted for p in points])
        slack = 1e-6 * curve.power_max.mean_torque
        assert np.all(np.diff(torque) <= slack)
        assert np.all(np.diff(rms) <= slack / MU[:-1])

    def test_no_point_beats_another_at_its_own_price(self, curve: Tradeoff) -> None:
        for point in price_points(curve):
            for other in price_points(curve):
                value = other.mean_torque - point.mu * other.rms_weighted
                assert value <= point.objective + 2e-7 * curve.power_max.mean_torque

    def test_pareto_clean(self, curve: Tradeoff) -> None:
        points = price_points(curve)
        for a in points:
            for b in points:
                margin = 1e-5 * curve.power_max.mean_torque
                assert not (
                    b.mean_torque > a.mean_torque + margin
                    and b.rms_weighted < a.rms_weighted - margin
                )

    @pytest.mark.parametrize("loss", [0.03, 0.07])
    def test_losses_are_met(self, curve: Tradeoff, loss: float) -> None:
        (point,) = [p for p in curve.points if p.target == loss]
        assert curve.loss(point) == pytest.approx(loss, abs=2e-6)
        assert point.rms_lower_bound is not None
        assert 0 <= point.rms_lower_bound <= point.rms_weighted * (1 + 1e-9)
        better = [p for p in price_points(curve) if curve.loss(p) <= loss]
        assert all(point.rms_weighted <= p.rms_weighted * (1 + 1e-6) for p in better)

    def test_bounds_and_gaps(self, curve: Tradeoff) -> None:
        for point in curve.points:
            assert point.upper_bound is not None and point.gap is not None
            want = (point.upper_bound - point.objective) / curve.power_max.mean_torque
            assert point.gap == pytest.approx(want, rel=1e-12)
            assert point.gap >= -1e-9
            assert point.certificate is not None

    def test_fields_agree_with_the_profile(self, curve: Tradeoff) -> None:
        problem, weights = TASK.problem(), TASK.weights
        for point in (curve.constant, curve.power_max, *curve.points):
            loads = problem.curves.evaluate(point.profile)
            assert point.mean_torque == pytest.approx(float(loads.mean[0]), rel=1e-12)
            assert list(point.rms.values()) == pytest.approx(list(loads.rms), rel=1e-9)
            assert list(point.rms) == ["torque", "tilt", "yaw", "thrust"]
            assert point.rms_sum == pytest.approx(float(loads.rms.sum()))
            assert point.rms_weighted == pytest.approx(weights.weighted(loads))
            change = np.abs(np.diff(point.profile, append=point.profile[0])).sum()
            assert point.pitch_travel == pytest.approx(change)
            between = TASK.between(point.profile, None)
            assert between is not None and point.between is not None
            assert point.rms_sum_between == pytest.approx(float(between.rms.sum()))
            out, over = problem.limits.violation(problem.curves, point.profile)
            assert max(out, over) <= 1e-6
            assert point.objective == pytest.approx(
                point.mean_torque - point.mu * point.rms_weighted, rel=1e-9
            )

    def test_cuts(self, curve: Tradeoff) -> None:
        point = curve.points[-1]
        assert curve.cut(point) == pytest.approx(
            1 - point.rms_weighted / curve.constant.rms_weighted
        )
        between = curve.cut_between(point)
        assert between is not None
        assert 0 < between < curve.cut(point)  # a coarse grid flatters itself
        blind = replace(point, rms_weighted_between=None)
        assert curve.cut_between(blind) is None

    def test_knee(self, curve: Tradeoff) -> None:
        """Farthest from the chord, by the distance of points from a line."""
        points = [(curve.power_max.mean_torque, curve.power_max.rms_weighted)]
        points += [(p.mean_torque, p.rms_weighted) for p in curve.points]
        xy = np.array(points)
        xy = (xy - xy.min(axis=0)) / np.ptp(xy, axis=0)
        first, last = np.array([1.0, 1.0]), np.array([0.0, 0.0])  # most torque, least RMS
        along = (last - first) / np.linalg.norm(last - first)
        offset = xy - first
        distance = along[0] * offset[:, 1] - along[1] * offset[:, 0]
        assert curve.knee == int(np.argmax(np.abs(distance[1:])))
        assert 0 < curve.knee < len(curve.points) - 1

    def test_constant_set(self, curve: Tradeoff) -> None:
        pitch, torque, rms, pareto = constant_set(TASK)
        np.testing.assert_array_equal(pitch, curve.constant_pitch)
        np.testing.assert_array_equal(pareto, curve.constant_pareto)
        for i in range(0, pitch.size, 7):
            loads = TASK.problem().curves.evaluate(np.full(18, pitch[i]))
            assert torque[i] == pytest.approx(loads.mean[0])
            assert rms[i] == pytest.approx(TASK.weights.weighted(loads))
            beaten = np.any((torque > torque[i]) & (rms < rms[i]))
            assert not (beaten and pareto[i])

    def test_settings_are_recorded(self, curve: Tradeoff) -> None:
        assert curve.settings["seed"] == 0
        assert curve.settings["positions"] == 6
        assert curve.settings["weights"]["thrust"] == 1.0
        assert curve.seconds > 0

    def test_same_seed_same_result(self) -> None:
        a = tradeoff(SMALL, mu=[1.0, 10.0, 50.0], seed=3, starts=7)
        b = tradeoff(SMALL, mu=[50.0, 1.0, 10.0], seed=3, starts=7)
        for p, q in zip(a.points, b.points, strict=True):
            np.testing.assert_array_equal(p.profile, q.profile)
            assert p.upper_bound == q.upper_bound

    def test_without_certificates(self) -> None:
        out = tradeoff(SMALL, mu=[1.0], losses=(), certify=False)
        (point,) = out.points
        assert point.upper_bound is None and point.gap is None and point.certificate is None

    def test_progress(self) -> None:
        calls: list[tuple[int, int, str]] = []
        tradeoff(SMALL, mu=[1.0, 5.0], progress=lambda *call: calls.append(call))
        done, total, labels = zip(*calls, strict=True)
        assert list(done) == sorted(done)
        assert done[0] == 1
        assert set(total) == {done[-1]}
        assert labels[0] == "constant pitch"
        assert "loss 3 %" in labels

    def test_default_prices(self) -> None:
        reference = constant(SMALL)
        mu = default_mu(reference)
        assert mu.size == 20
        np.testing.assert_allclose(np.diff(np.log(mu)), np.log(mu[1] / mu[0]))
        costs = mu * reference.rms_weighted / reference.mean_torque
        np.testing.assert_allclose(costs[[0, -1]], [2.5e-3, 9.0])
        with pytest.raises(InputError, match="points: got 0"):
            default_mu(reference, 0)


class TestDesign:
    def test_one_price(self) -> None:
        point = design(TASK, mu=10.0)
        assert (point.kind, point.mu, point.status) == ("mu", 10.0, Status.CONVERGED)
        assert point.gap is not None and point.gap > -1e-9

    def test_more_starts_are_no_worse(self) -> None:
        values = [design(TASK, mu=10.0, starts=s, certify=False).objective for s in (1, 5, 9)]
        assert values[1] >= values[0] - 1.0
        assert values[2] >= values[1] - 1.0

    @pytest.mark.parametrize("loss", [0.005, 0.02, 0.2])
    def test_loss(self, best: Design, loss: float) -> None:
        point = design(TASK, max_power_loss=loss)
        assert point.status is Status.CONVERGED
        assert 1 - point.mean_torque / best.mean_torque <= loss + 2e-6
        assert point.target == loss

    @pytest.mark.parametrize("share", [0.5, 0.9, 0.97])
    def test_mean_torque(self, best: Design, share: float) -> None:
        want = share * best.mean_torque
        point = design(TASK, mean_torque=want)
        assert point.status is Status.CONVERGED
        assert point.mean_torque == pytest.approx(want, rel=1e-6)
        flat = constant_for_torque(TASK, want)
        assert point.rms_weighted < flat.rms_weighted
        assert point.rms_lower_bound is not None
        assert point.rms_lower_bound <= point.rms_weighted

    def test_constant(self) -> None:
        point = constant(TASK)
        pitch = np.linspace(-0.1, 0.25, 4001)
        rotor, _ = TASK.problem().curves.evaluate_constant(pitch)
        assert point.mean_torque == pytest.approx(rotor[:, 0].mean(axis=1).max(), rel=1e-7)
        assert np.ptp(point.profile) == 0

    def test_constant_for_torque(self) -> None:
        top = constant(TASK)
        point = constant_for_torque(TASK, 0.8 * top.mean_torque)
        assert point.mean_torque == pytest.approx(0.8 * top.mean_torque, rel=1e-9)
        assert point.profile[0] > top.profile[0]  # towards feather
        other = constant_for_torque(TASK, 0.9 * top.mean_torque, best=top, side="stall")
        assert other.mean_torque == pytest.approx(0.9 * top.mean_torque, rel=1e-9)
        assert other.profile[0] < top.profile[0]
        with pytest.raises(InfeasibleError, match=r"down to -5\.73 deg goes down to"):
            constant_for_torque(TASK, 0.8 * top.mean_torque, best=top, side="stall")

    def test_regression_a_held_torque_is_looked_for_on_both_sides(self) -> None:
        """Here the least RMS lies towards stall, the constant pitch compared with at feather."""
        task = load_case("biegel2011").task()
        loss = compared(task, max_power_loss=0.07, certify=False)
        held = compared(task, mean_torque=loss.design.mean_torque, certify=False)
        assert held.constant.profile[0] > loss.constant.profile[0] > held.design.profile.mean()
        assert held.design.mean_torque == pytest.approx(loss.design.mean_torque, rel=1e-6)
        assert held.design.rms_weighted <= loss.design.rms_weighted * (1 + 1e-4)

    @pytest.mark.parametrize("torque", [1e9, -1e9])
    def test_torque_out_of_reach(self, torque: float) -> None:
        with pytest.raises(InfeasibleError, match="mean torque: got"):
            design(SMALL, mean_torque=torque)

    def test_regression_torque_between_constant_and_power_maximum(self, best: Design) -> None:
        """What a profile reaches must not be refused because no constant pitch reaches it."""
        flat = constant(TASK).mean_torque
        want = 0.5 * (flat + best.mean_torque)
        assert flat < want < best.mean_torque
        point = design(TASK, mean_torque=want)
        assert point.mean_torque == pytest.approx(want, rel=1e-6)

    def test_a_blade_cap_relative_to_constant_pitch(self) -> None:
        task = replace(TASK, blade_cap=1.0)
        out = tradeoff(task, mu=[10.0, 50.0])
        cap = out.constant.loads.blade_rms
        assert all(p.loads.blade_rms <= cap * (1 + 1e-6) for p in out.points)
        free = tradeoff(TASK, mu=[10.0, 50.0])
        assert any(p.loads.blade_rms > cap * 1.01 for p in free.points)

    @pytest.mark.parametrize("goal", ["max_power_loss", "mean_torque"])
    def test_regression_rms_bound_with_a_travel_penalty(self, goal: str) -> None:
        """The bound is on the RMS alone; the penalty on travel must not be booked as RMS.

        With one segment per station the problem is convex and the bound has no room to hide.
        """
        table = rotor_curves(positions=6, knots=2)
        task = DesignTask(
            model=CurvesModel(table=table), positions=6, limits=wide_limits(), travel=3e5
        )
        value = {"max_power_loss": 0.05, "mean_torque": 0.9 * constant(task).mean_torque}[goal]
        point = design(task, **{goal: value})
        assert point.pitch_travel > 1e-3
        assert point.rms_lower_bound is not None
        assert point.rms_lower_bound <= point.rms_weighted * (1 + 1e-6)

    def test_weights_move_the_design(self) -> None:
        plain = design(SMALL, mu=20.0)
        heavy = design(replace(SMALL, weights=LoadWeights(thrust=90.0)), mu=20.0)
        assert heavy.rms["thrust"] < plain.rms["thrust"]

    def test_a_table_of_curves(self) -> None:
        table = rotor_curves(positions=3)
        task = DesignTask(model=CurvesModel(table=table), positions=3, limits=wide_limits())
        point = design(task, mu=5.0)
        assert point.between is None and point.rms_weighted_between is None
        assert point.status is Status.CONVERGED

    @pytest.mark.parametrize("blades", [1, 2])
    def test_other_rotors(self, blades: int) -> None:
        task = replace(SMALL, model=SmoothModel(blades=blades))
        point = design(task, mu=3.0)
        assert point.status is Status.CONVERGED
        assert point.profile.size == 3 * blades


@pytest.mark.parametrize("change", [{"limits": wide_limits(0.0)}, {"harmonics": 0}], ids=str)
class TestRegressionConstantPitchOnly:
    """A rate limit of zero is legal: every design is then a constant pitch."""

    def test_curve(self, change: dict[str, Any]) -> None:
        task = replace(SMALL, **change)
        out = tradeoff(task, mu=[0.1, 1.0, 10.0])
        assert all(np.ptp(p.profile) < 1e-12 for p in out.points)
        assert all(p.status.ok for p in out.points)
        for p in price_points(out):
            pitch = np.linspace(*task.mean_range, 501)
            objective = Objective.tradeoff(p.mu, task.weights)
            problem = task.problem()
            values = [problem.value(np.full(9, float(b)), objective) for b in pitch]
            assert p.objective >= max(values) - 1e-4 * abs(max(values))

    @pytest.mark.parametrize("goal", ["mu", "max_power_loss", "mean_torque"])
    def test_one(self, change: dict[str, Any], goal: str) -> None:
        task = replace(SMALL, **change)
        top = constant(task).mean_torque
        value = {"mu": 3.0, "max_power_loss": 0.03, "mean_torque": 0.9 * top}[goal]
        point = design(task, **{goal: value})
        assert point.status.ok
        assert np.ptp(point.profile) < 1e-12
        if goal == "max_power_loss":
            assert point.mean_torque >= 0.97 * power_max(task).mean_torque * (1 - 1e-6)
        if goal == "mean_torque":
            assert point.mean_torque == pytest.approx(0.9 * top, rel=1e-6)
            sides = [constant_for_torque(task, value, side=s) for s in ("feather", "stall")]
            best = min(side.rms_weighted for side in sides)
            assert point.rms_weighted == pytest.approx(best, rel=1e-6)


class TestRefusals:
    @pytest.mark.parametrize(
        ("arguments", "message"),
        [
            ({"mu": []}, "mu: got "),
            ({"mu": [np.nan]}, "mu: got "),
            ({"mu": [1.0, -1.0]}, "mu: got "),
            ({"losses": [0.0]}, "losses: got 0"),
            ({"losses": [0.03, 1.0]}, "losses: got 1"),
            ({"losses": [np.nan]}, "losses: got nan"),
            ({"starts": 0}, "starts: got 0"),
            ({"starts": 1.5}, "starts: got 1.5"),
            ({"anchors": 0}, "anchors: got 0"),
            ({"anchors": True}, "anchors: got True"),
        ],
    )
    def test_curve(self, arguments: dict[str, Any], message: str) -> None:
        with pytest.raises(InputError, match=message):
            tradeoff(SMALL, **({"mu": [1.0]} | arguments))

    @pytest.mark.parametrize(
        ("arguments", "message"),
        [
            ({}, "goal: got none"),
            ({"mu": 1.0, "mean_torque": 1e5}, "goal: got mu and mean_torque"),
            ({"mu": -1.0}, "mu: got -1"),
            ({"mu": np.nan}, "mu: got nan"),
            ({"max_power_loss": 0.0}, "max_power_loss: got 0"),
            ({"max_power_loss": 1.0}, "max_power_loss: got 1"),
            ({"max_power_loss": np.nan}, "max_power_loss: got nan"),
            ({"mean_torque": np.inf}, "mean_torque: got inf"),
            ({"mu": 1.0, "starts": 0}, "starts: got 0"),
        ],
    )
    def test_one(self, arguments: dict[str, Any], message: str) -> None:
        with pytest.raises(InputError, match=message):
            design(SMALL, **arguments)

    @pytest.mark.parametrize(
        "arguments",
        [{"mu": "abc"}, {"mu": [[1.0, 2.0]]}, {"losses": ["a"]}, {"losses": "3%"}, {"starts": "a"}],
        ids=str,
    )
    def test_regression_other_types_raise_the_own_error(self, arguments: dict[str, Any]) -> None:
        with pytest.raises(InputError, match=next(iter(arguments))):
            tradeoff(SMALL, **({"mu": [1.0]} | arguments))
