"""``pitchopt sensitivity``, and the table that ``pitchopt design`` prints."""

from __future__ import annotations

import csv
import json

import pytest

SLOW = ("--pitch-rate-deg", "1.5", "--mu", "3", "--no-certify")


def names(folder):
    return sorted(path.name for path in folder.iterdir())


@pytest.fixture(scope="module")
def cheap():
    """Few starts, for re-solved designs that take a moment."""
    return ("--case", "biegel2011", "--positions", "6", "--segments", "10", "--starts", "1")


def test_help_names_problem_steps_and_files(run):
    done = run("sensitivity", "--help")
    assert done.status == 0
    for word in (
        "--problem",
        "--rate-step",
        "--range-step",
        "--shear-step",
        "--steps",
        "curves.png",
    ):
        assert word in done.out


def test_table_and_files(run, cheap, tmp_path):
    done = run("sensitivity", *cheap, *SLOW, "--out", "s")
    assert done.status == 0
    assert names(tmp_path / "s") == ["sensitivity.csv", "sensitivity.json", "sensitivity.png"]
    head = next(line for line in done.out.splitlines() if line.startswith("parameter"))
    assert head.split()[:4] == ["parameter", "now", "change", "order"]
    (rate,) = (line for line in done.out.splitlines() if line.startswith("pitch rate"))
    assert "1.5 deg/s" in rate
    assert "+1 deg/s" in rate
    assert "pitch rate at" in rate
    assert "not proven optima" in done.out
    document = json.loads((tmp_path / "s" / "sensitivity.json").read_text())
    with (tmp_path / "s" / "sensitivity.csv").open(newline="") as stream:
        table = list(csv.DictReader(stream))
    assert [row["parameter"] for row in table] == ["rate", "lower", "upper", "mu", "shear"]
    first = document["sensitivity"]["rows"][0]
    assert float(table[0]["first_order"]) == pytest.approx(first["first_order"])
    # first order of a limit's right-hand side overstates what a concave optimum gains
    assert first["first_order"] > first["resolved"] > 0.0


def test_one_json_document_and_nothing_else(run, cheap, tmp_path):
    done = run(
        "sensitivity", *cheap, *SLOW, "--rate-step", "0.5deg/s", "--range-step", "2", "--mu-step",
        "-20%", "--shear-step", "-0.05", "--json",
    )  # fmt: skip
    assert done.status == 0
    assert list(tmp_path.iterdir()) == []
    document = json.loads(done.out)
    assert document["problem"] == "design"
    assert document["curves"] == []
    assert {"case", "settings", "design", "constant", "power_max", "sensitivity"} <= set(document)
    result = document["sensitivity"]
    assert {"objective", "value", "largest_torque", "price", "held", "stationarity", "rows"} <= set(
        result
    )
    steps = {row["parameter"]: row["step_shown"] for row in result["rows"]}
    assert steps == pytest.approx(
        {"rate": 0.5, "lower": -2.0, "upper": 2.0, "mu": -0.6, "shear": -0.05}
    )
    for row in result["rows"]:
        assert row["resolved"] is not None
        assert row["error_high_order"] == pytest.approx(row["high_order"] - row["resolved"])
        assert set(row["assumptions"]) == {
            "A1 linearity", "A2 coupling", "A3 active set", "stationarity",
        }  # fmt: skip
    assert result["value"] == pytest.approx(document["design"]["objective"])


def test_steps_draw_curves(run, cheap, tmp_path):
    done = run("sensitivity", *cheap, *SLOW, "--steps", "1", "--out", "s")
    assert done.status == 0
    assert names(tmp_path / "s") == [
        "curves.csv", "curves.png", "sensitivity.csv", "sensitivity.json", "sensitivity.png",
    ]  # fmt: skip
    with (tmp_path / "s" / "curves.csv").open(newline="") as stream:
        table = list(csv.DictReader(stream))
    assert len(table) == 5 * 3
    rates = [row for row in table if row["parameter"] == "rate"]
    assert [float(row["step_shown"]) for row in rates] == pytest.approx([-1.0, 0.0, 1.0])
    assert float(rates[1]["resolved"]) == 0.0


def test_without_a_goal_it_is_the_design_for_three_per_cent(run, cheap):
    done = run("sensitivity", *cheap, "--no-certify", "--json")
    assert done.status == 0
    assert json.loads(done.out)["settings"]["search"]["max_power_loss"] == 0.03


def test_design_prints_the_estimates_as_well(run, cheap, tmp_path):
    done = run("design", *cheap, *SLOW, "--no-plots", "--out", "d")
    assert done.status == 0
    assert "what a change would buy" in done.out
    assert "from the multipliers" in done.out
    assert "re-solved" not in done.out
    document = json.loads((tmp_path / "d" / "design.json").read_text())
    rows = document["sensitivity"]["rows"]
    assert [row["parameter"] for row in rows] == ["rate", "lower", "upper", "mu", "shear"]
    assert all(row["resolved"] is None for row in rows)
    other = json.loads(run("sensitivity", *cheap, *SLOW, "--json").out)["sensitivity"]
    for ours, theirs in zip(rows, other["rows"], strict=True):
        assert ours["first_order"] == pytest.approx(theirs["first_order"], abs=1e-6)


def test_a_design_that_failed_has_no_estimates(run, monkeypatch, cheap):
    from dataclasses import replace

    import pitchopt.cli.design_command as module
    from pitchopt.design import Status

    solve = module.solve

    def stopped(case, options):
        solved = solve(case, options)
        return replace(solved, design=replace(solved.design, status=Status.ITERATION_LIMIT))

    monkeypatch.setattr(module, "solve", stopped)
    done = run("design", *cheap, *SLOW, "--json")
    assert done.status == 1
    result = json.loads(done.out)["sensitivity"]
    assert result["rows"] == []
    assert "expected a converged one" in result["message"]
    monkeypatch.setattr("pitchopt.cli.sensitivity_design.solve", stopped)
    done = run("sensitivity", *cheap, *SLOW, "--json")
    assert (done.status, done.out) == (1, "")
    assert "no multipliers to estimate from" in done.err


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("--mu", "3", "--loss-step", "1%"), "--loss-step: got a step without --max-power-loss"),
        (("--torque-step", "1%"), "--torque-step: got a step without --mean-torque"),
        (("--mu", "3", "--rate-step", "0"), "--rate-step: got '0', expected a number other than 0"),
        (("--mu", "3", "--rate-step", "fast"), "--rate-step: got 'fast'"),
        (("--mu", "3", "--rate-step", "5%"), "--rate-step: got '5%'"),
        (("--mu", "3", "--rate-step", "-20"), "change by -20 to -10 deg/s is not allowed"),
        (("--mu", "3", "--range-step", "-30"), "no constant pitch satisfies the range"),
        (("--mu", "3", "--shear-step", "5"), "shear exponent: a change by +5 to 5.2"),
        (("--mu", "3", "--mu-step", "-200%"), "price mu: a change by -6 to -3"),
        (("--max-power-loss", "3%", "--loss-step", "-4%"), "torque lost: a change by -4 to -1 %"),
        (("--max-power-loss", "1%", "--rate-step", "-10"), "no profile keeps the limits"),
        (("--mean-torque", "1.3e6", "--torque-step", "20%"), "the largest of any profile"),
        (("--mu", "3", "--mean-torque", "1e6"), "got --mu and --mean-torque"),
        (("--mu", "3", "--steps", "0"), "--steps"),
        (("--problem", "tower-of-babel"), "--problem"),
    ],
)
def test_bad_input_is_one_clear_line(run, cheap, arguments, message):
    done = run("sensitivity", *cheap, "--no-certify", *arguments, "--json")
    assert (done.status, done.out) == (2, "")
    assert message in done.err
    assert len(done.err.strip().splitlines()) == 1
    assert done.err.startswith("pitchopt")


def test_a_case_without_an_exponent_has_no_shear(run, cheap, tmp_path):
    path = tmp_path / "log.toml"
    path.write_text(
        'turbine = "biegel2011"\n[wind]\nshear = "log"\n[aero]\ninduction = "none"\nsegments = 10\n'
        '[limits]\npositions = 6\n[objective]\nweights = "unit"\nblade_cap = "none"\n'
    )
    options = ("--case", path, "--mu", "3", "--starts", "1", "--no-certify", "--json")
    done = run("sensitivity", *options)
    assert done.status == 0
    assert [r["parameter"] for r in json.loads(done.out)["sensitivity"]["rows"]][-1] == "mu"
    done = run("sensitivity", *options, "--shear-step", "0.1")
    assert done.status == 2
    assert "the case has a log law" in done.err
