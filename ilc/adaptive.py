"""AdaptiveLearner: a learner whose model follows the plant and whose steps keep the limits.

After each passage the local model (:mod:`ilc.local_model`) gives the loads and their slopes at the
profile in use, with the covariance of both.  The next profile is the one that promises least

    sum_i w_i J_i + HOLD w_1 |mean torque - set-point|,
    J_i^2 = mean over the positions of E[(y_i - mean y_i)^2].

Each J_i, and the last term alike, is replaced by the quadratic that touches it from above,
J^2 / (2 J_0) + J_0 / 2, and the program (:mod:`ilc.program`) is solved a few times with new J_0;
its limits are those of the actuators.  A deviation of mean torque costs more than any AC load that
it could save, so the set-point is held where limits admit it.  The covariance of the slopes enters
E[.] and so damps the step where slopes are not known: it is the regularisation, and it follows from
the noise.

How much uncertainty a step may accept is a trade: no step along what is uncertain, no progress.
It is charged with J_0 of at least `boldness` times the sum of all.  Boldness grows when a rotation
brought less load than any before and shrinks when it did not; after a surprise (a change of wind)
it starts again from a middle value, and it is the less, the less well slopes are known.  Within a
rotation the first passage is bold and those that follow settle what it disturbed.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from ilc._checks import FloatArray, array_of, count, number
from ilc.errors import LearningError
from ilc.layout import Layout
from ilc.learner import Learner, Samples, State, ac_load
from ilc.local_model import LocalModel
from ilc.program import Quadratic, StepProgram

__all__ = ["AdaptiveLearner", "harmonic_basis"]

HOLD = 2.0
"""Price of a deviation of mean torque, in weights of its RMS."""

_SIGNS = np.array([-1.0, -1.0, -1.0, -1.0, 1.0])  # means that are free, and the one that is held
_WELL_KNOWN = 0.1  # relative deviation of slopes up to which all boldness is allowed
_TOUCHES = 3  # programs solved for one step
_NO_ANSWER = 1e-9  # change of a load in the experiment, in units of its starting RMS
_LEAST_RMS = 5e-4  # in units of the starting RMS: below this a load counts as even
_BOLDEST, _MEEKEST = 100.0, 1e-3
_AFTER_SURPRISE = 0.3  # share of the boldest
_CALMER = 0.1  # share of boldness that a passage keeps of the one before it in a rotation
_LESS = 0.99  # a rotation below this share of the best so far was worth it
_GROW, _SHRINK = 1.3, 0.4
_SURPRISE = 225.0  # innovations of 15 times their expected size
_WORSE = 10.0  # and loads of ten times the best


def harmonic_basis(layout: Layout, harmonics: int) -> FloatArray:
    """Orthonormal columns for mean and harmonics 1P .. nP of every profile, (V, K)."""
    psi = layout.azimuth[: layout.stations]
    waves = [np.ones(psi.size)]
    for order in range(1, min(harmonics, (layout.stations - 1) // 2) + 1):
        waves += [np.cos(order * psi), np.sin(order * psi)]
    one = np.stack(waves, axis=1)
    one /= np.linalg.norm(one, axis=0)
    return np.asarray(np.kron(np.eye(layout.variables // layout.stations), one))


class AdaptiveLearner(Learner):
    """Learner with a tracked model and constrained steps.

    Parameters
    ----------
    harmonics : int, optional
        Restrict profiles to a mean and harmonics 1P .. nP, at least B // 2.
    reach : float
        Largest change of pitch at a station from one passage to the next [rad].
    **common
        See :class:`ilc.learner.Learner`.
    """

    def __init__(
        self,
        *,
        harmonics: int | None = None,
        reach: float = float(np.deg2rad(2.0)),
        **common: Any,
    ) -> None:
        super().__init__(**common)
        self.reach = number("reach", reach, above=0)
        self.harmonics = harmonics
        self._basis: FloatArray | None = None
        if harmonics is not None:
            least = self.layout.blades // 2
            self.harmonics = count("harmonics", harmonics, at_least=max(least, 1))
            self._basis = harmonic_basis(self.layout, self.harmonics)
            if np.abs(self._restricted(self._start) - self._start).max() > 1e-9:
                raise LearningError(f"start: holds harmonics above {self.harmonics}P")
        self.model = LocalModel(self.layout)
        self._program = StepProgram(self.layout, self.limits.step, self._basis)
        self._boldness = _BOLDEST
        self._best = np.inf
        self._rotation: list[float] = []

    # ---- learning ------------------------------------------------------------------------

    def _identify(self, pitch: FloatArray, loads: FloatArray) -> None:
        repeats = int(np.flatnonzero(self._offsets.any(axis=1))[0])
        self.model.identify(pitch, loads, repeats)
        if np.abs(self.model.slope).max() * self.amplitude < _NO_ANSWER:
            raise LearningError("experiment: the loads did not answer the pitch at any position")

    def _learn(self, samples: Samples) -> FloatArray:
        self.model.update(*samples)
        self._judge(samples.loads)
        to_come = (self.passages + 1 - self.experiment_passages) % self.layout.blades
        return self._step(self._boldness * _CALMER**to_come)

    def _judge(self, loads: FloatArray) -> None:
        """Set the boldness from the loads of the passage."""
        load = self._distance(loads)
        if self.model.surprise.max() > _SURPRISE and load > _WORSE * self._best:
            self._setpoint_changed()
        if np.isfinite(load):
            self._rotation.append(load)
        first = (self.passages - self.experiment_passages + 1) % self.layout.blades
        if first or not self._rotation:
            return
        least = min(self._rotation)
        self._rotation.clear()
        worth = least < _LESS * self._best
        bolder = self._boldness * (_GROW if worth else _SHRINK)
        self._boldness = min(max(bolder, _MEEKEST), _BOLDEST)
        self._best = min(self._best, least)

    def _distance(self, loads: FloatArray) -> float:
        """Weighted AC load and price of the mean torque's deviation, NaN if unknown."""
        load = ac_load(loads, self.weights)
        if np.isfinite(load) and self.weights[0] > 0:
            off = abs(float(np.nanmean(loads[0])) - self.setpoint)
            load += HOLD * float(self.weights[0]) * off
        return load

    def _setpoint_changed(self) -> None:
        """Start the search again, less boldly than at first."""
        self._boldness = _AFTER_SURPRISE * _BOLDEST
        self._best = np.inf
        self._rotation.clear()

    def _step(self, boldness: float) -> FloatArray:
        """The profile that promises the least loads, (V,)."""
        layout, model = self.layout, self.model
        index = layout.index
        low, high = self.limits.bounds(layout, self._now, self.passages + 1)
        low, high = (
            np.maximum(low, self._now - self.reach),
            np.minimum(high, self._now + self.reach),
        )
        moved = self._now[index] - model.at
        value = model.value + np.einsum("lpb,pb->lp", model.slope, moved)
        means = value.mean(axis=1)
        apart = value - means[:, None]
        off = means[0] - self.setpoint / model.scale[0]
        weights = self.weights * model.scale
        hold = HOLD * weights[0]
        covariance, slopes = model.covariance, model.slope
        mean_slope = slopes[0] / layout.tracked
        boldness = min(boldness, _BOLDEST * (_WELL_KNOWN / model.doubt()) ** 2)
        change = np.zeros((layout.tracked, layout.blades))
        flat = np.zeros(layout.variables)
        for _ in range(_TOUCHES):
            move = np.einsum("lpb,pb->lp", slopes, change)
            now = apart + move - move.mean(axis=1, keepdims=True)
            rms = np.sqrt((now**2 + covariance[..., 0, 0]).mean(axis=1) + _LEAST_RMS**2)
            price = weights / rms
            least = boldness * float(weights @ rms)
            charge = weights**2 / np.maximum(weights * rms, least)
            held = hold / float(np.hypot(off + move[0].mean(), _LEAST_RMS))
            blocks = np.einsum("l,lpb,lpc->pbc", price, slopes, slopes, optimize=True)
            blocks += np.einsum("l,lpbc->pbc", charge, covariance[..., 1:, 1:])
            slope = np.einsum("l,lpb,lp->pb", price, slopes, apart)
            slope += np.einsum("l,lpb->pb", charge, covariance[..., 1:, 0])
            slope += held * off * layout.tracked * mean_slope
            free = slopes * np.sqrt(price / layout.tracked)[:, None, None]
            kept = mean_slope * np.sqrt(held * layout.tracked)
            quadratic = Quadratic(blocks, np.concatenate([free, kept[None]]), _SIGNS, slope)
            flat = self._program.solve(quadratic, self._now, low, high)
            change = flat[index]
        return self._restricted(self._now + flat)

    def _restricted(self, profile: FloatArray) -> FloatArray:
        """The profile's part in the basis; with no basis the profile itself."""
        if self._basis is None:
            return profile
        return np.asarray(self._basis @ (self._basis.T @ profile))

    def _slow_down(self) -> None:
        self._boldness = max(self._boldness * _SHRINK, _MEEKEST)

    # ---- saving --------------------------------------------------------------------------

    def _settings(self) -> dict[str, Any]:
        return {"harmonics": self.harmonics, "reach": self.reach}

    def _arrays(self) -> State:
        return self.model.arrays() | {
            "search": np.array([self._boldness, self._best]),
            "rotation": np.array(self._rotation),
        }

    def _set_arrays(self, state: Mapping[str, np.ndarray]) -> None:
        self.model.set_arrays(state)
        search = array_of("search", state["search"], (2,), finite=False)
        self._boldness, self._best = map(float, search)
        self._rotation = [float(value) for value in state["rotation"]]
