"""Makes the factories of this folder importable, and lists the learners."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).parent))

from ilc import AdaptiveLearner, FixedLearner

LEARNERS = [pytest.param(FixedLearner, id="fixed"), pytest.param(AdaptiveLearner, id="adaptive")]
"""Learners for which the tests of every learner run."""


def pytest_generate_tests(metafunc: pytest.Metafunc) -> None:
    """Give every test that asks for `learner_type` all learners."""
    if "learner_type" in metafunc.fixturenames:
        metafunc.parametrize("learner_type", LEARNERS)
