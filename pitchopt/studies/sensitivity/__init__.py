"""Sensitivity estimates beside re-solved truth: quadratic programs and pitch designs."""

from __future__ import annotations

from pitchopt.studies.sensitivity.quadratic import (
    OptimumCurve,
    QuadraticProgram,
    active_set_program,
    coupling_programs,
    estimated_curve,
    linearity_programs,
)

__all__ = [
    "OptimumCurve",
    "QuadraticProgram",
    "active_set_program",
    "coupling_programs",
    "estimated_curve",
    "linearity_programs",
]
