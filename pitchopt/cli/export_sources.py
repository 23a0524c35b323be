"""Where ``pitchopt export`` takes profiles and controllers from."""

from __future__ import annotations

import json
import math
import zipfile
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

from pitchopt.errors import InputError

if TYPE_CHECKING:
    from pitchopt.checks import FloatArray
    from pitchopt.control import IndividualPitch

__all__ = ["Source", "controller_of_file", "profile_of_design", "profile_of_file"]

_STAYS = "individual pitch alone is written: torque and speed regulation stay ROSCO's own"


@dataclass(frozen=True, kw_only=True, eq=False)
class Source:
    """One profile to export.

    Parameters
    ----------
    azimuth, profile : array (N,)
        [rad].
    label : str
    blades : int
    rotor_speed : float
        [rad/s].
    settings : mapping
        Of the design, with its limits.
    """

    azimuth: FloatArray
    profile: FloatArray
    label: str
    blades: int
    rotor_speed: float
    settings: Mapping[str, Any] = field(default_factory=dict)

    def limits(self) -> dict[str, float]:
        """Range [rad] and rate [rad/s] of the design's actuators, as far as it names them."""
        held = self.settings.get("limits", {})
        names = {"lowest": "pitch_min_deg", "highest": "pitch_max_deg", "rate": "pitch_rate_deg"}
        return {
            name: math.radians(held[key])
            for name, key in names.items()
            if isinstance(held.get(key), int | float)
        }


def profile_of_file(path: str, point: str | None) -> Source:
    """Profile of an NPZ file of tradeoff, design, learn, robust or schedule."""
    from pitchopt.exports import ProfileSet, read_several_npz

    if Path(path).suffix.lower() in (".toml", ".json"):
        raise InputError(
            f"profiles file: got {path!r}, expected profiles.npz, robust.npz or schedule.npz; a "
            "controller goes with --format discon"
        )
    if _holds(path, "own_profiles"):
        several = read_several_npz(path)
        wind = several.wind(point)
        return Source(
            azimuth=several.azimuth,
            profile=several.profile(wind),
            label=several.labels[wind] if several.profiles.shape[0] > 1 else "all winds",
            blades=several.blades,
            rotor_speed=float(several.rotor_speeds[wind]),
            settings=several.settings,
        )
    found = ProfileSet.load(path)
    if point is None:
        if found.knee is not None:
            point = "knee"
        elif found.points == 1:
            point = "0"
        else:
            raise InputError(
                f"--point: got nothing, expected an index or one of {', '.join(found.labels)}"
            )
    return _row(found, found.row(point))


def _holds(path: str, name: str) -> bool:
    """Whether a file is an archive with an array of this name."""
    try:
        with zipfile.ZipFile(path) as archive:
            return f"{name}.npy" in archive.namelist()
    except (OSError, ValueError, zipfile.BadZipFile):
        return False


def _row(found: Any, row: int) -> Source:
    return Source(
        azimuth=found.azimuth,
        profile=found.profiles[row],
        label=found.labels[row],
        blades=found.blades,
        rotor_speed=found.rotor_speed,
        settings=found.settings,
    )


def profile_of_design(options: dict[str, Any]) -> Source:
    """Profile that the options of the design command give."""
    from pitchopt.cli.design_command import solve
    from pitchopt.cli.options import build_case
    from pitchopt.errors import ComputationError
    from pitchopt.exports import profile_set

    case = build_case(options)
    solved = solve(case, options)
    if not solved.design.status.ok:
        raise ComputationError(f"{solved.design.status.value}: {solved.design.message}")
    found = profile_set(
        solved.constant,
        solved.power_max,
        [solved.design],
        blades=case.blades,
        rotor_speed=case.rotor_speed,
        settings=solved.settings,
    )
    return _row(found, 2)


def controller_of_file(
    name: str, *, turbine: str, pitch_lag: float
) -> tuple[IndividualPitch, str, list[str]]:
    """Individual pitch of a controller's name or file, or of tuning.json.

    With what it is, and a sentence about all else of the controller.

    Raises
    ------
    InputError
        If there is none, or the file is something else.
    """
    if Path(name).suffix.lower() == ".npz":
        raise InputError(
            f"controller: got {name!r}, expected a controller file (.toml), tuning.json, or ipc; "
            "profiles go with --format rosco"
        )
    if Path(name).suffix.lower() == ".json":
        return (*_tuned(name), [_STAYS])
    from pitchopt.control import PitchActuator
    from pitchopt.sim import DynamicTurbine, Operation
    from pitchopt.studies.simulation import load_controller
    from pitchopt.turbines import load_turbine

    found = load_turbine(turbine)
    given: dict[str, Any] = {}
    if pitch_lag > 0.0:
        low, high = found.pitch_range
        given["actuator"] = PitchActuator(
            lowest=low, highest=high, rate=found.pitch_rate, time_constant=pitch_lag
        )
    controller = load_controller(name, Operation(DynamicTurbine(turbine=found, **given)))
    if controller.individual is None:
        raise InputError(
            f"controller: {name!r} has no individual pitch, expected ipc or a file with a section "
            "[individual]"
        )
    parts = {
        "the feed-forward profile": controller.feedforward,
        "the lowest pitch over the wind speed": controller.minimum_pitch,
    }
    left = [f"left out: {part}" for part, held in parts.items() if held is not None]
    return controller.individual, f"{name} on {found.name}", [_STAYS, *left]


def _tuned(path: str) -> tuple[IndividualPitch, str]:
    """Best point of ``tuning.json`` of the problem individual-pitch."""
    from pitchopt.control import IndividualPitch
    from pitchopt.exports.files import read_text

    try:
        document = json.loads(read_text(path, "controller"))
        problem = document["problem"]
        if problem != "individual-pitch":
            raise InputError(
                f"controller: {path!r} tunes {problem!r}, expected the problem individual-pitch"
            )
        names = list(document["parameters"])
        best = dict(zip(names, map(float, document["best"]["x"]), strict=True))
        orders = sorted(int(n.removeprefix("gain_").removesuffix("p")) for n in names
                        if n.startswith("gain_"))  # fmt: skip
        individual = IndividualPitch(
            order=orders,
            gain=[best[f"gain_{n}p"] for n in orders],  # type: ignore[arg-type]
            offset=[best[f"offset_{n}p"] for n in orders],
            limit=float(document["settings"]["problem"]["amplitude"]),
        )
    except InputError:
        raise
    except (KeyError, TypeError, ValueError, AttributeError) as error:
        raise InputError(
            f"controller: {path!r} is no tuning.json of pitchopt tune --problem individual-pitch "
            f"({type(error).__name__}: {error})"
        ) from error
    return individual, f"best of {document.get('method', 'tuning')} on {document.get('turbine')}"
