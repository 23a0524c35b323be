"""Tables of the docs from the records of `benchmarks/results`, so that figures cannot drift.

A table stands in a page between two comments,

    <!-- table: proof -->
    ...
    <!-- end of table -->

and is written anew from the record, with the machine of the record under it.  The prose around
it stays hand-written.

    python tools/record_tables.py            write the tables
    python tools/record_tables.py --check    say which are out of date, status 1 if any is
"""

from __future__ import annotations

import argparse
import json
import re
import sys
from collections.abc import Callable, Iterable, Sequence
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parents[1]
RESULTS = ROOT / "benchmarks" / "results"
PAGES = ("performance.md", "validation.md", "tuning.md", "compare.md")

Record = dict[str, Any]
Rows = list[Sequence[object]]
Table = tuple[Sequence[str], Rows, Sequence[Record]]  # headings, rows, records for the machine

_BLOCK = re.compile(
    r"(<!-- table: (?P<name>[a-z-]+) -->\n).*?(<!-- end of table -->)", flags=re.DOTALL
)


def lines(name: str, measurement: str | None = None) -> list[Record]:
    """Lines of a record, of one kind or all."""
    text = (RESULTS / f"{name}.json").read_text(encoding="utf-8")
    if text.startswith("{\n"):  # one document of a study, not a line a measurement
        return [json.loads(text)]
    found = [json.loads(line) for line in text.splitlines() if line.strip()]
    return [line for line in found if measurement in (None, line["measurement"])]


# --- numbers in words ----------------------------------------------------------------------------
def digits(value: float | None, count: int = 2) -> str:
    """To so many significant digits; integers from a hundred on, powers of ten far from one."""
    if value is None:
        return ""
    if value == 0.0:
        return "0"
    if abs(value) >= 10**count and abs(value) < 1e6:
        return f"{value:,.0f}"
    if abs(value) >= 1e6 or abs(value) < 1e-3:
        mantissa, power = f"{value:.{count - 1}e}".split("e")
        return f"{mantissa}e{int(power)}"
    whole = len(str(int(abs(value)))) if abs(value) >= 1.0 else 0
    leading = 0 if abs(value) >= 0.1 else 1 if abs(value) >= 0.01 else 2
    return f"{value:.{max(count - whole + leading, 0)}f}"


def seconds(value: float) -> str:
    """A time with its unit."""
    return f"{digits(value)} s" if value >= 0.1 else f"{digits(1e3 * value)} ms"


def percent(value: float, places: int = 1, *, sign: bool = True) -> str:
    """A share in per cent with a sign, no sign at zero."""
    text = f"{100.0 * value:{'+' if sign else ''}.{places}f}"
    return text.lstrip("+-") if float(text) == 0.0 else text


def span(values: Iterable[float]) -> str:
    """Least to largest."""
    found = sorted(values)
    low, high = digits(found[0]), digits(found[-1])
    return low if low == high else f"{low} to {high}"


# --- tables --------------------------------------------------------------------------------------
def _of(records: Sequence[Record], **wanted: object) -> Record:
    """The one record with these values."""
    found = [r for r in records if all(r.get(key) == value for key, value in wanted.items())]
    if len(found) != 1:
        raise LookupError(f"expected one record with {wanted}, found {len(found)}")
    return found[0]


def waiting() -> Table:
    """What a user waits for."""
    kinds = {r["measurement"]: r for r in lines("curve")}
    curve, command, start = kinds["curve"], kinds["command"], kinds["import"]
    rows: Rows = [
        (
            f"curve of `biegel2011`, {curve['points']} points with bounds",
            seconds(curve["seconds"]),
            f"{curve['seconds_aim']:g} s",
        ),
        (
            "`pitchopt tradeoff` from a cold start, plots included",
            seconds(command["seconds"]),
            f"{command['seconds_aim']:g} s",
        ),
        ("`import pitchopt`", seconds(start["seconds"]), f"{start['seconds_aim']:g} s"),
        ("the same with `pitchopt.design`", seconds(start["seconds_with_design"]), ""),
    ]
    return ("", "measured", "aim"), rows, list(kinds.values())


def subproblems() -> Table:
    """One subproblem against cvxpy."""
    found = lines("direct_vs_cvxpy")
    rows: Rows = [
        (
            r["cvxpy_formulation"],
            r["positions"],
            r["elements"],
            seconds(r["direct_seconds_median"]),
            seconds(r["cvxpy_seconds_median"]),
            digits(r["ratio"]),
            f"{r['ratio_aim']:g}",
            percent(r["direct_solver_share"], 0, sign=False) + " %",
        )
        for r in found
    ]
    heads = (
        "cvxpy's program",
        "m",
        "n",
        "ours",
        "cvxpy",
        "ratio",
        "aim",
        "Clarabel's share of ours",
    )
    return heads, rows, found


def growth() -> Table:
    """Growth of one local solve and of its bound."""
    found = [r for r in lines("growth") if r["measurement"].startswith("exponent")]
    rows: Rows = [
        (
            r["along"],
            f"{r['sizes'][0]:g} to {r['sizes'][-1]:g}",
            digits(r["exponent_run"]),
            digits(r["exponent_bound"]),
            "" if r["aim"] is None else f"{r['aim']:g}",
        )
        for r in found
    ]
    return ("along", "sizes", "exponent of a run", "of its bound", "aim"), rows, found


def largest() -> Table:
    """Points of the largest problem."""
    found = lines("growth", "largest")
    rows: Rows = [
        (
            f"{r['mu']:g}",
            seconds(r["seconds"]),
            r["subproblems"],
            seconds(r["bound_seconds"]),
            f"{digits(r['gap_percent'])} %",
            f"{r['peak_memory_mb']:.0f} MB",
            r["status"],
        )
        for r in found
    ]
    aims = found[0]
    heads = (
        "price",
        f"point (aim {aims['point_seconds_aim']:g} s)",
        "subproblems",
        f"bound (aim {aims['bound_seconds_aim']:g} s)",
        "gap of the hull",
        f"peak memory (aim {aims['peak_memory_mb_aim']:g} MB)",
        "status",
    )
    return heads, rows, found


def proof() -> Table:
    """Proven gaps."""
    found = lines("proof")
    rows: Rows = [
        (
            f"{r['pitch_rate_deg']:g} deg/s",
            f"{100 * r['loss']:g} %",
            digits(r["mu"], 3),
            digits(r["rms_weighted"], 4),
            digits(r["rms_lower_bound"], 4),
            f"{r['gap_hull_percent']:.1f} %",
            f"{r['gap_percent']:.2f} %",
            f"{r['regions']:,}",
            seconds(r["seconds"]),
            seconds(r["seconds_check"]),
        )
        for r in found
    ]
    heads = (
        "pitch rate",
        "torque lost",
        "price mu",
        "RMS",
        "RMS at least",
        "gap of the hull",
        f"proven gap (aim {found[0]['aim_gap_percent']:g} %)",
        "regions",
        f"time (aim {found[0]['aim_seconds']:g} s)",
        "check",
    )
    return heads, rows, found


_FORMULATIONS = {
    "direct": "RMS in the objective",
    "epigraph": "RMS as variables",
    "lifted": "rotor loads and RMS as variables",
}


def ipopt() -> Table:
    """Against CasADi with IPOPT."""
    found = lines("scp_vs_ipopt", "summary")
    lead = "{:.2f} to {:.1f} %"
    rows: Rows = []
    for r in found:
        for key, words in _FORMULATIONS.items():
            f = r["formulations"][key]
            least, most = f["objective_lead_percent_least"], f["objective_lead_percent_largest"]
            rows.append(
                (
                    r["positions"],
                    r["elements"],
                    words,
                    digits(f["ratio"]),
                    span((f["ratio_least"], f["ratio_largest"])),
                    f"{r['ratio_aim']:g}",
                    f"{f['ipopt_runs_solved']} of {f['runs']}",
                    lead.format(least, most),
                )
            )
    heads = (
        "m",
        "n",
        "formulation given to IPOPT",
        "ratio",
        "least to largest",
        "aim",
        "IPOPT runs that converged",
        "our objective ahead by",
    )
    return heads, rows, found


def several() -> Table:
    """Several winds."""
    found = lines("robust", "design")
    rows: Rows = [
        (
            f"{r['winds']:g}",
            digits(r["cpu_seconds_own_optima"]),
            digits(r["cpu_seconds_joint"]),
            digits(r["cpu_seconds_bound"]),
            digits(r["cpu_seconds"] + r["cpu_seconds_bound"]),
            "" if r["seconds_aim"] is None else f"{r['seconds_aim']:g}",
            digits(r["cpu_seconds_regret"]),
            f"{r['gap_percent']:.2f} %",
        )
        for r in found
    ]
    heads = (
        "winds",
        "own optima",
        "joint mean",
        "its bound",
        "together",
        "aim",
        "least largest regret, own optima included, no bound",
        "gap of the mean",
    )
    return heads, rows, found


def learning() -> Table:
    """Time of a learner."""
    found = lines("learning", "time of a rotation")
    rows: Rows = [
        (
            r["learner"],
            r["positions"],
            f"{digits(r['milliseconds'])} ms",
            f"{digits(r['milliseconds_rate_binding'])} ms",
            "" if r["milliseconds_aim"] is None else f"{r['milliseconds_aim']:g} ms",
        )
        for r in found
    ]
    return ("learner", "m", "a rotation", "with the rate limit binding", "aim"), rows, found


_MODELS = {"qs": "quasi-steady", "dbemt": "dynamic"}


def simulation() -> Table:
    """Speed of the dynamic turbine."""
    found = lines("simulate", "speed")
    rows: Rows = [
        (
            f"{_MODELS[r['model']]}, {r['step']:g}",
            f"{r['milliseconds_per_second']:.2f}",
            f"{r['milliseconds_aim']:g}",
            f"{r['microseconds_per_step']:.1f}",
            f"{r['nanoseconds_per_element']:.0f}",
            f"{r['balance_evaluations']:.3f}",
            digits(r["ratio"]),
        )
        for r in found
    ]
    heads = (
        "inflow, step [s]",
        "ms a simulated second",
        "aim",
        "microseconds a step",
        "ns a blade element and step",
        "balances an element and step",
        "OpenFAST over ours",
    )
    return heads, rows, found


_FUNCTIONS = {
    "forrester": "Forrester",
    "branin": "Branin",
    "hartmann3": "Hartmann 3",
    "hartmann4": "Hartmann 4",
    "hartmann6": "Hartmann 6",
    "ackley": "Ackley 2-D",
    "rosenbrock": "Rosenbrock 2-D",
}


def tuners() -> Table:
    """Bayesian tuner and scikit-optimize."""
    found = lines("tuners", "regret")
    rows: Rows = [
        (
            _FUNCTIONS.get(r["function"], r["function"])
            + (f", {r['noise']:g}" if r["noise"] else ""),
            r["evaluations"][-1],
            digits(r["pitchopt_median"][-1]),
            digits(r["skopt_median"][-1]),
            digits(r["p_gain"], 1),
            digits(r["p_loss"], 2),
        )
        for r in sorted(found, key=lambda r: bool(r["noise"]))
    ]
    heads = (
        "function, noise std",
        "evaluations",
        "ours",
        "scikit-optimize",
        "p of a gain",
        "p of a loss",
    )
    return heads, rows, found


def suggestions() -> Table:
    """Time of a suggestion."""
    found = lines("tuners", "suggestion")
    rows: Rows = [
        (
            r["tool"],
            r["samples"],
            r["dimensions"],
            seconds(r["seconds"]),
            seconds(r["seconds_largest"]),
            "" if r.get("seconds_aim") is None else f"{r['seconds_aim']:g} s",
        )
        for r in found
    ]
    return ("", "points told", "dimensions", "a suggestion", "at most", "aim"), rows, found


def convex_programs() -> Table:
    """Estimates against solving again."""
    found = lines("sensitivity", "convex program")
    rows: Rows = [
        (
            f"{r['variables']}, {r['rows']}",
            seconds(r["seconds_estimates"]),
            seconds(r["seconds_estimates_not_judged"]),
            seconds(r["seconds_solving_again"]),
            digits(r["ratio"]),
            digits(r["ratio_not_judged"]),
            f"{digits(100 * r['error_high_order'])} %",
            ", ".join(r["broken"]) or "nothing",
        )
        for r in found
    ]
    heads = (
        "variables, rows",
        "judged",
        "numbers alone",
        "solved again",
        "ratio judged",
        "numbers alone",
        "largest error of high-order, of the largest change",
        "looks broken",
    )
    return heads, rows, found


def towers() -> Table:
    """Load sets and sizing."""
    (loads,) = lines("sensitivity", "set of simulations")
    sizing = lines("sensitivity", "sizing")
    rows: Rows = [
        (
            f"a set: {loads['simulations']} simulations of {loads['duration']:g} s",
            seconds(loads["seconds"]),
            f"{loads['seconds_aim']:g} s",
        ),
        (
            "the first set of a study, turbulence boxes made",
            seconds(loads["seconds_with_boxes_made"]),
            "",
        ),
    ]
    rows += [(f"sizing, {r['configuration']}", seconds(r["seconds"]), "") for r in sizing]
    rows += [
        (f"the same by SLSQP, {r['configuration']}", seconds(r["slsqp_seconds"]), "")
        for r in sizing
    ]
    return ("", "measured", "aim"), rows, [loads, *sizing]


# --- validation ----------------------------------------------------------------------------------
def steady() -> Table:
    """Steady operation over OpenFAST's."""
    found = lines("simulate", "steady")
    keys = (
        "GenPwr_ratio",
        "RtAeroFxh_ratio",
        "RotSpeed_ratio",
        None,
        "TwrBsMyt_ratio",
        "RootMyc1_ratio",
    )
    rows: Rows = [
        (
            f"{r['model']}, {r['wind_speed']:g}",
            *(
                _degrees(r["pitch_difference_deg"]) if key is None else percent(r[key] - 1.0)
                for key in keys
            ),
        )
        for r in found
    ]
    heads = (
        "inflow, wind [m/s]",
        "power",
        "thrust",
        "rotor speed",
        "pitch",
        "tower base",
        "blade root",
    )
    return heads, rows, found


def _degrees(value: float) -> str:
    text = f"{value:+.2f}"
    return text.lstrip("+-") if float(text) == 0.0 else text


def turbulent() -> Table:
    """Turbulence over OpenFAST's; misses of the aims in bold."""
    found = sorted(
        lines("simulate", "turbulent"),
        key=lambda r: (r["shapes"] != "own", r["model"] != "qs", r["wind_speed"]),
    )
    keys = {
        "power_ratio": 0.02,
        "speed_std_ratio": 0.15,
        "pitch_std_ratio": None,
        "TwrBsMyt_del_ratio": 0.10,
        "RootMyc1_del_ratio": 0.10,
        "RootMxc1_del_ratio": None,
        "TwrBsMxt_del_ratio": None,
        "YawBrMyp_del_ratio": None,
        "YawBrMzp_del_ratio": None,
    }

    def shown(record: Record, key: str, aim: float | None) -> str:
        value = record.get(key)
        if value is None:
            return ""
        text = percent(value - 1.0)
        return f"**{text}**" if aim is not None and abs(value - 1.0) > aim else text

    rows: Rows = [
        (
            f"{r['shapes']}, {r['model']}, {r['wind_speed']:g}",
            *(shown(r, key, aim) for key, aim in keys.items()),
        )
        for r in found
    ]
    heads = (
        "tower shapes, inflow, wind",
        "power",
        "speed, std",
        "pitch, std",
        "tower base fore-aft",
        "blade out of plane",
        "blade in plane",
        "tower base side-side",
        "tilt",
        "yaw",
    )
    return heads, rows, found


def convergence() -> Table:
    """Differences to the finest step."""
    found = [r for r in lines("simulate", "convergence") if r["step"] > 0.00625]
    rows: Rows = [
        (
            f"{r['model']}, {r['step']:g}",
            percent(r["power_ratio"] - 1.0, 3),
            percent(r["speed_std_ratio"] - 1.0, 2),
            percent(r["TwrBsMyt_del_ratio"] - 1.0, 2),
            percent(r["RootMyc1_del_ratio"] - 1.0, 2),
            percent(r["TwrBsMxt_del_ratio"] - 1.0, 2),
            percent(r["error_check"], 1, sign=False),
        )
        for r in found
    ]
    heads = (
        "inflow, step [s]",
        "power",
        "speed, std",
        "tower fore-aft",
        "blade out of plane",
        "tower side-side",
        "error check",
    )
    return heads, rows, found


def random_starts() -> Table:
    """Gains of random starts, and optima without convex programs."""
    found = lines("random_starts", "case")
    flat = lines("random_starts", "flattened optimum")
    points = lines("random_starts", "point")
    rows: Rows = []
    for r in found:
        case = r["case"]
        gain = r["gain_largest_percent"]

        def excess(loss: float, case: str = case) -> str:
            match = [f for f in flat if f["case"] == case and f.get("target") == loss]
            if not match or not match[0]["applies"] or match[0].get("flat_rms_weighted") is None:
                return "none found"
            return f"{_signed(match[0]['flat_rms_weighted'] / match[0]['rms_weighted'] - 1.0)} %"

        priced = [f for f in flat if f["case"] == case and f["kind"] == "mu"]
        rows.append(
            (
                case,
                "0" if abs(gain) < 5e-4 else f"{gain:.4f} %",
                excess(0.03),
                excess(0.07),
                f"{priced[0]['gain_percent']:+.3f} %" if priced else "",
                f"{r['curve_cpu_seconds']:.0f} s",
            )
        )
    heads = (
        "case",
        "largest gain of a random start",
        "flattened RMS, 3 %",
        "7 %",
        "flattened objective, highest price",
        "curve",
    )
    return heads, rows, [*found, *flat, *points]


def _signed(value: float) -> str:
    return f"{100.0 * value:+.2f}"


# --- tuning --------------------------------------------------------------------------------------
_PROBLEMS = ("torque-gain", "speed-regulator", "minimum-pitch", "individual-pitch")


def tuning_problems() -> Table:
    """Every tuner on the four problems."""
    found = lines("tuning_problems", "study")
    methods = list(dict.fromkeys(r["method"] for r in found))
    rows: Rows = []
    for method in methods:
        row: list[object] = [method]
        for problem in _PROBLEMS:
            match = [r for r in found if r["method"] == method and r["problem"] == problem]
            places = 1 if problem in ("speed-regulator", "individual-pitch") else 2
            row.append(
                f"{100 * match[0]['gain']:.{places}f} / {100 * match[0]['fresh_gain']:.{places}f}"
                if match
                else ""
            )
        rows.append(row)
    heads = (
        "tuner",
        "torque gain",
        "speed regulator",
        "minimum pitch, kappa 0.03",
        "individual pitch, 15 m/s",
    )
    return heads, rows, found


# --- towers --------------------------------------------------------------------------------------
def tower_study() -> Table:
    """Tables 1 to 3 of the tower's paper and figures of its text, beside the record's."""
    (study,) = lines("tower_study")
    cells: dict[str, dict[str, Record]] = {}
    for row in study["tables"]:
        cells.setdefault(row["quantity"], {})[row["configuration"]] = row
    rows: Rows = [
        (
            quantity + ("" if first["unit"] in ("-", "") else f" [{_unit(first['unit'])}]"),
            *(
                _tower_figure(quantity, found.get(name, {}).get(key))
                for name in ("standard", "soft-soft")
                for key in ("paper", "ours")
            ),
        )
        for quantity, found in cells.items()
        for first in (next(iter(found.values())),)
    ]
    heads = ("", "standard, paper", "ours", "soft-soft, paper", "ours")
    return heads, rows, [study]


def _unit(text: str) -> str:
    return text.replace("$", "\\$").replace("s2/m2", "s²/m²")


def _tower_figure(quantity: str, value: float | None) -> str:
    if value is None:
        return ""
    if quantity.startswith("change of cost"):
        return f"{100.0 * value:+.3f} %"
    if quantity.startswith("change"):
        return f"{100.0 * value:+.1f} %"
    if quantity.startswith(("sets", "iterations")):
        return f"{value:.0f}"
    if quantity.startswith(("energy", "cost of energy", "weight")):
        return f"{value:.3f}"
    return f"{value:.1f}" if abs(value) >= 10.0 else f"{value:.2f}"


# --- comparison ----------------------------------------------------------------------------------
_LOADS = ("blade", "tower", "tilt", "yaw", "torque")


def _wind(record: Record) -> str:
    share = 100.0 * record["intensity"]
    if not share:
        return "steady"
    return f"{record['wind']}, {share:.1f} %" if record["wind"][0].isalpha() else f"{share:.0f} %"


def compared_changes() -> Table:
    """Change of every equivalent load by method and wind."""
    found = lines("comparison", "method in wind")
    rows: Rows = []
    for record in found:
        if record["method"] == "collective":
            continue
        cuts = record["del_cut"]
        cells = [_changed(cuts[load]) if cuts else record["status"] for load in _LOADS]
        travel = record["pitch_travel_deg"]
        rows.append(
            (record["method"], _wind(record), *cells, "" if travel is None else f"{travel:.1f}")
        )
    heads = ("method", "wind", *_LOADS, "travel [deg/turn]")
    return heads, rows, found


def _changed(cut: Record) -> str:
    text = percent(-cut["mean"])
    return text if cut["half_width"] is None else f"{text} ±{100.0 * cut['half_width']:.1f}"


def _some(value: float, form: str) -> str:
    """A number, nothing for zero."""
    return form.format(value) if value else ""


def compared_efforts() -> Table:
    """What each method took in class B."""
    found = [r for r in lines("comparison", "method in wind") if r["wind"] == "B"]
    rows: Rows = [
        (
            record["method"],
            record["spent"]["evaluations"] or "",
            record["spent"]["simulations"] or "",
            f"{record['spent']['rotations']:,.0f}" if record["spent"]["rotations"] else "",
            f"{record['spent']['turbine_time'] / 3600.0:.1f}"
            if record["spent"]["rotations"]
            else "",
            digits(record["spent"]["seconds"]) if record["spent"]["seconds"] else "",
        )
        for record in found
        if record["spent"]
    ]
    heads = ("method", "evaluations", "simulations", "rotations", "turbine hours", "seconds")
    return heads, rows, found


TABLES: dict[str, tuple[str, Callable[[], Table]]] = {
    "waiting": ("curve", waiting),
    "subproblems": ("direct_vs_cvxpy", subproblems),
    "growth": ("growth", growth),
    "largest": ("growth", largest),
    "proof": ("proof", proof),
    "ipopt": ("scp_vs_ipopt", ipopt),
    "several": ("robust", several),
    "learning": ("learning", learning),
    "simulation": ("simulate", simulation),
    "tuners": ("tuners", tuners),
    "suggestions": ("tuners", suggestions),
    "convex-programs": ("sensitivity", convex_programs),
    "towers": ("sensitivity", towers),
    "steady": ("simulate", steady),
    "turbulent": ("simulate", turbulent),
    "convergence": ("simulate", convergence),
    "random-starts": ("random_starts", random_starts),
    "tower-study": ("tower_study", tower_study),
    "tuning-problems": ("tuning_problems", tuning_problems),
    "compared-changes": ("comparison", compared_changes),
    "compared-efforts": ("comparison", compared_efforts),
}


# --- pages ---------------------------------------------------------------------------------------
def machine(records: Sequence[Record]) -> str:
    """Processor, cores and versions of the records, or that they do not say."""
    found = []
    for record in records:
        environment = record.get("environment")
        if not environment or not environment.get("cpu"):
            text = "Machine not recorded"
        else:
            versions = environment["versions"]
            text = (
                f"{environment['cpu']}, {environment['cores']} cores, "
                f"{environment['threads']} thread for linear algebra, Python {versions['python']}"
            )
            for name in ("clarabel", "cvxpy", "casadi"):
                if versions.get(name):
                    text += f", {name} {versions[name]}"
        if text not in found:
            found.append(text)
    return "; and ".join(found)


def table(name: str) -> str:
    """One table with its record and machine."""
    record, make = TABLES[name]
    heads, rows, used = make()
    parts = [f"| {' | '.join(heads)} |", f"|{'---|' * len(heads)}"]
    parts += [f"| {' | '.join(str(cell) for cell in row)} |" for row in rows]
    parts = [re.sub(r" {2,}", " ", part) for part in parts]
    return "\n".join([*parts, "", f"Record: `benchmarks/results/{record}.json`. {machine(used)}."])


def written(text: str) -> str:
    """A page with its tables as the records have them."""

    def one(match: re.Match[str]) -> str:
        name = match["name"]
        if name not in TABLES:
            raise LookupError(f"no table {name!r}; there are {', '.join(TABLES)}")
        return f"{match[1]}\n{table(name)}\n\n{match[3]}"

    return _BLOCK.sub(one, text)


def names_in(text: str) -> list[str]:
    """Names of a page's tables."""
    return [match["name"] for match in _BLOCK.finditer(text)]


def main(argv: list[str] | None = None) -> int:
    """Write the tables, or compare them."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--check", action="store_true", help="write nothing")
    args = parser.parse_args(argv)
    stale = []
    for name in PAGES:
        path = ROOT / "docs" / name
        before = path.read_text(encoding="utf-8")
        after = written(before)
        if after != before:
            stale.append(name)
            if not args.check:
                path.write_text(after, encoding="utf-8")
    if stale:
        print(("out of date: " if args.check else "written: ") + ", ".join(stale))
    return int(bool(stale) and args.check)


if __name__ == "__main__":
    sys.exit(main())
