"""A profile as a table and as harmonics, for anything that reads CSV, and read back.

python 32_csv_and_harmonics.py [FOLDER] [--quick]
"""

import argparse
from pathlib import Path

import numpy as np

from pitchopt.cases import load_case
from pitchopt.design import design
from pitchopt.exports import (
    harmonics,
    harmonics_csv,
    profile_csv,
    read_harmonics_csv,
    read_profile_csv,
    write_files,
)


def main(argv=None):
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("folder", nargs="?", default="example-output", type=Path)
    parser.add_argument("--quick", action="store_true", help="coarser")
    args = parser.parse_args(argv)

    case = load_case("biegel2011")
    if args.quick:
        case = case.with_values({"limits.positions": 6, "aero.segments": 10})
    found = design(case.task(), max_power_loss=0.03, starts=1, certify=False)
    series = harmonics(found.azimuth, found.profile)
    table, waves = write_files(
        args.folder,
        {
            "32_profile.csv": profile_csv(
                found.azimuth, found.profile, rotor_speed=case.rotor_speed
            ),
            "32_harmonics.csv": harmonics_csv(series),
        },
    )
    print(table.read_text(encoding="utf-8").splitlines()[0])
    for line in waves.read_text(encoding="utf-8").splitlines()[:5]:
        print(line)

    azimuth, pitch = read_profile_csv(table)
    again = read_harmonics_csv(waves)
    print(f"table read back: off by {np.abs(pitch - found.profile).max():.1e} rad")
    print(f"harmonics at the stations: off by {np.abs(again(azimuth) - pitch).max():.1e} rad")
    largest = np.argsort(again.amplitude[1:])[::-1][:3] + 1
    print(
        "largest: " + ", ".join(f"{n}P {np.rad2deg(again.amplitude[n]):.3f} deg" for n in largest)
    )


if __name__ == "__main__":
    main()
