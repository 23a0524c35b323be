"""Guard: the best profile seen, and when to go back to it.

It looks at the weighted AC load once a rotation.  When that has grown `patience` rotations in
succession and is above the best one by a tenth and by several times what it usually changes from
rotation to rotation, the best profile is to be taken back.  Noise alone makes that happen seldom.
A change of the wind makes them grow for whatever profile: if the best one turns out to be worse
than the one that was left for it, that one is to be gone on with.
"""

from __future__ import annotations

import numpy as np

from ilc._checks import FloatArray, array_of, count

__all__ = ["Guard"]

_EXCESS = 1.10  # loads within ten percent of the best are no reason to go back
_SCATTER = 4.0  # nor are differences of so many times the usual one between rotations
_MEMORY = 0.9  # weight of the past in that


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
        self.left: FloatArray | None = None
        self.left_load = np.inf
        self._last = np.inf
        self._grown = 0
        self._change = 0.0  # running mean of the change between rotations

    def observe(self, load: float, profile: FloatArray) -> bool:
        """Take note of a rotation; true if its profile should be left for the best one.

        Parameters
        ----------
        load : float
            Weighted AC load of the rotation.
        profile : ndarray
            Profile that it belongs to.
        """
        if np.isfinite(self._last):
            change = abs(load - self._last)
            self._change = _MEMORY * self._change + (1 - _MEMORY) * change
        self._grown = self._grown + 1 if load > self._last else 0
        self._last = load
        if load < self.best_load:
            self.best, self.best_load = profile.copy(), load
        most = max(_EXCESS * self.best_load, self.best_load + _SCATTER * self._change)
        if self._grown >= self.patience and load > most:
            self._grown = 0
            self.left, self.left_load = profile.copy(), load
            return True
        return False

    def returned(self, load: float) -> None:
        """The best profile is in use again, and this is its load now."""
        self.best_load = self._last = load

    def state(self) -> dict[str, FloatArray]:
        """All that :meth:`restore` needs."""
        numbers = [self.best_load, self.left_load, self._last, float(self._grown), self._change]
        profiles = {"best": self.best, "left": self.left}
        return {
            **{name: np.empty(0) if p is None else p.copy() for name, p in profiles.items()},
            "numbers": np.array(numbers),
        }

    def restore(self, state: dict[str, FloatArray], shape: tuple[int, ...]) -> None:
        """Go on from :meth:`state` with profiles of a shape."""
        best, left = (
            array_of(name, state[name], shape if np.size(state[name]) else (0,))
            for name in ("best", "left")
        )
        self.best, self.left = best if best.size else None, left if left.size else None
        self.best_load, self.left_load, self._last, grown, self._change = map(
            float, state["numbers"]
        )
        self._grown = int(grown)
