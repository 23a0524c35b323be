"""A small comparison in steady wind and in turbulence, made once."""

from __future__ import annotations

import math

import pytest

from pitchopt.cases import load_case
from pitchopt.studies.comparison import ComparisonSettings, compare
from windfield import BoxCache

SMALL = ComparisonSettings(
    turbulence=("C", "none"),
    methods=("feed-forward", "learned", "ipc-zoo", "feed-forward+ipc"),
    seeds=2,
    tuning_seeds=1,
    evaluations=4,
    rotations=8,
    averaged=4,
    duration=60.0,
    skip=30.0,
    pitch_lag=0.3,
)


@pytest.fixture(scope="package")
def case():
    return load_case("nrel-5mw").with_values(
        {"wind.speed": 15.0, "limits.positions": 8, "aero.segments": 12}
    )


@pytest.fixture(scope="package")
def folder(tmp_path_factory):
    return tmp_path_factory.mktemp("comparison")


@pytest.fixture(scope="package")
def result(case, folder):
    return compare(
        case, SMALL, workers=2, cache=BoxCache(folder / "boxes"), journals=folder / "journals"
    )


@pytest.fixture(scope="package")
def degree():
    return math.pi / 180.0
