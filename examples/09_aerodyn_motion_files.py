"""Motion files for the AeroDyn driver: NREL 5 MW, 15 m/s, 12.1 rpm, mean torque held.

Above rated wind the mean torque is not for sale: the profile keeps that of the constant pitch
which gives rated torque, and the blade load stays at its value there.  The files pitch_b1.csv ...
replay the profile; pitch_constant_b1.csv ... replay the constant pitch that it is compared with.

    python 09_aerodyn_motion_files.py [FOLDER] [--quick]
"""

import argparse
from pathlib import Path

import numpy as np

from pitchopt.cases import load_case
from pitchopt.design import design
from pitchopt.design.constant_pitch import constant_for_torque
from pitchopt.exports import blade_motion, motion_files, write_files
from pitchopt.exports.aerodyn import driver_block


def main(argv=None):
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("folder", nargs="?", default="example-output", type=Path)
    parser.add_argument("--quick", action="store_true", help="coarser")
    args = parser.parse_args(argv)

    case = load_case("nrel-5mw").with_values(
        {"wind.speed": 15.0, "operation.rotor_speed": 12.1 * np.pi / 30}
    )
    if args.quick:
        case = case.with_values(
            {
                "aero.segments": 10,
                "limits.positions": 6,
            }
        )
    task = case.task()
    rated = case.turbine_data.rated_torque
    best = constant_for_torque(task, rated)
    found = design(task, mean_torque=rated, starts=1 if args.quick else 5, certify=False)
    print(f"{found.status.value}: mean torque {found.mean_torque:.5g} N m, wanted {rated:.5g}")
    print(f"constant pitch {np.rad2deg(best.profile[0]):.3f} deg")
    for load, value in found.rms.items():
        print(f"predicted cut of {load:<7} {100 * (1 - value / best.rms[load]):6.1f} %")

    files = {}
    for stem, profile in (("pitch", found), ("pitch_constant", best)):
        motion = blade_motion(
            profile.azimuth, profile.profile, rotor_speed=case.rotor_speed, blades=case.blades
        )
        mine = motion_files(motion, stem)
        files |= {**mine, f"{stem}_driver_motion.txt": driver_block(tuple(mine), case.rotor_speed)}
    for path in write_files(args.folder / "09_aerodyn", files):
        print(path)


if __name__ == "__main__":
    main()
