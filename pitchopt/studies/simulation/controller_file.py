"""Controllers in TOML files: a base, and sections that change or add parts.

    base = "tuned"                     # baseline, tuned or lqr

    [torque]
    factor = 0.9                       # on the gain of region 2
    constant_power = true              # above rated, otherwise constant torque

    [pitch]
    frequency = 0.5                    # of the speed mode [rad/s], with damping; or the gains:
    damping = 0.8                      # proportional [s], integral [-], linear [1/rad],
                                       # quadratic [1/rad^2], reference_rpm of the generator
    [lqr]
    tower_velocity = 0.1               # weight [s^2/m^2]; with base = "lqr"

    [minimum_pitch]
    wind_speed = [8, 11, 14]           # estimated [m/s]
    pitch_deg = [0, 3, 0]

    [individual]
    harmonics = [1, 2]
    gain = [2e-8, 1e-8]                # [rad/(N m s)]
    offset_deg = [10, 8]               # of azimuth
    amplitude_deg = 5                  # largest, of each harmonic or one for all
    fade_from_deg = 0                  # collective pitch over which it grows
    fade_to_deg = 5
    fade_time = 30                     # [s]

    [feedforward]
    profile = "profiles.npz"           # of pitchopt design or tradeoff, or profile.csv; or
    point = "knee"                     # cosine_deg = [...], sine_deg = [...] of 1P, 2P, ...
    harmonics = 3                      # how many are kept
    time_constant = 0.4                # lead for an actuator of first order [s]
    amplitude = true                   # correct the amplitude too, not the phase alone
    wind_speed = [11, 13]              # estimated [m/s], over which scale is interpolated
    scale = [0, 1]

Unknown keys are errors that name the nearest known one; paths are relative to the file.
"""

from __future__ import annotations

import contextlib
import dataclasses
import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from pitchopt.cases.files import only_known, read_toml
from pitchopt.cases.kinds import Choice, Count, Flag, Kind, Number, PathName, Text
from pitchopt.checks import FloatArray
from pitchopt.control import (
    IndividualPitch,
    MinimumPitchTable,
    PitchProfile,
    PitchRegulator,
    TurbineController,
)
from pitchopt.errors import InputError
from pitchopt.exports import ProfileSet, read_profile_csv
from pitchopt.sim import Operation
from pitchopt.studies.simulation.controllers import actuator_time, named_controller, with_individual
from pitchopt.turbines.fields import brief

__all__ = ["controller_from_table", "read_controller"]

_DEG = math.pi / 180.0
_BASES = ("baseline", "tuned", "lqr")


@dataclass(frozen=True, kw_only=True)
class Numbers(Kind):
    """A list of finite numbers, or one of them."""

    factor: float = 1.0

    def allowed(self) -> str:
        """What is allowed, in words."""
        return "finite numbers, such as [1, 2]"

    def read(self, name: str, value: Any) -> FloatArray:
        """Inner value of a plain one."""
        items = value if isinstance(value, list) and value else [value]
        one = Number()
        if not isinstance(value, list | int | float) or value == []:
            self.fail(name, value)
        return np.array([one.read(name, item) for item in items], dtype=np.float64) * self.factor


_POSITIVE = Number(above=0.0)
_ANGLE = Number(unit="deg", factor=_DEG, at_least=-180.0, at_most=180.0)
_ANGLES = Numbers(factor=_DEG)
_SECTIONS: dict[str, dict[str, Kind]] = {
    "torque": {"factor": _POSITIVE, "constant_power": Flag()},
    "pitch": {
        "frequency": _POSITIVE,
        "damping": _POSITIVE,
        "proportional": Number(at_least=0.0),
        "integral": _POSITIVE,
        "linear": Number(),
        "quadratic": Number(),
        "reference_rpm": Number(unit="rpm", factor=math.pi / 30.0, above=0.0),
    },
    "lqr": {"tower_velocity": Number(at_least=0.0)},
    "minimum_pitch": {"wind_speed": Numbers(), "pitch_deg": _ANGLES},
    "individual": {
        "harmonics": Numbers(),
        "gain": Numbers(),
        "offset_deg": _ANGLES,
        "amplitude_deg": _ANGLES,
        "fade_from_deg": _ANGLE,
        "fade_to_deg": _ANGLE,
        "fade_time": Number(at_least=0.0),
    },
    "feedforward": {
        "profile": PathName(),
        "point": Text(),
        "cosine_deg": _ANGLES,
        "sine_deg": _ANGLES,
        "harmonics": Count(at_most=1000),
        "time_constant": Number(at_least=0.0),
        "amplitude": Flag(),
        "wind_speed": Numbers(),
        "scale": Numbers(),
    },
}
_TUNING = ("frequency", "damping")


def read_controller(path: Path, operation: Operation) -> TurbineController:
    """Controller of a file for a turbine.

    Raises
    ------
    InputError
        On anything wrong, naming file and key.
    """
    table = read_toml(path, "controller")
    try:
        return controller_from_table(table, operation, folder=path.parent)
    except InputError as error:
        raise InputError(f"controller: {path}: {error}") from error


def controller_from_table(
    table: Mapping[str, Any], operation: Operation, *, folder: Path = Path()
) -> TurbineController:
    """Controller of the plain data that a file holds.

    Parameters
    ----------
    table : mapping
    operation : Operation
        Of the turbine that is steered.
    folder : Path
        Where relative paths start.
    """
    only_known(dict(table), ("base", *_SECTIONS), "")
    base = Choice(_BASES).read("base", table.get("base", "tuned"))
    parts = {name: _section(name, table[name]) for name in _SECTIONS if name in table}
    if ("lqr" in parts) != (base == "lqr") and "lqr" in parts:
        raise InputError(f"lqr: got the section with base = {base!r}, expected base = 'lqr'")
    if base == "lqr":
        if "pitch" in parts:
            raise InputError("pitch: got the section with base = 'lqr', whose gains are its own")
        controller = operation.linear_quadratic(**parts.get("lqr", {}))
    else:
        controller = named_controller(operation, base)
    changes: dict[str, Any] = {}
    if "torque" in parts:
        with _in("torque"):
            changes["torque"] = dataclasses.replace(controller.torque, **parts["torque"])
    if "pitch" in parts:
        changes["pitch"] = _regulator(parts["pitch"], controller.pitch, operation)
    if "minimum_pitch" in parts:
        _needs(parts, "minimum_pitch", "wind_speed", "pitch_deg")
        found = parts["minimum_pitch"]
        with _in("minimum_pitch", pitch="pitch_deg"):
            changes["minimum_pitch"] = MinimumPitchTable(
                wind_speed=found["wind_speed"], pitch=found["pitch_deg"]
            )
        _reachable(found["pitch_deg"], operation)
    if "feedforward" in parts:
        changes["feedforward"] = _profile(parts, operation, folder)
    if "minimum_pitch" in parts or "wind_speed" in parts.get("feedforward", {}):
        changes["estimator"] = operation.estimator
    controller = dataclasses.replace(controller, **changes)
    if "individual" in parts:
        _needs(parts, "individual", "gain")
        with _in("individual", order="harmonics", offset="offset_deg", limit="amplitude_deg"):
            individual = _individual(parts, operation)
        controller = with_individual(controller, individual, operation)
    return controller


def _section(name: str, content: Any) -> dict[str, Any]:
    if not isinstance(content, dict):
        raise InputError(f"{name}: got {brief(content)}, expected a section [{name}]")
    kinds = _SECTIONS[name]
    only_known(content, tuple(kinds), name)
    return {key: kinds[key].read(f"{name}.{key}", value) for key, value in content.items()}


@contextlib.contextmanager
def _in(section: str, **keys: str) -> Iterator[None]:
    """Put the section before what is said of a number in it, with the file's key for a name."""
    try:
        yield
    except InputError as error:
        name, colon, rest = str(error).partition(":")
        raise InputError(f"{section}.{keys.get(name, name)}{colon}{rest}") from error


def _reachable(pitch: FloatArray, operation: Operation) -> None:
    """Refuse a lowest pitch that the actuators do not reach."""
    actuator = operation.dynamic.actuator
    assert actuator is not None  # set by DynamicTurbine
    for angle in pitch:
        if not actuator.lowest <= angle <= actuator.highest:
            raise InputError(
                f"minimum_pitch.pitch_deg: got {angle / _DEG:g}, expected angles that the pitch "
                f"actuators reach, {actuator.lowest / _DEG:g} to {actuator.highest / _DEG:g}"
            )


def _needs(parts: Mapping[str, Mapping[str, Any]], section: str, *keys: str) -> None:
    for key in keys:
        if key not in parts[section]:
            raise InputError(f"{section}.{key}: got nothing, expected a value")


def _regulator(found: dict[str, Any], base: Any, operation: Operation) -> PitchRegulator:
    gains = {key: value for key, value in found.items() if key not in _TUNING}
    if "reference_rpm" in gains:
        gains["reference_speed"] = gains.pop("reference_rpm")
    tuning = {key: found[key] for key in _TUNING if key in found}
    regulator = operation.pitch_regulator(**tuning) if tuning else base
    if tuning and {"proportional", "integral"} & set(gains):
        raise InputError(
            f"pitch.{next(iter(gains))}: got it together with {next(iter(tuning))}, expected gains "
            "or the frequency and damping that they follow from"
        )
    return dataclasses.replace(regulator, **gains)


def _individual(parts: Mapping[str, Mapping[str, Any]], operation: Operation) -> IndividualPitch:
    found = parts["individual"]
    count = found["gain"].size
    fine = operation.fine_pitch
    amplitude = found.get("amplitude_deg", np.array([5.0 * _DEG]))
    return IndividualPitch(
        gain=found["gain"],
        order=found.get("harmonics"),
        offset=found.get("offset_deg"),
        limit=np.full(count, amplitude[0]) if amplitude.size == 1 else amplitude,
        fade_from=found.get("fade_from_deg", fine),
        fade_to=found.get("fade_to_deg", found.get("fade_from_deg", fine)),
        fade_time=found.get("fade_time", 0.0),
    )


def _profile(
    parts: Mapping[str, Mapping[str, Any]], operation: Operation, folder: Path
) -> PitchProfile:
    found = parts["feedforward"]
    shared: dict[str, Any] = {
        "time_constant": found.get("time_constant", actuator_time(operation)),
        "amplitude": found.get("amplitude", True),
    }
    if "wind_speed" in found or "scale" in found:
        _needs(parts, "feedforward", "wind_speed", "scale")
        shared |= {
            "schedule_at": found["wind_speed"], "schedule": found["scale"], "over_wind": True,
        }  # fmt: skip
    given = [key for key in ("profile", "cosine_deg") if found.get(key) is not None]
    if len(given) != 1:
        raise InputError(
            f"feedforward: got {' and '.join(given) or 'neither'} of profile and cosine_deg, "
            "expected one of the two"
        )
    if given == ["cosine_deg"]:
        cosine = found["cosine_deg"]
        for key in ("point", "harmonics"):
            if key in found:
                raise InputError(f"feedforward.{key}: got it without a profile, expected none")
        with _in("feedforward", cosine="cosine_deg", sine="sine_deg", schedule="scale"):
            return PitchProfile(
                cosine=cosine, sine=found.get("sine_deg", np.zeros(cosine.size)), **shared
            )
    if "sine_deg" in found:
        raise InputError("feedforward.sine_deg: got it together with a profile, expected none")
    samples = _samples(folder / found["profile"], found.get("point"))
    return PitchProfile.from_samples(samples, harmonics=found.get("harmonics"), **shared)


def _samples(path: Path, point: str | None) -> FloatArray:
    """Pitch angles of a file at evenly spaced azimuths from 0 on [rad]."""
    if path.suffix.lower() == ".npz":
        source = ProfileSet.load(path)
        if point is None:
            point = "knee" if source.knee is not None else "0"
        azimuth, pitch = source.azimuth, source.profiles[source.row(point)]
    elif point is not None:
        raise InputError(
            f"feedforward.point: got {point!r} with {path.name}, expected an .npz file"
        )
    else:
        azimuth, pitch = read_profile_csv(path)
    if not np.allclose(azimuth, 2.0 * np.pi * np.arange(azimuth.size) / azimuth.size, atol=1e-6):
        raise InputError(
            f"feedforward.profile: {path.name} has azimuths from "
            f"{math.degrees(azimuth[0]):g} to {math.degrees(azimuth[-1]):g} deg, expected evenly "
            "spaced ones of a whole turn from 0 on"
        )
    return np.asarray(pitch, dtype=np.float64)
