"""A turbine of one's own, from a windIO version 2 file.

``data/example-1.5MW-77.yaml`` is made up; it shows what pitchopt reads of such a file.  Below
rated wind: the profile of least load variation for 1 % of torque.

    python 05_own_turbine.py [FOLDER] [--quick]
"""

import argparse
from pathlib import Path

import numpy as np

from pitchopt.cases import AeroSettings, Case, LimitSettings, WindSettings
from pitchopt.design import constant, design, power_max
from pitchopt.plotting import loads_figure, png

TURBINE = Path(__file__).parent / "data" / "example-1.5MW-77.yaml"


def main(argv=None):
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("folder", nargs="?", default="example-output", type=Path)
    parser.add_argument("--quick", action="store_true", help="coarser")
    args = parser.parse_args(argv)
    args.folder.mkdir(parents=True, exist_ok=True)

    case = Case(
        name="example-1.5MW",
        turbine=str(TURBINE),
        wind=WindSettings(speed=8.0, shear="log", roughness_length=0.05),
        aero=AeroSettings(
            segments=10 if args.quick else 40,
        ),
        limits=LimitSettings(positions=6 if args.quick else 24),
    )
    task = case.task()
    best = constant(task)
    most = power_max(task, reference=best)
    found = design(task, max_power_loss=0.01, starts=1 if args.quick else 3, certify=False)
    rpm = case.rotor_speed * 30 / np.pi
    print(f"{case.name} at {case.wind.speed:g} m/s, {rpm:.2f} rpm: {found.status.value}")
    print(f"torque lost {100 * (1 - found.mean_torque / most.mean_torque):.2f} %")
    for load, value in found.rms.items():
        print(f"RMS of {load:<7} {best.rms[load]:10.1f} -> {value:10.1f}")
    target = args.folder / "05_loads.png"
    target.write_bytes(png(loads_figure({"1 % lost": found, "constant": best}, title=case.name)))
    print(target)


if __name__ == "__main__":
    main()
