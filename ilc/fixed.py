"""FixedLearner: learning with a gain that stays as it was estimated (Biegel et al., section VI).

At every rotor position the errors e of the four loads answer the pitch beta of the blades,

    e = W (y - y_mean) ~ e_0 + D (beta - beta_0),       W = diag(weights),

with the Jacobian D from a least-squares fit to the experiment's loads.  Minimising
|e + D d|^2 + nu |d|^2 over the change d gives the gain H = (D'D + nu I)^-1 D', and the pitch of the
next passage is

    beta <- beta - kappa H e.

The mean of torque is the set-point.  The means of tilt, yaw and thrust follow what is measured,
once a rotation: mean <- (1 - q) mean + q measured.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ilc._checks import FloatArray, array_of, number
from ilc.errors import LearningError
from ilc.layout import Layout
from ilc.learner import Learner, Samples, State

__all__ = ["AffineFit", "FixedLearner", "affine_fit", "filled", "gains"]

_SPREAD = 0.2  # least singular value of the pitches tried, in units of the largest move


class AffineFit(NamedTuple):
    """What the loads answer to pitch.

    Attributes
    ----------
    offset : ndarray (4, P)
        y_0; the mean where D is not known, NaN where nothing was measured.
    jacobian : ndarray (P, 4, B)
        D [load/rad]; zero where it is not known.
    known : ndarray (P, 4) of bool
        Where enough was measured to tell D.
    """

    offset: FloatArray
    jacobian: FloatArray
    known: NDArray[np.bool_]


def affine_fit(pitch: FloatArray, loads: FloatArray) -> AffineFit:
    """Least-squares fit of y ~ y_0 + D (beta - beta_0) at every rotor position.

    Parameters
    ----------
    pitch : ndarray (E, P, B)
        Pitches applied [rad]; beta_0 is the first.
    loads : ndarray (E, 4, P)
        Loads measured; NaN is left out.
    """
    count, positions, blades = pitch.shape
    offset = np.full((4, positions), np.nan)
    jacobian = np.zeros((positions, 4, blades))
    known = np.zeros((positions, 4), dtype=bool)
    for k in range(positions):
        moves = pitch[:, k] - pitch[0, k]
        regressors = np.hstack([np.ones((count, 1)), moves])
        size = np.nanmax(np.abs(moves)) if np.isfinite(moves).any() else 0.0
        for load in range(4):
            good = np.isfinite(loads[:, load, k]) & np.isfinite(moves).all(axis=1)
            if not good.any():
                continue
            fit, _, _, singular = np.linalg.lstsq(
                regressors[good], loads[good, load, k], rcond=None
            )
            known[k, load] = singular.size > blades and singular[-1] > _SPREAD * size
            offset[load, k] = fit[0] if known[k, load] else loads[good, load, k].mean()
            if known[k, load]:
                jacobian[k, load] = fit[1:]
    return AffineFit(offset=offset, jacobian=jacobian, known=known)


def filled(layout: Layout, fit: AffineFit) -> FloatArray:
    """Jacobian (P, 4, B) with what is not known taken from the nearest stations where it is.

    What a blade does to a load varies smoothly from station to station, so it is interpolated along
    each profile; zero for a load that is known nowhere.
    """
    chains = layout.variables // layout.stations
    at = np.arange(layout.stations)
    out = np.zeros(fit.jacobian.shape)
    for load in range(4):
        values, known = np.zeros(layout.variables), np.zeros(layout.variables, dtype=bool)
        values[layout.index] = fit.jacobian[:, load]
        known[layout.index] = fit.known[:, load, None]
        for row, good in zip(values.reshape(chains, -1), known.reshape(chains, -1), strict=True):
            if good.any():
                row[:] = np.interp(at, at[good], row[good], period=layout.stations)
        out[:, load] = values[layout.index]
    return out


def gains(jacobian: FloatArray, weights: FloatArray, damping: float) -> FloatArray:
    """H = (D'D + nu I)^-1 D' with weighted loads, at every position.

    Parameters
    ----------
    jacobian : ndarray (P, 4, B)
        Of the unweighted loads.
    weights : ndarray (4,)
    damping : float
        nu as a share of the mean eigenvalue of D'D.

    Returns
    -------
    ndarray (P, B, 4)
        Acts on weighted errors; zero at positions where no load answers.
    """
    weighted = jacobian * weights[:, None]
    squares = weighted.transpose(0, 2, 1) @ weighted
    size = np.trace(squares, axis1=1, axis2=2)[:, None, None] / squares.shape[1]
    rounding = 1e-12  # a Jacobian without full rank leaves the directions it lacks alone
    return np.asarray(
        np.linalg.pinv(squares + damping * size * np.eye(squares.shape[1]), rcond=rounding)
        @ weighted.transpose(0, 2, 1)
    )


class FixedLearner(Learner):
    """The paper's learner: a fixed gain at every rotor position.

    Parameters
    ----------
    learning_rate : float
        kappa, above 0 and at most 1.
    damping : float
        nu as a share of the mean eigenvalue of D'D at each position, so that it has no unit.
    smoothing : float
        q, weight of a rotation's measured means, above 0 and at most 1.
    **common
        See :class:`ilc.learner.Learner`.
    """

    def __init__(
        self,
        *,
        learning_rate: float = 0.3,
        damping: float = 0.0,
        smoothing: float = 0.5,
        **common: Any,
    ) -> None:
        super().__init__(**common)
        self.learning_rate = number("learning_rate", learning_rate, above=0, at_most=1)
        self.damping = number("damping", damping, at_least=0)
        self.smoothing = number("smoothing", smoothing, above=0, at_most=1)
        layout = self.layout
        self.jacobian = np.zeros((layout.tracked, 4, layout.blades))
        self.gain = np.zeros((layout.tracked, layout.blades, 4))
        self._means = np.zeros(4)
        self._measured: list[FloatArray] = []
        self._share = 1.0  # of the learning rate, halved when loads grew

    def _identify(self, pitch: FloatArray, loads: FloatArray) -> None:
        fit = affine_fit(pitch, loads)
        self.jacobian = filled(self.layout, fit)
        missing = int((~fit.known[:, self.weights > 0]).any(axis=1).sum())
        if missing:
            self._say(f"slopes at {missing} positions taken from their neighbours")
        if not np.any(self.jacobian):
            raise LearningError("experiment: the loads did not answer the pitch at any position")
        self.gain = gains(self.jacobian, self.weights, self.damping)
        seen = np.isfinite(fit.offset).any(axis=1)
        self._means[seen] = np.nanmean(fit.offset[seen], axis=1)

    def _learn(self, samples: Samples) -> FloatArray:
        means = self._means.copy()
        means[0] = self.setpoint
        errors = self.weights[:, None] * (samples.loads - means[:, None])
        errors[self.weights == 0] = 0.0  # whether it is measured or not
        change = (self.gain[samples.rows] @ errors.T[:, :, None])[:, :, 0]
        change[np.isnan(change).any(axis=1)] = 0.0  # where a load is missing the pitch is kept
        wish = self._now.copy()
        wish[self.layout.index[samples.rows]] -= self._share * self.learning_rate * change
        self._update_means(samples.loads)
        return wish

    def _update_means(self, loads: FloatArray) -> None:
        self._measured.append(loads)
        if (self.passages + 1 - self.experiment_passages) % self.layout.blades:
            return
        rotation = np.concatenate(self._measured, axis=1)
        self._measured.clear()
        seen = np.isfinite(rotation).any(axis=1)
        measured = np.nanmean(rotation[seen], axis=1)
        self._means[seen] += self.smoothing * (measured - self._means[seen])

    def _slow_down(self) -> None:
        self._share *= 0.5

    def _speed_up(self) -> None:
        self._share = min(1.0, 1.1 * self._share)

    def _setpoint_changed(self) -> None:
        self._share = 1.0

    def _settings(self) -> dict[str, Any]:
        return {
            "learning_rate": self.learning_rate,
            "damping": self.damping,
            "smoothing": self.smoothing,
        }

    def _arrays(self) -> State:
        measured = self._measured or [np.empty((4, 0))]
        return {
            "jacobian": self.jacobian.copy(),
            "gain": self.gain.copy(),
            "means": self._means.copy(),
            "measured": np.concatenate(measured, axis=1),
            "share": np.array(self._share),
        }

    def _set_arrays(self, state: Mapping[str, np.ndarray]) -> None:
        self.jacobian = array_of("jacobian", state["jacobian"], self.jacobian.shape)
        self.gain = array_of("gain", state["gain"], self.gain.shape)
        self._means = array_of("means", state["means"], (4,))
        parts = state["measured"].shape[1] // self.layout.positions
        shape = (4, parts * self.layout.positions)
        measured = array_of("measured", state["measured"], shape, finite=False)
        self._measured = np.split(measured, parts, axis=1) if parts else []
        self._share = number("share", float(state["share"]), above=0, at_most=1)
