"""The least load variation for a stated loss of torque, through the library.

What ``pitchopt design --case nrel-5mw --max-power-loss 2%`` does, with the result at hand: its
status, its bound, its harmonics.

    python 06_max_power_loss.py [FOLDER] [--quick]
"""

import argparse
from pathlib import Path

import numpy as np

from pitchopt.cases import load_case
from pitchopt.design import constant, design
from pitchopt.exports import harmonics, harmonics_csv, write_whole


def main(argv=None):
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("folder", nargs="?", default="example-output", type=Path)
    parser.add_argument("--quick", action="store_true", help="coarser")
    args = parser.parse_args(argv)

    case = load_case("nrel-5mw")
    if args.quick:
        case = case.with_values(
            {
                "aero.segments": 10,
                "limits.positions": 6,
            }
        )
    task = case.task()
    best = constant(task)
    found = design(task, max_power_loss=0.02, starts=1 if args.quick else 5)
    print(f"{case.name} at {case.wind.speed:g} m/s: {found.status.value}, {found.message}")
    print(f"weighted RMS {best.rms_weighted:.4g} -> {found.rms_weighted:.4g} N m")
    if found.rms_lower_bound is not None:
        print(f"proven: not below {found.rms_lower_bound:.4g} N m for this torque")
    print(f"blade load {found.loads.blade_rms / best.loads.blade_rms:.3f} of constant pitch")
    series = harmonics(found.azimuth, found.profile)
    for n, (size, phase) in enumerate(zip(series.amplitude, series.phase, strict=True)):
        if n > 3:
            break
        at = np.rad2deg(phase) / max(n, 1)
        print(f"{n}P  {np.rad2deg(size):7.3f} deg, largest at azimuth {at:7.2f} deg")
    print(write_whole(args.folder / "06_harmonics.csv", harmonics_csv(series)))


if __name__ == "__main__":
    main()
