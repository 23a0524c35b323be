"""Figures of the paper that the tower study stands beside.

Source: J. Iori, C. Bottasso, M. McWilliam, "A sensitivity-based estimation method for
investigating control co-design relevance", 2024: tables 1 to 3 and the text of section 5.
Masses in t, energies in GWh, costs in $/MWh, changes as shares.
"""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType

__all__ = ["MEAN_DAMAGE_CHANGE", "PUBLISHED", "TURBINE"]

TURBINE = "iea-3.4-130"
"""Whose tower they are of."""

MEAN_DAMAGE_CHANGE = -0.068
"""Of the mean damage, weight from 0 to 0.3; on which configuration's tower is not said."""

PUBLISHED: Mapping[str, Mapping[str, float]] = MappingProxyType(
    {
        "standard": MappingProxyType(
            {
                "cost_change_codesign": -0.0001,
                "cost_change_first_order": -0.0014,
                "cost_change_high_order": -0.0002,
                "height": 110.0,
                "height_codesign": 110.6,
                "weight_codesign": 0.019,
                "mass": 331.07,
                "mass_codesign": 334.08,
                "energy": 14.955,
                "energy_codesign": 14.977,
                "cost": 41.481,
                "cost_codesign": 41.477,
                "frequency_multiplier": 2.44,
                "sets_estimate": 11,
                "sets_codesign": 20,
                "iterations_codesign": 4,
                "time_estimate": 0.54,
            }
        ),
        "soft-soft": MappingProxyType(
            {
                "cost_change_codesign": -0.0053,
                "cost_change_first_order": -0.0212,
                "cost_change_high_order": -0.0045,
                "height": 110.0,
                "height_codesign": 111.6,
                "weight_codesign": 0.203,
                "mass": 311.33,
                "mass_codesign": 302.47,
                "energy": 14.955,
                "energy_codesign": 15.014,
                "cost": 41.235,
                "cost_codesign": 41.016,
                "sets_estimate": 12,
                "sets_codesign": 50,
                "iterations_codesign": 6,
                "time_estimate": 0.16,
            }
        ),
    }
)
