"""The trade-off between mean torque and load variation: figure 5 of the paper.

One curve instead of one per start, with the proven bound above it.

    python 03_tradeoff_curve.py [FOLDER] [--quick]
"""

import argparse
from pathlib import Path

from pitchopt.cases import load_case
from pitchopt.design import tradeoff
from pitchopt.plotting import png, tradeoff_figure


def main(argv=None):
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("folder", nargs="?", default="example-output", type=Path)
    parser.add_argument("--quick", action="store_true", help="fewer positions and points")
    args = parser.parse_args(argv)
    args.folder.mkdir(parents=True, exist_ok=True)

    case = load_case("biegel2011")
    if args.quick:
        case = case.with_values({"limits.positions": 6, "aero.segments": 10})
    result = tradeoff(case.task(), points=3 if args.quick else 20, starts=2 if args.quick else 5)
    knee = result.points[result.knee]
    print(f"best constant pitch  {result.constant.mean_torque:.4g} N m")
    print(f"power maximum        {result.power_max.mean_torque:.4g} N m")
    print(
        f"knee                 {knee.mean_torque:.4g} N m, "
        f"{100 * result.loss(knee):.2f} % lost, RMS cut {100 * result.cut(knee):.1f} %"
    )
    target = args.folder / "03_tradeoff_curve.png"
    target.write_bytes(png(tradeoff_figure(result, weights_name="unit", title=case.name)))
    print(target)


if __name__ == "__main__":
    main()
