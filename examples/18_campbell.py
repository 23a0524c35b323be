"""Natural frequencies of a turbine over its rotor speed (Campbell diagram).

Modes of tower and blades in still air, in the frame that does not turn; grey lines are multiples
of the rotor speed.  A blade mode that whirls stands at its frequency plus and minus the rotor's.

    python 18_campbell.py [FOLDER] [--quick]
"""

import argparse
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

from pitchopt.plotting import png
from pitchopt.sim import DynamicTurbine, natural_modes
from pitchopt.turbines import load_turbine


def main(argv=None):
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("folder", nargs="?", default="example-output", type=Path)
    parser.add_argument("--turbine", default="nrel-5mw")
    parser.add_argument("--quick", action="store_true", help="fewer rotor speeds")
    args = parser.parse_args(argv)

    dynamic = DynamicTurbine(turbine=load_turbine(args.turbine))
    rated = dynamic.turbine.rated_rotor_speed
    speeds = np.linspace(0.0, 1.2 * rated, 3 if args.quick else 13)
    figure = Figure(figsize=(7.0, 5.0), layout="constrained")
    axes = figure.subplots()
    rows = [(speed, mode) for speed in speeds for mode in natural_modes(dynamic, speed)]
    for k, label in enumerate(dict.fromkeys(mode.label for _, mode in rows)):
        points = [(s * 30 / np.pi, m.frequency / (2 * np.pi)) for s, m in rows if m.label == label]
        axes.plot(*zip(*points, strict=True), "o", color=f"C{k % 10}", markersize=4, label=label)
    for multiple in (1, 2, 3, 6):
        axes.plot(speeds * 30 / np.pi, multiple * speeds / (2 * np.pi), color="0.8", zorder=0)
        axes.annotate(f"{multiple}P", (speeds[-1] * 30 / np.pi, multiple * speeds[-1] / 2 / np.pi))
    axes.axvline(rated * 30 / np.pi, color="0.8", linestyle=":", zorder=0)
    axes.set(xlabel="rotor speed [rpm]", ylabel="natural frequency [Hz]", ylim=(0.0, None))
    axes.set_ylim(top=1.25 * axes.get_ylim()[1])  # room for the legend
    axes.legend(frameon=False, fontsize=8, ncols=2)
    args.folder.mkdir(parents=True, exist_ok=True)
    path = args.folder / "18_campbell.png"
    path.write_bytes(png(figure, dpi=110))
    for mode in natural_modes(dynamic, rated):
        print(f"{mode.label:16} {mode.frequency / 2 / np.pi:6.3f} Hz, damping {mode.damping:.2%}")
    print(path)


if __name__ == "__main__":
    main()
