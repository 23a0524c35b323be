"""What more pitch rate, a wider range, a lower price or another shear would buy a pitch design.

Estimates from the multipliers of one solved design, beside the design solved again for every
change, and over a range of pitch rates.  The actuator is slowed to 2 deg/s, so that its rate has a
price.  A limit on the right-hand side has one estimate, a straight line; where the optimum bends
below it, it overstates what more of the limit buys and understates what less of it costs.

    python 28_sensitivity_design.py [FOLDER] [--quick]
"""

import argparse
from pathlib import Path

import numpy as np

from pitchopt.cases import load_case
from pitchopt.design import compared
from pitchopt.exports import write_files
from pitchopt.plotting import png, sensitivity_figure
from pitchopt.studies.sensitivity import (
    DesignPoint,
    curve_records,
    design_curve,
    design_sensitivity,
    sensitivity_csv,
    sensitivity_record,
)

DEGREE = np.pi / 180.0


def report(record):
    """A row for each parameter: estimates, truth, what carries them, what looks broken."""
    print(f"changes of {record['objective']} [N m], more is better")
    print(f"{'':20}{'change':>14}{'first-order':>13}{'high-order':>12}{'re-solved':>11}")
    for row in record["rows"]:
        unit = "" if row["unit"] == "-" else f" {row['unit']}"
        print(
            f"{row['label']:20}{row['step_shown']:+.3g}{unit:<8}".ljust(34)
            + f"{row['first_order']:13.1f}{row['high_order']:12.1f}{row['resolved']:11.1f}"
        )
        carried = [group["name"] for group in row["carried_by"] if abs(group["high_order"]) > 1e-3]
        broken = [n for n, a in row["assumptions"].items() if a["verdict"] == "broken"]
        if carried:
            print(f"    carried by {', '.join(carried[:3])}")
        if broken:
            print(f"    looks broken: {', '.join(broken)}")


def main(argv=None):
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("folder", nargs="?", default="example-output", type=Path)
    parser.add_argument("--quick", action="store_true", help="fewer rotor positions and steps")
    args = parser.parse_args(argv)

    positions, count, starts = (6, 2, 1) if args.quick else (24, 6, 5)
    case = load_case("biegel2011").with_values(
        {"limits.positions": positions, "limits.pitch_rate": 2.0 * DEGREE}
    )
    task = case.task()
    found = compared(task, mu=3.0, starts=starts, certify=False)
    point = DesignPoint(case=case, task=task, found=found)
    kkt = point.stationary
    print(
        f"mean torque - mu x RMS = {kkt.value:.1f} N m; stationarity missed by {kkt.worst:.1e} of "
        f"its largest term, {kkt.at_kink.sum()} of {kkt.theta.size} stations on kinks"
    )

    record = sensitivity_record(design_sensitivity(point, truth=True, starts=starts))
    report(record)

    curves = [
        design_curve(point, "rate", 0.25 * DEGREE, count, starts=starts),
        design_curve(point, "shear", 0.02, count, starts=starts),
    ]
    records = curve_records(curves)
    print("pitch rate: change [deg/s], first-order, re-solved [N m]")
    for r in records:
        if r["parameter"] == "rate":
            print(f"  {r['step_shown']:+.2f} {r['first_order']:10.1f} {r['resolved']:10.1f}")

    title = f"{case.name}, mu = 3, 2 deg/s"
    files = {
        "28_sensitivity.csv": sensitivity_csv(record),
        "28_sensitivity.png": png(sensitivity_figure(record, title=title)),
        "28_curves.png": png(sensitivity_figure(record, records, title=title)),
    }
    for path in write_files(args.folder, files):
        print(path)


if __name__ == "__main__":
    main()
