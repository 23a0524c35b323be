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

Gains go up to omega / k: the moment of a blade is M = M_0 - k beta with the wake held still, k the
largest of the full-load operating points, so that the loop of tilt and that of yaw have a bandwidth
of at most c_n k = omega, the rated rotor speed.  Faster than the rotor turns, the average that
the multiblade transform takes over a turn means nothing any more.

Common random numbers: every controller meets the same winds, and the variance of the cost is that
of the mean over seeds of what individual pitch changes against the same controller without it,
var(L_s - L_s,off) / seeds; how rough a seed's wind is cancels.

Source: S. Mulders, A. Pamososuryo, J.-W. van Wingerden, "Efficient tuning of Individual Pitch
Control: a Bayesian optimization machine learning approach", J. Phys.: Conf. Ser. 1618, 2020.  The
kernel sees gain and phase as points in a plane here; the paper's sees them as they are.
"""

from __future__ import annotations

import math
import threading
from collections.abc import Sequence
from itertools import pairwise
from typing import Any, ClassVar

import numpy as np
from numpy.typing import ArrayLike

from pitchopt.checks import FloatArray, finite_array, finite_number, whole_number
from pitchopt.control import IndividualPitch, TurbineController, decoupling_offset
from pitchopt.errors import ComputationError, InputError
from pitchopt.fatigue import bin_edges, combine_loads, weibull_weights
from pitchopt.sim.statistics import BLADE_SLOPE
from pitchopt.studies.simulation.controllers import moment_by_pitch, with_individual
from pitchopt.studies.tuning.plant import PlantRun, TuningPlant, failure_of, mean_measures
from pitchopt.tuning import Outcome, Parameter, Polar, Space
from pitchopt.turbines import Turbine

__all__ = ["IndividualPitchProblem", "individual_pitch_plant"]

SEEDS = (1, 2, 3, 4, 5, 6)
PITCH_LAG = 0.4  # of the paper's actuators [s]
AMPLITUDE = math.radians(5.0)  # largest of each harmonic
_ORDERS = (1, 2)
_START = 0.2  # bandwidth over rated rotor speed, that of the controller called ipc
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


class IndividualPitchProblem:
    """Cost of gains and offsets of individual pitch control.

    Parameters
    ----------
    plant : TuningPlant, optional
        See `individual_pitch_plant`; that of the NREL 5 MW without.
    wind_speeds : sequence of float
        Ascending [m/s].
    seeds : sequence of int
        Two or more, different.
    weibull_mean : float
        Mean wind speed of the site, for several wind speeds [m/s].
    controller : TurbineController, optional
        That individual pitch is added to; the turbine's baseline without.

    Attributes
    ----------
    space : Space
        ``gain_1p``, ``offset_1p``, ``gain_2p``, ``offset_2p`` in SI units.
    start : (4,) ndarray
        Bandwidths of a fifth of the rated rotor speed and the offsets of a rigid rotor.

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
        wind_speeds: Sequence[float] = (15.0,),
        seeds: Sequence[int] = SEEDS,
        weibull_mean: float = _MEAN_WIND,
        controller: TurbineController | None = None,
    ) -> None:
        self.plant = individual_pitch_plant() if plant is None else plant
        self.wind_speeds = tuple(finite_array("wind_speeds", wind_speeds).tolist())
        if any(b <= a for a, b in pairwise(self.wind_speeds)):
            raise InputError(f"wind_speeds: got {list(wind_speeds)}, expected ascending speeds")
        self.seeds = tuple(whole_number("seeds", seed, at_least=0) for seed in seeds)
        if len(set(self.seeds)) != len(self.seeds) or len(self.seeds) < 2:
            raise InputError(
                f"seeds: got {self.seeds}, expected two or more, different: the variance of the "
                "cost comes from them"
            )
        self.weibull_mean = finite_number("weibull_mean", weibull_mean, above=0.0)
        operation = self.plant.operation
        self.regulator = operation.baseline() if controller is None else controller
        rated = self.plant.turbine.rated_rotor_speed
        self.largest_gain = rated / moment_by_pitch(operation)
        self.space = Space(
            [
                part
                for n in _ORDERS
                for part in (
                    Parameter(name=f"gain_{n}p", low=0.0, high=self.largest_gain),
                    Parameter(
                        name=f"offset_{n}p", low=-math.pi / n, high=math.pi / n, periodic=True
                    ),
                )
            ],
            polar=[Polar(radius=f"gain_{n}p", angle=f"offset_{n}p") for n in _ORDERS],
        )
        speed = operation.start(self.wind_speeds[len(self.wind_speeds) // 2]).rotor_speed
        self.start = finite_array(
            "start",
            [
                part
                for n in _ORDERS
                for part in (
                    _START * self.largest_gain,
                    decoupling_offset(n, speed, self.plant.pitch_lag),
                )
            ],
        )
        self._lock = threading.Lock()
        self._reference: FloatArray | None = None

    def __getstate__(self) -> dict[str, Any]:
        return {name: value for name, value in self.__dict__.items() if name != "_lock"}

    def __setstate__(self, state: dict[str, Any]) -> None:
        self.__dict__.update(state)
        self._lock = threading.Lock()

    @property
    def simulations(self) -> int:
        """Runs so far, those of the reference included."""
        return self.plant.simulations

    @property
    def reference(self) -> FloatArray:
        """Loads of each seed (S,) without individual pitch [N m].

        Raises
        ------
        ComputationError
            If the turbine diverges without it.
        """
        with self._lock:
            if self._reference is None:
                runs = self._runs(self.regulator)
                failure = failure_of(runs)
                if failure is not None:
                    raise ComputationError(f"controller without individual pitch: {failure}")
                self._reference = self._loads(runs)
            return self._reference

    def document(self) -> dict[str, object]:
        """Plain data that names the problem."""
        return {
            "problem": self.name,
            "wind_speeds": list(self.wind_speeds),
            "seeds": list(self.seeds),
            "weibull_mean": self.weibull_mean if len(self.wind_speeds) > 1 else None,
            "amplitude": AMPLITUDE,
            "slope": BLADE_SLOPE,
            "plant": self.plant.document(),
            "space": self.space.document(),
        }

    def controller(self, x: ArrayLike) -> TurbineController:
        """Controller with the gains and offsets of a point (4,)."""
        point = self.space.point(x)
        individual = IndividualPitch(
            order=np.array(_ORDERS), gain=point[0::2], offset=point[1::2], limit=AMPLITUDE
        )
        return with_individual(self.regulator, individual, self.plant.operation)

    def __call__(self, x: ArrayLike) -> Outcome:
        """Cost of a point (4,), its replicates over seeds, and what else the runs measured.

        ``reduction`` is the share of the load that individual pitch takes off, ``pitch_rate`` the
        mean absolute pitch rate of the blades [rad/s].
        """
        reference = self.reference
        runs = self._runs(self.controller(x))
        failure = failure_of(runs)
        if failure is not None:
            return Outcome(cost=math.nan, message=failure)
        loads = self._loads(runs)
        changes = loads - reference
        cost = float(loads.mean())
        return Outcome(
            cost=cost,
            variance=float(changes.var(ddof=1)) / changes.size,
            replicates=tuple(loads.tolist()),
            measures={
                **mean_measures(runs),
                "reduction": 1.0 - cost / float(reference.mean()),
                "pitch_rate": float(np.mean([_pitch_rate(run) for run in runs])),
            },
        )

    def _runs(self, controller: TurbineController) -> list[PlantRun]:
        return self.plant.run(
            controller, [(speed, seed) for seed in self.seeds for speed in self.wind_speeds]
        )

    def _loads(self, runs: Sequence[PlantRun]) -> FloatArray:
        """Load of each seed (S,), summed in damage over the wind speeds."""
        loads = np.array([run.measures["blade_load"] for run in runs])
        loads = loads.reshape(len(self.seeds), len(self.wind_speeds))
        if len(self.wind_speeds) == 1:
            return np.asarray(loads[:, 0])
        weights = weibull_weights(
            bin_edges(self.wind_speeds), mean=self.weibull_mean, normalised=True
        )
        return combine_loads(loads, weights, BLADE_SLOPE)


def _pitch_rate(run: PlantRun) -> float:
    """Mean absolute pitch rate of the blades after the start-up [rad/s]."""
    simulation = run.simulation
    rows = simulation.after(run.skip)[:, [simulation.place(f"BldPitch{k}") for k in (1, 2, 3)]]
    return float(np.abs(np.diff(rows, axis=0)).mean() / simulation.interval)
