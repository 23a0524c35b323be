"""Verdicts: what pays, costs, or does nothing, and where it stops."""

from __future__ import annotations

from types import SimpleNamespace

import pytest

from pitchopt.studies.comparison import LOADS, Comparison, ComparisonSettings, Entry, verdicts
from pitchopt.studies.comparison.measures import Cut, RunMeasures
from pitchopt.studies.comparison.verdict import WORTH, effect, sentences, wind_name


def _run(seed: int, loads: float, travel: float) -> RunMeasures:
    values = dict.fromkeys(LOADS, loads)
    return RunMeasures(
        seed=seed, power=1.0, power_std=0.0, generator_speed_std=0.0, rms=values,
        equivalent_load=values, travel=travel, rate_use=0.0, rate_peak=0.0,
    )  # fmt: skip


def _comparison(shares: dict[str, list[float]]) -> Comparison:
    """Feed-forward that leaves these shares of the loads, by wind."""
    entries = []
    for wind, left in shares.items():
        for method, values in (("collective", [1.0] * len(left)), ("feed-forward", left)):
            runs = tuple(_run(seed, v, 0.1) for seed, v in enumerate(values))
            entries.append(Entry(method=method, wind=wind, status="judged", runs=runs))
    settings = ComparisonSettings(turbulence=tuple(shares))
    return Comparison(
        ground=SimpleNamespace(wind_speed=15.0),
        settings=settings,
        winds=settings.winds(15.0),
        entries=tuple(entries),
        seconds=0.0,
    )


@pytest.mark.parametrize(
    ("mean", "half_width", "word"),
    [
        (0.5, None, "pays"),
        (0.03, 0.019, "pays"),
        (0.03, 0.021, "unclear"),
        (0.5 * WORTH, 0.4 * WORTH, "nothing"),
        (0.5 * WORTH, None, "nothing"),
        (-0.03, 0.019, "costs"),
        (-0.03, 0.021, "unclear"),
        (-0.5 * WORTH, 0.4 * WORTH, "nothing"),
        (0.0, 0.5, "unclear"),
    ],
)
def test_effects(mean, half_width, word):
    assert effect(Cut(mean=mean, half_width=half_width)) == word


def test_it_stops_paying_at_the_first_wind_that_does_not_pay_after_one_that_did():
    found = verdicts(_comparison({"B": [1.0, 1.001], "none": [0.3], "0.05": [0.8, 0.81]}))
    for one in found:
        assert list(one.cuts) == ["none", "0.05", "B"]
        assert list(one.effects.values()) == ["pays", "pays", "nothing"]
        assert one.stops_at == "B"


def test_sentences_say_it():
    lines = sentences(_comparison({"none": [0.3], "C": [1.049, 1.051]}))
    assert len(lines) == len(LOADS) + 1
    assert lines[0].startswith("blade out of plane: -70.0 % in steady wind, +5.0 ±")
    assert lines[0].endswith("costs by class C")
    assert "5.73 for 5.73 in steady wind" in lines[-1]


@pytest.mark.parametrize(
    ("shares", "ending"),
    [
        ({"none": [0.5], "C": [0.5, 0.5]}, "pays everywhere"),
        ({"none": [1.0], "C": [1.0, 1.0]}, "pays nowhere"),
        ({"none": [1.2], "C": [1.0, 1.0]}, "pays nowhere, costs in steady wind"),
        ({"none": [0.5]}, "pays"),
        (
            {"none": [0.5], "C": [1.0, 1.0], "B": [0.5, 0.5]},
            "stops paying by class C, pays again in class B",
        ),
        ({"none": [0.5], "C": [0.5]}, "lost in the scatter by class C"),
        ({"none": [1.0], "C": [0.5, 0.5]}, "pays from class C on"),
    ],
)
def test_endings(shares, ending):
    assert sentences(_comparison(shares))[0].endswith(f": {ending}")


def test_too_few_seeds_tell_nothing():
    lines = sentences(_comparison({"none": [0.3], "C": [0.9, 1.0]}))
    assert lines[0].endswith("lost in the scatter by class C")


def test_names_of_winds():
    assert [wind_name(w) for w in ("none", "A+", "0.05", ".1")] == [
        "steady wind",
        "class A+",
        "turbulence of 5 %",
        "turbulence of 10 %",
    ]
