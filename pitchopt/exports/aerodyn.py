"""Blade motion files of the AeroDyn driver: pitch of each blade over time.

One file per blade (``BldMotionType`` 1, ``BldMotionFileName``), one header line, then the
columns time [s], pitch [rad], pitch rate [rad/s], pitch acceleration [rad/s^2].  The driver takes
rate and acceleration as given and interpolates linearly in time; the rate moves the sections
about the pitch axis.  The rotor turns at constant speed from azimuth 0, so blade b stands at

    psi_b(t) = omega t + 2 pi (b - 1) / B,      beta_b(t) = beta(psi_b(t)).

Between the stations the profile is continued in one of two ways:

    linear    straight lines, as the actuator follows them and as the design judges the profile
              between stations.  Rate: omega times the slope of the line; at a station the mean
              of the two slopes, which is the central difference that the design uses.
              Acceleration: zero (the line has none, its jumps are left out).
    fourier   the Fourier series through the stations, with its own derivatives.  Smooth, but it
              may leave range and rate limits between the stations.

Source of the format: AeroDyn driver (OpenFAST 5), generic turbine format.
"""

from __future__ import annotations

import os
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from pitchopt.checks import finite_number
from pitchopt.errors import InputError
from pitchopt.exports.files import read_text
from pitchopt.exports.harmonics import even_turn, harmonics

__all__ = [
    "BladeMotion",
    "Interpolation",
    "blade_motion",
    "driver_block",
    "motion_files",
    "read_motion_files",
]

FloatArray = NDArray[np.float64]
Interpolation = Literal["linear", "fourier"]

HEADER = "time_[s],pitch_[rad],pitch_rate_[rad/s],pitch_acc_[rad/s^2]"
MAX_ROWS = 2_000_000


@dataclass(frozen=True, kw_only=True, eq=False)
class BladeMotion:
    """Pitch motion of B blades.

    Parameters
    ----------
    time : array (T,)
        [s], increasing from 0.
    pitch, rate, acceleration : array (B, T)
        [rad], [rad/s], [rad/s^2].
    """

    time: FloatArray
    pitch: FloatArray
    rate: FloatArray
    acceleration: FloatArray

    def __post_init__(self) -> None:
        for name in ("time", "pitch", "rate", "acceleration"):
            value = np.array(getattr(self, name), dtype=np.float64)
            if not np.all(np.isfinite(value)):
                raise InputError(f"{name}: holds NaN or infinite values")
            value.setflags(write=False)
            object.__setattr__(self, name, value)
        if self.time.ndim != 1 or self.time.size < 2 or np.any(np.diff(self.time) <= 0):
            raise InputError("time: expected at least two increasing times")
        for name in ("pitch", "rate", "acceleration"):
            shape = getattr(self, name).shape
            if len(shape) != 2 or shape != self.pitch.shape or shape[1] != self.time.size:
                raise InputError(f"{name}: got shape {shape}, expected (B, {self.time.size})")

    @property
    def blades(self) -> int:
        """Number of blades B."""
        return int(self.pitch.shape[0])


def blade_motion(
    azimuth: ArrayLike,
    profile: ArrayLike,
    *,
    rotor_speed: float,
    blades: int = 3,
    step: float | None = None,
    revolutions: int = 4,
    interpolation: Interpolation = "linear",
    initial_azimuth: float = 0.0,
) -> BladeMotion:
    """Motion of all blades under one profile.

    Parameters
    ----------
    azimuth, profile : array (N,)
        Stations, evenly spaced over one turn, and pitch [rad].
    rotor_speed : float
        [rad/s], positive.
    blades : int
        Number of blades B.
    step : float, optional
        Azimuth from row to row [rad]; the profile's own stations by default.  Choose the time
        step of the driver so that its steps coincide with the rows.
    revolutions : int
        Revolutions that the files cover; the driver holds the last row afterwards.
    interpolation : {"linear", "fourier"}
        How the profile continues between its stations, see the module.
    initial_azimuth : float
        Of blade 1 at time 0 [rad]; the AeroDyn driver starts at 0.

    Raises
    ------
    InputError
        If a number is out of range or the files would be longer than two million rows.
    """
    psi, beta = even_turn(azimuth, profile)
    if not np.isfinite(rotor_speed) or rotor_speed <= 0:
        raise InputError(f"rotor_speed: got {rotor_speed} rad/s, expected more than 0")
    if step is None:
        step = min(2 * np.pi / psi.size, np.pi)
    if not np.isfinite(step) or not 0 < step <= np.pi:
        raise InputError(
            f"step: got {np.rad2deg(step):g} deg, expected more than 0 and at most 180"
        )
    if revolutions < 1 or int(revolutions) != revolutions:
        raise InputError(f"revolutions: got {revolutions}, expected a whole number of at least 1")
    if blades < 1 or int(blades) != blades:
        raise InputError(f"blades: got {blades}, expected a whole number of at least 1")
    rows = round(revolutions * 2 * np.pi / step)
    if rows + 1 > MAX_ROWS:
        raise InputError(f"step, revolutions: {rows + 1} rows, expected at most {MAX_ROWS}")
    turned = step * np.arange(rows + 1, dtype=np.float64)
    start = finite_number("initial_azimuth", initial_azimuth)
    place = start + turned + 2 * np.pi * np.arange(blades)[:, None] / blades
    if interpolation == "linear":
        pitch, slope = _linear(psi, beta, place)
        second = np.zeros_like(pitch)
    elif interpolation == "fourier":
        series = harmonics(psi, beta)
        pitch, slope, second = (series(place, derivative) for derivative in range(3))
    else:
        raise InputError(f"interpolation: got {interpolation!r}, expected 'linear' or 'fourier'")
    return BladeMotion(
        time=turned / rotor_speed,
        pitch=pitch,
        rate=rotor_speed * slope,
        acceleration=rotor_speed**2 * second,
    )


def _linear(
    azimuth: FloatArray, profile: FloatArray, place: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Pitch and its slope at any azimuth, on straight lines between the stations."""
    count = azimuth.size
    spacing = 2 * np.pi / count
    position = (place - azimuth[0]) / spacing
    nearest = np.rint(position)
    position = np.where(np.abs(position - nearest) < 1e-9 * count, nearest, position)
    base = np.floor(position)
    share = position - base
    index = base.astype(np.int64) % count
    slopes = (np.roll(profile, -1) - profile) / spacing
    pitch = profile[index] + share * spacing * slopes[index]
    slope = np.where(share == 0.0, 0.5 * (slopes[index] + slopes[index - 1]), slopes[index])
    return np.asarray(pitch), np.asarray(slope)


def motion_files(motion: BladeMotion, stem: str = "pitch") -> dict[str, str]:
    """Names ``<stem>_b1.csv`` ... and contents of the motion files."""
    files = {}
    for b in range(motion.blades):
        columns = (motion.time, motion.pitch[b], motion.rate[b], motion.acceleration[b])
        rows = (",".join(f"{value:.15e}" for value in row) for row in zip(*columns, strict=True))
        files[f"{stem}_b{b + 1}.csv"] = "\n".join((HEADER, *rows)) + "\n"
    return files


def driver_block(motion_names: Sequence[str], rotor_speed: float) -> str:
    """Motion lines of the driver's input file that use the motion files."""
    count = len(motion_names)
    lines: list[tuple[str, str]] = [
        ("0", "BaseMotionType(1)"),
        ("0", "DegreeOfFreedom(1)"),
        ("0", "Amplitude(1)"),
        ("0", "Frequency(1)"),
        ('""', "BaseMotionFileName(1)"),
        ("0", "NacMotionType(1)"),
        ("0", "NacYaw(1) (deg)"),
        ('""', "NacMotionFileName(1)"),
        ("0", "RotMotionType(1)"),
        (f"{rotor_speed * 30 / np.pi:.10g}", "RotSpeed(1) (rpm)"),
        ('""', "RotMotionFileName(1)"),
        ("1", "BldMotionType(1)"),
        *(("0", f"BldPitch(1_{b + 1})") for b in range(count)),
        *((f'"{name}"', f"BldMotionFileName(1_{b + 1})") for b, name in enumerate(motion_names)),
    ]
    return "".join(f"{value:<24}  {name}\n" for value, name in lines)


def read_motion_files(paths: Sequence[str | os.PathLike[str]]) -> BladeMotion:
    """Read motion files, blade 1 first.

    Raises
    ------
    InputError
        If a file is not such a file or the times of the blades differ.
    """
    tables = []
    for path in paths:
        lines = read_text(path, "motion file").splitlines()
        try:
            table = np.array([[float(v) for v in line.split(",")] for line in lines[1:]])
        except ValueError as error:
            raise InputError(f"motion file: {path} holds something else than numbers") from error
        if table.ndim != 2 or table.shape[1] != 4:
            raise InputError(f"motion file: {path} needs rows of four numbers after one header")
        tables.append(table)
    if not tables or any(t.shape != tables[0].shape for t in tables):
        raise InputError("motion file: expected at least one file, all with equally many rows")
    if any(not np.array_equal(t[:, 0], tables[0][:, 0]) for t in tables):
        raise InputError("motion file: the files must share their times")
    stacked = np.stack(tables)
    return BladeMotion(
        time=stacked[0, :, 0],
        pitch=stacked[:, :, 1],
        rate=stacked[:, :, 2],
        acceleration=stacked[:, :, 3],
    )
