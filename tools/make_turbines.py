"""Write the catalogue's data files from windIO files and the tables beside this script.

usage: python tools/make_turbines.py FOLDER_WITH_WINDIO_FILES [OUTPUT_FOLDER]

The folder is ``examples/02_reference_turbines`` of WISDEM 4.2.9 (in its wheel or repository).
"""

from __future__ import annotations

import json
import sys
from pathlib import Path
from typing import Any

import numpy as np

HERE = Path(__file__).resolve().parent
sys.path[:0] = [str(HERE), str(HERE.parent)]

from turbine_sources import BIEGEL_2011, EXTRAS, NREL_5, REPORT_5, WINDIO  # noqa: E402  (after the path)

from pitchopt.turbines.windio import windio_record  # noqa: E402  (after the path)

DECIMALS = {"alpha_deg": 3, "cl": 4, "cd": 5, "cm": 4, "twist_deg": 5, "structural_twist_deg": 4}
MAX_STATIONS = 60


def table(name: str) -> np.ndarray:
    """Numbers of a text table of this folder."""
    return np.loadtxt(HERE / "data" / name)


def airfoil_tables() -> dict[str, dict[str, Any]]:
    """Airfoils of the NREL 5 MW by name."""
    airfoils: dict[str, list[list[float]]] = {}
    rows: list[list[float]] = []
    for line in (HERE / "data" / "nrel5mw_airfoils.txt").read_text().splitlines():
        words = line.split()
        if line.startswith("#") or not words:
            continue
        if words[0] == "airfoil":
            rows = airfoils.setdefault(words[1], [])
        else:
            rows.append([float(word) for word in words])
    keys = ("alpha_deg", "cl", "cd", "cm")
    return {
        name: {"name": name} | dict(zip(keys, np.array(data).T.tolist(), strict=True))
        for name, data in airfoils.items()
    }


def smooth_naca64(folder: Path) -> dict[str, Any]:
    """NACA 64-618 as the windIO file of the NREL 5 MW has it: OpenFAST's table, smoothed."""
    import yaml

    loader = getattr(yaml, "CSafeLoader", yaml.SafeLoader)
    data = yaml.load((folder / "nrel5mw.yaml").read_text(), Loader=loader)  # noqa: S506 (safe)
    airfoil = next(a for a in data["airfoils"] if a["name"] == "NACA64_A17")
    polars = airfoil["polars"][0]["re_sets"][0]
    grid = np.asarray(polars["cl"]["grid"], dtype=float)
    record = {"name": "NACA64_A17", "alpha_deg": grid.tolist()}
    for key in ("cl", "cd", "cm"):
        record[key] = np.interp(grid, polars[key]["grid"], polars[key]["values"]).tolist()
    return record


def rounded(value: Any, key: str = "") -> Any:
    """Value with as many digits as the file keeps: six significant, fixed for angles and polars."""
    if isinstance(value, dict):
        return {k: rounded(v, k) for k, v in value.items() if v is not None}
    if isinstance(value, list):
        return [rounded(v, key) for v in value]
    if isinstance(value, float):
        value = round(value, DECIMALS[key]) if key in DECIMALS else float(f"{value:.7g}")
        return int(value) if value == int(value) and abs(value) < 1e15 else value
    return value


def write(record: dict[str, Any], key: str, folder: Path) -> None:
    """One data file: every array on one line."""
    record = rounded(record)
    lines = []
    for name, part in record.items():
        if isinstance(part, dict):
            body = ",\n".join(f'  "{k}": {json.dumps(v)}' for k, v in part.items())
            lines.append(f'"{name}": {{\n{body}\n}}')
        elif name == "airfoils":
            entries = [
                "{\n"
                + ",\n".join(
                    f'  "{k}": {json.dumps(v, separators=(",", ":"))}' for k, v in e.items()
                )
                + "\n}"
                for e in part
            ]
            lines.append('"airfoils": [\n' + ",\n".join(entries) + "\n]")
        else:
            lines.append(f'"{name}": {json.dumps(part)}')
    file = folder / f"{key}.json"
    file.write_text("{\n" + ",\n".join(lines) + "\n}\n")
    print(f"{file.name:20} {file.stat().st_size / 1000:6.1f} kB")


def thinned(structure: dict[str, Any]) -> dict[str, Any]:
    """Every second station of a finely sampled blade, and its tip."""
    count = len(structure["span"])
    if count <= MAX_STATIONS:
        return structure
    keep = sorted({*range(0, count, 2), count - 1})
    return {k: [v[i] for i in keep] for k, v in structure.items()}


def from_windio(key: str, folder: Path) -> dict[str, Any]:
    """Record of an IEA turbine."""
    extra = EXTRAS[key]
    record = windio_record(folder / extra["file"])
    record["name"], record["description"] = key, extra["description"]
    record["source"] = WINDIO.format(file=extra["file"]) + "; " + extra["report"]
    record["operation"] |= extra["operation"]
    for part in ("hub", "nacelle", "drivetrain", "notes"):
        record[part] = extra[part]
    if "blade_structure" in record:
        record["blade_structure"] = thinned(record["blade_structure"])
    if key == "iea-3.4-130":
        beside_the_report(record)
    for part, ratio in zip(("blade_structure", "tower"), extra["damping"], strict=True):
        if ratio is not None:
            record[part]["damping_ratio"] = ratio
    return record


def beside_the_report(record: dict[str, Any]) -> None:
    """Blade and tower structure of the IEA 3.4 MW, which its windIO file lacks."""
    fraction, twist, mass, flap, edge = table("iea34_structure.txt").T
    record["blade_structure"] = {
        "span": (fraction * record["blade"]["span"][-1]).tolist(),
        "mass_per_length": mass.tolist(),
        "flap_stiffness": flap.tolist(),
        "edge_stiffness": edge.tolist(),
        "structural_twist_deg": twist.tolist(),
    }
    tower = record["tower"]
    fraction, mass, stiffness = table("iea34_tower.txt").T
    height = fraction * tower["height"][-1]
    diameter = np.interp(height, tower["height"], tower["diameter"])
    area = mass / tower["density"]
    thickness = (diameter - np.sqrt(diameter**2 - 4.0 / np.pi * area)) / 2.0
    drag = np.interp(height, tower["height"], tower["drag_coefficient"])
    tower |= {
        "height": height.tolist(),
        "diameter": diameter.tolist(),
        "thickness": thickness.tolist(),
        "outfitting_factor": 1.0,
        "mass_per_length": mass.tolist(),
        "bending_stiffness": stiffness.tolist(),
        "drag_coefficient": drag.tolist(),
    }


def nrel5(folder: Path) -> dict[str, Any]:
    """Record of the NREL 5 MW with AeroDyn's own stations and tables."""
    span, prebend, sweep, twist, chord, airfoil = table("nrel5mw_blade.txt").T
    windio = windio_record(folder / NREL_5["file"], nodes=None)
    own = np.array(windio["blade"]["span"])
    fraction, structural, mass, flap, edge = table("nrel5mw_structure.txt").T
    length = 61.5
    beam = windio["blade_structure"]
    height = np.unique(np.concatenate([np.linspace(0.0, 87.6, 11), [85.268]]))
    part = height / 87.6
    d, t = 6.0 + (3.87 - 6.0) * part, 0.0351 + (0.0247 - 0.0351) * part
    inner = d - 2.0 * t
    density, modulus = 8500.0, 210e9
    return {
        "format": windio["format"],
        "name": "nrel-5mw",
        "source": f"OpenFAST/r-test (github.com/OpenFAST/r-test); {REPORT_5}",
        "description": NREL_5["description"],
        "rotor": NREL_5["rotor"],
        "operation": NREL_5["operation"],
        "blade": {
            "span": span.tolist(),
            "chord": chord.tolist(),
            "twist_deg": twist.tolist(),
            "prebend": prebend.tolist(),
            "sweep": sweep.tolist(),
            "relative_thickness": np.interp(
                span, own, windio["blade"]["relative_thickness"]
            ).tolist(),
            "pitch_axis": np.interp(span, own, windio["blade"]["pitch_axis"]).tolist(),
            "polars": [[int(i) - 1, int(i) - 1, 0] for i in airfoil],
        },
        "airfoils": list(airfoil_tables().values()),
        "blade_structure": {
            "span": (fraction * length).tolist(),
            "mass_per_length": (1.04536 * mass).tolist(),
            "flap_stiffness": flap.tolist(),
            "edge_stiffness": edge.tolist(),
            "structural_twist_deg": structural.tolist(),
            "torsion_stiffness": np.interp(
                fraction * length, beam["span"], beam["torsion_stiffness"]
            ).tolist(),
            "damping_ratio": 0.00477465,
        },
        "tower": {
            "height": height.tolist(),
            "diameter": np.interp(height, [0.0, 85.268, 87.6], [6.0, 3.87, 3.87]).tolist(),
            "thickness": t.tolist(),
            "density": density,
            "youngs_modulus": modulus,
            "poisson_ratio": 0.3,
            "mass_per_length": (density * np.pi / 4.0 * (d**2 - inner**2)).tolist(),
            "bending_stiffness": (modulus * np.pi / 64.0 * (d**4 - inner**4)).tolist(),
            "drag_coefficient": [1.0] * height.size,
            "damping_ratio": 0.01,
        },
        **{key: NREL_5[key] for key in ("hub", "nacelle", "drivetrain", "notes")},
    }


def main(arguments: list[str]) -> int:
    """Write all data files; returns the exit status."""
    if len(arguments) not in {1, 2}:
        print(__doc__)
        return 2
    folder = Path(arguments[0])
    target = HERE.parent / "pitchopt" / "turbines" / "data"
    if len(arguments) == 2:
        target = Path(arguments[1])
    target.mkdir(parents=True, exist_ok=True)
    write(nrel5(folder), "nrel-5mw", target)
    for key in EXTRAS:
        write(from_windio(key, folder), key, target)
    write(BIEGEL_2011 | {"airfoils": [smooth_naca64(folder)]}, "biegel2011", target)
    return 0


if __name__ == "__main__":
    raise SystemExit(main(sys.argv[1:]))
