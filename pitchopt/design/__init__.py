"""Pitch design on BladeCurves: limits, convex programs, sequential convex programming, bounds."""

from __future__ import annotations

from pitchopt.design.certificate import lagrangian_bound
from pitchopt.design.flat_optimum import FlatOptimum, flat_optimum
from pitchopt.design.goals import compared, constant, default_mu, design, power_max, tradeoff
from pitchopt.design.limits import PitchLimits
from pitchopt.design.multipliers import Multipliers
from pitchopt.design.problem import DesignProblem, LoadWeights, Objective
from pitchopt.design.program import ConvexSubproblem
from pitchopt.design.proof import (
    Certificate,
    Proof,
    ProofSettings,
    ProvenBound,
    check_proof,
    prove,
    prove_in_stages,
)
from pitchopt.design.relaxation import Relaxation, relax
from pitchopt.design.results import Compared, Design, LocalSolution, Status, Tradeoff
from pitchopt.design.scp import ScpSettings, solve_local
from pitchopt.design.several import Several, WindResult, robust, schedule
from pitchopt.design.task import CurvesModel, DesignTask, PitchModel

__all__ = [
    "Certificate",
    "Compared",
    "ConvexSubproblem",
    "CurvesModel",
    "Design",
    "DesignProblem",
    "DesignTask",
    "FlatOptimum",
    "LoadWeights",
    "LocalSolution",
    "Multipliers",
    "Objective",
    "PitchLimits",
    "PitchModel",
    "Proof",
    "ProofSettings",
    "ProvenBound",
    "Relaxation",
    "ScpSettings",
    "Several",
    "Status",
    "Tradeoff",
    "WindResult",
    "check_proof",
    "compared",
    "constant",
    "default_mu",
    "design",
    "flat_optimum",
    "lagrangian_bound",
    "power_max",
    "prove",
    "prove_in_stages",
    "relax",
    "robust",
    "schedule",
    "solve_local",
    "tradeoff",
]
