"""Pitch of the three blades and the loads that follow: figures 6 and 7 of the paper.

Solid: the power maximum. Dashed: a trade-off profile, here the least RMS for 3 % of torque lost.
Crosses: the best constant pitch.  The tower is passed at theta = pi/6.

    python 04_profiles_and_loads.py [FOLDER] [--quick]
"""

import argparse
from pathlib import Path

from pitchopt.cases import load_case
from pitchopt.design import constant, design, power_max
from pitchopt.plotting import loads_figure, png, profiles_figure


def main(argv=None):
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("folder", nargs="?", default="example-output", type=Path)
    parser.add_argument("--quick", action="store_true", help="fewer positions and starts")
    args = parser.parse_args(argv)
    args.folder.mkdir(parents=True, exist_ok=True)

    case = load_case("biegel2011")
    if args.quick:
        case = case.with_values({"limits.positions": 6, "aero.segments": 10})
    task = case.task()
    best = constant(task)
    most = power_max(task, reference=best)
    flat = design(task, max_power_loss=0.03, starts=1 if args.quick else 5, certify=False)

    shown = {"power maximum": most, "3 % torque lost": flat}
    for name, figure in (
        ("04_profiles.png", profiles_figure(shown, title="figure 6")),
        ("04_loads.png", loads_figure({**shown, "constant": best}, title="figure 7")),
    ):
        (args.folder / name).write_bytes(png(figure))
        print(args.folder / name)
    for label, found in {**shown, "constant": best}.items():
        rms = ", ".join(f"{load} {value:.3g}" for load, value in found.rms.items())
        print(f"{label:<16} mean torque {found.mean_torque:.4g} N m, RMS {rms}")


if __name__ == "__main__":
    main()
