"""Proven distance from the global optimum: certificates and branch and bound."""

from __future__ import annotations

from pitchopt.design.proof.certificate import Certificate
from pitchopt.design.proof.record import Proof, check_proof
from pitchopt.design.proof.search import (
    FIRST_GAP,
    ProofSettings,
    ProvenBound,
    prove,
    prove_in_stages,
)

__all__ = [
    "FIRST_GAP",
    "Certificate",
    "Proof",
    "ProofSettings",
    "ProvenBound",
    "check_proof",
    "prove",
    "prove_in_stages",
]
