"""A profile replayed by ROSCO in OpenFAST: NREL 5 MW, 15 m/s, 12.1 rpm, actuators of 0.3 s.

The table holds the command of each blade over time.  An actuator that lags would turn the profile
late and flatten it; the command leads by just that.  The pitch rate allows so many harmonics:
those beyond are left out.  Beside the table stand the lines of DISCON.IN that switch it on.

    python 30_rosco_open_loop.py [FOLDER] [--quick]
"""

import argparse
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

from pitchopt.cases import load_case
from pitchopt.design import design
from pitchopt.exports import (
    ActuatorLag,
    check_open_loop,
    harmonics,
    open_loop,
    open_loop_discon,
    open_loop_file,
    truncated,
    write_files,
)
from pitchopt.exports.lead import harmonics_within
from pitchopt.plotting import png


def behind(command, time, lag):
    """Pitch (T,) of an actuator of first order that starts at the first command."""
    pitch = np.empty_like(command)
    pitch[0] = command[0]
    keep = np.exp(-np.diff(time) / lag.time_constant)
    for k, share in enumerate(keep):
        pitch[k + 1] = share * pitch[k] + (1 - share) * 0.5 * (command[k] + command[k + 1])
    return pitch


def main(argv=None):
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("folder", nargs="?", default="example-output", type=Path)
    parser.add_argument("--quick", action="store_true", help="coarser")
    args = parser.parse_args(argv)

    case = load_case("nrel-5mw").with_values(
        {"wind.speed": 15.0, "operation.rotor_speed": 12.1 * np.pi / 30}
    )
    if args.quick:
        case = case.with_values({"aero.segments": 10, "limits.positions": 6})
    speed, rate = case.rotor_speed, case.turbine_data.pitch_rate
    found = design(
        case.task(),
        mean_torque=case.turbine_data.rated_torque,
        starts=1 if args.quick else 5,
        certify=False,
    )
    series = harmonics(found.azimuth, found.profile)
    lag = ActuatorLag(time_constant=0.3)
    kept = harmonics_within(series, lag, speed, rate=rate)
    print(
        f"{series.cosine.size - 1} harmonics; {kept} can be led within {np.rad2deg(rate):g} deg/s"
    )

    tables = {
        name: open_loop(
            found.azimuth, found.profile, rotor_speed=speed, lag=lead, keep_harmonics=kept
        )
        for name, lead in (("with lead", lag), ("without lead", None))
    }
    loop = tables["with lead"]
    check_open_loop(loop, rate=rate)
    print(f"command: {np.rad2deg(loop.rate):.3g} deg/s at most, {loop.time.size} rows")

    figure = Figure(figsize=(7, 4.5), layout="constrained")
    axes = figure.subplots()
    wanted = truncated(series, kept)
    for name, table in tables.items():
        pitch = behind(table.pitch[0], table.time, lag)
        turned = speed * table.time
        last = turned > turned[-1] - 2 * np.pi - 1e-9
        off = np.abs(pitch - wanted(turned))[last].max()
        print(f"{name}: blade off by {np.rad2deg(off):.3f} deg of "
              f"{np.rad2deg(np.ptp(wanted(turned))):.3f} deg of travel")  # fmt: skip
        place = np.rad2deg(turned[last] - (turned[-1] - 2 * np.pi))
        axes.plot(place, np.rad2deg(pitch[last]), label=f"blade, {name}")
        if table is loop:
            axes.plot(place, np.rad2deg(table.pitch[0][last]), "--", label="command with lead")
    place = np.linspace(0, 2 * np.pi, 361)
    axes.plot(np.rad2deg(place), np.rad2deg(wanted(place)), "k:", lw=2, label="profile")
    axes.set_xlabel("azimuth of blade 1 [deg]")
    axes.set_ylabel("pitch [deg]")
    axes.set_xticks(range(0, 361, 60))
    axes.legend()
    axes.grid(visible=True, alpha=0.3)

    write_files(args.folder, {"30_lead.png": png(figure)})
    files = {
        "pitch_open_loop.dat": open_loop_file(loop, label="mean torque held"),
        "discon_open_loop.txt": open_loop_discon(loop),
    }
    for path in write_files(args.folder / "30_rosco", files):
        print(path)
    print(files["discon_open_loop.txt"])


if __name__ == "__main__":
    main()
