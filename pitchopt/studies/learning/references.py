"""What a learning run is compared with: set-points, constant pitches, model-based designs.

The set-point of mean torque is a share of what the wind can give,

    setpoint(v) = (1 - loss) x largest mean torque of any profile at wind speed v,

so that after a change of wind it is the same share of what the new wind can give; or it is a
torque that stays.  At a set-point stand the constant pitch with that mean torque and the profile
of least weighted RMS with that mean torque.  Two constant pitches give the same torque, one
on either side of the best, towards stall and towards feather.  A run starts from the one on the
side where the design lies: learners end in an optimum near their start, and are to be compared with
one there.  That side is all that a run has from the model; it is not taken if it has less than a
degree to an end of the actuators' range.
"""

from __future__ import annotations

from contextlib import suppress
from dataclasses import dataclass

import numpy as np

from pitchopt.checks import FloatArray, finite_number
from pitchopt.design import Design, compared
from pitchopt.design.constant_pitch import constant_for_torque
from pitchopt.design.results import Compared
from pitchopt.design.task import DesignTask, Progress
from pitchopt.errors import InfeasibleError, InputError
from pitchopt.studies.learning.tasks import WindTasks
from pitchopt.studies.learning.wind import WindSchedule, interpolated

__all__ = ["Reference", "SetpointSchedule", "reference"]

_ROOM = float(np.deg2rad(1.0))


@dataclass(frozen=True, kw_only=True, eq=False)
class SetpointSchedule:
    """Mean torque to be held, over wind speed and over rotations.

    Exactly one of the two goals is given.

    Parameters
    ----------
    tasks : WindTasks
    wind : WindSchedule
    max_power_loss : float, optional
        Share of the largest mean torque at each wind speed that is given up, between 0 and 1.
        At a wind speed between grid speeds the largest torque is interpolated.
    mean_torque : float, optional
        A torque that stays the same [N m].

    Raises
    ------
    InputError
        If not exactly one goal is given, or it is out of range.
    """

    tasks: WindTasks
    wind: WindSchedule
    max_power_loss: float | None = None
    mean_torque: float | None = None

    def __post_init__(self) -> None:
        loss, torque = _goal(self.max_power_loss, self.mean_torque)
        object.__setattr__(self, "max_power_loss", loss)
        object.__setattr__(self, "mean_torque", torque)

    def of_wind(self, speed: float) -> float:
        """Set-point [N m] at a wind speed of the schedule [m/s]."""
        return float(interpolated(self.wind, speed, self.tasks.spacing, self._exact))

    def at(self, rotation: float) -> float:
        """Set-point [N m] at so many rotations since the end of the experiment."""
        return self.of_wind(self.wind.at(rotation))

    def _exact(self, speed: float) -> FloatArray:
        return np.asarray(_setpoint(self.tasks, speed, self.max_power_loss, self.mean_torque))


@dataclass(frozen=True, kw_only=True, eq=False)
class Reference:
    """Model-based figures at one wind speed.

    Attributes
    ----------
    wind_speed : float
        [m/s].
    setpoint : float
        Mean torque to be held [N m].
    best : Design
        The constant pitch of largest mean torque.
    power_max : Design
        The profile of largest mean torque.
    constant : Design
        The constant pitch with the set-point's mean torque, of the two the one on the design's
        side of `best`; `best` where no constant pitch gives that much.  A run starts from it.
    design : Design
        The profile of least weighted RMS at the set-point's mean torque.
    operating_pitch : float
        Pitch around which the design's curves are sampled, or at which its wake is frozen [rad];
        a plant that is given it has the same curves.
    """

    wind_speed: float
    setpoint: float
    best: Design
    power_max: Design
    constant: Design
    design: Design
    operating_pitch: float

    @property
    def start_pitch(self) -> float:
        """Pitch that a run starts from [rad]."""
        return float(self.constant.profile[0])

    @property
    def start_loads(self) -> FloatArray:
        """Rotor loads at that pitch, shape (4, m)."""
        return self.constant.loads.rotor


def reference(
    tasks: WindTasks,
    wind_speed: float | None = None,
    *,
    max_power_loss: float | None = None,
    mean_torque: float | None = None,
    certify: bool = False,
    progress: Progress | None = None,
) -> Reference:
    """Set-point, constant pitches and model-based design at a wind speed.

    Parameters
    ----------
    tasks : WindTasks
    wind_speed : float, optional
        [m/s]; the case's own by default.
    max_power_loss, mean_torque : float
        As in :class:`SetpointSchedule`; exactly one is given.
    certify : bool
        Bound the design's RMS from below.
    progress : callable, optional
        Told how far the design is.

    Raises
    ------
    InputError
        If not exactly one goal is given, or it is out of range.
    InfeasibleError
        If no profile gives the torque.
    """
    loss, torque = _goal(max_power_loss, mean_torque)
    speed = tasks.case.wind.speed if wind_speed is None else wind_speed
    task, best = tasks.task(speed), tasks.best(speed)
    setpoint = _setpoint(tasks, speed, loss, torque)
    found = compared(task, mean_torque=setpoint, certify=certify, progress=progress)
    operating = found.design.mean_pitch
    if operating is None:
        operating = float(found.constant.profile[0])
    # where torque suffices, what the design is compared with is the constant towards feather
    constants = [found.constant]
    if setpoint <= best.mean_torque:
        with suppress(InfeasibleError):
            constants.append(constant_for_torque(task, setpoint, best=best, side="stall"))
    return Reference(
        wind_speed=speed,
        setpoint=setpoint,
        best=best,
        power_max=found.power_max,
        constant=min(constants, key=lambda one: (_cramped(task, one), _apart(one, found, best))),
        design=found.design,
        operating_pitch=operating,
    )


def _cramped(task: DesignTask, constant: Design) -> bool:
    """True for a pitch with hardly any room to one end of the actuators' range."""
    pitch, limits = float(constant.profile[0]), task.limits
    return min(pitch - limits.lower, limits.upper - pitch) < _ROOM


def _apart(constant: Design, found: Compared, best: Design) -> bool:
    """True for a pitch and a design on different sides of the best constant pitch."""
    middle = float(best.profile[0])
    return bool((constant.profile[0] < middle) != (found.design.profile.mean() < middle))


def _goal(loss: float | None, torque: float | None) -> tuple[float | None, float | None]:
    """The goals, checked."""
    if (loss is None) == (torque is None):
        given = "none" if loss is None else "both"
        raise InputError(
            f"set-point: got {given}, expected exactly one of max_power_loss, mean_torque"
        )
    if torque is not None:
        return None, finite_number("mean_torque", torque)
    return finite_number("max_power_loss", loss, at_least=0, at_most=1), None


def _setpoint(tasks: WindTasks, speed: float, loss: float | None, torque: float | None) -> float:
    """Set-point [N m] at an exact wind speed."""
    if torque is not None:
        return torque
    assert loss is not None
    return (1.0 - loss) * tasks.power_max(speed).mean_torque
