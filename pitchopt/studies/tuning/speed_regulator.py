"""Natural frequency and damping of the speed regulator: Zalkind et al., section 3.2.

    minimise over (omega, zeta)    C = M + B,                                                (29)

    B = 0                                 for omega_max < omega_soft,
        k_B (omega_max - omega_soft)^2    else,                                              (30)
    k_B = c_max / (omega_hard - omega_soft)^2,    c_max = M(z^1) / 12,                 (31), (32)

with M a load, omega_max the largest generator speed of a run above rated, and z^1 the start.  The
two speeds are the same multiples of rated as the paper's 1300 and 1400 rpm of the NREL 5 MW's
1173.7; torque is constant above rated speed.

The paper does not name its wind speed.  The first whole one above rated is taken, 12 m/s for the
NREL 5 MW: near rated the thrust is at its peak, so what the pitch
does shows in the tower most (the authors say that fatigue is greatest from there on), and it is
where an optimum like theirs comes out, at a low frequency and a high damping, for about 22 % less
cost in class B.  At 14, 16 and 18 m/s the best of a 10 by 10 grid has 17, 11 and 8 % less.

Other rotors turn slower; their suggested start is (0.6 rad/s Omega / 12.1 rpm, 0.7), which is the
handbook's (0.6, 0.7) at the NREL 5 MW's rated speed.  Bounds and settings are the paper's for all.

Source: Zalkind, Dall'Anese, Pao, Automatic controller tuning using a zeroth-order optimization
algorithm, Wind Energy Science 5 (2020), table 2.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Sequence
from typing import Any, ClassVar, Literal

import numpy as np
from numpy.typing import ArrayLike

from pitchopt.checks import FloatArray
from pitchopt.control import TurbineController
from pitchopt.errors import InputError
from pitchopt.studies.tuning.plant import PlantRun, TuningPlant, plant_or_new
from pitchopt.studies.tuning.problem import TuningProblem
from pitchopt.tuning import Parameter, Space

__all__ = ["HARD_SPEED", "SOFT_SPEED", "SpeedRegulator", "suggested_start", "suggested_wind_speed"]

SOFT_SPEED = 1300.0 / 1173.7
HARD_SPEED = 1400.0 / 1173.7
"""Limits of the generator speed over rated."""
_SHARE = 1.0 / 12.0  # of the start's load that the barrier adds at the hard limit
_LOW, _HIGH = (0.01, 0.1), (1.0, 3.0)
_HANDBOOK = 0.6 / (12.1 * math.pi / 30.0)  # frequency over rated rotor speed

Load = Literal["tower_load", "flapwise_moment"]


def suggested_start(plant: TuningPlant) -> tuple[float, float]:
    """Frequency [rad/s] and damping of the handbook's controller, scaled to the rotor."""
    return _HANDBOOK * plant.turbine.rated_rotor_speed, 0.7


def suggested_wind_speed(plant: TuningPlant) -> float:
    """Lowest wind speed of the turbine's curve, in steps of 1 m/s, at which pitch limits power.

    Raises
    ------
    InputError
        If there is none.
    """
    operation = plant.operation
    if operation.full_load.size == 0:
        raise InputError(
            f"turbine {plant.turbine.name!r}: no wind speed at which pitch limits the power; give "
            "wind_speeds"
        )
    return float(operation.curve.wind_speed[operation.full_load[0]])


class SpeedRegulator(TuningProblem):
    """Speed regulator for the least load within the speed limits; the cost is in N m.

    Parameters
    ----------
    plant : TuningPlant, optional
        The NREL 5 MW in class B without.
    load : {"tower_load", "flapwise_moment"}
        M: damage-equivalent fore-aft moment of the tower base, or largest flapwise root moment.
    wind_speeds : sequence of float, optional
        `suggested_wind_speed` without.  The cost is the mean over them.
    seeds : sequence of int
    start : (2,) array_like, optional
        omega [rad/s] and zeta [-], z^1 of equation (32) wherever a tuner begins; `suggested_start`
        without.
    base : TurbineController, optional
        Controller whose pitch regulator is changed; the turbine's baseline without.  Either has
        constant torque above rated speed.
    """

    name: ClassVar[str] = "speed-regulator"

    def __init__(
        self,
        plant: TuningPlant | None = None,
        *,
        load: Load = "tower_load",
        wind_speeds: Sequence[float] | None = None,
        seeds: Sequence[int] = (1,),
        start: ArrayLike | None = None,
        base: TurbineController | None = None,
    ) -> None:
        if load not in ("tower_load", "flapwise_moment"):
            raise InputError(f"load: got {load!r}, expected tower_load or flapwise_moment")
        plant = plant_or_new(plant)
        super().__init__(
            plant,
            Space(
                [
                    Parameter(name="omega", low=_LOW[0], high=_HIGH[0]),
                    Parameter(name="zeta", low=_LOW[1], high=_HIGH[1]),
                ]
            ),
            suggested_start(plant) if start is None else start,
            wind_speeds=(suggested_wind_speed(plant),) if wind_speeds is None else wind_speeds,
            seeds=seeds,
            base=base,
        )
        self.load: Load = load
        self.shown = (load, "generator_speed")
        turbine = plant.turbine
        rated = turbine.rated_rotor_speed * turbine.drivetrain.gear_ratio
        self.soft_speed, self.hard_speed = SOFT_SPEED * rated, HARD_SPEED * rated
        self._barrier = math.nan

    def controller(self, x: FloatArray) -> TurbineController:
        """Base controller with the regulator of a frequency [rad/s] and a damping [-]."""
        regulator = self.plant.operation.pitch_regulator(frequency=float(x[0]), damping=float(x[1]))
        torque = dataclasses.replace(self.base.torque, constant_power=False)
        return dataclasses.replace(self.base, torque=torque, pitch=regulator)

    def barrier(self, speed: float) -> float:
        """B of the largest generator speed [rad/s], in N m."""
        return self._barrier * max(speed - self.soft_speed, 0.0) ** 2

    def cost_of(self, runs: Sequence[PlantRun]) -> float:
        """Load with the barrier, mean over wind speeds [N m]."""
        return float(
            np.mean(
                [
                    run.measures[self.load] + self.barrier(run.measures["generator_speed"])
                    for run in runs
                ]
            )
        )

    def _refer(self, runs: Sequence[PlantRun]) -> None:
        """k_B from the load of the start."""
        load = float(np.mean([run.measures[self.load] for run in runs]))
        self._barrier = _SHARE * load / (self.hard_speed - self.soft_speed) ** 2

    def document(self) -> dict[str, object]:
        """As the base's, with load and limits."""
        return super().document() | {
            "load": self.load,
            "soft_speed": self.soft_speed,
            "hard_speed": self.hard_speed,
        }

    def tuner_options(self, method: str) -> dict[str, Any]:
        """Table 2 of the paper for ``zoo``, with a random first angle."""
        if method != "zoo":
            return super().tuner_options(method)
        return {
            "samples": 3,
            "stages": 7,
            "radius": 0.05,
            "step": 3.0,
            "step_over": self.load,
            "scaling": (0.25, 1.0),
            "shrinkage": 0.5,
            "threshold": 0.05,
            "steps": 3,
            "directions": "even",
            "coordinates": "own",
        }
