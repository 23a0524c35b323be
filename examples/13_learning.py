"""Learning a pitch profile from measured loads alone, with both learners (paper 003, figure 8).

What ``pitchopt learn --wind-step 22:+2`` does, with the adaptive learner and with the paper's.

    python 13_learning.py [FOLDER] [--quick]
"""

import argparse
from pathlib import Path

from pitchopt.cases import load_case
from pitchopt.exports import write_files
from pitchopt.plotting import learning_figure, png
from pitchopt.studies.learning import LearningSettings, WindStep, learn


def main(argv=None):
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("folder", nargs="?", default="example-output", type=Path)
    parser.add_argument("--quick", action="store_true", help="coarser and shorter")
    args = parser.parse_args(argv)

    case = load_case("biegel2011")
    if args.quick:
        case = case.with_values({"aero.segments": 10, "limits.positions": 6})
    rotations, step = (12, 6) if args.quick else (50, 22)
    wind = WindStep(speed=case.wind.speed, change=2.0, rotation=step)
    files = {}
    for learner in ("adaptive", "paper"):
        result = learn(case, LearningSettings(learner=learner, rotations=rotations, wind=wind))
        recovery = result.recovery_rotations
        print(
            f"{learner}: {result.practice} rotations of experiment; sum of RMS "
            f"{result.start.rms_sum:.4g} at the start, {result.rms[step - 1].sum():.4g} after "
            f"{step} rotations, {result.ratio(step):.2f} times the design's; after the step "
            + (
                "1.3 times not reached"
                if recovery is None
                else f"1.3 times in {recovery} rotations"
            )
        )
        title = f"{case.name}, {learner} learner"
        files[f"13_{learner}.png"] = png(learning_figure(result, title=title))
    args.folder.mkdir(parents=True, exist_ok=True)
    for path in write_files(args.folder, files):
        print(path)


if __name__ == "__main__":
    main()
