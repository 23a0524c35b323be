"""Price of a loss: supported where it can be, least behind where it can't."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from pitchopt.design.price import supporting_price


def lead(torque: float, rms: float, others: np.ndarray, mu: float) -> float:
    """What the best of the others is ahead by at a price."""
    return float(np.max(others[:, 0] - torque - mu * (others[:, 1] - rms)))


def test_local_price_is_kept_where_it_supports() -> None:
    others = np.array([[110.0, 12.0], [80.0, 8.0]])
    assert supporting_price(100.0, 10.0, others, 7.0) == 7.0


def test_moves_inside_the_interval() -> None:
    others = np.array([[110.0, 12.0], [80.0, 8.0]])  # prices from 5 to 10
    for local in (1.0, 30.0):
        mu = supporting_price(100.0, 10.0, others, local)
        assert 5.0 <= mu <= 10.0
        assert lead(100.0, 10.0, others, mu) <= 0.0


def test_above_a_chord_it_falls_behind_least() -> None:
    others = np.array([[110.0, 11.0], [95.0, 8.0]])  # at least 10, at most 2.5
    mu = supporting_price(100.0, 10.0, others, 50.0)
    assert mu == pytest.approx(5.0, rel=1e-4)
    grid = np.linspace(0.5, 40.0, 4000)
    assert lead(100.0, 10.0, others, mu) <= min(lead(100.0, 10.0, others, m) for m in grid) + 1e-3


@pytest.mark.parametrize(
    ("others", "local", "want"),
    [
        (np.empty((0, 2)), 3.0, 3.0),
        (np.array([[110.0, 12.0]]), 3.0, 5.0),
        (np.array([[80.0, 8.0]]), 30.0, 10.0),
        (np.array([[100.0 + 1e-9, 10.0 + 1e-12]]), 3.0, 3.0),  # the design itself, with rounding
    ],
)
def test_one_sided_and_none(others: np.ndarray, local: float, want: float) -> None:
    assert supporting_price(100.0, 10.0, others, local) == pytest.approx(want)


@given(seed=st.integers(0, 10**6))
@settings(max_examples=80)
def test_no_price_of_a_grid_is_better(seed: int) -> None:
    rng = np.random.default_rng(seed)
    others = np.stack([rng.uniform(50, 150, 6), rng.uniform(5, 20, 6)], axis=1)
    # profiles that are better in both would make the design pointless: leave them out
    others = others[~((others[:, 0] >= 100) & (others[:, 1] <= 10))]
    others = others[~((others[:, 0] <= 100) & (others[:, 1] >= 10))]
    local = float(10.0 ** rng.uniform(-1, 2))
    mu = supporting_price(100.0, 10.0, others, local)
    if not others.size:
        assert mu == local
        return
    best = min(lead(100.0, 10.0, others, m) for m in np.geomspace(0.05, 500, 400))
    assert lead(100.0, 10.0, others, mu) <= max(best, 0.0) + 1e-3 * max(abs(best), 1.0)
