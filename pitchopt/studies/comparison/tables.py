"""Tables of a comparison as rows of text, for terminals and reports alike.

All take the document of `comparison_document`.  Changes are those of the collective controller's
figure in the same winds, minus for less, with the half width of the 95 % confidence interval of
their mean.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from pitchopt.studies.comparison.measures import LOADS
from pitchopt.studies.comparison.verdict import wind_name

__all__ = [
    "change_rows",
    "effort_rows",
    "few_seeds",
    "knowledge_rows",
    "load_rows",
    "point_rows",
    "promise",
    "wind_title",
]

_ENOUGH = 6  # of IEC 61400-1 for a wind speed

Document = Mapping[str, Any]
Rows = list[list[str]]


def wind_title(document: Document, wind: str) -> str:
    """A wind and what methods were judged in there."""
    share = next(one["intensity"] for one in document["winds"] if one["wind"] == wind)
    seeds = document["settings"]["judged_seeds"][wind]
    name = wind_name(wind)
    if share == 0.0:
        return f"{name[0].upper()}{name[1:]}, {document['wind_speed']:g} m/s"
    kind = f"Turbulence of {name}" if name.startswith("class") else "Turbulence"
    return (
        f"{kind}, intensity {100 * share:.1f} %, {document['wind_speed']:g} m/s, seeds that no "
        f"method has met: {len(seeds)}"
    )


def promise(document: Document) -> str:
    """What the static model promises of the design as it is played; empty without a design."""
    for record in document["entries"]:
        profile = record.get("profile")
        if record["method"] == "feed-forward" and profile and profile["predicted_cut"]:
            cuts = ", ".join(
                f"{load} {-100 * cut:+.1f} %" for load, cut in profile["predicted_cut"].items()
            )
            return (
                f"The static model ({profile['wake']} wake, harmonics 1 to {profile['harmonics']}) "
                f"promises of the design in the steady wind, RMS: {cuts}."
            )
    return ""


def few_seeds(document: Document) -> str:
    """A warning where there are too few seeds to conclude from; empty otherwise."""
    counts = [
        len(document["settings"]["judged_seeds"][one["wind"]])
        for one in document["winds"]
        if one["intensity"] > 0.0
    ]
    if not counts or min(counts) >= _ENOUGH:
        return ""
    return f"Seeds of turbulence: {min(counts)}. Fewer than {_ENOUGH} are too few to conclude from."


def change_rows(document: Document, wind: str, kind: str = "del") -> Rows:
    """Power, changes of loads, pitch travel and use of the pitch rate; two rows of headings.

    Parameters
    ----------
    document : mapping
    wind : str
    kind : {"del", "rms"}
        Damage-equivalent loads, or RMS about the mean.
    """
    rows = [
        ["method", "power", *LOADS, "travel", "rate use", "peak"],
        ["", "kW", *["%"] * len(LOADS), "deg/turn", "%", "%"],
    ]
    for record in _of(document, wind):
        if "del" not in record:
            rows.append([record["method"], record["status"], *["-"] * (len(LOADS) + 3)])
            continue
        cells = [_change(record[f"{kind}_cut"][load]) for load in LOADS]
        if record["method"] == "collective":
            cells = ["0"] * len(LOADS)
        rows.append(
            [
                record["method"],
                f"{1e-3 * record['mean_power']:.1f}",
                *cells,
                f"{record['pitch_travel_deg']:.2f}",
                f"{100 * record['rate_use']:.1f}",
                f"{100 * record['rate_peak']:.0f}",
            ]
        )
    return rows


def load_rows(document: Document, wind: str) -> Rows:
    """RMS and equivalent loads in kN m; two rows of headings."""
    rows = [
        ["method", *(f"{load}" for load in LOADS), *(f"{load}" for load in LOADS)],
        ["kN m", *["RMS"] * len(LOADS), *["DEL"] * len(LOADS)],
    ]
    for record in _of(document, wind):
        if "del" not in record:
            rows.append([record["method"], *["-"] * (2 * len(LOADS))])
            continue
        rows.append(
            [
                record["method"],
                *(f"{1e-3 * record[kind][load]:.4g}" for kind in ("rms", "del") for load in LOADS),
            ]
        )
    return rows


def effort_rows(document: Document) -> Rows:
    """What each method took in each wind, the design once; one row of headings."""
    first = document["winds"][0]["wind"]
    rows = [
        ["method", "wind", "evaluations", "simulations", "rotations", "turbine hours", "seconds"]
    ]
    for record in document["entries"]:
        spent = record.get("spent")
        once = record["method"] == "feed-forward"  # one design for all winds
        if spent is None or record["method"] == "collective" or (once and record["wind"] != first):
            continue
        rows.append(
            [
                record["method"],
                "all" if once else record["wind"],
                str(spent["evaluations"]),
                str(spent["simulations"]),
                f"{spent['rotations']:.0f}",
                f"{spent['turbine_time'] / 3600.0:.2f}",
                f"{spent['seconds']:.1f}",
            ]
        )
    return rows


def knowledge_rows(document: Document) -> Rows:
    """What each method had to know; one row of headings."""
    keys = ("model", "wind", "loads", "running")
    heads = ["method", "of the model", "of the wind", "loads, to prepare", "while it runs"]
    return [
        heads,
        *(
            [method, *(known[key] for key in keys)]
            for method, known in document["knowledge"].items()
        ),
    ]


def point_rows(document: Document) -> Rows:
    """Gains and offsets that tuners chose, and their cost; one row of headings."""
    heads = [
        "method",
        "wind",
        "1P gain",
        "1P offset",
        "2P gain",
        "2P offset",
        "cost",
        "of zero gain",
    ]
    units = ["", "", "rad/(MN m s)", "deg", "rad/(MN m s)", "deg", "kN m", "kN m"]
    rows = [heads, units]
    for record in document["entries"]:
        point = record.get("point")
        if not point:
            continue
        rows.append(
            [
                record["method"],
                record["wind"],
                *(
                    text
                    for n in (1, 2)
                    for text in (
                        f"{1e6 * point[f'gain_{n}p']:.4f}",
                        f"{57.29577951308232 * point[f'offset_{n}p']:.1f}",
                    )
                ),
                f"{1e-3 * record['tuning_cost']:.0f}",
                f"{1e-3 * record['start_cost']:.0f}",
            ]
        )
    return rows


def _of(document: Document, wind: str) -> list[Mapping[str, Any]]:
    return [record for record in document["entries"] if record["wind"] == wind]


def _change(found: Mapping[str, Any]) -> str:
    text = f"{-100 * found['mean']:+.1f}"
    return text if found["half_width"] is None else f"{text} ±{100 * found['half_width']:.1f}"
