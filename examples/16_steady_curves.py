"""Steady operation of the catalogue's turbines, computed and as the dynamic turbine settles.

Lines are operating points of the steady model in uniform wind: best tip-speed ratio below rated
power, rated speed and power above.  Points are where the dynamic turbine settles under its
controller in steady uniform wind without a tower shadow, with all its degrees of freedom.

    python 16_steady_curves.py [FOLDER] [--quick]
"""

import argparse
from pathlib import Path

import numpy as np

from pitchopt.errors import InputError
from pitchopt.plotting import SteadyCurve, png, steady_curves_figure
from pitchopt.sim import DynamicTurbine, Operation
from pitchopt.studies.simulation import SimulationSettings, run_simulations
from pitchopt.turbines import load_turbine, names

SPEEDS = (4.0, 6.0, 8.0, 10.0, 12.0, 14.0, 17.0, 20.0, 24.0)
CHANNELS = ("RtAeroFxh", "RtAeroMxh", "RotSpeed", "BldPitch1")


def steady_curve(dynamic, speeds, settle):
    """Operating points over the wind speed, and what the turbine settles at after `settle` s."""
    operation = Operation(dynamic)
    settings = SimulationSettings(
        wind_speeds=speeds,
        turbulence="none",
        shear=0.0,
        tower_shadow=False,
        skip=settle,
        duration=20.0,
        channels=CHANNELS,
    )
    result = run_simulations(dynamic, operation.controller(), settings, operation=operation)
    thrust, torque, speed, pitch = (
        np.array([run.statistics[name].mean for run in result.runs]) for name in CHANNELS
    )
    return SteadyCurve(
        name=dynamic.turbine.name,
        rated_power=operation.mechanical_power,
        curve=operation.curve,
        simulated={
            "wind_speed": speeds,
            "power": torque * speed,
            "thrust": thrust,
            "rotor_speed": speed,
            "pitch": pitch,
        },
    )


def main(argv=None):
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("folder", nargs="?", default="example-output", type=Path)
    parser.add_argument("--quick", action="store_true", help="two turbines, two wind speeds")
    args = parser.parse_args(argv)

    curves = []
    for key in ("nrel-5mw", "iea-15-240") if args.quick else names():
        try:
            dynamic = DynamicTurbine(turbine=load_turbine(key), step=0.05)
        except InputError as error:
            print(f"left out: {error}")  # the paper's rotor has neither masses nor stiffnesses
            continue
        one = steady_curve(dynamic, (8.0, 17.0) if args.quick else SPEEDS, 60.0)
        curves.append(one)
        computed = {
            name: np.interp(
                one.simulated["wind_speed"], one.curve.wind_speed, getattr(one.curve, name)
            )
            for name in ("power", "thrust", "rotor_speed", "pitch")
        }
        off = [
            100 * np.max(np.abs(one.simulated[name] / computed[name] - 1))
            for name in ("power", "thrust", "rotor_speed")
        ]
        angle = np.degrees(np.max(np.abs(one.simulated["pitch"] - computed["pitch"])))
        print(
            f"{key:12} largest difference: power {off[0]:.1f} %, thrust {off[1]:.1f} %, rotor "
            f"speed {off[2]:.1f} %, pitch {angle:.2f} deg"
        )
    args.folder.mkdir(parents=True, exist_ok=True)
    path = args.folder / "16_steady_curves.png"
    path.write_bytes(png(steady_curves_figure(curves), dpi=110))
    print(path)


if __name__ == "__main__":
    main()
