"""Chord and tower diameter of ``biegel2011`` from the two figures that the paper gives.

usage: python tools/calibrate_biegel.py

The paper leaves chord and tower radius open.  One chord and one radius are chosen so that the
best constant pitch (largest mean torque) has mean torque 1.41e6 N m and summed RMS 3.2e4.
Prints the values for ``turbine_sources.py``; all else of that case is a prediction.
"""

from __future__ import annotations

import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
from scipy.optimize import fsolve

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))

from pitchopt.cases import load_case
from pitchopt.design import constant

TORQUE, RMS_SUM = 1.41e6, 3.2e4


def misses(logarithms: np.ndarray) -> list[float]:
    """Logarithmic misses of torque and RMS for the logarithms of chord and radius."""
    chord, radius = np.exp(logarithms)
    case = load_case("biegel2011")
    task = case.task()
    model = task.model
    blade = replace(model.rotor.blade, chord=np.full(model.rotor.blade.chord.shape, chord))
    tower = replace(model.wind.tower, radius=np.full(np.shape(model.wind.tower.radius), radius))
    model = replace(
        model, rotor=replace(model.rotor, blade=blade), wind=replace(model.wind, tower=tower)
    )
    best = constant(replace(task, model=model))
    return [float(np.log(best.mean_torque / TORQUE)), float(np.log(best.rms_sum / RMS_SUM))]


def main() -> int:
    """Solve and print."""
    chord, radius = np.exp(fsolve(misses, np.log([0.957, 0.97]), xtol=1e-12))
    print(f'"chord": {chord:.9g}, "diameter": {2 * radius:.9g}  (radius {radius:.5f} m)')
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
