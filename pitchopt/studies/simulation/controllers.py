"""Controllers by name: the published one, one from the turbine's own numbers, and two more.

    baseline   published controller of the NREL 5 MW; ``tuned`` for every other turbine
    tuned      torque law and gain schedule from the turbine's own steady operation
    lqr        linear quadratic regulator with integral action
    ipc        baseline, and individual pitch at the rotor's frequency

The gain of ``ipc`` follows from the turbine: with the wake held still the out-of-plane moment of
a blade is M = M_0 - k beta, so an integrator of gain g closes a loop of bandwidth g k in tilt and
in yaw, and

    g = 0.2 omega_rated / max k,

the largest k of the full-load operating points.  Five times slower than the rotor turns, it
leaves the averages that the multiblade transform takes valid, and stays far below the blade's
flapwise frequency.  The offset takes out the lag of the pitch actuator.  The largest amplitude
grows with the collective pitch above its lowest, so that no blade pitches below fine.
"""

from __future__ import annotations

import dataclasses
import difflib
import math
import os
from pathlib import Path

import numpy as np

from pitchopt.control import IndividualPitch, PitchProfile, TurbineController, decoupling_offset
from pitchopt.errors import InputError
from pitchopt.sim import Operation

__all__ = ["CONTROLLERS", "individual_pitch", "load_controller", "named_controller"]

CONTROLLERS = ("baseline", "tuned", "lqr", "ipc")
_SHARE = 0.2  # bandwidth over rated rotor speed
_AMPLITUDE = math.radians(5.0)


def named_controller(operation: Operation, name: str) -> TurbineController:
    """One of `CONTROLLERS`.

    Raises
    ------
    InputError
        If the name is another one.
    """
    if name == "baseline":
        return operation.baseline()
    if name == "tuned":
        return operation.controller()
    if name == "lqr":
        return operation.linear_quadratic()
    if name == "ipc":
        return with_individual(operation.baseline(), individual_pitch(operation), operation)
    raise InputError(f"controller: got {name!r}, expected one of {', '.join(CONTROLLERS)}")


def load_controller(
    name_or_path: str | os.PathLike[str], operation: Operation
) -> TurbineController:
    """A controller by name, or from a file ending in ``.toml``.

    Raises
    ------
    InputError
        On an unknown name, naming the nearest, and on anything wrong in a file.
    """
    text = os.fspath(name_or_path)
    if Path(text).suffix.lower() == ".toml":
        from pitchopt.studies.simulation.controller_file import read_controller

        return read_controller(Path(text), operation)
    if text not in CONTROLLERS:
        near = difflib.get_close_matches(text.lower(), CONTROLLERS, n=1, cutoff=0.4)
        hint = f"; did you mean {near[0]!r}?" if near else ""
        raise InputError(
            f"controller: got {text!r}, expected one of {', '.join(CONTROLLERS)} or a file "
            f"ending in .toml{hint}"
        )
    return named_controller(operation, text)


def with_individual(
    controller: TurbineController, individual: IndividualPitch, operation: Operation
) -> TurbineController:
    """A controller with individual pitch, whose blades have the actuator's whole range."""
    return _with_whole_range(dataclasses.replace(controller, individual=individual), operation)


def with_feedforward(
    controller: TurbineController, profile: PitchProfile, operation: Operation
) -> TurbineController:
    """A controller with a pitch profile, whose blades have the actuator's whole range."""
    return _with_whole_range(dataclasses.replace(controller, feedforward=profile), operation)


def _with_whole_range(controller: TurbineController, operation: Operation) -> TurbineController:
    limits = controller.pitch_range
    actuator = operation.dynamic.actuator
    assert actuator is not None  # set by DynamicTurbine
    return dataclasses.replace(
        controller,
        pitch_range=dataclasses.replace(
            limits,
            blade_lowest=min(limits.lowest, actuator.lowest),
            blade_highest=max(limits.highest, actuator.highest),
        ),
    )


def individual_pitch(operation: Operation) -> IndividualPitch:
    """Individual pitch at the rotor's frequency; see the module."""
    turbine, fine = operation.dynamic.turbine, operation.fine_pitch
    return IndividualPitch(
        gain=np.array([_SHARE * turbine.rated_rotor_speed / _moment_by_pitch(operation)]),
        offset=[decoupling_offset(1, turbine.rated_rotor_speed, actuator_time(operation))],
        limit=_AMPLITUDE,
        fade_from=fine,
        fade_to=fine + _AMPLITUDE,
    )


def actuator_time(operation: Operation) -> float:
    """Time constant of the pitch actuator at low frequencies [s]."""
    actuator = operation.dynamic.actuator
    assert actuator is not None  # set by DynamicTurbine
    if actuator.frequency is not None and actuator.damping is not None:
        return 2.0 * actuator.damping / actuator.frequency
    return actuator.time_constant or 0.0


def _moment_by_pitch(operation: Operation) -> float:
    """Largest k at full load [N m/rad]."""
    slopes = -operation.frozen_slopes.bending[operation.full_load]
    if slopes.size == 0 or slopes.max() <= 0.0:
        raise InputError(
            f"turbine {operation.dynamic.turbine.name!r}: no operating point at which pitch takes "
            "off bending, which individual pitch needs"
        )
    return float(slopes.max())
