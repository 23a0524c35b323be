"""Error of windfield: one type, raised for every input that cannot be used."""

from __future__ import annotations

__all__ = ["WindFieldError"]


class WindFieldError(ValueError):
    """Bad input to a wind field: a value, a file or a point outside what the field knows."""
