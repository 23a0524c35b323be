"""One comparison: the turbulence in which a profile planned for steady wind stops paying.

A designed and a learned profile and individual pitch control on one turbine, in steady wind and in
weak and strong turbulence, side by side; a table, a picture and a page that needs no network.

Run:  python 33_compare.py [FOLDER] [--quick]
"""

from __future__ import annotations

import argparse
from pathlib import Path

from pitchopt import load_case
from pitchopt.exports import write_files
from pitchopt.plotting import method_figures, png
from pitchopt.studies.comparison import (
    ComparisonSettings,
    compare,
    comparison_document,
    comparison_report,
    sentences,
)


def main(argv: list[str] | None = None) -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("folder", nargs="?", default="example-output")
    parser.add_argument("--quick", action="store_true")
    options = parser.parse_args(argv)

    case = load_case("nrel-5mw").with_values({"wind.speed": 15.0, "limits.positions": 12})
    if options.quick:
        case = case.with_values({"limits.positions": 6, "aero.segments": 8})
    settings = ComparisonSettings(
        turbulence=("none", "C") if options.quick else ("none", "0.02", "0.05", "C", "B"),
        methods=("feed-forward", "learned", "ipc-zoo"),
        seeds=2 if options.quick else 12,
        tuning_seeds=1 if options.quick else 3,
        evaluations=4 if options.quick else 41,
        rotations=5 if options.quick else 20,
        averaged=2 if options.quick else 20,
        duration=30.0 if options.quick else 600.0,
        skip=30.0 if options.quick else 60.0,
    )
    result = compare(case, settings)

    print(f"change of the damage-equivalent loads at {case.wind.speed:g} m/s\n")
    print(f"{'method':<14}{'wind':<7}{'blade':>8}{'tower':>8}{'tilt':>8}{'yaw':>8}{'torque':>8}")
    for entry in result.entries:
        if entry.method == "collective":
            continue
        cuts = result.cuts(entry.method, entry.wind)
        changes = "".join(f"{-100 * cut.mean:>+7.1f}%" for cut in cuts.values())
        print(f"{entry.method:<14}{entry.wind:<7}{changes}")
    for method in ("feed-forward", "learned"):
        print(f"\nWhere the {method} profile pays")
        for line in sentences(result, method):
            print(f"  {line}")

    document = comparison_document(result)
    figures = method_figures(document, result.excerpts)
    written = write_files(
        Path(options.folder),
        {
            "33_changes.png": png(figures["changes"]),
            "33_compare.html": comparison_report(document, figures),
        },
    )
    print()
    for path in written:
        print(path)


if __name__ == "__main__":
    main()
