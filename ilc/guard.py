"""Guard: the best profile seen, and when to go back to it.

It looks at the weighted AC load once a rotation.  When that has grown `patience` rotations in
succession and is clearly above the best one, the best profile is to be taken back.
"""

from __future__ import annotations

import numpy as np

from ilc._checks import FloatArray, count

__all__ = ["Guard"]

_GROWTH = 1.02  # smaller changes from rotation to rotation are no growth
_EXCESS = 1.10  # nor is anything within ten percent of the best


class Guard:
    """Watches the AC load of successive rotations.

    Parameters
    ----------
    patience : int
        Rotations of growth in succession before the best profile is taken back.
    """

    def __init__(self, patience: int = 3) -> None:
        self.patience = count("patience", patience, at_least=1)
        self.forget()

    def forget(self) -> None:
        """Start afresh, as when the set-point changes."""
        self.best: FloatArray | None = None
        self.best_load = np.inf
        self._last = np.inf
        self._grown = 0

    def observe(self, load: float, profile: FloatArray) -> bool:
        """Take note of a rotation; true if its profile should be left for the best one.

        Parameters
        ----------
        load : float
            Weighted AC load of the rotation.
        profile : ndarray
            Profile that it belongs to.
        """
        self._grown = self._grown + 1 if load > _GROWTH * self._last else 0
        self._last = load
        if load < self.best_load:
            self.best, self.best_load = profile.copy(), load
        if self._grown >= self.patience and load > _EXCESS * self.best_load:
            self._grown = 0
            return True
        return False

    def returned(self, load: float) -> None:
        """The best profile is in use again, and this is its load now."""
        self.best_load = self._last = load

    def state(self) -> dict[str, FloatArray]:
        """All that :meth:`restore` needs."""
        best = np.empty(0) if self.best is None else self.best
        return {
            "best": best.copy(),
            "numbers": np.array([self.best_load, self._last, float(self._grown)]),
        }

    def restore(self, state: dict[str, FloatArray]) -> None:
        """Go on from :meth:`state`."""
        best = state["best"]
        self.best = best.copy() if best.size else None
        self.best_load, self._last = map(float, state["numbers"][:2])
        self._grown = int(state["numbers"][2])
