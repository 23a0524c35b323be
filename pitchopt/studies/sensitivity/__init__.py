"""Sensitivity estimates beside re-solved truth: quadratic programs and pitch designs."""

from __future__ import annotations

from pitchopt.studies.sensitivity.design import (
    DesignCurve,
    DesignRow,
    DesignSensitivity,
    design_curve,
    design_sensitivity,
)
from pitchopt.studies.sensitivity.design_document import (
    curve_records,
    sensitivity_csv,
    sensitivity_record,
)
from pitchopt.studies.sensitivity.design_point import PARAMETERS, DesignPoint
from pitchopt.studies.sensitivity.design_truth import Truth
from pitchopt.studies.sensitivity.quadratic import (
    OptimumCurve,
    QuadraticProgram,
    active_set_program,
    coupling_programs,
    estimated_curve,
    linearity_programs,
    quadratic_record,
)

__all__ = [
    "PARAMETERS",
    "DesignCurve",
    "DesignPoint",
    "DesignRow",
    "DesignSensitivity",
    "OptimumCurve",
    "QuadraticProgram",
    "Truth",
    "active_set_program",
    "coupling_programs",
    "curve_records",
    "design_curve",
    "design_sensitivity",
    "estimated_curve",
    "linearity_programs",
    "quadratic_record",
    "sensitivity_csv",
    "sensitivity_record",
]
