"""Individual pitch control for ROSCO: the gain of the turbine's own numbers, in DISCON.IN's terms.

ROSCO's law at 1P is ours but for one thing: its band pass about the rotor speed lets half of the
moment through, so its integral gain is twice ours.  The plot shows the band pass as it is, and as
it was meant.  Its 2P path regulates the tilt part alone, so a controller with 2P is refused unless
the 1P part is asked for.

    python 31_rosco_individual_pitch.py [FOLDER] [--quick]
"""

import argparse
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

from pitchopt.control import IndividualPitch, decoupling_offset
from pitchopt.errors import InputError
from pitchopt.exports import discon_ipc, read_discon_ipc, write_files
from pitchopt.plotting import png

SPEED = 12.1 * np.pi / 30  # [rad/s]
STEP = 0.0125  # [s]
LAG = 0.3  # of the actuators [s]


def band_pass(turns, delayed):
    """Discrete band pass of ROSCO at `turns` times the rotor speed.

    The numerator takes the difference to the input `delayed` steps ago: 1 in ROSCO 2.9.5 and
    2.10.6, 2 in the bilinear form.
    """
    z = np.exp(-1j * turns * SPEED * STEP)
    d, w = 0.7, SPEED * STEP
    a2, a1, a0 = d * w**2 + 2 * w + 4 * d, 2 * d * w**2 - 8 * d, d * w**2 - 2 * w + 4 * d
    return 2 * w * (1 - z**delayed) / (a2 + a1 * z + a0 * z**2)


def main(argv=None):
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("folder", nargs="?", default="example-output", type=Path)
    parser.add_argument("--quick", action="store_true", help="the same: it is quick")
    args = parser.parse_args(argv)

    controller = IndividualPitch(
        gain=np.array([4e-9, 2e-9]),
        offset=[decoupling_offset(n, SPEED, LAG) for n in (1, 2)],
    )
    try:
        discon_ipc(controller)
    except InputError as error:
        print(error)
    section = discon_ipc(controller, only_1p=True)
    print(section.text())
    (path,) = write_files(args.folder, {"31_discon_ipc.txt": section.text()})
    back = read_discon_ipc(path)
    print(f"read back: gain {back.gain[0]:.3g} rad/(N m s), "
          f"offset {np.rad2deg(back.offset[0]):.2f} deg")  # fmt: skip

    turns = np.geomspace(0.1, 10.0, 400)
    figure = Figure(figsize=(7, 5), layout="constrained")
    size, phase = figure.subplots(2, 1, sharex=True)
    for delayed, label in ((1, "ROSCO 2.9.5 and 2.10.6"), (2, "bilinear form")):
        answer = band_pass(turns, delayed)
        size.loglog(turns, np.abs(answer), label=label)
        phase.semilogx(turns, np.rad2deg(np.angle(answer)), label=label)
        at = np.abs(band_pass(np.array([1.0, 2.0]), delayed))
        print(f"{label}: {at[0]:.3f} of a 1P moment, {at[1]:.3f} of a 2P moment")
    for axes in (size, phase):
        for n in (1, 2):
            axes.axvline(n, color="0.7", lw=1)
        axes.grid(visible=True, which="both", alpha=0.3)
    size.set_ylabel("moment passed [-]")
    size.legend()
    phase.set_ylabel("phase [deg]")
    phase.set_xlabel("frequency over rotor speed [-]")
    write_files(args.folder, {"31_band_pass.png": png(figure)})


if __name__ == "__main__":
    main()
