"""Limits of a tower."""

from __future__ import annotations

import numpy as np
import pytest

from pitchopt.errors import InputError
from pitchopt.studies.tower.limits import TowerLimits
from pitchopt.turbines import Turbine


def _buckling_share(slenderness: float, yield_stress: float, quality: float) -> float:
    """Characteristic meridional buckling stress over f_y by EN 1993-1-6, D.1.2, C_x = 1."""
    radius = 0.5 * (slenderness - 1.0)  # of the middle surface over the wall
    critical = 0.605 * 210e9 / radius
    depth = np.sqrt(radius) / quality
    alpha = 0.62 / (1.0 + 1.91 * depth**1.44)
    lean = np.sqrt(yield_stress / critical)
    plastic = np.sqrt(alpha / (1.0 - 0.6))
    assert 0.2 < lean < plastic
    return float(1.0 - 0.6 * (lean - 0.2) / (plastic - 0.2))


def test_slenderness_keeps_three_quarters_of_the_yield_stress() -> None:
    assert _buckling_share(TowerLimits().slenderness, 355e6, 25.0) == pytest.approx(0.76, abs=0.005)


def test_defaults_are_close_to_the_reference_tower(turbine: Turbine) -> None:
    limits, tower = TowerLimits(), turbine.tower
    assert tower.thickness is not None
    assert 0.0 <= limits.largest_diameter - tower.diameter.max() <= 0.011
    assert tower.diameter[-1] == limits.top_diameter
    assert np.max(tower.diameter / tower.thickness) == pytest.approx(242.0, abs=0.5)
    ends = np.interp(np.linspace(0.0, 108.0, 11), tower.height, tower.diameter)
    assert np.min(ends[1:] / ends[:-1]) == pytest.approx(0.83, abs=0.01)
    # the walls of its ten cans, above the welds between them
    wall = tower.thickness[::2]
    step = np.maximum(wall[1:] / wall[:-1], wall[:-1] / wall[1:]).max()
    assert step == pytest.approx(1.20, abs=0.01)


def test_least_frequency(turbine: Turbine) -> None:
    once = turbine.rated_rotor_speed / (2.0 * np.pi)
    assert once == pytest.approx(0.1939, abs=1e-4)
    assert TowerLimits().least_frequency(turbine) == pytest.approx(once / 0.85)
    assert TowerLimits(frequency_margin=0.0).least_frequency(turbine) == pytest.approx(once)
    assert TowerLimits().configuration == "standard"
    soft = TowerLimits(frequency_margin=None)
    assert soft.least_frequency(turbine) is None
    assert soft.configuration == "soft-soft"


@pytest.mark.parametrize(
    ("change", "match"),
    [
        ({"frequency_margin": 1.0}, "frequency_margin"),
        ({"frequency_margin": -0.1}, "frequency_margin"),
        ({"largest_damage": 0.0}, "largest_damage"),
        ({"top_diameter": 6.0}, "top_diameter"),
        ({"least_wall": 0.2}, "least_wall"),
        ({"wall_step": 1.0}, "wall_step"),
        ({"taper": 1.0}, "taper"),
        ({"slenderness": float("inf")}, "slenderness"),
    ],
)
def test_bad_limits(change: dict[str, float], match: str) -> None:
    with pytest.raises(InputError, match=match):
        TowerLimits(**change)  # type: ignore[arg-type]
