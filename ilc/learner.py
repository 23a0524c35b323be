"""Learner: the part that all learners share.

    experiment  ->  model  ->  passage: loads -> wish -> limits -> profile  ->  passage ...

A learner proposes a profile; the loads of the passage made with it are told back.  The first
passages are the experiment.  What a learner makes of the loads is its own (`_identify`, `_learn`);
that the applied profile keeps the limits, that missing samples are left out and that the best
profile is taken back when loads grow is the same for all.
"""

from __future__ import annotations

import json
from abc import ABC, abstractmethod
from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from ilc._checks import FloatArray, IntArray, array_of, count, number
from ilc.errors import LearningError, StateError
from ilc.experiment import perturbations
from ilc.guard import Guard
from ilc.layout import Layout
from ilc.limits import ActuatorLimits
from ilc.storage import check_settings, part

__all__ = ["Learner", "Samples", "State", "ac_load"]

State = dict[str, np.ndarray]
"""What a learner knows, as arrays that one NPZ file holds."""

_OTHER = 0.05  # relative change of the set-point at once with which learning starts anew
_STALE = 0.01  # and change in all with which the best profile's load is no measure any more
_FAR_WORSE = 2.0  # on the way back to the best profile
_LEAST_SHARE = 0.5  # of the samples of a passage
_TOLERANCE = 1e-12  # [rad] of limits, in what is given from outside
_ABSURD = 1e30  # no load of any rotor; its square is still a number


class Samples(NamedTuple):
    """Loads of one passage, each with the tracked position and the pitch that it belongs to.

    Attributes
    ----------
    rows : ndarray (S,)
        Tracked positions.
    pitch : ndarray (S, B)
        Pitch of the blades [rad].
    loads : ndarray (4, S)
        NaN where nothing was measured.
    """

    rows: IntArray
    pitch: FloatArray
    loads: FloatArray


def ac_load(loads: FloatArray, weights: FloatArray) -> float:
    """Weighted sum of the RMS deviations of loads (4, S) from their means, NaN left out.

    NaN if a load that has a weight was measured at less than half of the samples: the deviation of
    a few samples is too small.
    """
    finite = np.isfinite(loads)
    if finite.all():
        apart = loads - loads.mean(axis=1, keepdims=True)
        return float(weights @ np.sqrt(np.einsum("ls,ls->l", apart, apart) / loads.shape[1]))
    weighed = weights > 0
    if finite[weighed].mean(axis=1).min() < _LEAST_SHARE:
        return float("nan")
    return float(weights[weighed] @ np.nanstd(loads[weighed], axis=1))


class Learner(ABC):
    """Base of the learners.

    Parameters
    ----------
    layout : Layout
        Blades, positions, and whether each blade has its own profile.
    limits : ActuatorLimits
    start : float or array
        Constant pitch or profile to start from [rad].
    setpoint : float
        Mean torque to hold [N m].
    weights : array (4,)
        Weights of torque, tilt, yaw and thrust.
    amplitude : float
        Size of the perturbations of the experiment [rad].
    delay : int
        Samples by which measurements lag, at most m.
    patience : int
        Rotations of growing AC load before the best profile is taken back.

    Raises
    ------
    LearningError
        On values out of range, or a start that breaks the limits.
    """

    def __init__(
        self,
        *,
        layout: Layout,
        limits: ActuatorLimits,
        start: float | ArrayLike,
        setpoint: float,
        weights: ArrayLike = (1.0, 1.0, 1.0, 1.0),
        amplitude: float = float(np.deg2rad(0.5)),
        delay: int = 0,
        patience: int = 3,
    ) -> None:
        self.layout = layout
        self.limits = limits
        self.weights = array_of("weights", weights, (4,))
        if np.any(self.weights < 0) or not np.any(self.weights > 0):
            raise LearningError(f"weights: got {self.weights}, expected numbers >= 0, one above 0")
        self.amplitude = number("amplitude", amplitude, above=0)
        self.delay = count("delay", delay)
        if self.delay > layout.positions:
            raise LearningError(
                f"delay: got {delay} samples, expected at most the {layout.positions} of a passage"
            )
        self._start = layout.values(start)
        excess = limits.violation(layout, self._start, self._start, 0)
        if excess > _TOLERANCE:
            raise LearningError(f"start: breaks the limits by {excess:.3g} rad")
        self._setpoint = number("setpoint", setpoint)
        self._guarded = self._setpoint  # the set-point that the guard's best load belongs to
        self._offsets = perturbations(layout, self.amplitude)
        self._now = self._start.copy()
        self._before = self._start.copy()
        self._pitch = np.full((len(self._offsets), layout.tracked, layout.blades), np.nan)
        self._seen = np.full((len(self._offsets), 4, layout.tracked), np.nan)
        self._guard = Guard(patience)
        self._holding = 0  # passages for which the best profile is still held
        self._rotation_loads: list[float] = []
        self.passages = 0
        self.events: list[tuple[int, str]] = []

    # ---- what users see ------------------------------------------------------------------

    @property
    def profile(self) -> FloatArray:
        """Pitch for the next passage [rad], (N,) or with separate profiles (B, N)."""
        return self.layout.profile(self._now)

    @property
    def experiment_passages(self) -> int:
        """Passages of the experiment, a whole number of rotations."""
        return len(self._offsets) * self.layout.dwell

    @property
    def learning(self) -> bool:
        """False during the experiment."""
        return self.passages >= self.experiment_passages

    @property
    def rotation(self) -> int:
        """Whole rotations made since the experiment; negative or 0 before its end."""
        return (self.passages - self.experiment_passages) // self.layout.blades

    @property
    def setpoint(self) -> float:
        """Mean torque to hold [N m]."""
        return self._setpoint

    @setpoint.setter
    def setpoint(self, value: float) -> None:
        value = number("setpoint", value)
        if abs(value - self._setpoint) > _OTHER * abs(self._setpoint):
            self._setpoint_changed()
        self._setpoint = value
        if abs(value - self._guarded) > _STALE * abs(self._guarded):
            self._guarded = value
            self._guard.forget()  # loads under the old set-point are no measure any more
            self._rotation_loads.clear()
            self._holding = 0

    def tell(self, loads: ArrayLike) -> None:
        """Take in the loads of the passage made with :attr:`profile`, and move on.

        Parameters
        ----------
        loads : array (4, m)
            Torque, tilt, yaw [N m] and thrust [N]; anything not finite, or of 1e30 and more,
            counts as missing.

        Raises
        ------
        LearningError
            If the shape is another.
        """
        layout = self.layout
        given = array_of("loads", loads, (4, layout.positions), finite=False)
        finite = np.abs(given) < _ABSURD
        enough = bool(finite.all())
        if not enough:
            given[~finite] = np.nan
            enough = bool(finite.mean() >= _LEAST_SHARE)
        samples = self._aligned(given)
        if not enough:
            self._say("too few samples: profile kept" if self.learning else "too few samples")
        wish = self._now
        if not self.learning:
            m = layout.positions
            slot = (self.passages * m - self.delay + np.arange(m)) // (m * layout.dwell)
            inside = slot >= 0
            self._pitch[slot[inside], samples.rows[inside]] = samples.pitch[inside]
            self._seen[slot[inside], :, samples.rows[inside]] = samples.loads.T[inside]
            following = self.passages + 1
            if following < self.experiment_passages:
                wish = self._start + self._offsets[following // layout.dwell]
            else:
                self._identify(self._pitch, self._seen)
                self._note_start()
                wish = self._start
        elif enough:
            wish = self._learn(samples)
        if self.learning:
            wish = self._watched(wish, samples)
        self.passages += 1
        applied = self.limits.projected(layout, wish, self._now, self.passages)
        self._before, self._now = self._now, applied

    # ---- what learners differ in ---------------------------------------------------------

    @abstractmethod
    def _identify(self, pitch: FloatArray, loads: FloatArray) -> None:
        """Make a model of the experiment's pitch (E, P, B) and loads (E, 4, P)."""

    @abstractmethod
    def _learn(self, samples: Samples) -> FloatArray:
        """The profile wished for the next passage, (V,)."""

    def _setpoint_changed(self) -> None:  # noqa: B027  nothing to do unless a learner says so
        """The set-point is quite another one now."""

    @abstractmethod
    def _slow_down(self) -> None:
        """Take smaller steps from now on: loads grew."""

    def _speed_up(self) -> None:  # noqa: B027  nothing to do unless a learner says so
        """Take back some of the caution: no rotation had less load."""

    @abstractmethod
    def _settings(self) -> dict[str, Any]:
        """Settings of this kind of learner, as plain data."""

    @abstractmethod
    def _arrays(self) -> State:
        """What this kind of learner knows."""

    @abstractmethod
    def _set_arrays(self, state: Mapping[str, np.ndarray]) -> None:
        """Go on from :meth:`_arrays`."""

    # ---- the shared parts ----------------------------------------------------------------

    def _say(self, text: str) -> None:
        self.events.append((self.passages, text))

    def _aligned(self, loads: FloatArray) -> Samples:
        """Samples with the positions and the pitches that they belong to, the delay undone."""
        layout, m, lag = self.layout, self.layout.positions, self.delay
        rows, index = layout.visit(self.passages)
        pitch = self._now[index]
        if lag:
            past, before = layout.visit(self.passages - 1)
            rows = np.concatenate([past[m - lag :], rows[: m - lag]])
            pitch = np.concatenate([self._before[before[m - lag :]], pitch[: m - lag]])
        return Samples(rows=rows, pitch=pitch, loads=loads)

    def _note_start(self) -> None:
        """Let the guard know the starting profile by the slots at rest."""
        rest = ~self._offsets.any(axis=1)
        loads = [ac_load(seen, self.weights) for seen in self._seen[rest]]
        known = [load for load in loads if np.isfinite(load)]
        if known:
            self._guard.observe(float(np.mean(known)), self._start)

    def _watched(self, wish: FloatArray, samples: Samples) -> FloatArray:
        """The wish, or the best profile seen if the AC load keeps growing."""
        load = ac_load(samples.loads, self.weights)
        if np.isfinite(load):
            self._rotation_loads.append(load)
        last = (self.passages + 1 - self.experiment_passages) % self.layout.blades == 0
        if self._holding:
            assert self._guard.best is not None  # it is what is held
            assert self._guard.left is not None
            self._holding -= 1
            wish = self._guard.best
            there = self._holding < self.layout.blades  # a rotation is enough to get there
            if load > self._guard.left_load * (1.0 if there else _FAR_WORSE):
                self._say("the best profile is worse now: on with the one that was left")
                wish = self._guard.left
                self._holding = 0
                self._guard.forget()
                self._rotation_loads.clear()
            elif not self._holding and self._rotation_loads:
                self._guard.returned(self._rotation_loads[-1])
                self._rotation_loads.clear()
        elif last and self._rotation_loads:
            mean = float(np.mean(self._rotation_loads))
            self._rotation_loads.clear()
            before = self._guard.best_load
            back = self._guard.observe(mean, self._now)
            if self._guard.best_load < before:
                self._speed_up()
            if back:
                assert self._guard.best is not None  # observe keeps one
                self._say(
                    f"AC load grew for {self._guard.patience} rotations: back to the best profile"
                )
                self._slow_down()
                self._holding = 2 * self.layout.blades
                wish = self._guard.best
        return wish

    # ---- saving and going on -------------------------------------------------------------

    def settings(self) -> dict[str, Any]:
        """Everything that was set at construction, as plain data."""
        return {
            "learner": type(self).__name__,
            "blades": self.layout.blades,
            "positions": self.layout.positions,
            "separate": self.layout.separate,
            "lower": self.limits.lower,
            "upper": self.limits.upper,
            "step": self.limits.step,
            "weights": self.weights.tolist(),
            "amplitude": self.amplitude,
            "delay": self.delay,
            "patience": self._guard.patience,
            **self._settings(),
        }

    def state(self) -> State:
        """All that the learner knows, as arrays; :meth:`restore` goes on exactly from there."""
        common = {
            "settings": np.array(json.dumps(self.settings())),
            "events": np.array(json.dumps(self.events)),
            "counts": np.array([self.passages, self._holding]),
            "setpoint": np.array([self._setpoint, self._guarded]),
            "start": self._start.copy(),
            "now": self._now.copy(),
            "before": self._before.copy(),
            "pitch": self._pitch.copy(),
            "seen": self._seen.copy(),
            "rotation_loads": np.array(self._rotation_loads),
        }
        parts = {f"guard.{name}": value for name, value in self._guard.state().items()}
        own = {f"model.{name}": value for name, value in self._arrays().items()}
        return common | parts | own

    def restore(self, state: Mapping[str, np.ndarray]) -> None:
        """Go on from a state that :meth:`state` gave.

        Raises
        ------
        StateError
            If something is missing, or the state is that of another learner or other settings.
        """
        try:
            check_settings("state", state["settings"], self.settings())
            events = [
                (int(passage), str(text)) for passage, text in json.loads(str(state["events"]))
            ]
            passages, holding = (int(value) for value in state["counts"])
            arrays = {
                name: array_of(name, state[name], getattr(self, "_" + name).shape, finite=finite)
                for names, finite in (
                    (("start", "now", "before"), True),
                    (("pitch", "seen"), False),
                )
                for name in names
            }
            excess = self.limits.violation(self.layout, arrays["now"], arrays["now"], passages)
            if excess > _TOLERANCE:
                raise StateError(f"state: damaged (its profile breaks the limits by {excess:.3g})")
            loads = [float(value) for value in state["rotation_loads"]]
            setpoint = array_of("setpoint", state["setpoint"], (2,))
            guard = part(state, "guard.")
            own = part(state, "model.")
        except StateError:
            raise
        except (KeyError, ValueError, TypeError) as error:
            raise StateError(f"state: damaged or not a learner's ({error})") from error
        try:
            self._guard.restore(guard, self._now.shape)
            self._set_arrays(own)
        except (KeyError, ValueError, IndexError, TypeError) as error:
            raise StateError(f"state: damaged ({error})") from error
        for name, value in arrays.items():
            setattr(self, "_" + name, value)
        if holding and (self._guard.best is None or self._guard.left is None):
            raise StateError("state: damaged (a profile is held that is not there)")
        self._setpoint, self._guarded = map(float, setpoint)
        self.passages, self._holding = passages, holding
        self._rotation_loads, self.events = loads, events
