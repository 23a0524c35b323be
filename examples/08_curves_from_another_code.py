"""Design on a table of loads over pitch that another aerodynamic code made.

The table says, for every azimuth station, what one blade contributes at some pitch angles:
torque, bending about the rotor centre, thrust.  Here a formula stands in for the other code.  The
table goes through a CSV file, as it would come from elsewhere.

    python 08_curves_from_another_code.py [FOLDER] [--quick]
"""

import argparse
from pathlib import Path

import numpy as np

from pitchopt import BladeCurves
from pitchopt.cases import Case, LimitSettings, ObjectiveSettings, OperationSettings
from pitchopt.design import constant, design, power_max

BLADES = 3


def other_code(azimuth, pitch):
    """Torque [N m], bending [N m] and thrust [N] of one blade; azimuth and pitch in rad."""
    wind = 1.0 + 0.08 * np.cos(azimuth) - 0.06 * np.exp(-(((azimuth - np.pi) / 0.3) ** 2))
    best = np.deg2rad(4.0) + 0.5 * (wind - 1.0)
    torque = 4e5 * wind**2 * (1.0 - 12.0 * (pitch - best) ** 2)
    thrust = 1.2e5 * wind**1.5 * (1.0 - 2.5 * pitch)
    return torque, 25.0 * thrust, thrust


def main(argv=None):
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("folder", nargs="?", default="example-output", type=Path)
    parser.add_argument("--quick", action="store_true", help="fewer stations and pitch angles")
    args = parser.parse_args(argv)
    args.folder.mkdir(parents=True, exist_ok=True)

    positions, pitches = (6, 15) if args.quick else (24, 41)
    azimuth = 2 * np.pi * np.arange(BLADES * positions) / (BLADES * positions)
    pitch = np.tile(np.deg2rad(np.linspace(-5.0, 15.0, pitches)), (azimuth.size, 1))
    torque, bending, thrust = other_code(azimuth[:, None], pitch)
    table = BladeCurves(
        blades=BLADES, azimuth=azimuth, beta=pitch, torque=torque, bending=bending, thrust=thrust
    )
    path = table.save(args.folder / "08_curves.csv")
    print(f"{path}: {positions} rotor positions, torque concave in pitch: {table.concave}")

    # on the command line:
    # pitchopt design --curves 08_curves.csv --rotor-speed-rpm 12 --max-power-loss 2%
    #                 --weights torque=1,tilt=1,yaw=1,thrust=80
    case = Case(
        name="another-code",
        curves=path,
        operation=OperationSettings(rotor_speed=12.0 * np.pi / 30),
        limits=LimitSettings(pitch_rate=np.deg2rad(8.0)),
        objective=ObjectiveSettings(
            weights={"torque": 1.0, "tilt": 1.0, "yaw": 1.0, "thrust": 80.0}, blade_cap=1.0
        ),
    )
    task = case.task()
    best = constant(task)
    most = power_max(task, reference=best)
    found = design(task, max_power_loss=0.02, starts=1 if args.quick else 5)
    lost = 1.0 - found.mean_torque / most.mean_torque
    print(f"{found.status.value}: {100 * lost:.2f} % of mean torque lost")
    print(f"weighted RMS {best.rms_weighted:.4g} -> {found.rms_weighted:.4g} N m")


if __name__ == "__main__":
    main()
