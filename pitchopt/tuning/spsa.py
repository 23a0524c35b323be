"""Simultaneous perturbation stochastic approximation.

In unit coordinates u, with signs Delta_k of +1 or -1 at random,

    g_k = [C(u_k + c_k Delta_k) - C(u_k - c_k Delta_k)] / (2 c_k) Delta_k,
    u_(k+1) = P(u_k - a_k g_k),    a_k = a / (k + 1 + A)^0.602,    c_k = c / (k + 1)^0.101,

so two evaluations estimate a gradient of any number of parameters.  P projects into the bounds
less c_(k+1), so that perturbed points lie inside; periodic parameters wrap.

Source: Spall, Implementation of the simultaneous perturbation algorithm for stochastic
optimization, IEEE Trans. Aerospace and Electronic Systems 34 (1998) 817-823, with its rules: A is a
tenth of the iterations, c of the order of the noise, and a such that the first step is as long as
is wanted, here from the mean size of the components of several gradients at the start.  A limit on
the move of one iteration is added: with a_0 set from a flat start, a step on a steep slope could
cross the whole box.
"""

from __future__ import annotations

from typing import ClassVar

import numpy as np
from numpy.typing import ArrayLike

from pitchopt.checks import FloatArray, finite_number, whole_number
from pitchopt.errors import InputError
from pitchopt.tuning.space import Space
from pitchopt.tuning.tuner import Proposal, StagedTuner, Stages

__all__ = ["Spsa"]

_ALPHA, _GAMMA = 0.602, 0.101  # Spall: the smallest that his theory allows


class Spsa(StagedTuner):
    """Simultaneous perturbation stochastic approximation.

    Parameters
    ----------
    space : Space
    start : (d,) array_like, optional
        In the units of the space; the middle by default.  Moved inside by `perturbation`.
    iterations : int
        After the calibration.
    perturbation : float
        c, in unit coordinates.
    step : float, optional
        a.  By default such that the mean move of a parameter in the first iteration is `move`.
    move : float
        That first move, in unit coordinates.
    largest_move : float
        Of a parameter in one iteration.
    calibration : int
        Gradients at the start, the mean of which makes the first step.
    seed : int

    Notes
    -----
    Evaluations: the start, two in each of the gradients, and the last point; the two of a gradient
    may be evaluated in parallel, and the start and all of the calibration too.  Failed points and
    those that break constraints enter with their `merit`; where all failed the point stays.
    """

    name: ClassVar[str] = "spsa"

    def __init__(
        self,
        space: Space,
        *,
        start: ArrayLike | None = None,
        iterations: int = 50,
        perturbation: float = 0.05,
        step: float | None = None,
        move: float = 0.1,
        largest_move: float = 0.2,
        calibration: int = 3,
        seed: int = 0,
    ) -> None:
        super().__init__(space, seed=seed)
        self.iterations = whole_number("iterations", iterations, at_least=0)
        self.perturbation = finite_number("perturbation", perturbation, above=0.0)
        if self.perturbation >= 0.5:
            raise InputError(f"perturbation: got {self.perturbation:g}, expected less than 0.5")
        self.step = None if step is None else finite_number("step", step, above=0.0)
        self.move = finite_number("move", move, above=0.0, at_most=1.0)
        self.largest_move = finite_number("largest_move", largest_move, above=0.0, at_most=1.0)
        self.calibration = whole_number("calibration", calibration, at_least=1)
        u = np.full(len(space), 0.5) if start is None else space.to_unit(space.point(start))
        self._start = self._inside(u, self.perturbation)

    @property
    def start(self) -> FloatArray:
        """First point in the units of the space."""
        return self.space.from_unit(self._start)

    def settings(self) -> dict[str, object]:
        """Plain data that names the tuner."""
        return {
            "name": self.name,
            "seed": self.seed,
            "start": self.start.tolist(),
            "iterations": self.iterations,
            "perturbation": self.perturbation,
            "step": self.step,
            "move": self.move,
            "largest_move": self.largest_move,
            "calibration": self.calibration,
        }

    def _inside(self, u: FloatArray, margin: float) -> FloatArray:
        return np.where(self.space.periodic, np.mod(u, 1.0), np.clip(u, margin, 1.0 - margin))

    def _stages(self) -> Stages:
        u, step = self._start, self.step
        stability = 0.1 * self.iterations
        for k in range(self.iterations + 1):
            width = self.perturbation / (k + 1) ** _GAMMA
            pairs = self.calibration if k == 0 else 1
            rng = np.random.default_rng([self.seed, k])
            delta = rng.choice([-1.0, 1.0], size=(pairs, len(u)))
            ends = np.stack([u + width * delta, u - width * delta], axis=1).reshape(-1, len(u))
            points = [
                Proposal(x=self.space.from_unit(end), origin=f"pair {k}.{place // 2}")
                for place, end in enumerate(ends)
            ]
            if k == 0:
                points.insert(0, Proposal(x=self.start, origin="start"))
            told = (yield points)[-2 * pairs :]
            merits = self.merits(told).reshape(pairs, 2)
            if not np.all(np.isfinite(merits)):
                continue
            slopes = (merits[:, 0] - merits[:, 1]) / (2.0 * width)
            gradients = slopes[:, np.newaxis] * delta
            size = float(np.mean(np.abs(gradients)))
            gain = (k + 1 + stability) ** _ALPHA
            if step is None and size > 0.0:
                step = self.move * gain / size
            if step is not None:
                moves = step / gain * np.mean(gradients, axis=0)
                u = u - np.clip(moves, -self.largest_move, self.largest_move)
            u = self._inside(u, self.perturbation / (k + 2) ** _GAMMA)
        yield [Proposal(x=self.space.from_unit(u), origin="last")]
