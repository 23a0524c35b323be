"""Names and contents of the files of ``pitchopt export``, by format."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import click

from pitchopt.errors import InputError

if TYPE_CHECKING:
    from pitchopt.cli.export_sources import Source
    from pitchopt.control import IndividualPitch
    from pitchopt.exports import ActuatorLag

__all__ = ["Exported", "actuator_lag", "controller_files", "profile_files"]

_REVOLUTIONS = {"aerodyn": 4, "rosco": 60}


@dataclass(frozen=True, kw_only=True)
class Exported:
    """Files by name, and sentences about what they need or leave out."""

    files: dict[str, bytes | str]
    notes: list[str] = field(default_factory=list)


def actuator_lag(options: dict[str, Any]) -> ActuatorLag | None:
    """Actuator that the options name; None without."""
    from pitchopt.exports import ActuatorLag

    tau, omega, zeta = (
        options[name] for name in ("actuator_lag", "actuator_frequency", "actuator_damping")
    )
    if tau is not None and omega is not None:
        raise InputError(
            f"--actuator-lag: got {tau:g} s beside --actuator-frequency, expected an actuator of "
            "first or of second order"
        )
    if (omega is None) != (zeta is None):
        missing = "--actuator-damping" if zeta is None else "--actuator-frequency"
        raise InputError(f"{missing}: got nothing, expected both of an actuator of second order")
    if tau is None and omega is None:
        if options["phase_only"]:
            raise InputError("--phase-only: got no actuator, expected --actuator-lag as well")
        return None
    return ActuatorLag(
        time_constant=tau, frequency=omega, damping=zeta, amplitude=not options["phase_only"]
    )


def profile_files(form: str, source: Source, options: dict[str, Any]) -> Exported:
    """Files of a profile."""
    from pitchopt.exports import (
        blade_motion,
        harmonics,
        harmonics_csv,
        led_command,
        motion_files,
        profile_csv,
        truncated,
    )
    from pitchopt.exports.aerodyn import driver_block

    speed = source.rotor_speed
    lag = actuator_lag(options)
    if form == "rosco":
        return _open_loop(source, lag, options)
    if form == "aerodyn":
        motion = blade_motion(
            source.azimuth,
            source.profile,
            rotor_speed=speed,
            blades=source.blades,
            step=_step(options, speed),
            revolutions=_revolutions("aerodyn", options),
            interpolation=options["interpolation"] or "linear",
        )
        files = motion_files(motion)
        return Exported(files={**files, "driver_motion.txt": driver_block(tuple(files), speed)})
    series = truncated(harmonics(source.azimuth, source.profile), options["keep_harmonics"])
    notes: list[str] = []
    profile = source.profile if options["keep_harmonics"] is None else series(source.azimuth)
    if lag is not None:
        _within(source, series, lag, options, notes)
        series = led_command(series, lag, speed)
        profile = series(source.azimuth)
        notes.append("what is written is the command that leads the actuator, not the pitch")
    if form == "harmonics":
        return Exported(files={"harmonics.csv": harmonics_csv(series)}, notes=notes)
    table = profile_csv(source.azimuth, profile, rotor_speed=speed)
    return Exported(files={"profile.csv": table}, notes=notes)


def _within(
    source: Source, series: Any, lag: ActuatorLag, options: dict[str, Any], notes: list[str]
) -> None:
    """See that a led series keeps the limits, by a table of it over one revolution."""
    from pitchopt.exports import open_loop

    loop = open_loop(
        source.azimuth,
        source.profile,
        rotor_speed=source.rotor_speed,
        revolutions=1,
        lag=lag,
        keep_harmonics=options["keep_harmonics"],
    )
    _limits(loop, series, source, options, notes)


def _limits(
    loop: Any, series: Any, source: Source, options: dict[str, Any], notes: list[str]
) -> None:
    from pitchopt.exports import check_open_loop

    limits = source.limits()
    if not limits:
        notes.append("the file names no limits of the actuators: none were checked")
    try:
        check_open_loop(loop, **limits, series=series)
    except InputError as error:
        if not options["beyond_limits"]:
            raise InputError(f"{error}; --beyond-limits writes it all the same") from error
        notes.append(f"beyond the limits: {error}")


def _step(options: dict[str, Any], speed: float) -> float | None:
    """Azimuth from row to row [rad]."""
    degrees, seconds = options["step_deg"], options["time_step"]
    if degrees is not None and seconds is not None:
        raise InputError(
            f"--time-step: got {seconds:g} s beside --step-deg, expected one of the two"
        )
    if seconds is not None:
        return float(seconds * speed)
    return None if degrees is None else math.radians(degrees)


def _revolutions(form: str, options: dict[str, Any]) -> int:
    return int(options["revolutions"] or _REVOLUTIONS[form])


def _open_loop(source: Source, lag: ActuatorLag | None, options: dict[str, Any]) -> Exported:
    """Table for ROSCO and the lines that switch it on."""
    from pitchopt.exports import (
        changed_discon,
        harmonics,
        open_loop,
        open_loop_discon,
        open_loop_file,
        open_loop_lines,
        read_discon,
        truncated,
    )
    from pitchopt.exports.rosco_open_loop import (
        BLADES,
        OPEN_LOOP_NAME,
        check_discon_limits,
        openfast_notes,
    )

    if source.blades != BLADES:
        raise InputError(f"blades: got {source.blades}, expected three for --format rosco")
    base = None if options["discon"] is None else read_discon(options["discon"])
    loop = open_loop(
        source.azimuth,
        source.profile,
        rotor_speed=source.rotor_speed,
        revolutions=_revolutions("rosco", options),
        step=_step(options, source.rotor_speed),
        initial_azimuth=math.radians(options["initial_azimuth_deg"] or 0.0),
        interpolation=options["interpolation"] or "linear",
        lag=lag,
        keep_harmonics=options["keep_harmonics"],
    )
    notes: list[str] = []
    series = truncated(harmonics(source.azimuth, source.profile), options["keep_harmonics"])
    _limits(loop, series, source, options, notes)
    files: dict[str, bytes | str] = {
        OPEN_LOOP_NAME: open_loop_file(loop, label=source.label),
        "discon_open_loop.txt": open_loop_discon(loop),
    }
    if base is not None:
        check_discon_limits(loop, base)
        notes += _other_actuator(base, lag)
        files["DISCON_open_loop.IN"] = changed_discon(base, open_loop_lines(loop))
    return Exported(files=files, notes=notes + openfast_notes(loop)[:3])


def _other_actuator(base: str, lag: ActuatorLag | None) -> list[str]:
    """What is said when the actuator of a parameter file gives way to that of the table."""
    from pitchopt.exports import discon_numbers

    mode, corner, damping = (
        discon_numbers(base, name, 1) for name in ("PA_Mode", "PA_CornerFreq", "PA_Damping")
    )
    if mode is None or corner is None or mode[0] == 0.0:
        return []
    zeta = 1.0 if damping is None else float(damping[0])
    if mode[0] == 1.0:
        tau = None if lag is None else lag.time_constant
        same = tau is not None and abs(tau * corner[0] - 1.0) < 1e-3
        leads = f"--actuator-lag {1.0 / corner[0]:g}"
    else:
        same = lag is not None and (lag.frequency, lag.damping) == (corner[0], zeta)
        leads = f"--actuator-frequency {corner[0]:g} --actuator-damping {zeta:g}"
    if same:
        return []
    instead = "none" if lag is None else "the one that the table leads"
    return [f"replaced: the DISCON file's actuator, by {instead}; {leads} would lead it"]


def controller_files(
    individual: IndividualPitch, options: dict[str, Any], others: list[str]
) -> Exported:
    """Parameters of ROSCO for individual pitch; `others` says what else the controller has."""
    from pitchopt.exports import changed_discon, discon_ipc, read_discon
    from pitchopt.exports.rosco_ipc import FILTER_GAIN, check_discon_modes

    base = None if options["discon"] is None else read_discon(options["discon"])
    if base is not None:
        check_discon_modes(base)
    section = discon_ipc(
        individual,
        wind_ramp=options["wind_ramp"],
        only_1p=options["only_1p"],
        filter_gain=options["filter_gain"] or FILTER_GAIN,
    )
    files: dict[str, bytes | str] = {"discon_ipc.txt": section.text()}
    if base is not None:
        files["DISCON_ipc.IN"] = changed_discon(base, section.lines)
    return Exported(files=files, notes=[*section.lacks, *others])


def tell(notes: list[str]) -> None:
    """Sentences on standard error."""
    for note in notes:
        click.echo(f"pitchopt: export: {note}", err=True)
