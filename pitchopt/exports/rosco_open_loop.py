r"""ROSCO's open-loop input: pitch of each blade over time at constant rotor speed.

With ``OL_Mode`` 1 ROSCO reads a table of numbers whose columns ``DISCON.IN`` names, and from the
first time of the table on commands each blade the pitch that it interpolates linearly at the
simulation's time; after the last row the last pitch stays.  The table knows no azimuth, so it fits
a rotor that turns at constant speed from a known place:

    psi_b(t) = psi_0 + omega t + 2 pi (b - 1)/3,      beta_b(t) = beta(psi_b(t)),

psi_0 the azimuth of blade 1 at time 0, zero with the blade up, growing clockwise seen from
upwind; time in seconds, pitch in radians, positive towards feather.  Nothing of ROSCO's own
pitch is left: speed regulator, individual pitch and minimum pitch are overwritten.

The command passes ROSCO's actuator model (``PA_Mode``), its range and its rate.  With an actuator
given, the command leads by what that actuator lags (`pitchopt.exports.lead`).

``OL_Mode`` 2 (rotor position control) tracks an azimuth over time with the generator torque; its
table is over time as well, and needs columns of torque and azimuth that a design does not have.

Source: ``rosco/controller/src`` of ROSCO 2.10.6: ``Controllers.f90`` (PitchControl),
``ROSCO_Helpers.f90`` (Read_OL_Input: leading lines with ``!``, ``#`` or ``%`` are comments),
``Functions.f90`` (interp1d), ``ReadSetParameters.f90`` (indices count from 1).
"""

from __future__ import annotations

import math
import os
import re
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from pitchopt.checks import FloatArray, finite_array, finite_number
from pitchopt.errors import InputError
from pitchopt.exports.aerodyn import Interpolation, blade_motion
from pitchopt.exports.discon import VERSIONS, DisconLine, discon_numbers, discon_text
from pitchopt.exports.files import read_text
from pitchopt.exports.harmonics import Harmonics, even_turn, harmonics
from pitchopt.exports.lead import ActuatorLag, harmonics_within, led_command, truncated

__all__ = [
    "OpenLoop",
    "check_discon_limits",
    "check_open_loop",
    "open_loop",
    "open_loop_discon",
    "open_loop_file",
    "open_loop_lines",
    "openfast_notes",
    "read_open_loop",
]

BLADES = 3
OPEN_LOOP_NAME = "pitch_open_loop.dat"
_COLUMNS = ("Time", "BldPitch1", "BldPitch2", "BldPitch3")
_UNITS = ("(s)", "(rad)", "(rad)", "(rad)")
_ROWS_A_PERIOD = 24  # of the highest harmonic: chords are off by 0.9 % of it
_NUMBERS = (
    "rotor_speed_rpm",
    "initial_azimuth_deg",
    "time_constant_s",
    "frequency_rad_s",
    "damping",
)
_ROUND = 1e-6  # share of a rate that rounding may add
_TINY = 1e-9  # [rad]


@dataclass(frozen=True, kw_only=True, eq=False)
class OpenLoop:
    """Commanded pitch of three blades over time.

    Parameters
    ----------
    time : array (T,)
        [s], increasing.
    pitch : array (3, T)
        Commands [rad].
    rotor_speed : float
        omega that the table is for [rad/s].
    initial_azimuth : float
        psi_0 [rad].
    lag : ActuatorLag, optional
        Actuator that the commands make up for.

    Raises
    ------
    InputError
        If a shape or a number is wrong.
    """

    time: FloatArray
    pitch: FloatArray
    rotor_speed: float
    initial_azimuth: float = 0.0
    lag: ActuatorLag | None = None

    def __post_init__(self) -> None:
        time = finite_array("time", self.time)
        if time.size < 2 or np.any(np.diff(time) <= 0.0):
            raise InputError("time: expected at least two increasing times")
        object.__setattr__(self, "time", time)
        pitch = finite_array("pitch", self.pitch, shape=(BLADES, time.size))
        object.__setattr__(self, "pitch", pitch)
        finite_number("rotor_speed", self.rotor_speed, above=0.0)
        finite_number("initial_azimuth", self.initial_azimuth)

    @property
    def rate(self) -> float:
        """Largest rate between two rows [rad/s], which is what ROSCO commands."""
        return float(np.abs(np.diff(self.pitch, axis=1) / np.diff(self.time)).max())

    def profile(self, stations: int) -> tuple[FloatArray, FloatArray]:
        """Azimuth and commanded pitch (N,) at N stations from azimuth 0 on, from blade 1.

        Raises
        ------
        InputError
            If the table is shorter than a revolution.
        """
        turned = self.rotor_speed * (self.time - self.time[0])
        if turned[-1] < 2.0 * np.pi * (1.0 - 1e-9):
            raise InputError(
                f"time: the table covers {turned[-1] / (2 * np.pi):.3g} revolutions, expected one "
                "or more"
            )
        start = self.initial_azimuth + self.rotor_speed * self.time[0]
        azimuth = 2.0 * np.pi * np.arange(stations) / stations
        place = np.mod(azimuth - start, 2.0 * np.pi)
        place[place > 2.0 * np.pi - 1e-9] = 0.0
        return azimuth, np.interp(place, turned, self.pitch[0])


def open_loop(
    azimuth: ArrayLike,
    profile: ArrayLike,
    *,
    rotor_speed: float,
    revolutions: int = 60,
    step: float | None = None,
    initial_azimuth: float = 0.0,
    interpolation: Interpolation = "linear",
    lag: ActuatorLag | None = None,
    keep_harmonics: int | None = None,
) -> OpenLoop:
    """Table of a profile, see the module.

    Parameters
    ----------
    azimuth, profile : array_like (N,)
        Stations, evenly spaced over one turn, and pitch [rad].
    rotor_speed : float
        [rad/s].
    revolutions : int
        That the table covers; ROSCO holds the last row afterwards.
    step : float, optional
        Azimuth from row to row [rad].  Without: the profile's stations (and time 0), between
        which ROSCO's straight lines are the profile's; or where the profile is written as a
        Fourier series 24 rows in a period of its highest harmonic.
    initial_azimuth : float
        psi_0 [rad].
    interpolation : {"linear", "fourier"}
        How the profile continues between its stations; a led or cut series is always Fourier.
    lag : ActuatorLag, optional
        Actuator that the commands lead.
    keep_harmonics : int, optional
        How many harmonics are kept, all without.

    Raises
    ------
    InputError
        If a number is out of range.
    """
    psi, beta = even_turn(azimuth, profile)
    start = finite_number("initial_azimuth", initial_azimuth)
    lead_in = _to_station(psi, start) if step is None else 0.0
    if lag is not None or keep_harmonics is not None or interpolation == "fourier":
        series = truncated(harmonics(psi, beta), keep_harmonics)
        if lag is not None:
            series = led_command(series, lag, rotor_speed)
        psi, beta = _samples(series)
        interpolation = "fourier"
        lead_in = 0.0
        if step is None:
            step = 2.0 * np.pi / max(_ROWS_A_PERIOD * (series.cosine.size - 1), 72)
    motion = blade_motion(
        psi,
        beta,
        rotor_speed=rotor_speed,
        blades=BLADES,
        step=step,
        revolutions=revolutions,
        interpolation=interpolation,
        initial_azimuth=start + lead_in,
    )
    time, pitch = motion.time, motion.pitch
    if lead_in > 0.0:
        first = start + 2.0 * np.pi / BLADES * np.arange(BLADES)
        pitch = np.column_stack([np.interp(first, psi, beta, period=2.0 * np.pi), pitch])
        time = np.append(0.0, time + lead_in / rotor_speed)
    return OpenLoop(
        time=time,
        pitch=pitch,
        rotor_speed=rotor_speed,
        initial_azimuth=initial_azimuth,
        lag=lag,
    )


def _to_station(azimuth: FloatArray, start: float) -> float:
    """Angle from `start` on to the next of evenly spaced stations [rad]."""
    spacing = 2.0 * np.pi / azimuth.size
    rest = float(np.mod(azimuth[0] - start, spacing))
    return rest if 1e-9 < rest < spacing - 1e-9 else 0.0


def _samples(series: Harmonics) -> tuple[FloatArray, FloatArray]:
    """Stations that determine a series, and its values there."""
    count = 2 * series.cosine.size
    psi = 2.0 * np.pi * np.arange(count) / count
    return psi, series(psi)


def check_open_loop(
    loop: OpenLoop, *, lowest: float = -np.inf, highest: float = np.inf, rate: float = np.inf,
    series: Harmonics | None = None,
) -> None:  # fmt: skip
    """Refuse commands beyond the actuators' range [rad] and rate [rad/s].

    Parameters
    ----------
    loop : OpenLoop
    lowest, highest, rate : float
    series : Harmonics, optional
        What the blades should do; the message then says how many harmonics would go.

    Raises
    ------
    InputError
        Saying what the commands need.
    """
    needs = []
    low, high, fast = float(loop.pitch.min()), float(loop.pitch.max()), loop.rate
    if low < lowest - _TINY or high > highest + _TINY:
        needs.append(
            f"{math.degrees(low):.4g} to {math.degrees(high):.4g} deg, the range is "
            f"{math.degrees(lowest):.4g} to {math.degrees(highest):.4g} deg"
        )
    if fast > rate * (1.0 + _ROUND):
        needs.append(
            f"{math.degrees(fast):.4g} deg/s, the largest rate is {math.degrees(rate):.4g} deg/s"
        )
    if not needs:
        return
    hint = "expected a profile with less travel"
    if loop.lag is not None and series is not None:
        count = harmonics_within(
            series, loop.lag, loop.rotor_speed, rate=rate, lowest=lowest, highest=highest
        )
        hint = (
            f"expected at most the first {count} harmonics (--keep-harmonics {count})"
            if count
            else "not even the first harmonic alone can be led within them"
        )
    raise InputError(f"command: needs {'; and '.join(needs)}; {hint}")


def open_loop_file(loop: OpenLoop, *, label: str = "") -> str:
    """Text of the table, with a header that :func:`read_open_loop` understands."""
    lag = loop.lag
    actuator = "none"
    if lag is not None:
        kind = (
            f"first order; time_constant_s = {lag.time_constant!r}"
            if lag.order == 1
            else f"second order; frequency_rad_s = {lag.frequency!r}; damping = {lag.damping!r}"
        )
        actuator = f"{kind}; amplitude = {str(lag.amplitude).lower()}"
    head = [
        f"pitch of each blade over time at constant rotor speed, for ROSCO {VERSIONS} (OL_Mode 1)",
        f"rotor_speed_rpm = {loop.rotor_speed * 30.0 / math.pi!r}",
        f"initial_azimuth_deg = {math.degrees(loop.initial_azimuth)!r}",
        "that is blade 1 at time 0; 0 is up, growing clockwise seen from upwind;",
        "blades 2 and 3 stand 120 and 240 deg further; pitch is positive towards feather",
        f"actuator led = {actuator}",
        *([f"profile: {' '.join(label.split())}"] if label else []),
        "    ".join(f"{name:>19}" for name in _COLUMNS),
        "    ".join(f"{name:>19}" for name in _UNITS),
    ]
    rows = ("  ".join(f"{value: .15e}" for value in row) for row in zip(loop.time, *loop.pitch,
                                                                      strict=True))  # fmt: skip
    return "\n".join((*(f"! {line}" for line in head), *rows)) + "\n"


def read_open_loop(
    path: str | os.PathLike[str],
    *,
    rotor_speed: float | None = None,
    initial_azimuth: float | None = None,
) -> OpenLoop:
    """Read a table as ROSCO does: comments first, then time and the blades' pitch.

    Parameters
    ----------
    path : path
    rotor_speed, initial_azimuth : float, optional
        [rad/s] and [rad], for a file whose header does not say them.

    Raises
    ------
    InputError
        If the file is something else, or says no rotor speed and none is given.
    """
    lines = read_text(path, "open-loop file").splitlines()
    first = next((k for k, line in enumerate(lines) if not re.search("[!#%]", line)), len(lines))
    said: dict[str, str] = {}
    for name, value in re.findall(r"(\w+) = ([^\s;]+)", " ".join(lines[:first])):
        said.setdefault(name, value)
    shown = os.fspath(path)
    try:
        table = np.array([line.split()[:4] for line in lines[first:] if line.strip()], dtype=float)
        known = {name: float(said[name]) for name in _NUMBERS if name in said}
    except ValueError as error:
        raise InputError(
            f"open-loop file: {shown!r} needs rows of time and three pitch angles after lines "
            f"that begin with ! ({error})"
        ) from error
    if table.ndim != 2 or table.shape[1] != 4:
        raise InputError(f"open-loop file: {shown!r} has {max(len(lines) - first, 0)} rows, "
                         "expected rows of time and three pitch angles")  # fmt: skip
    if rotor_speed is None:
        if "rotor_speed_rpm" not in known:
            raise InputError(
                f"rotor_speed: {shown!r} says none in its header, expected it as an argument"
            )
        rotor_speed = known["rotor_speed_rpm"] * math.pi / 30.0
    if initial_azimuth is None:
        initial_azimuth = math.radians(known.get("initial_azimuth_deg", 0.0))
    lag = None
    if "time_constant_s" in known or "frequency_rad_s" in known:
        lag = ActuatorLag(
            time_constant=known.get("time_constant_s"),
            frequency=known.get("frequency_rad_s"),
            damping=known.get("damping"),
            amplitude=said.get("amplitude", "true") == "true",
        )
    try:
        return OpenLoop(
            time=table[:, 0],
            pitch=table[:, 1:].T,
            rotor_speed=rotor_speed,
            initial_azimuth=initial_azimuth,
            lag=lag,
        )
    except InputError as error:
        raise InputError(f"open-loop file: {shown!r}: {error}") from error


def open_loop_lines(loop: OpenLoop, name: str = OPEN_LOOP_NAME) -> list[DisconLine]:
    """Parameters that make ROSCO follow the table in a file of this name.

    Those of an actuator are among them if the table leads one, which is then ROSCO's.
    """
    lag = loop.lag
    lines = [
        DisconLine(name="PC_ControlMode", value="1",
                   comment="the table is read in the pitch controller, whose own command it takes "
                           "the place of"),
        DisconLine(name="IPC_ControlMode", value="0", comment="the table overwrites it"),
        DisconLine(name="OL_Mode", value="1", comment="open loop over time"),
        DisconLine(name="AWC_Mode", value="0", comment="would add to the table"),
        DisconLine(name="PA_Mode", value=str(0 if lag is None else lag.order),
                   comment="actuator model: 0 none, 1 first order, 2 second order"),
        DisconLine(name="OL_Filename", value=f'"{name}"', comment="relative to this file"),
        DisconLine(name="OL_BP_Mode", value="0", comment="the table is over time"),
        DisconLine(name="Ind_Breakpoint", value="1", comment="column of the time [s]"),
        DisconLine(name="Ind_BldPitch", value="2 3 4", comment="columns of the blades [rad]"),
        DisconLine(name="Ind_GenTq", value="0", comment="torque stays ROSCO's own"),
        DisconLine(name="Ind_YawRate", value="0"),
        DisconLine(name="Ind_Azimuth", value="0", comment="of OL_Mode 2 alone"),
    ]  # fmt: skip
    if lag is not None:
        corner = lag.frequency if lag.time_constant is None else 1.0 / lag.time_constant
        lines.append(
            DisconLine(name="PA_CornerFreq", value=f"{corner:.10g}", comment="of the actuator "
                       "that the table leads [rad/s]")
        )  # fmt: skip
        if lag.damping is not None:
            lines.append(DisconLine(name="PA_Damping", value=f"{lag.damping:.10g}"))
    return lines


def openfast_notes(loop: OpenLoop) -> list[str]:
    """What the simulation must have for the table to fit, in words."""
    pitch = ", ".join(f"{angle:.6g}" for angle in np.rad2deg(loop.pitch[:, 0]))
    low, high, fast = float(loop.pitch.min()), float(loop.pitch.max()), loop.rate
    rpm, start = loop.rotor_speed * 30.0 / math.pi, math.degrees(loop.initial_azimuth)
    return [
        (
            f"ElastoDyn: GenDOF False, RotSpeed {rpm:.10g} rpm, Azimuth {start:g} deg, "
            f"BlPitch {pitch} deg"
        ),
        "ServoDyn: PCMode 5 from time 0 on, Ptch_Cntrl 1 (with 0 ROSCO refuses to start)",
        f"the table ends after {loop.time[-1]:.6g} s, the last pitch is held then",
        (
            f"commands from {math.degrees(low):.6g} to {math.degrees(high):.6g} deg at up to "
            f"{math.degrees(fast):.4g} deg/s:"
        ),
        f"limits of ROSCO that do not cut them: {low:.6g} to {high:.6g} rad, {fast:.4g} rad/s",
    ]


def open_loop_discon(loop: OpenLoop, name: str = OPEN_LOOP_NAME) -> str:
    """The lines as a text to paste, with what the simulation must have."""
    return discon_text("OPEN LOOP INDIVIDUAL PITCH", openfast_notes(loop),
                       open_loop_lines(loop, name))  # fmt: skip


def check_discon_limits(loop: OpenLoop, text: str) -> None:
    """Refuse a ``DISCON.IN`` whose range or rate would cut the commands.

    Raises
    ------
    InputError
        Naming the limit.
    """
    low, high, fast = float(loop.pitch.min()), float(loop.pitch.max()), loop.rate
    for name, need, sense, room in (
        ("PC_MinPit", low, -1.0, 1e-6),
        ("PC_MaxPit", high, 1.0, 1e-6),
        ("PC_MaxRat", fast, 1.0, 1e-3 * fast),
        ("PC_MinRat", -fast, -1.0, 1e-3 * fast),
    ):
        limit = discon_numbers(text, name, 1)
        if limit is not None and sense * (limit[0] - need) < -room:
            raise InputError(
                f"{name}: the DISCON file has {limit[0]:g}, the commands need {need:.6g}; "
                "expected a limit that does not cut them"
            )
