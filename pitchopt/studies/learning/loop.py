"""Loop: how fast the paper's learner converges on a plant, by its own Jacobian and the plant's.

    d <- (I - kappa H W D) d        for the distance d of the pitch from its fixed point,

with the gain H that the learner made of the experiment, and D estimated there or that of the
plant at the last profile (:mod:`ilc.analysis`).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ilc import FixedLearner, Layout, Learner, Record
from ilc.analysis import contraction
from pitchopt.checks import FloatArray
from pitchopt.studies.learning.plant import StaticPlant

__all__ = ["Loop", "loop_of"]

_PROBE = 1e-5  # [rad] by which pitch is moved for the plant's own Jacobian


@dataclass(frozen=True, kw_only=True, eq=False)
class Loop:
    """How fast the paper's learner approaches its fixed point, over the rotor positions.

    Attributes
    ----------
    azimuth : ndarray (P,)
        Azimuth of blade 1 [rad].
    estimated : ndarray (P,)
        Factor on the distance of the pitch in a passage, by the Jacobian of the experiment.
    true : ndarray (P,)
        The same by the plant's own Jacobian at the last profile.
    estimated_jacobian, true_jacobian : ndarray (P, 4, B)
        The Jacobians [load/rad].
    """

    azimuth: FloatArray
    estimated: FloatArray
    true: FloatArray
    estimated_jacobian: FloatArray
    true_jacobian: FloatArray


def loop_of(
    plant: StaticPlant, learner: Learner, record: Record, azimuth: FloatArray
) -> Loop | None:
    """The loop of a run that has ended; None for other learners than the paper's."""
    if not isinstance(learner, FixedLearner):
        return None
    rest = (learner.gain, learner.weights, learner.learning_rate)
    own = _jacobian(plant, learner.layout, record)
    return Loop(
        azimuth=azimuth[: learner.layout.tracked],
        estimated=contraction(learner.jacobian, *rest).pitch,
        true=contraction(own, *rest).pitch,
        estimated_jacobian=learner.jacobian,
        true_jacobian=own,
    )


def _jacobian(plant: StaticPlant, layout: Layout, record: Record) -> FloatArray:
    """The plant's own Jacobian (P, 4, B) at the last profile, by central differences.

    Each blade's whole profile is moved, so that pitch rates stay as they are.
    """
    blades, profile = layout.blades, record.learning.profile[-1]
    own = np.array(np.broadcast_to(profile, (blades, layout.stations)))
    first = int(record.learning.last_passage[-1]) - (blades - 1)
    out = np.zeros((layout.tracked, 4, blades))
    for number in range(first, first + layout.dwell):
        rows, _ = layout.visit(number)
        for blade in range(blades):
            move = np.zeros((blades, 1))
            move[blade] = _PROBE
            up, down = (plant.passage(own + s * move, number) for s in (1.0, -1.0))
            out[rows, :, blade] = ((up - down) / (2 * _PROBE)).T
    return out
