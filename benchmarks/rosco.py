"""Exports for ROSCO in ROSCO's compiled controller, beside ours.

Signals are made up: a rotor at constant speed, root moments with 1P, 2P and a rest.  The
controller's numbers pass a swap array in single precision, which bounds how near figures can come:
about 1e-8 rad in pitch, and 1e-7 of moments and azimuth.

Without the library (see `_rosco.py`) there is one line that says so.

    python benchmarks/rosco.py [--quick] [--out FILE.json]
"""

from __future__ import annotations

import math
import tempfile
from pathlib import Path
from typing import Any

import _harness
import _rosco
import numpy as np

from pitchopt.control import IndividualPitch, signals
from pitchopt.control.parameters import MEMORY_SIZE
from pitchopt.exports import (
    ActuatorLag,
    changed_discon,
    discon_ipc,
    open_loop,
    open_loop_file,
    open_loop_lines,
)
from pitchopt.exports.discon import DisconLine

SPEED = 12.1 * math.pi / 30
STEP = 0.0125
START = 0.2  # collective pitch [rad]
GAIN, OFFSET = 1e-9, 0.3
VERSIONS: set[str | None] = set()  # that the library called itself
LEVEL, FIRST, SECOND, REST = 1e6, 3e5, 2e5, 1e5  # [N m]


def azimuth(time: np.ndarray) -> np.ndarray:
    """Of blade 1, within one turn."""
    return np.mod(SPEED * time, 2 * np.pi)


def moments(time: np.ndarray, *, first: float = FIRST, second: float = 0.0) -> np.ndarray:
    """Root moments (T, 3) with tilt and yaw parts at 1P and 2P and slow ones in the fixed frame."""
    blades = SPEED * time[:, None] + 2 * np.pi / 3 * np.arange(3)
    slow = REST * np.sin(0.3 * time[:, None])
    return (
        LEVEL
        + (first + slow) * np.cos(blades)
        + 0.4 * first * np.sin(blades)
        + second * (np.cos(2 * blades) + 0.5 * np.sin(2 * blades))
    )


def ours(individual: IndividualPitch, time: np.ndarray, measured: np.ndarray) -> np.ndarray:
    """Pitch (T, 3) that our kernel adds; as ROSCO, the first call only resets."""
    from pitchopt.control.part_kernels import individual_pitch

    parameters = individual.parameters()
    memory = np.zeros(MEMORY_SIZE + 2 * parameters.order.size)
    state, added = np.zeros(signals.MEASURED), np.zeros_like(measured)
    for k in range(1, time.size):
        state[signals.AZIMUTH] = SPEED * time[k]
        state[signals.OUT_OF_PLANE : signals.OUT_OF_PLANE + 3] = measured[k]
        command = np.zeros(signals.COMMANDS)
        individual_pitch(parameters, STEP, memory, state, 0.0, command)
        added[k] = command[signals.PITCH_COMMAND :]
    return added


def parts(added: np.ndarray, time: np.ndarray, order: int, offset: float) -> np.ndarray:
    """Tilt and yaw part (T, 2) behind the blades' pitch."""
    blades = order * (SPEED * time[:, None] + 2 * np.pi / 3 * np.arange(3) + offset)
    return 2 / 3 * np.stack([np.sum(added * np.cos(blades), 1), np.sum(added * np.sin(blades), 1)],
                            axis=1)  # fmt: skip


def growth(added: np.ndarray, time: np.ndarray, order: int, offset: float) -> np.ndarray:
    """Mean rate of tilt and yaw part over the second half of a run [rad/s]."""
    found = parts(added, time, order, offset)
    half = time.size // 2
    return np.asarray((found[-1] - found[half]) / (time[-1] - time[half]))


def library_run(library: Path, discon: str, time: np.ndarray, **given: Any) -> np.ndarray:
    """Commands of ROSCO (T, 3)."""
    files = given.pop("files", {})
    with tempfile.TemporaryDirectory() as name:
        for file, text in files.items():
            (Path(name) / file).write_text(text, encoding="ascii")
        state = {
            "time": time,
            "rotor_speed": np.full(time.size, SPEED),
            "azimuth": azimuth(time),
            "moments": np.full((time.size, 3), LEVEL),
            "start": np.full(3, START),
            **given,
        }
        commands = _rosco.run(library, Path(name), discon, state)
        VERSIONS.add(_rosco.version(Path(name)))
        return commands


def individual(report: _harness.Report, library: Path, time: np.ndarray) -> None:
    """1P: ROSCO, its law in numpy, and our kernel."""
    controller = IndividualPitch(gain=np.array([GAIN]), offset=[OFFSET])
    discon = changed_discon(_rosco.DISCON, discon_ipc(controller).lines)
    measured = moments(time)
    theirs = library_run(library, discon, time, moments=measured) - START
    passed = _rosco.band_pass(measured, rotor_speed=SPEED, step=STEP)
    law = _rosco.individual_pitch_law(
        passed, SPEED * time, step=STEP, gain=(2 * GAIN, 0.0), offset=(OFFSET, 0.0), limit=0.2
    )
    double = IndividualPitch(gain=np.array([2 * GAIN]), offset=[OFFSET])
    kernel = ours(double, time, passed)
    undone = library_run(
        library, changed_discon(discon, discon_ipc(controller, filter_gain=1.0).lines), time,
        moments=moments(time),
    ) - START  # fmt: skip
    own = ours(controller, time, measured)
    report.add(
        "individual pitch",
        rosco=VERSIONS.pop(),
        largest_rad=np.abs(theirs).max(),
        library_less_law_rad=np.abs(theirs - law).max(),
        kernel_less_law_rad=np.abs(kernel - law).max(),
        library_less_kernel_rad=np.abs(theirs - kernel).max(),
        growth_ratio=float(np.linalg.norm(growth(theirs, time, 1, OFFSET))
                           / np.linalg.norm(growth(own, time, 1, OFFSET))),
        growth_ratio_filter_gain_1=float(np.linalg.norm(growth(undone, time, 1, OFFSET))
                                         / np.linalg.norm(growth(own, time, 1, OFFSET))),
        band_pass_at_1p=abs(response(1.0)),
        band_pass_at_1p_deg=math.degrees(np.angle(response(1.0))),
    )  # fmt: skip


def response(order: float, *, corrected: bool = False) -> complex:
    """Of the band pass at n times the rotor speed, from its coefficients."""
    z = np.exp(-1j * order * SPEED * STEP)
    d, w, t = 0.7, SPEED, STEP
    top = 2 * t * w * (1 - (z * z if corrected else z))
    bottom = (d * t**2 * w**2 + 2 * t * w + 4 * d) + (2 * d * t**2 * w**2 - 8 * d) * z
    return complex(top / (bottom + (d * t**2 * w**2 - 2 * t * w + 4 * d) * z * z))


def second(report: _harness.Report, library: Path, time: np.ndarray) -> None:
    """2P: what acts of it in ROSCO."""
    lines = [
        DisconLine(name="IPC_ControlMode", value="2"),
        DisconLine(name="IPC_KI", value=f"0.0 {GAIN}"),
        DisconLine(name="IPC_aziOffset", value="0.0 0.2"),
    ]
    measured = moments(time, first=0.0, second=SECOND)
    theirs = library_run(
        library, changed_discon(_rosco.DISCON, lines), time, moments=measured
    ) - START  # fmt: skip
    law = _rosco.individual_pitch_law(
        _rosco.band_pass(measured, rotor_speed=SPEED, step=STEP), SPEED * time, step=STEP,
        gain=(0.0, GAIN), offset=(0.0, 0.2), limit=0.3, second=True,
    )  # fmt: skip
    own = ours(IndividualPitch(gain=np.array([GAIN]), offset=[0.2], order=[2]), time, measured)
    rates, wanted = growth(theirs, time, 2, 0.2), growth(own, time, 2, 0.2)
    report.add(
        "second harmonic",
        library_less_law_rad=np.abs(theirs - law).max(),
        tilt_rate_ratio=rates[0] / wanted[0],
        yaw_rate_ratio=rates[1] / wanted[1],
        band_pass_at_2p=abs(response(2.0)),
        band_pass_at_2p_deg=math.degrees(np.angle(response(2.0))),
        band_pass_at_2p_corrected=abs(response(2.0, corrected=True)),
    )


def closed_loop(report: _harness.Report, library: Path, time: np.ndarray) -> None:
    """A rigid rotor whose moments follow the pitch: time until tilt and yaw fall to 1/e."""
    stiffness = 5e7  # [N m/rad]
    gain = 0.1 * SPEED / stiffness
    measured = moments(time)
    measured[:] = LEVEL + FIRST * np.cos(SPEED * time[:, None] + 2 * np.pi / 3 * np.arange(3))
    figures = {}
    for name, share in (("filter_gain_default", 0.5), ("filter_gain_1", 1.0)):
        section = discon_ipc(IndividualPitch(gain=np.array([gain])), filter_gain=share)
        pitch = library_run(
            library, changed_discon(_rosco.DISCON, section.lines), time, moments=measured,
            stiffness=stiffness,
        ) - START  # fmt: skip
        left = FIRST - stiffness * parts(pitch, time, 1, 0.0)[:, 0]
        figures[f"seconds_{name}"] = float(time[np.flatnonzero(left < FIRST / math.e)[0]])
    report.add("closed loop", seconds_ours=1.0 / (gain * stiffness), **figures)


def profile() -> tuple[np.ndarray, np.ndarray]:
    """A made-up profile of 72 stations with harmonics up to 4P."""
    psi = 2 * np.pi * np.arange(72) / 72
    beta = START + 0.02 * np.cos(psi - 0.5) + 0.008 * np.sin(2 * psi) + 0.004 * np.cos(3 * psi + 1)
    return psi, beta + 0.002 * np.sin(4 * psi)


def table(report: _harness.Report, library: Path, time: np.ndarray) -> None:
    """Open loop: commands over the profile, and the blades behind ROSCO's own actuator."""
    psi, beta = profile()
    turns = math.ceil(SPEED * time[-1] / (2 * np.pi)) + 1
    start = 0.7
    place = start + SPEED * time[:, None] + 2 * np.pi / 3 * np.arange(3)
    lines = np.interp(place, psi, beta, period=2 * np.pi)
    loop = open_loop(psi, beta, rotor_speed=SPEED, revolutions=turns, initial_azimuth=start)
    got = follow(library, loop, time)
    report.add(
        "open loop",
        rows=loop.time.size,
        library_less_profile_rad=np.abs(got - lines)[1:].max(),
        first_call_rad=float(np.abs(got[0] - START).max()),
        travel_rad=float(np.ptp(beta)),
    )
    smooth = profile_between(place)
    settled = time > time[-1] - 4 * np.pi / SPEED
    for name, lag in (
        ("first order", ActuatorLag(time_constant=0.4)),
        ("second order", ActuatorLag(frequency=6.0, damping=0.8)),
    ):
        figures = {}
        for which, led in (("with_lead", lag), ("phase_only", phase_alone(lag)), ("without", None)):
            loop = open_loop(
                psi, beta, rotor_speed=SPEED, revolutions=turns, initial_azimuth=start, lag=led,
                interpolation="fourier",
            )  # fmt: skip
            got = follow(library, loop, time, actuator=lag)
            figures[f"blade_less_profile_{which}_rad"] = float(np.abs(got - smooth)[settled].max())
        report.add("lead", actuator=name, travel_rad=float(np.ptp(beta)), **figures)


def phase_alone(lag: ActuatorLag) -> ActuatorLag:
    """The same actuator, led in phase alone."""
    return ActuatorLag(
        time_constant=lag.time_constant, frequency=lag.frequency, damping=lag.damping,
        amplitude=False,
    )  # fmt: skip


def profile_between(place: np.ndarray) -> np.ndarray:
    """The made-up profile at any azimuth."""
    return np.asarray(
        START
        + 0.02 * np.cos(place - 0.5)
        + 0.008 * np.sin(2 * place)
        + 0.004 * np.cos(3 * place + 1)
        + 0.002 * np.sin(4 * place)
    )


def follow(
    library: Path, loop: Any, time: np.ndarray, actuator: ActuatorLag | None = None
) -> np.ndarray:
    """Commands of ROSCO with a table, behind an actuator if one is named."""
    discon = changed_discon(_rosco.DISCON, open_loop_lines(loop))
    if actuator is not None:
        corner = actuator.frequency or 1.0 / (actuator.time_constant or 1.0)
        discon = changed_discon(
            discon,
            [
                DisconLine(name="PA_Mode", value=str(actuator.order)),
                DisconLine(name="PA_CornerFreq", value=repr(corner)),
                DisconLine(name="PA_Damping", value=repr(actuator.damping or 0.7)),
            ],
        )
    files = {"pitch_open_loop.dat": open_loop_file(loop)}
    return library_run(library, discon, time, files=files)


def main(argv: list[str] | None = None) -> None:
    given = _harness.options(__doc__, argv)
    library = _rosco.find_library()
    out = None if library is None else given.out  # a record made with the library stays
    report = _harness.Report("rosco", quick=given.quick, out=out)
    if library is None:
        report.add("no library", hint="pip install --no-deps --target FOLDER rosco")
    else:
        time = STEP * np.arange(4000 if given.quick else 16000)
        individual(report, library, time)
        second(report, library, time)
        closed_loop(report, library, time)
        table(report, library, time[: time.size // 2])
    report.close()


if __name__ == "__main__":
    main()
