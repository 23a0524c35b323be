"""Errors of pitchopt.

Every message names the field, says what arrived, what is allowed and, where it is not
obvious, what to change. All are ``ValueError`` so that callers who know nothing of pitchopt
can still catch them.
"""

from __future__ import annotations

__all__ = ["ComputationError", "InfeasibleError", "InputError", "PitchoptError"]


class PitchoptError(ValueError):
    """Base of all errors that pitchopt raises on purpose."""


class InputError(PitchoptError):
    """Bad input: a value, a file or a combination of values that cannot be used."""


class InfeasibleError(PitchoptError):
    """The problem is well posed but no profile satisfies all its constraints."""


class ComputationError(PitchoptError):
    """A solver failed on a problem that should have an answer, after every fallback."""
