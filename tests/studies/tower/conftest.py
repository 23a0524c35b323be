"""Synthetic loads and the turbine that the tower's tests share."""

from __future__ import annotations

import sys
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

sys.path.insert(0, str(Path(__file__).parent))

from pitchopt.studies.tower.fatigue_loads import MOMENT_BINS, FatigueLoads, Weld
from pitchopt.turbines import Turbine, load_turbine


def _weibull_loads(
    base: float = 6.4e6, top: float = 1.2e6, *, stations: int = 19, weld: Weld | None = None
) -> FatigueLoads:
    """Moment ranges with an exponential distribution (Weibull's, exponent 1).

    Its scale [N m] falls linearly from base to top; 1e8 cycles; four axes, one with the most.
    """
    scale = np.linspace(base, top, stations)[:, None] * np.array([1.0, 0.8, 0.6, 0.8])
    edges = np.append(MOMENT_BINS * np.exp(-0.005), MOMENT_BINS[-1] * np.exp(0.005))
    cycles = 1e8 * -np.diff(np.exp(-edges / scale[..., None]), axis=2)
    return FatigueLoads(cycles=cycles, weld=Weld() if weld is None else weld)


@pytest.fixture(scope="session")
def turbine() -> Turbine:
    """IEA 3.4 MW."""
    return load_turbine("iea-3.4-130")


@pytest.fixture(scope="session")
def loads() -> FatigueLoads:
    """Loads at 19 stations."""
    return _weibull_loads()


@pytest.fixture(scope="session")
def weibull_loads() -> Callable[..., FatigueLoads]:
    """Makes loads: moments at base and top [N m], `stations`, `weld`."""
    return _weibull_loads
