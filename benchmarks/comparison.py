"""The comparison of all methods in steady wind and in turbulence from weak to strong.

One line for each method and wind, with changes of loads against the collective controller, the half
width of their 95 % confidence interval, pitch travel, and what the method took; one line for the
whole with the verdicts.  A run takes ten minutes to half an hour on two cores.
"""

from __future__ import annotations

import sys
import time
from collections.abc import Mapping
from typing import Any

import _harness

WINDS = ("none", "0.02", "0.05", "C", "B")
WIND_SPEED = 15.0


def lines(report: _harness.Report, document: Mapping[str, Any], seconds: float) -> None:
    """The document of a comparison as lines."""
    level = {one["wind"]: one["intensity"] for one in document["winds"]}
    for entry in document["entries"]:
        report.add(
            "method in wind",
            turbine=document["turbine"],
            wind_speed=document["wind_speed"],
            intensity=level[entry["wind"]],
            seeds=len(document["settings"]["judged_seeds"][entry["wind"]]),
            **{key: entry.get(key) for key in KEPT},
        )
    report.add(
        "comparison",
        turbine=document["turbine"],
        wind_speed=document["wind_speed"],
        seconds=seconds,
        settings=document["settings"]["comparison"],
        verdict=document["verdict"],
        design={
            key: value
            for entry in document["entries"]
            if entry["method"] == "feed-forward" and entry.get("profile")
            for key, value in entry["profile"].items()
            if key in ("wake", "harmonics", "predicted_cut")
        },
    )


KEPT = (
    *("method", "wind", "status", "mean_power", "rms", "del", "rms_cut", "del_cut"),
    *("pitch_travel_deg", "rate_use", "rate_peak", "spent", "point", "tuning_cost", "start_cost"),
)


def main(argv: list[str] | None = None) -> int:
    args = _harness.options(__doc__, argv)
    from pitchopt.cases import load_case
    from pitchopt.studies.comparison import ComparisonSettings, compare, comparison_document

    case = load_case("nrel-5mw").with_values({"wind.speed": WIND_SPEED})
    settings = ComparisonSettings(turbulence=WINDS)
    if args.quick:
        case = case.with_values({"limits.positions": 6, "aero.segments": 8})
        settings = ComparisonSettings(
            turbulence=("none", "C"),
            methods=("feed-forward", "ipc-bayes"),
            seeds=2,
            tuning_seeds=1,
            evaluations=3,
            duration=20.0,
            skip=5.0,
        )
    began = time.perf_counter()
    document = comparison_document(compare(case, settings))
    report = _harness.Report("comparison", quick=args.quick, out=args.out)
    lines(report, document, time.perf_counter() - began)
    report.close()
    return 0


if __name__ == "__main__":
    sys.exit(main())
