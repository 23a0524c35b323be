"""Document, tables and pictures of a study; the paper's figures."""

from __future__ import annotations

import csv
import dataclasses
import io
import json
import math

import numpy as np
import pytest
from tower_factories import SETTINGS, ClosedSets

from pitchopt.cli.tower_tables import print_tower
from pitchopt.exports import document_text
from pitchopt.studies.tower import (
    MEAN_DAMAGE_CHANGE,
    PUBLISHED,
    TowerStudySettings,
    comparison_rows,
    run_tower_study,
    tower_csv,
    tower_document,
    tower_pictures,
)


@pytest.fixture(scope="module")
def study(turbine, weibull_loads):
    sets = ClosedSets(turbine, weibull_loads, coupling=0.3, lift=1.2)
    settings = TowerStudySettings(
        loads=SETTINGS, weights=(0.0, 0.03, 0.3), height_factors=(0.9, 1.0, 1.1), threshold=0.01
    )
    return run_tower_study(sets, settings)


@pytest.fixture(scope="module")
def document(study):
    """As a reader of the file has it; no number that JSON does not know."""
    return json.loads(document_text(tower_document(study)), parse_constant=pytest.fail)


def numbers(value):
    if isinstance(value, dict):
        value = list(value.values())
    if isinstance(value, list):
        for item in value:
            yield from numbers(item)
    elif isinstance(value, float):
        yield value


def test_document_is_finite(document):
    found = list(numbers(document))
    assert len(found) > 500
    assert all(map(math.isfinite, found))


def test_document_is_complete(study, document):
    assert list(document) == [
        "problem", "turbine", "settings", "reference_height", "configurations", "tables",
        "sets_simulated", "seconds",
    ]  # fmt: skip
    assert document["turbine"] == "iea-3.4-130"
    assert document["reference_height"] == 110.0
    assert document["settings"]["weights"] == [0.0, 0.03, 0.3]
    assert document["settings"]["loads"]["wind_speeds"] == [5.0, 9.0, 13.0]
    assert document["sets_simulated"] == study.sets_simulated > 10
    assert list(document["configurations"]) == ["standard", "soft-soft"]
    for name, part in document["configurations"].items():
        result = study.results[name]
        assert list(part) == [
            "reference", "estimates", "truth", "maps", "cost_change", "unsettled", "without",
            "codesign", "effort",
        ]  # fmt: skip
        reference = part["reference"]
        assert reference["mass"] == result.reference.mass
        assert len(reference["diameter"]) == 11
        assert len(reference["thickness"]) == 10
        assert np.shape(reference["frequencies_hz"]) == (2, 2)
        assert len(reference["multipliers"]["fatigue"]) == SETTINGS.stations
        assert len(reference["multipliers"]["frequency"]) == (2 if name == "standard" else 0)
        assert max(max(values) for values in reference["constraints"].values() if values) < 1e-5
        estimates = part["estimates"]
        np.testing.assert_array_equal(estimates["high_order"], result.estimates.high_order)
        np.testing.assert_array_equal(estimates["true"], result.true_change)
        assert np.shape(estimates["damage"]) == (3, SETTINGS.stations)
        np.testing.assert_allclose(
            estimates["mean_damage_change"],
            np.mean(np.array(estimates["damage"]) / estimates["damage"][0] - 1.0, axis=1),
        )
        assert [detail["weight"] for detail in estimates["details"]] == [0.03, 0.3]
        for k, detail in enumerate(estimates["details"]):
            assert detail["high_order"] == estimates["high_order"][k + 1]
            assert {a["verdict"] for a in detail["assumptions"]} <= {"holds", "broken", "unknown"}
        assert [tower["weight"] for tower in part["truth"]] == [0.0, 0.03, 0.3]
        for costs in part["maps"].values():
            for key in ("mass", "energy_gwh", "cost"):
                assert np.shape(costs[key]) == (3, 3)
        low = part["maps"]["true"]["lowest"]
        assert low["cost"] <= np.min(part["maps"]["true"]["cost"])
        for key in ("without", "codesign"):
            assert part[key]["cost"] == min(part[key]["costs"])
            assert len(part[key]["points"]) == len(part[key]["costs"])
        assert part["effort"]["codesign"]["sets"] == result.codesign_effort.sets


def test_rows_hold_our_figures(study):
    rows = {(row["configuration"], row["quantity"]): row for row in comparison_rows(study)}
    for name, part in study.results.items():
        found = part.with_codesign
        for words, value in (
            ("change of cost, co-design", part.cost_change["co-design"]),
            ("change of cost, high-order", part.cost_change["high-order"]),
            ("hub height, co-design", found.tower.hub_height),
            ("weight c, co-design", found.tower.tower_velocity),
            ("tower mass, without", part.without.tower.mass / 1e3),
            ("energy, co-design", found.energy / 3.6e12),
            ("cost of energy, co-design", found.cost),
            ("sets, high-order estimate", part.estimate_effort.sets),
            ("sets, co-design", part.codesign_effort.sets),
            ("time of the estimate over co-design's",
             part.estimate_effort.seconds / part.codesign_effort.seconds),
            ("change of mean damage at the largest c", part.estimates.damage_change[-1].mean()),
        ):  # fmt: skip
            assert rows[name, words]["ours"] == pytest.approx(value, rel=1e-12)
    multiplier = "multiplier of the first frequency"
    reference = study.results["standard"].reference
    assert rows["standard", multiplier]["ours"] == pytest.approx(
        reference.sizing.multipliers.frequency[0] / reference.mass
    )
    assert ("soft-soft", multiplier) not in rows


def test_every_figure_of_the_paper_stands_in_a_row(study):
    rows = comparison_rows(study)
    for name, figures in PUBLISHED.items():
        shown = [row["paper"] for row in rows if row["configuration"] == name]
        assert sorted(v for v in shown if v is not None) == sorted(
            [*figures.values(), MEAN_DAMAGE_CHANGE]
        )


def test_figures_of_the_paper_are_left_out_for_another_turbine(study):
    rows = comparison_rows(dataclasses.replace(study, turbine="nrel-5mw"))
    assert [row["paper"] for row in rows] == [None] * len(rows)
    assert [row["ours"] for row in rows] == [row["ours"] for row in comparison_rows(study)]


def test_what_did_not_converge_is_told(study, capsys):
    print_tower(json.loads(document_text(tower_document(study))))
    assert capsys.readouterr().out.count("all towers and searches converged") == 2
    part = study.results["standard"]
    assert part.unsettled == ()
    tower = dataclasses.replace(part.truth[2], converged=False)
    stopped = dataclasses.replace(
        part.with_codesign, search=dataclasses.replace(part.with_codesign.search, converged=False)
    )
    part = dataclasses.replace(part, unsettled=(tower,), with_codesign=stopped)
    other = dataclasses.replace(study, results={"standard": part})
    document = json.loads(document_text(tower_document(other)))
    print_tower(document)
    shown = capsys.readouterr().out
    assert shown.count("not converged\n") == 1
    assert "  tower at a hub height of 110 m with c = 0.3: sizes still change by 0." in shown
    count = len(part.with_codesign.search.values)
    assert f"  search of the lowest cost over height and c: stopped after {count} towers" in shown
    assert "at c = 0: stopped" not in shown


def test_lowest_cost_at_the_end_of_what_was_studied_is_told(study, capsys):
    document = json.loads(document_text(tower_document(study)))
    part = document["configurations"]["standard"]
    document["configurations"] = {"standard": part}
    for key, height, weight in (("without", 110.0, 0.0), ("codesign", 110.0, 0.1)):
        part[key]["tower"].update(hub_height=height, weight=weight)
    print_tower(document)
    assert "studied" not in capsys.readouterr().out
    part["without"]["tower"]["hub_height"] = part["maps"]["high_order"]["heights"][0]
    part["codesign"]["tower"].update(hub_height=121.0, weight=0.3)
    print_tower(document)
    shown = capsys.readouterr().out
    assert "lowest cost at c = 0: at the least hub height studied\n" in shown
    assert (
        "lowest cost over height and c: at the largest hub height and the largest c studied\n"
    ) in shown


def test_csv_is_the_rows(study):
    rows = comparison_rows(study)
    read = list(csv.DictReader(io.StringIO(tower_csv(study))))
    assert len(read) == len(rows)
    for line, row in zip(read, rows, strict=True):
        assert list(line) == ["table", "configuration", "quantity", "unit", "paper", "ours"]
        assert [line[key] for key in list(line)[:4]] == [str(row[key]) for key in list(line)[:4]]
        assert float(line["ours"]) == row["ours"]
        assert (line["paper"] == "") == (row["paper"] is None)
        if row["paper"] is not None:
            assert float(line["paper"]) == row["paper"]


def test_pictures(study):
    pictures = tower_pictures(study)
    assert list(pictures) == ["damage.png", "designs.png", "mass.png", "cost.png"]
    for draw in pictures.values():
        assert draw().startswith(b"\x89PNG")


PAPER = {  # tables 1 to 3 and the text: standard, soft-soft
    "cost_change_codesign": (-0.01e-2, -0.53e-2),
    "cost_change_first_order": (-0.14e-2, -2.12e-2),
    "cost_change_high_order": (-0.02e-2, -0.45e-2),
    "height": (110.0, 110.0),
    "height_codesign": (110.6, 111.6),
    "weight_codesign": (0.019, 0.203),
    "mass": (331.07, 311.33),
    "mass_codesign": (334.08, 302.47),
    "energy": (14.955, 14.955),
    "energy_codesign": (14.977, 15.014),
    "cost": (41.481, 41.235),
    "cost_codesign": (41.477, 41.016),
    "frequency_multiplier": (2.44, None),
    "sets_estimate": (11, 12),
    "sets_codesign": (20, 50),
    "iterations_codesign": (4, 6),
    "time_estimate": (0.54, 0.16),
}


def test_published_figures():
    assert list(PUBLISHED) == ["standard", "soft-soft"]
    for k, figures in enumerate(PUBLISHED.values()):
        expected = {key: pair[k] for key, pair in PAPER.items() if pair[k] is not None}
        assert dict(figures) == pytest.approx(expected)
    assert MEAN_DAMAGE_CHANGE == -0.068


def test_published_figures_agree_among_themselves():
    """Changes in per cent that the paper prints beside its figures, to their last digit."""
    for figures, mass, energy, height in (
        (PUBLISHED["standard"], 0.9, 0.1, 0.5),
        (PUBLISHED["soft-soft"], -2.8, 0.4, 1.5),
    ):
        for key, printed in (("mass", mass), ("energy", energy), ("height", height)):
            change = 100.0 * (figures[f"{key}_codesign"] / figures[key] - 1.0)
            assert change == pytest.approx(printed, abs=0.051)
        change = figures["cost_codesign"] / figures["cost"] - 1.0
        assert change == pytest.approx(figures["cost_change_codesign"], abs=5.1e-5)
    with pytest.raises(TypeError):
        PUBLISHED["standard"]["mass"] = 1.0  # type: ignore[index]
