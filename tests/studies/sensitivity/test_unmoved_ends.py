"""Ends of the range that a parameter does not move are not computed for its estimate."""

from __future__ import annotations

import numpy as np
import pytest

from pitchopt.cases import load_case
from pitchopt.design import compared
from pitchopt.studies.sensitivity import DesignPoint
from pitchopt.studies.sensitivity.design_states import States

DEGREE = np.pi / 180.0


@pytest.fixture(scope="module")
def narrow():
    """A design that the lower end of the range holds, the upper one nowhere."""
    case = load_case("biegel2011").with_values(
        {"limits.positions": 6, "aero.segments": 10, "limits.pitch_min": 1.0 * DEGREE}
    )
    task = case.task()
    found = compared(task, starts=1, certify=False, mu=3.0)
    return DesignPoint(case=case, task=task, found=found)


def test_only_the_end_that_moves_is_asked_for(narrow, monkeypatch):
    kkt = narrow.stationary
    assert np.any(kkt.lower)
    assert not np.any(kkt.upper)
    asked = []
    ends = DesignPoint.ends

    def counted(self, task):
        asked.append(task)
        return ends(self, task)

    monkeypatch.setattr(DesignPoint, "ends", counted)
    for name, all_ends, count in (("upper", False, 0), ("lower", False, 1), ("upper", True, 1)):
        states = States(narrow, name, all_ends=all_ends)
        states.at(states.reference + 0.5 * DEGREE)
        assert len(asked) == count, name
        asked.clear()
