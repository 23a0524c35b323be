"""Wind of one's own: any function of the position on the disc.

Here a low-level jet, fastest 20 m below the hub, with the tower's shadow in it.

    python 07_own_wind.py [FOLDER] [--quick]
"""

import argparse
from dataclasses import replace
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

from pitchopt.cases import load_case
from pitchopt.design import constant, design
from pitchopt.plotting import plot_profiles, plot_wind_field, png
from windfield import CallableField, sample_disc


def jet(y, z):
    """Wind speed [m/s] at y to the left and z above the hub [m]."""
    return 13.0 + 2.0 * np.exp(-(((z + 20.0) / 25.0) ** 2)) + 0.005 * y


def main(argv=None):
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("folder", nargs="?", default="example-output", type=Path)
    parser.add_argument("--quick", action="store_true", help="coarser")
    args = parser.parse_args(argv)
    args.folder.mkdir(parents=True, exist_ok=True)

    case = load_case("biegel2011")
    if args.quick:
        case = case.with_values({"limits.positions": 6, "aero.segments": 10})
    rotor = case.rotor()
    wind = CallableField(speed=jet, hub_height=rotor.hub_height, tower=case.wind_field().tower)
    task = replace(case.task(), model=replace(case.model(), wind=wind))
    best = constant(task)
    found = design(task, max_power_loss=0.01, starts=1 if args.quick else 3, certify=False)
    print(f"{found.status.value}: least RMS for 1 % of torque")
    print(f"weighted RMS {best.rms_weighted:.4g} -> {found.rms_weighted:.4g} N m")

    figure = Figure(figsize=(11.0, 4.6), layout="constrained")
    left, right = figure.subplots(1, 2)
    plot_wind_field(sample_disc(wind, rotor.radius, x=-rotor.overhang, closed=True), ax=left)
    plot_profiles({"1 % torque lost": found}, ax=right)
    target = args.folder / "07_own_wind.png"
    target.write_bytes(png(figure))
    print(target)


if __name__ == "__main__":
    main()
