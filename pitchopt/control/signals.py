"""Signals between turbine and controller: what is measured, what is commanded.

Both are vectors of float64 in SI units and radians, so that compiled and Python controllers see
the same numbers.  The constants are their indices.

Measured, ``(MEASURED,)``; the blades' entries are ``PITCH + k`` and so on, k = 0, 1, 2:

    TIME                    [s]
    ROTOR_SPEED             [rad/s], of the rotor
    GENERATOR_SPEED         [rad/s], high-speed side
    AZIMUTH                 of blade 1, 0 is up [rad], within one turn
    PITCH                   of each blade [rad]
    OUT_OF_PLANE, IN_PLANE  moments at each blade root, coned frame that does not pitch [N m]
    TOWER_X, TOWER_Y        displacement of the tower top, downwind and to the left [m]
    TOWER_VX, TOWER_VY      its velocity [m/s]
    TOWER_AX, TOWER_AY      its acceleration [m/s^2]
    GENERATOR_TORQUE        high-speed side [N m]
    SHAFT_TORQUE            low-speed side [N m]
    POWER                   electrical [W]

Commanded, ``(COMMANDS,)``: TORQUE [N m], high-speed side, and PITCH_COMMAND + k [rad].
"""

from __future__ import annotations

from typing import Protocol

from pitchopt.checks import FloatArray

__all__ = ["Controller"]

TIME = 0
ROTOR_SPEED = 1
GENERATOR_SPEED = 2
AZIMUTH = 3
PITCH = 4
OUT_OF_PLANE = 7
IN_PLANE = 10
TOWER_X = 13
TOWER_Y = 14
TOWER_VX = 15
TOWER_VY = 16
TOWER_AX = 17
TOWER_AY = 18
GENERATOR_TORQUE = 19
SHAFT_TORQUE = 20
POWER = 21
MEASURED = 22

TORQUE = 0
PITCH_COMMAND = 1
COMMANDS = 4


class Controller(Protocol):
    """Anything that steers the turbine from what is measured."""

    def start(self, step: float, measured: FloatArray) -> None:
        """Prepare for a run.

        Parameters
        ----------
        step : float
            Time between two calls of `command` [s].
        measured : ndarray (MEASURED,)
            At the first instant.
        """
        ...  # pragma: no cover

    def command(self, measured: FloatArray) -> FloatArray:
        """Commands (COMMANDS,) for what is measured (MEASURED,) now.

        The generator torque [N m], high-speed side, stands first, then the pitch of each blade
        [rad].
        """
        ...  # pragma: no cover
