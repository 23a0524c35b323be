"""The methods: what each has to know, and how it comes to its controller in a wind.

All of them are the turbine's baseline controller with something added to the blades' pitch:

    collective         nothing
    feed-forward       the convex design for the steady wind, the same in every wind
    learned            a profile that `ilc` learned in the wind itself
    ipc-handbook       individual pitch at 1P and 2P, by the handbook's rules alone
    ipc-grid           its two gains and two offsets on a grid
    ipc-zoo            the same numbers by the zeroth-order tuner
    ipc-bayes          the same by the Bayesian tuner
    feed-forward+ipc   the design from 2P on, and individual pitch tuned on top of it (Bayesian)

Individual pitch integrates the 1P part of the blades' loads away whatever a profile does there, so
the last leaves 1P to it.  Every tuner has the same space, seeds, cost (fatigue of the blade roots
out of plane) and number of evaluations, and begins with the handbook's design.
"""

from __future__ import annotations

import re
import time
from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cached_property
from os import PathLike
from pathlib import Path

import numpy as np

from pitchopt.checks import FloatArray
from pitchopt.control import PitchProfile, TurbineController
from pitchopt.errors import InputError
from pitchopt.studies.comparison.ground import Ground
from pitchopt.studies.comparison.profiles import PlayedProfile, designed_profile, learned_profile
from pitchopt.studies.comparison.spent import Spent
from pitchopt.studies.simulation.controllers import with_feedforward
from pitchopt.studies.tuning import IndividualPitchGains
from pitchopt.studies.tuning.tune import tune

__all__ = ["KNOWLEDGE", "Knowledge", "Methods", "Prepared"]

_FLAT = 1e-6  # [rad]
_ABOVE = 2  # lowest harmonic of the design beside individual pitch


@dataclass(frozen=True, kw_only=True)
class Knowledge:
    """What a method has to know, in words.

    Attributes
    ----------
    model, wind, loads, running : str
        Of the turbine; of the wind; what of the loads is measured to prepare it; and what while
        it runs.
    """

    model: str
    wind: str
    loads: str
    running: str


_IPC_LOADS = "fatigue of the blade roots, in every evaluation"
_IPC_RUNNING = "azimuth, root moments of all blades"
_RULES = "moment by pitch (gain), lag of the actuators (offset)"
_TUNED = Knowledge(
    model=f"to start and for the range of gains: {_RULES}",
    wind="mean speed",
    loads=_IPC_LOADS,
    running=_IPC_RUNNING,
)
_DESIGN = ("geometry, polars, actuators", "mean speed, shear, tower shadow")
KNOWLEDGE = {
    "collective": Knowledge(
        model="baseline controller's", wind="nothing", loads="nothing", running="rotor speed"
    ),
    "feed-forward": Knowledge(
        model=f"{_DESIGN[0]}; the moving turbine, to choose the wake",
        wind=_DESIGN[1],
        loads="nothing",
        running="azimuth",
    ),
    "learned": Knowledge(
        model="range and rate of the actuators",
        wind="nothing: it starts where the controller has the turbine",
        loads="torque, tilt, yaw, thrust at the hub over azimuth; in steady wind lag, mean torque",
        running="azimuth",
    ),
    "ipc-handbook": Knowledge(
        model=_RULES, wind="mean speed", loads="nothing", running=_IPC_RUNNING
    ),
    "ipc-grid": _TUNED,
    "ipc-zoo": _TUNED,
    "ipc-bayes": _TUNED,
    "feed-forward+ipc": Knowledge(
        model=f"{_DESIGN[0]}; {_TUNED.model}",
        wind=_DESIGN[1],
        loads=_IPC_LOADS,
        running=_IPC_RUNNING,
    ),
}


@dataclass(frozen=True, kw_only=True, eq=False)
class Prepared:
    """A method's controller in a wind.

    Attributes
    ----------
    controller : TurbineController
    spent : Spent
    point : dict of str to float
        Numbers that a tuner chose, by name, SI units.
    tuning_cost, start_cost : float or None
        Of that point and of no individual pitch, in the tuner's own seeds [N m].
    profile : PlayedProfile or None
    """

    controller: TurbineController
    spent: Spent = field(default_factory=Spent)
    point: dict[str, float] = field(default_factory=dict)
    tuning_cost: float | None = None
    start_cost: float | None = None
    profile: PlayedProfile | None = None


class Methods:
    """The methods on a ground.

    Parameters
    ----------
    ground : Ground
    journals : path, optional
        Folder in which studies of tuners are kept, and from which they go on.
    told : callable, optional
        Called with evaluations done, all of them, and what is tuned.
    """

    def __init__(
        self,
        ground: Ground,
        *,
        journals: str | PathLike[str] | None = None,
        told: Callable[[int, int, str], None] | None = None,
    ) -> None:
        self.ground = ground
        self._journals = None if journals is None else Path(journals)
        self._told = told

    def prepare(self, method: str, wind: str) -> Prepared:
        """Controller of a method in a wind.

        Raises
        ------
        PitchoptError
            If the method cannot be had there.
        """
        ground = self.ground
        if method == "collective":
            return Prepared(controller=ground.base)
        if method == "feed-forward":
            return self._played(self.design)
        if method == "learned":
            return self._played(learned_profile(ground, wind))
        if method == "ipc-handbook":
            return self._handbook(wind)
        if method == "feed-forward+ipc":
            return self._tuned("bayes", wind, self._upper, self.design)
        return self._tuned(method.removeprefix("ipc-"), wind, ground.base, None)

    @cached_property
    def design(self) -> PlayedProfile:
        """The convex design, made once."""
        return designed_profile(self.ground, self._told)

    @cached_property
    def _upper(self) -> TurbineController:
        """Baseline with the design from 2P on."""
        whole = self.design.feedforward
        if whole.cosine.size < _ABOVE or np.abs(self.design.deviation).max() < _FLAT:
            raise InputError(
                f"harmonics: the design has {whole.cosine.size}, expected two or more beside "
                "individual pitch, which has the first"
            )
        keep = np.arange(1, whole.cosine.size + 1) >= _ABOVE
        part = PitchProfile(
            cosine=np.where(keep, whole.cosine, 0.0),
            sine=np.where(keep, whole.sine, 0.0),
            time_constant=whole.time_constant,
        )
        return with_feedforward(self.ground.base, part, self.ground.operation)

    def _played(self, profile: PlayedProfile) -> Prepared:
        ground = self.ground
        return Prepared(
            controller=with_feedforward(ground.base, profile.feedforward, ground.operation),
            spent=profile.spent,
            profile=profile,
        )

    def _problem(self, wind: str, base: TurbineController) -> IndividualPitchGains:
        ground = self.ground
        return IndividualPitchGains(
            ground.plant(wind),
            wind_speeds=(ground.wind_speed,),
            seeds=ground.tuning_seeds(wind),
            base=base,
        )

    def _handbook(self, wind: str) -> Prepared:
        """Individual pitch as tuners begin with it, and its cost in their seeds."""
        problem = self._problem(wind, self.ground.base)
        return Prepared(
            controller=problem.controller(problem.handbook),
            point=dict(zip(problem.space.names, map(float, problem.handbook), strict=True)),
            tuning_cost=problem(problem.handbook).cost,
            start_cost=problem.reference.cost,
        )

    def _tuned(
        self, tuner: str, wind: str, base: TurbineController, profile: PlayedProfile | None
    ) -> Prepared:
        ground, settings = self.ground, self.ground.settings
        began = time.perf_counter()
        problem = self._problem(wind, base)
        name = f"{'ipc' if profile is None else 'feed-forward-ipc'}-{tuner}"
        if self._journals is not None:
            self._journals.mkdir(parents=True, exist_ok=True)
        found = tune(
            problem,
            tuner,
            start=problem.handbook,
            evaluations=settings.evaluations,
            seed=settings.seed,
            journal=(
                None
                if self._journals is None
                else self._journals / f"{name}-{re.sub('[^A-Za-z0-9.]', '_', wind)}.sqlite"
            ),
            progress=False if self._told is None else self._told,
        )
        best: FloatArray = found.best.x
        time_spent = found.simulations * ground.run_length(wind)
        spent = Spent(
            evaluations=len(found.result.evaluations),
            simulations=found.simulations,
            rotations=time_spent * ground.rotor_speed / (2.0 * np.pi),
            turbine_time=time_spent,
            seconds=time.perf_counter() - began,
        )
        return Prepared(
            controller=problem.controller(best),
            spent=spent if profile is None else spent + profile.spent,
            point=dict(zip(problem.space.names, map(float, best), strict=True)),
            tuning_cost=found.best.cost,
            start_cost=found.start.cost,
            profile=profile,
        )
