"""LearningResult: a run, the designs that it is compared with, and the figures that follow.

Rotations are 1 .. R after the experiment.  A figure of a rotation is that of its last passage,
which one profile was in use for; `design` there means the profile that was designed with a model
for the wind of that rotation, held on the same plant.  Over a drifting wind it is the profile for
the mean wind.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ilc import Record
from pitchopt.cases import Case
from pitchopt.checks import FloatArray
from pitchopt.studies.learning.figures import ProfileFigures
from pitchopt.studies.learning.loop import Loop
from pitchopt.studies.learning.references import Reference
from pitchopt.studies.learning.settings import LearningSettings
from pitchopt.studies.learning.wind import WindStep

__all__ = ["LearningResult", "Stretch"]

_NOTHING = 1e-9  # of the load at the best constant pitch; less is rounding
RECOVERED = 1.3
"""Ratio to the new design at which a learner has recovered from a change of wind."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Stretch:
    """Rotations over which the wind stays the same.

    Attributes
    ----------
    first, last : int
        Rotations, both included.
    reference : Reference
        Model-based figures at the wind speed.
    design : ProfileFigures
        The reference's design held on the plant of the run.
    constant : ProfileFigures
        The wind's best constant pitch held on the plant, in a wake of its own where one is
        frozen.
    mean_wind : bool
        The wind drifts, and `reference` belongs to its mean.
    """

    first: int
    last: int
    reference: Reference
    design: ProfileFigures
    constant: ProfileFigures
    mean_wind: bool = False


@dataclass(frozen=True, kw_only=True, eq=False)
class LearningResult:
    """A learning run.

    Attributes
    ----------
    case : Case
    settings : LearningSettings
    record : Record
        What happened, as :func:`ilc.run` wrote it down.
    winds : ndarray (R,)
        Wind speed in the last passage of each rotation [m/s].
    stretches : tuple of Stretch
        Where the wind stays the same; none where it changes all the time, as in a ramp.
    reference : Reference
        At the starting wind.
    reference_after : Reference or None
        At the wind that a step or a ramp leads to.
    baseline : ProfileFigures
        Best constant pitch of the starting wind.
    baseline_after : ProfileFigures or None
        The same in the wind that a step or a ramp leads to.
    start : ProfileFigures
        The pitch that the run starts from.
    design : ProfileFigures
        Model-based profile at the starting set-point.
    design_after : ProfileFigures or None
        The same in the wind that a step or a ramp leads to.
    learned : ProfileFigures
        The last profile, in the last passage.
    loop : Loop or None
        Of the paper's learner.
    seconds : float
    """

    case: Case
    settings: LearningSettings
    record: Record
    winds: FloatArray
    stretches: tuple[Stretch, ...]
    reference: Reference
    reference_after: Reference | None
    baseline: ProfileFigures
    baseline_after: ProfileFigures | None
    start: ProfileFigures
    design: ProfileFigures
    design_after: ProfileFigures | None
    learned: ProfileFigures
    loop: Loop | None
    seconds: float

    @property
    def azimuth(self) -> FloatArray:
        """Azimuth of the stations [rad], (N,)."""
        return self.reference.design.azimuth

    @property
    def rotor_speed(self) -> float:
        """Rotor speed in the last wind [rad/s]."""
        return self.case.with_values({"wind.speed": float(self.winds[-1])}).rotor_speed

    @property
    def practice(self) -> int:
        """Rotations of the experiment."""
        return len(self.record.experiment)

    @cached_property
    def rms(self) -> FloatArray:
        """J of the four loads in each rotation [N m, N], (R, 4)."""
        return np.asarray(self.record.passages.rms[self.record.learning.last_passage])

    @cached_property
    def experiment_rms(self) -> FloatArray:
        """The same in the rotations of the experiment."""
        return np.asarray(self.record.passages.rms[self.record.experiment.last_passage])

    @property
    def largest_move(self) -> float:
        """Largest change of pitch from the start in the rotations of the experiment [rad]."""
        return float(np.abs(self.record.experiment.profile - self.start.profile).max())

    def stretch(self, rotation: int) -> Stretch | None:
        """The stretch of constant wind that a rotation lies in."""
        for one in self.stretches:
            if one.first <= rotation <= one.last:
                return one
        return None

    def cut(self, rotation: int) -> float | None:
        """Share of the best constant pitch's sum of RMS that is gone in a rotation.

        The constant pitch is that of the wind at the time; None beyond the run and while the wind
        changes.
        """
        stretch = self.stretch(rotation)
        if stretch is None or rotation > self.record.rotations or stretch.constant.rms_sum <= 0:
            return None
        return float(1.0 - self.rms[rotation - 1].sum() / stretch.constant.rms_sum)

    def ratio(self, rotation: int) -> float | None:
        """Weighted RMS over that of the design.

        None where there is no design, no rotation, or nothing but rounding left by the design.
        """
        stretch = self.stretch(rotation)
        if stretch is None or not _compares(stretch.design, stretch.constant):
            return None
        return self.record.ratio(rotation, stretch.design.rms_weighted)

    def ratio_rotation(self, rotation: int) -> float | None:
        """The same with the RMS of all samples of the rotation, from passage to passage."""
        if self.ratio(rotation) is None:
            return None
        stretch = self.stretch(rotation)
        assert stretch is not None  # there is a ratio
        whole = self.record.learning.ac_load_rotation[rotation - 1]
        return float(whole / stretch.design.rms_weighted)

    def ratio_from_start(self, rotation: int) -> float | None:
        """The same, with rotations counted from the start of the experiment."""
        learning = rotation - self.practice
        if learning >= 1:
            return self.ratio(learning)
        if rotation < 1 or not _compares(self.design, self.baseline):
            return None
        return float(self.record.experiment.ac_load[rotation - 1] / self.design.rms_weighted)

    @property
    def recovery_rotations(self) -> int | None:
        """Fewest rotations after a step until the ratio to the new design is 1.3; else None."""
        step = self.settings.wind
        if not isinstance(step, WindStep):
            return None
        for rotation in range(step.rotation + 1, self.record.rotations + 1):
            ratio = self.ratio(rotation)
            if ratio is not None and ratio <= RECOVERED:
                return rotation - step.rotation
        return None

    @property
    def setpoint_after(self) -> float | None:
        """Set-point in the wind that a step or ramp leads to [N m]."""
        return None if self.reference_after is None else self.reference_after.setpoint

    @property
    def events(self) -> tuple[tuple[int, int, str], ...]:
        """What the learner said: passage and rotation, both from the end of the experiment.

        The first passage after it is 1, those within it are 0 and below.
        """
        blades = self.case.blades
        practice = self.practice * blades
        counted = [(passage - practice + 1, text) for passage, text in self.record.events]
        return tuple((passage, -(-passage // blades), text) for passage, text in counted)


def _compares(design: ProfileFigures, constant: ProfileFigures) -> bool:
    """True if a design leaves a load that others can be divided by."""
    return design.rms_weighted > _NOTHING * constant.rms_weighted
