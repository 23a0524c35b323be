"""Gain of the torque law below rated power: the problem of Zalkind et al., section 3.1.

    tau_g = k_fact k_opt omega_g^2,    minimise over k_fact    -P_avg,                  (23), (24)

    P_avg = sum_u p(u) P(u) / sum_u p(u),    u = 6, 8, 10 m/s,                               (25)

with P(u) the mean generator power of a turbulent run and p the density of a Weibull distribution.
At a rotor that follows its best tip-speed ratio slowly, less torque lets it speed up with gusts,
which hold more energy than lulls lack; so at 8 m/s alone, in region 2 throughout, the best factor
lies below one.  Near rated speed the transition to full torque draws it back.

Source: Zalkind, Dall'Anese, Pao, Automatic controller tuning using a zeroth-order optimization
algorithm, Wind Energy Science 5 (2020); turbulence of class A and table 1 are theirs.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Sequence
from typing import Any, ClassVar

import numpy as np

from pitchopt.checks import FloatArray, finite_number
from pitchopt.control import TurbineController
from pitchopt.errors import InputError
from pitchopt.studies.tuning.plant import PlantRun, TuningPlant, plant_or_new
from pitchopt.studies.tuning.problem import TuningProblem
from pitchopt.tuning import Parameter, Space

__all__ = ["TorqueGain", "weibull_density"]

WIND_SPEEDS = (6.0, 8.0, 10.0)
TURBULENCE = "A"
_SHAPE = 2.17
_SCALE = 10.3
_BOUNDS = (0.3, 1.7)


def weibull_density(speed: float, *, shape: float = _SHAPE, scale: float = _SCALE) -> float:
    """Density of wind speeds [s/m] at a speed [m/s] for a shape [-] and a scale [m/s]."""
    ratio = speed / scale
    return shape / scale * math.pow(ratio, shape - 1.0) * math.exp(-math.pow(ratio, shape))


class TorqueGain(TuningProblem):
    """Factor on the gain of region 2 for the largest mean power; the cost is in watts.

    Parameters
    ----------
    plant : TuningPlant, optional
        The NREL 5 MW in class A without.
    wind_speeds : sequence of float
        6, 8 and 10 m/s; ``(8.0,)`` for region 2 alone.
    seeds : sequence of int
        One turbulent run for each wind speed by default.
    start : float
        k_fact to begin with.
    base : TurbineController, optional
        Controller whose torque law is changed; the turbine's baseline without.
    shape, scale : float
        Of the Weibull distribution [-], [m/s].
    """

    name: ClassVar[str] = "torque-gain"
    shown = ("tower_load",)

    def __init__(
        self,
        plant: TuningPlant | None = None,
        *,
        wind_speeds: Sequence[float] = WIND_SPEEDS,
        seeds: Sequence[int] = (1,),
        start: float = 0.6,
        base: TurbineController | None = None,
        shape: float = _SHAPE,
        scale: float = _SCALE,
    ) -> None:
        super().__init__(
            plant_or_new(plant, turbulence=TURBULENCE),
            Space([Parameter(name="k_fact", low=_BOUNDS[0], high=_BOUNDS[1])]),
            [start],
            wind_speeds=wind_speeds,
            seeds=seeds,
            base=base,
        )
        self.shape = finite_number("shape", shape, above=0.0)
        self.scale = finite_number("scale", scale, above=0.0)
        if 0.0 in self.wind_speeds:
            raise InputError(f"wind_speeds: got {self.wind_speeds}, expected speeds above 0")
        density = np.array([weibull_density(u, shape=shape, scale=scale) for u in self.wind_speeds])
        weights = (density / density.sum()).tolist()
        self._weights: dict[float, float] = dict(zip(self.wind_speeds, weights, strict=True))

    def controller(self, x: FloatArray) -> TurbineController:
        """Base controller with the gain times k_fact."""
        torque = dataclasses.replace(self.base.torque, factor=float(x[0]))
        return dataclasses.replace(self.base, torque=torque)

    def cost_of(self, runs: Sequence[PlantRun]) -> float:
        """Minus the weighted mean power [W]."""
        return -sum(self._weights[run.wind_speed] * run.measures["power"] for run in runs)

    def measures_of(self, runs: Sequence[PlantRun]) -> dict[str, float]:
        """Means over wind speeds, and the mean power at each of them [W]."""
        powers = {
            f"power_{speed:g}": float(
                np.mean([run.measures["power"] for run in runs if run.wind_speed == speed])
            )
            for speed in self.wind_speeds
        }
        return super().measures_of(runs) | powers

    def document(self) -> dict[str, object]:
        """As the base's, with the distribution of wind speeds."""
        return super().document() | {"weibull": [self.shape, self.scale]}

    def tuner_options(self, method: str) -> dict[str, Any]:
        """Table 1 of the paper for ``zoo``."""
        if method != "zoo":
            return super().tuner_options(method)
        return {
            "samples": 2,
            "stages": 7,
            "radius": 0.05,
            "step": 10.0,
            "step_over": "cost",
            "shrinkage": 0.5,
            "threshold": 0.05,
            "steps": 3,
            "directions": "even",
            "coordinates": "own",
        }
