"""Feasibility to first order, in units of the variables."""

import numpy as np
import pytest
from scipy import sparse

from pitchopt.sensitivity.elastic import unmet_linear
from pitchopt.sensitivity.rows import Block, Layout

LAYOUT = Layout(
    (
        Block(name="g", kind="inequality", rows=2, shape=(2,)),
        Block(name="h", kind="equality", rows=1),
    )
)


@pytest.mark.parametrize("scale", [np.ones(2), np.array([1e3, 1e-3])])
@pytest.mark.parametrize(
    ("entries", "feasible"),
    [
        ([-1.0, -1.0, 0.5], True),  # x1 + x2 has to fall by 0.5
        ([-1.0, -1.0, -1.5], True),  # to rise by 1.5, and each may by 1
        ([-1.0, -1.0, -2.5], False),  # to rise by 2.5
        ([1.0, 1.0, 2.0], True),  # to fall by 2, and each has to by 1
        ([1.0, 1.0, 1.5], False),  # to fall by 1.5
        ([-5.0, -5.0, 9.0], True),
    ],
)
def test_two_limits_and_a_sum(scale, entries, feasible):
    jacobian = sparse.csr_array(np.array([[1.0, 0.0], [0.0, 1.0], [1.0, 1.0]]) / scale)
    found = unmet_linear(LAYOUT, np.array(entries), jacobian, scale, 1e-6)
    assert (found.names == ()) is feasible
    assert found.note == "to first order"
    assert set(found.names) <= {"g[0]", "g[1]", "h"}


def test_row_that_nothing_moves():
    jacobian = sparse.csr_array(np.array([[0.0, 0.0], [0.0, 1.0], [1.0, 1.0]]))
    found = unmet_linear(LAYOUT, np.array([0.3, -1.0, 0.0]), jacobian, np.ones(2), 1e-6)
    assert found.names == ("g[0]",)
