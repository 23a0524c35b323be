"""Errors of the learners; all of them are ``ValueError``."""

from __future__ import annotations

__all__ = ["LearningError", "StateError"]


class LearningError(ValueError):
    """Bad input: a value, a shape or a combination that cannot be used."""


class StateError(LearningError):
    """A saved state that is damaged, or belongs to another run."""
