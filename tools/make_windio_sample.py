"""Write the small windIO file that the tests read, from WISDEM's ``nrel5mw.yaml``.

usage: python tools/make_windio_sample.py PATH/nrel5mw.yaml OUTPUT.yaml

Kept: what the reader uses.  Dropped: composite layup, airfoil coordinates, most materials and
controller gains; polars keep every third angle of attack beyond 30 degrees.
"""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Any

import yaml

HEAD = """\
# NREL 5 MW reference turbine, windIO v2, shortened for tests by tools/make_windio_sample.py.
# Source: examples/02_reference_turbines/nrel5mw.yaml of WISDEM 4.2.9
# (github.com/WISDEM/WISDEM, Apache-2.0), after Jonkman et al. (2009), NREL/TP-500-38060.
"""
CONTROL = (
    "min_rotor_speed",
    "rated_rotor_speed",
    "max_rotor_speed",
    "fine_pitch",
    "optimal_tsr",
    "min_pitch_limit",
    "max_pitch_limit",
    "max_pitch_rate",
    "max_allowable_blade_tip_speed",
)


def rounded(value: Any) -> Any:
    """Numbers with six significant digits."""
    if isinstance(value, dict):
        return {k: rounded(v) for k, v in value.items()}
    if isinstance(value, list):
        return [rounded(v) for v in value]
    return float(f"{value:.6g}") if isinstance(value, float) else value


def thinned(table: dict[str, list[float]]) -> dict[str, list[float]]:
    """Polar with fewer angles; one that is constant keeps its ends."""
    grid, values = table["grid"], table["values"]
    last = len(grid) - 1
    keep = [i for i, a in enumerate(grid) if i in {0, last} or abs(a) <= 30.0 or i % 3 == 0]
    if max(values) - min(values) < 1e-9:
        keep = [0, last]
    return {
        "grid": [round(grid[i], 3) for i in keep],
        "values": [round(values[i], 4) for i in keep],
    }


def sample(full: dict[str, Any]) -> dict[str, Any]:
    """The shortened file."""
    parts = full["components"]
    blade, tower = parts["blade"], parts["tower"]
    blade["structure"] = {"elastic_properties": blade["structure"]["elastic_properties"]}
    drive = parts["drivetrain"]
    full["components"] = {
        "blade": blade,
        "hub": {k: parts["hub"][k] for k in ("diameter", "cone_angle")},
        "tower": tower,
        "drivetrain": {
            "outer_shape": drive["outer_shape"],
            "gearbox": {k: drive["gearbox"][k] for k in ("gear_ratio", "efficiency")},
            "generator": {
                "rpm_efficiency": drive["generator"]["generator_rpm_efficiency_user"],
            },
            "elastic_properties": drive["elastic_properties"],
        },
    }
    for airfoil in full["airfoils"]:
        del airfoil["coordinates"]
        for polar in airfoil["polars"]:
            for tables in polar["re_sets"]:
                for key in ("cl", "cd", "cm"):
                    tables[key] = thinned(tables[key])
    full["materials"] = [m for m in full["materials"] if m["name"] == "steel"]
    full["control"] = {k: full["control"][k] for k in CONTROL}
    return rounded(full)


def main(arguments: list[str]) -> int:
    """Read, shorten, write."""
    if len(arguments) != 2:
        print(__doc__)
        return 2
    full = yaml.safe_load(Path(arguments[0]).read_text())
    text = yaml.safe_dump(sample(full), default_flow_style=None, width=100, sort_keys=False)
    Path(arguments[1]).write_text(HEAD + text)
    print(f"{arguments[1]}: {len(HEAD + text) / 1000:.1f} kB")
    return 0


if __name__ == "__main__":
    raise SystemExit(main(sys.argv[1:]))
