"""Controllers as files that `pitchopt.studies.simulation.read_controller` reads.

What is written is the turbine's baseline controller with a feed-forward profile, individual
pitch, or both; other parts of a controller have no place in such a file and are refused.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from pitchopt.control import TurbineController
from pitchopt.errors import InputError

__all__ = ["controller_text"]


def controller_text(controller: TurbineController, *, comment: Sequence[str] = ()) -> str:
    """Text of a controller file.

    Parameters
    ----------
    controller : TurbineController
        The baseline controller of a turbine with what was added to it.
    comment : sequence of str
        Lines at the top.

    Raises
    ------
    InputError
        If it has a table of lowest pitch, or a profile over a schedule.
    """
    if controller.minimum_pitch is not None:
        raise InputError("minimum_pitch: got a table, expected none in a written controller")
    lines = [*(f"# {line}" for line in comment), 'base = "baseline"']
    profile = controller.feedforward
    if profile is not None:
        if np.size(profile.schedule) > 1 or profile.frequency is not None:
            raise InputError(
                "feedforward: got a schedule or actuators of second order, expected neither in a "
                "written controller"
            )
        lines += [
            "",
            "[feedforward]",
            f"cosine_deg = {_list(np.rad2deg(profile.cosine))}",
            f"sine_deg = {_list(np.rad2deg(profile.sine))}",
            f"time_constant = {float(profile.time_constant)!r}",
        ]
    part = controller.individual
    if part is not None:
        lines += [
            "",
            "[individual]",
            f"harmonics = {[int(n) for n in np.asarray(part.order)]}",
            f"gain = {_list(part.gain)}",
            f"offset_deg = {_list(np.rad2deg(np.asarray(part.offset)))}",
            f"amplitude_deg = {_list(np.rad2deg(np.asarray(part.limit)))}",
        ]
    return "\n".join(lines) + "\n"


def _list(values: Any) -> str:
    return "[" + ", ".join(repr(float(value)) for value in values) + "]"
