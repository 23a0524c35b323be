"""The wind over the rotor disc: figure 2 of the paper.

Baseline 15 m/s, vertical shear 0.2, horizontal shear 5e-4, and the tower's shadow.  The view is
downwind, so y (positive to the left) grows to the left.

    python 01_wind_field.py [FOLDER] [--quick]
"""

import argparse
from pathlib import Path

from matplotlib.figure import Figure

from pitchopt.cases import load_case
from pitchopt.plotting import plot_wind_field, png
from windfield import sample_disc


def main(argv=None):
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("folder", nargs="?", default="example-output", type=Path)
    parser.add_argument("--quick", action="store_true", help="coarser")
    args = parser.parse_args(argv)
    args.folder.mkdir(parents=True, exist_ok=True)

    case = load_case("biegel2011")
    rotor = case.rotor()
    sample = sample_disc(
        case.wind_field(),
        rotor.radius,
        x=-rotor.overhang,
        rings=20 if args.quick else 80,
        azimuths=60 if args.quick else 240,
        closed=True,
    )
    figure = Figure(figsize=(6.0, 4.8), layout="constrained")
    plot_wind_field(sample, ax=figure.add_subplot())
    target = args.folder / "01_wind_field.png"
    target.write_bytes(png(figure))
    print(f"wind from {sample.speed.min():.2f} to {sample.speed.max():.2f} m/s: {target}")


if __name__ == "__main__":
    main()
