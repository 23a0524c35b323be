"""Points that do not look at results: random, Latin hypercube, Sobol.

All are even in the unit coordinates of the space.  What comes as number i depends on the seed and
on i alone.  McKay, Beckman, Conover, Technometrics 21 (1979) 239-245; Sobol, USSR Comput. Math.
Math. Phys. 7 (1967) 86-112, scrambled as by Owen, J. Complexity 14 (1998) 466-489.
"""

from __future__ import annotations

from abc import abstractmethod
from functools import cached_property
from typing import TYPE_CHECKING, ClassVar

import numpy as np
from numpy.typing import ArrayLike

from pitchopt.checks import FloatArray, whole_number
from pitchopt.tuning.space import Space
from pitchopt.tuning.tuner import Proposal, Tuner

if TYPE_CHECKING:
    from scipy.stats import qmc

__all__ = ["LatinHypercube", "RandomSearch", "Sobol"]


class _Sampling(Tuner):
    """Tuner whose points are a sequence in the unit cube, after a start if there is one."""

    def __init__(self, space: Space, *, start: ArrayLike | None = None, seed: int = 0) -> None:
        super().__init__(space, seed=seed)
        self.start = None if start is None else space.point(start)

    def settings(self) -> dict[str, object]:
        """Plain data that names the tuner."""
        return {
            "name": self.name,
            "seed": self.seed,
            "start": None if self.start is None else self.start.tolist(),
        }

    def _propose(self) -> Proposal:
        if self.start is not None and self._asked == 0:
            return Proposal(x=self.start, origin="start")
        number = self._asked - (self.start is not None)
        return Proposal(x=self.space.from_unit(self._unit(number)), origin=f"sample {number}")

    @abstractmethod
    def _unit(self, number: int) -> FloatArray:
        """Point of the sequence in unit coordinates; numbers come in their order."""


class RandomSearch(_Sampling):
    """Independent points.

    Parameters
    ----------
    space : Space
    start : (d,) array_like, optional
        Evaluated first, in the units of the space.
    seed : int
    """

    name: ClassVar[str] = "random"

    def _unit(self, number: int) -> FloatArray:
        return np.random.default_rng([self.seed, number]).random(len(self.space))


class LatinHypercube(_Sampling):
    """Latin hypercubes, one after the other.

    Parameters
    ----------
    space : Space
    samples : int
        Points of one hypercube: each parameter has one in each of so many equal parts.
    start : (d,) array_like, optional
        Evaluated first, in the units of the space.
    seed : int
    """

    name: ClassVar[str] = "lhs"

    def __init__(
        self,
        space: Space,
        *,
        samples: int = 50,
        start: ArrayLike | None = None,
        seed: int = 0,
    ) -> None:
        super().__init__(space, start=start, seed=seed)
        self.samples = whole_number("samples", samples, at_least=1)
        self._cube = np.zeros((0, len(space)))

    def settings(self) -> dict[str, object]:
        """Plain data that names the tuner."""
        return super().settings() | {"samples": self.samples}

    def _unit(self, number: int) -> FloatArray:
        turn, place = divmod(number, self.samples)
        if place == 0:
            from scipy.stats import qmc

            rng = np.random.default_rng([self.seed, turn])
            self._cube = qmc.LatinHypercube(len(self.space), rng=rng).random(self.samples)
        return np.asarray(self._cube[place])


class Sobol(_Sampling):
    """Scrambled Sobol sequence; most even after a power of two.

    Parameters
    ----------
    space : Space
    start : (d,) array_like, optional
        Evaluated first, in the units of the space.
    seed : int
    """

    name: ClassVar[str] = "sobol"

    @cached_property
    def _engine(self) -> qmc.Sobol:
        from scipy.stats import qmc

        return qmc.Sobol(len(self.space), rng=np.random.default_rng(self.seed))

    def _unit(self, number: int) -> FloatArray:  # noqa: ARG002  the engine counts
        return np.asarray(self._engine.random(1)[0])
