"""Proven distance from the global optimum: certificates and branch and bound."""

from __future__ import annotations

from pitchopt.design.proof.certificate import Certificate
from pitchopt.design.proof.record import Proof, check_proof
from pitchopt.design.proof.search import ProofSettings, ProvenBound, prove

__all__ = ["Certificate", "Proof", "ProofSettings", "ProvenBound", "check_proof", "prove"]
