"""Tower of a wind turbine designed together with its controller."""

from __future__ import annotations

from pitchopt.studies.tower.cost import JOULES_PER_MWH, BladeDesign, CostModel
from pitchopt.studies.tower.design import INSIDE, Joints, TowerDesign, station_joints
from pitchopt.studies.tower.document import comparison_rows, tower_csv, tower_document
from pitchopt.studies.tower.economics import Economics
from pitchopt.studies.tower.energy import (
    YEAR,
    annual_energy,
    annual_energy_by_bins,
    mean_wind_at,
    positive_array,
)
from pitchopt.studies.tower.estimates import (
    CostMap,
    MassEstimates,
    cost_estimates,
    mass_estimates,
    station_damage,
)
from pitchopt.studies.tower.fatigue_loads import (
    BIN_WIDTH,
    MOMENT_BINS,
    FatigueLoads,
    JointDamage,
    Weld,
    section_modulus,
)
from pitchopt.studies.tower.frozen_loads import OptimalTower, Round, optimal_tower
from pitchopt.studies.tower.limits import TowerLimits
from pitchopt.studies.tower.load_sets import LoadSet, LoadSets
from pitchopt.studies.tower.load_settings import LoadSettings
from pitchopt.studies.tower.pictures import tower_pictures
from pitchopt.studies.tower.published import MEAN_DAMAGE_CHANGE, PUBLISHED
from pitchopt.studies.tower.results import CoDesign, ConfigurationResult, Effort
from pitchopt.studies.tower.sizing import Sizing, scaled_start, size_tower
from pitchopt.studies.tower.study import (
    CONFIGURATIONS,
    TowerStudy,
    TowerStudySettings,
    run_tower_study,
)
from pitchopt.studies.tower.towers import Towers

__all__ = [
    "BIN_WIDTH",
    "CONFIGURATIONS",
    "INSIDE",
    "JOULES_PER_MWH",
    "MEAN_DAMAGE_CHANGE",
    "MOMENT_BINS",
    "PUBLISHED",
    "YEAR",
    "BladeDesign",
    "CoDesign",
    "ConfigurationResult",
    "CostMap",
    "CostModel",
    "Economics",
    "Effort",
    "FatigueLoads",
    "JointDamage",
    "Joints",
    "LoadSet",
    "LoadSets",
    "LoadSettings",
    "MassEstimates",
    "OptimalTower",
    "Round",
    "Sizing",
    "TowerDesign",
    "TowerLimits",
    "TowerStudy",
    "TowerStudySettings",
    "Towers",
    "Weld",
    "annual_energy",
    "annual_energy_by_bins",
    "comparison_rows",
    "cost_estimates",
    "mass_estimates",
    "mean_wind_at",
    "optimal_tower",
    "positive_array",
    "run_tower_study",
    "scaled_start",
    "section_modulus",
    "size_tower",
    "station_damage",
    "station_joints",
    "tower_csv",
    "tower_document",
    "tower_pictures",
]
