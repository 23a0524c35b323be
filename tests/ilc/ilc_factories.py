"""Affine plants, and learners that suit them."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ilc import ActuatorLimits, FixedLearner, Layout, Learner

FloatArray = NDArray[np.float64]

SCALE = np.array([1.4e6, 3e5, 3e5, 8e4])
"""Size of torque, tilt, yaw [N m] and thrust [N] of a middling turbine."""
WEIGHTS = SCALE[0] / SCALE
WIDE = ActuatorLimits(lower=-10.0, upper=10.0, step=20.0)
"""Limits that never bind."""
EXACT = {"rtol": 0, "atol": 1e-11}
"""Tolerance of pitches near 0.1 rad after some hundred roundings."""
CLOSE = {"rtol": 0, "atol": 1e-7}
"""The same where each step is a program solved to a gap of 1e-9."""


def same_as(kind: type[Learner]) -> dict[str, float]:
    """Tolerance to which a learner's profiles may be compared."""
    return EXACT if kind is FixedLearner else CLOSE


class AffinePlant:
    """Loads y_0[q] + D[q] beta at every tracked position q of a layout.

    Torque and thrust answer the collective pitch, tilt and yaw the cyclic one, with differences
    from position to position.  `drift(number)`, if given, is added to all loads (4,).
    """

    def __init__(
        self, layout: Layout, offset: FloatArray, jacobian: FloatArray, *, drift: Any = None
    ) -> None:
        self.layout, self.offset, self.jacobian, self.drift = layout, offset, jacobian, drift
        assert offset.shape == (layout.tracked, 4)
        assert jacobian.shape == (layout.tracked, 4, layout.blades)

    @classmethod
    def random(
        cls,
        seed: int,
        *,
        blades: int = 3,
        positions: int = 8,
        separate: bool = False,
        spread: float = 0.1,
    ) -> AffinePlant:
        """A well-conditioned plant; `spread` is the relative scatter of its Jacobian."""
        random = np.random.default_rng(seed)
        layout = Layout(blades=blades, positions=positions, separate=separate)
        q, b = np.arange(layout.tracked)[:, None], np.arange(blades)
        psi = 2 * np.pi * (q / layout.stations + b / blades)
        rows = [-0.5 * np.ones(psi.shape), -2 * np.cos(psi), -2 * np.sin(psi), -np.ones(psi.shape)]
        jacobian = np.stack(rows, axis=1)
        jacobian += spread * random.standard_normal(jacobian.shape)
        turn = 2 * np.pi * np.arange(layout.tracked) / layout.tracked
        waves = np.array([np.cos(turn), np.sin(turn), np.cos(2 * turn), np.sin(2 * turn)])
        offset = np.array([1.0, 0.3, -0.2, 1.0]) + 0.05 * waves.T @ random.standard_normal((4, 4))
        return cls(layout, SCALE * offset, SCALE[:, None] * jacobian)

    @property
    def blades(self) -> int:
        return self.layout.blades

    @property
    def positions(self) -> int:
        return self.layout.positions

    def passage(self, profile: FloatArray, number: int) -> FloatArray:
        rows = self.layout.visit(number)[0]
        pitch = self.layout.values(profile)[self.layout.index[rows]]
        loads = self.offset[rows] + np.einsum("qlb,qb->ql", self.jacobian[rows], pitch)
        return (loads + (0 if self.drift is None else self.drift(number))).T


class Turncoat(AffinePlant):
    """A plant whose loads answer the pitch the other way round from some passage on."""

    def __init__(self, plant: AffinePlant, passage: int) -> None:
        super().__init__(plant.layout, plant.offset, plant.jacobian)
        self.other = AffinePlant(plant.layout, plant.offset, -plant.jacobian)
        self.turn = passage

    def passage(self, profile: np.ndarray, number: int) -> np.ndarray:
        if number >= self.turn:
            return self.other.passage(profile, number)
        return super().passage(profile, number)


def make_learner(plant: AffinePlant, kind: type[Learner] = FixedLearner, **changes: Any) -> Learner:
    """A learner for a plant, with limits that never bind unless they are given."""
    given: dict[str, Any] = {
        "layout": plant.layout,
        "limits": WIDE,
        "start": 0.0,
        "setpoint": float(SCALE[0]),
        "weights": WEIGHTS,
    }
    return kind(**(given | changes))


def turned(plant: AffinePlant, learner: Learner, passages: int) -> list[FloatArray]:
    """Let a learner learn; the profiles used, and last the next one."""
    profiles = [learner.profile]
    for _ in range(passages):
        learner.tell(plant.passage(learner.profile, learner.passages))
        profiles.append(learner.profile)
    return profiles
