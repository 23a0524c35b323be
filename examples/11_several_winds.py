"""One profile for several winds: best on average, and with the least largest regret.

What ``pitchopt robust --winds 13,15,17 --mu 10`` does, through the library.

    python 11_several_winds.py [FOLDER] [--quick]
"""

import argparse
from pathlib import Path

from pitchopt.cases import load_case
from pitchopt.design import robust
from pitchopt.exports import write_files
from pitchopt.plotting import png, several_figures


def main(argv=None):
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("folder", nargs="?", default="example-output", type=Path)
    parser.add_argument("--quick", action="store_true", help="coarser")
    args = parser.parse_args(argv)

    case = load_case("biegel2011")
    if args.quick:
        case = case.with_values({"aero.segments": 10, "limits.positions": 6})
    speeds = (13.0, 15.0, 17.0)
    tasks = [case.with_values({"wind.speed": speed}).task() for speed in speeds]
    labels = [f"{speed:g} m/s" for speed in speeds]
    files = {}
    for goal in ("mean", "regret"):
        found = robust(tasks, mu=10.0, goal=goal, labels=labels, starts=1 if args.quick else 3)
        print(f"{goal}: {found.status.value}, largest regret {found.largest_regret:.4g} N m")
        for wind in found.winds:
            print(f"  {wind.label}: mean torque {wind.mean_torque:.4g}, regret {wind.regret:.4g}")
        if goal == "regret":
            print(f"  proven: at least {max(-found.upper_bound, 0.0):.4g} N m for any profile")
        profiles, regrets = several_figures(found, title=f"{case.name}, {goal}")
        files[f"11_profiles_{goal}.png"] = png(profiles)
        files[f"11_regrets_{goal}.png"] = png(regrets)
    args.folder.mkdir(parents=True, exist_ok=True)
    for path in write_files(args.folder, files):
        print(path)


if __name__ == "__main__":
    main()
