"""A small trade-off that the tests of this folder share."""

from __future__ import annotations

import pytest

from pitchopt.cases import load_case
from pitchopt.design import tradeoff


@pytest.fixture(scope="session")
def small_case():
    return load_case("biegel2011").with_values({"limits.positions": 6, "aero.segments": 10})


@pytest.fixture(scope="session")
def small_tradeoff(small_case):
    return tradeoff(small_case.task(), mu=[1.0, 10.0], starts=2)
