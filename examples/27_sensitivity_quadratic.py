"""Is it worth re-optimising?  Estimates from one optimum beside re-solved ones, on small programs.

Figures C2, C4 and C5 of Iori et al.: three families of quadratic programs, with an objective that
curves in the design, one that couples design and parameter, and a constraint that becomes active on
the way.  Each estimate says which of its assumptions look broken.

    python 27_sensitivity_quadratic.py [FOLDER] [--quick]
"""

import argparse
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

from pitchopt.plotting import estimates_figure, plot_design_plane, plot_estimates, png
from pitchopt.studies.sensitivity import (
    active_set_program,
    coupling_programs,
    estimated_curve,
    linearity_programs,
)

SHOWN = (0.1, 0.5, 1.0)


def report(family, curves):
    """Estimates at a few dc, and where which assumption looks broken first."""
    print(f"{family}\n  {'':20}   dc  re-solved  first-order  high-order")
    for curve in curves:
        for dc in SHOWN:
            i = int(np.argmin(np.abs(curve.dc - dc)))
            print(
                f"  {curve.name:20} {curve.dc[i]:4.1f} {curve.truth[i]:10.3f} "
                f"{curve.first_order[i]:12.3f} {curve.high_order[i]:11.3f}"
            )
        for name, dc in curve.broken:
            i = int(np.argmin(np.abs(curve.dc - dc)))
            message = next(a.message for a in curve.estimates[i].broken if a.name == name)
            print(f"    from dc = {dc:g}: {name} looks broken ({message})")


def main(argv=None):
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("folder", nargs="?", default="example-output", type=Path)
    parser.add_argument("--quick", action="store_true", help="fewer values of the parameter")
    args = parser.parse_args(argv)
    args.folder.mkdir(parents=True, exist_ok=True)
    dc = np.linspace(0.0, 1.0, 11 if args.quick else 51)
    dc = np.round(dc, 12)

    pages = {}
    for key, family, programs in (
        ("27_c2_linearity", "objective that curves in x (C2)", linearity_programs()),
        ("27_c4_coupling", "objective that couples x2 and c (C4)", coupling_programs()),
    ):
        curves = [estimated_curve(program, dc) for program in programs]
        report(family, curves)
        pages[key] = estimates_figure(curves)

    halved = [estimated_curve(program.halved(), dc) for program in linearity_programs()]
    report("the same as C2 with one half before P", halved)
    pages["27_c2_with_one_half"] = estimates_figure(halved)

    curve = estimated_curve(active_set_program(), dc)
    report("constraint that becomes active (C5)", [curve])
    page = Figure(figsize=(10.0, 4.2), layout="constrained")
    left, right = page.subplots(1, 2)
    plot_design_plane(curve, ax=left)
    plot_estimates(curve, ax=right).set_title("")
    pages["27_c5_active_set"] = page

    for key, figure in pages.items():
        (args.folder / f"{key}.png").write_bytes(png(figure, dpi=110))
        print(args.folder / f"{key}.png")


if __name__ == "__main__":
    main()
