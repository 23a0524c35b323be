"""Sensors: what a learner is told of the loads, with the imperfections of measurement.

From the exact load y of sample k, counted through all passages, a learner gets

    quantised(y[k - delay] + noise),     noise ~ N(0, sigma^2) for every sample and load,

or NaN where a sample, or a whole passage, is lost; nothing is known before the first sample.  The
delay runs on from one passage to the next.  A learner that knows it (its `delay`) undoes it.

The same numbers are drawn whatever is switched on, so that the noise of a seed is the same with
and without the rest.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from typing import Any, Self

import numpy as np
from numpy.typing import ArrayLike

from ilc._checks import FloatArray, array_of, count, number
from ilc.errors import LearningError, StateError
from ilc.storage import check_settings

__all__ = ["Sensors"]


class Sensors:
    """Imperfect measurement of the four rotor loads.

    Parameters
    ----------
    noise : float or array (4,)
        Standard deviation sigma of torque, tilt, yaw [N m] and thrust [N].
    quantisation : float or array (4,)
        Step to whose multiples the loads are rounded [N m, N]; 0 for none.
    delay : int
        Samples by which the measurement lags, at most the m of a passage.
    dropout : float
        Probability of each sample of each load to be lost.
    passage_dropout : float
        Probability of each passage to be lost as a whole.
    seed : int
        Of the random numbers.

    Raises
    ------
    LearningError
        On values out of range.
    """

    def __init__(
        self,
        *,
        noise: ArrayLike = 0.0,
        quantisation: ArrayLike = 0.0,
        delay: int = 0,
        dropout: float = 0.0,
        passage_dropout: float = 0.0,
        seed: int = 0,
    ) -> None:
        self.noise = _for_loads("noise", noise)
        self.quantisation = _for_loads("quantisation", quantisation)
        self.delay = count("delay", delay)
        self.dropout = number("dropout", dropout, at_least=0, at_most=1)
        self.passage_dropout = number("passage_dropout", passage_dropout, at_least=0, at_most=1)
        self.seed = count("seed", seed)
        self._random = np.random.default_rng(self.seed)
        self._lagging = np.full((4, self.delay), np.nan)

    @classmethod
    def with_share(cls, share: ArrayLike, of: ArrayLike, **others: Any) -> Self:
        """Sensors whose noise is a share of given loads.

        Parameters
        ----------
        share : float or array (4,)
            Standard deviation as a share, 0.02 for 2 %.
        of : array (4,)
            RMS deviations of the loads, or their means; the sign does not matter [N m, N].
        **others
            The parameters of :class:`Sensors` other than `noise`.
        """
        return cls(noise=_for_loads("share", share) * np.abs(array_of("of", of, (4,))), **others)

    def read(self, exact: ArrayLike) -> FloatArray:
        """Measure the loads of the next passage.

        Parameters
        ----------
        exact : array (4, m)
            Torque, tilt, yaw [N m] and thrust [N].

        Returns
        -------
        ndarray (4, m)
            NaN where nothing was measured.

        Raises
        ------
        LearningError
            If the shape is another, or the passage shorter than the delay.
        """
        given = np.asarray(exact, dtype=np.float64)
        if given.ndim != 2 or len(given) != 4 or given.shape[1] < max(self.delay, 1):
            raise LearningError(
                f"exact: got shape {given.shape}, expected (4, m) with m at least "
                f"{max(self.delay, 1)}"
            )
        measured = given + self.noise[:, None] * self._random.standard_normal(given.shape)
        lost = self._random.random(given.shape) < self.dropout
        lost |= self._random.random() < self.passage_dropout
        steps = np.broadcast_to(self.quantisation[:, None], given.shape)
        rounded = steps > np.finfo(np.float64).eps * np.abs(measured)  # else too fine to show
        measured[rounded] = np.round(measured[rounded] / steps[rounded]) * steps[rounded]
        stream = np.concatenate([self._lagging, measured], axis=1)
        self._lagging = stream[:, given.shape[1] :].copy()
        return np.where(lost, np.nan, stream[:, : given.shape[1]])

    def settings(self) -> dict[str, Any]:
        """Everything that was set at construction, as plain data."""
        return {
            "noise": self.noise.tolist(),
            "quantisation": self.quantisation.tolist(),
            "delay": self.delay,
            "dropout": self.dropout,
            "passage_dropout": self.passage_dropout,
            "seed": self.seed,
        }

    def state(self) -> dict[str, np.ndarray]:
        """Settings, random numbers and samples under way; :meth:`restore` goes on from there."""
        return {
            "settings": np.array(json.dumps(self.settings())),
            "random": np.array(json.dumps(self._random.bit_generator.state)),
            "lagging": self._lagging.copy(),
        }

    def restore(self, state: Mapping[str, np.ndarray]) -> None:
        """Go on exactly from a state that :meth:`state` gave.

        Raises
        ------
        StateError
            If it is damaged, or that of sensors with other settings.
        """
        try:
            check_settings("sensors", state["settings"], self.settings())
            random = np.random.default_rng()
            random.bit_generator.state = json.loads(str(state["random"]))
            lagging = array_of("lagging", state["lagging"], self._lagging.shape, finite=False)
        except StateError:
            raise
        except (KeyError, ValueError, TypeError) as error:
            raise StateError(f"sensors: damaged state ({error})") from error
        self._random, self._lagging = random, lagging


def _for_loads(name: str, value: ArrayLike) -> FloatArray:
    """One number >= 0 a load, from one for all of them or four."""
    out = array_of(name, np.broadcast_to(value, (4,)) if np.ndim(value) == 0 else value, (4,))
    if np.any(out < 0):
        raise LearningError(f"{name}: got {out}, expected numbers of at least 0")
    return out
