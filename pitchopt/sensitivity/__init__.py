"""Post-optimum sensitivity: what a change of a frozen parameter does to an optimal value."""

from __future__ import annotations

from pitchopt.sensitivity.estimate import Assumption, Contribution, Estimate, Thresholds
from pitchopt.sensitivity.model import Counts
from pitchopt.sensitivity.post_optimum import PostOptimum

__all__ = ["Assumption", "Contribution", "Counts", "Estimate", "PostOptimum", "Thresholds"]
