"""A polar with its concave and convex fits and their limits: figure 4 of the paper.

The fits are best fits between two angles of attack, not envelopes; their largest error is
reported.

    python 02_polar_fit.py [FOLDER] [--quick]
"""

import argparse
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

from pitchopt.aero import fit_polar
from pitchopt.cases import load_case
from pitchopt.plotting import plot_polar_fit, png


def main(argv=None):
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("folder", nargs="?", default="example-output", type=Path)
    parser.add_argument("--quick", action="store_true", help="fewer segments")
    args = parser.parse_args(argv)
    args.folder.mkdir(parents=True, exist_ok=True)

    polar = load_case("biegel2011").rotor().blade.polars[-1]
    low, high = np.deg2rad(-5.0), polar.stall_angle()
    fit = fit_polar(polar, (low, high), segments=8 if args.quick else 40)
    figure = Figure(figsize=(6.8, 5.0), layout="constrained")
    plot_polar_fit(polar, fit, ax=figure.add_subplot())
    target = args.folder / "02_polar_fit.png"
    target.write_bytes(png(figure))
    print(
        f"{polar.name}, {np.rad2deg(low):.1f} to {np.rad2deg(high):.1f} deg: largest error in lift "
        f"{fit.cl_error:.4f}, in drag {fit.cd_error:.4f}: {target}"
    )


if __name__ == "__main__":
    main()
