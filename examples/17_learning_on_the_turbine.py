"""The learner on the dynamic turbine: structure in motion, steady sheared wind and turbulence.

What ``pitchopt learn --plant dynamic`` does: first with blades and tower locked and free in
steady wind, then in turbulence, where the loads of every profile are averaged over rotations.

    python 17_learning_on_the_turbine.py [FOLDER] [--quick]
"""

import argparse
from pathlib import Path

from pitchopt.cases import load_case
from pitchopt.exports import write_files
from pitchopt.plotting import png, turbine_learning_figure
from pitchopt.studies.learning import LearningSettings, TurbineSettings, learn_on_turbine


def main(argv=None):
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("folder", nargs="?", default="example-output", type=Path)
    parser.add_argument("--quick", action="store_true", help="coarser and shorter")
    args = parser.parse_args(argv)

    case = load_case("nrel-5mw").with_values(
        {"wind.speed": 9.0, "objective.weights": "unit", "objective.harmonics": 3}
    )
    case = case.with_values({"limits.positions": 8 if args.quick else 24})
    runs = {
        "rigid": TurbineSettings(structure="rigid"),
        "flexible": TurbineSettings(),
        "turbulent": TurbineSettings(turbulence="C", averaged=1 if args.quick else 20),
    }
    files, known = {}, None
    for name, turbine in runs.items():
        settings = LearningSettings(
            rotations=3 if args.quick else 10,
            max_power_loss=0.03,
            amplitude=0.026 if turbine.averaged else None,
        )
        result = learn_on_turbine(
            case, settings, turbine, known=known, judged=5 if args.quick else 60
        )
        known = result.reference
        print(
            f"{name}: loads {result.setup.lag.samples} samples late; of the constant pitch's RMS "
            f"the learned profile leaves {100 * result.share(result.learned, 'total'):.0f} %, of "
            f"what repeats with the rotor {100 * result.share(result.learned, 'periodic'):.0f} %"
        )
        files[f"17_{name}.png"] = png(turbine_learning_figure(result, title=f"nrel-5mw, {name}"))
    args.folder.mkdir(parents=True, exist_ok=True)
    for path in write_files(args.folder, files):
        print(path)


if __name__ == "__main__":
    main()
