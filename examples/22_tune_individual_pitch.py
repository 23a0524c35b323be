"""Individual pitch at once and twice per turn, tuned by Bayesian optimisation.

Gains and azimuth offsets of both harmonics for the least blade fatigue of the NREL 5 MW below and
above rated wind speed (figures 3 and 4 of Mulders et al.), beside the offsets that decouple tilt
from yaw: those of a rigid rotor behind its actuators in closed form, and those measured on the
turbine.

    python 22_tune_individual_pitch.py [FOLDER] [--quick]
"""

import argparse
import math
from pathlib import Path

from pitchopt.control import decoupling_offset
from pitchopt.exports import write_files
from pitchopt.plotting import gain_samples, individual_pitch_figure, png, progress_figure
from pitchopt.studies.tuning import (
    IndividualPitchGains,
    fixed_frame_response,
    individual_pitch_plant,
)
from pitchopt.tuning import run_study
from pitchopt.tuning.methods import make_tuner


def main(argv=None):
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("folder", nargs="?", default="example-output", type=Path)
    parser.add_argument("--quick", action="store_true", help="shorter, with fewer evaluations")
    args = parser.parse_args(argv)

    coarse = {"duration": 30.0, "skip": 10.0, "box_points": 7} if args.quick else {}
    evaluations = 12 if args.quick else 100
    plant = individual_pitch_plant("nrel-5mw", **coarse)
    samples = {}
    for speed in (7.0, 25.0):
        problem = IndividualPitchGains(
            plant, wind_speeds=(speed,), seeds=(1, 2) if args.quick else range(1, 7)
        )
        tuner = make_tuner("bayes", problem.space, evaluations=evaluations)
        study = run_study(
            problem, tuner, evaluations=evaluations, problem=problem.document(), progress=True
        )
        off, handbook = problem.reference.cost, problem(problem.handbook).cost
        gain, offset = study.best.x[0::2], study.best.x[1::2]
        print(
            f"{speed:g} m/s: {off / 1e6:.3f} MN m without individual pitch, by the handbook "
            f"{100 * (handbook / off - 1):+.1f} %, tuned {100 * (study.best.cost / off - 1):+.1f} "
            f"% after {len(study.evaluations)} evaluations in {study.seconds:.0f} s"
        )
        omega = plant.operation.start(speed).rotor_speed
        for n in (1, 2):
            measured = fixed_frame_response(
                plant.dynamic,
                speed,
                order=n,
                settling=10.0 if args.quick else 60.0,
                operation=plant.operation,
            ).decoupling_offset
            print(
                f"  {n}P: gain {gain[n - 1] / problem.space.upper[0]:.2f} of the largest, offset "
                f"{math.degrees(offset[n - 1]):.1f} deg; decoupled at {math.degrees(measured):.1f} "
                "deg, rigid rotor at "
                f"{math.degrees(decoupling_offset(n, omega, plant.pitch_lag)):.1f} deg"
            )
        samples[f"{speed:g} m/s"] = gain_samples(study.evaluations, off)
    args.folder.mkdir(parents=True, exist_ok=True)
    files = {
        "22_progress.png": png(progress_figure(samples)),
        "22_samples.png": png(individual_pitch_figure(samples)),
        "22_samples_rectangular.png": png(individual_pitch_figure(samples, plane="rectangular")),
    }
    for path in write_files(args.folder, files):
        print(path)


if __name__ == "__main__":
    main()
