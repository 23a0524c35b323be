"""Estimates for pitch designs: what carries them, other winds and optima, documents, bad input."""

from __future__ import annotations

import csv
import io
import json
from dataclasses import replace

import numpy as np
import pytest

from pitchopt.cases import load_case
from pitchopt.design import compared
from pitchopt.design.scp import solve_local
from pitchopt.errors import InfeasibleError, InputError
from pitchopt.exports import document_text
from pitchopt.plotting import plot_design_curve, plot_design_sensitivity, sensitivity_figure
from pitchopt.studies.sensitivity import (
    DesignPoint,
    curve_records,
    design_curve,
    design_sensitivity,
    sensitivity_csv,
    sensitivity_record,
)
from pitchopt.studies.sensitivity.design import where
from pitchopt.studies.sensitivity.design_rows import DesignRows
from pitchopt.studies.sensitivity.design_truth import resolved

DEGREE = np.pi / 180.0
SMALL = {"limits.positions": 6, "aero.segments": 10}


def point(goal, case="biegel2011", **values):
    case = load_case(case).with_values(
        SMALL | {name.replace("__", "."): value for name, value in values.items()}
    )
    task = case.task()
    return DesignPoint(case=case, task=task, found=compared(task, starts=1, certify=False, **goal))


@pytest.fixture(scope="module")
def slow():
    """A design that a slow actuator holds back."""
    return point({"mu": 3.0}, limits__pitch_rate=1.5 * DEGREE)


@pytest.fixture(scope="module")
def loss():
    return point({"max_power_loss": 0.03})


def row(result, name):
    return next(r for r in result.rows if r.parameter == name)


# ---- estimates -----------------------------------------------------------------------------


def test_a_limit_on_the_right_hand_side_has_one_estimate(slow):
    result = design_sensitivity(slow)
    rate = row(result, "rate")
    assert rate.first == pytest.approx(rate.high, rel=1e-9)
    price = slow.stationary.rate_up + slow.stationary.rate_down
    stations = price.size
    per = rate.step * 2 * np.pi / (stations * slow.task.limits.rotor_speed)
    assert rate.first == pytest.approx(price.sum() * per)
    (group,) = rate.groups
    assert group.share == pytest.approx(price * per)


def test_the_price_is_an_envelope_and_the_truth_convex(slow):
    for step in (-0.5, 0.5):
        result = design_sensitivity(slow, {"mu": step})
        mu = row(result, "mu")
        assert mu.first == pytest.approx(-step * slow.design.rms_weighted)
        assert mu.high == pytest.approx(mu.first)
        truth = resolved(slow, slow.changed("mu", step), starts=0)
        assert truth.change >= mu.first - 1e-8 * slow.largest_torque


def test_groups_add_up_to_the_estimate(slow, loss):
    for found in (slow, loss):
        for r in design_sensitivity(found).rows:
            assert sum(g.first for g in r.groups) == pytest.approx(r.first, abs=1e-6)
            assert sum(g.high for g in r.groups) == pytest.approx(r.high, abs=1e-6)
            sizes = [max(abs(g.first), abs(g.high)) for g in r.groups]
            assert sizes == sorted(sizes, reverse=True)


def test_another_shear_leaves_the_lines_by_second_order_only(slow):
    """On moved curves, profiles on kinks would fall off them: an error of first order."""
    gaps = []
    for step in (0.02, 0.005):
        shear = row(design_sensitivity(slow, {"shear": step}), "shear")
        gaps.append(abs(shear.high - shear.first))
    assert gaps[0] / gaps[1] == pytest.approx(16.0, rel=0.1)


def test_frozen_lines_beat_moved_curves_on_kinks():
    """Full size, where torque kinks hold many stations."""
    found = point({"mu": 3.0}, limits__positions=24, aero__segments=40)
    assert found.stationary.at_kink.sum() >= 2
    step = -0.02
    shear = row(design_sensitivity(found, {"shear": step}), "shear")
    changed = found.changed("shear", step)
    problem = changed.task.problem()
    truth = solve_local(problem, changed.objective, found.design.profile).value
    truth -= found.stationary.value
    y, g = found.stationary.prices, found.stationary.torque_price
    moved = problem.curves.contributions(found.design.profile)
    moved -= found.problem.curves.contributions(found.design.profile)
    naive = g * moved[0].sum() / problem.curves.positions - float(np.sum(y * moved))
    assert abs(shear.high - truth) < 0.1 * abs(truth)
    assert abs(naive - truth) > 5 * abs(shear.high - truth)


def test_assumptions_are_judged_where_asked_for(slow):
    plain = row(design_sensitivity(slow), "rate").estimate
    judged = row(design_sensitivity(slow, judged=True), "rate").estimate
    assert plain.coupling.verdict == "not judged"
    assert judged.coupling.verdict == "holds"
    assert judged.stationarity.verdict == "holds"
    # a degree a second more moves the profile far enough for loads to bend
    assert judged.linearity.verdict == "broken"
    assert judged.first_order == pytest.approx(plain.first_order)


def test_gradients_of_the_rows_are_those_of_their_functions(slow):
    rows = DesignRows(slow, "shear", 0.01, judged=True)
    rng = np.random.default_rng(3)
    x = rows.at + np.concatenate(
        [1e-4 * rng.normal(size=rows.count), 10.0 * rng.normal(size=rows.at.size - rows.count)]
    )
    direction = np.concatenate(
        [1e-3 * rng.normal(size=rows.count), 50.0 * rng.normal(size=rows.at.size - rows.count)]
    )
    c, h = rows.reference, 1e-4
    f, g, eq = rows._gradients(rows.at, c)
    ahead, behind = rows._rows(x + h * direction, c), rows._rows(x - h * direction, c)
    numeric = (ahead - behind) / (2 * h)
    flat = np.concatenate([g, eq]) @ direction
    # all rows but the objective are linear in x
    assert numeric[1:] == pytest.approx(flat, rel=1e-6, abs=1e-6)
    near = rows._rows(rows.at + 1e-6 * direction, c)[0] - rows._rows(rows.at, c)[0]
    assert near / 1e-6 == pytest.approx(f @ direction, rel=1e-3, abs=1.0)


# ---- truth ---------------------------------------------------------------------------------


def test_truth_comes_from_the_best_start(slow):
    result = design_sensitivity(slow, {"rate": DEGREE}, truth=True, starts=1)
    rate = row(result, "rate")
    assert rate.truth is not None
    assert 0.0 < rate.truth.change <= rate.first * (1 + 1e-9)
    assert rate.errors == pytest.approx((rate.first - rate.truth.change,) * 2)
    assert not rate.truth.other
    assert rate.truth.missed == 0.0


def test_another_optimum_is_told_and_taken_off_where_it_is_no_gain_of_the_parameter():
    """A design that is a poor local optimum: solving anew finds the better one for any change."""
    found = point({"mu": 10.0})
    problem, objective = found.problem, found.objective
    poor = min(
        (
            solve_local(problem, objective, np.full(problem.curves.stations, pitch * DEGREE))
            for pitch in (-6.0, -3.0, 5.0, 8.0)
        ),
        key=lambda solution: solution.value,
    )
    behind = found.stationary.value - poor.value
    assert behind > 1e-4 * found.largest_torque
    weighted = found.task.weights.weighted(poor.loads)
    design = replace(
        found.design, profile=poor.profile, loads=poor.loads, rms_weighted=weighted,
        objective=poor.value,
    )  # fmt: skip
    start = DesignPoint(case=found.case, task=found.task, found=replace(found.found, design=design))
    truth = resolved(start, start.changed("rate", DEGREE), starts=5)
    assert truth.other
    assert truth.missed == pytest.approx(behind, rel=0.2)
    assert abs(truth.change) < 0.2 * behind


def test_a_change_that_leaves_no_profile():
    found = point({"max_power_loss": 0.01})
    with pytest.raises(InfeasibleError, match="no profile keeps the limits"):
        resolved(found, found.changed("rate", -found.value("rate")), starts=1)
    with pytest.raises(InputError, match="pitch rate: no profile keeps the limits"):
        design_sensitivity(found, {"rate": -found.value("rate")}, truth=True, starts=1)


def test_curves_over_a_range(slow):
    curve = design_curve(slow, "rate", DEGREE, 2, starts=1)
    assert curve.dc == pytest.approx(DEGREE * np.array([-2, -1, 0, 1, 2]))
    # 1.5 deg/s less 2 is no rate
    assert np.isnan(curve.truth[0])
    assert np.isnan(curve.first_order[0])
    assert curve.truth[2] == curve.first_order[2] == 0.0
    assert np.all(np.diff(curve.truth[1:]) >= 0.0)
    assert np.all(curve.first_order[1:] >= curve.truth[1:] - 1e-9 * slow.largest_torque)


# ---- what a design has ---------------------------------------------------------------------


def test_parameters_follow_from_goal_and_case(slow, loss):
    assert slow.parameters == ("rate", "lower", "upper", "mu", "shear")
    assert loss.parameters == ("rate", "lower", "upper", "loss", "shear")
    assert point({"mean_torque": 1.3e6}).parameters[3] == "torque"
    assert "shear" not in point({"mu": 3.0}, wind__shear="log").parameters


def test_a_table_of_curves_has_no_shear(tmp_path):
    case = load_case("biegel2011").with_values(SMALL)
    path = case.model().curves(6).save(tmp_path / "curves.npz")
    found = point({"mu": 3.0}, curves=path, limits__pitch_rate=1.5 * DEGREE)
    assert "shear" not in found.parameters
    plain = point({"mu": 3.0}, limits__pitch_rate=1.5 * DEGREE)
    ours, theirs = (row(design_sensitivity(p), "rate").first for p in (found, plain))
    assert ours == pytest.approx(theirs, rel=1e-4)
    with pytest.raises(InputError, match="a table of curves, whose wind is in it"):
        design_sensitivity(found, {"shear": 0.1})


@pytest.mark.parametrize(
    ("steps", "message"),
    [
        ({"loss": 0.01}, "the design has no such parameter, the goal of the design is mu"),
        ({"weight": 1.0}, "parameter: got 'weight', expected one of rate"),
        ({"rate": 0.0}, "step of the pitch rate: got 0, expected a change of more than"),
        ({"rate": 1e-12}, "a millionth of 1.5 deg/s"),
        ({"rate": float("nan")}, "step of the pitch rate"),
        ({"rate": -1.0}, "pitch rate: a change by -57.2958 to -55.7958 deg/s is not allowed"),
        ({"lower": 1.0}, "lower end of range"),
        ({"upper": -1.0}, "upper end of range"),
        ({"shear": 3.0}, "shear exponent: a change by \\+3 to 3.2 is not allowed"),
        ({"mu": -5.0}, "price mu: a change by -5 to -2 is not allowed"),
    ],
)
def test_steps_that_are_not_allowed(slow, steps, message):
    with pytest.raises(InputError, match=message):
        design_sensitivity(slow, steps, truth=True, starts=1)


def test_limits_on_torque_stay_where_they_are(loss):
    changed = loss.changed("shear", 0.02)
    assert changed.objective.torque_min == loss.objective.torque_min
    with pytest.raises(InputError, match="expected a share"):
        loss.changed("loss", -0.1)
    held = point({"mean_torque": 1.3e6})
    with pytest.raises(InfeasibleError, match="the largest of any profile"):
        held.changed("torque", 3e5)
    with pytest.raises(InputError, match="the largest of any profile"):
        design_sensitivity(held, {"torque": 3e5})


def test_held_flow_is_for_curves_of_held_flow():
    rotor = load_case("biegel2011").with_values({"aero.induction": "equilibrium"}).model()
    with pytest.raises(InputError, match="expected none or frozen"):
        rotor.fixed_inflow(6)
    rotor = load_case("biegel2011").with_values(SMALL).model()
    curves, inflow = rotor.curves(6), rotor.fixed_inflow(6)
    pitch = np.full(curves.stations, 0.02)
    assert inflow.loads(pitch)[0] == pytest.approx(curves.contributions(pitch)[0])


# ---- documents and pictures ----------------------------------------------------------------


def test_runs_of_azimuth():
    azimuth = np.radians(np.arange(0.0, 360.0, 30.0))
    share = np.zeros(12)
    share[[11, 0, 1, 5]] = 1.0, 2.0, 1.0, 9.0
    assert np.degrees(where(share, azimuth)) == pytest.approx(np.array([[150, 150], [330, 30]]))
    assert where(np.zeros(12), azimuth) == []
    assert np.degrees(where(np.ones(12), azimuth)) == pytest.approx(np.array([[0, 330]]))


def test_documents(slow):
    held = point({"max_power_loss": 0.01}, limits__pitch_rate=1.5 * DEGREE)
    result = design_sensitivity(slow, {"rate": DEGREE}, truth=True, starts=1)
    record = json.loads(document_text(sensitivity_record(result)))
    assert record["objective"] == "mean torque - mu x weighted RMS"
    assert record["stationarity"]["residual"] < 1e-6
    rate = record["rows"][0]
    assert (rate["unit"], rate["value_shown"], rate["step_shown"]) == (
        "deg/s", pytest.approx(1.5), pytest.approx(1.0),
    )  # fmt: skip
    assert rate["error_first_order"] == pytest.approx(rate["first_order"] - rate["resolved"])
    assert rate["relative_error_first_order"] == pytest.approx(
        rate["error_first_order"] / rate["resolved"]
    )
    assert rate["carried_by"][0]["name"] == "pitch rate"
    assert rate["carried_by"][0]["azimuth_deg"]
    table = list(csv.DictReader(io.StringIO(sensitivity_csv(record))))
    assert [r["parameter"] for r in table] == list(slow.parameters)
    assert float(table[0]["resolved"]) == pytest.approx(rate["resolved"])
    other = sensitivity_record(design_sensitivity(held))
    assert other["objective"] == "- weighted RMS"
    assert "a mean torque of" in other["held"]
    floor = next(r for r in other["rows"] if r["parameter"] == "loss")
    # worth in torque: what the multiplier says is the torque that is given up
    assert floor["share_of_torque"] == pytest.approx(0.005, rel=1e-3)
    assert floor["share_of_rms"] == pytest.approx(floor["high_order"] / held.design.rms_weighted)


def test_pictures(slow):
    from matplotlib.figure import Figure

    result = design_sensitivity(slow, truth=True, starts=1)
    record = sensitivity_record(result)
    ax = plot_design_sensitivity(record, ax=Figure().add_subplot())
    assert len(ax.patches) == 3 * len(record["rows"])
    records = curve_records([design_curve(slow, "rate", DEGREE, 1, starts=1)])
    ax = plot_design_curve(records, ax=Figure().add_subplot())
    assert ax.get_xlabel() == "change of rate [deg/s]"
    figure = sensitivity_figure(record, records, title="both")
    assert len([a for a in figure.axes if a.lines]) == 1
    assert sensitivity_figure(record).axes[0].get_xlabel().endswith("N m]")
