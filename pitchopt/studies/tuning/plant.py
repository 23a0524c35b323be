"""The dynamic turbine as the plant of tuning problems: controllers in, runs and measures out.

Every controller meets the same winds: a Kaimal box is made once for each mean speed and seed and
kept, so that costs of two controllers differ by the controllers alone (common random numbers).
Runs of one controller go side by side in threads; results do not depend on how many there are.

What a run is judged by, all without its start-up:

    power             mean electrical power [W]
    tower_load        1 Hz damage-equivalent fore-aft moment of the tower base, slope 4 [N m]
    blade_load        1 Hz damage-equivalent out-of-plane root moment, slope 10, mean of the
                      blades [N m]
    generator_speed   largest [rad/s]
    flapwise_moment   largest flapwise root moment of all blades [N m]

A plant that travels to another process takes its numbers along; winds and tables are made there,
when they are needed, and stay there for the next time that the same plant comes.
"""

from __future__ import annotations

import copy
import dataclasses
import hashlib
import json
import os
import threading
import uuid
from collections import OrderedDict
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from functools import cached_property, partial
from typing import Any, Literal

import numpy as np

from pitchopt.checks import finite_number, whole_number
from pitchopt.control import PitchActuator, TurbineController
from pitchopt.errors import InputError
from pitchopt.sim import DynamicTurbine, Operation, Simulation, simulate_many, statistics
from pitchopt.sim.wind import Wind, check_speeds
from pitchopt.studies.simulation import SimulationSettings, WindCase, wind_cases
from pitchopt.studies.tuning.plain import plain
from pitchopt.turbines import Turbine, load_turbine
from windfield import BoxCache

__all__ = ["MEASURES", "PlantRun", "TuningPlant", "failure_of", "mean_measures", "plant_or_new"]

MEASURES = ("power", "tower_load", "blade_load", "generator_speed", "flapwise_moment")
"""Names of what a run is judged by."""

_BLADES = (1, 2, 3)  # as many as a dynamic turbine has
_VISITORS = 2  # plants from other processes whose winds are kept


@dataclass(frozen=True, kw_only=True, eq=False)
class PlantRun:
    """One run.

    Attributes
    ----------
    wind_speed : float
        Mean at the hub [m/s].
    seed : int
    skip : float
        Start of the series that measures leave out [s].
    simulation : Simulation
    """

    wind_speed: float
    seed: int
    skip: float
    simulation: Simulation

    @property
    def failure(self) -> str | None:
        """Why the run cannot be judged, or None."""
        if self.simulation.status == "finished":
            return None
        return f"{self.wind_speed:g} m/s, seed {self.seed}: {self.simulation.message}"

    @cached_property
    def measures(self) -> dict[str, float]:
        """Numbers of `MEASURES` by name, SI units; see the module.  Of a finished run."""
        bending = [f"RootMyc{k}" for k in _BLADES]
        flapwise = [f"RootMyb{k}" for k in _BLADES]
        found = statistics(
            self.simulation,
            skip=self.skip,
            names=["GenPwr", "GenSpeed", "TwrBsMyt", *bending, *flapwise],
        )
        tower = found["TwrBsMyt"].equivalent_load
        loads = np.array([found[name].equivalent_load for name in bending], dtype=np.float64)
        assert tower is not None  # moments have one
        return {
            "power": found["GenPwr"].mean,
            "tower_load": tower,
            "blade_load": float(loads.mean()),
            "generator_speed": found["GenSpeed"].largest,
            "flapwise_moment": max(found[name].largest for name in flapwise),
        }


def plant_or_new(plant: TuningPlant | None, **settings: Any) -> TuningPlant:
    """The given plant, or a new one.

    Raises
    ------
    InputError
        If what is given is no plant.
    """
    if plant is None:
        return TuningPlant(**settings)
    if not isinstance(plant, TuningPlant):
        raise InputError(f"plant: got {type(plant).__name__}, expected a TuningPlant")
    return plant


def failure_of(runs: Iterable[PlantRun]) -> str | None:
    """Why a controller cannot be judged by its runs: the first failure, or None."""
    return next((run.failure for run in runs if run.failure is not None), None)


def mean_measures(runs: Sequence[PlantRun]) -> dict[str, float]:
    """Mean of each measure over runs; of the largest values too, so that seeds weigh alike."""
    return {name: float(np.mean([run.measures[name] for run in runs])) for name in MEASURES}


class _Made:
    """What a plant makes and keeps: winds, and the tables of its turbine."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._dynamic: DynamicTurbine | None = None
        self._operation: Operation | None = None
        self._locks: dict[tuple[float, int | None], threading.Lock] = {}
        self._winds: dict[tuple[float, int | None], Wind] = {}

    def turbine(self, make: Callable[[], DynamicTurbine]) -> DynamicTurbine:
        """The turbine that moves."""
        with self._lock:
            if self._dynamic is None:
                self._dynamic = make()
            return self._dynamic

    def steady(self, dynamic: DynamicTurbine) -> Operation:
        """Steady operation with its curve, which controllers and starts of runs follow from."""
        with self._lock:
            if self._operation is None:
                operation = Operation(dynamic)
                operation.curve  # noqa: B018  (here, and not by several threads at once)
                self._operation = operation
            return self._operation

    def elsewhere(self) -> _Made:
        """The same turbine and operation, without winds."""
        other = _Made()
        with self._lock:
            other._dynamic, other._operation = self._dynamic, self._operation
        return other

    def wind(self, case: WindCase) -> Wind:
        """Wind of a case, made by whoever asks first while others wait for it."""
        key = (case.wind_speed, case.seed)
        with self._lock:
            lock = self._locks.setdefault(key, threading.Lock())
        with lock:
            if key not in self._winds:
                self._winds[key] = case.make()
            return self._winds[key]


_visitors: OrderedDict[str, _Made] = OrderedDict()
_door = threading.Lock()


def _visitor(token: str) -> _Made:
    """What was made for a plant when it came before."""
    with _door:
        found = _visitors.setdefault(token, _Made())
        _visitors.move_to_end(token)
        while len(_visitors) > _VISITORS:
            _visitors.popitem(last=False)
        return found


class TuningPlant:
    """A turbine with its winds.

    Parameters
    ----------
    turbine : str or Turbine
        Key of the catalogue, file, or the turbine itself.
    turbulence : str
        IEC class ``A+``, ``A``, ``B``, ``C``, an intensity such as ``0.14``, or ``none`` for steady
        wind, which is the same with every seed.
    duration : float
        That measures are taken over [s].
    skip : float
        Simulated before that [s].
    pitch_lag : float
        Time constant of the pitch actuators [s]; 0 for none.
    pitch_below : float
        How far the actuators reach below the turbine's own range [rad], for blades that pitch
        about a collective pitch at its end.
    inflow : {"dynamic", "quasi-steady"}
        See `DynamicTurbine`.
    generator_inertia : float, optional
        In place of the turbine's own [kg m^2].
    shear : float, optional
        Exponent of the mean wind's power law, 0.2 without.
    tower_shadow : bool
    box_points : int
        Of a Kaimal box across and upward.
    box_interval : float
        Between two slices of it [s].
    workers : int, optional
        Threads of one controller's runs; as many as there are cores without.
    cache : BoxCache, optional
        Where Kaimal boxes are kept on disk.

    Attributes
    ----------
    settings : SimulationSettings
        Without wind speeds and seeds.
    dynamic : DynamicTurbine
    operation : Operation
        Of the turbine, for controllers.

    Raises
    ------
    InputError
        If the turbine is unknown or lacks data, or a number is out of range.
    """

    def __init__(
        self,
        turbine: str | Turbine = "nrel-5mw",
        *,
        turbulence: str = "B",
        duration: float = 600.0,
        skip: float = 60.0,
        pitch_lag: float = 0.0,
        pitch_below: float = 0.0,
        inflow: Literal["dynamic", "quasi-steady"] = "dynamic",
        generator_inertia: float | None = None,
        shear: float | None = None,
        tower_shadow: bool = True,
        box_points: int = 13,
        box_interval: float = 0.1,
        workers: int | None = None,
        cache: BoxCache | None = None,
    ) -> None:
        self.turbine = turbine if isinstance(turbine, Turbine) else load_turbine(turbine)
        self.settings = SimulationSettings(
            turbulence=turbulence,
            duration=duration,
            skip=skip,
            shear=shear,
            tower_shadow=tower_shadow,
            box_points=box_points,
            box_interval=box_interval,
        )
        self.pitch_lag = finite_number("pitch_lag", pitch_lag, at_least=0.0)
        self.pitch_below = finite_number("pitch_below", pitch_below, at_least=0.0)
        self.inflow = inflow
        self.generator_inertia = generator_inertia
        self.workers = (
            os.cpu_count() or 1 if workers is None else whole_number("workers", workers, at_least=1)
        )
        self.cache = cache
        self._token = uuid.uuid4().hex
        self._made = _Made()
        self._lock = threading.Lock()
        self._simulations = 0
        self.dynamic  # noqa: B018  (raises what is missing)

    def __getstate__(self) -> dict[str, Any]:
        made = ("_lock", "_made", "_simulations")
        return {name: value for name, value in self.__dict__.items() if name not in made}

    def __setstate__(self, state: dict[str, Any]) -> None:
        self.__dict__.update(state)
        self._made = _visitor(self._token)
        self._lock = threading.Lock()
        self._simulations = 0

    @property
    def dynamic(self) -> DynamicTurbine:
        """The turbine that moves."""
        return self._made.turbine(self._moving)

    @property
    def operation(self) -> Operation:
        """Steady operation of the turbine."""
        return self._made.steady(self.dynamic)

    def _moving(self) -> DynamicTurbine:
        low, high = self.turbine.pitch_range
        return DynamicTurbine(
            turbine=self.turbine,
            inflow=self.inflow,
            generator_inertia=self.generator_inertia,
            actuator=PitchActuator(
                lowest=low - self.pitch_below,
                highest=high,
                rate=self.turbine.pitch_rate,
                time_constant=self.pitch_lag or None,
            ),
        )

    @property
    def simulations(self) -> int:
        """Runs so far, those that diverged included."""
        return self._simulations

    def document(self) -> dict[str, object]:
        """Plain data that results depend on besides controllers, wind speeds and seeds."""
        settings = self.settings
        return {
            "turbine": self.turbine.name,
            "turbine_data": self._digest,
            "turbulence": settings.turbulence,
            "duration": settings.duration,
            "skip": settings.skip,
            "pitch_lag": self.pitch_lag,
            "pitch_below": self.pitch_below,
            "inflow": self.inflow,
            "generator_inertia": self.dynamic.generator_inertia,
            "shear": settings.exponent,
            "tower_shadow": settings.tower_shadow,
            "box_points": settings.box_points,
            "box_interval": settings.box_interval,
            "step": self.dynamic.step,
        }

    @cached_property
    def _digest(self) -> str:
        """Fingerprint of all numbers of the turbine, so that another of its name is another."""
        numbers = json.dumps(plain(self.turbine), sort_keys=True)
        return hashlib.sha256(numbers.encode()).hexdigest()[:16]

    def run(
        self, controller: TurbineController, cases: Iterable[tuple[float, int]]
    ) -> list[PlantRun]:
        """Run a controller in winds of mean speeds [m/s] and seeds, in their order.

        Raises
        ------
        InputError
            If a wind is outside of the turbine's range or a number cannot be used.
        """
        pairs = list(cases)
        wanted = [self._case(speed, seed) for speed, seed in pairs]
        found = simulate_many(
            self.dynamic,
            [partial(self._made.wind, case) for case in wanted],
            controller,
            self.settings.length,
            start=[self.operation.start(case.wind_speed) for case in wanted],
            interval=self.settings.interval,
            labels=[
                f"{case.turbulence}, seed {seed}"
                for case, (_, seed) in zip(wanted, pairs, strict=True)
            ],
            workers=self.workers,
        )
        with self._lock:
            self._simulations += len(found)
        return [
            PlantRun(
                wind_speed=case.wind_speed,
                seed=seed,
                skip=self.settings.skip,
                simulation=simulation,
            )
            for case, (_, seed), simulation in zip(wanted, pairs, found, strict=True)
        ]

    def check(self, cases: Iterable[tuple[float, int]]) -> None:
        """See without a run that winds of mean speeds [m/s] and seeds can be used.

        Raises
        ------
        InputError
            If not.
        """
        for speed, seed in cases:
            self._case(speed, seed)
            check_speeds(self.turbine, speed, speed)

    def in_turbulence(self, turbulence: str, *, skip: float | None = None) -> TuningPlant:
        """The same turbine with its steady operation, in other turbulence.

        Parameters
        ----------
        turbulence : str
        skip : float, optional
            Start-up [s]; the same without.
        """
        other = copy.copy(self)
        other.settings = dataclasses.replace(
            self.settings,
            turbulence=turbulence,
            skip=self.settings.skip if skip is None else skip,
        )
        other._token = uuid.uuid4().hex
        other._made = self._made.elsewhere()
        other._lock = threading.Lock()
        other._simulations = 0
        return other

    def _case(self, speed: float, seed: int) -> WindCase:
        one = whole_number("seed", seed, at_least=0)
        settings = dataclasses.replace(
            self.settings,
            wind_speeds=(float(speed),),
            seeds=None if self.settings.turbulence == "none" else (one,),
        )
        return wind_cases(self.dynamic, settings, self.cache)[0]
