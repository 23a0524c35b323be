"""The dynamic turbine: speed of the time loop, convergence with the step, and OpenFAST's figures.

Speed: NREL 5 MW, 12 m/s, class B, all degrees of freedom but shaft torsion, baseline controller;
best of five runs, compiled before, building of the wind not counted.  OpenFAST v5.0.0 with the
same degrees of freedom takes 0.12 s a simulated second (its reference data say so).

Accuracy: against the reference data of OpenFAST v5.0.0 (``--reference FOLDER``; by default
../shared/reference beside the checkout), steady and in its nine Mann boxes.  These are made by the
script that lies with the data (package hipersim 0.1.22, extra ``bench``) into the folder
``--boxes``, or read from there if they exist.  Figures are ratios of ours to OpenFAST's, means over
seeds; ``own`` with the tower's eigenmodes, ``given`` with the mode shapes of OpenFAST's input file.
Without the data or hipersim these lines say that they are skipped.

    python benchmarks/simulate.py [--quick] [--out FILE.json] [--reference DIR] [--boxes DIR]
"""

from __future__ import annotations

import csv
import functools
import math
import runpy
import tempfile
import time
from pathlib import Path
from typing import Any

import _harness
import numpy as np

OPENFAST_MS = 120.0
AIM_MS = 0.3
RPM, DEG = math.pi / 30.0, math.pi / 180.0
MODELS = {"qs": "quasi-steady", "dbemt": "dynamic"}
# powers 2 to 6 of the relative height, fore-aft and side-side, of the input file (OpenFAST/r-test)
SHAPES = (
    (0.7004, 2.1963, -5.6202, 6.2275, -2.504),
    (1.385, -1.7684, 3.0871, -2.2395, 0.5357),
)
STEADY = {"GenPwr": 1e3, "RtAeroFxh": 1.0, "RotSpeed": RPM, "BldPitch1": DEG, "TwrBsMyt": 1e3,
          "RootMyc1": 1e3}  # fmt: skip
LOADS = {"TwrBsMyt": 4.0, "TwrBsMxt": 4.0, "RootMyc1": 10.0, "RootMxc1": 10.0, "YawBrMyp": 4.0,
         "YawBrMzp": 4.0}  # fmt: skip


@functools.cache
def turbine() -> Any:
    from pitchopt.turbines import load_turbine

    return load_turbine("nrel-5mw")


def dynamic(model: str, **options: Any) -> Any:
    from pitchopt.sim import DynamicTurbine

    return DynamicTurbine(turbine=turbine(), inflow=MODELS[model], **options)


def sheared(speed: float) -> Any:
    from windfield import PowerLaw, StaticField, TowerShadow

    tower = turbine().tower
    shadow = TowerShadow(radius=tower.radius, height=tower.height, top=tower.top)
    return StaticField(speed=speed, hub_height=90.0, vertical=PowerLaw(exponent=0.2), tower=shadow)


def run(dyn: Any, wind: Any, duration: float, speed: float, **options: Any) -> Any:
    from pitchopt.control import nrel_5mw_baseline
    from pitchopt.sim import Start, simulate

    start = {
        8: Start(rotor_speed=9.0 * RPM, torque=19e3),
        12: Start(rotor_speed=12.1 * RPM, pitch=3.0 * DEG, torque=43.1e3),
        18: Start(rotor_speed=12.1 * RPM, pitch=14.6 * DEG, torque=43.1e3),
    }[round(speed)]
    return simulate(dyn, wind, nrel_5mw_baseline(), duration, start=start, **options)


def speed(report: _harness.Report, *, quick: bool) -> None:
    from windfield import TurbulentField, kaimal_box

    duration = 20.0 if quick else 660.0
    points = (5, 5) if quick else (13, 13)
    seconds = []
    for seed in range(1 if quick else 3):
        began = time.perf_counter()
        box = kaimal_box(
            12.0, duration, 0.1, hub_height=90.0, width=145.0, points=points, seed=seed
        )
        seconds.append(time.perf_counter() - began)
    report.add(
        "turbulence box",
        points=list(points),
        seconds=min(seconds),
        seconds_aim=3.0,
        slices=int(box.velocity.shape[0]),
    )
    wind = TurbulentField(mean=sheared(12.0), box=box)
    for model in MODELS:
        for step in (0.025,) if quick else (0.0125, 0.02, 0.025, 0.05):
            dyn = dynamic(model, step=step)
            run(dyn, wind, 1.0, 12.0)
            results = [run(dyn, wind, duration, 12.0) for _ in range(1 if quick else 5)]
            best = min(result.seconds for result in results)
            elements = 3 * turbine().rotor.blade.span.size
            report.add(
                "speed",
                model=model,
                step=step,
                milliseconds_per_second=best / duration * 1e3,
                milliseconds_aim=AIM_MS,
                microseconds_per_step=best / duration * step * 1e6,
                nanoseconds_per_element=best / duration * step / elements * 1e9,
                balance_evaluations=results[0].evaluations,
                ratio=OPENFAST_MS / (best / duration * 1e3),
            )


def convergence(report: _harness.Report, *, quick: bool) -> None:
    from pitchopt.sim import statistics
    from windfield import TurbulentField, kaimal_box

    duration = 30.0 if quick else 660.0
    box = kaimal_box(12.0, duration, 0.1, hub_height=90.0, width=145.0, points=(13, 13), seed=1)
    wind = TurbulentField(mean=sheared(12.0), box=box)
    for model in MODELS:
        lines = {}
        for step in (0.05, 0.025) if quick else (0.05, 0.025, 0.0125, 0.00625):
            result = run(dynamic(model, step=step), wind, duration, 12.0)
            lines[step] = (result, statistics(result, skip=10.0 if quick else 60.0))
        finest = lines[min(lines)][1]
        for step, (result, line) in lines.items():
            report.add(
                "convergence",
                model=model,
                step=step,
                power_ratio=line["GenPwr"].mean / finest["GenPwr"].mean,
                speed_std_ratio=line["GenSpeed"].std / finest["GenSpeed"].std,
                error_check=float(np.max(result.error)),
                **{
                    f"{name}_del_ratio": line[name].equivalent_load / finest[name].equivalent_load
                    for name in ("TwrBsMyt", "TwrBsMxt", "RootMyc1", "RootMxc1")
                },
            )


def steady(report: _harness.Report, reference: Path) -> None:
    from pitchopt.control import nrel_5mw_baseline
    from pitchopt.sim import Start, simulate

    with (reference / "b1_steady_shear.csv").open() as lines:
        rows = [row for row in csv.DictReader(lines) if row["model"] in MODELS]
    for row in rows:
        wind = float(row["wind_speed"])
        result = simulate(
            dynamic(row["model"], step=0.0125),
            sheared(wind),
            nrel_5mw_baseline(),
            200.0,
            start=Start(
                rotor_speed=float(row["RotSpeed_mean"]) * RPM,
                pitch=float(row["BldPitch1_mean"]) * DEG,
                torque=float(row["GenTq_mean"]) * 1e3,
            ),
        )
        rows_after = result.after(140.0)
        figures = {}
        for name, unit in STEADY.items():
            ours = float(rows_after[:, result.place(name)].mean()) / unit
            theirs = float(row[f"{name}_mean"])
            if name == "BldPitch1":
                figures["pitch_difference_deg"] = ours - theirs
            else:
                figures[f"{name}_ratio"] = ours / theirs
        report.add("steady", model=row["model"], wind_speed=wind, **figures)


def read_box(folder: Path, wind: int, seed: int) -> Any:
    from windfield import read_hawc2

    stem = f"U{wind:02d}_s{seed}_"
    return read_hawc2(
        *(folder / f"{stem}{c}.bin" for c in "uvw"),
        shape=(4096, 32, 32),
        spacing=(wind * 700.0 / 4096, 145.0 / 31, 145.0 / 31),
        mean_speed=float(wind),
        centre_height=90.0,
    )


def turbulent(report: _harness.Report, reference: Path, boxes: Path) -> None:
    from pitchopt.sim import statistics
    from windfield import TurbulentField

    boxes.mkdir(parents=True, exist_ok=True)
    means = read_table(reference / "b3_turbulent_stats.csv")
    loads = read_table(reference / "b3_turbulent_del.csv")
    for wind in (8, 12, 18):
        fields = []
        for seed in (1, 2, 3):
            if not (boxes / f"U{wind:02d}_s{seed}_meta.json").exists():
                make = runpy.run_path(str(reference / "make_box.py"))["make"]
                make(wind, seed, str(boxes))
            fields.append(
                TurbulentField(mean=sheared(float(wind)), box=read_box(boxes, wind, seed))
            )
        for model in MODELS:
            for shapes, given in (("own", None), ("given", SHAPES)):
                dyn = dynamic(model, step=0.0125, tower_polynomials=given)
                lines = [statistics(run(dyn, field, 660.0, float(wind))) for field in fields]

                def ours(name: str, kind: str, lines: Any = lines) -> float:
                    return float(np.mean([getattr(line[name], kind) for line in lines]))

                def theirs(
                    table: Any, name: str, kind: str, model: str = model, wind: int = wind
                ) -> float:
                    return float(
                        np.mean([table[model, wind, seed, name][kind] for seed in (1, 2, 3)])
                    )

                figures = {
                    "power_ratio": ours("GenPwr", "mean") / (theirs(means, "GenPwr", "mean") * 1e3),
                    "speed_std_ratio": ours("GenSpeed", "std")
                    / (theirs(means, "GenSpeed", "std") * RPM),
                    "thrust_ratio": ours("RtAeroFxh", "mean") / theirs(means, "RtAeroFxh", "mean"),
                }
                if wind > 8:
                    figures["pitch_std_ratio"] = ours("BldPitch1", "std") / (
                        theirs(means, "BldPitch1", "std") * DEG
                    )
                for name in LOADS:
                    figures[f"{name}_del_ratio"] = ours(name, "equivalent_load") / (
                        theirs(loads, name, "DEL_1Hz") * 1e3
                    )
                report.add("turbulent", model=model, wind_speed=wind, shapes=shapes, **figures)


def read_table(file: Path) -> dict[tuple[str, int, int, str], dict[str, float]]:
    table = {}
    with file.open() as lines:
        for row in csv.DictReader(lines):
            key = (row["model"], int(row["wind_speed"]), int(row["seed"]), row["channel"])
            table[key] = {
                name: float(value)
                for name, value in row.items()
                if name not in ("model", "wind_speed", "seed", "channel", "unit")
            }
    return table


def main() -> None:
    given = _harness.parser(__doc__)
    root = Path(__file__).resolve().parents[1]
    given.add_argument("--reference", type=Path, default=root.parent / "shared" / "reference")
    given.add_argument("--boxes", type=Path, help="folder of the Mann boxes (450 MB)")
    asked = given.parse_args()
    report = _harness.Report("simulate", quick=asked.quick, out=asked.out)
    speed(report, quick=asked.quick)
    convergence(report, quick=asked.quick)
    if asked.quick:
        report.close()
        return
    if not (asked.reference / "README.md").is_file():
        report.add("skipped", reason="no reference data: steady and turbulent were not run")
        report.close()
        return
    steady(report, asked.reference)
    try:
        if asked.boxes is not None:
            turbulent(report, asked.reference, asked.boxes)
        else:
            with tempfile.TemporaryDirectory() as folder:
                turbulent(report, asked.reference, Path(folder))
    except ModuleNotFoundError as error:
        report.add("skipped", reason=f"turbulent: {error}; it comes with the extra 'bench'")
    report.close()


if __name__ == "__main__":
    main()
