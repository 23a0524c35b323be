"""A table of profiles over wind speed, with a bounded change from each to the next.

What ``pitchopt schedule --wind-speeds 13,14,15,16 --max-change-deg 0.5 --mu 10`` does, and what
the bound on the change costs.

    python 12_schedule.py [FOLDER] [--quick]
"""

import argparse
from pathlib import Path

import numpy as np

from pitchopt.cases import load_case
from pitchopt.design import schedule
from pitchopt.exports import schedule_csv, write_files


def main(argv=None):
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("folder", nargs="?", default="example-output", type=Path)
    parser.add_argument("--quick", action="store_true", help="coarser")
    args = parser.parse_args(argv)

    case = load_case("biegel2011")
    if args.quick:
        case = case.with_values({"aero.segments": 10, "limits.positions": 6})
    speeds = (13.0, 14.0, 15.0, 16.0)
    tasks = [case.with_values({"wind.speed": speed}).task() for speed in speeds]
    labels = [f"{speed:g} m/s" for speed in speeds]
    for change_deg in (0.0, 0.5, np.inf):
        found = schedule(
            tasks,
            mu=10.0,
            change=np.deg2rad(change_deg),
            labels=labels,
            starts=1 if args.quick else 3,
            certify=False,
        )
        print(
            f"change up to {change_deg:g} deg: {found.status.value}, mean objective "
            f"{found.objective:.5g} N m, largest change {np.rad2deg(found.largest_change):.2f} deg"
        )
        if change_deg == 0.5:
            table = schedule_csv(found)
    args.folder.mkdir(parents=True, exist_ok=True)
    for path in write_files(args.folder, {"12_schedule.csv": table}):
        print(path)


if __name__ == "__main__":
    main()
