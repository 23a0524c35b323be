"""Tasks by name: what they check, their documents, winds that no tuner saw, bounds."""

from __future__ import annotations

import csv
import io
import math

import numpy as np
import pytest

from pitchopt.errors import InputError
from pitchopt.studies.tuning import (
    PROBLEMS,
    comparison_document,
    evaluations_csv,
    fresh_gain,
    make_task,
    tune,
    tuned_document,
)

COARSE = {"duration": 60.0, "skip": 10.0, "box_points": 5, "box_interval": 0.25, "workers": 1}


@pytest.mark.slow
def test_names_have_tasks():
    for name in PROBLEMS:
        assert make_task(name, **COARSE).name == name
    with pytest.raises(InputError, match="did you mean torque-gain"):
        make_task("torque", **COARSE)


@pytest.mark.parametrize(
    ("name", "settings", "text"),
    [
        ("torque-gain", {"load": "blade"}, "load: .*expected it for speed-regulator alone"),
        ("speed-regulator", {"kappa": (0.1,)}, "kappa: .*expected it for minimum-pitch alone"),
        ("minimum-pitch", {"start": (0.1,)}, "start: .*expected none"),
        ("minimum-pitch", {"kappa": (0.1, 0.1)}, "kappa: .*each once"),
        ("torque-gain", {"start": (0.6, 0.7)}, "start"),
        ("speed-regulator", {"bounds": {"omega": (0.3, 0.3)}}, "bounds of omega: got 0.3 to 0.3"),
        ("speed-regulator", {"bounds": {"omega": (0.7, 1.0)}}, "start"),
        ("speed-regulator", {"bounds": {"gain": (0.1, 0.3)}}, "bounds: got 'gain'"),
        ("individual-pitch", {"bounds": {"offset_1p": (-1.0, 1.0)}}, "offset_1p"),
    ],
)
def test_settings_that_do_not_fit_are_named(name, settings, text):
    with pytest.raises(InputError, match=text):
        make_task(name, **COARSE, **settings)


def test_other_seeds_and_bounds_are_other_problems(regulator):
    before = regulator.reference.cost
    fresh = regulator.with_seeds((5, 6))
    assert fresh.seeds == (5, 6)
    assert fresh.reference.cost != before
    assert len(fresh.reference.replicates) == 2
    narrow = regulator.bounded({"omega": (0.2, 0.8)})
    np.testing.assert_allclose(narrow.space.lower, [0.2, 0.1])
    assert (regulator.seeds, regulator.space.lower[0]) == ((1,), 0.01)
    assert regulator.reference.cost == before
    assert narrow.reference.cost == before


def test_fresh_gain_is_that_of_the_same_winds(regulator):
    point = [0.3, 1.0]
    found = fresh_gain(regulator, point, 2)
    fresh = regulator.with_seeds((1001, 1002))
    assert found["fresh_start_cost"] == fresh.reference.cost
    assert found["fresh_best_cost"] == fresh(point).cost
    expected = 1.0 - found["fresh_best_cost"] / found["fresh_start_cost"]
    assert found["fresh_gain"] == pytest.approx(expected, abs=1e-12)
    assert fresh_gain(regulator, regulator.start.tolist(), 2)["fresh_gain"] == 0.0


def test_documents_say_what_was_evaluated(regulator):
    tuned = [tune(regulator, method, evaluations=5) for method in ("sobol", "nelder-mead")]
    documents = [tuned_document(one) for one in tuned]
    for one, document in zip(tuned, documents, strict=True):
        good = [e["cost"] for e in document["evaluations"] if e["status"] == "ok"]
        assert document["best"]["cost"] == min(good) == one.best.cost
        assert document["start"]["cost"] == regulator.reference.cost
        assert document["gain"] == pytest.approx(
            1.0 - document["best"]["cost"] / document["start"]["cost"]
        )
        assert [e["number"] for e in document["evaluations"]] == list(range(5))
        distinct = {tuple(e["x"]) for e in document["evaluations"]} | {tuple(regulator.start)}
        assert document["simulations"] == len(distinct) * regulator.simulations
        rows = list(csv.DictReader(io.StringIO(evaluations_csv(document))))
        for row, evaluation in zip(rows, document["evaluations"], strict=True):
            assert [float(row["omega"]), float(row["zeta"])] == evaluation["x"]
            cost = float(row["cost"]) if row["cost"] else math.nan
            assert cost == evaluation["cost"] or evaluation["cost"] is None
    table = comparison_document(documents)
    gains = [row["gain"] for row in table["comparison"]]
    assert gains == sorted(gains, reverse=True)
    assert table["simulations"] == sum(d["simulations"] for d in documents)
    assert {row["method"] for row in table["comparison"]} == {"sobol", "nelder-mead"}
