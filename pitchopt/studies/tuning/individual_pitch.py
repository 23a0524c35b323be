"""Individual pitch at once and twice per turn: gains and azimuth offsets for least blade fatigue.

The controller is `pitchopt.control.IndividualPitch` with two harmonics beside a regulator of the
rotor speed, and four numbers are tuned: integral gains c_1, c_2 [rad/(N m s)] and azimuth offsets
psi_1, psi_2 [rad].  The cost is the 1 Hz damage-equivalent load, slope 10, of the root moments out
of plane [N m], mean over blades and over seeds; over several wind speeds the loads of a seed are
first summed in damage with the Weibull weights of the speeds.  Individual pitch is not faded, so it
works below rated wind speed too, and the actuators reach as far below the fine pitch as both
amplitudes need.

A gain is not negative, and the offset stands within n (psi + offset), so that it has the period
2 pi / n and is free to turn the sign.  At gain zero all offsets are one controller, which
the space says by its polar pairs.

Gains go up to omega / k: with the wake held still the moment of a blade is M = M_0 - k beta, so
the loop of tilt and that of yaw have a bandwidth of c_n k, which at the largest gain is the rotor
speed omega; of several wind speeds the one with the least omega / k counts.  Faster than the rotor
turns, the average that the multiblade transform takes over a turn means nothing any more.

The start is the controller without individual pitch.  Every point meets its winds, so how rough a
seed is cancels from the variance of the cost (`pitchopt.studies.tuning.problem`).  A design by the
handbook stands beside it: bandwidths of a fifth of the rotor speed, as the controller called ipc
has above rated, and the offsets of a rigid rotor, atan(n omega tau)/n.

Source: S. Mulders, A. Pamososuryo, J.-W. van Wingerden, "Efficient tuning of Individual Pitch
Control: a Bayesian optimization machine learning approach", J. Phys.: Conf. Ser. 1618, 2020.  The
kernel sees gain and phase as points in a plane here; the paper's sees them as they are.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import pairwise
from typing import Any, ClassVar

import numpy as np

from pitchopt.checks import FloatArray, finite_array, finite_number
from pitchopt.control import IndividualPitch, TurbineController, decoupling_offset
from pitchopt.errors import InputError
from pitchopt.fatigue import bin_edges, combine_loads, weibull_weights
from pitchopt.sim.statistics import BLADE_SLOPE
from pitchopt.studies.simulation.controllers import with_individual
from pitchopt.studies.tuning.plant import PlantRun, TuningPlant, mean_measures
from pitchopt.studies.tuning.problem import TuningProblem
from pitchopt.tuning import Parameter, Polar, Space
from pitchopt.turbines import Turbine

__all__ = ["IndividualPitchGains", "individual_pitch_plant"]

WIND_SPEED = 15.0  # [m/s]
SEEDS = (1, 2, 3, 4, 5, 6)
PITCH_LAG = 0.4  # of the paper's actuators [s]
AMPLITUDE = math.radians(5.0)  # largest of each harmonic
_ORDERS = (1, 2)
_SHARE = 0.2  # bandwidth over rotor speed of the handbook's design
_MEAN_WIND = 10.0  # of class I, IEC 61400-1 [m/s]


def individual_pitch_plant(turbine: str | Turbine = "nrel-5mw", **options: Any) -> TuningPlant:
    """Plant with the paper's actuators, whose range leaves room below the fine pitch.

    Parameters
    ----------
    turbine : str or Turbine
    **options
        Of `TuningPlant`.
    """
    given = {"pitch_lag": PITCH_LAG, "pitch_below": len(_ORDERS) * AMPLITUDE, **options}
    return TuningPlant(turbine, **given)


class IndividualPitchGains(TuningProblem):
    """Cost of gains and offsets of individual pitch control.

    Parameters
    ----------
    plant : TuningPlant, optional
        See `individual_pitch_plant`; that of the NREL 5 MW without.
    wind_speeds : sequence of float
        Ascending [m/s].
    seeds : sequence of int
        Different.
    weibull_mean : float
        Mean wind speed of the site, for several wind speeds [m/s].
    base : TurbineController, optional
        That individual pitch is added to; the turbine's baseline without.

    Attributes
    ----------
    space : Space
        ``gain_1p``, ``offset_1p``, ``gain_2p``, ``offset_2p`` in SI units and radians.
    start : (4,) ndarray
        No individual pitch.
    handbook : (4,) ndarray
        The handbook's design; see the module.

    Raises
    ------
    InputError
        If a number is out of range.
    """

    name: ClassVar[str] = "individual-pitch"

    def __init__(
        self,
        plant: TuningPlant | None = None,
        *,
        wind_speeds: Sequence[float] = (WIND_SPEED,),
        seeds: Sequence[int] = SEEDS,
        weibull_mean: float = _MEAN_WIND,
        base: TurbineController | None = None,
    ) -> None:
        plant = individual_pitch_plant() if plant is None else plant
        speeds = finite_array("wind_speeds", wind_speeds)
        largest = min(_largest_gain(plant, speed) for speed in speeds.tolist())
        space = Space(
            [
                part
                for n in _ORDERS
                for part in (
                    Parameter(name=f"gain_{n}p", low=0.0, high=largest),
                    Parameter(
                        name=f"offset_{n}p", low=-math.pi / n, high=math.pi / n, periodic=True
                    ),
                )
            ],
            polar=[Polar(radius=f"gain_{n}p", angle=f"offset_{n}p") for n in _ORDERS],
        )
        super().__init__(
            plant, space, np.zeros(len(space)), wind_speeds=wind_speeds, seeds=seeds, base=base
        )
        if any(b <= a for a, b in pairwise(self.wind_speeds)):
            raise InputError(f"wind_speeds: got {self.wind_speeds}, expected ascending speeds")
        self.weibull_mean = finite_number("weibull_mean", weibull_mean, above=0.0)
        omega = plant.operation.start(self.wind_speeds[len(self.wind_speeds) // 2]).rotor_speed
        self.handbook = finite_array(
            "handbook",
            [
                part
                for n in _ORDERS
                for part in (_SHARE * largest, decoupling_offset(n, omega, plant.pitch_lag))
            ],
        )

    def controller(self, x: FloatArray) -> TurbineController:
        """Controller with the gains and offsets of a point (4,)."""
        individual = IndividualPitch(
            order=np.array(_ORDERS), gain=x[0::2], offset=x[1::2], limit=AMPLITUDE
        )
        return with_individual(self.base, individual, self.plant.operation)

    def cost_of(self, runs: Sequence[PlantRun]) -> float:
        """Load of a seed [N m], summed in damage over the wind speeds."""
        loads = [run.measures["blade_load"] for run in runs]
        if len(loads) == 1:
            return loads[0]
        weights = weibull_weights(
            bin_edges(self.wind_speeds), mean=self.weibull_mean, normalised=True
        )
        return float(combine_loads(loads, weights, BLADE_SLOPE))

    def measures_of(self, runs: Sequence[PlantRun]) -> dict[str, float]:
        """Those of the plant and ``pitch_rate``, mean and absolute over the blades [rad/s]."""
        return {
            **mean_measures(runs),
            "pitch_rate": float(np.mean([_pitch_rate(run) for run in runs])),
        }

    def document(self) -> dict[str, object]:
        """Plain data that names the problem with all that its results depend on."""
        several = len(self.wind_speeds) > 1
        return {
            **super().document(),
            "weibull_mean": self.weibull_mean if several else None,
            "amplitude": AMPLITUDE,
        }

    def tuner_options(self, method: str) -> dict[str, Any]:
        """Start of a zeroth-order tuner from the handbook's design."""
        if method == "zoo":
            return {"start": self.handbook}
        return super().tuner_options(method)


def _largest_gain(plant: TuningPlant, wind_speed: float) -> float:
    """Rotor speed over moment by pitch [rad/(N m s)] in steady operation at a speed [m/s]."""
    operation = plant.operation
    moment = -float(
        np.interp(wind_speed, operation.curve.wind_speed, operation.frozen_slopes.bending)
    )
    if moment <= 0.0:
        raise InputError(
            f"wind_speeds: at {wind_speed:g} m/s pitch takes no bending off the blades of "
            f"{plant.turbine.name!r}, which individual pitch needs"
        )
    return operation.start(wind_speed).rotor_speed / moment


def _pitch_rate(run: PlantRun) -> float:
    """Mean absolute pitch rate of the blades after the start-up [rad/s]."""
    simulation = run.simulation
    rows = simulation.after(run.skip)[:, [simulation.place(f"BldPitch{k}") for k in (1, 2, 3)]]
    return float(np.abs(np.diff(rows, axis=0)).mean() / simulation.interval)
