"""A turbine in turbulence: statistics and equivalent loads, and a controller of one's own.

The IEA 15 MW runs in class B turbulence under the controller that follows from its own steady
operation, with individual pitch on top, and under a controller written in Python: the same as
the first, with a generator torque that also damps the tower sideways.  Any object with `start` and
`command` can steer the turbine.

    python 15_turbulence.py [FOLDER] [--quick]
"""

import argparse
from pathlib import Path

from pitchopt.control.signals import TORQUE, TOWER_VY
from pitchopt.exports import series_csv
from pitchopt.plotting import png, simulation_figure
from pitchopt.sim import DynamicTurbine, Operation
from pitchopt.studies.simulation import SimulationSettings, named_controller, run_simulations
from pitchopt.turbines import load_turbine

TOWER_GAIN = 0.5  # torque for the speed of the tower top, over rated torque [s/m]
LOADS = ("TwrBsMyt", "TwrBsMxt", "RootMyc1", "GenPwr", "BldPitch1")


class TowerDamper:
    """A controller, with more torque while the tower top moves left, which pushes it right."""

    def __init__(self, inner, gain):
        self.inner, self.gain = inner, gain

    def start(self, step, measured):
        """Begin a run."""
        self.inner.start(step, measured)

    def command(self, measured):
        """Commands (4,): torque [N m] and the pitch of the blades [rad]."""
        out = self.inner.command(measured)
        out[TORQUE] += self.gain * measured[TOWER_VY]
        return out


def main(argv=None):
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("folder", nargs="?", default="example-output", type=Path)
    parser.add_argument("--quick", action="store_true", help="shorter")
    args = parser.parse_args(argv)

    dynamic = DynamicTurbine(turbine=load_turbine("iea-15-240"), step=0.025)
    operation = Operation(dynamic)
    settings = SimulationSettings(
        wind_speeds=(16.0,),
        turbulence="B",
        seeds=(1,) if args.quick else (1, 2),
        duration=60.0 if args.quick else 300.0,
        skip=30.0,
        box_points=7 if args.quick else 13,
        channels=("Wind1VelX", "RotSpeed", *LOADS),
    )
    tuned = operation.controller()
    controllers = {
        "tuned": tuned,
        "individual pitch": named_controller(operation, "ipc"),
        "tower damper": TowerDamper(tuned, TOWER_GAIN * tuned.torque.rated_torque),
    }
    print(f"{'':22}" + "".join(f"{name:>14}" for name in LOADS))
    args.folder.mkdir(parents=True, exist_ok=True)
    for name, controller in controllers.items():
        result = run_simulations(dynamic, controller, settings, name=name, operation=operation)
        found = result.summary()[0].statistics
        units = {channel.name: channel for channel in result.channels}
        for kind, text in (("mean", "mean"), ("std", "std"), ("equivalent_load", "DEL")):
            cells = []
            for load in LOADS:
                value = getattr(found[load], kind)
                cells.append("-" if value is None else f"{units[load].factor * value:.4g}")
            print(
                f"{name if kind == 'mean' else '':18}{text:>4}" + "".join(f"{c:>14}" for c in cells)
            )
        if name == "tuned":
            path = args.folder / "15_series.csv"
            path.write_text(series_csv(result.runs[0].series), encoding="utf-8")
            print(path)
        path = args.folder / f"15_{name.replace(' ', '_')}.png"
        path.write_bytes(png(simulation_figure(result, title=f"iea-15-240, {name}"), dpi=110))
        print(path)


if __name__ == "__main__":
    main()
