"""DynamicPlant: the dynamic turbine as a plant for `ilc`.

The turbine runs on from passage to passage.  In passage j blade b is told the pitch of its
profile, linear between the stations,

    command_b = [collective of the controller - pitch_0 +]  beta_b(psi_b - delta / 2),

with delta = 2 pi / N the azimuth between two stations.  The half station is what a plant needs that
does not know the next profile: a blade goes from the last station of one profile to the first of
the next, the very step that `ilc` keeps within the actuators' rate, and is there at the end of the
interval whose middle is the position.  Position k's loads are the mean over that interval of what
the hub transmits (`pitchopt.sim.kernels_reactions.reactions`): torque about the shaft, tilt, yaw
and thrust in the hub frame that does not turn, with inertia and gravity in them.

Two ways to run the rotor:

- its speed is held.  Then the profile has the mean pitch in it, and mean torque answers it as that
  of the static rotor does;
- a controller has torque and collective pitch, and the rotor its speed.  The profile is then added
  to what the controller asks for, less the pitch_0 that the run starts from.  A change of the
  profile's mean acts at once and is taken back by the controller within its own time, that of a
  few rotations.  The generator sets the mean torque.

In turbulence the loads of one passage are mostly chance.  With `averaged` = n the plant holds every
profile for 1 + B n passages of the turbine, a number after which each blade stands where it does
after one, and answers with the mean over the last B n of them, n rotations.

The answer to a profile depends on what was before: structure, wake, controller and turbulence go
on.  :meth:`DynamicPlant.state` and :meth:`~DynamicPlant.restore` carry all of it over.
"""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np
from numpy.typing import ArrayLike

from pitchopt.checks import FloatArray, finite_array, whole_number
from pitchopt.control import TurbineController, nrel_5mw_baseline
from pitchopt.control.signals import ROTOR_SPEED
from pitchopt.errors import ComputationError, InputError
from pitchopt.sim import DynamicTurbine, Start, TurbineRun
from pitchopt.sim.wind import Wind, check_wind, wind_direction

__all__ = ["DynamicPlant", "whole_step"]


def whole_step(rotor_speed: float, stations: int, longest: float) -> float:
    """Time step [s] of which a whole number goes from station to station at a rotor speed.

    Parameters
    ----------
    rotor_speed : float
        [rad/s].
    stations : int
        N, a turn.
    longest : float
        Step that is not passed [s].
    """
    time = 2.0 * math.pi / (stations * rotor_speed)
    return time / math.ceil(time / longest * (1.0 - 1e-9))


class DynamicPlant:
    """The dynamic turbine, turned passage by passage.

    Parameters
    ----------
    dynamic : DynamicTurbine
        Without the freedom ``rotor-speed`` its speed is held.
    wind : StaticField, TransientField or TurbulentField
        A box of turbulence is repeated when it is used up.
    positions : int
        Rotor positions m of a passage.
    start : Start
        Its azimuth is not used.
    controller : TurbineController, optional
        Given with, and only with, a rotor whose speed is free.
    averaged : int
        Rotations n over which the loads of a profile are averaged; 0 for those of one passage.
    warm_up : int
        Rotations at the starting pitch before the first passage, in which transients die away.

    Raises
    ------
    InputError
        If speed and controller do not fit each other, the wind not the turbine, or a step is
        longer than the way between two positions.
    ComputationError
        If the turbine diverges.
    """

    def __init__(
        self,
        dynamic: DynamicTurbine,
        wind: Wind,
        *,
        positions: int,
        start: Start,
        controller: TurbineController | None = None,
        averaged: int = 0,
        warm_up: int = 40,
    ) -> None:
        from pitchopt.control.kernels import start as begin_control

        free = "rotor-speed" in dynamic.freedoms
        if free != (controller is not None):
            raise InputError(
                f"controller: got {'none' if free else 'one'} with a rotor whose speed is "
                f"{'free' if free else 'held'}, expected {'one' if free else 'none'}"
            )
        self.dynamic, self.wind = dynamic, wind
        self._positions = whole_number("positions", positions, at_least=1)
        self._station = 2.0 * math.pi / (dynamic.blades * self._positions)
        if start.rotor_speed * dynamic.step > self._station:
            raise InputError(
                f"step: got {dynamic.step:g} s, in which the rotor turns by "
                f"{start.rotor_speed * dynamic.step / self._station:.3g} times the way between "
                "two positions, expected at most once: take fewer positions or a shorter step"
            )
        reach = dynamic.reach_in(wind_direction(wind))
        check_wind(dynamic.turbine, reach, wind, dynamic.step, repeat=True)
        self._start = start
        self.averaged = whole_number("averaged", averaged, at_least=0)
        self._run = TurbineRun(
            dynamic,
            wind,
            rotor_speed=start.rotor_speed,
            pitch=start.pitch,
            torque=start.torque,
            azimuth=2.0 * math.pi - 0.5 * self._station,
        )
        self._controlled = controller is not None
        # without one its numbers have the types that the compiled loop takes, and are not read
        steered = nrel_5mw_baseline() if controller is None else controller
        self._control = steered.parameters(dynamic.step)
        memory = np.zeros(steered.memory_size)
        if controller is not None:
            begin_control(self._control, memory, self._run.measured())
        hub = self._run.work.hub
        self._own: dict[str, FloatArray] = {
            "memory": memory,
            "place": np.zeros(1),
            "before": np.array([hub[3], hub[4], hub[5], hub[0]]),
            "carry": np.zeros(4),
            "last": np.full(dynamic.blades, start.pitch),
            "passages": np.zeros(1),
        }
        constant = np.full(self.stations, start.pitch)
        turns = whole_number("warm_up", warm_up, at_least=1)
        self.warm_loads = np.array(
            [self._turn(constant, j) for j in range(turns * self.blades)]
        ).reshape(turns, self.blades, 4, self._positions)
        """Loads of the warm-up by rotation and passage, (W, B, 4, m)."""

    @property
    def blades(self) -> int:
        """Number of blades B."""
        return self.dynamic.blades

    @property
    def positions(self) -> int:
        """Rotor positions m at which the loads are sampled in a passage."""
        return self._positions

    @property
    def stations(self) -> int:
        """N = B m."""
        return self.blades * self._positions

    @property
    def time(self) -> float:
        """Now, from the start of the warm-up [s]."""
        return self._run.time

    @property
    def pitch(self) -> FloatArray:
        """Of the blades now, (B,) [rad]."""
        return np.array(self._run.state.pitch)

    @property
    def rotor_speed(self) -> float:
        """Now [rad/s]."""
        return float(self._run.measured()[ROTOR_SPEED])

    @property
    def passages(self) -> int:
        """Passages made after the warm-up, each of `turns` of the turbine."""
        return int(self._own["passages"][0])

    @property
    def turns(self) -> int:
        """Passages of the turbine in one of the plant, 1 or 1 + B n."""
        return 1 + self.blades * self.averaged

    def passage(self, profile: ArrayLike, number: int) -> FloatArray:
        """Turn by one blade passage.

        Parameters
        ----------
        profile : array (N,) or (B, N)
            Pitch at the stations [rad]; one for all blades or one each.
        number : int
            Passages made before this one.

        Returns
        -------
        ndarray (4, m)
            Torque, tilt, yaw [N m] and thrust [N] at the hub.

        Raises
        ------
        InputError
            If the profile has another shape or is not finite, or `number` is not that of the
            passage that comes next.
        ComputationError
            If the turbine diverges.
        """
        shape = np.shape(profile)
        if shape not in ((self.stations,), (self.blades, self.stations)):
            raise InputError(
                f"profile: got shape {shape}, expected ({self.stations},) or "
                f"({self.blades}, {self.stations})"
            )
        own = np.broadcast_to(
            finite_array("profile", profile, shape=shape), (self.blades, self.stations)
        )
        if number != self.passages:
            raise InputError(
                f"number: got {number}, expected {self.passages}: the turbine runs on from the "
                "passage before"
            )
        turned = [self._turn(own, number + turn) for turn in range(self.turns)]
        self._own["passages"][0] += 1.0
        return np.asarray(turned[0] if self.turns == 1 else np.mean(turned[1:], axis=0))

    def held(self, profile: ArrayLike, rotations: int) -> FloatArray:
        """Loads (R, B, 4, m) of coming rotations with a profile, passage by passage.

        A plant that does not average is needed, as nothing of a passage is kept else.
        """
        if self.turns != 1:
            raise InputError(
                f"averaged: got a plant that averages over {self.averaged} rotations, expected 0"
            )
        first = self.passages
        count = whole_number("rotations", rotations, at_least=1) * self.blades
        loads = [self.passage(profile, first + j) for j in range(count)]
        return np.reshape(loads, (rotations, self.blades, 4, self._positions))

    def _turn(self, own: FloatArray, number: int) -> FloatArray:
        """Loads (4, m) of a passage with profiles (B, N), or (N,) for all."""
        from pitchopt.sim.kernels_march import RUNNING
        from pitchopt.studies.learning.kernels_passage import march_passage

        m, blades = self._positions, self.blades
        cut = np.broadcast_to(own, (blades, self.stations)).reshape(blades, blades, m)
        who = np.arange(blades)
        told = cut[who, (who + number) % blades]
        mine = self._own
        commands = np.column_stack([mine["last"], told])
        mine["last"][:] = told[:, -1]
        if self._controlled:
            commands -= self._start.pitch
        loads = np.zeros((4, m))
        run = self._run
        status = march_passage(
            run.model, run.state, run.work, self._control, mine["memory"], self._controlled,
            self._start.torque, commands, self._station, mine["place"], mine["before"],
            mine["carry"], loads,
        )  # fmt: skip
        if status != RUNNING:
            raise ComputationError(
                f"turbine {self.dynamic.turbine.name!r} diverged at {run.time:g} s in passage "
                f"{number}: the rotor ran away or a deflection passed half the radius"
            )
        return loads

    # ---- going on -----------------------------------------------------------------------

    def state(self) -> dict[str, FloatArray]:
        """All that :meth:`restore` needs to go on from here to the last bit."""
        own = {name: array.copy() for name, array in self._own.items()}
        return own | {f"run.{name}": array for name, array in self._run.snapshot().items()}

    def restore(self, state: Mapping[str, FloatArray]) -> None:
        """Go on from a state of a plant of the same turbine, wind, start and controller.

        Raises
        ------
        InputError
            If an array is missing or has another shape.
        """
        for name, array in self._own.items():
            if name not in state or np.shape(state[name]) != array.shape:
                raise InputError(
                    f"state: array {name!r} is missing or of another shape than {array.shape}; "
                    "it belongs to another plant"
                )
        self._run.restore(
            {
                name.removeprefix("run."): np.asarray(array)
                for name, array in state.items()
                if name.startswith("run.")
            }
        )
        for name, array in self._own.items():
            array[...] = state[name]
